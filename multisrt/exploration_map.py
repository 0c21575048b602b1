"""What one robot knows of the world: a grow-only set of nodes, and what follows from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.frontier_arcs import (
    SHORTEST_ARC_M,
    arc_ends,
    arc_labels,
    frontier_candidates,
    joined_lengths,
    long_arcs,
    pieces_by_owner,
    total_length,
    uncovered,
)
from multisrt.geometry.kernel import FloatArray, IntArray
from multisrt.geometry.point_hash import PointHash
from multisrt.geometry.raster import Raster, bounds_of
from multisrt.geometry.safe_region import LocalSafeRegion

Array = TypeVar("Array", FloatArray, IntArray)


class NodeId(NamedTuple):
    """Who made a node, and its serial number among that robot's nodes."""

    robot: int
    serial: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Node:
    """A place that was visited, with what was seen from there.

    Attributes
    ----------
    id : NodeId
        Unique in the team.
    configuration : Configuration
        Where the scan was taken.
    region : LocalSafeRegion
        What the robot took as surely free around it.
    parent : NodeId or None
        The node that the robot came from; None at a root.
    time_s : float
        When the scan was taken.
    """

    id: NodeId
    configuration: Configuration
    region: LocalSafeRegion
    parent: NodeId | None
    time_s: float


class ExplorationMap:
    """A robot's knowledge. Adding a node is its only change; the order does not matter.

    Frontier arcs are kept per node and trimmed by the regions that arrive near by, so that one
    more node costs the same however many there are. Where the boundary of the whole known
    region passes from one node's arc to another's, the two are joined: an opening that several
    nodes see in parts is as wide as its parts together.

    Parameters
    ----------
    reach_m : float
        No region reaches further from its node than this.
    shortest_arc_m : float
        Frontier below this length, joined over all nodes, cannot be passed by the body and
        does not count.
    gaps_count : bool
        Whether radial pieces behind corners are frontier.
    """

    def __init__(
        self, *, reach_m: float, shortest_arc_m: float = 0.0, gaps_count: bool = True
    ) -> None:
        self._reach = reach_m
        self._shortest_arc = shortest_arc_m
        self._gaps_count = gaps_count
        self._nodes: dict[NodeId, Node] = {}
        self._ids: list[NodeId] = []
        self._index: dict[NodeId, int] = {}
        self._uncovered: list[FloatArray] = []
        self._ends: list[FloatArray] = []
        self._frontiers: dict[int, tuple[int, FloatArray]] = {}
        self._sizes: IntArray = np.zeros(64, np.int64)
        self._changed: IntArray = np.zeros(64, np.int64)
        self._revision = 0
        self._maybe_open: dict[NodeId, None] = {}
        self._places = PointHash(reach_m)
        self._boxes: FloatArray = np.empty((64, 4))
        self._starts: IntArray = np.zeros(65, np.int64)
        self._corners: FloatArray = np.empty((4096, 2))
        self._raster: Raster | None = None

    def __len__(self) -> int:
        return len(self._ids)

    def __contains__(self, node_id: NodeId) -> bool:
        return node_id in self._nodes

    def __getitem__(self, node_id: NodeId) -> Node:
        return self._nodes[node_id]

    @property
    def nodes(self) -> tuple[Node, ...]:
        """All nodes, in the order in which they became known here."""
        return tuple(self._nodes.values())

    def add(self, node: Node) -> bool:
        """Take in a node; one that is known already changes nothing.

        Returns
        -------
        bool
            Whether the node was new.
        """
        if node.id in self._nodes:
            return False
        neighbours = self._places.within(
            node.configuration.x, node.configuration.y, 2.0 * self._reach
        )
        index = self._store(node)
        candidates = frontier_candidates(
            node.region.boundary, node.region.tags, include_gaps=self._gaps_count
        )
        arcs, _ = uncovered(candidates, self._starts, self._corners, self._boxes, neighbours)
        self._uncovered.append(arcs)
        self._ends.append(arc_ends(arcs))
        self._set_uncovered(index, arcs)
        self._trim(neighbours, index)
        if self._raster is not None:
            self._raster.paint(node.region.boundary)
        return True

    def frontier(self, node_id: NodeId) -> FloatArray:
        """Give a node's local frontier as ``(m, 4)`` segments, the region on their left."""
        index = self._index[node_id]
        if not self._sizes[index]:
            return self._uncovered[index]
        # Arcs of others that join a node's own count too: it is as new as the newest change near.
        x, y = self._places.points[index].tolist()
        near = self._places.within(x, y, 2.0 * self._reach)
        revision = int(self._changed[near].max())
        known = self._frontiers.get(index)
        if known is None or known[0] != revision:
            known = revision, self._wide_enough(index, near[self._sizes[near] > 0])
            self._frontiers[index] = known
        return known[1]

    def frontier_arcs(self, node_id: NodeId) -> list[FloatArray]:
        """Give a node's local frontier arc by arc, each as ``(k, 4)`` joined segments."""
        segments = self.frontier(node_id)
        labels, count = arc_labels(segments)
        return [segments[labels == k] for k in range(count)]

    def has_frontier(self, node_id: NodeId) -> bool:
        """Whether a node has a local frontier."""
        return node_id in self._maybe_open and len(self.frontier(node_id)) > 0

    def is_complete(self) -> bool:
        """Whether no node has a local frontier."""
        # The last node that had one is asked first: mostly it still has.
        while self._maybe_open:
            node_id = next(reversed(self._maybe_open))
            if len(self.frontier(node_id)):
                return False
            if not any(self.has_frontier(other) for other in self._maybe_open):
                return True
            witness = next(n for n in self._maybe_open if self.has_frontier(n))
            del self._maybe_open[witness]
            self._maybe_open[witness] = None
        return True

    def open_nodes(self) -> list[NodeId]:
        """Give all nodes that have a local frontier, in the order of their ids."""
        return sorted(node_id for node_id in self._maybe_open if self.has_frontier(node_id))

    def open_frontier_m(self) -> float:
        """Sum of all local frontiers' lengths in metres."""
        return math.fsum(total_length(self.frontier(node_id)) for node_id in self.open_nodes())

    def close(self, node_id: NodeId, segments: FloatArray) -> None:
        """Take segments out of a node's frontier: nothing can be done about them."""
        index = self._index[node_id]
        arcs = self._uncovered[index]
        gone = {tuple(segment) for segment in segments.tolist()}
        keep = [tuple(segment) not in gone for segment in arcs.tolist()]
        self._set_uncovered(index, arcs[np.asarray(keep, np.bool_)])

    def near(self, x: float, y: float, radius_m: float) -> list[Node]:
        """Give the nodes whose place lies within a radius, in the order of their ids."""
        found = self._places.within(x, y, radius_m)
        return sorted((self._nodes[self._ids[i]] for i in found), key=lambda node: node.id)

    def places_near(self, x: float, y: float, radius_m: float) -> FloatArray:
        """Give the places of the nodes within a radius, ``(n, 2)``."""
        return self._places.points[self._places.within(x, y, radius_m)]

    def local_union(self, x: float, y: float, half_width_m: float) -> BaseGeometry:
        """Unite the regions of all nodes inside a square window around a place."""
        near = self.near(x, y, math.sqrt(2.0) * half_width_m + self._reach)
        polygons = np.array([node.region.polygon() for node in near])
        window = (x - half_width_m, y - half_width_m, x + half_width_m, y + half_width_m)
        return shapely.union_all(shapely.intersection(polygons, shapely.box(*window)))

    def region_union(self) -> BaseGeometry:
        """Unite all regions, exactly. Costs more the larger the map is: not for the loop."""
        return shapely.union_all([node.region.polygon() for node in self._nodes.values()])

    def raster(self, cell_m: float) -> Raster:
        """Give the raster of the union, painted once and from then on updated by `add`."""
        if self._raster is None or self._raster.cell_m != cell_m:
            self._raster = Raster(cell_m)
            for node in self._nodes.values():
                self._raster.paint(node.region.boundary)
        return self._raster

    def _store(self, node: Node) -> int:
        index = len(self._ids)
        if index == len(self._boxes):
            self._boxes = _grown(self._boxes, 2 * index)
            self._sizes = _grown(self._sizes, 2 * index)
            self._changed = _grown(self._changed, 2 * index)
            self._starts = _grown(self._starts, 2 * index + 1)
        boundary = node.region.boundary
        first, last = self._starts[index], self._starts[index] + len(boundary)
        if last > len(self._corners):
            self._corners = _grown(self._corners, max(int(last), 2 * len(self._corners)))
        self._corners[first:last] = boundary
        self._starts[index + 1] = last
        self._boxes[index] = bounds_of(boundary)
        x, y, _ = node.configuration
        self._places.add(x, y)
        self._nodes[node.id] = node
        self._ids.append(node.id)
        self._index[node.id] = index
        return index

    def _trim(self, neighbours: IntArray, index: int) -> None:
        still_open = neighbours[self._sizes[neighbours] > 0]
        if not len(still_open):
            return
        arcs = [self._uncovered[i] for i in still_open.tolist()]
        owners = np.repeat(np.arange(len(arcs)), self._sizes[still_open])
        segments = np.concatenate(arcs)
        rest, source = uncovered(
            segments, self._starts, self._corners, self._boxes, np.asarray([index])
        )
        begins, cut = pieces_by_owner(segments, owners, len(arcs), rest, source)
        for k in np.flatnonzero(cut).tolist():
            self._set_uncovered(int(still_open[k]), rest[begins[k] : begins[k + 1]])

    def _set_uncovered(self, index: int, arcs: FloatArray) -> None:
        arcs = long_arcs(arcs, SHORTEST_ARC_M)
        arcs.setflags(write=False)
        self._uncovered[index] = arcs
        self._ends[index] = arc_ends(arcs)
        self._sizes[index] = len(arcs)
        self._revision += 1
        self._changed[index] = self._revision
        if len(arcs):
            self._maybe_open[self._ids[index]] = None
        else:
            self._maybe_open.pop(self._ids[index], None)

    def _wide_enough(self, index: int, near: IntArray) -> FloatArray:
        # The node's arcs that are long enough together with those of others that they join.
        arcs = self._uncovered[index]
        own = self._ends[index]
        others = [self._ends[i] for i in near.tolist() if i != index]
        lengths = joined_lengths(np.concatenate([own, *others]))[: len(own)]
        labels, _ = arc_labels(arcs)
        kept: FloatArray = arcs[(lengths >= self._shortest_arc)[labels]]
        kept.setflags(write=False)
        return kept


def _grown(array: Array, length: int) -> Array:
    larger = np.zeros((length, *array.shape[1:]), array.dtype)
    larger[: len(array)] = array
    return larger
