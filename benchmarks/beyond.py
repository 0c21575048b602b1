"""Strategies of this project against those of the papers, in worlds on which none was tuned.

``python -m benchmarks.beyond run beyond.sqlite --maps FOLDER`` makes the runs that the store lacks,
``python -m benchmarks.beyond unite runs.csv beyond.sqlite`` puts them into a table, and
``python -m benchmarks.beyond page runs.csv`` prints their page in Markdown. The worlds are fifteen
of the suites and, if their folder is given, five maps of other projects. A few repetitions of all
strategies show which of the papers' is the best; with ``--strategies`` only this one and that of
this project are repeated more often, and with ``--first-seed`` repetitions go on where those of
another machine ended, each time in a store of its own. ``--worlds``, ``--teams`` and ``--radios``
divide the runs among several stores.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

import multisrt as ms
from benchmarks.maps import read as read_map
from multisrt import load_results
from multisrt.experiments.spec import (
    EnvironmentChoice,
    ExperimentSpec,
    Only,
    RadioChoice,
    StartsChoice,
    StrategyChoice,
)
from multisrt.geometry.errors import counted
from multisrt.presets.summary import markdown_table
from multisrt.recording.files import atomic_write
from multisrt.robots.naming import joined
from multisrt.statistics.families import paired_family
from multisrt.statistics.intervals import Interval
from multisrt.statistics.rank_tests import RankTest, corrected, paired
from multisrt.statistics.ratios import ratio_of

OURS: Final = ("gain", "routes")
"""Strategies of this project."""

PAPERS: Final = ("closest", "greedy", "minpos", "utility", "self-bidding", "rules")
"""Strategies of the papers. Those of the SRT family need several times as long in every world."""

TURNING: Final = "utility-saves-turns"
"""The strategy of the papers that is fastest here, with the curves on which `gain` drives: what is
left of the lead of `gain` is due to its choices."""

CHOICES: Final = {
    TURNING: StrategyChoice(name="utility", label=TURNING, options={"saves_turns": True})
}
"""Strategies with options, by name."""

WORLDS: Final = {
    "indoor-30": (3, 8, 13, 18, 23),
    "mazes-30": (3, 8, 13, 18, 23),
    "outdoor-30": (13, 14, 15, 16, 17),
}
"""Numbers of worlds, by suite. Kinds of worlds take turns in the suites: four kinds indoors, two of
mazes, and five outdoors, so that there every fifth world would be a city."""

MAPS: Final = (
    "explore_bench/room.pgm",
    "ipa_coverage_planning/Freiburg52_scan.png",
    "ipa_coverage_planning/lab_intel.png",
    "movingai/den204d.map",
    "stage/hospital_section.png",
)
"""Files in the folder of maps."""

TEAMS: Final = (1, 2, 4, 8)
REPETITIONS: Final = 20
FULL, LIMITED = "full", "limited"
RADIOS: Final = (
    RadioChoice(label=FULL),
    RadioChoice(label=LIMITED, range_m=10.0, walls="block"),
)

TIME, END = "time_to_99_s", "makespan_s"
QUANTITIES: Final = {TIME: "time to 99 %", END: "makespan"}

NAMED: Final = {FULL: "unlimited", LIMITED: "limited"}
"""What radios are called in the page; tables of runs have their labels."""

PENALTY: Final = 2.0
"""A run that failed counts with the longest makespan of its cell times this (PAR-2)."""

FEWEST_SEEDS: Final = 6
"""Minimum number of pairs in a cell for intervals and tests: none of fewer is significant."""

LEVEL: Final = 0.05
"""Significance level, after Holm's correction over all cells."""

CELL: Final = ["environment", "robots", "radio"]

STARTED: Final = ["environment", "robots", "seed"]
"""What the informed plan depends on."""

COLUMNS_KEPT: Final = (
    *CELL,
    "strategy",
    "seed",
    "status",
    "reason",
    "digest",
    "key",
    "coverage",
    TIME,
    END,
    "total_distance_m",
    "collisions",
    "over_informed",
    "computing_s",
)
"""Columns of the table of runs."""


def experiment(
    maps: Path | None,
    *,
    repetitions: int,
    reference: bool,
    strategies: Sequence[str] = (*OURS, *PAPERS),
    first_seed: int = 0,
    only: Sequence[str] = (),
    teams: Sequence[int] = TEAMS,
    radios: Sequence[str] = (FULL, LIMITED),
) -> ExperimentSpec:
    """Return the experiment.

    Parameters
    ----------
    maps : Path or None
        Folder with `MAPS`; None leaves them out.
    repetitions : int
        Repetitions of every cell.
    reference : bool
        Whether times are compared with those of the informed plan.
    strategies : sequence of str
        Names of strategies, or of `CHOICES`.
    first_seed : int
        Seed of the first repetition; the others follow it.
    only : sequence of str
        Names of worlds, to which the experiment is restricted.
    teams : sequence of int
        Numbers of robots.
    radios : sequence of str
        Which of "full" and "limited"; a single robot has full radio only.

    Raises
    ------
    SystemExit
        If there is no world or radio of one of these names.
    """
    worlds = [
        EnvironmentChoice(name=f"{suite}/{number:02d}")
        for suite, numbers in WORLDS.items()
        for number in numbers
    ]
    if maps is not None:
        worlds += [read_map(maps / name, name).choice for name in MAPS]
    if only:
        named = {world.label or world.name: world for world in worlds}
        unknown = set(only) - named.keys()
        if unknown:
            raise SystemExit(f"no world is named {', '.join(sorted(unknown))}")
        worlds = [world for name, world in named.items() if name in only]
    if unknown := set(radios) - {FULL, LIMITED}:
        raise SystemExit(f"no radio is named {', '.join(sorted(unknown))}: {FULL} or {LIMITED}")
    return ExperimentSpec(
        name="Beyond the papers",
        about="Is a strategy of this project faster than the best of the papers'?",
        environments=tuple(worlds),
        strategies=tuple(CHOICES.get(name) or StrategyChoice(name=name) for name in strategies),
        robots=tuple(teams),
        # Each repetition begins elsewhere: from one place, runs without chance would be copies.
        starts=(StartsChoice(how="clustered", first="drawn"),),
        radios=tuple(radio for radio in RADIOS if radio.label in radios),
        exclude=(Only(robots=1, radio=LIMITED),) if 1 in teams and LIMITED in radios else (),
        repetitions=repetitions,
        first_seed=first_seed,
        reference="informed" if reference else "none",
    )


@dataclass(frozen=True, slots=True)
class Comparison:
    """One strategy against another in some cells.

    Attributes
    ----------
    ratio : Interval
        Of the times, below 1 if the first is faster.
    p_value : float
        Of the family of cells.
    mean : float
        Geometric mean over cells of the ratios of the median times.
    faster, slower : int
        Cells in which the first is significantly faster, or slower, after Holm's correction.
    cells, pairs : int
        Number of cells, and of pairs of runs in all of them.
    seeds : int
        Largest number of pairs in a cell.
    """

    ratio: Interval
    p_value: float
    mean: float
    faster: int
    slower: int
    cells: int
    pairs: int
    seeds: int


def compared(runs: pd.DataFrame, first: str, second: str, quantity: str) -> Comparison:
    """Compare two strategies in all cells of some runs, paired by seed."""
    a, b = (_by_cell(runs, name, quantity) for name in (first, second))
    cells = [cell for cell in a if cell in b]
    pairs = [a[cell].align(b[cell], join="inner") for cell in cells]
    ones, others = ([pair[k].to_numpy() for pair in pairs] for k in (0, 1))
    seeds = [pair[0].index.tolist() for pair in pairs]

    def test(ratio: float) -> RankTest:
        return paired_family(ones, others, repetitions=seeds, ratio=ratio)

    tests = corrected([paired(one, other) for one, other in zip(ones, others, strict=True)])
    is_significant = [test.p_value < LEVEL for test in tests]
    medians = np.array(
        [[np.median(one), np.median(other)] for one, other in zip(ones, others, strict=True)]
    )
    return Comparison(
        ratio=ratio_of(test),
        p_value=test(1.0).p_value,
        mean=float(np.exp(np.mean(np.log(medians[:, 0] / medians[:, 1])))),
        faster=sum(
            ok and found.a_lower > 0.5 for ok, found in zip(is_significant, tests, strict=True)
        ),
        slower=sum(
            ok and found.a_lower < 0.5 for ok, found in zip(is_significant, tests, strict=True)
        ),
        cells=len(cells),
        pairs=sum(map(len, ones)),
        seeds=max(map(len, ones)),
    )


def of_all(runs: pd.DataFrame, names: Sequence[str]) -> pd.DataFrame:
    """Return the runs of some strategies in those repetitions that all of them have in a cell."""
    of_these = runs[runs["strategy"].isin(names)]
    count = of_these.groupby([*CELL, "seed"])["strategy"].transform("nunique")
    return of_these[count == len(names)]


def united(tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Return the runs of several tables, each once: a crashed one only if no other is whole.

    All runs of a team from the same starts are compared with the informed plan if one of them is.

    Raises
    ------
    SystemExit
        If two tables have different recordings of a run, as those of two versions of the program.
    """
    runs = pd.concat(tables, ignore_index=True)
    key = [*CELL, "strategy", "seed"]
    if (runs.groupby(key)["digest"].nunique() > 1).any():
        raise SystemExit("the files have different recordings of the same runs: make one anew")
    runs = runs.assign(is_lost=runs["digest"].isna())
    runs = runs.sort_values([*key, "is_lost", "over_informed"]).drop(columns="is_lost")
    runs = runs.drop_duplicates(key, ignore_index=True)
    informed_s = runs[TIME] / runs["over_informed"]
    informed_s = informed_s.groupby([runs[name] for name in STARTED]).transform("median")
    return runs.fillna({"over_informed": runs[TIME] / informed_s})


def read(file: Path) -> pd.DataFrame:
    """Return the runs of a table, or of the store of an experiment."""
    runs = pd.read_csv(file) if file.suffix == ".csv" else load_results(file)
    # The digest of a run that crashed is empty, and missing where a table was written.
    return runs[list(COLUMNS_KEPT)].replace({"digest": {"": np.nan}})


def best_of(runs: pd.DataFrame, names: Sequence[str], quantity: str) -> str:
    """Return the strategy with the lowest geometric mean of its median times over cells.

    Of the strategies that were repeated most often, in those repetitions that all of these have.
    """
    often = runs[runs["strategy"].isin(names)].groupby("strategy")["seed"].nunique()
    repeated = often.index[often == often.max()].tolist()
    medians = (
        _timed(of_all(runs, repeated), quantity)
        .groupby(["strategy", *CELL], sort=True)[quantity]
        .median()
    )
    means = np.log(medians).groupby("strategy").mean()
    return str(means.loc[[name for name in names if name in means.index]].idxmin())


def beside_the_best(runs: pd.DataFrame, name: str, others: Sequence[str], quantity: str) -> float:
    """Return the geometric mean over cells of a median time over the lowest of other strategies."""
    alike = of_all(runs, [name, *others])
    medians = _timed(alike, quantity).groupby([*CELL, "strategy"], sort=True)[quantity].median()
    table = medians.unstack("strategy")
    ratios = table[name] / table[list(others)].min(axis=1)
    return float(np.exp(np.log(ratios.dropna()).mean()))


def cross_validated_ratio(
    runs: pd.DataFrame, names: Sequence[str], other: str, quantity: str
) -> float | None:
    """Return the mean ratio of the better of some strategies to another one, cross-validated.

    Which one is better in a cell is found in every second repetition, by the lowest median, and
    measured in the others, and vice versa, so that luck does not count. The mean is geometric, over
    cells with at least two repetitions; None if there are none.
    """
    alike = _timed(of_all(runs, [*names, other]), quantity)
    half = alike.groupby(list(CELL))["seed"].rank(method="dense").mod(2.0).rename("half")
    medians = alike.groupby([half, *CELL, "strategy"])[quantity].median().unstack("strategy")
    halves = [part.droplevel("half") for _, part in medians.groupby("half")]
    if len(halves) < 2:
        return None
    cells = halves[0].index.intersection(halves[1].index)
    logs = []
    for chosen, measured in (halves, halves[::-1]):
        better = chosen.loc[cells, list(names)].idxmin(axis=1)
        own = [measured.at[cell, name] for cell, name in better.items()]
        logs.append(np.log(own / measured.loc[cells, other]).mean())
    return float(np.exp(np.mean(logs)))


def page(runs: pd.DataFrame) -> list[str]:
    """Return the lines of the page; the runs are of at least one strategy of each kind."""
    present = [name for name in (*OURS, *PAPERS, TURNING) if name in set(runs["strategy"])]
    ours = [name for name in present if name in OURS]
    papers = [name for name in present if name in PAPERS]
    others = [name for name in present if name not in OURS]
    has_maps = runs["environment"].isin(MAPS).any()
    whole = (runs["status"] == "complete").sum()
    lines = [
        "# Beyond the papers",
        "",
        "Made with `python -m benchmarks.beyond run beyond.sqlite --maps FOLDER`, "
        "`python -m benchmarks.beyond unite beyond.csv beyond.sqlite` and "
        "`python -m benchmarks.beyond page beyond.csv`. The [table](beyond.csv) has all runs.",
        "",
        *_in_words(runs, ours, papers),
        f"{len(runs):,} runs in {runs['environment'].nunique()} worlds, on which no strategy was "
        f"tuned: of the suites{' and of other projects' if has_maps else ''}. "
        f"Teams of {_teams(runs)} start close together, at a place that is drawn anew for each "
        f"repetition: {_repetitions(runs)}. {whole:,} of the runs are complete; "
        f"{runs['collisions'].sum():.0f} collisions. Runs of the same seed are paired; a *cell* "
        "is a world, a team size and a radio.",
        "",
        "- *ratio*: time of the strategy of this project over that of the other; below 1 it is "
        "faster. It is the factor at which the signed ranks of all cells, added by repetition, "
        "favour neither; the 95 % interval inverts this test. Its sample is the repetitions, not "
        "the pairs: it applies to these worlds with other starts.",
        "- *p*: two-sided, of the same test.",
        "- *mean*: geometric mean of the ratios of the cells' medians.",
        "- *faster in*, *slower in*: cells with a significant difference, tested one by one with "
        "Holm's correction over all cells of a row.",
        f"- Rows without *p* have fewer than {FEWEST_SEEDS} repetitions: no interval and no test.",
        "- *(best)*: the one with the lowest geometric mean of its cells' medians among the "
        "strategies of the papers with the most repetitions; only the best of the first repetition "
        "were repeated.",
        "- A run that failed (not complete, or less than 99 % covered) counts with twice the "
        "longest makespan of its cell.",
        "",
    ]
    if TURNING in present:
        lines += [
            f"`{TURNING}` is `utility` that drives in curves like `gain` instead of turning in "
            "place; what is left of the lead of `gain` is due to its choices, and to when it makes "
            "them: `gain` chooses again when its map has changed, `utility` when its goal is "
            "reached or seen.",
            "",
        ]
    for radio in (FULL, LIMITED):
        part = runs[runs["radio"] == radio]
        if part.empty:
            continue
        lines += [f"## With {NAMED[radio]} radio", ""]
        for quantity, words in QUANTITIES.items():
            best = best_of(part, papers, quantity)
            rows = [
                _row(name, f"{other} (best)" if other == best else other, found)
                for name in ours
                for other in others
                for found in [compared(part, name, other, quantity)]
            ]
            lines += [f"{words[0].upper()}{words[1:]}:", "", markdown_table(COLUMNS, rows), ""]
            lines += [
                f"Against the strategy of the papers with the lowest median in each cell, which is "
                f"known only afterwards, the mean of `{name}` is "
                f"{beside_the_best(part, name, papers, quantity):.3f}.\n"
                for name in ours
            ]
            chosen = cross_validated_ratio(part, ours, best, quantity) if len(ours) > 1 else None
            if chosen is not None:
                lines += [
                    f"If the better one of {joined([f'`{name}`' for name in ours])} is chosen for "
                    "each cell in every second of the repetitions that all have, and measured "
                    f"against `{best}` in the others, and vice versa, the mean is {chosen:.3f}.",
                    "",
                ]
        best = best_of(part, papers, TIME)
        lines += [
            f"By team size, against `{best}`, time to 99 %:",
            "",
            markdown_table(
                ("robots", "strategy", *COLUMNS[2:]),
                _rows_by(part, "robots", ours, best),
            ),
            "",
            f"By world, against `{best}`, time to 99 %:",
            "",
            markdown_table(
                ("world", "strategy", *COLUMNS[2:]),
                _rows_by(part, "environment", ours, best),
            ),
            "",
        ]
    return lines + _regrets(runs, present) + list(TRIED)


TRIED: Final = (
    "## What did not help",
    "",
    "None of these was shown to make a team faster. Times to 99 % are multiples of those of `gain` "
    "as it was before the change; the pages of the strategies tell in which worlds.",
    "",
    "- Knowing beforehand the area that a scan at each frontier will show: not faster "
    "([gain](../algorithms/gain.md#the-effect-of-tours-and-of-keeping-goals)). Knowing the whole "
    "unknown area that is nearest to each frontier: 0.99, with one robot.",
    "- Rooms, told apart on the robot's own map, that are finished before they are left: 1.005 "
    "± 0.004 ([gain](../algorithms/gain.md#rooms-and-other-rules-of-order)).",
    "- `routes` as soon as only small areas are in sight: 1.01.",
    "- More frequent scans or choices: 0.99 to 1.01 of the time, with up to 2.5 times the "
    "computing time.",
    "- Path lengths only to where most of the area beyond a frontier is in sight: 1.05, with one "
    "robot.",
    "- Assigning frontiers by the shortest longest tour, or going along the shortest tour without "
    "values: 1.04 and 1.06 of the time of `gain` without tours, or about 1.1 of that with them.",
    "- Routes of the whole team ([routes](../algorithms/routes.md)): 0.99 of "
    "the time of `gain` where the parameters were chosen, no faster in other worlds, and slower "
    "with a limited radio.",
    "",
)
"""What did not help, with links to the pages that have the figures."""


COLUMNS: Final = (
    "strategy",
    "against",
    "ratio",
    "mean",
    "p",
    "pairs",
    "cells",
    "faster in",
    "slower in",
)


def _teams(runs: pd.DataFrame) -> str:
    """Return the team sizes with each radio."""
    sizes = {radio: sorted(part["robots"].unique()) for radio, part in runs.groupby("radio")}
    return " and ".join(
        f"{joined([str(size) for size in sizes[radio]])} robots with {words} radio"
        for radio, words in ((FULL, "unlimited"), (LIMITED, "limited (10 m, walls block)"))
        if radio in sizes
    )


def _in_words(runs: pd.DataFrame, ours: Sequence[str], papers: Sequence[str]) -> list[str]:
    """Return the result of each strategy of this project in a sentence."""
    said = []
    for radio, part in runs.groupby("radio", sort=True):
        best = best_of(part, papers, TIME)
        needs = joined([_needs(name, compared(part, name, best, TIME)) for name in ours])
        said.append(
            f"With {NAMED[str(radio)]} radio {needs} of the time of `{best}`, the best strategy of "
            "the papers, to cover 99 %."
        )
    trees = "[compared with `gain`](../algorithms/multi-srt.md#results)"
    return [f"{' '.join(said)} The SRT family is {trees} on another page.", ""]


def _needs(name: str, found: Comparison) -> str:
    """Return the time that a strategy needs, and in how many repetitions if these are few."""
    few = f" (in {counted(found.seeds, 'repetition')})" if found.seeds < FEWEST_SEEDS else ""
    return f"`{name}` needs {found.ratio.value:.2f}{few}"


def _repetitions(runs: pd.DataFrame) -> str:
    """Return how often the cells were repeated, such as "2 repetitions of all strategies"."""
    of = runs.groupby(["strategy", "radio"])["seed"].nunique().unstack("radio")
    fewest = int(np.nanmin(of.to_numpy()))
    often = []
    for name, counts in of.iterrows():
        more = counts[counts > fewest]
        if more.nunique() == 1 and len(more) == counts.count():
            often.append(f"{more.iloc[0]:.0f} of `{name}`")
        else:
            often += [f"{c:.0f} of `{name}` with {NAMED[str(r)]} radio" for r, c in more.items()]
    repetitions = "repetition" if fewest == 1 else "repetitions"
    return ", ".join([f"{fewest} {repetitions} of all strategies", *often])


def _rows_by(
    runs: pd.DataFrame, column: str, names: Sequence[str], other: str
) -> list[tuple[str, ...]]:
    """Return the comparisons with another strategy by team size, or by world, and by strategy."""
    return [
        (str(value), name, *_row(name, other, compared(part, name, other, TIME))[2:])
        for value, part in runs.groupby(column, sort=True)
        for name in names
        if {name, other} <= set(part["strategy"])
    ]


def _row(name: str, other: str, found: Comparison) -> tuple[str, ...]:
    ratio, mean, counts = found.ratio, f"{found.mean:.3f}", (str(found.pairs), str(found.cells))
    if found.seeds < FEWEST_SEEDS:
        return name, other, f"{ratio.value:.3f}", mean, "", *counts, "", ""
    return (
        name,
        other,
        f"{ratio.value:.3f} ({ratio.low:.3f} to {ratio.high:.3f})",
        mean,
        f"{found.p_value:.2g}",
        *counts,
        str(found.faster),
        str(found.slower),
    )


def _regrets(runs: pd.DataFrame, names: Sequence[str]) -> list[str]:
    """Return the part on times as multiples of those of the informed plan."""
    known = runs.dropna(subset=["over_informed"])
    if known.empty:
        return []
    regrets = dict(list(known.groupby(["radio", "strategy"])["over_informed"]))
    rows = [
        (NAMED[radio], name, *(f"{found.quantile(share):.2f}" for share in (0.5, 0.25, 0.75)))
        for radio, name in product((FULL, LIMITED), names)
        for found in [regrets.get((radio, name))]
        if found is not None
    ]
    return [
        "## Compared with a team that knows the map",
        "",
        f"Time to 99 % as a multiple of that of the informed plan, {len(known):,} runs.",
        "",
        markdown_table(("radio", "strategy", "median", "lower quartile", "upper quartile"), rows),
        "",
    ]


def _timed(runs: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """Return the runs, those that failed with `PENALTY` times the longest makespan of their cell.

    A run fails that is not complete, or covers less than 99 %.
    """
    has_failed = (runs["status"] != "complete") | runs[TIME].isna()
    longest_s = runs.groupby(CELL)[END].transform("max")
    return runs.assign(**{quantity: runs[quantity].mask(has_failed, PENALTY * longest_s)})


def _by_cell(runs: pd.DataFrame, name: str, quantity: str) -> dict[object, pd.Series]:
    """Return the times of a strategy by cell, each a series by seed."""
    own = _timed(runs, quantity)
    own = own[own["strategy"] == name]
    return {
        cell: of_cell.set_index("seed")[quantity].sort_index()
        for cell, of_cell in own.groupby(CELL, sort=True)
    }


def main() -> None:
    """Make the runs, unite them in a table, or print the page."""
    parser = argparse.ArgumentParser(description="strategies of this project against the papers'")
    commands = parser.add_subparsers(dest="command", required=True)
    made = commands.add_parser("run", help="make the runs that a store lacks")
    made.add_argument("store", type=Path)
    made.add_argument("--maps", type=Path, help="folder with maps of other projects")
    made.add_argument("--repetitions", type=int, default=REPETITIONS)
    made.add_argument("--first-seed", type=int, default=0, help="seed of the first repetition")
    made.add_argument(
        "--strategies", default=",".join((*OURS, *PAPERS)), help="names, comma between"
    )
    made.add_argument("--worlds", help="names, comma between; by default all of them")
    made.add_argument(
        "--teams", default=",".join(map(str, TEAMS)), help="numbers of robots, comma between"
    )
    made.add_argument("--radios", default=f"{FULL},{LIMITED}", help="names, comma between")
    made.add_argument("--informed", action="store_true", help="compare with the informed plan")
    made.add_argument("--workers", type=int)
    unite = commands.add_parser("unite", help="add runs to a table")
    unite.add_argument("table", type=Path, help="CSV file, made if it is missing")
    unite.add_argument("files", type=Path, nargs="+", help="stores, or tables")
    page_of = commands.add_parser("page", help="print the page")
    page_of.add_argument("files", type=Path, nargs="+", help="stores, or tables")
    given = parser.parse_args()
    if given.command == "run":
        spec = experiment(
            given.maps,
            repetitions=given.repetitions,
            reference=given.informed,
            strategies=given.strategies.split(","),
            first_seed=given.first_seed,
            only=given.worlds.split(",") if given.worlds else (),
            teams=[int(number) for number in given.teams.split(",")],
            radios=given.radios.split(","),
        )
        ms.compare(spec, store=given.store, workers=given.workers)
    elif given.command == "unite":
        held = [given.table] if given.table.exists() else []
        runs = united([read(file) for file in (*held, *given.files)])
        with atomic_write(given.table) as file:
            runs.to_csv(file, index=False)
    else:
        print("\n".join(page(united([read(file) for file in given.files]))))


if __name__ == "__main__":
    main()
