"""The room that a robot is in, on maps drawn by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, UNKNOWN
from multisrt.robots.frontier.own_room import SPAN_M, are_in_own_room

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
    assert found.tolist() == [True, False, False, False]


def test_a_hall_is_no_room():
    assert not are_in_own_room(robot_at(8.0, 1.0, house()), PLACES, 30.0).any()
    assert are_in_own_room(robot_at(8.0, 1.0, house()), PLACES, 40.0)[3]


def test_only_what_is_known_counts_as_area():
    cells = house()
    cells[:, 80:] = UNKNOWN
    assert are_in_own_room(robot_at(6.0, 1.0, cells), np.array([[7.0, 2.0]]), 30.0).all()


def test_targets_far_away_are_not_in_it():
    cells = np.full((60, 400), FREE, np.uint8)
    far = np.array([[1.0 + SPAN_M - 0.5, 3.0], [1.0 + SPAN_M + 0.5, 3.0]])
    assert are_in_own_room(robot_at(1.0, 3.0, cells), far, 1000.0).tolist() == [True, False]
    assert are_in_own_room(robot_at(30.0, 3.0, cells), far, 1000.0).tolist() == [False, False]


def test_a_robot_that_knows_nothing_is_in_no_room():
    cells = house()
    cells[:] = UNKNOWN
    assert not are_in_own_room(robot_at(2.0, 1.0, cells), PLACES, 30.0).any()
