"""Unknown area in sight, by hand and against lines to every cell."""

import math

import numpy as np
import pytest

from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, UNKNOWN
from multisrt.geometry.grids.unknown_area import unknown_areas

SIZE = 41
MIDDLE = np.array([[SIZE // 2, SIZE // 2]])


def area(states: np.ndarray, indices: np.ndarray = MIDDLE, range_cells: float = 12.0) -> float:
    (found,) = unknown_areas(states, indices, range_cells)
    return float(found)


def by_lines(states: np.ndarray, row: int, column: int, range_cells: float) -> int:
    """Count the unknown cells in range to which a finely sampled line meets no occupied cell."""
    count = 0
    for r, c in np.argwhere(states == UNKNOWN).tolist():
        distance = math.hypot(r - row, c - column)
        if distance > range_cells:
            continue
        share = np.linspace(0.0, 1.0, 4 * math.ceil(distance) + 2)
        rows = np.floor(row + 0.5 + share * (r - row)).astype(int)
        columns = np.floor(column + 0.5 + share * (c - column)).astype(int)
        count += not (states[rows, columns] == OCCUPIED).any()
    return count


def grid(state: int) -> np.ndarray:
    return np.full((SIZE, SIZE), state, np.uint8)


def test_where_all_is_known_nothing_is_left():
    assert area(grid(FREE)) == 0.0
    assert area(grid(OCCUPIED)) == 0.0


def test_half_of_a_disc():
    states = grid(FREE)
    states[SIZE // 2 :] = UNKNOWN
    # The rows from that of the robot on: half a disc and half a row.
    assert area(states) == pytest.approx(0.5 * math.pi * 12.0**2 + 12.0, rel=0.02)


def test_a_wall_hides_what_is_behind():
    states = grid(UNKNOWN)
    states[SIZE // 2 + 3] = OCCUPIED
    # What is nearer than the wall, 2.5 rows away: half a disc and a segment of the other half.
    h, r = 2.5, 12.0
    cap = r * r * math.acos(h / r) - h * math.sqrt(r * r - h * h)
    assert area(states) == pytest.approx(math.pi * r * r - cap, rel=0.02)


def test_beyond_the_grid_all_is_unknown():
    states = grid(FREE)
    corner = np.array([[0, 0]])
    # Of the disc round the corner cell's centre the grid holds a quarter, and half a cell more.
    known = 0.25 * math.pi * 144.0 + 2 * 0.5 * 12.0 + 0.25
    assert area(states, corner) == pytest.approx(math.pi * 144.0 - known, rel=0.02)


def test_the_range_may_end_within_a_cell():
    assert area(grid(UNKNOWN), range_cells=3.7) == pytest.approx(math.pi * 3.7**2)


@pytest.mark.parametrize("seed", range(4))
def test_areas_are_near_the_count_of_cells_in_sight(seed):
    rng = np.random.default_rng(seed)
    states = grid(FREE)
    for _ in range(3):
        row, column = rng.integers(5, SIZE - 10, 2).tolist()
        states[row : row + 9, column : column + 9] = UNKNOWN
    for _ in range(3):
        row, column = rng.integers(2, SIZE - 8, 2).tolist()
        states[row, column : column + 7] = OCCUPIED
    row, column = MIDDLE[0].tolist()
    states[row - 1 : row + 2, column - 1 : column + 2] = FREE
    counted = by_lines(states, row, column, 12.0)
    assert counted > 0
    assert area(states) == pytest.approx(counted, rel=0.12, abs=6.0)


def test_every_cell_has_an_area_of_its_own():
    states = grid(FREE)
    states[:10] = UNKNOWN
    both = np.array([[SIZE - 1, SIZE // 2], [12, SIZE // 2]])
    far, near = unknown_areas(states, both, 12.0).tolist()
    assert far > 0.0  # Below the grid.
    assert near > 0.0
    assert unknown_areas(states, both[1:], 12.0).tolist() == [near]
    assert unknown_areas(states, np.empty((0, 2), np.int64), 12.0).shape == (0,)
