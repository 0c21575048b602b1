"""Geodesic distances on a grid: lengths of the shortest paths around the obstacles."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.connected import connected
from multisrt.geometry.grids.fast_march import EXACT_CELLS, descend
from multisrt.geometry.grids.field_inputs import checked_cells, checked_sources
from multisrt.geometry.grids.march_window import MarchWindow
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray

NO_CELLS: Final[IntArray] = np.empty((0, 2), np.int64)


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
    sources : (k, 2) array_like
        Points x, y in metres, each in a free cell.
    x0, y0 : float
        Lower left corner of the grid in metres.
    asked : (m, 2) array_like of int, optional
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
    paths of a visibility graph in nine rooms with doors, distances are too long by 0.54 % on
    average with cells of 0.1 m, 0.22 % with 0.05 m and 0.15 % with 0.025 m; the error arises
    where paths turn around corners. Where nothing is in the way it is 0.03 % on average.

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
    """Lengths of the shortest paths from the nearest source, computed as far as needed.

    The march stops once the cells asked for are final and continues when others are. It works on
    a window of the grid that grows when the front reaches its rim, so that neither time nor
    memory depend on the size of the grid. When cells have changed, `repair` takes back what
    they may have had a share in and keeps the rest.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Where a path may run; row 0 is the lowest y. It is not copied: call `repair` after a
        change and before the next query.
    cell_m : float
        Width of a cell in metres.
    sources : (k, 2) array_like
        Points x, y in metres, each in a passable cell.
    x0, y0 : float
        Lower left corner of the grid in metres.

    Attributes
    ----------
    passable, cell_m, x0, y0
        As given.
    sources : (k, 2) array
        As given.

    Raises
    ------
    InvalidInputError
        If the grid is not two-dimensional or not of bool, the cell not positive, there is no
        source, or a source is not in a passable cell.

    Notes
    -----
    Cells of equal value are accepted by row and column, so that the grid alone determines the
    sequence: stopping, going on and repairing lead to the same bits as a new march. See
    `distance_field` for the method and its error. Queries march on: a field is not shared
    between threads.

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

    __slots__ = ("_march", "_starts", "cell_m", "passable", "sources", "x0", "y0")

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
        self._starts = checked_sources(self.sources, passable, cell_m, x0, y0)
        # The march begins when cells are asked for, with room for the paths to them.
        self._march: MarchWindow | None = None

    @property
    def starts(self) -> FloatArray:
        """The sources x, y in widths of a cell from the grid's corner, (k, 2)."""
        return self._starts

    def distance(self, cells: ArrayLike, at_most_m: float = math.inf) -> FloatArray:
        """Return the length of the shortest path to the centre of each of some cells.

        Parameters
        ----------
        cells : (k, 2) array_like of int
            Rows and columns.
        at_most_m : float
            Length in metres beyond which the march does not continue. Cells that it has reached
            before keep their lengths.

        Returns
        -------
        (k,) array
            Metres; ``inf`` where there is no path, or none that is short enough.

        Raises
        ------
        InvalidInputError
            If a cell is not in the grid.

        Examples
        --------
        >>> field = DistanceField(np.ones((1, 9), bool), 0.5, [(0.25, 0.25)])
        >>> field.distance([(0, 2), (0, 8)], at_most_m=1.0).tolist()
        [1.0, inf]
        """
        asked = checked_cells(cells, self.passable)
        march = self._march_to(asked, farthest=True, at_most_m=at_most_m)
        lengths: FloatArray = march.values_of(asked) * self.cell_m
        return lengths

    def first(self, cells: ArrayLike, at_most_m: float = math.inf) -> tuple[int, float] | None:
        """Return which of some cells is nearest, and its distance.

        The march stops at the first of them, so this costs less than `distance` of all.

        Parameters
        ----------
        cells : (k, 2) array_like of int
            Rows and columns.
        at_most_m : float
            Length in metres beyond which the march does not continue. Cells that it has reached
            before count nevertheless.

        Returns
        -------
        (index, length) or None
            Index of the cell, the smallest if it is given twice, and metres; None if no path
            leads to any, or none that is short enough.

        Raises
        ------
        InvalidInputError
            If a cell is not in the grid.

        Examples
        --------
        >>> field = DistanceField(np.ones((1, 9), bool), 0.5, [(0.25, 0.25)])
        >>> field.first([(0, 8), (0, 4)])
        (1, 2.0)
        >>> field.first([(0, 8)], at_most_m=3.0) is None
        True
        """
        asked = checked_cells(cells, self.passable)
        march = self._march_to(asked, farthest=False, at_most_m=at_most_m)
        first, value = march.first_of(asked)
        return None if first < 0 else (first, value * self.cell_m)

    def reachable(self) -> BoolArray:
        """Return to which cells there is a path, without marching.

        Returns
        -------
        (rows, columns) array of bool
            Where the distance is finite. This takes about a thirtieth of the time of `complete`.

        Examples
        --------
        >>> passable = np.array([[True, True, False, True]])
        >>> DistanceField(passable, 0.5, [(0.25, 0.25)]).reachable().tolist()
        [[True, True, False, False]]
        """
        return connected(self.passable, self._starts[:, ::-1].astype(np.int64))

    def complete(self) -> None:
        """March until every cell that can be reached has its final value."""
        self._begun(NO_CELLS, farthest=False).complete()

    def reached(self) -> FloatArray:
        """Return the distances to all cells that are final by now.

        Returns
        -------
        (rows, columns) array
            Metres; ``inf`` in all other cells.
        """
        field = np.full(self.passable.shape, np.inf)
        if self._march is not None:
            r0, r1, c0, c1 = self._march.window
            field[r0:r1, c0:c1] = self._march.values() * self.cell_m
        return field

    @property
    def nbytes(self) -> int:
        """Memory of the arrays that the field has of its own, in bytes."""
        return 0 if self._march is None else self._march.nbytes

    def descent(self, cell: ArrayLike) -> IntArray:
        """Follow the field from a cell to a source, each step to the steepest of 8 neighbours.

        Parameters
        ----------
        cell : (2,) array_like of int
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

        Examples
        --------
        >>> field = DistanceField(np.ones((3, 4), bool), 1.0, [(0.5, 0.5)])
        >>> field.descent((2, 3)).tolist()
        [[2, 3], [1, 2], [0, 1], [0, 0]]
        """
        return self.descents(cell)[0]

    def descents(self, cells: ArrayLike) -> tuple[IntArray, IntArray]:
        """Follow the field from many cells, as `descent` does from one.

        Parameters
        ----------
        cells : (k, 2) array_like of int
            Rows and columns.

        Returns
        -------
        paths : (n, 2) array of int
            The cells of all paths, one path after the other.
        begins : (k + 1,) array of int
            Path i is ``paths[begins[i]:begins[i + 1]]``.

        Raises
        ------
        InvalidInputError
            If a cell is not in the grid, or no path leads there.
        """
        asked = checked_cells(cells, self.passable)
        march = self._march_to(asked, farthest=True)
        unreachable = np.flatnonzero(np.isinf(march.values_of(asked)))
        if len(unreachable):
            row, column = asked[unreachable[0]]
            raise InvalidInputError(
                f"no path leads to cell ({row}, {column}): its distance is infinite"
            )
        arrays = march.arrays
        at = march.numbers_of(asked)
        down, begins = descend(at, arrays.state, arrays.distance, arrays.width)
        return march.cells_of(down), begins

    def repair(self, window: tuple[int, int, int, int]) -> None:
        """Adapt to cells that have become passable or blocked.

        All values from the first on that a changed cell may have had a share in are taken
        back; the march continues from there when they are asked for. Where a change lies within
        `EXACT_CELLS` of a source the field is computed afresh. Whatever the changes, all later
        answers are those of a new field, to the bit.

        Parameters
        ----------
        window : (r0, r1, c0, c1)
            Rows r0 to r1 - 1 and columns c0 to c1 - 1 hold all cells that have changed.

        Raises
        ------
        InvalidInputError
            If the cell of a source is blocked now; the field is as before then.
        """
        if self._march is None:
            self._check_sources()
            return
        rows, columns = self._march.changes_in(window)
        if not len(rows):
            return
        for x, y in self._starts.tolist():
            near = (abs(rows - int(y)) <= EXACT_CELLS) & (abs(columns - int(x)) <= EXACT_CELLS)
            if near.any():
                self._check_sources()
                self._march = None
                return
        self._march.take_back(rows, columns)

    def _check_sources(self) -> None:
        checked_sources(self.sources, self.passable, self.cell_m, self.x0, self.y0)

    def _begun(self, cells: IntArray, *, farthest: bool) -> MarchWindow:
        if self._march is None:
            self._march = MarchWindow(self.passable, self._starts, cells, farthest=farthest)
        return self._march

    def _march_to(
        self, cells: IntArray, *, farthest: bool, at_most_m: float = math.inf
    ) -> MarchWindow:
        march = self._begun(cells, farthest=farthest)
        march.march_to(cells, farthest=farthest, limit=at_most_m / self.cell_m)
        return march
