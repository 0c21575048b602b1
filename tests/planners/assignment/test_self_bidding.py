from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy.optimize import linear_sum_assignment

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.self_bidding import CohesionRadii, minimum_matching, self_bidding

INF = np.inf
TABLES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=4)
BIDS = arrays(float, TABLES, elements=st.sampled_from([-3.0, -1.0, 0.0, 1.0, 2.0, 5.0, INF]))


def bid(robot, rho, a, path_gap=None, frontier_gap=None, **numbers):
    near = np.ones(np.shape(a))
    return self_bidding(
        robot,
        rho,
        a,
        near if path_gap is None else path_gap,
        near if frontier_gap is None else frontier_gap,
        CohesionRadii(**({"range_m": 10.0, "diagonal_m": 50.0} | numbers)),
    )


def all_matchings(bids):
    """Every matching of robots to frontiers or to none, without infinite bids."""
    robots, frontiers = bids.shape
    columns = [*range(frontiers), *[-1] * robots]
    for chosen in set(permutations(columns, robots)):
        if all(j < 0 or np.isfinite(bids[i, j]) for i, j in enumerate(chosen)):
            yield chosen


def best_by_brute_force(bids, path_lengths):
    # The most finite bids, then the minimum sum, then the nearest frontier robot by robot.
    def cost(chosen):
        real = [(i, j) for i, j in enumerate(chosen) if j >= 0]
        liked = [(j < 0, path_lengths[i, j] if j >= 0 else 0.0, j) for i, j in enumerate(chosen)]
        return -len(real), sum(bids[i, j] for i, j in real), liked

    return list(min(all_matchings(bids), key=cost))


@given(BIDS, st.data())
def test_matchings_are_optimal_and_ties_are_settled(bids, data):
    path_lengths = data.draw(
        arrays(float, bids.shape, elements=st.sampled_from([0.0, 1.0, 2.0, 3.0]))
    )
    assert minimum_matching(bids, path_lengths).tolist() == best_by_brute_force(bids, path_lengths)


@given(arrays(float, array_shapes(min_dims=2, max_dims=2, max_side=9), elements=st.floats(-90, 90)))
def test_matching_costs_as_much_as_the_padded_square(bids):
    # The paper's own padding: a square of the larger size, a very large number elsewhere.
    size = max(bids.shape)
    square = np.full((size, size), 1e6)
    square[: bids.shape[0], : bids.shape[1]] = bids
    rows, columns = linear_sum_assignment(square)
    real = (rows < bids.shape[0]) & (columns < bids.shape[1])
    matching = minimum_matching(bids, np.zeros(bids.shape))
    robots = np.flatnonzero(matching >= 0)
    assert len(robots) == min(bids.shape)
    total = bids[robots, matching[robots]].sum()
    assert total == pytest.approx(bids[rows[real], columns[real]].sum(), abs=2e-6)


@given(BIDS, st.randoms(use_true_random=False))
def test_order_of_robots_and_frontiers_does_not_matter(bids, random):
    # No ties: every entry has a power of two of its own.
    bids = bids + 2.0 ** -np.arange(1, bids.size + 1).reshape(bids.shape)
    rows, columns = ([*range(size)] for size in bids.shape)
    random.shuffle(rows)
    random.shuffle(columns)
    path_lengths = np.zeros(bids.shape)
    straight = minimum_matching(bids, path_lengths)
    shuffled = minimum_matching(bids[np.ix_(rows, columns)], path_lengths)
    assert [columns[j] if j >= 0 else -1 for j in shuffled] == straight[rows].tolist()


def test_bids_of_figure_3():
    # Figure 3: robot r2 (row 1) at its goal bids for f5 (column 4). Exploitation
    # rho_2 + a_2^5 = 0 + 6, exploration rho_1 + a_1^5 = 3 + 11, so b = 6 - 14 = -8. f1 lies
    # outside the circle of phi = 0.9 * 10 around its companion and is left out.
    a = [[2.0, 4.0, 5.0, 9.0, 11.0], [15.0, 12.0, 8.0, 7.0, 6.0]]
    away = [[1.0] * 5, [9.5, 8.0, 5.0, 4.0, 6.0]]
    decision = bid(1, [3.0, 0.0], a, frontier_gap=away)
    assert decision.phi_m == 9.0
    assert decision.bids[1].tolist() == [INF, 12.0 - 7.0, 8.0 - 8.0, 7.0 - 12.0, -8.0]
    assert decision.bids[0].tolist() == [5 - 15, 7 - 12, 8 - 8, 12 - 7, 14 - 6]
    # Robot 1 takes f1 at -10, robot 2 f5 at -8.
    assert decision.matching.tolist() == [0, 4]
    assert decision.choice == 4


def test_adjacent_frontiers_go_to_two_robots():
    # Figure 1a: f1 and f2 are next to each other, so two robots go to explore what one could
    # (which is what the stop signal is for). Robot 0 bids 4 - 5 and 5 - 5, robot 1 1 and 0:
    # -1 + 0 is less than 0 + 1.
    a = [[4.0, 5.0], [5.0, 5.0]]
    decisions = [bid(robot, [0.0, 0.0], a) for robot in (0, 1)]
    assert [decision.choice for decision in decisions] == [0, 1]


def test_three_robots_compare_with_the_mean_of_the_others():
    # Robot 0 on f0: 4 - (6 + 8) / 2 = -3. Robot 1: 6 - (4 + 8) / 2 = 0. Robot 2: 8 - 5 = 3.
    assert bid(0, [1.0, 2.0, 3.0], [[3.0], [4.0], [5.0]]).bids.tolist() == [[-3.0], [0.0], [3.0]]


def test_a_single_robot_takes_the_nearest():
    # Gaps do not matter without other robots.
    far = np.full((1, 3), INF)
    decision = bid(0, [2.0], [[7.0, 4.0, 5.0]], far, far)
    assert decision.bids.tolist() == [[9.0, 6.0, 7.0]]
    assert decision.choice == 1
    assert len(decision.steps) == 1


def test_radius_grows_until_the_robot_has_a_bid():
    # phi = 10 * (0.9, 1.4, 1.9): the path to f0 strays 16 m, to f1 25 m; f1 itself is near.
    path_gap = [[16.0, 25.0], [1.0, 1.0]]
    decision = bid(0, [0.0, 0.0], [[20.0, 5.0], [3.0, 4.0]], path_gap)
    assert [step.phi_m for step in decision.steps] == [9.0, 14.0, 19.0]
    assert [np.isfinite(step.bids[0]).tolist() for step in decision.steps] == [
        [False, False],
        [False, False],
        [True, False],
    ]
    # Robot 1 bids all along. f0 to robot 0, f1 to robot 1 is the largest matching.
    assert decision.matching.tolist() == [0, 1]


def test_factors_of_the_radius_are_options():
    path_gap = [[16.0], [1.0]]
    decision = bid(0, [0.0, 0.0], [[20.0], [3.0]], path_gap, first=1.0, step=1.0)
    assert [step.phi_m for step in decision.steps] == [10.0, 20.0]


def test_path_and_frontier_must_both_be_near():
    decision = bid(0, [0, 0], [[1, 2, 3]] * 2, [[8, 9, 1]] * 2, [[1, 1, 9]] * 2)
    assert np.isfinite(decision.bids[0]).tolist() == [True, False, False]


def test_a_virtual_frontier_means_the_nearest_one():
    # One frontier within the radius, and robot 0 bids less: 1 - 6 against 6 - 1. Robot 1 goes to
    # its nearest, the same one, which holds the bridge.
    gap = [[1.0, 99.0], [1.0, 99.0]]
    decision = bid(1, [0.0, 0.0], [[1.0, 9.0], [6.0, 8.0]], gap)
    assert decision.matching.tolist() == [0, -1]
    assert decision.choice == 0


def test_search_ends_beyond_the_diagonal():
    # f0 is out of reach of robot 0: no phi helps. 9, 14, ..., 54 > 50.
    decision = bid(0, [0.0, 0.0], [[INF], [3.0]])
    assert decision.phi_m == 54.0
    assert decision.choice is None
    assert decision.matching.tolist() == [-1, 0]


def test_a_robot_without_a_path_counts_with_the_diagonal():
    assert bid(0, [0.0, 0.0], [[8.0], [INF]]).bids.tolist() == [[8.0 - 50.0], [INF]]
    # Unless a way in the table is longer still.
    longer = bid(0, [0.0, 0.0], [[8.0, 70.0], [INF, 1.0]])
    assert longer.bids[0].tolist() == [8.0 - 70.0, 69.0]


def test_unlimited_range_breaks_no_bridge():
    decision = bid(0, [0.0, 0.0], [[5.0], [1.0]], [[900.0]] * 2, range_m=INF)
    assert np.isfinite(decision.bids).all()


def test_rounding_does_not_decide_equally_good_matchings():
    # In a corridor robots at 0 and 3 m and frontiers at 10 and 14 m: both matchings sum to 0.
    # Shifted by any offset they differ in the last digits only.
    for offset in np.linspace(0.0, 1.0, 37):
        robots, frontiers = np.array([0.0, 3.0]) + offset, np.array([10.0, 14.0]) + offset / 3.0
        a = np.abs(frontiers - robots[:, None])
        assert bid(0, [0.0, 0.0], a).matching.tolist() == [0, 1]


@given(
    arrays(float, (3, 4), elements=st.integers(0, 30)),
    arrays(float, (3, 4), elements=st.integers(0, 40)),
)
def test_robots_with_the_same_radius_decide_alike(a, gap):
    decisions = [bid(robot, [0.0, 2.0, 5.0], a, gap) for robot in range(3)]
    for decision in decisions[1:]:
        if decision.phi_m == decisions[0].phi_m:
            assert decision.matching.tolist() == decisions[0].matching.tolist()
            assert (decision.bids == decisions[0].bids).all()


@given(
    arrays(float, (3, 4), elements=st.integers(0, 30)),
    arrays(float, (3,), elements=st.integers(0, 30)),
)
def test_what_is_left_of_paths_decides_only_who_goes_without(a, rho):
    # With a frontier for each robot the bids of a row differ by one number, and nothing else does.
    for robot in range(3):
        assert bid(robot, rho, a).choice == bid(robot, [0.0, 0.0, 0.0], a).choice


def test_the_robot_with_more_of_its_path_left_goes_without():
    # One frontier, 1 m from both goals.
    a = [[1.0], [1.0]]
    assert bid(0, [5.0, 2.0], a).matching.tolist() == [-1, 0]
    assert bid(0, [2.0, 5.0], a).matching.tolist() == [0, -1]


def test_radii_too_small_for_a_map_grow_faster():
    usual = CohesionRadii(range_m=10.0, diagonal_m=50.0)
    assert [usual.radius_m(k) for k in range(3)] == [9.0, 14.0, 19.0]
    for tiny in (CohesionRadii(range_m=1e-6, diagonal_m=50.0), replace(usual, step=1e-7)):
        assert tiny.radius_m(0) == 0.9 * tiny.range_m
        assert tiny.radius_m(9_999) < 50.0 + 0.9 * tiny.range_m
        assert tiny.radius_m(10_000) >= 50.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robot": 1}, "robot is 1; the table has rows 0 to 0"),
        ({"a": [[1.0], [2.0]]}, "a has 2 rows; rho has 1 robots"),
        ({"path_gap": [[1.0, 2.0]]}, r"path_gap has the shape \(1, 2\); a has \(1, 1\)"),
        ({"step": 0.0}, "step is 0.0; it must be positive"),
        ({"diagonal_m": INF}, "diagonal_m is inf; it must be positive"),
    ],
)
def test_invalid_input_is_rejected(change, message):
    good = {"robot": 0, "rho": [0.0], "a": [[1.0]]}
    with pytest.raises(InvalidInputError, match=message):
        bid(**(good | change))
