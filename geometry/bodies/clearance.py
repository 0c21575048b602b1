"""Distances from the boundary of a region, and from discs, to points and paths.

All lengths are in metres, headings in radians. A region is a closed ring ``(m, 2)`` of corners,
counter-clockwise, the first repeated at the end or not. A region with holes is its rings one
after another, each closed by its first corner and followed by a row of NaN, the holes clockwise
(see `rings_of`): no comparison holds for the pieces to and from NaN, so they have no
effect.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.numerics.segments import cross_each_other, squared_distance

TWO_PI: Final = 2.0 * math.pi


def rings_of(region: BaseGeometry) -> FloatArray:
    """Return the rings of polygons, with their holes, as the kernels take them.

    Parameters
    ----------
    region : BaseGeometry
        A polygon, or several; parts that are not polygons are ignored.

    Returns
    -------
    (m, 2) array
        Corners with the region on their left. Every ring is closed, and between two rings, before
        the first and after the last is a row of NaN.

    Examples
    --------
    >>> rings_of(shapely.box(0, 0, 2, 1)).tolist()
    [[nan, nan], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [0.0, 0.0], [2.0, 0.0], [nan, nan]]
    """
    gap = np.full((1, 2), np.nan)
    rows = [gap]
    for part in shapely.get_parts(region):
        if part.geom_type == "Polygon" and not part.is_empty:
            part = shapely.orient_polygons(part)
            for ring in (part.exterior, *part.interiors):
                rows += [np.asarray(ring.coords)[:, :2], gap]
    return np.ascontiguousarray(np.vstack(rows))


@kernel
def disc_clearance(boundary: FloatArray, x: float, y: float) -> float:
    """Return the distance from a point to the boundary, from inside or outside.

    Parameters
    ----------
    boundary : (m, 2) array
        Ring, or rings, of the region in metres.
    x, y : float
        The point in metres.

    Examples
    --------
    >>> room = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
    >>> disc_clearance(room, 1.0, 2.5), disc_clearance(room, -3.0, -4.0)
    (0.5, 5.0)
    """
    nearest = np.inf
    ax, ay = boundary[-1, 0] - x, boundary[-1, 1] - y
    for j in range(boundary.shape[0]):
        bx, by = boundary[j, 0] - x, boundary[j, 1] - y
        nearest = min(nearest, squared_distance(ax, ay, bx, by))
        ax, ay = bx, by
    return math.sqrt(nearest)


@kernel
def paths_keep_clear(paths: FloatArray, discs: FloatArray) -> BoolArray:
    """Return which straight paths keep clear of all discs.

    Parameters
    ----------
    paths : (n, 4) array
        First and last point x, y, x, y of each path in metres.
    discs : (m, 3) array
        Centre x, y and radius of each disc in metres.

    Returns
    -------
    (n,) array of bool
        True where no point of the path is inside a disc; it may touch.

    Examples
    --------
    >>> paths = np.array([(0.0, 0.0, 4.0, 0.0), (0.0, 2.0, 4.0, 2.0)])
    >>> paths_keep_clear(paths, np.array([(2.0, 0.5, 1.0)])).tolist()
    [False, True]
    """
    off = np.ones(paths.shape[0], np.bool_)
    for i in range(paths.shape[0]):
        for k in range(discs.shape[0]):
            x, y, radius = discs[k]
            ax, ay, bx, by = paths[i, 0] - x, paths[i, 1] - y, paths[i, 2] - x, paths[i, 3] - y
            if squared_distance(ax, ay, bx, by) < radius * radius:
                off[i] = False
                break
    return off


class _Arc(NamedTuple):
    """An arc about the origin that begins at (px, py), with its signed angle in radians."""

    px: float
    py: float
    radius: float
    turn: float


@kernel
def path_clearance(
    boundary: FloatArray, x: float, y: float, dx: float, dy: float, turn: float
) -> float:
    """Return the distance from the boundary to a straight path, or to a circular arc.

    Parameters
    ----------
    boundary : (m, 2) array
        Ring, or rings, of the region in metres.
    x, y : float
        First point of the path in metres.
    dx, dy : float
        Displacement from the first to the last point in metres.
    turn : float
        Angle of the arc in radians, counter-clockwise positive, at most one turn; 0: straight.

    Returns
    -------
    float
        Metres; 0 where the path meets the boundary.

    Examples
    --------
    >>> room = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
    >>> path_clearance(room, 1.0, 1.0, 2.0, 0.0, 0.0)
    1.0
    >>> round(path_clearance(room, 1.0, 1.0, 2.0, 0.0, np.pi), 6)
    0.0
    """
    # Seen from the first point, or from the arc's centre.
    px, py = 0.0, 0.0
    radius = 0.0
    if turn != 0.0:
        away = 0.5 / math.tan(0.5 * turn)
        px, py = 0.5 * -dx + away * dy, 0.5 * -dy - away * dx
        radius = math.hypot(px, py)
    qx, qy = px + dx, py + dy
    ox, oy = x - px, y - py
    nearest = np.inf
    ax, ay = boundary[-1, 0] - ox, boundary[-1, 1] - oy
    for j in range(boundary.shape[0]):
        bx, by = boundary[j, 0] - ox, boundary[j, 1] - oy
        nearest = min(nearest, math.sqrt(squared_distance(ax - px, ay - py, bx - px, by - py)))
        nearest = min(nearest, math.sqrt(squared_distance(ax - qx, ay - qy, bx - qx, by - qy)))
        if turn == 0.0:
            nearest = min(nearest, math.sqrt(squared_distance(-ax, -ay, dx - ax, dy - ay)))
            if cross_each_other(ax, ay, bx, by, px, py, qx, qy):
                return 0.0
        else:
            nearest = _near_arc(nearest, ax, ay, bx, by, _Arc(px, py, radius, turn))
        if nearest == 0.0:
            return 0.0
        ax, ay = bx, by
    return nearest


@kernel
def _near_arc(
    nearest: float,
    ax: float,
    ay: float,
    bx: float,
    by: float,
    arc: _Arc,
) -> float:
    # The smaller of a distance and that from segment a-b to an arc. The ends of the arc are not
    # considered.
    radius = arc.radius
    gap = abs(math.hypot(ax, ay) - radius)
    if gap < nearest and _is_on_arc(ax, ay, arc):
        nearest = gap
    ex, ey = bx - ax, by - ay
    squared = ex * ex + ey * ey
    if not squared > 0.0:
        return nearest
    foot = -(ax * ex + ay * ey) / squared
    fx, fy = ax + foot * ex, ay + foot * ey
    offset = math.hypot(fx, fy)
    if offset > radius:
        gap = offset - radius
        if gap < nearest and 0.0 <= foot <= 1.0 and _is_on_arc(fx, fy, arc):
            nearest = gap
        return nearest
    half = math.sqrt((radius - offset) * (radius + offset) / squared)
    for along in (foot - half, foot + half):
        if 0.0 <= along <= 1.0 and _is_on_arc(ax + along * ex, ay + along * ey, arc):
            return 0.0
    return nearest


@kernel
def _is_on_arc(x: float, y: float, arc: _Arc) -> bool:
    # Whether the direction of a point lies within the angle of an arc.
    angle = math.atan2(arc.px * y - arc.py * x, arc.px * x + arc.py * y)
    if arc.turn < 0.0:
        angle = -angle
    if angle < 0.0:
        angle += TWO_PI
    return angle <= abs(arc.turn)
