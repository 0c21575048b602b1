"""Numerical building blocks, and the compilation and caching of kernels."""
