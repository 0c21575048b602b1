"""The one way in which this package compiles its numba kernels.

Kernels are pure: arrays in, arrays out. They are cached on disk, release the interpreter
lock, and never use fast-math, whose results depend on the machine.
"""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

from multisrt.geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["BoolArray", "FloatArray", "IntArray", "inlined_kernel", "kernel"]

P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function on first use, keeping its types for readers and checkers."""
    compiled: Callable[P, R] = numba.njit(cache=True, nogil=True, fastmath=False)(function)
    return compiled


def inlined_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a small kernel into each kernel that calls it, where a call would dominate."""
    compiled: Callable[P, R] = numba.njit(cache=True, nogil=True, fastmath=False, inline="always")(
        function
    )
    return compiled
