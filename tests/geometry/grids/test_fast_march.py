import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.grids.fast_march import (
    ACCEPTED,
    BLOCKED,
    FREE,
    RIM,
    ask,
    drop_first,
    first_accepted,
    forget,
    in_sight,
    moved_cells,
    numbers_of,
    push,
)


@given(st.lists(st.tuples(st.integers(0, 40), st.integers(0, 9)), min_size=1, max_size=80))
def test_cells_leave_the_heap_by_value_and_number_with_the_last_value_they_got(offers):
    heap, keys = np.zeros(64, np.int32), np.zeros(64)
    places, held = np.zeros(64, np.int32), 0
    least: dict[int, float] = {}
    for cell, key in offers:
        if key < least.get(cell, np.inf):
            least[cell] = float(key)
            held = push(heap, keys, places, held, float(key), cell)
    assert held == len(least)
    left = []
    while held:
        left.append((float(keys[1]), int(heap[1])))
        held = drop_first(heap, keys, places, held)
    assert left == sorted((key, cell) for cell, key in least.items())


@given(st.integers(0, 5), st.integers(0, 5), st.integers(0, 5), st.integers(0, 5))
def test_cells_keep_their_place_when_the_grid_grows(below, above, left, right):
    small = np.arange(4 * 7).reshape(4, 7)
    large = np.full((4 + below + above, 7 + left + right), -1)
    large[below : below + 4, left : left + 7] = small
    cells = np.arange(small.size, dtype=np.int32)
    moved = moved_cells(cells, 7, large.shape[1], below, left)
    assert np.array_equal(large.ravel()[moved], cells)


def test_asked_cells_count_once_and_are_forgotten():
    state = np.full(6, FREE, np.uint8)
    marks = np.zeros(6, np.uint8)
    state[4], marks[2] = ACCEPTED, RIM
    assert ask(np.array([1, 2, 1, 4]), state, marks) == (2, 1)
    assert np.flatnonzero(marks).tolist() == [1, 2]
    forget(np.array([1, 2, 1, 4]), marks)
    assert marks.tolist() == [0, 0, RIM, 0, 0, 0]


def test_cells_that_do_not_lie_in_the_window_are_those_that_are_missing():
    rows, columns = np.array([3, 4, 6, 7]), np.array([9, 10, 11, 12])
    numbers = numbers_of(rows, columns, (4, 7, 9, 12), 3 + 4)
    assert numbers.tolist() == [0, 2 * 7 + 1 + 2, 4 * 7 + 2 + 2, 0]
    state, marks = np.full(49, FREE, np.uint8), np.zeros(49, np.uint8)
    state[0] = BLOCKED
    assert ask(numbers, state, marks) == (4, 0)
    assert np.flatnonzero(marks).tolist() == [17, 32]


def test_which_cell_was_accepted_first():
    state, places = np.full(6, FREE, np.uint8), np.arange(6, 0, -1).astype(np.int32)
    asked = np.array([0, 2, 4, 2])
    assert first_accepted(asked, state, places) == -1
    state[[2, 4]] = ACCEPTED
    assert first_accepted(asked, state, places) == 2
    places[4] = 7
    assert first_accepted(asked, state, places) == 1


def test_nothing_is_seen_between_two_cells_that_meet_in_a_corner_beside_a_blocked_one():
    free = np.ones((3, 3), bool)
    assert in_sight(free, 0.5, 0.5, 2, 2)
    free[1, 0] = False
    assert not in_sight(free, 0.5, 0.5, 2, 2)
    assert in_sight(free, 0.5, 0.5, 2, 0)
