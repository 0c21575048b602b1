"""Ratios of the kernels' speed to that of well-known libraries: ``python -m benchmarks``."""
