"""The cells of a grid whose centres lie in a polygon, row by row."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, Int32Array, IntArray
from multisrt.geometry.numerics.kernel import kernel


@kernel
def paint_polygon(boundary: FloatArray, x0: float, y0: float, cell: float, cells: BoolArray) -> int:
    """Paint the cells whose centres lie in a polygon, by the even-odd rule.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the polygon in metres.
    x0, y0 : float
        Lower left corner of the grid in metres.
    cell : float
        Width of a cell in metres.
    cells : (rows, columns) array of bool
        The grid, painted in place.

    Returns
    -------
    int
        Number of cells that were not painted before.

    Examples
    --------
    >>> cells = np.zeros((3, 4), np.bool_)
    >>> triangle = np.array([(0.0, 0.0), (3.2, 0.0), (0.0, 3.2)])
    >>> paint_polygon(triangle, 0.0, 0.0, 1.0, cells)
    6
    >>> cells.astype(int).tolist()
    [[1, 1, 1, 0], [1, 1, 0, 0], [1, 0, 0, 0]]
    """
    new = 0
    for row, begin, end in runs_inside(boundary, x0, y0, cell, *cells.shape):
        # A slice instead of indices, so that the loop is vectorized.
        run = cells[row, begin:end]
        for i in range(run.shape[0]):
            new += not run[i]
        run[:] = True
    return new


@kernel
def runs_inside(
    boundary: FloatArray, x0: float, y0: float, cell: float, rows: int, columns: int
) -> Int32Array:
    """Return the cells that `paint_polygon` paints, as runs along rows.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the polygon in metres.
    x0, y0 : float
        Lower left corner of the grid in metres.
    cell : float
        Width of a cell in metres.
    rows, columns : int
        Size of the grid.

    Returns
    -------
    (k, 3) array of int32
        Row, first column and column after the last of each run.
    """
    first_row, starts, crossings = row_crossings(boundary, y0, cell, 0, rows - 1)
    runs = np.empty((crossings.shape[0] // 2, 3), np.int32)
    count = 0
    for r in range(starts.shape[0] - 1):
        for i in range(starts[r], starts[r + 1] - 1, 2):
            begin = max(0, int(np.ceil((crossings[i] - x0) / cell - 0.5)))
            end = min(columns, int(np.ceil((crossings[i + 1] - x0) / cell - 0.5)))
            if begin < end:
                runs[count, 0], runs[count, 1], runs[count, 2] = first_row + r, begin, end
                count += 1
    return runs[:count].copy()


@kernel
def row_crossings(
    boundary: FloatArray, y0: float, cell: float, lowest_row: int, highest_row: int
) -> tuple[int, IntArray, FloatArray]:
    """Find where the centre lines of rows cross the boundary of a polygon.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the polygon in metres.
    y0 : float
        Lower border of row 0 in metres.
    cell : float
        Height of a row in metres.
    lowest_row, highest_row : int
        First and last of the rows to look at.

    Returns
    -------
    first_row : int
        The first of these rows that the polygon reaches.
    starts : (k + 1,) array of int
        For k rows from there on: the crossings of row ``first_row + i`` are
        ``crossings[starts[i]:starts[i + 1]]``.
    crossings : (m,) array
        Their x in metres, ascending within each row, an even number per row.
    """
    n = boundary.shape[0]
    bottom = top = boundary[0, 1]
    for i in range(n):
        bottom, top = min(bottom, boundary[i, 1]), max(top, boundary[i, 1])
    first_row = max(lowest_row, int(np.ceil((bottom - y0) / cell - 0.5)))
    last_row = min(highest_row, int(np.floor((top - y0) / cell - 0.5)))
    height = max(0, last_row - first_row + 1)
    # Count the crossings, then write them in compressed rows.
    spans = np.empty((n, 2), np.int64)
    starts = np.zeros(height + 1, np.int64)
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        low, high = boundary[i, 1], boundary[j, 1]
        if low > high:
            low, high = high, low
        spans[i, 0] = max(first_row, int(np.ceil((low - y0) / cell - 0.5)))
        spans[i, 1] = min(last_row, int(np.ceil((high - y0) / cell - 0.5)) - 1)
        for r in range(spans[i, 0], spans[i, 1] + 1):
            starts[r - first_row] += 1
    total = 0
    for r in range(height + 1):
        count = starts[r]
        starts[r] = total
        total += count
    crossings = np.empty(total)
    fill = starts.copy()
    for i in range(n):
        if spans[i, 1] < spans[i, 0]:
            continue
        j = i + 1 if i + 1 < n else 0
        ax, ay, bx, by = boundary[i, 0], boundary[i, 1], boundary[j, 0], boundary[j, 1]
        if ay > by:
            ax, bx, ay, by = bx, ax, by, ay
        slope = (bx - ax) / (by - ay)
        left, right = min(ax, bx), max(ax, bx)
        for r in range(spans[i, 0], spans[i, 1] + 1):
            k = fill[r - first_row]
            # Rounding would carry it far beyond the ends of an edge almost along the line.
            crossings[k] = min(max(ax + (y0 + (r + 0.5) * cell - ay) * slope, left), right)
            fill[r - first_row] += 1
    for r in range(height):
        low, high = starts[r], starts[r + 1]
        for i in range(low + 1, high):
            value = crossings[i]
            k = i - 1
            while k >= low and crossings[k] > value:
                crossings[k + 1] = crossings[k]
                k -= 1
            crossings[k + 1] = value
    return first_row, starts, crossings
