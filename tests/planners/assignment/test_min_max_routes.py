"""Min-max routes against all permutations."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.planners.assignment.min_max_routes import Costs, improve, objective, route_times


def costs_of(places, starts, headings, *, turn_s, home):
    """Straight legs in the plane, for robots of one kind with a speed of 1 m/s."""
    points = np.vstack((places, starts))
    step = points[None, :, :] - points[:, None, :]
    angle = np.arctan2(step[:, :, 1], step[:, :, 0]) % math.pi
    return Costs(
        time_s=np.hypot(step[:, :, 0], step[:, :, 1])[None],
        angle=angle[None],
        turn_s=np.array([turn_s]),
        kind=np.zeros(len(starts), np.int64),
        heading=np.asarray(headings, np.float64) % math.pi,
        home=home,
    )


def time_of(points, heading, route, turn_s, home):
    """The time of one route, from its definition."""
    stops = [points[k] for k in ([*route, route[0]] if home and len(route) > 1 else route)]
    total, line = 0.0, heading
    for (ax, ay), (bx, by) in itertools.pairwise(stops):
        total += math.hypot(bx - ax, by - ay)
        ahead = math.atan2(by - ay, bx - ax)
        turn = abs(math.remainder(ahead - line, math.pi))
        total += turn_s * turn
        line = ahead
    return total


def routes_of(counts, order, m):
    n = len(counts)
    routes, sizes = np.full((n, m + 1), -1, np.int64), np.ones(n, np.int64)
    rest = list(order)
    for r, count in enumerate(counts):
        taken, rest = rest[:count], rest[count:]
        routes[r, : count + 1] = [m + r, *taken]
        sizes[r] += count
    return routes, sizes


coordinate = st.integers(-20, 20).map(lambda k: k / 4)
points = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=5, unique=True)


@settings(max_examples=60, deadline=None)
@given(points, st.integers(1, 3), st.sampled_from([0.0, 0.6]), st.booleans(), st.randoms())
def test_times_are_those_of_the_definition_and_never_get_worse(places, n, turn_s, home, random):
    starts = [(0.1 + k, 7.0) for k in range(n)]
    headings = [random.uniform(-3.0, 3.0) for _ in range(n)]
    costs = costs_of(np.array(places), np.array(starts), headings, turn_s=turn_s, home=home)
    m = len(places)
    order = list(range(m))
    random.shuffle(order)
    cut = sorted(random.randint(0, m) for _ in range(n - 1))
    counts = np.diff([0, *cut, m]).tolist()
    routes, sizes = routes_of(counts, order, m)
    everything = [*places, *starts]

    def true_times(arrays, lengths):
        return [
            time_of(everything, headings[r], arrays[r, : lengths[r]].tolist(), turn_s, home)
            for r in range(n)
        ]

    before = route_times(routes, sizes, costs)
    assert before == pytest.approx(true_times(routes, sizes), abs=1e-9)
    better, lengths = improve(routes, sizes, costs)
    after = route_times(better, lengths, costs)
    assert after == pytest.approx(true_times(better, lengths), abs=1e-9)
    assert objective(after) <= objective(before) + 1e-9
    visited = sorted(k for r in range(n) for k in better[r, 1 : lengths[r]].tolist())
    assert visited == list(range(m))


def test_the_best_routes_of_small_teams_are_found():
    rng = np.random.default_rng(5)
    found, best = [], []
    for _ in range(20):
        places, starts = rng.uniform(0, 10, (5, 2)), rng.uniform(0, 10, (2, 2))
        costs = costs_of(places, starts, [0.0, 0.0], turn_s=0.5, home=False)
        values = []
        for order in itertools.permutations(range(5)):
            for cut in range(6):
                routes, sizes = routes_of([cut, 5 - cut], order, 5)
                values.append(objective(route_times(routes, sizes, costs)))
        best.append(min(values))
        routes, sizes = routes_of([5, 0], range(5), 5)
        found.append(objective(route_times(*improve(routes, sizes, costs), costs)))
    # Local search: mostly the optimum, never far from it.
    excess = np.array(found) / np.array(best)
    assert np.median(excess) < 1.0 + 1e-9
    assert excess.max() < 1.15
