"""The heap of cells, against sorting."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.grids.cell_heap import drop_first, push


@given(st.lists(st.tuples(st.integers(0, 40), st.integers(0, 9)), min_size=1, max_size=80))
def test_cells_leave_by_their_lowest_key_and_then_by_number(offers):
    cells, keys, places = (np.zeros(64, np.int32), np.zeros(64), np.zeros(64, np.int32))
    held = 0
    least: dict[int, float] = {}
    for cell, key in offers:
        if key < least.get(cell, np.inf):
            least[cell] = float(key)
            held = push(cells, keys, places, held, float(key), cell)
    assert held == len(least)
    left = []
    while held:
        left.append((float(keys[1]), int(cells[1])))
        held = drop_first(cells, keys, places, held)
    assert left == sorted((key, cell) for cell, key in least.items())
