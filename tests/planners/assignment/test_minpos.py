import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.minpos import minpos

INF = np.inf
TABLES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=6)
TIED = arrays(float, TABLES, elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, INF]))


@st.composite
def distinct(draw):
    """Tables without ties."""
    shape = draw(TABLES)
    order = draw(st.permutations(range(shape[0] * shape[1])))
    return np.array(order, float).reshape(shape)


def team(costs):
    return [minpos(costs, robot).choice for robot in range(len(costs))]


def test_a_robot_passes_by_a_frontier_that_another_is_nearer_to():
    # Figure 5: robot 5 goes to F0, though F3 is closer to it and has no robot assigned. It is
    # second for F1, F2 and F3: robot 1 is nearer to F1, and robot 3 to F2 and F3, of which
    # robot 3 takes F2.
    costs = np.array(
        [
            # F0    F1    F2    F3
            [18.0, 1.0, 15.0, 14.0],  # robot 1
            [16.0, 13.0, 2.0, 4.0],  # robot 3
            [10.0, 12.0, 8.0, 5.0],  # robot 5
        ]
    )
    decision = minpos(costs, 2)
    assert decision.ranks[2] == (0, 1, 1, 1)
    assert decision.choice == 0
    assert closest(costs[2]) == 3
    assert team(costs) == [1, 2, 0]


def test_a_group_near_one_frontier_splits_evenly():
    # Figure 6: four robots in a corridor of 20 m at 2, 3, 4 and 5 m, a frontier at each end.
    places = np.array([2.0, 3.0, 4.0, 5.0])
    costs = np.column_stack([places, 20.0 - places])
    assert [closest(row) for row in costs] == [0, 0, 0, 0]
    # Towards the left end their positions are 0, 1, 2, 3; towards the right end 3, 2, 1, 0.
    assert minpos(costs, 0).ranks == ((0, 3), (1, 2), (2, 1), (3, 0))
    assert team(costs) == [0, 0, 1, 1]


def test_robots_at_one_place_take_turns():
    # F1 is nearest, then F2, then F0. The paper's strict comparison has all at position 0
    # everywhere, hence all at F1.
    assert team([[7.0, 2.0, 5.0]] * 3) == [1, 2, 0]


@given(st.integers(1, 9), st.lists(st.integers(1, 4), min_size=1, max_size=5))
def test_robots_at_one_place_spread_evenly(robots, row):
    chosen = team(np.array([row] * robots, float))
    # In the order of distance, over and over.
    order = sorted(range(len(row)), key=lambda j: (row[j], j))
    assert chosen == [order[robot % len(row)] for robot in range(robots)]


def test_the_lower_id_is_in_front_at_equal_distance():
    assert minpos([[3.0, 4.0], [3.0, 9.0]], 0).ranks == ((0, 0), (1, 1))
    # Also where the tie is for its second nearest frontier and the other's nearest.
    assert minpos([[3.0, 1.0], [3.0, 9.0]], 0).ranks == ((0, 0), (1, 1))


def test_only_frontiers_within_reach_are_chosen():
    # Robot 1 is in position 0 nowhere that it can reach.
    costs = [[1.0, 2.0, INF], [INF, 3.0, INF]]
    assert team(costs) == [0, 1]
    assert team([[INF, INF]]) == [None]
    assert team(np.empty((2, 0))) == [None, None]


@given(distinct())
def test_without_ties_it_is_algorithm_3(costs):
    robots, frontiers = costs.shape
    for i in range(robots):
        row = tuple(
            sum(costs[k, j] < costs[i, j] for k in range(robots) if k != i)
            for j in range(frontiers)
        )
        decision = minpos(costs, i)
        assert decision.ranks[i] == row
        assert decision.choice == min(range(frontiers), key=lambda j: (row[j], costs[i, j]))


@given(TIED)
def test_positions_are_a_permutation_in_every_column(costs):
    ranks = np.array(minpos(costs, 0).ranks)
    assert (np.sort(ranks, axis=0) == np.arange(len(costs))[:, None]).all()
    # Nobody comes before a robot that is nearer.
    for i, j in np.ndindex(costs.shape):
        nearer = (costs[:, j] < costs[i, j]).sum()
        assert nearer <= ranks[i, j] < nearer + (costs[:, j] == costs[i, j]).sum()


@given(TIED)
def test_robots_that_know_the_same_decide_alike(costs):
    decisions = [minpos(costs, robot) for robot in range(len(costs))]
    assert all(decision.ranks == decisions[0].ranks for decision in decisions)


@given(distinct(), st.randoms(use_true_random=False))
def test_it_does_not_depend_on_the_order_of_robots_and_frontiers(costs, random):
    rows, columns = ([*range(size)] for size in costs.shape)
    random.shuffle(rows)
    random.shuffle(columns)
    straight = team(costs)
    shuffled = team(costs[np.ix_(rows, columns)])
    assert [columns[j] for j in shuffled] == [straight[i] for i in rows]


def test_a_robot_that_is_not_in_the_table_is_refused():
    with pytest.raises(InvalidInputError, match="robot is 2; the table has rows 0 to 1"):
        minpos([[1.0], [2.0]], 2)
