import itertools
import math
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.effect_size import magnitude, vargha_delaney
from multisrt.statistics.rank_tests import RankTest, corrected, holm, mark, paired, unpaired

INF = math.inf

# Few distinct values, for many ties; 9 stands for a failed run.
coarse = st.integers(0, 9).map(lambda value: INF if value == 9 else float(value))
small_samples = st.lists(coarse, min_size=1, max_size=5)
pairs = st.lists(st.tuples(coarse, coarse), min_size=1, max_size=6)
p_values = st.lists(st.floats(0.0, 1.0), max_size=20)


def wins(a, b) -> float:
    """Return the number of pairs in which the value of `a` is lower, ties as half."""
    return sum((x < y) + 0.5 * (x == y) for x in a for y in b)


def p_of_all_allotments(a, b) -> float:
    """Return the p-value by enumeration of all assignments of the values to `a`."""
    pool = [*a, *b]
    seen, results = wins(a, b), []
    for chosen in itertools.combinations(range(len(pool)), len(a)):
        rest = [pool[i] for i in range(len(pool)) if i not in chosen]
        results.append(wins([pool[i] for i in chosen], rest))
    low = sum(result <= seen for result in results) / len(results)
    high = sum(result >= seen for result in results) / len(results)
    return min(1.0, 2.0 * min(low, high))


def p_of_all_signs(a, b) -> float:
    """Return the p-value by enumeration of all swaps of the pairs that differ."""
    d = [y - x for x, y in zip(a, b, strict=True) if x != y]
    ranks = [0.5 + sum((abs(y) < abs(x)) + 0.5 * (abs(y) == abs(x)) for y in d) for x in d]
    seen = sum(rank for rank, x in zip(ranks, d, strict=True) if x > 0)
    results = [
        sum(rank for rank, sign in zip(ranks, signs, strict=True) if sign)
        for signs in itertools.product([False, True], repeat=len(d))
    ]
    low = sum(result <= seen for result in results) / len(results)
    high = sum(result >= seen for result in results) / len(results)
    return min(1.0, 2.0 * min(low, high))


class TestUnpaired:
    def test_example_of_scipy(self):
        males, females = [19, 22, 16, 29, 24], [20, 11, 17, 12]
        found = unpaired(males, females)
        assert found.p_value == pytest.approx(0.1111111111111111)
        # U of the males is 17 of 20: they are lower in the other 3.
        assert found.a_lower == 3 / 20

    def test_separated_samples_by_hand(self):
        # One of the 20 ways to choose three of six, at each end.
        assert unpaired([1, 2, 3], [4, 5, INF]) == RankTest(p_value=0.1, a_lower=1.0)
        assert unpaired([4, 5, INF], [1, 2, 3]) == RankTest(p_value=0.1, a_lower=0.0)

    @given(small_samples, small_samples)
    def test_ties_and_failures_are_exact(self, a, b):
        assert unpaired(a, b).p_value == pytest.approx(p_of_all_allotments(a, b), abs=1e-12)

    @pytest.mark.parametrize("sizes", [(8, 8), (6, 9)])
    def test_ties_agree_with_scipys_permutation_test(self, sizes):
        rng = np.random.default_rng(1)
        a, b = (rng.integers(0, 6, n).astype(float) for n in sizes)
        method = stats.PermutationMethod(n_resamples=cast(Any, math.inf))
        expected = stats.mannwhitneyu(a, b, method=method).pvalue
        assert unpaired(a, b).p_value == pytest.approx(expected, abs=1e-12)

    def test_without_ties_it_is_scipys_exact_test(self):
        rng = np.random.default_rng(2)
        a, b = rng.normal(size=31), rng.normal(0.5, size=33)
        expected = stats.mannwhitneyu(a, b, method="exact").pvalue
        assert unpaired(a, b).p_value == pytest.approx(expected, rel=1e-12)

    def test_exact_and_approximate_agree_at_the_limit(self):
        rng = np.random.default_rng(3)
        a, b = rng.integers(0, 12, 32).astype(float), rng.integers(1, 13, 32).astype(float)
        a[:2] = b[:5] = INF
        clear = np.where(np.isinf(np.concatenate([a, b])), 99.0, np.concatenate([a, b]))
        expected = stats.mannwhitneyu(clear[:32], clear[32:], method="asymptotic").pvalue
        assert unpaired(a, b).p_value == pytest.approx(expected, rel=0.1)

    def test_many_runs_use_scipys_approximation(self):
        rng = np.random.default_rng(4)
        a, b = rng.integers(0, 30, 60).astype(float), rng.integers(3, 33, 50).astype(float)
        expected = stats.mannwhitneyu(a, b, method="asymptotic").pvalue
        assert unpaired(a, b).p_value == pytest.approx(expected, rel=1e-12)
        a[a == a.max()] = INF
        same = np.where(np.isinf(a), 1000.0, a)
        expected = stats.mannwhitneyu(same, b, method="asymptotic").pvalue
        assert unpaired(a, b).p_value == pytest.approx(expected, rel=1e-12)

    @pytest.mark.parametrize("runs", [1, 5, 40])
    @pytest.mark.parametrize("value", [3.0, INF])
    def test_equal_values_have_p_value_one(self, runs, value):
        same = [value] * runs
        assert unpaired(same, same) == RankTest(p_value=1.0, a_lower=0.5)

    @given(small_samples, small_samples, st.randoms(use_true_random=False))
    def test_order_is_irrelevant_and_sides_mirror(self, a, b, random):
        found = unpaired(a, b)
        random.shuffle(a)
        assert unpaired(a, b) == found
        mirrored = unpaired(b, a)
        assert mirrored.p_value == pytest.approx(found.p_value, abs=1e-12)
        assert mirrored.a_lower == pytest.approx(1.0 - found.a_lower, abs=1e-12)


class TestPaired:
    def test_example_of_scipy(self):
        d = np.array([6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75])
        found = paired(np.zeros(15), d)
        assert found.p_value == pytest.approx(0.041259765625)
        # The two negative differences rank 10 and 14: 24 of 120.
        assert found.a_lower == pytest.approx(96 / 120)

    def test_a_failed_run_has_the_largest_difference(self):
        # Ranks 1 and 2 for b, 3.5 twice for a: 7 or more come from both 3.5 with any of the others,
        # 4 of the 16 sign vectors.
        found = paired([5, 7, 1, 2], [4, 5, INF, INF])
        assert found.a_lower == 0.7
        assert found.p_value == 0.5

    def test_five_pairs_of_the_same_sign(self):
        # One of 32 sign vectors at each end, with ties and with an additional equal pair.
        expected = RankTest(p_value=2 / 32, a_lower=1.0)
        assert paired([1, 2, 3, 4, 5], [2, 4, 6, 8, 10]) == expected
        assert paired([1, 2, 3, 4, 5, 7], [2, 3, 4, 5, 6, 7]) == expected
        assert paired([1, 2, 3, 4, 5, INF], [2, 3, 4, 5, INF, INF]) == expected

    @given(pairs)
    def test_ties_equal_pairs_and_failures_are_exact(self, pairs):
        a, b = zip(*pairs, strict=True)
        assert paired(a, b).p_value == pytest.approx(p_of_all_signs(a, b), abs=1e-12)

    def test_without_ties_it_is_scipys_exact_test(self):
        rng = np.random.default_rng(5)
        a, b = rng.normal(size=(2, 64))
        expected = stats.wilcoxon(a, b, method="exact").pvalue
        assert paired(a, b).p_value == pytest.approx(expected, rel=1e-9)

    def test_exact_and_approximate_agree_at_the_limit(self):
        rng = np.random.default_rng(6)
        d = rng.integers(1, 9, 64) * np.where(rng.random(64) < 0.65, 1.0, -1.0)
        counted = paired(np.zeros(64), d).p_value
        # With every pair doubled scipy approximates: z grows by the square root of two.
        twice = stats.wilcoxon(np.tile(d, 2)).pvalue
        expected = 2.0 * stats.norm.sf(stats.norm.isf(twice / 2.0) / math.sqrt(2.0))
        assert counted == pytest.approx(expected, rel=0.1)

    def test_many_pairs_use_scipys_approximation(self):
        rng = np.random.default_rng(7)
        a, b = rng.integers(0, 30, 80).astype(float), rng.integers(3, 33, 80).astype(float)
        d = (b - a)[a != b]
        assert d.size > 64
        expected = stats.wilcoxon(d, method="approx").pvalue
        assert paired(a, b).p_value == pytest.approx(expected, rel=1e-12)

    @pytest.mark.parametrize("values", [[1.0], [1.0, INF, 3.0], [INF] * 60])
    def test_equal_values_have_p_value_one(self, values):
        assert paired(values, values) == RankTest(p_value=1.0, a_lower=0.5)

    @given(pairs, st.randoms(use_true_random=False))
    def test_order_is_irrelevant_and_sides_mirror(self, pairs, random):
        a, b = zip(*pairs, strict=True)
        found = paired(a, b)
        mirrored = paired(b, a)
        assert mirrored.p_value == pytest.approx(found.p_value, abs=1e-12)
        assert mirrored.a_lower == pytest.approx(1.0 - found.a_lower, abs=1e-12)
        random.shuffle(pairs)
        again = paired(*zip(*pairs, strict=True))
        assert again.p_value == pytest.approx(found.p_value, abs=1e-12)

    def test_bad_pairs_are_refused(self):
        with pytest.raises(InvalidInputError, match="not 2 and 1"):
            paired([1.0, 2.0], [1.0])


@pytest.mark.parametrize("test", [unpaired, paired, vargha_delaney])
@pytest.mark.parametrize(
    ("bad", "words"), [([], "at least one"), ([math.nan], "must not hold nan")]
)
def test_bad_samples_are_refused(test, bad, words):
    with pytest.raises(InvalidInputError, match=f"a .*{words}"):
        test(bad, [1.0])
    with pytest.raises(InvalidInputError, match=f"b .*{words}"):
        test([1.0], bad)


class TestHolm:
    def test_by_hand(self):
        # Smallest times 4, then times 3 and 2, never below the one before: 0.06 is kept.
        given_, expected = [0.01, 0.04, 0.03, 0.005], [0.03, 0.06, 0.06, 0.02]
        assert holm(given_) == pytest.approx(expected)

    def test_adjusted_values_never_exceed_one(self):
        assert holm([0.6, 0.7]).tolist() == [1.0, 1.0]
        assert holm([]).size == 0
        assert holm([0.03]).tolist() == [0.03]

    @given(p_values)
    def test_it_is_holms_procedure(self, values):
        # Reject the smallest while p is at most level / still open, then stop.
        adjusted = holm(values)
        for level in (0.01, 0.05, 0.3):
            rejected: set[int] = set()
            for i in sorted(range(len(values)), key=lambda i: values[i]):
                if values[i] * (len(values) - len(rejected)) > level:
                    break
                rejected.add(i)
            assert {i for i in range(len(values)) if adjusted[i] <= level} == rejected

    @given(p_values, st.randoms(use_true_random=False))
    def test_order_is_kept_and_values_never_lowered(self, values, random):
        adjusted = holm(values)
        assert (adjusted >= values).all()
        assert (adjusted <= 1.0).all()
        by_size = adjusted[np.argsort(values, kind="stable")]
        assert (np.diff(by_size) >= 0.0).all()
        order = list(range(len(values)))
        random.shuffle(order)
        assert np.array_equal(holm([values[i] for i in order]), adjusted[order])

    @pytest.mark.parametrize("bad", [[-0.1], [0.5, 1.1], [math.nan]])
    def test_values_outside_zero_and_one_are_refused(self, bad):
        with pytest.raises(InvalidInputError, match="p-values"):
            holm(bad)

    def test_corrected_tests_keep_effect_sizes(self):
        tests = [RankTest(p_value=0.03, a_lower=0.9), RankTest(p_value=0.02, a_lower=0.2)]
        assert corrected(tests) == [
            RankTest(p_value=0.04, a_lower=0.9),
            RankTest(p_value=0.04, a_lower=0.2),
        ]


class TestMark:
    @pytest.mark.parametrize(
        ("p_value", "a_lower", "lower_is_better", "expected"),
        [
            (0.049, 0.8, True, "+"),
            (0.049, 0.2, True, "-"),
            (0.049, 0.8, False, "-"),
            (0.049, 0.2, False, "+"),
            (0.05, 0.8, True, ""),
            (0.001, 0.5, True, ""),
        ],
    )
    def test_marks_say_whether_a_is_better(self, p_value, a_lower, lower_is_better, expected):
        test = RankTest(p_value=p_value, a_lower=a_lower)
        assert mark(test, lower_is_better=lower_is_better) == expected

    def test_marks_from_values(self):
        fast, slow = np.arange(10.0), np.arange(10.0) + 20.0
        failing = [INF] * 10
        for test in (unpaired, paired):
            assert mark(test(fast, slow)) == "+"
            assert mark(test(slow, fast)) == "-"
            assert mark(test(slow, failing)) == "+"
            assert mark(test(-slow, np.full(10, -INF)), lower_is_better=False) == "+"

    def test_significance_out_of_range_is_refused(self):
        with pytest.raises(InvalidInputError, match="significance"):
            mark(RankTest(p_value=0.5, a_lower=0.5), significance=1.0)


class TestFalsePositives:
    """Rate of marks in experiments without a difference."""

    EXPERIMENTS = 1000
    # 99.99 % quantile of the number of false positives.
    MOST = int(stats.binom(EXPERIMENTS, 0.05).ppf(0.9999))

    @staticmethod
    def smooth(rng: np.random.Generator) -> np.ndarray:
        return rng.lognormal(size=12)

    @staticmethod
    def ties_and_failures(rng: np.random.Generator) -> np.ndarray:
        values = rng.integers(0, 8, 12).astype(float)
        values[rng.random(12) < 0.15] = INF
        return values

    @staticmethod
    def many(rng: np.random.Generator) -> np.ndarray:
        return np.where(rng.random(60) < 0.1, INF, rng.normal(size=60))

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("test", "runs"),
        [
            (unpaired, smooth),
            (paired, smooth),
            (unpaired, ties_and_failures),
            (paired, ties_and_failures),
            (unpaired, many),
        ],
    )
    def test_rate_in_one_cell(self, test, runs):
        rng = np.random.default_rng(8)
        marks = [mark(test(runs(rng), runs(rng))) for _ in range(self.EXPERIMENTS)]
        wrong = self.EXPERIMENTS - marks.count("")
        assert wrong <= self.MOST
        # The rate is near the level: a test without power would be useless.
        assert wrong >= 0.02 * self.EXPERIMENTS
        low, high = stats.binom(wrong, 0.5).interval(0.9999)
        assert low <= marks.count("+") <= high

    @pytest.mark.slow
    def test_rate_in_a_family_of_cells(self):
        rng = np.random.default_rng(9)
        plain = with_holm = 0
        for _ in range(self.EXPERIMENTS):
            tests = [unpaired(*rng.integers(0, 50, (2, 8)).astype(float)) for _ in range(5)]
            plain += any(mark(test) for test in tests)
            with_holm += any(mark(test) for test in corrected(tests))
        assert with_holm <= self.MOST
        assert with_holm >= 0.02 * self.EXPERIMENTS
        # Five cells, each with a rate near 5 %.
        assert plain >= 3 * with_holm

    def test_a_real_difference_is_found(self):
        rng = np.random.default_rng(10)
        marks = [mark(unpaired(rng.normal(size=20), rng.normal(1.5, size=20))) for _ in range(100)]
        assert marks.count("+") >= 95
        assert marks.count("-") == 0


class TestEffectSize:
    @pytest.mark.parametrize(
        ("a", "b", "expected"),
        [
            ([1, 2], [3, 4], 1.0),
            ([3, 4], [1, 2], 0.0),
            ([1, 2], [1, 2], 0.5),
            # Pairs: 1 < 2, 1 < 4, 3 > 2, 3 < 4.
            ([1, 3], [2, 4], 0.75),
            ([1, INF], [INF], 0.75),
            ([1, INF], [2, INF], 0.625),
            ([-INF], [0.0], 1.0),
        ],
    )
    def test_by_hand(self, a, b, expected):
        assert vargha_delaney(a, b) == expected

    @given(small_samples, small_samples)
    def test_effect_size_is_mann_whitneys_u_of_the_other_side(self, a, b):
        clear = [[10.0 if value == INF else value for value in side] for side in (a, b)]
        ranks = stats.rankdata([*clear[1], *clear[0]])
        u_of_b = ranks[: len(b)].sum() - len(b) * (len(b) + 1) / 2
        assert vargha_delaney(a, b) == pytest.approx(u_of_b / (len(a) * len(b)), abs=1e-12)
        assert vargha_delaney(a, b) + vargha_delaney(b, a) == pytest.approx(1.0, abs=1e-12)
        assert unpaired(a, b).a_lower == vargha_delaney(a, b)

    @pytest.mark.parametrize(
        ("share", "word"),
        [
            (0.5, "negligible"),
            (0.559, "negligible"),
            (0.56, "small"),
            (0.639, "small"),
            (0.64, "medium"),
            (0.709, "medium"),
            (0.71, "large"),
            (1.0, "large"),
        ],
    )
    def test_magnitudes_are_equal_on_both_sides(self, share, word):
        assert magnitude(share) == word
        assert magnitude(1.0 - share) == word

    @pytest.mark.parametrize("share", [-0.01, 1.01, math.nan])
    def test_shares_out_of_range_are_refused(self, share):
        with pytest.raises(InvalidInputError, match="from 0 to 1"):
            magnitude(share)
