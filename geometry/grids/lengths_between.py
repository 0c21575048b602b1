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

UNKNOWN: Final = np.iinfo(np.int32).max
"""Value of a block that no wave has reached."""

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
    unknown, width = _blocks(passable)
    blocks = _block_numbers(indices, width)
    count = blocks.shape[0]
    lengths = np.zeros((count, count))
    waiting = np.empty((BUCKETS, unknown.size), np.int32)
    values, is_asked = np.empty(unknown.size, np.int32), np.zeros(unknown.size, np.bool_)
    for k in range(count - 1):
        values[:] = unknown
        _wave(width, blocks[k], blocks[k + 1 :], waiting, values, is_asked)
        for j in range(k + 1, count):
            lengths[k, j] = lengths[j, k] = _length(values[blocks[j]])
    return lengths


@kernel
def _length(value: int) -> float:
    return value * BLOCK_CELLS / UNITS if 0 <= value < UNKNOWN else np.inf


@kernel
def _block_numbers(indices: IntArray, width: int) -> IntArray:
    numbers: IntArray = (
        (indices[:, 0] // BLOCK_CELLS + 1) * width + indices[:, 1] // BLOCK_CELLS + 1
    )
    return numbers


@kernel
def _blocks(passable: BoolArray) -> tuple[Int32Array, int]:
    # The values of blocks before a wave, row by row: UNKNOWN if they hold a passable cell, and -1,
    # so that no wave enters them, otherwise and on a rim of one block. Returns their columns, too.
    rows, columns = passable.shape
    height, width = -(-rows // BLOCK_CELLS) + 2, -(-columns // BLOCK_CELLS) + 2
    values = np.full(height * width, -1, np.int32)
    for r in range(rows):
        below = (r // BLOCK_CELLS + 1) * width + 1
        for c in range(columns):
            if passable[r, c]:
                values[below + c // BLOCK_CELLS] = UNKNOWN
    return values, width


@kernel
def _wave(
    width: int,
    source: int,
    asked: IntArray,
    waiting: Int32Array,
    values: Int32Array,
    is_asked: BoolArray,
) -> None:
    # Write the lengths from a block to all that are reached before all those asked for are final,
    # into their values before the wave. A bucket takes a block once for each value, so it has room
    # for all blocks.
    left = 0
    for block in asked:
        if not is_asked[block]:
            is_asked[block] = True
            left += 1
    sizes = np.zeros(BUCKETS, np.int64)
    values[source] = 0
    waiting[0, 0], sizes[0] = source, 1
    value = empty = 0
    while left and empty < BUCKETS:
        bucket = value % BUCKETS
        empty = 0 if sizes[bucket] else empty + 1
        straight, diagonal = (value + STRAIGHT) % BUCKETS, (value + DIAGONAL) % BUCKETS
        for k in range(sizes[bucket]):
            block = waiting[bucket, k]
            if values[block] != value:
                continue
            if is_asked[block]:
                is_asked[block] = False
                left -= 1
            for other in (block - 1, block + 1, block - width, block + width):
                if value + STRAIGHT < values[other]:
                    values[other] = value + STRAIGHT
                    waiting[straight, sizes[straight]] = other
                    sizes[straight] += 1
            for other in (
                block - width - 1,
                block - width + 1,
                block + width - 1,
                block + width + 1,
            ):
                if value + DIAGONAL < values[other]:
                    values[other] = value + DIAGONAL
                    waiting[diagonal, sizes[diagonal]] = other
                    sizes[diagonal] += 1
        sizes[bucket] = 0
        value += 1
    is_asked[asked] = False
