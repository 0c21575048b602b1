import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import DenseCosts
from multisrt.planners.assignment.greedy import greedy
from multisrt.planners.assignment.minpos import UNCOUNTED, minpos
from multisrt.planners.assignment.positions import positions

INF = np.inf
TABLES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=6)
TIED = arrays(float, TABLES, elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, 7.0, INF]))


class LazyCosts:
    """An oracle that stops at the limit, and records what it was asked."""

    def __init__(self, table, slack: float = 0.0) -> None:
        self.table = np.asarray(table, float)
        self.slack = slack
        self.searched: list[tuple[int, float]] = []
        self.ahead: list[tuple[int, int]] = []

    @property
    def shape(self):
        return self.table.shape

    def lower_bounds(self):
        # Euclidean distances know nothing of walls: no bound is infinite.
        finite = np.where(np.isfinite(self.table), self.table, 0.0)
        return np.maximum(finite - self.slack, 0.0)

    def nearest(self, robot, frontiers, limit_m=math.inf):
        self.searched.append((robot, limit_m))
        found = [
            (float(self.table[robot, j]), int(j))
            for j in frontiers
            if self.table[robot, j] <= limit_m and self.table[robot, j] < INF
        ]
        return min(found, default=None)

    def robots_ahead(self, robot, frontier):
        column = positions(self.table)[:, frontier]
        for k in np.argsort(column)[: column[robot]].tolist():
            self.ahead.append((frontier, k))
            yield k


@given(TIED, st.sampled_from([0.0, 0.5, 2.0, 9.0]))
def test_lazy_and_dense_costs_give_the_same_choices(table, slack):
    dense, lazy = DenseCosts(table), LazyCosts(table, slack)
    assert greedy(lazy).rounds == greedy(dense).rounds
    for robot in range(len(table)):
        assert closest(lazy, robot) == closest(dense, robot)
        chosen, expected = minpos(lazy, robot), minpos(dense, robot)
        assert chosen.choice == expected.choice
        assert chosen.positions.tolist() == expected.positions.tolist()


def test_greedy_searches_no_farther_than_the_cheapest_pair():
    # Bounds are 1 m below the costs. Robot 1 is asked first (bound 1) and finds 2 m. Robot 0
    # (bound 2) could be as cheap, so that its search ends at 2 m. Robot 2 (bound 7) is not asked.
    lazy = LazyCosts([[3.0, 9.0], [2.0, 4.0], [8.0, 9.0]], slack=1.0)
    assert greedy(lazy, until=1).rounds == ((1, 0, 2.0),)
    assert lazy.searched == [(1, INF), (0, 2.0)]


def test_greedy_keeps_what_it_found():
    # Robot 0 gets f0. Robot 1 was not searched for, as its bound is above 1 m; robot 1 then gets
    # f1. Of robot 2 the first search ends at 1 m, the second at 4 m.
    lazy = LazyCosts([[1.0, 5.0, 5.0], [9.0, 4.0, 8.0], [1.5, 6.0, 7.0]], slack=1.0)
    assert [pair[:2] for pair in greedy(lazy).rounds] == [(0, 0), (1, 1), (2, 2)]
    assert lazy.searched == [(0, INF), (2, 1.0), (1, INF), (2, INF)]


def test_minpos_counts_positions_up_to_the_lowest():
    # Towards f0, the nearest, one robot is ahead. Towards f1 three are, of whom one is counted.
    # Towards f2 none is, so that f3 is not looked at.
    lazy = LazyCosts(
        [[2.0, 3.0, 4.0, 5.0], [1.0, 2.0, 9.0, 9.0], [8.0, 1.0, 9.0, 9.0], [8.0, 2.5, 9.0, 9.0]]
    )
    chosen = minpos(lazy, 0)
    assert chosen.choice == 2
    assert lazy.ahead == [(0, 1), (1, 2)]
    assert chosen.positions[0].tolist() == [1, 1, 0, UNCOUNTED]
    assert chosen.positions[1].tolist() == [0, UNCOUNTED, UNCOUNTED, UNCOUNTED]


@given(TIED, st.data())
def test_nearest_frontier_is_the_minimum_within_the_limit(table, data):
    costs = DenseCosts(table)
    robot = data.draw(st.integers(0, len(table) - 1))
    frontiers = data.draw(st.lists(st.integers(0, table.shape[1] - 1), unique=True))
    limit = data.draw(st.sampled_from([0.0, 2.5, INF]))
    found = costs.nearest(robot, np.array(frontiers, np.int64), limit)
    row = [table[robot, j] for j in frontiers]
    if min(row, default=INF) in (INF,) or min(row) > limit:
        assert found is None
    else:
        assert found == (min(row), frontiers[row.index(min(row))])


@given(TIED)
def test_robots_ahead_are_those_of_lower_position(table):
    costs, ranks = DenseCosts(table), positions(DenseCosts(table).table)
    for robot, frontier in np.ndindex(table.shape):
        ahead = list(costs.robots_ahead(robot, frontier))
        assert [ranks[k, frontier] for k in ahead] == [*range(ranks[robot, frontier])]


@pytest.mark.parametrize(
    ("costs", "message"),
    [
        ([[1.0, -2.0]], r"costs is -2.0 at \[0, 1\]; distances are 0 or more"),
        ([[1.0], [np.nan]], r"costs is nan at \[1, 0\]"),
        ([1.0, 2.0], "costs has 1 dimensions; it must have 2"),
    ],
)
def test_invalid_tables_are_rejected(costs, message):
    with pytest.raises(InvalidInputError, match=message):
        DenseCosts(costs)


def test_table_is_a_read_only_copy():
    table = np.array([[1.0, 2.0]])
    costs = DenseCosts(table)
    table[:] = 9.0
    assert costs.table.tolist() == [[1.0, 2.0]]
    assert not costs.table.flags.writeable
