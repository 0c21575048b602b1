"""Checks of what a field on a grid is made from and asked for."""

from __future__ import annotations

import itertools
import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.march_cells import first_outside
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray

ROUNDING: Final = 1e-9
"""Distance from a border of cells at which a point is on it, in widths of a cell."""


def checked_sources(
    sources: ArrayLike, free: BoolArray, cell_m: float, x0: float, y0: float
) -> FloatArray:
    """Check the sources of a field and convert them to widths of a cell.

    A source on the border of two cells, to 1e-9 of their width, is in the one that is free.

    Parameters
    ----------
    sources : (k, 2) array_like
        Points x, y in metres.
    free : (rows, columns) array of bool
        The grid.
    cell_m : float
        Width of a cell in metres.
    x0, y0 : float
        Lower left corner of the grid in metres.

    Returns
    -------
    (k, 2) array
        The sources x, y from the grid's corner: cell (r, c) is ``[c, c + 1) x [r, r + 1)``.

    Raises
    ------
    InvalidInputError
        If the grid is not two-dimensional or not of bool, the cell not positive, there is no
        source, or one is not in a free cell.
    """
    if free.ndim != 2:
        raise InvalidInputError(f"a grid of free cells has two dimensions, not {free.ndim}")
    if free.dtype != np.bool_:
        raise InvalidInputError(f"a grid of free cells is of bool, not {free.dtype}")
    if not 0.0 < cell_m < math.inf:
        raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")
    points = np.asarray(sources, np.float64)
    if points.ndim != 2 or points.shape[1:] != (2,) or not len(points):
        raise InvalidInputError(f"sources are a (k, 2) array with k > 0, not {points.shape}")
    rows, columns = free.shape
    cells: FloatArray = (points - (x0, y0)) / cell_m
    for k, (column, row) in enumerate(cells.tolist()):
        for x, y in itertools.product(_beside_borders(column), _beside_borders(row)):
            if 0.0 <= x < columns and 0.0 <= y < rows and free[int(y), int(x)]:
                cells[k] = x, y
                break
        else:
            raise InvalidInputError(
                f"source {k} at ({points[k, 0]:g}, {points[k, 1]:g}) is not in a free cell: "
                "move it to one"
            )
    return cells


def _beside_borders(at: float) -> tuple[float, ...]:
    """Return a coordinate and, if it is that of a border, those next to it on both sides."""
    border = math.floor(at + 0.5) if math.isfinite(at) else math.inf
    if not abs(at - border) <= ROUNDING:
        return (at,)
    return at, border, math.nextafter(border, -math.inf)


def checked_cells(cells: ArrayLike, free: BoolArray) -> IntArray:
    """Check the cells that a field is asked for.

    Parameters
    ----------
    cells : (k, 2) array_like of int
        Rows and columns.
    free : (rows, columns) array of bool
        The grid.

    Returns
    -------
    (k, 2) array of int

    Raises
    ------
    InvalidInputError
        If a cell is not in the grid.
    """
    asked = np.ascontiguousarray(cells, np.int64).reshape(-1, 2)
    rows, columns = free.shape
    outside = first_outside(asked, rows, columns)
    if outside >= 0:
        row, column = asked[outside]
        raise InvalidInputError(
            f"the asked cell ({row}, {column}) is not in the grid of {rows} rows and "
            f"{columns} columns"
        )
    return asked
