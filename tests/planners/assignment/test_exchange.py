import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.exchange import exchange

INF = np.inf


def test_goal_is_taken_if_cheaper_than_own_and_for_its_owner():
    # Own goal 9. Robot 1's goal: 5 < 9, but 4 to its owner. Robot 2's: 6 < 9 and < 8. Robot 3's:
    # 10 is more than the own.
    assert exchange(0, [9, 5, 6, 10], [9, 4, 8, 20]) == 2


def test_cheapest_goal_then_lower_number_wins():
    assert exchange(1, [3, 9, 2, 2], [8, 9, 8, 8]) == 2


@pytest.mark.parametrize(
    ("to_goals", "own"),
    [
        ([9.0, 9.0], [9.0, 20.0]),  # not below the own
        ([9.0, 5.0], [9.0, 5.0]),  # not below the owner's
        ([INF, INF], [INF, INF]),  # no path to any goal
        ([4.0], [4.0]),
    ],
)
def test_goals_are_kept(to_goals, own):
    assert exchange(0, to_goals, own) is None


def test_robot_without_a_path_to_its_goal_takes_another():
    assert exchange(0, [INF, 7.0], [INF, 8.0]) == 1


@given(arrays(float, (4, 4), elements=st.integers(0, 9)), st.integers(0, 3))
def test_exchanged_goals_are_not_exchanged_back(costs, robot):
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
        (lambda: exchange(0, [1.0], [1.0, 2.0]), "to_goals has 1 robots, own has 2"),
        (lambda: exchange(2, [1.0], [1.0]), "robot is 2"),
    ],
)
def test_invalid_input_is_rejected(call, message):
    with pytest.raises(InvalidInputError, match=message):
        call()
