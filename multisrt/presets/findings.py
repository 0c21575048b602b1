"""Tests of comparisons: one of a family, and one of each of its cells."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from multisrt.presets.cells import Comparison, Family
from multisrt.statistics.effect_size import vargha_delaney
from multisrt.statistics.families import paired_family, unpaired_family
from multisrt.statistics.intervals import LEVEL, Interval
from multisrt.statistics.rank_tests import (
    SIGNIFICANCE,
    RankTest,
    corrected,
    paired,
    unpaired,
)
from multisrt.statistics.ratios import ratio_of
from multisrt.statistics.summaries import median

Saying = Literal["for", "against", "nothing"]


def saying(p_value: float, is_lower: bool) -> Saying:
    """Return whether a test supports that the first set is lower, contradicts it, or neither."""
    if p_value >= SIGNIFICANCE:
        return "nothing"
    return "for" if is_lower else "against"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Result of the test of a single comparison.

    Attributes
    ----------
    comparison : Comparison
        The comparison.
    p_value : float
        P-value, adjusted over the comparisons of the claim.
    is_lower : bool
        Whether the first set is lower, as claimed, significantly or not.
    effect : float
        Vargha and Delaney's A: probability that a run of the first set is lower than one of the
        second.
    """

    comparison: Comparison
    p_value: float
    is_lower: bool
    effect: float

    @property
    def saying(self) -> Saying:
        """Whether the comparison supports the claim or contradicts it."""
        return saying(self.p_value, self.is_lower)


@dataclass(frozen=True, slots=True, kw_only=True)
class FamilyFinding:
    """Result of the one test of all comparisons of a claim.

    Attributes
    ----------
    test : RankTest
        The test; `a` is the set that is claimed to be lower.
    ratio : Interval
        Ratio of the first set to the second, with its interval.
    level : float
        Confidence level of the interval.
    cells, repetitions : int
        Numbers of comparisons and of repetitions that have runs.
    paired : bool
        Whether repetitions are pairs.
    reference : float
        Mean over cells of the median of the second set, those without a finite one left out;
        nan if there is none.
    """

    test: RankTest
    ratio: Interval
    level: float
    cells: int
    repetitions: int
    paired: bool
    reference: float

    @property
    def saying(self) -> Saying:
        """Whether the family supports the claim or contradicts it."""
        return saying(self.test.p_value, self.test.a_lower > 0.5)


def weigh(comparisons: Iterable[Comparison], *, adjusted: bool = True) -> list[Finding]:
    """Return the tests of the comparisons of one claim, without those that lack runs.

    Parameters
    ----------
    comparisons : iterable of Comparison
        The comparisons.
    adjusted : bool
        Whether to adjust p-values over them by Holm's procedure.
    """
    found = [comparison for comparison in comparisons if comparison.has_runs]
    tests = [(paired if c.paired else unpaired)(*c.sides) for c in found]
    return [
        Finding(
            comparison=comparison,
            p_value=test.p_value,
            is_lower=test.a_lower > 0.5,
            effect=vargha_delaney(*comparison.sides),
        )
        for comparison, test in zip(found, corrected(tests) if adjusted else tests, strict=True)
    ]


def weigh_family(family: Family, *, level: float = LEVEL) -> FamilyFinding | None:
    """Return the one test of the comparisons of a claim; None if all of them lack runs.

    Parameters
    ----------
    family : Family
        The cells.
    level : float
        Confidence level of the ratio's interval.
    """
    found = family.with_runs
    if not found:
        return None
    test = _paired(found) if family.paired else _unpaired(found)
    medians = np.array([float(median(np.array([*one.higher.values()]))) for one in found])
    finite = medians[np.isfinite(medians)]
    return FamilyFinding(
        test=test(1.0),
        ratio=ratio_of(test, level=level),
        level=level,
        cells=len(found),
        repetitions=len(set().union(*(comparison.repetitions for comparison in found))),
        paired=family.paired,
        reference=float(finite.mean()) if finite.size else math.nan,
    )


def _paired(found: Sequence[Comparison]) -> Callable[[float], RankTest]:
    lower, higher = zip(*(comparison.pairs for comparison in found), strict=True)
    repetitions = [comparison.repetitions for comparison in found]
    return lambda ratio: paired_family(lower, higher, repetitions=repetitions, ratio=ratio)


def _unpaired(found: Sequence[Comparison]) -> Callable[[float], RankTest]:
    sides = [one.lower for one in found], [one.higher for one in found]
    lower, higher = ([[*cell.values()] for cell in side] for side in sides)
    first, second = ([[*cell] for cell in side] for side in sides)
    return lambda ratio: unpaired_family(lower, higher, repetitions=(first, second), ratio=ratio)
