"""Where robots were and where they went, in a replay."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
import shapely

from multisrt.drawing.colours import RobotStyles
from multisrt.events import Coordinated, Decided, Decision, Ended, GoalChosen, Motion, Point
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.trajectory import leg_points
from multisrt.recording import Recording
from multisrt.replay.nodes import Names
from multisrt.replay.packing import UNIT_M, UNIT_RAD, UNIT_S, Packed, points, whole

Waypoint = tuple[float, float, float, float]


def packed_robots(recording: Recording) -> list[Packed]:
    """Pack the bodies, colours and tracks of all robots."""
    motions: list[list[Motion]] = [[] for _ in recording.starts]
    for motion in recording.of(Motion):
        motions[motion.robot].append(motion)
    robots = []
    for robot, spec in enumerate(recording.spec.robots):
        styles = RobotStyles.of(robot)
        body = shapely.get_coordinates(Footprint.parse(spec.footprint).placed((0.0, 0.0, 0.0)))
        own = sorted(motions[robot], key=lambda motion: motion.time_s)
        robots.append(
            {
                "body": points([body[:-1]]),
                "colour": styles.edge.stroke,
                "area": styles.area.fill,
                "dashes": list(styles.edge.dashes_mm),
                "track": _track(recording.header.starts[robot], own),
            }
        )
    return robots


def packed_goals(recording: Recording) -> Packed:
    """Pack the goals of robots, with the places from which they were chosen."""
    rows: list[tuple[float, int, Point | None, tuple[Point, ...] | None]] = []
    for event in recording.events:
        match event:
            case Decision():
                rows.append((event.time_s, event.robot, event.target, None))
            case Coordinated():
                rows.append((event.time_s, event.robot, event.new_target, None))
            case GoalChosen():
                rows.append((event.time_s, event.robot, event.goal, event.frontiers))
            case Decided():
                rows.append((event.time_s, event.robot, event.goal, event.options))
            case Ended():
                rows.append((event.time_s, event.robot, None, ()))
    places = np.array([goal or (0.0, 0.0) for _, _, goal, _ in rows]).reshape(-1, 2)
    return {
        "t": whole([row[0] for row in rows], UNIT_S),
        "robot": [row[1] for row in rows],
        "none": [number for number, row in enumerate(rows) if row[2] is None],
        "x": whole(places[:, 0], UNIT_M),
        "y": whole(places[:, 1], UNIT_M),
        "options": points([np.array(row[3] or ()).reshape(-1, 2) for row in rows]),
    }


def packed_bridges(recording: Recording, names: Names) -> Packed:
    """Pack the paths between nodes that no edge joins, each when it was first driven."""
    if any(node.stage == "scan" for node in names.nodes):
        found: list[tuple[float, int, FloatArray]] = []
    else:
        found = sorted(_bridges(recording, names), key=lambda bridge: bridge[0])
    return {
        "t": whole([time for time, _, _ in found], UNIT_S),
        "robot": [robot for _, robot, _ in found],
        "line": points([line for _, _, line in found]),
    }


def _track(start: tuple[float, float, float], motions: Sequence[Motion]) -> Packed:
    # Waypoints of all motions; each heading continues from the one before, so that a robot that
    # stands does not turn by full circles between two motions.
    rows: list[Waypoint] = [(0.0, *start)]
    begins = []
    for motion in motions:
        turn = 2.0 * math.pi * round((rows[-1][3] - motion.waypoints[0][3]) / (2.0 * math.pi))
        begins.append(len(rows))
        rows += [(t, x, y, heading + turn) for t, x, y, heading in motion.waypoints]
    way = np.array(rows)
    return {
        "t": whole(way[:, 0], UNIT_S),
        "x": whole(way[:, 1], UNIT_M),
        "y": whole(way[:, 2], UNIT_M),
        "heading": whole(way[:, 3], UNIT_RAD),
        "begin": whole(begins, 1.0),
    }


def _bridges(recording: Recording, names: Names) -> Iterator[tuple[float, int, FloatArray]]:
    places = {_rounded(node.configuration) for node in names.nodes}
    edges = {
        frozenset(
            (
                _rounded(names.nodes[names.numbers[node.parent]].configuration),
                _rounded(node.configuration),
            )
        )
        for node in names.nodes
        if node.parent is not None
    }
    known: set[tuple[int, frozenset[Point]]] = set()
    for motion in recording.of(Motion):
        for section in _sections(motion.waypoints, places):
            ends = frozenset((_rounded(section[0][1:]), _rounded(section[-1][1:])))
            if len(ends) < 2 or not ends <= places or ends in edges:
                continue
            if (motion.robot, ends) not in known:
                known.add((motion.robot, ends))
                yield section[-1][0], motion.robot, _line(section)


def _sections(waypoints: Sequence[Waypoint], places: set[Point]) -> Iterator[list[Waypoint]]:
    # The parts of a motion from node to node.
    section = [waypoints[0]]
    for waypoint in waypoints[1:]:
        section.append(waypoint)
        if _rounded(waypoint[1:]) in places:
            yield section
            section = [waypoint]


def _line(section: Iterable[Waypoint]) -> FloatArray:
    line: list[Point] = []
    for leg in pairwise(section):
        line += [point for point in leg_points(*leg) if not line or point != line[-1]]
    return np.array(line)


def _rounded(place: Sequence[float]) -> Point:
    return round(float(place[0]), 6), round(float(place[1]), 6)
