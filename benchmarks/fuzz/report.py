"""The results of a campaign: a row for each reader, its failures, and a page for all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from benchmarks.fuzz.judging import MAX_MEMORY, MAX_SECONDS, Outcome, Verdict
from benchmarks.fuzz.target import Target
from multisrt.geometry.errors import counted

MAX_KEPT: Final = 3
"""Upper bound of the inputs that are written of each group of equal failures."""

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

    @property
    def inputs(self) -> int:
        """Number of inputs."""
        return self.counts.total()

    @property
    def failed(self) -> int:
        """Number of inputs that failed."""
        return sum(map(len, self.faults.values()))

    def row(self) -> str:
        """Return a line of the table."""
        slow, number = self.slowest
        return (
            f"{self.target.name:20} {self.inputs:8,} {self.counts[Verdict.READ]:8,} "
            f"{self.counts[Verdict.REFUSED]:8,} {self.failed:7,} {self.seconds:7.0f} "
            f"{self.inputs / max(self.seconds, 1e-9):7.0f} {slow:8.2f} {number:8} "
            f"{self.memory / 2**20:6.0f}"
        )

    def failures(self) -> Iterator[str]:
        """Yield a line for each group of failures, the largest first."""
        for kind, numbers in sorted(self.faults.items(), key=lambda one: -len(one[1])):
            some = ", ".join(map(str, numbers[:MAX_KEPT]))
            yield f"    {len(numbers):,} x {kind[:600]} (number {some})"


def total(reports: Sequence[Report]) -> str:
    """Return the number of inputs and of failures of all readers, in one line."""
    inputs, failed = (
        sum(each) for each in zip(*((r.inputs, r.failed) for r in reports), strict=True)
    )
    made = f"{counted(inputs, 'input')} of {counted(len(reports), 'format')}"
    return f"{made}, {failed:,} failed"


def page(reports: Sequence[Report], command: str) -> str:
    """Return the results of a campaign as a page of the documentation.

    Parameters
    ----------
    reports : sequence of Report
        The results of each reader.
    command : str
        The command that made them, without the page.
    """
    table = [
        "| format | inputs | read | refused | failed | slowest (s) | largest (MB) |",
        "|---|--:|--:|--:|--:|--:|--:|",
        *(
            f"| `{report.target.name}` | {report.inputs:,} | {report.counts[Verdict.READ]:,} "
            f"| {report.counts[Verdict.REFUSED]:,} | {report.failed:,} "
            f"| {report.slowest[0]:.2f} | {report.memory / 2**20:.0f} |"
            for report in reports
        ),
    ]
    again = f"{command} --page docs/results/fuzz.md"
    words = [
        f"{total(reports)}. {ABOUT}",
        VERDICTS,
        "\n".join(table),
        "Slowest is the processor time of an input, and largest the memory that one added to its "
        f"process. Made by\n\n```text\n{again}\n```",
    ]
    return "\n\n".join(["# Broken input", *words]) + "\n"


ABOUT: Final = (
    "Files that strangers may have made are damaged and given to what reads them: maps of every "
    "format, recordings, specs of runs and of experiments, results of experiments and of "
    "campaigns, folders of failures, and strategies, as scripts of what explorers yield. An input "
    "is made of a seed in `tests/fuzz/seeds` by one or several mutations: of bytes, of tokens, and "
    "of the structure of the format, as of the tree of a JSON file or of the tables of an SQLite "
    "file."
)
VERDICTS: Final = (
    "An input is *read*, or *refused* by an error of this package in one line that names the file; "
    "of a strategy, by one that names robot, strategy and time. All else *failed*: another "
    f"exception, a warning, more than {MAX_SECONDS:g} s of processor time or "
    f"{MAX_MEMORY / 2**30:g} GiB, a world that cannot be explored, a robot that drives through a "
    "wall. A strategy that computes for ever within one decision is not among the inputs: the "
    "simulation cannot stop it; `multisrt check` and the limits of experiments do."
)
"""What the page says of the inputs, and of what counts as a failure."""


def _alike(one: str, other: str) -> bool:
    # The place comes last; without one, the first words are compared.
    places = [
        text.rpartition(" (")[2] if text.endswith(")") else text[:40] for text in (one, other)
    ]
    return one.partition(":")[0] == other.partition(":")[0] and places[0] == places[1]
