"""The part of a grid on which a march has been working so far, which grows with the front."""

from __future__ import annotations

import math
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.grids.fast_march import (
    BLOCKED,
    RIM,
    March,
    advance,
    ask,
    forget,
    moved_cells,
    numbers_of,
    seed,
    take_back,
)
from multisrt.geometry.grids.raster import Corners
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, Int32Array, IntArray

MARGIN_CELLS: Final = 48
"""Distance in rows and columns from the sources to the rim of the first window."""

Number = TypeVar("Number", np.uint8, np.int32, np.float64)


class MarchWindow:
    """A march on a window of a grid, which doubles when the front reaches its rim.

    Neither time nor memory depend on the size of the grid.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        The grid. It is read again when the window grows, and compared with in `changes_in`.
    starts : (k, 2) array
        The sources x, y in widths of a cell from the grid's corner, each in a passable cell.

    Attributes
    ----------
    passable : (rows, columns) array of bool
        As given.
    arrays : March
        The march, whose cells are those of the window with a border of two blocked cells.
    window : (r0, r1, c0, c1)
        Rows r0 to r1 - 1 and columns c0 to c1 - 1 of the grid.
    """

    __slots__ = ("_count", "_held", "_seed_values", "_seeds", "arrays", "passable", "window")

    def __init__(self, passable: BoolArray, starts: FloatArray) -> None:
        self.passable = passable
        columns, rows = starts.astype(np.int64).T
        shape = passable.shape
        self.window = (
            max(0, int(rows.min()) - MARGIN_CELLS),
            min(shape[0], int(rows.max()) + MARGIN_CELLS + 1),
            max(0, int(columns.min()) - MARGIN_CELLS),
            min(shape[1], int(columns.max()) + MARGIN_CELLS + 1),
        )
        self.arrays = _new_arrays(passable, self.window)
        r0, r1, c0, c1 = self.window
        # Number of cells on the front and of those accepted, and the front at the beginning.
        self._held = seed(
            np.ascontiguousarray(passable[r0:r1, c0:c1]), starts - (c0, r0), self.arrays
        )
        self._count = 0
        self._seeds: Int32Array = self.arrays.cells[1 : self._held + 1].copy()
        self._seed_values: FloatArray = self.arrays.keys[1 : self._held + 1].copy()

    def numbers_of(self, rows: IntArray, columns: IntArray) -> IntArray:
        """Return the numbers of cells in the present window, 0 for those outside of it."""
        return numbers_of(rows, columns, self.window, self.arrays.width)

    def values(self) -> FloatArray:
        """Return the values of the window's cells in widths of a cell, as a view."""
        return _inner(self.arrays.distance, self.arrays.width)

    def march_to(
        self, rows: IntArray, columns: IntArray, *, all_of_them: bool, limit: float = math.inf
    ) -> None:
        """March until some cells are accepted.

        Parameters
        ----------
        rows, columns : (k,) arrays
            The cells; those that are not passable are ignored.
        all_of_them : bool
            Whether to march to the last or to the first of them.
        limit : float
            Highest value to accept, in widths of a cell.
        """
        free = self.passable[rows, columns]
        rows, columns = rows[free], columns[free]
        if all_of_them and math.isinf(limit):
            self._hold(rows, columns)
        while True:
            at = self.numbers_of(rows, columns)
            missing, final = ask(at, self.arrays.state, self.arrays.marks)
            is_too_small = False
            if missing and (all_of_them or not final):
                is_too_small = self._advance(missing if all_of_them else 1, limit)
            forget(at, self.arrays.marks)
            if not is_too_small:
                return
            self._widen()

    def complete(self) -> None:
        """March until every cell of the grid that can be reached is accepted."""
        self._look_at((0, self.passable.shape[0], 0, self.passable.shape[1]))
        self._advance(-1, math.inf)

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
            self.numbers_of(rows, columns),
            self.arrays,
            self._held,
            self._count,
            self._seeds,
            self._seed_values,
        )

    def _advance(self, remaining: int, limit: float) -> bool:
        # March until so many marked cells are accepted. Return whether the window is too small.
        self._held, self._count, at_rim = advance(
            self.arrays, self._held, self._count, remaining, limit
        )
        return bool(at_rim)

    def _hold(self, rows: IntArray, columns: IntArray) -> None:
        # Widen at once to hold cells that the front is to reach.
        (r0, r1, c0, c1), shape = self.window, self.passable.shape
        if not len(rows):
            return
        low, high = int(rows.min()), int(rows.max())
        left, right = int(columns.min()), int(columns.max())
        if low < r0 or high >= r1 or left < c0 or right >= c1:
            self._look_at(
                (
                    max(0, min(r0, low - MARGIN_CELLS)),
                    min(shape[0], max(r1, high + MARGIN_CELLS + 1)),
                    max(0, min(c0, left - MARGIN_CELLS)),
                    min(shape[1], max(c1, right + MARGIN_CELLS + 1)),
                )
            )

    def _widen(self) -> None:
        # To all sides at once: memory costs less than moving into it.
        r0, r1, c0, c1 = self.window
        more = max(r1 - r0, c1 - c0) // 2 + 1
        rows, columns = self.passable.shape
        self._look_at(
            (max(0, r0 - more), min(rows, r1 + more), max(0, c0 - more), min(columns, c1 + more))
        )

    def _look_at(self, window: Corners) -> None:
        # Move into arrays for a larger window.
        old, before = self.arrays, self.window
        if window == before:
            return
        new = _new_arrays(self.passable, window)
        below, left = before[0] - window[0], before[2] - window[2]
        part = np.s_[
            below : below + before[1] - before[0],
            left : left + before[3] - before[2],
        ]
        _inner(new.state, new.width)[part] = _inner(old.state, old.width)
        _inner(new.distance, new.width)[part] = _inner(old.distance, old.width)
        _inner(new.places, new.width)[part] = _inner(old.places, old.width)

        def moved(cells: Int32Array) -> Int32Array:
            return moved_cells(cells, old.width, new.width, below, left)

        count, end = self._count, self._held + 1
        new.order[:count] = moved(old.order[:count])
        new.cells[1:end] = moved(old.cells[1:end])
        new.keys[1:end] = old.keys[1:end]
        self._seeds = moved(self._seeds)
        self.arrays, self.window = new, window


def _new_arrays(passable: BoolArray, window: Corners) -> March:
    # With a border of two blocked cells. Cells on the rim are marked where the grid continues.
    r0, r1, c0, c1 = window
    width = c1 - c0 + 4
    size = (r1 - r0 + 4) * width
    keys = np.empty(size)
    keys[0] = np.inf
    march = March(
        width=width,
        state=np.zeros(size, np.uint8),
        marks=np.zeros(size, np.uint8),
        distance=np.full(size, np.inf),
        order=np.empty(size, np.int32),
        cells=np.empty(size, np.int32),
        keys=keys,
        places=np.zeros(size, np.int32),
    )
    _inner(march.state, width)[:] = passable[r0:r1, c0:c1]
    rim = _inner(march.marks, width)
    rim[0], rim[-1] = RIM * (r0 > 0), RIM * (r1 < passable.shape[0])
    rim[:, 0] |= RIM * (c0 > 0)
    rim[:, -1] |= RIM * (c1 < passable.shape[1])
    return march


def _inner(array: NDArray[Number], width: int) -> NDArray[Number]:
    # A flat array as a grid without its border, as a view.
    return array.reshape(-1, width)[2:-2, 2:-2]
