"""Ways through what is known where the roadmap has none.

The paper's robots never die, and its roadmap joins all trees. Here whoever stands for good may
block a way where there is room to pass, and trees may touch where no two nodes see each other.
The way is found on a raster of what is known, without bodies; its first straight piece becomes
the next edge of the tree.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from multisrt.geometry.bodies.clearance import keep_off
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.raster import eroded
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray
from multisrt.robots.exploration_map import NodeId

if TYPE_CHECKING:
    from multisrt.robots.multi_srt.robot import SrtRobot

CELLS_PER_RADIUS = 5.0
"""Cells of the raster that make up a body's radius."""

BEYOND_CELLS = 0.1
"""Cells that are so much further off a body than a way has to be have clear ways between them."""


def first_leg(
    robot: SrtRobot,
    wanted: Callable[[NodeId], bool] | None = None,
    goal: tuple[float, float] | None = None,
) -> tuple[NodeId, NodeId | tuple[float, float]] | None:
    """Find the straight way off the roadmap with which the way to a wanted node, or place, begins.

    Parameters
    ----------
    robot : SrtRobot
        Who goes. A car has no such way: it would need its own curves.
    wanted : callable or None
        Whether a node is one of those looked for; None: none is.
    goal : (x, y) or None
        A place that is looked for instead.

    Returns
    -------
    start : NodeId
        Where it begins; the roadmap leads there.
    end : NodeId or (x, y)
        Where it ends: at a node from which the roadmap leads on, or at a place without a node.
    None, if there is none.
    """
    if robot.here is None or robot.is_car:
        return None
    for find in (_rest_of_the_way, _search):
        track = find(robot, wanted, goal)
        clear = 0 if track is None else _clear_places(robot, track)
        if track is not None and clear:
            if clear == len(track.along) and track.end is not None:
                robot.track = None
                return track.start, track.end
            robot.track = replace(track, gone=clear)
            x, y = track.along[clear - 1].tolist()
            return track.start, (x, y)
    robot.track = None
    return None


@dataclass(frozen=True, slots=True)
class Track:
    """A way off the roadmap that was found, and is gone piece by piece.

    Attributes
    ----------
    found_at : NodeId
        Where the robot was.
    start : NodeId
        The node at which it leaves the roadmap.
    along : (n, 2) array
        Places along it, cell by cell.
    end : NodeId or None
        The node at its end; None: it ends at a place.
    gone : int
        How many of the places lie on its first piece.
    """

    found_at: NodeId
    start: NodeId
    along: FloatArray
    end: NodeId | None
    gone: int = 0


def _rest_of_the_way(
    robot: SrtRobot,
    wanted: Callable[[NodeId], bool] | None,
    goal: tuple[float, float] | None,
) -> Track | None:
    # Of the way found last, if it leads to what is looked for still.
    track, here = robot.track, robot.here
    if track is None or here is None:
        return None
    if tuple(track.along[track.gone - 1]) == robot.q_act[:2]:
        track = Track(here, here, track.along[track.gone :], track.end)
    elif here != track.found_at or robot.way(here, track.start) is None:
        return None
    if not len(track.along):
        return None
    if track.end is None or wanted is None:
        leads = track.end is None and goal == tuple(track.along[-1])
    else:
        leads = robot.ways.to_nearest(track.end, wanted, robot.is_passable) is not None
    return track if leads else None


def _clear_places(robot: SrtRobot, track: Track) -> int:
    # How many places of a way lie on the longest straight piece with which it may begin.
    start = np.array(robot.map[track.start].configuration[:2])
    clear = np.flatnonzero(_goes_straight(robot, start, track.along))
    return int(clear[-1]) + 1 if len(clear) else 0


def _search(
    robot: SrtRobot,
    wanted: Callable[[NodeId], bool] | None,
    goal: tuple[float, float] | None,
) -> Track | None:
    # The shortest way off the roadmap.
    assert robot.here is not None
    looked_for = [] if wanted is None else [n.id for n in robot.map.nodes if wanted(n.id)]
    if goal is None and not looked_for:
        return None
    robot.ways.extend()
    grid, roadmap = _Grid(robot), robot.ways.roadmap
    starts = roadmap.lengths([robot.here], robot.is_passable)
    begins = grid.with_room([*starts])
    beyond = roadmap.lengths(looked_for, robot.is_passable)
    ends = grid.with_room([node for node in beyond if node not in starts])
    spots = grid.cells(_places(robot, begins))
    places = _places(robot, ends) if goal is None else np.array([goal])
    if not len(begins) or not grid.has_room(places).any():
        return None
    field = DistanceField(grid.room, grid.cell_m, places, x0=grid.x0, y0=grid.y0)
    best = _best_start(field, spots, np.array([starts[node] for node in begins]))
    if best is None:
        return None
    cells = field.descent(spots[best])
    last = int(np.hypot(*(places - grid.places(cells[-1:])).T).argmin())
    along = np.vstack([grid.places(cells[1:]), places[last]])
    return Track(robot.here, begins[best], along, ends[last] if goal is None else None)


class _Grid:
    """Where a robot's body has room in what is known, off all bodies: on a raster."""

    def __init__(self, robot: SrtRobot) -> None:
        self.cell_m = robot.body.outer_radius_m / CELLS_PER_RADIUS
        raster = robot.map.raster(self.cell_m)
        self.x0, self.y0 = raster.x0, raster.y0
        # The border runs anywhere between a cell that is known and its neighbour that is not.
        least = robot.body.roomy_radius_m / self.cell_m + math.sqrt(0.5)
        self.room: BoolArray = eroded(raster.cells, least)
        self._robot = robot
        xs, ys = raster.centres()
        for x, y, berth_m in robot.berths.tolist():
            reach = berth_m + BEYOND_CELLS * self.cell_m
            columns = np.flatnonzero(np.abs(xs - x) < reach)
            rows = np.flatnonzero(np.abs(ys - y) < reach)
            near = np.hypot(xs[columns] - x, ys[rows, None] - y) < reach
            self.room[np.ix_(rows, columns)] &= ~near

    def cells(self, places: FloatArray) -> IntArray:
        """Give the rows and columns in which places lie."""
        cells: IntArray = np.floor((places - (self.x0, self.y0)) / self.cell_m).astype(np.int64)
        return cells[:, ::-1]

    def places(self, cells: IntArray) -> FloatArray:
        """Give the middles of cells."""
        places: FloatArray = (cells[:, ::-1] + 0.5) * self.cell_m + np.array([self.x0, self.y0])
        return places

    def has_room(self, places: FloatArray) -> BoolArray:
        """Tell at which places the body has room; all lie in what is known."""
        rows, columns = self.cells(places).T
        room: BoolArray = self.room[rows, columns]
        return room

    def with_room(self, nodes: list[NodeId]) -> list[NodeId]:
        """Give the nodes at which the body has room."""
        room = self.has_room(_places(self._robot, nodes))
        return [node for node, has_room in zip(nodes, room.tolist(), strict=True) if has_room]


def _best_start(field: DistanceField, spots: IntArray, before_m: FloatArray) -> int | None:
    # Of the cells in which a way may leave the roadmap the one with the shortest way in all. The
    # front goes only so far as may be shorter than the way over the first that it comes to.
    nearest = field.first(spots)
    if nearest is None:
        return None
    first, to_first_m = nearest
    bound_m = float(to_first_m + before_m[first])
    centres = (spots[:, ::-1] + 0.5) * field.cell_m + (field.x0, field.y0)
    straight_m = cKDTree(field.sources).query(centres)[0] - field.cell_m
    promising = np.flatnonzero(before_m + straight_m <= bound_m)
    at_most_m = bound_m - float(before_m[promising].min())
    lengths = field.distance(spots[promising], at_most_m) + before_m[promising]
    return int(promising[np.argmin(lengths)])


def _places(robot: SrtRobot, nodes: list[NodeId]) -> FloatArray:
    return np.array([robot.map[node].configuration[:2] for node in nodes]).reshape(-1, 2)


def _goes_straight(robot: SrtRobot, start: FloatArray, ends: FloatArray) -> BoolArray:
    # Whether the body gets straight from a place with room to others, no farther than it sees.
    x, y = start.tolist()
    ways = np.hstack([np.broadcast_to(start, ends.shape), ends])
    known = robot.map.known_space(x, y, robot.me.range_m + robot.body.outer_radius_m)
    clear: BoolArray = np.hypot(*(ends - start).T) <= robot.me.range_m
    clear[clear] = known.passes(ways[clear], robot.body.roomy_radius_m)
    clear[clear] = keep_off(ways[clear], robot.berths)
    return clear
