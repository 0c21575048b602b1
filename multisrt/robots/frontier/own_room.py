"""Map sense: the room that a robot is in, on its own map."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from multisrt.geometry.grids.rooms import room_around
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.robots.frontier.robot import FrontierRobot

DOORWAY_M: Final = 0.7
"""Half the width of the widest doorway in metres."""

SPAN_M: Final = 10.0
"""How far from the robot the map is looked at, in metres."""


def are_in_own_room(robot: FrontierRobot, targets: FloatArray, room_m2: float) -> BoolArray:
    """Return which targets are inside the room that a robot is in.

    Parameters
    ----------
    robot : FrontierRobot
        The robot, on whose map rooms are told apart.
    targets : (m, 2) array
        The targets in metres.
    room_m2 : float
        A larger part of the map, in square metres, is no room.

    Returns
    -------
    (m,) array of bool
        False for targets in doorways and at walls: these may lead out. All False if the robot is
        in no room.
    """
    raster = robot.raster
    row, column = robot.indices_of(np.array([robot.at[:2]]))[0].tolist()
    span = math.ceil(SPAN_M / raster.cell_m)
    top, left = max(0, row - span), max(0, column - span)
    near = np.ascontiguousarray(raster.cells[top : row + span + 1, left : column + span + 1])
    room = room_around(near, row - top, column - left, doorway_cells=DOORWAY_M / raster.cell_m)
    inside = np.zeros(len(targets), np.bool_)
    if room is None or np.count_nonzero(room.cells) * raster.cell_m**2 > room_m2:
        return inside
    rows, columns = (robot.indices_of(targets) - (top, left)).T
    height, width = near.shape
    is_near = (rows >= 0) & (columns >= 0) & (rows < height) & (columns < width)
    inside[is_near] = room.inner[rows[is_near], columns[is_near]]
    return inside
