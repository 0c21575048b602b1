"""The experiment of MinPos: worlds, robots and options."""

from __future__ import annotations

import msgspec

from multisrt.experiments.spec import (
    EnvironmentChoice,
    ExperimentSpec,
    StartsChoice,
    StrategyChoice,
)
from multisrt.spec import DriveSpec, RangeFinderSpec, Scalar, StopRule

CLOSEST, GREEDY, MINPOS = "closest", "greedy", "minpos"
RULES = (CLOSEST, GREEDY, MINPOS)
MAZE, HOSPITAL = "maze", "hospital"
WORLDS = (MAZE, HOSPITAL)
TEAMS, QUICK_TEAMS = (2, 4, 8, 12), (2, 4)
REPETITIONS, QUICK_REPETITIONS = 40, 8
MAZE_M, MAZE_CELLS = 50.0, 25
WINGS, WING_LENGTH_M = 9, 52.2
"""The generated hospital is 143.6 x 60 m, about as large as that of Player/Stage."""

CELL_M, SPEED_M_S = 0.3, 0.5
STEP_S = CELL_M / SPEED_M_S
"""Time of a step (s): from a cell to the next one. The paper counts time in steps."""

SCAN_STEPS = 4
"""Number of steps from one scan of a robot to its next. It chooses at every step with news."""

RANGE_M = 4.0
BODY = "disc:0.2"
"""A disc about as wide as a cell, as in the paper; two of them pass each other in a door."""


def every(steps: int) -> str:
    """Return how often something happens in words: at every step, or every n-th one."""
    return "every step" if steps == 1 else f"every {ORDINALS.get(steps, f'{steps}th')} step"


ORDINALS = {2: "second", 3: "third", 4: "fourth"}


def scans(steps: int) -> dict[str, Scalar]:
    """Return options for a scan after a number of steps, and a choice at every step with news."""
    return {"sense_period_s": steps * STEP_S, "replan_period_s": STEP_S}


OPTIONS: dict[str, Scalar] = {"cell_m": CELL_M, **scans(SCAN_STEPS)}
"""Options of all strategies."""

MAX_TIME_S = 28_800.0
"""Limit of a run in simulated time: several times what the smallest team needs."""

STRATEGIES = tuple(StrategyChoice(name=rule, options=OPTIONS) for rule in RULES)
STARTS = StartsChoice(how="clustered", first="drawn")
MAZES = EnvironmentChoice(
    name=MAZE, parameters={"size_m": MAZE_M, "cells": MAZE_CELLS}, seed="repetition"
)
HOSPITALS = EnvironmentChoice(
    name=HOSPITAL, parameters={"wings": WINGS, "wing_length_m": WING_LENGTH_M}
)


def experiment(quick: bool) -> ExperimentSpec:
    """Return the experiment of the paper, or a quick one with fewer teams and runs."""
    return ExperimentSpec(
        name="minpos quick" if quick else "minpos",
        about="How much sooner a team is done that does not go to the closest frontier",
        environments=(MAZES, HOSPITALS),
        strategies=STRATEGIES,
        robots=QUICK_TEAMS if quick else TEAMS,
        starts=(STARTS,),
        bodies=(BODY,),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        drive=DriveSpec(kind="holonomic", speed_m_s=SPEED_M_S),
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


def for_hospital(spec: ExperimentSpec, world: EnvironmentChoice) -> ExperimentSpec:
    """Return an experiment with a map in the place of the hospital, whose label it takes."""
    maze, _ = spec.environments
    hospital = msgspec.structs.replace(world, label=HOSPITAL)
    return msgspec.structs.replace(
        spec, name=f"{spec.name} on {world.label}", environments=(maze, hospital)
    )
