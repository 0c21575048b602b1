"""Area that a range finder would show for the first time, were all unknown cells free."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from multisrt.geometry.grids.occupancy import OCCUPIED, UNKNOWN
from multisrt.geometry.numerics.arrays import ByteArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel

RAYS: Final = 120
"""Number of rays: one for every 3 degrees."""


@kernel
def unknown_areas(states: ByteArray, indices: IntArray, range_cells: float) -> FloatArray:
    """Return the unknown area in sight of cells, where unknown cells hide nothing.

    Rays from the centre of a cell are followed cell width by cell width up to the first occupied
    cell or the range; each piece whose middle is in an unknown cell counts by the area of its
    sector. Beyond the grid all is unknown.

    Parameters
    ----------
    states : (rows, columns) array of uint8
        States of an `Occupancy`.
    indices : (m, 2) array of int
        Rows and columns of the cells.
    range_cells : float
        Range of the range finder in widths of a cell.

    Returns
    -------
    (m,) array
        Areas in cells.

    Examples
    --------
    In the middle of an unknown world it is the disc of the range finder:

    >>> states = np.zeros((3, 3), np.uint8)
    >>> (area,) = unknown_areas(states, np.array([[1, 1]]), 40.0)
    >>> bool(abs(area / (np.pi * 40.0**2) - 1.0) < 1e-9)
    True
    """
    rows, columns = states.shape
    angle = 2.0 * math.pi / RAYS
    steps = math.ceil(range_cells)
    areas = np.zeros(indices.shape[0])
    for k in range(indices.shape[0]):
        y, x = indices[k, 0] + 0.5, indices[k, 1] + 0.5
        squares = 0.0  # the sum of the differences of squared radii
        for ray in range(RAYS):
            dx, dy = math.cos(ray * angle), math.sin(ray * angle)
            for step in range(steps):
                begin, end = float(step), min(step + 1.0, range_cells)
                middle = 0.5 * (begin + end)
                row, column = math.floor(y + middle * dy), math.floor(x + middle * dx)
                if row < 0 or column < 0 or row >= rows or column >= columns:
                    squares += end * end - begin * begin
                    continue
                state = states[row, column]
                if state == OCCUPIED:
                    break
                if state == UNKNOWN:
                    squares += end * end - begin * begin
        areas[k] = 0.5 * angle * squares
    return areas
