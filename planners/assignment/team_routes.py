"""Routes of a whole team over all targets that minimise the longest route."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel
from multisrt.planners.assignment.costs import cost_table
from multisrt.planners.assignment.min_max_routes import (
    Costs,
    improve,
    insert,
    objective,
    route_times,
)

MAX_RESTARTS: Final = 12
"""Maximum number of local searches, each from other initial routes; the best result is returned.

In 300 random situations with 5 or 6 targets for 2 robots, the routes cost 0.3 % more than the best
ones on average, and at most 21 %; with a single local search 3.6 % and 48 %, in 60 situations.
"""

MIN_GAIN_M: Final = 1e-6
"""Minimum decrease in metres of the cost of the routes by a later search."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamRoutes:
    """Routes of a team.

    Attributes
    ----------
    routes : tuple of tuple of int
        For each robot the targets that it visits, in order.
    left_out : tuple of int
        Targets that are on no route: no robot can reach them.
    lengths_m : tuple of float
        Length of each route in metres, with its initial length and the service lengths of its
        stops; 0 for an empty one.
    """

    routes: tuple[tuple[int, ...], ...]
    left_out: tuple[int, ...]
    lengths_m: tuple[float, ...]

    @property
    def longest_m(self) -> float:
        """Length of the longest route in metres."""
        return max(self.lengths_m)

    @property
    def cost_m(self) -> float:
        """Cost that is minimised: the longest route plus a tenth of the mean of all, in metres."""
        return float(objective(np.array(self.lengths_m)))


def team_routes(
    costs: ArrayLike,
    path_lengths: ArrayLike,
    *,
    goals: Sequence[int | None] | None = None,
    service_lengths: ArrayLike | None = None,
    initial_lengths: ArrayLike | None = None,
) -> TeamRoutes:
    """Return routes of all robots over all targets that minimise the longest route.

    Parameters
    ----------
    costs : (n, m) array
        Cost of each robot to each target in metres; ``inf`` where there is no path, or where the
        robot must not go.
    path_lengths : (m, m) array
        Lengths of the paths between targets in metres, symmetric; ``inf`` where there is no path.
    goals : sequence of (int or None), optional
        Present goal of each robot, with which its initial route begins. Of robots with the same
        goal the first one keeps it.
    service_lengths : (m,) array, optional
        Length that a robot drives at each target to explore what is beyond it, in metres. Half of
        it counts before and half after a target, so only half at the end of a route.
    initial_lengths : (n,) array, optional
        Length that each robot drives before its route begins, in metres.

    Returns
    -------
    TeamRoutes

    Raises
    ------
    InvalidInputError
        If there is no robot, a table has the wrong shape, a negative entry or NaN, or the goals are
        not a target or None for each robot.

    Notes
    -----
    The cost that is minimised is the longest route plus a tenth of the mean of all. The initial
    routes begin with the goals. The other targets are inserted where the cost increases least, the
    one that is farthest from all robots first. Then routes are changed as long as the cost
    decreases (`min_max_routes.improve`). This is done up to twelve times, each time with another
    target inserted before the others, and the best routes are returned. Equal tables give equal
    routes.

    Source: the routes of M-TARE (repository `caochao39/mtare_planner`), and the goals of J. Faigl,
    M. Kulich and L. Přeučil, Goal assignment using distance cost in multi-robot exploration (2012);
    differs in: the former are found by a solver within a limit of time, which is not repeatable,
    and the latter by clusters of frontiers, each put in order by itself.

    Examples
    --------
    Two robots on a line, at 0 and at 10 m. The one at 0 has both targets to its left, the nearer
    one first:

    >>> x = np.array([-4.0, -1.0, 12.0])
    >>> team_routes([np.abs(x), np.abs(x - 10.0)], np.abs(x[:, None] - x)).routes
    ((1, 0), (2,))
    """
    table = cost_table(costs)
    robots, targets = table.shape
    if robots == 0:
        raise InvalidInputError("costs has no rows; give one for each robot")
    lengths = _table(path_lengths, "path_lengths", (targets, targets))
    service = _table(service_lengths, "service_lengths", (targets,))
    before = _table(initial_lengths, "initial_lengths", (robots,))
    first = _checked_goals(goals, robots, targets)

    legs = _legs(table + before[:, None], lengths, service)
    nearest = table.min(axis=0, initial=math.inf)
    order = np.argsort(-nearest, kind="stable")
    rows, sizes = _best(robots, targets, first, order[np.isfinite(nearest[order])], legs)
    routes = tuple(
        tuple(row[1:size]) for row, size in zip(rows.tolist(), sizes.tolist(), strict=True)
    )
    return TeamRoutes(
        routes=routes,
        left_out=tuple(sorted(set(range(targets)).difference(*routes))),
        lengths_m=tuple(route_times(rows, sizes, legs).tolist()),
    )


def _table(given: ArrayLike | None, name: str, shape: tuple[int, ...]) -> FloatArray:
    """Return a table of a shape, zeros if it is not given."""
    if given is None:
        return np.zeros(shape)
    table = cost_table(given, name, dimensions=len(shape))
    if table.shape != shape:
        raise InvalidInputError(f"{name} has the shape {table.shape}; it must be {shape}")
    return table


def _checked_goals(goals: Sequence[int | None] | None, robots: int, targets: int) -> IntArray:
    """Return the goals, -1 for none."""
    if goals is None:
        return np.full(robots, -1, np.int64)
    if len(goals) != robots:
        raise InvalidInputError(f"there are {len(goals)} goals; give one for each robot: {robots}")
    for goal in goals:
        if goal is not None and not 0 <= goal < targets:
            raise InvalidInputError(
                f"goals has {goal}; targets are numbered from 0 to {targets - 1}"
            )
    return np.array([-1 if goal is None else goal for goal in goals], np.int64)


def _legs(costs: FloatArray, path_lengths: FloatArray, service: FloatArray) -> Costs:
    """Return the costs of the legs as `min_max_routes` takes them, metres in place of seconds.

    Each robot is of a kind of its own, which has no legs to targets to which it has no path.
    """
    robots, targets = costs.shape
    half = service / 2.0
    legs = np.full((robots, targets + robots, targets + robots), np.inf)
    legs[:, :targets, :targets] = path_lengths + half + half[:, None]
    for robot, own in enumerate(costs):
        legs[robot, :targets, targets + robot] = legs[robot, targets + robot, :targets] = own + half
        legs[robot][:, :targets][:, np.isinf(own)] = np.inf
        legs[robot][:targets][np.isinf(own)] = np.inf
    return Costs(
        time_s=legs,
        angle=np.zeros((robots, 1, 1)),
        turn_s=np.zeros(robots),
        kind=np.arange(robots),
        heading=np.zeros(robots),
        home=False,
    )


@kernel
def _best(
    robots: int, targets: int, first: IntArray, order: IntArray, costs: Costs
) -> tuple[IntArray, IntArray]:
    # The best of several local searches: that which visits the most targets, of several such that
    # with the lowest cost. Each begins with another target; the others follow in the given order.
    count = len(order)
    starts = min(MAX_RESTARTS, max(1, count))
    best, found, found_sizes = np.inf, _empty(robots, targets), np.zeros(robots, np.int64)
    for start in range(starts):
        begin = start * count // starts
        routes, sizes = _empty(robots, targets), np.ones(robots, np.int64)
        _construct(
            routes,
            sizes,
            first,
            np.concatenate((order[begin : begin + 1], order[:begin], order[begin + 1 :])),
            costs,
        )
        routes, sizes = improve(routes, sizes, costs)
        value = objective(route_times(routes, sizes, costs))
        more = sizes.sum() - found_sizes.sum()
        if more > 0 or (more == 0 and value < best - MIN_GAIN_M):
            best, found, found_sizes = value, routes, sizes
    return found, found_sizes


@kernel
def _empty(robots: int, targets: int) -> IntArray:
    # Routes that consist of the start of their robot only.
    routes = np.full((robots, targets + 1), -1, np.int64)
    routes[:, 0] = targets + np.arange(robots)
    return routes


@kernel
def _construct(
    routes: IntArray, sizes: IntArray, first: IntArray, order: IntArray, costs: Costs
) -> None:
    # Fill routes in place: first the goals, then each target where the cost increases least.
    is_open = np.ones(routes.shape[1], np.bool_)
    for r in range(len(sizes)):
        goal = first[r]
        if goal >= 0 and is_open[goal] and np.isfinite(costs.time_s[r, routes[r, 0], goal]):
            insert(routes[r], sizes[r], 1, goal)
            sizes[r] += 1
            is_open[goal] = False
    times = route_times(routes, sizes, costs)
    trial = times.copy()
    for target in order:
        if not is_open[target]:
            continue
        best, taker, place, length = np.inf, -1, 0, 0.0
        for r in range(len(sizes)):
            legs = costs.time_s[r]
            for k in range(1, sizes[r] + 1):
                more = legs[routes[r, k - 1], target]
                if k < sizes[r]:
                    more += legs[target, routes[r, k]] - legs[routes[r, k - 1], routes[r, k]]
                trial[:] = times
                trial[r] += more
                value = objective(trial)
                if value < best:
                    best, taker, place, length = value, r, k, trial[r]
        if taker >= 0:
            insert(routes[taker], sizes[taker], place, target)
            sizes[taker] += 1
            times[taker] = length
