"""The edges of a world in a uniform grid, so that a query reads its neighbourhood only."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel, unsigned
from multisrt.geometry.numerics.segments import cross_each_other, squared_distance

MAX_CELLS: Final = 4_000_000
"""Number of cells above which a grid gets larger cells instead."""


class EdgeGrid(NamedTuple):
    """Edges and the cells of a uniform grid that they touch, as kernels take them.

    Attributes
    ----------
    edges : (n, 4) array
        x0, y0, x1, y1 of every edge in metres, free space on its left.
    bins : (c,) array of int
        Edges by cell: those that touch cell k are ``bins[bins[k]:bins[k + 1]]``, ascending. The
        cell in column i and row j is number ``i * rows + j``.
    x0, y0 : float
        Lower left corner of the grid in metres.
    cell_m : float
        Width of a cell in metres.
    columns, rows : int
        Size of the grid in cells.
    free_winding : int
        How often the edges wind around free space: 1 inside an outline, otherwise 0.
    """

    edges: FloatArray
    bins: IntArray
    x0: float
    y0: float
    cell_m: float
    columns: int
    rows: int
    free_winding: int


class EdgeIndex:
    """Directed edges, free space on their left, binned into square cells.

    An index never changes, and queries keep nothing in it: any number of threads may share one.

    Parameters
    ----------
    edges : (n, 4) array
        x0, y0, x1, y1 of every edge in metres, free space on the left.
    cell_m : float
        Width of a cell in metres; a third of the range of the queries serves well.

    Attributes
    ----------
    grid : EdgeGrid
        The edges and their cells, as kernels take them.

    Raises
    ------
    InvalidInputError
        If there is no edge, an edge is not finite, or the cell is not positive.

    Examples
    --------
    A room of 4 x 3 m:

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    >>> room = EdgeIndex(np.hstack([corners, np.roll(corners, -1, axis=0)]), 1.0)
    >>> room.grid.columns, room.grid.rows
    (5, 4)
    >>> winding_number(1.0, 1.0, room.grid), winding_number(5.0, 1.0, room.grid)
    (1, 0)
    """

    __slots__ = ("grid",)

    def __init__(self, edges: FloatArray, cell_m: float) -> None:
        # Read-only whatever is given, so that kernels are compiled for one type of grid.
        edges = np.ascontiguousarray(edges, dtype=np.float64).view()
        edges.setflags(write=False)
        if edges.ndim != 2 or edges.shape[1] != 4 or not len(edges):
            raise InvalidInputError(f"edges are an (n, 4) array with n > 0, not {edges.shape}")
        if not np.isfinite(edges).all():
            raise InvalidInputError("edges are finite numbers of metres")
        if not 0.0 < cell_m < np.inf:
            raise InvalidInputError(f"the cell of an edge index is a positive width, not {cell_m}")
        x0, y0 = edges[:, [0, 2]].min(), edges[:, [1, 3]].min()
        width, height = edges[:, [0, 2]].max() - x0, edges[:, [1, 3]].max() - y0
        cell_m = max(cell_m, float(np.sqrt(width * height / MAX_CELLS)), max(width, height) / 1e6)
        cell_m, x0, y0 = float(cell_m), float(x0), float(y0)
        columns, rows = int(width / cell_m) + 1, int(height / cell_m) + 1
        twice_area = (edges[:, 0] - x0) * (edges[:, 3] - y0) - (edges[:, 2] - x0) * (
            edges[:, 1] - y0
        )
        self.grid = EdgeGrid(
            edges=edges,
            bins=_bin_edges(edges, x0, y0, cell_m, columns, rows),
            x0=x0,
            y0=y0,
            cell_m=cell_m,
            columns=columns,
            rows=rows,
            free_winding=1 if float(twice_area.sum()) > 0.0 else 0,
        )

    @property
    def edges(self) -> FloatArray:
        """The indexed edges, ``(n, 4)``, x0, y0, x1, y1 in metres."""
        return self.grid.edges


@kernel
def _bin_edges(
    edges: FloatArray, x0: float, y0: float, cell: float, columns: int, rows: int
) -> IntArray:
    # The bins of an `EdgeGrid`. A cell has its whole border, and a hair more for rounding: what
    # passes exactly through a cell's corner may be looked up in any cell around it. Two passes,
    # to count and to fill.
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
def _cell_range(low: float, high: float, cell: float, count: int) -> tuple[int, int]:
    # First cell of an interval along an axis of the grid, and the one behind its last.
    first = int(min(max(0.0, np.floor(low / cell)), float(count)))
    last = int(max(-1.0, min(count - 1.0, np.floor(high / cell))))
    return first, max(first, last + 1)


@kernel
def edges_within(x: float, y: float, radius: float, grid: EdgeGrid) -> IntArray:
    """Return the edges of all cells that a disc touches.

    Parameters
    ----------
    x, y, radius : float
        The disc, in metres.
    grid : EdgeGrid
        The edges.

    Returns
    -------
    (k,) array of int
        Rows of `grid.edges`, each once, in the order of the cells.
    """
    bins, rows, cell = grid.bins, grid.rows, grid.cell_m
    first_column, end_column = _cell_range(
        x - radius - grid.x0, x + radius - grid.x0, cell, grid.columns
    )
    first_row, end_row = _cell_range(y - radius - grid.y0, y + radius - grid.y0, cell, rows)
    most = 0
    for i in range(first_column, end_column):
        most += bins[i * rows + end_row] - bins[i * rows + first_row]
    found = np.empty(most, np.int64)
    # Open addressing: edges next to each other have numbers next to each other.
    size = 8
    while size < 2 * most:
        size *= 2
    table = np.full(size, -1)
    count = 0
    for i in range(first_column, end_column):
        dx = max(0.0, max(grid.x0 + i * cell - x, x - grid.x0 - (i + 1) * cell))
        for j in range(first_row, end_row):
            dy = max(0.0, max(grid.y0 + j * cell - y, y - grid.y0 - (j + 1) * cell))
            if dx * dx + dy * dy > radius * radius:
                continue
            for k in range(bins[i * rows + j], bins[i * rows + j + 1]):
                e = bins[k]
                slot = e & (size - 1)
                while table[slot] >= 0 and table[slot] != e:
                    slot = (slot + 1) & (size - 1)
                if table[slot] < 0:
                    table[slot] = e
                    found[count] = e
                    count += 1
    return found[:count]


@kernel
def no_edge_within(
    ax: float, ay: float, bx: float, by: float, distance: float, grid: EdgeGrid
) -> bool:
    """Whether all edges are farther from a segment than a distance.

    Parameters
    ----------
    ax, ay, bx, by : float
        Ends of the segment, in metres.
    distance : float
        In metres, positive.
    grid : EdgeGrid
        The edges.
    """
    edges, bins, rows, cell = grid.edges, grid.bins, grid.rows, grid.cell_m
    first_column, end_column = _cell_range(
        min(ax, bx) - distance - grid.x0, max(ax, bx) + distance - grid.x0, cell, grid.columns
    )
    first_row, end_row = _cell_range(
        min(ay, by) - distance - grid.y0, max(ay, by) + distance - grid.y0, cell, rows
    )
    least = distance * distance
    for i in range(first_column, end_column):
        # The cells of a column follow each other.
        for k in range(bins[i * rows + first_row], bins[i * rows + end_row]):
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
def winding_number(x: float, y: float, grid: EdgeGrid) -> int:
    """Return how often the edges wind around a point, counter-clockwise.

    Parameters
    ----------
    x, y : float
        The point, in metres.
    grid : EdgeGrid
        The edges; only those in the point's row of cells, to its right, are read.
    """
    edges, bins = grid.edges, grid.bins
    row = np.floor((y - grid.y0) / grid.cell_m)
    if row < 0.0 or row >= grid.rows:
        return 0
    j = int(row)
    first = int(min(max(0.0, np.floor((x - grid.x0) / grid.cell_m)), float(grid.columns)))
    winding = 0
    for i in range(first, grid.columns):
        cell = i * grid.rows + j
        for k in range(bins[cell], bins[cell + 1]):
            e = unsigned(bins[k])
            ax, ay = edges[e, 0] - x, edges[e, 1] - y
            bx, by = edges[e, 2] - x, edges[e, 3] - y
            turn = 0
            if ay <= 0.0 < by and ax * by - ay * bx > 0.0:
                turn = 1
            elif by <= 0.0 < ay and ax * by - ay * bx < 0.0:
                turn = -1
            # The cells of an edge in one row follow each other: it counts in the first of them.
            if turn != 0 and (i == first or not _is_in_cell(bins[k], cell - grid.rows, bins)):
                winding += turn
    return winding


@kernel
def _is_in_cell(edge: int, cell: int, bins: IntArray) -> bool:
    k, end = bins[cell], bins[cell + 1]
    while k < end and bins[k] != edge:
        k += 1
    is_found: bool = k < end
    return is_found
