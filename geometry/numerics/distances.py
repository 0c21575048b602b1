"""How far places are from points, segments and boundaries."""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray, kernel


@kernel
def distance_to_boundary(boundary: FloatArray, x: float, y: float, ux: float, uy: float) -> float:
    """Distance from a point to the first crossing of a boundary in a direction."""
    n = boundary.shape[0]
    nearest = np.inf
    px, py = boundary[n - 1, 0] - x, boundary[n - 1, 1] - y
    side_p = ux * py - uy * px
    for i in range(n):
        qx, qy = boundary[i, 0] - x, boundary[i, 1] - y
        side_q = ux * qy - uy * qx
        if (side_p > 0.0) != (side_q > 0.0):
            fraction = side_p / (side_p - side_q)
            t = ux * (px + fraction * (qx - px)) + uy * (py + fraction * (qy - py))
            if 0.0 <= t < nearest:
                nearest = t
        px, py, side_p = qx, qy, side_q
    return nearest


@kernel
def inside(boundary: FloatArray, x: float, y: float) -> bool:
    """Whether a point lies inside a polygon, by the even-odd rule."""
    n = boundary.shape[0]
    odd = False
    j = n - 1
    for i in range(n):
        if (boundary[i, 1] > y) != (boundary[j, 1] > y):
            slope = (boundary[j, 0] - boundary[i, 0]) / (boundary[j, 1] - boundary[i, 1])
            if x < boundary[i, 0] + (y - boundary[i, 1]) * slope:
                odd = not odd
        j = i
    return odd


@kernel
def nearest_point(points: FloatArray, x: float, y: float) -> float:
    """Distance from a place to the nearest of some points; ``inf`` if there are none."""
    nearest = np.inf
    for i in range(points.shape[0]):
        nearest = min(nearest, (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2)
    return math.sqrt(nearest)


@kernel
def nearest_points(points: FloatArray, places: FloatArray) -> FloatArray:
    """Distance from every place to the nearest of some points."""
    result = np.empty(places.shape[0])
    for i in range(places.shape[0]):
        result[i] = nearest_point(points, places[i, 0], places[i, 1])
    return result


@kernel
def distance_to_segments(places: FloatArray, segments: FloatArray) -> FloatArray:
    """Distance from every place to the nearest of some segments."""
    result = np.full(places.shape[0], np.inf)
    for k in range(segments.shape[0]):
        ax, ay = segments[k, 0], segments[k, 1]
        dx, dy = segments[k, 2] - ax, segments[k, 3] - ay
        length2 = dx * dx + dy * dy
        for i in range(places.shape[0]):
            px, py = places[i, 0] - ax, places[i, 1] - ay
            t = 0.0
            if length2 > 0.0:
                t = min(1.0, max(0.0, (px * dx + py * dy) / length2))
            distance = np.hypot(px - t * dx, py - t * dy)
            result[i] = min(result[i], distance)
    return result
