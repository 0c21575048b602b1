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

from typing import Final, cast

import numpy as np

from multisrt.geometry.grids.unknown_area import unknown_areas
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.assignment.gain import GainChoice, LazyCosts, Values, gain
from multisrt.planners.assignment.gain_tours import gain_on_tours
from multisrt.robots.frontier.options import GainOptions
from multisrt.robots.frontier.path_costs import PathCosts, lengths_among
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.utility import apart
from multisrt.robots.frontier.wavefront_costs import WavefrontCosts
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on

MAX_TARGETS: Final = 24
"""Number of frontiers among which tours are compared: those of the highest values to the robot."""


def choose_gain(robot: FrontierRobot, because: str) -> Choice:
    """GAIN: the frontier of the highest value, after the robots that come before this one."""
    options = cast(GainOptions, robot.options)
    costs = WavefrontCosts(robot, every=True)
    if not costs.is_choosable.any():
        return (yield from settle_on(robot, costs.table(), None, "gain", because))
    ways = PathCosts(robot, costs)
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


def _on_tours(
    robot: FrontierRobot, costs: WavefrontCosts, ways: PathCosts, areas: FloatArray
) -> GainChoice:
    """Choose by tours among the frontiers of the highest values; none if the others take them."""
    options = cast(GainOptions, robot.options)
    if options.tour_weight == 0.0:
        return GainChoice(choice=None, rounds=())
    bounds = ways.bounds()
    own = bounds[costs.row]
    reached = np.flatnonzero(np.isfinite(own))
    rule = Values(robot.me.range_m, options.power)
    values = (areas + options.return_area_m2) * libm.power(own + rule.nearest_m, -rule.power)
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


def areas_beyond(robot: FrontierRobot, targets: FloatArray) -> FloatArray:
    """Return the unknown area that would be seen from targets, ``(m,)`` square metres."""
    cell_m = robot.raster.cell_m
    cells = unknown_areas(robot.raster.cells, robot.indices_of(targets), robot.me.range_m / cell_m)
    areas: FloatArray = cells * cell_m**2
    return areas
