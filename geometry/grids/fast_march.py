"""The fast march on a grid: its kernels, its heap, and sight from cell to cell.

Grids are flat here. They have a border of two blocked cells, so that no neighbour is out of
bounds; a cell's upper neighbour is `width` further on. `distance` has the values that are final,
and ``inf`` everywhere else; the values of the front are the heap's keys, of which number 0, for
all cells not in it, is ``inf``.

Source: J. A. Sethian, Fast marching methods, SIAM Review 41 (1999), sections 3 and 5; differs
in: exact values around a source, and what has been accepted can be taken back.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.numerics.kernel import (
    BoolArray,
    FloatArray,
    IntArray,
    inlined_kernel,
    kernel,
    unsigned,
)

EXACT_CELLS: Final = 10
"""Cells in sight of a source and no further from it than this start with their exact distance.

A front that starts from a point has a corner there, and all later values inherit its error.
"""

EXACT_SLACK_CELLS: Final = 0.5
"""An exact start value gives way only to a source that is nearer by more than this.

Across the source, where distances have a kink, one step of the march is wrong by up to a third.
"""

BLOCKED: Final = 0
FREE: Final = 1
EXACT: Final = 2
ACCEPTED: Final = 3

ASKED: Final = 1
RIM: Final = 2


@kernel
def seed(
    free: BoolArray,
    starts: FloatArray,
    state: NDArray[np.uint8],
    places: NDArray[np.int32],
    heap: NDArray[np.int32],
    keys: FloatArray,
    width: int,
) -> int:
    """Give the cells around the sources their exact distances; tells how many the heap holds.

    `free` is the grid without its border, and `starts` are the sources in widths of its cells.
    """
    rows, columns = free.shape
    held = 0
    for k in range(starts.shape[0]):
        x, y = starts[k, 0], starts[k, 1]
        for r in range(max(0, int(y) - EXACT_CELLS), min(rows, int(y) + EXACT_CELLS + 1)):
            for c in range(max(0, int(x) - EXACT_CELLS), min(columns, int(x) + EXACT_CELLS + 1)):
                straight = np.hypot(c + 0.5 - x, r + 0.5 - y)
                u = (r + 2) * width + c + 2
                if straight < keys[places[u]] and in_sight(free, x, y, c, r):
                    state[u] = EXACT
                    held = push(heap, keys, places, held, straight, u)
    return held


@kernel
def march(
    state: NDArray[np.uint8],
    marks: NDArray[np.uint8],
    distance: FloatArray,
    places: NDArray[np.int32],
    order: NDArray[np.int32],
    heap: NDArray[np.int32],
    keys: FloatArray,
    held: int,
    count: int,
    width: int,
    remaining: int,
    limit: float,
) -> tuple[int, int, bool]:
    """Accept cells in the order of their values.

    Until the front is empty or beyond the limit, as many asked cells as remain are accepted, or
    the next one lies on the rim. An accepted cell's place is its rank.

    Returns
    -------
    held, count : int
        How many cells the heap holds, and how many are accepted.
    at_rim : bool
        Whether the next cell lies on the rim.
    """
    one, across = unsigned(1), unsigned(width)
    while held > 0 and remaining != 0:
        u, value = unsigned(heap[1]), keys[1]
        if value > limit:
            return held, count, False
        if marks[u] != 0:
            if marks[u] & RIM:
                return held, count, True
            remaining -= 1
        held = drop_first(heap, keys, places, held)
        state[u], distance[u] = ACCEPTED, value
        places[u], order[count] = count, u
        count += 1
        for v in (u + one, u - one, u + across, u - across):
            if state[v] == FREE or state[v] == EXACT:
                value = _upwind(distance, v, across)
                if _is_lower(value, keys[unsigned(places[v])], state[v]):
                    state[v] = FREE
                    held = push(heap, keys, places, held, value, v)
    return held, count, False


@kernel
def numbers_of(
    rows: IntArray, columns: IntArray, window: tuple[int, int, int, int], width: int
) -> IntArray:
    """Give the numbers that cells have in a window of the grid, with its border.

    Parameters
    ----------
    rows, columns : (n,) arrays
        Where they are in the grid.
    window : (r0, r1, c0, c1)
        The window's rows are r0 to r1 - 1, its columns c0 to c1 - 1.
    width : int
        Columns of the window with its border.

    Returns
    -------
    (n,) array
        0, which is a cell of the border, for those that do not lie in the window.
    """
    r0, r1, c0, c1 = window
    numbers = np.zeros(rows.shape[0], np.int64)
    for i in range(rows.shape[0]):
        if r0 <= rows[i] < r1 and c0 <= columns[i] < c1:
            numbers[i] = (rows[i] - r0 + 2) * width + columns[i] - c0 + 2
    return numbers


@kernel
def ask(at: IntArray, state: NDArray[np.uint8], marks: NDArray[np.uint8]) -> tuple[int, int]:
    """Mark cells as asked for; tell how many of them are not accepted yet, and how many are.

    Those that do not lie in the window are not accepted.
    """
    missing = final = 0
    for u in at:
        if state[u] == ACCEPTED:
            final += 1
        elif u == 0:
            missing += 1
        elif not marks[u] & ASKED:
            marks[u] |= ASKED
            missing += 1
    return missing, final


@kernel
def first_accepted(at: IntArray, state: NDArray[np.uint8], places: NDArray[np.int32]) -> int:
    """Give the index of the cell that was accepted first; -1 if none was."""
    first = -1
    for i in range(at.shape[0]):
        if state[at[i]] == ACCEPTED and (first < 0 or places[at[i]] < places[at[first]]):
            first = i
    return first


@kernel
def forget(at: IntArray, marks: NDArray[np.uint8]) -> None:
    """Have cells no longer asked for."""
    for u in at:
        marks[u] &= RIM


@kernel
def moved_cells(
    cells: NDArray[np.int32], across: int, width: int, below: int, left: int
) -> NDArray[np.int32]:
    """Give the numbers of cells in a grid that has more rows below and more columns to the left.

    Parameters
    ----------
    cells : (n,) array
        Their numbers in a grid that is `across` wide.
    across, width : int
        Widths of the two grids, borders included.
    below, left : int
        How many more rows and columns.
    """
    numbers = np.empty_like(cells)
    for i in range(len(cells)):
        row, column = cells[i] // across, cells[i] % across
        numbers[i] = (row + below) * width + column + left
    return numbers


@inlined_kernel
def _is_lower(value: float, own: float, state: int) -> bool:
    # Whether a cell takes a value that it is offered instead of its own.
    return value < own - (EXACT_SLACK_CELLS if state == EXACT else 0.0)


@inlined_kernel
def _upwind(distance: FloatArray, v: int, width: int) -> float:
    # Solve sum over the axes of weight * (value - base)^2 = 1 with the accepted cells upwind.
    base_x, weight_x = _one_sided(distance, v, unsigned(1))
    base_y, weight_y = _one_sided(distance, v, width)
    if base_x < np.inf and base_y < np.inf:
        a = weight_x + weight_y
        b = weight_x * base_x + weight_y * base_y
        c = weight_x * base_x * base_x + weight_y * base_y * base_y - 1.0
        discriminant = b * b - a * c
        if discriminant >= 0.0:
            value = (b + math.sqrt(discriminant)) / a
            if value >= max(base_x, base_y):
                return value
    # The front comes along one axis only.
    return min(base_x + 1.0 / math.sqrt(weight_x), base_y + 1.0 / math.sqrt(weight_y))


@inlined_kernel
def _one_sided(distance: FloatArray, v: int, step: int) -> tuple[float, float]:
    # The difference along one axis as sqrt(weight) * (value - base); base inf if none is known.
    # Choices instead of branches: which neighbours are known nobody can predict.
    before, after = distance[v - step], distance[v + step]
    beyond = v + step + step if after < before else v - step - step
    nearest, second = min(before, after), distance[beyond]
    of_second_order = second <= nearest and second < np.inf
    base = (4.0 * nearest - second) / 3.0 if of_second_order else nearest
    return base, 2.25 if of_second_order else 1.0


@kernel
def descend(
    at: IntArray, state: NDArray[np.uint8], distance: FloatArray, width: int
) -> tuple[IntArray, IntArray]:
    """Follow the distances down to a source, each time to the steepest of 8 neighbours.

    Returns
    -------
    ways : (n,) array
        The ways from all cells that are asked for, one after the other.
    begins : (k + 1,) array
        Way k is ``ways[begins[k]:begins[k + 1]]``.
    """
    ways, count = np.empty(256, np.int64), 0
    begins = np.zeros(at.shape[0] + 1, np.int64)
    for k in range(at.shape[0]):
        u = at[k]
        while True:
            if count == ways.shape[0]:
                more = np.empty(2 * count, np.int64)
                more[:count] = ways
                ways = more
            ways[count] = u
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
    return ways[:count].copy(), begins


@kernel
def take_back(
    changed: IntArray,
    state: NDArray[np.uint8],
    distance: FloatArray,
    places: NDArray[np.int32],
    order: NDArray[np.int32],
    heap: NDArray[np.int32],
    keys: FloatArray,
    held: int,
    count: int,
    width: int,
    seeds: NDArray[np.int32],
    seed_values: FloatArray,
) -> tuple[int, int]:
    """Block cells that were free and free those that were blocked, and take back what follows.

    Returns how many cells the heap holds, and how many remain accepted.
    """
    # A cell that is blocked now has had no share in anything accepted before it, one that is
    # passable now can have none in what was accepted before its first neighbour: so far a new
    # march would go the same way.
    kept = count
    for w in changed:
        if state[w] == ACCEPTED:
            kept = min(kept, places[w])
        elif state[w] == BLOCKED:
            for step in (1, -1, width, -width):
                if state[w + step] == ACCEPTED:
                    kept = min(kept, places[w + step] + 1)
    # Forget the rest, and the front.
    loose = np.concatenate((heap[1 : held + 1], order[kept:count], changed.astype(np.int32)))
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
            held = push(heap, keys, places, held, seed_values[k], u)
    # The front of that moment.
    around = np.full(25, np.inf)
    for u in loose:
        if state[u] != BLOCKED:
            held = _relive(u, distance, state, places, heap, keys, held, width, around)
    return held, kept


@kernel
def _relive(
    v: int,
    distance: FloatArray,
    state: NDArray[np.uint8],
    places: NDArray[np.int32],
    heap: NDArray[np.int32],
    keys: FloatArray,
    held: int,
    width: int,
    around: FloatArray,
) -> int:
    # The value of a cell of the front is the least that it was offered as its neighbours were
    # accepted. Offer them again in that order, each with what was accepted by then, which is
    # laid out in 5 x 5 cells around it.
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
            held = push(heap, keys, places, held, value, v)
        done = rank


@kernel
def in_sight(free: BoolArray, x: float, y: float, column: int, row: int) -> bool:
    """Whether a cell's centre is seen from a point, given in cells, through free cells alone.

    Between two cells that meet in a corner both cells beside it have to be free.
    """
    c, r = int(x), int(y)
    dx, dy = column + 0.5 - x, row + 0.5 - y
    step_c, step_r = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    next_x = np.inf if dx == 0.0 else (c + (step_c > 0) - x) / dx
    next_y = np.inf if dy == 0.0 else (r + (step_r > 0) - y) / dy
    if not free[r, c]:
        return False
    while c != column or r != row:
        if c != column and r != row and abs(next_x - next_y) < 1e-9:
            if not (free[r, c + step_c] and free[r + step_r, c]):
                return False
            c, r = c + step_c, r + step_r
            next_x, next_y = next_x + abs(1.0 / dx), next_y + abs(1.0 / dy)
        elif r == row or (c != column and next_x < next_y):
            c, next_x = c + step_c, next_x + abs(1.0 / dx)
        else:
            r, next_y = r + step_r, next_y + abs(1.0 / dy)
        if not free[r, c]:
            return False
    return True


@kernel
def push(
    heap: NDArray[np.int32],
    keys: FloatArray,
    places: NDArray[np.int32],
    held: int,
    key: float,
    cell: int,
) -> int:
    """Put a cell into a binary heap, or move it to where its lower key belongs.

    The heap begins at index 1. It knows where each cell lies in it, so that a lower value moves
    the cell instead of adding it again; place 0 is that of cells not in it. Equal keys go by
    the cells' numbers, so that the order in which cells leave does not depend on how they came.
    Returns how many cells it holds.
    """
    one, new = unsigned(1), unsigned(cell)
    i = unsigned(places[new])
    if i == 0:
        held += 1
        i = unsigned(held)
    while i > 1:
        parent = i >> one
        above = unsigned(heap[parent])
        if keys[parent] <= key and (keys[parent] < key or above < new):
            break
        heap[i], keys[i], places[above] = above, keys[parent], i
        i = parent
    heap[i], keys[i], places[new] = new, key, i
    return held


@kernel
def drop_first(
    heap: NDArray[np.int32], keys: FloatArray, places: NDArray[np.int32], held: int
) -> int:
    """Take the cell of the lowest key out of a heap; returns how many cells it holds then.

    Its place is left for the caller to overwrite.
    """
    # The hole at the top goes down to the bottom along the smaller children, without a branch
    # to mispredict; there the last cell, which has one of the largest values, is near its place.
    one, last, key = unsigned(1), unsigned(heap[held]), keys[held]
    held -= 1
    i, child, bottom = unsigned(1), unsigned(2), unsigned(held)
    while child < bottom:
        left, right = keys[child], keys[child + one]
        if left == right:
            child += one if heap[child + one] < heap[child] else unsigned(0)
        else:
            child += one if right < left else unsigned(0)
        below = unsigned(heap[child])
        heap[i], keys[i], places[below] = below, keys[child], i
        i, child = child, child + child
    if child == bottom:
        below = unsigned(heap[child])
        heap[i], keys[i], places[below] = below, keys[child], i
        i = child
    if held > 0:
        places[last] = i
        push(heap, keys, places, held, key, last)
    return held
