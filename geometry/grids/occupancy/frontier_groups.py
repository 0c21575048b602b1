"""Groups of connected frontier cells, put together again only where cells have changed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from multisrt.geometry.grids.occupancy.layers import FRONTIER, GROUPED, NEAR, Layers
from multisrt.geometry.grids.raster import Corners
from multisrt.geometry.numerics.arrays import ByteArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel

MAX_OUTDATED: Final = 64
"""Number of changed windows that are collected before groups are put together again."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrontierGroup:
    """Frontier cells that are connected over their eight neighbours.

    Attributes
    ----------
    cells : (k, 2) array of int
        Rows and columns in the lattice, in row-major order; read-only.
    target : (row, column) or None
        The passable cell of the group that is nearest to its centroid, of equally near ones the
        first in row-major order; None if no cell of the group is passable.
    size_m : float
        Length of the group in metres: of a straight one from end to end in any direction, of a
        crooked one the number of its cells times their width.
    """

    cells: IntArray
    target: tuple[int, int] | None
    size_m: float


class FrontierGroups:
    """The frontier groups of an occupancy, kept from one change to the next.

    Knowledge only grows, so new frontier cells lie where cells have changed, and cells that have
    ceased to be frontier lie at most one cell beside. Only groups with a cell there are put
    together again; all others remain the same objects.
    """

    __slots__ = ("_by_first_cell", "_in_order", "_outdated")

    def __init__(self) -> None:
        self._by_first_cell: dict[tuple[int, int], FrontierGroup] = {}
        self._in_order: list[FrontierGroup] = []
        self._outdated: list[Corners] = []

    def note_change(self, window: Corners, layers: Layers) -> None:
        """Record that cells have changed in a window of the lattice."""
        self._outdated.append(window)
        if len(self._outdated) >= MAX_OUTDATED:
            self._group_again(layers)

    def all(self, layers: Layers) -> list[FrontierGroup]:
        """Return all groups in row-major order of their first cells.

        Parameters
        ----------
        layers : Layers
            The present window; which cells are `GROUPED` is written into it.
        """
        if self._outdated:
            self._group_again(layers)
        return list(self._in_order)

    def _group_again(self, layers: Layers) -> None:
        windows = _with_rims(np.array(self._outdated, np.int64), layers)
        self._outdated.clear()

        released, firsts = _release(windows, layers)
        for row, column in firsts.tolist():
            del self._by_first_cell[row, column]
        members, ends = _group(windows, released, layers)
        cells, targets, sizes = _described(members, ends, layers)

        begin = 0
        for end, target, size in zip(ends.tolist(), targets.tolist(), sizes.tolist(), strict=True):
            nearest: tuple[int, int] | None = None
            if target >= 0:
                row, column = cells[target].tolist()
                nearest = row, column
            own = cells[begin:end].copy()  # a view would keep the cells of all groups in memory
            own.setflags(write=False)
            row, column = own[0].tolist()
            self._by_first_cell[row, column] = FrontierGroup(
                cells=own,
                target=nearest,
                size_m=size * layers.cell_m,
            )
            begin = end
        self._in_order = [self._by_first_cell[first] for first in sorted(self._by_first_cell)]


@kernel
def _with_rims(windows: IntArray, layers: Layers) -> IntArray:
    # Windows of the lattice, one cell larger on all sides, as windows of the arrays.
    rows, columns = layers.states.shape
    larger = np.empty_like(windows)
    for w in range(windows.shape[0]):
        larger[w, 0] = min(rows, max(0, windows[w, 0] - 1 - layers.row))
        larger[w, 1] = min(rows, max(0, windows[w, 1] + 1 - layers.row))
        larger[w, 2] = min(columns, max(0, windows[w, 2] - 1 - layers.column))
        larger[w, 3] = min(columns, max(0, windows[w, 3] + 1 - layers.column))
    return larger


@kernel
def _release(windows: IntArray, layers: Layers) -> tuple[IntArray, IntArray]:
    # Take apart the groups with a cell in some windows of the arrays. Return the flat indices of
    # their cells, and the first cell of each group in the lattice. Few cells are in a group: a row
    # without any is recognized without a branch per cell.
    marks = layers.marks
    columns = marks.shape[1]
    members = np.empty(1024, np.int64)
    firsts = np.empty((64, 2), np.int64)
    count = groups = 0
    for w in range(windows.shape[0]):
        for r in range(windows[w, 0], windows[w, 1]):
            any_mark = np.uint8(0)
            for mark in marks[r, windows[w, 2] : windows[w, 3]]:
                any_mark |= mark
            if not any_mark & GROUPED:
                continue
            for c in range(windows[w, 2], windows[w, 3]):
                if not marks[r, c] & GROUPED:
                    continue
                begin = count
                members, count = _fill(r * columns + c, GROUPED, GROUPED, marks, members, count)
                if groups == firsts.shape[0]:
                    firsts = np.concatenate((firsts, np.empty_like(firsts)))
                first = members[begin:count].min()
                firsts[groups, 0] = first // columns + layers.row
                firsts[groups, 1] = first % columns + layers.column
                groups += 1
    return members[:count], firsts[:groups]


@kernel
def _group(windows: IntArray, released: IntArray, layers: Layers) -> tuple[IntArray, IntArray]:
    # Put together the frontier cells of some windows of the arrays, and those released. Return
    # the cells of all new groups one group after the other, as flat indices, sorted within each,
    # and where each ends.
    marks = layers.marks
    columns = marks.shape[1]
    either = FRONTIER | GROUPED
    members = np.empty(1024, np.int64)
    ends = np.empty(64, np.int64)
    count = groups = 0
    for k in range(released.shape[0] + windows.shape[0]):
        if k < released.shape[0]:
            top, left = divmod(released[k], columns)
            bottom, right = top + 1, left + 1
        else:
            top, bottom, left, right = windows[k - released.shape[0]]
        for r in range(top, bottom):
            # A slice instead of indices, so that the loop is vectorized.
            any_left = False
            for mark in marks[r, left:right]:
                any_left |= mark & either == FRONTIER
            if not any_left:
                continue
            for c in range(left, right):
                if marks[r, c] & either == FRONTIER:
                    begin = count
                    members, count = _fill(r * columns + c, either, FRONTIER, marks, members, count)
                    members[begin:count].sort()
                    if groups == ends.shape[0]:
                        ends = np.concatenate((ends, np.empty_like(ends)))
                    ends[groups] = count
                    groups += 1
    return members[:count], ends[:groups]


@kernel
def _fill(
    start: int, bits: int, wanted: int, marks: ByteArray, members: IntArray, count: int
) -> tuple[IntArray, int]:
    # Append to the members a cell and all that are connected with it by cells whose bits are the
    # wanted ones, and invert `GROUPED` in each. Return the members, in a longer array if they need
    # one, and their number.
    rows, columns = marks.shape
    marks[start // columns, start % columns] ^= GROUPED
    if count == members.shape[0]:
        members = np.concatenate((members, np.empty_like(members)))
    members[count] = start
    reached = count + 1
    while count < reached:
        r, c = members[count] // columns, members[count] % columns
        count += 1
        for s in range(max(0, r - 1), min(rows, r + 2)):
            for d in range(max(0, c - 1), min(columns, c + 2)):
                if marks[s, d] & bits == wanted:
                    marks[s, d] ^= GROUPED
                    if reached == members.shape[0]:
                        members = np.concatenate((members, np.empty_like(members)))
                    members[reached] = s * columns + d
                    reached += 1
    return members, count


@kernel
def _described(
    members: IntArray, ends: IntArray, layers: Layers
) -> tuple[IntArray, IntArray, FloatArray]:
    # The members' cells in the lattice, and for each group the index of its target among them,
    # or -1, and its size in cells.
    columns = layers.marks.shape[1]
    cells = np.empty((members.shape[0], 2), np.int64)
    targets = np.empty(ends.shape[0], np.int64)
    sizes = np.empty(ends.shape[0])
    begin = 0
    for g in range(ends.shape[0]):
        end = ends[g]
        count = end - begin
        top, bottom = members[begin] // columns, members[end - 1] // columns
        left, right = columns, 0
        row_sum = column_sum = 0
        for i in range(begin, end):
            r, c = members[i] // columns, members[i] % columns
            cells[i, 0], cells[i, 1] = r + layers.row, c + layers.column
            left, right = min(left, c), max(right, c)
            row_sum += r - top
            column_sum += c
        column_sum -= count * left
        # Distances to the centroid times the count are whole numbers, so that ties are exact.
        targets[g], nearest2 = -1, np.inf
        for i in range(begin, end):
            r, c = members[i] // columns, members[i] % columns
            if not layers.marks[r, c] & NEAR:
                across = float(count * (c - left) - column_sum)
                along = float(count * (r - top) - row_sum)
                distance2 = across * across + along * along
                if distance2 < nearest2:
                    targets[g], nearest2 = i, distance2
        sizes[g] = max(float(count), 1.0 + np.hypot(float(bottom - top), float(right - left)))
        begin = end
    return cells, targets, sizes
