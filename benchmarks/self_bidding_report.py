"""What the runs of `benchmarks.self_bidding` say, beside Tables I to V of the paper.

Where a cell of ours and of the paper has a mark, they are compared: + where self-bidding does
significantly better than the other strategy, - where it does worse, blank where neither can be
said.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np
from scipy import stats

from benchmarks import rows as results
from benchmarks.reporting import bullets, known_values, markdown, spread

Mark = Literal["+", "-", ""]

SURE = 0.05
"""A difference whose p is below this is significant."""

OTHERS = ("closest", "utility")
STRATEGIES = (*OTHERS, "self-bidding")
RADIO_RANGES_M = (15.0, 20.0, 30.0)
TEAMS = (2, 3, 4, 5)

PAPERS_NAMES = {"closest": "Yamauchi", "utility": "Stachniss", "self-bidding": "SBX-R"}


class Case(msgspec.Struct, frozen=True, kw_only=True, order=True):
    """One run of the grid."""

    strategy: str
    radio_range_m: float
    robots: int
    seed: int


class Measures(results.Measures, frozen=True, kw_only=True):
    """What is kept of a run's metrics."""

    makespan_s: float
    waiting_time_s: float
    isolated_total_s: float
    isolated_longest_s: float
    beyond_range_m: float | None
    split_s: float
    known_to_one_m2s: float


Row = results.Row[Case, Measures]
Cell = tuple[str, float, int]
"""Strategy, range of the radio (m), robots."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperTable:
    """A table of the paper: medians by strategy and radio range, then teams of 2 to 5; and marks.

    Marks are written as in the paper, one for each team, `.` for blank.
    """

    number: str
    title: str
    unit: str
    measure: Callable[[Measures], float | None]
    medians: dict[tuple[str, float], tuple[float, float, float, float]]
    marks: dict[tuple[str, float], str]

    def median(self, cell: Cell) -> float:
        """What the paper prints."""
        strategy, radio, robots = cell
        return self.medians[strategy, radio][TEAMS.index(robots)]

    def mark(self, cell: Cell) -> Mark:
        """How the paper marks it."""
        strategy, radio, robots = cell
        found = self.marks[strategy, radio][TEAMS.index(robots)]
        return "+" if found == "+" else "-" if found == "-" else ""


PAPER = (
    PaperTable(
        number="I",
        title="Total time isolated",
        unit="s",
        measure=lambda m: m.isolated_total_s,
        medians={
            ("closest", 15.0): (201.10, 290.90, 166.00, 141.05),
            ("closest", 20.0): (106.55, 207.20, 75.10, 65.55),
            ("closest", 30.0): (47.70, 101.90, 47.00, 0.00),
            ("utility", 15.0): (391.40, 503.10, 207.00, 105.40),
            ("utility", 20.0): (351.40, 289.50, 111.60, 32.60),
            ("utility", 30.0): (66.50, 57.00, 24.65, 0.00),
            ("self-bidding", 15.0): (43.20, 77.70, 16.90, 14.70),
            ("self-bidding", 20.0): (17.90, 44.00, 0.00, 3.45),
            ("self-bidding", 30.0): (0.00, 11.20, 0.00, 0.00),
        },
        marks={
            ("closest", 15.0): "+++.",
            ("closest", 20.0): "+++.",
            ("closest", 30.0): ".++.",
            ("utility", 15.0): "+++.",
            ("utility", 20.0): "+++.",
            ("utility", 30.0): "+++.",
        },
    ),
    PaperTable(
        number="II",
        title="Longest isolation of a robot",
        unit="s",
        measure=lambda m: m.isolated_longest_s,
        medians={
            ("closest", 15.0): (162.60, 181.90, 135.00, 60.65),
            ("closest", 20.0): (72.80, 145.55, 66.00, 56.40),
            ("closest", 30.0): (39.10, 91.65, 47.00, 0.00),
            ("utility", 15.0): (191.80, 184.00, 137.80, 45.30),
            ("utility", 20.0): (212.70, 125.10, 77.65, 29.20),
            ("utility", 30.0): (52.30, 57.00, 24.65, 0.00),
            ("self-bidding", 15.0): (26.40, 50.30, 14.70, 0.35),
            ("self-bidding", 20.0): (16.15, 33.95, 0.00, 1.45),
            ("self-bidding", 30.0): (0.00, 10.10, 0.00, 0.00),
        },
        marks={
            ("closest", 15.0): "++++",
            ("closest", 20.0): "++++",
            ("closest", 30.0): "+++.",
            ("utility", 15.0): "++++",
            ("utility", 20.0): "++++",
            ("utility", 30.0): "+++.",
        },
    ),
    PaperTable(
        number="III",
        title="Largest distance beyond the range of the radio",
        unit="m",
        measure=lambda m: m.beyond_range_m,
        medians={
            ("closest", 15.0): (19.478, 26.997, 19.725, 7.410),
            ("closest", 20.0): (10.794, 21.946, 9.138, 7.828),
            ("closest", 30.0): (8.830, 12.310, 2.284, 0.000),
            ("utility", 15.0): (17.499, 2.881, 15.408, 5.117),
            ("utility", 20.0): (16.423, 13.122, 10.207, 4.421),
            ("utility", 30.0): (4.903, 8.800, 2.028, 0.000),
            ("self-bidding", 15.0): (4.455, 6.841, 1.776, 1.481),
            ("self-bidding", 20.0): (1.514, 2.846, 0.000, 0.154),
            ("self-bidding", 30.0): (0.000, 1.105, 0.000, 0.000),
        },
        marks={
            ("closest", 15.0): "++++",
            ("closest", 20.0): "++++",
            ("closest", 30.0): "+++.",
            ("utility", 15.0): "++++",
            ("utility", 20.0): "++++",
            ("utility", 30.0): "+++.",
        },
    ),
    PaperTable(
        number="IV",
        title="Exploration time",
        unit="s",
        measure=lambda m: m.exploration_time_s,
        medians={
            ("closest", 15.0): (668.0, 572.1, 544.1, 393.5),
            ("closest", 20.0): (648.3, 534.65, 466.15, 426.35),
            ("closest", 30.0): (604.6, 525.5, 504.5, 445.3),
            ("utility", 15.0): (820.9, 582.2, 467.45, 386.4),
            ("utility", 20.0): (773.05, 539.35, 447.15, 384.95),
            ("utility", 30.0): (769.9, 555.05, 450.0, 419.5),
            ("self-bidding", 15.0): (762.25, 535.3, 449.6, 426.55),
            ("self-bidding", 20.0): (655.75, 462.05, 391.8, 395.5),
            ("self-bidding", 30.0): (608.8, 435.9, 368.2, 363.4),
        },
        marks={
            ("closest", 15.0): "-.+.",
            ("closest", 20.0): ".++.",
            ("closest", 30.0): ".+++",
            ("utility", 15.0): "...-",
            ("utility", 20.0): "+++.",
            ("utility", 30.0): "++++",
        },
    ),
    PaperTable(
        number="V",
        title="Distance travelled by the team",
        unit="m",
        measure=lambda m: m.total_distance_m,
        medians={
            ("closest", 15.0): (445.03, 534.86, 642.52, 544.81),
            ("closest", 20.0): (438.22, 517.30, 566.63, 583.50),
            ("closest", 30.0): (385.48, 501.63, 584.82, 643.11),
            ("utility", 15.0): (440.81, 476.46, 486.54, 487.20),
            ("utility", 20.0): (430.83, 440.94, 458.38, 485.49),
            ("utility", 30.0): (419.30, 455.45, 479.60, 497.29),
            ("self-bidding", 15.0): (512.78, 512.22, 523.49, 592.76),
            ("self-bidding", 20.0): (459.24, 435.25, 464.05, 525.48),
            ("self-bidding", 30.0): (402.19, 391.33, 387.56, 466.43),
        },
        marks={
            ("closest", 15.0): "..+.",
            ("closest", 20.0): "-.++",
            ("closest", 30.0): ".+++",
            ("utility", 15.0): "----",
            ("utility", 20.0): "-...",
            ("utility", 30.0): ".++.",
        },
    ),
)

READING = (
    "The paper prints medians of 31 runs. Some of its minus signs are hard to read in print; where "
    "they are (Table IV, Stachniss at 30 m with 2, 4 and 5 robots), the sign is the one that "
    "agrees with the medians and with the counts in its text.",
    "Table III prints 2.881 m for Stachniss at 15 m with 3 robots and marks it as worse than the "
    "6.841 m of SBX-R: one of the two is a misprint.",
)


def by_cell(rows: Iterable[Row]) -> dict[Cell, list[Row]]:
    """Sort runs into the cells of the grid."""
    cells: defaultdict[Cell, list[Row]] = defaultdict(list)
    for row in rows:
        cells[row.case.strategy, row.case.radio_range_m, row.case.robots].append(row)
    return dict(cells)


# Marks --------------------------------------------------------------------------------------


def mark(ours: Sequence[float], others: Sequence[float]) -> Mark:
    """Compare by a two-sided rank test (Mann-Whitney): + where ours are significantly smaller."""
    if not ours or not others or np.ptp([*ours, *others]) == 0.0:
        return ""
    test = stats.mannwhitneyu(ours, others, alternative="two-sided")
    if test.pvalue >= SURE:
        return ""
    # The statistic counts the pairs in which ours is the larger one.
    return "+" if test.statistic < 0.5 * len(ours) * len(others) else "-"


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A cell of one of the tables: our mark and the paper's."""

    table: PaperTable
    cell: Cell
    ours: Mark
    papers: Mark

    @property
    def verdict(self) -> Literal["agree", "ours alone", "the paper's alone", "opposite"]:
        """How the two marks stand to one another."""
        if self.ours == self.papers:
            return "agree"
        if not self.papers:
            return "ours alone"
        return "opposite" if self.ours else "the paper's alone"


def comparisons(rows: Iterable[Row]) -> list[Comparison]:
    """Compare all marks for which there are runs."""
    cells = by_cell(rows)
    return [
        Comparison(
            table=table,
            cell=cell,
            ours=mark(
                known_values(cells["self-bidding", *cell[1:]], table.measure),
                known_values(cells[cell], table.measure),
            ),
            papers=table.mark(cell),
        )
        for table in PAPER
        for cell in _cells_of_others()
        if cell in cells and ("self-bidding", *cell[1:]) in cells
    ]


def _cells_of_others() -> Iterator[Cell]:
    for strategy in OTHERS:
        for radio in RADIO_RANGES_M:
            for robots in TEAMS:
                yield strategy, radio, robots


def agreement(rows: Sequence[Row]) -> str:
    """Say which marks agree: a count for each table, then all that do not."""
    found = comparisons(rows)
    verdicts = ("agree", "ours alone", "the paper's alone", "opposite")
    lines = []
    for table in PAPER:
        for strategy in OTHERS:
            here = [c for c in found if c.table is table and c.cell[0] == strategy]
            counts = [sum(c.verdict == verdict for c in here) for verdict in verdicts]
            lines.append([table.number, f"self-bidding against {strategy}", *map(str, counts)])
    columns = ("table", "compared", "same mark", "only we", "only the paper", "opposite")
    return "\n\n".join([markdown(columns, lines), _differing(found)])


def _differing(found: Sequence[Comparison]) -> str:
    if not found:
        return "No data."
    lines = [
        f"Table {c.table.number}, {c.cell[0]}, {c.cell[1]:g} m, {c.cell[2]} robots: "
        f"ours {_word(c.ours)}, the paper's {_word(c.papers)}"
        for c in sorted(found, key=lambda c: c.verdict != "opposite")
        if c.verdict != "agree"
    ]
    return "All marks agree." if not lines else "Marks that differ:\n\n" + bullets(lines)


def _word(mark: Mark) -> str:
    return mark or "blank"


def statement(rows: Sequence[Row]) -> str:
    """Say in words what agrees with the paper."""
    found = comparisons(rows)
    if not found:
        return "No data."
    same = sum(c.verdict == "agree" for c in found)
    opposite = sum(c.verdict == "opposite" for c in found)
    lines = [f"{same} of {len(found)} marks are the paper's; {opposite} are the opposite."]
    for claim, numbers in (
        ("Self-bidding keeps the team together (Tables I to III)", ("I", "II", "III")),
        ("It costs no time but in small teams with a short radio (Table IV)", ("IV",)),
        ("It costs distance against utility with a short radio (Table V)", ("V",)),
    ):
        here = [c for c in found if c.table.number in numbers]
        lines.append(f"{claim}: {_tally(here, 'ours')}; in the paper: {_tally(here, 'papers')}.")
    return bullets(lines)


def _tally(found: Sequence[Comparison], whose: Literal["ours", "papers"]) -> str:
    marks = [c.ours if whose == "ours" else c.papers for c in found]
    return (
        f"better in {marks.count('+')}, worse in {marks.count('-')}, neither in "
        f"{marks.count('')} of {len(marks)} comparisons"
    )


# Tables -------------------------------------------------------------------------------------


def table(rows: Iterable[Row], paper: PaperTable) -> str:
    """Write one table in the paper's shape; under each line of ours that of the paper."""
    cells = by_cell(rows)
    digits = 1 if paper.unit == "m" else 0
    lines = []
    for strategy in STRATEGIES:
        for radio in RADIO_RANGES_M:
            ours, theirs = [], []
            for robots in TEAMS:
                cell = (strategy, radio, robots)
                values = known_values(cells.get(cell, []), paper.measure)
                bids = known_values(cells.get(("self-bidding", radio, robots), []), paper.measure)
                own = strategy == "self-bidding"
                ours.append(_entry(values, "" if own else mark(bids, values), digits))
                theirs.append(f"{paper.median(cell):g} {'' if own else paper.mark(cell)}".strip())
            lines.append([strategy, f"{radio:g} m", *ours])
            lines.append([f"paper: {PAPERS_NAMES[strategy]}", f"{radio:g} m", *theirs])
    return markdown(("strategy", "radio", *(f"{n} robots" for n in TEAMS)), lines)


def _entry(values: Sequence[float], sign: Mark, digits: int) -> str:
    if not values:
        return "-"
    return f"{np.median(values):.{digits}f} ({spread(values, digits)}) {sign}".strip()


def alone(rows: Iterable[Row]) -> str:
    """Say what a robot alone needs, for which all strategies are one."""
    mine = [row for row in rows if row.case.robots == 1]
    if not mine:
        return ""
    time = spread(known_values(mine, lambda m: m.exploration_time_s))
    distance = spread(known_values(mine, lambda m: m.total_distance_m))
    return (
        f"A robot alone (closest) needs {time} s and {distance} m; the paper shows this in its "
        "figures only."
    )


def completeness(rows: Iterable[Row]) -> str:
    """Write how many runs came to a complete end, by strategy and team, and how they did."""
    cells: defaultdict[tuple[str, int], list[Row]] = defaultdict(list)
    for row in rows:
        cells[row.case.strategy, row.case.robots].append(row)
    lines = []
    for strategy, robots in sorted(cells):
        here = cells[strategy, robots]
        measured = [row.measures for row in here if row.measures is not None]
        lines.append(
            [
                strategy,
                str(robots),
                f"{sum(row.status == 'complete' for row in here)}/{len(here)}",
                spread([100.0 * m.coverage for m in measured], 2),
                spread([m.waiting_time_s for m in measured]),
                spread([m.split_s for m in measured]),
                spread([m.known_to_one_m2s for m in measured]),
                str(sum(m.collisions for m in measured)),
            ]
        )
    return markdown(
        (
            *("strategy", "robots", "complete", "coverage %", "waiting s", "team split s"),
            *("known to one m2 s", "collisions"),
        ),
        lines,
    )
