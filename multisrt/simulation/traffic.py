"""The motions of all bodies in time: where they are, and when one comes too near another.

It holds the truth for the simulation. The first encounter of each pair of robots is found once,
and holds until one of the two sets out again or is stopped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely

from multisrt.geometry.bodies.collision import Body, body_distance
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.boxes import intersecting_boxes
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.line_of_sight import line_of_sight
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.protective_stop import stop_within
from multisrt.simulation.courses import NOWHERE, Box, Course, overlap
from multisrt.simulation.encounters import Encounter, first_encounter

STOP_SLACK_M = 1e-5
"""A body within this of the guard distance counts as nearer when a motion begins: a protective
stop ends a motion slightly before the distance is reached."""

ROUNDING_M = 1e-6
"""Bound on how far rounding puts a position on a course outside the box of the course."""


class Traffic:
    """Where all bodies are at any time, and how their motions meet.

    Two bodies see each other if no edge crosses the line between their reference points, or that
    between their nearest points: so bodies that are about to touch are in sight.

    Parameters
    ----------
    bodies : sequence of Body
        The robots' bodies.
    starts : sequence of Configuration
        Where they stand at first.
    index : EdgeIndex
        The edges of the world, which block the sight.
    """

    def __init__(
        self, bodies: Sequence[Body], starts: Sequence[Configuration], index: EdgeIndex
    ) -> None:
        self._bodies = tuple(bodies)
        self._index = index
        self._courses = [Course.standing(start, 0.0) for start in starts]
        self._moving = np.zeros(len(self._bodies), np.bool_)
        self._reaches = np.array([body.footprint.circumscribed_radius_m for body in bodies])
        self._pair_reaches = [self._reaches + reach for reach in self._reaches]
        self._guards = np.zeros(len(self._bodies))
        # First encounters of each robot's present motion, with the other's course they hold for.
        self._known: list[dict[int, tuple[Course, Encounter | None]]] = [{} for _ in starts]
        # Where the last change of a robot's motion may matter to others, and since when.
        self._boxes = np.array([course.remaining_box(0.0) for course in self._courses])
        self._changes = [(course.remaining_box(0.0), 0.0) for course in self._courses]
        self._found = np.empty(len(self._bodies), np.int64)

    def begin(
        self, robot: int, time_s: float, trajectory: Trajectory, guard_m: float | None
    ) -> None:
        """Begin the motion of a robot that stands.

        Parameters
        ----------
        robot : int
            The robot.
        time_s : float
            When it sets out, in seconds.
        trajectory : Trajectory
            Its motion, which starts where it stands.
        guard_m : float or None
            The distance of the protective stop in metres; None for no such stop.

        Raises
        ------
        InvalidInputError
            If the robot moves already, or the distance is not positive and finite.
        """
        if self._moving[robot]:
            raise InvalidInputError(f"robot {robot} moves already; end its motion first")
        if guard_m is not None and not 0.0 < guard_m < math.inf:
            raise InvalidInputError(
                f"a protective stop at {guard_m:g} m; it is positive and finite, or None"
            )
        course = Course(trajectory, time_s, guard_m)
        self._moving[robot] = True
        self._guards[robot] = 0.0 if guard_m is None else guard_m
        self._set(robot, course, (course.remaining_box(time_s), time_s))
        if guard_m is not None:
            here = trajectory.start
            slack = self._pair_reaches[robot] + guard_m + STOP_SLACK_M
            for other in self._near(robot, (*here[:2], *here[:2]), slack):
                distance = self._distance(robot, other, time_s)
                if distance <= guard_m + STOP_SLACK_M:
                    course.nearer[other] = stop_within(distance, guard_m)

    def end(self, robot: int, time_s: float) -> Configuration:
        """End a robot's motion; return where it is at that time, from its arrival on the end.

        Raises
        ------
        InvalidInputError
            If the robot stands.
        """
        if not self._moving[robot]:
            raise InvalidInputError(f"robot {robot} stands; there is no motion to end")
        course = self._courses[robot]
        self._moving[robot] = False
        self._guards[robot] = 0.0
        if time_s >= course.arrival_s:
            # Encounters with it there are known already: it stands where it was going to.
            self._boxes[robot] = course.remaining_box(math.inf)
            self._changes[robot] = (NOWHERE, time_s)
            return course.trajectory.end
        here = course.trajectory.until(time_s - course.begin_s).end
        self._set(robot, Course.standing(here, time_s), (course.remaining_box(time_s), time_s))
        return here

    def where(self, robot: int, time_s: float) -> Configuration:
        """Return where a robot is at a time, not before its last motion began."""
        return self._courses[robot].at(time_s)

    def next_event(self, robot: int, now_s: float) -> Encounter | None:
        """Return the first thing that another body does to a robot's motion, from a time on.

        It is what happens if all robots continue as they do. The protective stop regards bodies in
        sight at its distance; for one that was nearer already when the motion began, `stop_within`
        says where it stops. Contact is regarded always.

        Returns
        -------
        Encounter or None
            The earliest encounter, of several the one with the lowest robot; None if the robot
            arrives without any, or stands.
        """
        if not self._moving[robot]:
            return None
        course = self._courses[robot]
        slack = self._reaches + (self._reaches[robot] + self._guards[robot])
        first: Encounter | None = None
        for other in self._near(robot, course.remaining_box(now_s), slack):
            encounter = self._known_encounter(robot, other, now_s)
            if encounter is not None and (first is None or encounter.time_s < first.time_s):
                first = encounter
        return first

    def affected(self, robot: int) -> list[int]:
        """Return the moving robots whose next events a robot's last `begin` or `end` may change.

        They come in increasing order.
        """
        box, since_s = self._changes[robot]
        if box is NOWHERE:
            return []
        slack = self._pair_reaches[robot] + self._guards
        return [
            other
            for other in self._near(robot, box, slack)
            if self._moving[other]
            and overlap(self._courses[other].remaining_box(since_s), box, slack[other])
        ]

    def in_sight(self, robot: int, time_s: float, range_m: float) -> list[int]:
        """Return the robots that a robot sees, in increasing order.

        It sees a robot whose body is within range of its own reference point, if no edge crosses
        the line between the reference points of the two.

        Parameters
        ----------
        robot : int
            The robot that looks.
        time_s : float
            When, in seconds.
        range_m : float
            The range of its range finder in metres.
        """
        x, y, _ = self.where(robot, time_s)
        seen = []
        for other in self._near(robot, (x, y, x, y), self._reaches + range_m):
            there = self.where(other, time_s)
            if self._distance_to_point(other, there, x, y) <= range_m and line_of_sight(
                self._index, x, y, there.x, there.y
            ):
                seen.append(other)
        return seen

    def may_reach(
        self,
        robot: int,
        range_m: float,
        *,
        relayed: bool,
        base: tuple[float, float] | None = None,
    ) -> list[int]:
        """Return all that may hear a robot or the base, itself included, in increasing order.

        They are those whose courses come within range of the robot's, and, where messages are
        relayed, within range of one another's. It is a superset: the radio asks exactly.

        Parameters
        ----------
        robot : int
            The robot that sends; the number of robots for the base station.
        range_m : float
            The range of the radio in metres.
        relayed : bool
            Whether robots, and the base station, relay messages.
        base : (x, y), optional
            Where the base station is, in metres.
        """
        slack_m = range_m + ROUNDING_M
        slacks, station = np.full(len(self._boxes), slack_m), len(self._boxes)
        at_base = NOWHERE if base is None else (*base, *base)
        found, waiting = {robot}, [robot]
        while waiting:
            number = waiting.pop()
            box = at_base if number == station else tuple(self._boxes[number].tolist())
            near = set(self._meeting(box, slacks)) - found
            if base is not None and station not in found and overlap(box, at_base, slack_m):
                near.add(station)
            found |= near
            waiting += sorted(near) if relayed else []
        return sorted(found)

    def _set(self, robot: int, course: Course, change: tuple[Box, float]) -> None:
        self._known[robot] = {}
        self._courses[robot] = course
        self._boxes[robot] = course.remaining_box(course.begin_s)
        self._changes[robot] = change

    def _near(self, robot: int, box: Box, slack: FloatArray) -> list[int]:
        # The other robots whose courses come within the slack of each of a box.
        if len(self._courses) == 1:
            return []
        return [other for other in self._meeting(box, slack) if other != robot]

    def _meeting(self, box: Box, slack: FloatArray) -> list[int]:
        count = intersecting_boxes(self._boxes, slack, box, self._found)
        found: list[int] = self._found[:count].tolist()
        return found

    def _distance(self, robot: int, other: int, time_s: float) -> float:
        return body_distance(
            self._bodies[robot],
            self.where(robot, time_s),
            self._bodies[other],
            self.where(other, time_s),
        )

    def _distance_to_point(self, robot: int, there: Configuration, x: float, y: float) -> float:
        footprint = self._bodies[robot].footprint
        if footprint.is_disc:
            return math.hypot(there.x - x, there.y - y) - footprint.radius_m
        return float(shapely.distance(footprint.placed(there), shapely.Point(x, y)))

    def _known_encounter(self, robot: int, other: int, now_s: float) -> Encounter | None:
        known, course = self._known[robot], self._courses[other]
        if other in known:
            of_course, encounter = known[other]
            if of_course is course and (encounter is None or encounter.time_s >= now_s):
                return encounter
        encounter = first_encounter(
            self._index,
            (self._bodies[robot], self._bodies[other]),
            (self._courses[robot], course),
            other,
            now_s,
        )
        known[other] = course, encounter
        return encounter
