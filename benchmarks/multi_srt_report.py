"""What the runs of `benchmarks.multi_srt` say: tables, and which of the paper's claims hold.

All is computed from the rows alone, so that it can be written again without a run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import msgspec
import numpy as np
from scipy import stats

from benchmarks import rows as results
from benchmarks.reporting import known_values, markdown, spread

Starts = Literal["scattered", "clustered"]

SURE = 0.05
"""A difference whose p is below this is beyond chance."""

MOSTLY = 0.8
"""What is true of this share of all cases is true mostly."""


class Case(msgspec.Struct, frozen=True, kw_only=True, order=True):
    """One run of the grid."""

    world: str
    strategy: str
    starts: Starts
    radio_range_m: float | None
    robots: int
    seed: int

    @property
    def cell(self) -> Cell:
        """The cell of the grid that the run belongs to."""
        return Cell(self.world, self.strategy, self.starts, self.radio_range_m, self.robots)

    def command(self, max_time_s: float) -> str:
        """The command that repeats the run."""
        radio = "" if self.radio_range_m is None else f" --radio-range {self.radio_range_m:g}"
        return (
            f"multisrt explore {self.world} --strategy {self.strategy} --robots {self.robots} "
            f"--starts {self.starts}{radio} --seed {self.seed} --max-time {max_time_s:g}"
        )


class Measures(results.Measures, frozen=True, kw_only=True):
    """What is kept of a run's metrics."""

    makespan_s: float
    waiting_time_s: float
    overlap_share: float
    nodes: int
    messages: int
    bytes_sent: int
    coordinations: int
    deadlocks: int
    protective_stops: int
    smallest_clearance_m: float


Row = results.Row[Case, Measures]


@dataclass(frozen=True, slots=True)
class Cell:
    """What runs that differ in their seeds only have in common."""

    world: str
    strategy: str
    starts: str
    radio_range_m: float | None
    robots: int

    @property
    def radio(self) -> str:
        """The radio's range in words."""
        return "unlimited" if self.radio_range_m is None else f"{self.radio_range_m:g} m"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A claim of the paper, what the numbers say, and on what grounds."""

    claim: str
    verdict: str
    grounds: tuple[str, ...]


# Tables -------------------------------------------------------------------------------------

COLUMNS = (
    *("strategy", "starts", "radio", "robots", "complete", "exploration time s", "makespan s"),
    *("distance m", "waiting s", "overlap %", "coverage min / mean %"),
    *("collisions", "deadlocks", "protective stops"),
)


def table(rows: Iterable[Row], world: str) -> str:
    """Write the table of one world in Markdown, one line for each cell.

    Means and standard deviations are over the runs that were measured; those of the exploration
    time over the runs in which a robot came to know that the map is complete.
    """
    cells = by_cell(row for row in rows if row.case.world == world)
    lines = [_table_line(cell, cells[cell]) for cell in sorted(cells, key=_table_order)]
    return markdown(COLUMNS, lines)


def by_cell(rows: Iterable[Row]) -> dict[Cell, list[Row]]:
    """Sort runs into the cells of the grid."""
    cells: defaultdict[Cell, list[Row]] = defaultdict(list)
    for row in rows:
        cells[row.case.cell].append(row)
    return dict(cells)


def _table_order(cell: Cell) -> tuple[object, ...]:
    # A robot alone comes first; scattered before clustered, unlimited before limited.
    alone = cell.robots == 1
    return (
        cell.strategy,
        not alone,
        cell.starts == "clustered",
        cell.radio_range_m is not None,
        cell.robots,
    )


def _table_line(cell: Cell, rows: list[Row]) -> list[str]:
    measured = [row.measures for row in rows if row.measures is not None]
    complete = sum(row.status == "complete" for row in rows)
    coverage = [100.0 * m.coverage for m in measured]
    return [
        cell.strategy,
        "-" if cell.robots == 1 else cell.starts,
        "-" if cell.robots == 1 else cell.radio,
        str(cell.robots),
        f"{complete}/{len(rows)}",
        spread([m.exploration_time_s for m in measured]),
        spread([m.makespan_s for m in measured]),
        spread([m.total_distance_m for m in measured]),
        spread([m.waiting_time_s for m in measured]),
        spread([100.0 * m.overlap_share for m in measured], digits=1),
        f"{min(coverage):.2f} / {np.mean(coverage):.2f}" if coverage else "-",
        str(sum(m.collisions for m in measured)),
        str(sum(m.deadlocks for m in measured)),
        str(sum(m.protective_stops for m in measured)),
    ]


# Claims -------------------------------------------------------------------------------------

Measure = Callable[[Measures], float | None]


def findings(rows: Sequence[Row]) -> list[Finding]:
    """Decide the paper's claims by the numbers."""
    return [
        time_falls(rows, "scattered"),
        time_does_not_always_fall(rows),
        distance_grows(rows),
        radial_before_star(rows),
    ]


def time_falls(rows: Sequence[Row], starts: str) -> Finding:
    """Claim: the exploration time falls as the team grows (scattered starts)."""
    steps = steps_of(rows, starts, _time)
    down = [step for step in steps if step.change < 0.0]
    return Finding(
        claim=f"With {starts} starts the exploration time falls as the team grows.",
        verdict=_verdict(down, steps, "steps from one team size to the next"),
        grounds=_grounds(steps, "s", [step.line("s") for step in steps if step not in down]),
    )


def time_does_not_always_fall(rows: Sequence[Row]) -> Finding:
    """Claim: with clustered starts there are team sizes at which the time does not fall."""
    steps = steps_of(rows, "clustered", _time)
    up = [step for step in steps if step.change >= 0.0]
    sure = [step for step in up if step.p < SURE]
    if not steps:
        verdict = "no data"
    elif sure:
        verdict = (
            f"holds: the time rises at {len(up)} of {len(steps)} steps, at {len(sure)} of them "
            "beyond chance"
        )
    elif up:
        verdict = f"holds weakly: the time rises at {len(up)} of {len(steps)} steps, within chance"
    else:
        verdict = f"does not hold: the time falls at all of {len(steps)} steps"
    return Finding(
        claim="With clustered starts it does not always fall.",
        verdict=verdict,
        grounds=_grounds(steps, "s", [step.line("s") for step in up]),
    )


def distance_grows(rows: Sequence[Row]) -> Finding:
    """Claim: the total distance grows with the team."""
    steps = [
        step
        for starts in ("scattered", "clustered")
        for step in steps_of(rows, starts, lambda m: m.total_distance_m)
    ]
    up = [step for step in steps if step.change > 0.0]
    return Finding(
        claim="The total distance grows with the size of the team.",
        verdict=_verdict(up, steps, "steps from one team size to the next"),
        grounds=_grounds(steps, "m", [step.line("m") for step in steps if step not in up]),
    )


def radial_before_star(rows: Sequence[Row]) -> Finding:
    """Claim: radial does better than star, in time and in distance."""
    cells = by_cell(rows)
    pairs = [
        (cell, Cell(cell.world, "srt-radial", cell.starts, cell.radio_range_m, cell.robots))
        for cell in sorted(cells, key=lambda cell: (cell.world, *_table_order(cell)))
        if cell.strategy == "srt-star"
    ]
    better: list[Step] = []
    compared: list[Step] = []
    grounds = []
    for name, unit, measure in (
        ("exploration time", "s", _time),
        ("total distance", "m", lambda m: m.total_distance_m),
    ):
        steps = [
            Step.between(star, known_values(cells[star], measure), radial, other)
            for star, radial in pairs
            if (other := known_values(cells.get(radial, []), measure))
            and known_values(cells[star], measure)
        ]
        less = [step for step in steps if step.change < 0.0]
        better, compared = better + less, compared + steps
        if steps:
            sure = sum(step.p < SURE for step in less)
            shares = [step.change / step.before for step in steps]
            grounds.append(
                f"{name}: radial needs less in {len(less)} of {len(steps)} cells, in {sure} of "
                f"them beyond chance; {-100 * np.median(shares):.0f} % less in the median"
            )
            grounds += [
                f"not so in the {name}: {step.where} "
                f"({step.before:.0f} {unit} with star, {step.after:.0f} {unit} with radial, "
                f"p = {step.p:.2g})"
                for step in steps
                if step not in less
            ]
    return Finding(
        claim="Radial does better than star.",
        verdict=_verdict(better, compared, "comparisons"),
        grounds=tuple(grounds),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """Two means, and the p of Welch's test that they are one."""

    where: str
    sizes: tuple[int, int]
    before: float
    after: float
    p: float

    @classmethod
    def between(cls, a: Cell, first: list[float], b: Cell, second: list[float]) -> Step:
        """Compare the runs of two cells."""
        place = f"{b.world}, {b.starts}, {b.radio} radio, {b.robots} robots"
        if a.strategy == b.strategy:
            place = f"{b.world}, {b.strategy}, {b.starts}, {b.radio} radio"
        return cls(
            where=place,
            sizes=(a.robots, b.robots),
            before=float(np.mean(first)),
            after=float(np.mean(second)),
            p=welch(first, second),
        )

    @property
    def change(self) -> float:
        """By how much the mean grows."""
        return self.after - self.before

    def line(self, unit: str) -> str:
        """Say it in words."""
        return (
            f"{self.where}: {self.before:.0f} {unit} in a team of {self.sizes[0]}, "
            f"{self.after:.0f} {unit} in a team of {self.sizes[1]} (p = {self.p:.2g})"
        )


def steps_of(rows: Sequence[Row], starts: str, measure: Measure) -> list[Step]:
    """Compare every team size with the next, in all series of equal starts.

    A series begins with the robot alone, for which starts and radio make no difference.
    """
    cells = by_cell(rows)
    series: defaultdict[tuple[object, ...], list[Cell]] = defaultdict(list)
    for cell in sorted(cells, key=lambda cell: (cell.world, *_table_order(cell))):
        if cell.robots > 1 and cell.starts == starts:
            series[cell.world, cell.strategy, cell.radio_range_m].append(cell)
    steps = []
    for (world, strategy, _), teams in series.items():
        alone = [
            cell
            for cell in cells
            if (cell.world, cell.strategy, cell.robots) == (world, strategy, 1)
        ]
        known = [
            (cell, values)
            for cell in alone + teams
            if (values := known_values(cells[cell], measure))
        ]
        for (a, first), (b, second) in pairwise(known):
            steps.append(Step.between(a, first, b, second))
    return steps


def welch(first: Sequence[float], second: Sequence[float]) -> float:
    """The p of Welch's test that two means are one; 1 where there is too little to tell."""
    if min(len(first), len(second)) < 2:
        return 1.0
    if np.ptp(first) == np.ptp(second) == 0.0:
        return 0.0 if first[0] != second[0] else 1.0
    return float(stats.ttest_ind(first, second, equal_var=False).pvalue)


def _time(measures: Measures) -> float | None:
    return measures.exploration_time_s


def _verdict(so: Sequence[Step], steps: Sequence[Step], what: str) -> str:
    # Whether a claim holds that is true of `so` among the steps.
    if not steps:
        return "no data"
    contrary = [step for step in steps if step not in so]
    if not contrary:
        word = "holds"
    elif len(so) >= MOSTLY * len(steps):
        word = "holds mostly"
    else:
        word = "does not hold throughout" if so else "does not hold"
    against = (
        f"; {sum(step.p < SURE for step in contrary)} of the other {len(contrary)} go the other "
        "way beyond chance"
        if contrary
        else ""
    )
    return (
        f"{word}: at {len(so)} of {len(steps)} {what}, {sum(step.p < SURE for step in so)} of them "
        f"beyond chance{against}"
    )


def _grounds(steps: list[Step], unit: str, exceptions: list[str]) -> tuple[str, ...]:
    # The ends of every series, then where a step goes the other way.
    ends: dict[str, list[Step]] = defaultdict(list)
    for step in steps:
        ends[step.where].append(step)
    whole = [
        f"{where}: {part[0].before:.0f} {unit} with {part[0].sizes[0]}, "
        + ", ".join(f"{step.after:.0f} with {step.sizes[1]}" for step in part)
        for where, part in ends.items()
    ]
    return (*whole, *(f"the other way: {line}" for line in exceptions))
