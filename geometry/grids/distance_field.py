"""Geodesic distances on a grid: how far it is to every free cell, around the obstacles."""

from __future__ import annotations

import math
from typing import Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.fast_march import (
    BLOCKED,
    EXACT_CELLS,
    RIM,
    ask,
    descend,
    first_accepted,
    forget,
    march,
    moved_cells,
    numbers_of,
    seed,
    take_back,
)
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray

MARGIN_CELLS: Final = 48
"""The part of the grid that a field looks at first reaches this far around its sources."""

Number = TypeVar("Number", np.uint8, np.int32, np.float64)


def distance_field(
    free: BoolArray,
    cell_m: float,
    sources: ArrayLike,
    *,
    x0: float = 0.0,
    y0: float = 0.0,
    asked: ArrayLike | None = None,
) -> FloatArray:
    """Compute the length of the shortest path from the nearest source to every free cell.

    Parameters
    ----------
    free : (rows, columns) array of bool
        Where a path may run; row 0 is the lowest y.
    cell_m : float
        Width of a cell in metres.
    sources : (k, 2) array
        Points x, y in metres, each in a free cell.
    x0, y0 : float
        Lower left corner of the grid in metres.
    asked : (m, 2) array of int, optional
        Rows and columns of the cells that matter. The march ends once all of them that are free
        have their final values; cells that it has not reached by then are ``inf``.

    Returns
    -------
    (rows, columns) array
        Distances to the cells' centres in metres; ``inf`` in blocked and in unreachable cells.

    Raises
    ------
    InvalidInputError
        If the grid is not two-dimensional, the cell not positive, there is no source, a source
        is not in a free cell, or an asked cell is not in the grid.

    Notes
    -----
    Fast marching with one-sided differences of second order where the cells for them are known,
    of first order elsewhere. Cost: O(n log n) for n cells reached. Compared with the shortest
    paths of a visibility graph in nine rooms with doors, distances are too long by 0.54 % in the
    mean with cells of 0.1 m, 0.22 % with 0.05 m and 0.15 % with 0.025 m, which is lost where
    paths turn around corners; where nothing is in the way the mean error is 0.03 %.

    Source: J. A. Sethian, Fast marching methods, SIAM Review 41 (1999), sections 3 and 5;
    differs in: exact values around a source.

    Examples
    --------
    >>> import numpy as np
    >>> free = np.ones((3, 5), bool)
    >>> free[:2, 2] = False
    >>> field = distance_field(free, 1.0, [(0.5, 0.5)])
    >>> bool(field[0, 0] == 0.0), bool(np.isinf(field[0, 2])), bool(5.0 < field[0, 4] < 6.5)
    (True, True, True)
    """
    field = DistanceField(np.asarray(free, np.bool_), cell_m, sources, x0=x0, y0=y0)
    if asked is None:
        field.complete()
    else:
        field.distance(asked)
    return field.reached()


class DistanceField:
    """Lengths of the shortest paths from the nearest source, computed as far as they are asked for.

    The march stops once the cells asked for are final and goes on when others are. It works on
    a window of the grid that doubles when the front comes to its rim, so that neither time nor
    memory depend on the size of the grid. When cells have changed, `repair` takes back what
    they may have had a share in and keeps the rest.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Where a path may run; row 0 is the lowest y. It is read again later, not copied: whoever
        changes it calls `repair` before asking for more.
    cell_m : float
        Width of a cell in metres.
    sources : (k, 2) array
        Points x, y in metres, each in a passable cell.
    x0, y0 : float
        Lower left corner of the grid in metres.

    Raises
    ------
    InvalidInputError
        If the grid is not two-dimensional or not of bool, the cell not positive, there is no
        source, or a source is not in a passable cell.

    Notes
    -----
    Cells of equal value are accepted by row and column, so that a march is a sequence that the
    grid alone determines: stopping, going on and repairing lead to the same bits as a new
    march. See `distance_field` for the method and its error.

    Examples
    --------
    >>> import numpy as np
    >>> passable = np.ones((3, 5), bool)
    >>> field = DistanceField(passable, 1.0, [(0.5, 0.5)])
    >>> field.distance([(0, 4)]).tolist()
    [4.0]
    >>> passable[:, 2] = False
    >>> field.repair((0, 3, 2, 3))
    >>> field.distance([(0, 4), (0, 1)]).tolist()
    [inf, 1.0]
    """

    def __init__(
        self,
        passable: BoolArray,
        cell_m: float,
        sources: ArrayLike,
        *,
        x0: float = 0.0,
        y0: float = 0.0,
    ) -> None:
        self.passable = passable
        self.cell_m = cell_m
        self.x0, self.y0 = x0, y0
        self.sources: FloatArray = np.array(sources, np.float64)
        self._starts = cells_of(self.sources, passable, cell_m, x0, y0)
        # Of a window of the grid, which has a border of two blocked cells in these arrays.
        self._window = (0, 0, 0, 0)
        self._width = 0
        self._state = np.empty(0, np.uint8)
        self._marks = np.empty(0, np.uint8)
        self._distance = np.empty(0)
        self._places = np.empty(0, np.int32)
        # Cells in the order in which they were accepted, and those that have a value but not
        # their final one; what the march began with.
        self._order, self._count = np.empty(0, np.int32), 0
        self._heap, self._keys, self._held = np.empty(0, np.int32), np.empty(0), 0
        self._seeds, self._seed_values = np.empty(0, np.int32), np.empty(0)
        self._begin()

    @property
    def starts(self) -> FloatArray:
        """The sources in widths of cells from the grid's corner, columns first, (k, 2)."""
        return self._starts

    def distance(self, cells: ArrayLike, at_most_m: float = math.inf) -> FloatArray:
        """Length of the shortest path to the centre of each of some cells.

        Parameters
        ----------
        cells : (k, 2) array of int
            Rows and columns.
        at_most_m : float
            The front goes no farther; what it has come to before counts all the same.

        Returns
        -------
        (k,) array
            Metres; ``inf`` where no path leads, or none that is so short.

        Raises
        ------
        InvalidInputError
            If a cell is not in the grid.
        """
        rows, columns = asked_cells(cells, self.passable)
        self._march_to(rows, columns, all_of_them=True, at_most_m=at_most_m)
        at = numbers_of(rows, columns, self._window, self._width)
        lengths: FloatArray = self._distance[at] * self.cell_m
        return lengths

    def first(self, cells: ArrayLike, at_most_m: float = math.inf) -> tuple[int, float] | None:
        """Which of some cells is nearest: the first that the front comes to; and how far it is.

        Parameters
        ----------
        cells : (k, 2) array of int
            Rows and columns.
        at_most_m : float
            The front goes no farther to find one; what it has come to before counts all the same.

        Returns
        -------
        (index, length) or None
            Its index, the smallest if the cell is there twice, and metres; None if no path leads
            to any, or none that is so short.

        Raises
        ------
        InvalidInputError
            If a cell is not in the grid.
        """
        rows, columns = asked_cells(cells, self.passable)
        self._march_to(rows, columns, all_of_them=False, at_most_m=at_most_m)
        at = numbers_of(rows, columns, self._window, self._width)
        first = first_accepted(at, self._state, self._places)
        if first < 0:
            return None
        return first, float(self._distance[at[first]] * self.cell_m)

    def complete(self) -> None:
        """March until every cell that can be reached has its final value."""
        self._look_at((0, self.passable.shape[0], 0, self.passable.shape[1]))
        self._advance(-1)

    def reached(self) -> FloatArray:
        """Distances in metres to all cells that are final by now, ``inf`` elsewhere.

        Returns
        -------
        (rows, columns) array
        """
        field = np.full(self.passable.shape, np.inf)
        r0, r1, c0, c1 = self._window
        field[r0:r1, c0:c1] = self._inner(self._distance) * self.cell_m
        return field

    def descent(self, cell: ArrayLike) -> IntArray:
        """Follow the field from a cell down to a source, each time to the steepest of 8 neighbours.

        Parameters
        ----------
        cell : (2,) array of int
            Row and column.

        Returns
        -------
        (n, 2) array of int
            Rows and columns, from the cell to one that holds or touches a source; two cells that
            meet in a corner follow one another only if both cells beside it are passable.

        Raises
        ------
        InvalidInputError
            If the cell is not in the grid, or no path leads there.
        """
        return self.descents(cell)[0]

    def descents(self, cells: ArrayLike) -> tuple[IntArray, IntArray]:
        """Follow the field from many cells, as `descent` does from one.

        Parameters
        ----------
        cells : (k, 2) array of int
            Rows and columns.

        Returns
        -------
        ways : (n, 2) array of int
            The ways, one after the other.
        begins : (k + 1,) array of int
            Way i is ``ways[begins[i]:begins[i + 1]]``.

        Raises
        ------
        InvalidInputError
            If a cell is not in the grid, or no path leads there.
        """
        rows, columns = asked_cells(cells, self.passable)
        lost = np.flatnonzero(np.isinf(self.distance(cells)))
        if len(lost):
            raise InvalidInputError(
                f"no path leads to cell ({rows[lost[0]]}, {columns[lost[0]]}): its distance tells"
            )
        at = numbers_of(rows, columns, self._window, self._width)
        down, begins = descend(at, self._state, self._distance, self._width)
        row, column = np.divmod(down, self._width)
        ways = np.column_stack([row - 2 + self._window[0], column - 2 + self._window[2]])
        return ways, begins

    def repair(self, window: tuple[int, int, int, int]) -> None:
        """Take in that cells have become passable or blocked.

        All values from the first on that a changed cell may have had a share in are taken
        back; the front goes on from there when it is asked for them. Where a change lies within
        `EXACT_CELLS` of a source the field starts anew. Whatever the changes, all later answers
        are those of a new field, to the bit.

        Parameters
        ----------
        window : (r0, r1, c0, c1)
            Rows r0 to r1 - 1 and columns c0 to c1 - 1 hold all cells that have changed.

        Raises
        ------
        InvalidInputError
            If a source's cell is blocked now; the field is as before then.
        """
        r0, c0 = max(window[0], self._window[0]), max(window[2], self._window[2])
        r1, c1 = min(window[1], self._window[1]), min(window[3], self._window[3])
        if r0 >= r1 or c0 >= c1:
            return
        below, left = self._window[0], self._window[2]
        known = self._inner(self._state)[r0 - below : r1 - below, c0 - left : c1 - left]
        rows, columns = np.nonzero((known != BLOCKED) != self.passable[r0:r1, c0:c1])
        if not len(rows):
            return
        rows, columns = rows + r0, columns + c0
        for x, y in self._starts.tolist():
            near = (abs(rows - int(y)) <= EXACT_CELLS) & (abs(columns - int(x)) <= EXACT_CELLS)
            if near.any():
                cells_of(self.sources, self.passable, self.cell_m, self.x0, self.y0)
                self._begin()
                return
        self._held, self._count = take_back(
            numbers_of(rows, columns, self._window, self._width),
            self._state,
            self._distance,
            self._places,
            self._order,
            self._heap,
            self._keys,
            self._held,
            self._count,
            self._width,
            self._seeds,
            self._seed_values,
        )

    def _begin(self) -> None:
        columns, rows = self._starts.astype(np.int64).T
        shape = self.passable.shape
        self._held = self._count = 0
        self._window = (0, 0, 0, 0)
        self._look_at(
            (
                max(0, int(rows.min()) - MARGIN_CELLS),
                min(shape[0], int(rows.max()) + MARGIN_CELLS + 1),
                max(0, int(columns.min()) - MARGIN_CELLS),
                min(shape[1], int(columns.max()) + MARGIN_CELLS + 1),
            )
        )
        r0, r1, c0, c1 = self._window
        self._held = seed(
            np.ascontiguousarray(self.passable[r0:r1, c0:c1]),
            self._starts - (c0, r0),
            self._state,
            self._places,
            self._heap,
            self._keys,
            self._width,
        )
        self._seeds = self._heap[1 : self._held + 1].copy()
        self._seed_values = self._keys[1 : self._held + 1].copy()

    def _look_at(self, window: tuple[int, int, int, int]) -> None:
        # Take over what is known into arrays for a larger window. They have a border of two
        # blocked cells, so that no neighbour is out of bounds; cells on the rim are marked
        # where the grid goes on behind it.
        old = self._window
        if window == old:
            return
        r0, r1, c0, c1 = window
        rows, columns = r1 - r0, c1 - c0
        width, size = columns + 4, (rows + 4) * (columns + 4)
        state, marks = np.zeros(size, np.uint8), np.zeros(size, np.uint8)
        distance, places = np.full(size, np.inf), np.zeros(size, np.int32)
        self._marks, self._width, self._window = marks, width, window
        self._inner(state)[:] = self.passable[r0:r1, c0:c1]
        rim = self._inner(marks)
        rim[0], rim[-1] = RIM * (r0 > 0), RIM * (r1 < self.passable.shape[0])
        rim[:, 0] |= RIM * (c0 > 0)
        rim[:, -1] |= RIM * (c1 < self.passable.shape[1])
        order, heap = np.empty(size, np.int32), np.empty(size, np.int32)
        keys = np.empty(size)
        keys[0] = np.inf
        if old[0] < old[1]:
            below, left, across = old[0] - r0, old[2] - c0, old[3] - old[2] + 4
            part = np.s_[below : below + old[1] - old[0], left : left + old[3] - old[2]]
            self._inner(state)[part] = self._state.reshape(-1, across)[2:-2, 2:-2]
            self._inner(distance)[part] = self._distance.reshape(-1, across)[2:-2, 2:-2]
            self._inner(places)[part] = self._places.reshape(-1, across)[2:-2, 2:-2]
            count, end = self._count, self._held + 1
            order[:count] = moved_cells(self._order[:count], across, width, below, left)
            heap[1:end] = moved_cells(self._heap[1:end], across, width, below, left)
            keys[1:end] = self._keys[1:end]
            self._seeds = moved_cells(self._seeds, across, width, below, left)
        self._state, self._distance, self._places = state, distance, places
        self._order, self._heap, self._keys = order, heap, keys

    def _widen(self) -> None:
        # Double the window, to all sides at once: memory costs less than moving into it does.
        r0, r1, c0, c1 = self._window
        more = max(r1 - r0, c1 - c0) // 2 + 1
        rows, columns = self.passable.shape
        self._look_at(
            (max(0, r0 - more), min(rows, r1 + more), max(0, c0 - more), min(columns, c1 + more))
        )

    def _march_to(
        self,
        rows: IntArray,
        columns: IntArray,
        *,
        all_of_them: bool,
        at_most_m: float = math.inf,
    ) -> None:
        # Mark the cells asked for that are not final yet and march to the last or first of them.
        free = self.passable[rows, columns]
        rows, columns = rows[free], columns[free]
        limit = at_most_m / self.cell_m
        while True:
            at = numbers_of(rows, columns, self._window, self._width)
            missing, final = ask(at, self._state, self._marks)
            if missing and (all_of_them or not final):
                more = self._advance(missing if all_of_them else 1, limit, widen=False)
            else:
                more = False
            forget(at, self._marks)
            if not more:
                return
            self._widen()

    def _advance(self, remaining: int, limit: float = math.inf, *, widen: bool = True) -> bool:
        # March until so many marked cells are accepted; True if the window is too small for it.
        while True:
            self._held, self._count, at_rim = march(
                self._state,
                self._marks,
                self._distance,
                self._places,
                self._order,
                self._heap,
                self._keys,
                self._held,
                self._count,
                self._width,
                remaining,
                limit,
            )
            if not at_rim or not widen:
                return bool(at_rim)
            self._widen()

    def _inner(self, array: NDArray[Number]) -> NDArray[Number]:
        return array.reshape(-1, self._width)[2:-2, 2:-2]


def cells_of(
    sources: ArrayLike, free: BoolArray, cell_m: float, x0: float, y0: float
) -> FloatArray:
    """Give sources in widths of cells from the grid's corner: (r, c) is [c, c + 1) x [r, r + 1).

    Raises `InvalidInputError` for one that is not in a free cell, or if that is no grid.
    """
    if free.ndim != 2:
        raise InvalidInputError(f"a grid of free cells has two dimensions, not {free.ndim}")
    if free.dtype != np.bool_:
        raise InvalidInputError(f"a grid of free cells is of bool, not {free.dtype}")
    if not 0.0 < cell_m < math.inf:
        raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")
    points = np.asarray(sources, np.float64)
    if points.ndim != 2 or points.shape[1:] != (2,) or not len(points):
        raise InvalidInputError(f"sources are a (k, 2) array with k > 0, not {points.shape}")
    rows, columns = free.shape
    cells: FloatArray = (points - (x0, y0)) / cell_m
    for k, (column, row) in enumerate(cells.tolist()):
        inside = 0.0 <= column < columns and 0.0 <= row < rows
        if not (inside and free[int(row), int(column)]):
            raise InvalidInputError(
                f"source {k} at ({points[k, 0]:g}, {points[k, 1]:g}) is not in a free cell: "
                "move it to one"
            )
    return cells


def asked_cells(asked: ArrayLike, free: BoolArray) -> tuple[IntArray, IntArray]:
    """Give rows and columns of cells; raises `InvalidInputError` for one outside the grid."""
    cells = np.asarray(asked, np.int64).reshape(-1, 2)
    outside = (cells < 0) | (cells >= free.shape)
    if outside.any():
        row, column = cells[int(np.flatnonzero(outside.any(axis=1))[0])]
        raise InvalidInputError(
            f"the asked cell ({row}, {column}) is not in the grid of "
            f"{free.shape[0]} rows and {free.shape[1]} columns"
        )
    return cells[:, 0], cells[:, 1]
