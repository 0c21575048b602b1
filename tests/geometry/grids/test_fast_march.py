"""Kernels of the fast march: cells by number, asked for and accepted."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.grids.fast_march import (
    ACCEPTED,
    BLOCKED,
    FREE,
    RIM,
    ask,
    first_accepted,
    forget,
    moved_cells,
    numbers_of,
)


@given(st.integers(0, 5), st.integers(0, 5), st.integers(0, 5), st.integers(0, 5))
def test_cells_keep_their_place_when_the_grid_grows(below, above, left, right):
    small = np.arange(4 * 7).reshape(4, 7)
    large = np.full((4 + below + above, 7 + left + right), -1)
    large[below : below + 4, left : left + 7] = small
    cells = np.arange(small.size, dtype=np.int32)
    moved = moved_cells(cells, 7, large.shape[1], below, left)
    assert np.array_equal(large.ravel()[moved], cells)


def test_asked_cells_are_counted_once_and_forgotten():
    state = np.full(6, FREE, np.uint8)
    marks = np.zeros(6, np.uint8)
    state[4], marks[2] = ACCEPTED, RIM
    assert ask(np.array([1, 2, 1, 4]), state, marks) == (2, 1)
    assert np.flatnonzero(marks).tolist() == [1, 2]
    forget(np.array([1, 2, 1, 4]), marks)
    assert marks.tolist() == [0, 0, RIM, 0, 0, 0]


def test_cells_outside_of_the_window_are_missing():
    rows, columns = np.array([3, 4, 6, 7]), np.array([9, 10, 11, 12])
    numbers = numbers_of(rows, columns, (4, 7, 9, 12), 3 + 4)
    assert numbers.tolist() == [0, 2 * 7 + 1 + 2, 4 * 7 + 2 + 2, 0]
    state, marks = np.full(49, FREE, np.uint8), np.zeros(49, np.uint8)
    state[0] = BLOCKED
    assert ask(numbers, state, marks) == (4, 0)
    assert np.flatnonzero(marks).tolist() == [17, 32]


def test_the_cell_accepted_first_is_found():
    state, places = np.full(6, FREE, np.uint8), np.arange(6, 0, -1).astype(np.int32)
    asked = np.array([0, 2, 4, 2])
    assert first_accepted(asked, state, places) == -1
    state[[2, 4]] = ACCEPTED
    assert first_accepted(asked, state, places) == 2
    places[4] = 7
    assert first_accepted(asked, state, places) == 1
