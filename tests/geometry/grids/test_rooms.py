"""Rooms of a grid, by hand and against the distances to every part."""

import doctest

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

import multisrt.geometry.grids.rooms as module
from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, UNKNOWN
from multisrt.geometry.grids.rooms import Room, room_around

DOORWAY_CELLS = 6.0


def found_room(states: np.ndarray, row: int, column: int) -> Room:
    room = room_around(states, row, column, doorway_cells=DOORWAY_CELLS)
    assert room is not None
    return room


def two_rooms(doorway: int) -> np.ndarray:
    """Return two rooms of 20 by 20 cells with a wall of 2 between them, and a doorway in it."""
    states = np.full((22, 44), OCCUPIED, np.uint8)
    states[1:21, 1:21] = states[1:21, 23:43] = FREE
    states[5 : 5 + doorway, 21:23] = FREE
    return states


def test_a_doorway_divides_two_rooms():
    states = two_rooms(doorway=5)
    room = found_room(states, 10, 10)
    # Each room takes the half of the doorway that is nearer to it.
    assert room.cells[:, :22].sum() == 20 * 20 + 5
    assert not room.cells[:, 22:].any()
    other = found_room(states, 10, 30)
    assert (other.cells == room.cells[:, ::-1]).all()


@pytest.mark.parametrize(("doorway", "divides"), [(5, True), (6, True), (7, False), (12, False)])
def test_the_widest_doorway(doorway, divides):
    states = two_rooms(doorway)
    room = found_room(states, 10, 10)
    assert (room.cells.sum() < (states == FREE).sum()) == divides


def test_corners_are_in_the_room_and_doorways_are_not():
    states = two_rooms(doorway=5)
    room = found_room(states, 10, 10)
    assert (room.inner[1:21, 1:21]).all()
    assert not room.inner[:, 21:].any()


def test_a_cell_is_in_a_doorway_if_another_surface_faces_the_nearest_one():
    # Cell 4 of a gap of 6 between walls, and of one of 7.
    for gap, expected in ((6, 0), (7, 1)):
        states = np.full((30, 40), FREE, np.uint8)
        states[10, 20 : 20 + 2] = states[10 + gap + 1, 20 : 20 + 2] = OCCUPIED
        inner = found_room(states, 0, 0).inner
        assert inner[14, 20:22].sum() == 2 * expected
        assert inner[9, 20:22].all()


def test_a_cell_that_is_not_free_is_in_no_room():
    states = two_rooms(doorway=5)
    states[10, 10] = UNKNOWN
    assert room_around(states, 10, 10, doorway_cells=DOORWAY_CELLS) is None
    assert room_around(states, 0, 0, doorway_cells=DOORWAY_CELLS) is None


def test_from_narrow_places_alone_no_room_is_reached():
    corridor = np.full((7, 40), OCCUPIED, np.uint8)
    corridor[1:6] = FREE
    assert room_around(corridor, 3, 20, doorway_cells=DOORWAY_CELLS) is None
    # A part of 9 cells is none: it takes 18.
    alcove = np.full((9, 9), OCCUPIED, np.uint8)
    alcove[1:8, 1:8] = FREE
    assert room_around(alcove, 4, 4, doorway_cells=DOORWAY_CELLS) is None


def test_parts_without_a_wall_are_connected():
    states = np.full((9, 20), FREE, np.uint8)
    states[:, 10] = UNKNOWN
    assert not found_room(states, 4, 4).cells[:, 10:].any()


def test_without_a_wall_all_is_one_room():
    states = np.full((9, 9), FREE, np.uint8)
    room = found_room(states, 0, 0)
    assert room.cells.all()
    assert room.inner.all()


@given(st.integers(0, 100_000), st.floats(0.0, 0.03))
def test_free_cells_belong_to_the_part_that_is_nearest(seed, blocked):
    rng = np.random.default_rng(seed)
    states = np.where(rng.random((40, 50)) < blocked, OCCUPIED, FREE).astype(np.uint8)
    states[rng.integers(40)] = OCCUPIED
    states[rng.random((40, 50)) < 0.02] = UNKNOWN
    row, column = int(rng.integers(40)), int(rng.integers(50))
    free = states == FREE
    occupied = np.argwhere(states == OCCUPIED)
    gaps = np.min(
        [np.hypot(*(np.indices(states.shape) - np.reshape(o, (2, 1, 1)))) for o in occupied], axis=0
    )
    labels, count = ndimage.label(free & (gaps > 0.5 * DOORWAY_CELLS))
    large = [k for k in range(1, count + 1) if (labels == k).sum() >= 0.5 * DOORWAY_CELLS**2]
    steps = [steps_from(free, labels == k) for k in large]
    if not free[row, column] or not np.isfinite([s[row, column] for s in steps]).any():
        assert room_around(states, row, column, doorway_cells=DOORWAY_CELLS) is None
        return
    found = found_room(states, row, column)
    own = next(k for k in large if found.cells[labels == k].all())
    nearest = np.min(steps, axis=0)
    here = steps[large.index(own)]
    assert not (found.inner & ~found.cells).any()
    assert found.inner[labels == own].all()
    assert (here[found.cells] == nearest[found.cells]).all()
    others = [s for k, s in zip(large, steps, strict=True) if k != own]
    is_nearer = here < np.min(others, axis=0, initial=np.inf)
    assert found.cells[is_nearer].all()


def steps_from(free: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Count the steps over the sides of free cells from a part, by growing it."""
    steps = np.where(part, 0.0, np.inf)
    reached = part
    for k in range(1, free.size):
        grown = ndimage.binary_dilation(reached) & free
        if (grown == reached).all():
            return steps
        steps[grown & ~reached] = k
        reached = grown
    return steps


def test_examples():
    assert doctest.testmod(module).attempted > 0
