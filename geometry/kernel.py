"""The one way in which this package compiles its numba kernels.

Kernels are pure: arrays in, arrays out. They are cached on disk, release the interpreter
lock, and never use fast-math, whose results depend on the machine.
"""

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba
import numpy as np

from multisrt.geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = [
    "BoolArray",
    "FloatArray",
    "IntArray",
    "borrowing_kernel",
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
    compiled: Callable[P, R] = numba.njit(cache=True, nogil=True, fastmath=False)(function)
    return compiled


def borrowing_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that neither makes arrays nor gives any.

    Other kernels count who holds each array, by instructions that lock memory: a few for every
    array of every call, which in a small kernel take longer than its work. One that makes an
    array in spite of it is refused as it is compiled, but not by every numba function on arrays:
    such a kernel calls functions of numbers and other borrowing kernels alone.
    """
    compiled: Callable[P, R] = numba.njit(cache=True, nogil=True, fastmath=False, _nrt=False)(
        function
    )
    return compiled


def inlined_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a small kernel into each kernel that calls it, where a call would dominate."""
    compiled: Callable[P, R] = numba.njit(cache=True, nogil=True, fastmath=False, inline="always")(
        function
    )
    return compiled
