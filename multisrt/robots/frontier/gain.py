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
from types import EllipsisType
from typing import Final, cast

import numpy as np

from multisrt.geometry.grids.lengths_between import lengths_between
from multisrt.geometry.grids.unknown_area import unknown_areas
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.planners.assignment.gain import GainChoice, LazyCosts, Values, gain
from multisrt.planners.assignment.gain_tours import gain_on_tours
from multisrt.robots.frontier.options import GainOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.utility import apart
from multisrt.robots.frontier.wavefront_costs import WavefrontCosts
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on

MAX_TARGETS: Final = 24
"""Number of frontiers among which tours are compared: those of the highest values to the robot."""

SAME_GOAL_M: Final = 1.0
"""A frontier this close to a goal is taken for that goal: frontiers move as they are seen."""


def choose_gain(robot: FrontierRobot, because: str) -> Choice:
    """GAIN: the frontier of the highest value, after the robots that come before this one."""
    options = cast(GainOptions, robot.options)
    costs = WavefrontCosts(robot, whole=True)
    if not np.isfinite(costs.costs[costs.row]).any():
        return (yield from settle_on(robot, costs.table(), None, "gain", because))
    ways = _Ways(robot, costs)
    areas = areas_beyond(robot, costs.targets)
    chosen = _on_tours(robot, costs, ways, areas)
    if chosen.choice is None:
        chosen = gain(
            ways.whole(),
            areas + options.return_area_m2,
            apart(costs.targets, costs.targets),
            costs.row,
            range_m=robot.me.range_m,
            power=options.power,
        )
    rounds = tuple((costs.robots[i], *rest) for i, *rest in chosen.rounds)
    return (
        yield from settle_on(robot, costs.table(), chosen.choice, "gain", because, rounds=rounds)
    )


class _Ways:
    """Ways of robots to targets: path lengths with the first turn, goals that are kept nearer.

    Parameters
    ----------
    robot : FrontierRobot
        The robot that decides.
    costs : WavefrontCosts
        Path lengths; its own are known.
    """

    def __init__(self, robot: FrontierRobot, costs: WavefrontCosts) -> None:
        options = cast(GainOptions, robot.options)
        self._costs = costs
        self._turns_m = options.turn_m_per_rad * first_turns(robot, costs.robots, costs.targets)
        self._nearer_m = options.keep_m * present_goals(robot, costs.robots, costs.targets)

    def whole(self) -> FloatArray:
        """Return the ways of all robots to all targets, ``(n, m)`` metres."""
        self._costs.compute_others()
        return self._of(self._costs.costs)

    def bounds(self) -> FloatArray:
        """Return own ways and lower bounds of those of the others, ``(n, m)`` metres."""
        lengths = self._costs.lower_bounds()
        lengths[self._costs.row] = self._costs.costs[self._costs.row]
        return self._of(lengths)

    def way(self, row: int, target: int) -> float:
        """Return the way of a robot to a target in metres; ``inf`` if there is no path."""
        found = self._costs.nearest(row, np.array([target]))
        if found is None:
            return math.inf
        return float(self._of(found[0], (row, target)))

    def _of(
        self, lengths: FloatArray | float, pair: tuple[int, int] | EllipsisType = ...
    ) -> FloatArray:
        """Return the ways for path lengths, of one robot to one target or of all to all."""
        ways: FloatArray = np.maximum(0.0, lengths + self._turns_m[pair] - self._nearer_m[pair])
        return ways


def _on_tours(
    robot: FrontierRobot, costs: WavefrontCosts, ways: _Ways, areas: FloatArray
) -> GainChoice:
    """Choose by tours among the frontiers of the highest values; none if the others take them."""
    options = cast(GainOptions, robot.options)
    if options.tour_weight == 0.0:
        return GainChoice(choice=None, rounds=())
    bounds = ways.bounds()
    own = bounds[costs.row]
    reached = np.flatnonzero(np.isfinite(own))
    rule = Values(robot.me.range_m, options.power)
    values = (areas + options.return_area_m2) * (own + rule.nearest_m) ** -rule.power
    near = np.sort(reached[np.argsort(-values[reached], kind="stable")[:MAX_TARGETS]])
    targets = costs.targets[near]
    euclidean = apart(targets, targets)
    chosen = gain_on_tours(
        LazyCosts(bounds[:, near], lambda row, target: ways.way(row, int(near[target]))),
        areas[near],
        euclidean,
        lengths_among(robot, targets, costs.costs[costs.row, near], euclidean),
        costs.row,
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


def present_goals(robot: FrontierRobot, robots: tuple[int, ...], targets: FloatArray) -> BoolArray:
    """Return which target is the present goal of which robot, ``(n, m)``; at most one of each."""
    reports = robot.team.mates.reports
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
