"""A binary heap of cells that finds each of its cells again, so that keys can be lowered."""

from __future__ import annotations

from multisrt.geometry.numerics.arrays import FloatArray, Int32Array
from multisrt.geometry.numerics.kernel import inlined_kernel, unsigned


@inlined_kernel
def push(
    cells: Int32Array, keys: FloatArray, places: Int32Array, held: int, key: float, cell: int
) -> int:
    """Insert a cell into a heap, or lower the key of a cell that is in it.

    Cells of equal keys are ordered by their numbers, so that the order in which cells leave does
    not depend on the order in which they came.

    Parameters
    ----------
    cells : (c + 1,) array of int32
        Numbers of the cells, the one with the lowest key at index 1; changed in place.
    keys : (c + 1,) array
        Keys of the cells; changed in place. Key 0 is that of all cells that are not in the heap:
        ``inf`` where the caller compares with it.
    places : (n,) array of int32
        Index in the heap for each cell, by its number; 0 if it is not in the heap. Changed in
        place.
    held : int
        Number of cells in the heap.
    key : float
        Key of the cell, lower than the one it may have.
    cell : int
        Number of the cell.

    Returns
    -------
    int
        Number of cells in the heap now.
    """
    one, new = unsigned(1), unsigned(cell)
    i = unsigned(places[new])
    if i == 0:
        held += 1
        i = unsigned(held)
    while i > 1:
        parent = i >> one
        above = unsigned(cells[parent])
        if keys[parent] <= key and (keys[parent] < key or above < new):
            break
        cells[i], keys[i], places[above] = above, keys[parent], i
        i = parent
    cells[i], keys[i], places[new] = new, key, i
    return held


@inlined_kernel
def drop_first(cells: Int32Array, keys: FloatArray, places: Int32Array, held: int) -> int:
    """Remove the cell with the lowest key from a heap.

    Parameters
    ----------
    cells, keys, places : arrays
        The heap, as for `push`. The place of the removed cell is left for the caller to set.
    held : int
        Number of cells in it, at least 1.

    Returns
    -------
    int
        Number of cells in the heap now.
    """
    # The hole at the top moves down to the bottom along the smaller children, without a branch
    # that is hard to predict. The last cell, one with a high key, then is close to its place.
    one, last, key = unsigned(1), unsigned(cells[held]), keys[held]
    held -= 1
    i, child, bottom = unsigned(1), unsigned(2), unsigned(held)
    while child < bottom:
        left, right = keys[child], keys[child + one]
        if left == right:
            child += one if cells[child + one] < cells[child] else unsigned(0)
        else:
            child += one if right < left else unsigned(0)
        below = unsigned(cells[child])
        cells[i], keys[i], places[below] = below, keys[child], i
        i, child = child, child + child
    if child == bottom:
        below = unsigned(cells[child])
        cells[i], keys[i], places[below] = below, keys[child], i
        i = child
    if held > 0:
        places[last] = i
        push(cells, keys, places, held, key, last)
    return held
