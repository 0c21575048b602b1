"""Damaged files for every reader of maps, and of recordings: ``python -m benchmarks.fuzz``."""
