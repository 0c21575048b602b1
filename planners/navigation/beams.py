"""Range readings along beams, as a laser on a robot would give them.

Beam i of n points in the direction ``2 pi i / n`` from the robot's front, counter-clockwise. Beams
have to be dense for the nearness diagram: along a wall at a distance a to the side, neighbouring
beams that end r away differ by about ``2 pi r^2 / (n a)``. Where that exceeds the body's width the
wall looks like a row of gaps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.regions.boundary import OBSTACLE, TagArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion

BEAMS: Final = 720
"""Default number of beams: enough for a small robot beside a wall at a range of a few metres."""

MIN_BEAMS: Final = 8
"""Minimum number of beams; with fewer, valleys have no meaning."""


def region_ranges(region: LocalSafeRegion, at: Configuration, beams: int = BEAMS) -> FloatArray:
    """Return the readings of a robot in a local safe region.

    Parameters
    ----------
    region : LocalSafeRegion
        The region.
    at : Configuration
        Configuration of the robot in it; beam 0 points along its heading.
    beams : int
        Number of beams, at least `MIN_BEAMS`.

    Returns
    -------
    (beams,) array
        Distances to obstacles in metres; ``inf`` where a beam leaves the region at its range, a
        gap or a cut.

    Raises
    ------
    InvalidInputError
        If the robot is outside the region, or there are too few beams.
    """
    if beams < MIN_BEAMS:
        raise InvalidInputError(f"navigation takes at least {MIN_BEAMS} beams, not {beams}")
    if not inside(region.boundary, at.x, at.y):
        raise InvalidInputError(
            f"({at.x:g}, {at.y:g}) is not in the region around ({region.x:g}, {region.y:g}); "
            "scan again from there"
        )
    return _ranges_in(region.boundary, region.tags, at.x, at.y, at.heading, beams)


def nearer(
    ranges: FloatArray,
    discs: FloatArray | None = None,
    polygons: Sequence[FloatArray] = (),
) -> FloatArray:
    """Return the readings with other bodies as additional obstacles.

    Parameters
    ----------
    ranges : (n,) array
        The readings without them in metres.
    discs : (m, 3) array, optional
        x, y and radius of round bodies in the robot's frame.
    polygons : sequence of (k, 2) array
        Corners of other bodies in the robot's frame.

    Returns
    -------
    (n,) array
        The smaller of reading and distance to a body; all 0 if a body covers the robot's
        reference point.

    Raises
    ------
    InvalidInputError
        If there are fewer than `MIN_BEAMS` beams.

    Examples
    --------
    >>> nearer(np.full(8, 5.0), np.array([[2.0, 0.0, 0.5]])).tolist()
    [1.5, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0]
    """
    directions = directions_of(ranges)
    if discs is not None:
        ranges = _cut_by_discs(ranges, directions, np.ascontiguousarray(discs, dtype=np.float64))
    for corners in polygons:
        corners = np.ascontiguousarray(corners, dtype=np.float64)
        ranges = _cut_by_polygon(ranges, directions, corners)
    return ranges


def in_frame_of(at: Configuration, x: float, y: float) -> tuple[float, float]:
    """Return a place in a robot's frame: x along its front, y to its left.

    Examples
    --------
    >>> in_frame_of(Configuration(1.0, 1.0, 0.0), 3.0, 2.0)
    (2.0, 1.0)
    """
    c, s = math.cos(at.heading), math.sin(at.heading)
    dx, dy = x - at.x, y - at.y
    return c * dx + s * dy, c * dy - s * dx


def directions_of(ranges: FloatArray) -> FloatArray:
    """Return the unit vectors of beams in the robot's frame, ``(2, n)``.

    Raises `InvalidInputError` unless `ranges` holds at least `MIN_BEAMS` readings.
    """
    if ranges.ndim != 1 or len(ranges) < MIN_BEAMS:
        raise InvalidInputError(
            f"beams are an (n,) array with n of at least {MIN_BEAMS}, not {ranges.shape}"
        )
    return _directions(len(ranges))


@lru_cache(maxsize=32)
def _directions(beams: int) -> FloatArray:
    angles = np.arange(beams) * (2.0 * math.pi / beams)
    directions = np.array([libm.cos(angles), libm.sin(angles)])
    directions.setflags(write=False)
    return directions


@kernel
def _ranges_in(
    boundary: FloatArray, tags: TagArray, x: float, y: float, heading: float, beams: int
) -> FloatArray:
    # As for a laser, each edge visits the beams that it spans. Edges that face away are skipped;
    # of the others the first that a beam meets ends it.
    inverse = np.zeros(beams)
    open_there = np.ones(beams, np.bool_)
    per_rad = beams / (2.0 * math.pi)
    corners = boundary.shape[0]
    for e in range(corners):
        following = e + 1 if e + 1 < corners else 0
        ax, ay = boundary[e, 0] - x, boundary[e, 1] - y
        bx, by = boundary[following, 0] - x, boundary[following, 1] - y
        cross = ax * by - ay * bx
        if cross <= 0.0:
            continue
        begin_rad = math.atan2(ay, ax) - heading
        start = begin_rad * per_rad
        end = start + math.atan2(cross, ax * bx + ay * by) * per_rad
        along_x, along_y = (by - ay) / cross, (ax - bx) / cross
        is_open = tags[e] != OBSTACLE
        for i in range(int(np.ceil(start - 1e-9)), int(np.floor(end + 1e-9)) + 1):
            angle = heading + i / per_rad
            value = math.cos(angle) * along_x + math.sin(angle) * along_y
            k = i % beams
            # Where an obstacle and an opening meet, the obstacle counts.
            if value > inverse[k] * (1.0 + 1e-9):
                open_there[k] = is_open
            elif value > inverse[k] * (1.0 - 1e-9):
                open_there[k] = open_there[k] and is_open
            inverse[k] = max(inverse[k], value)
    ranges = np.full(beams, np.inf)
    for k in range(beams):
        if not open_there[k]:
            ranges[k] = 1.0 / inverse[k]
    return ranges


@kernel
def _cut_by_discs(ranges: FloatArray, directions: FloatArray, discs: FloatArray) -> FloatArray:
    cut = ranges.copy()
    for k in range(discs.shape[0]):
        x, y, radius = discs[k, 0], discs[k, 1], discs[k, 2]
        outside2 = x * x + y * y - radius * radius
        for i in range(cut.shape[0]):
            if outside2 <= 0.0:
                cut[i] = 0.0
                continue
            ahead = x * directions[0, i] + y * directions[1, i]
            under = ahead * ahead - outside2
            if ahead > 0.0 and under >= 0.0:
                cut[i] = min(cut[i], ahead - math.sqrt(under))
    return cut


@kernel
def _cut_by_polygon(ranges: FloatArray, directions: FloatArray, corners: FloatArray) -> FloatArray:
    cut = ranges.copy()
    covered = inside(corners, 0.0, 0.0)
    ax, ay = corners[-1, 0], corners[-1, 1]
    for k in range(corners.shape[0]):
        bx, by = corners[k, 0], corners[k, 1]
        for i in range(cut.shape[0]):
            ux, uy = directions[0, i], directions[1, i]
            side_a, side_b = ux * ay - uy * ax, ux * by - uy * bx
            if (side_a > 0.0) != (side_b > 0.0):
                share = side_a / (side_a - side_b)
                along = ux * (ax + share * (bx - ax)) + uy * (ay + share * (by - ay))
                if along >= 0.0:
                    cut[i] = min(cut[i], along)
        ax, ay = bx, by
    if covered:
        cut[:] = 0.0
    return cut
