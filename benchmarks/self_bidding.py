"""Self-bidding under a radio's range, as in its paper: ``python -m benchmarks.self_bidding``.

Teams of 1 to 5 robots explore an office of 50 x 25 m by `closest`, `utility` and `self-bidding`
with a radio of 15, 20 and 30 m: how long and how far robots are cut off from their team, and what
it costs to keep together, beside Tables I to V of the paper. Called again, only the runs that are
missing are made. The exit code is 1 where a run failed or is missing.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial

from benchmarks.grid_of_runs import Experiment, drawn_start, main, repeat_by_spec, world_of
from benchmarks.reporting import account, bullets, failures, joined
from benchmarks.self_bidding_report import (
    PAPER,
    RADIO_RANGES_M,
    READING,
    STRATEGIES,
    TEAMS,
    Case,
    Measures,
    Row,
    agreement,
    alone,
    completeness,
    statement,
    table,
)
from multisrt.spec import (
    CatalogEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Scalar,
    StopRule,
)

NAME = "self_bidding"
WORLD = CatalogEnvironment(name="office", parameters={"width_m": 50.0, "height_m": 25.0})
RANGE_M = 4.0
OPTIONS: dict[str, dict[str, Scalar]] = {"closest": {"replan": "target"}}
"""In this paper a robot decides at its target, by all strategies; the others do so by default."""

MAX_TIME_S = 14_400.0
"""Of the run's own clock: several times what a robot alone needs."""

SEEDS, QUICK_SEEDS, QUICK_TEAMS = 10, 1, (1, 3)

CONDITIONS = (
    "World: an office of 50 x 25 m, as large as the paper's, which is not at hand. Ours has more "
    "rooms and furniture, so times and distances cannot be compared as such; the marks can.",
    f"Robots: discs of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} m, all around, "
    "exact. Messages are relayed; walls do not stop them.",
    "Starts: the paper does not tell them. Here a place and a heading are drawn by the seed for "
    "the first robot and the others stand around it; one seed gives one start for all strategies.",
    "A robot chooses a goal when it has reached the last one, as in the paper; self-bidding also "
    "when it is told to stop.",
    "For a robot alone all strategies are one: it runs `closest` once for each seed, as in the "
    "paper.",
)


def grid(seeds: int, teams: Sequence[int] = (1, *TEAMS)) -> list[Case]:
    """Give all runs, seed by seed, so that a grid that is cut short has something of each cell."""
    return [
        Case(strategy=strategy, radio_range_m=radio, robots=robots, seed=seed)
        for seed in range(seeds)
        for robots in teams
        for radio in RADIO_RANGES_M
        for strategy in STRATEGIES
        if robots > 1 or (strategy, radio) == (STRATEGIES[0], RADIO_RANGES_M[0])
    ]


def spec_of(case: Case) -> RunSpec:
    """Describe a run of the grid."""
    sees = RangeFinderSpec(range_m=RANGE_M)
    start = drawn_start(world_of(WORLD), case.seed)
    others = (RobotSpec(range_finder=sees),) * (case.robots - 1)
    return RunSpec(
        environment=WORLD,
        strategy=case.strategy,
        options=OPTIONS.get(case.strategy, {}),
        robots=(RobotSpec(start=start, range_finder=sees), *others),
        starts="clustered",
        radio=RadioSpec(range_m=case.radio_range_m),
        stop=StopRule(max_time_s=MAX_TIME_S),
        seed=case.seed,
    )


def report(rows: Sequence[Row], asked: int, command: str) -> str:
    """Write what came out in Markdown."""
    sections = [
        "# Self-bidding under a radio's range",
        f"Made with `{command}`. The paper: J. C. Elizondo, G. Ramírez, E. Rodriguez and J. R. "
        "Martínez, Multi-robot Exploration Using Self-Biddings under Constraints on Communication "
        "Range (SBX-R).",
        account(rows, asked, CONDITIONS),
        "## What agrees with the paper",
        statement(rows),
        "## Signs",
        "Each mark of our tables beside that of the paper: + where self-bidding is significantly "
        "better than the strategy of that line, - where it is worse, blank where there is no "
        "significant difference. Ours are by a two-sided Mann-Whitney test at 5 %; the paper does "
        "not name its test. With fewer runs than the paper's 31, fewer differences are "
        "significant.",
        agreement(rows),
        "## Tables",
        "Ours: median (mean ± standard deviation) and mark, over complete runs. Below, the paper's "
        "median and mark. Isolation counts until the last robot is home.",
        bullets(READING),
    ]
    for paper in PAPER:
        sections += [
            f"### Table {paper.number}. {paper.title} ({paper.unit})",
            table(rows, paper),
        ]
    sections += [
        alone(rows),
        "## All runs",
        completeness(rows),
        "## Runs that failed",
        "\n".join(failures(rows, partial(repeat_by_spec, NAME))),
    ]
    return joined(sections)


def cases_of(seeds: int, given: argparse.Namespace) -> list[Case]:
    """Give the runs that the command line asks for."""
    return grid(seeds, QUICK_TEAMS if given.quick else (1, *TEAMS))


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
