import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.costs import DenseCosts
from multisrt.planners.assignment.greedy import greedy

INF = np.inf
TABLES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=6)
# Few values, so that ties are frequent; some entries without a path.
TIED = arrays(float, TABLES, elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, 7.0, INF]))


@st.composite
def distinct(draw):
    """Tables without ties."""
    shape = draw(TABLES)
    order = draw(st.permutations(range(shape[0] * shape[1])))
    return np.array(order, float).reshape(shape)


def assigned(costs) -> list[int]:
    return greedy(DenseCosts(costs)).assignment.tolist()


def greedy_by_hand(costs):
    # Algorithm 2 with lists, looking at every pair in each iteration.
    robots = [i for i, row in enumerate(costs) if min(row) < INF]
    everything = list(range(len(costs[0])))
    remaining, got = list(everything), [-1] * len(costs)
    while robots:
        pairs = ((costs[i][j], i, j) for i in robots for j in remaining)
        cost, i, j = min(pairs, default=(INF, 0, 0))
        if cost == INF:
            remaining = list(everything)
            continue
        got[i] = j
        robots.remove(i)
        remaining.remove(j)
    return got


def test_robots_get_different_frontiers():
    # Figure 4. The minimum is 1 (robot 1, frontier 0); of the remaining robots 0 and 2 and
    # frontiers 1 and 2, 6 (robot 0, frontier 1); then robot 2 gets frontier 2, at 9.
    given_ = greedy(DenseCosts([[2.0, 6.0, 8.0], [1.0, 3.0, 7.0], [3.0, 7.0, 9.0]]))
    assert given_.assignment.tolist() == [1, 0, 2]
    assert given_.rounds == ((1, 0, 1.0), (0, 1, 6.0), (2, 2, 9.0))


def test_rounds_end_with_the_robot_asked_for():
    costs = DenseCosts([[2.0, 6.0, 8.0], [1.0, 3.0, 7.0], [3.0, 7.0, 9.0]])
    given_ = greedy(costs, until=0)
    assert given_.assignment.tolist() == [1, 0, -1]
    assert given_.rounds == ((1, 0, 1.0), (0, 1, 6.0))


def test_frontiers_are_available_again_when_all_are_assigned():
    # 1 (robot 2, f0), 4 (robot 0, f1), then both again: 3 (robot 1, f0), 9 (robot 3, f1).
    assert assigned([[2.0, 4.0], [3.0, 5.0], [1.0, 6.0], [5.0, 9.0]]) == [1, 0, 0, 1]


def test_no_robot_is_idle_for_an_unreachable_frontier():
    # After robot 0 has frontier 0, frontier 1 remains, which no robot can reach.
    assert assigned([[1.0, INF], [2.0, INF], [INF, INF]]) == [0, 0, -1]


def test_no_frontiers_give_no_assignment():
    assert assigned(np.empty((2, 0))) == [-1, -1]


@given(TIED)
def test_greedy_is_algorithm_2(costs):
    assert assigned(costs) == greedy_by_hand(costs.tolist())


@given(TIED, st.data())
def test_rounds_up_to_a_robot_are_those_of_all(table, data):
    costs = DenseCosts(table)
    robot = data.draw(st.integers(0, len(table) - 1))
    whole, part = greedy(costs).rounds, greedy(costs, until=robot).rounds
    assert part == whole[: len(part)]
    assert len(part) == len(whole) or part[-1].robot == robot


@given(distinct())
def test_greedy_balances_the_frontiers(costs):
    # Criterion 1: the numbers of robots at any two frontiers differ by at most one.
    robots_at = np.bincount(assigned(costs), minlength=costs.shape[1])
    assert robots_at.max() - robots_at.min() <= 1


@given(distinct(), st.randoms(use_true_random=False))
def test_order_of_robots_and_frontiers_does_not_matter(costs, random):
    rows, columns = ([*range(size)] for size in costs.shape)
    random.shuffle(rows)
    random.shuffle(columns)
    straight = np.array(assigned(costs))
    shuffled = assigned(costs[np.ix_(rows, columns)])
    assert [columns[j] for j in shuffled] == straight[rows].tolist()


def test_robot_outside_the_table_is_rejected():
    with pytest.raises(InvalidInputError, match="robot is 2; the table has rows 0 to 1"):
        greedy(DenseCosts([[1.0], [2.0]]), until=2)
