"""MinPos against its rivals, as in its paper: ``python -m benchmarks.minpos``.

Teams of 1 to 12 robots explore mazes and a hospital by `closest`, `greedy` and `minpos`: how much
shorter the exploration is than by `closest`, beside what the paper says. Called again, only the
runs that are missing are made. The exit code is 1 where a run failed or is missing.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial

from benchmarks.grid_of_runs import Experiment, drawn_start, main, repeat_by_spec, world_of
from benchmarks.minpos_report import (
    FEWEST_PAIRS,
    STRATEGIES,
    TEAMS,
    WORLDS,
    Case,
    Measures,
    Row,
    gains,
    statement,
    times,
)
from benchmarks.reporting import account, failures, joined
from multisrt.spec import (
    CatalogEnvironment,
    DriveSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Scalar,
    StopRule,
)

NAME = "minpos"
MAZE_M, MAZE_CELLS = 20.0, 10
RANGE_M = 4.0
MAX_TIME_S = 14_400.0
"""Of the run's own clock: several times what a robot alone needs."""

SEEDS, QUICK_SEEDS, QUICK_TEAMS = 20, 1, (1, 4)

CONDITIONS = (
    f"Worlds: perfect mazes of {MAZE_M:g} x {MAZE_M:g} m with {MAZE_CELLS} x {MAZE_CELLS} cells, "
    "one drawn for each seed, and the hospital of the catalogue. The paper's mazes and its "
    "hospital (of Player/Stage) are not at hand.",
    f"Robots: discs of 0.25 m that drive in any direction, 0.5 m/s; range finders {RANGE_M:g} m, "
    "exact; a radio that reaches everywhere. The paper's robots are as large as a cell of its grid "
    "and its time is counted in steps.",
    "Robots keep each other from passing: bodies have a size, and they give way. The paper's text "
    "does not say whether its robots do.",
    "Starts: the paper does not tell them; it speaks of robots that are grouped and separate. Here "
    "a place and a heading are drawn by the seed for the first robot and the others stand around "
    "it; one seed gives one start and one world for all strategies.",
    "All strategies choose anew on news, at most once in a second.",
)


def grid(seeds: int, teams: Sequence[int] = TEAMS) -> list[Case]:
    """Give all runs, seed by seed, so that a grid that is cut short has something of each cell.

    For a robot alone all strategies are one: it explores once for each seed.
    """
    return [
        Case(world=world, strategy=strategy, robots=robots, seed=seed)
        for seed in range(seeds)
        for robots in teams
        for world in WORLDS
        for strategy in STRATEGIES
        if robots > 1 or strategy == STRATEGIES[0]
    ]


def spec_of(case: Case) -> RunSpec:
    """Describe a run of the grid."""
    world = CatalogEnvironment(name="hospital")
    if case.world == "maze":
        size: dict[str, Scalar] = {"size_m": MAZE_M, "cells": MAZE_CELLS}
        world = CatalogEnvironment(name="maze", parameters=size, seed=case.seed)
    drive, sees = DriveSpec(kind="holonomic"), RangeFinderSpec(range_m=RANGE_M)
    first = RobotSpec(start=drawn_start(world_of(world), case.seed), drive=drive, range_finder=sees)
    others = (RobotSpec(drive=drive, range_finder=sees),) * (case.robots - 1)
    return RunSpec(
        environment=world,
        strategy=case.strategy,
        robots=(first, *others),
        starts="clustered",
        stop=StopRule(max_time_s=MAX_TIME_S),
        seed=case.seed,
    )


def report(rows: Sequence[Row], asked: int, command: str) -> str:
    """Write what came out in Markdown."""
    sections = [
        "# MinPos, greedy and the closest frontier",
        f"Made with `{command}`. The paper: A. Bautin, O. Simonin and F. Charpillet, Towards a "
        "communication free coordination for multi-robot exploration.",
        account(rows, asked, CONDITIONS),
        "## What agrees with the paper",
        statement(rows),
        "## Gains",
        "By how much the mean exploration time is shorter than with `closest`, in percent of that, "
        "over the seeds in which both were complete; in brackets the p of Wilcoxon's signed-rank "
        f"test over these pairs, which takes {FEWEST_PAIRS} at least. The paper gives its times "
        "as curves only, so it has no numbers for single team sizes.",
        gains(rows),
        "## Times",
        "Mean ± standard deviation over complete runs: the exploration time is when the first "
        "robot knows that nothing is left.",
    ]
    for world in WORLDS:
        sections += [f"### {world.capitalize()}", times(rows, world)]
    sections += ["## Runs that failed", "\n".join(failures(rows, partial(repeat_by_spec, NAME)))]
    return joined(sections)


def cases_of(seeds: int, given: argparse.Namespace) -> list[Case]:
    """Give the runs that the command line asks for."""
    return grid(seeds, QUICK_TEAMS if given.quick else TEAMS)


EXPERIMENT = Experiment(
    name=NAME,
    about=__doc__,
    case=Case,
    measures=Measures,
    grid=cases_of,
    spec_of=spec_of,
    report=report,
    seeds=SEEDS,
    quick_seeds=QUICK_SEEDS,
    limit_s=900.0,
)

if __name__ == "__main__":
    main(EXPERIMENT)
