"""The frontier that a run left open, also where robots died or the run was cut off."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from multisrt.analysis.recorded_map import recorded_closing, recorded_node
from multisrt.events import BLOCKED, ArcClosed, ArcReopened, Ended, Motion, NodeAdded, Segment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.spec import Scalar


def remaining_frontier(recording: Recording) -> dict[int, tuple[Segment, ...]]:
    """Return the frontier that each robot left open.

    For a robot that ended it is what its last `Ended` says. For one that did something after its
    last end, or died or was cut off before any, or ended before it was complete without saying what
    it left, as one that went home in time, it is the part of the frontiers of its nodes that no
    region of the team covers, without the arcs that any robot gave up for good.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    dict of int to tuple of (x0, y0, x1, y1)
        Segments in metres by robot, with their region on the left.
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


def arcs_given_up(recording: Recording) -> tuple[ArcClosed, ...]:
    """Return the frontier arcs that robots gave up and did not take up again.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    tuple of ArcClosed
        In the order in which they were given up. Those that bodies barred to the end are among
        them, and among the frontier that was left open.
    """
    given_up: dict[tuple[object, ...], ArcClosed] = {}
    for event in recording.events:
        if isinstance(event, ArcClosed):
            given_up[event.robot, event.node, event.arc, event.reason] = event
        elif isinstance(event, ArcReopened):
            given_up.pop((event.robot, event.node, event.arc, BLOCKED), None)
    return tuple(given_up.values())


def _said(recording: Recording) -> dict[int, tuple[Segment, ...]]:
    # The frontiers that robots stated at their last ends, unless they went on afterwards.
    last: dict[int, Ended | Motion | NodeAdded] = {}
    for event in reversed(recording.events):
        if isinstance(event, Ended | Motion | NodeAdded):
            last.setdefault(event.robot, event)
            if len(last) == len(recording.starts):
                break
    return {
        robot: event.frontier
        for robot, event in last.items()
        if isinstance(event, Ended) and (event.complete or event.frontier)
    }


def _team_map(recording: Recording) -> ExplorationMap:
    # The map of all robots together, with the arcs that any of them gave up for good.
    spec = recording.spec
    widths = [Footprint.parse(robot.footprint).width_m for robot in spec.robots]
    team_map = ExplorationMap(
        reach_m=max(robot.range_finder.range_m for robot in spec.robots),
        min_arc_m=min(widths),
        # Arcs that are too narrow for any of them count as closed.
        width_m=max(widths),
        gaps_count=_gaps_count(spec.options),
    )
    for number, event in enumerate(recording.events):
        match event:
            case NodeAdded():
                team_map.add(recorded_node(event, spec.robots[event.robot].range_finder.range_m))
            case ArcClosed() if event.reason != "blocked by a robot":
                width_m = widths[event.robot]
                team_map.close(recorded_closing(event, event.reason, number, width_m))
    return team_map


def _gaps_count(options: Mapping[str, Scalar]) -> bool:
    # Options may be given as text; a strategy without this option counts gaps.
    try:
        return msgspec.convert(options.get("gaps_count", True), bool, strict=False)
    except msgspec.ValidationError as error:
        raise InvalidInputError(f"option gaps_count of the recording: {error}") from None
