"""Multi-SRT in the two worlds of its paper, over many seeds: ``python -m benchmarks.multi_srt``.

Teams of 1 to 16 robots explore the garden and the clutter with SRT-Star and SRT-Radial, from
scattered and clustered starts, with an unlimited and a limited radio. Results go line by line to
a JSONL file beside the report: called again, only the runs that are missing are made. The exit
code is 1 where a run failed or is missing.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from benchmarks.grid_of_runs import Experiment, main
from benchmarks.multi_srt_report import SURE, Case, Measures, Row, Starts, findings, table
from benchmarks.reporting import account, bullets, failures, joined
from multisrt.spec import (
    CatalogEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

WORLDS = ("garden", "clutter")
STRATEGIES = ("srt-star", "srt-radial")
TEAMS = (1, 2, 4, 8, 16)
STARTS: tuple[Starts, ...] = ("scattered", "clustered")
RANGE_M = 4.0
RADIO_RANGES_M = (None, 15.0)
MAX_TIME_S = 14_400.0
"""Of the run's own clock: several times what a robot alone needs."""

SEEDS, QUICK_SEEDS, QUICK_TEAMS = 20, 2, (1, 2, 4)

CONDITIONS = (
    f"Robots: discs of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} m, exact; "
    f"limited radio {RADIO_RANGES_M[1]:g} m, relayed.",
    "Worlds: those of the catalogue with their default parameters. A robot alone starts "
    "where the world suggests.",
)


def grid(seeds: int, teams: Sequence[int] = TEAMS) -> list[Case]:
    """Give all runs, seed by seed, so that a grid that is cut short has something of each cell.

    For a robot alone neither starts nor radio make a difference: it explores once for each seed.
    """
    return [
        Case(
            world=world,
            strategy=strategy,
            starts=starts,
            radio_range_m=radio,
            robots=robots,
            seed=seed,
        )
        for seed in range(seeds)
        for robots in teams
        for world in WORLDS
        for strategy in STRATEGIES
        for starts in STARTS
        for radio in RADIO_RANGES_M
        if robots > 1 or (starts, radio) == (STARTS[0], RADIO_RANGES_M[0])
    ]


def spec_of(case: Case) -> RunSpec:
    """Describe a run of the grid."""
    robot = RobotSpec(range_finder=RangeFinderSpec(range_m=RANGE_M))
    return RunSpec(
        environment=CatalogEnvironment(name=case.world),
        strategy=case.strategy,
        robots=(robot,) * case.robots,
        starts=case.starts,
        radio=RadioSpec(range_m=case.radio_range_m),
        stop=StopRule(max_time_s=MAX_TIME_S),
        seed=case.seed,
    )


def report(rows: Sequence[Row], asked: int, command: str) -> str:
    """Write what came out in Markdown."""
    sections = [
        "# Multi-SRT in the garden and the clutter",
        f"Made with `{command}`.",
        account(rows, asked, CONDITIONS),
        "## The paper's claims",
        *(
            f"**{finding.claim}** {finding.verdict[0].upper()}{finding.verdict[1:]}.\n\n"
            + bullets(finding.grounds)
            for finding in findings(rows)
        ),
        "The claims compare means over complete runs; p is that of Welch's test, and what is "
        f"below {SURE:g} is called beyond chance.",
        "## Tables",
        "Mean ± standard deviation over all runs that came to an end, complete or not; that of the "
        "exploration time over those in which a robot came to know that its map is complete. "
        "Collisions, deadlocks and protective stops are sums.",
    ]
    for world in WORLDS:
        if any(row.case.world == world for row in rows):
            sections += [f"### {world.capitalize()}", table(rows, world)]
    sections += ["## Runs that failed", "\n".join(failures(rows, command_of))]
    return joined(sections)


def cases_of(seeds: int, given: argparse.Namespace) -> list[Case]:
    """Give the runs that the command line asks for."""
    return grid(seeds, QUICK_TEAMS if given.quick else TEAMS)


def command_of(case: Case) -> str:
    """Give the command that repeats a run."""
    return case.command(MAX_TIME_S)


EXPERIMENT = Experiment(
    name="multi_srt",
    about=__doc__,
    case=Case,
    measures=Measures,
    grid=cases_of,
    spec_of=spec_of,
    report=report,
    command_of=command_of,
    seeds=SEEDS,
    quick_seeds=QUICK_SEEDS,
)

if __name__ == "__main__":
    main(EXPERIMENT)
