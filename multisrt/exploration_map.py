"""What one robot knows of the world: grow-only sets of nodes and closings, and what follows."""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Iterable
from typing import Final, NamedTuple, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from multisrt.entries import Closing, ClosingId, Entries, Entry, Have, Node, NodeId
from multisrt.geometry.arc_pieces import apart_from, common_pieces, in_long_arcs
from multisrt.geometry.boxes import boxes_meeting
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.frontier_arcs import (
    OUTWARD_M,
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
from multisrt.geometry.kernel import BoolArray, FloatArray, IntArray
from multisrt.geometry.point_hash import PointHash
from multisrt.geometry.raster import Raster, bounds_of

__all__ = ["Closing", "ClosingId", "Entry", "ExplorationMap", "Have", "Node", "NodeId"]

ON_ARC_M: Final = 1e-6
"""Frontier within this of an arc that was given up is part of it."""

ONE_BORDER_M: Final = 0.5 * OUTWARD_M
"""Borders of two nodes within this of each other are one. Further apart than twice this, the
region of the outer one takes the inner one away."""

ROUNDING_M: Final = 1e-9
"""Widths and lengths that differ by less are equal."""

Box = tuple[float, float, float, float]
Array = TypeVar("Array", FloatArray, IntArray)


class _Frontier(NamedTuple):
    """A node's local frontier: as of which revision of the map, and of the map near the node."""

    asked: int
    newest: int
    segments: FloatArray


class ExplorationMap:
    """A robot's knowledge: nodes and closings. It only grows; order and repetition do not matter.

    Frontier arcs are kept per node and trimmed by the regions that arrive near by, so that one
    more node costs the same however many there are. Where the boundary of the whole known
    region passes from one node's arc to another's, the two are joined: an opening that several
    nodes see in parts is as wide as its parts together. A border that several nodes share is
    frontier of the one with the lowest id.

    Parameters
    ----------
    reach_m : float
        No region of the team reaches further from its node than this.
    shortest_arc_m : float
        Frontier below this length, joined over all nodes, cannot be passed by the body and
        does not count.
    gaps_count : bool
        Whether radial pieces behind corners are frontier.
    width_m : float or None
        How wide the own body is; None: `shortest_arc_m`. What was too narrow for another is
        closed where the own body is no narrower.
    robot : int or None
        Whose map this is: what others could not reach, or found blocked by a robot, stays open
        for it. None: nobody's, and all such arcs are closed.
    """

    def __init__(
        self,
        *,
        reach_m: float,
        shortest_arc_m: float = 0.0,
        gaps_count: bool = True,
        width_m: float | None = None,
        robot: int | None = None,
    ) -> None:
        self._reach = reach_m
        self._shortest_arc = shortest_arc_m
        self._gaps_count = gaps_count
        self._width = shortest_arc_m if width_m is None else width_m
        self._robot = robot
        self._entries = Entries()
        self._nodes = self._entries.nodes
        self._closed_arcs: dict[NodeId, list[FloatArray]] = {}
        self._roots: list[NodeId] = []
        self._root_of: dict[NodeId, NodeId] = {}
        self._orphans: dict[NodeId, list[NodeId]] = {}
        self._ids: list[NodeId] = []
        self._index: dict[NodeId, int] = {}
        self._pieces: list[FloatArray] = []
        self._wholes: list[FloatArray] = []
        self._uncovered: list[FloatArray] = []
        self._ends: list[FloatArray] = []
        self._frontiers: dict[int, _Frontier] = {}
        self._sizes: IntArray = np.zeros(64, np.int64)
        self._changed: IntArray = np.zeros(64, np.int64)
        self._revision = 0
        self._maybe_open: dict[NodeId, None] = {}
        self._witness: NodeId | None = None
        self._unlisted: dict[int, None] = {}
        self._open: dict[NodeId | None, dict[NodeId, float]] = {}
        self._open_m: dict[NodeId | None, float] = {}
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

    @property
    def closings(self) -> tuple[Closing, ...]:
        """All closings, in the order in which they became known here."""
        return tuple(self._entries.closings.values())

    def add(self, node: Node) -> bool:
        """Take in a node; one that is known already changes nothing.

        Its parent need not be known.

        Returns
        -------
        bool
            Whether the node was new.

        Raises
        ------
        InvalidInputError
            If the node's region reaches further than `reach_m`.
        """
        if node.id in self._nodes:
            return False
        if node.region.range_m > self._reach + ROUNDING_M:
            raise InvalidInputError(
                f"node {tuple(node.id)} reaches {node.region.range_m} m, but the map was made for "
                f"{self._reach} m: reach_m is the largest range of the team"
            )
        neighbours = self._places.within(
            node.configuration.x, node.configuration.y, 2.0 * self._reach
        )
        self._entries.add_node(node)
        index = self._store(node)
        candidates = frontier_candidates(
            node.region.boundary, node.region.tags, include_gaps=self._gaps_count
        )
        pieces, source = uncovered(candidates, self._starts, self._corners, self._boxes, neighbours)
        still_open = neighbours[self._sizes[neighbours] > 0]
        earlier = np.array([self._ids[i] < node.id for i in still_open.tolist()], np.bool_)
        self._set_pieces(
            index,
            *self._without_shared_borders(pieces, candidates[source], still_open[earlier]),
        )
        self._trim(still_open, ~earlier, index)
        self._join_tree(node)
        if self._raster is not None:
            self._raster.paint(node.region.boundary)
        return True

    def close(self, closing: Closing) -> bool:
        """Take in that an arc was given up; what is known already changes nothing.

        What lies along the arc is no longer frontier of the node, also when the node becomes
        known later. Whether this holds for the own body, too, depends on the reason: what was
        seen from near is closed for all; what was too narrow, where the own body is no narrower;
        what was not reachable or blocked, for its maker alone.

        Returns
        -------
        bool
            Whether the closing was new.
        """
        if not self._entries.add_closing(closing):
            return False
        if self._applies(closing):
            self._closed_arcs.setdefault(closing.node, []).append(closing.arc)
            if closing.node in self._index:
                self._set_uncovered(self._index[closing.node])
        return True

    def merge(self, entries: Iterable[Entry]) -> tuple[NodeId, ...]:
        """Take in nodes and closings, in any order.

        Returns
        -------
        tuple of NodeId
            The nodes that were new.
        """
        new = []
        for entry in entries:
            if isinstance(entry, Closing):
                self.close(entry)
            elif self.add(entry):
                new.append(entry.id)
        return tuple(new)

    def have(self) -> dict[int, tuple[int, int]]:
        """Say what is known, in short: the version vector.

        Returns
        -------
        dict
            By robot, in rising order: of how many of its nodes and of how many of its closings,
            from the first on, none is missing.
        """
        return self._entries.have()

    def lacks(self, theirs: Have) -> tuple[Entry, ...]:
        """Give what another robot lacks, as far as what it said with `have` tells.

        Returns
        -------
        tuple of Node or Closing
            What is known here beyond the other's counts: by robot, nodes first, by number.
        """
        return tuple(self._entries.lacks(theirs))

    def knows_more_than(self, theirs: Have) -> bool:
        """Whether `lacks` would give anything."""
        return self._entries.more_than(theirs)

    def roots(self) -> list[NodeId]:
        """Give the roots of all trees, in the order of their ids."""
        return list(self._roots)

    def tree(self, node_id: NodeId) -> NodeId | None:
        """Give the root at the end of a known node's parent links; None while one is missing."""
        if node_id not in self._nodes:
            raise InvalidInputError(f"node {tuple(node_id)} is not known, nor is its tree")
        return self._root_of.get(node_id)

    def frontier(self, node_id: NodeId) -> FloatArray:
        """Give a node's local frontier as ``(m, 4)`` segments, the region on their left."""
        index = self._index[node_id]
        if not len(self._uncovered[index]):
            return self._uncovered[index]
        known = self._frontiers.get(index)
        if known is not None and known.asked == self._revision:
            return known.segments
        # Arcs of others that join a node's own count too: it is as new as the newest change near.
        near = self._around(index)
        newest = int(self._changed[near].max())
        if known is None or known.newest != newest:
            segments = self._wide_enough(index, near[self._sizes[near] > 0])
        else:
            segments = known.segments
        self._frontiers[index] = _Frontier(self._revision, newest, segments)
        return segments

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
        if self._witness is not None and self.has_frontier(self._witness):
            return False
        self._list_open()
        self._witness = next((node for nodes in self._open.values() for node in nodes), None)
        return self._witness is None

    def open_nodes(self, tree: NodeId | None = None) -> list[NodeId]:
        """Give the nodes that have a local frontier, in the order of their ids.

        Parameters
        ----------
        tree : NodeId or None
            The root of the tree that is asked for; None: all nodes.
        """
        if tree is None:
            self._list_open()
            return sorted(node_id for nodes in self._open.values() for node_id in nodes)
        return sorted(self._open_in(tree))

    def open_frontier_m(self, tree: NodeId | None = None) -> float:
        """Sum of all local frontiers' lengths in metres, of all nodes or of a tree's.

        What changed since it was asked last is looked at, and nothing else.
        """
        if tree is None:
            self._list_open()
            return math.fsum(m for nodes in self._open.values() for m in nodes.values())
        nodes = self._open_in(tree)
        known = self._open_m.get(tree)
        if known is None:
            known = self._open_m[tree] = math.fsum(nodes.values())
        return known

    def near(self, x: float, y: float, radius_m: float) -> list[Node]:
        """Give the nodes whose place lies within a radius, in the order of their ids."""
        found = self._places.within(x, y, radius_m)
        return sorted((self._nodes[self._ids[i]] for i in found), key=lambda node: node.id)

    def places_near(self, x: float, y: float, radius_m: float) -> FloatArray:
        """Give the places of the nodes within a radius, ``(n, 2)``."""
        return self._places.points[self._places.within(x, y, radius_m)]

    def local_union(self, x: float, y: float, half_width_m: float) -> BaseGeometry:
        """Unite the regions of all nodes inside a square window around a place."""
        window = (x - half_width_m, y - half_width_m, x + half_width_m, y + half_width_m)
        near = self._places.within(x, y, math.sqrt(2.0) * half_width_m + self._reach)
        near = near[boxes_meeting(self._boxes[near], np.zeros(len(near)), window)]
        near = np.array(sorted(near.tolist(), key=self._ids.__getitem__), np.int64)
        polygons = self._polygons(near)
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
        self._ids.append(node.id)
        self._index[node.id] = index
        self._pieces.append(np.empty((0, 4)))
        self._wholes.append(np.empty((0, 4)))
        self._uncovered.append(np.empty((0, 4)))
        self._ends.append(np.empty((0, 5)))
        return index

    def _polygons(self, indices: IntArray) -> NDArray[np.object_]:
        # The regions as shapely polygons, all made at once.
        if not len(indices):
            return np.empty(0, np.object_)
        first, last = self._starts[indices].tolist(), self._starts[indices + 1].tolist()
        corners = [self._corners[a:b] for a, b in zip(first, last, strict=True)]
        owners = np.repeat(np.arange(len(corners)), [len(ring) for ring in corners])
        rings = shapely.linearrings(np.concatenate(corners), indices=owners)
        return np.asarray(shapely.polygons(rings), np.object_)

    def _without_shared_borders(
        self, pieces: FloatArray, wholes: FloatArray, earlier: IntArray
    ) -> tuple[FloatArray, FloatArray]:
        # Of a border on which several regions end on one side, the node with the lowest id keeps
        # the frontier. Regions on two sides have taken it from each other already.
        if not len(pieces) or not len(earlier):
            return pieces, wholes
        concerned = np.ones(len(wholes), np.bool_)
        lines = np.concatenate([self._wholes[i] for i in earlier.tolist()])
        rest, source = apart_from(wholes, concerned, lines, ONE_BORDER_M)
        left, origin = common_pieces(pieces, wholes, rest, source)
        return left, wholes[origin]

    def _trim(self, neighbours: IntArray, later: BoolArray, index: int) -> None:
        # Takes a new node's region from the frontiers near by, and the borders that it shares
        # with nodes of higher ids.
        if not len(neighbours):
            return
        indices = neighbours.tolist()
        pieces = np.concatenate([self._pieces[i] for i in indices])
        wholes = np.concatenate([self._wholes[i] for i in indices])
        owners = np.repeat(np.arange(len(indices)), self._sizes[neighbours])
        rest, source = uncovered(
            wholes, self._starts, self._corners, self._boxes, np.asarray([index])
        )
        left, origin = common_pieces(pieces, wholes, rest, source)
        if later.any():
            concerned: BoolArray = later[owners[origin]]
            left_wholes = wholes[origin]
            rest, source = apart_from(left_wholes, concerned, self._wholes[index], ONE_BORDER_M)
            left, further = common_pieces(left, left_wholes, rest, source)
            origin = origin[further]
        begins, cut = pieces_by_owner(pieces, owners, len(indices), left, origin)
        for k in np.flatnonzero(cut).tolist():
            own = slice(begins[k], begins[k + 1])
            self._set_pieces(indices[k], left[own].copy(), wholes[origin[own]])

    def _set_pieces(self, index: int, pieces: FloatArray, wholes: FloatArray) -> None:
        # What no other region takes of a node's frontier.
        if len(pieces):
            keep = in_long_arcs(pieces, SHORTEST_ARC_M)
            if not keep.all():
                pieces, wholes = pieces[keep], wholes[keep]
        self._pieces[index] = pieces
        self._wholes[index] = wholes
        self._sizes[index] = len(pieces)
        self._set_uncovered(index)

    def _set_uncovered(self, index: int) -> None:
        # That, without what was given up.
        node_id = self._ids[index]
        arcs, wholes = self._pieces[index], self._wholes[index]
        closed = self._closed_arcs.get(node_id)
        if closed and len(arcs):
            rest, source = apart_from(
                wholes, np.ones(len(wholes), np.bool_), np.concatenate(closed), ON_ARC_M
            )
            arcs = long_arcs(common_pieces(arcs, wholes, rest, source)[0], SHORTEST_ARC_M)
        self._revision += 1
        self._changed[index] = self._revision
        self._unlisted[index] = None
        if len(arcs):
            arcs.setflags(write=False)
            self._uncovered[index] = arcs
            self._ends[index] = arc_ends(arcs)
            self._maybe_open[node_id] = None
        else:
            self._uncovered[index], self._ends[index] = np.empty((0, 4)), np.empty((0, 5))
            self._maybe_open.pop(node_id, None)

    def _applies(self, closing: Closing) -> bool:
        if closing.reason == "seen from near":
            return True
        if closing.reason == "too narrow":
            return self._width >= closing.width_m - ROUNDING_M
        return self._robot is None or closing.id.robot == self._robot

    def _join_tree(self, node: Node) -> None:
        # A node's root is known once its parent's is; then so is that of all that waited for it.
        if node.parent is None:
            root = node.id
            insort(self._roots, root)
        elif node.parent in self._root_of:
            root = self._root_of[node.parent]
        else:
            self._orphans.setdefault(node.parent, []).append(node.id)
            return
        found = [node.id]
        while found:
            node_id = found.pop()
            self._root_of[node_id] = root
            found += self._orphans.pop(node_id, [])
            self._set_open(None, node_id, 0.0)
            self._unlisted[self._index[node_id]] = None

    def _open_in(self, tree: NodeId) -> dict[NodeId, float]:
        if self._root_of.get(tree) != tree:
            raise InvalidInputError(f"{tuple(tree)} is not the root of a tree known here")
        self._list_open()
        return self._open.get(tree, {})

    def _list_open(self) -> None:
        # Looks again at the nodes near those that changed: arcs of others that join theirs count.
        if not self._unlisted:
            return
        near = [self._around(index) for index in self._unlisted]
        for index in np.unique(np.concatenate(near)).tolist():
            node_id = self._ids[index]
            if index in self._unlisted or len(self._uncovered[index]):
                length = total_length(self.frontier(node_id))
                self._set_open(self._root_of.get(node_id), node_id, length)
        self._unlisted.clear()

    def _set_open(self, tree: NodeId | None, node_id: NodeId, length_m: float) -> None:
        nodes = self._open.setdefault(tree, {})
        if nodes.get(node_id, 0.0) == length_m:
            return
        self._open_m.pop(tree, None)
        if length_m:
            nodes[node_id] = length_m
        else:
            del nodes[node_id]

    def _around(self, index: int) -> IntArray:
        # The nodes whose regions can meet a node's, itself among them.
        x, y = self._places.points[index].tolist()
        return self._places.within(x, y, 2.0 * self._reach)

    def _wide_enough(self, index: int, near: IntArray) -> FloatArray:
        # The node's arcs that are long enough together with those of others that they join.
        arcs = self._uncovered[index]
        own = self._ends[index]
        others = [self._ends[i] for i in near.tolist() if i != index]
        lengths = joined_lengths(np.concatenate([own, *others]))[: len(own)]
        labels, _ = arc_labels(arcs)
        kept: FloatArray = arcs[(lengths >= self._shortest_arc - ROUNDING_M)[labels]]
        kept.setflags(write=False)
        return kept


def _grown(array: Array, length: int) -> Array:
    larger = np.zeros((length, *array.shape[1:]), array.dtype)
    larger[: len(array)] = array
    return larger
