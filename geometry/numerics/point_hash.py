"""Points in the plane in a hash of square cells: a query costs what lies near its place."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray, IntArray, grown
from multisrt.geometry.numerics.kernel import kernel

EMPTY: Final = -1
"""Marks an empty slot, and the end of the chain of points in a cell."""

INSERTION_SORT: Final = 64
"""Up to this length insertion sort is faster than numpy's sort."""


class PointHash:
    """Points that are added one by one and numbered in that order.

    They lie in square cells, of which only those with points take memory: a hash table holds
    the newest point of each cell, and each point the one before it in its cell.

    Parameters
    ----------
    cell_m : float
        Width of a cell in metres; about the radius of the queries to come.

    Raises
    ------
    InvalidInputError
        If the width is not positive and finite.

    Notes
    -----
    Queries reuse memory: a hash is not shared between threads.

    Examples
    --------
    >>> points = PointHash(1.0)
    >>> [points.add(x, 0.0) for x in (0.0, 0.5, 3.0, 1.0)]
    [0, 1, 2, 3]
    >>> points.within(0.0, 0.0, 1.0).tolist()
    [0, 1, 3]
    >>> points.pairs(3, 0.6).tolist()
    [[3, 1]]
    """

    __slots__ = ("_count", "_found", "_hash")

    def __init__(self, cell_m: float) -> None:
        if not 0.0 < cell_m < math.inf:
            raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")
        self._count = 0
        self._found: IntArray = np.empty(64, np.int64)
        self._hash = _Hash(
            cell_m=cell_m,
            table=np.full((256, 3), EMPTY, np.int64),
            before=np.empty(64, np.int64),
            points=np.empty((64, 2)),
        )

    def __len__(self) -> int:
        return self._count

    @property
    def points(self) -> FloatArray:
        """All points in metres, as an ``(n, 2)`` view."""
        return self._hash.points[: self._count]

    def add(self, x: float, y: float) -> int:
        """Add a point and return its number."""
        number = self._count
        if number == len(self._hash.points):
            # The table has room for four times as many cells as there are points.
            larger = _Hash(
                cell_m=self._hash.cell_m,
                table=np.full((8 * number, 3), EMPTY, np.int64),
                before=np.empty(2 * number, np.int64),
                points=grown(self._hash.points, 2 * number),
            )
            for earlier in range(number):
                _insert(larger, earlier)
            self._hash = larger
        self._hash.points[number] = x, y
        _insert(self._hash, number)
        self._count += 1
        return number

    def within(self, x: float, y: float, radius_m: float) -> IntArray:
        """Return the numbers of all points within a radius of a place, border included.

        Parameters
        ----------
        x, y : float
            The place in metres.
        radius_m : float
            The radius in metres.

        Returns
        -------
        (n,) array of int
            In ascending order.
        """
        while True:
            count = _find(self._hash, x, y, radius_m, self._found)
            if count <= len(self._found):
                break
            self._found = np.empty(2 * count, np.int64)
        found = self._found[:count].copy()
        if count > INSERTION_SORT:
            found.sort()
        return found

    def around(self, numbers: IntArray, radius_m: float) -> IntArray:
        """Return the numbers of all points within a radius of any of some points.

        Parameters
        ----------
        numbers : (k,) array of int
            Numbers of the points to look around.
        radius_m : float
            The radius in metres.

        Returns
        -------
        (n,) array of int
            In ascending order, with the given ones.
        """
        if len(numbers) == 1:
            x, y = self._hash.points[numbers[0]].tolist()
            return self.within(x, y, radius_m)
        return _around(self._hash, numbers, radius_m)

    def pairs(self, first: int, radius_m: float) -> IntArray:
        """Pair the points from a number on with all earlier points within a radius.

        Parameters
        ----------
        first : int
            Number of the first of these points.
        radius_m : float
            The radius in metres.

        Returns
        -------
        (n, 2) array of int
            Numbers of the later and the earlier point, sorted by the one and then by the other.
        """
        return _pairs(self._hash, first, self._count, radius_m)


class _Hash(NamedTuple):
    """The arrays of a hash.

    Attributes
    ----------
    cell_m : float
        Width of a cell in metres.
    table : (slots, 3) array of int
        Column and row of a cell, and the number of its newest point or `EMPTY`. The number of
        slots is a power of two.
    before : (n,) array of int
        Number of the point before each in its cell, or `EMPTY`.
    points : (n, 2) array
        The points in metres.
    """

    cell_m: float
    table: IntArray
    before: IntArray
    points: FloatArray


@kernel
def _slot(table: IntArray, i: int, j: int) -> int:
    # Index of a cell in the table, or of the slot where it would be inserted.
    last = table.shape[0] - 1
    k: int = ((i * 73856093) ^ (j * 19349663)) & last
    while table[k, 2] != EMPTY and (table[k, 0] != i or table[k, 1] != j):
        k = (k + 1) & last
    return k


@kernel
def _insert(points: _Hash, number: int) -> None:
    x, y = points.points[number, 0], points.points[number, 1]
    i, j = int(np.floor(x / points.cell_m)), int(np.floor(y / points.cell_m))
    table = points.table
    k = _slot(table, i, j)
    points.before[number] = table[k, 2]
    table[k, 0], table[k, 1], table[k, 2] = i, j, number


@kernel
def _within(points: _Hash, x: float, y: float, radius: float) -> IntArray:
    # Numbers of the points within a radius, in ascending order.
    found = np.empty(64, np.int64)
    count = _find(points, x, y, radius, found)
    if count > found.shape[0]:
        found = np.empty(count, np.int64)
        _find(points, x, y, radius, found)
    found = found[:count]
    if count > INSERTION_SORT:
        found.sort()
    return found


@kernel
def _sort(numbers: IntArray, count: int) -> None:
    for i in range(1, count):
        number, k = numbers[i], i
        while k > 0 and numbers[k - 1] > number:
            numbers[k] = numbers[k - 1]
            k -= 1
        numbers[k] = number


@kernel
def _find(points: _Hash, x: float, y: float, radius: float, found: IntArray) -> int:
    # Write the numbers of the points within a radius as far as there is room, and sort them if
    # they are few. Return how many there are.
    cell = points.cell_m
    count = 0
    for i in range(int(np.floor((x - radius) / cell)), int(np.floor((x + radius) / cell)) + 1):
        for j in range(int(np.floor((y - radius) / cell)), int(np.floor((y + radius) / cell)) + 1):
            number = points.table[_slot(points.table, i, j), 2]
            while number != EMPTY:
                dx, dy = points.points[number, 0] - x, points.points[number, 1] - y
                if dx * dx + dy * dy <= radius * radius:
                    if count < found.shape[0]:
                        found[count] = number
                    count += 1
                number = points.before[number]
    if count <= min(INSERTION_SORT, found.shape[0]):
        _sort(found, count)
    return count


@kernel
def _around(points: _Hash, numbers: IntArray, radius: float) -> IntArray:
    found = np.empty(64, np.int64)
    count = 0
    for number in numbers:
        near = _within(points, points.points[number, 0], points.points[number, 1], radius)
        if count + near.shape[0] > found.shape[0]:
            more = np.empty(2 * (count + near.shape[0]), np.int64)
            more[:count] = found[:count]
            found = more
        found[count : count + near.shape[0]] = near
        count += near.shape[0]
    return np.unique(found[:count])


@kernel
def _pairs(points: _Hash, first: int, end: int, radius: float) -> IntArray:
    pairs = np.empty((64, 2), np.int64)
    count = 0
    for later in range(first, end):
        x, y = points.points[later, 0], points.points[later, 1]
        for number in _within(points, x, y, radius):
            if number >= later:
                break
            if count == pairs.shape[0]:
                more = np.empty((2 * count, 2), np.int64)
                more[:count] = pairs
                pairs = more
            pairs[count, 0], pairs[count, 1] = later, number
            count += 1
    return pairs[:count].copy()
