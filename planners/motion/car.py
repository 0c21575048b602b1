"""Ways of a car inside a region that it knows to be free (MOVE_TO of Multi-SRT).

First the shortest curve. Where it leaves the region, a plan by sampling in the car's own state
space: by RRT-Connect, or by RRT for a car that cannot reverse, which can only be planned for
forwards from its start. It ends on a count and not on a clock, and so repeats.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.clearance import rings_of
from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.curves import curve, curve_length, set_state, state_space
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.room import Room
from multisrt.planners.motion.trajectory import Trajectory

MOST_CHECKS = 1000
"""After so many motions that were looked at, a plan by sampling is given up."""

STRIDE = 4.0
"""The longest motion of a plan by sampling, in turning radii."""

FAN = tuple(k * math.pi / 4.0 for k in (0, 1, -1, 2, -2, 3, -3, 4))
"""Headings at a place, from the direction in which it lies; the first is tried first."""

MOST_PLANS = 2
"""For so many headings at a place a way is planned by sampling."""

MOST_SEED = 2**31 - 1
"""Seeds of OMPL lie between 1 and this."""


def car_way(
    body: PlanningBody,
    car: Car,
    region: FloatArray | BaseGeometry,
    start: Configuration,
    goal: Configuration,
    seed: int,
    *,
    most_checks: int = MOST_CHECKS,
) -> Trajectory | None:
    """Plan a way from one configuration to another inside a region.

    Parameters
    ----------
    body, car
        What moves, and how.
    region : (n, 2) array or shapely geometry
        What is known to be free: a ring without holes, or a polygon, or several.
    start, goal : Configuration
        Where from and to.
    seed : int
        Of the plan by sampling.
    most_checks : int
        How many motions a plan by sampling may look at; 0: the shortest curve or nothing.

    Returns
    -------
    Trajectory or None
        Arcs and straight pieces that end exactly at the goal; None if no way was found.
    """
    room = body.room(_rings(region), start, goal)
    if room is None:
        return None
    return shortest_way(car, room, start, goal) or _planned(
        car, room, start, goal, seed, _Budget(most_checks)
    )


def car_ways(
    body: PlanningBody,
    car: Car,
    region: FloatArray | BaseGeometry,
    start: Configuration,
    x: float,
    y: float,
    seed: int,
    *,
    most_checks: int = MOST_CHECKS,
) -> tuple[Trajectory, Trajectory] | None:
    """Plan a way to a place, and one back from there, both inside a region.

    The car gets there in the direction in which the place lies, if it can, or else in another
    one, the shortest way first. It never enters a place that it could not leave.

    Parameters
    ----------
    body, car
        What moves, and how.
    region : (n, 2) array or shapely geometry
        What is known to be free: a ring without holes, or a polygon, or several.
    start : Configuration
        Where the car is.
    x, y : float
        The place.
    seed : int
        Of the plans by sampling.
    most_checks : int
        How many motions all plans by sampling together may look at; 0: shortest curves only.

    Returns
    -------
    (out, back) or None
        `back` begins where `out` ends, and ends at the start with its heading. A car that can
        reverse comes back on the way on which it went.
    """
    room = body.room(_rings(region), start)
    if room is None:
        return None
    found: list[tuple[Configuration, Trajectory | None, Trajectory | None]] = []
    for goal in _goals(car, start, x, y):
        if not room.holds(goal):
            continue
        out = shortest_way(car, room, start, goal)
        back = _back(out) if car.reverse else shortest_way(car, room, goal, start)
        if out is not None and back is not None:
            return out, back
        found.append((goal, out, back))
    # Those first of which half is known.
    found.sort(key=lambda ways: ways[1] is None and ways[2] is None)
    budget = _Budget(most_checks)
    for goal, out, back in found[:MOST_PLANS]:
        out = out or _planned(car, room, start, goal, seed, budget)
        if car.reverse:
            back = _back(out)
        elif out is not None and back is None:
            back = _planned(car, room, goal, start, seed, budget)
        if out is not None and back is not None:
            return out, back
    return None


def _rings(region: FloatArray | BaseGeometry) -> FloatArray:
    return rings_of(region) if isinstance(region, BaseGeometry) else region


def _goals(car: Car, start: Configuration, x: float, y: float) -> list[Configuration]:
    # At a place: straight on first, then other headings, the shortest way first.
    along = math.atan2(y - start.y, x - start.x)
    ahead, *others = (Configuration(x, y, wrap_angle(along + turn)) for turn in FAN)
    return [ahead, *sorted(others, key=lambda goal: curve_length(car, start, goal))]


def _back(out: Trajectory | None) -> Trajectory | None:
    return None if out is None else out.reversed()


def shortest_way(
    car: Car, room: Room, start: Configuration, goal: Configuration
) -> Trajectory | None:
    """Give the motion along a car's shortest curve, if there is room for it."""
    way = curve(car, start, goal)
    return way if room.lets_pass(way.waypoints) else None


class _Budget:
    """How many motions plans by sampling may still look at."""

    def __init__(self, checks: int) -> None:
        self.left = checks

    def is_used_up(self) -> bool:
        # An iteration counts as well: there may be some that look at no motion.
        self.left -= 1
        return self.left < 0


def _planned(
    car: Car,
    room: Room,
    start: Configuration,
    goal: Configuration,
    seed: int,
    budget: _Budget,
) -> Trajectory | None:
    """Plan by sampling in the car's state space, and cut short what can be of the plan."""
    if budget.is_used_up():
        return None
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed % MOST_SEED + 1)
    space = state_space(car.reverse, car.turning_radius_m)
    x0, y0, x1, y1 = room.bounds
    bounds = base.RealVectorBounds(2)
    for axis, (low, high) in enumerate(((x0, x1), (y0, y1))):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    space.setBounds(bounds)
    information = base.SpaceInformation(space)

    def lets_pass(first: Any, last: Any) -> bool:
        budget.left -= 1
        a, b = _configuration(first), _configuration(last)
        return room.holds(b) and shortest_way(car, room, a, b) is not None

    information.setStateValidityChecker(lambda state: room.holds(_configuration(state)))
    information.setMotionValidator(_motion_validator()(information, lets_pass))
    information.setup()
    first, last = space.allocState(), space.allocState()
    set_state(first, start)
    set_state(last, goal)
    problem = base.ProblemDefinition(information)
    problem.setStartAndGoalStates(first, last)
    planner = (geometric.RRTConnect if car.reverse else geometric.RRT)(information)
    planner.setRange(STRIDE * car.turning_radius_m)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(base.PlannerTerminationCondition(budget.is_used_up))
    if not problem.hasExactSolution():
        return None
    path = problem.getSolutionPath()
    stops = [_configuration(state) for state in path.getStates()]
    return _joined(car, room, [start, *stops[1:-1], goal])


@lru_cache(maxsize=1)
def _motion_validator() -> Any:
    # A class of OMPL's can only be derived from where OMPL is imported.
    from ompl import base

    class MotionValidator(base.MotionValidator):  # type: ignore[misc]
        """Asks a function about whole motions, where OMPL's own would look at points of them."""

        def __init__(self, information: Any, lets_pass: Callable[[Any, Any], bool]) -> None:
            super().__init__(information)
            self.lets_pass = lets_pass

        def checkMotion(self, first: Any, last: Any) -> bool:
            """Whether the motion between two states is free."""
            return self.lets_pass(first, last)

    return MotionValidator


def _joined(car: Car, room: Room, stops: list[Configuration]) -> Trajectory | None:
    """Go from stop to stop, leaving out all those that a shortest curve can pass by.

    OMPL moves from stop to stop by its own copies of the curves, which differ from ours by
    rounding: None where that matters.
    """
    way: Trajectory | None = None
    here = 0
    while here < len(stops) - 1:
        for there in range(len(stops) - 1, here, -1):
            leg = shortest_way(car, room, stops[here], stops[there])
            if leg is not None:
                break
        if leg is None:
            return None
        way = leg if way is None else way.then(leg)
        here = there
    return way


def _configuration(state: Any) -> Configuration:
    return Configuration(state.getX(), state.getY(), state.getYaw())
