"""ROUTES: every robot plans the routes of the whole team, and goes to the first stop of its own.

A strategy of this project. Each time a goal is chosen, up to 24 frontiers are divided among the
robots and ordered to minimise the longest route (`planners.assignment.team_routes`). Every robot
starts the search from the goals that the robots have told one another, so robots with the same
knowledge plan the same routes; a goal costs less for the robot that has it, so that plans do not
alternate. Plans of different robots differ only by what one of them alone knows: bodies that bar
its paths, and frontiers for which it has no time.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final, cast

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.planners.assignment.team_routes import team_routes
from multisrt.robots.frontier.areas import areas_beyond
from multisrt.robots.frontier.options import RoutesOptions
from multisrt.robots.frontier.path_costs import PathCosts, lengths_among, present_goals
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.utility import euclidean_distances
from multisrt.robots.frontier.wavefront_costs import WavefrontCosts
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on

MAX_TARGETS: Final = 24
"""Maximum number of frontiers on the routes: those nearest to any robot."""


def choose_routes(robot: FrontierRobot, because: str) -> Choice:
    """Choose the first stop of the robot's own route, or its nearest frontier if that is empty."""
    options = cast(RoutesOptions, robot.options)
    costs = WavefrontCosts(robot, every=True)
    if not costs.is_choosable.any():
        return (yield from settle_on(robot, costs.table(), None, "routes", because))
    return (yield from choose_first_stop(robot, because, costs, options.search_m_per_m2))


def choose_first_stop(
    robot: FrontierRobot, because: str, costs: WavefrontCosts, search_m_per_m2: float
) -> Choice:
    """Choose the first stop of the robot's own route, or its nearest frontier if that is empty.

    Parameters
    ----------
    robot : FrontierRobot
        The robot that decides.
    because : str
        Reason for choosing, as in `GoalChosen`.
    costs : WavefrontCosts
        Path lengths; some frontier must be choosable.
    search_m_per_m2 : float
        Path length in metres that a robot needs to explore a square metre beyond a frontier.

    Returns
    -------
    Goal or None
        As of `settle_on`.
    """
    path_costs = PathCosts(robot, costs).all_costs()
    near = _nearest(costs)
    path_costs = path_costs[:, near]
    targets = costs.targets[near]
    goals = present_goals(robot, costs.robots, costs.targets)[:, near]
    areas = areas_beyond(robot, targets)
    service = search_m_per_m2 * areas
    path_lengths = lengths_among(
        robot, targets, costs.costs[costs.row, near], euclidean_distances(targets, targets)
    )
    routes = team_routes(
        path_costs,
        path_lengths,
        goals=[int(np.argmax(row)) if row.any() else None for row in goals],
        service_lengths=service,
    ).routes
    own = routes[costs.row]
    choice = int(near[own[0]]) if own else int(np.argmin(costs.costs[costs.row]))
    rounds = tuple(
        (number, int(near[stop]), float(areas[stop]), at_m)
        for number, own_costs, route in zip(costs.robots, path_costs, routes, strict=True)
        for stop, at_m in _along(route, own_costs, path_lengths, service)
    )
    return (yield from settle_on(robot, costs.table(), choice, "routes", because, rounds=rounds))


def _along(
    route: tuple[int, ...], costs: FloatArray, path_lengths: FloatArray, service: FloatArray
) -> Iterator[tuple[int, float]]:
    """Yield the stops of a route, and the length up to each in metres."""
    at_m = 0.0
    for before, stop in pairwise((None, *route)):
        assert stop is not None
        at_m += costs[stop] if before is None else service[before] + path_lengths[before, stop]
        yield stop, float(at_m)


def _nearest(costs: WavefrontCosts) -> IntArray:
    """Return the frontiers nearest to any robot, of those that the deciding robot can reach."""
    reached = np.flatnonzero(np.isfinite(costs.costs[costs.row]))
    nearest = costs.costs[:, reached].min(axis=0)
    found: IntArray = np.sort(reached[np.argsort(nearest, kind="stable")[:MAX_TARGETS]])
    return found
