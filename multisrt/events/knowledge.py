"""Events that explorers put on record about what they know: nodes, arcs, and other robots."""

from __future__ import annotations

import itertools
from typing import Final, Literal

import numpy as np

from multisrt.events.event import Event, NodeName, Point, Pose, Segment
from multisrt.geometry.numerics.kernel import FloatArray

Stage = Literal["root", "draw", "approach", "complete", "bypass", "coordinate", "passed", "scan"]
"""How the place of a node was found; see `NodeAdded`."""

ClosingReason = Literal["too narrow", "seen from near", "not reachable"]
"""Why a robot gave up a frontier arc for good; see `ArcClosed`."""

ArcReason = Literal[ClosingReason, "blocked by a robot"]
"""Why a robot gave up a frontier arc, for good or until a body is gone; see `ArcClosed`."""

BLOCKED: Final = "blocked by a robot"
"""The one reason that passes: such an arc is taken up again when the body is gone."""


class NodeAdded(Event, frozen=True, kw_only=True, tag="node"):
    """A robot added a node to its tree.

    Attributes
    ----------
    serial : int
        The serial number of the node among those of its robot.
    parent : (robot, serial) or None
        The node from which the robot came; None for a root.
    configuration : (x, y, heading)
        Where the scan was taken.
    stage : {"root", "draw", "approach", "complete", "bypass", "coordinate", "passed", "scan"}
        How the place was found. `draw`, `approach`, `complete`: by that stage of the planner;
        `bypass`: on a detour around a robot that stands still; `coordinate`: by a master, or where
        a protective stop ended a motion; `passed`: on the way to a chosen place; `scan`: where a
        robot that bids for frontiers took a scan that showed something new.
    boundary : tuple of (x, y)
        Corners of the local safe region, counter-clockwise, not closed.
    tags : str
        One digit for the edge from corner i to corner i + 1: 0 obstacle, 1 range, 2 gap, 3 cut.
    """

    serial: int
    parent: NodeName | None
    configuration: Pose
    stage: Stage
    boundary: tuple[Point, ...]
    tags: str

    def region(self) -> FloatArray:
        """Return the corners of the local safe region as a new array, ``(n, 2)``."""
        numbers = itertools.chain.from_iterable(self.boundary)
        return np.fromiter(numbers, np.float64, 2 * len(self.boundary)).reshape(-1, 2)


class ArcClosed(Event, frozen=True, kw_only=True, tag="arc_closed"):
    """A robot gave up a frontier arc: for good, or `blocked by a robot` until `ArcReopened`.

    Attributes
    ----------
    node : (robot, serial)
        The node of the arc.
    reason : str
        `too narrow`: the body fits nowhere from which the arc can be seen. `not reachable`: it
        would fit, but no known path leads there. `seen from near`: the robot has taken scans from
        every such place, or has set out for the spot `max_views` times and seen hardly more of it.
        `blocked by a robot`: a known path leads there, but past a body that the robot plans around:
        that of a robot that does not answer, that is left out of its group, or that did not clear
        the way; such an arc is left for later, and stays part of the frontier.
    arc : tuple of (x0, y0, x1, y1)
        The segments of the arc.
    """

    node: NodeName
    reason: ArcReason
    arc: tuple[Segment, ...]


class ArcReopened(Event, frozen=True, kw_only=True, tag="arc_reopened"):
    """A robot takes up an arc that was `blocked by a robot`: a body is gone, or responds again."""

    node: NodeName
    arc: tuple[Segment, ...]


class MapComplete(Event, frozen=True, kw_only=True, tag="map_complete"):
    """No frontier is left in the map of a robot, not even behind bodies of other robots.

    For a robot that bids: none that it could reach if no body blocked its path.
    """


class Learned(Event, frozen=True, kw_only=True, tag="learned"):
    """A robot learned of nodes that other robots made.

    Attributes
    ----------
    nodes : tuple of (robot, serial)
        The nodes that were new to it.
    """

    nodes: tuple[NodeName, ...]


class PresumedLost(Event, frozen=True, kw_only=True, tag="taken_as_lost"):
    """A robot no longer waits for another one, which has not answered for too long.

    Attributes
    ----------
    other : int
        The robot that did not answer.
    """

    other: int
