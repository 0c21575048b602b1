import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.families import paired_family, unpaired_family
from multisrt.statistics.intervals import Interval
from multisrt.statistics.ratios import POWER, ratio_of, smallest_reduction

INF = math.inf

value = st.integers(0, 9).map(lambda n: INF if n == 9 else float(n))
cells = st.lists(st.lists(st.tuples(value, value), min_size=8, max_size=8), min_size=1, max_size=3)


def found_ratio(a, b, **given) -> Interval:
    return ratio_of(lambda ratio: paired_family(a, b, ratio=ratio), **given)


def lognormal(rng, ratio: float, spread: float, cells: int = 4, runs: int = 10):
    """Return runs of `a` and `b` in cells of different scales, with a true ratio of a to b."""
    scale = 10.0 ** np.arange(cells)[:, np.newaxis]
    shared = scale * np.exp(rng.normal(0.0, 0.3, (cells, runs)))
    own = math.sqrt(0.5) * spread
    a, b = (shared * np.exp(rng.normal(0.0, own, (cells, runs))) for _ in range(2))
    return list(ratio * a), list(b)


def test_of_one_cell_against_one_it_is_that_of_walsh_averages():
    # Against a constant 1, ratios that the test does not reject are those of the signed-rank
    # interval: of 6 values the lowest and the highest mean of two, itself included, at 1 - 2 / 64.
    a = [0.5, 0.6, 0.7, 0.8, 1.1, 1.6]
    found = found_ratio([a], [[1.0] * 6])
    means = sorted(0.5 * (a[i] + a[j]) for i in range(6) for j in range(i, 6))
    assert found.low == pytest.approx(means[0], rel=2e-4)
    assert found.high == pytest.approx(means[-1], rel=2e-4)
    assert found.value == pytest.approx(np.median(means), rel=2e-4)


def test_a_ratio_without_spread_is_found():
    b = [[100.0, 150.0, 80.0, 120.0, 90.0, 70.0], [1.0, 1.5, 0.8, 1.2, 0.9, 0.7]]
    found = found_ratio([[0.75 * x for x in cell] for cell in b], b)
    assert [found.value, found.low, found.high] == pytest.approx([0.75] * 3, rel=3e-4)


def _at(test, a, b, ratio):
    return test(a, b, ratio=ratio)


@pytest.mark.slow
@given(cells)
@settings(max_examples=40, deadline=None)
def test_the_interval_is_beside_one_if_the_test_is_significant(cells):
    a = [[x for x, _ in cell] for cell in cells]
    b = [[y for _, y in cell] for cell in cells]
    for test in (paired_family, unpaired_family):
        found = ratio_of(partial(_at, test, a, b))
        assert found.low <= found.value <= found.high
        outside = found.high < 1.0 or found.low > 1.0
        assert outside == (test(a, b).p_value < 0.05)


def test_scaling_one_side_scales_ratio_and_interval():
    a, b = lognormal(np.random.default_rng(1), 0.8, 0.3)
    once, twice = found_ratio(a, b), found_ratio([2.0 * cell for cell in a], b)
    for end in ("value", "low", "high"):
        assert getattr(twice, end) == pytest.approx(2.0 * getattr(once, end), rel=3e-4)
    assert smallest_reduction(twice) == pytest.approx(smallest_reduction(once), abs=3e-4)


def test_failed_runs_and_zeros_leave_a_ratio():
    rng = np.random.default_rng(2)
    a, b = lognormal(rng, 0.6, 0.2)
    a[0][:2], b[1][:3], b[2][0], a[2][0] = INF, INF, INF, INF
    a[3][4] = b[3][4] = 0.0
    found = found_ratio(a, b)
    assert 0.5 < found.low < found.high < 0.8


def test_runs_that_bound_nothing():
    zeros, ones = [[0.0] * 8], [[1.0] * 8]
    assert found_ratio(zeros, zeros) == Interval(1.0, 0.0, INF)
    # Nothing at all is less than any share of something, and what failed more than any multiple.
    assert found_ratio(zeros, ones) == Interval(0.0, 0.0, 0.0)
    failed = found_ratio([[INF] * 8], ones)
    assert (failed.value, failed.high) == (INF, INF)
    few = found_ratio([[1.0, 2.0, 3.0]], [[2.0, 3.0, 5.0]])
    assert (few.low, few.high) == (0.0, INF)
    assert smallest_reduction(few) == 1.0
    assert smallest_reduction(failed) == smallest_reduction(Interval(0.0, 0.0, 0.5)) == 1.0


def test_the_smallest_reduction_is_where_the_test_turns_significant():
    a, b = lognormal(np.random.default_rng(3), 1.1, 0.4)
    found = found_ratio(a, b)
    ratio = 1.0 - smallest_reduction(found)

    def p_at(wanted):
        factor = wanted / found.value
        return paired_family([factor * cell for cell in a], b).p_value

    assert p_at(ratio * 0.999) < 0.05 <= p_at(ratio * 1.001)


def test_more_runs_and_less_spread_show_less():
    def shown(spread, runs):
        rng = np.random.default_rng(4)
        return smallest_reduction(found_ratio(*lognormal(rng, 1.0, spread, runs=runs)))

    assert shown(0.1, 10) < shown(0.3, 10) < shown(0.9, 10)
    assert shown(0.3, 40) < 0.7 * shown(0.3, 10)


@pytest.mark.slow
def test_power_is_as_stated():
    # The reduction that experiments without one state for 80 %, and how many then find it.
    rng = np.random.default_rng(5)
    stated = [
        smallest_reduction(found_ratio(*lognormal(rng, 1.0, 0.4, runs=12)), power=POWER)
        for _ in range(40)
    ]
    true = 1.0 - float(np.median(stated))
    hits = [paired_family(*lognormal(rng, true, 0.4, runs=12)).p_value < 0.05 for _ in range(400)]
    assert 0.72 < np.mean(hits) < 0.88


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_stated():
    rng = np.random.default_rng(6)
    within = 0
    for _ in range(300):
        found = found_ratio(*lognormal(rng, 0.8, 0.5))
        within += found.low <= 0.8 <= found.high
    # Three standard deviations below 95 %.
    assert within / 300 > 0.912


def test_wrong_levels_and_powers_are_refused():
    with pytest.raises(InvalidInputError, match="level"):
        found_ratio([[1.0]], [[1.0]], level=1.0)
    for power in (0.4, 1.0):
        with pytest.raises(InvalidInputError, match="power"):
            smallest_reduction(Interval(1.0, 0.5, 2.0), power=power)
