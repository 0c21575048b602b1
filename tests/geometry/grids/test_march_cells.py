"""Kernels between the cells of a grid and a march on a window of it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.grids.fast_march import ACCEPTED, EXACT_CELLS, FREE, RIM, March
from multisrt.geometry.grids.march_cells import (
    DETOUR,
    MARGIN_CELLS,
    cells_of,
    cropped,
    first_accepted,
    first_outside,
    lay_out,
    march_to,
    move,
    numbers_of,
    values_of,
    window_around,
)


def march(part, rim=(False, False, False, False)):
    width, size = part.shape[1] + 4, (part.shape[0] + 4) * (part.shape[1] + 4)
    arrays = March(
        width=width,
        state=np.zeros(size, np.uint8),
        marks=np.zeros(size, np.uint8),
        distance=np.full(size, 9.0),
        order=np.full(size, 9, np.int32),
        cells=np.full(size, 9, np.int32),
        keys=np.full(size, 9.0),
        places=np.zeros(size, np.int32),
    )
    lay_out(part, rim, arrays)
    return arrays


def test_a_march_is_laid_out_with_a_border_of_two_cells():
    part = np.array([[True, False, True], [True, True, False]])
    arrays = march(part, (True, False, False, True))
    state, marks = arrays.state.reshape(6, 7), arrays.marks.reshape(6, 7)
    assert np.array_equal(state[2:-2, 2:-2], part)
    assert state.sum() == 4
    assert marks[2:-2, 2:-2].tolist() == [[RIM, RIM, RIM], [0, 0, RIM]]
    assert np.count_nonzero(marks) == 4
    assert np.isinf(arrays.distance).all()
    assert np.isinf(arrays.keys[0])
    assert not arrays.places.any()


@given(st.integers(0, 5), st.integers(0, 5), st.integers(0, 5), st.integers(0, 5))
def test_cells_keep_their_values_when_the_window_grows(below, above, left, right):
    old = march(np.ones((3, 4), np.bool_))
    inner = np.flatnonzero(old.state)
    accepted, front = inner[[3, 0, 4, 1, 7]], inner[[2, 5, 6]]
    old.order[:5], old.places[accepted] = accepted, range(5)
    old.state[accepted], old.distance[accepted] = ACCEPTED, accepted + 0.5
    old.cells[1:4], old.places[front], old.keys[1:4] = front, (1, 2, 3), (1.0, 2.0, 3.0)
    seeds = inner[:2].astype(np.int32)
    new = march(np.zeros((3 + below + above, 4 + left + right), np.bool_))
    move(old, new, 3, 5, below, left, seeds)
    rows, columns = np.divmod(inner, old.width)
    moved = (rows + below) * new.width + columns + left
    assert np.flatnonzero(new.state).tolist() == moved.tolist()
    assert new.state[moved].tolist() == old.state[inner].tolist()
    assert new.distance[moved].tolist() == old.distance[inner].tolist()
    assert new.places[moved].tolist() == old.places[inner].tolist()
    assert new.order[:5].tolist() == moved[[3, 0, 4, 1, 7]].tolist()
    assert new.cells[1:4].tolist() == moved[[2, 5, 6]].tolist()
    assert new.keys[1:4].tolist() == [1.0, 2.0, 3.0]
    assert seeds.tolist() == moved[:2].tolist()
    rest = np.setdiff1d(np.arange(new.state.size), moved)
    assert np.isinf(new.distance[rest]).all()
    assert not new.places[rest].any()


def test_cells_outside_of_the_window_have_number_0():
    cells = np.array([[3, 9], [4, 10], [6, 11], [7, 12], [4, 12]])
    numbers = numbers_of(cells, (4, 7, 9, 12), 3 + 4)
    assert numbers.tolist() == [0, 2 * 7 + 1 + 2, 4 * 7 + 2 + 2, 0, 0]


@given(st.integers(0, 9), st.integers(1, 4), st.integers(0, 9), st.integers(1, 4))
def test_numbers_lead_back_to_their_cells(row, rows, column, columns):
    window = (row, row + rows, column, column + columns)
    cells = np.argwhere(np.ones((rows, columns), np.bool_)) + np.array([row, column])
    numbers = numbers_of(cells, window, columns + 4)
    assert len(set(numbers.tolist())) == rows * columns
    assert cells_of(numbers, window, columns + 4).tolist() == cells.tolist()


@pytest.mark.parametrize("cell", [(-1, 0), (3, 0), (0, -1), (0, 4)])
def test_the_first_cell_outside_of_the_grid_is_found(cell):
    cells = np.array([(0, 0), (2, 3), cell, (9, 9)])
    assert first_outside(cells, 3, 4) == 2
    assert first_outside(cells[:2], 3, 4) == -1


def test_a_window_has_room_for_the_way_to_the_nearest_or_the_farthest_cell():
    passable = np.ones((1, 200), np.bool_)
    starts = np.array([(50.5, 0.5), (100.5, 0.5)])
    cells = np.array([(0, 70), (0, 150), (0, 52)])
    least = EXACT_CELLS + MARGIN_CELLS

    def columns(farthest):
        r0, r1, c0, c1 = window_around(cells, passable, starts, farthest)
        assert (r0, r1) == (0, 1)
        return c0, c1 - 1

    assert columns(False) == (50 - least, 100 + least)
    assert columns(True) == (0, 100 + math.ceil(50 * DETOUR) + MARGIN_CELLS)
    passable[0, [150, 52]] = False
    reach = math.ceil(20 * DETOUR) + MARGIN_CELLS
    assert columns(False) == columns(True) == (50 - reach, 100 + reach)
    passable[:] = False
    assert columns(True) == (50 - least, 100 + least)


@given(
    st.sets(st.tuples(st.integers(0, 6), st.integers(0, 8)), max_size=4),
    st.tuples(st.integers(0, 3), st.integers(4, 7), st.integers(0, 4), st.integers(5, 9)),
)
def test_a_window_is_cropped_to_its_passable_cells_and_one_more(cells, window):
    passable = np.zeros((7, 9), np.bool_)
    for cell in cells:
        passable[cell] = True
    r0, r1, c0, c1 = window
    rows, columns = np.nonzero(passable[r0:r1, c0:c1])
    expected = window
    if len(rows):
        expected = (
            max(r0, r0 + rows.min() - 1),
            min(r1, r0 + rows.max() + 2),
            max(c0, c0 + columns.min() - 1),
            min(c1, c0 + columns.max() + 2),
        )
    assert cropped(window, passable) == expected


def test_asked_cells_are_counted_once_and_forgotten():
    passable = np.ones((2, 3), np.bool_)
    passable[1, 1] = False
    window = (0, 1, 0, 3)
    arrays = march(passable[:1], (False, True, False, False))
    asked = np.array([(0, 1), (0, 1), (0, 2), (1, 1)])
    # Nothing is on the front, so that nothing is reached.
    assert march_to(arrays, 0, 0, passable, window, asked, True, np.inf) == (0, 0, False)
    assert set(arrays.marks[2 * 7 + 2 : 2 * 7 + 5].tolist()) == {RIM}
    # One that is accepted ends the march to the first.
    arrays.state[2 * 7 + 3] = ACCEPTED
    arrays.cells[1], arrays.keys[1] = 2 * 7 + 4, 1.0
    assert march_to(arrays, 1, 0, passable, window, asked, False, np.inf) == (1, 0, False)
    assert march_to(arrays, 1, 0, passable, window, asked, True, np.inf) == (1, 0, True)


def test_the_cell_accepted_first_is_found():
    arrays = march(np.ones((1, 6), np.bool_))
    window, first = (0, 1, 0, 6), 2 * arrays.width + 2
    arrays.places[first : first + 6] = np.arange(6, 0, -1)
    asked = np.array([(0, 0), (0, 2), (0, 4), (0, 2), (5, 5)])
    assert first_accepted(arrays, window, asked) == (-1, np.inf)
    arrays.state[[first + 2, first + 4]] = ACCEPTED
    arrays.distance[[first + 2, first + 4]] = 1.5, 2.5
    assert first_accepted(arrays, window, asked) == (2, 2.5)
    arrays.places[first + 4] = 7
    assert first_accepted(arrays, window, asked) == (1, 1.5)
    assert values_of(arrays, window, asked).tolist() == [np.inf, 1.5, 2.5, 1.5, np.inf]
    assert (arrays.state[first], FREE) == (1, 1)
