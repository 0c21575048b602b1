"""Driving along paths, sensing on the way."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from typing import Final

from multisrt.events import Purpose
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.steering import clear_of, to_room_to_turn
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.planners.navigation.path_following import ahead, follow
from multisrt.robots.explorer import Action, Move, Moved, Outcome, Sighting, Stop
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot

REACHED_M = 0.01
"""A robot this close to its goal is there."""

ERRANDS: Final = ("home", "support")
"""Purposes of the motions of robots on errands."""

Driven = Generator[Action, Outcome, Event | Sighting]
"""Returns why a drive ended: an event, or the robot before which the protective stop ended it."""

Drive = Callable[[FrontierRobot, Goal], Driven]
"""Drives to a goal."""


def drive(
    robot: FrontierRobot,
    goal: Goal,
    purpose: Purpose = "explore",
    *,
    to_see: bool = True,
    all_the_way: bool = False,
    until: Callable[[], bool] | None = None,
) -> Driven:
    """Follow the path to a goal until there is a reason to end.

    Every leg lies in the region of the last scan, so the robot drives through nothing that it has
    not sensed to be free.

    Parameters
    ----------
    robot : FrontierRobot
        The robot.
    goal : Goal
        Where to.
    purpose : str
        Purpose of the motions, for the record.
    to_see : bool
        Whether the robot goes there to see what is unknown. If so, the drive also ends where that
        is seen from afar, nothing is left to be seen, or the map has changed.
    all_the_way : bool
        Whether it goes on though the raster has no frontier there, as to a place that was chosen
        by other means: otherwise the drive ends before it begins.
    until : callable, optional
        Asked after each leg whether the errand is over for which the robot drives.

    Returns
    -------
    Event or Sighting
        `REACHED`, `NEWS`, `NOTHING_LEFT`, `INTERRUPTED`, `ERRAND`, `ERRAND_OVER` or `NO_WAY`; or
        the robot before which the protective stop ended the drive.
    """
    path = goal.path
    while True:
        if until is not None and until():
            return Event.ERRAND_OVER
        if purpose == "explore" and robot.is_called_home():
            return Event.ERRAND
        reason = reason_to_end(robot, goal, to_see=to_see, all_the_way=all_the_way)
        if reason is not None:
            return reason
        path = ahead(path, robot.at)
        ended = yield from drive_leg(robot, path, purpose)
        if ended is Event.NO_WAY:
            ended = yield from pull_out(robot, purpose)
        if ended is not None:
            return ended


def drive_leg(
    robot: FrontierRobot, path: FloatArray, purpose: Purpose
) -> Generator[Action, Outcome, Event | Sighting | None]:
    """Follow a path until the next scan, and take it.

    Parameters
    ----------
    robot : FrontierRobot
        The robot. A car follows curves of its own along the path.
    path : (n, 2) array
        The path in metres, from where the robot is.
    purpose : str
        Purpose of the motion, for the record.

    Returns
    -------
    Event or Sighting or None
        Why driving ended, as `drive` returns it; None if it continues.
    """
    car = robot.car
    if car is None:
        motion = follow(
            robot.driven_body(),
            robot.me.kinematics,
            robot.map.boundary,
            robot.at,
            path,
            until_s=robot.options.sense_period_s,
            # A curve leaves the path, which leads round bodies in the way.
            saves_turns=robot.options.saves_turns and not len(robot.bodies),
        )
    else:
        motion = yield from car.motion_along(path)
    if motion is None:
        return Event.NO_WAY
    return (yield from _make(robot, motion, purpose))


def pull_out(
    robot: FrontierRobot, purpose: Purpose, *, beside_bodies: bool = False
) -> Generator[Action, Outcome, Event | Sighting | None]:
    """Drive straight to where a body that is no disc has room to turn in place.

    The body turns first, by as little as it can. A robot does so only once at each place from which
    it cannot begin a leg of a path, as its corners would touch; beside other bodies, which may
    leave, once while its map stays the same.

    Parameters
    ----------
    robot : FrontierRobot
        The robot.
    purpose : str
        Purpose of the motion, for the record.
    beside_bodies : bool
        Whether bodies in sight keep it from turning. It does not approach them, as its protective
        stop would end the motion.

    Returns
    -------
    Event or Sighting or None
        As `drive_leg` returns it.
    """
    drive, here, now = robot.me.kinematics, robot.at[:2], robot.raster.revision
    if robot.body.is_disc or isinstance(drive, Car):
        return Event.NO_WAY
    seen = (yield from robot.bodies.look()) if beside_bodies else ()
    bodies = [sighting.footprint.placed(sighting.configuration) for sighting in seen]
    near_m, since = (REACHED_M, now) if bodies else (robot.options.cell_m, 0)
    if any(
        math.dist(here, place) < near_m and revision >= since
        for place, revision in robot.pulled_out_from
    ):
        return Event.NO_WAY
    own = robot.me.footprint.placed(robot.at)
    guard_m = robot.options.guard_m if bodies else 0.0
    region = clear_of(robot.map.boundary, own, bodies, guard_m)
    if region is None:
        return Event.NO_WAY
    motion = to_room_to_turn(robot.body, drive, region, robot.at, spare_m=guard_m)
    if motion is None:
        return Event.NO_WAY
    met = yield from _make(robot, motion, purpose)
    if math.dist(robot.at[:2], here) > REACHED_M:
        robot.pulled_out_from.append((here, now))
    return met


def _make(
    robot: FrontierRobot, motion: Trajectory, purpose: Purpose
) -> Generator[Action, Outcome, Sighting | None]:
    # Make a motion until the next scan, and take it. Return before whom it ended, if anybody.
    moved = yield from carry_out(robot, motion.until(robot.options.sense_period_s), purpose)
    if robot.car is not None:
        robot.car.note_driven(moved, robot.course.set_out_s)
    yield from robot.perceive(maps=robot.options.sense == "moving")
    return moved.blocked_by


def carry_out(
    robot: FrontierRobot, motion: Trajectory, purpose: Purpose
) -> Generator[Action, Outcome, Moved]:
    """Make a motion, listening; stop at once for a request.

    Returns
    -------
    Moved
        Where and when the motion ended.
    """
    team = robot.team
    # Robots on errands take no frontier: others leave them out, as those that have nothing to do.
    team.phase = "idle" if purpose in ERRANDS else "driving"
    robot.course.set_out(motion)
    outcome: Outcome = yield Move(
        trajectory=motion,
        purpose=purpose,
        guard_m=None if team.is_alone else robot.options.guard_m,
        listen=team.has_receivers,
    )
    moved = yield from team.take(outcome)
    while moved is None:
        if team.requests.any_pending:
            outcome = yield Stop()
            assert isinstance(outcome, Moved)
            moved = outcome
        else:
            moved = yield from team.hear(None)
    robot.course.arrive(moved.configuration, moved.time_s)
    if team.has_receivers:
        yield from team.hear()
        if robot.time_s >= team.reported_s + robot.options.report_period_s:
            yield from team.report()
    return moved


def reason_to_end(
    robot: FrontierRobot, goal: Goal, *, to_see: bool, all_the_way: bool = False
) -> Event | None:
    """Return the reason not to drive on to a goal, as in `drive`; None if there is none."""
    if robot.team.requests.any_pending:
        return Event.INTERRUPTED
    if math.dist(robot.at[:2], goal.place) <= REACHED_M:
        return Event.REACHED
    if not to_see:
        return None
    if robot.sees_at_half_range(goal):
        return Event.REACHED
    may_end_early = robot.options.sense == "moving" and robot.options.replan != "arrival"
    if may_end_early and not all_the_way and not robot.is_frontier(*goal.place):
        return Event.NOTHING_LEFT
    if robot.may_choose_anew():
        return Event.NEWS
    return None
