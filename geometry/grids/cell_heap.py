"""A binary heap of cells that finds each of its cells again, so that keys can be lowered."""

from __future__ import annotations

from typing import NamedTuple

from multisrt.geometry.numerics.arrays import FloatArray, Int32Array
from multisrt.geometry.numerics.kernel import kernel


class CellHeap(NamedTuple):
    """The arrays of a heap, which begins at index 1.

    Attributes
    ----------
    cells : (c + 1,) array of int32
        Numbers of the cells, the one with the lowest key at index 1.
    keys : (c + 1,) array
        Keys of the cells. Number 0 stands for all cells that are not in the heap: ``inf`` where
        the caller compares with it.
    places : (n,) array of int32
        Index in the heap for each cell, by its number; 0 if it is not in the heap.
    """

    cells: Int32Array
    keys: FloatArray
    places: Int32Array


@kernel
def push(heap: CellHeap, held: int, key: float, cell: int) -> int:
    """Insert a cell into a heap, or lower the key of a cell that is in it.

    Cells of equal keys are ordered by their numbers, so that the order in which cells leave does
    not depend on the order in which they came.

    Parameters
    ----------
    heap : CellHeap
        The heap, changed in place.
    held : int
        Number of cells in it.
    key : float
        Key of the cell, lower than the one it may have.
    cell : int
        Number of the cell.

    Returns
    -------
    int
        Number of cells in the heap now.
    """
    cells, keys, places = heap
    i = int(places[cell])
    if i == 0:
        held += 1
        i = held
    while i > 1:
        parent = i >> 1
        above = cells[parent]
        if keys[parent] <= key and (keys[parent] < key or above < cell):
            break
        cells[i], keys[i], places[above] = above, keys[parent], i
        i = parent
    cells[i], keys[i], places[cell] = cell, key, i
    return held


@kernel
def drop_first(heap: CellHeap, held: int) -> int:
    """Remove the cell with the lowest key from a heap.

    Parameters
    ----------
    heap : CellHeap
        The heap, changed in place. The place of the removed cell is left for the caller to set.
    held : int
        Number of cells in it, at least 1.

    Returns
    -------
    int
        Number of cells in the heap now.
    """
    # The hole at the top moves down to the bottom along the smaller children, without a branch
    # that is hard to predict. The last cell, one with a high key, then is close to its place.
    cells, keys, places = heap
    last, key = cells[held], keys[held]
    held -= 1
    i, child = 1, 2
    while child < held:
        left, right = keys[child], keys[child + 1]
        if left == right:
            child += 1 if cells[child + 1] < cells[child] else 0
        else:
            child += 1 if right < left else 0
        below = cells[child]
        cells[i], keys[i], places[below] = below, keys[child], i
        i, child = child, child + child
    if child == held:
        below = cells[child]
        cells[i], keys[i], places[below] = below, keys[child], i
        i = child
    if held > 0:
        places[last] = i
        push(heap, held, key, last)
    return held
