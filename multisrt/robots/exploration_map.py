"""One robot's knowledge of the world: grow-only sets of nodes and closings, and what follows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from shapely.geometry.base import BaseGeometry

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.raster import Raster
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.frontier_arcs import arc_labels
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.geometry.regions.overlay import union_on_grid
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.knowledge import Closing, ClosingId, Entries, Entry, Node, NodeId
from multisrt.robots.local_frontiers import LocalFrontiers
from multisrt.robots.node_regions import NodeRegions
from multisrt.robots.open_frontiers import OpenFrontiers
from multisrt.robots.tree_membership import TreeMembership

__all__ = ["Closing", "ClosingId", "Entry", "ExplorationMap", "Node", "NodeId"]

ROUNDING_M: Final = 1e-9
"""Widths and lengths that differ by at most this, in metres, are equal."""


class ExplorationMap:
    """A robot's knowledge: nodes and closings.

    It only grows, and neither the order nor the repetition of what is added makes a difference.
    Frontier arcs are kept per node and trimmed by the regions that become known near by, so that
    one more node costs the same however many there are.

    Where the boundary of the whole known region passes from one node's arc to another's, the two
    are joined: an opening that several nodes see in parts is as wide as its parts together. A
    border that several nodes share is frontier of the one with the lowest id.

    Parameters
    ----------
    reach_m : float
        Maximum range of the team's range finders in metres.
    min_arc_m : float, default 0.0
        Minimum length in metres of frontier, joined over all nodes: the body cannot pass through a
        narrower opening.
    gaps_count : bool, default True
        Whether radial pieces behind corners are frontier.
    width_m : float, optional
        Width of the robot's own body in metres; default: `min_arc_m`. What was too narrow
        for another robot is closed if the own body is no narrower.
    robot : int, optional
        The robot whose map this is: arcs that other robots could not reach stay open for it.
        Default: no robot's, and all such arcs are closed.

    Attributes
    ----------
    entries : Entries
        All nodes and closings, as robots send them to each other. Read-only: `add`, `close` and
        `merge` add to it.

    Examples
    --------
    One node that sees a square of 2 x 2 m with an open right side:

    >>> import numpy as np
    >>> from multisrt.geometry.configuration import Configuration
    >>> from multisrt.geometry.regions.boundary import OBSTACLE, RANGE
    >>> from multisrt.geometry.regions.safe_region import LocalSafeRegion
    >>> corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> tags = np.array([OBSTACLE, RANGE, OBSTACLE, OBSTACLE], np.int8)
    >>> place = Configuration(1.0, 1.0)
    >>> region = LocalSafeRegion(x=1.0, y=1.0, range_m=2.0, boundary=corners, tags=tags)
    >>> root = Node(id=NodeId(0, 0), configuration=place, region=region, parent=None, time_s=0.0)
    >>> known = ExplorationMap(reach_m=2.0, min_arc_m=0.5)
    >>> known.add(root), known.add(root)
    (True, False)
    >>> known.frontier(root.id).tolist(), known.open_frontier_m()
    ([[2.0, 0.0, 2.0, 2.0]], 2.0)
    >>> [node.time_s for node in known.near(1.5, 1.0, 1.0)], known.region_union().area
    ([0.0], 4.0)

    The robot gives its opening up, and another robot hears of all this:

    >>> arc, id = known.frontier(root.id), ClosingId(0, 0)
    >>> known.close(Closing(id=id, node=root.id, arc=arc, reason="too narrow", width_m=0.5))
    True
    >>> known.is_complete()
    True
    >>> other = ExplorationMap(reach_m=2.0, min_arc_m=0.3, robot=1)
    >>> other.merge(known.entries.missing_from(other.entries.have()))
    (NodeId(robot=0, serial=0),)
    >>> other.is_complete()
    False
    """

    __slots__ = (
        "_frontiers",
        "_open",
        "_raster",
        "_regions",
        "_robot",
        "_trees",
        "_width_m",
        "entries",
    )

    def __init__(
        self,
        *,
        reach_m: float,
        min_arc_m: float = 0.0,
        gaps_count: bool = True,
        width_m: float | None = None,
        robot: int | None = None,
    ) -> None:
        self._width_m = min_arc_m if width_m is None else width_m
        self._robot = robot
        self.entries = Entries()
        self._regions = NodeRegions(reach_m)
        self._trees = TreeMembership()
        self._frontiers = LocalFrontiers(self._regions, min_arc_m - ROUNDING_M, gaps_count)
        self._open = OpenFrontiers(self._regions, self._frontiers, self._trees)
        self._raster: Raster | None = None

    def __len__(self) -> int:
        return len(self._regions)

    def __contains__(self, node_id: NodeId) -> bool:
        return node_id in self.entries.nodes

    def __getitem__(self, node_id: NodeId) -> Node:
        return self.entries.nodes[node_id]

    @property
    def nodes(self) -> tuple[Node, ...]:
        """All nodes, in the order in which they became known here."""
        return tuple(self.entries.nodes.values())

    @property
    def closings(self) -> tuple[Closing, ...]:
        """All closings, in the order in which they became known here."""
        return tuple(self.entries.closings.values())

    def add(self, node: Node) -> bool:
        """Add a node, unless it is known.

        Parameters
        ----------
        node : Node
            Its parent need not be known.

        Returns
        -------
        bool
            Whether the node was new.

        Raises
        ------
        InvalidInputError
            If the range of the node's scan is above `reach_m`.
        """
        if node.id in self.entries.nodes:
            return False
        reach_m = self._regions.reach_m
        if node.region.range_m > reach_m + ROUNDING_M:
            raise InvalidInputError(
                f"node {tuple(node.id)} reaches {node.region.range_m} m, but the map was made for "
                f"{reach_m} m: reach_m is the largest range of the team"
            )
        x, y, _ = node.configuration
        neighbours = self._regions.places.within(x, y, 2.0 * reach_m)
        self.entries.add_node(node)
        number = self._regions.add(node)
        changed = self._frontiers.add(number, node.region, neighbours)
        self._open.note_changed(changed.tolist())
        self._open.note_moved(self._trees.add(node.id, node.parent))
        if self._raster is not None:
            self._raster.paint(node.region.boundary)
        return True

    def close(self, closing: Closing) -> bool:
        """Add a closing, unless it is known.

        What lies along the closed arc is no longer frontier of its node, also if the node becomes
        known later. Whether this holds for the own body depends on the reason: arcs seen from
        near are closed for all; those too narrow, where the own body is no narrower; those not
        reachable, for the robot that closed them.

        Parameters
        ----------
        closing : Closing
            Its node need not be known.

        Returns
        -------
        bool
            Whether the closing was new.
        """
        if not self.entries.add_closing(closing):
            return False
        if self._applies(closing):
            changed = self._frontiers.give_up(closing.node, closing.arc)
            self._open.note_changed(changed.tolist())
        return True

    def merge(self, entries: Iterable[Entry]) -> tuple[NodeId, ...]:
        """Add nodes and closings, in any order.

        Parameters
        ----------
        entries : iterable of Node or Closing
            As another robot sends them.

        Returns
        -------
        tuple of NodeId
            The nodes that were new.

        Raises
        ------
        InvalidInputError
            As `add`.
        """
        new = []
        for entry in entries:
            if isinstance(entry, Closing):
                self.close(entry)
            elif self.add(entry):
                new.append(entry.id)
        return tuple(new)

    def roots(self) -> list[NodeId]:
        """Return the roots of all trees, sorted.

        A node whose parent is not known is the root of what grows from it.

        Returns
        -------
        list of NodeId
        """
        return list(self._trees.roots)

    def tree(self, node_id: NodeId) -> NodeId:
        """Return the root at the end of a node's parent links, as far as these are known.

        Parameters
        ----------
        node_id : NodeId
            A known node.

        Returns
        -------
        NodeId
            The root; the node itself if its parent is not known.

        Raises
        ------
        InvalidInputError
            If the node is not known.
        """
        return self._trees.root(node_id)

    def frontier(self, node_id: NodeId) -> FloatArray:
        """Return a node's local frontier.

        Parameters
        ----------
        node_id : NodeId
            A known node.

        Returns
        -------
        (m, 4) array
            Segments x0, y0, x1, y1 in metres, the node's region on their left; read-only.

        Raises
        ------
        KeyError
            If the node is not known.
        """
        return self._frontiers.segments(self._regions.numbers[node_id])

    def frontier_arcs(self, node_id: NodeId) -> list[FloatArray]:
        """Return a node's local frontier arc by arc.

        Parameters
        ----------
        node_id : NodeId
            A known node.

        Returns
        -------
        list of (k, 4) array
            Joined segments x0, y0, x1, y1 in metres, for each arc.

        Raises
        ------
        KeyError
            If the node is not known.
        """
        segments = self.frontier(node_id)
        labels, count = arc_labels(segments)
        return [segments[labels == k] for k in range(count)]

    def has_frontier(self, node_id: NodeId) -> bool:
        """Return whether a node is known and has a local frontier.

        Parameters
        ----------
        node_id : NodeId
            Any node.

        Returns
        -------
        bool
        """
        number = self._regions.numbers.get(node_id)
        return number is not None and self._frontiers.is_open(number)

    def is_complete(self) -> bool:
        """Return whether no node has a local frontier.

        Returns
        -------
        bool
        """
        return self._open.is_empty()

    def open_nodes(self, tree: NodeId | None = None) -> list[NodeId]:
        """Return the nodes that have a local frontier, sorted.

        Parameters
        ----------
        tree : NodeId, optional
            Any node of the tree to look at. Default: all trees.

        Returns
        -------
        list of NodeId

        Raises
        ------
        InvalidInputError
            If the node is not known.
        """
        return self._open.nodes(tree)

    def open_frontier_m(self, tree: NodeId | None = None) -> float:
        """Return the sum of the lengths of local frontiers.

        Parameters
        ----------
        tree : NodeId, optional
            Any node of the tree to look at. Default: all trees.

        Returns
        -------
        float
            Metres.

        Raises
        ------
        InvalidInputError
            If the node is not known.
        """
        return self._open.length_m(tree)

    def near(self, x: float, y: float, radius_m: float) -> list[Node]:
        """Return the nodes within a radius of a place.

        Parameters
        ----------
        x, y, radius_m : float
            The place and the radius in metres.

        Returns
        -------
        list of Node
            Ordered by id.
        """
        found = self._regions.places.within(x, y, radius_m).tolist()
        ids = sorted(self._regions.ids[number] for number in found)
        return [self.entries.nodes[node_id] for node_id in ids]

    def regions_reaching(self, x: float, y: float, half_width_m: float) -> list[LocalSafeRegion]:
        """Return the regions that may reach into a square window: those whose boxes do.

        Parameters
        ----------
        x, y : float
            Centre of the window in metres.
        half_width_m : float
            Half the width of the window in metres.

        Returns
        -------
        list of LocalSafeRegion
            Ordered by the ids of their nodes.
        """
        _, reaching = self._regions.in_window(x, y, half_width_m)
        ids = self._regions.ids
        return [self.entries.nodes[ids[number]].region for number in reaching.tolist()]

    def places_near(self, x: float, y: float, radius_m: float) -> FloatArray:
        """Return the places of the nodes within a radius of a place.

        Parameters
        ----------
        x, y, radius_m : float
            The place and the radius in metres.

        Returns
        -------
        (n, 2) array
            x and y in metres, in the order of `nodes`.
        """
        places = self._regions.places
        return places.points[places.within(x, y, radius_m)]

    def pairs_near(self, first: int, radius_m: float) -> IntArray:
        """Return pairs of a node and one that became known before it and lies within a radius.

        Parameters
        ----------
        first : int
            Position in `nodes` from which on nodes are paired.
        radius_m : float
            Maximum distance of the two in metres, borders included.

        Returns
        -------
        (n, 2) array of int
            Positions in `nodes` of the later and of the earlier node; ordered by the former,
            then by the id of the latter.
        """
        return self._regions.pairs_near(first, radius_m)

    @property
    def places(self) -> FloatArray:
        """The places of all nodes, ``(n, 2)`` in metres, in the order of `nodes`."""
        return self._regions.places.points

    @property
    def rings(self) -> Rings:
        """The boundaries of all nodes' regions, in the order of `nodes`."""
        return self._regions.rings

    def known_space(self, x: float, y: float, half_width_m: float) -> KnownSpace:
        """Return the known space in a square window, for bodies that move in it.

        Parameters
        ----------
        x, y : float
            Centre of the window in metres.
        half_width_m : float
            Half the width of the window in metres.

        Returns
        -------
        KnownSpace
        """
        return self._regions.known_space(x, y, half_width_m)

    def local_union(self, x: float, y: float, half_width_m: float) -> BaseGeometry:
        """Return the union of all nodes' regions in a square window.

        Parameters
        ----------
        x, y : float
            Centre of the window in metres.
        half_width_m : float
            Half the width of the window in metres.

        Returns
        -------
        BaseGeometry
            Polygons of shapely, in metres.
        """
        return self._regions.local_union(x, y, half_width_m)

    def region_union(self) -> BaseGeometry:
        """Return the exact union of all regions.

        Its cost grows with the size of the map.

        Returns
        -------
        BaseGeometry
            Polygons of shapely, in metres.
        """
        return union_on_grid(node.region.polygon() for node in self.nodes)

    def raster(self, cell_m: float) -> Raster:
        """Return a raster of the union of all regions, which `add` keeps up to date.

        Parameters
        ----------
        cell_m : float
            Width of a cell in metres. All regions are repainted when it changes.

        Returns
        -------
        Raster
            The same object at every call with the same width; read-only.
        """
        if self._raster is None or self._raster.cell_m != cell_m:
            self._raster = Raster(cell_m)
            for node in self.nodes:
                self._raster.paint(node.region.boundary)
        return self._raster

    def _applies(self, closing: Closing) -> bool:
        if closing.reason == "seen from near":
            return True
        if closing.reason == "too narrow":
            return self._width_m >= closing.width_m - ROUNDING_M
        return self._robot is None or closing.id.robot == self._robot
