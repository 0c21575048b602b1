"""Driving by Smooth Nearness Diagram, as in SBX-R, with other robots as obstacles."""

from __future__ import annotations

import itertools
import math
from collections.abc import Generator
from typing import cast

from multisrt.events import DiagramEnd, DiagramLeft
from multisrt.geometry.numerics.distances import length_of
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.kinematics import Differential, Holonomic
from multisrt.planners.navigation.beams import in_frame_of, nearer, region_ranges
from multisrt.planners.navigation.held_command import known_clearance, motion, safe_time
from multisrt.planners.navigation.nearness_diagram import command
from multisrt.planners.navigation.path_following import ahead
from multisrt.robots.explorer import Action, Note, Outcome
from multisrt.robots.frontier.bodies import discs_of
from multisrt.robots.frontier.driving import Driven, carry_out, drive, reason_to_end
from multisrt.robots.frontier.goal import Goal, Place
from multisrt.robots.frontier.options import BiddingOptions
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot

STUCK_S = 5.0
"""A robot without progress for this long follows its path instead."""

PROGRESS_M = 0.1
"""Minimum decrease of the remaining length that counts as progress."""

MIN_HELD_S = 0.02
"""A command that may not be held for this long is not given."""

NEAR_GOAL_M = 0.5
"""A robot this near to its goal follows its path: the diagram stops short of walls."""

STANDSTILL_RAD_S = 1e-6
"""Below this rate of turn, a robot of zero speed stands."""

DIAGRAM_MARGIN_M = 0.004
"""Distance in metres that a body keeps from others and from the unknown under any held command."""


def drive_by_option(robot: FrontierRobot, goal: Goal) -> Driven:
    """Follow a goal's path, or steer along it by the diagram, as the option `drive` says.

    Where the diagram makes no progress, the path is followed. Parameters and result are those of
    `driving.drive`.
    """
    options = cast(BiddingOptions, robot.options)
    if options.drive == "nearness-diagram" and options.sense == "moving":
        ended = yield from steer(robot, goal, options)
        yield from robot.map_last_scan()
        if isinstance(ended, Event):
            return ended
        yield Note(DiagramLeft(time_s=robot.time_s, robot=robot.me.robot, because=ended))
    return (yield from drive(robot, goal))


def steer(
    robot: FrontierRobot, goal: Goal, options: BiddingOptions
) -> Generator[Action, Outcome, Event | DiagramEnd]:
    """Steer along a goal's path by the diagram.

    Returns
    -------
    Event or str
        The reason to end the drive, or why the rest of it is to follow the path.
    """
    path = goal.path
    nearest_m, since_s = math.inf, robot.time_s
    while True:
        if robot.is_called_home():
            return Event.ERRAND
        reason = reason_to_end(robot, goal, to_see=True)
        if reason is not None:
            return reason
        path = ahead(path, robot.at)
        left_m = length_of(path) + math.dist(robot.at[:2], path[0])
        if left_m < nearest_m - PROGRESS_M:
            nearest_m, since_s = left_m, robot.time_s
        if left_m < NEAR_GOAL_M:
            return "near the goal"
        if robot.time_s > since_s + STUCK_S:
            return "no progress"
        towards = lead(robot, path, options.lookahead_m)
        held_s = yield from hold_command(robot, towards, options)
        # A command that a request cut short could be held.
        if held_s < MIN_HELD_S and not robot.team.requests.any_pending:
            return "no command"


def hold_command(
    robot: FrontierRobot, towards: Place, options: BiddingOptions
) -> Generator[Action, Outcome, float]:
    """Hold one command of the diagram, and take a scan.

    Parameters
    ----------
    robot : FrontierRobot
        The robot.
    towards : (x, y)
        Where to, in metres.
    options : BiddingOptions
        Its parameters.

    Returns
    -------
    float
        For how long it was held, in seconds; hardly any time if a body is so near that the
        protective stop ends the motion at once.
    """
    kinematics = cast(Differential | Holonomic, robot.me.kinematics)
    region = robot.map.region
    assert region is not None
    bodies = discs_of((yield from robot.bodies.look()))
    around = bodies.copy()
    for body in around:
        body[:2] = in_frame_of(robot.at, body[0], body[1])
    radius = robot.body.outer_radius_m
    chosen = command(
        nearer(region_ranges(region, robot.at), around),
        robot.body.ample_radius_m,
        in_frame_of(robot.at, *towards),
        kinematics.speed_m_s,
        kinematics.turn_rate_rad_s if isinstance(kinematics, Differential) else math.pi,
        range_m=robot.me.range_m,
        any_direction=isinstance(kinematics, Holonomic),
    )
    if chosen.situation == "blocked" or (
        chosen.speed_m_s == 0.0 and abs(chosen.turn_rate_rad_s) < STANDSTILL_RAD_S
    ):
        return 0.0
    clearance = known_clearance(region.boundary, robot.at, bodies)
    safe_s = safe_time(
        chosen, clearance, radius, margin_m=DIAGRAM_MARGIN_M, is_disc=robot.body.is_disc
    )
    held_s = min(options.control_period_s, safe_s)
    if held_s < MIN_HELD_S:
        return held_s
    began_s = robot.time_s
    moved = yield from carry_out(robot, motion(chosen, kinematics, robot.at, held_s), "explore")
    yield from robot.perceive_on_the_way()
    return moved.time_s - began_s


def lead(robot: FrontierRobot, path: FloatArray, lookahead_m: float) -> Place:
    """Return the farthest place on a path, up to the lookahead, to which the path is straight."""
    boundary, (x, y, _) = robot.map.boundary, robot.at
    best = path[min(1, len(path) - 1)].tolist()
    for place in corners_within(path, lookahead_m):
        if not robot.body.disc_travel(boundary, x, y, *place):
            break
        best = place
    return best[0], best[1]


def corners_within(path: FloatArray, limit_m: float) -> list[list[float]]:
    """Return the corners of a path up to a length, and the place where that length ends."""
    points, left = [], limit_m
    for a, b in itertools.pairwise(path):
        step = float(math.dist(a, b))
        if step >= left:
            points.append((a + (b - a) * (left / step)).tolist())
            break
        points.append(b.tolist())
        left -= step
    return points
