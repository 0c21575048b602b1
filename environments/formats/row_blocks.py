"""Large grids in blocks of rows: comparisons and counts of a whole grid would need a copy of it."""

from collections.abc import Iterator
from typing import Final

BLOCK_CELLS: Final = 2**18
"""Upper bound of the cells of a block of several rows."""


def row_blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    """Yield slices of the rows of a grid, in order.

    A block has about as many cells whatever the shape of the grid: the fixed cost of a step counts
    once for a block, not once for each of millions of short rows.

    Parameters
    ----------
    shape : (rows, columns)
        Shape of the grid; further axes are ignored.

    Examples
    --------
    >>> list(row_blocks((3, 200_000)))
    [slice(0, 1, None), slice(1, 2, None), slice(2, 3, None)]
    >>> len(list(row_blocks((1_000_000, 1))))
    4
    """
    rows, columns = shape[:2]
    step = max(1, BLOCK_CELLS // max(columns, 1))
    for first in range(0, rows, step):
        yield slice(first, min(first + step, rows))
