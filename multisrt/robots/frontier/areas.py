"""Areas that a robot's own map leaves open."""

from __future__ import annotations

from multisrt.geometry.grids.unknown_area import unknown_areas
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.robots.frontier.robot import FrontierRobot


def areas_beyond(robot: FrontierRobot, targets: FloatArray) -> FloatArray:
    """Return the unknown areas that would be seen from targets if all unknown cells were free.

    Parameters
    ----------
    robot : FrontierRobot
        The robot, on whose map the areas are unknown.
    targets : (m, 2) array
        The targets, x and y in metres in the frame of the map.

    Returns
    -------
    (m,) array
        Square metres.
    """
    cell_m = robot.raster.cell_m
    cells = unknown_areas(robot.raster.cells, robot.indices_of(targets), robot.me.range_m / cell_m)
    areas: FloatArray = cells * cell_m**2
    return areas
