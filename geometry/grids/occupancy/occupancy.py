"""The class that composes layers, painting, changes and frontier groups."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.march_cells import first_outside
from multisrt.geometry.grids.occupancy.change_log import ChangeLog
from multisrt.geometry.grids.occupancy.frontier_groups import FrontierGroup, FrontierGroups
from multisrt.geometry.grids.occupancy.layers import (
    UNKNOWN,
    empty_layers,
    grown,
    holds_region,
)
from multisrt.geometry.grids.occupancy.painting import paint_region
from multisrt.geometry.grids.occupancy.passability import (
    block_discs,
    frontier_is_within,
    indices_at,
    nearest_passable,
)
from multisrt.geometry.grids.raster import (
    OFFSET_X,
    OFFSET_Y,
    Corners,
    refuse_cell_width,
    refuse_corners,
)
from multisrt.geometry.numerics.arrays import BoolArray, ByteArray, FloatArray, IntArray
from multisrt.geometry.numerics.boxes import bounds_of
from multisrt.geometry.regions.safe_region import LocalSafeRegion

ROUNDING_CELLS: Final = 1e-9
"""Lengths that differ by less than this many cells count as equal."""


class Occupancy:
    """Cells that are unknown, free or occupied, and where a round body can stand.

    The same regions in any order, however often they are added, lead to the same cells, the same
    passable cells and the same frontier groups.

    Parameters
    ----------
    cell_m : float
        Width of a cell in metres, at most the diameter of the body.
    radius_m : float
        Distance that the body's centre keeps from every surface, in metres.
    bounds : (x0, y0, x1, y1), optional
        The first window in metres; it grows to hold regions outside.

    Attributes
    ----------
    cell_m, radius_m : float
        As given.

    Raises
    ------
    InvalidInputError
        If a length is not positive and finite, or the cells are wider than the body.

    Notes
    -----
    A cell is free if its centre lies in a region. It is occupied if a piece of a region's
    boundary that is tagged as an obstacle passes through it, whatever else is known of it. Such
    a piece occupies a cell between any two neighbouring centres that it separates, so the
    frontier never leads through a surface that was seen.

    Adding a region costs time in proportion to its bounds, whatever the size of the world.

    `blocked` changes `passable` for a while: an occupancy is not shared between threads.

    Examples
    --------
    A robot sees a room of 4 m x 3 m from within, but for one side beyond its range:

    >>> from multisrt.geometry.regions.boundary import OBSTACLE, RANGE
    >>> corners = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
    >>> tags = np.array([OBSTACLE, RANGE, OBSTACLE, OBSTACLE], np.int8)
    >>> region = LocalSafeRegion(x=1.0, y=1.0, range_m=3.0, boundary=corners, tags=tags)
    >>> occupancy = Occupancy(0.1, 0.25)
    >>> occupancy.add(region) > 0
    True
    >>> occupancy.is_known(2.0, 1.5), occupancy.is_known(5.0, 1.5)
    (True, False)

    The open side is one frontier group, with a target in its middle:

    >>> [group] = occupancy.frontier_groups()
    >>> round(group.size_m, 1)
    2.9
    >>> x, y = occupancy.centre_of(*group.target)
    >>> round(x, 1), round(y, 1)
    (4.0, 1.5)
    """

    __slots__ = (
        "_blocks",
        "_changes",
        "_cleared",
        "_groups",
        "_is_unblocked",
        "_layers",
        "cell_m",
        "radius_m",
    )

    def __init__(
        self,
        cell_m: float,
        radius_m: float,
        bounds: tuple[float, float, float, float] | None = None,
    ) -> None:
        refuse_cell_width(cell_m)
        if not 0.0 < radius_m < math.inf:
            raise InvalidInputError(f"a body has a positive radius in metres, not {radius_m}")
        if cell_m > 2.0 * radius_m * (1.0 + ROUNDING_CELLS):
            raise InvalidInputError(
                f"cells of {cell_m:g} m are wider than the body: choose at most {2 * radius_m:g} m"
            )
        self.cell_m = cell_m
        self.radius_m = radius_m
        self._layers = empty_layers(cell_m)
        self._changes = ChangeLog()
        self._groups = FrontierGroups()
        self._blocks = 0
        self._is_unblocked = False
        self._cleared: list[IntArray | None] = []
        if bounds is not None:
            self._layers = grown(self._layers, bounds)

    @property
    def row(self) -> int:
        """Lattice row of the first row of the arrays; it falls when the window grows downwards."""
        return self._layers.row

    @property
    def column(self) -> int:
        """Lattice column of the first column of the arrays; it falls as the window grows left."""
        return self._layers.column

    @property
    def cells(self) -> ByteArray:
        """`UNKNOWN`, `FREE` or `OCCUPIED` for each cell, (rows, columns); row 0 is the lowest."""
        return self._layers.states

    @property
    def passable(self) -> BoolArray:
        """Whether each cell is free and `radius_m` off every surface seen, (rows, columns)."""
        return self._layers.passable

    @property
    def revision(self) -> int:
        """Number of changes to `cells` and `passable` so far."""
        return self._changes.revision

    @property
    def x0(self) -> float:
        """Left border of the window in metres."""
        return (self.column - OFFSET_X) * self.cell_m

    @property
    def y0(self) -> float:
        """Lower border of the window in metres."""
        return (self.row - OFFSET_Y) * self.cell_m

    @property
    def diagonal_m(self) -> float:
        """Length of the window's diagonal in metres."""
        return math.hypot(*self.cells.shape) * self.cell_m

    def add(self, region: LocalSafeRegion) -> int:
        """Add what a region shows.

        Parameters
        ----------
        region : LocalSafeRegion
            Free space around a place, with a tagged boundary.

        Returns
        -------
        int
            Number of cells that were unknown and no longer are. It may be 0 although something
            has changed, for a free cell may have become occupied; see `revision`.

        Raises
        ------
        InvalidInputError
            If the raster would grow too large, discs are `blocked`, or a corner of the region is
            not finite. Nothing has changed then.
        """
        if self._blocks:
            raise InvalidInputError("no region can be added while discs are blocked: leave first")
        margin = self.radius_m + self.cell_m
        if not holds_region(self._layers, region.boundary, margin):
            refuse_corners(region.boundary, self.cell_m)
            x0, y0, x1, y1 = bounds_of(region.boundary)
            self._layers = grown(self._layers, (x0 - margin, y0 - margin, x1 + margin, y1 + margin))
        new, first_row, last_row, first_column, last_column = paint_region(
            region.boundary, region.tags, self._layers, self.radius_m
        )
        if first_row <= last_row:
            window = (first_row, last_row + 1, first_column, last_column + 1)
            self._changes.add(window)
            self._groups.note_change(window, self._layers)
        return new

    def changed_since(self, revision: int) -> Corners | None:
        """Return a window of all cells that have changed after a revision.

        Parameters
        ----------
        revision : int
            An earlier value of `revision`.

        Returns
        -------
        (r0, r1, c0, c1) or None
            Rows r0 to r1 - 1 and columns c0 to c1 - 1 of the lattice hold every later change to
            `cells` and `passable`, and for a revision long ago earlier ones as well. None if
            nothing has changed. Cells outside can have become or ceased to be frontier only if
            they touch the window.
        """
        return self._changes.since(revision)

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """Return the lattice row and column of the cell that holds a point.

        Parameters
        ----------
        x, y : float
            The point in metres, inside the window or not.
        """
        return math.floor(y / self.cell_m + OFFSET_Y), math.floor(x / self.cell_m + OFFSET_X)

    def cells_of(self, places: ArrayLike) -> IntArray:
        """Return the lattice rows and columns of the cells that hold points, ``(k, 2)``.

        Parameters
        ----------
        places : (k, 2) array_like
            Points x, y in metres, inside the window or not.
        """
        points = np.asarray(places, np.float64).reshape(-1, 2)
        return np.floor(points[:, ::-1] / self.cell_m + (OFFSET_Y, OFFSET_X)).astype(np.int64)

    def centre_of(self, row: int, column: int) -> tuple[float, float]:
        """Return the centre x, y of a cell in metres, by its lattice row and column."""
        cell = self.cell_m
        return (column + 0.5) * cell - OFFSET_X * cell, (row + 0.5) * cell - OFFSET_Y * cell

    def centres_of(self, cells: ArrayLike) -> FloatArray:
        """Return the centres x, y of cells in metres, ``(k, 2)``.

        Parameters
        ----------
        cells : (k, 2) array_like of int
            Lattice rows and columns.
        """
        rows_columns = np.asarray(cells, np.int64).reshape(-1, 2)
        centres = rows_columns[:, ::-1].astype(np.float64)
        return (centres + 0.5) * self.cell_m - np.array((OFFSET_X, OFFSET_Y)) * self.cell_m

    def indices_of(self, cells: ArrayLike) -> tuple[IntArray, IntArray]:
        """Return where cells are in the arrays at present.

        Parameters
        ----------
        cells : (k, 2) array_like of int
            Lattice rows and columns.

        Returns
        -------
        rows, columns : (k,) arrays of int
            Indices into `cells` and `passable`, valid until the window grows.

        Raises
        ------
        InvalidInputError
            If a cell is not in the window.
        """
        index = np.array(cells, np.int64, order="C").reshape(-1, 2)
        index -= (self.row, self.column)
        self._require_inside(index)
        return index[:, 0], index[:, 1]

    def indices_at(self, places: ArrayLike) -> IntArray:
        """Return where the cells that hold points are in the arrays at present, ``(k, 2)``.

        Parameters
        ----------
        places : (k, 2) array_like
            Points x, y in metres.

        Raises
        ------
        InvalidInputError
            If a point is not in the window.
        """
        points = np.ascontiguousarray(places, np.float64).reshape(-1, 2)
        index = indices_at(points, self._layers)
        self._require_inside(index)
        return index

    def _require_inside(self, index: IntArray) -> None:
        rows, columns = self.cells.shape
        outside = first_outside(index, rows, columns)
        if outside >= 0:
            row, column = (index[outside] + (self.row, self.column)).tolist()
            raise InvalidInputError(
                f"cell ({row}, {column}) is not in the window of {rows} rows from "
                f"{self.row} and {columns} columns from {self.column}"
            )

    def square(self, row: int, column: int, width: int) -> ByteArray:
        """Return the cells of a square, `UNKNOWN` where nothing is stored.

        Parameters
        ----------
        row, column : int
            Lattice row and column of its first cell.
        width : int
            Number of its rows and columns.

        Returns
        -------
        (width, width) array of uint8
            A copy of `cells` there.
        """
        found = np.full((width, width), UNKNOWN, np.uint8)
        row, column = row - self.row, column - self.column
        rows, columns = self.cells.shape
        r0, r1 = max(0, row), min(rows, row + width)
        c0, c1 = max(0, column), min(columns, column + width)
        if r0 < r1 and c0 < c1:
            found[r0 - row : r1 - row, c0 - column : c1 - column] = self.cells[r0:r1, c0:c1]
        return found

    def window_of(self, corners: Corners) -> Corners:
        """Return where a window ``(r0, r1, c0, c1)`` of the lattice is in the arrays at present."""
        r0, r1, c0, c1 = corners
        return r0 - self.row, r1 - self.row, c0 - self.column, c1 - self.column

    def is_known(self, x: float, y: float) -> bool:
        """Whether the cell that holds a point is free or occupied."""
        row, column = self.cell_of(x, y)
        row, column = row - self.row, column - self.column
        rows, columns = self.cells.shape
        inside = 0 <= row < rows and 0 <= column < columns
        return inside and bool(self.cells[row, column] != UNKNOWN)

    def passable_near(self, x: float, y: float, within_cells: int) -> tuple[int, int] | None:
        """Return the passable cell whose centre is nearest to a point.

        Parameters
        ----------
        x, y : float
            The point in metres.
        within_cells : int
            Maximum distance in rows and in columns from the cell that holds the point.

        Returns
        -------
        (row, column) or None
            Lattice row and column, of equally near cells the first in row-major order; None if
            there is none.
        """
        found = nearest_passable(x, y, within_cells, self._layers)
        if found < 0:
            return None
        row, column = divmod(int(found), self.passable.shape[1])
        return row + self.row, column + self.column

    def passable_centres(self, x: float, y: float, half_width_m: float) -> FloatArray:
        """Return the centres of the passable cells in a square around a point.

        Parameters
        ----------
        x, y : float
            The point in metres.
        half_width_m : float
            Half the width of the square in metres, rounded up to whole cells.

        Returns
        -------
        (k, 2) array
            Points x, y in metres, in row-major order of their cells.
        """
        reach = math.ceil(half_width_m / self.cell_m)
        row, column = self.cell_of(x, y)
        r0, c0 = max(0, row - self.row - reach), max(0, column - self.column - reach)
        r1, c1 = row - self.row + reach + 1, column - self.column + reach + 1
        cells = np.argwhere(self.passable[r0 : max(r0, r1), c0 : max(c0, c1)])
        return self.centres_of(cells + np.array([r0 + self.row, c0 + self.column]))

    def has_frontier_near(self, x: float, y: float, radius_m: float) -> bool:
        """Whether the centre of a frontier cell lies within a radius of a point, in metres."""
        return bool(frontier_is_within(x, y, radius_m, self._layers))

    def frontier_groups(self, min_size_m: float | None = None) -> list[FrontierGroup]:
        """Return the groups of frontier cells, in row-major order of their first cells.

        Frontier cells are free cells with an unknown one among their four neighbours, whether
        they are passable or not: an opening has its full width.

        Parameters
        ----------
        min_size_m : float, optional
            Smaller groups are omitted; by default those smaller than the body's diameter.

        Returns
        -------
        list of FrontierGroup
            Groups where nothing has changed since the last call are the same objects as before.
            Targets do not depend on discs that are `blocked`.
        """
        size_m = 2.0 * self.radius_m if min_size_m is None else min_size_m
        size_m -= ROUNDING_CELLS * self.cell_m
        return [group for group in self._groups.all(self._layers) if group.size_m >= size_m]

    @contextmanager
    def blocked(self, discs: ArrayLike) -> Iterator[None]:
        """Make cells within some discs not passable while a ``with`` block is executed.

        Blocks can be nested. `revision` does not change, and no region can be added meanwhile.

        Parameters
        ----------
        discs : (k, 3) array_like
            Centres x, y and radii in metres; a cell is blocked if its centre lies in a disc.

        Raises
        ------
        InvalidInputError
            If a number is not finite.
        """
        circles = np.ascontiguousarray(discs, dtype=np.float64).reshape(-1, 3)
        if not np.isfinite(circles).all():
            raise InvalidInputError("blocked discs are finite x, y and radii in metres")
        passable, cleared = self.passable, None
        if len(circles):
            cleared = block_discs(circles, self._layers)
        self._blocks += 1
        self._cleared.append(cleared)
        try:
            yield
        finally:
            self._blocks -= 1
            self._cleared.pop()
            if cleared is not None:
                passable.reshape(-1)[cleared] = True

    @contextmanager
    def unblocked(self) -> Iterator[None]:
        """Make cells passable again that are `blocked`, while a ``with`` block is executed.

        What is kept for longer than a block, as distances from places, is to be computed so. Such
        blocks cannot be nested.

        Raises
        ------
        InvalidInputError
            Inside another such block.

        Examples
        --------
        >>> raster = Occupancy(0.1, 0.25)
        >>> with raster.blocked([(1.0, 1.0, 0.5)]), raster.unblocked():
        ...     raster.passable.any()
        np.False_
        """
        if self._is_unblocked:
            raise InvalidInputError(
                "`unblocked` cannot be nested: the cells are passable again already"
            )
        cells = self.passable.reshape(-1)
        again = [cleared for cleared in self._cleared if cleared is not None]
        for cleared in again:
            cells[cleared] = True
        self._is_unblocked = True
        try:
            yield
        finally:
            self._is_unblocked = False
            for cleared in again:
                cells[cleared] = False
