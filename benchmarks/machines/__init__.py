"""Experiments and campaigns on machines that break: ``python -m benchmarks.machines``."""
