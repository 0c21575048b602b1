"""A robot that stands in the only doorway for good, and what the other one does about it."""

from __future__ import annotations

import msgspec
import shapely

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.simulation.worlds import build_environment, inline
from multisrt.spec import Death, RobotSpec, RunSpec, StopRule
from multisrt.testing.cases import Case, NeverEnds

WIDTH_M, HEIGHT_M, WALL_M = 12.0, 5.0, 0.2
"""The two rooms with the wall between them, in metres."""

DOOR_RADII = 4.0
"""Width of the doorway in radii of the body: one that stands in its middle leaves no way past."""

MAX_IDLE_S = 600.0
"""For how long the other robot may wait in vain, in seconds of the run."""


def waits_for_ever(like: Case) -> str:
    """Return what an explorer does that never ends while another body blocks its way for good.

    Parameters
    ----------
    like : Case
        A case of the explorer; its strategy, options, first robot and radio are taken.

    Returns
    -------
    str
        What it does, and what to do; empty if it ends, or if its body is too large for the world.

    Raises
    ------
    ExplorerDefect
        If it does anything wrong besides.
    """
    case = _case(like)
    if case is None:
        return ""
    try:
        case.run_supervised()
    except NeverEnds as defect:
        return (
            "it never ends where a robot that has died stands in the only doorway: "
            f"{defect.what}; after some attempts give up what lies behind it, and end with "
            "Done(complete=False)"
        )
    return ""


def _case(like: Case) -> Case | None:
    robot = like.spec.robots[0]
    radius_m = Footprint.parse(robot.footprint).circumscribed_radius_m
    door_m = DOOR_RADII * radius_m
    if door_m > HEIGHT_M - 1.0:
        return None
    middle = 0.5 * (WIDTH_M - WALL_M), 0.5 * WIDTH_M + 0.5 * WALL_M
    wall = shapely.box(middle[0], 0.0, middle[1], HEIGHT_M).difference(
        shapely.box(0.0, 0.5 * (HEIGHT_M - door_m), WIDTH_M, 0.5 * (HEIGHT_M + door_m))
    )
    rooms = shapely.box(0.0, 0.0, WIDTH_M, HEIGHT_M).difference(wall)
    description = inline(Environment("two rooms, a robot in the doorway", rooms))
    robots = _starting_at(robot, 2.0), _starting_at(robot, 0.5 * WIDTH_M)
    spec = RunSpec(
        environment=description,
        strategy=like.spec.strategy,
        options=like.spec.options,
        robots=robots,
        radio=like.spec.radio,
        faults=(Death(robot=1, time_s=0.0),),
        stop=StopRule(max_time_s=like.spec.stop.max_time_s, max_idle_s=MAX_IDLE_S),
        seed=like.spec.seed,
    )
    return like.again(spec, build_environment(description))


def _starting_at(robot: RobotSpec, x: float) -> RobotSpec:
    return msgspec.structs.replace(robot, start=(x, 0.5 * HEIGHT_M, 0.0))
