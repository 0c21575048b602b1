"""Timed motions of a body."""

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
"""A leg that turns by less is straight; collision checks draw the line there, too."""

HALF_CIRCLE_RAD = math.pi + NO_TURN_RAD
"""A leg that translates turns by no more."""

CHORD_RAD = math.radians(3.0)
"""Arcs are drawn as chords of this angle: of a circle of 1 m they are off by 0.3 mm."""


class Waypoint(NamedTuple):
    """A configuration at a time; headings of a trajectory are not wrapped, so turns are signed."""

    time_s: float
    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A body's motion: between two waypoints it moves with a constant twist.

    So the body goes straight where the heading stays, turns in place where the position stays,
    and otherwise follows a circular arc, along which it looks ahead in the same way all the
    time. A leg that translates turns by at most half a circle.

    Attributes
    ----------
    waypoints : tuple of Waypoint
        At least one; times from 0 and never falling.

    Raises
    ------
    InvalidInputError
        If a leg translates and turns by more than half a circle.
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
        """How long the motion takes."""
        return self.waypoints[-1].time_s

    @property
    def length_m(self) -> float:
        """How far the reference point travels."""
        return math.fsum(leg_length(a, b) for a, b in pairwise(self.waypoints))

    @property
    def start(self) -> Configuration:
        """Where the motion begins."""
        return _configuration(self.waypoints[0])

    @property
    def end(self) -> Configuration:
        """Where the motion ends."""
        return _configuration(self.waypoints[-1])

    def at(self, time_s: float) -> Configuration:
        """Give the configuration at a time; before the start the first, after the end the last."""
        if time_s >= self.duration_s:
            return self.end
        following = bisect_right(self.waypoints, time_s, key=itemgetter(0))
        if following == 0:
            return self.start
        a, b = self.waypoints[following - 1], self.waypoints[following]
        x, y, heading = leg_pose(a, b, (time_s - a.time_s) / (b.time_s - a.time_s))
        return Configuration(x, y, wrap_angle(heading))

    def until(self, time_s: float) -> Trajectory:
        """Cut the motion off at a time."""
        kept = tuple(w for w in self.waypoints if w.time_s < time_s)
        if not kept or len(kept) == len(self.waypoints):
            return Trajectory(self.waypoints[:1]) if not kept else self
        a, b = kept[-1], self.waypoints[len(kept)]
        last = leg_pose(a, b, (time_s - a.time_s) / (b.time_s - a.time_s))
        return Trajectory((*kept, Waypoint(time_s, *last)))

    def sections(self, duration_s: float) -> list[Trajectory]:
        """Cut the motion into sections that last so long, but for the last."""
        found, rest = [], self
        while rest.duration_s > duration_s * (1.0 + 1e-9):
            found.append(rest.until(duration_s))
            rest = rest.after(duration_s)
        return [*found, rest]

    def after(self, time_s: float) -> Trajectory:
        """Give what is left of the motion from a time on."""
        first = self.until(time_s).waypoints[-1]
        left = (w for w in self.waypoints if w.time_s > time_s)
        return Trajectory(
            (
                Waypoint(0.0, *first[1:]),
                *(Waypoint(w.time_s - time_s, *w[1:]) for w in left),
            )
        )

    def then(self, other: Trajectory) -> Trajectory:
        """Join another motion that begins where this one ends."""
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
        """Give the motion back along the same way, at the same speeds."""
        whole = self.duration_s
        return Trajectory(
            tuple(Waypoint(whole - w.time_s, *w[1:]) for w in reversed(self.waypoints))
        )

    def points(self, spacing_rad: float = CHORD_RAD) -> FloatArray:
        """Give the way of the reference point as ``(n, 2)`` points, arcs as chords.

        Parameters
        ----------
        spacing_rad : float
            Largest angle of a chord.
        """
        points = [self.waypoints[0][1:3]]
        for a, b in pairwise(self.waypoints):
            points += leg_points(a, b, spacing_rad)[1:]
        return np.array(points)


def leg_pose(a: Sequence[float], b: Sequence[float], fraction: float) -> tuple[float, float, float]:
    """Give x, y and the heading, not wrapped, at a fraction of a motion with constant twist.

    Parameters
    ----------
    a, b : (time, x, y, heading)
        The waypoints at its ends.
    fraction : float
        How much of it has passed, from 0 to 1.
    """
    _, x, y, heading = a
    dx, dy, turn = b[1] - x, b[2] - y, b[3] - heading
    if abs(turn) < NO_TURN_RAD:
        return x + fraction * dx, y + fraction * dy, heading + fraction * turn
    # The chord to here from where the leg begins: the whole one, shortened and turned back.
    share = math.sin(0.5 * fraction * turn) / math.sin(0.5 * turn)
    back = 0.5 * (fraction - 1.0) * turn
    c, s = share * math.cos(back), share * math.sin(back)
    return x + c * dx - s * dy, y + s * dx + c * dy, heading + fraction * turn


def leg_length(a: Sequence[float], b: Sequence[float]) -> float:
    """Give how far the reference point travels between two waypoints (time, x, y, heading)."""
    chord = math.hypot(b[1] - a[1], b[2] - a[2])
    half = 0.5 * abs(b[3] - a[3])
    if chord == 0.0 or 2.0 * half < NO_TURN_RAD:
        return chord
    return chord * half / math.sin(half)


def leg_points(
    a: Sequence[float], b: Sequence[float], spacing_rad: float = CHORD_RAD
) -> list[tuple[float, float]]:
    """Give the way between two waypoints (time, x, y, heading) as points, both ends included.

    Parameters
    ----------
    a, b : (time, x, y, heading)
        The waypoints.
    spacing_rad : float
        Largest angle of a chord of an arc. A straight way has two points, as has a turn in place.
    """
    chords = 1
    if (a[1], a[2]) != (b[1], b[2]):
        chords = max(1, math.ceil(abs(b[3] - a[3]) / spacing_rad))
    inner = [leg_pose(a, b, k / chords)[:2] for k in range(1, chords)]
    return [(a[1], a[2]), *inner, (b[1], b[2])]


def standing_at(configuration: Configuration) -> Trajectory:
    """Give the motion of a body that stands."""
    return Trajectory((Waypoint(0.0, *configuration),))


def _configuration(waypoint: Waypoint) -> Configuration:
    return Configuration(waypoint.x, waypoint.y, wrap_angle(waypoint.heading))
