"""GAIN: every robot goes where it will see much for a short way.

A strategy of this project. The value of a frontier is the area that would be seen from it, were all
unknown cells free, over a power of the way there. To the area is added what stands for the way
back to a frontier that is left behind: without it robots follow the large areas and leave scraps
all over the map, which cost more in the end than was saved. The way counts the first turn, so that
a robot does not turn back for a small advantage. Robots take frontiers in order of value and go on
from there, and those that are taken leave less to others near them (`planners.assignment.gain`);
each robot works this out for itself, for all robots that it takes into account.
"""

from __future__ import annotations

import math
from typing import cast

import numpy as np

from multisrt.geometry.grids.unknown_area import unknown_areas
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.assignment.gain import gain
from multisrt.robots.frontier.options import GainOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.utility import apart
from multisrt.robots.frontier.wavefront_costs import full_table
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on


def choose_gain(robot: FrontierRobot, because: str) -> Choice:
    """GAIN: the frontier of the highest value, after the robots that come before this one."""
    options = cast(GainOptions, robot.options)
    table = full_table(robot)
    if not len(table.targets):
        return (yield from settle_on(robot, table, None, "gain", because))
    chosen = gain(
        table.costs + options.turn_m_per_rad * first_turns(robot, table.robots, table.targets),
        areas_beyond(robot, table.targets) + options.return_area_m2,
        apart(table.targets, table.targets),
        table.row,
        range_m=robot.me.range_m,
        power=options.power,
    )
    rounds = tuple((table.robots[i], *rest) for i, *rest in chosen.rounds)
    return (yield from settle_on(robot, table, chosen.choice, "gain", because, rounds=rounds))


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
