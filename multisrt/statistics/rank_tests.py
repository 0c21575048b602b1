"""Whether two sets of runs differ: rank tests, Holm's correction, and the marks of a table.

The tests are two-sided. Up to `EXACT_UP_TO` runs they are exact, with ties as without: scipy's
where there are none, and with ties by counting the arrangements of the ranks. Beyond that they are
scipy's normal approximations, which allow for ties.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.statistics.samples import finite_sample_of, sample_of
from multisrt.statistics.wins import share_of_wins

EXACT_UP_TO = 50
"""Runs in both samples together, or pairs that differ, up to which a test is exact."""

SIGNIFICANCE = 0.05
"""A difference is significant where the p-value is below this, unless told otherwise."""

Mark = Literal["+", "-", ""]


@dataclass(frozen=True, slots=True, kw_only=True)
class RankTest:
    """What a rank test says of two sets of runs, `a` and `b`.

    Attributes
    ----------
    p_value : float
        Two-sided: how probable so large a difference is where there is none.
    a_lower : float
        Where `a` stands, from 0 (all of `a` is higher) over 0.5 to 1 (all of `a` is lower).
        Unpaired it is `effect_size.vargha_delaney`; paired, the share that pairs with `a` lower
        have in the sum of the signed ranks.
    """

    p_value: float
    a_lower: float


def unpaired(a: ArrayLike, b: ArrayLike) -> RankTest:
    """Mann-Whitney's U test, of runs that have nothing to do with each other.

    Parameters
    ----------
    a, b : array_like, shapes (n,) and (m,)
        Values of runs; infinite ones are ties at their end.

    Raises
    ------
    InvalidInputError
        If one is empty or holds nan.
    """
    of_a, of_b = sample_of(a, "a"), sample_of(b, "b")
    pooled = np.concatenate([of_a, of_b])
    # The test goes by ranks; given to it instead of the values, infinite ones are as good as any.
    ranks = stats.rankdata(pooled)
    a_lower = share_of_wins(of_a, of_b)
    if np.all(pooled == pooled[0]):
        return RankTest(p_value=1.0, a_lower=a_lower)
    small = pooled.size <= EXACT_UP_TO
    if small and _has_ties(pooled):
        doubled = _doubled(ranks)
        ways = _ways_of_choosing(doubled, of_a.size)
        p_value = _two_sided(ways, int(doubled[: of_a.size].sum()))
    else:
        p_value = float(
            stats.mannwhitneyu(
                ranks[: of_a.size],
                ranks[of_a.size :],
                alternative="two-sided",
                method="exact" if small else "asymptotic",
            ).pvalue
        )
    return RankTest(p_value=p_value, a_lower=a_lower)


def paired(a: ArrayLike, b: ArrayLike) -> RankTest:
    """Wilcoxon's signed-rank test, of runs made in pairs under the same conditions.

    Pairs that are equal, also both failed, say nothing and are left out, as Wilcoxon did; where
    all are, the p-value is 1. A pair of which one failed differs more than any that did not.

    Parameters
    ----------
    a, b : array_like, shape (n,)
        Values of runs, pairs in the same order.

    Raises
    ------
    InvalidInputError
        If they are empty, hold nan or differ in length.
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
    sizes = np.abs(differences)
    ranks = stats.rankdata(sizes)
    a_is_lower = differences > 0.0
    if sizes.size <= EXACT_UP_TO and _has_ties(sizes):
        doubled = _doubled(ranks)
        p_value = _two_sided(_ways_of_signing(doubled), int(doubled[a_is_lower].sum()))
    else:
        # Exact here up to fifty pairs, by scipy's own choice.
        p_value = float(stats.wilcoxon(np.where(a_is_lower, ranks, -ranks)).pvalue)
    return RankTest(p_value=p_value, a_lower=float(ranks[a_is_lower].sum() / ranks.sum()))


def holm(p_values: ArrayLike) -> FloatArray:
    """Adjust the p-values of a family of tests by Holm's step-down procedure.

    Where those below a level are taken as significant, the probability that any of the tests
    finds a difference where there is none is at most that level, however they depend on each
    other.

    Parameters
    ----------
    p_values : array_like, shape (n,)
        Of all tests of the family, in any order; may be empty.

    Returns
    -------
    ndarray of float, shape (n,)
        In the same order, none smaller than before.

    Raises
    ------
    InvalidInputError
        Unless all are from 0 to 1.

    Source: Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
    Statistics 6, 1979.
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
    """Give the tests of a family with their p-values adjusted by `holm`."""
    adjusted = holm([test.p_value for test in tests])
    return [replace(test, p_value=float(p)) for test, p in zip(tests, adjusted, strict=True)]


def mark(
    test: RankTest, *, significance: float = SIGNIFICANCE, lower_is_better: bool = True
) -> Mark:
    """Mark `a` against its rival `b`: "+" significantly better, "-" worse, "" no difference found.

    Marks of several cells call for `corrected` tests.

    Source: Elizondo, Ramírez, Rodriguez and Martínez, Multi-robot Exploration Using Self-Biddings
    under Constraints on Communication Range, Tables I to V, in which `a` is what the paper
    proposes and each cell belongs to a rival `b`; they do not say which test is behind them.

    Raises
    ------
    InvalidInputError
        Unless 0 < `significance` < 1.
    """
    if not 0.0 < significance < 1.0:
        raise InvalidInputError(f"a significance must be between 0 and 1, not {significance}")
    if test.p_value >= significance or test.a_lower == 0.5:
        return ""
    return "+" if (test.a_lower > 0.5) == lower_is_better else "-"


# Exact distributions with ties ----------------------------------------------------------------
# Streitberg and Röhmel, Exact distributions for permutation and rank tests: an introduction to
# some recently published algorithms, Statistical Software Newsletter 12, 1986. Ranks in the
# middle of ties are halves: doubled, all are whole numbers.


def _ways_of_choosing(ranks: IntArray, chosen: int) -> FloatArray:
    """Entry s: in how many ways so many of the ranks can be chosen that they add up to s."""
    ways = np.zeros((chosen + 1, int(ranks.sum()) + 1))
    ways[0, 0] = 1.0
    for rank in ranks:
        ways[1:, rank:] += ways[:-1, :-rank].copy()
    return np.asarray(ways[chosen])


def _ways_of_signing(ranks: IntArray) -> FloatArray:
    """Entry s: with how many sets of signs the ranks with a plus add up to s."""
    ways = np.zeros(int(ranks.sum()) + 1)
    ways[0] = 1.0
    for rank in ranks:
        ways[rank:] += ways[:-rank].copy()
    return ways


def _two_sided(ways: FloatArray, seen: int) -> float:
    """Twice the probability of the lighter of the two tails that begin at what was seen."""
    lighter = min(ways[: seen + 1].sum(), ways[seen:].sum())
    return float(min(1.0, 2.0 * lighter / ways.sum()))


def _doubled(ranks: FloatArray) -> IntArray:
    return np.rint(2.0 * ranks).astype(np.int64)


def _has_ties(values: FloatArray) -> bool:
    return np.unique(values).size < values.size
