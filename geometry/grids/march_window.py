"""The part of a grid on which a march has been working so far, which grows with the front."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.grids.fast_march import BLOCKED, March, advance, seed, take_back
from multisrt.geometry.grids.march_cells import (
    cells_of,
    cropped,
    first_accepted,
    lay_out,
    march_to,
    move,
    numbers_of,
    values_of,
    window_around,
)
from multisrt.geometry.grids.raster import Corners
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, Int32Array, IntArray

Number = TypeVar("Number", np.uint8, np.int32, np.float64)


class MarchWindow:
    """A march on a window of a grid, which grows when the front reaches its rim.

    Neither time nor memory depend on the size of the grid.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        The grid. It is read again when the window grows, and compared with in `changes_in`.
    starts : (k, 2) array
        The sources x, y in widths of a cell from the grid's corner, each in a passable cell.
    cells : (n, 2) array of int
        Rows and columns of cells that will be asked for.
    farthest : bool
        Whether the first window is to have room for paths to all of them or to the nearest one.

    Attributes
    ----------
    passable : (rows, columns) array of bool
        As given.
    arrays : March
        The march, whose cells are those of the window with a border of two blocked cells.
    window : (r0, r1, c0, c1)
        Rows r0 to r1 - 1 and columns c0 to c1 - 1 of the grid.
    """

    __slots__ = (
        "_count",
        "_held",
        "_seed_values",
        "_seeds",
        "_starts",
        "arrays",
        "passable",
        "window",
    )

    def __init__(
        self, passable: BoolArray, starts: FloatArray, cells: IntArray, *, farthest: bool
    ) -> None:
        self.passable = passable
        self._starts = starts
        self.window: Corners = cropped(window_around(cells, passable, starts, farthest), passable)
        r0, r1, c0, c1 = self.window
        part = np.ascontiguousarray(passable[r0:r1, c0:c1])
        self.arrays = _new_arrays(part, self.window, passable.shape)
        # Number of cells on the front and of those accepted, and the front at the beginning.
        self._held = seed(part, starts - (c0, r0), self.arrays)
        self._count = 0
        self._seeds: Int32Array = self.arrays.cells[1 : self._held + 1].copy()
        self._seed_values: FloatArray = self.arrays.keys[1 : self._held + 1].copy()

    @property
    def nbytes(self) -> int:
        """Memory of the window's arrays in bytes."""
        return sum(array.nbytes for array in self.arrays[1:])

    def numbers_of(self, cells: IntArray) -> IntArray:
        """Return the numbers of cells in the present window, 0 for those outside of it."""
        return numbers_of(cells, self.window, self.arrays.width)

    def cells_of(self, numbers: IntArray) -> IntArray:
        """Return the rows and columns in the grid of cells with some numbers, ``(n, 2)``."""
        return cells_of(numbers, self.window, self.arrays.width)

    def values_of(self, cells: IntArray) -> FloatArray:
        """Return the values of cells in widths of a cell, ``inf`` if not accepted."""
        return values_of(self.arrays, self.window, cells)

    def first_of(self, cells: IntArray) -> tuple[int, float]:
        """Return which of some cells was accepted first, -1 if none is, and its value."""
        return first_accepted(self.arrays, self.window, cells)

    def values(self) -> FloatArray:
        """Return the values of the window's cells in widths of a cell, as a view."""
        return _inner(self.arrays.distance, self.arrays.width)

    def march_to(self, cells: IntArray, *, farthest: bool, limit: float = math.inf) -> None:
        """March until some cells are accepted.

        Parameters
        ----------
        cells : (k, 2) array of int
            Their rows and columns; those that are not passable are ignored.
        farthest : bool
            Whether to march to the last or to the first of them.
        limit : float
            Highest value to accept, in widths of a cell.
        """
        while True:
            self._held, self._count, is_too_small = march_to(
                self.arrays,
                self._held,
                self._count,
                self.passable,
                self.window,
                cells,
                farthest,
                limit,
            )
            if not is_too_small:
                return
            self._widen(cells, farthest)

    def complete(self) -> None:
        """March until every cell of the grid that can be reached is accepted."""
        rows, columns = self.passable.shape
        self._look_at(cropped((0, rows, 0, columns), self.passable))
        self._held, self._count, _ = advance(self.arrays, self._held, self._count, -1, math.inf)

    def changes_in(self, window: Corners) -> tuple[IntArray, IntArray]:
        """Return the rows and columns of the cells that differ from the grid by now.

        Parameters
        ----------
        window : (r0, r1, c0, c1)
            The rows and columns of the grid that are compared, as far as the march knows them.

        Returns
        -------
        rows, columns : (k,) arrays
        """
        r0, c0 = max(window[0], self.window[0]), max(window[2], self.window[2])
        r1, c1 = min(window[1], self.window[1]), min(window[3], self.window[3])
        if r0 >= r1 or c0 >= c1:
            return np.empty(0, np.int64), np.empty(0, np.int64)
        below, left = self.window[0], self.window[2]
        state = _inner(self.arrays.state, self.arrays.width)
        known = state[r0 - below : r1 - below, c0 - left : c1 - left]
        rows, columns = np.nonzero((known != BLOCKED) != self.passable[r0:r1, c0:c1])
        return rows + r0, columns + c0

    def take_back(self, rows: IntArray, columns: IntArray) -> None:
        """Toggle cells between passable and blocked, and take back what follows from them.

        Parameters
        ----------
        rows, columns : (k,) arrays
            What `changes_in` has returned, none within `EXACT_CELLS` of a source.
        """
        self._held, self._count = take_back(
            self.numbers_of(np.column_stack([rows, columns])),
            self.arrays,
            self._held,
            self._count,
            self._seeds,
            self._seed_values,
        )

    def _widen(self, cells: IntArray, farthest: bool) -> None:
        # To all sides at once: memory costs less than moving into it.
        r0, r1, c0, c1 = self.window
        more = max(r1 - r0, c1 - c0) // 2 + 1
        rows, columns = self.passable.shape
        wider = max(0, r0 - more), min(rows, r1 + more), max(0, c0 - more), min(columns, c1 + more)
        wider = _both(wider, window_around(cells, self.passable, self._starts, farthest))
        before = self.window
        self._look_at(cropped(wider, self.passable))
        if self.window == before:
            # The front has come to a rim that is blocked by now, without a `repair`.
            self._look_at(wider)

    def _look_at(self, window: Corners) -> None:
        # Move into arrays for a window that holds another one as well.
        old, before = self.arrays, self.window
        window = _both(before, window)
        if window == before:
            return
        r0, r1, c0, c1 = window
        part = np.ascontiguousarray(self.passable[r0:r1, c0:c1])
        new = _new_arrays(part, window, self.passable.shape)
        below, left = before[0] - r0, before[2] - c0
        move(old, new, self._held, self._count, below, left, self._seeds)
        self.arrays, self.window = new, window


def _new_arrays(part: BoolArray, window: Corners, shape: tuple[int, ...]) -> March:
    # With a border of two blocked cells. Cells on the rim are marked where the grid continues.
    r0, r1, c0, c1 = window
    width = c1 - c0 + 4
    size = (r1 - r0 + 4) * width
    march = March(
        width=width,
        state=np.zeros(size, np.uint8),
        marks=np.zeros(size, np.uint8),
        distance=np.empty(size),
        order=np.empty(size, np.int32),
        cells=np.empty(size, np.int32),
        keys=np.empty(size),
        places=np.zeros(size, np.int32),
    )
    lay_out(part, (r0 > 0, r1 < shape[0], c0 > 0, c1 < shape[1]), march)
    return march


def _both(first: Corners, second: Corners) -> Corners:
    # The smallest window that holds two windows.
    return (
        min(first[0], second[0]),
        max(first[1], second[1]),
        min(first[2], second[2]),
        max(first[3], second[3]),
    )


def _inner(array: NDArray[Number], width: int) -> NDArray[Number]:
    # A flat array as a grid without its border, as a view.
    return array.reshape(-1, width)[2:-2, 2:-2]
