"""The command: a campaign over some or all readers, its table and its failures.

An input depends only on the format, the seed and its number, so that it can be made and read
again: ``python -m benchmarks.fuzz --format svg --number 1234``. Inputs that a reader fails on are
written to a folder; once the reader is fixed, the smallest input that shows the defect goes to
``tests/environments/fuzz/kept``.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from benchmarks.fuzz.judging import Outcome, Verdict, judge
from benchmarks.fuzz.processes import Campaign, run
from benchmarks.fuzz.targets import TARGETS, Target

MAX_KEPT: Final = 3
"""Upper bound of the inputs that are written of each group of equal failures."""

PROGRESS_S: Final = 60.0
"""Time between two lines of progress, in seconds."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a campaign, or read one input again; exit with 1 if a reader failed."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz", description=__doc__)
    parser.add_argument(
        "--inputs", type=int, default=10_000, help="number of inputs, over all formats"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the campaign")
    parser.add_argument("--workers", type=int, default=1, help="number of processes at a time")
    parser.add_argument(
        "--format",
        action="append",
        choices=list(TARGETS),
        help="a format, repeatable; by default all",
    )
    parser.add_argument("--number", type=int, help="only make and read this input of one --format")
    parser.add_argument(
        "--out", type=Path, default=Path("out/fuzz"), help="folder for failing inputs"
    )
    named = parser.parse_args(arguments)
    targets = [TARGETS[name] for name in named.format or TARGETS]
    if named.number is not None:
        if len(targets) != 1:
            parser.error("--number requires exactly one --format")
        sys.exit(again(targets[0], named.seed, named.number, named.out))
    print(TITLE)
    failed = False
    for target, count in zip(targets, shares(named.inputs, len(targets)), strict=True):
        campaign = Campaign(
            target=target, seed=named.seed, numbers=range(count), workers=named.workers
        )
        report = report_of(campaign, named.out)
        print(report.row(), flush=True)
        for line in report.failures():
            print(line, flush=True)
        failed |= bool(report.faults)
    sys.exit(1 if failed else 0)


def shares(inputs: int, parts: int) -> list[int]:
    """Return the number of inputs of each part, as equal as possible."""
    return [(inputs + part) // parts for part in range(parts)]


TITLE: Final = (
    f"{'format':20} {'inputs':>8} {'read':>8} {'refused':>8} {'failed':>7} {'s':>7} {'1/s':>7} "
    f"{'slowest':>8} {'number':>8} {'MB':>6}"
)


@dataclass(slots=True)
class Report:
    """Results of the inputs of a reader.

    Attributes
    ----------
    target : Target
        The reader.
    counts : Counter of Verdict
        Number of inputs for each verdict.
    faults : dict of str to list of int
        Numbers of the inputs that failed, by the kind of failure.
    seconds : float
        Elapsed time in seconds.
    slowest : (float, int)
        Processor time in seconds and number of the input that took longest.
    memory : int
        Largest memory that an input added to its process, in bytes.
    """

    target: Target
    counts: Counter[Verdict] = field(default_factory=Counter)
    faults: dict[str, list[int]] = field(default_factory=dict)
    seconds: float = 0.0
    slowest: tuple[float, int] = (0.0, 0)
    memory: int = 0

    def add(self, number: int, outcome: Outcome) -> bool:
        """Count an input; return whether it is one of the first with such a failure."""
        self.counts[outcome.verdict] += 1
        self.slowest = max(self.slowest, (outcome.seconds, number))
        self.memory = max(self.memory, outcome.memory)
        if outcome.verdict.is_right:
            return False
        kind = f"{outcome.verdict.value}: {outcome.detail}"
        # Failures in the same place are grouped: their messages may cite different values.
        known = next((one for one in self.faults if _alike(one, kind)), kind)
        self.faults.setdefault(known, []).append(number)
        return len(self.faults[known]) <= MAX_KEPT

    def row(self) -> str:
        """Return a line of the table."""
        total = self.counts.total()
        failed = sum(map(len, self.faults.values()))
        slow, number = self.slowest
        return (
            f"{self.target.name:20} {total:8,} {self.counts[Verdict.READ]:8,} "
            f"{self.counts[Verdict.REFUSED]:8,} {failed:7,} {self.seconds:7.0f} "
            f"{total / max(self.seconds, 1e-9):7.0f} {slow:8.2f} {number:8} "
            f"{self.memory / 2**20:6.0f}"
        )

    def failures(self) -> Iterator[str]:
        """Yield a line for each group of failures, the largest first."""
        for kind, numbers in sorted(self.faults.items(), key=lambda one: -len(one[1])):
            some = ", ".join(map(str, numbers[:MAX_KEPT]))
            yield f"    {len(numbers):,} x {kind[:600]} (number {some})"


def _alike(one: str, other: str) -> bool:
    # The place comes last; without one, the first words are compared.
    places = [
        text.rpartition(" (")[2] if text.endswith(")") else text[:40] for text in (one, other)
    ]
    return one.partition(":")[0] == other.partition(":")[0] and places[0] == places[1]


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
