"""Edges of a world in a uniform grid, so that a query touches its neighbourhood only."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel, unsigned
from multisrt.geometry.numerics.segments import cross_each_other, squared_distance

MAX_CELLS = 4_000_000
"""A grid never has more cells than this; its cells are made larger instead."""


class EdgeIndex:
    """Directed edges, free space on their left, binned into square cells.

    An index holds scratch memory for its queries: use one per simulation or thread.

    Parameters
    ----------
    edges : (n, 4) array
        x0, y0, x1, y1 of every edge in metres, free space on the left.
    cell_m : float
        Width of a cell; a third of the range of the queries to come serves well.

    Raises
    ------
    InvalidInputError
        If there is no edge, an edge is not finite, or the cell is not positive.
    """

    __slots__ = (
        "bins",
        "cell_m",
        "columns",
        "edges",
        "free_winding",
        "grid",
        "rows",
        "scratch",
        "x0",
        "y0",
    )

    def __init__(self, edges: FloatArray, cell_m: float) -> None:
        edges = np.ascontiguousarray(edges, dtype=np.float64)
        if edges.ndim != 2 or edges.shape[1] != 4 or not len(edges):
            raise InvalidInputError(f"edges are an (n, 4) array with n > 0, not {edges.shape}")
        if not np.isfinite(edges).all():
            raise InvalidInputError("edges are finite numbers of metres")
        if not 0.0 < cell_m < np.inf:
            raise InvalidInputError(f"the cell of an edge index is a positive width, not {cell_m}")
        x0, y0 = edges[:, [0, 2]].min(), edges[:, [1, 3]].min()
        width, height = edges[:, [0, 2]].max() - x0, edges[:, [1, 3]].max() - y0
        cell_m = max(cell_m, float(np.sqrt(width * height / MAX_CELLS)), max(width, height) / 1e6)
        self.edges = edges
        self.cell_m = float(cell_m)
        self.x0, self.y0 = float(x0), float(y0)
        self.columns = int(width / cell_m) + 1
        self.rows = int(height / cell_m) + 1
        self.bins = _bin_edges(edges, self.x0, self.y0, self.cell_m, self.columns, self.rows)
        # As the kernels take them.
        self.grid = (self.x0, self.y0, self.cell_m, self.columns, self.rows)
        self.scratch = Scratch(len(edges))
        # How often the edges wind around free space: once inside an outline, else not at all.
        twice_area = (edges[:, 0] - x0) * (edges[:, 3] - y0) - (edges[:, 2] - x0) * (
            edges[:, 1] - y0
        )
        self.free_winding = 1 if float(twice_area.sum()) > 0.0 else 0


class Scratch:
    """Memory that queries reuse: in which query each edge was last met, and the edges met now.

    Both are rows of one array, for every array that is handed to a kernel costs time.
    """

    __slots__ = ("memory", "query")

    def __init__(self, edges: int) -> None:
        self.memory: IntArray = np.zeros((2, edges), np.int64)
        self.query = 0

    def next_query(self) -> int:
        """Give a number that no earlier query of this memory had; the one after it is free too."""
        self.query += 2
        return self.query


@kernel
def _bin_edges(
    edges: FloatArray, x0: float, y0: float, cell: float, columns: int, rows: int
) -> IntArray:
    # Compressed rows in one array: bins[bins[k]:bins[k + 1]] are the edges that touch cell k,
    # which has its whole border, and a hair more for rounding: what passes exactly through a
    # cell's corner may be looked up in any cell around it. Two passes, to count and to fill.
    margin = 1e-6 * cell
    bins = np.zeros(columns * rows + 1, np.int64)
    fill = np.empty(0, np.int64)
    for counting in (True, False):
        if not counting:
            cells = columns * rows + 1
            total = cells
            for k in range(cells):
                count = bins[k]
                bins[k] = total
                total += count
            fill = bins
            bins = np.empty(total, np.int64)
            bins[:cells] = fill
        for e in range(edges.shape[0]):
            ax, ay, bx, by = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
            dx, dy = bx - ax, by - ay
            first_column = int(max(0.0, (min(ax, bx) - x0 - margin) / cell))
            last_column = int(min(columns - 1.0, (max(ax, bx) - x0 + margin) / cell))
            first_row = int(max(0.0, (min(ay, by) - y0 - margin) / cell))
            last_row = int(min(rows - 1.0, (max(ay, by) - y0 + margin) / cell))
            # Separating axis along the edge's normal.
            reach = (abs(dx) + abs(dy)) * (0.5 * cell + margin)
            for i in range(first_column, last_column + 1):
                for j in range(first_row, last_row + 1):
                    cx, cy = x0 + (i + 0.5) * cell, y0 + (j + 0.5) * cell
                    if abs((cx - ax) * dy - (cy - ay) * dx) <= reach:
                        k = i * rows + j
                        if counting:
                            bins[k] += 1
                        else:
                            bins[fill[k]] = e
                            fill[k] += 1
    return bins


@kernel
def edges_within(
    x: float,
    y: float,
    radius: float,
    grid: tuple[float, float, float, int, int],
    bins: IntArray,
    stamps: IntArray,
    query: int,
    found: IntArray,
) -> int:
    """Write the edges of all cells that a disc touches into `found`; return how many."""
    x0, y0, cell, columns, rows = grid
    first_column = int(max(0.0, np.floor((x - radius - x0) / cell)))
    last_column = int(min(columns - 1.0, np.floor((x + radius - x0) / cell)))
    first_row = int(max(0.0, np.floor((y - radius - y0) / cell)))
    last_row = int(min(rows - 1.0, np.floor((y + radius - y0) / cell)))
    count = 0
    for i in range(first_column, last_column + 1):
        dx = max(0.0, max(x0 + i * cell - x, x - x0 - (i + 1) * cell))
        for j in range(first_row, last_row + 1):
            dy = max(0.0, max(y0 + j * cell - y, y - y0 - (j + 1) * cell))
            if dx * dx + dy * dy > radius * radius:
                continue
            for k in range(bins[i * rows + j], bins[i * rows + j + 1]):
                e = unsigned(bins[k])
                if stamps[e] != query:
                    stamps[e] = query
                    found[count] = e
                    count += 1
    return count


@kernel
def no_edge_within(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    distance: float,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: IntArray,
) -> bool:
    """Whether all edges are farther from the line from a to b than a distance."""
    x0, y0, cell, columns, rows = grid
    first_column = int(max(0.0, np.floor((min(ax, bx) - distance - x0) / cell)))
    last_column = int(min(columns - 1.0, np.floor((max(ax, bx) + distance - x0) / cell)))
    first_row = int(max(0.0, np.floor((min(ay, by) - distance - y0) / cell)))
    last_row = int(min(rows - 1.0, np.floor((max(ay, by) + distance - y0) / cell)))
    least = distance * distance
    for i in range(first_column, last_column + 1):
        for j in range(first_row, last_row + 1):
            for k in range(bins[i * rows + j], bins[i * rows + j + 1]):
                px, py, qx, qy = edges[bins[k]]
                if (
                    squared_distance(px - ax, py - ay, qx - ax, qy - ay) <= least
                    or squared_distance(px - bx, py - by, qx - bx, qy - by) <= least
                    or squared_distance(ax - px, ay - py, bx - px, by - py) <= least
                    or squared_distance(ax - qx, ay - qy, bx - qx, by - qy) <= least
                    or cross_each_other(ax, ay, bx, by, px, py, qx, qy)
                ):
                    return False
    return True


@kernel
def winding_number(
    x: float,
    y: float,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: IntArray,
    stamps: IntArray,
    query: int,
) -> int:
    """Count how often the edges wind around a point, in the grid's row to the right of it."""
    x0, y0, cell, columns, rows = grid
    row = np.floor((y - y0) / cell)
    if row < 0.0 or row >= rows:
        return 0
    j = int(row)
    winding = 0
    for i in range(int(min(max(0.0, np.floor((x - x0) / cell)), float(columns))), columns):
        for k in range(bins[i * rows + j], bins[i * rows + j + 1]):
            e = unsigned(bins[k])
            if stamps[e] == query:
                continue
            stamps[e] = query
            ax, ay = edges[e, 0] - x, edges[e, 1] - y
            bx, by = edges[e, 2] - x, edges[e, 3] - y
            if ay <= 0.0 < by and ax * by - ay * bx > 0.0:
                winding += 1
            elif by <= 0.0 < ay and ax * by - ay * bx < 0.0:
                winding -= 1
    return winding
