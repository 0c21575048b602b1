"""Speed beside well-known libraries, and costs of runs in yardsticks: ``python -m benchmarks``."""
