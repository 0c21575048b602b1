"""What one robot knows of the world: grow-only sets of nodes and closings, and what follows."""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.raster import Raster
from multisrt.geometry.numerics.arrays import grown
from multisrt.geometry.numerics.boxes import boxes_meeting
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.geometry.numerics.point_hash import PointHash
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.arc_pieces import ArcPieces
from multisrt.geometry.regions.frontier_arcs import arc_labels, total_length
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.robots.knowledge import Closing, ClosingId, Entries, Entry, Node, NodeId

__all__ = ["Closing", "ClosingId", "Entry", "ExplorationMap", "Node", "NodeId"]

ON_ARC_M: Final = 1e-6
"""Frontier within this of an arc that was given up is part of it."""

ROUNDING_M: Final = 1e-9
"""Widths and lengths that differ by less are equal."""

NO_FRONTIER: Final[FloatArray] = np.empty((0, 4))
NO_FRONTIER.setflags(write=False)

Box = tuple[float, float, float, float]


class _Frontier(NamedTuple):
    """A node's local frontier: as of which revision of the map, and of the map near the node."""

    asked: int
    newest: int
    segments: FloatArray
    length_m: float


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

    Attributes
    ----------
    entries : Entries
        All that is known, as robots tell each other of it; to be read: `add`, `close` and `merge`
        take in more.
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
        self._least_m = shortest_arc_m - ROUNDING_M
        self._gaps_count = gaps_count
        self._width = shortest_arc_m if width_m is None else width_m
        self._robot = robot
        self.entries = Entries()
        self._nodes = self.entries.nodes
        self._closed_arcs: dict[NodeId, list[FloatArray]] = {}
        self._roots: list[NodeId] = []
        self._root_of: dict[NodeId, NodeId] = {}
        # Of trees whose first node's parent is missing: their roots by that parent, and all nodes.
        self._cut_off: dict[NodeId, list[NodeId]] = {}
        self._members: dict[NodeId, list[NodeId]] = {}
        self._ids: list[NodeId] = []
        self._index: dict[NodeId, int] = {}
        self._arcs = ArcPieces()
        self._frontiers: dict[int, _Frontier] = {}
        self._changed: IntArray = np.zeros(0, np.int64)
        self._revision = 0
        self._witness = 0
        self._unlisted: dict[int, None] = {}
        self._open: dict[NodeId, dict[NodeId, float]] = {}
        self._open_m: dict[NodeId, float] = {}
        self._places = PointHash(reach_m)
        self._id_rows: IntArray = np.zeros((0, 2), np.int64)
        self._rings = Rings()
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
        return tuple(self.entries.closings.values())

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
        self.entries.add_node(node)
        index = self._store(node)
        changed = self._arcs.take_in(
            index,
            node.region,
            self._gaps_count,
            neighbours,
            self._id_rows,
            self._rings.arrays,
        )
        self._note_changed(changed)
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
        if not self.entries.add_closing(closing):
            return False
        if self._applies(closing):
            self._closed_arcs.setdefault(closing.node, []).append(closing.arc)
            if closing.node in self._index:
                self._note_changed(np.array([self._index[closing.node]]))
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

    def roots(self) -> list[NodeId]:
        """Give the roots of all trees, in the order of their ids.

        While a node's parent is not known, it is the root of what grows from it.
        """
        return list(self._roots)

    def tree(self, node_id: NodeId) -> NodeId:
        """Give the root at the end of a known node's parent links, as far as they are known."""
        if node_id not in self._nodes:
            raise InvalidInputError(f"node {tuple(node_id)} is not known, nor is its tree")
        return self._root_of[node_id]

    def frontier(self, node_id: NodeId) -> FloatArray:
        """Give a node's local frontier as ``(m, 4)`` segments, the region on their left."""
        index = self._index[node_id]
        return self._frontier(index).segments if self._arcs.is_open(index) else NO_FRONTIER

    def _frontier(self, index: int) -> _Frontier:
        # Of a node of which something is open.
        known = self._frontiers.get(index)
        if known is not None and known.asked == self._revision:
            return known
        near, newest = np.array([index]), int(self._changed[index])
        if self._arcs.lengths_m[index, 0] < self._least_m:
            # Arcs of others that join its own count, too: it is as new as the newest change near.
            near = self._places.around(near, 2.0 * self._reach)
            newest = int(self._changed[near].max())
        if known is None or known.newest != newest:
            segments = self._arcs.wide_enough(index, near, self._least_m)
            segments.setflags(write=False)
            known = _Frontier(self._revision, newest, segments, total_length(segments))
        else:
            known = known._replace(asked=self._revision)
        self._frontiers[index] = known
        return known

    def frontier_arcs(self, node_id: NodeId) -> list[FloatArray]:
        """Give a node's local frontier arc by arc, each as ``(k, 4)`` joined segments."""
        segments = self.frontier(node_id)
        labels, count = arc_labels(segments)
        return [segments[labels == k] for k in range(count)]

    def has_frontier(self, node_id: NodeId) -> bool:
        """Whether a node has a local frontier."""
        index = self._index.get(node_id)
        if index is None:
            return False
        longest_m = self._arcs.lengths_m[index, 1]
        if longest_m < 0.0 or longest_m >= self._least_m:
            return bool(longest_m >= 0.0)
        return len(self.frontier(node_id)) > 0

    def is_complete(self) -> bool:
        """Whether no node has a local frontier."""
        if not self._ids:
            return True
        # One arc that is long enough by itself will do; the longest one mostly stays so.
        if not self._is_wide(self._witness):
            self._witness = int(self._arcs.lengths_m[: len(self._ids), 1].argmax())
        if self._is_wide(self._witness):
            return False
        self._list_open()
        return not any(self._open.values())

    def open_nodes(self, tree: NodeId | None = None) -> list[NodeId]:
        """Give the nodes that have a local frontier, in the order of their ids.

        Parameters
        ----------
        tree : NodeId or None
            Any node of the tree that is asked for; None: all nodes.
        """
        if tree is None:
            self._list_open()
            return sorted(node_id for nodes in self._open.values() for node_id in nodes)
        return sorted(self._open_in(tree))

    def open_frontier_m(self, tree: NodeId | None = None) -> float:
        """Sum of all local frontiers' lengths in metres, of all nodes or of those in one's tree.

        What changed since it was asked last is looked at, and nothing else.
        """
        if tree is None:
            self._list_open()
            return math.fsum(m for nodes in self._open.values() for m in nodes.values())
        nodes, root = self._open_in(tree), self._root_of[tree]
        known = self._open_m.get(root)
        if known is None:
            known = self._open_m[root] = math.fsum(nodes.values())
        return known

    def near(self, x: float, y: float, radius_m: float) -> list[Node]:
        """Give the nodes whose place lies within a radius, in the order of their ids."""
        found = self._places.within(x, y, radius_m)
        return [self._nodes[node_id] for node_id in sorted(self._ids[i] for i in found.tolist())]

    def places_near(self, x: float, y: float, radius_m: float) -> FloatArray:
        """Give the places of the nodes within a radius, ``(n, 2)``."""
        return self._places.points[self._places.within(x, y, radius_m)]

    def pairs_near(self, first: int, radius_m: float) -> IntArray:
        """Pair nodes with those that became known before them and lie within a radius.

        Parameters
        ----------
        first : int
            The node from which on all are paired, by its place in `nodes`.
        radius_m : float
            How far from one another they may be.

        Returns
        -------
        (n, 2) array
            The later one's place in `nodes`, and the earlier one's; by the former, and then in
            the order of the latter's ids.
        """
        pairs = self._places.pairs(first, radius_m)
        ids = self._id_rows[pairs[:, 1]]
        return pairs[np.lexsort((ids[:, 1], ids[:, 0], pairs[:, 0]))]

    @property
    def places(self) -> FloatArray:
        """The places of all nodes, ``(n, 2)``, in the order of `nodes`."""
        return self._places.points

    @property
    def rings(self) -> Rings:
        """The boundaries of all nodes' regions, in the order of `nodes`."""
        return self._rings

    def known_space(self, x: float, y: float, half_width_m: float) -> KnownSpace:
        """Give the union of the regions of all nodes inside a square window around a place."""
        window, near = self._window(x, y, half_width_m)
        return KnownSpace(self.rings, near, window)

    def local_union(self, x: float, y: float, half_width_m: float) -> BaseGeometry:
        """Unite the regions of all nodes inside a square window around a place."""
        window, near = self._window(x, y, half_width_m)
        return shapely.union_all(shapely.intersection(self._polygons(near), shapely.box(*window)))

    def _window(self, x: float, y: float, half_width_m: float) -> tuple[Box, IntArray]:
        # A square around a place, and whose regions reach into it, in the order of their ids.
        window = (x - half_width_m, y - half_width_m, x + half_width_m, y + half_width_m)
        near = self._places.within(x, y, math.sqrt(2.0) * half_width_m + self._reach)
        found = np.empty_like(near)
        boxes = self._rings.arrays.boxes[near]
        near = near[found[: boxes_meeting(boxes, np.zeros(len(near)), window, found)]]
        return window, np.array(sorted(near.tolist(), key=self._ids.__getitem__), np.int64)

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
        index = self._rings.add(node.region.boundary)
        if index == len(self._id_rows):
            count = max(64, 2 * index)
            self._arcs.make_room(count)
            self._id_rows = grown(self._id_rows, count)
            self._changed = grown(self._changed, count)
        self._id_rows[index] = node.id
        x, y, _ = node.configuration
        self._places.add(x, y)
        self._ids.append(node.id)
        self._index[node.id] = index
        return index

    def _polygons(self, indices: IntArray) -> NDArray[np.object_]:
        # The regions as shapely polygons, all made at once.
        if not len(indices):
            return np.empty(0, np.object_)
        corners = [self._rings.ring(index) for index in indices.tolist()]
        owners = np.repeat(np.arange(len(corners)), [len(ring) for ring in corners])
        rings = shapely.linearrings(np.concatenate(corners), indices=owners)
        return np.asarray(shapely.polygons(rings), np.object_)

    def _note_changed(self, indices: IntArray) -> None:
        # What other regions leave of these nodes' frontiers is new, or something was given up.
        self._revision += 1
        self._changed[indices] = self._revision
        for index in indices.tolist():
            self._unlisted[index] = None
            closed = self._closed_arcs.get(self._ids[index])
            if closed:
                self._arcs.give_up(index, np.concatenate(closed), ON_ARC_M)

    def _is_wide(self, index: int) -> bool:
        # Whether an arc of a node is long enough by itself.
        return bool(self._arcs.lengths_m[index, 1] >= self._least_m)

    def _applies(self, closing: Closing) -> bool:
        if closing.reason == "seen from near":
            return True
        if closing.reason == "too narrow":
            return self._width >= closing.width_m - ROUNDING_M
        return self._robot is None or closing.id.robot == self._robot

    def _join_tree(self, node: Node) -> None:
        # A node whose parent is missing is a root until the parent comes: then its tree joins.
        root, joined = node.id, [node.id]
        if node.parent is None:
            insort(self._roots, root)
        elif node.parent in self._root_of:
            root = self._root_of[node.parent]
        else:
            insort(self._roots, root)
            self._cut_off.setdefault(node.parent, []).append(root)
            self._members[root] = []
        for head in self._cut_off.pop(node.id, []):
            self._roots.remove(head)
            joined += self._members.pop(head)
        for node_id in joined:
            if node_id in self._root_of:
                self._set_open(self._root_of[node_id], node_id, 0.0)
            self._root_of[node_id] = root
            self._unlisted[self._index[node_id]] = None
        if root in self._members:
            self._members[root] += joined

    def _open_in(self, tree: NodeId) -> dict[NodeId, float]:
        root = self.tree(tree)
        self._list_open()
        return self._open.get(root, {})

    def _list_open(self) -> None:
        # Looks again at the nodes near those that changed: arcs of others that join theirs count.
        if not self._unlisted:
            return
        near = self._places.around(np.array([*self._unlisted]), 2.0 * self._reach)
        opened = self._arcs.lengths_m[near, 1] >= 0.0
        for index, is_open in zip(near.tolist(), opened.tolist(), strict=True):
            if is_open or index in self._unlisted:
                node_id = self._ids[index]
                length = self._frontier(index).length_m if is_open else 0.0
                self._set_open(self._root_of[node_id], node_id, length)
        self._unlisted.clear()

    def _set_open(self, tree: NodeId, node_id: NodeId, length_m: float) -> None:
        nodes = self._open.setdefault(tree, {})
        if nodes.get(node_id, 0.0) == length_m:
            return
        self._open_m.pop(tree, None)
        if length_m:
            nodes[node_id] = length_m
        else:
            del nodes[node_id]
