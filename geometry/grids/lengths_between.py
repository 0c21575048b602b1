"""Lengths of paths between many cells of a grid, by waves over blocks of cells."""

from __future__ import annotations

from typing import Final

import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, Int32Array, IntArray
from multisrt.geometry.numerics.kernel import kernel

BLOCK_CELLS: Final = 3
"""Width of a block in cells: waves run over a ninth of the cells."""

STRAIGHT: Final = 5
DIAGONAL: Final = 7
UNITS: Final = 5.2
"""Lengths of the steps between blocks, and units in a block's width.

With 5 units in a block's width, paths along rows would be exact and those halfway to the diagonal
8 % too long; with 5.2, lengths are between 5 % too short and 4 % too long.
"""

BUCKETS: Final = 8
"""One more than the longest step: values of the blocks that wait differ by less."""


@kernel
def lengths_between(passable: BoolArray, indices: IntArray) -> FloatArray:
    """Return the approximate lengths of the shortest paths between cells.

    Waves run over blocks of `BLOCK_CELLS` by `BLOCK_CELLS` cells, each of which is passable if one
    of its cells is. So no path is missed, but one may lead through what separates two passable
    cells that are in one block, or in blocks side by side.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Where paths may run.
    indices : (m, 2) array of int
        Rows and columns of the cells.

    Returns
    -------
    (m, m) array
        Lengths in widths of a cell; ``inf`` where there is no path.

    Notes
    -----
    Cost: O(m b) for b blocks of the grid; pass the part of a grid that matters.

    Source: G. Borgefors, Distance transformations in digital images, CVGIP 34 (1986), the steps;
    R. B. Dial, Algorithm 360, CACM 12 (1969), the buckets.

    Examples
    --------
    >>> lengths = lengths_between(np.ones((30, 30), np.bool_), np.array([[0, 0], [0, 27]]))
    >>> bool(abs(lengths[0, 1] - 27.0) < 1.5)
    True
    """
    free = _blocks(passable)
    columns = free.shape[1]
    blocks = (indices[:, 0] // BLOCK_CELLS) * columns + indices[:, 1] // BLOCK_CELLS
    count = blocks.shape[0]
    lengths = np.zeros((count, count))
    waiting = np.empty((BUCKETS, free.size), np.int32)
    values, is_asked = np.empty(free.size, np.int32), np.zeros(free.size, np.bool_)
    for k in range(count - 1):
        _wave(free, blocks[k], blocks[k + 1 :], waiting, values, is_asked)
        for j in range(k + 1, count):
            value = values[blocks[j]]
            length = np.inf if value < 0 else value * BLOCK_CELLS / UNITS
            lengths[k, j] = lengths[j, k] = length
    return lengths


@kernel
def _blocks(passable: BoolArray) -> BoolArray:
    # Which blocks hold a passable cell; with a rim of blocks that do not, behind the last ones.
    rows, columns = passable.shape
    free = np.zeros((rows // BLOCK_CELLS + 2, columns // BLOCK_CELLS + 2), np.bool_)
    for r in range(rows):
        for c in range(columns):
            if passable[r, c]:
                free[r // BLOCK_CELLS, c // BLOCK_CELLS] = True
    return free


@kernel
def _wave(
    free: BoolArray,
    source: int,
    asked: IntArray,
    waiting: Int32Array,
    known: Int32Array,
    is_asked: BoolArray,
) -> None:
    # Write the lengths from a block to all that are reached before all those asked for are final;
    # -1 where none is known. A bucket takes a block once for each value, so it has room for all
    # blocks.
    columns = free.shape[1]
    known[:] = -1
    is_asked[:] = False
    left = 0
    for block in asked:
        if not is_asked[block]:
            is_asked[block] = True
            left += 1
    sizes = np.zeros(BUCKETS, np.int64)
    known[source] = 0
    waiting[0, 0], sizes[0] = source, 1
    value = empty = 0
    while left and empty < BUCKETS:
        bucket = value % BUCKETS
        empty = 0 if sizes[bucket] else empty + 1
        for k in range(sizes[bucket]):
            block = waiting[bucket, k]
            if known[block] != value:
                continue
            if is_asked[block]:
                is_asked[block] = False
                left -= 1
            row, column = block // columns, block % columns
            for down in range(-1, 2):
                for right in range(-1, 2):
                    r, c = row + down, column + right
                    if r < 0 or c < 0 or not free[r, c]:
                        continue
                    step = DIAGONAL if down != 0 and right != 0 else STRAIGHT
                    other, longer = r * columns + c, value + step
                    if known[other] < 0 or longer < known[other]:
                        known[other] = longer
                        at = longer % BUCKETS
                        waiting[at, sizes[at]] = other
                        sizes[at] += 1
        sizes[bucket] = 0
        value += 1
