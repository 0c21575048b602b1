"""Alternating timing of two sides, and the table of results.

Queries are taken in blocks of twenty, which the sides run in turn, so that a busy machine slows
both alike and neither pays for caches that the other one has emptied. A side runs each query
three times in a row, of which the fastest counts; a claim compares the medians over the queries.
Times depend on the machine, their ratios hardly.
"""

from __future__ import annotations

import importlib.util
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

REPEATS = 3
"""Runs of each query in a row, of which the fastest counts."""

BLOCK = 20
"""Queries after which it is the next side's turn."""

Side = Callable[[Any], object]


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A target, and what was measured for it.

    Attributes
    ----------
    text : str
        What is measured: what the other side is.
    ours, theirs : float
        The two sides, in `unit`.
    unit : str
        Their unit.
    at_least : float or None
        Lower bound of theirs over ours: how many times as fast we are meant to be.
    at_most : float or None
        Upper bound of ours over theirs: how much a cost may grow, or be of a limit. Exactly one
        of the two bounds is given.
    holds : bool
        Whether the results are right, where the comparison can show it.
    note : str
        What else is worth knowing.
    """

    text: str
    ours: float
    theirs: float
    unit: str = "us"
    at_least: float | None = None
    at_most: float | None = None
    holds: bool = True
    note: str = ""

    @property
    def ratio(self) -> float:
        """The figure that the target bounds; infinite where it would divide by zero."""
        above, below = (
            (self.ours, self.theirs) if self.at_least is None else (self.theirs, self.ours)
        )
        return above / below if below else math.inf

    @property
    def met(self) -> bool:
        """Whether the results are right and the target is reached."""
        fast = self.at_least is None or self.ratio >= self.at_least
        small = self.at_most is None or self.ratio <= self.at_most
        return self.holds and fast and small

    def line(self) -> str:
        """Return the line of the table."""
        target = f">= {self.at_least:g}" if self.at_least is not None else f"<= {self.at_most:g}"
        return (
            f"{self.text:60} {self.ours:9.1f} {self.theirs:10.1f} {self.unit:10} "
            f"{self.ratio:8.2f} {target:>8}  {'met' if self.met else 'NOT MET'}"
            + (f"  ({self.note})" if self.note else "")
        )


Benchmark = Callable[[], Iterable[Claim | str]]
"""Measures claims one after the other; a text is a line that is not a claim."""


def in_turns(
    queries: Sequence[Any], sides: dict[str, Side], repeats: int = REPEATS
) -> dict[str, float]:
    """Return the median time of every side in microseconds; the first query only warms up."""
    for run in sides.values():
        run(queries[0])
    best = {name: np.full(len(queries) - 1, np.inf) for name in sides}
    for first in range(1, len(queries), BLOCK):
        for name, run in sides.items():
            for q, query in enumerate(queries[first : first + BLOCK], first - 1):
                for _ in range(repeats):
                    begin = time.perf_counter()
                    run(query)
                    best[name][q] = min(best[name][q], time.perf_counter() - begin)
    return {name: float(np.median(times)) * 1e6 for name, times in best.items()}


def installed(package: str) -> bool:
    """Return whether a package that a comparison needs is installed."""
    return importlib.util.find_spec(package) is not None


def skipped(text: str, missing: str) -> str:
    """Return the line of a claim that cannot be measured here."""
    return f"{text:60} skipped: {missing} is missing"


def show(benchmarks: Mapping[str, Benchmark]) -> None:
    """Print a line for every claim as soon as it is measured, and a count of them at the end.

    A benchmark that raises has a line with its error, and the next one runs.

    Parameters
    ----------
    benchmarks : mapping from str to Benchmark
        What to measure, by the names that errors are reported under.
    """
    print(f"{'claim':60} {'ours':>9} {'theirs':>10} {'unit':10} {'ratio':>8} {'target':>8}")
    measured = met = errors = 0
    for name, benchmark in benchmarks.items():
        try:
            for found in benchmark():
                if isinstance(found, Claim):
                    measured += 1
                    met += found.met
                print(found.line() if isinstance(found, Claim) else found, flush=True)
        except Exception as error:
            errors += 1
            print(f"{name:60} ERROR: {type(error).__name__}: {error}", flush=True)
    print(f"\n{met} of {measured} targets are met", end="")
    print(f"; benchmarks that failed: {errors}" if errors else "")
