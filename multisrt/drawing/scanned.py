"""Data for pictures of frontier bidding: explored cells, remaining frontier, isolated paths.

These robots scan while they drive, and every informative scan is a node. Their pictures therefore
show paths, goals and the raster instead of trees.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import msgspec
import numpy as np
import shapely
from numpy.typing import NDArray

from multisrt.analysis.isolation import Spell, isolation
from multisrt.drawing.traces import Trace
from multisrt.environments.environment import Environment
from multisrt.events import GoalChosen, NodeAdded, Point
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.occupancy import UNKNOWN, Occupancy
from multisrt.geometry.numerics.boxes import bounds_of
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.trajectory import leg_points, leg_pose
from multisrt.recording import Recording
from multisrt.robots.frontier.options import FrontierOptions

Waypoint = tuple[float, float, float, float]


NOBODY = -1
"""Entry of a cell that no robot has seen."""


def team_raster(recording: Recording) -> tuple[Occupancy, NDArray[np.int32]]:
    """Return the raster of all that the team saw, for its smallest body.

    Returns
    -------
    raster : Occupancy
        The raster.
    first : (rows, columns) array of int
        The robot that saw each cell first, or `NOBODY`.

    Raises
    ------
    InvalidInputError
        If the options `cell_m` and `margin_m` of the recording are not numbers.
    """
    cell_m, margin_m = _option(recording, "cell_m"), _option(recording, "margin_m")
    if cell_m is None or margin_m is None:
        raise InvalidInputError("options cell_m and margin_m of the recording must be lengths")
    bodies = [Footprint.parse(robot.footprint) for robot in recording.spec.robots]
    radius_m = min(PlanningBody(body, margin_m).ample_radius_m for body in bodies)
    nodes = [event for event in recording.events if isinstance(event, NodeAdded)]
    if not nodes:
        raster = Occupancy(cell_m, radius_m)
        return raster, np.full(raster.cells.shape, NOBODY, np.int32)
    # Large enough for all regions, so that rows and columns never shift.
    beyond_m = 2.0 * (radius_m + cell_m)
    x0, y0, x1, y1 = bounds_of(np.concatenate([node.region() for node in nodes]))
    bounds = x0 - beyond_m, y0 - beyond_m, x1 + beyond_m, y1 + beyond_m
    raster = Occupancy(cell_m, radius_m, bounds)
    first = np.full(raster.cells.shape, NOBODY, np.int32)
    for node in nodes:
        before = raster.revision
        raster.add(_region(node, recording.spec.robots[node.robot].range_finder.range_m))
        changed = raster.changed_since(before)
        if changed is not None:
            r0, r1, c0, c1 = raster.window_of(changed)
            new = (raster.cells[r0:r1, c0:c1] != UNKNOWN) & (first[r0:r1, c0:c1] == NOBODY)
            first[r0:r1, c0:c1][new] = node.robot
    return raster, first


def rings_of(raster: Occupancy, mask: BoolArray) -> list[FloatArray]:
    """Return the rings around the cells of a mask, each as ``(n, 2)`` points in metres."""
    return _rings(raster, np.argwhere(mask) + np.array([raster.row, raster.column]))


def frontier_left(raster: Occupancy, min_frontier_m: float) -> list[FloatArray]:
    """Return the rings around reachable frontier groups of at least `min_frontier_m` metres."""
    groups = [group for group in raster.frontier_groups(min_frontier_m) if group.target is not None]
    return [ring for group in groups for ring in _rings(raster, group.cells)]


def min_frontier_m(recording: Recording) -> float:
    """Return the minimum length of a frontier for any robot of the team, in metres."""
    said = _option(recording, "min_frontier_m")
    if said is not None:
        return said
    return min(Footprint.parse(robot.footprint).width_m for robot in recording.spec.robots)


def goals_of(recording: Recording, robot: int) -> list[Point]:
    """Return the goals that a robot drove to, without those that news of the map replaced."""
    choices = [e for e in recording.events if isinstance(e, GoalChosen) and e.robot == robot]
    ended = [*(following.because != "news" for following in choices[1:]), True]
    goals = (c.goal for c, last in zip(choices, ended, strict=False) if last and c.goal is not None)
    return list(dict.fromkeys(goals))


def isolated_paths(
    recording: Recording, environment: Environment, traces: Sequence[Trace]
) -> dict[int, list[FloatArray]]:
    """Return the parts of paths that were driven in isolation, by robot, as ``(n, 2)`` points."""
    cut_off = isolation(recording, environment)
    found = {}
    for trace in traces:
        paths = list(_paths_within(trace, cut_off[trace.robot].spells))
        if paths:
            found[trace.robot] = paths
    return found


def _paths_within(trace: Trace, spells: Sequence[Spell]) -> Iterator[FloatArray]:
    legs = [leg for motion in trace.motions for leg in pairwise(motion.waypoints)]
    for begin, end in spells:
        points: list[Point] = []
        for a, b in legs:
            if max(a[0], begin) < min(b[0], end):
                points += leg_points(_at(a, b, max(a[0], begin)), _at(a, b, min(b[0], end)))
        if len(set(points)) > 1:
            yield np.asarray(points)


def _at(a: Waypoint, b: Waypoint, time_s: float) -> Waypoint:
    return time_s, *leg_pose(a, b, (time_s - a[0]) / (b[0] - a[0]))


def _region(node: NodeAdded, range_m: float) -> LocalSafeRegion:
    x, y, _ = node.configuration
    return LocalSafeRegion(
        x=x,
        y=y,
        range_m=range_m,
        boundary=node.region(),
        tags=np.asarray([int(tag) for tag in node.tags], np.int8),
    )


def _option(recording: Recording, name: str) -> float | None:
    # Options may be texts; for strategies without the option its default is used.
    said = recording.spec.options.get(name, getattr(FrontierOptions(), name))
    try:
        return msgspec.convert(said, float | None, strict=False)
    except msgspec.ValidationError as error:
        raise InvalidInputError(f"option {name} of the recording: {error}") from None


def _rings(raster: Occupancy, cells: IntArray) -> list[FloatArray]:
    # The cells of each row become boxes with integer corners, which join without gaps.
    if not len(cells):
        return []
    row, column = cells.T
    begins = np.ones(len(cells), np.bool_)
    begins[1:] = (np.diff(row) != 0) | (np.diff(column) != 1)
    first = np.flatnonzero(begins)
    last = np.append(first[1:], len(cells)) - 1
    bars = shapely.box(column[first], row[first], column[last] + 1, row[first] + 1)
    x, y = raster.centre_of(0, 0)
    corner = np.array([x, y]) - 0.5 * raster.cell_m
    return [
        shapely.get_coordinates(ring) * raster.cell_m + corner
        for part in shapely.get_parts(shapely.union_all(bars))
        for ring in (part.exterior, *part.interiors)
    ]
