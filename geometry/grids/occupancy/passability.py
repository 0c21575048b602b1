"""Kernels that look for passable and frontier cells around a place, and block some for a while."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.grids.occupancy.layers import FRONTIER, Layers
from multisrt.geometry.grids.raster import OFFSET_X, OFFSET_Y
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel


@kernel
def block_discs(discs: FloatArray, layers: Layers) -> IntArray:
    """Clear the passable cells whose centres lie within some discs, in place.

    Parameters
    ----------
    discs : (k, 3) array
        Centres x, y and radii in metres, borders included; a negative radius blocks nothing.
    layers : Layers
        The window.

    Returns
    -------
    (n,) array of int
        Flat indices of the cells that have been cleared.
    """
    cell, passable = layers.cell_m, layers.passable
    row, column = layers.row, layers.column
    rows, columns = passable.shape
    shift_x, shift_y = OFFSET_X * cell, OFFSET_Y * cell
    spans = np.empty((discs.shape[0], 4), np.int64)
    capacity = 0
    for k in range(discs.shape[0]):
        x, y, radius = discs[k, 0], discs[k, 1], discs[k, 2]
        spans[k, 0] = max(0, int(np.floor((y - radius) / cell + OFFSET_Y - 0.5)) - row)
        spans[k, 1] = min(rows, int(np.ceil((y + radius) / cell + OFFSET_Y - 0.5)) + 1 - row)
        spans[k, 2] = max(0, int(np.floor((x - radius) / cell + OFFSET_X - 0.5)) - column)
        spans[k, 3] = min(columns, int(np.ceil((x + radius) / cell + OFFSET_X - 0.5)) + 1 - column)
        capacity += max(0, spans[k, 1] - spans[k, 0]) * max(0, spans[k, 3] - spans[k, 2])
    cleared = np.empty(capacity, np.int64)
    count = 0
    for k in range(discs.shape[0]):
        x, y, radius = discs[k, 0], discs[k, 1], discs[k, 2]
        for r in range(spans[k, 0], spans[k, 1]):
            dy = (r + row + 0.5) * cell - shift_y - y
            for c in range(spans[k, 2], spans[k, 3]):
                dx = (c + column + 0.5) * cell - shift_x - x
                if passable[r, c] and radius >= 0.0 and dx * dx + dy * dy <= radius * radius:
                    passable[r, c] = False
                    cleared[count] = r * columns + c
                    count += 1
    return cleared[:count].copy()


@kernel
def nearest_passable(x: float, y: float, within_cells: int, layers: Layers) -> int:
    """Return the passable cell whose centre is nearest to a place, as a flat index.

    Parameters
    ----------
    x, y : float
        The place in metres.
    within_cells : int
        Maximum distance in rows and in columns from the cell that holds the place.
    layers : Layers
        The window.

    Returns
    -------
    int
        Of equally near cells the first in row-major order; -1 if there is none.
    """
    cell, passable = layers.cell_m, layers.passable
    row, column = layers.row, layers.column
    rows, columns = passable.shape
    r0 = int(np.floor(y / cell + OFFSET_Y)) - row
    c0 = int(np.floor(x / cell + OFFSET_X)) - column
    shift_x, shift_y = OFFSET_X * cell, OFFSET_Y * cell
    found, nearest2 = -1, np.inf
    for r in range(max(0, r0 - within_cells), min(rows, r0 + within_cells + 1)):
        dy = (r + row + 0.5) * cell - shift_y - y
        for c in range(max(0, c0 - within_cells), min(columns, c0 + within_cells + 1)):
            dx = (c + column + 0.5) * cell - shift_x - x
            if passable[r, c] and dx * dx + dy * dy < nearest2:
                found, nearest2 = r * columns + c, dx * dx + dy * dy
    return found


@kernel
def frontier_is_within(x: float, y: float, radius_m: float, layers: Layers) -> bool:
    """Whether the centre of a frontier cell lies within a radius of a place, border included.

    Parameters
    ----------
    x, y : float
        The place in metres.
    radius_m : float
        The radius in metres.
    layers : Layers
        The window.
    """
    cell, marks = layers.cell_m, layers.marks
    row, column = layers.row, layers.column
    rows, columns = marks.shape
    shift_x, shift_y = OFFSET_X * cell, OFFSET_Y * cell
    reach = int(np.ceil(radius_m / cell)) + 1
    r0 = int(np.floor(y / cell + OFFSET_Y)) - row
    c0 = int(np.floor(x / cell + OFFSET_X)) - column
    for r in range(max(0, r0 - reach), min(rows, r0 + reach + 1)):
        dy = (r + row + 0.5) * cell - shift_y - y
        for c in range(max(0, c0 - reach), min(columns, c0 + reach + 1)):
            dx = (c + column + 0.5) * cell - shift_x - x
            if marks[r, c] & FRONTIER and dx * dx + dy * dy <= radius_m * radius_m:
                return True
    return False


@kernel
def indices_at(points: FloatArray, layers: Layers) -> IntArray:
    """Return the rows and columns of the arrays in which points lie, inside or not, ``(k, 2)``.

    Parameters
    ----------
    points : (k, 2) array
        Points x, y in metres.
    layers : Layers
        The window.
    """
    cell = layers.cell_m
    indices = np.empty(points.shape, np.int64)
    for i in range(points.shape[0]):
        indices[i, 0] = int(np.floor(points[i, 1] / cell + OFFSET_Y)) - layers.row
        indices[i, 1] = int(np.floor(points[i, 0] / cell + OFFSET_X)) - layers.column
    return indices
