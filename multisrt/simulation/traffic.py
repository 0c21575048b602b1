"""The motions of all bodies in time: where they are, and when one comes too near another.

It holds the truth for the simulation. Nothing is stepped through time: the encounters of a pair
of robots follow in closed form or by conservative advancement from the legs of their motions,
are found once, and hold until one of the two sets out anew or is stopped.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import itemgetter
from typing import Literal

import numpy as np
import shapely

from multisrt.geometry.bodies.collision import (
    RESOLUTION_M,
    Body,
    body_distance,
    first_contact_between,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.boxes import boxes_meeting
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.line_of_sight import line_of_sight
from multisrt.planners.motion.trajectory import (
    Trajectory,
    Waypoint,
    leg_length,
    leg_pose,
    standing_at,
)
from multisrt.robots.protective_stop import stop_within

STOP_SLACK_M = 1e-5
"""A protective stop ends a motion a hair before its distance is reached; a body that is no
farther than this beyond counts as nearer when the next motion begins."""

ROUNDING_M = 1e-6
"""How far rounding may put a place on a course outside the box of the course."""

LOOK_M = 0.02
"""While a body is near but hidden, it is looked for each time the two have moved by this."""

FINEST_M = 1e-5
"""The shortest step along a motion, for bodies that stand next to each other."""

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
        Whether it comes so near, in sight, that the protective stop ends the motion, or the two
        are about to touch.
    """

    time_s: float
    other: int
    kind: Kind


class Traffic:
    """Where all bodies are at any time, and how their motions meet.

    Two bodies see each other where nothing stands between their reference points, or between
    their nearest points: so bodies that are about to touch are in sight.

    Parameters
    ----------
    bodies : sequence of Body
        The robots' bodies.
    starts : sequence of Configuration
        Where they stand at first.
    index : EdgeIndex
        The edges of the world, which they cannot see through.
    """

    def __init__(
        self, bodies: Sequence[Body], starts: Sequence[Configuration], index: EdgeIndex
    ) -> None:
        self._bodies = tuple(bodies)
        self._index = index
        self._courses = [_standing(start, 0.0) for start in starts]
        self._moving = np.zeros(len(self._bodies), np.bool_)
        self._reaches = np.array([body.footprint.circumscribed_radius_m for body in bodies])
        self._pair_reaches = [self._reaches + reach for reach in self._reaches]
        self._guards = np.zeros(len(self._bodies))
        # What the last change of a robot's motion may have an effect on, and since when.
        self._boxes = np.array([course.rest(0.0) for course in self._courses])
        self._changes = [(course.rest(0.0), 0.0) for course in self._courses]
        self._found = np.empty(len(self._bodies), np.int64)

    def begin(
        self, robot: int, time_s: float, trajectory: Trajectory, guard_m: float | None
    ) -> None:
        """Let a robot that stands follow a trajectory, which begins where it is.

        Parameters
        ----------
        robot : int
            Which.
        time_s : float
            When it sets out.
        trajectory : Trajectory
            How it moves.
        guard_m : float or None
            The distance of the protective stop; None: no such stop.

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
        course = _Course(trajectory, time_s, guard_m)
        self._moving[robot] = True
        self._guards[robot] = 0.0 if guard_m is None else guard_m
        self._set(robot, course, (course.rest(time_s), time_s))
        if guard_m is not None:
            here = trajectory.start
            slack = self._pair_reaches[robot] + guard_m + STOP_SLACK_M
            for other in self._near(robot, (*here[:2], *here[:2]), slack):
                distance = self._distance(robot, other, time_s)
                if distance <= guard_m + STOP_SLACK_M:
                    course.nearer[other] = stop_within(distance, guard_m)

    def end(self, robot: int, time_s: float) -> Configuration:
        """End a robot's motion where it is at a time; after its arrival that is its very end.

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
            # All that meet it there know already that it stands there in the end.
            self._boxes[robot] = course.rest(math.inf)
            self._changes[robot] = (_NOWHERE, time_s)
            return course.trajectory.end
        here = course.trajectory.until(time_s - course.begin_s).end
        self._set(robot, _standing(here, time_s), (course.rest(time_s), time_s))
        return here

    def where(self, robot: int, time_s: float) -> Configuration:
        """Give where a robot is at a time, from the begin of its last motion on."""
        return self._courses[robot].at(time_s)

    def is_moving(self, robot: int) -> bool:
        """Whether a robot's motion has not been ended."""
        return bool(self._moving[robot])

    def next_event(self, robot: int, now_s: float) -> Encounter | None:
        """Give the first thing that another body does to a robot's motion, from a time on.

        It is what happens if all robots go on as they do. The protective stop counts bodies in
        sight at its distance; one that was nearer already when the motion began, or as near as a
        stop had left it, as `stop_within` says. Contact counts always.

        Returns
        -------
        Encounter or None
            The earliest, of the robot of the lowest number; None: the robot arrives, or stands.
        """
        if not self._moving[robot]:
            return None
        course = self._courses[robot]
        slack = self._reaches + (self._reaches[robot] + self._guards[robot])
        first: Encounter | None = None
        for other in self._near(robot, course.rest(now_s), slack):
            encounter = self._known_encounter(robot, other, now_s)
            if encounter is not None and (first is None or encounter.time_s < first.time_s):
                first = encounter
        return first

    def affected(self, robot: int) -> list[int]:
        """Give the moving robots whose next events may have changed when this one's motion did.

        That is by its last `begin` or `end`; the robots come in increasing order.
        """
        box, since_s = self._changes[robot]
        if box is _NOWHERE:
            return []
        slack = self._pair_reaches[robot] + self._guards
        return [
            other
            for other in self._near(robot, box, slack)
            if self._moving[other]
            and _overlap(self._courses[other].rest(since_s), box, slack[other])
        ]

    def in_sight(self, robot: int, time_s: float, range_m: float) -> list[int]:
        """Give the robots that a robot sees, in increasing order.

        Those are whose bodies are within range of its reference point, with nothing between
        theirs and its own.

        Parameters
        ----------
        robot : int
            Who looks.
        time_s : float
            When.
        range_m : float
            How far it sees.
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

    def may_reach(self, robot: int, range_m: float, *, relayed: bool) -> list[int]:
        """Give all robots whose courses come so near to a robot's that they may hear it.

        It is among them itself, and where messages are relayed also who is near to those.

        Parameters
        ----------
        robot : int
            Which.
        range_m : float
            How far they hear.
        relayed : bool
            Whether they relay.
        """
        # A little more, for places on a course are rounded: whether they hear is asked exactly.
        slacks = np.full(len(self._boxes), range_m + ROUNDING_M)
        found, waiting = {robot}, [robot]
        while waiting:
            box = self._boxes[waiting.pop()]
            near = set(self._meeting(tuple(box.tolist()), slacks)) - found
            found |= near
            waiting += sorted(near) if relayed else []
        return sorted(found)

    # ---------------------------------------------------------------------------------------

    def _set(self, robot: int, course: _Course, change: tuple[_Box, float]) -> None:
        # What the last course knew of others would keep all of theirs that ever were.
        self._courses[robot].encounters.clear()
        self._courses[robot] = course
        self._boxes[robot] = course.rest(course.begin_s)
        self._changes[robot] = change

    def _near(self, robot: int, box: _Box, slack: FloatArray) -> list[int]:
        # The others whose courses come into a box that is widened by the slack of each.
        if len(self._courses) == 1:
            return []
        return [other for other in self._meeting(box, slack) if other != robot]

    def _meeting(self, box: _Box, slack: FloatArray) -> list[int]:
        count = boxes_meeting(self._boxes, slack, box, self._found)
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
        known, others = self._courses[robot].encounters, self._courses[other]
        if other in known:
            course, encounter = known[other]
            if course is others and (encounter is None or encounter.time_s >= now_s):
                return encounter
        encounter = self._encounter(robot, other, now_s)
        known[other] = others, encounter
        return encounter

    def _encounter(self, robot: int, other: int, now_s: float) -> Encounter | None:
        a, b = self._courses[robot], self._courses[other]
        stop = 0.0 if a.guard_m is None else a.nearer.get(other, a.guard_m)
        reach = float(self._reaches[robot] + self._reaches[other]) + stop
        until = max(now_s, a.begin_s)
        while True:
            begin, until = _next_near(a.way, b.way, until, a.arrival_s, reach)
            if begin == math.inf:
                return None
            bodies = self._bodies[robot], self._bodies[other]
            span = _Span(self._index, bodies, (a, b), begin, until)
            met = span.protective_stop(stop) if stop > 0.0 else span.contact(begin)
            if met is not None:
                return Encounter(time_s=met[0], other=other, kind=met[1])


_Box = tuple[float, float, float, float]
_NOWHERE: _Box = (math.inf, math.inf, -math.inf, -math.inf)


class _Course:
    """A motion that begins at a time; the body stands where it ends, from then on."""

    __slots__ = (
        "_boxes",
        "_bulges",
        "_way",
        "arrival_s",
        "begin_s",
        "encounters",
        "guard_m",
        "nearer",
        "trajectory",
    )

    def __init__(self, trajectory: Trajectory, begin_s: float, guard_m: float | None) -> None:
        self.trajectory = trajectory
        self.begin_s = begin_s
        self.arrival_s = begin_s + trajectory.duration_s
        self.guard_m = guard_m
        # Bodies that were nearer than the guard when it began, with the distance to stop at.
        self.nearer: dict[int, float] = {}
        # What is known of encounters with others, and for which course of theirs.
        self.encounters: dict[int, tuple[_Course, Encounter | None]] = {}
        points = trajectory.waypoints
        bulges = [leg_length(a, b) * abs(b.heading - a.heading) / 8.0 for a, b in pairwise(points)]
        self._bulges = [*bulges, 0.0]
        self._boxes = _boxes_of_rests(points, self._bulges)
        self._way: FloatArray | None = None

    @property
    def way(self) -> FloatArray:
        """Every waypoint's time, x and y, and by how much the leg from there bulges: ``(n, 4)``.

        Most motions come near nobody's, and need none.
        """
        if self._way is None:
            self._way = np.array(
                [
                    (self.begin_s + w.time_s, w.x, w.y, bulge)
                    for w, bulge in zip(self.trajectory.waypoints, self._bulges, strict=True)
                ]
            )
        return self._way

    def at(self, time_s: float) -> Configuration:
        """Give where the body is."""
        return self.trajectory.at(time_s - self.begin_s)

    def rest(self, time_s: float) -> _Box:
        """Give a box around all places of the reference point from a time on."""
        leg = bisect_right(self.trajectory.waypoints, time_s - self.begin_s, key=_time) - 1
        return self._boxes[max(leg, 0)]

    def stretch(self, begin_s: float, until_s: float) -> tuple[_Pose, _Pose]:
        """Give the poses, headings not wrapped, at two times within one leg."""
        waypoints = self.trajectory.waypoints
        middle = 0.5 * (begin_s + until_s) - self.begin_s
        following = bisect_right(waypoints, middle, key=_time)
        if following in (0, len(waypoints)):
            here = waypoints[0 if following == 0 else -1][1:]
            return here, here
        a, b = waypoints[following - 1], waypoints[following]

        def pose(time_s: float) -> _Pose:
            fraction = (time_s - self.begin_s - a.time_s) / (b.time_s - a.time_s)
            return leg_pose(a, b, min(1.0, max(0.0, fraction)))

        return pose(begin_s), pose(until_s)


_Pose = tuple[float, float, float]
_time = itemgetter(0)


class _Span:
    """A span of time in which each of two bodies is on one leg of its course, or stands."""

    def __init__(
        self,
        index: EdgeIndex,
        bodies: tuple[Body, Body],
        courses: tuple[_Course, _Course],
        begin_s: float,
        until_s: float,
    ) -> None:
        self._index = index
        self._bodies = bodies
        self._courses = courses
        self._begin_s = begin_s
        self._until_s = until_s

    def contact(self, begin_s: float) -> tuple[float, Kind] | None:
        """Give when the bodies touch."""
        time_s = self._first_within(begin_s, 0.0)
        return None if time_s is None else (time_s, "contact")

    def protective_stop(self, distance_m: float) -> tuple[float, Kind] | None:
        """Give when the bodies are in sight of each other at a distance, or touch."""
        time_s = self._begin_s
        while (near_s := self._first_within(time_s, distance_m)) is not None:
            if self._sees(near_s):
                return near_s, "guard"
            # Near, but hidden: follow them until they see each other, are apart, or touch.
            contact = self.contact(near_s)
            end_s = self._until_s if contact is None else contact[0]
            step_s = self._time_to_move(LOOK_M)
            time_s = near_s
            while time_s < end_s:
                before_s, time_s = time_s, min(time_s + step_s, end_s)
                if self._distance(time_s) > distance_m:
                    break
                if self._sees(time_s):
                    return self._first_sight(before_s, time_s), "guard"
            else:
                return contact
        return None

    def _first_within(self, begin_s: float, distance_m: float) -> float | None:
        (body_a, body_b), (a, b) = self._bodies, self._courses
        start_a, end_a = a.stretch(begin_s, self._until_s)
        start_b, end_b = b.stretch(begin_s, self._until_s)
        # A step that is short beside the distance does not step over it into a contact.
        resolution = RESOLUTION_M if distance_m == 0.0 else max(FINEST_M, 0.4 * distance_m)
        fraction = first_contact_between(
            body_a,
            start_a,
            end_a,
            body_b,
            start_b,
            end_b,
            turn_a=end_a[2] - start_a[2],
            turn_b=end_b[2] - start_b[2],
            arc_a=True,
            arc_b=True,
            gap_m=distance_m,
            resolution_m=min(RESOLUTION_M, resolution),
        )
        return None if fraction is None else begin_s + fraction * (self._until_s - begin_s)

    def _distance(self, time_s: float) -> float:
        (body_a, body_b), (a, b) = self._bodies, self._courses
        return body_distance(body_a, a.at(time_s), body_b, b.at(time_s))

    def _sees(self, time_s: float) -> bool:
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
        for _ in range(20):
            middle = 0.5 * (hidden_s + seen_s)
            if self._sees(middle):
                seen_s = middle
            else:
                hidden_s = middle
        return seen_s

    def _time_to_move(self, distance_m: float) -> float:
        # How long it takes until no point of the bodies can have moved farther, both together.
        way = 0.0
        for body, course in zip(self._bodies, self._courses, strict=True):
            start, end = course.stretch(self._begin_s, self._until_s)
            way += leg_length((0.0, *start), (0.0, *end))
            way += body.turning_radius_m * abs(end[2] - start[2])
        whole = self._until_s - self._begin_s
        return whole if way <= distance_m else whole * distance_m / way


def _standing(configuration: Configuration, time_s: float) -> _Course:
    return _Course(standing_at(configuration), time_s, None)


def _shape(body: Body, at: Configuration) -> shapely.Point | shapely.Polygon:
    # A disc's nearest point lies on the way from its centre, which is free.
    return shapely.Point(at.x, at.y) if body.footprint.is_disc else body.footprint.placed(at)


def _boxes_of_rests(points: Sequence[Waypoint], bulges: Sequence[float]) -> list[_Box]:
    # For every leg a box around it and all that follow.
    boxes: list[_Box] = []
    x0, y0, x1, y1 = _NOWHERE
    _, next_x, next_y, _ = points[-1]
    for point, bulge in zip(reversed(points), reversed(bulges), strict=True):
        _, x, y, _ = point
        x0, x1 = min(x0, x - bulge, next_x - bulge), max(x1, x + bulge, next_x + bulge)
        y0, y1 = min(y0, y - bulge, next_y - bulge), max(y1, y + bulge, next_y + bulge)
        boxes.append((x0, y0, x1, y1))
        next_x, next_y = x, y
    return boxes[::-1]


def _overlap(box: _Box, other: _Box, slack: float) -> bool:
    return (
        box[0] <= other[2] + slack
        and box[2] >= other[0] - slack
        and box[1] <= other[3] + slack
        and box[3] >= other[1] - slack
    )


@kernel
def _next_near(
    a: FloatArray, b: FloatArray, begin: float, end: float, reach: float
) -> tuple[float, float]:
    """Find the next span of time, within one leg of each of two ways, that comes within reach.

    Parameters
    ----------
    a, b : (n, 4) array
        Time, x and y of waypoints, and how far the leg from each bulges away from its chord.
    begin, end : float
        Between which times to look.
    reach : float
        What distance of the reference points counts.

    Returns
    -------
    tuple of float
        From when to when the two are on these legs; infinities if there is no such span.
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
        # The point of the chord that is nearest to the origin.
        squared = vx * vx + vy * vy
        share = 0.0 if squared == 0.0 else min(1.0, max(0.0, -(x * vx + y * vy) / squared))
        nearest = math.hypot(x + share * vx, y + share * vy)
        if nearest <= reach + a[i, 3] + b[j, 3] + 1e-6:
            return time, until
        time = until
    return np.inf, np.inf


@kernel
def _place(way: FloatArray, leg: int, time: float) -> tuple[float, float]:
    if leg + 1 >= way.shape[0]:
        return way[leg, 1], way[leg, 2]
    share = (time - way[leg, 0]) / (way[leg + 1, 0] - way[leg, 0])
    share = min(1.0, max(0.0, share))
    x = way[leg, 1] + share * (way[leg + 1, 1] - way[leg, 1])
    y = way[leg, 2] + share * (way[leg + 1, 2] - way[leg, 2])
    return x, y
