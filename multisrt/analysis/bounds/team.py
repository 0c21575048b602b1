"""The properties of a robot that the bounds need."""

from __future__ import annotations

import math
from typing import NamedTuple, Self

from multisrt.geometry.configuration import Configuration
from multisrt.spec import RobotSpec


class Member(NamedTuple):
    """A robot of a team.

    Attributes
    ----------
    start : (x, y)
        Where it starts, in metres.
    speed_m_s : float
        The maximum speed of its reference point.
    range_m : float
        The range of its range finder.
    spread_m : float
        Maximum distance of a point that its range finder shows to be free from one that it sees:
        0 for the exact visibility polygon. The region between two neighbouring beams of a laser
        is the triangle of its place and one point on each beam; a point of it is an average of
        the place and the ends of the triangle, so that one on the longer beam, as far along it,
        is away from it by at most the chord of the beams' angle at the range.
    """

    start: tuple[float, float]
    speed_m_s: float
    range_m: float
    spread_m: float

    @classmethod
    def of(cls, robot: RobotSpec, start: Configuration) -> Self:
        """Return a robot as it is specified, at its start."""
        finder = robot.range_finder
        angle = 2.0 * math.pi / finder.beams if finder.beams else 0.0
        return cls(
            start=(start.x, start.y),
            speed_m_s=robot.drive.speed_m_s,
            range_m=finder.range_m,
            spread_m=2.0 * finder.range_m * math.sin(0.5 * angle),
        )
