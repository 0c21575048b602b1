"""Whether a polygon fits inside a region that is known to be free, at rest and as it turns.

All lengths are in metres, headings in radians. A region is a closed ring ``(m, 2)`` of corners,
counter-clockwise, the first repeated at the end or not. A region with holes is its rings one
after another, each closed by its first corner and followed by a row of NaN, the holes clockwise
(see `clearance.rings_of`): no comparison holds for the pieces to and from NaN, so they have no
effect.

Touching is allowed, and so is sliding along the boundary: body and boundary may overlap by
`TOLERANCE_M`, which covers the rounding of a touch. A body that overlaps deeper, or whose numbers
are not finite, does not fit.
"""

import math
from typing import Final

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.numerics.segments import cross_each_other, squared_distance

TOLERANCE_M: Final = 1e-9
"""Depth up to which an overlap counts as a touch, in metres."""

TWO_PI: Final = 2.0 * math.pi


@kernel
def pose_is_inside(
    boundary: FloatArray, body: FloatArray, x: float, y: float, heading: float
) -> bool:
    """Whether a polygon lies inside the region; it may touch the boundary.

    Parameters
    ----------
    boundary : (m, 2) array
        Ring, or rings, of the region in metres.
    body : (k, 2) array
        Corners of the body about its reference point, counter-clockwise, in metres.
    x, y, heading : float
        Configuration of the body in metres and radians.

    Examples
    --------
    >>> room = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
    >>> box = np.array([(-0.5, -0.25), (0.5, -0.25), (0.5, 0.25), (-0.5, 0.25)])
    >>> pose_is_inside(room, box, 0.5, 1.0, 0.0), pose_is_inside(room, box, 0.4, 1.0, 0.0)
    (True, False)
    """
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(heading)):
        return False
    # The body is shrunk by the tolerance. Edges and corners that touch, which is common where
    # walls and bodies follow a grid, are then clearly apart or clearly crossed, and a body whose
    # outline does not cross a ring is inside or outside of it as a whole.
    corners = body.shape[0]
    outline = _shrunk_outline(body, heading)
    reach = _reach(body)
    inside = False
    px, py = outline[-1, 0], outline[-1, 1]
    ax, ay = boundary[-1, 0] - x, boundary[-1, 1] - y
    for j in range(boundary.shape[0]):
        bx, by = boundary[j, 0] - x, boundary[j, 1] - y
        if (ay > py) != (by > py) and px < ax + (bx - ax) * (py - ay) / (by - ay):
            inside = not inside
        if squared_distance(ax, ay, bx, by) < reach * reach:
            vx, vy = px, py
            for i in range(corners):
                ux, uy = vx, vy
                vx, vy = outline[i, 0], outline[i, 1]
                if cross_each_other(ax, ay, bx, by, ux, uy, vx, vy):
                    return False
        ax, ay = bx, by
    return inside


@kernel
def rotation_is_free(
    boundary: FloatArray,
    body: FloatArray,
    x: float,
    y: float,
    heading_from: float,
    turn: float,
) -> bool:
    """Whether a polygon can turn in place about its reference point.

    Parameters
    ----------
    boundary : (m, 2) array
        Ring, or rings, of the region in metres.
    body : (k, 2) array
        Corners of the body about its reference point, counter-clockwise, in metres.
    x, y, heading_from : float
        Configuration at the start in metres and radians.
    turn : float
        Angle to turn by in radians, counter-clockwise positive, from -2 pi to 2 pi.

    Returns
    -------
    bool
        True if the body starts inside the region and never crosses its boundary; False for
        larger turns.

    Examples
    --------
    >>> corridor = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 0.8), (0.0, 0.8)])
    >>> box = np.array([(-0.5, -0.25), (0.5, -0.25), (0.5, 0.25), (-0.5, 0.25)])
    >>> rotation_is_free(corridor, box, 2.0, 0.4, 0.0, 0.1)
    True
    >>> rotation_is_free(corridor, box, 2.0, 0.4, 0.0, np.pi)
    False
    """
    if not pose_is_inside(boundary, body, x, y, heading_from):
        return False
    if not abs(turn) <= TWO_PI + 1e-9:
        return False
    # Two outlines first meet at a corner of one of them: corners of the body move along arcs
    # against the boundary, and in the body's frame the corners of the boundary move backwards.
    corners = body.shape[0]
    c, s = math.cos(heading_from), math.sin(heading_from)
    reach = _reach(body)
    ax, ay = boundary[-1, 0] - x, boundary[-1, 1] - y
    for j in range(boundary.shape[0]):
        bx, by = boundary[j, 0] - x, boundary[j, 1] - y
        if squared_distance(ax, ay, bx, by) < reach * reach:
            # The boundary's corner b in the body's frame.
            corner_x, corner_y = bx * c + by * s, by * c - bx * s
            corner_is_near = bx * bx + by * by < reach * reach
            vx, vy = body[-1, 0], body[-1, 1]
            for i in range(corners):
                ux, uy = vx, vy
                vx, vy = body[i, 0], body[i, 1]
                if _arc_leaves_left(vx * c - vy * s, vx * s + vy * c, turn, ax, ay, bx, by):
                    return False
                if corner_is_near and _arc_leaves_left(corner_x, corner_y, -turn, vx, vy, ux, uy):
                    return False
        ax, ay = bx, by
    return True


@kernel
def _reach(body: FloatArray) -> float:
    # Distance from the reference point within which the body may touch something.
    squared = 0.0
    for i in range(body.shape[0]):
        squared = max(squared, body[i, 0] * body[i, 0] + body[i, 1] * body[i, 1])
    return math.sqrt(squared) + 2.0 * TOLERANCE_M


@kernel
def _shrunk_outline(body: FloatArray, heading: float) -> FloatArray:
    # The body turned by its heading, with its edges moved inwards by the tolerance.
    corners = body.shape[0]
    c, s = math.cos(heading), math.sin(heading)
    outline = np.empty((corners, 2))
    ux, uy = body[-1, 0], body[-1, 1]
    ex, ey = _direction(ux - body[-2, 0], uy - body[-2, 1])
    for i in range(corners):
        vx, vy = body[i, 0], body[i, 1]
        fx, fy = _direction(vx - ux, vy - uy)
        # Corner u, between edges e and f, moves to where their lines meet when moved inwards.
        shift = TOLERANCE_M / max(1.0 + ex * fx + ey * fy, 1e-6)
        wx, wy = ux - shift * (ey + fy), uy + shift * (ex + fx)
        outline[i - 1, 0] = c * wx - s * wy
        outline[i - 1, 1] = s * wx + c * wy
        ux, uy, ex, ey = vx, vy, fx, fy
    return outline


@kernel
def _direction(x: float, y: float) -> tuple[float, float]:
    # The unit vector along a vector; zero for a vector of no length.
    length = math.hypot(x, y)
    if length == 0.0:
        return 0.0, 0.0
    return x / length, y / length


@kernel
def _arc_leaves_left(
    px: float, py: float, turn: float, ax: float, ay: float, bx: float, by: float
) -> bool:
    # Whether point p, turning about the origin, passes from the left of segment a-b to its right.
    # The arc is shrunk by the tolerance towards the left side: its radius where the segment lies
    # across it, its start where it lies along it.
    ex, ey = bx - ax, by - ay
    length = math.hypot(ex, ey)
    radius = math.hypot(px, py)
    if length == 0.0 or radius <= TOLERANCE_M:
        return False
    ex, ey = ex / length, ey / length
    # The left normal is (-ey, ex); the origin is on the left where the line's offset is negative.
    offset = ay * ex - ax * ey
    slack = TOLERANCE_M / radius
    if offset < 0.0:
        radius -= TOLERANCE_M
    elif offset > 0.0:
        radius += TOLERANCE_M
    if abs(offset) >= radius:
        return False
    # On the circle, offset = radius cos(angle from the normal): a point leaves the left side
    # at plus acos if it turns counter-clockwise, at minus acos if clockwise.
    cosine = offset / radius
    sine = math.sqrt((1.0 - cosine) * (1.0 + cosine))
    if turn < 0.0:
        sine = -sine
    qx = radius * (-ey * cosine - ex * sine)
    qy = radius * (ex * cosine - ey * sine)
    along = (qx - ax) * ex + (qy - ay) * ey
    if along < -TOLERANCE_M or along > length + TOLERANCE_M:
        return False
    turned = math.atan2(px * qy - py * qx, px * qx + py * qy)
    if turn < 0.0:
        turned = -turned
    if turned < -slack:
        turned += TWO_PI
    return turned <= abs(turn)
