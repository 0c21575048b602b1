import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import DenseCosts

INF = np.inf
TABLES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=6)
# Few values, so that ties are frequent; some entries without a path.
TIED = arrays(float, TABLES, elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, 7.0, INF]))


def test_two_robots_take_the_same_closest_frontier():
    # Figure 2: no robot takes the other into account, and areas are left without robots.
    costs = DenseCosts([[2.0, 8.0], [3.0, 9.0]])
    assert [closest(costs, robot) for robot in (0, 1)] == [0, 0]


def test_robots_in_a_row_part_at_a_crossing():
    # Figure 3: at the crossing three ways are equally near; each robot that has gone into one
    # has pushed its frontier 5 m further when the next arrives.
    costs, chosen = np.array([4.0, 4.0, 4.0]), []
    for _ in range(3):
        target = closest(DenseCosts([costs]), 0)
        assert target is not None
        chosen.append(target)
        costs[target] += 5.0
    assert sorted(chosen) == [0, 1, 2]


@given(TIED)
def test_closest_is_the_first_of_the_minima(table):
    costs = DenseCosts(table)
    for robot, row in enumerate(table.tolist()):
        assert closest(costs, robot) == (row.index(min(row)) if min(row) < INF else None)


def test_no_frontier_gives_no_choice():
    assert closest(DenseCosts(np.empty((1, 0))), 0) is None


def test_robot_outside_the_table_is_rejected():
    with pytest.raises(InvalidInputError, match="robot is 1; the table has rows 0 to 0"):
        closest(DenseCosts([[1.0]]), 1)
