"""Lower bounds of the time that an exploration takes."""

from __future__ import annotations

import math

from multisrt.analysis.explorable import Explorable
from multisrt.geometry.configuration import Configuration
from multisrt.spec import RunSpec

RASTER_SHARE = 0.99
"""A path length measured on the raster is at most 1 % and one cell longer than the true one."""


def lower_bounds(
    spec: RunSpec, what: Explorable, starts: tuple[Configuration, ...]
) -> tuple[float, float]:
    """Return two times below which no exploration of a world by a team can end.

    Parameters
    ----------
    spec : RunSpec
        The team.
    what : Explorable
        What it can explore.
    starts : tuple of Configuration
        Where its robots start.

    Returns
    -------
    reach_s : float
        Time to come within range of the point that is farthest from its nearest start, at the
        speed and with the range of the best robot.
    area_s : float
        Time to sweep the area: each robot covers a strip as wide as twice the range, at its
        speed, after one disc around each distinct start.
    """
    speed = max(robot.drive.speed_m_s for robot in spec.robots)
    range_m = max(robot.range_finder.range_m for robot in spec.robots)
    farthest = RASTER_SHARE * what.farthest_m(*starts) - what.raster.cell_m
    seen_at_once = len(set(starts)) * math.pi * range_m**2
    area = what.area_m2 - seen_at_once
    return (
        max(0.0, farthest - range_m) / speed,
        max(0.0, area) / (2.0 * range_m * speed * len(spec.robots)),
    )
