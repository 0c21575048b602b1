"""The room that a robot is in, on its own map."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from multisrt.geometry.grids.rooms import room_around
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.robots.frontier.robot import FrontierRobot

DOORWAY_M: Final = 1.4
"""Width of the widest doorway in metres."""

SPAN_M: Final = 10.0
"""How far from the robot, along either axis, a room may reach, in metres."""


def are_in_own_room(robot: FrontierRobot, targets: FloatArray, room_m2: float) -> BoolArray:
    """Return which targets are in the room that a robot is in.

    Parameters
    ----------
    robot : FrontierRobot
        The robot, on whose map rooms are told apart; see `room_around`.
    targets : (m, 2) array
        The targets, x and y in metres in the frame of the map.
    room_m2 : float
        Maximum known area of a room in square metres. A larger one does not count, nor does one
        that reaches farther than `SPAN_M`.

    Returns
    -------
    (m,) array of bool
        False for targets in doorways, which lead out. All False if the robot is in no such room.
    """
    raster = robot.raster
    row, column = robot.indices_of(np.array([robot.at[:2]]))[0].tolist()
    span = math.ceil(SPAN_M / raster.cell_m)
    top, left = max(0, row - span - 1), max(0, column - span - 1)
    near = np.ascontiguousarray(raster.cells[top : row + span + 2, left : column + span + 2])
    at = row - top, column - left
    room = room_around(near, *at, doorway_cells=DOORWAY_M / raster.cell_m)
    inside = np.zeros(len(targets), np.bool_)
    if room is None:
        return inside
    steps = np.abs(np.argwhere(room.cells) - at)
    if len(steps) * raster.cell_m**2 > room_m2 or steps.max() > span:
        return inside
    rows, columns = (robot.indices_of(targets) - (top, left)).T
    height, width = near.shape
    is_near = (rows >= 0) & (columns >= 0) & (rows < height) & (columns < width)
    inside[is_near] = room.inner[rows[is_near], columns[is_near]]
    return inside
