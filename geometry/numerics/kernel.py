"""The one way in which this package compiles functions with numba.

Kernels take and return numbers, arrays and named tuples of them. They are cached on disk, release
the interpreter lock, and never use fast-math, whose results depend on the machine.
"""

from collections.abc import Callable, Sequence
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel_cache import cache_for

__all__ = [
    "BoolArray",
    "FloatArray",
    "IntArray",
    "declared_kernels",
    "inlined_kernel",
    "kernel",
    "unsigned",
]

P = ParamSpec("P")
R = TypeVar("R")

unsigned = cast(Callable[[int], int], np.uint64)
"""Convert an index to an unsigned integer, which saves the test for a negative one per access.

Only unsigned integers may be added to it: the sum with a signed one is a float.
"""


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function when it is first called, keeping its types for type checkers.

    Parameters
    ----------
    function : callable
        A function of a module, in the part of Python that numba compiles in nopython mode.
    """
    return _compiled(function)


def inlined_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a small kernel into each kernel that calls it."""
    return _compiled(function, inline="always")


_DECLARED: list[Any] = []


def declared_kernels() -> Sequence[Any]:
    """Return the kernels of all modules imported so far, as dispatchers of numba.

    Those that are compiled into their callers are left out.
    """
    return _DECLARED


def _compiled(function: Callable[P, R], **options: str) -> Callable[P, R]:
    with cache_for(function.__module__) as cached:
        compiled: Callable[P, R] = numba.njit(cache=cached, nogil=True, fastmath=False, **options)(
            function
        )
    if not options:
        _DECLARED.append(compiled)
    return compiled
