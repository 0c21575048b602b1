"""How far a body may move inside a region that is known to be free.

The kernels a planner asks about the region around a robot. The region is a closed ring
``(m, 2)`` of corners, counter-clockwise, the first repeated at the end or not; the
body starts inside it. All lengths are in metres, headings in radians. Arrays are float64.

A region with holes is its rings one after another, each closed by its first corner and followed
by a row of NaN, the holes clockwise (`rings_of`): `pose_is_inside`, `free_travel_polygon`,
`rotation_is_free`, `disc_clearance` and `path_clearance` take it, too. No comparison holds for
the pieces to and from NaN, so they are nowhere.

Touching is allowed, and so is sliding along the boundary: bodies and boundary may overlap by
`TOLERANCE_M`, which is what rounding makes of a touch; whatever goes deeper is blocked. A body
that already overlaps deeper, or whose numbers are not finite, may not move at all.
"""

import math

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel
from multisrt.geometry.numerics.segments import cross_each_other, squared_distance

TOLERANCE_M = 1e-9
"""Overlaps up to this depth count as touching."""

CLEARLY_M = 1e-6
"""What is further away than a touch by this is so in spite of all rounding."""

TWO_PI = 2.0 * math.pi


def rings_of(region: BaseGeometry) -> FloatArray:
    """Give the rings of a polygon or several, with their holes, as one ``(m, 2)`` array.

    Every ring is closed and followed by a row of NaN; the region is on the left.
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
    """Distance from a point to the boundary ring, inside or outside."""
    nearest = np.inf
    ax, ay = boundary[-1, 0] - x, boundary[-1, 1] - y
    for j in range(boundary.shape[0]):
        bx, by = boundary[j, 0] - x, boundary[j, 1] - y
        nearest = min(nearest, squared_distance(ax, ay, bx, by))
        ax, ay = bx, by
    return math.sqrt(nearest)


@kernel
def path_clearance(
    boundary: FloatArray, x: float, y: float, dx: float, dy: float, turn: float
) -> float:
    """Distance from the boundary to a straight way, or to one along a circular arc.

    Parameters
    ----------
    boundary : (m, 2) array
        The ring, or rings.
    x, y : float
        Where the way begins.
    dx, dy : float
        From there to where it ends.
    turn : float
        Angle of the arc, counter-clockwise positive, at most a whole circle; 0: straight.

    Returns
    -------
    float
        Metres; 0 where the way meets the boundary.
    """
    # Seen from the way's beginning, or from the arc's centre.
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
            nearest = _near_arc(nearest, ax, ay, bx, by, px, py, radius, turn)
        if nearest == 0.0:
            return 0.0
        ax, ay = bx, by
    return nearest


@kernel
def free_travel_disc(
    boundary: FloatArray,
    x: float,
    y: float,
    cos_t: float,
    sin_t: float,
    radius: float,
    limit: float,
) -> float:
    """How far a disc may move in a direction until it touches the boundary.

    Parameters
    ----------
    boundary : (m, 2) array
        The ring.
    x, y : float
        Centre of the disc.
    cos_t, sin_t : float
        Unit vector of the motion.
    radius : float
        Radius of the disc.
    limit : float
        Longest travel of interest.

    Returns
    -------
    float
        Travel in metres, from 0 to ``limit``; 0 where the disc already overlaps the boundary.
    """
    # Seen from the centre, every edge is grown into a stadium (its two circles and its two long
    # sides). The ray is blocked by a stadium if it enters one of radius r - tolerance; it then
    # is to stop where it enters the one of radius r.
    if not (math.isfinite(x + y + cos_t + sin_t + radius) and limit > 0.0):
        return 0.0
    inner = radius - TOLERANCE_M
    clear = radius + CLEARLY_M
    travel = limit
    bx, by = boundary[-1, 0] - x, boundary[-1, 1] - y
    next_ahead, next_aside = bx * cos_t + by * sin_t, bx * sin_t - by * cos_t
    for j in range(boundary.shape[0]):
        ax, ay, ahead, aside = bx, by, next_ahead, next_aside
        bx, by = boundary[j, 0] - x, boundary[j, 1] - y
        next_ahead, next_aside = bx * cos_t + by * sin_t, bx * sin_t - by * cos_t
        # Most edges lie wholly behind the disc, further on, or on one side of its way.
        if (
            (ahead < -clear and next_ahead < -clear)
            or (ahead > travel + clear and next_ahead > travel + clear)
            or (aside < -clear and next_aside < -clear)
            or (aside > clear and next_aside > clear)
        ):
            continue
        if not squared_distance(ax, ay, bx, by) >= inner * inner:
            return 0.0
        if ahead > 0.0 and abs(aside) < inner:
            entry = ahead - math.sqrt((radius - aside) * (radius + aside))
            travel = min(travel, max(entry, 0.0))
        ex, ey = bx - ax, by - ay
        length = math.hypot(ex, ey)
        if length > 0.0:
            ex, ey = ex / length, ey / length
            # Distance of the centre from the edge's line, and how fast it shrinks.
            offset = ax * ey - ay * ex
            closing = cos_t * ey - sin_t * ex
            if offset < 0.0:
                offset, closing = -offset, -closing
            if closing > 0.0:
                start = -(ax * ex + ay * ey)
                drift = cos_t * ex + sin_t * ey
                deep = start + drift * (offset - inner) / closing
                if offset >= inner and 0.0 <= deep <= length:
                    entry = max((offset - radius) / closing, 0.0)
                    # A ray that slips in round the end is over the edge only from there.
                    if drift > 0.0:
                        entry = max(entry, -start / drift)
                    elif drift < 0.0:
                        entry = max(entry, (length - start) / drift)
                    travel = min(travel, entry)
    return travel


@kernel
def free_travel_disc_fan(
    boundary: FloatArray, x: float, y: float, directions: FloatArray, radius: float, limit: float
) -> FloatArray:
    """Give `free_travel_disc` for many directions in radians, as an array of their length."""
    travels = np.empty(directions.shape[0])
    for k in range(directions.shape[0]):
        travels[k] = free_travel_disc(
            boundary, x, y, math.cos(directions[k]), math.sin(directions[k]), radius, limit
        )
    return travels


@kernel
def disc_bridges(
    places: FloatArray,
    corners: FloatArray,
    starts: IntArray,
    pairs: IntArray,
    radius: float,
) -> BoolArray:
    """Whether a disc gets straight from place to place through the regions around both.

    It goes as far as it gets in the one's region; the rest of the way has to lie in the other's.

    Parameters
    ----------
    places : (n, 2) array
        Where the disc is, and where it is to get.
    corners, starts : (c, 2) and (n + 1,) arrays
        The ring around place k is ``corners[starts[k]:starts[k + 1]]``.
    pairs : (m, 2) array of int
        From which place to which.
    radius : float
        Radius of the disc.

    Returns
    -------
    (m,) array of bool
    """
    joined = np.ones(pairs.shape[0], np.bool_)
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        x, y = places[a, 0], places[a, 1]
        px, py = places[b, 0], places[b, 1]
        dx, dy = px - x, py - y
        length = math.hypot(dx, dy)
        if length > 0.0:
            ux, uy = dx / length, dy / length
            ring = corners[starts[a] : starts[a + 1]]
            reached = free_travel_disc(ring, x, y, ux, uy, radius, length)
            if reached < length:
                ring = corners[starts[b] : starts[b + 1]]
                reached += free_travel_disc(ring, px, py, -ux, -uy, radius, length)
            joined[k] = reached >= length
    return joined


@kernel
def free_travel_polygon(
    boundary: FloatArray,
    body: FloatArray,
    x: float,
    y: float,
    heading: float,
    cos_t: float,
    sin_t: float,
    limit: float,
) -> float:
    """How far a polygon may move in a direction, its heading kept, until it touches the boundary.

    Parameters
    ----------
    boundary : (m, 2) array
        The ring.
    body : (k, 2) array
        Corners of the body about its reference point, counter-clockwise.
    x, y, heading : float
        Configuration of the body.
    cos_t, sin_t : float
        Unit vector of the motion.
    limit : float
        Longest travel of interest.

    Returns
    -------
    float
        Travel in metres, from 0 to ``limit``; 0 where the body is not inside the region.
    """
    if not (math.isfinite(cos_t + sin_t) and limit > 0.0):
        return 0.0
    if not pose_is_inside(boundary, body, x, y, heading):
        return 0.0
    # In the frame of the motion (ahead, aside) every edge is a graph over `aside`. The gap
    # between an edge of the body that faces ahead and one of the boundary that faces it is
    # linear in `aside` and so least at an end of the stretch they share: where a corner of the
    # one meets the other. In counter-clockwise rings such edges have `aside` rising.
    corners = body.shape[0]
    # Turns the body by its heading and looks at it along the motion, in one.
    c = math.cos(heading) * cos_t + math.sin(heading) * sin_t
    s = math.sin(heading) * cos_t - math.cos(heading) * sin_t
    outline = np.empty((corners, 2))
    for i in range(corners):
        outline[i, 0] = body[i, 0] * c - body[i, 1] * s
        outline[i, 1] = body[i, 0] * s + body[i, 1] * c
    travel = limit
    bx, by = boundary[-1, 0] - x, boundary[-1, 1] - y
    wall_end, wall_high = bx * cos_t + by * sin_t, by * cos_t - bx * sin_t
    for j in range(boundary.shape[0]):
        wall_start, wall_low = wall_end, wall_high
        bx, by = boundary[j, 0] - x, boundary[j, 1] - y
        wall_end, wall_high = bx * cos_t + by * sin_t, by * cos_t - bx * sin_t
        if wall_high <= wall_low:
            continue
        wall_slope = (wall_end - wall_start) / (wall_high - wall_low)
        end, high = outline[-1, 0], outline[-1, 1]
        for i in range(corners):
            start, low = end, high
            end, high = outline[i, 0], outline[i, 1]
            first, last = max(low, wall_low), min(high, wall_high)
            # What shares no more than rounding slides past; `high <= low` ends here as well.
            if last - first <= 2.0 * TOLERANCE_M:
                continue
            slope = (end - start) / (high - low)
            gap = wall_start - start - wall_slope * wall_low + slope * low
            relative = wall_slope - slope
            most = max(
                gap + relative * (first + TOLERANCE_M), gap + relative * (last - TOLERANCE_M)
            )
            # An edge of the boundary that lies deeper behind than a touch was never ahead.
            if most >= -TOLERANCE_M * (1.0 + abs(wall_slope) + abs(slope)):
                least = min(gap + relative * first, gap + relative * last)
                travel = min(travel, max(least, 0.0))
    return travel


@kernel
def rotation_is_free(
    boundary: FloatArray,
    body: FloatArray,
    x: float,
    y: float,
    heading_from: float,
    turn: float,
) -> bool:
    """Whether a polygon may turn in place about its reference point.

    Parameters
    ----------
    boundary : (m, 2) array
        The ring.
    body : (k, 2) array
        Corners of the body about its reference point, counter-clockwise.
    x, y, heading_from : float
        Configuration at the start.
    turn : float
        Angle to turn by, counter-clockwise positive, from -2 pi to 2 pi.

    Returns
    -------
    bool
        Whether the body starts inside the region and never cuts its boundary on the way.
    """
    if not pose_is_inside(boundary, body, x, y, heading_from):
        return False
    if not abs(turn) <= TWO_PI + 1e-9:
        return False
    # Two outlines first meet at a corner of one of them: corners of the body run along arcs
    # against the boundary, and seen from the body the corners of the boundary run backwards.
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
def pose_is_inside(
    boundary: FloatArray, body: FloatArray, x: float, y: float, heading: float
) -> bool:
    """Whether a polygon lies inside the region; it may touch the boundary.

    Parameters
    ----------
    boundary : (m, 2) array
        The ring.
    body : (k, 2) array
        Corners of the body about its reference point, counter-clockwise.
    x, y, heading : float
        Configuration of the body.
    """
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(heading)):
        return False
    # The body is made smaller by the tolerance. Touching edges and corners, the rule rather than
    # the exception where walls and bodies follow a grid, are then clearly apart or clearly
    # crossed, and a body whose outline does not cross a ring is inside it or outside as a whole.
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
def keep_off(ways: FloatArray, discs: FloatArray) -> BoolArray:
    """Tell which straight ways, ``(n, 4)``, keep off all discs, ``(m, 3)``: x, y and radius."""
    off = np.ones(ways.shape[0], np.bool_)
    for i in range(ways.shape[0]):
        for k in range(discs.shape[0]):
            x, y, radius = discs[k]
            ax, ay, bx, by = ways[i, 0] - x, ways[i, 1] - y, ways[i, 2] - x, ways[i, 3] - y
            if squared_distance(ax, ay, bx, by) < radius * radius:
                off[i] = False
                break
    return off


@kernel
def _near_arc(
    nearest: float,
    ax: float,
    ay: float,
    bx: float,
    by: float,
    px: float,
    py: float,
    radius: float,
    turn: float,
) -> float:
    """Give the lesser of a distance and that from segment a-b to an arc about the origin.

    The arc begins at p. Its ends are nowhere the nearest points here: they are looked at apart.
    """
    gap = abs(math.hypot(ax, ay) - radius)
    if gap < nearest and _is_on_arc(ax, ay, px, py, turn):
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
        if gap < nearest and 0.0 <= foot <= 1.0 and _is_on_arc(fx, fy, px, py, turn):
            nearest = gap
        return nearest
    half = math.sqrt((radius - offset) * (radius + offset) / squared)
    for along in (foot - half, foot + half):
        if 0.0 <= along <= 1.0 and _is_on_arc(ax + along * ex, ay + along * ey, px, py, turn):
            return 0.0
    return nearest


@kernel
def _is_on_arc(x: float, y: float, px: float, py: float, turn: float) -> bool:
    """Whether an arc about the origin, which begins at p, passes the direction of a point."""
    angle = math.atan2(px * y - py * x, px * x + py * y)
    if turn < 0.0:
        angle = -angle
    if angle < 0.0:
        angle += TWO_PI
    return angle <= abs(turn)


@kernel
def _reach(body: FloatArray) -> float:
    """Give the distance from the reference point within which the body may touch something."""
    squared = 0.0
    for i in range(body.shape[0]):
        squared = max(squared, body[i, 0] * body[i, 0] + body[i, 1] * body[i, 1])
    return math.sqrt(squared) + 2.0 * TOLERANCE_M


@kernel
def _shrunk_outline(body: FloatArray, heading: float) -> FloatArray:
    """Turn a body by its heading and move its edges inwards by the tolerance."""
    corners = body.shape[0]
    c, s = math.cos(heading), math.sin(heading)
    outline = np.empty((corners, 2))
    ux, uy = body[-1, 0], body[-1, 1]
    ex, ey = _direction(ux - body[-2, 0], uy - body[-2, 1])
    for i in range(corners):
        vx, vy = body[i, 0], body[i, 1]
        fx, fy = _direction(vx - ux, vy - uy)
        # Corner u, between edges e and f, goes to where their lines meet when moved inwards.
        shift = TOLERANCE_M / max(1.0 + ex * fx + ey * fy, 1e-6)
        wx, wy = ux - shift * (ey + fy), uy + shift * (ex + fx)
        outline[i - 1, 0] = c * wx - s * wy
        outline[i - 1, 1] = s * wx + c * wy
        ux, uy, ex, ey = vx, vy, fx, fy
    return outline


@kernel
def _direction(x: float, y: float) -> tuple[float, float]:
    """Give the unit vector along a vector; of no length, where that has none."""
    length = math.hypot(x, y)
    if length == 0.0:
        return 0.0, 0.0
    return x / length, y / length


@kernel
def _arc_leaves_left(
    px: float, py: float, turn: float, ax: float, ay: float, bx: float, by: float
) -> bool:
    """Whether point p, turning about the origin, passes from the left of segment a-b to its right.

    The arc is shrunk by the tolerance towards the left side: its radius where the segment lies
    across it, its start where it lies along it.
    """
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
    # On the circle, offset = radius cos(angle from the normal): going counter-clockwise the
    # left is left at plus acos, going clockwise at minus acos.
    cosine = offset / radius
    sine = math.sqrt((1.0 - cosine) * (1.0 + cosine))
    if turn < 0.0:
        sine = -sine
    qx = radius * (-ey * cosine - ex * sine)
    qy = radius * (ex * cosine - ey * sine)
    along = (qx - ax) * ex + (qy - ay) * ey
    if along < -TOLERANCE_M or along > length + TOLERANCE_M:
        return False
    way = math.atan2(px * qy - py * qx, px * qx + py * qy)
    if turn < 0.0:
        way = -way
    if way < -slack:
        way += TWO_PI
    return way <= abs(turn)
