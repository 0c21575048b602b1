"""Stand-ins for modules that the competition's simulator imports and that may be missing.

An installed module is used. Otherwise the functions that the simulator calls are replaced by those
of this file, which take the same steps, so that runs are the same to the last cell:

============  ==================================================================================
range_libc    ranges of rays through a grid by Bresenham's algorithm, in single precision
pyastar2d     cheapest paths through a 4-connected grid by A*, with ties broken as by the binary
              heap of the C++ standard library
skimage       reduction of blocks, and the cells of a line
============  ==================================================================================

Modules that the simulator imports but does not call in a run (cv2, tqdm, matplotlib) are replaced
by empty ones, since no pictures are drawn.
"""

from __future__ import annotations

import importlib.util
import math
import sys
from types import ModuleType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.numerics.arrays import BoolArray, IntArray
from multisrt.geometry.numerics.kernel import kernel

Float32Array = NDArray[np.float32]

COMPUTING: Final = ("range_libc", "pyastar2d", "skimage")
"""Modules on whose results a run depends."""


def install() -> tuple[str, ...]:
    """Install stand-ins for missing modules in this process.

    Returns
    -------
    tuple of str
        The modules of `COMPUTING` that are replaced.
    """
    replaced = tuple(name for name in COMPUTING if importlib.util.find_spec(name) is None)
    if "range_libc" in replaced:
        _module("range_libc", PyOMap=OccupancyMap, PyBresenhamsLine=BresenhamRays)
    if "pyastar2d" in replaced:
        _module("pyastar2d", astar_path=astar_path)
    if "skimage" in replaced:
        _module("skimage")
        _module("skimage.measure", block_reduce=block_reduce)
        _module("skimage.draw", line=line)
    _module("cv2")
    _module("tqdm", tqdm=None)
    _module("tqdm.contrib")
    _module("tqdm.contrib.concurrent", process_map=None)
    _module("matplotlib", use=lambda *_, **__: None)
    _module("matplotlib.pyplot")
    return replaced


def _module(name: str, **contents: Any) -> None:
    module = ModuleType(name, "Stand-in of multisrt.")
    module.__dict__.update(contents)
    module.__path__ = []  # it may have submodules
    sys.modules[name] = module
    parent, _, child = name.rpartition(".")
    if parent:
        setattr(sys.modules[parent], child, module)


class OccupancyMap:
    """The occupied cells of a grid, like ``range_libc.PyOMap``."""

    def __init__(self, grid: NDArray[Any]) -> None:
        self.occupied: BoolArray = grid != 0


class BresenhamRays:
    """Ranges of rays, like ``range_libc.PyBresenhamsLine``.

    Parameters
    ----------
    grid : OccupancyMap
        The occupied cells.
    max_range : float
        Maximum range in cells.
    """

    def __init__(self, grid: OccupancyMap, max_range: float) -> None:
        self._occupied = grid.occupied
        self._max_range = np.float32(max_range)

    def calc_range_many(self, queries: Float32Array, ranges: Float32Array) -> None:
        """Write the range of each ray to `ranges`; the parameters are those of `cast_rays`."""
        cast_rays(self._occupied, queries, self._max_range, ranges)


@kernel
def cast_rays(
    occupied: BoolArray, queries: Float32Array, max_range: Any, ranges: Float32Array
) -> None:
    """Write the ranges of rays to the first occupied cell.

    Parameters
    ----------
    occupied : (rows, columns) array of bool
        The grid.
    queries : (n, 3) array of float32
        Row and column of the start, and the angle, which is measured from the axis of the rows
        towards that of the columns.
    max_range : float32
        Maximum range in cells, which is also the range of rays that hit nothing.
    ranges : (n,) array of float32
        Output: the distance of the occupied cell that is hit, or of the last cell before the ray
        leaves the grid.

    Notes
    -----
    The cells of a ray are computed by Bresenham's algorithm in single precision: one in each row if
    the ray is closer to the axis of the rows, otherwise one in each column. Source: range_libc,
    ``BresenhamsLine::calc_range``, including its conversion from world coordinates.
    """
    rows, columns = occupied.shape
    turn = np.float32(-3.0 * math.pi / 2.0)
    two = np.float32(2.0)
    for n in range(len(queries)):
        row, column = queries[n, 0], queries[n, 1]
        heading = np.float32(-queries[n, 2] + turn)
        ranges[n] = max_range
        if occupied[int(row), int(column)]:
            ranges[n] = np.float32(0.0)
            continue
        a0, b0 = row, column
        a1 = np.float32(row + np.float32(max_range * np.float32(math.sin(heading))))
        b1 = np.float32(column + np.float32(max_range * np.float32(math.cos(heading))))
        steep = abs(b1 - b0) > abs(a1 - a0)
        if steep:
            a0, b0, a1, b1 = b0, a0, b1, a1
        delta_a, delta_b = np.float32(abs(a1 - a0)), np.float32(abs(b1 - b0))
        step_a = np.float32(1.0 if a0 < a1 else -1.0)
        step_b = np.float32(1.0 if b0 < b1 else -1.0)
        error = np.float32(0.0)
        a, b = a0, b0
        while True:
            i, j = (b, a) if steep else (a, b)
            if not (0 <= i < rows and 0 <= j < columns):
                da, db = np.float32(a - step_a - a0), np.float32(b - step_b - b0)
                ranges[n] = np.float32(math.sqrt(da * da + db * db))
                break
            if occupied[int(i), int(j)]:
                da, db = np.float32(a - a0), np.float32(b - b0)
                ranges[n] = np.float32(math.sqrt(da * da + db * db))
                break
            a = np.float32(a + step_a)
            error = np.float32(error + delta_b)
            if np.float32(error * two) >= delta_a:
                b = np.float32(b + step_b)
                error = np.float32(error - delta_a)
            if (step_a > 0 and a > a1) or (step_a < 0 and a < a1):
                break


def astar_path(
    weights: Float32Array, start: Any, goal: Any, allow_diagonal: bool = False
) -> NDArray[np.int32] | None:
    """Return a cheapest path between two cells, like ``pyastar2d.astar_path``.

    Parameters
    ----------
    weights : (rows, columns) array of float32
        Cost of entering a cell, at least 1; ``inf`` if it cannot be entered.
    start, goal : (row, column)
        The two cells.
    allow_diagonal : bool
        Must be False.

    Returns
    -------
    (n, 2) array of int32 or None
        The cells of the path, with both ends; None if there is no path.
    """
    if allow_diagonal:
        raise NotImplementedError("paths through the corners of cells need pyastar2d: install it")
    path = cheapest_path(weights, int(start[0]), int(start[1]), int(goal[0]), int(goal[1]))
    return path if len(path) else None


@kernel
def cheapest_path(
    weights: Float32Array, start_row: int, start_column: int, goal_row: int, goal_column: int
) -> NDArray[np.int32]:
    """Return the cells of a cheapest path, ``(n, 2)``; empty if there is no path.

    Notes
    -----
    A* with the Manhattan distance as the lower bound, costs in single precision and neighbours in
    the order up, left, right, down. The binary heap is updated like ``std::priority_queue`` of
    GCC's standard library, because it determines which of several paths of equal cost is found.
    Source: pyastar2d 1.1.
    """
    rows, columns = weights.shape
    start, goal = start_row * columns + start_column, goal_row * columns + goal_column
    costs = np.full(rows * columns, np.inf, np.float32)
    before = np.full(rows * columns, -1, np.int32)
    costs[start] = 0.0
    keys, cells = np.empty(1024, np.float32), np.empty(1024, np.int32)
    keys[0], cells[0], size = 0.0, start, 1
    found = False
    while size > 0:
        cell = cells[0]
        if cell == goal:
            found = True
            break
        # Remove the first entry: the hole moves down to a leaf, where the last entry moves up.
        size -= 1
        key, last = keys[size], cells[size]
        hole, child = 0, 0
        while child < (size - 1) // 2:
            child = 2 * child + 2
            if keys[child] > keys[child - 1]:
                child -= 1
            keys[hole], cells[hole] = keys[child], cells[child]
            hole = child
        if size % 2 == 0 and child == (size - 2) // 2 and size > 0:
            child = 2 * child + 1
            keys[hole], cells[hole] = keys[child], cells[child]
            hole = child
        while hole > 0 and keys[(hole - 1) // 2] > key:
            parent = (hole - 1) // 2
            keys[hole], cells[hole] = keys[parent], cells[parent]
            hole = parent
        keys[hole], cells[hole] = key, last

        row, column = cell // columns, cell % columns
        for k in range(4):
            i = row + (-1, 0, 0, 1)[k]
            j = column + (0, -1, 1, 0)[k]
            if not (0 <= i < rows and 0 <= j < columns):
                continue
            neighbour = i * columns + j
            cost = np.float32(costs[cell] + weights[i, j])
            if cost < costs[neighbour]:
                key = np.float32(cost + np.float32(abs(i - goal_row) + abs(j - goal_column)))
                if size == len(keys):
                    keys = np.concatenate((keys, np.empty(size, np.float32)))
                    cells = np.concatenate((cells, np.empty(size, np.int32)))
                hole = size
                size += 1
                while hole > 0 and keys[(hole - 1) // 2] > key:
                    parent = (hole - 1) // 2
                    keys[hole], cells[hole] = keys[parent], cells[parent]
                    hole = parent
                keys[hole], cells[hole] = key, neighbour
                costs[neighbour], before[neighbour] = cost, cell
    if not found:
        return np.empty((0, 2), np.int32)
    length, cell = 1, goal
    while cell != start:
        cell = before[cell]
        length += 1
    path = np.empty((length, 2), np.int32)
    cell = goal
    for k in range(length - 1, -1, -1):
        path[k, 0], path[k, 1] = cell // columns, cell % columns
        cell = before[cell]
    return path


def block_reduce(
    image: NDArray[Any], block_size: tuple[int, int], func: Any = np.sum, cval: float = 0
) -> NDArray[Any]:
    """Reduce blocks of an array, like ``skimage.measure.block_reduce``."""
    high, wide = block_size
    rows, columns = image.shape
    padded = np.pad(image, ((0, -rows % high), (0, -columns % wide)), constant_values=cval)
    blocks = padded.reshape(-(-rows // high), high, -(-columns // wide), wide)
    return np.asarray(func(blocks, axis=(1, 3)))


def line(r0: int, c0: int, r1: int, c1: int) -> tuple[IntArray, IntArray]:
    """Return the cells of a line by Bresenham's algorithm, like ``skimage.draw.line``.

    Examples
    --------
    >>> [cells.tolist() for cells in line(0, 0, 1, 4)]
    [[0, 0, 1, 1, 1], [0, 1, 2, 3, 4]]
    """
    cells = _line_cells(int(r0), int(c0), int(r1), int(c1))
    return cells[0], cells[1]


@kernel
def _line_cells(r0: int, c0: int, r1: int, c1: int) -> IntArray:
    high, wide = abs(r1 - r0), abs(c1 - c0)
    steep = high > wide
    a, b = (c0, r0) if steep else (r0, c0)
    da, db = (wide, high) if steep else (high, wide)
    step_r, step_c = (1 if r1 > r0 else -1), (1 if c1 > c0 else -1)
    step_a, step_b = (step_c, step_r) if steep else (step_r, step_c)
    cells = np.empty((2, db + 1), np.int64)
    error = 2 * da - db
    for k in range(db):
        cells[0, k], cells[1, k] = (b, a) if steep else (a, b)
        while error >= 0 and db > 0:
            a += step_a
            error -= 2 * db
        b += step_b
        error += 2 * da
    cells[0, db], cells[1, db] = r1, c1
    return cells
