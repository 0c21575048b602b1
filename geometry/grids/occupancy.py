"""What one robot knows of the world as a raster: free and occupied cells, and their frontier.

A cell is named by its row and column in the lattice, which `cell_m` alone fixes. The names stay
the same however the window of cells that are held grows, and two robots with cells of equal
width mean the same place by them. `Occupancy.indices_of` leads from them into the arrays.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.raster import (
    FARTHEST_CELL,
    OFFSET,
    Window,
    moved,
    refuse_cell_width,
    refuse_corners,
    row_crossings,
    window_over,
)
from multisrt.geometry.numerics.boxes import bounds_of
from multisrt.geometry.numerics.kernel import (
    BoolArray,
    FloatArray,
    IntArray,
    inlined_kernel,
    kernel,
    unsigned,
)
from multisrt.geometry.regions.boundary import OBSTACLE, TagArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion

UNKNOWN: Final = 0
"""No region holds the cell's centre."""
FREE: Final = 1
"""A region holds the cell's centre, and no surface passes through the cell."""
OCCUPIED: Final = 2
"""A surface passes through the cell."""

# Marks of a cell beside what it holds.
NEAR: Final = 1
"""A surface is nearer to the cell's centre than the body's radius."""
FRONTIER: Final = 2
"""The cell is free and one of its four neighbours is unknown."""
LABELLED: Final = 4
"""The cell has a label: it was frontier when labels were given last."""

CELL_BYTES: Final = 7
"""Memory of a cell in all arrays together."""

CHANGES_KEPT: Final = 64
"""So many changes are told apart; older ones are remembered as one."""

TOGETHER: Final = 8
"""Of so many pieces of a boundary it is asked at once whether there is anything new around them."""

ROUNDING_CELLS: Final = 1e-9
"""Widths that differ by less, in cells, are equal."""

Corners = tuple[int, int, int, int]
"""First row, row after the last, first column, column after the last, in the lattice."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrontierGroup:
    """Frontier cells that hang together over their eight neighbours.

    Attributes
    ----------
    cells : (k, 2) array of int
        Rows and columns in the lattice, row by row.
    target : (row, column) or None
        The passable cell of the group that is nearest to its centroid, the first one row by row
        if several are; None if the body can stand on none.
    size_m : float
        Length of the group in metres: of a straight one from end to end in any direction, of a
        crooked one the number of its cells times their width.
    """

    cells: IntArray
    target: tuple[int, int] | None
    size_m: float


class Occupancy:
    """Cells that are unknown, free or occupied, and where a round body can stand.

    The same regions in any order, however often, give the same cells, the same passable cells
    and the same frontier groups.

    Parameters
    ----------
    cell_m : float
        Width of a cell in metres, at most the body's width.
    radius_m : float
        How far the body's centre has to stay from every surface.
    bounds : (x0, y0, x1, y1), optional
        The window to begin with; regions outside make it grow.

    Attributes
    ----------
    cell_m, radius_m : float
        As given.
    row, column : int
        Where the first row and column of the arrays lie in the lattice. They fall when the
        window grows downwards or to the left.
    cells : (rows, columns) array of uint8
        `UNKNOWN`, `FREE` or `OCCUPIED`; row 0 is the lowest y.
    passable : (rows, columns) array of bool
        Whether a cell is free and its centre at least `radius_m` from every surface seen.
    revision : int
        How many changes there have been to the two.

    Raises
    ------
    InvalidInputError
        If the cells are wider than the body.

    Notes
    -----
    A cell is free if its centre lies in a region. It is occupied if a piece of a region's
    boundary passes through it that is tagged as an obstacle, whatever else is known of it.
    Between the centres of two neighbouring cells on either side of such a piece, one of them
    holds the crossing: so no surface that was seen lets the frontier through.

    Adding a region costs what lies in its bounds, whatever the size of the world.
    """

    __slots__ = (
        "_blocked",
        "_changes",
        "_first_cells",
        "_groups",
        "_labels",
        "_marks",
        "_next_label",
        "_older",
        "_unlabelled",
        "cell_m",
        "cells",
        "column",
        "passable",
        "radius_m",
        "revision",
        "row",
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
        self.row = self.column = 0
        self.cells: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)
        self.passable: BoolArray = np.zeros((0, 0), np.bool_)
        self.revision = 0
        self._marks: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)
        self._blocked = 0
        # Windows of the latest changes, each with its revision, and one over all before them.
        self._changes: deque[tuple[int, Corners]] = deque()
        self._older: tuple[int, Corners] | None = None
        # Frontier groups by label, their first cells in order, the label of every frontier cell,
        # and the windows where labels are out of date.
        self._groups: dict[int, FrontierGroup] = {}
        self._first_cells: list[tuple[int, int, int]] = []
        self._labels: NDArray[np.int32] = np.zeros((0, 0), np.int32)
        self._next_label = 1
        self._unlabelled: list[Corners] = []
        if bounds is not None:
            self._cover(bounds)

    @property
    def x0(self) -> float:
        """Left border of the window."""
        return (self.column - OFFSET) * self.cell_m

    @property
    def y0(self) -> float:
        """Lower border of the window."""
        return (self.row - OFFSET) * self.cell_m

    def add(self, region: LocalSafeRegion) -> int:
        """Learn what a region shows.

        Returns
        -------
        int
            How many cells were unknown before and no longer are. 0 does not mean that nothing
            has changed: a free cell may have become occupied, see `revision`.

        Raises
        ------
        InvalidInputError
            If the raster would grow too large, or while discs are `blocked`, or for a region with
            corners that are not finite.
        """
        if self._blocked:
            raise InvalidInputError("no region can be added while discs are blocked: leave first")
        margin = self.radius_m + self.cell_m
        if not _fits(
            region.boundary, margin, self.cell_m, self.row, self.column, *self.cells.shape
        ):
            refuse_corners(region.boundary, self.cell_m)
            x0, y0, x1, y1 = bounds_of(region.boundary)
            self._cover((x0 - margin, y0 - margin, x1 + margin, y1 + margin))
        new, first_row, last_row, first_column, last_column = _learn(
            region.boundary,
            region.tags,
            self.cell_m,
            self.radius_m,
            self.row,
            self.column,
            self.cells,
            self.passable,
            self._marks,
        )
        if first_row <= last_row:
            self._note_change((first_row, last_row + 1, first_column, last_column + 1))
        return new

    def changed_since(self, revision: int) -> Corners | None:
        """Give a window of all cells that have changed after a revision.

        Returns
        -------
        (r0, r1, c0, c1) or None
            Rows r0 to r1 - 1 and columns c0 to c1 - 1 in the lattice hold every change to
            `cells` and `passable` since, and for a revision long ago earlier ones too. None: there
            was no change. Cells outside can have become or ceased to be frontier only if they
            touch the window.
        """
        union: Corners | None = None
        for number, window in reversed(self._changes):
            if number <= revision:
                return union
            union = _around(union, window)
        if self._older is not None and self._older[0] > revision:
            union = _around(union, self._older[1])
        return union

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """Give the row and column, in the lattice, of the cell that holds a point."""
        return math.floor(y / self.cell_m + OFFSET), math.floor(x / self.cell_m + OFFSET)

    def cells_of(self, places: ArrayLike) -> IntArray:
        """Give the rows and columns, in the lattice, of the cells that hold (k, 2) points x, y."""
        points = np.asarray(places, np.float64).reshape(-1, 2)
        return np.floor(points[:, ::-1] / self.cell_m + OFFSET).astype(np.int64)

    def centre_of(self, row: int, column: int) -> tuple[float, float]:
        """Give x and y of a cell's centre."""
        shift = OFFSET * self.cell_m
        return (column + 0.5) * self.cell_m - shift, (row + 0.5) * self.cell_m - shift

    def centres_of(self, cells: ArrayLike) -> FloatArray:
        """Give the centres x, y of (k, 2) rows and columns in the lattice."""
        named = np.asarray(cells, np.int64).reshape(-1, 2)
        centres = named[:, ::-1].astype(np.float64)
        return (centres + 0.5) * self.cell_m - OFFSET * self.cell_m

    def indices_of(self, cells: ArrayLike) -> tuple[IntArray, IntArray]:
        """Give where (k, 2) rows and columns in the lattice are in the arrays at present.

        Raises
        ------
        InvalidInputError
            If a cell is not in the window.
        """
        named = np.asarray(cells, np.int64).reshape(-1, 2)
        index = named - (self.row, self.column)
        outside = ((index < 0) | (index >= self.cells.shape)).any(axis=1)
        if outside.any():
            row, column = named[int(np.flatnonzero(outside)[0])].tolist()
            raise InvalidInputError(
                f"cell ({row}, {column}) is not in the window of {self.cells.shape[0]} rows from "
                f"{self.row} and {self.cells.shape[1]} columns from {self.column}"
            )
        return index[:, 0], index[:, 1]

    def window_of(self, corners: Corners) -> Corners:
        """Give where a window of the lattice is in the arrays at present."""
        r0, r1, c0, c1 = corners
        return r0 - self.row, r1 - self.row, c0 - self.column, c1 - self.column

    def passable_near(self, x: float, y: float, within_cells: int) -> tuple[int, int] | None:
        """Give the passable cell, in the lattice, whose centre is nearest to a place.

        Parameters
        ----------
        x, y : float
            The place.
        within_cells : int
            How many rows and columns away to look at most.

        Returns
        -------
        (row, column) or None
            Of equally near cells the first one row by row; None: there is none.
        """
        found = _passable_near(
            x, y, within_cells, self.cell_m, self.row, self.column, self.passable
        )
        if found < 0:
            return None
        row, column = divmod(int(found), self.passable.shape[1])
        return row + self.row, column + self.column

    def passable_centres(self, x: float, y: float, half_width_m: float) -> FloatArray:
        """Give the centres of the passable cells in a square around a place, ``(k, 2)``."""
        reach = math.ceil(half_width_m / self.cell_m)
        row, column = self.cell_of(x, y)
        r0, c0 = max(0, row - self.row - reach), max(0, column - self.column - reach)
        r1, c1 = row - self.row + reach + 1, column - self.column + reach + 1
        cells = np.argwhere(self.passable[r0 : max(r0, r1), c0 : max(c0, c1)])
        return self.centres_of(cells + np.array([r0 + self.row, c0 + self.column]))

    def has_frontier_near(self, x: float, y: float, radius_m: float) -> bool:
        """Whether the centre of a frontier cell lies within a radius of a place."""
        return bool(
            _has_frontier_near(x, y, radius_m, self.cell_m, self.row, self.column, self._marks)
        )

    def is_known(self, x: float, y: float) -> bool:
        """Whether the cell that holds a place is free or occupied."""
        row, column = self.cell_of(x, y)
        row, column = row - self.row, column - self.column
        rows, columns = self.cells.shape
        inside = 0 <= row < rows and 0 <= column < columns
        return inside and bool(self.cells[row, column] != UNKNOWN)

    @property
    def diagonal_m(self) -> float:
        """Diagonal of the window."""
        return math.hypot(*self.cells.shape) * self.cell_m

    def frontier_groups(self, least_m: float | None = None) -> list[FrontierGroup]:
        """Give the groups of frontier cells, in the order of their first cells row by row.

        Frontier cells are free cells with an unknown one among their four neighbours, also those
        that the body cannot stand on: an opening is as wide as it is.

        Parameters
        ----------
        least_m : float, optional
            Groups of a smaller size are left out; by default those smaller than the body.

        Notes
        -----
        Groups are labelled again only where cells have changed since the last call; all others
        are the same objects as before. Targets do not depend on discs that are `blocked`.
        """
        if self._unlabelled:
            self._label_again()
        least = 2.0 * self.radius_m if least_m is None else least_m
        least -= ROUNDING_CELLS * self.cell_m
        groups = [self._groups[label] for _, _, label in self._first_cells]
        return [group for group in groups if group.size_m >= least]

    @contextmanager
    def blocked(self, discs: ArrayLike) -> Iterator[None]:
        """Make cells with their centres within some discs not passable for a while.

        Blocks can be nested. `revision` does not change, and no region can be added meanwhile.

        Parameters
        ----------
        discs : (k, 3) array
            Centres x, y and radii in metres.
        """
        circles = np.ascontiguousarray(discs, dtype=np.float64).reshape(-1, 3)
        if not np.isfinite(circles).all():
            raise InvalidInputError("blocked discs are finite x, y and radii in metres")
        passable, taken = self.passable, None
        if len(circles):
            taken = _block(circles, self.cell_m, self.row, self.column, passable)
        self._blocked += 1
        try:
            yield
        finally:
            self._blocked -= 1
            if taken is not None:
                passable.reshape(-1)[taken] = True

    def _cover(self, bounds: tuple[float, float, float, float]) -> None:
        held = Window(self.row, self.column, *self.cells.shape)
        window = window_over(bounds, self.cell_m, held, CELL_BYTES)
        if window != held:
            self.cells = moved(self.cells, held, window)
            self.passable = moved(self.passable, held, window)
            self._marks = moved(self._marks, held, window)
            self._labels = moved(self._labels, held, window)
            self.row, self.column = window.row, window.column

    def _note_change(self, window: Corners) -> None:
        self.revision += 1
        self._changes.append((self.revision, window))
        if len(self._changes) > CHANGES_KEPT:
            revision, oldest = self._changes.popleft()
            older = None if self._older is None else self._older[1]
            self._older = revision, _around(older, oldest)
        self._unlabelled.append(window)
        if len(self._unlabelled) >= CHANGES_KEPT:
            self._label_again()

    def _label_again(self) -> None:
        # As knowledge only grows, new frontier cells lie where cells have changed, and what has
        # ceased to be frontier is at most one further. So are the groups that this joins or parts.
        windows = np.array(self._unlabelled, np.int64)
        windows += np.array([-1, 1, -1, 1])
        windows -= np.array([self.row, self.row, self.column, self.column])
        windows = np.maximum(windows, 0)
        windows[:, :2] = np.minimum(windows[:, :2], self.cells.shape[0])
        windows[:, 2:] = np.minimum(windows[:, 2:], self.cells.shape[1])
        self._unlabelled.clear()

        old = dict.fromkeys(_labels_in(windows, self._marks, self._labels).tolist())
        gone = [self._groups.pop(label).cells for label in old]
        released = np.concatenate(gone) if gone else np.empty((0, 2), np.int64)
        members, ends, targets, lengths = _flood(
            windows,
            released,
            self.row,
            self.column,
            self.cells,
            self._marks,
            self._labels,
            self._next_label,
        )
        members.setflags(write=False)
        first_cells = [first for first in self._first_cells if first[2] not in old]
        begin = 0
        for label, (end, target, length) in enumerate(
            zip(ends.tolist(), targets.tolist(), lengths.tolist(), strict=True), self._next_label
        ):
            row, column = members[begin].tolist()
            first_cells.append((row, column, label))
            goal = None
            if target >= 0:
                goal_row, goal_column = members[target].tolist()
                goal = goal_row, goal_column
            self._groups[label] = FrontierGroup(
                cells=members[begin:end], target=goal, size_m=length * self.cell_m
            )
            begin = end
        self._next_label += len(ends)
        first_cells.sort()
        self._first_cells = first_cells


def _around(union: Corners | None, window: Corners) -> Corners:
    if union is None:
        return window
    return (
        min(union[0], window[0]),
        max(union[1], window[1]),
        min(union[2], window[2]),
        max(union[3], window[3]),
    )


@kernel
def _fits(
    boundary: FloatArray,
    margin: float,
    cell: float,
    row: int,
    column: int,
    rows: int,
    columns: int,
) -> bool:
    # Whether a window holds a region with a margin, as `window_over` asks it. Corners in no cell
    # that has a number fit nowhere.
    farthest = FARTHEST_CELL * cell
    for i in range(boundary.shape[0]):
        if not (abs(boundary[i, 0]) < farthest and abs(boundary[i, 1]) < farthest):
            return False
    x0, y0, x1, y1 = bounds_of(boundary)
    return (
        int(np.floor((x0 - margin) / cell + OFFSET)) >= column
        and int(np.floor((y0 - margin) / cell + OFFSET)) >= row
        and int(np.floor((x1 + margin) / cell + OFFSET)) < column + columns
        and int(np.floor((y1 + margin) / cell + OFFSET)) < row + rows
    )


@kernel
def _learn(
    boundary: FloatArray,
    tags: TagArray,
    cell: float,
    radius: float,
    row: int,
    column: int,
    cells: NDArray[np.uint8],
    passable: BoolArray,
    marks: NDArray[np.uint8],
) -> tuple[int, int, int, int, int]:
    # How many cells are newly known, and the first and last row and column of the changes.
    changed = np.array([cells.shape[0], -1, cells.shape[1], -1])
    new = 0
    n = boundary.shape[0]
    holds = np.empty((n, 2), np.int64)
    for i in range(n):
        # The cell that holds a corner, as `_occupy` finds it.
        holds[i, 0] = int(np.floor(boundary[i, 1] / cell + OFFSET)) - row
        holds[i, 1] = int(np.floor(boundary[i, 0] / cell + OFFSET)) - column
    for first in range(0, n, TOGETHER):
        end = min(first + TOGETHER, n)
        all_near = _surfaces_are_near(boundary, tags, first, end, cell, radius, row, column, marks)
        for i in range(first, end):
            if tags[i] != OBSTACLE:
                continue
            j = i + 1 if i + 1 < n else 0
            r, c = holds[i, 0], holds[i, 1]
            in_one = r == holds[j, 0] and c == holds[j, 1]
            is_known = in_one and cells[unsigned(r), unsigned(c)] == OCCUPIED
            is_near = all_near or _surfaces_are_near(
                boundary, tags, i, i + 1, cell, radius, row, column, marks
            )
            # From below to above, so that a surface is the same from either side.
            if (boundary[i, 1], boundary[i, 0]) > (boundary[j, 1], boundary[j, 0]):
                i, j = j, i
            ax, ay, bx, by = boundary[i, 0], boundary[i, 1], boundary[j, 0], boundary[j, 1]
            if not is_known:
                new += _occupy(ax, ay, bx, by, cell, row, column, cells, passable, changed)
            if not is_near:
                _keep_away(ax, ay, bx, by, cell, radius, row, column, passable, marks, changed)
    new += _set_free(boundary, cell, row, column, cells, passable, marks, changed)
    _mark_frontier(changed, cells, marks)
    return new, row + changed[0], row + changed[1], column + changed[2], column + changed[3]


@inlined_kernel
def _touch(changed: IntArray, r: int, c: int) -> None:
    changed[0], changed[1] = min(changed[0], r), max(changed[1], r)
    changed[2], changed[3] = min(changed[2], c), max(changed[3], c)


@kernel
def _occupy(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    cell: float,
    row: int,
    column: int,
    cells: NDArray[np.uint8],
    passable: BoolArray,
    changed: IntArray,
) -> int:
    # All cells that a segment passes through, row by row. Two rows share the cell where it passes
    # from one into the other, so that its cells hang together over their four neighbours.
    ax, ay, bx, by = ax / cell + OFFSET, ay / cell + OFFSET, bx / cell + OFFSET, by / cell + OFFSET
    least, most = min(ax, bx), max(ax, bx)
    first, last = int(np.floor(ay)), int(np.floor(by))
    new = 0
    begin = ax
    for r in range(first, last + 1):
        end = bx
        if r < last:
            end = min(most, max(least, ax + (r + 1 - ay) / (by - ay) * (bx - ax)))
        low, high = int(np.floor(min(begin, end))), int(np.floor(max(begin, end)))
        k = unsigned(r - row)
        for c in range(unsigned(low - column), unsigned(high - column + 1)):
            if cells[k, c] != OCCUPIED:
                new += cells[k, c] == UNKNOWN
                cells[k, c] = OCCUPIED
                passable[k, c] = False
                _touch(changed, r - row, int(c))
        begin = end
    return new


@kernel
def _surfaces_are_near(
    boundary: FloatArray,
    tags: TagArray,
    first: int,
    end: int,
    cell: float,
    radius: float,
    row: int,
    column: int,
    marks: NDArray[np.uint8],
) -> bool:
    # Whether all cells around some pieces of a boundary are known to be near to a surface: to
    # those pieces that are surfaces there is nothing to be kept away from then.
    left, right, low, high = np.inf, -np.inf, np.inf, -np.inf
    n = boundary.shape[0]
    for i in range(first, end):
        if tags[i] == OBSTACLE:
            j = i + 1 if i + 1 < n else 0
            left = min(left, boundary[i, 0], boundary[j, 0])
            right = max(right, boundary[i, 0], boundary[j, 0])
            low = min(low, boundary[i, 1], boundary[j, 1])
            high = max(high, boundary[i, 1], boundary[j, 1])
    if left > right:
        return True
    c0 = int(np.ceil((left - radius) / cell + OFFSET - 0.5)) - column
    c1 = int(np.floor((right + radius) / cell + OFFSET - 0.5)) - column
    r0 = int(np.ceil((low - radius) / cell + OFFSET - 0.5)) - row
    r1 = int(np.floor((high + radius) / cell + OFFSET - 0.5)) - row
    near = np.uint8(NEAR)
    for r in range(unsigned(r0), unsigned(r1 + 1)):
        # Without a branch for each cell.
        for c in range(unsigned(c0), unsigned(c1 + 1)):
            near &= marks[r, c]
        if not near:
            return False
    return True


@kernel
def _keep_away(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    cell: float,
    radius: float,
    row: int,
    column: int,
    passable: BoolArray,
    marks: NDArray[np.uint8],
    changed: IntArray,
) -> None:
    # Cells with a segment nearer to their centres than the radius. One that is near to some
    # surface already is passed over: of what is seen again next to nothing is computed again.
    shift = OFFSET * cell
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    first = int(np.ceil((ay - radius) / cell + OFFSET - 0.5))
    last = int(np.floor((by + radius) / cell + OFFSET - 0.5))
    for r in range(first, last + 1):
        # Only the part of the segment counts that is near enough to the row.
        y = (r + 0.5) * cell - shift
        begin, end = ax, bx
        if dy > 0.0:
            begin = ax + min(1.0, max(0.0, (y - radius - ay) / dy)) * dx
            end = ax + min(1.0, max(0.0, (y + radius - ay) / dy)) * dx
        left = int(np.ceil((min(begin, end) - radius) / cell + OFFSET - 0.5)) - column
        right = int(np.floor((max(begin, end) + radius) / cell + OFFSET - 0.5)) - column
        held, free = marks[r - row, left : right + 1], passable[r - row, left : right + 1]
        for i in range(held.shape[0]):
            if held[i] & NEAR:
                continue
            px, py = (column + left + i + 0.5) * cell - shift - ax, y - ay
            t = min(1.0, max(0.0, (px * dx + py * dy) / length2)) if length2 > 0.0 else 0.0
            ex, ey = px - t * dx, py - t * dy
            if ex * ex + ey * ey < radius * radius:
                held[i] |= NEAR
                if free[i]:
                    free[i] = False
                    _touch(changed, r - row, left + i)


@kernel
def _set_free(
    boundary: FloatArray,
    cell: float,
    row: int,
    column: int,
    cells: NDArray[np.uint8],
    passable: BoolArray,
    marks: NDArray[np.uint8],
    changed: IntArray,
) -> int:
    rows, columns = cells.shape
    first_row, starts, crossings = row_crossings(
        boundary, -OFFSET * cell, cell, row, row + rows - 1
    )
    new = 0
    for k in range(starts.shape[0] - 1):
        r = first_row + k - row
        for i in range(starts[k], starts[k + 1] - 1, 2):
            begin = int(np.ceil(crossings[i] / cell + OFFSET - 0.5)) - column
            end = int(np.ceil(crossings[i + 1] / cell + OFFSET - 0.5)) - column
            begin, end = max(0, begin), min(columns, end)
            if _all_are_known(cells[r, begin:end]):
                continue
            first, last = columns, -1
            for c in range(begin, end):
                if cells[r, c] == UNKNOWN:
                    cells[r, c] = FREE
                    passable[r, c] = not marks[r, c] & NEAR
                    new += 1
                    first, last = min(first, c), c
            if first <= last:
                _touch(changed, r, first)
                _touch(changed, r, last)
    return new


@inlined_kernel
def _all_are_known(cells: NDArray[np.uint8]) -> bool:
    # Without a branch for each cell.
    unknown = False
    for cell in cells:
        unknown |= cell == UNKNOWN
    return not unknown


@kernel
def _mark_frontier(changed: IntArray, cells: NDArray[np.uint8], marks: NDArray[np.uint8]) -> None:
    # In the window of the changes and one cell around it. Outside the array nothing is known.
    rows, columns = cells.shape
    first, end = max(0, changed[2] - 1), min(columns, changed[3] + 2)
    c0 = max(first, 1)
    c1 = max(c0, min(end, columns - 1))
    nothing = np.zeros(c1 - c0, np.uint8)
    for r in range(max(0, changed[0] - 1), min(rows, changed[1] + 2)):
        for c in (0, columns - 1):
            if first <= c < end:
                marks[r, c] = _with_frontier(marks[r, c], cells[r, c], UNKNOWN)
        # Slices: so there is no branch for each cell.
        here, held = cells[r, c0:c1], marks[r, c0:c1]
        left, right = cells[r, c0 - 1 : c1 - 1], cells[r, c0 + 1 : c1 + 1]
        below = cells[r - 1, c0:c1] if r > 0 else nothing
        above = cells[r + 1, c0:c1] if r + 1 < rows else nothing
        for i in range(held.shape[0]):
            least = min(min(left[i], right[i]), min(below[i], above[i]))
            held[i] = _with_frontier(held[i], here[i], least)


@inlined_kernel
def _with_frontier(marks: int, cell: int, least_around: int) -> int:
    is_frontier = (cell == FREE) & (least_around == UNKNOWN)
    return (marks & ~FRONTIER) | (FRONTIER if is_frontier else 0)


@kernel
def _block(discs: FloatArray, cell: float, row: int, column: int, passable: BoolArray) -> IntArray:
    # Clears the passable cells within some discs and gives them as flat indices.
    rows, columns = passable.shape
    shift = OFFSET * cell
    spans = np.empty((discs.shape[0], 4), np.int64)
    most = 0
    for k in range(discs.shape[0]):
        x, y, radius = discs[k, 0], discs[k, 1], discs[k, 2]
        spans[k, 0] = max(0, int(np.floor((y - radius) / cell + OFFSET - 0.5)) - row)
        spans[k, 1] = min(rows, int(np.ceil((y + radius) / cell + OFFSET - 0.5)) + 1 - row)
        spans[k, 2] = max(0, int(np.floor((x - radius) / cell + OFFSET - 0.5)) - column)
        spans[k, 3] = min(columns, int(np.ceil((x + radius) / cell + OFFSET - 0.5)) + 1 - column)
        most += max(0, spans[k, 1] - spans[k, 0]) * max(0, spans[k, 3] - spans[k, 2])
    taken = np.empty(most, np.int64)
    count = 0
    for k in range(discs.shape[0]):
        x, y, radius = discs[k, 0], discs[k, 1], discs[k, 2]
        for r in range(spans[k, 0], spans[k, 1]):
            dy = (r + row + 0.5) * cell - shift - y
            for c in range(spans[k, 2], spans[k, 3]):
                dx = (c + column + 0.5) * cell - shift - x
                if passable[r, c] and radius >= 0.0 and dx * dx + dy * dy <= radius * radius:
                    passable[r, c] = False
                    taken[count] = r * columns + c
                    count += 1
    return taken[:count].copy()


@kernel
def _labels_in(windows: IntArray, marks: NDArray[np.uint8], labels: NDArray[np.int32]) -> IntArray:
    # The labels in some windows, most of them once only. Few cells have one: whether a row has
    # any is told without a branch for each of its cells.
    found = np.empty(64, np.int64)
    count = 0
    for w in range(windows.shape[0]):
        first = windows[w, 2]
        for r in range(windows[w, 0], windows[w, 1]):
            row = marks[r, first : windows[w, 3]]
            any_mark = np.uint8(0)
            for mark in row:
                any_mark |= mark
            if not any_mark & LABELLED:
                continue
            for c in range(row.shape[0]):
                if not row[c] & LABELLED:
                    continue
                label = labels[r, first + c]
                if count == 0 or found[count - 1] != label:
                    if count == found.shape[0]:
                        longer = np.empty(2 * count, np.int64)
                        longer[:count] = found
                        found = longer
                    found[count] = label
                    count += 1
    return np.unique(found[:count])


@kernel
def _flood(
    windows: IntArray,
    released: IntArray,
    row: int,
    column: int,
    cells: NDArray[np.uint8],
    marks: NDArray[np.uint8],
    labels: NDArray[np.int32],
    next_label: int,
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    # Labels the frontier cells of the windows and of the groups released, from `next_label` on.
    # Gives the cells of all groups one after another, each group's row by row, and per group
    # where it ends, which cell is its target or -1, and its length in cells.
    columns = cells.shape[1]
    most = released.shape[0]
    for i in range(released.shape[0]):
        marks[released[i, 0] - row, released[i, 1] - column] &= ~LABELLED
    for w in range(windows.shape[0]):
        for r in range(windows[w, 0], windows[w, 1]):
            # Slices: so there is no branch for each cell.
            for mark in marks[r, windows[w, 2] : windows[w, 3]]:
                most += (mark & FRONTIER) != 0

    members = np.empty(most, np.int64)
    ends = np.empty(most, np.int64)
    count = groups = 0
    for i in range(released.shape[0]):
        r, c = released[i, 0] - row, released[i, 1] - column
        if marks[r, c] & (FRONTIER | LABELLED) == FRONTIER:
            count = _fill(r, c, next_label + groups, marks, labels, members, count)
            ends[groups] = count
            groups += 1
    for w in range(windows.shape[0]):
        for r in range(windows[w, 0], windows[w, 1]):
            any_left = False
            for mark in marks[r, windows[w, 2] : windows[w, 3]]:
                any_left |= mark & (FRONTIER | LABELLED) == FRONTIER
            if not any_left:
                continue
            for c in range(windows[w, 2], windows[w, 3]):
                if marks[r, c] & (FRONTIER | LABELLED) == FRONTIER:
                    count = _fill(r, c, next_label + groups, marks, labels, members, count)
                    ends[groups] = count
                    groups += 1

    named = np.empty((count, 2), np.int64)
    targets = np.empty(groups, np.int64)
    lengths = np.empty(groups)
    begin = 0
    for g in range(groups):
        end = ends[g]
        members[begin:end].sort()
        size = end - begin
        top, bottom = members[begin] // columns, members[end - 1] // columns
        left, right = columns, 0
        row_sum = column_sum = 0
        for i in range(begin, end):
            r, c = members[i] // columns, members[i] % columns
            named[i, 0], named[i, 1] = r + row, c + column
            left, right = min(left, c), max(right, c)
            row_sum += r - top
            column_sum += c
        column_sum -= size * left
        # Distances to the centroid times the size are whole numbers: ties are ties.
        targets[g], least = -1, np.inf
        for i in range(begin, end):
            r, c = members[i] // columns, members[i] % columns
            if not marks[r, c] & NEAR:
                across = float(size * (c - left) - column_sum)
                along = float(size * (r - top) - row_sum)
                distance2 = across * across + along * along
                if distance2 < least:
                    targets[g], least = i, distance2
        lengths[g] = max(float(size), 1.0 + np.hypot(float(bottom - top), float(right - left)))
        begin = end
    return named, ends[:groups].copy(), targets, lengths


@kernel
def _fill(
    r: int,
    c: int,
    label: int,
    marks: NDArray[np.uint8],
    labels: NDArray[np.int32],
    members: IntArray,
    count: int,
) -> int:
    # Labels all frontier cells that hang together with one, and appends them to the members.
    rows, columns = marks.shape
    labels[r, c] = label
    marks[r, c] |= LABELLED
    members[count] = r * columns + c
    reached = count + 1
    while count < reached:
        r, c = members[count] // columns, members[count] % columns
        count += 1
        for s in range(max(0, r - 1), min(rows, r + 2)):
            for d in range(max(0, c - 1), min(columns, c + 2)):
                if marks[s, d] & (FRONTIER | LABELLED) == FRONTIER:
                    labels[s, d] = label
                    marks[s, d] |= LABELLED
                    members[reached] = s * columns + d
                    reached += 1
    return count


@kernel
def _passable_near(
    x: float, y: float, within: int, cell: float, row: int, column: int, passable: BoolArray
) -> int:
    rows, columns = passable.shape
    r0, c0 = int(np.floor(y / cell + OFFSET)) - row, int(np.floor(x / cell + OFFSET)) - column
    shift = OFFSET * cell
    found, nearest = -1, np.inf
    for r in range(max(0, r0 - within), min(rows, r0 + within + 1)):
        dy = (r + row + 0.5) * cell - shift - y
        for c in range(max(0, c0 - within), min(columns, c0 + within + 1)):
            dx = (c + column + 0.5) * cell - shift - x
            if passable[r, c] and dx * dx + dy * dy < nearest:
                found, nearest = r * columns + c, dx * dx + dy * dy
    return found


@kernel
def _has_frontier_near(
    x: float,
    y: float,
    radius: float,
    cell: float,
    row: int,
    column: int,
    marks: NDArray[np.uint8],
) -> bool:
    rows, columns = marks.shape
    shift = OFFSET * cell
    reach = int(np.ceil(radius / cell)) + 1
    r0, c0 = int(np.floor(y / cell + OFFSET)) - row, int(np.floor(x / cell + OFFSET)) - column
    for r in range(max(0, r0 - reach), min(rows, r0 + reach + 1)):
        dy = (r + row + 0.5) * cell - shift - y
        for c in range(max(0, c0 - reach), min(columns, c0 + reach + 1)):
            dx = (c + column + 0.5) * cell - shift - x
            if marks[r, c] & FRONTIER and dx * dx + dy * dy <= radius * radius:
                return True
    return False
