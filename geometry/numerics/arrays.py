"""Types of the arrays that this package passes around, and arrays that grow."""

import math
import mmap
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Int32Array = NDArray[np.int32]
ByteArray = NDArray[np.uint8]
BoolArray = NDArray[np.bool_]

Array = TypeVar("Array", FloatArray, IntArray, Int32Array, ByteArray)


MAPPED_BYTES: Final = 1 << 18
"""Arrays that grow to this size have pages of memory of their own."""


def grown(array: Array, length: int) -> Array:
    """Return a copy of an array with more rows, those added being zero.

    Rows take no memory before they are written, and all of it is returned when the array is
    dropped: the arrays of large teams grow in turns, and would leave holes in a common heap.

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
    shape = (length, *array.shape[1:])
    size = math.prod(shape) * array.itemsize
    larger: Array
    if size < MAPPED_BYTES:
        larger = np.zeros(shape, array.dtype)
    else:
        larger = np.frombuffer(mmap.mmap(-1, size), array.dtype).reshape(shape)
    larger[: len(array)] = array
    return larger


def roomier(held: int, needed: int) -> int:
    """Return the number of rows that arrays with too few of them are to have.

    Parameters
    ----------
    held : int
        Rows that they have.
    needed : int
        Rows that they need at least.

    Examples
    --------
    >>> roomier(0, 1), roomier(1000, 1001), roomier(1000, 5000)
    (64, 2000, 5000)
    """
    return max(needed, 2 * held, 64)


def builtin(value: Any) -> Any:
    """Return the builtin equivalent of a number, a text or an array of numpy.

    Parameters
    ----------
    value : numpy scalar or array
        What is converted.

    Returns
    -------
    bool, int, float, str or list
        Nested lists for an array; a number for an array without dimensions.

    Raises
    ------
    TypeError
        If it is anything else, such as a complex number.

    Examples
    --------
    >>> builtin(np.float32(0.5)), builtin(np.array([[1, 2]]))
    (0.5, [[1, 2]])
    """
    match value:
        case np.ndarray():
            return value.tolist()
        case np.bool_():
            return bool(value)
        case np.integer():
            return int(value)
        case np.floating():
            return float(value)
        case np.str_():
            return str(value)
    raise TypeError(f"a {type(value).__name__} is no number, text or array")
