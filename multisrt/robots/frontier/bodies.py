"""Bodies of other robots that block the path and do not leave."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable
from dataclasses import dataclass
from typing import cast

import numpy as np

from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.robots.explorer import Action, Look, Outcome, Sighting
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.scan_map import ScanMap

MOVED_M = 0.05
"""A robot seen farther than this from where it was has moved."""


@dataclass(frozen=True, slots=True)
class BodyInTheWay:
    """A robot that blocks the path and does not leave.

    Attributes
    ----------
    sighting : Sighting
        Where it was seen.
    seen_s : float
        When it was seen there.
    until_s : float
        The first look after this drops it; ``inf`` if it does not answer: then it is an obstacle
        until it is heard from or seen elsewhere.
    """

    sighting: Sighting
    seen_s: float
    until_s: float

    @property
    def is_lost(self) -> bool:
        """Whether the robot is presumed lost."""
        return math.isinf(self.until_s)


class Bodies:
    """The bodies that one robot takes as obstacles.

    Parameters
    ----------
    course : Course
        The robot's clock.
    map : ScanMap
        What it saw last.
    """

    def __init__(self, course: Course, map: ScanMap) -> None:
        self._course = course
        self._map = map
        self._standing: dict[int, BodyInTheWay] = {}
        # Robots that were dropped to look for them, and where they had been seen.
        self._sought: dict[int, Sighting] = {}

    def __len__(self) -> int:
        return len(self._standing)

    def __contains__(self, robot: int) -> bool:
        return robot in self._standing

    def numbers(self) -> list[int]:
        """Return the numbers of the robots, in the order in which they were added."""
        return list(self._standing)

    def sightings(self) -> list[Sighting]:
        """Return where each was seen."""
        return [body.sighting for body in self._standing.values()]

    def add(self, sighting: Sighting, until_s: float = math.inf) -> None:
        """Take a robot as an obstacle until the first look after a time.

        Parameters
        ----------
        sighting : Sighting
            Where it was seen.
        until_s : float
            The time in seconds; ``inf`` if it is presumed lost.
        """
        number = sighting.robot
        if number in self._sought and has_moved(sighting, self._sought[number]):
            del self._sought[number]
        self._standing[number] = BodyInTheWay(sighting, self._course.time_s, until_s)

    def note_heard(self, robot: int) -> None:
        """Drop a robot that was presumed lost: it was heard from."""
        self._sought.pop(robot, None)
        body = self._standing.get(robot)
        if body is not None and body.is_lost:
            del self._standing[robot]

    def seek_lost(self, age_s: float) -> bool:
        """Drop robots presumed lost that were last seen long ago; return whether there is any.

        They may have left, and only their messages were lost. Each is dropped once, as it may be
        dead, until it is heard from or was seen elsewhere.

        Parameters
        ----------
        age_s : float
            Minimum time in seconds since it was seen.
        """
        sought = {
            number: body.sighting
            for number, body in self._standing.items()
            if body.is_lost
            and self._course.time_s > body.seen_s + age_s
            and number not in self._sought
        }
        for number in sought:
            del self._standing[number]
        self._sought |= sought
        return bool(sought)

    def all_are_lost(self) -> bool:
        """Whether none of the robots answers; true if there is none."""
        return all(body.is_lost for body in self._standing.values())

    def look(self) -> Generator[Action, Outcome, tuple[Sighting, ...]]:
        """Notice the bodies in sight, and drop those that are not where they were seen.

        Yields
        ------
        Look

        Returns
        -------
        tuple of Sighting
            All bodies in sight.
        """
        seen = cast(tuple[Sighting, ...], (yield Look()))
        places = {sighting.robot: sighting for sighting in seen}
        for number, body in list(self._standing.items()):
            if number in places:
                has_left = has_moved(places[number], body.sighting)
            else:
                x, y, _ = body.sighting.configuration
                has_left = inside(self._map.boundary, x, y)
            if has_left or self._course.time_s >= body.until_s:
                del self._standing[number]
        return seen


def has_moved(now: Sighting, then: Sighting) -> bool:
    """Whether a robot is farther than `MOVED_M` from where it was."""
    return now.configuration.distance(then.configuration) > MOVED_M


def discs_of(sightings: Iterable[Sighting], grown_by_m: float = 0.0) -> FloatArray:
    """Return discs around bodies.

    Parameters
    ----------
    sightings : iterable of Sighting
        The bodies.
    grown_by_m : float
        Added to the radius of each.

    Returns
    -------
    (k, 3) array
        x, y and radius of each in metres.
    """
    return np.array(
        [(*s.configuration[:2], grown_by_m + s.footprint.circumscribed_radius_m) for s in sightings]
    ).reshape(-1, 3)
