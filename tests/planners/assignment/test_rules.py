import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.rules import (
    cells_ahead,
    choose_cell,
    exchange,
    mates_ahead,
)

INF = np.inf
RIGHT = math.pi / 2.0


def test_the_score_of_a_cell():
    # D = 100, p = 3. Cell 0: P_d = 45 * 0.2 = 9, P_a = 25 * 90 / 360 = 6.25,
    # P_r = 30 * (0.4 + 0.5) / 3 = 9: 70 - 9 - 6.25 + 9 = 63.75. Cell 1: 22.5, 0, 30 * 1.2 / 3
    # = 12: 59.5.
    chosen = choose_cell([20, 50], [-RIGHT, 0], [[40, 60], [50, 60]], 3, 100.0)
    assert chosen.distance.tolist() == pytest.approx([9.0, 22.5])
    assert chosen.turn.tolist() == pytest.approx([6.25, 0.0])
    assert chosen.others.tolist() == pytest.approx([9.0, 12.0])
    assert chosen.scores.tolist() == pytest.approx([63.75, 59.5])
    assert chosen.choice == 0


@pytest.mark.parametrize(
    ("turn", "points"),
    [
        (math.radians(350), 25 / 36),
        (math.radians(-350), 25 / 36),
        (math.pi, 12.5),
        (4 * math.pi, 0),
    ],
)
def test_whole_turns_do_not_count(turn, points):
    chosen = choose_cell([1.0], [turn], np.empty((0, 1)), 1, 10.0)
    assert chosen.turn.tolist() == pytest.approx([points])


def test_of_equal_scores_the_nearer_cell_then_the_first():
    # With no weight on the distance all score 70.
    even = choose_cell([3, 2, 2], [0, 0, 0], np.empty((0, 3)), 1, 10.0, distance_weight=0.0)
    assert even.choice == 1


def test_without_cells_there_is_no_choice():
    assert choose_cell([], [], np.empty((2, 0)), 3, 10.0).choice is None


@given(st.integers(1, 6), st.integers(0, 3), st.data())
def test_scores_are_the_equations(cells, goals, data):
    numbers = st.floats(0.0, 40.0)
    distances = data.draw(arrays(float, cells, elements=numbers))
    turns = data.draw(arrays(float, cells, elements=st.floats(-math.pi, math.pi)))
    to_goals = data.draw(arrays(float, (goals, cells), elements=numbers))
    chosen = choose_cell(distances, turns, to_goals, goals + 1, 50.0)
    for c in range(cells):
        near = 45 * distances[c] / 50
        turned = 25 * math.degrees(abs(turns[c])) / 360
        spread = 30 * sum(to_goals[g, c] / 50 for g in range(goals)) / (goals + 1)
        assert chosen.scores[c] == pytest.approx(70 - near - turned + spread)
    assert chosen.scores[chosen.choice] == chosen.scores.max()


def grid(columns: int, rows: int, cell_m: float = 1.0) -> np.ndarray:
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    return np.column_stack([x.ravel(), y.ravel()]) * cell_m


def test_cells_ahead_lie_in_the_rectangle_and_the_sector():
    # From (0.5, 0.5) to (4.5, 4.5), bearing 45 degrees: off the diagonal, (3.5, 4.5) and
    # (2.5, 3.5) have atan(4 / 3) = 53.1 and atan(3 / 2) = 56.3 degrees, (1.5, 2.5) has 63.4.
    centres = grid(7, 7)
    ahead = cells_ahead(centres, (0.5, 0.5), (4.5, 4.5), 1.0)
    found = {tuple(c) for c in centres[ahead].tolist()}
    diagonal = {(k + 0.5, k + 0.5) for k in range(1, 5)}
    beside = {(2.5, 3.5), (3.5, 4.5)}
    assert found == diagonal | beside | {(y, x) for x, y in beside}


def test_along_an_axis_a_row_of_cells_lies_ahead():
    # Robot and goal are not at centres: a rectangle of no height would hold no cell.
    centres = grid(8, 5)
    ahead = cells_ahead(centres, (1.2, 2.4), (5.8, 2.4), 1.0)
    # The cell with its centre at 1.5 is at atan(0.1 / 0.3) = 18 degrees and out of the sector.
    assert centres[ahead].tolist() == [[x, 2.5] for x in (2.5, 3.5, 4.5, 5.5)]


def test_the_sector_goes_on_across_the_left():
    centres = grid(6, 3)
    ahead = cells_ahead(centres, (5.5, 1.5), (0.5, 1.5), 1.0)
    assert centres[ahead].tolist() == [[x, 1.5] for x in (0.5, 1.5, 2.5, 3.5, 4.5)]
    assert not cells_ahead(centres, (2.5, 1.5), (2.5, 1.5), 1.0).any()


@given(st.tuples(*[st.floats(0.0, 9.0)] * 4))
def test_cells_ahead_are_those_near_the_line(ends):
    start, end = np.array(ends[:2]), np.array(ends[2:])
    centres = grid(9, 9)
    for centre, ahead in zip(centres, cells_ahead(centres, start, end, 1.0), strict=True):
        offset, way = centre - start, end - start
        if ahead:
            cosine = offset @ way / np.linalg.norm(offset) / np.linalg.norm(way)
            assert cosine >= math.cos(math.radians(15)) - 1e-6
            assert (np.minimum(start, end) - 0.5 - 1e-6 <= centre).all()
            assert (centre <= np.maximum(start, end) + 0.5 + 1e-6).all()
        elif np.linalg.norm(way) > 1e-6:
            # What the line runs through in the middle of a cell is found.
            along = offset @ way / (way @ way)
            beside = np.linalg.norm(offset - along * way)
            clear = np.linalg.norm(offset) * math.sin(math.radians(15)) - 1e-6
            assert not (0.0 < along < 1.0 and beside < min(clear, 0.5))


def at(distance: float, degrees: float) -> tuple[float, float]:
    return distance * math.cos(math.radians(degrees)), distance * math.sin(math.radians(degrees))


def test_mates_in_the_sector_are_found():
    # The robot of row 1 stands at the origin and looks to the left, 180 degrees.
    places = [at(2, 180), (0, 0), at(2, -166), at(2, 164), at(3.1, 180), at(2, 0), at(3, 180)]
    found = mates_ahead(1, places, math.pi, [False] * 7, 3.0)
    assert found.tolist() == [True, False, True, False, False, False, True]


def test_inactive_mates_are_ignored():
    places = [(0, 0), (1, 0), (2, 0)]
    assert mates_ahead(0, places, 0.0, [False, True, False], 5.0).tolist() == [False, False, True]


def test_a_mate_at_the_same_place_is_found_whatever_the_heading():
    for heading in np.linspace(-3.0, 3.0, 7):
        assert mates_ahead(0, [(1, 1), (1, 1)], heading, [False, False], 1.0)[1]


def test_the_sector_is_an_option():
    wide = mates_ahead(0, [(0, 0), at(1, 40)], 0.0, [False] * 2, 2.0, sector_rad=math.radians(45))
    assert wide[1]


def test_a_goal_is_taken_that_is_cheaper_for_both_comparisons():
    # Own goal 9. Robot 1's goal: 5 < 9, but 4 to its owner. Robot 2's: 6 < 9 and < 8. Robot 3's:
    # 10 is more than the own.
    assert exchange(0, [9, 5, 6, 10], [9, 4, 8, 20]) == 2


def test_the_cheapest_goal_then_the_lower_id():
    assert exchange(1, [3, 9, 2, 2], [8, 9, 8, 8]) == 2


@pytest.mark.parametrize(
    ("to_goals", "own"),
    [
        ([9.0, 9.0], [9.0, 20.0]),  # not below the own
        ([9.0, 5.0], [9.0, 5.0]),  # not below the owner's
        ([INF, INF], [INF, INF]),  # no way to anything
        ([4.0], [4.0]),
    ],
)
def test_goals_are_kept(to_goals, own):
    assert exchange(0, to_goals, own) is None


def test_a_robot_without_a_way_to_its_goal_takes_another():
    assert exchange(0, [INF, 7.0], [INF, 8.0]) == 1


@given(arrays(float, (4, 4), elements=st.integers(0, 9)), st.integers(0, 3))
def test_what_was_swapped_is_not_swapped_back(costs, robot):
    # costs[i, g]: robot i to goal g; robot i has goal i.
    goals = np.arange(4)
    partner = exchange(robot, costs[robot, goals], costs[np.arange(4), goals])
    if partner is None:
        return
    goals[[robot, partner]] = goals[[partner, robot]]
    for one, other in ((robot, partner), (partner, robot)):
        own = costs[np.arange(4), goals]
        assert exchange(one, costs[one, goals], own) != other


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: choose_cell([1.0], [], np.empty((0, 1)), 1, 9.0), "turns are 1 finite angles"),
        (lambda: choose_cell([1.0], [0.0], [[1.0, 2.0]], 2, 9.0), "to_goals has 2 columns"),
        (lambda: choose_cell([1.0], [0.0], [[1.0]], 1, 9.0), "robots is 1; others alone have 1"),
        (lambda: choose_cell([1.0], [0.0], [[1.0]], 2, 0.0), "diagonal_m is 0.0"),
        (lambda: cells_ahead([1.0], (0, 0), (1, 1), 1.0), "centres: pairs x, y"),
        (lambda: cells_ahead([(1, 1)], (0, 0), (1, 1), 0.0), "a cell is a positive width"),
        (lambda: mates_ahead(0, [(0, 0)], 0.0, [], 1.0), "inactive has the shape"),
        (lambda: mates_ahead(0, [(0, 0)], INF, [False], 1.0), "no sector has heading inf"),
        (lambda: exchange(0, [1.0], [1.0, 2.0]), "to_goals has 1 robots, own has 2"),
        (lambda: exchange(2, [1.0], [1.0]), "robot is 2"),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(InvalidInputError, match=message):
        call()
