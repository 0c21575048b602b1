"""The bound of the total way against all ways of small teams."""

import itertools
import math

import numpy as np
import pytest

from multisrt.analysis.bounds.forest import Service, chosen_regions, min_total_length


def shortest(between, start, robots):
    """Return the least total length of the ways of a team that serves all regions."""
    count = len(start)
    if not count:
        return 0.0
    best = math.inf
    for order in itertools.permutations(range(count)):
        # Where another robot goes on, from the root.
        for cuts in range(robots):
            for begins in itertools.combinations(range(1, count), cuts):
                length = start[order[0]]
                for k in range(1, count):
                    length += start[order[k]] if k in begins else between[order[k - 1], order[k]]
                best = min(best, length)
    return best


def shortest_with_spare(between, start, amounts, spare, robots):
    count, best = len(start), math.inf
    for size in range(count + 1):
        for left_out in itertools.combinations(range(count), size):
            if amounts[list(left_out)].sum() <= spare:
                kept = [k for k in range(count) if k not in left_out]
                best = min(best, shortest(between[np.ix_(kept, kept)], start[kept], robots))
    return best


def drawn(seed, count=5):
    # No triangle inequality, and some distances of 0, as between overlapping regions.
    rng = np.random.default_rng(seed)
    between = np.triu(
        rng.uniform(0.0, 10.0, (count, count)) * (rng.random((count, count)) > 0.2), 1
    )
    return between + between.T, rng.uniform(0.0, 10.0, count), rng.uniform(0.2, 2.0, count)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("robots", [1, 2, 3])
def test_no_team_serves_all_regions_with_less(seed, robots):
    between, start, amounts = drawn(seed)
    service = Service(between, start, amounts, 0.0, 1e6, robots)
    length = min_total_length(service, np.arange(5), 100)
    assert 0.0 < length <= shortest(between, start, robots) + 1e-9


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("price", [0.0, 1.0, 4.0, 20.0])
@pytest.mark.parametrize("spare", [0.3, 1.0, 3.0])
def test_nor_with_less_if_some_are_left_out(seed, price, spare):
    between, start, amounts = drawn(seed)
    service = Service(between, start, amounts, spare, price, 2)
    length = min_total_length(service, np.arange(5), 100)
    assert 0.0 <= length <= shortest_with_spare(between, start, amounts, spare, 2) + 1e-9


def test_a_star_of_dead_ends_is_driven_out_and_back():
    # From the middle into each of four dead ends of 5 m; back out of all but the last.
    between = 10.0 * (1.0 - np.eye(4))
    service = Service(between, np.full(4, 5.0), np.ones(4), 0.0, 1e6, 1)
    assert min_total_length(service, np.arange(4), 300) == pytest.approx(35.0, abs=0.5)
    # A robot for each.
    assert min_total_length(service._replace(robots=4), np.arange(4), 300) == pytest.approx(20.0)


def test_a_region_that_is_a_shortcut_is_not_chosen():
    # The third region reaches from the first to the second, so that it makes ways shorter.
    between = np.array([[0.0, 9.0, 0.0], [9.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    service = Service(between, np.array([4.0, 5.0, 0.0]), np.ones(3), 0.0, 1e6, 1)
    assert chosen_regions(service, np.ones(3, np.bool_), 20).tolist() == [0, 1]
    assert min_total_length(service, np.arange(2), 100) == pytest.approx(13.0, abs=0.2)


def test_without_regions_there_is_no_path():
    service = Service(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0, 1.0, 1)
    assert min_total_length(service, np.arange(0), 10) == 0.0
