"""Damaged files and strategies, for all that reads them: ``python -m benchmarks.fuzz``."""
