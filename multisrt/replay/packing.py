"""Numbers of a replay as whole numbers, so that they pack well."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from typing import Any, Final

import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray

UNIT_S: Final = 0.001
UNIT_M: Final = 0.001
UNIT_RAD: Final = 0.0001

Packed = dict[str, Any]
"""A part of the data of a page: what JSON can say."""


def whole(values: Any, unit: float) -> list[int]:
    """Return numbers in whole units, each as the difference from the one before.

    Examples
    --------
    >>> whole([1.0, 1.25, 1.2504], 0.001)
    [1000, 250, 0]
    """
    numbers = np.rint(np.asarray(values, np.float64) / unit).astype(np.int64).ravel()
    found: list[int] = np.diff(numbers, prepend=0).tolist()
    return found


def differences(values: Iterable[int]) -> list[int]:
    """Return whole numbers, each as the difference from the one before."""
    return whole(list(values), 1.0)


def points(arrays: Sequence[FloatArray]) -> Packed:
    """Pack arrays of points, in millimetres.

    Parameters
    ----------
    arrays : sequence of (n, 2) array
        Points in metres.

    Returns
    -------
    dict
        `n`, the number of points of each array, and `x` and `y` of all of them.

    Examples
    --------
    >>> points([np.array([[0.0, 1.0], [0.5, 1.0]])])
    {'n': [2], 'x': [0, 500], 'y': [1000, 0]}
    """
    together = np.vstack([np.empty((0, 2)), *arrays])
    return {
        "n": [len(array) for array in arrays],
        "x": whole(together[:, 0], UNIT_M),
        "y": whole(together[:, 1], UNIT_M),
    }


def lists(rows: Iterable[Sequence[int]]) -> Packed:
    """Pack lists of whole numbers: `n`, the length of each, and `of`, all their numbers."""
    held = [list(row) for row in rows]
    return {
        "n": [len(row) for row in held],
        "of": differences(number for row in held for number in row),
    }


class Table:
    """Values that occur several times and are stored once.

    Examples
    --------
    >>> table = Table()
    >>> [table.index(word) for word in ("a", "b", "a")], table.values
    ([0, 1, 0], ['a', 'b'])
    """

    def __init__(self) -> None:
        self._index: dict[Hashable, int] = {}

    def index(self, value: Hashable) -> int:
        """Return the number of a value, which is stored if it is new."""
        return self._index.setdefault(value, len(self._index))

    @property
    def values(self) -> list[Any]:
        """The values by number."""
        return list(self._index)
