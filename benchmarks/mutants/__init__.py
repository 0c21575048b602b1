"""Planted defects, and whether campaigns find them: ``python -m benchmarks.mutants``."""
