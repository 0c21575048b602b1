"""The path of one robot to its target, step by step."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from multisrt.events import Purpose
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.knowledge import Node
from multisrt.robots.multi_srt.messages import Order, motion_of
from multisrt.robots.multi_srt.roadmap import OutAndBack, SrtRoadmap
from multisrt.robots.multi_srt.targets import Interrupted, KnownNode, NewPlace, Step, Target
from multisrt.robots.multi_srt.whereabouts import Whereabouts

NEW_PLACE_M: Final = 0.05
"""Distance in metres from all places visited in a task, from which on a place is new."""


class Journey:
    """The current target of a robot, and the motions that lead there.

    Parameters
    ----------
    at : Whereabouts
        Where the robot is.
    known : ExplorationMap
        Its map.
    roadmap : SrtRoadmap
        Its roadmap.

    Attributes
    ----------
    target : Target or None
        The target, as long as it has not been reached.
    came : Step or None
        The last step made.
    interrupted : Interrupted or None
        The motion in which a car stands that cannot reverse and was boxed in.
    purpose : Purpose
        Why the robot moves, for the record.
    """

    def __init__(self, at: Whereabouts, known: ExplorationMap, roadmap: SrtRoadmap) -> None:
        self.target: Target | None = None
        self.came: Step | None = None
        self.interrupted: Interrupted | None = None
        self.purpose: Purpose = "explore"
        self._been: list[tuple[float, float]] = []
        self._at = at
        self._map = known
        self._roadmap = roadmap

    def begin(self, purpose: Purpose) -> None:
        """Begin a task: to extend a tree, or to go to a node."""
        self.target = None
        self.purpose = purpose
        self._been.clear()

    def note_here(self) -> None:
        """Record that the robot has been here in this task."""
        if self.is_at_new_place:
            self._been.append(self._at.q_act[:2])

    @property
    def is_at_new_place(self) -> bool:
        """Whether the robot has not been here in this task.

        Places count, not nodes: a robot that is sent back from the same place again and again
        may add a node there each time.
        """
        here = self._at.q_act[:2]
        return all(math.dist(here, place) >= NEW_PLACE_M for place in self._been)

    def place_of(self, target: Target | None) -> tuple[float, float] | None:
        """Return the position of a target in metres; None for none."""
        if target is None:
            return None
        if isinstance(target, NewPlace):
            return target.x, target.y
        x, y, _ = self._map[target.route[-1]].configuration
        return x, y

    def past_here(self, target: Target) -> Target | None:
        """Return the remainder of a target after the nodes at the very place of the robot.

        These count as reached: a motion without length cannot be distinguished from standing, and
        no master would let the robot go. None, if the target itself is one of them.
        """
        at = self._at
        while len(target.route) > 1:
            a, b = target.route[:2]
            is_here = self._map[b].configuration[:2] == at.q_act[:2]
            if not is_here or len(self._roadmap.hop(at.q_act, a, b).waypoints) > 1:
                return target
            at.here = b
            target = replace(target, route=target.route[1:])
        return None if isinstance(target, KnownNode) else target

    def step_to(self, target: Target, frontier_m: float = 0.0) -> Step:
        """Return the next step towards a target, made for a frontier of this length."""
        a = target.route[0]
        if len(target.route) > 1:
            b = target.route[1]
            is_last = isinstance(target, KnownNode) and len(target.route) == 2
            return Step(
                out_and_back=OutAndBack(self._roadmap.hop(self._at.q_act, a, b)),
                node=b,
                rest=None if is_last else replace(target, route=target.route[1:]),
                parent=a,
                frontier_m=frontier_m,
            )
        assert isinstance(target, NewPlace)
        boundary = self._map[a].region.boundary
        motion = self._roadmap.to_place(self._at.q_act, boundary, target.x, target.y, target.roomy)
        if motion is None:
            raise AssertionError(f"no path to ({target.x}, {target.y}), which was found free")
        return Step(
            out_and_back=motion,
            node=None,
            parent=a,
            stage=target.stage,
            roomy=target.roomy,
            frontier_m=frontier_m,
        )

    def step_by(self, order: Order, planned: Step | None) -> Step | None:
        """Return the step that carries out a master's order; None: the robot waits.

        Parameters
        ----------
        order : Order
            The order.
        planned : Step or None
            What the robot itself has planned.
        """
        here = self._at.here
        if order.order == "keep":
            return planned
        if order.order == "wait" or here is None or self.interrupted is not None:
            return None
        if order.node is not None:
            if not self._roadmap.knows_hop(here, order.node):
                return None
            return Step(
                out_and_back=OutAndBack(self._roadmap.hop(self._at.q_act, here, order.node)),
                node=order.node,
                parent=here,
                order=order.order,
            )
        # A detour: from the new place the robot continues to where it was going.
        target = self.target
        rest = None
        if order.order == "new target" and target is not None:
            rest = target if len(target.route) == 1 else replace(target, route=target.route[1:])
        return Step(
            out_and_back=OutAndBack(motion_of(order.path)),
            node=None,
            rest=rest,
            parent=here,
            stage="coordinate",
            order=order.order,
        )

    def resume(self) -> None:
        """At a new node on a detour, go on to the old target where a straight path leads to it."""
        target, here = self.target, self._at.node
        if target is None or target.route[0] == here:
            return
        self.target = None
        node = self._map[here]
        seen = [n.region.boundary for n in (node, *self._parent(node))]
        if isinstance(target, NewPlace) and len(target.route) == 1:
            # Where the new node has a frontier, the planner chooses again.
            if self._map.has_frontier(here) or self._roadmap.is_car:
                return
            if any(self._goes_straight(around, target.x, target.y) for around in seen):
                self.target = replace(target, route=(here,), roomy=True)
            return
        self._roadmap.extend()
        following = target.route[0]
        if not self._roadmap.graph.joins(here, following) and not self._roadmap.is_car:
            x, y, _ = self._map[following].configuration
            if any(self._goes_straight(around, x, y) for around in seen):
                self._roadmap.join(here, following)
        if self._roadmap.graph.joins(here, following):
            self.target = replace(target, route=(here, *target.route))

    def _parent(self, node: Node) -> list[Node]:
        return [] if node.parent is None else [self._map[node.parent]]

    def _goes_straight(self, boundary: FloatArray, x: float, y: float) -> bool:
        # In the region of any node, in any heading.
        q = self._at.q_act
        return self._roadmap.body.disc_travel(boundary, q.x, q.y, x, y)
