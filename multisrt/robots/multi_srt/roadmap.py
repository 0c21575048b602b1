"""Motions of one robot's body: between nodes of its roadmap, and from a node to a new place."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.overlay import union_on_grid
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.car import MAX_SEED, Checks, car_out_and_back, shortest_curves
from multisrt.planners.motion.kinematics import Car, Holonomic, turns_between
from multisrt.planners.motion.roadmap import Roadmap
from multisrt.planners.motion.steering import steer, turn_and_drive
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.exploration_map import ExplorationMap, Node, NodeId
from multisrt.robots.explorer import RobotSelf

Passable = Callable[[NodeId, NodeId], bool]

ALONG_RAD: Final = 1e-6
"""A body that faces an edge to this, in radians, is not turned before it drives along it."""


class OutAndBack(NamedTuple):
    """A motion to a place, and the motion back.

    Attributes
    ----------
    out : Trajectory
        The motion to the place.
    back : Trajectory or None
        The motion back, for a body that has to retrace its path; None: the roadmap has one.
    """

    out: Trajectory
    back: Trajectory | None = None


class SrtRoadmap:
    """The roadmap of one robot, and how its body follows the edges.

    Where the body fits in any heading, it turns and drives straight. In a narrow place a body
    that is not a disc retraces the motion on which it first came. A car stands at every node in the
    heading in which it first came there, and keeps for every edge the motions in both
    directions: a car that cannot turn round goes back as it came, and one that cannot reverse
    goes only where it knows a path back.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    body : PlanningBody
        Its body.
    known : ExplorationMap
        Its map.

    Attributes
    ----------
    graph : Roadmap of NodeId
        Nodes, and edges between those that the body can go between.
    """

    def __init__(self, me: RobotSelf, body: PlanningBody, known: ExplorationMap) -> None:
        self.me = me
        self.body = body
        self.map = known
        self.graph: Roadmap[NodeId] = Roadmap()
        self._seen = 0
        # Edges on which the body does not fit in every heading, as far as known, both ways.
        self._narrow: set[tuple[NodeId, NodeId]] = set()
        self._has_room: set[NodeId] = set()
        self._turns: dict[NodeId, float] = {}
        self._driven: dict[tuple[NodeId, NodeId], Trajectory] = {}
        self._planned: dict[tuple[float, float], OutAndBack] = {}

    @property
    def is_car(self) -> bool:
        """Whether the body moves as a car does."""
        return isinstance(self.me.kinematics, Car)

    @property
    def can_reverse(self) -> bool:
        """Whether the body can retrace a motion backwards."""
        return not isinstance(self.me.kinematics, Car) or self.me.kinematics.reverse

    # The roadmap -----------------------------------------------------------------------

    def add(self, node: Node, out_and_back: OutAndBack | None, roomy: bool) -> None:
        """Add a node of the robot's own, and the edge from its parent.

        Parameters
        ----------
        node : Node
            The node.
        out_and_back : OutAndBack or None
            The motion on which the robot came from the parent; None at a root.
        roomy : bool
            Whether the body fits in any heading all along that motion.
        """
        self._place(node)
        self._planned.clear()
        if self.body.has_room(node.region.boundary, node.configuration):
            self._has_room.add(node.id)
        if node.parent is None or out_and_back is None:
            return
        parent = self.map[node.parent]
        self._place(parent)  # of another robot, it may have been heard of since `extend`
        self.graph.connect(parent.id, node.id)
        first, last = out_and_back.out.waypoints[0], out_and_back.out.waypoints[-1]
        aside = _turn_to_line(node.configuration, *parent.configuration[:2])
        self._turns[node.id] = last.heading - first.heading + aside
        if out_and_back.back is not None:
            self._driven[parent.id, node.id] = out_and_back.out
            self._driven[node.id, parent.id] = out_and_back.back
        elif roomy:
            self._has_room.update((parent.id, node.id))
        else:
            self._narrow.update(((parent.id, node.id), (node.id, parent.id)))

    def extend(self) -> None:
        """Add bridges for the nodes that are new in the map: straight paths from node to node.

        On a bridge the body goes as far as it gets in the region of one node, and on in that of
        the other. Trees of other robots are joined, too: their edges are such paths. No bridge is
        longer than the sensing range, by which groups of robots that may meet are found.
        """
        if len(self.map) == self._seen:
            return
        nodes = self.map.nodes
        for node in nodes[self._seen :]:
            self._place(node)
        # Every pair is considered once, when the later of the two nodes is new.
        pairs = self.map.pairs_near(self._seen, self.me.range_m)
        self._seen = len(nodes)
        unknown = [not self._is_settled(nodes[a].id, nodes[b].id) for a, b in pairs.tolist()]
        pairs = pairs[np.array(unknown, np.bool_)]
        joined = self.body.bridges(self.map.places, self.map.rings, pairs)
        for a, b in pairs[joined].tolist():
            self._bridge(nodes[a], nodes[b])

    def path(
        self, start: NodeId, end: NodeId, passable: Passable | None = None
    ) -> list[NodeId] | None:
        """Return the shortest route between two nodes, both included, or None."""
        return self.graph.path(start, end, passable)

    def to_nearest(
        self, start: NodeId, wanted: Callable[[NodeId], bool], passable: Passable | None = None
    ) -> list[NodeId] | None:
        """Return the shortest route to any of the wanted nodes, or None."""
        return self.graph.path_to_nearest(start, wanted, passable)

    def _is_settled(self, a: NodeId, b: NodeId) -> bool:
        # Whether there is an edge that no bridge would improve.
        return self.graph.joins(a, b) and (a, b) not in self._narrow

    def _place(self, node: Node) -> None:
        self.graph.add(node.id, node.configuration.x, node.configuration.y)

    def _bridge(self, a: Node, b: Node) -> None:
        if isinstance(self.me.kinematics, Car):
            region = union_on_grid([a.region.polygon(), b.region.polygon()])
            curves = shortest_curves(
                self.body, self.me.kinematics, region, a.configuration, b.configuration
            )
            if curves is None:
                return
            self._driven[a.id, b.id], self._driven[b.id, a.id] = curves
            self.graph.connect(a.id, b.id)
        else:
            self.join(a.id, b.id)

    def join(self, a: NodeId, b: NodeId) -> None:
        """Add an edge: a straight path on which the body fits in any heading.

        `extend` has added both nodes.
        """
        self.graph.connect(a, b)
        self._narrow.difference_update(((a, b), (b, a)))
        self._has_room.update((a, b))

    # Motions -----------------------------------------------------------------------------

    def to_place(
        self, at: Configuration, boundary: FloatArray, x: float, y: float, roomy: bool = False
    ) -> OutAndBack | None:
        """Return the motion to a place in a region; None where the body does not get there.

        Parameters
        ----------
        at : Configuration
            Where the motion begins.
        boundary : (n, 2) array
            Boundary of the region, in metres.
        x, y : float
            The place.
        roomy : bool
            Whether it is known that the body fits in any heading all along.
        """
        drive = self.me.kinematics
        if isinstance(drive, Car):
            if (x, y) not in self._planned and not self._plans(at, boundary, x, y):
                return None
            return self._planned[x, y]
        if roomy or self.body.is_disc:
            return OutAndBack(turn_and_drive(drive, at, x, y))
        motion = steer(self.body, drive, boundary, at, x, y)
        return None if motion is None else OutAndBack(motion)

    def leads(self, node: Node, known: BaseGeometry, x: float, y: float, checks: Checks) -> bool:
        """Whether a car gets from a node to a place and back within a part of the known space."""
        return self._plans(node.configuration, known, x, y, checks)

    def _plans(
        self,
        at: Configuration,
        region: FloatArray | BaseGeometry,
        x: float,
        y: float,
        checks: Checks | None = None,
    ) -> bool:
        assert isinstance(self.me.kinematics, Car)
        seed = int(self.me.rng.integers(1, MAX_SEED))
        found = car_out_and_back(
            self.body, self.me.kinematics, region, at, x, y, seed, checks=checks
        )
        if found is None:
            return False
        self._planned[x, y] = OutAndBack(*found)
        return True

    def hop(self, at: Configuration, a: NodeId, b: NodeId) -> Trajectory:
        """Return the motion along an edge from node `a` to `b`, from the configuration at `a`."""
        driven = self._driven.get((a, b))
        if driven is not None:
            return driven
        start, end = self.map[a], self.map[b]
        x, y, _ = end.configuration
        drive = self.me.kinematics
        assert not isinstance(drive, Car)
        if (
            self.body.is_disc
            or isinstance(drive, Holonomic)
            or self._is_settled(a, b)
            or self._is_wide(start, end)
        ):
            return turn_and_drive(drive, at, x, y)
        child, parent = (end, start) if end.parent == a else (start, end)
        aside = _turn_to_line(child.configuration, *parent.configuration[:2])
        if a in self._has_room:
            along = child.configuration.heading + aside
            turned = drive.turn(at, turns_between(at.heading, along)[0])
        elif child is end:
            turned = drive.turn(at, self._turns[b])
        else:
            turned = drive.turn(at, aside)
        motion = turned.then(drive.drive(turned.end, x, y))
        if child is start and b not in self._has_room:
            return motion.then(drive.turn(motion.end, -self._turns[a]))
        return motion

    def knows_hop(self, a: NodeId, b: NodeId) -> bool:
        """Whether this robot knows a motion from one node straight to another; see `hop`.

        An edge of another robot's roadmap proves nothing: that robot's body may be smaller.
        """
        if isinstance(self.me.kinematics, Car):
            return (a, b) in self._driven
        self.extend()
        return self.graph.joins(a, b)

    def _is_wide(self, a: Node, b: Node) -> bool:
        # Whether the body fits in any heading on the edge of the tree between two nodes.
        if a.id not in self._has_room or b.id not in self._has_room:
            return False
        parent, child = (a, b) if b.parent == a.id else (b, a)
        (px, py, _), (cx, cy, _) = parent.configuration, child.configuration
        return self.body.disc_travel(parent.region.boundary, px, py, cx, cy)


def _turn_to_line(at: Configuration, x: float, y: float) -> float:
    """Return the smallest turn to face a place or its opposite; 0 but where a turn was ended.

    A body comes to a child of a node along the edge, forwards or backwards. Only where the
    protective stop has ended a turn after that is it turned a little away from the edge. Where it
    has ended a turn before the edge, the child is where its parent is, and there is no such line.
    """
    if (at.x, at.y) == (x, y):
        return 0.0
    ahead = math.atan2(y - at.y, x - at.x)
    turns = (wrap_angle(ahead - at.heading), wrap_angle(ahead + math.pi - at.heading))
    turn = min(turns, key=abs)
    return turn if abs(turn) > ALONG_RAD else 0.0
