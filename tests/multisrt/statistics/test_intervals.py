import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.intervals import (
    MAX_VALUES_AT_ONCE,
    Interval,
    bootstrap,
    drawn_counts,
    student,
    wilson,
)
from multisrt.statistics.samples import finite_sample_of, sample_of, strata_of
from multisrt.statistics.summaries import interquartile_mean, mean, median, quantile

INF = math.inf

numbers = st.floats(-1e6, 1e6)
samples = st.lists(numbers, min_size=1, max_size=30).map(np.array)


def within_binomial_bounds(successes: int, experiments: int, probability: float) -> bool:
    """Whether a count is within 99.99 % of its binomial distribution."""
    low, high = stats.binom(experiments, probability).interval(0.9999)
    return bool(low <= successes <= high)


class TestSamples:
    def test_failed_runs_at_one_end_are_accepted(self):
        assert sample_of([1, INF]).tolist() == [1.0, INF]
        assert sample_of([1, -INF]).tolist() == [1.0, -INF]

    @pytest.mark.parametrize(
        ("values", "words"),
        [
            ([], "at least one number"),
            ([[1.0, 2.0]], r"shape \(1, 2\)"),
            (3.0, r"shape \(\)"),
            ([1.0, math.nan], "times must not hold nan"),
            ([INF, -INF], "both inf and -inf"),
            (["a"], "times must be numbers"),
        ],
    )
    def test_bad_samples_are_refused(self, values, words):
        with pytest.raises(InvalidInputError, match=words):
            sample_of(values, "times")

    def test_finite_samples_refuse_failed_runs(self):
        with pytest.raises(InvalidInputError, match="2 of 3 are not"):
            finite_sample_of([1.0, INF, INF])

    def test_errors_name_the_stratum(self):
        with pytest.raises(InvalidInputError, match=r"strata\[1\] must not hold nan"):
            strata_of([[1.0], [math.nan]])
        with pytest.raises(InvalidInputError, match="not none"):
            strata_of([])
        with pytest.raises(InvalidInputError, match="both inf and -inf"):
            strata_of([[INF], [-INF]])


class TestSummaries:
    @pytest.mark.parametrize(
        ("values", "expected"),
        [
            ([5.0], 5.0),
            ([5.0, 1.0, 9.0], 5.0),
            # One of five is left out at each end, two of eight.
            ([100.0, 2.0, 3.0, 4.0, 1.0], 3.0),
            ([8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0], 4.5),
            ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, INF, INF], 4.5),
            ([1.0, 2.0, 3.0, 4.0, 5.0, INF, INF, INF], INF),
        ],
    )
    def test_interquartile_means_by_hand(self, values, expected):
        assert interquartile_mean(np.array(values)) == expected

    def test_interquartile_mean_of_all_tasks_is_that_of_rliable(self):
        # Agarwal et al.: all runs of all tasks together, a quarter left out at both ends.
        scores = np.random.default_rng(1).normal(size=(10, 6))
        heap = np.sort(scores, axis=None)
        expected = heap[15:45].sum() / 30
        assert interquartile_mean(scores.ravel()) == pytest.approx(expected, rel=1e-12)

    @pytest.mark.parametrize(
        ("values", "expected"),
        [([3, 1, 2], 2), ([4, 1], 2.5), ([1, 2, INF], 2), ([1, INF], INF), ([INF, INF], INF)],
    )
    def test_medians_by_hand(self, values, expected):
        assert median(np.array(values, dtype=float)) == expected

    def test_means_of_failed_runs_are_refused(self):
        assert mean(np.array([1.0, 4.0])) == 2.5
        with pytest.raises(InvalidInputError, match="must be finite"):
            mean(np.array([1.0, INF]))

    @given(samples, st.floats(0.0, 1.0))
    def test_quantiles_are_those_of_numpy(self, values, share):
        assert quantile(values, share) == pytest.approx(
            np.quantile(values, share), rel=1e-9, abs=1e-6
        )

    def test_quantiles_of_failed_runs(self):
        values = np.array([INF, 1.0, 2.0, INF, INF])
        assert quantile(values, 0.25) == 2.0
        assert quantile(values, 0.3) == INF
        assert quantile(values, 0.9) == INF
        assert quantile(-values, 0.5) == -INF

    @pytest.mark.parametrize("statistic", [mean, median, interquartile_mean])
    def test_summaries_reduce_the_last_axis(self, statistic):
        table = np.random.default_rng(2).normal(size=(3, 4, 9))
        whole = statistic(table)
        assert whole.shape == (3, 4)
        assert whole[1, 2] == statistic(table[1, 2])

    @pytest.mark.parametrize("share", [-0.1, 1.1, math.nan])
    def test_shares_out_of_range_are_refused(self, share):
        with pytest.raises(InvalidInputError, match="from 0 to 1"):
            quantile(np.ones(3), share)


class TestBootstrap:
    def test_two_values_by_hand(self):
        # Means of resamples: 0 in a quarter of the cases, 1/2 in a half, 1 in a quarter.
        wide = bootstrap([[0.0, 1.0]], mean, level=0.9, rng=1)
        assert wide == Interval(0.5, 0.0, 1.0)
        assert bootstrap([[0.0, 1.0]], mean, level=0.4, rng=1) == Interval(0.5, 0.5, 0.5)

    @pytest.mark.parametrize("statistic", [mean, median, interquartile_mean])
    def test_ends_equal_those_of_all_possible_resamples(self, statistic):
        values = np.array([1.0, 2.0, 4.0, 8.0, 9.0])
        everything = statistic(np.array(list(itertools.product(values, repeat=5))))
        found = bootstrap([values], statistic, level=0.8, resamples=20_000, rng=3)
        # An estimated quantile lies between those of shares 0.01 lower and higher.
        for end, share in ((found.low, 0.1), (found.high, 0.9)):
            assert np.quantile(everything, share - 0.01) <= end
            assert end <= np.quantile(everything, share + 0.01)

    def test_ends_are_those_of_scipy(self):
        values = np.random.default_rng(4).gamma(2.0, size=25)
        theirs = stats.bootstrap(
            (values,),
            np.mean,
            method="percentile",
            n_resamples=40_000,
            rng=np.random.default_rng(5),
        ).confidence_interval
        ours = bootstrap([values], mean, resamples=40_000, rng=6)
        width = theirs.high - theirs.low
        assert ours.low == pytest.approx(theirs.low, abs=0.02 * width)
        assert ours.high == pytest.approx(theirs.high, abs=0.02 * width)

    def test_runs_are_drawn_within_their_task(self):
        apart = bootstrap([[0.0, 0.0], [10.0, 10.0]], mean, rng=7)
        assert apart == Interval(5.0, 5.0, 5.0)
        heap = bootstrap([[0.0, 0.0, 10.0, 10.0]], mean, rng=7)
        assert heap.low < 5.0 < heap.high

    def test_blocks_of_resamples_give_the_same_interval(self):
        assert MAX_VALUES_AT_ONCE < 20_000 * 300
        many = np.random.default_rng(8).normal(size=300)
        found = bootstrap([many], mean, resamples=20_000, rng=9)
        spread = many.std() / math.sqrt(300)
        assert found.low == pytest.approx(many.mean() - 1.96 * spread, abs=0.05 * spread)
        assert found.high == pytest.approx(many.mean() + 1.96 * spread, abs=0.05 * spread)

    def test_the_same_seed_gives_the_same_interval(self):
        values = np.random.default_rng(10).normal(size=12)
        by_seed = bootstrap([values], median, rng=11)
        assert by_seed == bootstrap([values], median, rng=np.random.default_rng(11))
        generator = np.random.default_rng(11)
        generator.random()
        assert by_seed != bootstrap([values], mean, rng=generator)

    def test_failed_runs_make_the_upper_end_infinite(self):
        found = bootstrap([[*range(1, 9), INF, INF, INF]], median, rng=12)
        assert found.value == 6.0
        assert 1.0 <= found.low < 6.0
        assert found.high == INF
        with pytest.raises(InvalidInputError, match="must be finite"):
            bootstrap([[1.0, INF]], mean, rng=12)

    @given(st.lists(samples, min_size=1, max_size=4))
    def test_ends_lie_among_the_values(self, strata):
        found = bootstrap(strata, median, resamples=50, rng=13)
        heap = np.concatenate(strata)
        assert heap.min() <= found.low <= found.high <= heap.max()
        assert heap.min() <= found.value <= heap.max()

    @given(st.lists(st.integers(0, 1000), min_size=1, max_size=10))
    def test_the_value_lies_in_the_interval_of_a_symmetric_sample(self, half):
        values = np.array(half, dtype=float)
        found = bootstrap([np.concatenate([-values, values])], mean, rng=14)
        assert found.low <= found.value <= found.high
        assert found.value == 0.0

    @given(samples, st.floats(0.5, 0.9))
    def test_a_higher_level_is_never_narrower(self, values, level):
        narrow = bootstrap([values], mean, level=level, resamples=100, rng=15)
        wide = bootstrap([values], mean, level=level + 0.09, resamples=100, rng=15)
        assert wide.low <= narrow.low
        assert narrow.high <= wide.high

    def test_coverage_of_means_agrees_with_theory(self):
        # Of n normal values, the percentile interval is nearly m ± 1.96 s sqrt((n - 1) / n²):
        # its coverage is the probability of Student's t with n - 1 degrees within that.
        rng = np.random.default_rng(16)
        expected = 1.0 - 2.0 * stats.t.sf(stats.norm.isf(0.025) * math.sqrt(19 / 20), 19)
        held = 0
        for _ in range(1000):
            found = bootstrap([rng.normal(3.0, 2.0, 20)], mean, resamples=1000, rng=rng)
            held += found.low <= 3.0 <= found.high
        assert expected == pytest.approx(0.93, abs=0.005)
        assert within_binomial_bounds(held, 1000, expected)

    def test_coverage_of_interquartile_means(self):
        rng = np.random.default_rng(17)
        held = 0
        for _ in range(500):
            # Two tasks with the same centre and different variances.
            strata = [rng.normal(0.0, 1.0, 20), rng.normal(0.0, 3.0, 20)]
            found = bootstrap(strata, interquartile_mean, resamples=300, rng=rng)
            held += found.low <= 0.0 <= found.high
        assert 0.91 <= held / 500 <= 0.98

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            ({"level": 1.0}, "level of an interval"),
            ({"level": 0.0}, "level of an interval"),
            ({"resamples": 0}, "at least 1 resample"),
        ],
    )
    def test_options_out_of_range_are_refused(self, options, words):
        with pytest.raises(InvalidInputError, match=words):
            bootstrap([[1.0, 2.0]], mean, rng=1, **options)

    def test_drawn_counts_sum_to_the_number_of_runs(self):
        counts = drawn_counts(4, 3000, np.random.default_rng(18))
        assert counts.shape == (3000, 4)
        assert (counts.sum(axis=1) == 4).all()
        # Each run is drawn with probability 1/4 in each of four draws.
        seen = [np.count_nonzero(counts[:, 0] == k) for k in range(5)]
        expected = 3000 * stats.binom(4, 0.25).pmf(range(5))
        assert stats.chisquare(seen, expected).pvalue > 0.001


class TestWilson:
    @pytest.mark.parametrize(
        ("successes", "count"), [(0, 10), (8, 10), (10, 10), (1, 1), (37, 400)]
    )
    @pytest.mark.parametrize("level", [0.8, 0.95])
    def test_ends_are_those_of_wilsons_formula(self, successes, count, level):
        p, z = successes / count, stats.norm.ppf((1 + level) / 2)
        centre = (p + z**2 / (2 * count)) / (1 + z**2 / count)
        half = z / (1 + z**2 / count) * math.sqrt(p * (1 - p) / count + z**2 / (4 * count**2))
        found = wilson(successes, count, level)
        assert found.value == p
        assert found.low == pytest.approx(centre - half, abs=1e-12)
        assert found.high == pytest.approx(centre + half, abs=1e-12)

    def test_eight_of_ten(self):
        found = wilson(8, 10)
        assert found.low == pytest.approx(0.4902, abs=5e-5)
        assert found.high == pytest.approx(0.9433, abs=5e-5)

    @pytest.mark.parametrize(("successes", "count"), [(1, 0), (0, 0), (3, 2), (-1, 2)])
    def test_impossible_counts_are_refused(self, successes, count):
        with pytest.raises(InvalidInputError, match="at least one run"):
            wilson(successes, count)


class TestStudent:
    @given(st.lists(st.floats(-100.0, 100.0), min_size=2, max_size=12))
    def test_it_is_scipys_interval(self, values):
        found = student(values, 0.9)
        if np.ptp(values) < 1e-6:
            assert [found.low, found.high] == pytest.approx([found.value] * 2, abs=1e-5)
            return
        ends = stats.ttest_1samp(values, 0.0).confidence_interval(0.9)
        assert [found.low, found.high] == pytest.approx([ends.low, ends.high], abs=1e-6)

    def test_bad_values_are_refused(self):
        with pytest.raises(InvalidInputError, match="at least two"):
            student([1.0])
        with pytest.raises(InvalidInputError, match="finite"):
            student([1.0, INF])
        with pytest.raises(InvalidInputError, match="level"):
            student([1.0, 2.0], 1.0)
