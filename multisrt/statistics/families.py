"""Tests of a family of cells: one question about two sets of runs, asked under many conditions.

A cell is one condition, such as a radio range and a team size, with runs of `a` and of `b`. Values
are ranked within each cell, so that cells of different scales can be added, one large value cannot
decide, and a failed run is worse than all others. One p-value answers the question for the family;
it can find effects for which no cell alone has enough runs.

Both tests have a parameter `ratio`, by which the values of `b` are multiplied first; `ratios`
inverts them to estimates and intervals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.statistics.permutations import (
    MAX_EXACT,
    doubled_ranks,
    two_sided,
    ways_of_choosing,
    ways_of_signing,
)
from multisrt.statistics.rank_tests import RankTest
from multisrt.statistics.samples import strata_of
from multisrt.statistics.wins import share_of_wins

MAX_SUMS = 200_000
"""Number of different rank sums up to which the test of unpaired runs is exact."""

MAX_COMMON = 1_000_000
"""Bound of the common multiple of cell sizes that makes all weights whole."""

Repetitions = Sequence[Sequence[int]]
"""Numbers of the repetitions of the runs of each cell, none twice in a cell."""

Run = tuple[str, int, int]
"""Side, number of the repetition, and the cell if a repetition has runs in one cell only, or -1."""


def paired_family(
    a_by_cell: Sequence[ArrayLike],
    b_by_cell: Sequence[ArrayLike],
    *,
    repetitions: Repetitions | None = None,
    ratio: float = 1.0,
) -> RankTest:
    """Return the signed-rank test of a family whose cells share repetitions.

    In each cell Wilcoxon's signed ranks of the differences are computed: pairs of equal values, or
    of two failed runs, are left out, and a pair in which one run failed has the largest
    difference. The signed ranks of one repetition are added over the cells, so that a cell counts
    by the number of its pairs that differ.

    If it does not matter which run is of `a` and which of `b`, then a repetition's sum may as well
    have the opposite sign, however the cells depend on each other within the repetition: given the
    sizes of the sums, all vectors of their signs are equally likely. The p-value is exact, by
    counting them, up to `permutations.MAX_EXACT` repetitions, and by the normal approximation
    beyond. With one cell it is that of `rank_tests.paired`.

    Repetitions must be independent of each other. Pairs by chance are valid but arbitrary; of
    sides that share nothing, use `unpaired_family`.

    Source: Wilcoxon, Individual comparisons by ranking methods, Biometrics Bulletin 1, 1945, in
    each cell; cells are combined by the sum, as in Pesarin and Salmaso, Permutation Tests for
    Complex Data, 2010.

    Parameters
    ----------
    a_by_cell, b_by_cell : sequence of array_like, shapes (n_i,)
        Values of runs by cell, cells in the same order; in each cell as many of `a` as of `b`, in
        pairs.
    repetitions : sequence of sequence of int, optional
        Numbers of the repetitions of the pairs of each cell, none twice in a cell; cells may lack
        some. By default pairs at the same index are of the same repetition.
    ratio : float
        Positive number by which the values of `b` are multiplied.

    Returns
    -------
    RankTest
        The p-value, and the share of pairs with `a` lower in the sum of ranks of all cells: 1 if
        all of `a` are lower.

    Raises
    ------
    InvalidInputError
        If cells are empty, hold nan or do not fit to each other, or the ratio is not positive.

    Examples
    --------
    Six repetitions of two cells. One of 64 sign vectors has a sum as large, one as small:

    >>> a = [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]]
    >>> b = [[2.0, 4.0, 6.0, 8.0, 9.0, 9.0], [12.0, 21.0, 35.0, 44.0, 53.0, float("inf")]]
    >>> paired_family(a, b)
    RankTest(p_value=0.03125, a_lower=1.0)
    """
    cells = _cells(a_by_cell, b_by_cell, ratio)
    of_repetition: dict[int, int] = {}
    all_ranks = 0
    for i, (a, b) in enumerate(cells):
        if a.size != b.size:
            raise InvalidInputError(
                f"cell {i} of a paired family needs as many values of a as of b, not {a.size} and "
                f"{b.size}"
            )
        signed = _signed_ranks(a, b)
        all_ranks += int(np.abs(signed).sum())
        for number, rank in zip(_numbers(repetitions, i, a.size), signed.tolist(), strict=True):
            of_repetition[number] = of_repetition.get(number, 0) + rank
    sums = np.array(list(of_repetition.values()), dtype=np.int64)
    if all_ranks == 0:
        return RankTest(p_value=1.0, a_lower=0.5)
    a_lower = 0.5 + 0.5 * float(sums.sum()) / all_ranks
    return RankTest(p_value=_p_of_signs(sums), a_lower=a_lower)


def unpaired_family(
    a_by_cell: Sequence[ArrayLike],
    b_by_cell: Sequence[ArrayLike],
    *,
    repetitions: tuple[Repetitions, Repetitions] | None = None,
    ratio: float = 1.0,
) -> RankTest:
    """Return the rank-sum test of a family of unpaired runs: van Elteren's, or by repetition.

    The statistic is the sum over cells of the rank sum of `a` divided by the number of runs of the
    cell plus 1, the weights that are best if the effect is about the same in all cells. If the
    cells are independent, any runs of a cell may as well be those of `a`: this is van Elteren's
    test. If they share repetitions, as when a drawn world is met by several teams, whole
    repetitions are exchanged instead of runs: those that have runs in the same cells.

    The p-value is exact where there are few enough sums to count (`MAX_SUMS`; cells of one size
    have few) and no more than `permutations.MAX_EXACT` repetitions to exchange; otherwise it is
    the normal approximation with the variance for ties. With one cell it is `rank_tests.unpaired`.

    Source: van Elteren, On the combination of independent two sample tests of Wilcoxon, Bulletin
    of the Institute of International Statistics 37, 1960; Lehmann, Nonparametrics, 1975,
    section 3.3; differs in: whole repetitions are exchanged where cells share them.

    Parameters
    ----------
    a_by_cell, b_by_cell : sequence of array_like, shapes (n_i,) and (m_i,)
        Values of runs by cell, cells in the same order.
    repetitions : (sequence of sequence of int, sequence of sequence of int), optional
        Numbers of the repetitions of the runs of `a` and of `b` in each cell. Equal numbers of `a`
        and `b` mean nothing. By default no two runs are of one repetition.
    ratio : float
        Positive number by which the values of `b` are multiplied.

    Returns
    -------
    RankTest
        The p-value, and the mean over cells of `effect_size.vargha_delaney` with van Elteren's
        weights, n m / (n + m + 1).

    Raises
    ------
    InvalidInputError
        As in `paired_family`, but for different numbers of runs.

    Examples
    --------
    Two cells of two runs each: one of 6 * 6 arrangements is as extreme, at each end. If the cells
    share their repetitions, there are no more than 6.

    >>> a, b = [[1, 2], [10, 20]], [[3, 4], [30, 40]]
    >>> round(unpaired_family(a, b).p_value, 4)
    0.0556
    >>> shared = [[0, 1], [0, 1]]
    >>> round(unpaired_family(a, b, repetitions=(shared, shared)).p_value, 4)
    0.3333
    """
    cells = _cells(a_by_cell, b_by_cell, ratio)
    importance = np.array([a.size * b.size / (a.size + b.size + 1) for a, b in cells])
    wins = np.array([share_of_wins(a, b) for a, b in cells])
    return RankTest(
        p_value=_p_of_exchanges(_exchangeable(cells, repetitions)),
        a_lower=float(importance @ wins / importance.sum()),
    )


# Signs of repetitions ------------------------------------------------------------------------


def _signed_ranks(a: FloatArray, b: FloatArray) -> IntArray:
    """Return doubled signed ranks of the pairs, positive where `a` is lower, 0 for equal pairs."""
    signed = np.zeros(a.size, dtype=np.int64)
    differ = a != b
    differences = b[differ] - a[differ]
    ranks = doubled_ranks(np.abs(differences))
    signed[differ] = np.where(differences > 0.0, ranks, -ranks)
    return signed


def _numbers(repetitions: Repetitions | None, cell: int, runs: int) -> Sequence[int]:
    if repetitions is None:
        return range(runs)
    numbers = repetitions[cell] if cell < len(repetitions) else ()
    if len(numbers) != runs or len(set(numbers)) != runs:
        raise InvalidInputError(
            f"cell {cell} has {runs} values and needs as many different repetitions, not "
            f"{list(numbers)}"
        )
    return numbers


def _p_of_signs(sums: IntArray) -> float:
    if np.count_nonzero(sums) <= MAX_EXACT:
        sizes = np.abs(sums[sums != 0])
        return two_sided(ways_of_signing(sizes), int(sums[sums > 0].sum()))
    deviation = math.sqrt(float(np.square(sums, dtype=np.float64).sum()))
    return _p_of_z(float(sums.sum()) / deviation)


# Exchanges ----------------------------------------------------------------------------------


class _Group(NamedTuple):
    """Repetitions that can be exchanged: their sums, and whether each is of `a`."""

    sums: IntArray
    of_a: BoolArray


def _exchangeable(
    cells: Sequence[tuple[FloatArray, FloatArray]],
    repetitions: tuple[Repetitions, Repetitions] | None,
) -> list[_Group]:
    """Return the weighted sums of ranks of all repetitions, by the cells in which they have runs.

    Ranks are doubled and less their mean in the cell.
    """
    sizes = [a.size + b.size for a, b in cells]
    sums: dict[Run, int] = {}
    where: dict[Run, list[int]] = {}
    for i, (cell, weight) in enumerate(zip(cells, _whole_weights(sizes), strict=True)):
        ranks = weight * (doubled_ranks(np.concatenate(cell)) - (sizes[i] + 1))
        for run, rank in zip(_runs(cell, repetitions, i), ranks.tolist(), strict=True):
            sums[run] = sums.get(run, 0) + rank
            where.setdefault(run, []).append(i)
    alike: dict[tuple[int, ...], list[Run]] = {}
    for run, met in where.items():
        alike.setdefault(tuple(met), []).append(run)
    return [
        _Group(np.array([sums[run] for run in runs]), np.array([run[0] == "a" for run in runs]))
        for runs in alike.values()
    ]


def _whole_weights(sizes: Sequence[int]) -> list[int]:
    """Return van Elteren's weights in whole numbers, which are rounded if they are very large."""
    common = min(math.lcm(*(size + 1 for size in sizes)), MAX_COMMON)
    return [round(common / (size + 1)) for size in sizes]


def _runs(
    cell: tuple[FloatArray, FloatArray], repetitions: tuple[Repetitions, Repetitions] | None, i: int
) -> list[Run]:
    """Return the side and the repetition of each run of a cell, first those of `a`."""
    of_a, of_b = (None, None) if repetitions is None else repetitions
    own_cell = i if repetitions is None else -1
    return [
        (side, number, own_cell)
        for side, values, of in (("a", cell[0], of_a), ("b", cell[1], of_b))
        for number in _numbers(of, i, values.size)
    ]


def _p_of_exchanges(groups: Sequence[_Group]) -> float:
    # From 1 on, in the largest unit, so that they can be counted; how many are chosen is fixed.
    above = [group.sums - group.sums.min() for group in groups]
    unit = max(1, int(np.gcd.reduce(np.concatenate(above))))
    shifted = [sums // unit + 1 for sums in above]
    exact = (
        max(sums.size for sums in shifted) <= MAX_EXACT
        and sum(int(sums.sum()) for sums in shifted) <= MAX_SUMS
    )
    if not exact:
        return _p_by_normal(groups)
    shares, seen = np.ones(1), 0
    for sums, group in zip(shifted, groups, strict=True):
        ways = ways_of_choosing(sums, int(np.count_nonzero(group.of_a)))
        seen += int(sums[group.of_a].sum())
        shares = np.convolve(shares, ways / ways.sum())
    return two_sided(shares, seen)


def _p_by_normal(groups: Sequence[_Group]) -> float:
    excess, variance = 0.0, 0.0
    for sums, of_a in groups:
        from_mean = sums - sums.mean()
        excess += float(from_mean[of_a].sum())
        spread = float(np.square(from_mean).sum()) / max(1, sums.size - 1)
        variance += np.count_nonzero(of_a) * np.count_nonzero(~of_a) / sums.size * spread
    return _p_of_z(excess / math.sqrt(variance)) if variance > 0.0 else 1.0


def _p_of_z(z: float) -> float:
    return float(2.0 * stats.norm.sf(abs(z)))


# Input ---------------------------------------------------------------------------------------


def _cells(
    a_by_cell: Sequence[ArrayLike], b_by_cell: Sequence[ArrayLike], ratio: float
) -> list[tuple[FloatArray, FloatArray]]:
    a, b = strata_of(a_by_cell, "a"), strata_of(b_by_cell, "b")
    if len(a) != len(b):
        raise InvalidInputError(
            f"a and b must have runs in the same cells, but a has {len(a)} and b has {len(b)}"
        )
    if not 0.0 < ratio < math.inf:
        raise InvalidInputError(f"a ratio must be positive and finite, not {ratio}")
    if ratio == 1.0:
        return list(zip(a, b, strict=True))
    lowest = min(float(values.min()) for values in (*a, *b))
    if lowest < 0.0:
        raise InvalidInputError(f"ratios need values of at least 0, not {lowest}")
    return [(of_a, ratio * of_b) for of_a, of_b in zip(a, b, strict=True)]
