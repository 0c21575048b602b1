"""The trees that a robot knows: its own, and those of others (paper: T and all T_i)."""

from __future__ import annotations

from collections.abc import Mapping

from multisrt.events import (
    BLOCKED,
    ArcClosed,
    ArcReason,
    ArcReopened,
    ClosingReason,
    MapComplete,
    Segment,
)
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.explorer import Note, RobotSelf, Sighting, Steps
from multisrt.robots.knowledge import Closing, ClosingId, Node, NodeId
from multisrt.robots.multi_srt.deferred_arcs import DeferredArcs
from multisrt.robots.multi_srt.roadmap import OutAndBack, SrtRoadmap
from multisrt.robots.multi_srt.targets import Step
from multisrt.robots.multi_srt.whereabouts import Whereabouts


class Trees:
    """What a robot adds to its map, and which frontier is left in it.

    Every change is recorded: the methods that make one are procedures of an explorer.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    at : Whereabouts
        Where it is.
    known : ExplorationMap
        Its map.
    roadmap : SrtRoadmap
        Its roadmap.
    deferred : DeferredArcs
        The arcs that it leaves for later.

    Attributes
    ----------
    root : NodeId
        Root of its own tree.
    reopened : list of NodeId
        Nodes of which arcs were opened again since the robot last chose a tree to support.
    """

    def __init__(
        self,
        me: RobotSelf,
        at: Whereabouts,
        known: ExplorationMap,
        roadmap: SrtRoadmap,
        deferred: DeferredArcs,
    ) -> None:
        self.me = me
        self.at = at
        self.map = known
        self.roadmap = roadmap
        self.deferred = deferred
        self.root = NodeId(me.robot, 0)
        self.reopened: list[NodeId] = []
        self._nodes = 0
        self._closings = 0
        self._told_complete = False

    def add(self, region: LocalSafeRegion, came: Step | None) -> Steps:
        """ADD: the current configuration and its region as a node, which is where the robot is.

        Parameters
        ----------
        region : LocalSafeRegion
            The region perceived.
        came : Step or None
            The step that led there; None at the root.
        """
        node = self._new_node(region, None if came is None else came.parent)
        self.at.here = node.id
        self.roadmap.add(
            node, None if came is None else came.out_and_back, came is not None and came.roomy
        )
        yield Note(node.added("root" if came is None else came.stage))
        yield from self.tell_when_complete()

    def add_passing(self, region: LocalSafeRegion, step: Step, driven: Trajectory) -> Steps:
        """ADD: a scan taken on the way to a new place as a node; the robot continues.

        A car that cannot reverse knows no motion back from there: the node has no edge yet.
        """
        node = self._new_node(region, step.parent)
        back = driven.reversed() if self.roadmap.is_car else None
        came = OutAndBack(driven, back) if self.roadmap.can_reverse else None
        self.roadmap.add(node, came, step.roomy)
        yield Note(node.added("passed"))

    def _new_node(self, region: LocalSafeRegion, parent: NodeId | None) -> Node:
        node = Node(
            id=NodeId(self.me.robot, self._nodes),
            configuration=self.at.q_act,
            region=region,
            parent=parent,
            time_s=self.at.time_s,
        )
        self._nodes += 1
        self.map.add(node)
        return node

    def close(self, node: NodeId, arc: FloatArray, reason: ClosingReason) -> Steps:
        """Give up a frontier arc ``(k, 4)`` of a node for a reason that lasts."""
        self.map.close(
            Closing(
                id=ClosingId(self.me.robot, self._closings),
                node=node,
                arc=arc,
                reason=reason,
                width_m=self.me.footprint.width_m,
            )
        )
        self._closings += 1
        yield self._closed(node, arc, reason)

    def defer(self, node: NodeId, arc: FloatArray, bodies: Mapping[int, Sighting]) -> Steps:
        """Leave a frontier arc ``(k, 4)`` of a node for later, as bodies block the path."""
        self.deferred.defer(node, arc, bodies)
        yield self._closed(node, arc, BLOCKED)

    def reopen(self) -> Steps:
        """Take up the arcs again to which no body blocks the path any more."""
        for node, arc in self.deferred.take_back():
            self.reopened.append(node)
            yield Note(
                ArcReopened(
                    time_s=self.at.time_s,
                    robot=self.me.robot,
                    node=node,
                    arc=segments_of(arc),
                )
            )

    def _closed(self, node: NodeId, arc: FloatArray, reason: ArcReason) -> Note:
        return Note(
            ArcClosed(
                time_s=self.at.time_s,
                robot=self.me.robot,
                node=node,
                reason=reason,
                arc=segments_of(arc),
            )
        )

    def tell_when_complete(self) -> Steps:
        """Record, once, that there is no frontier left in the map, not even behind bodies."""
        here = self.at.here
        if self._told_complete or (here is not None and self.map.has_frontier(here)):
            return
        if self.map.is_complete():
            self._told_complete = True
            yield Note(MapComplete(time_s=self.at.time_s, robot=self.me.robot))

    def may_extend(self, node: NodeId) -> bool:
        """Whether a node of the tree that the robot extends has frontier that no body bars."""
        if self.at.tree is None or not self.deferred.has_frontier(node):
            return False
        return self.map.tree(node) == self.map.tree(self.at.tree)


def segments_of(segments: FloatArray) -> tuple[Segment, ...]:
    """Return segments ``(k, 4)`` as events hold them."""
    return tuple((x0, y0, x1, y1) for x0, y0, x1, y1 in segments.tolist())
