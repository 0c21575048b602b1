"""Curves as polylines, within a tolerance and with a bounded number of segments."""

import math
from typing import Final

import numpy as np

from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

FLATNESS_M: Final = 0.005
"""Maximum distance between a curve of a drawing and its polyline, in metres."""

MAX_SEGMENTS: Final = 1000
"""Upper bound of the segments of a curve; very large curves deviate by more than the tolerance."""


def cubic_points(controls: FloatArray, tolerance: float) -> FloatArray:
    """Return points of a cubic Bézier curve.

    Parameters
    ----------
    controls : float array, shape (4, 2)
        The control points.
    tolerance : float
        Maximum distance between the curve and the polyline, in the unit of the points.

    Returns
    -------
    float array, shape (n, 2)
        At most `MAX_SEGMENTS` points, from after the start to the end.

    Examples
    --------
    >>> import numpy as np
    >>> line = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    >>> cubic_points(line, 0.1)
    array([[3., 0.]])
    """
    # A chord over a step h of the parameter is at most h^2 / 8 max|B''| from the curve.
    bend = 6.0 * float(np.hypot(*np.diff(controls, n=2, axis=0).T).max())
    t = _steps(math.sqrt(bend / (8.0 * tolerance)))[:, np.newaxis]
    s = 1.0 - t
    p0, p1, p2, p3 = controls
    points: FloatArray = s * s * s * p0 + 3 * s * s * t * p1 + 3 * s * t * t * p2 + t * t * t * p3
    points[-1] = p3
    return points


def arc_points(
    center: tuple[float, float],
    radii: tuple[float, float],
    angles: tuple[float, float],
    tolerance: float,
    *,
    turn: float = 0.0,
) -> FloatArray:
    """Return points of an arc of an ellipse.

    Parameters
    ----------
    center : (x, y)
        Centre of the ellipse.
    radii : (a, b)
        Semi-axes.
    angles : (start, sweep)
        Parameter at the start and its change, in radians.
    tolerance : float
        Maximum distance between the arc and the polyline, in the unit of the radii.
    turn : float
        Angle of the axis ``a`` from x, in radians.

    Returns
    -------
    float array, shape (n, 2)
        At most `MAX_SEGMENTS` points, from after the start to the end.

    Examples
    --------
    >>> quarter = arc_points((0, 0), (2, 1), (0, math.pi / 2), 0.01)
    >>> len(quarter), quarter[-1].round(12).tolist()
    (8, [0.0, 1.0])
    """
    start, sweep = angles
    largest = max(radii)
    step = 2.0 * math.acos(max(0.0, 1.0 - tolerance / largest)) if largest > 0.0 else math.pi
    # At most 60 degrees a segment, so that a small circle does not become a line.
    step = min(max(step, 1e-9), math.pi / 3)
    number = abs(sweep) / step
    if abs(sweep) > 6.28:  # whole ellipses keep their four extreme points
        number = 4.0 * math.ceil(min(number, MAX_SEGMENTS) / 4.0)
    t = start + sweep * _steps(number)
    x, y = radii[0] * libm.cos(t), radii[1] * libm.sin(t)
    cos, sin = math.cos(turn), math.sin(turn)
    return np.column_stack([center[0] + cos * x - sin * y, center[1] + sin * x + cos * y])


def _steps(number: float) -> FloatArray:
    """Return equal steps of a parameter from above 0 to 1."""
    count = min(max(math.ceil(min(number, MAX_SEGMENTS) - 1e-9), 1), MAX_SEGMENTS)
    return np.arange(1, count + 1) / count
