"""When one body comes too near another: the first encounter of two courses.

Nothing is stepped through time. For each span in which both bodies keep to one leg of their
courses, the moment of contact, or of a distance, follows in closed form or by conservative
advancement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely

from multisrt.geometry.bodies.collision import (
    RESOLUTION_M,
    Body,
    body_distance,
    first_meeting,
)
from multisrt.geometry.bodies.motion import Motion
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.line_of_sight import line_of_sight
from multisrt.planners.motion.trajectory import leg_length
from multisrt.simulation.courses import Course

LOOK_M = 0.02
"""Motion of two near but hidden bodies, together, between two checks whether they are in sight."""

MIN_RESOLUTION_M = 1e-5
"""The finest resolution of motions that is asked for, for bodies that stand next to each other."""

SIGHT_BISECTIONS = 20
"""Bisections that locate the moment at which two bodies come into sight."""

Kind = Literal["guard", "contact"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Encounter:
    """What another body does to a robot's motion.

    Attributes
    ----------
    time_s : float
        When; the bodies are still apart then.
    other : int
        The robot whose body it is.
    kind : {"guard", "contact"}
        `guard`: it comes so near, in sight, that the protective stop ends the motion.
        `contact`: the two are about to touch.
    """

    time_s: float
    other: int
    kind: Kind


def first_encounter(
    index: EdgeIndex,
    bodies: tuple[Body, Body],
    courses: tuple[Course, Course],
    other: int,
    now_s: float,
) -> Encounter | None:
    """Return the first encounter of a moving body with another one, from a time on.

    Parameters
    ----------
    index : EdgeIndex
        The edges of the world, which block the sight.
    bodies, courses : pair of Body, pair of Course
        The moving body and its course first, the other one's second.
    other : int
        The number of the other robot.
    now_s : float
        From when on, in seconds.

    Returns
    -------
    Encounter or None
        None if there is none before the moving body arrives.
    """
    own, others = courses
    stop_m = 0.0 if own.guard_m is None else own.nearer.get(other, own.guard_m)
    reach_m = sum(body.footprint.circumscribed_radius_m for body in bodies) + stop_m
    until_s = max(now_s, own.begin_s)
    while True:
        begin_s, until_s = _next_near(own.track, others.track, until_s, own.arrival_s, reach_m)
        if begin_s == math.inf:
            return None
        span = _Span(index, bodies, courses, begin_s, until_s)
        met = span.protective_stop(stop_m) if stop_m > 0.0 else span.contact(begin_s)
        if met is not None:
            return Encounter(time_s=met[0], other=other, kind=met[1])


class _Span:
    """A span of time in which each of two bodies keeps to one leg of its course, or stands."""

    def __init__(
        self,
        index: EdgeIndex,
        bodies: tuple[Body, Body],
        courses: tuple[Course, Course],
        begin_s: float,
        until_s: float,
    ) -> None:
        self._index = index
        self._bodies = bodies
        self._courses = courses
        self._begin_s = begin_s
        self._until_s = until_s

    def contact(self, begin_s: float) -> tuple[float, Kind] | None:
        """Return when the bodies touch."""
        time_s = self._first_within(begin_s, 0.0)
        return None if time_s is None else (time_s, "contact")

    def protective_stop(self, distance_m: float) -> tuple[float, Kind] | None:
        """Return when the bodies are in sight of each other at a distance, or touch."""
        time_s = self._begin_s
        while (near_s := self._first_within(time_s, distance_m)) is not None:
            if self._is_in_sight(near_s):
                return near_s, "guard"
            # Near but hidden: follow them until they see each other, are apart, or touch.
            contact = self.contact(near_s)
            end_s = self._until_s if contact is None else contact[0]
            step_s = self._time_to_move(LOOK_M)
            time_s = near_s
            while time_s < end_s:
                before_s, time_s = time_s, min(time_s + step_s, end_s)
                if self._distance(time_s) > distance_m:
                    break
                if self._is_in_sight(time_s):
                    return self._first_sight(before_s, time_s), "guard"
            else:
                return contact
        return None

    def _first_within(self, begin_s: float, distance_m: float) -> float | None:
        (body_a, body_b), (a, b) = self._bodies, self._courses
        # A step that is short beside the distance does not step over it into a contact.
        resolution = RESOLUTION_M if distance_m == 0.0 else max(MIN_RESOLUTION_M, 0.4 * distance_m)
        fraction = first_meeting(
            body_a,
            self._motion(a, begin_s),
            body_b,
            self._motion(b, begin_s),
            gap_m=distance_m,
            resolution_m=min(RESOLUTION_M, resolution),
        )
        return None if fraction is None else begin_s + fraction * (self._until_s - begin_s)

    def _motion(self, course: Course, begin_s: float) -> Motion:
        start, end = course.stretch(begin_s, self._until_s)
        return Motion.between(start, end, end[2] - start[2], arc=True)

    def _distance(self, time_s: float) -> float:
        (body_a, body_b), (a, b) = self._bodies, self._courses
        return body_distance(body_a, a.at(time_s), body_b, b.at(time_s))

    def _is_in_sight(self, time_s: float) -> bool:
        (body_a, body_b), (a, b) = self._bodies, self._courses
        here, there = a.at(time_s), b.at(time_s)
        if line_of_sight(self._index, *here[:2], *there[:2]):
            return True
        if body_a.footprint.is_disc and body_b.footprint.is_disc:
            return False
        between = shapely.shortest_line(_shape(body_a, here), _shape(body_b, there))
        (ax, ay), (bx, by) = shapely.get_coordinates(between)
        return line_of_sight(self._index, float(ax), float(ay), float(bx), float(by))

    def _first_sight(self, hidden_s: float, seen_s: float) -> float:
        for _ in range(SIGHT_BISECTIONS):
            middle = 0.5 * (hidden_s + seen_s)
            if self._is_in_sight(middle):
                seen_s = middle
            else:
                hidden_s = middle
        return seen_s

    def _time_to_move(self, distance_m: float) -> float:
        # A time in which no two points of the bodies move by more than a distance, together.
        moved_m = 0.0
        for body, course in zip(self._bodies, self._courses, strict=True):
            start, end = course.stretch(self._begin_s, self._until_s)
            moved_m += leg_length((0.0, *start), (0.0, *end))
            moved_m += body.turning_radius_m * abs(end[2] - start[2])
        whole = self._until_s - self._begin_s
        return whole if moved_m <= distance_m else whole * distance_m / moved_m


def _shape(body: Body, at: Configuration) -> shapely.Point | shapely.Polygon:
    # A disc's nearest point lies on the line from its centre, so the centre stands for it.
    return shapely.Point(at.x, at.y) if body.footprint.is_disc else body.footprint.placed(at)


@kernel
def _next_near(
    a: FloatArray, b: FloatArray, begin: float, end: float, reach: float
) -> tuple[float, float]:
    """Return the next span of time, within one leg of each of two tracks, that comes within reach.

    Parameters
    ----------
    a, b : (n, 4) array
        Time, x and y of waypoints, and the bulge of the leg from each.
    begin, end : float
        The time in which to search, in seconds.
    reach : float
        The distance of the reference points that counts, in metres.

    Returns
    -------
    tuple of float
        Begin and end of the span; infinite if there is none.
    """
    i = j = 0
    time = begin
    while time < end:
        while i + 1 < a.shape[0] and a[i + 1, 0] <= time:
            i += 1
        while j + 1 < b.shape[0] and b[j + 1, 0] <= time:
            j += 1
        until = end
        if i + 1 < a.shape[0]:
            until = min(until, a[i + 1, 0])
        if j + 1 < b.shape[0]:
            until = min(until, b[j + 1, 0])
        ax, ay = _place(a, i, time)
        bx, by = _place(b, j, time)
        x, y = bx - ax, by - ay
        ax, ay = _place(a, i, until)
        bx, by = _place(b, j, until)
        vx, vy = bx - ax - x, by - ay - y
        # The point nearest to the origin, on the chord of the relative motion.
        squared = vx * vx + vy * vy
        share = 0.0 if squared == 0.0 else min(1.0, max(0.0, -(x * vx + y * vy) / squared))
        nearest = math.hypot(x + share * vx, y + share * vy)
        if nearest <= reach + a[i, 3] + b[j, 3] + 1e-6:
            return time, until
        time = until
    return np.inf, np.inf


@kernel
def _place(track: FloatArray, leg: int, time: float) -> tuple[float, float]:
    if leg + 1 >= track.shape[0]:
        return track[leg, 1], track[leg, 2]
    share = (time - track[leg, 0]) / (track[leg + 1, 0] - track[leg, 0])
    share = min(1.0, max(0.0, share))
    x = track[leg, 1] + share * (track[leg + 1, 1] - track[leg, 1])
    y = track[leg, 2] + share * (track[leg + 1, 2] - track[leg, 2])
    return x, y
