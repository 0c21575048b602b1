"""What the reports on grids of runs have in common: tables, the account, the runs that failed."""

from __future__ import annotations

import platform
from collections.abc import Callable, Iterable, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from benchmarks.rows import CaseT, MeasuresT, Row

PACKAGES = ("multisrt", "numpy", "numba", "scipy", "shapely", "simpy", "python-fcl")


def markdown(columns: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """Write a table that can be read as it is, too."""
    widths = [max(map(len, column)) for column in zip(columns, *lines, strict=True)]

    def line(fields: Sequence[str]) -> str:
        padded = (text.rjust(width) for text, width in zip(fields, widths, strict=True))
        return f"| {' | '.join(padded)} |"

    rule = f"|{'|'.join('-' * (width + 1) + ':' for width in widths)}|"
    return "\n".join([line(columns), rule, *map(line, lines)])


def spread(values: Iterable[float | None], digits: int = 0) -> str:
    """Write mean and standard deviation of what is there."""
    known = [value for value in values if value is not None]
    if not known:
        return "-"
    mean = f"{np.mean(known):.{digits}f}"
    return f"{mean} ± {np.std(known, ddof=1):.{digits}f}" if len(known) > 1 else mean


def known_values(
    rows: Iterable[Row[CaseT, MeasuresT]], measure: Callable[[MeasuresT], float | None]
) -> list[float]:
    """Give a measure of the complete runs that have it."""
    values = (
        measure(row.measures)
        for row in rows
        if row.status == "complete" and row.measures is not None
    )
    return [value for value in values if value is not None]


def bullets(lines: Iterable[str]) -> str:
    """Write a list."""
    return "\n".join(f"- {line}" for line in lines)


def joined(sections: Iterable[str]) -> str:
    """Put the sections of a report together."""
    return "\n\n".join(section.rstrip() for section in sections if section) + "\n"


def account(rows: Sequence[Row[Any, Any]], asked: int, conditions: Sequence[str]) -> str:
    """Say how many runs there are and under which conditions and by what they were made."""
    versions = [f"Python {platform.python_version()} ({platform.machine()})"]
    versions += [f"{package} {version(package)}" for package in PACKAGES]
    programs = sorted({row.program for row in rows})
    seconds = sum(row.seconds for row in rows)
    lines = [
        f"Runs: {len(rows)} of {asked}; {sum(row.status == 'complete' for row in rows)} "
        f"complete, {sum(row.failed for row in rows)} failed.",
        f"Time of all runs together: {seconds / 3600:.2f} h on one core, "
        f"{seconds / max(1, len(rows)):.1f} s a run.",
        *conditions,
        f"Versions: {', '.join(versions)}.",
        f"Digest of the program's source: {', '.join(programs)}.",
    ]
    if len(programs) > 1:
        lines.append(
            f"**{len(programs)} states of the program made these results; remove the raw "
            "results and repeat all runs before they are relied upon.**"
        )
    return bullets(lines)


def failures(
    rows: Iterable[Row[CaseT, MeasuresT]], command_of: Callable[[CaseT], str]
) -> list[str]:
    """List the runs that are not complete or had a collision, with what repeats them."""
    lines = []
    for row in rows:
        if row.failed:
            touched = row.measures is not None and row.measures.collisions > 0
            what = "collision" if touched else row.status.replace("_", " ")
            lines.append(f"- {what}: {row.reason}\n  `{command_of(row.case)}`")
    return lines or ["None."]
