"""Timing of two sides in turns, so that a busy machine slows both alike.

Queries are taken in blocks of twenty, which the sides run in turn: neither should pay for the
caches that the other one has emptied. A side runs each query three times in a row, of which the
least counts, and a claim compares the medians over the queries. Times depend on the machine,
their ratios hardly.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

REPEATS = 3
BLOCK = 20

Side = Callable[[Any], object]


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """What is claimed, and what was measured.

    `ratio` is theirs over ours where faster is claimed (`at_least`), ours over theirs where a
    bound on the growth of a cost is (`at_most`).
    """

    text: str
    ours_us: float = 0.0
    theirs_us: float = 0.0
    at_least: float | None = None
    at_most: float | None = None
    note: str = ""
    holds: bool = True
    skipped: bool = False

    @property
    def ratio(self) -> float:
        return (
            self.ours_us / self.theirs_us
            if self.at_most is not None
            else self.theirs_us / self.ours_us
        )

    @property
    def met(self) -> bool:
        fast = self.ratio >= self.at_least if self.at_least is not None else True
        steady = self.ratio <= self.at_most if self.at_most is not None else True
        return self.holds and fast and steady


def in_turns(
    queries: Sequence[Any], sides: dict[str, Side], repeats: int = REPEATS
) -> dict[str, float]:
    """Give the median time of every side in microseconds; the first query only warms up."""
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
    """Whether a package that a comparison needs is here."""
    return importlib.util.find_spec(package) is not None


def skipped(text: str, package: str) -> Claim:
    """A claim that cannot be measured here."""
    return Claim(text=text, note=f"{package} is not installed: skipped", skipped=True)


def show(claims: Iterable[Claim]) -> bool:
    """Print one line per claim, as they come; tell whether all that were measured are met."""
    print(f"{'claim':60} {'ours us':>9} {'theirs us':>10} {'ratio':>8} {'target':>8}")
    all_met = True
    for claim in claims:
        if claim.skipped:
            print(f"{claim.text:60} {claim.note}", flush=True)
            continue
        target = f">= {claim.at_least:g}" if claim.at_least is not None else f"<= {claim.at_most:g}"
        verdict = "met" if claim.met else "NOT MET"
        print(
            f"{claim.text:60} {claim.ours_us:9.1f} {claim.theirs_us:10.1f} {claim.ratio:8.2f} "
            f"{target:>8}  {verdict}" + (f"  ({claim.note})" if claim.note else ""),
            flush=True,
        )
        all_met = all_met and claim.met
    return all_met
