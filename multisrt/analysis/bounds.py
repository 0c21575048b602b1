"""Lower bounds of the time that an exploration takes."""

from __future__ import annotations

import math

import numpy as np
import shapely

from multisrt.analysis.explorable import Explorable
from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.distance_field import distance_field
from multisrt.geometry.grids.raster import Raster, paint_polygon
from multisrt.spec import RunSpec

CELL_M = 0.1
"""Width of the cells on which paths are measured, in metres."""

RASTER_SHARE = 0.99
"""A path length measured on the raster is at most 1 % and one cell longer than the true one."""


def lower_bounds(
    spec: RunSpec, environment: Environment, what: Explorable, starts: tuple[Configuration, ...]
) -> tuple[float, float]:
    """Return two times below which no exploration of a world by a team can end.

    Parameters
    ----------
    spec : RunSpec
        The team.
    environment : Environment
        The world.
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
    farthest = RASTER_SHARE * farthest_m(environment, starts) - CELL_M
    seen_at_once = len(set(starts)) * math.pi * range_m**2
    area = what.area_m2 - seen_at_once
    return (
        max(0.0, farthest - range_m) / speed,
        max(0.0, area) / (2.0 * range_m * speed * len(spec.robots)),
    )


def farthest_m(environment: Environment, starts: tuple[Configuration, ...]) -> float:
    """Return the largest path length from the nearest start to a free cell, in metres."""
    raster = Raster(CELL_M, environment.bounds)
    for part in environment.free.geoms:
        raster.paint_inside(shapely.get_coordinates(part.exterior))
    for part in environment.free.geoms:
        for ring in part.interiors:
            hole = np.zeros_like(raster.cells)
            paint_polygon(shapely.get_coordinates(ring), raster.x0, raster.y0, CELL_M, hole)
            raster.cells &= ~hole
    sources = [(start.x, start.y) for start in starts]
    for x, y in sources:
        raster.cells[math.floor((y - raster.y0) / CELL_M), math.floor((x - raster.x0) / CELL_M)] = (
            True
        )
    field = distance_field(raster.cells, CELL_M, sources, x0=raster.x0, y0=raster.y0)
    return float(np.max(field[np.isfinite(field)], initial=0.0))
