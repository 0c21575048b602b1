"""The area that a body sweeps on a way: what two robots must not share."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.footprint import Footprint, place
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.motion.trajectory import NO_TURN_RAD, Trajectory, Waypoint, leg_pose

NO_WAY_M = 1e-9
"""A shorter way is none; lines of hardly any length have no distance that could be computed."""

SAGITTA_M = 0.002
"""What a chord may leave out of an arc; so much the pad is wider than it had to be."""

LONGEST_TURN_RAD = 0.5 * math.pi
"""Longer turns are looked at in parts, each of which covers no place twice."""


class Sweep:
    """The area that a body covers while it follows a trajectory, or while it stands.

    It lies within `shape` grown by `pad_m`, and fills that but for a few millimetres.

    Parameters
    ----------
    footprint : Footprint
        The body.
    trajectory : Trajectory
        Its motion; a single waypoint is a body that stands.

    Attributes
    ----------
    shape : shapely geometry
        The way of a disc's centre, or what a polygon covers, with chords for arcs.
    pad_m : float
        How far the area reaches beyond the shape.
    """

    __slots__ = ("pad_m", "shape")

    def __init__(self, footprint: Footprint, trajectory: Trajectory) -> None:
        self.shape, self.pad_m = (_of_disc if footprint.is_disc else _of_polygon)(
            footprint, trajectory.waypoints
        )
        shapely.prepare(self.shape)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Give the least x and y of the area, and the greatest."""
        x0, y0, x1, y1 = self.shape.bounds
        return x0 - self.pad_m, y0 - self.pad_m, x1 + self.pad_m, y1 + self.pad_m

    def distance_to(self, other: Sweep) -> float:
        """Distance between two areas in metres, 0 where they meet; never too long.

        It is too short by at most 4 mm for each body that turns.
        """
        gap = float(shapely.distance(self.shape, other.shape)) - (self.pad_m + other.pad_m)
        return max(0.0, gap)

    def comes_within(self, other: Sweep, gap_m: float) -> bool:
        """Whether two areas come as near to each other as a gap, by `distance_to`.

        Cheap where their bounds are apart.
        """
        ax0, ay0, ax1, ay1 = self.bounds
        bx0, by0, bx1, by1 = other.bounds
        aside, above = max(ax0 - bx1, bx0 - ax1, 0.0), max(ay0 - by1, by0 - ay1, 0.0)
        return math.hypot(aside, above) <= gap_m and self.distance_to(other) <= gap_m


def _of_disc(footprint: Footprint, waypoints: tuple[Waypoint, ...]) -> tuple[BaseGeometry, float]:
    points = [waypoints[0][1:3]]
    left_out = 0.0
    for a, b in pairwise(waypoints):
        if math.dist(a[1:3], b[1:3]) < NO_WAY_M:
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
        parts = max(1, math.ceil(abs(b.heading - a.heading) / LONGEST_TURN_RAD))
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
    """Give what the sides of a body pass over as it turns about a centre.

    A side is divided where it comes nearest to the centre, so that on each part of it the
    distance from there only grows: the part then passes over a ring's sector, aslant.
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
    turns = np.array([[np.cos(angles), np.sin(angles)], [-np.sin(angles), np.cos(angles)]])
    there = np.einsum("mi,ijk->mkj", inner, turns)
    back = np.einsum("mi,ijk->mkj", outer, turns)[:, ::-1]
    areas = shapely.polygons(np.concatenate([there, back], axis=1) + centre)
    # Chords of a short part's two arcs can cross.
    return [area if area.is_valid else shapely.make_valid(area) for area in areas.tolist()]


def _chords(a: Waypoint, b: Waypoint, reach: float) -> tuple[int, float]:
    # How many chords stand for a leg, and what they leave out of the arcs of the body's points,
    # which lie within some reach of the reference point.
    turn = abs(b.heading - a.heading)
    if turn < NO_TURN_RAD:
        return 1, 0.0
    radius = reach + math.hypot(b.x - a.x, b.y - a.y) / (2.0 * math.sin(0.5 * turn))
    most = 2.0 * math.acos(max(0.0, 1.0 - SAGITTA_M / radius))
    count = math.ceil(turn / most)
    return count, radius * (1.0 - math.cos(0.5 * turn / count))
