"""What range finders show: by CGAL's visibility polygon, and by beams met with every wall."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import pyvispoly as cgal
import shapely
from numpy.typing import NDArray
from shapely import Polygon

FloatArray = NDArray[np.float64]

CHORD_M: Final = 0.01
"""Where a view ends at its range, its border consists of chords that lie at most this far inside
the circle, in metres: with them, judge and package mean the same region."""

CHORD_SHARE: Final = 0.0025
"""The same as a share of the range, for short ranges."""

MIN_CHORDS: Final = 8
"""Lower bound of the number of chords of a circle."""

SHARPEST_RAD: Final = math.radians(45.0)
"""Corners of obstacles that may stand unseen between two beams are at least so wide."""

ON_SEGMENT: Final = 1e-12
"""Tolerance of the share of a wall at which a beam meets it."""


class Views:
    """What is seen from places of a connected part of free space.

    Parameters
    ----------
    component : Polygon
        The part of free space, in metres.
    """

    def __init__(self, component: Polygon) -> None:
        whole = shapely.orient_polygons(component)
        rings = [np.asarray(r.coords)[:-1, :2] for r in (whole.exterior, *whole.interiors)]
        outer, *inner = (
            cgal.Polygon([cgal.Point(x, y) for x, y in ring.tolist()]) for ring in rings
        )
        self._calculator = cgal.VisibilityPolygonCalculator(cgal.PolygonWithHoles(outer, inner))
        self._walls: FloatArray = np.concatenate(
            [np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in rings]
        )

    def view(self, x: float, y: float, range_m: float) -> FloatArray:
        """Return the corners of the visibility polygon of a place, cut at a range."""
        seen = self._calculator.compute_visibility_polygon(cgal.Point(float(x), float(y)))
        corners = np.array([(float(p.x()), float(p.y())) for p in seen.boundary()])
        return cut_at_range(corners, (x, y), range_m)

    def beams(self, x: float, y: float, range_m: float, count: int) -> FloatArray:
        """Return the corners of what a laser's beams show to be free.

        On every beam the region ends at the least of its reading and those of its two
        neighbours, r, less what a corner of `SHARPEST_RAD` may reach into the space between two
        beams: at r (1 - tan(a) / tan(c / 2)), a being half the angle between beams and c that
        of the corner.
        """
        angles = 2.0 * math.pi / count * np.arange(count)
        ux, uy = np.cos(angles)[:, None], np.sin(angles)[:, None]
        ax, ay = self._walls[:, 0] - x, self._walls[:, 1] - y
        ex, ey = self._walls[:, 2] - self._walls[:, 0], self._walls[:, 3] - self._walls[:, 1]
        across = ux * ey - uy * ex
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (ax * ey - ay * ex) / across
            share = (ax * uy - ay * ux) / across
        meets = (distance > 0.0) & (share >= -ON_SEGMENT) & (share <= 1.0 + ON_SEGMENT)
        readings = np.where(meets, distance, np.inf).min(axis=1)
        readings = np.minimum(readings, range_m)
        nearest = np.minimum(readings, np.minimum(np.roll(readings, 1), np.roll(readings, -1)))
        less = math.tan(math.pi / count) / math.tan(SHARPEST_RAD / 2.0)
        radii = nearest * (1.0 - less)
        return np.column_stack([x + radii * ux[:, 0], y + radii * uy[:, 0]])


def chords(range_m: float) -> int:
    """Return the number of chords that stand for a circle."""
    sagitta_m = min(CHORD_M, CHORD_SHARE * range_m)
    return max(MIN_CHORDS, math.ceil(math.pi / math.acos(1.0 - sagitta_m / range_m)))


def cut_at_range(corners: FloatArray, place: Sequence[float], range_m: float) -> FloatArray:
    """Return a polygon around a place, cut at a range.

    Parameters
    ----------
    corners : (n, 2) array
        Corners in metres, counter-clockwise; the polygon is star-shaped about the place.
    place : (x, y)
        The place in metres.
    range_m : float
        The range in metres.

    Returns
    -------
    (m, 2) array
        Where the polygon goes beyond the range, chords join the points of the circle in the
        directions 2 pi k / n, and those at which the polygon leaves and enters the circle.
    """
    a = corners - np.asarray(place)
    d = np.roll(a, -1, axis=0) - a
    squares, halves = (d * d).sum(axis=1), (a * d).sum(axis=1)
    below = halves**2 - squares * ((a * a).sum(axis=1) - range_m**2)
    root = np.sqrt(np.maximum(below, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        enters, leaves = (-halves - root) / squares, (-halves + root) / squares
    inside = np.flatnonzero((squares > 0.0) & (below > 0.0) & (leaves > 0.0) & (enters < 1.0))
    step = 2.0 * math.pi / chords(range_m)
    pieces: list[FloatArray] = []
    if not len(inside):
        pieces = [range_m * _directions(step * np.arange(chords(range_m), dtype=np.float64))]
    for edge, after in zip(inside, np.roll(inside, -1), strict=True):
        first = a[edge] + max(0.0, enters[edge]) * d[edge]
        last = a[edge] + min(1.0, leaves[edge]) * d[edge]
        pieces += [first[None], last[None]]
        if leaves[edge] < 1.0:
            again = a[after] + max(0.0, enters[after]) * d[after]
            begin = math.atan2(last[1], last[0])
            turn = (math.atan2(again[1], again[0]) - begin) % (2.0 * math.pi)
            if turn > 2.0 * math.pi - 1e-9:
                continue
            k = np.arange(math.floor(begin / step) + 1, math.ceil((begin + turn) / step))
            pieces.append(range_m * _directions(step * k.astype(np.float64)))
    cut: FloatArray = np.asarray(place) + np.concatenate(pieces)
    return cut


def _directions(angles: FloatArray) -> FloatArray:
    return np.column_stack([np.cos(angles), np.sin(angles)])
