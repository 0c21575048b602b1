"""Local safe regions: what a robot takes as surely free around the place of a scan.

Three shapes, after how much of the readings they keep (Multi-SRT, paper section 3; Oriolo et
al. 2004 for ball and star; Espinoza et al. 2007 for radial):

- *radial*: every reading in its own direction, so the whole visibility polygon;
- *star*: equal cones, each cut at its smallest reading;
- *ball*: a disc of the smallest reading.

Every piece of a region's boundary says why the region ends there: `OBSTACLE`, `RANGE`, `GAP`,
or `CUT` where a star or a ball leaves out space that the readings show to be free. Without the
last a star would see no door narrower than a cone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal

import numpy as np
import shapely

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.boxes import bounds_of
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.boundary import (
    CUT,
    GAP,
    OBSTACLE,
    RANGE,
    TagArray,
    add_open_piece,
    arc_divisions,
    arc_tolerance,
)
from multisrt.geometry.regions.scan import LaserScan, Scan, beam_spacing_rad

Shape = Literal["ball", "star", "radial"]

CONTACT_TOLERANCE_M: Final = 0.05
"""A star's or ball's arc lies at an obstacle where a reading ends within this behind it."""

SHARPEST_CORNER_RAD: Final = math.radians(45.0)
"""Corners of obstacles that stand between two beams are taken to be no sharper than this."""

GRAZING_ANGLE_RAD: Final = math.radians(10.0)
"""Neighbouring beams hit one surface unless it would be met at a flatter angle than this."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocalSafeRegion:
    """A star-shaped polygon of surely free space around the place of a scan.

    Attributes
    ----------
    x, y : float
        The place of the scan in metres.
    range_m : float
        How far the range finder reached.
    boundary : (n, 2) array
        Corners in metres, counter-clockwise, not closed.
    tags : (n,) array of int8
        Why the region ends at the piece from corner i to corner i + 1.
    """

    x: float
    y: float
    range_m: float
    boundary: FloatArray
    tags: TagArray

    def polygon(self) -> shapely.Polygon:
        """Give the region as a shapely polygon."""
        return shapely.Polygon(self.boundary)

    def overlaps(self, other: LocalSafeRegion) -> bool:
        """Whether the region has anything in common with another one; both ask alike."""
        first, second = self.boundary, other.boundary
        if (other.x, other.y) < (self.x, self.y):
            first, second = second, first
        return bool(_have_common_points(first, second))


def local_safe_region(
    scan: Scan,
    shape: Shape,
    *,
    cones: int = 16,
    contact_tolerance_m: float = CONTACT_TOLERANCE_M,
) -> LocalSafeRegion:
    """Build the local safe region of a scan.

    Parameters
    ----------
    scan : Scan
        What the range finder reported.
    shape : {"ball", "star", "radial"}
        How much of the readings the region keeps.
    cones : int
        How many equal cones a star has, at least 3.
    contact_tolerance_m : float
        See `CONTACT_TOLERANCE_M`.

    Raises
    ------
    InvalidInputError
        For an unknown shape, fewer than 3 cones or fewer than 5 beams.

    Notes
    -----
    From beams the region is conservative: between two beams it ends before the nearer of their
    readings, or before the range, by about half the beams' spacing there. It holds no point of
    an obstacle that is wider than the beams' spacing and has no corner sharper than 45 degrees
    (`SHARPEST_CORNER_RAD`); what is thinner can stand between two beams unseen, as for any laser.
    """
    reach = scan.range_m
    if isinstance(scan, LaserScan):
        boundary, tags = _boundary_from_beams(scan)
        half = 0.5 * beam_spacing_rad(scan)
        reach *= math.cos(half) - math.sin(half) / math.tan(0.5 * SHARPEST_CORNER_RAD)
    else:
        boundary, tags = scan.boundary, scan.tags
    x, y, _ = scan.configuration
    if shape in ("star", "ball"):
        if cones < 3:
            raise InvalidInputError(f"a star has at least 3 cones, not {cones}")
        count = cones if shape == "star" else 1
        parts = math.ceil(arc_divisions(scan.range_m, arc_tolerance(scan.range_m)) / count)
        boundary, tags = _cut_at_smallest_readings(
            boundary, tags, x, y, reach, count, parts, contact_tolerance_m
        )
    elif shape != "radial":
        raise InvalidInputError(f"a safe region is ball, star or radial, not {shape!r}")
    boundary.setflags(write=False)
    tags.setflags(write=False)
    return LocalSafeRegion(x=x, y=y, range_m=scan.range_m, boundary=boundary, tags=tags)


def _boundary_from_beams(scan: LaserScan) -> tuple[FloatArray, TagArray]:
    # From a corner of angle c between two beams the chord of their hits is seen under that angle,
    # so that it lies on or behind an arc. It comes nearest for equal readings r: to
    # r (cos a - sin a / tan(c / 2)) along the middle, a being half the spacing; chords between
    # beams at r (1 - tan a / tan(c / 2)) touch it there.
    spacing = beam_spacing_rad(scan)
    if len(scan.ranges) < 5:
        raise InvalidInputError(
            f"a safe region needs at least 5 beams around the robot, not {len(scan.ranges)}"
        )
    x, y, _ = scan.configuration
    directions = _directions(len(scan.ranges), spacing)
    boundary, tags = _chords(scan.ranges, scan.range_m, x, y, spacing, directions)
    return boundary, tags


@lru_cache(maxsize=16)
def _directions(beams: int, spacing_rad: float) -> FloatArray:
    angles = spacing_rad * np.arange(beams)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    directions.setflags(write=False)
    return directions


@kernel
def _have_common_points(a: FloatArray, b: FloatArray) -> bool:
    # Two borders cross or touch, or one polygon lies in the other.
    left, low, right, high = bounds_of(b)
    px, py = a[-1]
    for i in range(a.shape[0]):
        qx, qy = a[i]
        if (
            max(px, qx) >= left
            and min(px, qx) <= right
            and max(py, qy) >= low
            and min(py, qy) <= high
        ):
            ex, ey = qx - px, qy - py
            ux, uy = b[-1]
            side_u = ex * (uy - py) - ey * (ux - px)
            for j in range(b.shape[0]):
                vx, vy = b[j]
                side_v = ex * (vy - py) - ey * (vx - px)
                if (
                    side_u * side_v <= 0.0
                    and max(ux, vx) >= min(px, qx)
                    and min(ux, vx) <= max(px, qx)
                    and max(uy, vy) >= min(py, qy)
                    and min(uy, vy) <= max(py, qy)
                ):
                    fx, fy = vx - ux, vy - uy
                    side_p = fx * (py - uy) - fy * (px - ux)
                    if side_p * (fx * (qy - uy) - fy * (qx - ux)) <= 0.0:
                        return True
                ux, uy, side_u = vx, vy, side_v
        px, py = qx, qy
    return inside(a, b[0, 0], b[0, 1]) or inside(b, a[0, 0], a[0, 1])


@kernel
def _chords(
    ranges: FloatArray,
    range_m: float,
    x: float,
    y: float,
    spacing: float,
    directions: FloatArray,
) -> tuple[FloatArray, TagArray]:
    # A corner on every beam, before the nearest of its reading and those beside it.
    n = ranges.shape[0]
    indent = math.tan(0.5 * spacing) / math.tan(0.5 * SHARPEST_CORNER_RAD)
    steepest = math.tan(GRAZING_ANGLE_RAD)
    reading, nearest = np.empty(n), np.empty(n)
    for i in range(n):
        reading[i] = ranges[i] if np.isfinite(ranges[i]) else range_m
    boundary, tags = np.empty((n, 2)), np.empty(n, np.int8)
    for i in range(n):
        nearest[i] = min(reading[i], reading[i - 1], reading[i + 1 - n])
        radius = nearest[i] * (1.0 - indent)
        boundary[i, 0], boundary[i, 1] = (
            x + radius * directions[i, 0],
            y + radius * directions[i, 1],
        )
    for i in range(n):
        j = i + 1 - n
        is_surface = np.isfinite(ranges[i]) and np.isfinite(ranges[j])
        for distance in (reading, nearest):
            jump = abs(distance[j] - distance[i])
            is_surface &= jump <= min(distance[i], distance[j]) * spacing / steepest
        if is_surface:
            tags[i] = OBSTACLE
        elif nearest[i] == range_m and nearest[j] == range_m:
            tags[i] = RANGE
        else:
            tags[i] = GAP
    return boundary, tags


@kernel
def _cut_at_smallest_readings(
    boundary: FloatArray,
    tags: TagArray,
    x: float,
    y: float,
    reach: float,
    cones: int,
    parts: int,
    contact_tolerance: float,
) -> tuple[FloatArray, TagArray]:
    # 1. The smallest reading in every cone, and the surfaces with the angles that they span.
    n = cones * parts
    width = 2.0 * np.pi / n
    opening = parts * width
    smallest = np.full(cones, reach)
    corners = boundary.shape[0]
    walls = np.empty((corners, 4))
    spans = np.empty((corners, 2))
    wall_count = 0
    for i in range(corners):
        j = i + 1 if i + 1 < corners else 0
        ax, ay = boundary[i, 0] - x, boundary[i, 1] - y
        bx, by = boundary[j, 0] - x, boundary[j, 1] - y
        near_end = min(np.hypot(ax, ay), np.hypot(bx, by))
        if tags[i] == RANGE and near_end > reach - 1e-6:
            continue
        if ax * by - ay * bx < 0.0:
            ax, ay, bx, by = bx, by, ax, ay
        dx, dy = bx - ax, by - ay
        length2 = dx * dx + dy * dy
        if length2 == 0.0:
            continue
        start = np.arctan2(ay, ax)
        end = np.arctan2(by, bx)
        if end < start - np.pi:
            end += 2.0 * np.pi
        closest = -(ax * dx + ay * dy) / length2
        first = int(np.floor((start - 1e-12) / opening))
        last = int(np.floor((end + 1e-12) / opening))
        for cone in range(first, last + 1):
            t0 = _crossing(ax, ay, dx, dy, start, end, cone * opening)
            t1 = _crossing(ax, ay, dx, dy, start, end, (cone + 1) * opening)
            t = min(max(closest, t0), max(t0, t1))
            k = cone % cones
            smallest[k] = min(smallest[k], np.hypot(ax + t * dx, ay + t * dy))
        if tags[i] == OBSTACLE:
            walls[wall_count] = ax, ay, bx, by
            spans[wall_count, 0] = start if start >= 0.0 else start + 2.0 * np.pi
            spans[wall_count, 1] = end - start
            wall_count += 1
    walls, spans = walls[:wall_count], spans[:wall_count]

    # 2. Every cone ends at its smallest reading, on an arc of chords; radial sides join cones of
    #    different depth. Arcs and sides are obstacle where a wall is close behind them.
    most = n + (cones + 1) * (2 + 4 * wall_count)
    result = np.empty((most, 2))
    result_tags = np.empty(most, np.int8)
    count = 0
    placed = walls + np.array([x, y, x, y])
    previous = smallest[cones - 1]
    for cone in range(cones):
        depth = smallest[cone]
        begin = cone * opening
        if abs(previous - depth) > 1e-9:
            ux, uy = np.cos(begin), np.sin(begin)
            count = add_open_piece(
                result,
                result_tags,
                count,
                (x + previous * ux, y + previous * uy),
                (x + depth * ux, y + depth * uy),
                placed,
                contact_tolerance,
                1e-6,
                CUT,
            )
        previous = depth
        contacts = np.empty((0, 2))
        if depth < reach:
            contacts = _contacts(walls, spans, depth + contact_tolerance, begin, opening)
        angle, part = 0.0, 0
        while part < parts:
            # The next corner of the chords, or border of a contact, whichever comes first.
            until = (part + 1) * width
            touching = False
            for k in range(contacts.shape[0]):
                low, high = contacts[k, 0], contacts[k, 1]
                if low <= angle + 1e-9:
                    if high > angle + 1e-9:
                        touching = True
                        until = min(until, high)
                else:
                    until = min(until, low)
            theta = begin + angle
            result[count, 0], result[count, 1] = (
                x + depth * np.cos(theta),
                y + depth * np.sin(theta),
            )
            result_tags[count] = RANGE if depth == reach else (OBSTACLE if touching else CUT)
            count += 1
            angle = until
            if angle >= (part + 1) * width - 1e-9:
                part += 1
                angle = part * width
    return result[:count].copy(), result_tags[:count].copy()


@kernel
def _contacts(
    walls: FloatArray, spans: FloatArray, radius: float, begin: float, opening: float
) -> FloatArray:
    # Between which angles from `begin`, over one cone, walls lie within a radius.
    contacts = np.empty((walls.shape[0] + 1, 2))
    count = 0
    for k in range(walls.shape[0]):
        first = (spans[k, 0] - begin) % (2.0 * np.pi)
        if first > opening and first + spans[k, 1] < 2.0 * np.pi:
            continue
        ax, ay = walls[k, 0], walls[k, 1]
        dx, dy = walls[k, 2] - ax, walls[k, 3] - ay
        length2 = dx * dx + dy * dy
        cross = ax * dy - ay * dx
        chord2 = radius * radius - cross * cross / length2
        if chord2 <= 0.0:
            continue
        middle, half = -(ax * dx + ay * dy) / length2, math.sqrt(chord2 / length2)
        t0, t1 = max(0.0, middle - half), min(1.0, middle + half)
        if t1 <= t0:
            continue
        # Angles relative to the wall's own begin never wrap: a wall spans less than pi.
        low = _angle_between(ax, ay, ax + t0 * dx, ay + t0 * dy)
        high = _angle_between(ax, ay, ax + t1 * dx, ay + t1 * dy)
        if first > opening:
            first -= 2.0 * np.pi
        low, high = max(0.0, first + low), min(opening, first + high)
        if high > low:
            contacts[count, 0], contacts[count, 1] = low, high
            count += 1
    return contacts[:count]


@kernel
def _angle_between(ax: float, ay: float, bx: float, by: float) -> float:
    return math.atan2(ax * by - ay * bx, ax * bx + ay * by)


@kernel
def _crossing(
    ax: float, ay: float, dx: float, dy: float, start: float, end: float, theta: float
) -> float:
    # Where the ray in direction theta meets the segment from a, seen from angle start to end,
    # as a share of the segment's length; its nearer end for rays that pass beside it.
    if theta <= start:
        return 0.0
    if theta >= end:
        return 1.0
    ux, uy = math.cos(theta), math.sin(theta)
    return min(1.0, max(0.0, (ax * uy - ay * ux) / (ux * dy - uy * dx)))
