"""GAIN: every robot goes where it will see a large area at a low cost.

A strategy of this project. The value of a frontier is the area that would be seen from it if all
unknown cells were free, over a power of the cost of the path there. A return area is added to the
area, for the path back to a frontier that is left behind: without it robots follow the large areas
and leave small ones all over the map, which cost more in the end than was saved. If every message
reaches all robots, they share it. The cost includes the first turn, so that a robot does not turn
back for a small advantage. Robots take frontiers in order of value and go on from there, and
frontiers that are taken reduce the areas of others near them (`planners.assignment.gain`). Each
robot computes this for itself, for all robots that it takes into account. Of the frontiers that it
takes, a robot goes first to one from which its tour of the others is short
(`planners.assignment.gain_tours`), and it does not leave a goal for a small advantage.

As options, a robot finishes a room before it leaves it (`own_room`), and chooses by the routes of
the whole team (`routes`) as soon as no large area is in sight.
"""

from __future__ import annotations

from typing import Final, cast

import numpy as np

from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.planners.assignment.gain import GainChoice, LazyCosts, ValueParameters, gain
from multisrt.planners.assignment.gain_tours import SEARCH_M_PER_M2, gain_on_tours
from multisrt.robots.frontier.areas import areas_beyond
from multisrt.robots.frontier.options import GainOptions
from multisrt.robots.frontier.own_room import are_in_own_room
from multisrt.robots.frontier.path_costs import PathCosts, lengths_among
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.routes import choose_first_stop
from multisrt.robots.frontier.utility import euclidean_distances
from multisrt.robots.frontier.wavefront_costs import WavefrontCosts
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on

MAX_TARGETS: Final = 24
"""Maximum number of frontiers in the auction: those of the highest values to the robot."""


def choose_gain(robot: FrontierRobot, because: str) -> Choice:
    """Choose a frontier by GAIN: by value and tour among those that others leave to this robot."""
    options = cast(GainOptions, robot.options)
    costs = WavefrontCosts(robot, every=True)
    if not costs.is_choosable.any():
        return (yield from settle_on(robot, costs.table(), None, "gain", because))
    areas = areas_beyond(robot, costs.targets)
    if areas[costs.is_choosable].max() < options.routes_below_m2:
        return (yield from choose_first_stop(robot, because, costs, SEARCH_M_PER_M2))
    path_costs = PathCosts(robot, costs)
    bounds = path_costs.bounds()
    # Others with a path to one of these have paths to all of them.
    reached = np.flatnonzero(np.isfinite(bounds[costs.row]))
    rule, chosen = "gain", GainChoice(choice=None, rounds=())
    if options.tour_weight > 0.0:
        rule, chosen = _on_tours(robot, costs, path_costs, areas, bounds, reached)
    if chosen.choice is None:
        targets = costs.targets[reached]
        among_reached = gain(
            _costs_of(path_costs, bounds, reached),
            areas[reached] + return_area_m2(robot, costs),
            euclidean_distances(targets, targets),
            costs.row,
            range_m=robot.me.range_m,
            power=options.power,
            overlap_ranges=options.overlap_ranges,
        )
        chosen = _among_all(among_reached, reached)
    rounds = tuple((costs.robots[i], *rest) for i, *rest in chosen.rounds)
    return (yield from settle_on(robot, costs.table(), chosen.choice, rule, because, rounds=rounds))


def _on_tours(
    robot: FrontierRobot,
    costs: WavefrontCosts,
    path_costs: PathCosts,
    areas: FloatArray,
    bounds: FloatArray,
    reached: IntArray,
) -> tuple[str, GainChoice]:
    """Choose by tours among the frontiers of the highest values; choose none if others take all.

    Returns
    -------
    rule : {"gain", "room"}
        "room" if the robot is in a room and goes to one of the frontiers that it took there.
    chosen : GainChoice
        What it chooses.
    """
    options = cast(GainOptions, robot.options)
    parameters = ValueParameters(
        robot.me.range_m,
        options.power,
        overlap_ranges=options.overlap_ranges,
        return_area_m2=return_area_m2(robot, costs),
    )
    weights = libm.power(bounds[costs.row] + parameters.offset_m, -parameters.power)
    values = (areas + parameters.return_area_m2) * weights
    near = np.sort(reached[np.argsort(-values[reached], kind="stable")[:MAX_TARGETS]])
    targets = costs.targets[near]
    distances = euclidean_distances(targets, targets)
    in_room = are_in_own_room(robot, targets, options.room_m2) if options.room_m2 else None
    chosen = gain_on_tours(
        _costs_of(path_costs, bounds, near),
        areas[near],
        distances,
        lengths_among(robot, targets, costs.costs[costs.row, near], distances),
        costs.row,
        parameters=parameters,
        tour_weight=options.tour_weight,
        preferred=in_room,
    )
    is_inside = in_room is not None and chosen.choice is not None and in_room[chosen.choice]
    return "room" if is_inside else "gain", _among_all(chosen, near)


def return_area_m2(robot: FrontierRobot, costs: WavefrontCosts) -> float:
    """Return what is added to every area for the path back to what is left, in square metres.

    Robots that hear each other everywhere share it: any of them may go back.
    """
    options = cast(GainOptions, robot.options)
    share = len(costs.robots) if robot.me.radio.reaches_all else 1
    return options.return_area_m2 / share


def _costs_of(path_costs: PathCosts, bounds: FloatArray, some: IntArray) -> LazyCosts:
    """Return the costs of some of the targets."""
    return LazyCosts(bounds[:, some], lambda row, target: path_costs.cost(row, int(some[target])))


def _among_all(chosen: GainChoice, some: IntArray) -> GainChoice:
    """Return a choice among some of the targets with their numbers among all."""
    return GainChoice(
        choice=None if chosen.choice is None else int(some[chosen.choice]),
        rounds=tuple((i, int(some[j]), area, value) for i, j, area, value in chosen.rounds),
    )
