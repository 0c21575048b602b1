"""Groups of connected frontier cells, labelled again only where cells have changed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from multisrt.geometry.grids.occupancy.layers import FRONTIER, LABELLED, NEAR, Layers
from multisrt.geometry.grids.raster import Corners
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel

MAX_OUTDATED: Final = 64
"""Number of windows with outdated labels that are collected before labels are assigned again."""


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
    ceased to be frontier lie at most one cell beside. Only groups with a cell there are labelled
    again; all others remain the same objects.
    """

    __slots__ = ("_by_label", "_first_cells", "_next_label", "_outdated")

    def __init__(self) -> None:
        self._by_label: dict[int, FrontierGroup] = {}
        # The first cell of each group, and its label, sorted.
        self._first_cells: list[tuple[int, int, int]] = []
        self._next_label = 1
        self._outdated: list[Corners] = []

    def note_change(self, window: Corners, layers: Layers) -> None:
        """Record that cells have changed in a window of the lattice."""
        self._outdated.append(window)
        if len(self._outdated) >= MAX_OUTDATED:
            self._label_again(layers)

    def all(self, layers: Layers) -> list[FrontierGroup]:
        """Return all groups in row-major order of their first cells.

        Parameters
        ----------
        layers : Layers
            The present window; labels are written into it.
        """
        if self._outdated:
            self._label_again(layers)
        return [self._by_label[label] for _, _, label in self._first_cells]

    def _label_again(self, layers: Layers) -> None:
        windows = np.array(self._outdated, np.int64) + np.array([-1, 1, -1, 1])
        windows -= np.array([layers.row, layers.row, layers.column, layers.column])
        windows = np.maximum(windows, 0)
        windows[:, :2] = np.minimum(windows[:, :2], layers.states.shape[0])
        windows[:, 2:] = np.minimum(windows[:, 2:], layers.states.shape[1])
        self._outdated.clear()

        old = dict.fromkeys(_labels_in(windows, layers).tolist())
        removed = [self._by_label.pop(label).cells for label in old]
        released = np.concatenate(removed) if removed else np.empty((0, 2), np.int64)
        members, ends = _label(windows, released, layers, self._next_label)
        cells, targets, sizes = _described(members, ends, layers)

        first_cells = [first for first in self._first_cells if first[2] not in old]
        begin = 0
        for label, (end, target, size) in enumerate(
            zip(ends.tolist(), targets.tolist(), sizes.tolist(), strict=True), self._next_label
        ):
            row, column = cells[begin].tolist()
            first_cells.append((row, column, label))
            nearest: tuple[int, int] | None = None
            if target >= 0:
                row, column = cells[target].tolist()
                nearest = row, column
            own = cells[begin:end].copy()  # a view would keep the cells of all groups in memory
            own.setflags(write=False)
            self._by_label[label] = FrontierGroup(
                cells=own,
                target=nearest,
                size_m=size * layers.cell_m,
            )
            begin = end
        self._next_label += len(ends)
        first_cells.sort()
        self._first_cells = first_cells


@kernel
def _labels_in(windows: IntArray, layers: Layers) -> IntArray:
    # The labels in some windows of the arrays, each once. Few cells have one: a row without any
    # is recognized without a branch per cell.
    found = np.empty(64, np.int64)
    count = 0
    for w in range(windows.shape[0]):
        first = windows[w, 2]
        for r in range(windows[w, 0], windows[w, 1]):
            row = layers.marks[r, first : windows[w, 3]]
            any_mark = np.uint8(0)
            for mark in row:
                any_mark |= mark
            if not any_mark & LABELLED:
                continue
            for c in range(row.shape[0]):
                if not row[c] & LABELLED:
                    continue
                label = layers.labels[r, first + c]
                if count == 0 or found[count - 1] != label:
                    if count == found.shape[0]:
                        longer = np.empty(2 * count, np.int64)
                        longer[:count] = found
                        found = longer
                    found[count] = label
                    count += 1
    return np.unique(found[:count])


@kernel
def _label(
    windows: IntArray, released: IntArray, layers: Layers, next_label: int
) -> tuple[IntArray, IntArray]:
    # Assign labels, from the next one on, to the frontier cells of some windows of the arrays
    # and of released groups, whose cells are given in the lattice. Return the cells of all new
    # groups one group after the other, as flat indices, sorted within each, and where each ends.
    columns = layers.marks.shape[1]
    marks = layers.marks
    capacity = released.shape[0]
    for i in range(released.shape[0]):
        marks[released[i, 0] - layers.row, released[i, 1] - layers.column] &= ~LABELLED
    for w in range(windows.shape[0]):
        for r in range(windows[w, 0], windows[w, 1]):
            # A slice instead of indices, so that the loop is vectorized.
            for mark in marks[r, windows[w, 2] : windows[w, 3]]:
                capacity += (mark & FRONTIER) != 0

    members = np.empty(capacity, np.int64)
    ends = np.empty(capacity, np.int64)
    count = groups = 0
    for i in range(released.shape[0]):
        r, c = released[i, 0] - layers.row, released[i, 1] - layers.column
        if marks[r, c] & (FRONTIER | LABELLED) == FRONTIER:
            count = _fill(r * columns + c, next_label + groups, layers, members, count)
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
                    count = _fill(r * columns + c, next_label + groups, layers, members, count)
                    ends[groups] = count
                    groups += 1
    begin = 0
    for g in range(groups):
        members[begin : ends[g]].sort()
        begin = ends[g]
    return members[:count].copy(), ends[:groups].copy()


@kernel
def _fill(start: int, label: int, layers: Layers, members: IntArray, count: int) -> int:
    # Label all unlabelled frontier cells connected with one, and append them to the members.
    # Return the new number of members.
    marks, labels = layers.marks, layers.labels
    rows, columns = marks.shape
    labels[start // columns, start % columns] = label
    marks[start // columns, start % columns] |= LABELLED
    members[count] = start
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
