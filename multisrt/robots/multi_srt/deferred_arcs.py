"""Frontier arcs that a robot defers because bodies of other robots block the path to them.

A body blocks the path only for a time, so such an arc is not closed but stays open in the map. The
robot that could not get there leaves it out of its plans until one of the bodies is gone. While an
arc is deferred, the map of this robot is not complete.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import shapely

from multisrt.geometry.numerics.kernel import BoolArray, FloatArray
from multisrt.geometry.regions.frontier_arcs import arc_labels, total_length
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.explorer import Sighting
from multisrt.robots.knowledge import NodeId
from multisrt.robots.local_frontiers import ON_ARC_M
from multisrt.robots.multi_srt.obstacles import UNMOVED_M, is_gone
from multisrt.robots.multi_srt.roster import Roster


@dataclass(slots=True, eq=False)
class _Body:
    # A body that bars paths, where it was seen; whether its robot could be asked to leave then;
    # whether it was asked since if it is still there; and whether it is gone.
    sighting: Sighting
    responded: bool
    was_asked: bool = False
    is_gone: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class _Deferral:
    arc: FloatArray
    bodies: tuple[_Body, ...]

    @property
    def is_over(self) -> bool:
        return any(body.is_gone for body in self.bodies)


class DeferredArcs:
    """The frontier of a robot's map without what bodies bar, and what becomes of the rest.

    A body is gone when it is seen elsewhere, when its place is in sight and empty, when its robot
    says that it moves or stands elsewhere, and when a robot that did not respond does so again.

    The arcs of one node are opened again at most `max_reopenings` times: robots that give way to
    each other by turns would otherwise try the same forever. After that they are left for good,
    but stay open in the map.

    Parameters
    ----------
    known : ExplorationMap
        The robot's map.
    roster : Roster
        What it knows of the other robots.
    max_reopenings : int
        How many times the arcs of a node are opened again.
    """

    def __init__(self, known: ExplorationMap, roster: Roster, max_reopenings: int) -> None:
        self._map = known
        self._roster = roster
        self._max_reopenings = max_reopenings
        self._deferred: dict[NodeId, list[_Deferral]] = {}
        self._standing: dict[int, _Body] = {}
        self._reopened: Counter[NodeId] = Counter()

    # The frontier without these arcs -------------------------------------------------------

    def frontier(self, node: NodeId) -> FloatArray:
        """Return the segments ``(m, 4)`` of a node's local frontier that are not left for later."""
        segments = self._map.frontier(node)
        if node not in self._deferred:
            return segments
        return segments[~self._are_deferred(node, segments)]

    def arcs(self, node: NodeId) -> list[FloatArray]:
        """Return the same arc by arc."""
        segments = self.frontier(node)
        labels, count = arc_labels(segments)
        return [segments[labels == k] for k in range(count)]

    def has_frontier(self, node: NodeId) -> bool:
        """Whether a node is known and has a local frontier that is not left for later."""
        if node not in self._deferred:
            return self._map.has_frontier(node)
        return len(self.frontier(node)) > 0

    def open_m(self, tree: NodeId) -> float:
        """Return the length of such frontier in the tree of a node, in metres."""
        nodes = self._map.open_nodes(tree)
        if self._deferred.keys().isdisjoint(nodes):
            return self._map.open_frontier_m(tree)
        return math.fsum(total_length(self.frontier(node)) for node in nodes)

    # What is left for later, and opened again ----------------------------------------------

    def defer(self, node: NodeId, arc: FloatArray, bodies: Mapping[int, Sighting]) -> None:
        """Leave a frontier arc ``(k, 4)`` of a node for later, until one of the bodies is gone."""
        there = tuple(self._body(bodies[number]) for number in sorted(bodies))
        self._deferred.setdefault(node, []).append(_Deferral(arc, there))

    def notice(self, seen: tuple[Sighting, ...], view: FloatArray | None) -> None:
        """Take in which bodies are in sight; see `Obstacles.forget_gone`."""
        in_sight = {sighting.robot: sighting for sighting in seen}
        for body in list(self._standing.values()):
            if is_gone(body.sighting, in_sight, view):
                self._note_gone(body)

    def is_due(self) -> bool:
        """Whether an arc is to be opened again."""
        self._hear()
        return any(
            deferral.is_over
            for node, deferrals in self._deferred.items()
            if self._reopened[node] < self._max_reopenings
            for deferral in deferrals
        )

    def take_back(self) -> list[tuple[NodeId, FloatArray]]:
        """Open the arcs again that a body no longer bars; return them, with their nodes."""
        if not self.is_due():
            return []
        taken: list[tuple[NodeId, FloatArray]] = []
        for node, deferrals in list(self._deferred.items()):
            over = [deferral.arc for deferral in deferrals if deferral.is_over]
            if not over or self._reopened[node] >= self._max_reopenings:
                continue
            self._reopened[node] += 1
            taken += [(node, arc) for arc in over]
            self._deferred[node] = [deferral for deferral in deferrals if not deferral.is_over]
            if not self._deferred[node]:
                del self._deferred[node]
        return taken

    def left(self) -> tuple[float, list[int]]:
        """Return what is left for later.

        Returns
        -------
        length_m : float
            Length of the frontier to which bodies block the path, in metres.
        robots : list of int
            The robots whose bodies these are, in rising order.
        """
        lengths_m, robots = [], set[int]()
        for node, deferrals in self._deferred.items():
            segments = self._map.frontier(node)
            lengths_m.append(total_length(segments[self._are_deferred(node, segments)]))
            for deferral in deferrals:
                if _lie_along(deferral.arc, segments).any():
                    robots.update(body.sighting.robot for body in deferral.bodies)
        return math.fsum(lengths_m), sorted(robots)

    def to_ask(self) -> list[int]:
        """Return the robots in the way that are believed to answer, each body only once."""
        asked = []
        for number in self.left()[1]:
            body = self._standing.get(number)
            if body is not None and not body.was_asked and self._roster.answers(number):
                body.was_asked = True
                asked.append(number)
        return asked

    def _are_deferred(self, node: NodeId, segments: FloatArray) -> BoolArray:
        # Frontier is only ever cut off, so a piece lies along an arc as a whole or not at all.
        deferrals = self._deferred.get(node)
        if not deferrals or not len(segments):
            return np.zeros(len(segments), np.bool_)
        return _lie_along(np.concatenate([deferral.arc for deferral in deferrals]), segments)

    def _body(self, sighting: Sighting) -> _Body:
        number = sighting.robot
        known = self._standing.get(number)
        if known is not None:
            if not is_gone(known.sighting, {number: sighting}, None):
                return known
            self._note_gone(known)
        body = self._standing[number] = _Body(sighting, self._roster.responds(number))
        return body

    def _hear(self) -> None:
        # Note the bodies that are gone by the reports of their robots, or of others.
        for number, body in list(self._standing.items()):
            if not self._roster.responds(number):
                continue
            state, (x, y, _) = self._roster.states[number], body.sighting.configuration
            moves = state.phase == "moving" or math.dist(state.place[:2], (x, y)) > UNMOVED_M
            if moves or not body.responded:
                self._note_gone(body)

    def _note_gone(self, body: _Body) -> None:
        body.is_gone = True
        del self._standing[body.sighting.robot]


def _lie_along(arc: FloatArray, segments: FloatArray) -> BoolArray:
    # Which segments have their middle on an arc.
    line = shapely.MultiLineString(list(arc.reshape(-1, 2, 2)))
    middles = shapely.points(0.5 * (segments[:, :2] + segments[:, 2:]))
    return np.asarray(shapely.dwithin(line, middles, ON_ARC_M), np.bool_)
