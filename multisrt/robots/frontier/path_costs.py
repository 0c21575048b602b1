"""Costs of robots to frontiers for `gain` and `routes`, and path lengths between frontiers."""

from __future__ import annotations

import math
from types import EllipsisType
from typing import Final, cast

import numpy as np

from multisrt.geometry.grids.lengths_between import lengths_between
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.planners.motion.kinematics import Car, Kinematics
from multisrt.robots.frontier.options import PathCostOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_costs import WavefrontCosts

SAME_GOAL_M: Final = 1.0
"""Maximum distance in metres of a frontier from a goal that it is taken for.

Frontiers move as they are seen.
"""


class PathCosts:
    """Costs of robots to targets: path lengths with the first turn, less for the present goals.

    Parameters
    ----------
    robot : FrontierRobot
        The robot that decides.
    costs : WavefrontCosts
        Path lengths; those of the robot itself are known.
    """

    def __init__(self, robot: FrontierRobot, costs: WavefrontCosts) -> None:
        options = cast(PathCostOptions, robot.options)
        self._costs = costs
        self._turns_m = options.turn_m_per_rad * first_turns(robot, costs.robots, costs.targets)
        self._nearer_m = options.keep_m * present_goals(robot, costs.robots, costs.targets)

    def all_costs(self) -> FloatArray:
        """Return the costs of all robots to all targets, ``(n, m)`` metres."""
        self._costs.compute_others()
        return self._of(self._costs.costs)

    def bounds(self) -> FloatArray:
        """Return the robot's own costs and lower bounds of those of others, ``(n, m)`` metres."""
        lengths = self._costs.lower_bounds()
        lengths[self._costs.row] = self._costs.costs[self._costs.row]
        return self._of(lengths)

    def cost(self, row: int, target: int) -> float:
        """Return the cost of a robot to a target in metres; ``inf`` if there is no path."""
        length_m = float(self._costs.costs[row, target])
        if not math.isfinite(length_m):
            found = self._costs.nearest(row, np.array([target]))
            if found is None:
                return math.inf
            length_m = found[0]
        return float(self._of(length_m, (row, target)))

    def _of(
        self, lengths: FloatArray | float, pair: tuple[int, int] | EllipsisType = ...
    ) -> FloatArray:
        """Return the costs for path lengths, of one robot to one target or of all to all."""
        costs: FloatArray = np.maximum(0.0, lengths + self._turns_m[pair] - self._nearer_m[pair])
        return costs


def lengths_among(
    robot: FrontierRobot, targets: FloatArray, costs: FloatArray, distances: FloatArray
) -> FloatArray:
    """Return approximate lengths of the paths between targets that a robot can reach.

    Parameters
    ----------
    robot : FrontierRobot
        The robot, on whose map the paths lead.
    targets : (m, 2) array
        The targets in metres.
    costs : (m,) array
        The robot's path lengths to them in metres; finite.
    distances : (m, m) array
        Euclidean distances between them in metres, which are lower bounds.

    Returns
    -------
    (m, m) array
        Metres. Paths that lead far out of the box around the targets count as those via the robot.
    """
    raster = robot.raster
    indices = robot.indices_of(targets)
    margin = math.ceil(robot.me.range_m / raster.cell_m)
    low = np.maximum(indices.min(axis=0) - margin, 0)
    high = indices.max(axis=0) + margin + 1
    box = raster.passable[low[0] : high[0], low[1] : high[1]]
    found = lengths_between(np.ascontiguousarray(box), indices - low) * raster.cell_m
    lengths: FloatArray = np.maximum(np.minimum(found, costs[:, None] + costs), distances)
    return lengths


def present_goals(robot: FrontierRobot, robots: tuple[int, ...], targets: FloatArray) -> BoolArray:
    """Return which target is the present goal of which robot, ``(n, m)``; at most one of each."""
    reports = robot.team.teammates.reports
    own = None if robot.goal is None else robot.goal.place
    are_goals = np.zeros((len(robots), len(targets)), np.bool_)
    for row, number in enumerate(robots):
        goal = own if number == robot.me.robot else reports[number].goal
        if goal is None:
            continue
        gaps = np.hypot(*(targets - goal).T)
        target = int(np.argmin(gaps))
        are_goals[row, target] = gaps[target] < SAME_GOAL_M
    return are_goals


def first_turns(robot: FrontierRobot, robots: tuple[int, ...], targets: FloatArray) -> FloatArray:
    """Return by how much robots turn towards targets, ``(n, m)`` radians from 0 to pi.

    A robot that can drive backwards and does so to save turns turns by at most a right angle. The
    others are assumed to do as this one does.
    """
    reports = robot.team.teammates.reports
    x, y, heading = np.array(
        [robot.at if n == robot.me.robot else reports[n].place for n in robots]
    ).T[:, :, None]
    turns = libm.arctan2(targets[:, 1] - y, targets[:, 0] - x) - heading
    smallest: FloatArray = np.abs((turns + math.pi) % (2.0 * math.pi) - math.pi)
    if robot.options.saves_turns and _can_reverse(robot.me.kinematics):
        smallest = np.minimum(smallest, math.pi - smallest)
    return smallest


def _can_reverse(drive: Kinematics) -> bool:
    return not isinstance(drive, Car) or drive.reverse
