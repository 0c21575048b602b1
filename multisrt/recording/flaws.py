"""Defects of an event of a recording whose fields have the right types."""

from __future__ import annotations

import itertools
import math
from collections.abc import Container, Iterable, Iterator, Sequence

from multisrt.events import (
    AnyEvent,
    ArcClosed,
    ArcReopened,
    BaseLearned,
    Blocked,
    Coordinated,
    Decided,
    Decision,
    Ended,
    Learned,
    Motion,
    NodeAdded,
    NodeName,
    Organized,
    PresumedLost,
    Segment,
    Sensed,
    Sent,
    Supports,
)
from multisrt.spec import RunSpec
from multisrt.spec.numbering import missing

MAX_COORDINATE_M = 1e9
"""Bound of the absolute coordinates in a recording, in metres."""

MAX_TURN_RAD = 4.0 * math.pi
"""Bound of the turn on one leg of a motion, in radians."""

ROUNDING_S = 1e-6
"""Times that differ by less are equal, in seconds."""

ROUNDING_M = 1e-3
"""Distance by which a region may exceed the range of its robot, for rounding."""


def flaw_of(event: AnyEvent, spec: RunSpec, nodes: Container[NodeName]) -> str:
    """Return what is wrong with an event, in words; empty if nothing is.

    Parameters
    ----------
    event : AnyEvent
        The event.
    spec : RunSpec
        The run.
    nodes : container of (robot, serial)
        The nodes of the recording.
    """
    robots = spec.robots
    # The base station takes part in the radio traffic, under the number after the last robot.
    members = len(robots) + (isinstance(event, Sent) and spec.base is not None)
    for robot in (event.robot, *_others(event)):
        if not 0 <= robot < members:
            return missing(robot, len(robots))
    if isinstance(event, BaseLearned) and spec.base is None:
        return "a base station learned of nodes, but the run has none"
    for name in _nodes_named(event):
        if name not in nodes:
            return f"node {name[1]} of robot {name[0]} is nowhere in the recording"
    if isinstance(event, Motion):
        return waypoints_flaw(event.waypoints)
    if isinstance(event, Sensed):
        return _too_far(*event.configuration[:2])
    if isinstance(event, NodeAdded):
        return _node_flaw(event, robots[event.robot].range_finder.range_m)
    if isinstance(event, Decided):
        places = (*event.options, *(() if event.goal is None else (event.goal,)))
        return next(filter(None, (_too_far(x, y) for x, y in places)), "")
    for x0, y0, x1, y1 in _segments(event):
        if flaw := _too_far(x0, y0) or _too_far(x1, y1):
            return flaw
    return ""


def order_flaws(events: Sequence[AnyEvent], end_s: float) -> Iterator[tuple[int, str]]:
    """Yield what is wrong with the order of events: the index of each such event, and why.

    Parameters
    ----------
    events : sequence of AnyEvent
        The events of a recording.
    end_s : float
        When the run ended, in seconds.
    """
    last_s, nodes = 0.0, set()
    for number, event in enumerate(events):
        if not -ROUNDING_S <= event.time_s <= end_s + ROUNDING_S:
            yield number, f"time {event.time_s:g} s, in a run from 0 to {end_s:g} s"
        if not isinstance(event, Motion):
            if event.time_s < last_s - ROUNDING_S:
                yield number, f"time {event.time_s:g} s after one of {last_s:g} s"
            last_s = event.time_s
        if isinstance(event, NodeAdded):
            if (event.robot, event.serial) in nodes:
                yield number, f"node {event.serial} of robot {event.robot} stands there twice"
            nodes.add((event.robot, event.serial))


def _segments(event: AnyEvent) -> Iterable[Segment]:
    match event:
        case ArcClosed() | ArcReopened():
            return event.arc
        case Ended():
            return event.frontier
    return ()


def waypoints_flaw(waypoints: Sequence[tuple[float, float, float, float]]) -> str:
    """Return what is wrong with the waypoints of a motion; empty if nothing is.

    Parameters
    ----------
    waypoints : sequence of (time_s, x, y, heading)
        Seconds, metres and radians.
    """
    legs = list(itertools.pairwise(waypoints))
    if not waypoints:
        return "a motion has at least one waypoint"
    if any(b[0] < a[0] for a, b in legs):
        return "the times of a motion's waypoints never fall"
    if any(abs(b[3] - a[3]) > MAX_TURN_RAD for a, b in legs):
        return f"a leg of a motion turns by more than {MAX_TURN_RAD:.4g} rad"
    for _, x, y, _ in waypoints:
        if flaw := _too_far(x, y):
            return flaw
    return ""


def _node_flaw(node: NodeAdded, range_m: float) -> str:
    if len(node.boundary) < 3 or len(node.tags) != len(node.boundary):
        return (
            f"a region of {len(node.boundary)} corners with {len(node.tags)} tags; "
            "it has at least 3 corners and as many tags"
        )
    if not set(node.tags) <= set("0123"):
        return f"tags are digits from 0 to 3, not {node.tags!r}"
    x, y, _ = node.configuration
    if flaw := _too_far(x, y):
        return flaw
    farthest_m = max(map(math.dist, itertools.repeat((x, y)), node.boundary))
    if farthest_m > range_m + ROUNDING_M:
        return f"a region reaches {farthest_m:g} m, but robot {node.robot} sees {range_m:g} m"
    return ""


def _too_far(x: float, y: float) -> str:
    if max(abs(x), abs(y)) <= MAX_COORDINATE_M:
        return ""
    return (
        f"a place at ({x:g}, {y:g}); none lies farther than {MAX_COORDINATE_M:g} m from the origin"
    )


def _others(event: AnyEvent) -> Iterable[int]:
    # The other robots that an event names.
    match event:
        case Decision():
            return (*event.gpr, *event.ger)
        case Coordinated():
            return (*event.ger, event.master, *event.feasible, *event.unfeasible)
        case Organized():
            in_tables = (*event.before, *event.after, *event.orders)
            in_conflict = itertools.chain.from_iterable(event.conflicts)
            return (*event.feasible, *event.unfeasible, *in_tables, *in_conflict)
        case Supports():
            chosen = () if event.tree is None else (event.tree,)
            return (*chosen, *event.open_frontier_m, *event.active_robots, *event.candidates)
        case Sent():
            return (*event.reached, *event.lost)
        case PresumedLost():
            return (event.other,)
        case Blocked():
            return (event.by,)
    return ()


def _nodes_named(event: AnyEvent) -> Iterable[NodeName]:
    # The nodes that an event refers to.
    match event:
        case NodeAdded():
            return () if event.parent is None else (event.parent,)
        case Decision() | ArcClosed() | ArcReopened():
            return (event.node,)
        case Learned() | BaseLearned():
            return event.nodes
    return ()
