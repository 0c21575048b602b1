"""What a number of beams shows: its bounds, and how far space is surely free between two beams."""

from __future__ import annotations

import math
from typing import Final

MIN_BEAMS: Final = 5
"""Minimum number of beams from which a region can be made."""

MIN_CORNER_RAD: Final = math.radians(45.0)
"""Minimum angle in radians of the corners of obstacles that may stand between two beams."""


def sure_reach(range_m: float, beams: int) -> float:
    """Return the distance in metres that is surely free between two beams that hit nothing.

    Parameters
    ----------
    range_m : float
        Range of the laser in metres.
    beams : int
        Number of its beams around the full circle.

    Returns
    -------
    float
        0 or less for beams so few that no space around the robot is surely free.

    Examples
    --------
    >>> round(sure_reach(4.0, 360), 3), round(sure_reach(4.0, 14), 3)
    (3.916, 1.751)
    """
    half = math.pi / beams
    return range_m * (math.cos(half) - math.sin(half) / math.tan(0.5 * MIN_CORNER_RAD))
