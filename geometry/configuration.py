"""Configurations of a body in the plane: position and heading."""

import math
from typing import NamedTuple


class Configuration(NamedTuple):
    """Position and heading of a body's reference point.

    Attributes
    ----------
    x, y : float
        Position in metres.
    heading : float
        Angle in radians, counter-clockwise from +x.

    Examples
    --------
    >>> here = Configuration(1.0, 2.0)
    >>> here.heading
    0.0
    >>> here.distance(Configuration(4.0, 6.0, 1.5))
    5.0
    """

    x: float
    y: float
    heading: float = 0.0

    def distance(self, other: "Configuration") -> float:
        """Return the Euclidean distance between two positions in metres."""
        return math.hypot(other.x - self.x, other.y - self.y)


def wrap_angle(angle_rad: float) -> float:
    """Return the equivalent of an angle in (-pi, pi], in radians.

    Examples
    --------
    >>> round(wrap_angle(3.0 * math.pi / 2.0), 4)
    -1.5708
    >>> wrap_angle(-math.pi) == math.pi
    True
    """
    wrapped = math.remainder(angle_rad, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped
