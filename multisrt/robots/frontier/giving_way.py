"""Robots that block each other's path: detours, asking, and making room.

Source: Álvarez, section "Conflicts between robots": of robots that meet, the first to notice
leads and continues, and the others pause. Differs in: where a pause is not enough, as in a passage
no wider than one body, the other leaves the leader's path.
"""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from multisrt.events import PresumedLost
from multisrt.planners.navigation.path_following import ahead
from multisrt.planners.navigation.right_of_way import place_aside
from multisrt.robots.explorer import Action, Note, Outcome, Send, Sighting, Steps
from multisrt.robots.frontier.bodies import MOVED_M, has_moved
from multisrt.robots.frontier.driving import REACHED_M, drive, pull_out
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.messages import GiveWayMessage
from multisrt.robots.frontier.progress import Event, Progress
from multisrt.robots.frontier.robot import FrontierRobot

EASY_TIMES = 4
"""A robot that gives way to another one more often than this, with the same map, pauses longer."""

MAX_DOUBLINGS = 4
"""How many times a pause is doubled at most."""


def find_detour(
    robot: FrontierRobot, goal: Goal, progress: Progress
) -> Generator[Action, Outcome, Goal | None]:
    """Look for a path to a goal round the robots in sight.

    Returns
    -------
    Goal or None
        None if no path is short enough, or the last detour began here.
    """
    seen = yield from robot.bodies.look()
    if progress.has_detoured:
        return None
    options = robot.options
    limit_m = options.detour_factor * goal.cost_m + options.detour_extra_m
    around = robot.path_finder.detour_to(goal, seen, limit_m)
    if around is None or around.cost_m <= REACHED_M:
        return None
    progress.note_detour()
    return around


def ask_to_leave(robot: FrontierRobot, goal: Goal, met: Sighting) -> Steps:
    """Ask another robot repeatedly to give way, until it moves or `patience` is exhausted.

    Ends early when this robot is itself asked to give way. A robot that does not leave is taken
    as an obstacle for a while; one that does not answer is presumed lost.

    Parameters
    ----------
    robot : FrontierRobot
        The robot that asks.
    goal : Goal
        Where it is going.
    met : Sighting
        The other robot, before which the protective stop ended a motion.
    """
    team, other = robot.team, met.robot
    began_s = robot.time_s
    for _ in range(robot.options.patience):
        asked_s = team.asked_s[other] = robot.time_s
        yield Send(request_for(robot, goal), other)
        yield from team.pause(team.period_s)
        if team.requests.give_way is None and team.teammates.last_heard_s(other) >= asked_s:
            yield from team.pause(robot.options.pause_s * robot.me.rng.random())
        if team.requests.give_way is not None:
            return
        now = {sighting.robot: sighting for sighting in (yield from robot.bodies.look())}
        if other not in now or has_moved(now[other], met):
            return
    if team.teammates.last_heard_s(other) < began_s:
        robot.bodies.add(met)
        team.teammates.note_lost(other, robot.time_s)
        yield Note(PresumedLost(time_s=robot.time_s, robot=robot.me.robot, other=other))
        return
    share = 0.5 + robot.me.rng.random()
    robot.bodies.add(met, robot.time_s + share * robot.options.body_stays_s)


def give_way(robot: FrontierRobot, times: int) -> Steps:
    """Leave the path of the robot that asked for it, and give it time to pass.

    Robots that make room for each other by turns, each of which is slow to pass, would do so
    forever: after `EASY_TIMES` times, each pause is twice as long as the one before.

    Parameters
    ----------
    robot : FrontierRobot
        The robot that was asked.
    times : int
        How often it has already given way to that robot since its map last changed.
    """
    team, pause_s, here = robot.team, robot.options.pause_s, robot.at[:2]
    asked, team.requests.give_way = team.requests.give_way, None
    assert asked is not None
    aside = yield from find_place_aside(robot, asked)
    if aside is not None and aside.cost_m > REACHED_M:
        robot.set_goal(aside)
        ended = yield from drive(robot, aside, "give way", to_see=False)
        if ended is Event.NO_WAY:
            yield from leave_by_exit(robot, asked)
        elif isinstance(ended, Sighting) and math.dist(robot.at[:2], here) <= MOVED_M:
            # Its corners would come too near to the other when it turned.
            yield from pull_out(robot, "give way", beside_bodies=True)
        robot.set_goal(None)
        yield from team.report()
    elif aside is None and not (yield from leave_by_exit(robot, asked)):
        # The robot that asked may have a place to go to.
        if not asked.firm and robot.goal is not None:
            yield Send(request_for(robot, robot.goal, firm=True), asked.sender)
        yield from team.pause(pause_s * robot.me.rng.random())
        return
    once_s = pause_s * (0.5 + robot.me.rng.random())
    until_s = robot.time_s + once_s * 2.0 ** min(max(times - EASY_TIMES, 0), MAX_DOUBLINGS)
    yield from team.pause(once_s)
    while robot.time_s < until_s and team.requests.give_way is None:
        yield from team.pause(once_s)


def leave_by_exit(robot: FrontierRobot, asked: GiveWayMessage) -> Generator[Action, Outcome, bool]:
    """Let a car that finds no place aside leave along its exit; return whether it does."""
    if robot.car is None:
        return False
    path = np.array(asked.path).reshape(-1, 2)
    motion = robot.car.leave_by_exit(path, apart_m(robot, asked))
    if motion is None:
        return False
    x, y, _ = motion.end
    goal = Goal(x, y, np.array([robot.at[:2], (x, y)]), motion.length_m)
    robot.set_goal(goal)
    yield from drive(robot, goal, "give way", to_see=False)
    robot.set_goal(None)
    yield from robot.team.report()
    return True


def request_for(robot: FrontierRobot, goal: Goal, firm: bool = False) -> GiveWayMessage:
    """Return the request to leave the rest of the path to a goal."""
    rest = ahead(goal.path, robot.at)
    return GiveWayMessage(
        sender=robot.me.robot,
        path=tuple((x, y) for x, y in rest.tolist()),
        radius_m=robot.body.outer_radius_m,
        firm=firm,
    )


def apart_m(robot: FrontierRobot, asked: GiveWayMessage) -> float:
    """Return how far from the other robot's path a place aside must be, in metres."""
    return (
        robot.body.outer_radius_m
        + asked.radius_m
        + robot.options.guard_m
        + 2.0 * robot.options.margin_m
    )


def find_place_aside(
    robot: FrontierRobot, asked: GiveWayMessage
) -> Generator[Action, Outcome, Goal | None]:
    """Return the nearest place off another robot's path.

    Preferred is a place that can be reached without passing any robot in sight. If there is none,
    only the robot that asked is not to be passed: the others will be asked to give way in turn.
    """
    seen = yield from robot.bodies.look()
    path = np.array(asked.path).reshape(-1, 2)
    for bodies in (seen, [s for s in seen if s.robot == asked.sender]):
        with robot.around_bodies(bodies):
            field = robot.own_field()
            if field is None:
                continue
            places = robot.raster.passable_centres(*robot.at[:2], robot.options.aside_m)
            costs = field.distance(robot.indices_of(places))
            place = place_aside(places, costs, path, apart_m(robot, asked))
            if place is not None:
                return robot.goal_at(field, *place)
    return None
