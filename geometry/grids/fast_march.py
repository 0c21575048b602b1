"""Kernels of the fast marching method on a grid.

Grids are flat here, with a border of two blocked cells, so that no neighbour is out of bounds; a
cell's upper neighbour is one `width` further on.

Source: J. A. Sethian, Fast marching methods, SIAM Review 41 (1999), sections 3 and 5; differs
in: exact values around a source, and accepted cells can be taken back.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.grids.cell_heap import drop_first, push
from multisrt.geometry.grids.sight import in_sight
from multisrt.geometry.numerics.arrays import (
    BoolArray,
    ByteArray,
    FloatArray,
    Int32Array,
    IntArray,
)
from multisrt.geometry.numerics.kernel import inlined_kernel, kernel, unsigned

EXACT_CELLS: Final = 10
"""Cells in sight of a source and within this many rows and columns start with exact distances.

A front that starts from a point has a corner there, and all later values inherit its error.
"""

EXACT_SLACK_CELLS: Final = 0.5
"""An exact start value is replaced only by one that is lower by more than this, in cells.

Across the source, where distances have a kink, one step of the march is wrong by up to a third.
"""

BLOCKED: Final = 0
FREE: Final = 1
EXACT: Final = 2
ACCEPTED: Final = 3

ASKED: Final = 1
"""Mark of a cell that is to be accepted before the march stops."""
RIM: Final = 2
"""Mark of a cell behind which the grid continues, but not the window."""


class March(NamedTuple):
    """The arrays of a march, with one value per cell unless stated otherwise.

    Attributes
    ----------
    width : int
        Columns of the grid, with its border.
    state : (n,) array of uint8
        `BLOCKED`, `FREE`, `EXACT` (free, with an exact start value) or `ACCEPTED`.
    marks : (n,) array of uint8
        Bits `ASKED` and `RIM`.
    distance : (n,) array
        Values of the accepted cells in widths of a cell, ``inf`` elsewhere.
    order : (n,) array of int32
        Numbers of the accepted cells in the order in which they were accepted.
    cells, keys, places : arrays
        The front as a heap, see `cell_heap.push`: cells with values that are not final, which
        are the keys; key 0 is ``inf``. The place of an accepted cell is its index in `order`.
    """

    width: int
    state: ByteArray
    marks: ByteArray
    distance: FloatArray
    order: Int32Array
    cells: Int32Array
    keys: FloatArray
    places: Int32Array


@kernel
def seed(free: BoolArray, starts: FloatArray, march: March) -> int:
    """Put the cells around the sources on the front, with exact distances.

    Parameters
    ----------
    free : (rows, columns) array of bool
        The grid without its border.
    starts : (k, 2) array
        The sources x, y in widths of a cell from the corner of `free`.
    march : March
        A march that has not begun, changed in place.

    Returns
    -------
    int
        Number of cells on the front.
    """
    rows, columns = free.shape
    cells, keys, places = march.cells, march.keys, march.places
    blocked = np.zeros((2 * EXACT_CELLS + 2, 2 * EXACT_CELLS + 2), np.int32)
    held = 0
    for k in range(starts.shape[0]):
        x, y = starts[k, 0], starts[k, 1]
        r0, c0 = max(0, int(y) - EXACT_CELLS), max(0, int(x) - EXACT_CELLS)
        r1, c1 = min(rows, int(y) + EXACT_CELLS + 1), min(columns, int(x) + EXACT_CELLS + 1)
        # blocked[i, j] counts the cells of the first i rows and j columns that are not free. What
        # lies between a source and a cell is in sight of it if it is free all over.
        for r in range(r0, r1):
            before = 0
            for c in range(c0, c1):
                before += not free[r, c]
                blocked[r + 1 - r0, c + 1 - c0] = blocked[r - r0, c + 1 - c0] + before
        for r in range(r0, r1):
            low, high = min(r, int(y)) - r0, max(r, int(y)) - r0 + 1
            for c in range(c0, c1):
                straight = np.hypot(c + 0.5 - x, r + 0.5 - y)
                u = (r + 2) * march.width + c + 2
                if straight < keys[places[u]]:
                    left, right = min(c, int(x)) - c0, max(c, int(x)) - c0 + 1
                    walls = blocked[high, right] - blocked[low, right]
                    walls += blocked[low, left] - blocked[high, left]
                    if walls == 0 or in_sight(free, x, y, c, r):
                        march.state[u] = EXACT
                        held = push(cells, keys, places, held, straight, u)
    return held


@kernel
def advance(
    march: March, held: int, count: int, remaining: int, limit: float
) -> tuple[int, int, bool]:
    """Accept cells in the order of their values.

    It stops when the front is empty or beyond the limit, enough asked cells are accepted, or the
    next cell lies on the rim.

    Parameters
    ----------
    march : March
        The march, changed in place.
    held, count : int
        Number of cells on the front, and of those accepted.
    remaining : int
        Number of cells marked `ASKED` to accept; negative for no end.
    limit : float
        Highest value to accept, in widths of a cell.

    Returns
    -------
    held, count : int
        Number of cells on the front now, and of those accepted.
    at_rim : bool
        Whether the next cell lies on the rim.
    """
    state, marks, distance, order = march.state, march.marks, march.distance, march.order
    cells, keys, places = march.cells, march.keys, march.places
    one, width = unsigned(1), unsigned(march.width)
    while held > 0 and remaining != 0:
        u, value = unsigned(cells[1]), keys[1]
        if value > limit:
            return held, count, False
        if marks[u] != 0:
            if marks[u] & RIM:
                return held, count, True
            remaining -= 1
        held = drop_first(cells, keys, places, held)
        state[u], distance[u] = ACCEPTED, value
        places[u], order[count] = count, u
        count += 1
        for v in (u + one, u - one, u + width, u - width):
            if state[v] == FREE or state[v] == EXACT:
                value = _upwind(distance, v, width)
                if _is_lower(value, keys[unsigned(places[v])], state[v]):
                    state[v] = FREE
                    held = push(cells, keys, places, held, value, v)
    return held, count, False


@kernel
def descend(
    at: IntArray, state: ByteArray, distance: FloatArray, width: int
) -> tuple[IntArray, IntArray]:
    """Follow the distances from cells down to a source, each step to the steepest of 8 neighbours.

    Parameters
    ----------
    at : (k,) array
        Numbers of accepted cells.
    state, distance : (n,) arrays
        As in `March`.
    width : int
        Columns of the grid with its border.

    Returns
    -------
    paths : (m,) array
        The cells on the paths from all of them, one path after the other.
    begins : (k + 1,) array
        Path k is ``paths[begins[k]:begins[k + 1]]``.
    """
    paths, count = np.empty(256, np.int64), 0
    begins = np.zeros(at.shape[0] + 1, np.int64)
    for k in range(at.shape[0]):
        u = at[k]
        while True:
            if count == paths.shape[0]:
                more = np.empty(2 * count, np.int64)
                more[:count] = paths
                paths = more
            paths[count] = u
            count += 1
            steepest, below = 0.0, 0
            for away in (-1, 0, 1):
                for aside in (-1, 0, 1):
                    v = u + away * width + aside
                    if not (state[u + away * width] and state[u + aside]):
                        continue
                    slope = distance[u] - distance[v]
                    if away != 0 and aside != 0:
                        slope *= math.sqrt(0.5)
                    if slope > steepest:
                        steepest, below = slope, v
            if steepest == 0.0:
                break
            u = below
        begins[k + 1] = count
    return paths[:count].copy(), begins


@kernel
def take_back(
    changed: IntArray,
    march: March,
    held: int,
    count: int,
    seeds: Int32Array,
    seed_values: FloatArray,
) -> tuple[int, int]:
    """Toggle cells between free and blocked, and take back what they may have had a share in.

    Parameters
    ----------
    changed : (k,) array
        Numbers of the cells that were free and are blocked now, or the reverse.
    march : March
        The march, changed in place.
    held, count : int
        Number of cells on the front, and of those accepted.
    seeds : (s,) array of int32
        Numbers of the cells on the front when the march began.
    seed_values : (s,) array
        Their values.

    Returns
    -------
    held, count : int
        Number of cells on the front now, and of those that remain accepted. The march continues as
        one from nothing would at that moment.
    """
    # A cell that is blocked now had no share in anything accepted before it, and one that is
    # free now can have none in anything accepted before its first neighbour.
    state, distance, order, width = march.state, march.distance, march.order, march.width
    cells, keys, places = march.cells, march.keys, march.places
    kept = count
    for w in changed:
        if state[w] == ACCEPTED:
            kept = min(kept, places[w])
        elif state[w] == BLOCKED:
            for step in (1, -1, width, -width):
                if state[w + step] == ACCEPTED:
                    kept = min(kept, places[w + step] + 1)
    # The rest is forgotten, and so is the front.
    front = cells[1 : held + 1]
    loose = np.concatenate((front, order[kept:count], changed.astype(np.int32)))
    for u in loose:
        if state[u] != BLOCKED:
            state[u] = FREE
        distance[u], places[u] = np.inf, 0
    for w in changed:
        state[w] = FREE if state[w] == BLOCKED else BLOCKED
    held = 0
    for k in range(len(seeds)):
        u = seeds[k]
        if state[u] != ACCEPTED:
            state[u] = EXACT
            held = push(cells, keys, places, held, seed_values[k], u)
    # The front of that moment.
    around = np.full(25, np.inf)
    for u in loose:
        if state[u] != BLOCKED:
            held = _restore(u, march, held, around)
    return held, kept


@kernel
def _restore(v: int, march: March, held: int, around: FloatArray) -> int:
    # The value of a cell on the front is the lowest that it was offered as its neighbours were
    # accepted. They are offered again in that order, each from what was accepted by then, which
    # is laid out in the 5 x 5 cells of `around`.
    state, distance, width = march.state, march.distance, march.width
    cells, keys, places = march.cells, march.keys, march.places
    done = -1
    while True:
        rank = np.iinfo(np.int32).max
        for step in (1, -1, width, -width):
            if state[v + step] == ACCEPTED and done < places[v + step] < rank:
                rank = places[v + step]
        if rank == np.iinfo(np.int32).max:
            return held
        for away in (-2, -1, 1, 2):
            for step, here in ((1, 1), (width, 5)):
                w = v + away * step
                by_then = state[w] == ACCEPTED and places[w] <= rank
                around[12 + away * here] = distance[w] if by_then else np.inf
        value = _upwind(around, unsigned(12), unsigned(5))
        if _is_lower(value, keys[places[v]], state[v]):
            state[v] = FREE
            held = push(cells, keys, places, held, value, v)
        done = rank


@inlined_kernel
def _is_lower(value: float, own: float, state: int) -> bool:
    # Whether a cell takes a value that it is offered instead of its own.
    return value < own - (EXACT_SLACK_CELLS if state == EXACT else 0.0)


@inlined_kernel
def _upwind(distance: FloatArray, v: int, width: int) -> float:
    # Solve sum over the axes of weight * (value - base)^2 = 1 with the accepted cells upwind.
    base_x, weight_x, length_x = _one_sided(distance, v, unsigned(1))
    base_y, weight_y, length_y = _one_sided(distance, v, width)
    a = weight_x + weight_y
    b = weight_x * base_x + weight_y * base_y
    c = weight_x * base_x * base_x + weight_y * base_y * base_y - 1.0
    value = (b + math.sqrt(b * b - a * c)) / a
    # Otherwise, also where it is no number, the front arrives along one axis only.
    arrives_along_both = value >= max(base_x, base_y)
    return value if arrives_along_both else min(base_x + length_x, base_y + length_y)


@inlined_kernel
def _one_sided(distance: FloatArray, v: int, step: int) -> tuple[float, float, float]:
    # The difference along one axis as (value - base) / length, with the weight 1 / length^2; base
    # is inf if no value is known. Selections instead of branches, here and in `_upwind`: which
    # neighbours are known is hard to predict.
    before, after = distance[v - step], distance[v + step]
    beyond = v + step + step if after < before else v - step - step
    nearest, second = min(before, after), distance[beyond]
    of_second_order = second <= nearest and second < np.inf
    base = (4.0 * nearest - second) / 3.0 if of_second_order else nearest
    return base, 2.25 if of_second_order else 1.0, 2.0 / 3.0 if of_second_order else 1.0
