"""Faster replacements of the slowest functions of the competition's simulator.

They give the same results. The simulator spends four fifths of the time of a run on whole maps of
which only a small part changes: it fills each scan in a separate map, copies maps to merge them,
and dilates all walls to plan a path of three cells. Here scans and plans are limited to the
surroundings of the robot, and maps are merged in place. Cases that these functions do not cover are
passed on to those of the simulator.

The replacements are used for strategies of this package only. A policy of others might keep a map
that it was given, which would change when maps are merged in place; it runs in the original
simulator.
"""

from __future__ import annotations

import importlib
import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from shapely.geometry import MultiPolygon, Polygon

from multisrt.competition.stand_ins import Float32Array, cast_rays, cheapest_path
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel

SCAN_HALF: Final = 160
"""Cells from a robot to the edge of the window of its scan; the range is 150 cells."""

PLAN_HALF: Final = 64
"""Cells from a robot to the edge of the window in which its path is planned."""

PLAN_MARGIN: Final = 12
"""Width in cells of a margin around that window: walls raise costs up to 9 cells from them."""

ORIGINAL_SUFFIX: Final = "_original"
"""Suffix of the names under which the simulator's replaced functions are kept."""

GOAL_TOLERANCE: Final = 10
"""Distance in cells below which the simulator regards a goal as reached."""


def install(fast: bool) -> None:
    """Install the faster functions in the simulator's modules in this process, or remove them.

    Parameters
    ----------
    fast : bool
        Whether the simulator runs with the faster functions.
    """
    module = importlib.import_module
    for owner, names in (
        (module("robot").Robot, {"observe": _observe}),
        (module("policy").PlanningEngine, {"plan": _plan}),
        (
            module("comm").CommunicationManager,
            {
                "_share_information": _share,
                "_share_information_with_base_station": _share_with_base,
            },
        ),
    ):
        for name, function in names.items():
            if not hasattr(owner, name + ORIGINAL_SUFFIX):
                setattr(owner, name + ORIGINAL_SUFFIX, getattr(owner, name))
            setattr(owner, name, function if fast else getattr(owner, name + ORIGINAL_SUFFIX))


def _observe(robot: Any, world: Any) -> None:
    """Take a scan, like ``Robot.observe``."""
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
        robot.observe_original(world)
        return
    outline: Any = Polygon(ends).buffer(1)
    parts = list(outline.geoms) if isinstance(outline, MultiPolygon) else [outline]
    shell = max(parts, key=lambda part: float(part.area)).exterior
    corner = row - SCAN_HALF, column - SCAN_HALF
    inside, closed = filled_outline(np.array(shell.coords).astype(np.int64), corner, SCAN_HALF)
    if closed:
        write_scan(inside, corner, hits, robot.combined_obs_map, robot.unreported_mask)
    else:
        robot.observe_original(world)


def _share(links: Any, robots: list[Any]) -> None:
    """Merge the maps of robots in contact, like ``CommunicationManager._share_information``."""
    for i, one in enumerate(robots):
        for j in range(i + 1, len(robots)):
            if not links.comm_graph[i, j]:
                continue
            other = robots[j]
            merge(one.combined_obs_map, other.combined_obs_map)
            for receiver, sender in ((one, other), (other, one)):
                receiver.pose_lists_of_others[f"robot{sender.id}"] = sender.pose_list.copy()
                if sender.intent is not None:
                    receiver.intents_of_others[f"robot{sender.id}"] = sender.intent.copy()


def _share_with_base(links: Any, base: Any, world: Any) -> None:
    """Merge maps with the base's, like ``_share_information_with_base_station``."""
    for i, robot in enumerate(world.robots):
        if links.base_comm_graph[i]:
            merge(base.obs_map, robot.combined_obs_map)
            robot.unreported_mask[:] = False


class _FixedGoal:
    """A policy with a given goal, for the simulator's original planner."""

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
    """Return the next pose of an exploring robot, like ``PlanningEngine.plan``."""
    policy, locked = robot.user_policy, robot.locked_frontier_center
    observation = engine._build_observation(robot, base, links, options)
    policy.should_relay(observation, options, world.t, options.max_steps)
    if locked is None or math.dist(locked, pose) < GOAL_TOLERANCE:
        goal = policy.decide(observation, options)
        path = None if goal is None else _local_path(known, pose, goal)
        if path is not None:
            robot.locked_frontier_center, robot.intent = goal, path
            return engine.pseudo_traj_planner(path[:, 0], path[:, 1], 3)
        robot.user_policy = _FixedGoal(goal)
    try:  # the original planner asks for this goal, or continues to the locked one
        return engine.plan_original(known, pose, options, robot, base, links, world)
    finally:
        robot.user_policy = policy


def _local_path(known: FloatArray, pose: Any, goal: Any) -> NDArray[np.int32] | None:
    """Return a cheapest path to a goal; None if that of the whole map might be another one."""
    row, column = (int(x) for x in pose)
    to_goal = int(goal[0]) - row, int(goal[1]) - column
    if max(abs(to_goal[0]), abs(to_goal[1])) > PLAN_HALF // 4:
        return None
    half = PLAN_HALF + PLAN_MARGIN
    corner = row - half, column - half
    if min(corner) < 1 or row + half + 1 >= known.shape[0] or column + half + 1 >= known.shape[1]:
        return None
    inner = slice(PLAN_MARGIN, -PLAN_MARGIN)
    weights = local_weights(known, corner, half)[inner, inner].copy()
    end = PLAN_HALF + to_goal[0], PLAN_HALF + to_goal[1]
    path = cheapest_path(weights, PLAN_HALF, PLAN_HALF, *end)
    # Every cell costs at least 1, so the search visits no cell that is farther than the path costs.
    if not len(path) or not weights[path[1:, 0], path[1:, 1]].sum() + 2 < PLAN_HALF:
        return None
    if not np.isfinite(weights[end]):
        return None
    return path + np.array([row - PLAN_HALF, column - PLAN_HALF], np.int32)


@kernel
def draw_line(grid: NDArray[np.int8], x1: int, y1: int, x2: int, y2: int) -> None:
    """Set the cells of a line to 1, like ``bresenham`` of the simulator's ``utils``."""
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
def filled_outline(
    outline: IntArray, corner: tuple[int, int], half: int
) -> tuple[NDArray[np.int8], bool]:
    """Return the cells inside an outline around the centre of a window of the map.

    Parameters
    ----------
    outline : (n, 2) array
        Cells, which are joined by lines.
    corner : (row, column)
        First cell of the window.
    half : int
        Cells from the centre of the window to its edge.

    Returns
    -------
    inside : (2 * half + 1, 2 * half + 1) array of int8
        2 inside, 1 on the outline, 0 outside.
    closed : bool
        Whether the outline separates the centre from the edge of the window.
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
def write_scan(
    inside: NDArray[np.int8],
    corner: tuple[int, int],
    hits: IntArray,
    known: FloatArray,
    unreported: BoolArray,
) -> None:
    """Write a scan to a map, like ``Robot.accumulate_obs_given_dict``."""  # fmt: skip
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
    """Merge two maps in place: occupied in either, otherwise free in either, otherwise unknown."""
    a, b = one.ravel(), other.ravel()
    for k in range(len(a)):
        if a[k] != b[k]:
            value = 1.0 if a[k] == 1.0 or b[k] == 1.0 else 0.0
            a[k] = value
            b[k] = value


@kernel
def local_weights(known: FloatArray, corner: tuple[int, int], half: int) -> Float32Array:
    """Return the costs of entering the cells of a window of a map, like ``inflate_map``.

    Occupied cells and those next to one cannot be entered. Others cost 10 minus their distance from
    the nearest cell that is not free or cannot be entered, but at least 1. Costs are exact at 10 or
    more cells from the edge of the window.
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
