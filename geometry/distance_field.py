"""Geodesic distances on a grid: how far it is to every free cell, around the obstacles."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.kernel import BoolArray, FloatArray, IntArray, inlined_kernel, kernel

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
    free = np.ascontiguousarray(free, dtype=np.bool_)
    if free.ndim != 2:
        raise InvalidInputError(f"a grid of free cells has two dimensions, not {free.ndim}")
    if not 0.0 < cell_m < math.inf:
        raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")
    starts = _cells_of(sources, free, cell_m, x0, y0)
    wanted = np.zeros(free.shape, np.bool_)
    count = -1
    if asked is not None:
        rows, columns = _asked_cells(asked, free)
        wanted[rows, columns] = free[rows, columns]
        count = int(np.count_nonzero(wanted))
    return _march(free, starts, wanted, count) * cell_m


def _cells_of(
    sources: ArrayLike, free: BoolArray, cell_m: float, x0: float, y0: float
) -> FloatArray:
    # In widths of cells from the grid's corner: cell (r, c) is [c, c + 1) x [r, r + 1).
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


def _asked_cells(asked: ArrayLike, free: BoolArray) -> tuple[IntArray, IntArray]:
    cells = np.asarray(asked, np.int64).reshape(-1, 2)
    outside = (cells < 0).any(axis=1) | (cells >= free.shape).any(axis=1)
    if outside.any():
        row, column = cells[int(np.flatnonzero(outside)[0])]
        raise InvalidInputError(
            f"the asked cell ({row}, {column}) is not in the grid of "
            f"{free.shape[0]} rows and {free.shape[1]} columns"
        )
    return cells[:, 0], cells[:, 1]


@kernel
def _march(
    free: BoolArray, starts: FloatArray, wanted: NDArray[np.bool_], remaining: int
) -> FloatArray:
    # The grid gets a border of two blocked cells, so that no neighbour is out of bounds.
    rows, columns = free.shape
    width = columns + 4
    size = (rows + 4) * width
    state = np.full(size, BLOCKED, np.uint8)
    distance = np.full(size, np.inf)
    for r in range(rows):
        for c in range(columns):
            if free[r, c]:
                state[(r + 2) * width + c + 2] = FREE

    # A binary heap of the cells that have a value but not their final one. It knows where each
    # cell lies in it, so that a lower value moves the cell instead of adding it again.
    heap, keys = np.empty(rows * columns, np.int32), np.empty(rows * columns)
    places = np.full(size, -1, np.int32)
    held = 0
    for k in range(starts.shape[0]):
        x, y = starts[k, 0], starts[k, 1]
        for r in range(max(0, int(y) - EXACT_CELLS), min(rows, int(y) + EXACT_CELLS + 1)):
            for c in range(max(0, int(x) - EXACT_CELLS), min(columns, int(x) + EXACT_CELLS + 1)):
                straight = np.hypot(c + 0.5 - x, r + 0.5 - y)
                u = (r + 2) * width + c + 2
                if straight < distance[u] and _in_sight(free, x, y, c, r):
                    distance[u] = straight
                    state[u] = EXACT
                    held = _raise(heap, keys, places, held, straight, u)

    while held > 0 and remaining != 0:
        u = heap[0]
        held = _drop_first(heap, keys, places, held)
        state[u] = ACCEPTED
        if remaining > 0 and wanted[u // width - 2, u % width - 2]:
            remaining -= 1
        for step in (1, -1, width, -width):
            v = u + step
            if state[v] == FREE or state[v] == EXACT:
                value = _upwind(distance, state, v, width)
                slack = EXACT_SLACK_CELLS if state[v] == EXACT else 0.0
                if value < distance[v] - slack:
                    distance[v] = value
                    state[v] = FREE
                    held = _raise(heap, keys, places, held, value, v)

    field = np.full((rows, columns), np.inf)
    for r in range(rows):
        for c in range(columns):
            u = (r + 2) * width + c + 2
            if state[u] == ACCEPTED:
                field[r, c] = distance[u]
    return field


@inlined_kernel
def _upwind(distance: FloatArray, state: NDArray[np.uint8], v: int, width: int) -> float:
    # Solve sum over the axes of weight * (value - base)^2 = 1 with the accepted cells upwind.
    base_x, weight_x = _one_sided(distance, state, v, 1)
    base_y, weight_y = _one_sided(distance, state, v, width)
    if weight_x > 0.0 and weight_y > 0.0:
        a = weight_x + weight_y
        b = weight_x * base_x + weight_y * base_y
        c = weight_x * base_x * base_x + weight_y * base_y * base_y - 1.0
        discriminant = b * b - a * c
        if discriminant >= 0.0:
            value = (b + math.sqrt(discriminant)) / a
            if value >= max(base_x, base_y):
                return value
    # The front comes along one axis only.
    value = np.inf
    if weight_x > 0.0:
        value = base_x + 1.0 / math.sqrt(weight_x)
    if weight_y > 0.0:
        value = min(value, base_y + 1.0 / math.sqrt(weight_y))
    return value


@inlined_kernel
def _one_sided(
    distance: FloatArray, state: NDArray[np.uint8], v: int, step: int
) -> tuple[float, float]:
    # The difference along one axis as sqrt(weight) * (value - base); weight 0 if none is known.
    nearest, toward = np.inf, 0
    if state[v - step] == ACCEPTED:
        nearest, toward = distance[v - step], -step
    if state[v + step] == ACCEPTED and distance[v + step] < nearest:
        nearest, toward = distance[v + step], step
    if toward == 0:
        return 0.0, 0.0
    second = v + 2 * toward
    if state[second] == ACCEPTED and distance[second] <= nearest:
        return (4.0 * nearest - distance[second]) / 3.0, 2.25
    return nearest, 1.0


@kernel
def _in_sight(free: BoolArray, x: float, y: float, column: int, row: int) -> bool:
    # Walk the cells from a point to a cell's centre. Between two cells that meet in a corner
    # both cells beside it have to be free.
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
def _raise(
    heap: NDArray[np.int32],
    keys: FloatArray,
    places: NDArray[np.int32],
    held: int,
    key: float,
    cell: int,
) -> int:
    # Move a cell towards the top to where its lower value belongs; put it in if it is not there.
    i = places[cell]
    if i < 0:
        i = held
        held += 1
    while i > 0:
        parent = (i - 1) >> 1
        if keys[parent] <= key:
            break
        above = heap[parent]
        heap[i], keys[i], places[above] = above, keys[parent], i
        i = parent
    heap[i], keys[i], places[cell] = cell, key, i
    return held


@kernel
def _drop_first(
    heap: NDArray[np.int32], keys: FloatArray, places: NDArray[np.int32], held: int
) -> int:
    # The hole at the top goes down to the bottom along the smaller children, without a branch
    # to mispredict; there the last cell, which has one of the largest values, is near its place.
    held -= 1
    i, child = 0, 1
    while child + 1 < held:
        child += 1 if keys[child + 1] < keys[child] else 0
        below = heap[child]
        heap[i], keys[i], places[below] = below, keys[child], i
        i, child = child, 2 * child + 1
    if child < held:
        below = heap[child]
        heap[i], keys[i], places[below] = below, keys[child], i
        i = child
    last = heap[held]
    places[last] = i
    _raise(heap, keys, places, held, keys[held], last)
    return held
