"""The experiment of Álvarez: maps, robots and options of the thesis."""

from __future__ import annotations

from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import (
    EnvironmentChoice,
    ExperimentSpec,
    StartsChoice,
    StrategyChoice,
)
from multisrt.presets.alvarez_maps import QUICK_SCENARIOS, SCENARIOS, Scenario
from multisrt.presets.exponents import Quantity
from multisrt.spec import DriveSpec, RangeFinderSpec, Scalar, StopRule

STRATEGY = "rules"
TEAMS, QUICK_TEAMS = (1, 2, 3, 4, 5, 6, 7, 8), (1, 2, 4)
REPETITIONS, QUICK_REPETITIONS = 20, 7
PAPERS_REPETITIONS = 40
SPEED_M_S, RANGE_M, CELL_M = 0.1, 4.5, 0.5
"""Speed, range of the laser and width of cells in the thesis (chapter 4, section 3.1)."""

BODY = "disc:0.335"
"""Disc as wide as a Husky A200 (0.67 m)."""

OPTIONS: dict[str, Scalar] = {
    "cell_m": CELL_M,
    "search_cell_m": CELL_M,
    "sense_period_s": 2.5,
    "exchange_when": "nearer",
}
"""Options of the strategy: the thesis's cells and swaps; a scan for every 0.25 m."""

MAX_TIME_S = 86_400.0
"""Limit of a run in simulated time: 4.5 times what one robot needs on the largest map."""

COVERED = 0.95
"""Minimum share of the explorable area that a successful run has covered."""

TIME, HOME = measure_named("known_complete_s"), measure_named("makespan_s")
"""The time by which the claims are judged, and the one that is shown beside it."""

TO_95, DISTANCE = measure_named("time_to_95_s"), measure_named("distance_per_robot_m")

TIME_FALLS = Quantity("exploration time", HOME.heading, (-1.02, -0.70))
DISTANCE_FALLS = Quantity("path length of a robot", "", (-1.42, -0.74))
"""What falls, with the bounds of 99 % of all exponents by the thesis (section 4.2.1)."""

M2_PER_ROBOT = 60.0
"""Area per robot below which more robots do not help, by the thesis (section 4.2.1)."""

MIN_SUCCESS = min(scenario.success_percent for scenario in SCENARIOS)

SUCCEEDS = f"At least {MIN_SUCCESS:g} % of all explorations succeed."
TAKES_LESS = (
    f"The exploration takes less time with twice as many robots, up to one per {M2_PER_ROBOT:g} m2."
)
TRAVELS_LESS = f"A robot travels less with twice as many robots, up to one per {M2_PER_ROBOT:g} m2."
"""Texts of the claims; those on exponents are `Quantity.claim` of what falls."""


def map_of(scenario: Scenario) -> EnvironmentChoice:
    """Return our map in the place of one of the thesis."""
    return EnvironmentChoice(
        name=scenario.name, label=scenario.label, parameters=scenario.parameters
    )


def experiment(quick: bool) -> ExperimentSpec:
    """Return the experiment of the thesis, or a quick one with fewer maps, teams and runs."""
    maps = tuple(
        map_of(scenario)
        for scenario in SCENARIOS
        if not quick or scenario.number in QUICK_SCENARIOS
    )
    return ExperimentSpec(
        name="alvarez quick" if quick else "alvarez",
        about="How time and distance fall with the team by Álvarez's rules, and how many succeed",
        environments=maps,
        strategies=(StrategyChoice(name=STRATEGY, options=OPTIONS),),
        robots=QUICK_TEAMS if quick else TEAMS,
        starts=(StartsChoice(how="scattered", first="drawn"),),
        bodies=(BODY,),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        drive=DriveSpec(speed_m_s=SPEED_M_S),
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )
