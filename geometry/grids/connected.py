"""The cells of a grid that are connected with some of them."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, IntArray
from multisrt.geometry.numerics.kernel import kernel


@kernel
def connected(passable: BoolArray, cells: IntArray) -> BoolArray:
    """Return the cells that passable neighbours connect with one of some cells.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        The grid.
    cells : (k, 2) array of int
        Rows and columns in the grid; those that are not passable are ignored.

    Returns
    -------
    (rows, columns) array of bool
        With these cells themselves. Neighbours share a side.

    Examples
    --------
    >>> passable = np.array([[True, True, False, True]])
    >>> connected(passable, np.array([[0, 1]])).tolist()
    [[True, True, False, False]]
    """
    rows, columns = passable.shape
    found = np.zeros(passable.shape, np.bool_)
    # Cells of runs in a row that are still to be filled, and whose neighbours are to be looked at.
    waiting = np.empty(max(64, len(cells)), np.int64)
    count = 0
    for k in range(len(cells)):
        r, c = cells[k, 0], cells[k, 1]
        if passable[r, c] and not found[r, c]:
            found[r, c] = True
            waiting[count] = r * columns + c
            count += 1
    while count:
        count -= 1
        r, c = divmod(waiting[count], columns)
        begin, end = c, c + 1
        while begin > 0 and passable[r, begin - 1] and not found[r, begin - 1]:
            begin -= 1
            found[r, begin] = True
        while end < columns and passable[r, end] and not found[r, end]:
            found[r, end] = True
            end += 1
        if count + end - begin + 2 > len(waiting):
            more = np.empty(2 * (count + end - begin + 2), np.int64)
            more[:count] = waiting[:count]
            waiting = more
        for beside in (r - 1, r + 1):
            if 0 <= beside < rows:
                is_in_run = False
                for c in range(begin, end):
                    is_new = passable[beside, c] and not found[beside, c]
                    if is_new and not is_in_run:
                        found[beside, c] = True
                        waiting[count] = beside * columns + c
                        count += 1
                    is_in_run = is_new
    return found
