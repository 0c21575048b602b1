import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.navigation.sector import cells_ahead, is_in_sector


def grid(columns: int, rows: int, cell_m: float = 1.0) -> np.ndarray:
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    return np.column_stack([x.ravel(), y.ravel()]) * cell_m


def test_cells_ahead_are_in_the_rectangle_and_the_sector():
    # From (0.5, 0.5) to (4.5, 4.5), bearing 45 degrees: off the diagonal, (3.5, 4.5) and
    # (2.5, 3.5) have atan(4 / 3) = 53.1 and atan(3 / 2) = 56.3 degrees, (1.5, 2.5) has 63.4.
    centres = grid(7, 7)
    ahead = cells_ahead(centres, (0.5, 0.5), (4.5, 4.5), 1.0)
    found = {tuple(c) for c in centres[ahead].tolist()}
    diagonal = {(k + 0.5, k + 0.5) for k in range(1, 5)}
    beside = {(2.5, 3.5), (3.5, 4.5)}
    assert found == diagonal | beside | {(y, x) for x, y in beside}


def test_a_row_of_cells_is_ahead_along_an_axis():
    # Robot and goal are not at centres: a rectangle of height 0 would hold no cell.
    centres = grid(8, 5)
    ahead = cells_ahead(centres, (1.2, 2.4), (5.8, 2.4), 1.0)
    # The cell with its centre at 1.5 is at atan(0.1 / 0.3) = 18 degrees, outside the sector.
    assert centres[ahead].tolist() == [[x, 2.5] for x in (2.5, 3.5, 4.5, 5.5)]


def test_sector_extends_across_the_bearing_of_180_degrees():
    centres = grid(6, 3)
    ahead = cells_ahead(centres, (5.5, 1.5), (0.5, 1.5), 1.0)
    assert centres[ahead].tolist() == [[x, 1.5] for x in (0.5, 1.5, 2.5, 3.5, 4.5)]
    assert not cells_ahead(centres, (2.5, 1.5), (2.5, 1.5), 1.0).any()


@given(st.tuples(*[st.floats(0.0, 9.0)] * 4))
def test_cells_ahead_are_near_the_line_to_the_goal(ends):
    start, end = np.array(ends[:2]), np.array(ends[2:])
    centres = grid(9, 9)
    for centre, ahead in zip(centres, cells_ahead(centres, start, end, 1.0), strict=True):
        offset, step = centre - start, end - start
        if ahead:
            cosine = offset @ step / np.linalg.norm(offset) / np.linalg.norm(step)
            assert cosine >= math.cos(math.radians(15)) - 1e-6
            assert (np.minimum(start, end) - 0.5 - 1e-6 <= centre).all()
            assert (centre <= np.maximum(start, end) + 0.5 + 1e-6).all()
        elif np.linalg.norm(step) > 1e-6:
            # Cells whose middle the line passes through are found.
            along = offset @ step / (step @ step)
            beside = np.linalg.norm(offset - along * step)
            clear = float(np.linalg.norm(offset)) * math.sin(math.radians(15)) - 1e-6
            assert not (0.0 < along < 1.0 and beside < min(clear, 0.5))


def at(distance: float, degrees: float) -> Configuration:
    angle = math.radians(degrees)
    return Configuration(distance * math.cos(angle), distance * math.sin(angle), 0.0)


def test_robots_in_the_sector_are_found():
    robot = Configuration(0.0, 0.0, math.pi)
    teammates = [at(2, 180), at(2, -166), at(2, 164), at(3.1, 180), at(2, 0), at(3, 180)]
    found = [is_in_sector(robot, teammate, 3.0) for teammate in teammates]
    assert found == [True, True, False, False, False, True]


def test_sector_is_15_degrees_wide_to_either_side():
    robot = Configuration(0.0, 0.0, math.pi)
    assert is_in_sector(robot, Configuration(-2.9, 0.7), 3.0)
    assert is_in_sector(robot, Configuration(-2.9, -0.7), 3.0)
    assert not is_in_sector(robot, Configuration(-2.9, 0.8), 3.0)
    assert not is_in_sector(robot, Configuration(-3.1, 0.0), 3.0)
    assert not is_in_sector(robot, Configuration(2.0, 0.0), 3.0)


def test_a_robot_at_the_same_place_is_in_every_sector():
    for heading in np.linspace(-3.0, 3.0, 7).tolist():
        assert is_in_sector(Configuration(1.0, 1.0, heading), Configuration(1.0, 1.0), 1.0)


def test_opening_of_the_sector_is_an_option():
    origin = Configuration(0.0, 0.0, 0.0)
    assert is_in_sector(origin, at(1, 40), 2.0, math.radians(45))
    assert not is_in_sector(origin, at(1, 40), 2.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cells_ahead([1.0], (0, 0), (1, 1), 1.0), "centres: pairs x, y"),
        (lambda: cells_ahead([(1, 1)], (0, 0), (1, 1), 0.0), "a cell is a positive width"),
    ],
)
def test_invalid_input_is_rejected(call, message):
    with pytest.raises(InvalidInputError, match=message):
        call()
