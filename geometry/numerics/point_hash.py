"""Points in the plane, found again by place: what a query costs depends on what is near it."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel

EMPTY: Final = -1
"""No point in a slot, or none after this one in its cell."""


FEW: Final = 64
"""So many numbers are sorted fastest by inserting each among those before it."""


class PointHash:
    """Points that are added one by one and numbered in that order.

    They lie in square cells, of which only those with points take memory: a hash table holds
    the newest point of every cell, and every point the one before it in its cell.

    Parameters
    ----------
    cell_m : float
        Width of a cell; about the radius of the queries to come.
    """

    __slots__ = ("_before", "_cell", "_count", "_found", "_points", "_table")

    def __init__(self, cell_m: float) -> None:
        if not 0.0 < cell_m < math.inf:
            raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")
        self._cell = cell_m
        self._count = 0
        self._points: FloatArray = np.empty((64, 2))
        self._before: IntArray = np.empty(64, np.int64)
        self._found: IntArray = np.empty(64, np.int64)
        self._table: IntArray = np.full((256, 3), EMPTY, np.int64)

    def __len__(self) -> int:
        return self._count

    @property
    def points(self) -> FloatArray:
        """All points, as an ``(n, 2)`` view."""
        return self._points[: self._count]

    def add(self, x: float, y: float) -> int:
        """Add a point and give its number."""
        number = self._count
        if number == len(self._points):
            # The table has room for four times as many cells as there are points.
            points, self._points = self._points, np.empty((2 * number, 2))
            self._points[:number] = points
            self._before = np.empty(2 * number, np.int64)
            self._table = np.full((8 * number, 3), EMPTY, np.int64)
            for earlier in range(number):
                _insert(self._table, self._before, self._points, earlier, self._cell)
        self._points[number] = x, y
        _insert(self._table, self._before, self._points, number, self._cell)
        self._count += 1
        return number

    def within(self, x: float, y: float, radius_m: float) -> IntArray:
        """Give the numbers of all points within a radius, the borders included, rising."""
        while True:
            count = _find(
                self._table, self._before, self._points, x, y, radius_m, self._cell, self._found
            )
            if count <= len(self._found):
                break
            self._found = np.empty(2 * count, np.int64)
        found = self._found[:count].copy()
        if count > FEW:
            found.sort()
        return found

    def around(self, numbers: IntArray, radius_m: float) -> IntArray:
        """Give the numbers of all points within a radius of any of some points, rising."""
        if len(numbers) == 1:
            x, y = self._points[numbers[0]].tolist()
            return self.within(x, y, radius_m)
        return _around(self._table, self._before, self._points, numbers, radius_m, self._cell)

    def pairs(self, first: int, radius_m: float) -> IntArray:
        """Pair all points from a number on with those before them that are within a radius.

        Returns
        -------
        (n, 2) array
            Numbers of both, the later one first; by it, and by the earlier one, rising.
        """
        return _pairs(
            self._table, self._before, self._points, first, self._count, radius_m, self._cell
        )


@kernel
def _slot(table: IntArray, i: int, j: int) -> int:
    # Where a cell is in the table, or where it would be put; the slots are a power of two.
    last = table.shape[0] - 1
    k: int = ((i * 73856093) ^ (j * 19349663)) & last
    while table[k, 2] != EMPTY and (table[k, 0] != i or table[k, 1] != j):
        k = (k + 1) & last
    return k


@kernel
def _insert(
    table: IntArray, before: IntArray, points: FloatArray, number: int, cell: float
) -> None:
    i, j = int(np.floor(points[number, 0] / cell)), int(np.floor(points[number, 1] / cell))
    k = _slot(table, i, j)
    before[number] = table[k, 2]
    table[k, 0], table[k, 1], table[k, 2] = i, j, number


@kernel
def _within(
    table: IntArray,
    before: IntArray,
    points: FloatArray,
    x: float,
    y: float,
    radius: float,
    cell: float,
) -> IntArray:
    found = np.empty(64, np.int64)
    count = _find(table, before, points, x, y, radius, cell, found)
    if count > found.shape[0]:
        found = np.empty(count, np.int64)
        _find(table, before, points, x, y, radius, cell, found)
    found = found[:count]
    if count > FEW:
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
def _find(
    table: IntArray,
    before: IntArray,
    points: FloatArray,
    x: float,
    y: float,
    radius: float,
    cell: float,
    found: IntArray,
) -> int:
    # Writes the numbers of the points within a radius, as far as there is room; few of them
    # rising. Tells how many there are.
    count = 0
    for i in range(int(np.floor((x - radius) / cell)), int(np.floor((x + radius) / cell)) + 1):
        for j in range(int(np.floor((y - radius) / cell)), int(np.floor((y + radius) / cell)) + 1):
            number = table[_slot(table, i, j), 2]
            while number != EMPTY:
                dx, dy = points[number, 0] - x, points[number, 1] - y
                if dx * dx + dy * dy <= radius * radius:
                    if count < found.shape[0]:
                        found[count] = number
                    count += 1
                number = before[number]
    if count <= min(FEW, found.shape[0]):
        _sort(found, count)
    return count


@kernel
def _around(
    table: IntArray,
    before: IntArray,
    points: FloatArray,
    numbers: IntArray,
    radius: float,
    cell: float,
) -> IntArray:
    found = np.empty(64, np.int64)
    count = 0
    for number in numbers:
        x, y = points[number, 0], points[number, 1]
        near = _within(table, before, points, x, y, radius, cell)
        if count + near.shape[0] > found.shape[0]:
            more = np.empty(2 * (count + near.shape[0]), np.int64)
            more[:count] = found[:count]
            found = more
        found[count : count + near.shape[0]] = near
        count += near.shape[0]
    return np.unique(found[:count])


@kernel
def _pairs(
    table: IntArray,
    before: IntArray,
    points: FloatArray,
    first: int,
    end: int,
    radius: float,
    cell: float,
) -> IntArray:
    pairs = np.empty((64, 2), np.int64)
    count = 0
    for later in range(first, end):
        x, y = points[later, 0], points[later, 1]
        for number in _within(table, before, points, x, y, radius, cell):
            if number >= later:
                break
            if count == pairs.shape[0]:
                more = np.empty((2 * count, 2), np.int64)
                more[:count] = pairs
                pairs = more
            pairs[count, 0], pairs[count, 1] = later, number
            count += 1
    return pairs[:count].copy()
