"""How a claim is judged: its comparisons are tested together, and what most of them say counts.

Every comparison of a claim is between two sets of runs, of which the claim says that the first
has the lower values. All are tested by two-sided rank tests, whose p-values are adjusted by Holm's
procedure over the comparisons of the claim. A comparison then speaks for the claim or against it
where p is below 5 %, and else says nothing.
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
"""How far a claim goes: without exception, in general, or in at least one case."""


class Quantity(Protocol):
    """What is compared, for people: every `Measure` is one."""

    @property
    def heading(self) -> str:
        """Its title with its unit."""

    @property
    def unit(self) -> str:
        """Its unit, or nothing."""

    @property
    def digits(self) -> int:
        """How many digits after the point are shown."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Two sets of runs, of which a claim says that the first has the lower values.

    Attributes
    ----------
    where : str
        Which runs they are.
    lower, higher : tuple of float
        Their values; a run that failed has an infinite one. Empty where there are no runs.
    paired : bool
        Whether the values at one place belong together: they are of one repetition, made in the
        same world and from the same starts.
    """

    where: str
    lower: tuple[float, ...]
    higher: tuple[float, ...]
    paired: bool = False

    @property
    def has_runs(self) -> bool:
        """Whether there is anything to compare."""
        return bool(self.lower) and bool(self.higher)

    @property
    def least_p_value(self) -> float:
        """The smallest p-value that so many runs can lead to; 1 without any."""
        n, m = len(self.lower), len(self.higher)
        if not self.has_runs:
            return 1.0
        return min(1.0, 2.0 / (2.0**n if self.paired else float(math.comb(n + m, n))))


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What the test of a comparison says.

    Attributes
    ----------
    comparison : Comparison
        What was tested.
    p_value : float
        Adjusted over the comparisons of the claim.
    is_lower : bool
        Whether the first set is the lower one, as claimed, be it by chance.
    effect : float
        Vargha and Delaney's A: how probable it is that a run of the first set is lower than one
        of the second.
    """

    comparison: Comparison
    p_value: float
    is_lower: bool
    effect: float

    @property
    def saying(self) -> Saying:
        """Whether it speaks for the claim or against it."""
        if self.p_value >= SIGNIFICANCE:
            return "nothing"
        return "for" if self.is_lower else "against"


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """A claim, judged, and the table of the comparisons behind it."""

    claim: Claim
    table: PrintedTable


# Runs ---------------------------------------------------------------------------------------


class Cells:
    """The runs of an experiment by their condition; those that are missing too, as none.

    Parameters
    ----------
    results : Results
        What there is of the experiment.
    """

    def __init__(self, results: Results) -> None:
        self._runs: dict[Condition, dict[int, Result]] = {
            condition: {} for condition in conditions(results.experiment)
        }
        for result in results:
            self._runs.setdefault(result.condition, {})[result.repetition] = result

    def conditions(self) -> list[Condition]:
        """Return all that the experiment asks for, in its order."""
        return list(self._runs)

    def of(self, condition: Condition) -> list[Result]:
        """Return the runs that there are of a condition."""
        return list(self._runs.get(condition, {}).values())

    def values(self, condition: Condition, measure: Measure) -> tuple[float, ...]:
        """Return a measure of all of them; infinite for those that are not complete."""
        return tuple(measure.values(self.of(condition)))

    def unpaired(
        self, where: str, *, lower: Condition, higher: Condition, measure: Measure
    ) -> Comparison:
        """Compare the runs of two conditions."""
        return Comparison(
            where=where, lower=self.values(lower, measure), higher=self.values(higher, measure)
        )

    def paired(
        self, where: str, *, lower: Condition, higher: Condition, measure: Measure
    ) -> Comparison:
        """Compare the runs of two conditions, repetition by repetition."""
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
    """Test the comparisons of one claim together; those without runs are left out."""
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
    """Say whether a claim holds, by what its comparisons say.

    - "always": it holds where more than half of them speak for it and none against it; one that
      does is enough to refute it.
    - "mostly": it holds where more than half speak for it, whatever others say; it does not where
      fewer do and one speaks against it.
    - "somewhere": it holds where one speaks for it, and does not where all speak against it.

    In all other cases nothing is significant enough.
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


def can_tell(comparisons: Sequence[Comparison], scope: Scope) -> bool:
    """Whether there are runs enough for the claim to hold, if only they differ enough."""
    possible = holm([comparison.least_p_value for comparison in comparisons if comparison.has_runs])
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
    """Judge a claim by its comparisons.

    Parameters
    ----------
    text, source : str
        See `Claim`.
    comparisons : sequence of Comparison
        What the claim says of runs; those that lack their runs too.
    scope : {"always", "mostly", "somewhere"}
        See `verdict`.
    quantity : Quantity
        What was compared.
    so, otherwise : str
        What is the case where a comparison goes as claimed, and where it goes the other way.
    sides : (str, str)
        Headings of the two sets of runs: the lower one by the claim, and the higher one.
    """
    findings = weigh(comparisons)
    grounds = [_count(findings, so, otherwise)] if findings else []
    decision: Verdict = "not tested"
    if not comparisons:
        grounds.append("the experiment has no runs that it speaks of")
    elif can_tell(comparisons, scope):
        decision = verdict([finding.saying for finding in findings], scope)
    else:
        grounds.append("too few runs: no difference could come out as significant often enough")
    missing = len(comparisons) - len(findings)
    if missing:
        grounds.append(f"{missing} of {len(comparisons)} comparisons have no runs yet")
    if findings:
        grounds.append(_method(findings))
    told = findings if len(findings) <= FEW else [f for f in findings if f.saying == "against"]
    grounds += [_line(finding, quantity, sides) for finding in told]
    return Judged(
        claim=Claim(text=text, source=source, verdict=decision, grounds=tuple(grounds)),
        table=_table(text, findings, quantity, sides),
    )


FEW = 4
"""So many comparisons are told one by one; of more, those that speak against the claim."""


# Words --------------------------------------------------------------------------------------


def number(value: float, digits: int) -> str:
    """Write a value, or a word where half of the runs or more have none."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "incomplete"


def p_text(p_value: float) -> str:
    """Write a p-value."""
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
        f"{len(findings)} comparisons; n = {runs} each; effect size A {effect:.2f} in the median "
        "(0.5: none, 1: always as claimed)"
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
        columns=("where", *sides, "n", "p (Holm)", "A", "speaks"),
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
