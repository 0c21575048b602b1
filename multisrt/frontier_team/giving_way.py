"""Robots that stand in each other's way: detours, asking, and giving way.

Source: Álvarez, section "Conflicts between robots": of robots that meet, the first to notice
leads and goes on, and the others pause. Where a pause is not enough, in a passage no wider than
one body, ours has the other leave the leader's way.
"""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from multisrt.explorer import Action, Outcome, Send, Sighting
from multisrt.frontier_team.driving import drive
from multisrt.frontier_team.messages import GiveWayMessage
from multisrt.frontier_team.robot import FrontierRobot, Goal
from multisrt.geometry.kernel import FloatArray
from multisrt.planners.navigation.right_of_way import place_aside

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
    at last it takes the other for an obstacle, and another goal.
    """
    other = met.robot
    seen = yield from robot.look()
    around = robot.detour(goal, list(seen), DETOUR_SHARE * goal.cost_m + DETOUR_M)
    if around is not None:
        robot.goal = around
        return
    path = tuple((x, y) for x, y in goal.path.tolist())
    team = robot.team
    for _ in range(robot.options.patience):
        asked_s = robot.time_s
        team.asks_s[other] = asked_s
        yield Send(
            GiveWayMessage(sender=robot.me.robot, path=path, radius_m=robot.body.outer_radius_m),
            other,
        )
        yield from team.pause(team.period_s)
        if team.is_interrupted:
            return
        if team.heard_s.get(other, -math.inf) >= asked_s:
            yield from team.pause(robot.options.pause_s * robot.me.rng.random())
        if team.is_interrupted:
            return
        now = {sighting.robot: sighting for sighting in (yield from robot.look())}
        if other not in now or has_left(now[other], met):
            return
    robot.bodies[other] = met
    robot.unblock_s[other] = robot.time_s + robot.options.forget_after_s


def give_way(robot: FrontierRobot) -> Steps:
    """Leave the way of a robot that asked for it, and wait until it has passed."""
    team = robot.team
    asked, team.asked_way = team.asked_way, None
    assert asked is not None
    way = np.array(asked.path).reshape(-1, 2)
    aside = yield from find_place_aside(robot, asked, way)
    if aside is None:
        # Whoever can go somewhere has to.
        if not asked.firm and robot.goal is not None:
            path = tuple((x, y) for x, y in robot.goal.path.tolist())
            yield Send(
                GiveWayMessage(
                    sender=robot.me.robot,
                    path=path,
                    radius_m=robot.body.outer_radius_m,
                    firm=True,
                ),
                asked.sender,
            )
        yield from team.pause(robot.options.pause_s * robot.me.rng.random())
        return
    before, robot.goal = robot.goal, aside
    yield from drive(robot, aside, "give way")
    robot.goal = before
    yield from team.report()
    yield from team.pause(robot.options.pause_s * (0.5 + robot.me.rng.random()))


def find_place_aside(
    robot: FrontierRobot, asked: GiveWayMessage, way: FloatArray
) -> Generator[Action, Outcome, Goal | None]:
    """Find the nearest place out of another's way that can be reached past those who stand."""
    seen = yield from robot.look()
    own = robot.body.outer_radius_m
    apart = own + asked.radius_m + robot.options.guard_m + 2.0 * robot.options.margin_m
    for bodies in (list(seen), [s for s in seen if s.robot == asked.sender]):
        with robot.raster.blocked(robot.discs(bodies)):
            field = robot.fresh_field(*robot.at[:2])
            if field is None:
                continue
            cells, distances = field.within(ASIDE_M)
            place = place_aside(robot.raster.centres_of(cells), distances, way, apart)
            if place is not None:
                return robot.goal_at(field, *place)
    return None


def has_left(now: Sighting, then: Sighting) -> bool:
    """Whether a robot is not where it was."""
    return now.configuration.distance(then.configuration) > 0.05
