"""Motions of a car inside a region that is known to be free (MOVE_TO of Multi-SRT).

The shortest curve is tried first. Where it leaves the region, a sampling-based planner searches
the car's state space: RRT-Connect, or RRT for a car that cannot reverse and so can only be planned
for from its start. Planning is bounded by a count and not by time, and is thus deterministic.
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
from multisrt.planners.motion.curves import curve_length, curves_of, set_state, state_space
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.room import Room
from multisrt.planners.motion.trajectory import Trajectory

MAX_CHECKS = 1000
"""Default bound of the motions that a sampling-based plan checks."""

STRIDE = 4.0
"""Maximum length of a motion of a sampling-based plan, in turning radii."""

ARRIVAL_TURNS = tuple(k * math.pi / 4.0 for k in (0, 1, -1, 2, -2, 3, -3, 4))
"""Headings to arrive with at a place, relative to its direction; the first is preferred."""

MAX_PLANS = 2
"""Bounds the headings at a place for which a sampling-based plan is made."""

FIRST_SHARES = (0.5, 0.25, 0.75)
"""Where curves are tested first, as shares of them: most that do not fit are ruled out there."""

MAX_SEED = 2**31 - 1
"""Maximum seed of OMPL; the minimum is 1."""


class Checks:
    """The motions that sampling-based plans may still check; plans count them down.

    Parameters
    ----------
    left : int
        Their number.
    """

    def __init__(self, left: int = MAX_CHECKS) -> None:
        self._left = left

    @property
    def are_used_up(self) -> bool:
        """Whether none are left."""
        return self._left <= 0

    def use_one(self) -> bool:
        """Count one down, and return whether it was left."""
        self._left -= 1
        return self._left >= 0


def car_trajectory(
    body: PlanningBody,
    car: Car,
    region: FloatArray | BaseGeometry,
    start: Configuration,
    goal: Configuration,
    seed: int,
    *,
    checks: Checks | None = None,
) -> Trajectory | None:
    """Return a motion from one configuration to another inside a region.

    Parameters
    ----------
    body, car
        The body that moves, and its kinematics.
    region : (n, 2) array or shapely geometry
        Space known to be free in metres: a ring without holes, or one or more polygons.
    start, goal : Configuration
        Ends of the motion.
    seed : int
        Seed of the sampling-based planner, 0 or more.
    checks : Checks, optional
        The motions that the planner may check, which it counts down. Default:
        ``Checks(MAX_CHECKS)``.

    Returns
    -------
    Trajectory or None
        Arcs and straight lines that end exactly at the goal; None if no motion was found.

    Examples
    --------
    >>> import numpy as np
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> body = PlanningBody(Footprint.parse("box:0.6x0.4"), margin_m=0.05)
    >>> hall = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [0.0, 4.0]])
    >>> start, goal = Configuration(1.0, 2.0, 0.0), Configuration(5.0, 2.0, 0.0)
    >>> round(car_trajectory(body, Car(), hall, start, goal, seed=1).length_m, 6)
    4.0
    """
    room = body.room(_rings(region), start, goal)
    if room is None:
        return None
    return shortest_curve(car, room, start, goal) or _planned(
        car, room, start, goal, seed, Checks() if checks is None else checks
    )


def shortest_curves(
    body: PlanningBody,
    car: Car,
    region: FloatArray | BaseGeometry,
    start: Configuration,
    goal: Configuration,
) -> tuple[Trajectory, Trajectory] | None:
    """Return the shortest curves from one configuration to another and back inside a region.

    Parameters
    ----------
    body, car
        The body that moves, and its kinematics.
    region : (n, 2) array or shapely geometry
        Space known to be free in metres: a ring without holes, or one or more polygons.
    start, goal : Configuration
        Ends of the motions.

    Returns
    -------
    (there, back) or None
        None if there is no room for one of them.
    """
    room = body.room(_rings(region), start, goal)
    if room is None:
        return None
    there = shortest_curve(car, room, start, goal)
    if there is None:
        return None
    back = shortest_curve(car, room, goal, start)
    return None if back is None else (there, back)


def car_out_and_back(
    body: PlanningBody,
    car: Car,
    region: FloatArray | BaseGeometry,
    start: Configuration,
    x: float,
    y: float,
    seed: int,
    *,
    checks: Checks | None = None,
) -> tuple[Trajectory, Trajectory] | None:
    """Return a motion to a place and one back, both inside a region.

    The car arrives with the heading of the place's direction if it can, else with another, the
    shortest motion first. It never enters a place that it could not leave.

    Parameters
    ----------
    body, car
        The body that moves, and its kinematics.
    region : (n, 2) array or shapely geometry
        Space known to be free in metres: a ring without holes, or one or more polygons.
    start : Configuration
        Configuration of the car.
    x, y : float
        The place in metres.
    seed : int
        Seed of the sampling-based planner, 0 or more.
    checks : Checks, optional
        The motions that sampling-based plans may check, which they count down. If none are left,
        only shortest curves are tried. Default: ``Checks(MAX_CHECKS)``.

    Returns
    -------
    (out, back) or None
        `back` begins at the end of `out` and ends at the start with its heading. A car that can
        reverse returns on the path it came.
    """
    room = body.room(_rings(region), start)
    if room is None:
        return None
    found: list[tuple[Configuration, Trajectory | None, Trajectory | None]] = []
    for goal in _goals(car, start, x, y):
        if not room.holds(goal):
            continue
        out = shortest_curve(car, room, start, goal)
        back = _back(out) if car.reverse else shortest_curve(car, room, goal, start)
        if out is not None and back is not None:
            return out, back
        found.append((goal, out, back))
    # Headings for which one direction is known already come first.
    found.sort(key=lambda known: known[1] is None and known[2] is None)
    checks = Checks() if checks is None else checks
    for goal, out, back in found[:MAX_PLANS]:
        out = out or _planned(car, room, start, goal, seed, checks)
        if car.reverse:
            back = _back(out)
        elif out is not None and back is None:
            back = _planned(car, room, goal, start, seed, checks)
        if out is not None and back is not None:
            return out, back
    return None


def _rings(region: FloatArray | BaseGeometry) -> FloatArray:
    return rings_of(region) if isinstance(region, BaseGeometry) else region


def _goals(car: Car, start: Configuration, x: float, y: float) -> list[Configuration]:
    """Return the configurations to arrive in: straight on first, then by length of the curve."""
    along = math.atan2(y - start.y, x - start.x)
    ahead, *others = (Configuration(x, y, wrap_angle(along + turn)) for turn in ARRIVAL_TURNS)
    return [ahead, *sorted(others, key=lambda goal: curve_length(car, start, goal))]


def _back(out: Trajectory | None) -> Trajectory | None:
    return None if out is None else out.reversed()


def shortest_curve(
    car: Car, room: Room, start: Configuration, goal: Configuration
) -> Trajectory | None:
    """Return the motion along a car's shortest curve; None if there is no room for it."""
    curves = curves_of(car.reverse, car.turning_radius_m)
    if not all(map(room.holds, curves.between(start, goal, FIRST_SHARES))):
        return None
    motion = curves.curve(start, goal, car.speed_m_s)
    return motion if room.lets_pass(motion.waypoints) else None


def _planned(
    car: Car,
    room: Room,
    start: Configuration,
    goal: Configuration,
    seed: int,
    checks: Checks,
) -> Trajectory | None:
    """Return a sampling-based plan in the car's state space, shortened where possible."""
    # An iteration counts as well, as it may check no motion.
    if not checks.use_one():
        return None
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed % MAX_SEED + 1)
    space = state_space(car.reverse, car.turning_radius_m)
    x0, y0, x1, y1 = room.bounds
    bounds = base.RealVectorBounds(2)
    for axis, (low, high) in enumerate(((x0, x1), (y0, y1))):
        bounds.setLow(axis, low)
        bounds.setHigh(axis, high)
    space.setBounds(bounds)
    information = base.SpaceInformation(space)

    def lets_pass(first: Any, last: Any) -> bool:
        checks.use_one()
        a, b = _configuration(first), _configuration(last)
        return room.holds(b) and shortest_curve(car, room, a, b) is not None

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
    planner.solve(base.PlannerTerminationCondition(lambda: not checks.use_one()))
    if not problem.hasExactSolution():
        return None
    path = problem.getSolutionPath()
    stops = [_configuration(state) for state in path.getStates()]
    return _joined(car, room, [start, *stops[1:-1], goal])


@lru_cache(maxsize=1)
def _motion_validator() -> Any:
    # Made when needed, as OMPL is slow to import.
    from ompl import base

    class MotionValidator(base.MotionValidator):  # type: ignore[misc]
        """Checks whole motions by a function, where OMPL's own checks points of them."""

        def __init__(self, information: Any, lets_pass: Callable[[Any, Any], bool]) -> None:
            super().__init__(information)
            self.lets_pass = lets_pass

        def checkMotion(self, first: Any, last: Any) -> bool:
            """Whether the motion between two states is free."""
            return self.lets_pass(first, last)

    return MotionValidator


def _joined(car: Car, room: Room, stops: list[Configuration]) -> Trajectory | None:
    """Return the motion along stops, without those that a shortest curve can skip.

    OMPL's curves between stops differ from ours by rounding; None where that matters.
    """
    motion: Trajectory | None = None
    here = 0
    while here < len(stops) - 1:
        for there in range(len(stops) - 1, here, -1):
            leg = shortest_curve(car, room, stops[here], stops[there])
            if leg is not None:
                break
        if leg is None:
            return None
        motion = leg if motion is None else motion.then(leg)
        here = there
    return motion


def _configuration(state: Any) -> Configuration:
    return Configuration(state.getX(), state.getY(), state.getYaw())
