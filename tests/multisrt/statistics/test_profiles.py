import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.improvement import probability_of_improvement
from multisrt.statistics.intervals import Interval
from multisrt.statistics.profiles import gap, gaps_to_bound, performance_profile

INF = math.inf

values = st.lists(st.integers(0, 6).map(float) | st.just(INF), min_size=1, max_size=6)


class TestProfile:
    def test_by_hand(self):
        band = performance_profile([[1, 2, 3, INF], [2, 2]], [0, 1, 2, 3, 9], rng=1)
        # Of the first task 0, 1/4, 2/4, 3/4, 3/4; of the second 0, 0, 1, 1, 1.
        assert band.at.tolist() == [0, 1, 2, 3, 9]
        assert band.value.tolist() == [0, 0.125, 0.75, 0.875, 0.875]

    def test_band_by_hand(self):
        # Shares of resamples of two runs: 0, 1/2, 1 in a quarter, a half, a quarter of the cases.
        wide = performance_profile([[0.0, 1.0]], [-1.0, 0.5, 2.0], level=0.9, rng=2)
        assert wide.low.tolist() == [0.0, 0.0, 1.0]
        assert wide.high.tolist() == [0.0, 1.0, 1.0]
        narrow = performance_profile([[0.0, 1.0]], [0.5], level=0.4, rng=2)
        assert (narrow.low[0], narrow.high[0]) == (0.5, 0.5)

    def test_profiles_agree_with_rliable(self):
        # Agarwal et al.: F(tau) = 1/M sum over tasks of 1/N sum over runs of [score > tau].
        rng = np.random.default_rng(3)
        scores, thresholds = rng.integers(0, 20, (5, 7)).astype(float), np.arange(-1.0, 21.0)
        above = [
            sum(sum(score > tau for score in task) / 7 for task in scores) / 5 for tau in thresholds
        ]
        band = performance_profile(list(scores), thresholds, rng=4)
        assert band.value == pytest.approx(1.0 - np.array(above))
        # Where higher is better, "at least tau" is the complement of "below".
        mirrored = performance_profile(list(-scores), -thresholds[::-1], rng=4)
        below = [(scores < tau).mean() for tau in thresholds[::-1]]
        assert mirrored.value == pytest.approx(1.0 - np.array(below))

    def test_band_equals_that_of_all_possible_resamples(self):
        tasks, tau = [np.array([1.0, 2.0, 5.0, 9.0]), np.array([3.0, 4.0, 6.0])], 4.5
        shares = [
            [np.mean(task[list(drawn)] <= tau) for drawn in itertools.product(range(n), repeat=n)]
            for task, n in zip(tasks, (4, 3), strict=True)
        ]
        everything = np.add.outer(*map(np.array, shares)).ravel() / 2
        band = performance_profile(tasks, [tau], level=0.8, resamples=20_000, rng=5)
        for end, share in ((band.low[0], 0.1), (band.high[0], 0.9)):
            assert np.quantile(everything, share - 0.01) - 1e-12 <= end
            assert end <= np.quantile(everything, share + 0.01) + 1e-12

    @given(st.lists(values, min_size=1, max_size=3))
    def test_profiles_ascend_within_their_band(self, strata):
        band = performance_profile(strata, [-1.0, 2.0, 4.0, 6.0], resamples=50, rng=6)
        for line in (band.value, band.low, band.high):
            assert (np.diff(line) >= 0.0).all()
        assert (band.low <= band.high).all()
        assert band.low[0] == band.value[0] == band.high[0] == 0.0
        finished = np.mean([np.mean(np.isfinite(task)) for task in strata])
        assert band.value[-1] == pytest.approx(finished)

    @pytest.mark.parametrize("thresholds", [[], [1.0, 1.0], [2.0, 1.0], [INF], [math.nan]])
    def test_bad_thresholds_are_refused(self, thresholds):
        with pytest.raises(InvalidInputError, match="thresholds"):
            performance_profile([[1.0]], thresholds, rng=1)


class TestGap:
    def test_of_runs_by_hand(self):
        assert gaps_to_bound([10, 15, 20, INF], 10).tolist() == [0.0, 0.5, 1.0, INF]
        assert gaps_to_bound([10, 15], [5, 10]).tolist() == [1.0, 0.5]

    def test_of_tasks_by_hand(self):
        # Gaps 0, 1, 2, 3 and 1, 1, 1, inf: of all eight, the middle half is 1, 1, 1, 2.
        found = gap([[10, 20, 30, 40], [4, 6, 10, INF]], [10, [2, 3, 5, 1]], rng=1)
        assert found.value == 1.25
        assert found.low <= 1.25 <= found.high

    def test_gaps_convert_to_rliables_optimality_gap(self):
        # Agarwal et al.: gamma - mean of min(score, gamma), at gamma = 1.
        rng = np.random.default_rng(2)
        bound = 40.0
        times = np.append(bound * (1.0 + rng.exponential(size=20)), INF)
        theirs = 1.0 - np.mean(np.minimum(bound / times, 1.0))
        gaps = gaps_to_bound(times[:-1], bound)
        assert theirs == pytest.approx((np.sum(gaps / (1.0 + gaps)) + 1.0) / 21)

    @pytest.mark.parametrize(
        ("bound", "words"),
        [
            (0.0, "must be positive"),
            ([1.0, -2.0], "must be positive"),
            (INF, "must be finite"),
            ([1.0, 2.0, 3.0], "one bound or one each, not 3"),
        ],
    )
    def test_bad_bounds_are_refused(self, bound, words):
        with pytest.raises(InvalidInputError, match=words):
            gaps_to_bound([1.0, 2.0], bound)

    def test_each_task_needs_a_bound(self):
        with pytest.raises(InvalidInputError, match="2 tasks and 1 bounds"):
            gap([[1.0], [2.0]], [1.0], rng=1)


class TestProbabilityOfImprovement:
    def test_by_hand(self):
        # 1 is better than 2 and 3 is not: 1/2. Resamples of a: 1, 1/2, 0 in 1/4, 1/2, 1/4.
        wide = probability_of_improvement([[1, 3]], [[2]], level=0.9, rng=1)
        assert wide == Interval(0.5, 0.0, 1.0)
        narrow = probability_of_improvement([[1, 3]], [[2]], level=0.4, rng=1)
        assert narrow == Interval(0.5, 0.5, 0.5)

    def test_tasks_have_equal_weight(self):
        # 1 in the first task, whatever its runs; 1/4 in the second.
        found = probability_of_improvement([[1, 1, 1, 1, 1], [4, 2]], [[2], [3, 1]], rng=2)
        assert found.value == 0.625

    def test_improvement_agrees_with_rliable(self):
        # Agarwal et al.: mean over tasks of 1/N² sum of S(x, y), S = 1 if x > y, 1/2 if equal.
        rng = np.random.default_rng(3)
        x, y = rng.integers(0, 9, (2, 4, 6)).astype(float)
        total = 0.0
        for task in range(4):
            for one, other in itertools.product(x[task], y[task]):
                total += 1.0 if one > other else 0.5 if one == other else 0.0
        found = probability_of_improvement(list(x), list(y), lower_is_better=False, rng=4)
        assert found.value == pytest.approx(total / (4 * 36))
        assert found.low < found.value < found.high

    def test_interval_equals_that_of_all_possible_resamples(self):
        a, b = np.array([1.0, 4.0, INF]), np.array([2.0, 4.0, 6.0])
        drawn = [list(d) for d in itertools.product(range(3), repeat=3)]
        everything = [
            np.mean(np.less.outer(a[i], b[j]) + 0.5 * np.equal.outer(a[i], b[j]))
            for i, j in itertools.product(drawn, drawn)
        ]
        found = probability_of_improvement([a], [b], level=0.8, resamples=20_000, rng=5)
        for end, share in ((found.low, 0.1), (found.high, 0.9)):
            assert np.quantile(everything, share - 0.01) - 1e-12 <= end
            assert end <= np.quantile(everything, share + 0.01) + 1e-12

    @given(st.lists(st.tuples(values, values), min_size=1, max_size=3))
    def test_both_sides_add_up_to_one(self, tasks):
        a, b = zip(*tasks, strict=True)
        one = probability_of_improvement(a, b, resamples=20, rng=6)
        other = probability_of_improvement(b, a, resamples=20, rng=6)
        assert one.value + other.value == pytest.approx(1.0)
        assert 0.0 <= one.low <= one.high <= 1.0
        negated = [[[-v for v in task] for task in side] for side in (a, b)]
        again = probability_of_improvement(*negated, lower_is_better=False, resamples=20, rng=6)
        assert again == one

    def test_coverage_without_a_difference(self):
        rng = np.random.default_rng(7)
        held = 0
        for _ in range(500):
            a, b = rng.normal(size=(2, 3, 10))
            found = probability_of_improvement(list(a), list(b), resamples=200, rng=rng)
            held += found.low <= 0.5 <= found.high
        assert 0.90 <= held / 500 <= 0.98

    def test_bad_input_is_refused(self):
        with pytest.raises(InvalidInputError, match="a has 1 and b has 2"):
            probability_of_improvement([[1.0]], [[1.0], [2.0]], rng=1)
        with pytest.raises(InvalidInputError, match=r"b\[0\] must not hold nan"):
            probability_of_improvement([[1.0]], [[math.nan]], rng=1)
        with pytest.raises(InvalidInputError, match="at least 1 resample"):
            probability_of_improvement([[1.0]], [[1.0]], resamples=-1, rng=1)
