"""UTILITY: a leader assigns frontiers to all robots in contact.

Source: Burgard, Moors, Stachniss and Schneider, Coordinated Multi-robot Exploration (2005), as
the SBX-R paper compares with it. The leader is the robot of the lowest number among those in
contact; a robot that hears nothing from its leader turns to the next.
"""

from __future__ import annotations

from typing import Final, cast

import numpy as np

from multisrt.geometry.grids.occupancy import OCCUPIED
from multisrt.geometry.grids.sight import in_sight
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import DenseCosts
from multisrt.planners.assignment.utility import utility
from multisrt.robots.explorer import Send
from multisrt.robots.frontier.messages import AssignmentMessage
from multisrt.robots.frontier.options import UtilityOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_costs import full_table, own_costs
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on

MAX_REQUESTS: Final = 3
"""Bounds the requests of a robot to a leader that does not answer."""


def choose_utility(robot: FrontierRobot, because: str) -> Choice:
    """Go where the leader says, or assign targets as the leader."""
    team = robot.team
    while True:
        leader = min(
            [robot.me.robot, *(r.robot for r in team.present() if not team.mates.is_deaf(r.robot))]
        )
        if leader == robot.me.robot:
            return (yield from assign(robot, because))
        for _ in range(MAX_REQUESTS):
            if team.requests.assignment is not None:
                break
            yield from team.report(wants_goal=True, to=leader)
            yield from team.pause(team.period_s)
        assignment, team.requests.assignment = team.requests.assignment, None
        if assignment is not None:
            return (yield from follow_assignment(robot, assignment, because))
        team.mates.note_deaf(leader, robot.time_s)


def assign(robot: FrontierRobot, because: str) -> Choice:
    """As the leader, assign targets to all robots, and go to this robot's own."""
    options = cast(UtilityOptions, robot.options)
    table = full_table(robot)
    # An assignment by an earlier leader is void.
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


def follow_assignment(robot: FrontierRobot, assignment: AssignmentMessage, because: str) -> Choice:
    """Go where the leader says, or to the nearest frontier if the own map has none there."""
    robot.team.requests.goal = False
    table = own_costs(robot)
    place = dict(assignment.goals)[robot.me.robot]
    choice = closest(DenseCosts(table.costs), table.row)
    if place is not None and len(table.targets):
        gaps = np.hypot(*(table.targets - place).T)
        nearest = int(np.argmin(gaps))
        if gaps[nearest] <= robot.me.range_m and np.isfinite(table.costs[table.row, nearest]):
            choice = nearest
    return (yield from settle_on(robot, table, choice, "utility", because))


def apart(targets: FloatArray) -> FloatArray:
    """Return the Euclidean distances between targets, ``(m, m)`` metres."""
    gaps: FloatArray = np.hypot(*(targets[:, None] - targets[None]).transpose(2, 0, 1))
    return gaps


def see_each_other(robot: FrontierRobot, targets: FloatArray) -> BoolArray:
    """Return which targets are in sight of each other, ``(m, m)``; unknown cells hide nothing."""
    count = len(targets)
    seen = np.eye(count, dtype=np.bool_)
    if count < 2:
        return seen
    indices = robot.indices_of(targets)
    low, high = indices.min(axis=0), indices.max(axis=0) + 1
    open_cells = robot.raster.cells[low[0] : high[0], low[1] : high[1]] != OCCUPIED
    rows, columns = (indices - low).T.tolist()
    for i in range(count):
        for j in range(i):
            seen[i, j] = seen[j, i] = in_sight(
                open_cells, columns[i] + 0.5, rows[i] + 0.5, columns[j], rows[j]
            )
    return seen
