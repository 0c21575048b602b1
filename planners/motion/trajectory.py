"""Timed motions of bodies."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray

NO_TURN_RAD = 1e-8
"""A leg that turns by less is straight, in radians; also for collision checks."""

HALF_CIRCLE_RAD = math.pi + NO_TURN_RAD
"""Maximum turn of a leg that translates, in radians."""

CHORD_RAD = math.radians(3.0)
"""Default angle of the chords that approximate an arc; 0.3 mm off for a radius of 1 m."""


class Waypoint(NamedTuple):
    """A configuration at a time.

    Attributes
    ----------
    time_s : float
        Seconds since the start of the motion.
    x, y : float
        Position of the reference point in metres.
    heading : float
        Radians, not wrapped, so that turns between waypoints are signed.
    """

    time_s: float
    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A motion with a constant twist between any two waypoints.

    The body moves straight if its heading stays, turns in place if its position stays, and
    otherwise follows a circular arc with a constant angle between its heading and the tangent. A
    leg that translates turns by at most half a circle.

    Attributes
    ----------
    waypoints : tuple of Waypoint
        At least one; times begin at 0 and do not decrease.

    Raises
    ------
    InvalidInputError
        If a leg translates and turns by more than half a circle.

    Examples
    --------
    A quarter of a circle of radius 1 m to the left, in two seconds:

    >>> quarter = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(2.0, 1.0, 1.0, math.pi / 2)))
    >>> round(quarter.length_m, 6)
    1.570796
    >>> x, y, heading = quarter.at(1.0)
    >>> round(x, 3), round(y, 3), round(heading, 3)
    (0.707, 0.293, 0.785)
    """

    waypoints: tuple[Waypoint, ...]

    def __post_init__(self) -> None:
        for a, b in pairwise(self.waypoints):
            if abs(b[3] - a[3]) > HALF_CIRCLE_RAD and (a.x, a.y) != (b.x, b.y):
                raise InvalidInputError(
                    f"the leg from ({a.x:g}, {a.y:g}) to ({b.x:g}, {b.y:g}) turns by "
                    f"{b.heading - a.heading:g} rad; split an arc of more than half a circle"
                )

    @property
    def duration_s(self) -> float:
        """Duration of the motion in seconds."""
        return self.waypoints[-1].time_s

    @property
    def length_m(self) -> float:
        """Length of the reference point's path in metres."""
        return math.fsum(leg_length(a, b) for a, b in pairwise(self.waypoints))

    @property
    def start(self) -> Configuration:
        """First configuration, its heading in (-pi, pi]."""
        return _configuration(self.waypoints[0])

    @property
    def end(self) -> Configuration:
        """Last configuration, its heading in (-pi, pi]."""
        return _configuration(self.waypoints[-1])

    def at(self, time_s: float) -> Configuration:
        """Return the configuration at a time in seconds; the last one after the end."""
        if time_s >= self.duration_s:
            return self.end
        following = bisect_right(self.waypoints, time_s, key=itemgetter(0))
        if following == 0:
            return self.start
        a, b = self.waypoints[following - 1], self.waypoints[following]
        x, y, heading = leg_pose(a, b, (time_s - a.time_s) / (b.time_s - a.time_s))
        return Configuration(x, y, wrap_angle(heading))

    def until(self, time_s: float) -> Trajectory:
        """Return the part of the motion up to a time in seconds; all of it after its end."""
        kept = tuple(w for w in self.waypoints if w.time_s < time_s)
        if not kept or len(kept) == len(self.waypoints):
            return Trajectory(self.waypoints[:1]) if not kept else self
        a, b = kept[-1], self.waypoints[len(kept)]
        last = leg_pose(a, b, (time_s - a.time_s) / (b.time_s - a.time_s))
        return Trajectory((*kept, Waypoint(time_s, *last)))

    def sections(self, duration_s: float) -> list[Trajectory]:
        """Return consecutive parts of the motion, all but the last of them `duration_s` long."""
        found, rest = [], self
        while rest.duration_s > duration_s * (1.0 + 1e-9):
            found.append(rest.until(duration_s))
            rest = rest.after(duration_s)
        return [*found, rest]

    def after(self, time_s: float) -> Trajectory:
        """Return the rest of the motion from a time in seconds on; its own times begin at 0."""
        first = self.until(time_s).waypoints[-1]
        left = (w for w in self.waypoints if w.time_s > time_s)
        return Trajectory(
            (
                Waypoint(0.0, *first[1:]),
                *(Waypoint(w.time_s - time_s, *w[1:]) for w in left),
            )
        )

    def then(self, other: Trajectory) -> Trajectory:
        """Return this motion followed by another that begins where this one ends.

        Headings of the other are shifted by full turns, so that they continue this motion's.
        """
        last, first = self.waypoints[-1], other.waypoints[0]
        offset = last.heading - first.heading
        return Trajectory(
            self.waypoints
            + tuple(
                Waypoint(last.time_s + w.time_s, w.x, w.y, w.heading + offset)
                for w in other.waypoints[1:]
            )
        )

    def reversed(self) -> Trajectory:
        """Return the motion back along the same path at the same speeds."""
        whole = self.duration_s
        return Trajectory(
            tuple(Waypoint(whole - w.time_s, *w[1:]) for w in reversed(self.waypoints))
        )

    def points(self, spacing_rad: float = CHORD_RAD) -> FloatArray:
        """Return the path of the reference point as a polyline.

        Parameters
        ----------
        spacing_rad : float
            Maximum angle of the chords that approximate arcs, in radians.

        Returns
        -------
        (n, 2) array
            Metres.
        """
        points = [self.waypoints[0][1:3]]
        for a, b in pairwise(self.waypoints):
            points += leg_points(a, b, spacing_rad)[1:]
        return np.array(points)


def leg_pose(a: Sequence[float], b: Sequence[float], fraction: float) -> tuple[float, float, float]:
    """Return the pose at a fraction of a leg.

    Parameters
    ----------
    a, b : (time, x, y, heading)
        The waypoints at the ends of the leg.
    fraction : float
        From 0 at `a` to 1 at `b`.

    Returns
    -------
    x, y, heading : float
        Metres and radians; the heading is not wrapped.
    """
    _, x, y, heading = a
    dx, dy, turn = b[1] - x, b[2] - y, b[3] - heading
    whole = math.sin(0.5 * turn)
    if whole == 0.0:
        return x + fraction * dx, y + fraction * dy, heading + fraction * turn
    # The chord from the beginning of the leg is the whole chord, shortened and rotated back. Legs
    # that hardly turn are no exception, so that parts of a leg are where the whole leg is.
    share = math.sin(0.5 * fraction * turn) / whole
    back = 0.5 * (fraction - 1.0) * turn
    c, s = share * math.cos(back), share * math.sin(back)
    return x + c * dx - s * dy, y + s * dx + c * dy, heading + fraction * turn


def leg_length(a: Sequence[float], b: Sequence[float]) -> float:
    """Return the path length in metres between two waypoints (time, x, y, heading)."""
    chord = math.hypot(b[1] - a[1], b[2] - a[2])
    half = 0.5 * abs(b[3] - a[3])
    if chord == 0.0 or 2.0 * half < NO_TURN_RAD:
        return chord
    return chord * half / math.sin(half)


def leg_points(
    a: Sequence[float], b: Sequence[float], spacing_rad: float = CHORD_RAD
) -> list[tuple[float, float]]:
    """Return the path of a leg as points.

    Parameters
    ----------
    a, b : (time, x, y, heading)
        The waypoints at the ends of the leg.
    spacing_rad : float
        Maximum angle of the chords that approximate an arc, in radians.

    Returns
    -------
    list of (x, y)
        Metres, both ends included; two points for a straight leg and for a turn in place.
    """
    chords = 1
    if (a[1], a[2]) != (b[1], b[2]):
        chords = max(1, math.ceil(abs(b[3] - a[3]) / spacing_rad))
    inner = [leg_pose(a, b, k / chords)[:2] for k in range(1, chords)]
    return [(a[1], a[2]), *inner, (b[1], b[2])]


def standing_at(configuration: Configuration) -> Trajectory:
    """Return the motion of a body at rest: a single waypoint at time 0."""
    return Trajectory((Waypoint(0.0, *configuration),))


def _configuration(waypoint: Waypoint) -> Configuration:
    return Configuration(waypoint.x, waypoint.y, wrap_angle(waypoint.heading))
