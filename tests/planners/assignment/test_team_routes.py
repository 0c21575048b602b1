"""Routes of a team against all permutations, and worked out by hand."""

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.team_routes import team_routes

MEAN_WEIGHT = 0.1


def length_of(route, costs, lengths, searches):
    """Length of one route, from its definition: searches count by half before and after."""
    if not route:
        return 0.0
    legs = [costs[route[0]], *(lengths[a][b] for a, b in itertools.pairwise(route))]
    return sum(legs) + sum(searches[k] for k in route) - searches[route[-1]] / 2.0


def distances_of(places):
    step = places[:, None] - places
    return np.hypot(step[..., 0], step[..., 1])


def test_robots_take_the_sides_they_are_on():
    x = np.array([-4.0, -1.0, 12.0])
    found = team_routes([np.abs(x), np.abs(x - 10.0)], np.abs(x[:, None] - x))
    assert found.routes == ((1, 0), (2,))
    assert found.lengths_m == (4.0, 2.0)


def test_a_near_robot_leaves_a_target_to_one_with_a_short_route():
    # Robot 0 is nearer to all; three on one side and one on the other are divided all the same.
    x = np.array([1.0, 2.0, 3.0, -5.0])
    found = team_routes([np.abs(x), np.abs(x + 11.0)], np.abs(x[:, None] - x))
    assert found.routes == ((0, 1, 2), (3,))


def test_what_has_to_be_searched_longest_comes_last():
    # 3 m to the right and 3 m to the left; a search counts by half at the end of a route.
    x = np.array([3.0, -3.0])
    lengths = np.abs(x[:, None] - x)
    assert team_routes([np.abs(x)], lengths, service_lengths=[4.0, 0.0]).routes == ((1, 0),)
    assert team_routes([np.abs(x)], lengths, service_lengths=[0.0, 4.0]).routes == ((0, 1),)
    assert team_routes([np.abs(x)], lengths, service_lengths=[0.0, 4.0]).lengths_m == (11.0,)


def test_the_search_begins_with_the_goals():
    # Both robots are as near to both targets.
    costs, lengths = np.full((2, 2), 5.0), [[0.0, 6.0], [6.0, 0.0]]
    assert team_routes(costs, lengths, goals=[0, 1]).routes == ((0,), (1,))
    assert team_routes(costs, lengths, goals=[1, 0]).routes == ((1,), (0,))
    assert team_routes(costs, lengths, goals=[1, 1]).routes == ((1,), (0,))


def test_targets_without_a_path_are_left_out():
    inf = np.inf
    costs = [[1.0, inf, 4.0], [inf, inf, 2.0]]
    lengths = 3.0 - 3.0 * np.eye(3)
    assert team_routes(costs, lengths).routes == ((0,), (2,))
    assert team_routes(costs, lengths, goals=[1, 0]).routes == ((0,), (2,))
    assert team_routes(costs, lengths).left_out == (1,)
    assert team_routes([[inf, inf, inf]], lengths).routes == ((),)
    assert team_routes([[inf, inf, inf]], lengths).left_out == (0, 1, 2)
    nothing = team_routes(np.empty((2, 0)), np.empty((0, 0)))
    assert nothing.routes == ((), ())
    assert nothing.longest_m == 0.0


def test_no_target_is_left_out_for_a_shorter_route():
    # Robot 1 may not go to target 1, and no path joins the targets.
    inf = np.inf
    found = team_routes([[1.0, 1.0], [1.0, inf]], [[0.0, inf], [inf, 0.0]])
    assert found.routes == ((1,), (0,))
    assert found.left_out == ()


def test_the_cost_is_the_longest_and_a_tenth_of_the_mean():
    found = team_routes([[20.0, 20.0]] * 2, [[0.0, 40.0], [40.0, 0.0]], initial_lengths=[0.0, 25.0])
    assert found.lengths_m == (20.0, 45.0)
    assert found.cost_m == pytest.approx(45.0 + 0.1 * 32.5)


def test_a_robot_gets_no_target_without_a_path_between_others_either():
    # Robot 1 is on the line but may not go to target 1, which lies between the others.
    x = np.array([1.0, 2.0, 3.0])
    costs = [np.hypot(x - 2.0, 20.0), np.where(x == 2.0, np.inf, x)]
    found = team_routes(costs, np.abs(x[:, None] - x))
    assert found.routes == ((1,), (0, 2))


def test_two_ends_of_a_line_are_shared():
    # One robot in the middle drives to one end and back through the middle to the other: 60 m.
    ends = np.array([[0.0, 40.0], [40.0, 0.0]])
    assert team_routes([[20.0, 20.0]], ends).longest_m == 60.0
    both = [[20.0, 20.0]] * 2
    assert team_routes(both, ends).longest_m == 20.0
    # With 25 m to drive before, sharing is still better, with 65 m it is not.
    assert team_routes(both, ends, initial_lengths=[0.0, 25.0]).longest_m == 45.0
    assert team_routes(both, ends, initial_lengths=[0.0, 65.0]).lengths_m == (60.0, 0.0)


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 4), st.integers(0, 12), st.integers(0, 2**32 - 1))
def test_every_target_is_on_one_route(robots, targets, seed):
    rng = np.random.default_rng(seed)
    places, starts = rng.uniform(0, 10, (targets, 2)), rng.uniform(0, 10, (robots, 2))
    costs = np.hypot(*(starts[:, None] - places).transpose(2, 0, 1))
    lengths, searches = distances_of(places), rng.uniform(0, 5, targets)
    goals = [int(rng.integers(targets)) if targets and rng.uniform() < 0.5 else None] * robots
    found = team_routes(costs, lengths, goals=goals, service_lengths=searches)
    assert sorted(itertools.chain.from_iterable(found.routes)) == list(range(targets))
    assert found.lengths_m == pytest.approx(
        [
            length_of(route, row, lengths, searches)
            for route, row in zip(found.routes, costs, strict=True)
        ]
    )
    assert team_routes(costs, lengths, goals=goals, service_lengths=searches) == found


def test_the_best_routes_of_small_teams_are_found():
    rng = np.random.default_rng(3)
    excess = []
    for _ in range(20):
        places, starts = rng.uniform(0, 10, (5, 2)), rng.uniform(0, 10, (2, 2))
        costs = np.hypot(*(starts[:, None] - places).transpose(2, 0, 1))
        lengths, searches = distances_of(places), rng.uniform(0, 3, 5)
        best = np.inf
        for order in itertools.permutations(range(5)):
            for cut in range(6):
                both = [
                    length_of(part, row, lengths, searches)
                    for part, row in zip((order[:cut], order[cut:]), costs, strict=True)
                ]
                best = min(best, max(both) + MEAN_WEIGHT * float(np.mean(both)))
        own = team_routes(costs, lengths, service_lengths=searches).lengths_m
        excess.append((max(own) + MEAN_WEIGHT * float(np.mean(own))) / best)
    assert min(excess) > 1.0 - 1e-9
    assert np.median(excess) < 1.0 + 1e-9
    assert max(excess) < 1.15


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"path_lengths": np.zeros((2, 3))}, "path_lengths has the shape"),
        ({"costs": np.empty((0, 2))}, "costs"),
        ({"service_lengths": [1.0]}, "service_lengths has the shape"),
        ({"service_lengths": [1.0, -1.0]}, "service_lengths"),
        ({"initial_lengths": [1.0, 2.0]}, "initial_lengths has the shape"),
        ({"goals": [0, 1]}, "one for each robot"),
        ({"goals": [2]}, "goals"),
        ({"costs": [[1.0, np.nan]]}, "costs"),
    ],
)
def test_bad_tables_are_refused(given, message):
    tables: dict[str, Any] = {"costs": [[1.0, 2.0]], "path_lengths": np.zeros((2, 2))}
    with pytest.raises(InvalidInputError, match=message):
        team_routes(**(tables | given))
