import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.cell_choice import choose_cell

RIGHT = math.pi / 2.0


def test_score_of_a_cell():
    # D = 100, p = 3. Cell 0: P_d = 45 * 0.2 = 9, P_a = 25 * 90 / 360 = 6.25,
    # P_r = 30 * (0.4 + 0.5) / 3 = 9: 70 - 9 - 6.25 + 9 = 63.75. Cell 1: 22.5, 0, 30 * 1.2 / 3
    # = 12: 59.5.
    chosen = choose_cell([20, 50], [-RIGHT, 0], [[40, 60], [50, 60]], 3, 100.0)
    assert chosen.distance.tolist() == pytest.approx([9.0, 22.5])
    assert chosen.turn.tolist() == pytest.approx([6.25, 0.0])
    assert chosen.others.tolist() == pytest.approx([9.0, 12.0])
    assert chosen.scores.tolist() == pytest.approx([63.75, 59.5])
    assert chosen.order.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("turn", "points"),
    [
        (math.radians(350), 25 / 36),
        (math.radians(-350), 25 / 36),
        (math.pi, 12.5),
        (4 * math.pi, 0),
    ],
)
def test_full_turns_do_not_count(turn, points):
    chosen = choose_cell([1.0], [turn], np.empty((0, 1)), 1, 10.0)
    assert chosen.turn.tolist() == pytest.approx([points])


def test_ties_go_to_the_nearer_cell_then_to_the_lower_index():
    # P_d = 10 d / D and P_r = 20 d / D / 2 cancel out, so that all cells score 70.
    weights = {"distance_weight": 10.0, "others_weight": 20.0}
    even = choose_cell([3, 2, 2], [0, 0, 0], [[3, 2, 2]], 2, 10.0, **weights)
    assert even.scores.tolist() == [70.0, 70.0, 70.0]
    assert even.order.tolist() == [1, 2, 0]


def test_no_cells_have_no_order():
    assert not len(choose_cell([], [], np.empty((2, 0)), 3, 10.0).order)


@given(st.integers(1, 6), st.integers(0, 3), st.data())
def test_scores_follow_the_equations(cells, goals, data):
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
    assert (np.diff(chosen.scores[chosen.order]) <= 0.0).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: choose_cell([1.0], [], np.empty((0, 1)), 1, 9.0), "turns are 1 finite angles"),
        (lambda: choose_cell([1.0], [0.0], [[1.0, 2.0]], 2, 9.0), "to_goals has 2 columns"),
        (lambda: choose_cell([1.0], [0.0], [[1.0]], 1, 9.0), "robots is 1; others alone have 1"),
        (lambda: choose_cell([1.0], [0.0], [[1.0]], 2, 0.0), "diagonal_m is 0.0"),
    ],
)
def test_invalid_input_is_rejected(call, message):
    with pytest.raises(InvalidInputError, match=message):
        call()
