"""Driving to a goal, with the range finder looking round on the way."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Literal

from multisrt.events import Purpose
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.planners.navigation.path_following import ahead, follow
from multisrt.robots.explorer import Action, Move, Moved, Outcome, Sighting, Stop
from multisrt.robots.frontier.robot import FrontierRobot, Goal

Reason = Literal["reached", "news", "nothing left", "interrupted", "no way"]
"""Why driving ended: the goal is reached; the map has changed, so that a goal may be chosen
anew; nothing is left to be seen at the goal; another robot said something that asks for it; or
the way turns out not to be free."""

REACHED_M = 0.01
"""A robot that near to its goal is there."""


def drive(
    robot: FrontierRobot, goal: Goal, purpose: Purpose = "explore"
) -> Generator[Action, Outcome, Reason | Sighting]:
    """Follow a goal's path until there is a reason to end.

    Every leg lies in the region that was seen last, so that nothing is driven through that was
    not sensed to be free.

    Returns
    -------
    Reason or Sighting
        Why it ended; a sighting: of the robot before which the protective stop ended it.
    """
    path = goal.path
    while True:
        reason = reason_to_end(robot, goal, purpose)
        if reason is not None:
            return reason
        path = ahead(path, robot.at)
        ended = yield from drive_leg(robot, path, purpose)
        if ended is not None:
            return ended


def drive_leg(
    robot: FrontierRobot, path: FloatArray, purpose: Purpose
) -> Generator[Action, Outcome, Reason | Sighting | None]:
    """Follow a path until the next look round, and look; a car by curves of its own.

    Returns
    -------
    Reason or Sighting or None
        Why driving ended there, as `drive` has it; None: the way goes on.
    """
    car = robot.car
    if car is None:
        motion = follow(robot.driven_body(), robot.me.kinematics, robot.boundary, robot.at, path)
    else:
        motion = yield from car.way_along(path)
    if motion is None:
        return "no way"
    moved = yield from carry_out(robot, motion.until(robot.options.sense_period_s), purpose)
    if car is not None:
        car.has_driven(moved, robot.set_out_s)
    yield from robot.perceive(maps=robot.options.sense == "moving")
    return moved.blocked_by


def carry_out(
    robot: FrontierRobot, motion: Trajectory, purpose: Purpose
) -> Generator[Action, Outcome, Moved]:
    """Make a motion, and listen meanwhile; whoever wants it stopped is obeyed at once."""
    team = robot.team
    team.phase = "driving"
    robot.motion, robot.set_out_s = motion, robot.time_s
    outcome: Outcome = yield Move(
        trajectory=motion,
        purpose=purpose,
        guard_m=None if team.is_alone else robot.options.guard_m,
        listen=not team.is_alone,
    )
    moved = yield from team.take(outcome)
    while moved is None:
        if team.is_interrupted:
            outcome = yield Stop()
            assert isinstance(outcome, Moved)
            moved = outcome
        else:
            moved = yield from team.hear(None)
    robot.motion = None
    robot.at, robot.time_s = moved.configuration, moved.time_s
    if not team.is_alone:
        yield from team.hear()
        if robot.time_s >= team.told_s + robot.options.report_period_s:
            yield from team.report()
    return moved


def reason_to_end(robot: FrontierRobot, goal: Goal, purpose: Purpose) -> Reason | None:
    """Whether there is a reason not to drive on to a goal."""
    if robot.team.is_interrupted:
        return "interrupted"
    if math.dist(robot.at[:2], goal.place) <= REACHED_M:
        return "reached"
    if purpose != "explore":
        return None
    if robot.sees_at_half_range(goal):
        return "reached"
    if robot.options.sense == "moving" and not robot.is_frontier(*goal.place):
        return "nothing left"
    if robot.may_choose_anew():
        return "news"
    return None
