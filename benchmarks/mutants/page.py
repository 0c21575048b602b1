"""The table of planted defects, as text and as a page of the documentation."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

from benchmarks.mutants.catalogue import CONTROL, MUTANTS
from benchmarks.mutants.findings import Finding
from multisrt.geometry.errors import counted
from multisrt.presets.summary import markdown_table

PAGE: Final = Path(__file__).parents[2] / "docs/results/mutants.md"
"""The page."""

COLUMNS: Final = ("defect", "what it breaks", "found by", "missions", "time (s)")


def rows_of(names: Iterable[str], findings: Mapping[str, Finding]) -> list[tuple[str, ...]]:
    """Return the rows of the table.

    Parameters
    ----------
    names : iterable of str
        The defects.
    findings : mapping of str to Finding
        What was found of each; of those that are not among them the row says so.

    Returns
    -------
    list of tuple of str
        The fields of each row, by `COLUMNS`.
    """
    return [(name, *_told(name, findings.get(name))) for name in names]


def _told(name: str, found: Finding | None) -> tuple[str, ...]:
    breaks = "Nothing: this is the program as it is." if name == CONTROL else MUTANTS[name].breaks
    if found is None:
        return breaks, "not tried yet", "", ""
    if found.mission is not None:
        by = ", ".join(f"`{invariant}`" for invariant in found.invariants)
        return breaks, by, str(found.mission), f"{found.seconds:.0f}"
    return breaks, "nothing", f"{found.missions}, none failed", f"{found.seconds:.0f}"


def page(findings: Mapping[str, Finding], seed: int) -> str:
    """Return the page of the documentation.

    Parameters
    ----------
    findings : mapping of str to Finding
        What was found of each defect, and of the control.
    seed : int
        Seed of the campaigns.

    Returns
    -------
    str
        Markdown.
    """
    numbers = sorted(
        findings[name].mission or 0
        for name in MUTANTS
        if name in findings and findings[name].mission is not None
    )
    said = f"Campaigns found {len(numbers)} of {len(MUTANTS)} defects"
    if numbers:
        within = sum(number <= 100 for number in numbers)
        each_or_some = "each" if within == len(numbers) else f"{within} of them"
        said += (
            f", {each_or_some} within 100 missions (median {statistics.median(numbers):g}, maximum "
            f"{numbers[-1]})"
        )
    control = findings.get(CONTROL)
    if control is not None:
        failed = "none of them failed"
        if control.mission is not None:
            failed = f"the last failed ({', '.join(control.invariants)}: {control.says})"
        said += f". The unmodified program ran {counted(control.missions, 'mission')}; {failed}"
    own_seed = f" --seed {seed}" if seed else ""
    return "\n".join(
        [
            "# Planted defects",
            "",
            f"Made with `python -m benchmarks.mutants{own_seed}` and `python -m benchmarks.mutants "
            "--page`. A [campaign](../campaign.md) without failures is evidence only if it would "
            f"have found defects: each of {len(MUTANTS)} was planted in a copy of the program, one "
            f"at a time, by a change of a line or two, and a campaign (seed {seed}) run until its "
            "first failure, or for as many missions as its row says.",
            "",
            f"{said}.",
            "",
            "*missions*: how many were executed until the first failure; *found by*: all "
            "invariants that this mission violated. Times are those of runs and checks in one "
            f"process, on a machine that was busy with other things.{_programs(findings)}",
            "",
            markdown_table(COLUMNS, rows_of((*MUTANTS, CONTROL), findings)),
            "",
        ]
    )


def _programs(findings: Mapping[str, Finding]) -> str:
    programs = sorted({found.program for found in findings.values()})
    if not programs:
        return ""
    some = "is" if len(programs) == 1 else "are, of several versions,"
    return f" The digest of the program's source {some} {', '.join(programs)}."
