"""SBX-R: robots bid for themselves and for each other, and keep within reach of one another.

Source: J. C. Elizondo, G. Ramírez, E. Rodriguez and J. R. Martínez, Multi-robot Exploration Using
Self-Biddings under Constraints on Communication Range (SBX-R), section III.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import cast

import numpy as np

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.grid_path import straightened
from multisrt.geometry.numerics.distances import nearest_point, nearest_points
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel
from multisrt.planners.assignment.self_bidding import self_bidding
from multisrt.robots.explorer import Action, Outcome, Send
from multisrt.robots.frontier.messages import StopMessage
from multisrt.robots.frontier.options import SelfBiddingOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.rules import Choice, Table, finite, own_bids, settle_on

ROUNDING_M = 1e-6
"""A way that stays within a circle by so little is looked at more closely."""


def choose_by_self_bidding(robot: FrontierRobot, because: str) -> Choice:
    """CHOOSE TARGET: ask those in range where they go, and bid for all of them."""
    team, options = robot.team, cast(SelfBiddingOptions, robot.options)
    robot.set_goal(None)
    if not team.is_alone:
        yield from team.report(asks=True)
        yield from team.pause(team.round_trip_s)
    own, targets, own_costs = own_bids(robot)
    indices = robot.indices_of(targets)
    # Where everybody will be when it bids next, how far it is to there, and where it is now.
    goals, rho, places = {robot.me.robot: robot.at[:2]}, {robot.me.robot: 0.0}, {}
    places[robot.me.robot] = robot.at[:2]
    for report in team.present():
        goals[report.robot] = report.place[:2] if report.goal is None else report.goal
        rho[report.robot] = report.remaining_m
        places[report.robot] = report.place[:2]
    numbers = tuple(sorted(goals))
    row = numbers.index(robot.me.robot)
    a = np.full((len(numbers), len(targets)), np.inf)
    path_gap, frontier_gap = np.full_like(a, np.inf), np.full_like(a, np.inf)
    first_phi_m = options.phi_factor * robot.me.radio.range_m
    for i, number in enumerate(numbers):
        field = own if i == row else robot.field(*goals[number])
        if field is None or not len(targets):
            continue
        a[i] = own_costs if i == row else field.distance(indices)
        others = np.array([goals[n] for n in numbers if n != number]).reshape(-1, 2)
        if len(others):
            path_gap[i] = path_gaps(field, indices, others, options.cell_m, first_phi_m)
            around = np.array([places[n] for n in numbers if n != number])
            frontier_gap[i] = nearest_points(around, targets)
    table = Table(
        targets=targets,
        robots=numbers,
        costs=a + np.array([rho[number] for number in numbers])[:, None],
        field=own,
        row=row,
    )
    if not len(targets):
        return (yield from settle_on(robot, table, None, "self-bidding", because))
    bid = self_bidding(
        row,
        [rho[number] for number in numbers],
        a,
        path_gap,
        frontier_gap,
        radio_range_m=robot.me.radio.range_m,
        diagonal_m=robot.raster.diagonal_m,
        j0=options.phi_factor,
        dj=options.phi_step,
    )
    return (
        yield from settle_on(
            robot,
            table,
            bid.choice,
            "self-bidding",
            because,
            bids=finite(bid.bids),
            phi_m=tuple(step.phi_m for step in bid.steps if math.isfinite(step.phi_m)),
        )
    )


def path_gaps(
    field: DistanceField,
    indices: IntArray,
    others: FloatArray,
    step_m: float,
    least_m: float,
) -> FloatArray:
    """Give how far the way to each target leads from the nearest of some places; inf: no way.

    It is compared with radii that are no less than `least_m`. Where a way surely stays within
    that, an upper bound is given instead: the way is pulled from cells that lead downhill, so it
    lies in every circle that holds these.
    """
    costs = field.distance(indices)
    gaps = np.where(np.isfinite(costs), 0.0, np.inf)
    if math.isinf(least_m):
        return gaps
    reached = np.flatnonzero(np.isfinite(costs))
    ways, begins = field.descents(indices[reached])
    corner = np.array([field.x0, field.y0])
    cells: FloatArray = (ways[:, ::-1] + 0.5) * field.cell_m + corner
    starts: FloatArray = field.starts * field.cell_m + corner
    radii = least_radii(cells, begins, starts, others)
    gaps[reached] = radii
    for k in np.flatnonzero(radii > least_m - ROUNDING_M).tolist():
        path = straightened(field, ways[begins[k] : begins[k + 1]])
        gaps[reached[k]] = farthest_along(path, step_m, others)
    return gaps


@kernel
def least_radii(
    points: FloatArray, begins: IntArray, starts: FloatArray, places: FloatArray
) -> FloatArray:
    """Give the radius of the smallest circle around one of some places that holds a way's points.

    Way k is ``points[begins[k]:begins[k + 1]]``, and the starts of all.
    """
    radii = np.full(begins.shape[0] - 1, np.inf)
    for j in range(places.shape[0]):
        x, y = places[j, 0], places[j, 1]
        around = 0.0
        for i in range(starts.shape[0]):
            dx, dy = starts[i, 0] - x, starts[i, 1] - y
            around = max(around, dx * dx + dy * dy)
        for k in range(radii.shape[0]):
            radius2 = around
            for i in range(begins[k], begins[k + 1]):
                dx, dy = points[i, 0] - x, points[i, 1] - y
                radius2 = max(radius2, dx * dx + dy * dy)
            radii[k] = min(radii[k], radius2)
    return np.sqrt(radii)


@kernel
def farthest_along(path: FloatArray, step_m: float, places: FloatArray) -> float:
    """Give the largest distance of a path's points from the nearest of some places.

    Its points are taken not more than a step apart.
    """
    farthest = nearest_point(places, path[0, 0], path[0, 1])
    for k in range(1, path.shape[0]):
        x, y = path[k - 1, 0], path[k - 1, 1]
        dx, dy = path[k, 0] - x, path[k, 1] - y
        parts = max(1, math.ceil(math.hypot(dx, dy) / step_m))
        for i in range(1, parts + 1):
            share = i / parts
            farthest = max(farthest, nearest_point(places, x + dx * share, y + dy * share))
    return farthest


def tell_who_may_stop(robot: FrontierRobot) -> Generator[Action, Outcome, None]:
    """STOP SIGNAL: tell those whose goal is seen to be a frontier no more."""
    team = robot.team
    for report in team.present():
        goal = report.goal
        if goal is None or team.told_to_stop.get(report.robot) == goal:
            continue
        if robot.raster.is_known(*goal) and not robot.is_frontier(*goal):
            team.told_to_stop[report.robot] = goal
            yield Send(StopMessage(sender=robot.me.robot, goal=goal), report.robot)
