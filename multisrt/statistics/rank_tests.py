"""Rank tests of two sets of runs, Holm's correction, and the marks of a table.

The tests are two-sided. Up to `MAX_EXACT` runs in both samples together, or pairs that differ,
they are exact, with or without ties, by counting the arrangements of the ranks. Beyond that they
are scipy's normal approximations, which account for ties.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.statistics.permutations import (
    MAX_EXACT,
    doubled_ranks,
    two_sided,
    ways_of_choosing,
    ways_of_signing,
)
from multisrt.statistics.samples import finite_sample_of, sample_of
from multisrt.statistics.wins import share_of_wins

SIGNIFICANCE = 0.05
"""Default significance level: a smaller p-value is significant."""

Mark = Literal["+", "-", ""]


@dataclass(frozen=True, slots=True, kw_only=True)
class RankTest:
    """The result of a rank test of two sets of runs, `a` and `b`.

    Attributes
    ----------
    p_value : float
        Two-sided p-value.
    a_lower : float
        Effect size from 0 (all of `a` are higher) to 1 (all of `a` are lower). Unpaired it is
        `effect_size.vargha_delaney`; paired, the share of pairs with `a` lower in the sum of
        ranks.
    """

    p_value: float
    a_lower: float


def unpaired(a: ArrayLike, b: ArrayLike) -> RankTest:
    """Return the result of Mann and Whitney's U test, for independent runs.

    Parameters
    ----------
    a, b : array_like, shapes (n,) and (m,)
        Values of runs; infinite ones are tied.

    Returns
    -------
    RankTest
        p-value and effect size; the p-value is 1 if all values are equal.

    Raises
    ------
    InvalidInputError
        If one is empty or holds nan.

    Examples
    --------
    >>> test = unpaired([1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0])
    >>> round(test.p_value, 4), test.a_lower
    (0.0286, 1.0)
    """
    of_a, of_b = sample_of(a, "a"), sample_of(b, "b")
    pooled = np.concatenate([of_a, of_b])
    a_lower = share_of_wins(of_a, of_b)
    if np.all(pooled == pooled[0]):
        return RankTest(p_value=1.0, a_lower=a_lower)
    # Ranks instead of values: the test is the same, and infinite values do no harm.
    ranks = doubled_ranks(pooled)
    of_first, of_second = ranks[: of_a.size], ranks[of_a.size :]
    if pooled.size <= MAX_EXACT:
        ways = ways_of_choosing(ranks, of_first.size)
        p_value = two_sided(ways, int(of_first.sum()))
    else:
        test = stats.mannwhitneyu(of_first, of_second, method="asymptotic")
        p_value = float(test.pvalue)
    return RankTest(p_value=p_value, a_lower=a_lower)


def paired(a: ArrayLike, b: ArrayLike) -> RankTest:
    """Return the result of Wilcoxon's signed-rank test, for runs in pairs.

    Pairs of equal values, or of two failed runs, are left out, as Wilcoxon did. A pair in which
    one run failed has the largest difference.

    Parameters
    ----------
    a, b : array_like, shape (n,)
        Values of runs; pairs, made under equal conditions, in the same order.

    Returns
    -------
    RankTest
        p-value and effect size; the p-value is 1 if all pairs are equal.

    Raises
    ------
    InvalidInputError
        If they are empty, hold nan or differ in length.

    Examples
    --------
    >>> paired([1.0, 2.0, 3.0, 4.0, 5.0], [2.0, 4.0, 6.0, 8.0, 10.0])
    RankTest(p_value=0.0625, a_lower=1.0)
    """
    of_a, of_b = sample_of(a, "a"), sample_of(b, "b")
    if of_a.size != of_b.size:
        raise InvalidInputError(
            f"a paired test needs as many values of a as of b, not {of_a.size} and {of_b.size}"
        )
    differ = of_a != of_b
    if not differ.any():
        return RankTest(p_value=1.0, a_lower=0.5)
    differences = of_b[differ] - of_a[differ]
    ranks = doubled_ranks(np.abs(differences))
    a_is_lower = differences > 0.0
    if ranks.size <= MAX_EXACT:
        p_value = two_sided(ways_of_signing(ranks), int(ranks[a_is_lower].sum()))
    else:
        signed = np.where(a_is_lower, ranks, -ranks)
        p_value = float(stats.wilcoxon(signed, method="approx").pvalue)
    return RankTest(p_value=p_value, a_lower=float(ranks[a_is_lower].sum() / ranks.sum()))


def holm(p_values: ArrayLike) -> FloatArray:
    """Return the p-values of a family of tests, adjusted by Holm's step-down procedure.

    If adjusted p-values below a level count as significant, the probability of any false positive
    in the family is at most that level, whatever the dependence of the tests.

    Source: Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
    Statistics 6, 1979.

    Parameters
    ----------
    p_values : array_like, shape (n,)
        p-values of all tests of the family, in any order; may be empty.

    Returns
    -------
    ndarray of float, shape (n,)
        Adjusted p-values in the same order, none smaller than before.

    Raises
    ------
    InvalidInputError
        If a p-value is not from 0 to 1.

    Examples
    --------
    >>> holm([0.01, 0.04, 0.03])
    array([0.03, 0.06, 0.06])
    """
    if np.size(p_values) == 0:
        return np.zeros(0)
    given = finite_sample_of(p_values, "p-values")
    if given.min() < 0.0 or given.max() > 1.0:
        raise InvalidInputError(
            f"p-values are from 0 to 1, not from {given.min()} to {given.max()}"
        )
    order = np.argsort(given, kind="stable")
    still_open = np.arange(given.size, 0, -1)
    adjusted = np.empty_like(given)
    adjusted[order] = np.minimum(np.maximum.accumulate(still_open * given[order]), 1.0)
    return adjusted


def corrected(tests: Sequence[RankTest]) -> list[RankTest]:
    """Return the tests of a family with p-values adjusted by `holm`.

    Parameters
    ----------
    tests : sequence of RankTest
        All tests of the family.

    Returns
    -------
    list of RankTest
        The tests in the same order.
    """
    adjusted = holm([test.p_value for test in tests])
    return [replace(test, p_value=float(p)) for test, p in zip(tests, adjusted, strict=True)]


def mark(
    test: RankTest, *, significance: float = SIGNIFICANCE, lower_is_better: bool = True
) -> Mark:
    """Return the mark of `a` against its rival `b` in a table.

    Tables with several marks need `corrected` tests.

    Source: Elizondo, Ramírez, Rodriguez and Martínez, Multi-robot Exploration Using Self-Biddings
    under Constraints on Communication Range, Tables I to V, in which `a` is the proposed method
    and each cell belongs to a rival `b`; the paper does not name its test.

    Parameters
    ----------
    test : RankTest
        Test of `a` and `b`.
    significance : float
        Significance level, between 0 and 1.
    lower_is_better : bool
        Whether lower values are better.

    Returns
    -------
    {"+", "-", ""}
        "+" if `a` is significantly better, "-" if it is worse, "" if no difference was found.

    Raises
    ------
    InvalidInputError
        If `significance` is not between 0 and 1.

    Examples
    --------
    >>> mark(RankTest(p_value=0.01, a_lower=0.9))
    '+'
    """
    if not 0.0 < significance < 1.0:
        raise InvalidInputError(f"a significance must be between 0 and 1, not {significance}")
    if test.p_value >= significance or test.a_lower == 0.5:
        return ""
    return "+" if (test.a_lower > 0.5) == lower_is_better else "-"
