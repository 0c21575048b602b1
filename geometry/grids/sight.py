"""Lines of sight through the cells of a grid."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray
from multisrt.geometry.numerics.kernel import kernel


@kernel
def in_sight(free: BoolArray, x: float, y: float, column: int, row: int) -> bool:
    """Whether the line from a point to the centre of a cell runs through free cells alone.

    Where the line passes from a cell to one that meets it in a corner, both cells beside that
    corner have to be free as well.

    Parameters
    ----------
    free : (rows, columns) array of bool
        The grid.
    x, y : float
        The point in widths of a cell from the grid's corner, inside the grid: cell (r, c) is the
        square ``[c, c + 1) x [r, r + 1)``.
    column, row : int
        The cell, inside the grid.
    """
    c, r = int(x), int(y)
    dx, dy = column + 0.5 - x, row + 0.5 - y
    step_c, step_r = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    next_x = np.inf if dx == 0.0 else (c + (step_c > 0) - x) / dx
    next_y = np.inf if dy == 0.0 else (r + (step_r > 0) - y) / dy
    if not free[r, c]:
        return False
    while c != column or r != row:
        if c != column and r != row and abs(next_x - next_y) < 1e-9:
            if not (free[r, c + step_c] and free[r + step_r, c]):
                return False
            c, r = c + step_c, r + step_r
            next_x, next_y = next_x + abs(1.0 / dx), next_y + abs(1.0 / dy)
        elif r == row or (c != column and next_x < next_y):
            c, next_x = c + step_c, next_x + abs(1.0 / dx)
        else:
            r, next_y = r + step_r, next_y + abs(1.0 / dy)
        if not free[r, c]:
            return False
    return True
