"""The experiment of MinPos: worlds, robots, options, and variants of them."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from multisrt.experiments.crossing import Condition
from multisrt.experiments.spec import (
    Block,
    EnvironmentChoice,
    ExperimentSpec,
    StartsChoice,
    StrategyChoice,
)
from multisrt.presets.preset import WORLD
from multisrt.spec import DriveSpec, RangeFinderSpec, Scalar, StopRule

CLOSEST, GREEDY, MINPOS = "closest", "greedy", "minpos"
RULES = (CLOSEST, GREEDY, MINPOS)
MAZE, HOSPITAL = "maze", "hospital"
WORLDS = (MAZE, HOSPITAL)
TEAMS, QUICK_TEAMS = (2, 4, 8, 12), (2, 4)
REPETITIONS, QUICK_REPETITIONS = 40, 8
MAZE_M, MAZE_CELLS = 50.0, 25
WINGS, WING_LENGTH_M = 9, 52.2
"""The generated hospital is 143.6 x 60 m; that of Player/Stage is 140 x 60 m."""

CELL_M, SPEED_M_S = 0.3, 0.5
STEP_S = CELL_M / SPEED_M_S
"""Time of a step (s): from a cell to the next one. The paper counts time in steps."""

SCAN_STEPS = 4
RANGE_M = 4.0
BODY = "disc:0.2"
"""A disc about as wide as a cell, as in the paper; two of them pass each other in a door."""

OPTIONS: dict[str, Scalar] = {
    "cell_m": CELL_M,
    "sense_period_s": SCAN_STEPS * STEP_S,
    "replan_period_s": SCAN_STEPS * STEP_S,
}
"""Options of all strategies: a scan every fourth step, 1.2 m, and a choice if it shows news."""

MAX_TIME_S = 28_800.0
"""Limit of a run in simulated time: several times what the smallest team needs."""

CLUSTERED, SCATTERED = "clustered, drawn", "scattered, drawn"
"""Labels of starts."""

VARIANT_TEAM = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """What all strategies are run with in mazes, to see what gains depend on.

    Attributes
    ----------
    title : str
        Name in tables.
    suffix : str
        Addition to the labels of strategies, if their options differ.
    body, starts : str
        Labels.
    """

    title: str
    suffix: str = ""
    body: str = BODY
    starts: str = CLUSTERED

    def rule(self, at: Condition) -> str | None:
        """Return the strategy of a condition without the suffix; None for other variants."""
        rule = at.strategy.removesuffix(self.suffix)
        is_own = rule in RULES and rule + self.suffix == at.strategy
        return rule if is_own and (at.body, at.starts) == (self.body, self.starts) else None


PLAIN = Variant(title="as in the experiment")
VARIANTS = (
    Variant(title="goals kept until they are reached", suffix=", targets"),
    Variant(title="bodies of 1 m, of which two cannot pass in a corridor", body="disc:0.5"),
    Variant(title="starts far apart", starts=SCATTERED),
)

DEVIATIONS = (
    f"Mazes: perfect mazes of {MAZE_M:g} x {MAZE_M:g} m with {MAZE_CELLS} x {MAZE_CELLS} cells, "
    "one for each repetition. The paper's are not available.",
    f"{WORLD} a generated hospital of 143.6 x 60 m. That of the paper is one of Player/Stage, "
    "140 x 60 m; `--map` takes that file, or another one, in its place.",
    f"Robots: discs of 0.4 m ({BODY}) that drive in any direction, on cells of {CELL_M:g} m; in "
    "the paper they are as wide as a cell, which would close some doors here. "
    f"{SPEED_M_S:g} m/s, so that a step from cell to cell takes {STEP_S:g} s; range finders "
    f"{RANGE_M:g} m, exact; a radio of unlimited range. The paper gives no range.",
    "Robots obstruct each other where two cannot pass: bodies have a size, and robots give way. "
    "Doors and corridors have room for two. The paper does not say whether its simulated robots "
    "obstruct each other.",
    "Starts: close together, as in the paper (section II), which does not say where. Here the "
    "configuration of the first robot is drawn in each repetition and the others stand around it. "
    "All strategies have the same starts and worlds.",
    "The paper gives neither team sizes nor the number of runs in its text, and times as curves "
    "only: there are no printed figures for single team sizes.",
    f"All strategies take a scan every fourth step ({SCAN_STEPS * STEP_S:g} s, "
    f"{SCAN_STEPS * CELL_M:g} m), and choose again if it shows news. In the paper time is "
    "discrete, and robots sense and choose at steps.",
    "An exploration ends when one of the robots has a complete map, as in the paper (section II). "
    "The claims are judged by the time until all are done as well, and both are shown.",
)


def experiment(quick: bool) -> ExperimentSpec:
    """Return the experiment of the paper, or a quick one with fewer teams and runs."""
    maze = EnvironmentChoice(
        name=MAZE, parameters={"size_m": MAZE_M, "cells": MAZE_CELLS}, seed="repetition"
    )
    hospital = EnvironmentChoice(
        name=HOSPITAL, parameters={"wings": WINGS, "wing_length_m": WING_LENGTH_M}
    )
    return ExperimentSpec(
        name="minpos quick" if quick else "minpos",
        about="How much sooner a team is done that does not go to the closest frontier",
        environments=(maze, hospital),
        strategies=_strategies(OPTIONS),
        robots=QUICK_TEAMS if quick else TEAMS,
        starts=(_starts(CLUSTERED),),
        bodies=(BODY,),
        blocks=() if quick else (Block(), *(_block(one, maze) for one in VARIANTS)),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        drive=DriveSpec(kind="holonomic", speed_m_s=SPEED_M_S),
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


def _strategies(options: dict[str, Scalar], suffix: str = "") -> tuple[StrategyChoice, ...]:
    return tuple(
        StrategyChoice(name=rule, label=rule + suffix if suffix else None, options=options)
        for rule in RULES
    )


def _starts(label: str) -> StartsChoice:
    return StartsChoice(how="clustered" if label == CLUSTERED else "scattered", first="drawn")


def _block(variant: Variant, maze: EnvironmentChoice) -> Block:
    options = {**OPTIONS, "replan": "target"} if variant.suffix else OPTIONS
    return Block(
        environments=(maze,),
        robots=(VARIANT_TEAM,),
        strategies=_strategies(options, variant.suffix),
        bodies=(variant.body,),
        starts=(_starts(variant.starts),),
    )


def for_hospital(spec: ExperimentSpec, world: EnvironmentChoice) -> ExperimentSpec:
    """Return an experiment with a map in the place of the hospital, whose label it takes."""
    maze, _ = spec.environments
    hospital = msgspec.structs.replace(world, label=HOSPITAL)
    return msgspec.structs.replace(
        spec, name=f"{spec.name} on {world.label}", environments=(maze, hospital)
    )
