"""SBX-R: robots bid for themselves and for each other, where they can within reach of the others.

Source: J. C. Elizondo, G. Ramírez, E. Rodriguez and J. R. Martínez, Multi-robot Exploration Using
Self-Biddings under Constraints on Communication Range (SBX-R), section III. Differs in:

- In the paper all path lengths and paths are EEDT's. Here the lengths a, and the paths that phi
  bounds, come from the fast march, straightened for the latter. With ``paths="eedt"``, the default,
  the robot then drives the path of EEDT, and rho is measured along that path.
- Robots with nothing to do, or all of whose paths others block, do not take part: they have no row
  in the table of bids, and no goal or position of theirs holds the bridge. Nor do robots that are
  presumed lost: those met that did not answer, or not heard from for `lost_after_s`. In the paper
  only a robot that is broken is left out, and nothing is said about how others know. Until then a
  robot out of range takes part with its last known goal and position. Nobody waits for it: phi
  grows until a bid is finite.
- Nodes are sent after every scan that changed the map; in Algorithm 1 a robot asks for maps when
  it decides. It still asks for goals then, and for the nodes that it lacks.
- Stop signals are sent after a scan that added a node of the robot's own, once for each goal, by
  the robot that explored the goal; in Algorithm 1 at any time while it drives. The paper sends them
  also where another robot has just chosen the same frontier, but its Algorithm 1 does not.
- The robot that hears the last stop signal, to all, bids again, and is done if it knows no frontier
  either.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.grid_path import straightened
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.geometry.numerics.distances import inside, nearest_point, nearest_points
from multisrt.geometry.numerics.kernel import kernel
from multisrt.planners.assignment.self_bidding import CohesionRadii, self_bidding
from multisrt.robots.explorer import Action, Outcome, Send
from multisrt.robots.frontier.messages import StopMessage
from multisrt.robots.frontier.options import SelfBiddingOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_costs import Table, own_costs
from multisrt.robots.frontier.wavefront_rules import Choice, finite_or_none, settle_on

ROUNDING_M: Final = 1e-6
"""A path whose upper bound is within this of the first radius is measured exactly."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Prospect:
    """The goals and positions of all robots that bid, as one of them knows them.

    Attributes
    ----------
    robots : tuple of int
        Their ids, ascending.
    goals : (n, 2) array
        Position in metres from which each robot bids next: its goal, or its place without one.
    rho : (n,) array
        Remaining path lengths to these goals in metres.
    places : (n, 2) array
        Present positions in metres.
    """

    robots: tuple[int, ...]
    goals: FloatArray
    rho: FloatArray
    places: FloatArray


def choose_by_self_bidding(robot: FrontierRobot, because: str) -> Choice:
    """CHOOSE TARGET: ask the robots in range where they go, and bid for all of them.

    All are those in `Teammates.present`; see the module.
    """
    team, options = robot.team, cast(SelfBiddingOptions, robot.options)
    robot.set_goal(None)
    if not team.is_alone:
        yield from team.report(asks=True)
        yield from team.pause(team.round_trip_s)
    own = own_costs(robot)
    known = _prospect(robot)
    row = known.robots.index(robot.me.robot)
    a, path_gap, frontier_gap = _bid_tables(robot, own, known)
    table = Table(
        targets=own.targets,
        robots=known.robots,
        costs=a + known.rho[:, None],
        field=own.field,
        row=row,
    )
    if not len(own.targets):
        return (yield from settle_on(robot, table, None, "self-bidding", because))
    radii = CohesionRadii(
        range_m=_cohesion_m(robot),
        diagonal_m=robot.raster.diagonal_m,
        first=options.phi_factor,
        step=options.phi_step,
    )
    bid = self_bidding(row, known.rho, a, path_gap, frontier_gap, radii)
    return (
        yield from settle_on(
            robot,
            table,
            bid.choice,
            "self-bidding",
            because,
            bids=finite_or_none(bid.bids),
            phi_m=tuple(step.phi_m for step in bid.steps if math.isfinite(step.phi_m)),
        )
    )


def _cohesion_m(robot: FrontierRobot) -> float:
    """Return the range of the radio in metres; a robot alone need not have one."""
    return robot.me.radio.range_m if robot.me.radio.range_m > 0.0 else math.inf


def _prospect(robot: FrontierRobot) -> _Prospect:
    """Collect what is known of the robots that are taken into account."""
    here = robot.at[:2]
    known = {robot.me.robot: (here, 0.0, here)}
    for report in robot.team.present():
        place = report.place[:2]
        goal = place if report.goal is None else report.goal
        known[report.robot] = goal, report.remaining_m, place
    robots = tuple(sorted(known))
    goals, rho, places = zip(*(known[number] for number in robots), strict=True)
    return _Prospect(
        robots=robots, goals=np.array(goals), rho=np.array(rho), places=np.array(places)
    )


def _bid_tables(
    robot: FrontierRobot, own: Table, known: _Prospect
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the path lengths a, the path gaps and the frontier gaps of `self_bidding`.

    All are those of the fast march, whatever the option `paths`.
    """
    options = cast(SelfBiddingOptions, robot.options)
    targets, indices = own.targets, robot.indices_of(own.targets)
    a = np.full((len(known.robots), len(targets)), np.inf)
    path_gap, frontier_gap = np.full_like(a, np.inf), np.full_like(a, np.inf)
    first_phi_m = options.phi_factor * _cohesion_m(robot)
    for i, number in enumerate(known.robots):
        is_own = number == robot.me.robot
        field = own.field if is_own else robot.field(*known.goals[i].tolist())
        if field is None or not len(targets):
            continue
        a[i] = own.costs[0] if is_own else field.distance(indices)
        others = np.delete(known.goals, i, axis=0)
        if len(others):
            path_gap[i] = path_gaps(field, indices, others, options.cell_m, first_phi_m)
            frontier_gap[i] = nearest_points(np.delete(known.places, i, axis=0), targets)
    return a, path_gap, frontier_gap


def path_gaps(
    field: DistanceField,
    indices: IntArray,
    others: FloatArray,
    step_m: float,
    first_phi_m: float,
) -> FloatArray:
    """Return how far the path to each target strays from the nearest of some places.

    Parameters
    ----------
    field : DistanceField
        Distances from the robot.
    indices : (m, 2) array of int
        Rows and columns of the targets in the field.
    others : (k, 2) array
        The places in metres.
    step_m : float
        Maximum spacing of the points compared along a path in metres.
    first_phi_m : float
        The smallest radius that the result will be compared with, in metres.

    Returns
    -------
    (m,) array
        Metres; ``inf`` where there is no path. Where a path is certain to stay within
        `first_phi_m`, an upper bound: the straightened path lies in every circle that holds the
        cells of the descent that it is pulled from.
    """
    costs = field.distance(indices)
    gaps = np.where(np.isfinite(costs), 0.0, np.inf)
    if math.isinf(first_phi_m):
        return gaps
    reached = np.flatnonzero(np.isfinite(costs))
    cells_on_paths, begins = field.descents(indices[reached])
    corner = np.array([field.x0, field.y0])
    cells: FloatArray = (cells_on_paths[:, ::-1] + 0.5) * field.cell_m + corner
    starts: FloatArray = field.starts * field.cell_m + corner
    radii = enclosing_radii(cells, begins, starts, others)
    gaps[reached] = radii
    for k in np.flatnonzero(radii > first_phi_m - ROUNDING_M).tolist():
        path = straightened(field, cells_on_paths[begins[k] : begins[k + 1]])
        gaps[reached[k]] = farthest_along(path, step_m, others)
    return gaps


@kernel
def enclosing_radii(
    points: FloatArray, begins: IntArray, starts: FloatArray, places: FloatArray
) -> FloatArray:
    """Return the radius of the smallest circle about one of some places that holds each path.

    Path k consists of ``points[begins[k]:begins[k + 1]]`` and all of `starts`.
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
    """Return the largest distance of a path from the nearest of some places.

    Distances are taken at points at most `step_m` apart.
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


def send_stop_signals(robot: FrontierRobot) -> Generator[Action, Outcome, None]:
    """STOP SIGNAL: inform other robots when this one has explored their goals.

    Called after every scan that added a node of the robot's own. A goal that ceased to be a
    frontier out of sight was explored by its own robot, which drives on, or by a third, which
    sends the signal itself.
    """
    stops = robot.team.stops
    if not cast(SelfBiddingOptions, robot.options).stop_signals:
        return
    for report in robot.team.present():
        number, goal = report.robot, report.goal
        if goal is None or stops.settled.get(number) == goal:
            continue
        if not robot.raster.is_known(*goal) or robot.is_frontier(*goal):
            stops.open_goals[number] = goal
            continue
        was_open = stops.open_goals.get(number) == goal
        stops.settled[number] = goal
        if not was_open or inside(robot.map.boundary, *goal):
            yield Send(StopMessage(sender=robot.me.robot, goal=goal), number)


def send_last_stop_signal(robot: FrontierRobot) -> Generator[Action, Outcome, None]:
    """STOP SIGNAL to all: this robot knows no frontier any more that it could reach.

    Sent once after every goal that the robot had, not each time that it hears something new.
    """
    team, options = robot.team, cast(SelfBiddingOptions, robot.options)
    if team.is_alone or not options.stop_signals or team.stops.ended_s >= robot.course.set_out_s:
        return
    team.stops.ended_s = robot.time_s
    yield Send(StopMessage(sender=robot.me.robot))
