"""A raster of painted polygons: exact at cell centres, growing as far as needed."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, Int32Array, IntArray
from multisrt.geometry.numerics.boxes import all_below, bounds_of
from multisrt.geometry.numerics.kernel import kernel

MAX_CELLS = 400_000_000
"""Maximum size of a raster in bytes, which for one byte per cell is its number of cells."""

MAX_CELL_INDEX = 2.0**52
"""Maximum distance from the origin, in cells, at which floats distinguish neighbouring cells."""

OFFSET_X, OFFSET_Y = 0.6947927077420251, 0.9741538717342381
"""Shift of the lattice in cells: ``3 u - v - 1`` and ``3 u + 3 v - 3``.

Here u = 1 / r and v = 1 / r**2, and r is the real root of r**3 = r + 1.
Walls tend to lie on round coordinates, along the axes or at angles whose slopes are ratios of
small numbers. No cell centre lies on such a wall, so that no cell depends on how a tie is broken.

Proof: a centre on a line ``p x + q y = s / m`` (in cells; p, q, s, m whole numbers) would make
``L = 2 m p OFFSET_X + 2 m q OFFSET_Y + n`` zero for a whole number n, and with it a sum of whole
multiples of 1, u and v that are not all zero. These are a basis of a cubic field of algebraic
integers, so that the norm of L is a whole number other than zero: L times the squared modulus of
its complex conjugate, which is at most proportional to ``h = m * max(abs(p), abs(q))`` for
abs(L) < 1. So abs(L) is at least a constant divided by h**2. These two multiples of u and v keep
centres farthest from walls along the axes and at 45 degrees on multiples of 1/10 of a cell.
"""

Corners = tuple[int, int, int, int]
"""A rectangle of cells ``(r0, r1, c0, c1)``: rows r0 to r1 - 1 and columns c0 to c1 - 1."""

Number = TypeVar("Number", bound=np.generic)


class Window(NamedTuple):
    """The part of the lattice that a raster stores.

    Attributes
    ----------
    row, column : int
        Lattice row and column of its first cell.
    rows, columns : int
        Number of its rows and columns.
    """

    row: int
    column: int
    rows: int
    columns: int


class Raster:
    """Cells whose centres lie in at least one of the polygons painted so far.

    The cell width alone determines the lattice, so that rasters of equal cell width have the
    same cells whatever window they store.

    Parameters
    ----------
    cell_m : float
        Width of a cell in metres.
    bounds : (x0, y0, x1, y1), optional
        The first window in metres; it grows to hold polygons outside.

    Attributes
    ----------
    cell_m : float
        Width of a cell in metres.
    column, row : int
        Lattice indices of the first column and row of the window.
    cells : (rows, columns) array of bool
        Whether each cell is painted; row 0 is the lowest y.

    Raises
    ------
    InvalidInputError
        If the width is not positive and finite, or there would be more than `MAX_CELLS` cells.

    Examples
    --------
    >>> raster = Raster(0.5)
    >>> square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    >>> raster.paint(square)
    16
    >>> raster.area_m2()
    4.0
    >>> raster.paint(square + 1.0)
    12
    """

    __slots__ = ("cell_m", "cells", "column", "row")

    def __init__(
        self, cell_m: float, bounds: tuple[float, float, float, float] | None = None
    ) -> None:
        refuse_cell_width(cell_m)
        self.cell_m = cell_m
        self.column = self.row = 0
        self.cells: BoolArray = np.zeros((0, 0), np.bool_)
        if bounds is not None:
            self._cover(bounds)

    @property
    def x0(self) -> float:
        """Left border of the window in metres."""
        return (self.column - OFFSET_X) * self.cell_m

    @property
    def y0(self) -> float:
        """Lower border of the window in metres."""
        return (self.row - OFFSET_Y) * self.cell_m

    def paint(self, boundary: FloatArray) -> int:
        """Paint the cells whose centres lie in a polygon, by the even-odd rule.

        The window grows to hold the polygon.

        Parameters
        ----------
        boundary : (n, 2) array
            Corners of the polygon in metres; the last is joined to the first.

        Returns
        -------
        int
            Number of cells that were not painted before.

        Raises
        ------
        InvalidInputError
            If the raster would grow beyond `MAX_CELLS`, or a corner is not finite. Nothing has
            changed then.
        """
        refuse_corners(boundary, self.cell_m)
        self._cover(bounds_of(boundary))
        return paint_polygon(boundary, self.x0, self.y0, self.cell_m, self.cells)

    def paint_inside(self, boundary: FloatArray) -> int:
        """Paint cells as `paint` does, but only those of the window, which does not grow.

        Parameters
        ----------
        boundary : (n, 2) array
            Corners of the polygon in metres; the last is joined to the first.

        Returns
        -------
        int
            Number of cells that were not painted before.

        Raises
        ------
        InvalidInputError
            If a corner is not finite.
        """
        refuse_corners(boundary, self.cell_m)
        return paint_polygon(boundary, self.x0, self.y0, self.cell_m, self.cells)

    def centres(self) -> tuple[FloatArray, FloatArray]:
        """Return the coordinates of the cells' centres in metres.

        Returns
        -------
        x : (columns,) array
            Of the centres in each column.
        y : (rows,) array
            Of the centres in each row.

        Examples
        --------
        >>> x, y = Raster(1.0, (0.0, 0.0, 2.0, 1.0)).centres()
        >>> x.round(2).tolist(), y.round(2).tolist()
        ([-0.19, 0.81, 1.81], [-0.47, 0.53])
        """
        rows, columns = self.cells.shape
        return (
            self.x0 + (np.arange(columns, dtype=np.float64) + 0.5) * self.cell_m,
            self.y0 + (np.arange(rows, dtype=np.float64) + 0.5) * self.cell_m,
        )

    def area_m2(self) -> float:
        """Return the area of all painted cells in square metres."""
        return float(np.count_nonzero(self.cells)) * self.cell_m**2

    def _cover(self, bounds: tuple[float, float, float, float]) -> None:
        held = Window(self.row, self.column, *self.cells.shape)
        window = window_over(bounds, self.cell_m, held)
        if window != held:
            self.cells = moved(self.cells, held, window)
            self.row, self.column = window.row, window.column


def refuse_cell_width(cell_m: float) -> None:
    """Raise an `InvalidInputError` unless the width of a cell is positive and finite."""
    if not 0.0 < cell_m < math.inf:
        raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")


def refuse_corners(boundary: FloatArray, cell_m: float) -> None:
    """Raise an `InvalidInputError` for corners not finite or beyond `MAX_CELL_INDEX`."""
    if not all_below(boundary, MAX_CELL_INDEX * cell_m):
        raise InvalidInputError(
            f"the corners of a polygon are finite numbers of metres, with cells of {cell_m:g} m "
            f"below {MAX_CELL_INDEX * cell_m:g}"
        )


def window_over(
    bounds: tuple[float, float, float, float], cell_m: float, held: Window, cell_bytes: int = 1
) -> Window:
    """Return the window that holds some bounds and the present window.

    It grows by at least half its size, so that growing costs little over a whole run.

    Parameters
    ----------
    bounds : (x0, y0, x1, y1)
        Bounds to hold, in metres.
    cell_m : float
        Width of a cell in metres.
    held : Window
        The present window, without rows if there is none yet.
    cell_bytes : int
        Memory per cell in bytes.

    Returns
    -------
    Window
        The present one if it already holds the bounds.

    Raises
    ------
    InvalidInputError
        If it would take more than `MAX_CELLS` bytes.

    Examples
    --------
    >>> window_over((0.0, 0.0, 4.0, 2.0), 1.0, Window(0, 0, 0, 0))
    Window(row=0, column=0, rows=3, columns=5)
    >>> window_over((-1.0, 0.0, 1.0, 1.0), 1.0, Window(0, 0, 3, 5))
    Window(row=0, column=-3, rows=3, columns=8)
    """
    first_column = math.floor(bounds[0] / cell_m + OFFSET_X)
    first_row = math.floor(bounds[1] / cell_m + OFFSET_Y)
    last_column = math.floor(bounds[2] / cell_m + OFFSET_X)
    last_row = math.floor(bounds[3] / cell_m + OFFSET_Y)
    row, column, rows, columns = held
    if rows == 0:
        row, column = first_row, first_column
    elif (
        first_column >= column
        and first_row >= row
        and last_column < column + columns
        and last_row < row + rows
    ):
        return held
    left = max(0, column - first_column)
    below = max(0, row - first_row)
    right = max(0, last_column + 1 - column - columns)
    above = max(0, last_row + 1 - row - rows)
    if rows:
        spare_x, spare_y = columns // 2, rows // 2
        left, right = left and left + spare_x, right and right + spare_x
        below, above = below and below + spare_y, above and above + spare_y
    window = Window(row - below, column - left, rows + below + above, columns + left + right)
    if window.rows * window.columns * cell_bytes > MAX_CELLS:
        raise InvalidInputError(
            f"a raster of {window.columns} x {window.rows} cells is larger than "
            f"{MAX_CELLS // cell_bytes} cells: choose cells wider than {cell_m:g} m"
        )
    return window


def moved(layer: NDArray[Number], held: Window, window: Window) -> NDArray[Number]:
    """Return a layer of a window as one of a larger window, with zeros in the new cells.

    Parameters
    ----------
    layer : (held.rows, held.columns) array
        One value per cell.
    held, window : Window
        The window of the layer, and one that contains it.

    Returns
    -------
    (window.rows, window.columns) array
    """
    larger = np.zeros((window.rows, window.columns), layer.dtype)
    below, left = held.row - window.row, held.column - window.column
    larger[below : below + held.rows, left : left + held.columns] = layer
    return larger


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
        for r in range(spans[i, 0], spans[i, 1] + 1):
            k = fill[r - first_row]
            crossings[k] = ax + (y0 + (r + 0.5) * cell - ay) * slope
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


@kernel
def eroded(cells: BoolArray, radius: float) -> BoolArray:
    """Erode a set of cells by a disc.

    Parameters
    ----------
    cells : (rows, columns) array of bool
        The set; cells outside of the array are not in it.
    radius : float
        Radius of the disc in widths of a cell, below 255.

    Returns
    -------
    (rows, columns) array of bool
        The cells whose centres are at least the radius away from those of all cells that are not
        in the set.

    Examples
    --------
    >>> eroded(np.ones((3, 5), np.bool_), 2.0).astype(int).tolist()
    [[0, 0, 0, 0, 0], [0, 1, 1, 1, 0], [0, 0, 0, 0, 0]]
    """
    rows, columns = cells.shape
    reach = math.ceil(radius)
    # Distance of each cell, within its row, to the nearest cell that is not in the set.
    across = np.empty((rows, columns), np.uint8)
    for r in range(rows):
        distance = 0
        for c in range(columns):
            distance = min(distance + 1, reach) if cells[r, c] else 0
            across[r, c] = distance
        distance = 0
        for c in range(columns - 1, -1, -1):
            distance = min(distance + 1, reach) if cells[r, c] else 0
            across[r, c] = min(across[r, c], distance)
    kept = cells.copy()
    for apart in range(-reach, reach + 1):
        # Smallest distance along a row that many rows away which is outside of the disc.
        required = 0
        while math.sqrt(apart * apart + required * required) < radius:
            required += 1
        for r in range(rows):
            if 0 <= r + apart < rows:
                for c in range(columns):
                    kept[r, c] &= across[r + apart, c] >= required
            elif required > 0:
                kept[r] = False
    return kept
