"""Routes of a team over targets: against all routes that there are."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.shared_routes import UNREACHABLE, shared_routes

PLACES = st.lists(st.tuples(st.integers(0, 50), st.integers(0, 50)), min_size=1, max_size=4)


def costs(one, other):
    far = np.abs(np.array(one)[:, None] - np.array(other)[None]).sum(axis=2)
    return far.astype(np.int64)


def length(start, before, tour, targets):
    if not tour:
        return 0
    stops = [start, *(targets[k] for k in tour)]
    return before + int(sum(abs(np.subtract(a, b)).sum() for a, b in itertools.pairwise(stops)))


def optimum(starts, before, targets):
    """Shortest longest route, of all shares and orders."""
    best = None
    for owners in itertools.product(range(len(starts)), repeat=len(targets)):
        longest = 0
        for i, start in enumerate(starts):
            mine = [k for k, owner in enumerate(owners) if owner == i]
            orders = itertools.permutations(mine)
            longest = max(longest, min(length(start, before[i], o, targets) for o in orders))
        best = longest if best is None else min(best, longest)
    return best


@given(PLACES.map(lambda p: p[:3]), PLACES, st.data())
def test_every_target_is_on_one_route_and_the_longest_is_what_it_says(starts, targets, data):
    before = data.draw(st.lists(st.integers(0, 30), min_size=len(starts), max_size=len(starts)))
    found = shared_routes(costs(starts, targets), costs(targets, targets), before=before)
    assert sorted(itertools.chain(*found.routes)) == list(range(len(targets)))
    assert found.left_out == ()
    lengths = [length(start, before[i], found.routes[i], targets) for i, start in enumerate(starts)]
    assert found.longest == max(lengths)
    best = optimum(starts, before, targets)
    assert best is not None
    assert best <= found.longest
    if len(starts) == 1 and len(targets) < 3:
        assert found.longest == best


def test_two_ends_of_a_line_are_shared():
    # One robot in the middle drives to one end and back through the middle to the other: 60.
    places = [(20, 0)]
    ends = [(0, 0), (40, 0)]
    alone = shared_routes(costs(places, ends), costs(ends, ends))
    assert alone.longest == 60
    both = shared_routes(costs(places * 2, ends), costs(ends, ends))
    assert both.longest == 20
    assert sorted(map(len, both.routes)) == [1, 1]
    # With 25 to drive before, sharing is still better: 45.
    late = shared_routes(costs(places * 2, ends), costs(ends, ends), before=[0, 25])
    assert late.longest == 45
    # With 45 it is not: the first does both.
    assert shared_routes(costs(places * 2, ends), costs(ends, ends), before=[0, 45]).longest == 60


def test_what_nobody_may_or_can_reach_is_left_out():
    starts = np.array([[5, UNREACHABLE, 7], [5, UNREACHABLE, 7]])
    between = np.array([[0, UNREACHABLE, 4], [UNREACHABLE, 0, UNREACHABLE], [4, UNREACHABLE, 0]])
    allowed = [[True, True, False], [True, True, False]]
    found = shared_routes(starts, between, allowed=allowed)
    assert found.left_out == (1, 2)
    assert found.cost == (2, 5)


def test_without_targets_there_is_nothing_to_do():
    found = shared_routes(np.empty((2, 0), int), np.empty((0, 0), int))
    assert found.routes == ((), ())
    assert found.longest == 0


@pytest.mark.parametrize(
    ("starts", "between"), [(np.zeros((0, 2)), np.zeros((2, 2))), (np.zeros((1, 2)), np.zeros(4))]
)
def test_arrays_that_do_not_fit_are_refused(starts, between):
    with pytest.raises(InvalidInputError, match="do not fit"):
        shared_routes(starts, between)
