"""The words and tables in which comparisons are reported."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from multisrt.experiments.results import Result
from multisrt.presets.cells import Comparison, Quantity
from multisrt.presets.findings import FamilyFinding, Finding
from multisrt.reporting.claims import PrintedTable
from multisrt.statistics.intervals import Interval
from multisrt.statistics.ratios import POWER, smallest_reduction
from multisrt.statistics.summaries import median

Sides = tuple[str, str]
"""Names of two sets of runs: of the one claimed to be lower, and of the other."""


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
        Runs that did not succeed, or were not complete.
    limit : int
        Upper bound of the runs with a separate line.
    """
    lines = [
        f"{result.condition}, repetition {result.repetition}: "
        f"{result.status.replace('_', ' ')}: {result.account}"
        for result in bad[:limit]
    ]
    return [*lines, f"and {len(bad) - limit} more"] if len(bad) > limit else lines


# A family -----------------------------------------------------------------------------------


def family_line(found: FamilyFinding, sides: Sides) -> str:
    """Return the sentence on the one test of a family."""
    cells = {1: "the one cell", 2: "both cells together"}.get(
        found.cells, f"all {found.cells} cells together"
    )
    kind = "paired repetitions" if found.paired else "unpaired repetitions"
    return (
        f"{cells}, by {found.repetitions} {kind}: {sides[0]} {_change(found.ratio)} against "
        f"{sides[1]}, p {_equals(found.test.p_value)}"
    )


def would_show(found: FamilyFinding) -> str:
    """Return the difference that is detected with a power of `POWER`, as a clause."""
    share = smallest_reduction(found.ratio, power=POWER, level=found.level)
    if share >= 1.0:
        return "no difference would have been detected in these runs"
    return f"a difference of {100.0 * share:.1f} % would have been detected"


def power_line(found: FamilyFinding, quantity: Quantity) -> str:
    """Return the sentence on the smallest differences that a family can detect."""
    true, seen = (
        smallest_reduction(found.ratio, power=power, level=found.level) for power in (POWER, None)
    )
    if true >= 1.0:
        return "with this spread no difference, however large, would have been detected"
    unit = f" {quantity.unit}" if quantity.unit else ""
    of = ""
    if math.isfinite(found.reference):
        parts = (number(x * found.reference, quantity.digits) for x in (true, 1.0))
        of = f" ({' of '.join(parts)}{unit})"
    return (
        f"detectable difference: {100.0 * true:.1f} %{of} with a power of {100.0 * POWER:.0f} %; "
        f"the smallest observed difference that would be significant is {100.0 * seen:.1f} %"
    )


def _change(ratio: Interval) -> str:
    value, low, high = (
        f"{100.0 * (end - 1.0):+.1f}" if math.isfinite(end) else "no bound"
        for end in (ratio.value, ratio.low, ratio.high)
    )
    return f"{value} % (95 % interval {low} to {high} %)"


# Cells --------------------------------------------------------------------------------------


def count_line(findings: Sequence[Finding], so: str, otherwise: str) -> str:
    """Return the sentence that counts the cells for and against a claim, by their medians."""
    sayings = [finding.saying for finding in findings]
    medians = [_medians(finding) for finding in findings]
    equal = sum(lower == higher for lower, higher in medians)
    return (
        f"by medians {so} in {sum(lower < higher for lower, higher in medians)} of "
        f"{len(findings)} cells" + f" and nothing changes in {equal}" * bool(equal) + ", "
        f"significantly by itself in {sayings.count('for')}; {otherwise} significantly in "
        f"{sayings.count('against')}"
    )


def range_line(findings: Sequence[Finding], sides: Sides) -> str | None:
    """Return the sentence on the differences of medians in single cells; None for one cell.

    The ratio of a family is one for all of its cells. This tells how far these are apart.
    """
    shares = [
        100.0 * (lower / higher - 1.0)
        for lower, higher in map(_medians, findings)
        if math.isfinite(lower) and math.isfinite(higher) and higher > 0.0
    ]
    if len(shares) < 2:
        return None
    left_out = len(findings) - len(shares)
    return (
        f"by cell: {sides[0]} {min(shares):+.1f} to {max(shares):+.1f} % against {sides[1]} by "
        f"medians, {float(np.median(shares)):+.1f} % in the median cell"
        + f"; without {left_out} in which there is no ratio"
        * bool(left_out)
    )


def method_line(findings: Sequence[Finding]) -> str:
    """Return the sentence on the tests of the cells."""
    names = {False: "Mann-Whitney's test", True: "Wilcoxon's test on pairs"}
    kinds = sorted({finding.comparison.paired for finding in findings})
    sizes = [len(side) for finding in findings for side in finding.comparison.sides]
    runs = f"{min(sizes)}" if min(sizes) == max(sizes) else f"{min(sizes)} to {max(sizes)}"
    effect = float(median(np.array([finding.effect for finding in findings])))
    return (
        f"each cell by {' and '.join(names[kind] for kind in kinds)}, n = {runs} each"
        + f", p after Holm over {len(findings)} cells" * (len(findings) > 1)
        + f"; median effect size A {effect:.2f}"
    )


def _medians(finding: Finding) -> tuple[float, float]:
    lower, higher = (float(median(np.array(side))) for side in finding.comparison.sides)
    return lower, higher


def cell_line(finding: Finding, quantity: Quantity, sides: Sides) -> str:
    """Return the sentence on one cell."""
    below, above = (number(middle, quantity.digits) for middle in _medians(finding))
    unit = f" {quantity.unit}" if quantity.unit else ""
    return (
        f"{finding.comparison.where}: median {below}{unit} ({sides[0]}) and {above}{unit} "
        f"({sides[1]}), n = {_sizes(finding.comparison)}, p {_equals(finding.p_value)}, "
        f"A = {finding.effect:.2f}"
    )


def cells_table(
    text: str,
    family: FamilyFinding | None,
    findings: Sequence[Finding],
    quantity: Quantity,
    sides: Sides,
) -> PrintedTable:
    """Return the table of the cells of a claim, below the family's test."""
    rows = [
        (
            finding.comparison.where,
            *(number(middle, quantity.digits) for middle in _medians(finding)),
            _sizes(finding.comparison),
            p_text(finding.p_value),
            f"{finding.effect:.2f}",
            "" if finding.saying == "nothing" else finding.saying,
        )
        for finding in findings
    ]
    if family is not None:
        evidence = "" if family.saying == "nothing" else family.saying
        whole = (f"{family.repetitions} repetitions", p_text(family.test.p_value))
        what = f"all {family.cells} together" if family.cells > 1 else "in pairs"
        rows.insert(0, (what, "", "", *whole, "", evidence))
    return PrintedTable(
        title=f"{text} {quantity.heading}, medians",
        source="",
        columns=("where", *sides, "n", "p", "A", "evidence"),
        rows=tuple(rows),
        note="The first row is the one test of all cells; below it each cell by itself, p after "
        "Holm."
        if family is not None
        else "Each cell by itself, p after Holm.",
    )


def _equals(p_value: float) -> str:
    text = p_text(p_value)
    return text if text.startswith("<") else f"= {text}"


def _sizes(comparison: Comparison) -> str:
    n, m = map(len, comparison.sides)
    if comparison.paired:
        return f"{n} pairs"
    return str(n) if n == m else f"{n} and {m}"
