"""Álvarez's rules on ten maps, as in the thesis: ``python -m benchmarks.alvarez``.

Teams of 1 to 8 robots explore maps of the sizes and kinds of the thesis from random starts; mean
time and mean distance of a robot are fitted by y = a x^b over team sizes, beside its Table 4.1.
Called again, only the runs that are missing are made. The exit code is 1 where a run failed or is
missing.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial

from benchmarks.alvarez_report import (
    COVERED,
    M2_FOR_A_ROBOT,
    SCENARIOS,
    TEAMS,
    Case,
    Measures,
    Row,
    distance_m,
    law_table,
    means_table,
    statement,
    time_s,
)
from benchmarks.grid_of_runs import Experiment, drawn_start, main, repeat_by_spec, world_of
from benchmarks.reporting import account, failures, joined
from multisrt.registry import strategy
from multisrt.spec import CatalogEnvironment, RangeFinderSpec, RobotSpec, RunSpec, StopRule

NAME = "alvarez"
STRATEGY = "rules"
RANGE_M = 4.5
MAX_TIME_S = 28_800.0
"""Of the run's own clock: several times what a robot alone needs on the largest map."""

SEEDS, QUICK_SEEDS = 5, 1
QUICK_TEAMS, QUICK_SCENARIOS = (1, 2, 4), (1, 11, 43)

WORLDS = {
    1: CatalogEnvironment(name="office", parameters={"width_m": 30.0, "height_m": 20.0}),
    11: CatalogEnvironment(name="maze", parameters={"size_m": 30.0, "cells": 15}),
    10: CatalogEnvironment(name="rooms", parameters={"size_m": 40.0, "rooms_per_side": 5}),
    13: CatalogEnvironment(name="office", parameters={"width_m": 40.0, "height_m": 40.0}),
    43: CatalogEnvironment(name="clutter", parameters={"size_m": 40.0}),
    18: CatalogEnvironment(
        name="clutter", parameters={"size_m": 40.0, "cover": 0.16, "passage_m": 0.8}
    ),
    45: CatalogEnvironment(name="maze", parameters={"size_m": 40.0, "cells": 16, "loops": 0.1}),
    16: CatalogEnvironment(
        name="clutter", parameters={"size_m": 40.0, "cover": 0.08, "obstacle_m": 5.0}
    ),
    21: CatalogEnvironment(name="maze", parameters={"size_m": 60.0, "cells": 20}),
    46: CatalogEnvironment(name="office", parameters={"width_m": 72.0, "height_m": 60.8}),
}
"""Our map for each scenario of the thesis: as large as it is over all, and of its kind."""

CONDITIONS = (
    "Worlds: maps of the catalogue's generators with the outer size and of the kind of the "
    "thesis's, which are not at hand. Its areas are taken for those of the whole maps.",
    f"Robots: discs of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} m, exact; a radio "
    "that reaches everywhere. The thesis has 0.1 m/s and the Husky A200, which is larger; times "
    "are shorter here for that alone, so compare exponents and distances, not times.",
    "Starts: places and headings drawn by the seed, those of a team far apart from one another.",
    f"Success: the team ended with a complete map and saw {100 * COVERED:g} % of what can be seen. "
    "The thesis does not say how it tells success. Means are over successful runs.",
)


def grid(
    seeds: int,
    name: str = STRATEGY,
    teams: Sequence[int] = TEAMS,
    scenarios: Sequence[int] = tuple(SCENARIOS),
) -> list[Case]:
    """Give all runs, seed by seed, so that a grid that is cut short has something of each cell."""
    return [
        Case(scenario=scenario, strategy=name, robots=robots, seed=seed)
        for seed in range(seeds)
        for scenario in scenarios
        for robots in teams
    ]


def spec_of(case: Case) -> RunSpec:
    """Describe a run of the grid."""
    world, sees = WORLDS[case.scenario], RangeFinderSpec(range_m=RANGE_M)
    first = RobotSpec(start=drawn_start(world_of(world), case.seed), range_finder=sees)
    return RunSpec(
        environment=world,
        strategy=case.strategy,
        robots=(first, *(RobotSpec(range_finder=sees),) * (case.robots - 1)),
        starts="scattered",
        stop=StopRule(max_time_s=MAX_TIME_S),
        seed=case.seed,
    )


def report(rows: Sequence[Row], asked: int, command: str) -> str:
    """Write what came out in Markdown."""
    ours = {number: spec.name for number, spec in WORLDS.items()}
    strategies = sorted({row.case.strategy for row in rows})
    sections = [
        "# Álvarez's rules on ten maps",
        f"Made with `{command}`; strategy: {', '.join(strategies) or 'none yet'}. The thesis: J. "
        "A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de "
        "escenarios 2D, Universidad de Guanajuato, 2018.",
        account(rows, asked, CONDITIONS),
        "## What agrees with the thesis",
        statement(rows),
        "The coefficients of the thesis do not agree with its speed: at 0.1 m/s the distance of a "
        "robot alone (a of the distance) takes longer than the time that it prints (a of the "
        "time); they would need 0.13 to 0.19 m/s. The thesis finds that more robots help up to one "
        f"for each {M2_FOR_A_ROBOT:g} m2; its smallest map has room for ten, so no team here goes "
        "beyond that.",
        "## Laws",
        "y = a x^b for a team of x, fitted to the means below in logarithms. Ours / the thesis's "
        "(Table 4.1); r2 is that of our fits.",
        law_table(rows, ours),
        "## Mean exploration time (s)",
        "In brackets, where not all: successful runs of all.",
        means_table(rows, time_s),
        "## Mean distance of a robot (m)",
        means_table(rows, distance_m),
        "## Runs that failed",
        "\n".join(failures(rows, partial(repeat_by_spec, NAME))),
    ]
    return joined(sections)


def cases_of(seeds: int, given: argparse.Namespace) -> list[Case]:
    """Give the runs that the command line asks for."""
    name = strategy(given.strategy).name
    if given.quick:
        return grid(seeds, name, QUICK_TEAMS, QUICK_SCENARIOS)
    return grid(seeds, name)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Let another strategy be tried in the same conditions."""
    parser.add_argument("--strategy", default=STRATEGY, help=f"how to explore ({STRATEGY})")


def own_options(given: argparse.Namespace) -> str:
    """Repeat which one."""
    return f"--strategy {given.strategy}"


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
    add_options=add_options,
    own_options=own_options,
)

if __name__ == "__main__":
    main(EXPERIMENT)
