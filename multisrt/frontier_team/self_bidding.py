"""SBX-R: robots bid for themselves and for each other, and keep within reach of one another.

Source: J. C. Elizondo, G. Ramírez, E. Rodriguez and J. R. Martínez, Multi-robot Exploration Using
Self-Biddings under Constraints on Communication Range (SBX-R), section III.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Generator
from typing import cast

import numpy as np

from multisrt.explorer import Action, Outcome, Send
from multisrt.frontier_team.messages import StopMessage
from multisrt.frontier_team.options import SelfBiddingOptions
from multisrt.frontier_team.robot import FrontierRobot
from multisrt.frontier_team.rules import Choice, Table, finite, own_bids, settle_on
from multisrt.geometry.distance_field import DistanceField
from multisrt.geometry.grid_path import shortest_path
from multisrt.geometry.kernel import FloatArray, IntArray
from multisrt.planners.assignment.self_bidding import self_bidding


def choose_by_self_bidding(robot: FrontierRobot, because: str) -> Choice:
    """CHOOSE TARGET: ask those in range where they go, and bid for all of them."""
    team, options = robot.team, cast(SelfBiddingOptions, robot.options)
    robot.goal = None
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
    for i, number in enumerate(numbers):
        field = own if i == row else robot.field(*goals[number])
        if field is None or not len(targets):
            continue
        a[i] = own_costs if i == row else field.distance(indices)
        others = np.array([goals[n] for n in numbers if n != number]).reshape(-1, 2)
        if len(others):
            path_gap[i] = [path_apart(robot, field, index, others) for index in indices]
            around = np.array([places[n] for n in numbers if n != number])
            frontier_gap[i] = apart(targets, around)
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


def path_apart(
    robot: FrontierRobot, field: DistanceField, index: IntArray, others: FloatArray
) -> float:
    """Give the largest distance of a path's points from the nearest of some places."""
    if not math.isfinite(field.distance(index[None])[0]):
        return math.inf
    path = densely(shortest_path(field, index), robot.options.cell_m)
    return float(apart(path, others).max())


def apart(points: FloatArray, places: FloatArray) -> FloatArray:
    """Give the distance of every point from the nearest place."""
    gaps: FloatArray = np.hypot(*(points[:, None] - places[None]).transpose(2, 0, 1)).min(axis=1)
    return gaps


def densely(path: FloatArray, step_m: float) -> FloatArray:
    """Give points along a polyline, not more than a step apart."""
    parts = [path[:1]]
    for a, b in itertools.pairwise(path):
        n = max(1, math.ceil(math.dist(a, b) / step_m))
        parts.append(a + (b - a) * (np.arange(1, n + 1) / n)[:, None])
    return np.vstack(parts)


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
