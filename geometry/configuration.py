"""Where a body is: position and heading in the plane."""

import math
from typing import NamedTuple


class Configuration(NamedTuple):
    """Position in metres and heading in radians, counter-clockwise from +x."""

    x: float
    y: float
    heading: float = 0.0

    def distance(self, other: "Configuration") -> float:
        """Euclidean distance between two positions in metres."""
        return math.hypot(other.x - self.x, other.y - self.y)


def wrap_angle(angle_rad: float) -> float:
    """Bring an angle into (-pi, pi]."""
    wrapped = math.remainder(angle_rad, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped
