"""Kernels that lead from cells of a grid to a march on a window of it, and back."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from multisrt.geometry.grids.fast_march import ACCEPTED, ASKED, EXACT_CELLS, RIM, March, advance
from multisrt.geometry.grids.raster import Corners
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, Int32Array, IntArray
from multisrt.geometry.numerics.kernel import inlined_kernel, kernel

MARGIN_CELLS: Final = 8
"""Distance in rows and columns that a window adds to the room for paths."""

DETOUR: Final = 1.25
"""Windows have room for paths that are longer than the straight lines by this factor."""


@kernel
def lay_out(part: BoolArray, rim: tuple[bool, bool, bool, bool], march: March) -> None:
    """Write the arrays of a march that has not begun.

    Parameters
    ----------
    part : (rows, columns) array of bool
        The grid in the window.
    rim : tuple of bool
        Whether the grid continues behind the first row, the last, the first column and the last.
    march : March
        Arrays for the window with a border of two cells, changed in place: states, marks and places
        are 0, the others may have any content.
    """
    rows, columns = part.shape
    march.keys[0] = np.inf
    march.distance[:] = np.inf
    for r in range(rows):
        begin = (r + 2) * march.width + 2
        state = march.state[begin : begin + columns]
        for c in range(columns):
            state[c] = part[r, c]
        if (r == 0 and rim[0]) or (r == rows - 1 and rim[1]):
            march.marks[begin : begin + columns] = RIM
        if rim[2]:
            march.marks[begin] = RIM
        if rim[3]:
            march.marks[begin + columns - 1] = RIM


@kernel
def move(
    old: March, new: March, held: int, count: int, below: int, left: int, seeds: Int32Array
) -> None:
    """Move a march into arrays for a larger window.

    Parameters
    ----------
    old, new : March
        The march, and the arrays as `lay_out` has written them, changed in place.
    held, count : int
        Number of cells on the front, and of those accepted.
    below, left : int
        Number of rows that the larger window has more below, and of columns to the left.
    seeds : (s,) array of int32
        Numbers of cells, changed in place to those that they have in the larger window.
    """
    across, width = old.width, new.width
    for r in range(2, len(old.state) // across - 2):
        here, there = r * across + 2, (r + below) * width + left + 2
        columns = across - 4
        new.state[there : there + columns] = old.state[here : here + columns]
    for i in range(count):
        u = new.order[i] = _moved(old.order[i], across, width, below, left)
        new.places[u], new.distance[u] = i, old.distance[old.order[i]]
    for i in range(1, held + 1):
        u = new.cells[i] = _moved(old.cells[i], across, width, below, left)
        new.places[u], new.keys[i] = i, old.keys[i]
    for i in range(len(seeds)):
        seeds[i] = _moved(seeds[i], across, width, below, left)


@inlined_kernel
def _moved(cell: int, across: int, width: int, below: int, left: int) -> int:
    return (cell // across + below) * width + cell % across + left


@kernel
def numbers_of(cells: IntArray, window: Corners, width: int) -> IntArray:
    """Return the numbers of cells in a window of the grid with its border.

    Parameters
    ----------
    cells : (n, 2) array
        Their rows and columns in the grid.
    window : (r0, r1, c0, c1)
        The window has rows r0 to r1 - 1 and columns c0 to c1 - 1.
    width : int
        Columns of the window with its border.

    Returns
    -------
    (n,) array
        0, which is a cell of the border, for those outside of the window.
    """
    numbers = np.empty(cells.shape[0], np.int64)
    for i in range(cells.shape[0]):
        numbers[i] = _number(cells, i, window, width)
    return numbers


@kernel
def cells_of(numbers: IntArray, window: Corners, width: int) -> IntArray:
    """Return the rows and columns in the grid of cells in a window, ``(n, 2)``.

    It is the inverse of `numbers_of`, whose parameters these are.
    """
    cells = np.empty((numbers.shape[0], 2), np.int64)
    for i in range(numbers.shape[0]):
        cells[i, 0] = numbers[i] // width - 2 + window[0]
        cells[i, 1] = numbers[i] % width - 2 + window[2]
    return cells


@inlined_kernel
def _number(cells: IntArray, i: int, window: Corners, width: int) -> int:
    row, column = cells[i, 0], cells[i, 1]
    number = 0
    if window[0] <= row < window[1] and window[2] <= column < window[3]:
        number = (row - window[0] + 2) * width + column - window[2] + 2
    return number


@kernel
def first_outside(cells: IntArray, rows: int, columns: int) -> int:
    """Return the index of the first cell that is not in a grid, -1 if all are.

    Parameters
    ----------
    cells : (n, 2) array
        Rows and columns.
    rows, columns : int
        Shape of the grid.
    """
    for i in range(cells.shape[0]):
        if not (0 <= cells[i, 0] < rows and 0 <= cells[i, 1] < columns):
            return i
    return -1


@kernel
def window_around(
    cells: IntArray, passable: BoolArray, starts: FloatArray, farthest: bool
) -> Corners:
    """Return a window around the sources that has room for paths to some cells.

    Parameters
    ----------
    cells : (n, 2) array
        Rows and columns; those that are not passable are ignored.
    passable : (rows, columns) array of bool
        The grid.
    starts : (k, 2) array
        Sources x, y in widths of a cell from the grid's corner; the nearest one counts.
    farthest : bool
        Whether there is room for paths to all of the cells or to the nearest one, unless they are
        longer than the straight lines by a factor above `DETOUR`.

    Returns
    -------
    (r0, r1, c0, c1)
        Rows r0 to r1 - 1 and columns c0 to c1 - 1 of the grid.
    """
    reach, found = 0.0, False
    for i in range(cells.shape[0]):
        if passable[cells[i, 0], cells[i, 1]]:
            away = np.inf
            for k in range(starts.shape[0]):
                x, y = cells[i, 1] + 0.5 - starts[k, 0], cells[i, 0] + 0.5 - starts[k, 1]
                away = min(away, math.hypot(x, y))
            if not found or (away > reach if farthest else away < reach):
                reach, found = away, True
    more = max(EXACT_CELLS, math.ceil(DETOUR * reach)) + MARGIN_CELLS
    rows, columns = passable.shape
    r0, r1, c0, c1 = rows, 0, columns, 0
    for k in range(starts.shape[0]):
        row, column = int(starts[k, 1]), int(starts[k, 0])
        r0, r1 = min(r0, row - more), max(r1, row + more + 1)
        c0, c1 = min(c0, column - more), max(c1, column + more + 1)
    return max(0, r0), min(rows, r1), max(0, c0), min(columns, c1)


@kernel
def cropped(window: Corners, passable: BoolArray) -> Corners:
    """Return the part of a window that holds its passable cells and one more cell on each side.

    Parameters
    ----------
    window : (r0, r1, c0, c1)
        The window.
    passable : (rows, columns) array of bool
        The grid.

    Returns
    -------
    (r0, r1, c0, c1)
        Paths within the window are within this part, too, and reach its rim only where they reach
        that of the window. It is the window if none of its cells is passable.
    """
    r0, r1, c0, c1 = window
    while r0 < r1 and not passable[r0, c0:c1].any():
        r0 += 1
    if r0 == r1:
        return window
    while not passable[r1 - 1, c0:c1].any():
        r1 -= 1
    left, right = c1, c0
    for r in range(r0, r1):
        row = passable[r]
        for c in range(c0, left):
            if row[c]:
                left = c
                break
        for c in range(c1 - 1, right - 1, -1):
            if row[c]:
                right = c + 1
                break
    return max(window[0], r0 - 1), min(window[1], r1 + 1), max(c0, left - 1), min(c1, right + 1)


@kernel
def march_to(
    march: March,
    held: int,
    count: int,
    passable: BoolArray,
    window: Corners,
    cells: IntArray,
    farthest: bool,
    limit: float,
) -> tuple[int, int, bool]:
    """March until the first or the last of some cells is accepted.

    Parameters
    ----------
    march : March
        The march, changed in place.
    held, count : int
        Number of cells on the front, and of those accepted.
    passable : (rows, columns) array of bool
        The grid.
    window : (r0, r1, c0, c1)
        Rows and columns of the grid on which the march works.
    cells : (k, 2) array
        Rows and columns of the cells in the grid; those that are not passable are ignored.
    farthest : bool
        Whether to march to the last of them.
    limit : float
        Highest value to accept, in widths of a cell.

    Returns
    -------
    held, count : int
        Number of cells on the front now, and of those accepted.
    is_too_small : bool
        Whether the march has to continue in a larger window.
    """
    missing = final = 0
    for i in range(cells.shape[0]):
        if passable[cells[i, 0], cells[i, 1]]:
            u = _number(cells, i, window, march.width)
            if march.state[u] == ACCEPTED:
                final += 1
            elif u == 0:
                missing += 1
            elif not march.marks[u] & ASKED:
                march.marks[u] |= ASKED
                missing += 1
    is_too_small = False
    if missing and (farthest or not final):
        remaining = missing if farthest else 1
        held, count, is_too_small = advance(march, held, count, remaining, limit)
    for i in range(cells.shape[0]):
        march.marks[_number(cells, i, window, march.width)] &= RIM
    return held, count, is_too_small


@kernel
def first_accepted(march: March, window: Corners, cells: IntArray) -> tuple[int, float]:
    """Return which of some cells was accepted first.

    Parameters
    ----------
    march : March
        The march.
    window : (r0, r1, c0, c1)
        Rows and columns of the grid on which the march works.
    cells : (k, 2) array
        Rows and columns of the cells in the grid.

    Returns
    -------
    index : int
        Index of the cell in `cells`, -1 if none is accepted.
    value : float
        Its value in widths of a cell.
    """
    first, rank, value = -1, 0, np.inf
    for i in range(cells.shape[0]):
        u = _number(cells, i, window, march.width)
        if march.state[u] == ACCEPTED and (first < 0 or march.places[u] < rank):
            first, rank, value = i, march.places[u], march.distance[u]
    return first, value


@kernel
def values_of(march: March, window: Corners, cells: IntArray) -> FloatArray:
    """Return the values of cells in widths of a cell, ``inf`` where they are not accepted.

    The parameters are those of `first_accepted`.
    """
    values = np.empty(cells.shape[0])
    for i in range(cells.shape[0]):
        values[i] = march.distance[_number(cells, i, window, march.width)]
    return values
