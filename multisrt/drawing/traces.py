"""What each robot did in a run, sorted out for drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from multisrt.events import ArcClosed, Collision, Motion, NodeAdded, Point, Segment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.kernel import FloatArray
from multisrt.recording import Recording
from multisrt.remaining_frontier import remaining_frontier

JOINED_M = 1e-6
"""Segments are one line where one begins within this of the other's end."""


@dataclass(slots=True, kw_only=True)
class Trace:
    """What one robot did.

    Attributes
    ----------
    robot : int
        Its number, from 0.
    start : Configuration
        Where it started.
    nodes : dict
        The nodes of its tree by serial number, in the order in which they were added.
    motions, closed, collisions : list of events
        What else happened to it, in order.
    frontier : tuple of segments
        What frontier it left open.
    """

    robot: int
    start: Configuration
    nodes: dict[int, NodeAdded] = field(default_factory=dict)
    motions: list[Motion] = field(default_factory=list)
    closed: list[ArcClosed] = field(default_factory=list)
    collisions: list[Collision] = field(default_factory=list)
    frontier: tuple[Segment, ...] = ()

    @property
    def end(self) -> Configuration:
        """Where it was at last."""
        if not self.motions:
            return self.start
        return Configuration(*self.motions[-1].waypoints[-1][1:])

    @property
    def path(self) -> FloatArray:
        """Where it went, as ``(n, 2)`` points."""
        points = [(self.start.x, self.start.y)]
        points += [(x, y) for motion in self.motions for _, x, y, _ in motion.waypoints]
        return np.asarray(points)

    @property
    def distance_m(self) -> float:
        """How far it went."""
        return float(np.hypot(*np.diff(self.path, axis=0).T).sum())

    def edges(self) -> list[tuple[Point, Point]]:
        """Give the places of parent and child for every edge of its tree."""
        return [
            (self.nodes[node.parent].configuration[:2], node.configuration[:2])
            for node in self.nodes.values()
            if node.parent is not None
        ]

    def is_off_tree(self) -> bool:
        """Whether it also went otherwise than straight along the edges of its tree."""
        edges = {frozenset(map(_rounded, edge)) for edge in self.edges()}
        legs = (frozenset(map(_rounded, leg)) for leg in pairwise(self.path.tolist()))
        return any(len(leg) == 2 and leg not in edges for leg in legs)


def traces_of(recording: Recording) -> list[Trace]:
    """Sort a recording's events by robot.

    Raises
    ------
    InvalidInputError
        If an event is of a robot that is not in the team, a node's parent is not in the tree,
        or a region is none; the message names the node.
    """
    if len(recording.starts) != len(recording.spec.robots):
        raise InvalidInputError(
            f"the recording has {len(recording.starts)} starts for a team of "
            f"{len(recording.spec.robots)}"
        )
    traces = [Trace(robot=k, start=start) for k, start in enumerate(recording.starts)]
    for event in recording.events:
        if not 0 <= event.robot < len(traces):
            raise InvalidInputError(
                f"the recording tells of robot {event.robot}, but its team has {len(traces)}, "
                "counted from 0"
            )
        trace = traces[event.robot]
        match event:
            case NodeAdded():
                _require_sound(event, trace)
                trace.nodes[event.serial] = event
            case Motion() if event.waypoints:
                trace.motions.append(event)
            case ArcClosed():
                _require_known(event.node, trace, "closes an arc of")
                trace.closed.append(event)
            case Collision():
                trace.collisions.append(event)
    for robot, segments in remaining_frontier(recording).items():
        traces[robot].frontier = segments
    return traces


def joined(segments: tuple[Segment, ...]) -> list[list[Point]]:
    """Join segments into lines where one begins at the other's end.

    Examples
    --------
    >>> joined(((0, 0, 1, 0), (1, 0, 1, 1), (5, 5, 6, 5)))
    [[(0, 0), (1, 0), (1, 1)], [(5, 5), (6, 5)]]
    """
    lines: list[list[Point]] = []
    for x0, y0, x1, y1 in segments:
        if not lines or abs(lines[-1][-1][0] - x0) + abs(lines[-1][-1][1] - y0) > JOINED_M:
            lines.append([(x0, y0)])
        lines[-1].append((x1, y1))
    return lines


def median_edge_m(traces: list[Trace]) -> float | None:
    """Give the median length of all trees' edges; None if there are none."""
    edges = np.asarray([edge for trace in traces for edge in trace.edges()])
    if not len(edges):
        return None
    return float(np.median(np.hypot(*(edges[:, 1] - edges[:, 0]).T)))


def _rounded(place: Sequence[float]) -> tuple[float, ...]:
    return tuple(round(value, 6) for value in place)


def _require_sound(node: NodeAdded, trace: Trace) -> None:
    name = f"node {node.serial} of robot {node.robot}"
    if node.serial in trace.nodes:
        raise InvalidInputError(f"the recording adds {name} twice")
    if node.parent is not None:
        _require_known(node.parent, trace, f"gives {name} as parent")
    if len(node.boundary) < 3 or len(node.boundary) != len(node.tags):
        raise InvalidInputError(
            f"the recording gives the region of {name} {len(node.boundary)} corners and "
            f"{len(node.tags)} tags; a region has at least 3 corners, and a tag for each"
        )
    if not set(node.tags) <= set("0123"):
        raise InvalidInputError(
            f"the recording gives the region of {name} the tags {node.tags!r}; "
            "tags are digits from 0 to 3"
        )


def _require_known(serial: int, trace: Trace, doing: str) -> None:
    if serial not in trace.nodes:
        raise InvalidInputError(
            f"the recording {doing} node {serial}, which is not in the tree of robot {trace.robot}"
        )
