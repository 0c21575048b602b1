"""Thirty planted defects, and whether campaigns find them: ``python -m benchmarks.mutants``."""
