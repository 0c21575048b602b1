"""Timed motions of a body."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import NamedTuple

from multisrt.geometry.configuration import Configuration, wrap_angle


class Waypoint(NamedTuple):
    """A configuration at a time; headings of a trajectory are not wrapped, so turns are signed."""

    time_s: float
    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A body's motion: between waypoints, position and heading change at constant rates.

    Attributes
    ----------
    waypoints : tuple of Waypoint
        At least one; times from 0 and never falling.
    """

    waypoints: tuple[Waypoint, ...]

    @property
    def duration_s(self) -> float:
        """How long the motion takes."""
        return self.waypoints[-1].time_s

    @property
    def length_m(self) -> float:
        """How far the reference point travels."""
        pairs = zip(self.waypoints, self.waypoints[1:], strict=False)
        return math.fsum(math.hypot(b.x - a.x, b.y - a.y) for a, b in pairs)

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
        following = bisect_right(self.waypoints, time_s, key=lambda waypoint: waypoint.time_s)
        if following == 0:
            return self.start
        if following == len(self.waypoints):
            return self.end
        a, b = self.waypoints[following - 1], self.waypoints[following]
        t = (time_s - a.time_s) / (b.time_s - a.time_s)
        return Configuration(
            a.x + t * (b.x - a.x),
            a.y + t * (b.y - a.y),
            wrap_angle(a.heading + t * (b.heading - a.heading)),
        )

    def until(self, time_s: float) -> Trajectory:
        """Cut the motion off at a time."""
        kept = tuple(w for w in self.waypoints if w.time_s < time_s)
        if not kept or len(kept) == len(self.waypoints):
            return Trajectory(self.waypoints[:1]) if not kept else self
        a, b = kept[-1], self.waypoints[len(kept)]
        t = (time_s - a.time_s) / (b.time_s - a.time_s)
        last = (v + t * (w - v) for v, w in zip(a[1:], b[1:], strict=True))
        return Trajectory((*kept, Waypoint(time_s, *last)))

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


def _configuration(waypoint: Waypoint) -> Configuration:
    return Configuration(waypoint.x, waypoint.y, wrap_angle(waypoint.heading))
