"""The exact Euclidean distance transform: by hand, and its two orders against each other."""

import doctest
import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import multisrt.geometry.grids.euclidean_field as module
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.distance_field import distance_field
from multisrt.geometry.grids.euclidean_field import EuclideanField


def every(passable):
    return np.argwhere(np.ones_like(passable))


def drawn(seed):
    rng = np.random.default_rng(seed)
    passable = rng.random((20, 26)) > rng.uniform(0.05, 0.45)
    passable[3, 4] = True
    return passable, rng


@pytest.mark.parametrize("order", ["queue", "sweeps"])
def test_cells_in_sight_have_their_euclidean_distance(order):
    passable = np.ones((30, 50), bool)
    field = EuclideanField(passable, 0.1, (10.23, 21.11), x0=10.0, y0=20.0, order=order)
    cells = every(passable)
    truth = np.hypot(*((cells[:, ::-1] + 0.5) * 0.1 + (10.0, 20.0) - (10.23, 21.11)).T)
    assert field.distance(cells) == pytest.approx(truth, abs=1e-9)
    assert field.path((29, 49)) == pytest.approx(np.array([(10.23, 21.11), (14.95, 22.95)]))


@pytest.mark.parametrize("order", ["queue", "sweeps"])
def test_around_a_wall_by_hand(order):
    passable = np.ones((30, 60), bool)
    passable[:20, 20:24] = False
    field = EuclideanField(passable, 1.0, (5.5, 5.5), order=order)
    turns = [(5.5, 5.5), (19.5, 20.5), (24.5, 20.5), (38.5, 5.5)]
    assert field.path((5, 38)).tolist() == [list(turn) for turn in turns]
    truth = sum(math.dist(a, b) for a, b in itertools.pairwise(turns))
    assert field.distance([(5, 38)])[0] == pytest.approx(truth)


@pytest.mark.slow
@pytest.mark.parametrize("order", ["queue", "sweeps"])
@given(seed=st.integers(0, 100_000))
def test_the_path_is_as_long_as_its_distance(order, seed):
    passable, rng = drawn(seed)
    source = (4.0 + rng.random(), 3.0 + rng.random())
    field = EuclideanField(passable, 0.5, np.array(source) * 0.5, order=order)
    cells = every(passable)
    lengths = field.distance(cells)
    marched = distance_field(passable, 0.5, [np.array(source) * 0.5])
    assert np.array_equal(np.isfinite(lengths), np.isfinite(marched).ravel())
    for cell, told in zip(cells[::7], lengths[::7], strict=True):
        if np.isfinite(told):
            path = field.path(cell)
            walked = np.hypot(*np.diff(path, axis=0).T).sum()
            # In sweeps a turning point may become nearer after the cells behind it are done.
            assert walked <= told + 1e-9
            assert order == "sweeps" or walked == pytest.approx(told)


def test_queue_and_sweeps_agree_on_average():
    longer = []
    for seed in range(60):
        passable, _ = drawn(seed)
        queue = EuclideanField(passable, 1.0, (4.5, 3.5))
        sweeps = EuclideanField(passable, 1.0, (4.5, 3.5), order="sweeps")
        a, b = queue.distance(every(passable)), sweeps.distance(every(passable))
        reached = np.isfinite(b)
        longer.append(a[reached] / np.maximum(b[reached], 1e-9) - 1.0)
    excess = np.concatenate(longer)
    assert excess.mean() < 0.0005
    assert excess.max() < 0.08


@given(st.integers(0, 100_000))
def test_an_early_stop_gives_final_values(seed):
    passable, rng = drawn(seed)
    whole = EuclideanField(passable, 1.0, (4.5, 3.5)).distance(every(passable))
    field = EuclideanField(passable, 1.0, (4.5, 3.5))
    for _ in range(4):
        asked = rng.integers(0, len(whole), 3)
        assert np.array_equal(field.distance(every(passable)[asked]), whole[asked])


def test_nothing_passes_between_cells_that_meet_in_a_corner():
    passable = np.zeros((4, 4), bool)
    passable[:2, :2] = passable[2:, 2:] = True
    for order in ("queue", "sweeps"):
        field = EuclideanField(passable, 1.0, (0.5, 0.5), order=order)
        assert field.distance([(1, 1), (2, 2), (0, 3)]).tolist() == [math.sqrt(2), np.inf, np.inf]


def test_refuses_invalid_fields():
    passable = np.ones((4, 5), bool)
    passable[2, 2] = False
    valid: dict[str, Any] = {"passable": passable, "cell_m": 1.0, "source": (0.5, 0.5)}
    for change, told in (
        ({"source": (2.5, 2.5)}, "not in a free cell"),
        ({"source": (9.0, 1.0)}, "not in a free cell"),
        ({"cell_m": 0.0}, "positive width"),
        ({"passable": np.ones(3, bool)}, "two dimensions, not 1"),
        ({"passable": np.ones((4, 5))}, "of bool, not float64"),
        ({"order": "random"}, "'queue' or 'sweeps', not 'random'"),
    ):
        with pytest.raises(InvalidInputError, match=told):
            EuclideanField(**valid | change)
    field = EuclideanField(passable, 1.0, (0.5, 0.5))
    with pytest.raises(InvalidInputError, match=r"no path leads to cell \(2, 2\)"):
        field.path((2, 2))
    with pytest.raises(InvalidInputError, match="not in the grid"):
        field.distance([(4, 0)])


def test_examples():
    assert doctest.testmod(module).failed == 0
