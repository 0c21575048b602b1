"""Area that a range finder would show for the first time, were all that is not known free."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.safe_region import LocalSafeRegion

RAYS: Final = 72
"""Number of rays: one for every 5 degrees."""

ON_WALL_M: Final = 1e-6
"""Obstacles within this distance in metres of where a ray begins do not stop it."""

SLACK_M: Final = 1e-6
"""Margin in metres by which bounding boxes are enlarged, for rounding."""


def unknown_areas(
    places: FloatArray, range_m: float, regions: Sequence[LocalSafeRegion]
) -> FloatArray:
    """Return the area in sight of places that lies in no region, taken as free.

    Rays from a place end at the first piece of a boundary that is an obstacle, or at the range.
    What of them lies in no region counts by the area of its sector.

    Parameters
    ----------
    places : (m, 2) array
        x and y in metres.
    range_m : float
        Range of the range finder in metres.
    regions : sequence of LocalSafeRegion
        All regions that come within the range of a place.

    Returns
    -------
    (m,) array
        Square metres, from 0 to the area of the disc of the range finder.

    Examples
    --------
    In an unknown world it is that disc; behind a wall along the y axis with known space before it,
    half of it:

    >>> import numpy as np
    >>> place = np.array([[0.0, 0.0]])
    >>> float(unknown_areas(place, 2.0, [])[0] / np.pi)
    4.0
    >>> corners = np.array([[-0.1, -9.0], [-0.1, 9.0], [-9.0, 9.0], [-9.0, -9.0]])
    >>> tags = np.full(4, OBSTACLE, np.int8)
    >>> room = LocalSafeRegion(x=-1.0, y=0.0, range_m=9.0, boundary=corners, tags=tags)
    >>> 2.0 < float(unknown_areas(place, 2.0, [room])[0] / np.pi) < 2.2
    True
    """
    starts = np.zeros(len(regions) + 1, np.int64)
    np.cumsum([len(region.boundary) for region in regions], out=starts[1:])
    corners = np.concatenate([np.empty((0, 2)), *(region.boundary for region in regions)])
    tags = np.concatenate([np.empty(0, np.int8), *(region.tags for region in regions)])
    areas: FloatArray = _unknown_areas(places, range_m, corners, tags == OBSTACLE, starts)
    return areas


@kernel
def _unknown_areas(
    places: FloatArray, range_m: float, corners: FloatArray, walls: BoolArray, starts: IntArray
) -> FloatArray:
    rings = starts.shape[0] - 1
    middles, halves = np.empty((rings, 2)), np.empty((rings, 2))  # of bounding boxes
    for ring in range(rings):
        for axis in range(2):
            of_ring = corners[starts[ring] : starts[ring + 1], axis]
            middles[ring, axis] = 0.5 * (of_ring.max() + of_ring.min())
            halves[ring, axis] = 0.5 * (of_ring.max() - of_ring.min()) + SLACK_M
    spans = np.empty((corners.shape[0] + 1, 2))
    crossings = np.empty(corners.shape[0] + 1)
    areas = np.zeros(places.shape[0])
    for k in range(places.shape[0]):
        x, y = places[k, 0], places[k, 1]
        squares = 0.0  # the sum of the differences of squared radii
        for ray in range(RAYS):
            angle = (ray + 0.5) * 2.0 * math.pi / RAYS
            dx, dy = math.cos(angle), math.sin(angle)
            limit, count = range_m, 0
            for ring in range(rings):
                to_x, to_y = middles[ring, 0] - x, middles[ring, 1] - y
                across = halves[ring, 0] * abs(dy) + halves[ring, 1] * abs(dx)
                along = halves[ring, 0] * abs(dx) + halves[ring, 1] * abs(dy)
                ahead = dx * to_x + dy * to_y
                if (
                    abs(dx * to_y - dy * to_x) > across
                    or ahead + along < 0.0
                    or ahead - along > range_m
                ):
                    continue
                first, last = starts[ring], starts[ring + 1]
                limit, found = _cross(
                    (x, y, dx, dy), limit, corners[first:last], walls[first:last], crossings
                )
                # Seen from outside, the last crossing leaves the ring, the one before enters it.
                ends = np.sort(crossings[:found])
                for end in range(found - 1, -1, -2):
                    spans[count, 0] = ends[end - 1] if end else 0.0
                    spans[count, 1] = ends[end]
                    count += 1
            squares += limit * limit - _covered(spans[:count], limit)
        areas[k] = max(0.0, 0.5 * squares * 2.0 * math.pi / RAYS)
    return areas


@kernel
def _cross(
    ray: tuple[float, float, float, float],
    limit: float,
    ring: FloatArray,
    walls: BoolArray,
    crossings: FloatArray,
) -> tuple[float, int]:
    """Find where a ray crosses a ring; return where the first wall ends it, and their number."""
    x, y, dx, dy = ray
    found = 0
    before = ring.shape[0] - 1
    ax, ay = ring[before, 0] - x, ring[before, 1] - y
    side_a = dx * ay - dy * ax
    for c in range(ring.shape[0]):
        bx, by = ring[c, 0] - x, ring[c, 1] - y
        side_b = dx * by - dy * bx
        # A corner on the ray counts as left of it, so that a ring is left as often as entered.
        if (side_a < 0.0) != (side_b < 0.0):
            t = side_a / (side_a - side_b)
            along = dx * (ax + t * (bx - ax)) + dy * (ay + t * (by - ay))
            if along > 0.0:
                crossings[found] = along
                found += 1
                if walls[before] and ON_WALL_M < along < limit:
                    limit = along
        ax, ay, side_a, before = bx, by, side_b, c
    return limit, found


@kernel
def _covered(spans: FloatArray, limit: float) -> float:
    """Return the sum of the differences of squared radii over the union of spans of a ray."""
    covered, reached = 0.0, 0.0
    for k in np.argsort(spans[:, 0]):
        begin, end = max(spans[k, 0], reached), min(spans[k, 1], limit)
        if end > begin:
            covered += end * end - begin * begin
            reached = end
    return covered
