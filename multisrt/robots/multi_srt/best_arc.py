"""PLANNER with ``choice="gain"``: the frontier arc that shows much for a short way.

A variant of this project; the idea is that of the strategy `gain`. Where SRT draws the next place
at random in the region of its node, and goes back along the tree when there is none, a robot here
compares all arcs of the tree that it extends. The value of an arc is the area that would be seen
from its middle, were all that is not known free, over a power of the way there over the roadmap.
To the area is added what stands for the way back to an arc that is left behind; the way counts the
first turn. Arcs near the targets of other robots on their way count less. The robot goes to a place
that sees the arc of the highest value, and stops on the last straight piece as soon as much of what
can be seen from there is in sight: a scan costs nothing, and shows where the way is not needed.

Nothing is drawn at random. Groups, the master, motions and the trees are as with random draws.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Iterator
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.configuration import wrap_angle
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.distances import nearest_points
from multisrt.geometry.regions.unknown_area import unknown_areas
from multisrt.planners.srt import Draws
from multisrt.planners.viewing import arc_points
from multisrt.robots.explorer import Action, Outcome
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.targets import Barred, NewPlace

NEAREST_M: Final = 0.5
"""Added to every way in metres, so that near arcs are compared by their areas."""

STOP_EVERY_M: Final = 0.5
"""Distance in metres of the places on the last straight piece at which the robot may stop."""

MAX_RECORDED: Final = 10
"""Number of arcs that are put on record, those of the highest values."""

ArcsOf = Callable[[NodeId], list[FloatArray]]
"""The arcs ``(k, 4)`` of a node that the robot may go to."""

Postpone = Callable[[NodeId, FloatArray], None]
"""Leaves an arc out until nothing else is left."""

ArcKey = tuple[NodeId, float, float]
"""The node of an arc, and x and y of its middle."""


class ValuedArc(NamedTuple):
    """A frontier arc, and what it is worth to a robot.

    Attributes
    ----------
    node : NodeId
        The node whose frontier it is part of.
    arc : (k, 4) array
        Its segments x0, y0, x1, y1 in metres.
    x, y : float
        Its middle in metres.
    area_m2 : float
        Unknown area in sight of the middle, less what robots on their way take, in square metres.
    way_m : float
        Way to the middle in metres, the first turn included.
    value : float
        The area and what stands for the way back, over the power of the way.
    """

    node: NodeId
    arc: FloatArray
    x: float
    y: float
    area_m2: float
    way_m: float
    value: float


def best_arc(
    robot: SrtRobot, arcs_of: ArcsOf, postpone: Postpone, draws: Draws
) -> Generator[Action, Outcome, tuple[bool, NewPlace] | None]:
    """Choose a place that sees the arc of the highest value; close arcs that no place sees.

    Parameters
    ----------
    robot : SrtRobot
        The robot, at a node.
    arcs_of : callable
        The arcs of a node that the robot may go to.
    postpone : callable
        Called for an arc to whose views no path leads.
    draws : Draws
        Filled with the arcs that were compared last.

    Returns
    -------
    is_interim : bool
        Whether the robot goes around a body first, off the roadmap.
    place : NewPlace
        The place. None in place of both, if no arc is left that the robot can reach.
    """
    late: set[ArcKey] = set()
    while True:
        ranked = valued_arcs(robot, arcs_of, late)
        draws.arcs = [(a.x, a.y, a.area_m2, a.way_m, a.value) for a in ranked[:MAX_RECORDED]]
        if not ranked:
            return None
        best = ranked[0]
        found = robot.views.viewing_place(best.node, best.arc)
        if isinstance(found, NewPlace):
            place = found if found.is_interim else first_view(robot, found)
            if not robot.leaves_out(place):
                if (place.x, place.y) != (found.x, found.y):
                    robot.views.forget_look()
                return found.is_interim, place
            robot.views.forget_look()
            late.add((best.node, best.x, best.y))
        elif isinstance(found, Barred):
            yield from robot.trees.defer(best.node, best.arc, found.bodies)
        elif found == "not reachable":
            postpone(best.node, best.arc)
        else:
            yield from robot.trees.close(best.node, best.arc, found)


def valued_arcs(robot: SrtRobot, arcs_of: ArcsOf, late: Collection[ArcKey] = ()) -> list[ValuedArc]:
    """Return arcs with their values, the highest first; of equal ones that of the shortest way.

    Arcs so far away that they cannot have the highest value are left out.

    Parameters
    ----------
    robot : SrtRobot
        The robot, at a node.
    arcs_of : callable
        The arcs of a node that are valued.
    late : collection of ArcKey
        Arcs that are left out, as the robot has no time for the place that sees them.

    Returns
    -------
    list of ValuedArc
    """
    options, range_m = robot.options, robot.me.range_m
    taken = targets_of_others(robot)
    most_m2 = math.pi * range_m**2 + options.return_area_m2
    found: list[ValuedArc] = []
    best = 0.0
    for node, to_node_m, turn in _ways(robot):
        if most_m2 * (to_node_m + NEAREST_M) ** -options.power < best:
            break
        place = robot.map[node].configuration
        for arc in arcs_of(node):
            x, y, *_ = arc_points(arc, range_m)[0]
            if (node, x, y) in late:
                continue
            turned = _turn(robot, x, y) if turn is None else turn
            way_m = to_node_m + math.dist(place[:2], (x, y)) + options.turn_m_per_rad * turned
            around = robot.map.regions_reaching(x, y, range_m)
            (area_m2,) = unknown_areas(np.array([[x, y]]), range_m, around).tolist()
            left = math.prod(min(1.0, math.dist((x, y), other) / range_m) for other in taken)
            worth = (area_m2 + options.return_area_m2) * left
            value = worth * (way_m + NEAREST_M) ** -options.power
            found.append(ValuedArc(node, arc, x, y, area_m2 * left, way_m, value))
            best = max(best, value)
    return sorted(found, key=lambda arc: (-arc.value, arc.way_m, arc.node, arc.x, arc.y))


def targets_of_others(robot: SrtRobot) -> list[tuple[float, float]]:
    """Return where other robots are on their way to, as they have said, in rising order."""
    present = robot.team.roster.present()
    return [present[n].target for n in sorted(present) if present[n].phase == "moving"]


def _ways(robot: SrtRobot) -> Iterator[tuple[NodeId, float, float | None]]:
    """Yield the nodes that the robot gets to, the nearest first, with the lengths of the routes.

    With each the first turn on the route in radians; None for the node at which the robot is.
    """
    robot.roadmap.extend()
    here = robot.at.node
    turns: dict[NodeId, float | None] = {}
    ways = robot.roadmap.graph.nearest_first({here: 0.0}, robot.routes.passable)
    for node, length_m, before in ways:
        if before is None:
            turns[node] = None
        elif before == here:
            turns[node] = _turn(robot, *robot.map[node].configuration[:2])
        else:
            turns[node] = turns[before]
        yield node, length_m, turns[node]


def _turn(robot: SrtRobot, x: float, y: float) -> float:
    # By how much the robot turns towards a place, from 0 to pi.
    at = robot.at.q_act
    return abs(wrap_angle(math.atan2(y - at.y, x - at.x) - at.heading))


def first_view(robot: SrtRobot, place: NewPlace) -> NewPlace:
    """Return the first place on the last straight piece of a way from which much is in sight.

    Parameters
    ----------
    robot : SrtRobot
        The robot.
    place : NewPlace
        The place at the end of the way.

    Returns
    -------
    NewPlace
        The first one from which at least the share `stop_share` is in sight of the largest unknown
        area that any place on the piece shows, and that is not near a node; or `place` itself, also
        where none shows any, or the body does not fit in any heading all along the piece.
    """
    options, range_m = robot.options, robot.me.range_m
    if not place.roomy or options.stop_share == 1.0:
        return place
    start, end = robot.map[place.route[-1]].configuration[:2], (place.x, place.y)
    length_m = math.dist(start, end)
    count = max(1, math.ceil(length_m / STOP_EVERY_M))
    shares = np.arange(1, count + 1)[:, None] / count
    stops = (1.0 - shares) * np.array(start) + shares * np.array(end)
    stops[-1] = end
    spacing_m = options.completion_spacing * robot.planner.d_min_m
    nodes = robot.map.places_near(*end, length_m + spacing_m)
    stops = np.vstack([stops[:-1][nearest_points(nodes, stops[:-1]) >= spacing_m], stops[-1:]])
    around = robot.map.regions_reaching(*end, length_m + range_m)
    areas = unknown_areas(stops, range_m, around)
    if not areas.max():
        return place
    first = int(np.argmax(areas >= options.stop_share * areas.max()))
    x, y = stops[first].tolist()
    return replace(place, x=x, y=y)
