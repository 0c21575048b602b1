"""Robots that stand in each other's way: detours, asking, and giving way.

Source: Álvarez, section "Conflicts between robots": of robots that meet, the first to notice
leads and goes on, and the others pause. Where a pause is not enough, in a passage no wider than
one body, ours has the other leave the leader's way.
"""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from multisrt.events import TakenAsLost
from multisrt.planners.navigation.path_following import ahead
from multisrt.planners.navigation.right_of_way import place_aside
from multisrt.robots.explorer import Action, Note, Outcome, Send, Sighting
from multisrt.robots.frontier.driving import REACHED_M, drive
from multisrt.robots.frontier.messages import GiveWayMessage
from multisrt.robots.frontier.robot import (
    MOVED_M,
    BodyInTheWay,
    FrontierRobot,
    Goal,
    has_moved,
)

Steps = Generator[Action, Outcome, None]

DETOUR_SHARE = 1.5
"""A way around another robot may be longer than the way through it by this factor..."""

DETOUR_M = 3.0
"""... and this much; else it is better to wait."""

ASIDE_M = 15.0
"""How far a robot goes to give way."""


def settle(robot: FrontierRobot, goal: Goal, met: Sighting) -> Steps:
    """Do something about a robot before which the protective stop ended a motion.

    It goes round, if that is not far. Else it asks the other to give way, waits, and asks again;
    at last it takes the other for an obstacle for a while.
    """
    team, other = robot.team, met.robot
    seen = yield from robot.look()
    if robot.detoured_at is None or math.dist(robot.at[:2], robot.detoured_at) > MOVED_M:
        # Who was stopped on a detour as soon as it began need not try it again.
        around = robot.goal_around(goal, seen, DETOUR_SHARE * goal.cost_m + DETOUR_M)
        if around is not None and around.cost_m > REACHED_M:
            robot.detour, robot.detoured_at = around, robot.at[:2]
            return
    began_s = robot.time_s
    for _ in range(robot.options.patience):
        asked_s = team.asks_s[other] = robot.time_s
        yield Send(ask_for_way(robot, goal), other)
        yield from team.pause(team.period_s)
        if team.asked_way is None and team.heard_s.get(other, -math.inf) >= asked_s:
            yield from team.pause(robot.options.pause_s * robot.me.rng.random())
        if team.asked_way is not None:
            return
        now = {sighting.robot: sighting for sighting in (yield from robot.look())}
        if other not in now or has_moved(now[other], met):
            return
    if team.heard_s.get(other, -math.inf) < began_s:
        # It does not answer: its body is an obstacle until it is heard of, or seen elsewhere.
        robot.bodies[other] = BodyInTheWay(met, math.inf)
        yield Note(TakenAsLost(time_s=robot.time_s, robot=robot.me.robot, other=other))
        return
    share = 0.5 + robot.me.rng.random()
    until_s = robot.time_s + share * robot.options.forget_after_s
    robot.bodies[other] = BodyInTheWay(met, until_s)


def give_way(robot: FrontierRobot) -> Steps:
    """Leave the way of a robot that asked for it, and wait until it has passed."""
    team, pause_s = robot.team, robot.options.pause_s
    asked, team.asked_way = team.asked_way, None
    assert asked is not None
    aside = yield from find_place_aside(robot, asked)
    if aside is not None and aside.cost_m > REACHED_M:
        robot.set_goal(aside)
        if (yield from drive(robot, aside, "give way")) == "no way":
            yield from go_on(robot, asked)
        robot.set_goal(None)
        yield from team.report()
    elif aside is None and not (yield from go_on(robot, asked)):
        # Whoever can go somewhere has to.
        if not asked.firm and robot.goal is not None:
            yield Send(ask_for_way(robot, robot.goal, firm=True), asked.sender)
        yield from team.pause(pause_s * robot.me.rng.random())
        return
    yield from team.pause(pause_s * (0.5 + robot.me.rng.random()))


def go_on(robot: FrontierRobot, asked: GiveWayMessage) -> Generator[Action, Outcome, bool]:
    """Let a car that finds no way aside leave another's way by what leads on; tell if it does."""
    if robot.car is None:
        return False
    on = robot.car.set_out_on(np.array(asked.path).reshape(-1, 2), apart_m(robot, asked))
    if on is None:
        return False
    x, y, _ = on.end
    goal = Goal(x, y, np.array([robot.at[:2], (x, y)]), on.length_m)
    robot.set_goal(goal)
    yield from drive(robot, goal, "give way")
    robot.set_goal(None)
    yield from robot.team.report()
    return True


def ask_for_way(robot: FrontierRobot, goal: Goal, firm: bool = False) -> GiveWayMessage:
    """Say where this robot wants to go along."""
    left = ahead(goal.path, robot.at)
    return GiveWayMessage(
        sender=robot.me.robot,
        path=tuple((x, y) for x, y in left.tolist()),
        radius_m=robot.body.outer_radius_m,
        firm=firm,
    )


def apart_m(robot: FrontierRobot, asked: GiveWayMessage) -> float:
    """Give how far from another's way a place aside is."""
    return (
        robot.body.outer_radius_m
        + asked.radius_m
        + robot.options.guard_m
        + 2.0 * robot.options.margin_m
    )


def find_place_aside(
    robot: FrontierRobot, asked: GiveWayMessage
) -> Generator[Action, Outcome, Goal | None]:
    """Find the nearest place out of another's way, not past those who stand around.

    If there is none, they are asked to give way in turn when they are met.
    """
    seen = yield from robot.look()
    way = np.array(asked.path).reshape(-1, 2)
    for bodies in (seen, [s for s in seen if s.robot == asked.sender]):
        with robot.around_bodies(bodies):
            field = robot.own_field()
            if field is None:
                continue
            places = robot.raster.passable_centres(*robot.at[:2], ASIDE_M)
            costs = field.distance(robot.indices_of(places))
            place = place_aside(places, costs, way, apart_m(robot, asked))
            if place is not None:
                return robot.goal_at(field, *place)
    return None
