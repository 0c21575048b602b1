"""A raster of painted polygons: exact at cell centres, growing as far as needed."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.polygon_fill import paint_polygon
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.geometry.numerics.boxes import all_below, bounds_of
from multisrt.geometry.numerics.kernel import kernel

MAX_CELLS = 400_000_000
"""Maximum size of a raster in bytes, which for one byte per cell is its number of cells."""

MAX_CELL_INDEX = 2.0**52
"""Maximum distance from the origin, in cells, at which floats distinguish neighbouring cells."""

MAX_SPARE = 512
"""Maximum number of columns, and of rows, by which a window grows beyond what it has to hold."""

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

    It grows by at least half its size, up to `MAX_SPARE` cells, so that growing costs little over
    a whole run, and a large window is not mostly empty.

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
        spare_x, spare_y = min(columns // 2, MAX_SPARE), min(rows // 2, MAX_SPARE)
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
