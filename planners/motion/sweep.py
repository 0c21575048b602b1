"""Areas swept by bodies in motion, by which conflicts of paths are found."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.footprint import Footprint, place
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.motion.trajectory import NO_TURN_RAD, Trajectory, Waypoint, leg_pose

MIN_LEG_M = 1e-9
"""A leg shorter than this is left out, in metres: distances to such lines are not computable."""

SAGITTA_M = 0.002
"""Maximum distance between a chord and its arc in metres; the pad is larger by as much."""

MAX_TURN_RAD = 0.5 * math.pi
"""Longer turns are split into parts, each of which covers no point twice."""


class Sweep:
    """The area that a body covers during a motion.

    The area lies within `shape` dilated by `pad_m`, and fills that up to a few millimetres.

    Parameters
    ----------
    footprint : Footprint
        The body.
    trajectory : Trajectory
        Its motion; a single waypoint for a body at rest.

    Attributes
    ----------
    shape : shapely geometry
        The path of a disc's centre, or the area of a polygon, with chords for arcs.
    pad_m : float
        Distance in metres by which the area extends beyond the shape.

    Examples
    --------
    Two discs of radius 0.25 m that drive in parallel, 1 m apart:

    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> disc = Footprint.disc(0.25)
    >>> low = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(4.0, 2.0, 0.0, 0.0)))
    >>> high = Trajectory((Waypoint(0.0, 0.0, 1.0, 0.0), Waypoint(4.0, 2.0, 1.0, 0.0)))
    >>> Sweep(disc, low).distance_to(Sweep(disc, high))
    0.5
    """

    __slots__ = ("pad_m", "shape")

    def __init__(self, footprint: Footprint, trajectory: Trajectory) -> None:
        self.shape, self.pad_m = (_of_disc if footprint.is_disc else _of_polygon)(
            footprint, trajectory.waypoints
        )
        shapely.prepare(self.shape)

    def distance_to(self, other: Sweep) -> float:
        """Return a lower bound of the distance between two areas.

        Parameters
        ----------
        other : Sweep
            The other area.

        Returns
        -------
        float
            Metres; 0 if the areas meet. Short of the true distance by at most 4 mm for each body
            that turns.
        """
        gap = float(shapely.distance(self.shape, other.shape)) - (self.pad_m + other.pad_m)
        return max(0.0, gap)


def _of_disc(footprint: Footprint, waypoints: tuple[Waypoint, ...]) -> tuple[BaseGeometry, float]:
    points = [waypoints[0][1:3]]
    left_out = 0.0
    for a, b in pairwise(waypoints):
        if math.dist(a[1:3], b[1:3]) < MIN_LEG_M:
            continue
        chords, sagitta = _chords(a, b, 0.0)
        left_out = max(left_out, sagitta)
        points += [leg_pose(a, b, (k + 1) / chords)[:2] for k in range(chords)]
    line = shapely.linestrings(points) if len(points) > 1 else shapely.Point(points[0])
    return line, footprint.radius_m + left_out


def _of_polygon(
    footprint: Footprint, waypoints: tuple[Waypoint, ...]
) -> tuple[BaseGeometry, float]:
    reach = footprint.circumscribed_radius_m
    areas: list[BaseGeometry] = [footprint.placed(waypoints[0][1:])]
    left_out = 0.0
    for a, b in pairwise(waypoints):
        if abs(b.heading - a.heading) < NO_TURN_RAD:
            areas.append(footprint.swept(a[1:], (b.x, b.y, a.heading)))
            continue
        chords, sagitta = _chords(a, b, reach)
        left_out = max(left_out, sagitta)
        parts = max(1, math.ceil(abs(b.heading - a.heading) / MAX_TURN_RAD))
        poses = [leg_pose(a, b, k / parts) for k in range(parts + 1)]
        for start, end in pairwise(poses):
            areas += _turned_over(footprint.vertices, start, end, math.ceil(chords / parts))
            areas.append(footprint.placed(end))
    return shapely.union_all(areas), left_out


def _turned_over(
    outline: FloatArray,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    chords: int,
) -> list[BaseGeometry]:
    """Return the areas that the sides of a body pass over as it turns about a centre.

    A side is split at its point nearest to the centre, so that the distance from the centre is
    monotonic along each part. The part then sweeps a skewed sector of a ring.
    """
    x, y, heading = start
    dx, dy, turn = end[0] - x, end[1] - y, end[2] - heading
    away = 0.5 / math.tan(0.5 * turn)
    centre = np.array([x + 0.5 * dx - away * dy, y + 0.5 * dy + away * dx])
    first = place(outline, *start) - centre
    last = np.roll(first, -1, axis=0)
    along = last - first
    foot = -(first * along).sum(axis=1) / (along * along).sum(axis=1)
    divided = (foot > 0.0) & (foot < 1.0)
    feet = (first + foot[:, None] * along)[divided]
    inner = np.vstack([first[~divided], feet, feet])
    outer = np.vstack([last[~divided], first[divided], last[divided]])
    angles = np.linspace(0.0, turn, chords + 1)
    turns = np.array([[libm.cos(angles), libm.sin(angles)], [-libm.sin(angles), libm.cos(angles)]])
    there = np.einsum("mi,ijk->mkj", inner, turns)
    back = np.einsum("mi,ijk->mkj", outer, turns)[:, ::-1]
    areas = shapely.polygons(np.concatenate([there, back], axis=1) + centre)
    # Chords of a short part's two arcs can cross.
    return [area if area.is_valid else shapely.make_valid(area) for area in areas.tolist()]


def _chords(a: Waypoint, b: Waypoint, reach: float) -> tuple[int, float]:
    """Return the number of chords for a leg, and their maximum distance from the true arcs.

    The arcs are those of all points within `reach` of the reference point.
    """
    turn = abs(b.heading - a.heading)
    if turn < NO_TURN_RAD:
        return 1, 0.0
    radius = reach + math.hypot(b.x - a.x, b.y - a.y) / (2.0 * math.sin(0.5 * turn))
    chord_rad = 2.0 * math.acos(max(0.0, 1.0 - SAGITTA_M / radius))
    count = math.ceil(turn / chord_rad)
    return count, radius * (1.0 - math.cos(0.5 * turn / count))
