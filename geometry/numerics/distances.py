"""Distances from points to points, segments and boundaries; lengths; containment in polygons."""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.kernel import kernel


@kernel
def distance_to_boundary(boundary: FloatArray, x: float, y: float, ux: float, uy: float) -> float:
    """Return the distance from a point to the first crossing of a boundary in a direction.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of a polygon in metres; the last is joined to the first.
    x, y : float
        The point in metres.
    ux, uy : float
        Unit vector of the direction.

    Returns
    -------
    float
        Metres; ``inf`` if the ray does not cross the boundary.

    Examples
    --------
    >>> square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    >>> distance_to_boundary(square, 0.5, 1.0, 1.0, 0.0)
    1.5
    """
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
    """Whether a point lies inside a polygon, by the even-odd rule.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the polygon in metres; the last is joined to the first.
    x, y : float
        The point in metres. For one on the boundary the answer may be either.

    Examples
    --------
    >>> square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    >>> inside(square, 0.5, 1.0), inside(square, 2.5, 1.0)
    (True, False)
    """
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
    """Return the distance from ``(x, y)`` to the nearest of ``(n, 2)`` points, ``inf`` of none."""
    nearest = np.inf
    for i in range(points.shape[0]):
        nearest = min(nearest, (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2)
    return math.sqrt(nearest)


@kernel
def nearest_points(points: FloatArray, places: FloatArray) -> FloatArray:
    """Return the distance from each of some places to the nearest of some points.

    Parameters
    ----------
    points : (n, 2) array
        The points in metres.
    places : (k, 2) array
        The places in metres.

    Returns
    -------
    (k,) array
        Metres; ``inf`` if there are no points.

    Examples
    --------
    >>> nearest_points(np.array([(0.0, 0.0), (4.0, 3.0)]), np.array([(4.0, 0.0)])).tolist()
    [3.0]
    """
    result = np.empty(places.shape[0])
    for i in range(places.shape[0]):
        result[i] = nearest_point(points, places[i, 0], places[i, 1])
    return result


@kernel
def distance_to_segments(places: FloatArray, segments: FloatArray) -> FloatArray:
    """Return the distance from each of some places to the nearest of some segments.

    Parameters
    ----------
    places : (k, 2) array
        The places in metres.
    segments : (n, 4) array
        x0, y0, x1, y1 of each segment in metres; it may have no length.

    Returns
    -------
    (k,) array
        Metres; ``inf`` if there are no segments.

    Examples
    --------
    >>> segments = np.array([(0.0, 0.0, 4.0, 0.0)])
    >>> distance_to_segments(np.array([(2.0, 1.5), (7.0, 4.0)]), segments).tolist()
    [1.5, 5.0]
    """
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


def length_of(path: FloatArray) -> float:
    """Return the length of a polyline.

    Parameters
    ----------
    path : (n, 2) array
        Its corners, at least one.

    Returns
    -------
    float
        In units of the corners; 0 for a single point.

    Examples
    --------
    >>> length_of(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]]))
    6.0
    >>> length_of(np.array([[1.0, 2.0]]))
    0.0
    """
    steps = path[1:] - path[:-1]
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
