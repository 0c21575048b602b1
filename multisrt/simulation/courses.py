"""Courses: motions placed in the time of a run, with boxes around what remains of them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from operator import itemgetter

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.trajectory import (
    Trajectory,
    Waypoint,
    leg_length,
    leg_pose,
    standing_at,
)

Box = tuple[float, float, float, float]
"""x0, y0, x1, y1 in metres."""

NOWHERE: Box = (math.inf, math.inf, -math.inf, -math.inf)
"""The empty box."""

Pose = tuple[float, float, float]
"""x, y in metres and heading in radians, not wrapped."""

_time = itemgetter(0)


class Course:
    """A motion that begins at a time; from its end on, the body stands there.

    Parameters
    ----------
    trajectory : Trajectory
        The motion.
    begin_s : float
        When it begins, in seconds.
    guard_m : float or None
        The distance of the protective stop; None for no such stop.

    Attributes
    ----------
    arrival_s : float
        When it ends.
    nearer : dict of int to float
        Robots whose bodies were within the guard when it began, with the distance to stop at.
    """

    __slots__ = (
        "_boxes",
        "_bulges",
        "_track",
        "arrival_s",
        "begin_s",
        "guard_m",
        "nearer",
        "trajectory",
    )

    def __init__(self, trajectory: Trajectory, begin_s: float, guard_m: float | None) -> None:
        self.trajectory = trajectory
        self.begin_s = begin_s
        self.arrival_s = begin_s + trajectory.duration_s
        self.guard_m = guard_m
        self.nearer: dict[int, float] = {}
        points = trajectory.waypoints
        bulges = [leg_length(a, b) * abs(b.heading - a.heading) / 8.0 for a, b in pairwise(points)]
        self._bulges = [*bulges, 0.0]
        self._boxes = _remaining_boxes(points, self._bulges)
        self._track: FloatArray | None = None

    @classmethod
    def standing(cls, configuration: Configuration, begin_s: float) -> Course:
        """Return the course of a body that stands from a time on."""
        return cls(standing_at(configuration), begin_s, None)

    @property
    def track(self) -> FloatArray:
        """Time, x and y of every waypoint, and the bulge of the leg that begins there, ``(n, 4)``.

        The bulge is the largest distance of an arc from its chord, in metres. The array is made
        on first use, as most motions come near no other.
        """
        if self._track is None:
            self._track = np.array(
                [
                    (self.begin_s + w.time_s, w.x, w.y, bulge)
                    for w, bulge in zip(self.trajectory.waypoints, self._bulges, strict=True)
                ]
            )
        return self._track

    def at(self, time_s: float) -> Configuration:
        """Return where the body is at a time."""
        return self.trajectory.at(time_s - self.begin_s)

    def remaining_box(self, time_s: float) -> Box:
        """Return a box around all positions of the reference point from a time on."""
        leg = bisect_right(self.trajectory.waypoints, time_s - self.begin_s, key=_time) - 1
        return self._boxes[max(leg, 0)]

    def stretch(self, begin_s: float, until_s: float) -> tuple[Pose, Pose]:
        """Return the poses, headings not wrapped, at two times within one leg."""
        waypoints = self.trajectory.waypoints
        middle = 0.5 * (begin_s + until_s) - self.begin_s
        following = bisect_right(waypoints, middle, key=_time)
        if following in (0, len(waypoints)):
            here = waypoints[0 if following == 0 else -1][1:]
            return here, here
        a, b = waypoints[following - 1], waypoints[following]

        def pose(time_s: float) -> Pose:
            fraction = (time_s - self.begin_s - a.time_s) / (b.time_s - a.time_s)
            return leg_pose(a, b, min(1.0, max(0.0, fraction)))

        return pose(begin_s), pose(until_s)


def overlap(box: Box, other: Box, slack: float) -> bool:
    """Whether two boxes come within a slack of each other, by x and by y."""
    return (
        box[0] <= other[2] + slack
        and box[2] >= other[0] - slack
        and box[1] <= other[3] + slack
        and box[3] >= other[1] - slack
    )


def _remaining_boxes(points: Sequence[Waypoint], bulges: Sequence[float]) -> list[Box]:
    # For every leg a box around it and all legs that follow.
    boxes: list[Box] = []
    x0, y0, x1, y1 = NOWHERE
    _, next_x, next_y, _ = points[-1]
    for point, bulge in zip(reversed(points), reversed(bulges), strict=True):
        _, x, y, _ = point
        x0, x1 = min(x0, x - bulge, next_x - bulge), max(x1, x + bulge, next_x + bulge)
        y0, y1 = min(y0, y - bulge, next_y - bulge), max(y1, y + bulge, next_y + bulge)
        boxes.append((x0, y0, x1, y1))
        next_x, next_y = x, y
    return boxes[::-1]
