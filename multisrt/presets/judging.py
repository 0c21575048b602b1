"""Judgement of a claim: its comparisons are tested together, and then counted.

A claim makes comparisons of two sets of runs, of which the first is claimed to have the lower
values. All are tested by two-sided rank tests, with p-values adjusted by Holm's procedure over the
comparisons of the claim. A comparison supports or contradicts the claim if p is below 5 %;
otherwise it is undecided.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from multisrt.experiments.crossing import Condition, conditions
from multisrt.experiments.measures import Measure
from multisrt.experiments.results import Result, Results
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.statistics.effect_size import vargha_delaney
from multisrt.statistics.rank_tests import SIGNIFICANCE, corrected, holm, paired, unpaired
from multisrt.statistics.summaries import median

Saying = Literal["for", "against", "nothing"]

Scope = Literal["always", "mostly", "somewhere"]
"""Scope of a claim: without exception, in general, or in at least one case."""


class Quantity(Protocol):
    """The quantity of a comparison, as tables show it; a `Measure` is one."""

    @property
    def heading(self) -> str:
        """Title with unit."""

    @property
    def unit(self) -> str:
        """Unit; may be empty."""

    @property
    def digits(self) -> int:
        """Number of decimals in texts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Two sets of runs, of which the first is claimed to have the lower values.

    Attributes
    ----------
    where : str
        Name of the comparison.
    lower, higher : tuple of float
        Values of the two sets, infinite for failed runs; empty without runs.
    paired : bool
        Whether values at the same index are of one repetition, with the same world and starts.
    """

    where: str
    lower: tuple[float, ...]
    higher: tuple[float, ...]
    paired: bool = False

    @property
    def has_runs(self) -> bool:
        """Whether both sets have runs."""
        return bool(self.lower) and bool(self.higher)

    @property
    def min_p_value(self) -> float:
        """Smallest p-value that this number of runs can have; 1 without runs."""
        n, m = len(self.lower), len(self.higher)
        if not self.has_runs:
            return 1.0
        return min(1.0, 2.0 / (2.0**n if self.paired else float(math.comb(n + m, n))))


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Result of the test of a comparison.

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
        if self.p_value >= SIGNIFICANCE:
            return "nothing"
        return "for" if self.is_lower else "against"


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """A judged claim and the table of its comparisons."""

    claim: Claim
    table: PrintedTable


# Runs ---------------------------------------------------------------------------------------


class Cells:
    """The runs of an experiment by condition; conditions without runs are included.

    Parameters
    ----------
    results : Results
        Results of the experiment, which may be incomplete.
    """

    def __init__(self, results: Results) -> None:
        self._runs: dict[Condition, dict[int, Result]] = {
            condition: {} for condition in conditions(results.experiment)
        }
        for result in results:
            self._runs.setdefault(result.condition, {})[result.repetition] = result

    def conditions(self) -> list[Condition]:
        """Return all conditions of the experiment, in its order."""
        return list(self._runs)

    def of(self, condition: Condition) -> list[Result]:
        """Return the runs of a condition."""
        return list(self._runs.get(condition, {}).values())

    def values(self, condition: Condition, measure: Measure) -> tuple[float, ...]:
        """Return a measure of the runs of a condition; infinite for runs that are not complete."""
        return tuple(measure.values(self.of(condition)))

    def unpaired(
        self, where: str, *, lower: Condition, higher: Condition, measure: Measure
    ) -> Comparison:
        """Return the comparison of all runs of two conditions."""
        return Comparison(
            where=where, lower=self.values(lower, measure), higher=self.values(higher, measure)
        )

    def paired(
        self, where: str, *, lower: Condition, higher: Condition, measure: Measure
    ) -> Comparison:
        """Return the comparison of the repetitions that two conditions share."""
        first, second = self._runs.get(lower, {}), self._runs.get(higher, {})
        both = sorted(first.keys() & second.keys())
        return Comparison(
            where=where,
            lower=tuple(measure.values(first[repetition] for repetition in both)),
            higher=tuple(measure.values(second[repetition] for repetition in both)),
            paired=True,
        )


# Verdicts -----------------------------------------------------------------------------------


def weigh(comparisons: Iterable[Comparison]) -> list[Finding]:
    """Return the tests of the comparisons of one claim, without those that lack runs."""
    found = [comparison for comparison in comparisons if comparison.has_runs]
    tests = [(paired if c.paired else unpaired)(c.lower, c.higher) for c in found]
    return [
        Finding(
            comparison=comparison,
            p_value=test.p_value,
            is_lower=test.a_lower > 0.5,
            effect=vargha_delaney(comparison.lower, comparison.higher),
        )
        for comparison, test in zip(found, corrected(tests), strict=True)
    ]


def verdict(sayings: Sequence[Saying], scope: Scope) -> Verdict:
    """Return the verdict on a claim by its comparisons.

    - "always": holds if more than half of them support it and none contradicts it; does not hold
      if any contradicts it.
    - "mostly": holds if more than half support it; otherwise does not hold if any contradicts it.
    - "somewhere": holds if any supports it; does not hold if all contradict it.

    Otherwise the verdict is "not significant".

    Examples
    --------
    >>> verdict(["for", "for", "against"], "mostly"), verdict(["for", "for", "against"], "always")
    ('holds', 'does not hold')
    """
    fors, againsts = sayings.count("for"), sayings.count("against")
    if scope == "somewhere":
        if fors:
            return "holds"
        return "does not hold" if sayings and againsts == len(sayings) else "not significant"
    if againsts and scope == "always":
        return "does not hold"
    if 2 * fors > len(sayings):
        return "holds"
    return "does not hold" if againsts else "not significant"


def could_be_significant(comparisons: Sequence[Comparison], scope: Scope) -> bool:
    """Return whether the claim could hold with these numbers of runs."""
    possible = holm([comparison.min_p_value for comparison in comparisons if comparison.has_runs])
    significant = int(np.count_nonzero(possible < SIGNIFICANCE))
    return significant > (0 if scope == "somewhere" else len(comparisons) // 2)


def judge(
    text: str,
    source: str,
    comparisons: Sequence[Comparison],
    *,
    scope: Scope,
    quantity: Quantity,
    so: str,
    otherwise: str,
    sides: tuple[str, str],
) -> Judged:
    """Return a claim with its verdict and the table of its comparisons.

    Parameters
    ----------
    text, source : str
        The claim and where the paper makes it; see `Claim`.
    comparisons : sequence of Comparison
        The comparisons that the claim makes, including those without runs.
    scope : {"always", "mostly", "somewhere"}
        Scope of the claim; see `verdict`.
    quantity : Quantity
        The quantity that is compared.
    so, otherwise : str
        Clauses for a comparison with the claimed outcome, and with the opposite one.
    sides : (str, str)
        Headings of the sets of runs: of the one claimed to be lower, and of the other.

    Returns
    -------
    Judged
        The claim, "not tested" if there are too few runs.
    """
    findings = weigh(comparisons)
    grounds = [_count(findings, so, otherwise)] if findings else []
    decision: Verdict = "not tested"
    if not comparisons:
        grounds.append("the experiment has no runs that the claim refers to")
    elif could_be_significant(comparisons, scope):
        decision = verdict([finding.saying for finding in findings], scope)
    else:
        grounds.append("too few runs: too few differences can be significant")
    missing = len(comparisons) - len(findings)
    if missing:
        grounds.append(f"{missing} of {len(comparisons)} comparisons have no runs yet")
    if findings:
        grounds.append(_method(findings))
    shown = (
        findings if len(findings) <= MAX_SHOWN else [f for f in findings if f.saying == "against"]
    )
    grounds += [_line(finding, quantity, sides) for finding in shown]
    return Judged(
        claim=Claim(text=text, source=source, verdict=decision, grounds=tuple(grounds)),
        table=_table(text, findings, quantity, sides),
    )


MAX_SHOWN = 4
"""Upper bound of the comparisons that are all in the grounds; of more, the contradicting ones."""


# Words --------------------------------------------------------------------------------------


def number(value: float, digits: int) -> str:
    """Return a value as text, and a word for an infinite one."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "incomplete"


def p_text(p_value: float) -> str:
    """Return a p-value as text."""
    return "< 0.001" if p_value < 0.001 else f"{p_value:.3f}"


def failed_runs(bad: Sequence[Result], limit: int) -> list[str]:
    """Return a line for each of the first runs that failed, and one that counts the others.

    Parameters
    ----------
    bad : sequence of Result
        Runs that were not complete, or had a collision.
    limit : int
        Upper bound of the runs with a line of their own.
    """
    lines = [
        f"{result.condition}, repetition {result.repetition}: "
        + (
            "a collision"
            if result.status == "complete"
            else f"{result.status.replace('_', ' ')}: {result.reason}"
        )
        for result in bad[:limit]
    ]
    return [*lines, f"and {len(bad) - limit} more"] if len(bad) > limit else lines


def _count(findings: Sequence[Finding], so: str, otherwise: str) -> str:
    sayings = [finding.saying for finding in findings]
    return (
        f"{so} in {sum(finding.is_lower for finding in findings)} of {len(findings)} comparisons, "
        f"significantly in {sayings.count('for')}; {otherwise} significantly in "
        f"{sayings.count('against')}"
    )


def _method(findings: Sequence[Finding]) -> str:
    names = {False: "Mann-Whitney's test", True: "Wilcoxon's signed-rank test on pairs"}
    kinds = sorted({finding.comparison.paired for finding in findings})
    sizes = [
        len(side)
        for finding in findings
        for side in (finding.comparison.lower, finding.comparison.higher)
    ]
    runs = f"{min(sizes)}" if min(sizes) == max(sizes) else f"{min(sizes)} to {max(sizes)}"
    effect = float(median(np.array([finding.effect for finding in findings])))
    return (
        f"{' and '.join(names[kind] for kind in kinds)}, two-sided, p after Holm over "
        f"{len(findings)} comparisons; n = {runs} each; median effect size A {effect:.2f} (0.5: "
        "none, 1: always as claimed)"
    )


def _line(finding: Finding, quantity: Quantity, sides: tuple[str, str]) -> str:
    below, above = (
        number(float(median(np.array(side))), quantity.digits)
        for side in (finding.comparison.lower, finding.comparison.higher)
    )
    unit = f" {quantity.unit}" if quantity.unit else ""
    return (
        f"{finding.comparison.where}: median {below}{unit} ({sides[0]}) and {above}{unit} "
        f"({sides[1]}), n = {_sizes(finding.comparison)}, p {_equals(finding.p_value)}, "
        f"A = {finding.effect:.2f}"
    )


def _equals(p_value: float) -> str:
    text = p_text(p_value)
    return text if text.startswith("<") else f"= {text}"


def _sizes(comparison: Comparison) -> str:
    n, m = len(comparison.lower), len(comparison.higher)
    if comparison.paired:
        return f"{n} pairs"
    return str(n) if n == m else f"{n} and {m}"


def _table(
    text: str, findings: Sequence[Finding], quantity: Quantity, sides: tuple[str, str]
) -> PrintedTable:
    return PrintedTable(
        title=f"{text} {quantity.heading}, medians",
        source="",
        columns=("where", *sides, "n", "p (Holm)", "A", "evidence"),
        rows=tuple(
            (
                finding.comparison.where,
                number(float(median(np.array(finding.comparison.lower))), quantity.digits),
                number(float(median(np.array(finding.comparison.higher))), quantity.digits),
                _sizes(finding.comparison),
                p_text(finding.p_value),
                f"{finding.effect:.2f}",
                "" if finding.saying == "nothing" else finding.saying,
            )
            for finding in findings
        ),
    )
