import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from multisrt.statistics.permutations import (
    doubled_ranks,
    two_sided,
    ways_of_choosing,
    ways_of_signing,
)

values = st.lists(st.sampled_from([0.0, 0.5, 1.0, 2.0, math.inf]), min_size=1, max_size=8)
ranks = st.lists(st.integers(1, 9), min_size=1, max_size=7)


@given(values)
def test_doubled_ranks_are_twice_scipys(values):
    assert doubled_ranks(np.array(values)).tolist() == (2.0 * stats.rankdata(values)).tolist()


@given(ranks, st.data())
def test_ways_of_choosing_are_counted(ranks, data):
    chosen = data.draw(st.integers(0, len(ranks)))
    expected = np.zeros(sum(ranks) + 1)
    for some in itertools.combinations(ranks, chosen):
        expected[sum(some)] += 1.0
    assert ways_of_choosing(np.array(ranks), chosen).tolist() == expected.tolist()


@given(st.lists(st.integers(0, 9), min_size=1, max_size=7))
def test_ways_of_signing_are_counted(ranks):
    expected = np.zeros(sum(ranks) + 1)
    for signs in itertools.product([0, 1], repeat=len(ranks)):
        expected[sum(r * s for r, s in zip(ranks, signs, strict=True))] += 1.0
    assert ways_of_signing(np.array(ranks)).tolist() == expected.tolist()


def test_both_tails_include_the_observed_sum():
    ways = np.array([1.0, 2.0, 1.0])
    assert [two_sided(ways, seen) for seen in range(3)] == pytest.approx([0.5, 1.0, 0.5])
