"""Kinematics of bodies: holonomic and differential drives and cars, with their limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.trajectory import NO_TURN_RAD, Trajectory, Waypoint


@dataclass(frozen=True, slots=True, kw_only=True)
class Holonomic:
    """A body that drives straight in any direction and keeps its heading.

    Attributes
    ----------
    speed_m_s : float
        Maximum speed in m/s.

    Raises
    ------
    InvalidInputError
        If the speed is not positive and finite.

    Examples
    --------
    >>> Holonomic(speed_m_s=0.5).drive(Configuration(0.0, 0.0, 1.0), 3.0, 4.0).duration_s
    10.0
    """

    speed_m_s: float = 0.5

    def __post_init__(self) -> None:
        _require_positive("speed_m_s", self.speed_m_s)

    def drive(self, start: Configuration, x: float, y: float) -> Trajectory:
        """Return the straight motion to a place at maximum speed.

        Parameters
        ----------
        start : Configuration
            Where the motion begins.
        x, y : float
            The place in metres.

        Returns
        -------
        Trajectory
        """
        return _straight(start, x, y, start.heading, self.speed_m_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Differential:
    """A body that turns in place and drives along its heading, one by one or both at once.

    It drives forwards and backwards.

    Attributes
    ----------
    speed_m_s : float
        Maximum speed in m/s.
    turn_rate_rad_s : float
        Maximum turn rate in rad/s.

    Raises
    ------
    InvalidInputError
        If a limit is not positive and finite.

    Examples
    --------
    >>> drive = Differential(speed_m_s=0.5, turn_rate_rad_s=1.0)
    >>> drive.turn(Configuration(0.0, 0.0, 0.0), -0.5).duration_s
    0.5
    """

    speed_m_s: float = 0.5
    turn_rate_rad_s: float = math.pi / 2

    def __post_init__(self) -> None:
        _require_positive("speed_m_s", self.speed_m_s)
        _require_positive("turn_rate_rad_s", self.turn_rate_rad_s)

    def turn(self, start: Configuration, turn_rad: float) -> Trajectory:
        """Return the turn in place by a signed angle, at the maximum rate.

        Parameters
        ----------
        start : Configuration
            Where the body stands.
        turn_rad : float
            Angle in radians, counter-clockwise positive; may exceed a full turn.

        Returns
        -------
        Trajectory
            A single waypoint for an angle of 0.
        """
        x, y, heading = start
        begin = Waypoint(0.0, x, y, heading)
        if turn_rad == 0.0:
            return Trajectory((begin,))
        duration = abs(turn_rad) / self.turn_rate_rad_s
        return Trajectory((begin, Waypoint(duration, x, y, heading + turn_rad)))

    def drive(self, start: Configuration, x: float, y: float) -> Trajectory:
        """Return the straight motion to a place at maximum speed.

        Parameters
        ----------
        start : Configuration
            Where the motion begins; the place must lie straight ahead or behind.
        x, y : float
            The place in metres.

        Returns
        -------
        Trajectory
        """
        return _straight(start, x, y, start.heading, self.speed_m_s)

    def curve(
        self, start: Configuration, x: float, y: float, *, backwards: bool = False
    ) -> Trajectory | None:
        """Return the motion to a place that turns at the maximum rate, then goes straight.

        The body drives at maximum speed all the way.

        Parameters
        ----------
        start : Configuration
            Where the motion begins.
        x, y : float
            The place in metres.
        backwards : bool
            Whether the body drives backwards.

        Returns
        -------
        Trajectory or None
            None if the place lies inside the turning circle, or if the body would have to turn by
            more than half a circle.

        Examples
        --------
        >>> drive = Differential(speed_m_s=1.0, turn_rate_rad_s=1.0)
        >>> motion = drive.curve(Configuration(0.0, 0.0, 0.0), 1.0, 3.0)
        >>> [tuple(round(number, 3) for number in waypoint[1:]) for waypoint in motion.waypoints]
        [(0.0, 0.0, 0.0), (1.0, 1.0, 1.571), (1.0, 3.0, 1.571)]
        """
        course = start.heading + (math.pi if backwards else 0.0)
        c, s = math.cos(course), math.sin(course)
        side = 1.0 if c * (y - start.y) >= s * (x - start.x) else -1.0
        radius = self.speed_m_s / self.turn_rate_rad_s
        centre_x, centre_y = start.x - side * radius * s, start.y + side * radius * c
        away = math.hypot(x - centre_x, y - centre_y)
        if away <= radius:
            return None
        towards = math.atan2(y - centre_y, x - centre_x) + side * math.asin(radius / away)
        turn = side * ((side * (towards - course)) % (2.0 * math.pi))
        if abs(turn) > 2.0 * math.pi - NO_TURN_RAD:
            turn = 0.0  # straight ahead, but for rounding
        if abs(turn) > math.pi:
            return None
        heading, turned_s = start.heading + turn, abs(turn) / self.turn_rate_rad_s
        end_x = centre_x + side * radius * math.sin(towards)
        end_y = centre_y - side * radius * math.cos(towards)
        straight_s = math.hypot(x - end_x, y - end_y) / self.speed_m_s
        return Trajectory(
            (
                Waypoint(0.0, *start),
                Waypoint(turned_s, end_x, end_y, heading),
                Waypoint(turned_s + straight_s, x, y, heading),
            )
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Car:
    """A body that drives along its heading in curves of limited curvature.

    Attributes
    ----------
    speed_m_s : float
        Maximum speed in m/s, forwards and backwards.
    turning_radius_m : float
        Minimum turning radius in metres.
    reverse : bool
        Whether it can drive backwards. Its shortest paths are Reeds-Shepp curves if so, else
        Dubins curves.

    Raises
    ------
    InvalidInputError
        If the speed or radius is not positive and finite.
    """

    speed_m_s: float = 0.5
    turning_radius_m: float = 0.6
    reverse: bool = True

    def __post_init__(self) -> None:
        _require_positive("speed_m_s", self.speed_m_s)
        _require_positive("turning_radius_m", self.turning_radius_m)


Kinematics = Holonomic | Differential | Car


def turns_between(heading: float, wanted: float) -> tuple[float, float]:
    """Return the two signed turns from one heading to another, the shorter first.

    Parameters
    ----------
    heading, wanted : float
        Headings in radians.

    Returns
    -------
    short, long : float
        Radians; they differ by a full turn.

    Examples
    --------
    >>> short, long = turns_between(0.0, 1.0)
    >>> short, round(long, 3)
    (1.0, -5.283)
    """
    short = wrap_angle(wanted - heading)
    long = short - math.copysign(2.0 * math.pi, short)
    return short, long


def _straight(start: Configuration, x: float, y: float, heading: float, speed: float) -> Trajectory:
    begin = Waypoint(0.0, start.x, start.y, heading)
    distance = math.hypot(x - start.x, y - start.y)
    if distance == 0.0:
        return Trajectory((begin,))
    return Trajectory((begin, Waypoint(distance / speed, x, y, heading)))


def _require_positive(name: str, value: float) -> None:
    if not 0.0 < value < math.inf:
        raise InvalidInputError(f"{name} is a positive, finite number, not {value:g}")
