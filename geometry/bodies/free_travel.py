"""How far a body can move on a straight line inside a region that is known to be free.

All lengths are in metres, headings in radians. A region is a closed ring ``(m, 2)`` of corners,
counter-clockwise, the first repeated at the end or not. A region with holes is its rings one
after another, each closed by its first corner and followed by a row of NaN, the holes clockwise
(see `clearance.rings_of`): no comparison holds for the pieces to and from NaN, so they have no
effect.

Touching is allowed, and so is sliding along the boundary: body and boundary may overlap by
`TOLERANCE_M`, which covers the rounding of a touch. A body that overlaps deeper, or whose numbers
are not finite, cannot move at all.
"""

import math
from typing import Final

import numpy as np

from multisrt.geometry.bodies.fitting import TOLERANCE_M, pose_is_inside
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.numerics.rings import RingArrays, corners_of
from multisrt.geometry.numerics.segments import squared_distance

CLEARLY_M: Final = 1e-6
"""Beyond a touch by this distance an edge is out of reach in spite of all rounding, in metres."""


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
    """Return how far a disc can move in a direction until it touches the boundary.

    Parameters
    ----------
    boundary : (m, 2) array
        Ring of the region in metres, without holes.
    x, y : float
        Centre of the disc in metres, inside the region.
    cos_t, sin_t : float
        Unit vector of the motion.
    radius : float
        Radius of the disc in metres.
    limit : float
        Maximum travel of interest in metres, which may be infinite.

    Returns
    -------
    float
        Travel in metres, from 0 to ``limit``; 0 where the disc already overlaps the boundary.

    Examples
    --------
    >>> room = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
    >>> free_travel_disc(room, 1.0, 1.0, 1.0, 0.0, 0.5, 10.0)
    2.5
    """
    # Seen from the centre, every edge is a stadium: two circles and two long sides. The ray is
    # blocked by an edge if it enters its stadium of radius r - tolerance; it then stops where it
    # enters the one of radius r.
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
        # Most edges lie wholly behind the disc, beyond its travel, or on one side of it.
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
            # Distance of the centre from the edge's line, and the rate at which it shrinks.
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
                    # A ray that enters around an end is above the edge only from there on.
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
    """Return how far a disc can move in each of many directions.

    Parameters
    ----------
    boundary : (m, 2) array
        Ring of the region in metres, without holes.
    x, y : float
        Centre of the disc in metres, inside the region.
    directions : (k,) array
        Directions in radians.
    radius : float
        Radius of the disc in metres.
    limit : float
        Maximum travel of interest in metres.

    Returns
    -------
    (k,) array
        Travel in metres, as of `free_travel_disc`.

    Examples
    --------
    >>> room = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
    >>> free_travel_disc_fan(room, 1.0, 1.0, np.array([0.0, np.pi / 2]), 0.5, 10.0).tolist()
    [2.5, 1.5]
    """
    travels = np.empty(directions.shape[0])
    for k in range(directions.shape[0]):
        travels[k] = free_travel_disc(
            boundary, x, y, math.cos(directions[k]), math.sin(directions[k]), radius, limit
        )
    return travels


@kernel
def disc_bridges(
    places: FloatArray,
    rings: RingArrays,
    pairs: IntArray,
    radius: float,
) -> BoolArray:
    """Whether a disc can move straight between places through the regions around both.

    From each end it can move as far as `free_travel_disc` says in the region of that end; the
    two travels together have to cover the line.

    Parameters
    ----------
    places : (n, 2) array
        Centres of the disc in metres.
    rings : RingArrays
        The regions around the places, with the corners of those in the pairs.
    pairs : (m, 2) array of int
        Start and end of each motion, as indices of places.
    radius : float
        Radius of the disc in metres.

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
            reached = free_travel_disc(corners_of(rings, a), x, y, ux, uy, radius, length)
            if reached < length:
                ring = corners_of(rings, b)
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
    """Return how far a polygon can move with constant heading until it touches the boundary.

    Parameters
    ----------
    boundary : (m, 2) array
        Ring, or rings, of the region in metres.
    body : (k, 2) array
        Corners of the body about its reference point, counter-clockwise, in metres.
    x, y, heading : float
        Configuration of the body in metres and radians.
    cos_t, sin_t : float
        Unit vector of the motion.
    limit : float
        Maximum travel of interest in metres, which may be infinite.

    Returns
    -------
    float
        Travel in metres, from 0 to ``limit``; 0 where the body is not inside the region.

    Examples
    --------
    >>> room = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
    >>> box = np.array([(-0.5, -0.25), (0.5, -0.25), (0.5, 0.25), (-0.5, 0.25)])
    >>> free_travel_polygon(room, box, 1.0, 1.0, 0.0, 1.0, 0.0, 10.0)
    2.5
    """
    if not (math.isfinite(cos_t + sin_t) and limit > 0.0):
        return 0.0
    if not pose_is_inside(boundary, body, x, y, heading):
        return 0.0
    # In the frame of the motion (ahead, aside) every edge is a graph over `aside`. The gap
    # between an edge of the body that faces ahead and one of the boundary that faces it is
    # linear in `aside` and so smallest at an end of the interval they share: where a corner of
    # one meets the other. In counter-clockwise rings such edges have `aside` rising.
    corners = body.shape[0]
    # One rotation turns the body by its heading and into the frame of the motion.
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
            # Edges that share no more than rounding slide past. This covers `high <= low` too.
            if last - first <= 2.0 * TOLERANCE_M:
                continue
            slope = (end - start) / (high - low)
            gap = wall_start - start - wall_slope * wall_low + slope * low
            relative = wall_slope - slope
            widest = max(
                gap + relative * (first + TOLERANCE_M), gap + relative * (last - TOLERANCE_M)
            )
            # An edge of the boundary that lies behind by more than a touch was never ahead.
            if widest >= -TOLERANCE_M * (1.0 + abs(wall_slope) + abs(slope)):
                narrowest = min(gap + relative * first, gap + relative * last)
                travel = min(travel, max(narrowest, 0.0))
    return travel
