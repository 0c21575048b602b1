"""Kernels that paint a region into an occupancy: free cells, surfaces and the frontier.

A cell is free if its centre lies in a region, and occupied if a surface passes through it. It is
passable if it is free and its centre keeps a radius from every surface. Cells that were painted
before are skipped wherever a comparison of whole rows shows it, so that a region that repeats
known ones costs little.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from multisrt.geometry.grids.occupancy.layers import (
    FREE,
    FRONTIER,
    NEAR,
    OCCUPIED,
    UNKNOWN,
    Layers,
)
from multisrt.geometry.grids.polygon_fill import row_crossings
from multisrt.geometry.grids.raster import OFFSET_X, OFFSET_Y
from multisrt.geometry.numerics.arrays import ByteArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.regions.boundary import OBSTACLE, TagArray

BATCH: Final = 8
"""Number of consecutive pieces of a boundary that are tested together for being near."""


@kernel
def paint_region(
    boundary: FloatArray, tags: TagArray, layers: Layers, radius_m: float
) -> tuple[int, int, int, int, int]:
    """Paint a region into the layers, in place.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the region in metres, counter-clockwise.
    tags : (n,) array
        What each piece of the boundary is: piece i leads from corner i to the next.
    layers : Layers
        A window that holds the region and a margin of the radius and a cell around it.
    radius_m : float
        Distance from a surface below which a cell's centre is not passable, in metres.

    Returns
    -------
    new : int
        Number of cells that were unknown and no longer are.
    first_row, last_row, first_column, last_column : int
        The smallest window of the lattice, ends included, that holds every change of `states`
        and `passable`; ``last_row < first_row`` if there is none.
    """
    states = layers.states
    changed = np.array([states.shape[0], -1, states.shape[1], -1])
    new = 0
    n = boundary.shape[0]
    holds = np.empty((n, 2), np.int64)
    for i in range(n):
        # The cell that holds a corner, by the same arithmetic as in `_occupy`.
        holds[i, 0] = int(np.floor(boundary[i, 1] / layers.cell_m + OFFSET_Y)) - layers.row
        holds[i, 1] = int(np.floor(boundary[i, 0] / layers.cell_m + OFFSET_X)) - layers.column
    for first in range(0, n, BATCH):
        end = min(first + BATCH, n)
        all_near = _surroundings_are_near(boundary, tags, first, end, layers, radius_m)
        for i in range(first, end):
            if tags[i] != OBSTACLE:
                continue
            j = i + 1 if i + 1 < n else 0
            r, c = holds[i, 0], holds[i, 1]
            in_one = r == holds[j, 0] and c == holds[j, 1]
            is_known = in_one and states[r, c] == OCCUPIED
            is_near = all_near or _surroundings_are_near(boundary, tags, i, i + 1, layers, radius_m)
            # Always upwards, so that a surface seen from either side paints the same cells.
            if (boundary[i, 1], boundary[i, 0]) > (boundary[j, 1], boundary[j, 0]):
                i, j = j, i
            ax, ay, bx, by = boundary[i, 0], boundary[i, 1], boundary[j, 0], boundary[j, 1]
            if not is_known:
                new += _occupy(ax, ay, bx, by, layers, changed)
            if not is_near:
                _keep_away(ax, ay, bx, by, layers, radius_m, changed)
    new += _set_free(boundary, layers, changed)
    _mark_frontier(layers, changed)
    row, column = layers.row, layers.column
    return new, row + changed[0], row + changed[1], column + changed[2], column + changed[3]


@kernel
def _touch(changed: IntArray, r: int, c: int) -> None:
    # Extend the window of the changes to a cell.
    changed[0], changed[1] = min(changed[0], r), max(changed[1], r)
    changed[2], changed[3] = min(changed[2], c), max(changed[3], c)


@kernel
def _occupy(ax: float, ay: float, bx: float, by: float, layers: Layers, changed: IntArray) -> int:
    # Occupy all cells that a segment with ay <= by passes through, row by row. Two rows share
    # the cell in which the segment crosses from one to the other, so that its cells are
    # connected over their four neighbours.
    cell, states = layers.cell_m, layers.states
    ax, ay = ax / cell + OFFSET_X, ay / cell + OFFSET_Y
    bx, by = bx / cell + OFFSET_X, by / cell + OFFSET_Y
    left, right = min(ax, bx), max(ax, bx)
    first, last = int(np.floor(ay)), int(np.floor(by))
    new = 0
    begin = ax
    for r in range(first, last + 1):
        end = bx
        if r < last:
            end = min(right, max(left, ax + (r + 1 - ay) / (by - ay) * (bx - ax)))
        low, high = int(np.floor(min(begin, end))), int(np.floor(max(begin, end)))
        k = r - layers.row
        for c in range(low - layers.column, high - layers.column + 1):
            if states[k, c] != OCCUPIED:
                new += states[k, c] == UNKNOWN
                states[k, c] = OCCUPIED
                layers.passable[k, c] = False
                _touch(changed, k, c)
        begin = end
    return new


@kernel
def _surroundings_are_near(
    boundary: FloatArray, tags: TagArray, first: int, end: int, layers: Layers, radius_m: float
) -> bool:
    # Whether all cells around some pieces of a boundary are marked as near a surface: then
    # `_keep_away` would change nothing.
    cell = layers.cell_m
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
    c0 = int(np.ceil((left - radius_m) / cell + OFFSET_X - 0.5)) - layers.column
    c1 = int(np.floor((right + radius_m) / cell + OFFSET_X - 0.5)) - layers.column
    r0 = int(np.ceil((low - radius_m) / cell + OFFSET_Y - 0.5)) - layers.row
    r1 = int(np.floor((high + radius_m) / cell + OFFSET_Y - 0.5)) - layers.row
    near = np.uint8(NEAR)
    for r in range(r0, r1 + 1):
        # Without a branch per cell, so that the loop is vectorized.
        for c in range(c0, c1 + 1):
            near &= layers.marks[r, c]
        if not near:
            return False
    return True


@kernel
def _keep_away(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    layers: Layers,
    radius_m: float,
    changed: IntArray,
) -> None:
    # Mark the cells whose centres are closer to a segment with ay <= by than the radius. Cells
    # that are near a surface already are skipped.
    cell = layers.cell_m
    shift_x, shift_y = OFFSET_X * cell, OFFSET_Y * cell
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    first = int(np.ceil((ay - radius_m) / cell + OFFSET_Y - 0.5))
    last = int(np.floor((by + radius_m) / cell + OFFSET_Y - 0.5))
    for r in range(first, last + 1):
        # Only the part of the segment within the radius of the row's centre line matters.
        y = (r + 0.5) * cell - shift_y
        begin, end = ax, bx
        if dy > 0.0:
            begin = ax + min(1.0, max(0.0, (y - radius_m - ay) / dy)) * dx
            end = ax + min(1.0, max(0.0, (y + radius_m - ay) / dy)) * dx
        left = int(np.ceil((min(begin, end) - radius_m) / cell + OFFSET_X - 0.5)) - layers.column
        right = int(np.floor((max(begin, end) + radius_m) / cell + OFFSET_X - 0.5)) - layers.column
        marks = layers.marks[r - layers.row, left : right + 1]
        passable = layers.passable[r - layers.row, left : right + 1]
        for i in range(marks.shape[0]):
            if marks[i] & NEAR:
                continue
            px, py = (layers.column + left + i + 0.5) * cell - shift_x - ax, y - ay
            t = min(1.0, max(0.0, (px * dx + py * dy) / length2)) if length2 > 0.0 else 0.0
            ex, ey = px - t * dx, py - t * dy
            if ex * ex + ey * ey < radius_m * radius_m:
                marks[i] |= NEAR
                if passable[i]:
                    passable[i] = False
                    _touch(changed, r - layers.row, left + i)


@kernel
def _set_free(boundary: FloatArray, layers: Layers, changed: IntArray) -> int:
    # Set unknown cells free whose centres lie in a polygon; return their number.
    cell, states = layers.cell_m, layers.states
    rows, columns = states.shape
    first_row, starts, crossings = row_crossings(
        boundary, -OFFSET_Y * cell, cell, layers.row, layers.row + rows - 1
    )
    new = 0
    for k in range(starts.shape[0] - 1):
        r = first_row + k - layers.row
        for i in range(starts[k], starts[k + 1] - 1, 2):
            begin = int(np.ceil(crossings[i] / cell + OFFSET_X - 0.5)) - layers.column
            end = int(np.ceil(crossings[i + 1] / cell + OFFSET_X - 0.5)) - layers.column
            begin, end = max(0, begin), min(columns, end)
            if _all_are_known(states[r, begin:end]):
                continue
            first, last = columns, -1
            for c in range(begin, end):
                if states[r, c] == UNKNOWN:
                    states[r, c] = FREE
                    layers.passable[r, c] = not layers.marks[r, c] & NEAR
                    new += 1
                    first, last = min(first, c), c
            if first <= last:
                _touch(changed, r, first)
                _touch(changed, r, last)
    return new


@kernel
def _all_are_known(states: ByteArray) -> bool:
    # Without a branch per cell, so that the loop is vectorized.
    unknown = False
    for state in states:
        unknown |= state == UNKNOWN
    return not unknown


@kernel
def _mark_frontier(layers: Layers, changed: IntArray) -> None:
    # Update the frontier in the window of the changes and one cell around it. Cells outside
    # of the arrays are unknown.
    states, marks = layers.states, layers.marks
    rows, columns = states.shape
    first, end = max(0, changed[2] - 1), min(columns, changed[3] + 2)
    c0 = max(first, 1)
    c1 = max(c0, min(end, columns - 1))
    outside = np.zeros(c1 - c0, np.uint8)
    for r in range(max(0, changed[0] - 1), min(rows, changed[1] + 2)):
        for c in (0, columns - 1):
            if first <= c < end:
                marks[r, c] = _with_frontier(marks[r, c], states[r, c], UNKNOWN)
        # Slices instead of indices, so that the loop is vectorized.
        here, held = states[r, c0:c1], marks[r, c0:c1]
        left, right = states[r, c0 - 1 : c1 - 1], states[r, c0 + 1 : c1 + 1]
        below = states[r - 1, c0:c1] if r > 0 else outside
        above = states[r + 1, c0:c1] if r + 1 < rows else outside
        for i in range(held.shape[0]):
            lowest = min(min(left[i], right[i]), min(below[i], above[i]))
            held[i] = _with_frontier(held[i], here[i], lowest)


@kernel
def _with_frontier(marks: int, state: int, lowest_around: int) -> int:
    is_frontier = (state == FREE) & (lowest_around == UNKNOWN)
    return (marks & ~FRONTIER) | (FRONTIER if is_frontier else 0)
