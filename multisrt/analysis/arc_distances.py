"""Distances of points that move on circular arcs from line segments, in closed form."""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray

TURN_TOLERANCE_RAD = 1e-12
"""Angle by which a direction may lie beyond an end of an arc, for rounding."""


def centres_of_rotation(starts: FloatArray, ends: FloatArray, turns: FloatArray) -> FloatArray:
    """Return the points about which motions of constant twist rotate.

    Parameters
    ----------
    starts, ends : (n, 2) array
        Where a point of the body is before and after the motion, in metres.
    turns : (n,) array
        Angles by which the body turns, in radians; not 0, and no whole turns unless the point
        stays.

    Returns
    -------
    (n, 2) array
        In metres.

    Examples
    --------
    A quarter of a circle to the left:

    >>> centres_of_rotation(
    ...     np.array([(0.0, 0.0)]), np.array([(1.0, 1.0)]), np.array([np.pi / 2])
    ... ).round(9)
    array([[-0.,  1.]])
    """
    chords = ends - starts
    aside = np.column_stack([-chords[:, 1], chords[:, 0]])
    stays = (chords == 0.0).all(axis=1)
    height = 0.5 / libm.tan(np.where(stays, 1.0, 0.5 * turns))
    return starts + 0.5 * chords + height[:, None] * aside


def arcs_to_segments(
    centres: FloatArray, starts: FloatArray, turns: FloatArray, segments: FloatArray
) -> FloatArray:
    """Return the distances of circular arcs from line segments.

    All arrays are broadcast to one shape ``(...)`` of pairs.

    Parameters
    ----------
    centres, starts : (..., 2) array
        The centre of each arc and the point where it begins, in metres.
    turns : (...) array
        Its angle in radians, counter-clockwise, of any size.
    segments : (..., 2, 2) array
        The ends of each segment.

    Returns
    -------
    (...) array
        Metres; 0 where they meet.

    Notes
    -----
    The distance is that of an end of the arc from the segment, of an end of the segment from the
    circle, or of the circle from the line at the foot of the perpendicular from the centre; the
    last two count where they fall on the arc and on the segment. It is 0 where the circle
    crosses the line on both. All of these are distances of two points of arc and segment, and
    where both nearest points are inner ones, the line between them is perpendicular to both.

    Examples
    --------
    A point turns by a right angle about the origin, below a wall at y = 3:

    >>> centre, start = np.array([0.0, 0.0]), np.array([1.0, 0.0])
    >>> wall = np.array([(-5.0, 3.0), (5.0, 3.0)])
    >>> float(arcs_to_segments(centre, start, np.array(np.pi / 2), wall))
    2.0
    """
    a, b = segments[..., 0, :], segments[..., 1, :]
    spoke = starts - centres
    radius = np.hypot(spoke[..., 0], spoke[..., 1])
    begin = libm.arctan2(spoke[..., 1], spoke[..., 0])
    cos, sin = libm.cos(turns), libm.sin(turns)
    ends = centres + np.stack(
        [cos * spoke[..., 0] - sin * spoke[..., 1], sin * spoke[..., 0] + cos * spoke[..., 1]], -1
    )
    nearest = np.minimum(_to_segment(starts, a, b), _to_segment(ends, a, b))

    def on_arc(ray: FloatArray) -> BoolArray:
        ahead = (libm.arctan2(ray[..., 1], ray[..., 0]) - begin) * np.where(turns < 0.0, -1.0, 1.0)
        ahead = np.mod(ahead + TURN_TOLERANCE_RAD, 2.0 * math.pi)
        within: BoolArray = ahead <= np.abs(turns) + 2.0 * TURN_TOLERANCE_RAD
        return within

    for corner in (a, b):
        ray = corner - centres
        off = np.abs(np.hypot(ray[..., 0], ray[..., 1]) - radius)
        nearest = np.where(on_arc(ray), np.minimum(nearest, off), nearest)
    along = b - a
    length = np.hypot(along[..., 0], along[..., 1])
    along = along / np.where(length > 0.0, length, 1.0)[..., None]
    at = ((centres - a) * along).sum(-1)
    foot = a + at[..., None] * along - centres
    height = np.hypot(foot[..., 0], foot[..., 1])
    hit = (at >= 0.0) & (at <= length) & on_arc(foot)
    nearest = np.where(hit, np.minimum(nearest, np.abs(height - radius)), nearest)
    half = np.sqrt(np.maximum(radius * radius - height * height, 0.0))
    for offset in (half, -half):
        crossing = (height < radius) & (at + offset >= 0.0) & (at + offset <= length)
        nearest = np.where(crossing & on_arc(foot + offset[..., None] * along), 0.0, nearest)
    return nearest


def _to_segment(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    along = b - a
    length2 = (along * along).sum(-1)
    share = ((points - a) * along).sum(-1) / np.where(length2 > 0.0, length2, 1.0)
    off = points - a - np.clip(share, 0.0, 1.0)[..., None] * along
    distance: FloatArray = np.hypot(off[..., 0], off[..., 1])
    return distance
