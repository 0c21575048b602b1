import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import DenseCosts
from multisrt.planners.assignment.minpos import UNCOUNTED, minpos
from multisrt.planners.assignment.positions import positions

INF = np.inf
TABLES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=6)
TIED = arrays(float, TABLES, elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, INF]))


@st.composite
def distinct(draw):
    """Tables without ties."""
    shape = draw(TABLES)
    order = draw(st.permutations(range(shape[0] * shape[1])))
    return np.array(order, float).reshape(shape)


def team(table):
    costs = DenseCosts(table)
    return [minpos(costs, robot).choice for robot in range(len(table))]


def ranks(table):
    return positions(DenseCosts(table).table).tolist()


def test_a_robot_passes_a_frontier_that_another_is_nearer_to():
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
    assert ranks(costs)[2] == [0, 1, 1, 1]
    assert minpos(DenseCosts(costs), 2).choice == 0
    assert closest(DenseCosts(costs), 2) == 3
    assert team(costs) == [1, 2, 0]


def test_a_group_near_one_frontier_splits_evenly():
    # Figure 6: four robots in a corridor of 20 m at 2, 3, 4 and 5 m, a frontier at each end.
    places = np.array([2.0, 3.0, 4.0, 5.0])
    costs = np.column_stack([places, 20.0 - places])
    assert [closest(DenseCosts(costs), robot) for robot in range(4)] == [0, 0, 0, 0]
    # Towards the left end their positions are 0, 1, 2, 3; towards the right end 3, 2, 1, 0.
    assert ranks(costs) == [[0, 3], [1, 2], [2, 1], [3, 0]]
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


def test_lower_number_is_in_front_at_equal_distance():
    assert ranks([[3.0, 4.0], [3.0, 9.0]]) == [[0, 0], [1, 1]]
    # Also where the tie is at its second nearest frontier and the other's nearest.
    assert ranks([[3.0, 1.0], [3.0, 9.0]]) == [[0, 0], [1, 1]]


def test_only_reachable_frontiers_are_chosen():
    # Robot 1 is in position 0 nowhere that it can reach.
    costs = [[1.0, 2.0, INF], [INF, 3.0, INF]]
    assert team(costs) == [0, 1]
    assert team([[INF, INF]]) == [None]
    assert team(np.empty((2, 0))) == [None, None]


@given(distinct())
def test_without_ties_it_is_algorithm_3(costs):
    robots, frontiers = costs.shape
    for i in range(robots):
        row = [
            sum(costs[k, j] < costs[i, j] for k in range(robots) if k != i)
            for j in range(frontiers)
        ]
        assert ranks(costs)[i] == row
        choice = minpos(DenseCosts(costs), i).choice
        assert choice == min(range(frontiers), key=lambda j: (row[j], costs[i, j]))


@given(TIED)
def test_choice_has_the_lowest_position_then_cost(costs):
    for i, row in enumerate(ranks(costs)):
        reachable = [j for j in range(costs.shape[1]) if costs[i, j] < INF]
        best = min(reachable, key=lambda j: (row[j], costs[i, j], j), default=None)
        assert minpos(DenseCosts(costs), i).choice == best


@given(TIED)
def test_counted_positions_are_right_or_cut_at_the_lowest(costs):
    expected = np.array(ranks(costs))
    for i in range(len(costs)):
        chosen = minpos(DenseCosts(costs), i)
        counted = chosen.positions != UNCOUNTED
        others = counted.copy()
        others[i] = False
        assert (chosen.positions[others] == expected[others]).all()
        assert (chosen.positions[i, counted[i]] <= expected[i, counted[i]]).all()
        if chosen.choice is not None:
            assert chosen.positions[i, chosen.choice] == expected[i, chosen.choice]


@given(TIED)
def test_positions_are_a_permutation_in_every_column(costs):
    table = np.array(ranks(costs))
    assert (np.sort(table, axis=0) == np.arange(len(costs))[:, None]).all()
    # No robot comes before one that is nearer.
    for i, j in np.ndindex(costs.shape):
        nearer = (costs[:, j] < costs[i, j]).sum()
        assert nearer <= table[i, j] < nearer + (costs[:, j] == costs[i, j]).sum()


@given(distinct(), st.randoms(use_true_random=False))
def test_order_of_robots_and_frontiers_does_not_matter(costs, random):
    rows, columns = ([*range(size)] for size in costs.shape)
    random.shuffle(rows)
    random.shuffle(columns)
    straight = team(costs)
    shuffled = team(costs[np.ix_(rows, columns)])
    assert [columns[j] for j in shuffled] == [straight[i] for i in rows]


def test_robot_outside_the_table_is_rejected():
    with pytest.raises(InvalidInputError, match="robot is 2; the table has rows 0 to 1"):
        minpos(DenseCosts([[1.0], [2.0]]), 2)
