"""A raster of painted polygons: exact at cell centres, growing as far as needed."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.boxes import all_below, bounds_of
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel

MAX_CELLS = 400_000_000
"""A raster never grows beyond this many cells of one byte, or as many fewer as they are larger."""

FARTHEST_CELL = 2.0**52
"""Cells farther from the origin are not told apart."""

OFFSET = 0.3819660112501051
"""Share of a cell by which the lattice is moved.

Walls like to lie on round coordinates; moved by an irrational share of a cell, no cell centre
lies exactly on one, so that no cell depends on how a tie is broken.
"""

Number = TypeVar("Number", bound=np.generic)


class Window(NamedTuple):
    """The part of the lattice that a raster holds: its first cell, and how many there are."""

    row: int
    column: int
    rows: int
    columns: int


class Raster:
    """Cells of free space that have been covered by at least one painted polygon.

    The lattice is fixed by the cell width alone, so that rasters of equal cell width fit
    together whatever window they hold.

    Parameters
    ----------
    cell_m : float
        Width of a cell in metres.
    bounds : (x0, y0, x1, y1), optional
        The window to begin with; polygons outside make it grow.

    Attributes
    ----------
    cell_m : float
        Width of a cell.
    column, row : int
        Lattice indices of the first column and row of the window.
    cells : (rows, columns) array of bool
        Whether a cell's centre has been painted; row 0 is the lowest y.
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
        """Left border of the window."""
        return (self.column - OFFSET) * self.cell_m

    @property
    def y0(self) -> float:
        """Lower border of the window."""
        return (self.row - OFFSET) * self.cell_m

    def paint(self, boundary: FloatArray) -> int:
        """Mark the cells whose centre lies in a polygon.

        Parameters
        ----------
        boundary : (n, 2) array
            Corners of a polygon; it closes by itself.

        Returns
        -------
        int
            How many of them were not marked before.

        Raises
        ------
        InvalidInputError
            If the raster would grow beyond `MAX_CELLS`, or a corner is not finite.
        """
        refuse_corners(boundary, self.cell_m)
        self._cover(bounds_of(boundary))
        return paint_polygon(boundary, self.x0, self.y0, self.cell_m, self.cells)

    def paint_inside(self, boundary: FloatArray) -> int:
        """Mark cells as `paint` does, but only those in the window, which stays as it is."""
        refuse_corners(boundary, self.cell_m)
        return paint_polygon(boundary, self.x0, self.y0, self.cell_m, self.cells)

    def centres(self) -> tuple[FloatArray, FloatArray]:
        """Give the x of every column's and the y of every row's cell centres."""
        rows, columns = self.cells.shape
        return (
            self.x0 + (np.arange(columns, dtype=np.float64) + 0.5) * self.cell_m,
            self.y0 + (np.arange(rows, dtype=np.float64) + 0.5) * self.cell_m,
        )

    def area_m2(self) -> float:
        """Area of all painted cells."""
        return float(np.count_nonzero(self.cells)) * self.cell_m**2

    def _cover(self, bounds: tuple[float, float, float, float]) -> None:
        held = Window(self.row, self.column, *self.cells.shape)
        window = window_over(bounds, self.cell_m, held)
        if window != held:
            self.cells = moved(self.cells, held, window)
            self.row, self.column = window.row, window.column


def refuse_cell_width(cell_m: float) -> None:
    """Raise an `InvalidInputError` unless a cell's width is positive and finite."""
    if not 0.0 < cell_m < math.inf:
        raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")


def refuse_corners(boundary: FloatArray, cell_m: float) -> None:
    """Raise an `InvalidInputError` for corners in no cell that has a number."""
    if not all_below(boundary, FARTHEST_CELL * cell_m):
        raise InvalidInputError(
            f"the corners of a polygon are finite numbers of metres, with cells of {cell_m:g} m "
            f"below {FARTHEST_CELL * cell_m:g}"
        )


def window_over(
    bounds: tuple[float, float, float, float], cell_m: float, held: Window, cell_bytes: int = 1
) -> Window:
    """Give the window that holds some bounds and all that is held already.

    It grows by a half at least, so that growing costs little over a whole run.

    Parameters
    ----------
    bounds : (x0, y0, x1, y1)
        What to hold, in metres.
    cell_m : float
        Width of a cell.
    held : Window
        What is held, with no rows at the very beginning.
    cell_bytes : int
        How much memory a cell takes.

    Raises
    ------
    InvalidInputError
        If it would have more than `MAX_CELLS` / `cell_bytes` cells.
    """
    first_column = math.floor(bounds[0] / cell_m + OFFSET)
    first_row = math.floor(bounds[1] / cell_m + OFFSET)
    last_column = math.floor(bounds[2] / cell_m + OFFSET)
    last_row = math.floor(bounds[3] / cell_m + OFFSET)
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
    """Copy one value per cell of a held window into a larger one, which is zero elsewhere."""
    larger = np.zeros((window.rows, window.columns), layer.dtype)
    below, left = held.row - window.row, held.column - window.column
    larger[below : below + held.rows, left : left + held.columns] = layer
    return larger


@kernel
def paint_polygon(
    boundary: FloatArray, x0: float, y0: float, cell: float, cells: NDArray[np.bool_]
) -> int:
    """Mark the cells whose centre lies inside a polygon, by the even-odd rule, row by row.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the polygon.
    x0, y0, cell : float
        Lower left corner of the grid and width of its cells.
    cells : (rows, columns) array of bool
        The grid, painted in place.

    Returns
    -------
    int
        How many cells were not marked before.
    """
    new = 0
    for row, begin, end in runs_inside(boundary, x0, y0, cell, *cells.shape):
        # A slice: so there is no branch for each cell.
        run = cells[row, begin:end]
        for i in range(run.shape[0]):
            new += not run[i]
        run[:] = True
    return new


@kernel
def runs_inside(
    boundary: FloatArray, x0: float, y0: float, cell: float, rows: int, columns: int
) -> NDArray[np.int32]:
    """Find the cells that `paint_polygon` marks.

    Parameters
    ----------
    boundary, x0, y0, cell
        As it takes them.
    rows, columns : int
        How many the grid has.

    Returns
    -------
    (k, 3) array
        Runs of cells: row, first column, column after the last.
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
        Corners of the polygon.
    y0, cell : float
        Lower border of row 0 and height of a row.
    lowest_row, highest_row : int
        The rows that matter.

    Returns
    -------
    first_row : int
        The first of the rows that matter and may cross.
    starts : (k + 1,) array
        For k rows from there on, where its crossings begin and those of the one before end.
    crossings : array
        Their x, in ascending order in each row, an even number of them.
    """
    n = boundary.shape[0]
    bottom = top = boundary[0, 1]
    for i in range(n):
        bottom, top = min(bottom, boundary[i, 1]), max(top, boundary[i, 1])
    first_row = max(lowest_row, int(np.ceil((bottom - y0) / cell - 0.5)))
    last_row = min(highest_row, int(np.floor((top - y0) / cell - 0.5)))
    height = max(0, last_row - first_row + 1)
    # Count, then write in compressed rows.
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
        The set; outside the array lies none of it.
    radius : float
        Of the disc, in widths of a cell, below 255.

    Returns
    -------
    (rows, columns) array of bool
        The cells whose centres lie at least so far from that of every cell not in the set.
    """
    rows, columns = cells.shape
    reach = math.ceil(radius)
    # Of each cell the distance within its row to the nearest cell that is not in the set.
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
    left = cells.copy()
    for apart in range(-reach, reach + 1):
        # In a row so far apart the nearest cell that is not in the set is at least this far.
        least = 0
        while math.sqrt(apart * apart + least * least) < radius:
            least += 1
        for r in range(rows):
            if 0 <= r + apart < rows:
                for c in range(columns):
                    left[r, c] &= across[r + apart, c] >= least
            elif least > 0:
                left[r] = False
    return left
