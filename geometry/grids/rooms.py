"""Rooms on a grid: parts of its free cells that doorways separate."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from multisrt.geometry.grids.occupancy import FREE, OCCUPIED
from multisrt.geometry.numerics.arrays import BoolArray, ByteArray, Int32Array, IntArray
from multisrt.geometry.numerics.kernel import kernel


class Room(NamedTuple):
    """A part of the free cells that doorways separate from the others.

    Attributes
    ----------
    cells : (rows, columns) array of bool
        Its cells, with its share of each doorway.
    inner : (rows, columns) array of bool
        Those of its cells that are in no doorway.
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
        Width of the widest doorway, in widths of a cell.

    Returns
    -------
    Room or None
        None if the cell is not free, or no such part is reached from it; see Notes.

    Notes
    -----
    The free cells farther than ``doorway_cells / 2`` from every occupied cell fall into parts that
    are connected across the sides of cells. Parts of fewer than ``doorway_cells**2 / 2`` cells are
    left out. Every other free cell belongs to the part from which it is reached first over free
    cells. One of these is in a doorway if the line from the occupied cell nearest to it, through
    the cell, meets another occupied cell within the width of a doorway and one cell more, as there
    is half a cell on either side.

    Examples
    --------
    Two rooms of 9 by 9 cells with a doorway of 3 between them:

    >>> states = np.full((11, 21), OCCUPIED, np.uint8)
    >>> states[1:10, 1:10] = states[1:10, 11:20] = states[4:7, 10] = FREE
    >>> room = room_around(states, 2, 3, doorway_cells=5.0)
    >>> int(room.cells.sum()), int(room.inner.sum())
    (84, 81)
    """
    free, is_clear = states == FREE, states != OCCUPIED
    if not free[row, column]:
        return None
    # A quotient such as 1.4 / 0.1 is a little less than 14.
    doorway_cells = round(doorway_cells, 6)
    gaps, nearest = ndimage.distance_transform_edt(is_clear, return_indices=True)
    is_wide = (gaps > 0.5 * doorway_cells) | is_clear.all()  # there is no distance to nothing
    labels, count = ndimage.label(free & is_wide)
    is_small = np.bincount(labels.ravel(), minlength=count + 1) < 0.5 * doorway_cells**2
    parts: Int32Array = np.where(is_small[labels], 0, labels).astype(np.int32)
    is_doorway = _doorways(is_clear, free & ~is_wide, nearest, doorway_cells + 1.0)
    whole = _spread(free, parts)
    own = whole[row, column]
    return Room(whole == own, (whole == own) & ~is_doorway) if own else None


@kernel
def _doorways(
    is_clear: BoolArray, is_narrow: BoolArray, nearest: Int32Array, width_cells: float
) -> BoolArray:
    # Whether the line from the occupied cell nearest to a narrow cell, through that, meets another
    # occupied cell at most this far from the first one.
    rows, columns = is_narrow.shape
    found = np.zeros(is_narrow.shape, np.bool_)
    for r in range(rows):
        for c in range(columns):
            if not is_narrow[r, c]:
                continue
            below, right = r - nearest[0, r, c], c - nearest[1, r, c]
            gap = math.hypot(below, right)
            for step in range(math.ceil(gap), math.floor(width_cells) + 1):
                i = nearest[0, r, c] + round(step * below / gap)
                j = nearest[1, r, c] + round(step * right / gap)
                if i < 0 or j < 0 or i >= rows or j >= columns:
                    break
                if not is_clear[i, j]:
                    found[r, c] = True
                    break
    return found


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
