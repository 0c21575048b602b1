"""A roadmap of the nodes of a map, with straight edges and shortest paths."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.roadmap import Roadmap
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.toolkit.places import places_of

Passable = Callable[[NodeId, NodeId], bool]


class NodeRoadmap:
    """The nodes of an `ExplorationMap`, with an edge if the body can go straight between two.

    It follows the map automatically, including nodes from other robots. Along an edge the body
    stays first in the region of one node and then in that of the other, and fits with any heading,
    so bodies that turn in place can follow it. Cars need curves: use `trajectory_inside` to drive
    along a path.

    Parameters
    ----------
    known : ExplorationMap
        The map.
    footprint : Footprint
        The body.
    reach_m : float
        Maximum length of an edge in metres: the sensing range.
    margin_m : float
        Distance in metres that the body keeps from the borders of regions where there is room.

    Examples
    --------
    Two scans in a hall of 8 m x 2 m, 3 m apart:

    >>> from multisrt.geometry.configuration import Configuration
    >>> from multisrt.geometry.regions.edge_index import EdgeIndex
    >>> from multisrt.geometry.regions.safe_region import local_safe_region
    >>> from multisrt.geometry.regions.scan import take_scan
    >>> corners = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 2.0], [0.0, 2.0]])
    >>> hall = EdgeIndex(np.hstack([corners, np.roll(corners, -1, axis=0)]), 4.0 / 3.0)
    >>> known = ExplorationMap(reach_m=3.0, min_arc_m=0.5)
    >>> for serial, x in enumerate([2.0, 5.0]):
    ...     scan = take_scan(hall, Configuration(x, 1.0), float(serial), range_m=3.0)
    ...     node = Node(
    ...         id=NodeId(0, serial),
    ...         configuration=scan.configuration,
    ...         region=local_safe_region(scan, "radial"),
    ...         parent=None,
    ...         time_s=scan.time_s,
    ...     )
    ...     _ = known.add(node)
    >>> roadmap = NodeRoadmap(known, Footprint.disc(0.25), reach_m=3.0)
    >>> roadmap.path((1.0, 0.5), (6.0, 1.5)).round(1).tolist()
    [[1.0, 0.5], [2.0, 1.0], [5.0, 1.0], [6.0, 1.5]]
    >>> roadmap.costs((2.0, 1.0), [(5.0, 1.0), (50.0, 1.0)]).tolist()
    [3.0, inf]
    """

    def __init__(
        self,
        known: ExplorationMap,
        footprint: Footprint,
        reach_m: float,
        margin_m: float = 0.02,
    ) -> None:
        self.map = known
        self.body = PlanningBody(footprint, margin_m)
        self.reach_m = reach_m
        self._graph: Roadmap[NodeId] = Roadmap()
        self._seen = 0

    @property
    def graph(self) -> Roadmap[NodeId]:
        """The graph of all nodes known so far."""
        self._extend()
        return self._graph

    def visible_from(self, place: Any) -> list[Node]:
        """Return the nodes from which the body can go straight to a place, nearest first.

        Parameters
        ----------
        place : (x, y), Configuration, Node, ...
            The place; see `places_of`.
        """
        [(x, y)] = _one(place)
        near = self.map.near(x, y, self.reach_m)
        near.sort(key=lambda node: math.dist(node.configuration[:2], (x, y)))
        return [node for node in near if self._leads(node, x, y)]

    def path(self, from_: Any, to: Any, passable: Passable | None = None) -> FloatArray | None:
        """Return the shortest path between two places over the nodes.

        Parameters
        ----------
        from_, to : place
            Its ends; each is a node, or is reachable from one in a straight line.
        passable : callable, optional
            Whether the path between two nodes, given by their ids, is free at present.

        Returns
        -------
        (k, 2) array or None
            Its vertices in metres, including both ends; None if there is no path.
        """
        start, end = _one(from_)[0], _one(to)[0]
        lengths, routes = self._routes(start, [end], passable)
        if not math.isfinite(lengths[0]):
            return None
        middle = [self.map[node].configuration[:2] for node in routes[0]]
        corners = [start]
        for corner in (*middle, end):
            if math.dist(corner, corners[-1]) > 0.0:
                corners.append(corner)
        return np.array(corners)

    def costs(self, from_: Any, to: Any, passable: Passable | None = None) -> FloatArray:
        """Return the lengths of the shortest paths from one place to others.

        Parameters
        ----------
        from_ : place
            Start of the paths.
        to : place or places
            Ends of the paths.
        passable : callable, optional
            As in `path`.

        Returns
        -------
        (m,) array
            Lengths in metres; ``inf`` if there is no path.
        """
        ends = [tuple(end) for end in places_of(to, "to").tolist()]
        return np.array(self._routes(_one(from_)[0], ends, passable)[0], np.float64)

    def _routes(
        self,
        start: tuple[float, float],
        ends: list[tuple[float, float]],
        passable: Passable | None,
    ) -> tuple[list[float], list[list[NodeId]]]:
        # The length of the shortest path to each end, and the nodes on it.
        first = {node.id: math.dist(node.configuration[:2], start) for node in self._at(start)}
        lengths, before = self.graph.tree(first, passable)
        found: list[float] = []
        routes: list[list[NodeId]] = []
        for end in ends:
            total, last = min(
                (
                    (lengths[node.id] + math.dist(node.configuration[:2], end), node.id)
                    for node in self._at(end)
                    if node.id in lengths
                ),
                default=(math.inf, None),
            )
            route: list[NodeId] = []
            while last is not None:
                route.append(last)
                last = before.get(last)
            found.append(total)
            routes.append(route[::-1])
        return found, routes

    def _at(self, place: tuple[float, float]) -> list[Node]:
        # The node at a place, else those that lead there.
        here = [n for n in self.map.near(*place, 1e-9) if n.configuration[:2] == place]
        return here[:1] or self.visible_from(place)

    def _leads(self, node: Node, x: float, y: float) -> bool:
        return self.body.disc_travel(node.region.boundary, *node.configuration[:2], x, y)

    def _extend(self) -> None:
        if len(self.map) == self._seen:
            return
        nodes = self.map.nodes
        for node in nodes[self._seen :]:
            self._graph.add(node.id, node.configuration.x, node.configuration.y)
        pairs = self.map.pairs_near(self._seen, self.reach_m)
        self._seen = len(nodes)
        joined = self.body.bridges(self.map.places, self.map.rings, pairs)
        for a, b in pairs[joined].tolist():
            self._graph.connect(nodes[a].id, nodes[b].id)


def _one(place: Any) -> list[tuple[float, float]]:
    found = places_of(place, "a place")
    if len(found) != 1:
        raise InvalidInputError(f"there are {len(found)} places; give one")
    x, y = found[0].tolist()
    return [(x, y)]
