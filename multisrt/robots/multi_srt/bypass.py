"""Paths through the known space where the roadmap has none.

The paper's robots never die, and its roadmap joins all trees. Here the body of a robot that does
not answer may block an edge of the roadmap where there is room to pass, and trees may touch where
no two nodes see each other. Such a path is found on a raster of the known space, without the
bodies; its first straight piece becomes the next edge of the tree.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np
from scipy.spatial import cKDTree

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.raster import eroded
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray
from multisrt.planners.motion.body import PlanningBody
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.obstacles import Obstacles
from multisrt.robots.multi_srt.routes import Routes
from multisrt.robots.multi_srt.targets import KnownNode, NewPlace, Target

CELLS_PER_RADIUS = 5.0
"""Cells of the raster along the circumscribed radius of the body."""

BEYOND_CELLS = 0.1
"""Margin in cells around bodies and walls: straight paths between cells beyond it keep off them."""

MAX_SEARCHES = 32
"""How many paths are looked at for one that keeps off walls that are thinner than a cell."""

Wanted = Callable[[NodeId], bool]
"""Whether a node is one of those that are looked for."""

Leg = tuple[NodeId, NodeId | tuple[float, float]]
"""A straight path off the roadmap: the node where it begins, and the node or place at its end."""


@dataclass(frozen=True, slots=True)
class Track:
    """A path off the roadmap that was found, and is followed piece by piece.

    Attributes
    ----------
    found_at : NodeId
        The node at which the robot was when it found the path.
    start : NodeId
        The node at which the path leaves the roadmap.
    along : (n, 2) array
        Places along it, cell by cell, in metres.
    end : NodeId or None
        The node at its end; None: it ends at a place.
    gone : int
        Number of places that lie on its first straight piece.
    """

    found_at: NodeId
    start: NodeId
    along: FloatArray
    end: NodeId | None
    gone: int = 0


class Bypass:
    """Finds paths off the roadmap for one robot, and remembers the last one.

    A car has no such paths: it would need curves of its own.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    body : PlanningBody
        Its body.
    routes : Routes
        Its routes over the roadmap.
    """

    def __init__(self, me: RobotSelf, body: PlanningBody, routes: Routes) -> None:
        self.me = me
        self.body = body
        self.routes = routes
        self.at = routes.at
        self.map = routes.map
        self._track: Track | None = None

    def to(self, wanted: Wanted) -> Target | None:
        """Return the target that leads on to the nearest wanted node, or None.

        Where the path off the roadmap is one straight line to a node, it becomes an edge of the
        roadmap, and the target is the wanted node; else the target is the end of its first piece.
        """
        leg = self.first_leg(wanted)
        if leg is None:
            return None
        start, end = leg
        if not isinstance(end, NodeId):
            return self._place(start, end)
        self.routes.roadmap.join(start, end)
        route = self.routes.to_nearest(self.at.node, wanted)
        return None if route is None else KnownNode(tuple(route))

    def to_place(self, x: float, y: float, aim: NodeId) -> NewPlace | None:
        """Return the target that leads on to a place from which `aim`'s frontier is seen."""
        leg = self.first_leg(goal=(x, y))
        if leg is None or isinstance(leg[1], NodeId):
            return None
        place = self._place(*leg)
        if place is None:
            return None
        if (place.x, place.y) != (x, y):
            return replace(place, aim=aim)
        return replace(place, stage="complete", aim=aim, is_interim=False)

    def _place(self, start: NodeId, place: tuple[float, float]) -> NewPlace | None:
        route = self.routes.route(self.at.node, start)
        if route is None:
            return None
        return NewPlace(*place, "bypass", tuple(route), roomy=True, is_interim=True)

    def first_leg(
        self, wanted: Wanted | None = None, goal: tuple[float, float] | None = None
    ) -> Leg | None:
        """Return the straight piece with which the shortest path off the roadmap begins.

        Parameters
        ----------
        wanted : callable or None
            Whether a node is one of those that are looked for; None: none is.
        goal : (x, y) or None
            A place that is looked for instead.

        Returns
        -------
        start : NodeId
            The node at which it begins; the roadmap leads there.
        end : NodeId or (x, y)
            Its end: a node from which the roadmap leads on, or a place without a node.
        None, if there is no path.
        """
        if self.at.here is None or self.routes.roadmap.is_car:
            return None
        for find in (self._rest_of_the_track, self._search):
            track = find(wanted, goal)
            clear = 0 if track is None else self._clear_places(track)
            if track is not None and clear:
                if clear == len(track.along) and track.end is not None:
                    self._track = None
                    return track.start, track.end
                self._track = replace(track, gone=clear)
                x, y = track.along[clear - 1].tolist()
                return track.start, (x, y)
        self._track = None
        return None

    def leads_without_bodies(
        self, wanted: Wanted | None = None, goal: tuple[float, float] | None = None
    ) -> bool:
        """Whether there would be a path if no body stood there; see `first_leg`."""
        obstacles = self.routes.obstacles
        if not obstacles or self.at.here is None or self.routes.roadmap.is_car:
            return False
        with obstacles.ignored():
            return self._search(wanted, goal) is not None

    def _rest_of_the_track(
        self, wanted: Wanted | None, goal: tuple[float, float] | None
    ) -> Track | None:
        # The remainder of the last track, where it still leads to what is looked for.
        track, here = self._track, self.at.node
        if track is None:
            return None
        if tuple(track.along[track.gone - 1]) == self.at.q_act[:2]:
            track = Track(here, here, track.along[track.gone :], track.end)
        elif here != track.found_at or self.routes.route(here, track.start) is None:
            return None
        if not len(track.along):
            return None
        if track.end is None or wanted is None:
            leads = track.end is None and goal == tuple(track.along[-1])
        else:
            leads = self.routes.to_nearest(track.end, wanted) is not None
        return track if leads else None

    def _clear_places(self, track: Track) -> int:
        # The number of places of a track on the longest straight piece with which it may begin.
        start = np.array(self.map[track.start].configuration[:2])
        clear = np.flatnonzero(self._goes_straight(start, track.along))
        return int(clear[-1]) + 1 if len(clear) else 0

    def _search(self, wanted: Wanted | None, goal: tuple[float, float] | None) -> Track | None:
        # The shortest path off the roadmap, on a raster.
        here, routes = self.at.node, self.routes
        looked_for = [] if wanted is None else [n.id for n in self.map.nodes if wanted(n.id)]
        if goal is None and not looked_for:
            return None
        routes.roadmap.extend()
        grid, roadmap = _Grid(self.body, self.map, routes.obstacles), routes.roadmap.graph
        starts = roadmap.lengths([here], routes.passable)
        begins = grid.with_room([*starts])
        beyond = roadmap.lengths(looked_for, routes.passable)
        ends = grid.with_room([node for node in beyond if node not in starts])
        spots = grid.cells(_places(self.map, begins))
        places = _places(self.map, ends) if goal is None else np.array([goal])
        if not len(begins):
            return None
        before_m = np.array([starts[node] for node in begins])
        for _ in range(MAX_SEARCHES):
            # Paths that come too near to walls block cells, those of places among them.
            has_room = grid.has_room(places)
            places, ends = places[has_room], list(compress(ends, has_room.tolist()))
            if not len(places):
                return None
            field = DistanceField(grid.room, grid.cell_m, places, x0=grid.x0, y0=grid.y0)
            best = _best_start(field, spots, before_m)
            if best is None:
                return None
            cells = field.descent(spots[best])
            if grid.keeps_off_walls(begins[best], cells, self.me.range_m):
                last = int(np.hypot(*(places - grid.places(cells[-1:])).T).argmin())
                along = np.vstack([grid.places(cells[1:]), places[last]])
                return Track(here, begins[best], along, ends[last] if goal is None else None)
        return None

    def _goes_straight(self, start: FloatArray, ends: FloatArray) -> BoolArray:
        # Whether the body gets straight from a place with room to others within sensing range.
        x, y = start.tolist()
        paths = np.hstack([np.broadcast_to(start, ends.shape), ends])
        known = self.map.known_space(x, y, self.me.range_m + self.body.outer_radius_m)
        clear: BoolArray = np.hypot(*(ends - start).T) <= self.me.range_m
        clear[clear] = known.passes(paths[clear], self.body.roomy_radius_m)
        clear[clear] = self.routes.obstacles.are_passed_by(paths[clear])
        return clear


class _Grid:
    """A raster of where the body has room in the known space, off all obstacles."""

    def __init__(self, body: PlanningBody, known: ExplorationMap, obstacles: Obstacles) -> None:
        self.cell_m = body.outer_radius_m / CELLS_PER_RADIUS
        raster = known.raster(self.cell_m)
        self.x0, self.y0 = raster.x0, raster.y0
        # The border runs anywhere between a cell that is known and its neighbour that is not.
        least = body.roomy_radius_m / self.cell_m + math.sqrt(0.5)
        self.room: BoolArray = eroded(raster.cells, least)
        self._map = known
        self._body = body
        xs, ys = raster.centres()
        for x, y, berth_m in obstacles.berths.tolist():
            reach = berth_m + BEYOND_CELLS * self.cell_m
            columns = np.flatnonzero(np.abs(xs - x) < reach)
            rows = np.flatnonzero(np.abs(ys - y) < reach)
            near = np.hypot(xs[columns] - x, ys[rows, None] - y) < reach
            self.room[np.ix_(rows, columns)] &= ~near

    def keeps_off_walls(self, start: NodeId, cells: IntArray, within_m: float) -> bool:
        """Return whether a path has room exactly where it begins; if not, block where it has none.

        The raster does not show walls that are thinner than a cell, nor sharp corners.

        Parameters
        ----------
        start : NodeId
            The node at which the path begins.
        cells : (n, 2) array
            Row and column of its cells.
        within_m : float
            How far from the node it is looked at.
        """
        x, y, _ = self._map[start].configuration
        places = np.vstack([(x, y), self.places(cells)])
        near = np.hypot(*(places - (x, y)).T) <= within_m
        known = self._map.known_space(x, y, within_m + self._body.outer_radius_m)
        radius_m = self._body.roomy_radius_m
        required_m = np.full(len(places), radius_m + BEYOND_CELLS * self.cell_m)
        required_m[0] = radius_m
        lacks_m = (required_m - known.clearances(places, float(required_m[-1])))[near]
        tight = lacks_m > 0.0
        for (row, column), lack_m in zip(
            np.vstack([cells[:1], cells])[near][tight].tolist(),
            lacks_m[tight].tolist(),
            strict=True,
        ):
            reach = int(lack_m / self.cell_m)
            rows, columns = np.ogrid[-reach : reach + 1, -reach : reach + 1]
            around = np.argwhere(rows**2 + columns**2 <= reach**2) - reach + (row, column)
            inside = ((around >= 0) & (around < self.room.shape)).all(axis=1)
            self.room[tuple(around[inside].T)] = False
        return not tight.any()

    def cells(self, places: FloatArray) -> IntArray:
        """Return the row and column in which each place lies, ``(n, 2)``."""
        cells: IntArray = np.floor((places - (self.x0, self.y0)) / self.cell_m).astype(np.int64)
        return cells[:, ::-1]

    def places(self, cells: IntArray) -> FloatArray:
        """Return the centres of cells, ``(n, 2)``."""
        places: FloatArray = (cells[:, ::-1] + 0.5) * self.cell_m + np.array([self.x0, self.y0])
        return places

    def has_room(self, places: FloatArray) -> BoolArray:
        """Return at which places, all of them in the known space, the body has room."""
        rows, columns = self.cells(places).T
        room: BoolArray = self.room[rows, columns]
        return room

    def with_room(self, nodes: list[NodeId]) -> list[NodeId]:
        """Return the nodes at which the body has room."""
        room = self.has_room(_places(self._map, nodes))
        return [node for node, has_room in zip(nodes, room.tolist(), strict=True) if has_room]


def _best_start(field: DistanceField, spots: IntArray, before_m: FloatArray) -> int | None:
    # The cell at which to leave the roadmap for the shortest path in total. The front of the field
    # advances only as far as a path may be shorter than that over the first cell it reaches.
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


def _places(known: ExplorationMap, nodes: list[NodeId]) -> FloatArray:
    return np.array([known[node].configuration[:2] for node in nodes]).reshape(-1, 2)
