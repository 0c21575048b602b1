"""Areas that a robot's own map leaves open."""

from __future__ import annotations

from multisrt.geometry.grids.unknown_area import unknown_areas
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.robots.frontier.robot import FrontierRobot


def areas_beyond(robot: FrontierRobot, targets: FloatArray) -> FloatArray:
    """Return the unknown areas that would be seen from targets, ``(m,)`` square metres."""
    cell_m = robot.raster.cell_m
    cells = unknown_areas(robot.raster.cells, robot.indices_of(targets), robot.me.range_m / cell_m)
    areas: FloatArray = cells * cell_m**2
    return areas
