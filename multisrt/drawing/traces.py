"""The events of a run by robot, prepared for drawing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from multisrt.analysis.remaining_frontier import arcs_given_up, remaining_frontier
from multisrt.events import (
    ArcClosed,
    BaseLearned,
    Blocked,
    Collision,
    Died,
    GoalChosen,
    Motion,
    NodeAdded,
    NodeName,
    Point,
    Purpose,
    Segment,
    Sent,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.trajectory import leg_length, leg_points
from multisrt.recording import Recording
from multisrt.spec import LateStart

JOINED_M = 1e-6
"""Segments are joined if one begins within this distance (m) of the end of the other."""

SUPPORTING: Final[tuple[Purpose, ...]] = ("support", "home")
"""Purposes of the motions of a robot that has completed its own tree."""

Edge = tuple[Point, Point]
"""The points of parent and child, in metres."""


@dataclass(slots=True, kw_only=True)
class Trace:
    """The events of one robot.

    Attributes
    ----------
    robot : int
        Number of the robot, from 0.
    start : Configuration
        Its start.
    late : bool
        Whether it was switched on late.
    nodes : dict from int to NodeAdded
        Its nodes by serial number, in the order in which they were added.
    edges : dict from int to list of Edge
        The edges to its nodes, by the robot that owns the root of their tree.
    motions, closed, stops, collisions : list of events
        Its other events, in order; `closed` without the arcs that it took up again.
    death : Died or None
        Its death.
    frontier : tuple of Segment
        The frontier that it left open.
    supporting : list of (n, 2) array
        Its paths to, along and back from the trees of other robots.
    bridges : list of (n, 2) array
        Its paths between nodes that no edge joins, each once.
    off_tree : list of (n, 2) array
        Its other paths, off the edges and bridges, each once.
    scans : bool
        Whether it is a robot of frontier bidding: its nodes are scans without edges, and its
        paths are not classified.
    """

    robot: int
    start: Configuration
    late: bool = False
    nodes: dict[int, NodeAdded] = field(default_factory=dict)
    edges: dict[int, list[Edge]] = field(default_factory=dict)
    motions: list[Motion] = field(default_factory=list)
    closed: list[ArcClosed] = field(default_factory=list)
    stops: list[Blocked] = field(default_factory=list)
    collisions: list[Collision] = field(default_factory=list)
    death: Died | None = None
    frontier: tuple[Segment, ...] = ()
    supporting: list[FloatArray] = field(default_factory=list)
    bridges: list[FloatArray] = field(default_factory=list)
    off_tree: list[FloatArray] = field(default_factory=list)
    scans: bool = False

    @property
    def end(self) -> Configuration:
        """Its last configuration."""
        if not self.motions:
            return self.start
        return Configuration(*self.motions[-1].waypoints[-1][1:])

    @property
    def is_away(self) -> bool:
        """Whether its last configuration visibly differs from its start."""
        return self.end.distance(self.start) > 1e-3

    @property
    def path(self) -> FloatArray:
        """Its path, as ``(n, 2)`` points in metres."""
        points = [(self.start.x, self.start.y)]
        points += [point for motion in self.motions for point in _points(motion.waypoints)]
        return np.asarray(points)

    @property
    def stretches(self) -> list[FloatArray]:
        """Its path in lines that lead over each leg once, however often it was driven.

        Dashes of a path that leads back over itself would fill each other's gaps.
        """
        legs = (np.stack(leg) for leg in pairwise(self.path))
        return _each_once(legs)

    @property
    def distance_m(self) -> float:
        """Length of its path in metres."""
        legs = (leg for motion in self.motions for leg in pairwise(motion.waypoints))
        return sum(leg_length(*leg) for leg in legs)


def traces_of(recording: Recording) -> list[Trace]:
    """Return the events of a recording by robot.

    Raises
    ------
    InvalidInputError
        If an event belongs to no robot of the team, the parent of a node is added after the node,
        or a region is malformed; the message names the node.
    """
    if len(recording.starts) != len(recording.spec.robots):
        raise InvalidInputError(
            f"the recording has {len(recording.starts)} starts for a team of "
            f"{len(recording.spec.robots)}"
        )
    late = {fault.robot for fault in recording.spec.faults if isinstance(fault, LateStart)}
    traces = [
        Trace(robot=robot, start=start, late=robot in late)
        for robot, start in enumerate(recording.starts)
    ]
    trees: dict[NodeName, int] = {}
    for event in recording.events:
        if isinstance(event, Sent | BaseLearned):
            continue
        if not 0 <= event.robot < len(traces):
            raise InvalidInputError(
                f"the recording mentions robot {event.robot}, but its team has {len(traces)}, "
                "counted from 0"
            )
        trace = traces[event.robot]
        match event:
            case NodeAdded():
                _require_sound(event, trees)
                trace.nodes[event.serial] = event
                trace.scans |= event.stage == "scan"
                _hang(event, traces, trees)
            case GoalChosen():
                trace.scans = True
            case Motion() if event.waypoints:
                trace.motions.append(event)
            case ArcClosed():
                _require_known(event.node, trees, "closes an arc of")
            case Blocked():
                trace.stops.append(event)
            case Died():
                trace.death = event
            case Collision():
                trace.collisions.append(event)
    for arc in arcs_given_up(recording):
        traces[arc.robot].closed.append(arc)
    if not any(trace.scans for trace in traces):
        for robot, segments in remaining_frontier(recording).items():
            traces[robot].frontier = segments
        _sort_paths(traces)
    return traces


def joined(segments: tuple[Segment, ...]) -> list[list[Point]]:
    """Return lines made of segments that begin where the one before ends.

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
    """Return the median length of the edges of all trees in metres; None if there are none."""
    edges = np.asarray([e for trace in traces for edges in trace.edges.values() for e in edges])
    if not len(edges):
        return None
    return float(np.median(np.hypot(*(edges[:, 1] - edges[:, 0]).T)))


def _hang(node: NodeAdded, traces: list[Trace], trees: dict[NodeName, int]) -> None:
    # The root at the end of the parent links determines the tree.
    name = (node.robot, node.serial)
    if node.parent is None:
        trees[name] = node.robot
        return
    robot, serial = node.parent
    trees[name] = tree = trees[robot, serial]
    if node.stage == "scan":
        return
    parent = traces[robot].nodes[serial]
    edge = (parent.configuration[:2], node.configuration[:2])
    traces[node.robot].edges.setdefault(tree, []).append(edge)


def _sort_paths(traces: list[Trace]) -> None:
    # Paths run along edges of any tree, along bridges between nodes, or off both.
    places = {_rounded(n.configuration) for trace in traces for n in trace.nodes.values()}
    edges = {
        frozenset(map(_rounded, edge))
        for trace in traces
        for edges in trace.edges.values()
        for edge in edges
    }
    for trace in traces:
        bridges: dict[frozenset[Point], FloatArray] = {}
        off_tree: list[FloatArray] = []
        for points in (p for motion in trace.motions for p in _sections(motion, places)):
            ends = frozenset((_rounded(points[0]), _rounded(points[-1])))
            if ends in edges and len(points) == 2:
                continue
            if len(ends) == 2 and ends <= places and ends not in edges:
                bridges.setdefault(ends, points)
            else:
                off_tree.append(points)
        trace.bridges = list(bridges.values())
        trace.off_tree = _each_once(off_tree)
        trace.supporting = _supporting(trace.motions, places)


def _supporting(motions: list[Motion], places: set[Point]) -> list[FloatArray]:
    return _each_once(
        points
        for motion in motions
        if motion.purpose in SUPPORTING
        for points in _sections(motion, places)
    )


def _each_once(paths: Iterable[FloatArray]) -> list[FloatArray]:
    # Each path once, also if it was driven several times or in both directions.
    known: set[tuple[Point, ...]] = set()
    lines: list[list[FloatArray]] = []
    end = None
    for points in paths:
        rounded = tuple(map(_rounded, points))
        if rounded in known or rounded[::-1] in known:
            continue
        known.add(rounded)
        # Dashes continue where one path begins at the end of another.
        if rounded[0] == end:
            lines[-1].append(points[1:])
        else:
            lines.append([points])
        end = rounded[-1]
    return [np.vstack(parts) for parts in lines]


def _sections(motion: Motion, places: set[Point]) -> Iterator[FloatArray]:
    # The path of a motion from node to node, without turns on the spot.
    section = [motion.waypoints[0]]
    for waypoint in motion.waypoints[1:]:
        section.append(waypoint)
        if _rounded(waypoint[1:]) in places or waypoint is motion.waypoints[-1]:
            points = _points(section)
            if len(points) > 1:
                yield np.asarray(points)
            section = [waypoint]


def _points(waypoints: Sequence[Sequence[float]]) -> list[Point]:
    # The points of a path, with chords for arcs, without repetitions.
    points = [(waypoints[0][1], waypoints[0][2])]
    for leg in pairwise(waypoints):
        points += [point for point in leg_points(*leg)[1:] if point != points[-1]]
    return points


def _rounded(place: Sequence[float]) -> Point:
    return round(float(place[0]), 6), round(float(place[1]), 6)


def _require_sound(node: NodeAdded, known: dict[NodeName, int]) -> None:
    name = f"node {node.serial} of robot {node.robot}"
    if (node.robot, node.serial) in known:
        raise InvalidInputError(f"the recording adds {name} twice")
    if node.parent is not None:
        _require_known(node.parent, known, f"gives {name} as parent")
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


def _require_known(name: NodeName, known: dict[NodeName, int], doing: str) -> None:
    robot, serial = name
    if name not in known:
        raise InvalidInputError(
            f"the recording {doing} node {serial} of robot {robot}, "
            "which it has not reported by then"
        )
