"""Types of the arrays that this package passes around."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Int32Array = NDArray[np.int32]
ByteArray = NDArray[np.uint8]
BoolArray = NDArray[np.bool_]

Array = TypeVar("Array", FloatArray, IntArray)


def grown(array: Array, length: int) -> Array:
    """Return a copy of an array with more rows, those added being zero.

    Parameters
    ----------
    array : (n, ...) array
        What is copied.
    length : int
        Rows of the copy, at least n.

    Returns
    -------
    (length, ...) array
    """
    larger = np.zeros((length, *array.shape[1:]), array.dtype)
    larger[: len(array)] = array
    return larger
