"""Names for the arrays that this package passes round."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

Array = TypeVar("Array", FloatArray, IntArray)


def grown(array: Array, length: int) -> Array:
    """Give an array with more rows: those that are there, and zeros."""
    larger = np.zeros((length, *array.shape[1:]), array.dtype)
    larger[: len(array)] = array
    return larger
