"""The command: a campaign over some or all readers, its table and its failures.

An input depends only on the format, the seed and its number, so that it can be made and read
again: ``python -m benchmarks.fuzz --format svg --number 1234``. Inputs that a reader fails on are
written to a folder; once the reader is fixed, the smallest input that shows the defect goes to
``tests/fuzz/kept``.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchmarks.arguments import add_count, at_least, parser_of
from benchmarks.fuzz.judging import judge
from benchmarks.fuzz.processes import Campaign, run
from benchmarks.fuzz.report import TITLE, Report, page, total
from benchmarks.fuzz.target import Target
from benchmarks.fuzz.targets import TARGETS

ABOUT: Final = f"""{__doc__}
A thousand inputs take about half a minute on one core. Exit code: 0, or 1 if a reader failed."""

EXAMPLES: Final = """
--inputs 14000
--format svg --format dxf --inputs 2000 --workers 2
--format svg --seed 0 --number 7
""".strip()

PROGRESS_S: Final = 60.0
"""Time between two lines of progress, in seconds."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a campaign, or read one input again; exit with 1 if a reader failed."""
    parser = parser_of("benchmarks.fuzz", ABOUT, EXAMPLES)
    inputs = "number of inputs over all formats, at least one for each"
    add_count(parser, "--inputs", "N", 10_000, 1, inputs)
    add_count(parser, "--seed", "S", 0, 0, "seed of the campaign")
    add_count(parser, "--workers", "N", 1, 1, "number of processes at a time")
    parser.add_argument(
        "--format",
        action="append",
        choices=list(TARGETS),
        metavar="NAME",
        help=f"a format, repeatable; default: all, which are {', '.join(TARGETS)}",
    )
    parser.add_argument(
        "--number",
        type=at_least(0),
        metavar="K",
        help="only make and read this input of one --format",
    )
    parser.add_argument(
        "--page", type=Path, metavar="FILE", help="also write the table to a page (.md)"
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/fuzz"),
        metavar="DIR",
        help="folder for failing inputs (default: out/fuzz)",
    )
    named = parser.parse_args(arguments)
    targets = [TARGETS[name] for name in dict.fromkeys(named.format or TARGETS)]
    if named.number is not None:
        if len(targets) != 1:
            parser.error("--number requires exactly one --format")
        sys.exit(again(targets[0], named.seed, named.number, named.out))
    if named.inputs < len(targets):
        parser.error(
            f"--inputs {named.inputs} is less than one for each of {len(targets)} formats: make "
            "more, or choose some by --format"
        )
    print(TITLE)
    reports = []
    for target, count in zip(targets, shares(named.inputs, len(targets)), strict=True):
        campaign = Campaign(
            target=target, seed=named.seed, numbers=range(count), workers=named.workers
        )
        report = report_of(campaign, named.out)
        print(report.row(), flush=True)
        for line in report.failures():
            print(line, flush=True)
        reports.append(report)
    print(total(reports))
    if named.page is not None:
        named.page.write_text(page(reports, command_of(named)), encoding="utf-8")
    sys.exit(1 if any(report.failed for report in reports) else 0)


def command_of(named: argparse.Namespace) -> str:
    """Return the command of a campaign, as far as its inputs depend on it."""
    formats = "".join(f" --format {name}" for name in named.format or ())
    return f"python -m benchmarks.fuzz --inputs {named.inputs} --seed {named.seed}{formats}"


def shares(inputs: int, parts: int) -> list[int]:
    """Return the number of inputs of each part, as equal as possible."""
    return [(inputs + part) // parts for part in range(parts)]


def report_of(campaign: Campaign, out: Path) -> Report:
    """Read inputs, write those that fail to a folder, and return the results.

    Parameters
    ----------
    campaign : Campaign
        The inputs, and how they are read.
    out : Path
        The folder; it is created at the first failure.
    """
    report = Report(campaign.target)
    begin = told = time.monotonic()
    for number, outcome in run(campaign):
        if report.add(number, outcome):
            write(campaign.target, campaign.seed, number, out)
        now = time.monotonic()
        report.seconds = now - begin
        if now - told > PROGRESS_S:
            told = now
            done = f"{report.counts.total():,} of {len(campaign.numbers):,}"
            print(f"    {done}", file=sys.stderr, flush=True)
    return report


def write(target: Target, seed: int, number: int, out: Path) -> Path:
    """Write an input to a folder, and return its path."""
    one = target.input(seed, number)
    path = out / f"{target.name}-{seed}-{number}{one.suffix}"
    out.mkdir(parents=True, exist_ok=True)
    path.write_bytes(one.content)
    return path


def again(target: Target, seed: int, number: int, out: Path) -> int:
    """Write an input, read it in this process, and return the exit code."""
    one = target.input(seed, number)
    print(f"{write(target, seed, number, out)}, options {one.options}")
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        target.prepare(Path(folder))
        outcome = judge(target, one, Path(folder))
    print(f"{outcome.verdict.value} in {outcome.seconds:.2f} s {outcome.detail}")
    return 0 if outcome.verdict.is_right else 1
