"""What frontier a run left open, also where it was cut off and nobody said so."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
import numpy as np

from multisrt.events import ArcClosed, Ended, Motion, NodeAdded, Segment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.recording import Recording
from multisrt.robots.exploration_map import Closing, ClosingId, ExplorationMap, Node, NodeId
from multisrt.spec import Scalar


def remaining_frontier(recording: Recording) -> dict[int, tuple[Segment, ...]]:
    """Give the frontier that every robot left open.

    A robot that came to its end says itself what it left; if it was called on again, what it
    says at its last end counts. For one that did not come to an end after what it did last,
    because it died or the run was cut off, it is what no region of the team covers of the
    frontiers of the nodes that it made, without the arcs that any robot gave up.

    Parameters
    ----------
    recording : Recording
        What happened.

    Returns
    -------
    dict
        Segments x0, y0, x1, y1 by robot, the region on their left.
    """
    said = _said(recording)
    robots = range(len(recording.spec.robots))
    if len(said) == len(robots):
        return {robot: said[robot] for robot in robots}
    team_map = _team_map(recording)
    left: dict[int, list[Segment]] = {robot: [] for robot in robots}
    for node in team_map.open_nodes():
        left[node.robot] += [(a, b, c, d) for a, b, c, d in team_map.frontier(node).tolist()]
    return {robot: said.get(robot, tuple(left[robot])) for robot in robots}


def _said(recording: Recording) -> dict[int, tuple[Segment, ...]]:
    # What robots said at their ends, unless they went on after it.
    last: dict[int, Ended | Motion | NodeAdded] = {}
    for event in reversed(recording.events):
        if isinstance(event, Ended | Motion | NodeAdded):
            last.setdefault(event.robot, event)
            if len(last) == len(recording.starts):
                break
    return {robot: event.frontier for robot, event in last.items() if isinstance(event, Ended)}


def _team_map(recording: Recording) -> ExplorationMap:
    # What all robots know together, with the arcs that any of them gave up.
    spec = recording.spec
    widths = [Footprint.parse(robot.footprint).width_m for robot in spec.robots]
    team_map = ExplorationMap(
        reach_m=max(robot.range_finder.range_m for robot in spec.robots),
        shortest_arc_m=min(widths),
        # What is too narrow for any of them counts as closed.
        width_m=max(widths),
        gaps_count=_gaps_count(spec.options),
    )
    for number, event in enumerate(recording.events):
        match event:
            case NodeAdded():
                team_map.add(_node(event, spec.robots[event.robot].range_finder.range_m))
            case ArcClosed():
                closing = Closing(
                    id=ClosingId(event.robot, number),
                    node=NodeId(*event.node),
                    arc=np.asarray(event.arc, np.float64).reshape(-1, 4),
                    reason=event.reason,
                    width_m=widths[event.robot],
                )
                team_map.close(closing)
    return team_map


def _gaps_count(options: Mapping[str, Scalar]) -> bool:
    # Options may be written as text; a strategy that has no such option counts them.
    try:
        return msgspec.convert(options.get("gaps_count", True), bool, strict=False)
    except msgspec.ValidationError as error:
        raise InvalidInputError(f"option gaps_count of the recording: {error}") from None


def _node(event: NodeAdded, range_m: float) -> Node:
    configuration = Configuration(*event.configuration)
    region = LocalSafeRegion(
        x=configuration.x,
        y=configuration.y,
        range_m=range_m,
        boundary=event.region(),
        tags=np.asarray([int(tag) for tag in event.tags], np.int8),
    )
    return Node(
        id=NodeId(event.robot, event.serial),
        configuration=configuration,
        region=region,
        parent=None if event.parent is None else NodeId(*event.parent),
        time_s=event.time_s,
    )
