"""Shortest curves of a car without obstacles: Reeds-Shepp and Dubins curves, by OMPL.

OMPL returns points of a curve but not its pieces. Here the arcs and straight lines are recovered
from such points, so that the curve becomes an exact trajectory.

Source: Reeds and Shepp 1990, Dubins 1957, as in OMPL's state spaces of these names.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.geometry.numerics.kernel import kernel
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.trajectory import Trajectory, Waypoint, leg_pose

CLOSE = 1e-7
"""Tolerance of a piece against OMPL's points, in metres and radians; OMPL rounds by 1e-6."""

MIN_PIECE_M = 1e-6
"""Pieces of a curve shorter than this are left out, in metres."""

MAX_ARC_RAD = 0.5 * math.pi
"""Longer arcs become several legs of a trajectory."""

COARSE_RAD = 1.0
"""Maximum spacing of the first points taken of a curve, as an angle of its arcs in radians."""


class Curves:
    """The shortest curves of one kind of car.

    Parameters
    ----------
    reverse : bool
        Whether the car can drive backwards.
    radius_m : float
        Minimum turning radius in metres.
    """

    def __init__(self, reverse: bool, radius_m: float) -> None:
        self.radius_m = radius_m
        self._space = state_space(reverse, radius_m)
        self._from, self._to, self._on = (self._space.allocState() for _ in range(3))

    def length(self, start: Configuration, goal: Configuration) -> float:
        """Return the length of the shortest curve in metres."""
        set_state(self._from, start)
        set_state(self._to, goal)
        return float(self._space.distance(self._from, self._to))

    def between(
        self, start: Configuration, goal: Configuration, shares: Iterable[float]
    ) -> Iterator[Configuration]:
        """Yield where the car is at shares of the shortest curve, up to OMPL's rounding."""
        set_state(self._from, start)
        set_state(self._to, goal)
        for share in shares:
            yield Configuration(*self._pose_at(share))

    def curve(self, start: Configuration, goal: Configuration, speed_m_s: float) -> Trajectory:
        """Return the motion along the shortest curve; its last waypoint is exactly the goal."""
        waypoints = [Waypoint(0.0, *start)]
        if start == goal:
            return Trajectory(tuple(waypoints))
        for x, y, turn, length in self._pieces(start, goal).tolist():
            a = waypoints[-1]
            waypoints += _legs(a, x, y, turn, length / speed_m_s)
        last = waypoints.pop()
        heading = last.heading + math.remainder(goal.heading - last.heading, 2.0 * math.pi)
        waypoints.append(Waypoint(last.time_s, goal.x, goal.y, heading))
        return Trajectory(tuple(waypoints))

    def _pieces(self, start: Configuration, goal: Configuration) -> FloatArray:
        length = self.length(start, goal)
        if length < MIN_PIECE_M:
            return np.array([(goal.x, goal.y, 0.0, length)])
        count = max(6, math.ceil(length / (COARSE_RAD * self.radius_m)))
        shares = [k / count for k in range(count + 1)]
        points = [(share * length, *self._pose_at(share)) for share in shares]
        while True:
            pieces, unclear = _pieces_of(np.array(points), self.radius_m)
            if not unclear.any():
                return pieces
            # Bisect the intervals that may hold more than one piece.
            for k in np.flatnonzero(unclear)[::-1].tolist():
                middle = 0.5 * (points[k][0] + points[k + 1][0]) / length
                points.insert(k + 1, (middle * length, *self._pose_at(middle)))

    def _pose_at(self, share: float) -> tuple[float, float, float]:
        self._space.interpolate(self._from, self._to, share, self._on)
        return self._on.getX(), self._on.getY(), self._on.getYaw()


@lru_cache(maxsize=16)
def curves_of(reverse: bool, radius_m: float) -> Curves:
    """Return the curves of one kind of car, made at the first call."""
    return Curves(reverse, radius_m)


def curve(car: Car, start: Configuration, goal: Configuration) -> Trajectory:
    """Return the motion along a car's shortest curve without obstacles.

    Parameters
    ----------
    car : Car
        The car.
    start, goal : Configuration
        Ends of the curve.

    Returns
    -------
    Trajectory
        Arcs of the minimum turning radius and straight lines, driven at maximum speed. The last
        waypoint is exactly the goal.

    Examples
    --------
    >>> motion = curve(Car(), Configuration(0.0, 0.0, 0.0), Configuration(2.0, 0.0, 0.0))
    >>> round(motion.length_m, 9), len(motion.waypoints)
    (2.0, 2)
    """
    return curves_of(car.reverse, car.turning_radius_m).curve(start, goal, car.speed_m_s)


def curve_length(car: Car, start: Configuration, goal: Configuration) -> float:
    """Return the length in metres of a car's shortest curve without obstacles.

    Parameters
    ----------
    car : Car
        The car.
    start, goal : Configuration
        Ends of the curve.

    Returns
    -------
    float

    Examples
    --------
    >>> start, goal = Configuration(0.0, 0.0, 0.0), Configuration(0.0, 1.2, math.pi)
    >>> round(curve_length(Car(turning_radius_m=0.6), start, goal), 3)  # half a circle
    1.885
    """
    return curves_of(car.reverse, car.turning_radius_m).length(start, goal)


def state_space(reverse: bool, radius_m: float) -> Any:
    """Return OMPL's state space of a car."""
    from ompl import base

    return base.ReedsSheppStateSpace(radius_m) if reverse else base.DubinsStateSpace(radius_m)


def set_state(state: Any, configuration: Configuration) -> None:
    """Assign a configuration to a state of OMPL, whose headings are less than pi."""
    state.setX(configuration.x)
    state.setY(configuration.y)
    state.setYaw(configuration.heading if configuration.heading < math.pi else -math.pi)


def _legs(a: Waypoint, x: float, y: float, turn: float, duration_s: float) -> list[Waypoint]:
    """Return an arc or straight line from a waypoint on as legs of at most `MAX_ARC_RAD`."""
    b = Waypoint(a.time_s + duration_s, x, y, a.heading + turn)
    count = max(1, math.ceil(abs(turn) / MAX_ARC_RAD - CLOSE))
    inner = [
        Waypoint(a.time_s + k / count * duration_s, *leg_pose(a, b, k / count))
        for k in range(1, count)
    ]
    return [*inner, b]


@kernel
def _pieces_of(points: FloatArray, radius: float) -> tuple[FloatArray, BoolArray]:
    """Split a curve into its pieces.

    Parameters
    ----------
    points : (n, 4) array
        Distance along the curve, x, y and heading of points on it, including both ends.
    radius : float
        Radius of its arcs in metres.

    Returns
    -------
    pieces : (m, 4) array
        x and y of the end, signed turn and length of every piece.
    unclear : (n - 1,) array of bool
        Intervals between points that need more points; if there are any, the pieces are invalid.
    """
    n = points.shape[0] - 1
    turning, driving = np.empty(n), np.empty(n)
    for i in range(n):
        turning[i], driving[i] = _piece_between(points[i], points[i + 1], radius)
    unclear = np.zeros(n, np.bool_)
    pieces = np.empty((n + 1, 4))
    count = 0
    begun = 0.0
    i = 0
    while i < n and driving[i] == 0.0 and points[i + 1, 0] < MIN_PIECE_M:
        i += 1
    if driving[min(i, n - 1)] == 0.0:
        unclear[: i + 1] = True
    while i < n and driving[i] != 0.0:
        # One piece: intervals of the same kind up to k, then unclear ones up to `following`.
        k = i + 1
        while k < n and driving[k] == driving[i] and turning[k] == turning[i]:
            k += 1
        following = k
        while following < n and driving[following] == 0.0:
            following += 1
        x, y, end = points[k, 1], points[k, 2], points[k, 0]
        if following > k and points[following, 0] - points[k, 0] >= MIN_PIECE_M:
            switch = -1.0
            if following < n:
                switch = _switch(
                    points[k],
                    points[following],
                    radius,
                    turning[i],
                    driving[i],
                    turning[following],
                    driving[following],
                )
            if switch < 0.0:
                unclear[k:following] = True
            else:
                x, y, _ = _moved(
                    points[k, 1],
                    points[k, 2],
                    points[k, 3],
                    turning[i],
                    driving[i] * switch,
                    radius,
                )
                end = points[k, 0] + switch
        elif following == n:
            x, y, end = points[n, 1], points[n, 2], points[n, 0]
        length = end - begun
        pieces[count, 0], pieces[count, 1] = x, y
        pieces[count, 2] = turning[i] * driving[i] * length / radius
        pieces[count, 3] = length
        count += 1
        begun = end
        i = following
    return pieces[:count], unclear


@kernel
def _piece_between(p: FloatArray, q: FloatArray, radius: float) -> tuple[float, float]:
    """Return the kind of piece that two points lie on.

    Returns
    -------
    turning : float
        Steering: 1 to the left, -1 to the right, 0 straight.
    driving : float
        1 forwards, -1 backwards; 0 if the points lie on different pieces.
    """
    length = q[0] - p[0]
    turn = _wrapped(q[3] - p[3])
    ahead = (q[1] - p[1]) * math.cos(p[3] + 0.5 * turn) + (q[2] - p[2]) * math.sin(
        p[3] + 0.5 * turn
    )
    driving = 1.0 if ahead >= 0.0 else -1.0
    if abs(turn) < CLOSE:
        turning = 0.0
    elif abs(abs(turn) - length / radius) < CLOSE:
        turning = driving if turn > 0.0 else -driving
    else:
        return 0.0, 0.0
    x, y, _ = _moved(p[1], p[2], p[3], turning, driving * length, radius)
    if math.hypot(x - q[1], y - q[2]) > CLOSE:
        return 0.0, 0.0
    return turning, driving


@kernel
def _switch(
    p: FloatArray,
    q: FloatArray,
    radius: float,
    turning_a: float,
    driving_a: float,
    turning_b: float,
    driving_b: float,
) -> float:
    """Return the distance from p at which its piece joins that of q; -1 if they do not join."""
    length = q[0] - p[0]
    turn = _wrapped(q[3] - p[3]) * radius
    switch: float
    rate_a, rate_b = turning_a * driving_a, turning_b * driving_b
    if rate_a != rate_b:
        switch = (turn - rate_b * length) / (rate_a - rate_b)
    elif turning_a != 0.0:
        # A cusp with the same turn rate on both sides: where the two circles touch.
        ax = p[1] - turning_a * radius * math.sin(p[3])
        ay = p[2] + turning_a * radius * math.cos(p[3])
        bx = q[1] - turning_b * radius * math.sin(q[3])
        by = q[2] + turning_b * radius * math.cos(q[3])
        heading = math.atan2(turning_a * (bx - ax), turning_a * (ay - by))
        switch = _wrapped(heading - p[3]) * radius * rate_a
    else:
        return -1.0
    if not -CLOSE <= switch <= length + CLOSE:
        return -1.0
    switch = min(max(switch, 0.0), length)
    x, y, heading = _moved(p[1], p[2], p[3], turning_a, driving_a * switch, radius)
    x, y, heading = _moved(x, y, heading, turning_b, driving_b * (length - switch), radius)
    if max(abs(x - q[1]), abs(y - q[2]), abs(_wrapped(heading - q[3]))) > CLOSE:
        return -1.0
    return switch


@kernel
def _moved(
    x: float, y: float, heading: float, turning: float, distance: float, radius: float
) -> tuple[float, float, float]:
    """Return x, y and heading after a signed distance on an arc or straight line."""
    turn = turning * distance / radius
    chord = distance
    if turn != 0.0:
        chord = 2.0 * radius * turning * math.sin(0.5 * turn)
    return (
        x + chord * math.cos(heading + 0.5 * turn),
        y + chord * math.sin(heading + 0.5 * turn),
        heading + turn,
    )


@kernel
def _wrapped(angle: float) -> float:
    # As `wrap_angle`, for kernels: to [-pi, pi), and rounded differently.
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)
