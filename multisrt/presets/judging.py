"""Judgement of a claim by one test of all its comparisons.

A claim makes comparisons of two sets of runs, of which the first is claimed to have the lower
values: the cells of a family. The family is tested once, two-sided at 5 %, by signed ranks within
the cells in pairs of repetitions (`statistics.families.paired_family`), or by ranks where there
are not pairs (`unpaired_family`). Its cells are tested individually, too, with p-values adjusted by
Holm's procedure: they show where, they find exceptions to a claim without exception, and they are
what a claim of "somewhere" is about.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from multisrt.presets.cells import Family
from multisrt.presets.findings import FamilyFinding, Finding, Saying, weigh, weigh_family
from multisrt.presets.words import (
    Sides,
    cell_line,
    cells_table,
    count_line,
    family_line,
    method_line,
    power_line,
    range_line,
    would_show,
)
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.statistics.rank_tests import SIGNIFICANCE, holm
from multisrt.statistics.ratios import smallest_reduction

Scope = Literal["always", "mostly", "somewhere"]
"""Scope of a claim: without exception, in general, or in at least one case."""

MAX_SHOWN = 4
"""Upper bound of the comparisons that are all in the grounds; of more, the contradicting ones."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """A judged claim and the table of its comparisons."""

    claim: Claim
    table: PrintedTable


def verdict(family: Saying, cells: Sequence[Saying], scope: Scope) -> Verdict:
    """Return the verdict on a claim by the test of its family and those of its cells.

    - "always": does not hold if any cell contradicts it; otherwise as "mostly".
    - "mostly": holds if the family supports it; does not hold if the family contradicts it.
    - "somewhere": holds if any cell supports it; does not hold if all cells contradict it.

    Otherwise the verdict is "inconclusive".

    Examples
    --------
    >>> cells = ["for", "nothing", "against"]
    >>> verdict("for", cells, "mostly"), verdict("for", cells, "always")
    ('holds', 'does not hold')
    """
    if scope == "somewhere":
        if "for" in cells:
            return "holds"
        return "does not hold" if cells and set(cells) == {"against"} else "inconclusive"
    if scope == "always" and "against" in cells:
        return "does not hold"
    if family == "nothing":
        return "inconclusive"
    return "holds" if family == "for" else "does not hold"


def could_be_significant(family: Family, scope: Scope) -> bool:
    """Return whether the claim could hold with these numbers of runs.

    More than half of the cells must have runs, and the smallest possible p-value of the family
    must be significant; for "somewhere", that of one cell after Holm.
    """
    found = family.with_runs
    if scope == "somewhere":
        possible = holm([comparison.min_p_value for comparison in found])
        return bool(np.any(possible < SIGNIFICANCE))
    return 2 * len(found) > len(family.comparisons) and family.min_p_value < SIGNIFICANCE


def judge(
    text: str,
    source: str,
    family: Family,
    *,
    scope: Scope,
    so: str,
    otherwise: str,
    sides: Sides,
    beside: Family | None = None,
) -> Judged:
    """Return a claim with its verdict and the table of its comparisons.

    Parameters
    ----------
    text, source : str
        The claim and where the paper makes it; see `Claim`.
    family : Family
        The comparisons that the claim makes, including those without runs.
    scope : {"always", "mostly", "somewhere"}
        Scope of the claim; see `verdict`.
    so, otherwise : str
        Clauses for a comparison with the claimed outcome, and with the opposite one.
    sides : (str, str)
        Headings of the sets of runs: of the one claimed to be lower, and of the other.
    beside : Family, optional
        The same comparisons by another quantity, whose verdict is given in the grounds.

    Returns
    -------
    Judged
        The claim, "not tested" if there are too few runs.
    """
    comparisons, quantity = family.comparisons, family.quantity
    findings = weigh(comparisons)
    whole, parts = weigh_family(family), _weighed_parts(family)
    decided = _decide(family, whole, findings, scope)
    limit = _limit(family, whole, scope) if decided != "not tested" else None
    where = " in one cell" * (scope == "somewhere")
    grounds = []
    if whole is not None:
        # A claim on one cell among others says nothing of all of them.
        grounds += [] if scope == "somewhere" else [_family_lines(whole, parts, sides)]
        grounds += _cell_lines(findings, so, otherwise, sides)
    if limit is not None:
        grounds.append(power_line(limit, family.quantity) + where)
    if not comparisons:
        grounds.append("the experiment has no runs that the claim refers to")
    elif decided == "not tested":
        grounds.append("too few runs: no difference can be significant")
    missing = len(comparisons) - len(findings)
    if missing:
        grounds.append(f"{missing} of {len(comparisons)} comparisons have no runs yet")
    if findings:
        grounds.append(method_line(findings))
    others = _verdicts_of_parts(family, parts, decided)
    if beside is not None and (other := weigh_family(beside)) is not None:
        name = beside.quantity.heading
        findings_beside, parts_beside = weigh(beside.comparisons), _weighed_parts(beside)
        verdict_beside = _decide(beside, other, findings_beside, scope)
        others.append((name, verdict_beside))
        others += [
            (f"{name}, {part}", of)
            for part, of in _verdicts_of_parts(beside, parts_beside, verdict_beside)
        ]
        lines = (
            _family_lines(other, parts_beside, sides),
            *_cell_lines(findings_beside, so, otherwise, sides),
        )
        grounds.append("\n  - ".join((f"{name}: {verdict_beside}", *lines)))
    shown = (
        findings if len(findings) <= MAX_SHOWN else [f for f in findings if f.saying == "against"]
    )
    grounds += [cell_line(finding, quantity, sides) for finding in shown]
    return Judged(
        claim=Claim(
            text=text,
            source=source,
            verdict=decided,
            grounds=tuple(grounds),
            would_show="" if limit is None else would_show(limit) + where,
            other_verdicts=tuple(others),
        ),
        table=cells_table(text, None if scope == "somewhere" else whole, findings, quantity, sides),
    )


def _weighed_parts(family: Family) -> dict[str, FamilyFinding | None]:
    """Return the tests of the parts of a family, by name; None for one without runs."""
    return {name: weigh_family(part) for name, part in family.parts.items()}


def _family_lines(
    whole: FamilyFinding, parts: Mapping[str, FamilyFinding | None], sides: Sides
) -> str:
    """Return the sentence on a family, and below it those on its parts."""
    lines = [
        f"{name}: {family_line(found, sides)}" for name, found in parts.items() if found is not None
    ]
    return "\n  - ".join((family_line(whole, sides), *lines))


def _cell_lines(findings: Sequence[Finding], so: str, otherwise: str, sides: Sides) -> list[str]:
    """Return the sentences on how many cells support a claim, and how far they are apart."""
    if len(findings) < 2:
        return []
    spread = range_line(findings, sides)
    return [count_line(findings, so, otherwise), *([] if spread is None else [spread])]


def _verdicts_of_parts(
    family: Family, parts: Mapping[str, FamilyFinding | None], decided: Verdict
) -> list[tuple[str, Verdict]]:
    """Return the verdicts by the parts of a family that differ from that by all of it."""
    verdicts = [
        (name, _decide(family.parts[name], found, (), "mostly")) for name, found in parts.items()
    ]
    return [(name, by_part) for name, by_part in verdicts if by_part != decided]


def _decide(
    family: Family, whole: FamilyFinding | None, findings: Sequence[Finding], scope: Scope
) -> Verdict:
    if whole is None or not could_be_significant(family, scope):
        return "not tested"
    return verdict(whole.saying, [finding.saying for finding in findings], scope)


def _limit(family: Family, whole: FamilyFinding | None, scope: Scope) -> FamilyFinding | None:
    """Return the test whose smallest difference is that of the claim."""
    return _median_cell(family) if scope == "somewhere" else whole


def _median_cell(family: Family) -> FamilyFinding:
    """Return the test of the cell that shows the median one of their smallest differences.

    The level of its interval is that of Holm's first step, which one cell among others must pass.
    """
    cells = [replace(family, comparisons=[one]) for one in family.with_runs]
    level = 1.0 - SIGNIFICANCE / len(cells)
    alone = [one for cell in cells if (one := weigh_family(cell, level=level)) is not None]
    alone.sort(key=lambda one: smallest_reduction(one.ratio, level=level))
    return alone[len(alone) // 2]
