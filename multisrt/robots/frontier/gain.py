"""GAIN: every robot goes where it will see much for a short way.

A strategy of this project. The value of a frontier is the area that would be seen from it, were all
unknown cells free, over a power of the way there. To the area is added what stands for the way
back to a frontier that is left behind: without it robots follow the large areas and leave scraps
all over the map, which cost more in the end than was saved. The way counts the first turn, so that
a robot does not turn back for a small advantage. Robots take frontiers in order of value and go on
from there, and those that are taken leave less to others near them (`planners.assignment.gain`);
each robot works this out for itself, for all robots that it takes into account. Of what a robot
takes it goes first to where its tour of the rest stays short (`planners.assignment.gain_tours`),
and it does not leave a goal for a small advantage.
"""

from __future__ import annotations

import math
from typing import Final, cast

import numpy as np

from multisrt.geometry.grids.lengths_between import lengths_between
from multisrt.geometry.grids.unknown_area import unknown_areas
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.assignment.gain import GainChoice, Values, gain
from multisrt.planners.assignment.gain_tours import gain_on_tours
from multisrt.robots.frontier.options import GainOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.utility import apart
from multisrt.robots.frontier.wavefront_costs import Table, full_table
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on

MAX_TARGETS: Final = 24
"""Number of frontiers among which tours are compared: those of the highest values to the robot."""

SAME_GOAL_M: Final = 1.0
"""A frontier this close to a goal is taken for that goal: frontiers move as they are seen."""


def choose_gain(robot: FrontierRobot, because: str) -> Choice:
    """GAIN: the frontier of the highest value, after the robots that come before this one."""
    options = cast(GainOptions, robot.options)
    table = full_table(robot)
    if not len(table.targets):
        return (yield from settle_on(robot, table, None, "gain", because))
    costs = table.costs + options.turn_m_per_rad * first_turns(robot, table.robots, table.targets)
    costs = nearer_goals(robot, table, costs, options.keep_m)
    areas = areas_beyond(robot, table.targets)
    chosen = _on_tours(robot, table, costs, areas)
    if chosen.choice is None:
        chosen = gain(
            costs,
            areas + options.return_area_m2,
            apart(table.targets, table.targets),
            table.row,
            range_m=robot.me.range_m,
            power=options.power,
        )
    rounds = tuple((table.robots[i], *rest) for i, *rest in chosen.rounds)
    return (yield from settle_on(robot, table, chosen.choice, "gain", because, rounds=rounds))


def _on_tours(
    robot: FrontierRobot, table: Table, costs: FloatArray, areas: FloatArray
) -> GainChoice:
    """Choose by tours among the frontiers of the highest values; none if the others take them."""
    options = cast(GainOptions, robot.options)
    reached = np.flatnonzero(np.isfinite(costs[table.row]))
    if options.tour_weight == 0.0 or not len(reached):
        return GainChoice(choice=None, rounds=())
    rule = Values(robot.me.range_m, options.power)
    ways = costs[table.row] + rule.nearest_m
    values = (areas + options.return_area_m2) * ways**-rule.power
    near = np.sort(reached[np.argsort(-values[reached], kind="stable")[:MAX_TARGETS]])
    targets = table.targets[near]
    euclidean = apart(targets, targets)
    chosen = gain_on_tours(
        costs[:, near],
        areas[near],
        euclidean,
        lengths_among(robot, targets, table.costs[table.row, near], euclidean),
        table.row,
        rule=rule,
        return_area_m2=options.return_area_m2,
        tour_weight=options.tour_weight,
    )
    rounds = tuple((i, int(near[j]), area, value) for i, j, area, value in chosen.rounds)
    choice = None if chosen.choice is None else int(near[chosen.choice])
    return GainChoice(choice=choice, rounds=rounds)


def lengths_among(
    robot: FrontierRobot, targets: FloatArray, costs: FloatArray, euclidean: FloatArray
) -> FloatArray:
    """Return approximate lengths of the paths between targets that a robot can reach.

    Parameters
    ----------
    robot : FrontierRobot
        The robot, on whose map the paths lead.
    targets : (m, 2) array
        The targets in metres.
    costs : (m,) array
        The robot's costs to them; finite, in metres.
    euclidean : (m, m) array
        Distances between them in metres: the least lengths.

    Returns
    -------
    (m, m) array
        Metres. Paths that lead far out of the box around the targets count as those by way of the
        robot.
    """
    raster = robot.raster
    indices = robot.indices_of(targets)
    margin = math.ceil(robot.me.range_m / raster.cell_m)
    low = np.maximum(indices.min(axis=0) - margin, 0)
    high = indices.max(axis=0) + margin + 1
    box = raster.passable[low[0] : high[0], low[1] : high[1]]
    found = lengths_between(np.ascontiguousarray(box), indices - low) * raster.cell_m
    lengths: FloatArray = np.maximum(np.minimum(found, costs[:, None] + costs), euclidean)
    return lengths


def nearer_goals(
    robot: FrontierRobot, table: Table, costs: FloatArray, keep_m: float
) -> FloatArray:
    """Return costs in which the present goal of each robot is nearer.

    Parameters
    ----------
    robot : FrontierRobot
        The robot that decides.
    table : Table
        The targets, and the robots that are taken into account.
    costs : (n, m) array
        Their costs in metres.
    keep_m : float
        By how much goals are nearer, in metres.

    Returns
    -------
    (n, m) array
        Metres, 0 or more.
    """
    reports, nearer = robot.team.mates.reports, costs.copy()
    own = None if robot.goal is None else robot.goal.place
    for row, number in enumerate(table.robots):
        goal = own if number == robot.me.robot else reports[number].goal
        if goal is None:
            continue
        gaps = np.hypot(*(table.targets - goal).T)
        target = int(np.argmin(gaps))
        if gaps[target] < SAME_GOAL_M:
            nearer[row, target] = max(0.0, nearer[row, target] - keep_m)
    return nearer


def areas_beyond(robot: FrontierRobot, targets: FloatArray) -> FloatArray:
    """Return the unknown area that would be seen from targets, ``(m,)`` square metres."""
    cell_m = robot.raster.cell_m
    cells = unknown_areas(robot.raster.cells, robot.indices_of(targets), robot.me.range_m / cell_m)
    areas: FloatArray = cells * cell_m**2
    return areas


def first_turns(robot: FrontierRobot, robots: tuple[int, ...], targets: FloatArray) -> FloatArray:
    """Return by how much robots turn towards targets, ``(n, m)`` radians from 0 to pi.

    A robot that drives backwards to save turns turns by at most a right angle. The others are taken
    to do as this one does.
    """
    reports = robot.team.mates.reports
    x, y, heading = np.array(
        [robot.at if n == robot.me.robot else reports[n].place for n in robots]
    ).T[:, :, None]
    turns = np.arctan2(targets[:, 1] - y, targets[:, 0] - x) - heading
    smallest: FloatArray = np.abs((turns + math.pi) % (2.0 * math.pi) - math.pi)
    if robot.options.saves_turns:
        smallest = np.minimum(smallest, math.pi - smallest)
    return smallest
