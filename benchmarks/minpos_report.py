"""What the runs of `benchmarks.minpos` say, beside what the paper claims."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from scipy import stats

from benchmarks import rows as results
from benchmarks.reporting import bullets, known_values, markdown, spread

STRATEGIES = ("closest", "greedy", "minpos")
WORLDS = ("maze", "hospital")
TEAMS = (1, 2, 4, 6, 8, 10, 12)

PAPER_MEAN_GAIN = {"greedy": 8.0, "minpos": 12.0}
"""On average, in percent of the time with the closest frontier (section V A)."""

PAPER_LARGEST_GAIN = {"hospital": 15.0, "maze": 20.0}
"""Of the better strategies, at most (section V A)."""

SURE = 0.05
"""A difference whose p is below this is beyond chance."""

FEWEST_PAIRS = 6
"""With fewer, no signed-rank test can come out below `SURE`."""


class Case(msgspec.Struct, frozen=True, kw_only=True, order=True):
    """One run of the grid."""

    world: str
    strategy: str
    robots: int
    seed: int


class Measures(results.Measures, frozen=True, kw_only=True):
    """What is kept of a run's metrics."""

    makespan_s: float
    waiting_time_s: float
    overlap_share: float


Row = results.Row[Case, Measures]


@dataclass(frozen=True, slots=True, kw_only=True)
class Gain:
    """By how much a strategy is faster than the closest frontier.

    `percent` is that of the mean time, over `pairs` seeds; `p` that of the signed-rank test.
    """

    percent: float
    p: float
    pairs: int

    def __str__(self) -> str:
        told = "" if self.pairs < FEWEST_PAIRS else f" (p = {self.p:.2g})"
        return f"{self.percent:+.1f}{told}"


def gain(rows: Iterable[Row], world: str, strategy: str, robots: int) -> Gain | None:
    """Compare a strategy with the closest frontier, seed by seed; None without a pair."""
    times: defaultdict[int, dict[str, float]] = defaultdict(dict)
    for row in rows:
        if (row.case.world, row.case.robots) == (world, robots):
            for time_s in known_values([row], lambda m: m.exploration_time_s):
                times[row.case.seed][row.case.strategy] = time_s
    pairs = [(t["closest"], t[strategy]) for t in times.values() if {"closest", strategy} <= {*t}]
    if not pairs:
        return None
    before, after = np.array(pairs).T
    percent = 100.0 * (1.0 - after.mean() / before.mean())
    return Gain(percent=float(percent), p=signed_rank(before, after), pairs=len(pairs))


def signed_rank(first: Sequence[float], second: Sequence[float]) -> float:
    """The p of Wilcoxon's test on pairs; 1 where there are too few or all are equal."""
    changes = np.asarray(second) - np.asarray(first)
    if np.count_nonzero(changes) < FEWEST_PAIRS:
        return 1.0
    return float(stats.wilcoxon(changes[changes != 0.0]).pvalue)


def gains(rows: Sequence[Row]) -> str:
    """Write the gains of all cells, with the paper's means below."""
    lines = []
    for world in WORLDS:
        for robots in TEAMS[1:]:
            found = [gain(rows, world, strategy, robots) for strategy in STRATEGIES[1:]]
            if any(found):
                cells = ["-" if one is None else str(one) for one in found]
                pairs = "/".join("0" if one is None else str(one.pairs) for one in found)
                lines.append([world, str(robots), *cells, pairs])
    lines.append(["mean", "", *(_percent(mean_gain(rows, s)) for s in STRATEGIES[1:]), ""])
    lines.append(["paper's mean", "", *(f"{PAPER_MEAN_GAIN[s]:+.1f}" for s in STRATEGIES[1:]), ""])
    return markdown(("world", "robots", "greedy %", "minpos %", "pairs"), lines)


def mean_gain(rows: Sequence[Row], strategy: str) -> float | None:
    """Mean of a strategy's gains over all worlds and teams of more than one robot."""
    found = [gain(rows, world, strategy, robots) for world in WORLDS for robots in TEAMS[1:]]
    known = [one.percent for one in found if one is not None]
    return float(np.mean(known)) if known else None


def largest_gain(rows: Sequence[Row], world: str) -> tuple[float, str, int] | None:
    """The largest gain in a world: percent, strategy, robots."""
    found = [
        (one.percent, strategy, robots)
        for strategy in STRATEGIES[1:]
        for robots in TEAMS[1:]
        if (one := gain(rows, world, strategy, robots)) is not None
    ]
    return max(found, default=None)


def statement(rows: Sequence[Row]) -> str:
    """Say in words what agrees with the paper."""
    lines = []
    for strategy in STRATEGIES[1:]:
        lines.append(
            f"{strategy} gains {_percent(mean_gain(rows, strategy))} % on closest in the mean of "
            f"all worlds and teams; the paper: {PAPER_MEAN_GAIN[strategy]:g} %. "
            + _cells(rows, strategy)
        )
    for world in WORLDS:
        largest = largest_gain(rows, world)
        ours = (
            "no data"
            if largest is None
            else f"{largest[0]:+.1f} % ({largest[1]} with {largest[2]} robots)"
        )
        lines.append(
            f"The largest gain in the {world}: {ours}; the paper: {PAPER_LARGEST_GAIN[world]:g} %."
        )
    greedy, minpos = (mean_gain(rows, strategy) for strategy in STRATEGIES[1:])
    if greedy is not None and minpos is not None:
        word = "is" if minpos > greedy else "is not"
        lines.append(f"MinPos {word} ahead of greedy in the mean; in the paper it is, slightly.")
    return bullets(lines)


def _cells(rows: Sequence[Row], strategy: str) -> str:
    found = [
        one
        for world in WORLDS
        for robots in TEAMS[1:]
        if (one := gain(rows, world, strategy, robots)) is not None
    ]
    sure = [one for one in found if one.p < SURE]
    return (
        f"It is faster in {sum(one.percent > 0.0 for one in found)} of {len(found)} cells; beyond "
        f"chance it is faster in {sum(one.percent > 0.0 for one in sure)} and slower in "
        f"{sum(one.percent < 0.0 for one in sure)}."
    )


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:+.1f}"


def times(rows: Iterable[Row], world: str) -> str:
    """Write the table of a world, one line for each strategy and team."""
    cells: defaultdict[tuple[int, int], list[Row]] = defaultdict(list)
    for row in rows:
        if row.case.world == world:
            cells[STRATEGIES.index(row.case.strategy), row.case.robots].append(row)
    lines = []
    for number, robots in sorted(cells):
        here = cells[number, robots]
        measured = [row.measures for row in here if row.measures is not None]
        lines.append(
            [
                "-" if robots == 1 else STRATEGIES[number],
                str(robots),
                f"{sum(row.status == 'complete' for row in here)}/{len(here)}",
                spread(known_values(here, lambda m: m.exploration_time_s)),
                spread(known_values(here, lambda m: m.makespan_s)),
                spread(known_values(here, lambda m: m.total_distance_m)),
                spread(known_values(here, lambda m: m.waiting_time_s)),
                spread([100.0 * m.overlap_share for m in measured], 1),
                f"{min(100.0 * m.coverage for m in measured):.2f}" if measured else "-",
                str(sum(m.collisions for m in measured)),
            ]
        )
    columns = (
        *("strategy", "robots", "complete", "exploration time s", "makespan s", "distance m"),
        *("waiting s", "overlap %", "least coverage %", "collisions"),
    )
    return markdown(columns, lines)
