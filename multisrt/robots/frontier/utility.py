"""UTILITY: a leader gives everybody a frontier, the ways weighed against what others will see.

Source: Burgard, Moors, Stachniss and Schneider, Coordinated Multi-robot Exploration (2005), as
the SBX-R paper compares with it. The leader is the robot of the lowest number among those that
are in contact; whoever hears nothing from it chooses the next one.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from multisrt.geometry.grids.fast_march import in_sight
from multisrt.geometry.grids.occupancy import OCCUPIED
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.utility import utility
from multisrt.robots.explorer import Send
from multisrt.robots.frontier.messages import AssignmentMessage
from multisrt.robots.frontier.options import UtilityOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.rules import Choice, Table, bid_table, own_bids, settle_on

MOST_WAITS = 3
"""A robot asks its leader so often; then it takes it as lost."""


def choose_utility(robot: FrontierRobot, because: str) -> Choice:
    """Follow the leader's word, or be the leader."""
    team = robot.team
    while True:
        leader = min(
            [robot.me.robot, *(r.robot for r in team.present() if not team.mates.is_deaf(r.robot))]
        )
        if leader == robot.me.robot:
            return (yield from assign(robot, because))
        for _ in range(MOST_WAITS):
            if team.requests.assignment is not None:
                break
            yield from team.report(wants_goal=True, to=leader)
            yield from team.pause(team.period_s)
        word, team.requests.assignment = team.requests.assignment, None
        if word is not None:
            return (yield from obey(robot, word, because))
        team.mates.note_deaf(leader, robot.time_s)


def assign(robot: FrontierRobot, because: str) -> Choice:
    """As the leader, give everybody a target, and take one's own."""
    options = cast(UtilityOptions, robot.options)
    table = bid_table(robot)
    # The word of one who led before counts no more.
    requests = robot.team.requests
    requests.goal, requests.assignment = False, None
    given = utility(
        table.costs,
        apart(table.targets),
        see_each_other(robot, table.targets),
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
    own, targets, costs = own_bids(robot)
    table = Table(targets=targets, robots=(robot.me.robot,), costs=costs[None], field=own, row=0)
    place = dict(word.goals)[robot.me.robot]
    choice = closest(costs)
    if place is not None and len(targets):
        gaps = np.hypot(*(targets - place).T)
        nearest = int(np.argmin(gaps))
        if gaps[nearest] <= robot.me.range_m and np.isfinite(costs[nearest]):
            choice = nearest
    return (yield from settle_on(robot, table, choice, "utility", because))


def apart(targets: FloatArray) -> FloatArray:
    """Give the distances between targets, ``(m, m)``."""
    gaps: FloatArray = np.hypot(*(targets[:, None] - targets[None]).transpose(2, 0, 1))
    return gaps


def see_each_other(robot: FrontierRobot, targets: FloatArray) -> BoolArray:
    """Tell which targets are in sight of each other, as far as walls are known, ``(m, m)``."""
    count = len(targets)
    seen = np.eye(count, dtype=np.bool_)
    if count < 2:
        return seen
    indices = robot.indices_of(targets)
    least, most = indices.min(axis=0), indices.max(axis=0) + 1
    open_cells = robot.raster.cells[least[0] : most[0], least[1] : most[1]] != OCCUPIED
    rows, columns = (indices - least).T.tolist()
    for i in range(count):
        for j in range(i):
            seen[i, j] = seen[j, i] = in_sight(
                open_cells, columns[i] + 0.5, rows[i] + 0.5, columns[j], rows[j]
            )
    return seen
