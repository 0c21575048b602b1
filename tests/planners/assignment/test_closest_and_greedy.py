import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.greedy import greedy

INF = np.inf
TABLES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=6)
# Few values, so that ties are frequent; some without a way.
TIED = arrays(float, TABLES, elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, 7.0, INF]))


@st.composite
def distinct(draw, least: int = 1):
    """Tables without ties."""
    shape = draw(array_shapes(min_dims=2, max_dims=2, min_side=least, max_side=6))
    order = draw(st.permutations(range(shape[0] * shape[1])))
    return np.array(order, float).reshape(shape)


def greedy_by_hand(costs):
    # Algorithm 2 with lists, looking at every pair each time.
    robots = [i for i, row in enumerate(costs) if min(row) < INF]
    everything = list(range(len(costs[0])))
    left, got = list(everything), [-1] * len(costs)
    while robots:
        cost, i, j = min(((costs[i][j], i, j) for i in robots for j in left), default=(INF, 0, 0))
        if cost == INF:
            left = list(everything)
            continue
        got[i] = j
        robots.remove(i)
        left.remove(j)
    return got


def test_two_robots_take_the_same_closest_frontier():
    # Figure 2: nobody looks at the others, and areas are left without robots.
    assert [closest(row) for row in ([2.0, 8.0], [3.0, 9.0])] == [0, 0]


def test_one_behind_the_other_robots_part_at_a_crossing():
    # Figure 3: at the crossing three ways are equally near; each robot that has gone into one
    # has pushed its frontier 5 m further when the next arrives.
    costs, chosen = np.array([4.0, 4.0, 4.0]), []
    for _ in range(3):
        chosen.append(closest(costs))
        costs[chosen[-1]] += 5.0
    assert sorted(chosen) == [0, 1, 2]


@given(TIED)
def test_closest_is_the_first_of_the_least(costs):
    for row in costs.tolist():
        choice = closest(row)
        assert choice == (row.index(min(row)) if min(row) < INF else None)


def test_no_frontier():
    assert closest([]) is None
    assert greedy(np.empty((2, 0))).assignment.tolist() == [-1, -1]


def test_greedy_gives_robots_different_frontiers():
    # Figure 4. The least of all is 1 (robot 1, frontier 0); of what is left, robots 0 and 2 and
    # frontiers 1 and 2, 6 (robot 0, frontier 1); then robot 2 has frontier 2 left, at 9.
    given_ = greedy([[2.0, 6.0, 8.0], [1.0, 3.0, 7.0], [3.0, 7.0, 9.0]])
    assert given_.assignment.tolist() == [1, 0, 2]
    assert given_.rounds == ((1, 0, 1.0, 1 / 9), (0, 1, 1.0, 6 / 9), (2, 2, 1.0, 1.0))


def test_frontiers_start_again_when_they_are_used_up():
    # 1 (robot 2, f0), 4 (robot 0, f1), then both again: 3 (robot 1, f0), 9 (robot 3, f1).
    costs = [[2.0, 4.0], [3.0, 5.0], [1.0, 6.0], [5.0, 9.0]]
    assert greedy(costs).assignment.tolist() == [1, 0, 0, 1]


def test_nobody_stands_idle_for_a_frontier_that_it_cannot_reach():
    # After robot 0 has frontier 0, frontier 1 is left, which nobody reaches.
    assert greedy([[1.0, INF], [2.0, INF], [INF, INF]]).assignment.tolist() == [0, 0, -1]


@given(TIED)
def test_greedy_is_algorithm_2(costs):
    assert greedy(costs).assignment.tolist() == greedy_by_hand(costs.tolist())


@given(distinct())
def test_greedy_balances_the_frontiers(costs):
    # Criterion 1: the numbers of robots at any two frontiers differ by one at most.
    robots_at = np.bincount(greedy(costs).assignment, minlength=costs.shape[1])
    assert robots_at.max() - robots_at.min() <= 1


@given(distinct(), st.randoms(use_true_random=False))
def test_greedy_does_not_depend_on_the_order_of_robots_and_frontiers(costs, random):
    rows, columns = ([*range(size)] for size in costs.shape)
    random.shuffle(rows)
    random.shuffle(columns)
    straight = greedy(costs).assignment
    shuffled = greedy(costs[np.ix_(rows, columns)]).assignment
    assert [columns[j] for j in shuffled] == straight[rows].tolist()


@pytest.mark.parametrize(
    ("costs", "message"),
    [
        ([[1.0, -2.0]], r"costs is -2.0 at \[0, 1\]; distances are 0 or more"),
        ([[1.0], [np.nan]], r"costs is nan at \[1, 0\]"),
        ([1.0, 2.0], "costs has 1 dimensions; it must have 2"),
    ],
)
def test_what_is_no_table_is_refused(costs, message):
    with pytest.raises(InvalidInputError, match=message):
        greedy(costs)


def test_a_decision_keeps_what_it_was_made_on():
    costs = np.array([[1.0, 2.0]])
    given_ = greedy(costs)
    costs[:] = 9.0
    assert given_.costs.tolist() == [[1.0, 2.0]]
    assert not given_.costs.flags.writeable
