"""Faster functions in place of the slowest of the competition's simulator, with the same results.

Four fifths of the time of a run are spent on whole maps, where only a part changes: a scan is
filled in on a map of its own, maps are copied to be merged, and walls are widened everywhere to
plan three cells of a way. Here a scan and a plan work on the part around the robot, and maps are
merged in place. In all cases that these functions do not treat they call those of the simulator.

Only strategies of this package are run so. A policy of others may keep a map that it was shown,
and maps that are merged in place change afterwards; it runs in the simulator as it is.
"""

from __future__ import annotations

import importlib
import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from shapely.geometry import MultiPolygon, Polygon

from multisrt.competition.stand_ins import Singles, cast_rays, cheapest_way
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel

SCAN_HALF: Final = 160
"""Cells from a robot to the edge of the part of a scan; the range is 150."""

PLAN_HALF: Final = 64
"""Cells from a robot to the edge of the part in which its way is planned."""

FAR: Final = 12
"""Cells around that part that are looked at: walls make ways dearer up to 9 cells from them."""

AS_IT_IS: Final = "_as_it_is"
"""What the names of the simulator's own functions end in where a faster one is in place."""

NEAR_GOAL: Final = 10
"""Distance below which the simulator takes a goal for reached, in cells."""


def install(fast: bool) -> None:
    """Put the faster functions in place in the simulator's modules, in this process, or take back.

    Parameters
    ----------
    fast : bool
        Whether the simulator is to run with them.
    """
    part = importlib.import_module
    for owner, names in (
        (part("robot").Robot, {"observe": _observe}),
        (part("policy").PlanningEngine, {"plan": _plan}),
        (
            part("comm").CommunicationManager,
            {
                "_share_information": _share,
                "_share_information_with_base_station": _share_with_base,
            },
        ),
    ):
        for name, function in names.items():
            if not hasattr(owner, name + AS_IT_IS):
                setattr(owner, name + AS_IT_IS, getattr(owner, name))
            setattr(owner, name, function if fast else getattr(owner, name + AS_IT_IS))


def _observe(robot: Any, world: Any) -> None:
    """Take a scan, as ``Robot.observe``."""
    row, column = (int(x) for x in robot.pose)
    if not hasattr(world, "occupied"):
        world.occupied = world.occ_map != 0
    reach = robot.lidar_range * robot.pixel_per_meter
    rays = np.zeros((robot.num_laser, 3), np.float32)
    rays[:, 0], rays[:, 1] = row, column
    rays[:, 2] = np.linspace(0, 2 * np.pi, robot.num_laser)
    ranges = np.zeros(robot.num_laser, np.float32)
    cast_rays(world.occupied, rays, np.float32(reach), ranges)
    points_at = importlib.import_module("scripts.utils").get_points_pos_from_ranges
    _, ends, hits = points_at(
        ranges, rays, robot.num_laser, (robot.pose[0], robot.pose[1]), reach, world.occ_map
    )
    if world.occ_map[row, column] == 1 or (ends == ends[0]).all():
        robot.observe_as_it_is(world)
        return
    outline: Any = Polygon(ends).buffer(1)
    parts = list(outline.geoms) if isinstance(outline, MultiPolygon) else [outline]
    shell = max(parts, key=lambda part: float(part.area)).exterior
    corner = row - SCAN_HALF, column - SCAN_HALF
    inside, closed = filled(np.array(shell.coords).astype(np.int64), corner, SCAN_HALF)
    if closed:
        note_scan(inside, corner, hits, robot.combined_obs_map, robot.unreported_mask)
    else:
        robot.observe_as_it_is(world)


def _share(links: Any, robots: list[Any]) -> None:
    """Merge the maps of robots in contact, as ``CommunicationManager._share_information``."""
    for i, one in enumerate(robots):
        for j in range(i + 1, len(robots)):
            if not links.comm_graph[i, j]:
                continue
            other = robots[j]
            merge(one.combined_obs_map, other.combined_obs_map)
            for told, teller in ((one, other), (other, one)):
                told.pose_lists_of_others[f"robot{teller.id}"] = teller.pose_list.copy()
                if teller.intent is not None:
                    told.intents_of_others[f"robot{teller.id}"] = teller.intent.copy()


def _share_with_base(links: Any, base: Any, world: Any) -> None:
    """Merge maps with the base's, as ``CommunicationManager`` does."""
    for i, robot in enumerate(world.robots):
        if links.base_comm_graph[i]:
            merge(base.obs_map, robot.combined_obs_map)
            robot.unreported_mask[:] = False


class _Decided:
    """A policy that has decided, for the simulator to go on with."""

    def __init__(self, goal: Any) -> None:
        self.goal = goal

    def should_relay(self, *_: Any) -> None:
        """Stay in the present mode."""

    def decide(self, *_: Any) -> Any:
        """Return the goal."""
        return self.goal


def _plan(
    engine: Any, known: Any, pose: Any, options: Any, robot: Any, base: Any, links: Any, world: Any
) -> Any:
    """Return the next pose of a robot that explores, as ``PlanningEngine.plan``."""
    policy, before = robot.user_policy, robot.locked_frontier_center
    observation = engine._build_observation(robot, base, links, options)
    policy.should_relay(observation, options, world.t, options.max_steps)
    if before is None or math.dist(before, pose) < NEAR_GOAL:
        goal = policy.decide(observation, options)
        way = None if goal is None else _way_nearby(known, pose, goal)
        if way is not None:
            robot.locked_frontier_center, robot.intent = goal, way
            return engine.pseudo_traj_planner(way[:, 0], way[:, 1], 3)
        robot.user_policy = _Decided(goal)
    try:  # the simulator takes this goal, or goes on to the last one if it is far away
        return engine.plan_as_it_is(known, pose, options, robot, base, links, world)
    finally:
        robot.user_policy = policy


def _way_nearby(known: FloatArray, pose: Any, goal: Any) -> NDArray[np.int32] | None:
    """Return a cheapest way to a goal, None unless it is that of the whole map."""
    row, column = (int(x) for x in pose)
    away = int(goal[0]) - row, int(goal[1]) - column
    if max(abs(away[0]), abs(away[1])) > PLAN_HALF // 4:
        return None
    half = PLAN_HALF + FAR
    corner = row - half, column - half
    if min(corner) < 1 or row + half + 1 >= known.shape[0] or column + half + 1 >= known.shape[1]:
        return None
    weights = weights_nearby(known, corner, half)[FAR:-FAR, FAR:-FAR].copy()
    end = PLAN_HALF + away[0], PLAN_HALF + away[1]
    way = cheapest_way(weights, PLAN_HALF, PLAN_HALF, *end)
    # Every cell costs 1 or more, so no cell farther than the way is dear was looked at.
    if not len(way) or not weights[way[1:, 0], way[1:, 1]].sum() + 2 < PLAN_HALF:
        return None
    if not np.isfinite(weights[end]):
        return None
    return way + np.array([row - PLAN_HALF, column - PLAN_HALF], np.int32)


@kernel
def draw_line(grid: NDArray[np.int8], x1: int, y1: int, x2: int, y2: int) -> None:
    """Set the cells of a line to 1, as ``bresenham`` of the simulator's ``utils``."""
    steep = abs(y2 - y1) > abs(x2 - x1)
    if steep:
        x1, y1, x2, y2 = y1, x1, y2, x2
    if x1 > x2:
        x1, y1, x2, y2 = x2, y2, x1, y1
    error, y = int((x2 - x1) / 2.0), y1
    for x in range(x1, x2 + 1):
        if steep:
            grid[y, x] = 1
        else:
            grid[x, y] = 1
        error -= abs(y2 - y1)
        if error < 0:
            y += 1 if y1 < y2 else -1
            error += x2 - x1


@kernel
def filled(outline: IntArray, corner: tuple[int, int], half: int) -> tuple[NDArray[np.int8], bool]:
    """Return the cells inside of an outline around the middle of a part of the map.

    Parameters
    ----------
    outline : (n, 2) array
        Cells, joined by lines.
    corner : (row, column)
        First cell of the part.
    half : int
        The part has twice as many rows and columns, and one more.

    Returns
    -------
    inside : array of int8
        2 inside, 1 on the outline, 0 outside.
    closed : bool
        Whether the outline has an inside that it separates from the edge of the part.
    """
    size = 2 * half + 1
    grid = np.zeros((size, size), np.int8)
    for k in range(len(outline)):
        one, other = outline[max(k - 1, 0)], outline[k]
        draw_line(
            grid, one[0] - corner[0], one[1] - corner[1], other[0] - corner[0], other[1] - corner[1]
        )
    if grid[half, half] == 1:
        return grid, False
    stack = np.empty(size * size + 1, np.int64)
    stack[0], count = half * size + half, 1
    while count:
        count -= 1
        cell = stack[count]
        i, j = cell // size, cell % size
        if i == 0 or j == 0 or i == size - 1 or j == size - 1:
            return grid, False
        for a, b in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
            if grid[a, b] == 0:
                grid[a, b] = 2
                stack[count] = a * size + b
                count += 1
    return grid, True


@kernel
def note_scan(
    inside: NDArray[np.int8],
    corner: tuple[int, int],
    hits: IntArray,
    known: FloatArray,
    unreported: BoolArray,
) -> None:
    """Write a scan into a map, as ``Robot.accumulate_obs_given_dict``."""  # fmt: skip
    row, column = corner
    for i in range(inside.shape[0]):
        for j in range(inside.shape[1]):
            if inside[i, j] == 2 and known[row + i, column + j] == 0.5:
                unreported[row + i, column + j] = True
                known[row + i, column + j] = 0.0
    for k in range(len(hits)):
        if known[hits[k, 0], hits[k, 1]] == 0.5:
            unreported[hits[k, 0], hits[k, 1]] = True
        known[hits[k, 0], hits[k, 1]] = 1.0


@kernel
def merge(one: FloatArray, other: FloatArray) -> None:
    """Write what two maps know into both: what is occupied in one is, before what is free."""
    a, b = one.ravel(), other.ravel()
    for k in range(len(a)):
        if a[k] != b[k]:
            value = 1.0 if a[k] == 1.0 or b[k] == 1.0 else 0.0
            a[k] = value
            b[k] = value


@kernel
def weights_nearby(known: FloatArray, corner: tuple[int, int], half: int) -> Singles:
    """Return the costs of entering cells of a part of a map, as ``inflate_map``.

    Cells beside occupied ones cannot be entered. Others cost 10, less their distance from the
    nearest that is not free, and 1 at least. Exact from 10 cells inside of the part.
    """
    size = 2 * half + 1
    distances = np.zeros((size, size), np.int64)
    weights = np.full((size, size), np.inf, np.float32)
    for i in range(size):
        for j in range(size):
            row, column = corner[0] + i, corner[1] + j
            blocked = False
            for a in range(row - 1, row + 2):
                for b in range(column - 1, column + 2):
                    if known[a, b] > 0.5:
                        blocked = True
            if not blocked:
                weights[i, j] = 10.0
                if known[row, column] == 0.0:
                    distances[i, j] = 10
    for i in range(size):
        for j in range(size):
            if distances[i, j] and i > 0 and 0 < j < size - 1:
                near = min(distances[i - 1, j - 1], distances[i - 1, j], distances[i - 1, j + 1])
                distances[i, j] = min(distances[i, j], near + 1, distances[i, j - 1] + 1)
    for i in range(size - 1, -1, -1):
        for j in range(size - 1, -1, -1):
            if distances[i, j] and i < size - 1 and 0 < j < size - 1:
                near = min(distances[i + 1, j - 1], distances[i + 1, j], distances[i + 1, j + 1])
                distances[i, j] = min(distances[i, j], near + 1, distances[i, j + 1] + 1)
            if weights[i, j] == 10.0:
                weights[i, j] = max(1.0, 10.0 - distances[i, j])
    return weights
