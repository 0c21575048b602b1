"""The room that a robot is in, on maps drawn by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, UNKNOWN
from multisrt.robots.frontier.own_room import are_in_own_room

CELL_M = 0.1


def robot_at(x: float, y: float, cells: np.ndarray) -> Any:
    def indices_of(places: np.ndarray) -> np.ndarray:
        return np.floor(places[:, ::-1] / CELL_M).astype(np.int64)

    raster = SimpleNamespace(cell_m=CELL_M, cells=cells)
    return SimpleNamespace(at=(x, y, 0.0), raster=raster, indices_of=indices_of)


def house() -> np.ndarray:
    """Return a room of 4 by 4 m and a hall of 4 by 8 m with a doorway of 1 m at x = 4 to 4.2."""
    cells = np.full((40, 122), FREE, np.uint8)
    cells[:, 40:42] = OCCUPIED
    cells[15:25, 40:42] = FREE
    cells[[0, -1]] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    return cells


IN_ROOM, AT_WALL, IN_DOORWAY, IN_HALL = (1.5, 2.0), (0.3, 2.0), (4.1, 2.0), (8.0, 2.0)
PLACES = np.array([IN_ROOM, AT_WALL, IN_DOORWAY, IN_HALL])


def test_targets_inside_the_room_are_in_it():
    found = are_in_own_room(robot_at(2.0, 1.0, house()), PLACES, 30.0)
    assert found.tolist() == [True, True, False, False]


def test_a_hall_is_no_room():
    assert not are_in_own_room(robot_at(8.0, 1.0, house()), PLACES, 30.0).any()
    assert are_in_own_room(robot_at(8.0, 1.0, house()), PLACES, 40.0)[3]


def test_a_room_may_have_just_this_area():
    # 38 by 39 cells, and half of the doorway: 10 cells.
    area_m2 = (38 * 39 + 10) * CELL_M**2
    assert are_in_own_room(robot_at(2.0, 1.0, house()), PLACES, area_m2 + 1e-9)[0]
    assert not are_in_own_room(robot_at(2.0, 1.0, house()), PLACES, area_m2 - 1e-9).any()


@pytest.mark.parametrize(("width", "is_room"), [(13, True), (14, True), (15, False)])
def test_doorways_are_at_most_1_4_m_wide(width, is_room):
    cells = house()
    cells[1:-1, 40:42] = OCCUPIED
    cells[10 : 10 + width, 40:42] = FREE
    assert are_in_own_room(robot_at(2.0, 1.0, cells), PLACES, 30.0)[0] == is_room


def test_only_what_is_known_counts_as_area():
    cells = house()
    cells[:, 80:] = UNKNOWN
    assert are_in_own_room(robot_at(6.0, 1.0, cells), np.array([[7.0, 2.0]]), 30.0).all()


@pytest.mark.parametrize(("length_m", "is_room"), [(10.0, True), (12.0, False)])
def test_a_room_reaches_at_most_10_m_from_the_robot(length_m, is_room):
    cells = np.full((30, round(length_m / CELL_M)), FREE, np.uint8)
    cells[[0, -1]] = OCCUPIED
    ends = np.array([[0.5, 1.5], [length_m - 0.5, 1.5]])
    found = are_in_own_room(robot_at(0.5, 1.5, cells), ends, 1000.0)
    assert found.tolist() == [is_room, is_room]
    middle = robot_at(length_m / 2.0, 1.5, cells)
    assert are_in_own_room(middle, ends, 1000.0).all()


def test_targets_far_from_the_room_are_not_in_it():
    cells = np.full((40, 400), FREE, np.uint8)
    cells[:, 40:42] = OCCUPIED
    far = np.array([[20.0, 1.0], [39.0, 3.0]])
    assert not are_in_own_room(robot_at(2.0, 1.0, cells), far, 30.0).any()


def test_a_robot_that_knows_nothing_is_in_no_room():
    cells = house()
    cells[:] = UNKNOWN
    assert not are_in_own_room(robot_at(2.0, 1.0, cells), PLACES, 30.0).any()
