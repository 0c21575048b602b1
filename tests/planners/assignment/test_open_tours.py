from itertools import pairwise, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multisrt.planners.assignment.open_tours import _length, _move, _reverse, open_tours


def on_a_line(*x: float) -> tuple[np.ndarray, np.ndarray]:
    places = np.array(x)
    return np.abs(places), np.abs(places[:, None] - places)


def test_no_place_and_one_place():
    assert open_tours(np.empty(0), np.empty((0, 0)), np.empty(0)).tolist() == []
    assert open_tours(np.array([3.0]), np.zeros((1, 1)), np.array([9.0])).tolist() == [3.0]


def test_a_tour_of_a_line_turns_round_once():
    # From 0: to 2, back to -1 and on to -3 is 2 + 3 + 2. To -1 or -3 first: 3, and 5 back to 2; the
    # tour that begins with -1 goes on to -3.
    costs, path_lengths = on_a_line(-1.0, -3.0, 2.0)
    assert open_tours(costs, path_lengths, np.zeros(3)).tolist() == [8.0, 8.0, 7.0]


def test_what_is_costly_to_leave_comes_last():
    # The tour that ends at -3 leaves -1 and 2, those that end at 2 leave -1 and -3.
    costs, path_lengths = on_a_line(-1.0, -3.0, 2.0)
    leaving = np.array([0.0, 0.0, 4.0])
    assert open_tours(costs, path_lengths, leaving).tolist() == [8.0, 8.0, 11.0]


def shortest(costs, path_lengths, leaving, first) -> float:
    others = [k for k in range(len(costs)) if k != first]
    tours = ((first, *rest) for rest in permutations(others))
    return min(
        costs[first] + sum(leaving[a] + path_lengths[a, b] for a, b in pairwise(tour))
        for tour in tours
    )


@given(
    arrays(float, (6, 2), elements=st.integers(0, 20)),
    arrays(float, 6, elements=st.integers(0, 4)),
)
def test_tours_are_hardly_longer_than_the_shortest(places, leaving):
    costs = np.hypot(*(places - 10.0).T)
    path_lengths = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    found = open_tours(costs, path_lengths, leaving)
    best = [shortest(costs, path_lengths, leaving, first) for first in range(6)]
    assert (found >= np.array(best) - 1e-9).all()
    assert found.min() <= 1.15 * min(best) + 1e-9


def test_tours_of_random_places_are_hardly_longer_on_average():
    rng = np.random.default_rng(1)
    ratios = []
    for _ in range(20):
        places, leaving = rng.random((6, 2)) * 10.0, rng.random(6) * 3.0
        costs = np.hypot(*(places - 5.0).T)
        path_lengths = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
        found = open_tours(costs, path_lengths, leaving)
        ratios += [found[k] / shortest(costs, path_lengths, leaving, k) for k in range(6)]
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.01)


def test_each_change_shortens_a_tour():
    # Both kinds of change find nearly all that the other one finds, so each is tried alone.
    rng = np.random.default_rng(3)
    changed = [0, 0, 0, 0]
    for _ in range(100):
        places, leaving = rng.random((7, 2)) * 10.0, rng.random(7) * 20.0
        path_lengths = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
        for size in range(4):
            tour = rng.permutation(7)
            first, before = tour[0], _length(tour, path_lengths, leaving)
            is_shorter = (
                _move(tour, size, path_lengths, leaving)
                if size
                else _reverse(tour, path_lengths, leaving)
            )
            after = _length(tour, path_lengths, leaving)
            assert sorted(tour.tolist()) == list(range(7))
            assert tour[0] == first
            assert after < before if is_shorter else after == before
            changed[size] += is_shorter
    assert min(changed) > 50
