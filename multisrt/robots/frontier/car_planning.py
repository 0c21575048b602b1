"""Motions of a car along a path that was planned on a raster, in what it knows to be free.

A path has corners that a car cannot follow. Planned is the shortest curve to the end of the path,
or to the farthest place along it to which one leads, certified as free in what was seen from
nearby. Where no curve leads on, a plan by sampling is tried, and then curves from places on the
exit (see `car_route`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.clearance import disc_clearance, rings_of
from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.overlay import union_on_grid
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.car import (
    ARRIVAL_TURNS,
    MAX_SEED,
    Checks,
    car_out_and_back,
    shortest_curve,
)
from multisrt.planners.motion.curves import curve_length
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.room import Room
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.planners.navigation.right_of_way import stands_in_the_way
from multisrt.robots.explorer import RobotSelf, Sighting
from multisrt.robots.frontier.bodies import Bodies
from multisrt.robots.frontier.car_route import Excursion
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.knowledge import Node

HORIZON = 1.5
"""Distance along its path that a car plans, in ranges of its range finder."""

SPACING_M = 0.5
"""Spacing, along a path, of the places that are tried as ends."""

MIN_LENGTH_M = 0.1
"""A motion that leads less far along a path is not worth driving."""

MAX_CHECKS = 400
"""Bounds the number of motions that a plan by sampling may check."""

MAX_LATER_STARTS = 8
"""Bounds the number of places on the exit from which a motion is planned."""

NEAREST_NODES = 6
"""Number of nodes nearest to a place among which one that sees it is looked for."""

End = tuple[float, float, float, float]
"""A place on a path to drive to: x, y, heading of the path, and distance along it."""


class CarPlanner:
    """Plans the motions of a car.

    Parameters
    ----------
    me : RobotSelf
        What the car knows of itself.
    car : Car
        How it moves.
    options : FrontierOptions
        Its parameters.
    course : Course
        Where it is.
    map : ScanMap
        What it knows.
    bodies : Bodies
        The bodies in its way.
    """

    def __init__(
        self,
        me: RobotSelf,
        car: Car,
        options: FrontierOptions,
        course: Course,
        map: ScanMap,
        bodies: Bodies,
    ) -> None:
        self._me = me
        self._car = car
        self._body = PlanningBody(me.footprint, 0.5 * options.margin_m)
        self._keep_off_m = options.guard_m + options.margin_m
        self._course = course
        self._map = map
        self._bodies = bodies
        # The nodes as a list, and their places as rows, extended as the map grows.
        self._nodes: list[Node] = []
        self._places = np.empty((0, 2))

    def plan(
        self, path: FloatArray, starts: Sequence[Trajectory], seen: Sequence[Sighting]
    ) -> Excursion | None:
        """Plan a motion along a path, and one back to where the car knows how to continue.

        Parameters
        ----------
        path : (n, 2) array
            The path in metres.
        starts : sequence of Trajectory
            Beginnings of the exit; the first has no length.
        seen : sequence of Sighting
            The bodies in sight.

        Returns
        -------
        Excursion or None
            None if no motion leads on.
        """
        body, car = self._body, self._car
        points = spaced_points(path, HORIZON * self._me.range_m)
        known = self._known_around(
            np.vstack([points[:, :2], [motion.end[:2] for motion in starts]])
        )
        rings = rings_of(known.difference(self._bodies_beside(path, seen)))
        room = body.room(rings, self._course.at)
        if room is None:
            return None
        curves = _Curves(car, room, starts)
        here, *later = starts
        ends = ends_of(points, rings, body.outer_radius_m)
        far = [end for end in ends if end[3] >= car.turning_radius_m] or ends[:1]
        return (
            curves.find(here, room, far)
            or self._sampled(here, rings, far[:1])
            or curves.find(here, room, ends[len(far) :])
            or next(
                (
                    plan
                    for first in later[:MAX_LATER_STARTS]
                    if (there := body.room(rings, first.end)) is not None
                    and (plan := curves.find(first, there, ends)) is not None
                ),
                None,
            )
        )

    def _sampled(self, here: Trajectory, rings: FloatArray, ends: list[End]) -> Excursion | None:
        """Plan by sampling, out and back to here."""
        for x, y, _, _ in ends:
            seed = int(self._me.rng.integers(1, MAX_SEED))
            found = car_out_and_back(
                self._body, self._car, rings, here.end, x, y, seed, checks=Checks(MAX_CHECKS)
            )
            if found is not None:
                return Excursion(here, *found, 0.0)
        return None

    def _known_around(self, points: FloatArray) -> BaseGeometry:
        """Return what is known to be free around points: the regions of nearby nodes."""
        nodes = self._map.entries.nodes
        if len(nodes) > len(self._nodes):
            new = list(nodes.values())[len(self._nodes) :]
            self._nodes += new
            self._places = np.vstack([self._places, [node.configuration[:2] for node in new]])
        assert self._map.region is not None
        chosen: dict[int, None] = {}
        for x, y in points.tolist():
            away = np.hypot(*(self._places - (x, y)).T)
            for i in np.argsort(away, kind="stable")[:NEAREST_NODES].tolist():
                if inside(self._nodes[i].region.boundary, x, y):
                    chosen[i] = None
                    break
        regions = [self._map.region, *(self._nodes[i].region for i in chosen)]
        return union_on_grid(region.polygon() for region in regions)

    def _bodies_beside(self, path: FloatArray, seen: Sequence[Sighting]) -> BaseGeometry:
        """Return the bodies to drive round, with the distance to keep from them.

        Bodies on the path are not among them unless they are known not to leave: the car will
        meet these robots and ask them to give way.
        """
        own = self._me.footprint.placed(self._course.at)
        around = []
        for body in {s.robot: s for s in (*self._bodies.sightings(), *seen)}.values():
            near = (
                self._body.outer_radius_m + body.footprint.circumscribed_radius_m + self._keep_off_m
            )
            may_leave = body.robot not in self._bodies
            if may_leave and stands_in_the_way(path, body.configuration, near):
                continue
            solid = body.footprint.placed(body.configuration)
            around.append(solid.buffer(min(self._keep_off_m, 0.5 * own.distance(solid))))
        return shapely.union_all(around)


class _Curves:
    """Shortest curves to places, and from there back to the exit."""

    def __init__(self, car: Car, room: Room, starts: Sequence[Trajectory]) -> None:
        self._car = car
        self._room = room
        self._homes = [
            (motion.duration_s, motion.end) for motion in starts if room.holds(motion.end)
        ]
        self._backs: dict[Configuration, tuple[Trajectory, float] | None] = {}

    def find(self, first: Trajectory, room: Room, ends: list[End]) -> Excursion | None:
        """Return a motion from the end of another to the first place that one leads to."""
        start = first.end
        for x, y, heading, _ in ends:
            goals = [Configuration(x, y, wrap_angle(heading + turn)) for turn in ARRIVAL_TURNS]
            goals = [goal for goal in goals if room.holds(goal)]
            # The nearest heading first, whether forwards or backwards.
            for goal in sorted(goals, key=lambda goal: curve_length(self._car, start, goal)):
                out = shortest_curve(self._car, room, start, goal)
                if out is None or out.duration_s == 0.0:
                    continue
                if self._car.reverse:
                    return Excursion(first, out, out.reversed(), first.duration_s)
                back = self._back(goal)
                if back is not None:
                    return Excursion(first, out, *back)
        return None

    def _back(self, place: Configuration) -> tuple[Trajectory, float] | None:
        """Return a motion from a place to the exit, and the time along the exit there."""
        if place not in self._backs:
            found = ((shortest_curve(self._car, self._room, place, at), s) for s, at in self._homes)
            self._backs[place] = next(
                ((motion, s) for motion, s in found if motion is not None), None
            )
        return self._backs[place]


def spaced_points(path: FloatArray, limit_m: float) -> FloatArray:
    """Return points on a polyline, `MIN_LENGTH_M` or less apart.

    Parameters
    ----------
    path : (n, 2) array
        Its corners in metres.
    limit_m : float
        Distance along it at which the points end.

    Returns
    -------
    (k, 4) array
        x, y, heading, and distance from the beginning, of each point.

    Examples
    --------
    >>> spaced_points(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.2)
    array([[0. , 0. , 0. , 0. ],
           [0.1, 0. , 0. , 0.1],
           [0.2, 0. , 0. , 0.2]])
    """
    steps = np.diff(path, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    last = min(float(ends[-1]), limit_m)
    at = np.linspace(0.0, last, 1 + max(1, math.ceil(last / MIN_LENGTH_M)))
    if not len(steps):
        return np.array([[*path[0], 0.0, 0.0]])
    x, y = (np.interp(at, ends, path[:, k]) for k in range(2))
    leg = np.clip(np.searchsorted(ends, at) - 1, 0, len(steps) - 1)
    heading = libm.arctan2(steps[leg, 1], steps[leg, 0])
    return np.column_stack([x, y, heading, at])


def ends_of(points: FloatArray, rings: FloatArray, radius_m: float) -> list[End]:
    """Choose the points on a path that a motion may end at, the farthest first.

    Parameters
    ----------
    points : (k, 4) array
        The points, as `spaced_points` returns them.
    rings : (n, 2) array
        Boundary of the area known to be free.
    radius_m : float
        Radius in metres of the disc that must fit there.
    """
    min_m = min(MIN_LENGTH_M, float(points[-1, 3]))
    ends: list[End] = []
    for x, y, heading, along in points[::-1].tolist():
        if along < min_m or (ends and ends[-1][3] - along < SPACING_M):
            continue
        if inside(rings, x, y) and disc_clearance(rings, x, y) >= radius_m:
            ends.append((x, y, heading, along))
    return ends
