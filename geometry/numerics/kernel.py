"""The one way in which this package compiles its numba kernels.

Kernels are pure: arrays in, arrays out. They are cached on disk, release the interpreter
lock, and never use fast-math, whose results depend on the machine.
"""

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba
import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel_cache import cache_for

__all__ = [
    "BoolArray",
    "FloatArray",
    "IntArray",
    "inlined_kernel",
    "kernel",
    "unsigned",
]

P = ParamSpec("P")
R = TypeVar("R")

unsigned = cast(Callable[[int], int], np.uint64)
"""Makes a number an unsigned index for a loop where each instruction counts.

A signed one that is negative counts from an array's end, and each access asks for that. What is
added to an unsigned one has to be unsigned, too, or the sum is no integer.
"""


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function on first use, keeping its types for readers and checkers."""
    return _compiled(function)


def inlined_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a small kernel into each kernel that calls it, where a call would dominate."""
    return _compiled(function, inline="always")


def _compiled(function: Callable[P, R], **options: str) -> Callable[P, R]:
    with cache_for(function.__module__) as cached:
        compiled: Callable[P, R] = numba.njit(cache=cached, nogil=True, fastmath=False, **options)(
            function
        )
    return compiled
