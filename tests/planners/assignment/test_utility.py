import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.utility import overlap, utility

INF = np.inf


def naive(costs, distances, visible, overlap_m, beta):
    # The equations with loops; of equal values the nearer, then the lower robot and target.
    robots, targets = len(costs), len(costs[0])
    finite = [cost for row in costs for cost in row if cost < INF]
    longest = max(finite, default=0.0) or 1.0
    worth = [1.0] * targets
    got = [-1] * robots
    left = [i for i in range(robots) if min(costs[i]) < INF]
    while left:
        _, _, i, t = min(
            (-(worth[t] - beta * (costs[i][t] / longest)), costs[i][t], i, t)
            for i in left
            for t in range(targets)
            if costs[i][t] < INF
        )
        got[i] = t
        left.remove(i)
        for other in range(targets):
            if other == t or visible[t][other]:
                distance = distances[t][other]
                if distance < overlap_m:
                    worth[other] -= 1.0 - distance / overlap_m
    return got


@st.composite
def situations(draw):
    robots, targets = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    costs = draw(
        arrays(
            float, (robots, targets), elements=st.sampled_from([0.0, 1.0, 2.5, 4.0, 7.3, 9.0, INF])
        )
    )
    places = draw(arrays(float, (targets, 2), elements=st.integers(0, 12)))
    distances = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    visible = draw(arrays(bool, (targets, targets)))
    return costs, distances, visible | visible.T


def test_a_target_in_sight_of_an_assigned_one_loses_utility():
    # R_p = 4, R = 8. Targets 0 and 1 are 2 m apart and in sight, target 2 is far away. The largest
    # cost is 10. Round 1: robot 0, target 0: 1 - 0.2 is the maximum. Then U_0 = 1 - 1 = 0 and
    # U_1 = 1 - (1 - 2 / 8) = 0.25. For robot 1: 0 - 0.3, 0.25 - 0.4 and 1 - 1.0: target 2.
    costs = [[2.0, 3.0, 9.0], [3.0, 4.0, 10.0]]
    distances = [[0.0, 2.0, 30.0], [2.0, 0.0, 30.0], [30.0, 30.0, 0.0]]
    given_ = utility(costs, distances, np.ones((3, 3), bool), 8.0)
    assert given_.assignment.tolist() == [0, 2]
    assert given_.rounds == ((0, 0, 1.0, 0.2), (1, 2, 1.0, 1.0))


def test_a_target_behind_a_wall_keeps_its_utility():
    # As above, but 0 and 1 do not see each other: robot 1 gets 1 - 0.4 for target 1.
    costs = [[2.0, 3.0, 9.0], [3.0, 4.0, 10.0]]
    distances = [[0.0, 2.0, 30.0], [2.0, 0.0, 30.0], [30.0, 30.0, 0.0]]
    given_ = utility(costs, distances, np.zeros((3, 3), bool), 8.0)
    assert given_.assignment.tolist() == [0, 1]
    assert given_.rounds == ((0, 0, 1.0, 0.2), (1, 1, 1.0, 0.4))


def test_more_robots_than_targets():
    # V = 0.25, 0.5, 0.75, 1 for target 0, and 1 for target 1. Values: robot 0 takes 0 (0.75),
    # then U_0 = 0; robots 1 to 3 have 0 for target 1 (U 1, V 1) and -0.5 at best for target 0:
    # robot 1 takes 1. Then U = (0, 0): robot 2 takes 0 at -0.75, U_0 = -1, robot 3 takes 1.
    costs = [[1.0, 4.0], [2.0, 4.0], [3.0, 4.0], [4.0, 4.0]]
    given_ = utility(costs, [[0.0, 90.0], [90.0, 0.0]], np.ones((2, 2), bool), 8.0)
    assert given_.assignment.tolist() == [0, 1, 0, 1]
    assert [worth for _, _, worth, _ in given_.rounds] == [1.0, 1.0, 0.0, 0.0]


def test_of_equal_values_the_nearer_target_is_taken():
    # beta = 0: every target has value 1 for every robot.
    given_ = utility([[5.0, 3.0, INF]], np.zeros((3, 3)), np.ones((3, 3), bool), 8.0, beta=0.0)
    assert given_.assignment.tolist() == [1]


def test_robots_that_reach_no_target_get_none():
    given_ = utility([[INF], [2.0]], [[0.0]], [[True]], 8.0)
    assert given_.assignment.tolist() == [-1, 0]
    assert utility(np.empty((2, 0)), np.empty((0, 0)), np.empty((0, 0)), 8.0).rounds == ()


@given(situations(), st.sampled_from([0.0, 0.5, 1.0, 3.0]))
def test_assignment_follows_the_equations(situation, beta):
    costs, distances, visible = situation
    given_ = utility(costs, distances, visible, 8.0, beta)
    expected = naive(costs.tolist(), distances.tolist(), visible.tolist(), 8.0, beta)
    assert given_.assignment.tolist() == expected


@pytest.mark.slow
@given(situations(), st.randoms(use_true_random=False))
def test_order_of_robots_and_targets_does_not_matter(situation, random):
    costs, distances, visible = situation
    # No ties: no two costs are equal, and no two differ by a reduction of utility.
    costs = costs + np.sqrt(np.arange(2, costs.size + 2)).reshape(costs.shape) / 100
    rows, columns = ([*range(size)] for size in costs.shape)
    random.shuffle(rows)
    random.shuffle(columns)
    both = np.ix_(columns, columns)
    straight = utility(costs, distances, visible, 8.0).assignment
    shuffled = utility(costs[np.ix_(rows, columns)], distances[both], visible[both], 8.0).assignment
    assert [columns[t] if t >= 0 else -1 for t in shuffled] == straight[rows].tolist()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"distances": [[0.0, 1.0]]}, r"distances has the shape \(1, 2\); for 1 targets"),
        ({"visible": np.ones((2, 2), bool)}, "visible has the shape"),
        ({"overlap_m": 0.0}, "overlap_m is 0.0; it must be positive"),
        ({"beta": -1.0}, "beta is -1.0; it must be 0 or more"),
        ({"worth": [1.0, 1.0]}, "worth must have a finite utility for each of 1 targets"),
        ({"worth": [math.nan]}, "worth must have a finite utility"),
    ],
)
def test_invalid_input_is_rejected(change, message):
    good = {"costs": [[1.0]], "distances": [[0.0]], "visible": [[True]], "overlap_m": 8.0}
    with pytest.raises(InvalidInputError, match=message):
        utility(**(good | change))


def test_goals_that_others_keep_lower_the_utility():
    costs, distances, visible = [[2.0, 3.0]], np.zeros((2, 2)), np.ones((2, 2), bool)
    assert utility(costs, distances, visible, 8.0).assignment.tolist() == [0]
    lost = overlap([[0.0, 6.0]], [[True, True]], 8.0).sum(axis=0)
    assert lost.tolist() == [1.0, 0.25]
    given = utility(costs, distances, visible, 8.0, worth=1.0 - lost)
    assert given.assignment.tolist() == [1]
    assert given.rounds == ((0, 1, 0.75, 1.0),)
