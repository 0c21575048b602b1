"""UTILITY: a leader gives everybody a frontier, the ways weighed against what others will see.

Source: Burgard, Moors, Stachniss and Schneider, Coordinated Multi-robot Exploration (2005), as
the SBX-R paper compares with it. The leader is the robot of the lowest number among those that
are in contact; whoever hears nothing from it chooses the next one.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from multisrt.explorer import Send
from multisrt.frontier_team.messages import AssignmentMessage
from multisrt.frontier_team.options import UtilityOptions
from multisrt.frontier_team.robot import FrontierRobot
from multisrt.frontier_team.rules import Choice, bid_table, settle_on
from multisrt.geometry.kernel import FloatArray
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.utility import utility

MOST_WAITS = 3
"""A robot asks its leader so often; then it takes it as lost."""


def choose_utility(robot: FrontierRobot, because: str) -> Choice:
    """Follow the leader's word, or be the leader."""
    team = robot.team
    while True:
        leader = min([robot.me.robot, *(r.robot for r in team.present() if not team.is_deaf(r))])
        if leader == robot.me.robot:
            return (yield from assign(robot, because))
        for _ in range(MOST_WAITS):
            if team.assignment is not None:
                break
            yield from team.report(wants_goal=True, to=leader)
            yield from team.pause(team.period_s)
        word, team.assignment = team.assignment, None
        if word is not None:
            return (yield from obey(robot, word, because))
        team.deaf_since_s[leader] = robot.time_s


def assign(robot: FrontierRobot, because: str) -> Choice:
    """As the leader, give everybody a target, and take one's own."""
    options = cast(UtilityOptions, robot.options)
    table = bid_table(robot)
    robot.team.wanted = False
    given = utility(
        table.costs,
        apart(table.targets),
        robot.raster.in_sight(table.targets),
        robot.me.range_m,
        options.beta,
    )
    targets = table.targets.tolist()
    goals = tuple(
        (number, tuple(targets[t]) if t >= 0 else None)
        for number, t in zip(table.robots, given.assignment.tolist(), strict=True)
    )
    if not robot.team.is_alone:
        yield Send(AssignmentMessage(sender=robot.me.robot, goals=goals))
    own = int(given.assignment[table.row])
    rounds = tuple((table.robots[i], *rest) for i, *rest in given.rounds)
    choice = own if own >= 0 else None
    return (yield from settle_on(robot, table, choice, "utility", because, rounds=rounds))


def obey(robot: FrontierRobot, word: AssignmentMessage, because: str) -> Choice:
    """Go where the leader said; where the own map has no such target, to the nearest."""
    table = bid_table(robot, alone=True)
    place = dict(word.goals).get(robot.me.robot)
    choice = closest(table.costs[0])
    if place is not None and len(table.targets):
        gaps = np.hypot(*(table.targets - place).T)
        nearest = int(np.argmin(gaps))
        if gaps[nearest] <= robot.me.range_m and np.isfinite(table.costs[0, nearest]):
            choice = nearest
    return (yield from settle_on(robot, table, choice, "utility", because))


def apart(targets: FloatArray) -> FloatArray:
    """Give the distances between targets, ``(m, m)``."""
    return np.hypot(*(targets[:, None] - targets[None]).transpose(2, 0, 1))
