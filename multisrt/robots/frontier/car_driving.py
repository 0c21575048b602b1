"""How a car drives to goals whose ways are planned on a raster: by curves in known free space.

The way on the raster tells where to; a car leaves it, since it has corners. What is driven is
the shortest curve to the goal, or to the farthest place along the way to which one leads, that
is certified as free in what was seen from around there; where none leads on, a plan by sampling.
A way is driven to its end as long as the goal stands.

A car knows at any time how to go on, so that it is never caught: one that can reverse goes back
as it came; one that cannot sets out only on ways from whose end it knows another one back, and
drives a way to its end unless it finds another from where it is. Where nothing leads to a goal
from where the car stands, it is looked for from places on that way.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.clearance import disc_clearance, rings_of
from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.car import FAN, MOST_SEED, car_ways, shortest_way
from multisrt.planners.motion.curves import curve_length
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.room import Room
from multisrt.planners.motion.trajectory import Trajectory, standing_at
from multisrt.planners.navigation.right_of_way import place_aside, stands_in_the_way
from multisrt.robots.explorer import Action, Moved, Outcome, Sighting
from multisrt.robots.knowledge import Node

if TYPE_CHECKING:
    from multisrt.robots.frontier.robot import FrontierRobot

HORIZON = 1.5
"""A car plans so far along its way, in ranges of its range finder."""

SPACING_M = 0.5
"""Places along a way that are tried as ends, and from which others saw the way, lie so close."""

LEAST_M = 0.1
"""A way that leads less far along is none."""

MOST_VAIN = 4
"""So many ways to a goal that do not lead nearer to it are driven until the map changes."""

MOST_CHECKS = 400
"""How many motions a plan by sampling may look at."""

PLACES_BACK = 8
"""From so many places on the way on ways are looked for..."""

APART = 1.0
"""... so far apart, in turning radii."""

MOST_HOMES = 16
"""A car that cannot reverse may come back to so many places on the way on."""

NEAREST = 6
"""Of so many of the nearest nodes one is taken that sees a place."""


Ways = tuple[Trajectory, ...]
"""Ways of which one begins where another ends; the last comes first."""

End = tuple[float, float, float, float]
"""A place on a path to drive to: x, y, the path's heading, and how far along it lies."""


@dataclass(frozen=True, slots=True)
class Leg:
    """A way that is being driven, or will be.

    Attributes
    ----------
    way : Trajectory
        The whole of it.
    on : tuple of Trajectory
        What leads on from its end, or from where `back` ends; the last comes first.
    back : Trajectory or None
        From its end to where the car knows how to go on; None: the way itself is such a one.
    driven_s : float
        How much of it is driven.
    """

    way: Trajectory
    on: Ways
    back: Trajectory | None
    driven_s: float = 0.0

    @property
    def rest(self) -> Trajectory:
        """What is left of it."""
        return self.way.after(self.driven_s)

    @property
    def is_driven(self) -> bool:
        """Whether nothing is left of it."""
        return self.driven_s >= self.way.duration_s * (1.0 - 1e-12)

    def on_from_end(self) -> Ways:
        """Give what leads on from its end."""
        return self.on if self.back is None else (*self.on, self.back)

    def on_from_here(self, reverse: bool) -> Ways:
        """Give what leads on from where the car is; who can reverse need not go to the end."""
        if reverse and self.back is not None:
            return *self.on, self.way.until(self.driven_s).reversed()
        return *self.on_from_end(), self.rest


class Plan(NamedTuple):
    """A way to somewhere: from here or from a place on the way on, and how to go on from there.

    Attributes
    ----------
    first : Trajectory
        The beginning of the way on up to that place.
    out : Trajectory
        The way from there.
    back : Trajectory
        A way from its end to the way on...
    home_s : float
        ... which it meets where the car would come after this time.
    """

    first: Trajectory
    out: Trajectory
    back: Trajectory
    home_s: float


@dataclass(slots=True)
class Trial:
    """How it goes with a goal: how near the car was, by its way, and how often it failed since."""

    nearest_m: float = math.inf
    vain: int = 0
    revision: int = -1


class CarDriver:
    """Plans a car's ways along paths, and keeps what leads on from wherever it gets.

    Parameters
    ----------
    robot : FrontierRobot
        Whose body.
    car : Car
        How it moves.
    """

    def __init__(self, robot: FrontierRobot, car: Car) -> None:
        self.robot = robot
        self.car = car
        self._aim: tuple[float, float] | None = None
        # What is being driven: a piece of the way on perhaps, and then the way to the aim.
        self._legs: list[Leg] = []
        # The way on from the end of the legs; the last comes first.
        self._on: Ways = ()
        self._trials: dict[tuple[float, float], Trial] = {}
        self._nodes: list[Node] = []
        self._places = np.empty((0, 2))

    def way_along(self, path: FloatArray) -> Generator[Action, Outcome, Trajectory | None]:
        """Give the motion on which the car goes along a path; None: none leads on.

        It is the rest of the last one as long as the path leads to the same place.
        """
        aim = float(path[-1, 0]), float(path[-1, 1])
        if aim == self._aim and self._legs:
            return self._legs[0].rest
        if not self._may_try(aim, path):
            return None
        seen = yield from self.robot.look()
        plan = self._plan(path, seen)
        if plan is None:
            return None
        on = self._way_on()
        self._legs = [Leg(plan.out, after(on, plan.home_s), plan.back)]
        if plan.first.duration_s > 0.0:
            self._legs.insert(0, Leg(plan.first, after(on, plan.first.duration_s), None))
        self._aim = aim
        return self._legs[0].rest

    def has_driven(self, moved: Moved, set_out_s: float) -> None:
        """Take note of how far the car came on the motion that it was given."""
        leg = self._legs[0]
        leg = replace(leg, driven_s=leg.driven_s + moved.time_s - set_out_s)
        if leg.is_driven:
            self._on = leg.on_from_end()
            del self._legs[0]
        else:
            self._legs[0] = leg
        if moved.blocked_by is not None:
            # Another way is tried, which counts: so nobody asks for the same way for ever.
            self._aim = None

    def set_out_on(self, path: FloatArray, apart_m: float) -> Trajectory | None:
        """Take what leads on up to where it is so far away from another's path; None: nowhere."""
        ways_on = self._ways_on()
        places = np.array([way.end[:2] for way in ways_on])
        place = place_aside(places, np.array([way.duration_s for way in ways_on]), path, apart_m)
        if place is None:
            return None
        first = next(way for way in ways_on if way.end[:2] == place)
        self._legs = [Leg(first, after(self._way_on(), first.duration_s), None)]
        self._aim = place
        return first

    def _may_try(self, aim: tuple[float, float], path: FloatArray) -> bool:
        # Whether the last ways to a place brought the car nearer, or something new was seen.
        trial = self._trials.setdefault(aim, Trial())
        left_m = float(np.hypot(*np.diff(path, axis=0).T).sum())
        left_m += math.dist(path[0], self.robot.at[:2])
        revision = self.robot.raster.revision
        if left_m < trial.nearest_m - LEAST_M:
            trial.nearest_m, trial.vain = left_m, 0
        elif revision != trial.revision:
            trial.vain = 0
        else:
            trial.vain += 1
        trial.revision = revision
        return trial.vain <= MOST_VAIN

    # The way on ---------------------------------------------------------------------------

    def _way_on(self) -> Ways:
        # What leads on from where the car is.
        return self._legs[0].on_from_here(self.car.reverse) if self._legs else self._on

    def _ways_on(self) -> list[Trajectory]:
        # Beginnings of what leads on, the first of no length.
        apart_s = APART * self.car.turning_radius_m / self.car.speed_m_s
        way = standing_at(self.robot.at)
        for piece in reversed(self._way_on()):
            if way.duration_s >= MOST_HOMES * apart_s:
                break
            way = way.then(piece)
        count = min(MOST_HOMES, math.ceil(way.duration_s / apart_s))
        return [way.until(k * apart_s) for k in range(count + 1)]

    # Planning -----------------------------------------------------------------------------

    def _plan(self, path: FloatArray, seen: tuple[Sighting, ...]) -> Plan | None:
        """Plan a way along a path, and one back to where the car knows how to go on."""
        body, car = self.robot.body, self.car
        points = points_along(path, HORIZON * self.robot.me.range_m)
        ways_on = self._ways_on()
        known = self._known_around(np.vstack([points[:, :2], [way.end[:2] for way in ways_on]]))
        rings = rings_of(known.difference(self._bodies_beside(path, seen)))
        room = body.room(rings, self.robot.at)
        if room is None:
            return None
        find = _Finder(car, room, ways_on)
        here, *others = ways_on
        ends = ends_of(points, rings, body.outer_radius_m)
        far = [end for end in ends if end[3] >= car.turning_radius_m] or ends[:1]
        return (
            find.curve(here, room, far)
            or self._sampled(here, rings, far[:1])
            or find.curve(here, room, ends[len(far) :])
            or next(
                (
                    plan
                    for first in others[:PLACES_BACK]
                    if (there := body.room(rings, first.end)) is not None
                    and (plan := find.curve(first, there, ends)) is not None
                ),
                None,
            )
        )

    def _sampled(self, here: Trajectory, rings: FloatArray, ends: list[End]) -> Plan | None:
        # A plan by sampling, out and back to here.
        for x, y, _, _ in ends:
            seed = int(self.robot.me.rng.integers(1, MOST_SEED))
            ways = car_ways(
                self.robot.body, self.car, rings, here.end, x, y, seed, most_checks=MOST_CHECKS
            )
            if ways is not None:
                return Plan(here, *ways, 0.0)
        return None

    def _known_around(self, points: FloatArray) -> BaseGeometry:
        # What is known to be free around some points: what was seen from the nearest nodes.
        robot = self.robot
        nodes = robot.entries.nodes
        if len(nodes) > len(self._nodes):
            new = list(nodes.values())[len(self._nodes) :]
            self._nodes += new
            self._places = np.vstack([self._places, [node.configuration[:2] for node in new]])
        assert robot.region is not None
        chosen: dict[int, None] = {}
        for x, y in points.tolist():
            away = np.hypot(*(self._places - (x, y)).T)
            for i in np.argsort(away, kind="stable")[:NEAREST].tolist():
                if inside(self._nodes[i].region.boundary, x, y):
                    chosen[i] = None
                    break
        regions = [robot.region, *(self._nodes[i].region for i in chosen)]
        return shapely.union_all([shapely.make_valid(region.polygon()) for region in regions])

    def _bodies_beside(self, path: FloatArray, seen: tuple[Sighting, ...]) -> BaseGeometry:
        # The bodies that the path goes round, with the distance that is kept from them. Those
        # on the path are met, and asked to leave it, but for those known not to do so.
        robot = self.robot
        own = robot.me.footprint.placed(robot.at)
        guard = robot.options.guard_m + robot.options.margin_m
        standing = (body.sighting for body in robot.bodies.values())
        around = []
        for body in {s.robot: s for s in (*standing, *seen)}.values():
            near = robot.body.outer_radius_m + body.footprint.circumscribed_radius_m + guard
            is_met = body.robot not in robot.bodies
            if is_met and stands_in_the_way(path, body.configuration, near):
                continue
            solid = body.footprint.placed(body.configuration)
            around.append(solid.buffer(min(guard, 0.5 * own.distance(solid))))
        return shapely.union_all(around)


class _Finder:
    # Shortest curves to places, and from there back to a way on.

    def __init__(self, car: Car, room: Room, ways_on: list[Trajectory]) -> None:
        self.car = car
        self.room = room
        self.homes = [(way.duration_s, way.end) for way in ways_on if room.holds(way.end)]
        self._backs: dict[Configuration, tuple[Trajectory, float] | None] = {}

    def curve(self, first: Trajectory, room: Room, ends: list[End]) -> Plan | None:
        """Find a way from the end of another one to the first place to which there is any."""
        start = first.end
        for x, y, heading, _ in ends:
            goals = [Configuration(x, y, wrap_angle(heading + turn)) for turn in FAN]
            goals = [goal for goal in goals if room.holds(goal)]
            # Whichever heading is nearest: backwards is as good as forwards.
            for goal in sorted(goals, key=lambda goal: curve_length(self.car, start, goal)):
                out = shortest_way(self.car, room, start, goal)
                if out is None or out.duration_s == 0.0:
                    continue
                if self.car.reverse:
                    return Plan(first, out, out.reversed(), first.duration_s)
                back = self._back(goal)
                if back is not None:
                    return Plan(first, out, *back)
        return None

    def _back(self, place: Configuration) -> tuple[Trajectory, float] | None:
        if place not in self._backs:
            ways = ((shortest_way(self.car, self.room, place, at), s) for s, at in self.homes)
            self._backs[place] = next(((way, s) for way, s in ways if way is not None), None)
        return self._backs[place]


def after(on: Ways, time_s: float) -> Ways:
    """Give what leads on from where the car comes in some time."""
    for k in reversed(range(len(on))):
        if on[k].duration_s > time_s + 1e-9:
            return *on[:k], on[k].after(time_s)
        time_s -= on[k].duration_s
    return ()


def points_along(path: FloatArray, limit_m: float) -> FloatArray:
    """Give points on a polyline up to a length: rows x, y, heading, length from the beginning.

    They are as close as the shortest way that is worth driving.
    """
    steps = np.diff(path, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    last = min(float(ends[-1]), limit_m)
    at = np.linspace(0.0, last, 1 + max(1, math.ceil(last / LEAST_M)))
    if not len(steps):
        return np.array([[*path[0], 0.0, 0.0]])
    x, y = (np.interp(at, ends, path[:, k]) for k in range(2))
    leg = np.clip(np.searchsorted(ends, at) - 1, 0, len(steps) - 1)
    heading = np.arctan2(steps[leg, 1], steps[leg, 0])
    return np.column_stack([x, y, heading, at])


def ends_of(points: FloatArray, rings: FloatArray, radius_m: float) -> list[End]:
    """Choose from points on a path those to drive to, the farthest first, where a disc has room."""
    least_m = min(LEAST_M, float(points[-1, 3]))
    ends: list[End] = []
    for x, y, heading, along in points[::-1].tolist():
        if along < least_m or (ends and ends[-1][3] - along < SPACING_M):
            continue
        if inside(rings, x, y) and disc_clearance(rings, x, y) >= radius_m:
            ends.append((x, y, heading, along))
    return ends
