"""Rooms on a grid: parts of its free cells that doorways divide."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from multisrt.geometry.grids.occupancy import FREE, OCCUPIED
from multisrt.geometry.numerics.arrays import BoolArray, ByteArray, Int32Array, IntArray
from multisrt.geometry.numerics.kernel import kernel


class Room(NamedTuple):
    """A part of the free cells that doorways divide from the others.

    Attributes
    ----------
    cells : (rows, columns) array of bool
        Its cells.
    inner : (rows, columns) array of bool
        Those of its cells that are in no doorway and not near a surface.
    """

    cells: BoolArray
    inner: BoolArray


def room_around(states: ByteArray, row: int, column: int, *, doorway_cells: float) -> Room | None:
    """Return the room that holds a cell.

    Parameters
    ----------
    states : (rows, columns) array of uint8
        States of an `Occupancy`; pass the part of a grid that matters.
    row, column : int
        The cell.
    doorway_cells : float
        Half the width of the widest doorway, in widths of a cell.

    Returns
    -------
    Room or None
        None if the cell is not free, or no wide place is reached from it.

    Notes
    -----
    The free cells farther than `doorway_cells` from every occupied cell fall into parts that are
    connected across the sides of cells. Parts of fewer than ``2 doorway_cells**2`` cells are left
    out. Every other free cell belongs to the part from which it is reached first over free cells.

    Examples
    --------
    Two rooms of 9 by 9 cells with a doorway of 3 between them:

    >>> states = np.full((11, 21), OCCUPIED, np.uint8)
    >>> states[1:10, 1:10] = states[1:10, 11:20] = states[4:7, 10] = FREE
    >>> room = room_around(states, 2, 3, doorway_cells=2.5)
    >>> int(room.cells.sum()), int(room.inner.sum())
    (84, 26)
    """
    free = states == FREE
    if not free[row, column]:
        return None
    is_clear = states != OCCUPIED
    # Without occupied cells scipy has no distances to give.
    gaps = np.inf if is_clear.all() else ndimage.distance_transform_edt(is_clear)
    parts, count = ndimage.label(free & (gaps > doorway_cells))
    is_small = np.bincount(parts.ravel(), minlength=count + 1) < 2.0 * doorway_cells**2
    inner = np.where(is_small[parts], 0, parts).astype(np.int32)
    whole = _spread(free, inner)
    own = whole[row, column]
    return Room(whole == own, inner == own) if own else None


@kernel
def _spread(free: BoolArray, parts: Int32Array) -> Int32Array:
    # Give every free cell the number of the part from which it is reached first over the sides of
    # free cells; 0 if it is reached from none.
    rows, columns = free.shape
    numbers = parts.copy()
    waiting: IntArray = np.empty(free.size, np.int64)
    count = 0
    for r in range(rows):
        for c in range(columns):
            if numbers[r, c]:
                waiting[count] = r * columns + c
                count += 1
    head = 0
    while head < count:
        r, c = divmod(waiting[head], columns)
        head += 1
        for below, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            i, j = r + below, c + right
            inside = 0 <= i < rows and 0 <= j < columns
            if inside and free[i, j] and not numbers[i, j]:
                numbers[i, j] = numbers[r, c]
                waiting[count] = i * columns + j
                count += 1
    return numbers
