"""The observation of a robot that asks where to go: arrays of fixed shapes.

All of it is made from the robot's scans, its messages and its own place. Lengths are in metres and
times in seconds. Offsets are along the axes of the world, from where the robot is; the map has its
lowest row first. Numbers beyond the bounds of this module are clipped to them.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.numerics.arrays import ByteArray
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.policy.decision_spec import DecisionSpec
from multisrt.robots.policy.questions import Question

Observation = dict[str, NDArray[Any]]
"""The parts of an observation, by name."""

FAR_M: Final = 1e4
"""Bounds offsets, sizes and costs, in metres."""

PLACE_M: Final = 1e6
"""Bounds the coordinates of a robot's own place, in metres."""

MAX_TIME_S: Final = 1e6
"""Bounds times and ages, in seconds."""

FRONTIER_COLUMNS: Final = ("dx", "dy", "size_m", "cost_m")
"""Observation of a frontier: its offset, its length, and the length of the path there."""

OTHER_COLUMNS: Final = ("dx", "dy", "goal_dx", "goal_dy", "age_s")
"""Observation of another robot: the offsets of its place and of its goal, as it last said
them, and how long ago that was."""


def observe(robot: FrontierRobot, question: Question, spec: DecisionSpec) -> Observation:
    """Return what a robot observes as it asks where to go.

    Parameters
    ----------
    robot : FrontierRobot
        The robot.
    question : Question
        What it asks.
    spec : DecisionSpec
        Which parts, and their shapes.

    Returns
    -------
    dict of str to array
        New arrays. Always ``pose`` (x, y, heading) and ``time`` (s); ``frontiers``, ``others``
        with ``others_mask`` in a team, and ``map`` as the spec says; ``action_mask`` where
        actions are frontiers, else ``decides``.
    """
    seen = nothing_observed(robot.me.team, spec)
    seen["pose"][:2] = np.clip(robot.at[:2], -PLACE_M, PLACE_M)
    # Headings are within a turn of 0, which rounding to 32 bits could exceed.
    seen["pose"][2] = np.clip(np.float32(robot.at.heading), -np.float32(np.pi), np.float32(np.pi))
    seen["time"][0] = min(robot.time_s, MAX_TIME_S)
    _allow(seen, spec, len(question.nearest))
    if "frontiers" in spec.observe:
        rows = question.nearest
        seen["frontiers"][: len(rows)] = np.column_stack(
            [
                np.clip(question.table.targets[rows] - robot.at[:2], -FAR_M, FAR_M),
                np.minimum(question.sizes_m[rows], FAR_M),
                np.minimum(question.costs_m[rows], FAR_M),
            ]
        )
    if "others" in spec.observe:
        _note_others(seen, robot)
    if "map" in spec.observe:
        x, y, _ = robot.at if spec.map_centre == "robot" else robot.me.start
        seen["map"] = cells_around(robot.raster, (x, y), spec.map_cells, spec.map_scale)
    return seen


def nothing_observed(team: int, spec: DecisionSpec) -> Observation:
    """Return the observation of a robot of a team that has observed nothing and asks nothing."""
    seen: Observation = {
        "pose": np.zeros(3, np.float32),
        "time": np.zeros(1, np.float32),
    }
    if "frontiers" in spec.observe:
        seen["frontiers"] = np.zeros((spec.frontiers, len(FRONTIER_COLUMNS)), np.float32)
    if "others" in spec.observe and team > 1:
        seen["others"] = np.zeros((team - 1, len(OTHER_COLUMNS)), np.float32)
        seen["others_mask"] = np.zeros((team - 1, 2), np.int8)
    if "map" in spec.observe:
        seen["map"] = np.zeros((spec.map_cells, spec.map_cells), np.uint8)
    _allow(seen, spec, 0)
    return seen


def on_the_way(seen: Observation, spec: DecisionSpec) -> Observation:
    """Return what a robot observed last, as a new observation of one that asks nothing now."""
    again = {name: part.copy() for name, part in seen.items()}
    _allow(again, spec, 0)
    return again


def cells_around(
    raster: Occupancy, place: tuple[float, float], count: int, scale: int
) -> ByteArray:
    """Return the cells of a raster around a place, several taken together.

    Parameters
    ----------
    raster : Occupancy
        The raster.
    place : (x, y)
        The middle in metres.
    count : int
        Number of rows and columns that are returned.
    scale : int
        Rows and columns of the raster that are taken together: a cell is occupied if one of
        them is, else free if one of them is free. Which are taken together does not depend on
        the place.

    Returns
    -------
    (count, count) array of uint8
        `UNKNOWN` (0), `FREE` (1) or `OCCUPIED` (2); the place is in row and column
        ``count // 2``.
    """
    row, column = ((k // scale - count // 2) * scale for k in raster.cell_of(*place))
    fine = raster.square(row, column, count * scale)
    coarse: ByteArray = fine.reshape(count, scale, count, scale).max(axis=(1, 3))
    return coarse


def _allow(seen: Observation, spec: DecisionSpec, frontiers: int) -> None:
    # Which actions a robot may take: one of some frontiers, or without any, none.
    if spec.actions == "place":
        seen["decides"] = np.array([frontiers > 0], np.int8)
        return
    mask = seen["action_mask"] = np.zeros(spec.frontiers + 1, np.int8)
    mask[:frontiers] = 1
    mask[spec.no_op] = frontiers == 0


def _note_others(seen: Observation, robot: FrontierRobot) -> None:
    x, y, _ = robot.at
    for number, report in robot.team.teammates.reports.items():
        row = number if number < robot.me.robot else number - 1
        goal = report.place[:2] if report.goal is None else report.goal
        offsets = (report.place[0] - x, report.place[1] - y, goal[0] - x, goal[1] - y)
        seen["others"][row, :4] = np.clip(offsets, -FAR_M, FAR_M)
        seen["others"][row, 4] = min(max(0.0, robot.time_s - report.time_s), MAX_TIME_S)
        seen["others_mask"][row] = True, report.goal is not None
