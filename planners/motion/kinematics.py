"""How bodies can move: holonomic and differential drives and cars, with their limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.trajectory import Trajectory, Waypoint


@dataclass(frozen=True, slots=True, kw_only=True)
class Holonomic:
    """A body that drives straight in any direction and keeps its heading.

    Attributes
    ----------
    speed_m_s : float
        Its greatest speed.
    """

    speed_m_s: float = 0.5

    def __post_init__(self) -> None:
        _require_positive("speed_m_s", self.speed_m_s)

    def drive(self, start: Configuration, x: float, y: float) -> Trajectory:
        """Drive straight to a place."""
        return _straight(start, x, y, start.heading, self.speed_m_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Differential:
    """A body that turns in place and drives along its heading, forwards or backwards.

    Attributes
    ----------
    speed_m_s : float
        Its greatest speed.
    turn_rate_rad_s : float
        Its greatest rate of turning.
    """

    speed_m_s: float = 0.5
    turn_rate_rad_s: float = math.pi / 2

    def __post_init__(self) -> None:
        _require_positive("speed_m_s", self.speed_m_s)
        _require_positive("turn_rate_rad_s", self.turn_rate_rad_s)

    def turn(self, start: Configuration, turn_rad: float) -> Trajectory:
        """Turn in place by a signed angle."""
        x, y, heading = start
        begin = Waypoint(0.0, x, y, heading)
        if turn_rad == 0.0:
            return Trajectory((begin,))
        duration = abs(turn_rad) / self.turn_rate_rad_s
        return Trajectory((begin, Waypoint(duration, x, y, heading + turn_rad)))

    def drive(self, start: Configuration, x: float, y: float) -> Trajectory:
        """Drive straight to a place that lies along the heading or right behind."""
        return _straight(start, x, y, start.heading, self.speed_m_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Car:
    """A body that steers as a car does: along its heading, in curves that are not too tight.

    Attributes
    ----------
    speed_m_s : float
        Its greatest speed, forwards and backwards.
    turning_radius_m : float
        Radius of its tightest curve.
    reverse : bool
        Whether it can drive backwards: its shortest ways are Reeds-Shepp's curves, or else
        Dubins's.
    """

    speed_m_s: float = 0.5
    turning_radius_m: float = 0.6
    reverse: bool = True

    def __post_init__(self) -> None:
        _require_positive("speed_m_s", self.speed_m_s)
        _require_positive("turning_radius_m", self.turning_radius_m)


Kinematics = Holonomic | Differential | Car


def turns_between(heading: float, wanted: float) -> tuple[float, float]:
    """Give the two signed turns from one heading to another, the shorter one first."""
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
