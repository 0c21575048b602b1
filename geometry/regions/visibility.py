"""What can be seen from a point: the exact visibility polygon, cut at a range."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, kernel, unsigned
from multisrt.geometry.regions.boundary import (
    GAP,
    OBSTACLE,
    RANGE,
    TagArray,
    add_open_piece,
    arc_divisions,
    arc_tolerance,
)
from multisrt.geometry.regions.edge_index import EdgeIndex, edges_within
from multisrt.geometry.regions.viewpoint import (
    MAX_RANGE_M,
    MIN_CLEARANCE_M,
    refuse_clearance,
    refuse_range,
    signed_clearance,
)

HAIR: Final = 1e-14
"""Intervals of (pseudo-)angle below this are rounding."""

GRAZING_M: Final = 1e-5
"""A gap that has a wall behind it within this runs along that wall: it is no gap."""


def visibility_polygon(
    index: EdgeIndex,
    x: float,
    y: float,
    range_m: float,
    *,
    arc_tolerance_m: float | None = None,
) -> tuple[FloatArray, TagArray]:
    """Compute the exact visibility polygon of a point, cut at a range.

    Parameters
    ----------
    index : EdgeIndex
        The edges of the world.
    x, y : float
        The viewpoint, strictly inside free space.
    range_m : float
        How far the view reaches; at most `MAX_RANGE_M`.
    arc_tolerance_m : float, optional
        Where the view ends at its range, chords lie inside the arc by at most this; see
        `arc_tolerance`.

    Returns
    -------
    boundary : (n, 2) array
        Corners in metres, counter-clockwise, not closed.
    tags : (n,) array of int8
        `OBSTACLE`, `RANGE` or `GAP` for the piece from corner i to corner i + 1.

    Raises
    ------
    ClearanceError
        If the viewpoint lies on an edge or inside an obstacle.
    InvalidInputError
        If the viewpoint or the range is not finite, or the range not positive or too large.

    Notes
    -----
    An angular sweep over the edges in range that face the viewpoint. Between two neighbouring
    event directions the nearest edge stays the same, for edges do not cross; it is found along
    the interval's middle, so that events in the same direction need no order among themselves.
    Cost: O(m log m) for m edges in range, whatever the size of the world.
    """
    if not (-math.inf < x < math.inf and -math.inf < y < math.inf):
        raise InvalidInputError(f"the viewpoint is finite, not ({x}, {y})")
    if not 0.0 < range_m <= MAX_RANGE_M:
        refuse_range(range_m)
    scratch = index.scratch
    boundary, tags, clearance = _sweep(
        x,
        y,
        range_m,
        index.free_winding,
        index.edges,
        index.grid,
        index.bins,
        scratch.memory,
        scratch.next_query(),
        arc_divisions(range_m, arc_tolerance_m or arc_tolerance(range_m)),
    )
    if clearance < MIN_CLEARANCE_M:
        refuse_clearance(x, y, clearance)
    return boundary, tags


@kernel
def _pseudo_angle(x: float, y: float) -> float:
    # Monotone in the true angle, in [0, 4): cheaper than the arc tangent, and exact on axes.
    t = y / (abs(x) + abs(y))
    if x >= 0.0:
        return t if y >= 0.0 else 4.0 + t
    return 2.0 - t


@kernel
def _direction(pseudo_angle: float) -> tuple[float, float]:
    if pseudo_angle <= 1.0:
        return 1.0 - pseudo_angle, pseudo_angle
    if pseudo_angle <= 2.0:
        return 1.0 - pseudo_angle, 2.0 - pseudo_angle
    if pseudo_angle <= 3.0:
        return pseudo_angle - 3.0, 2.0 - pseudo_angle
    return pseudo_angle - 3.0, pseudo_angle - 4.0


@kernel
def _sweep(
    x: float,
    y: float,
    radius: float,
    free_winding: int,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: NDArray[np.int64],
    scratch: NDArray[np.int64],
    query: int,
    divisions: int,
) -> tuple[FloatArray, TagArray, float]:
    stamps, found = scratch[0], scratch[1]
    count = edges_within(x, y, radius, grid, bins, stamps, query, found)
    clearance = signed_clearance(
        x, y, radius, free_winding, edges, grid, bins, stamps, query, found, count
    )
    if clearance < MIN_CLEARANCE_M:
        return np.empty((0, 2)), np.empty(0, np.int8), clearance

    # 1. Segments that face the viewpoint, relative to it, clipped to the disc. One that crosses
    #    the direction +x becomes two. The inverse of the distance at which a ray meets a segment
    #    is linear in the ray's direction, with the coefficients `inverse`.
    segments = np.empty((2 * count + 1, 4))
    inverse = np.empty((2 * count + 1, 2))
    source = np.empty(2 * count + 1, np.int64)
    angles = np.empty((2 * count + 1, 2))
    n = 0
    # Edges that are seen along their length: where there is a gap, it ends at them.
    grazed = np.empty(count, np.int64)
    grazed_count = 0
    radius2 = radius * radius
    for k in range(count):
        e = unsigned(found[k])
        ax, ay = edges[e, 0] - x, edges[e, 1] - y
        bx, by = edges[e, 2] - x, edges[e, 3] - y
        cross = ax * by - ay * bx
        dx, dy = bx - ax, by - ay
        length2 = dx * dx + dy * dy
        if cross * cross <= GRAZING_M * GRAZING_M * length2:
            grazed[grazed_count] = e
            grazed_count += 1
        if cross <= 0.0 or cross * cross >= radius2 * length2:
            continue
        if ax * ax + ay * ay > radius2 or bx * bx + by * by > radius2:
            middle = -(ax * dx + ay * dy) / length2
            half = np.sqrt(max(0.0, radius2 - cross * cross / length2) / length2)
            t0, t1 = middle - half, middle + half
            if t1 <= 0.0 or t0 >= 1.0:
                continue
            ox, oy = ax, ay
            if t0 > 0.0:
                ax, ay = ox + t0 * dx, oy + t0 * dy
            if t1 < 1.0:
                bx, by = ox + t1 * dx, oy + t1 * dy
        start, end = _pseudo_angle(ax, ay), _pseudo_angle(bx, by)
        if start == end:
            continue
        segments[n, 0], segments[n, 1], segments[n, 2], segments[n, 3] = ax, ay, bx, by
        inverse[n, 0], inverse[n, 1] = dy / cross, -dx / cross
        source[n] = e
        angles[n, 0], angles[n, 1] = start, end
        if end < start:
            angles[n, 1] = 4.0
            if end > 0.0:
                n += 1
                segments[n, 0], segments[n, 1], segments[n, 2], segments[n, 3] = ax, ay, bx, by
                inverse[n, 0], inverse[n, 1] = dy / cross, -dx / cross
                source[n] = e
                angles[n, 0], angles[n, 1] = 0.0, end
        n += 1

    events = np.empty(2 * n)
    for s in range(n):
        events[2 * s], events[2 * s + 1] = angles[s, 0], angles[s, 1]
    order = np.argsort(events)

    # 2. Sweep. `piece` is what the boundary runs along: -1 the range, an edge otherwise; -3
    #    before the first piece.
    active = np.empty(n + 1, np.int64)
    active_count = 0
    boundary = np.empty((4 * n + divisions + 16 + 2 * grazed_count, 2))
    tags = np.empty(4 * n + divisions + 16 + 2 * grazed_count, np.int8)
    corners = 0
    piece, piece_segment = -3, -1
    angle, next_event = 0.0, 0
    step = 2.0 * np.pi / divisions
    while angle < 4.0:
        while next_event < 2 * n and events[order[next_event]] <= angle:
            event = order[next_event]
            segment = event >> 1
            if event & 1:
                for k in range(active_count):
                    if active[k] == segment:
                        active_count -= 1
                        active[k] = active[active_count]
                        break
            else:
                active[active_count] = segment
                active_count += 1
            next_event += 1
        # An interval ends at the next event, or at an axis, where pseudo-angles have a corner.
        until = min(4.0, np.floor(angle) + 1.0)
        if next_event < 2 * n:
            until = min(until, events[order[next_event]])
        # Between the ends of an edge that is seen along its length there may be a hair of angle
        # by rounding, in which no edge would stop the ray.
        if until - angle <= HAIR:
            angle = until
            continue
        ux, uy = _direction(angle)
        vx, vy = _direction(until)
        mx, my = 0.5 * (ux + vx), 0.5 * (uy + vy)
        nearest, largest = -1, 0.0
        for k in range(active_count):
            s = active[k]
            value = mx * inverse[s, 0] + my * inverse[s, 1]
            if value > largest:
                largest, nearest = value, s
        now = -1 if nearest < 0 else source[nearest]
        starts_here = piece == -3 or now != piece
        if starts_here:
            px, py = _end_point(segments, angles, nearest, angle, ux, uy, radius)
            if piece != -3:
                lx, ly = _end_point(segments, angles, piece_segment, angle, ux, uy, radius)
                corners = add_open_piece(
                    boundary,
                    tags,
                    corners,
                    (x + lx, y + ly),
                    (x + px, y + py),
                    edges[grazed[:grazed_count]],
                    GRAZING_M,
                    GRAZING_M,
                    GAP,
                )
            boundary[corners, 0], boundary[corners, 1] = x + px, y + py
            tags[corners] = RANGE if now < 0 else OBSTACLE
            corners += 1
            piece = now
        piece_segment = nearest
        if nearest < 0:
            # Corners of the arc lie on one lattice of directions, whatever the interval; one
            # on the border of two intervals belongs to the second.
            first, last = np.arctan2(uy, ux), np.arctan2(vy, vx)
            if first < 0.0:
                first += 2.0 * np.pi
            if last <= 0.0:
                last += 2.0 * np.pi
            end = int(np.ceil(last / step - 1e-9))
            for i in range(int(np.ceil(first / step - 1e-9)), end):
                theta = i * step
                if starts_here and theta - first <= 1e-9 * step:
                    continue
                boundary[corners, 0] = x + radius * np.cos(theta)
                boundary[corners, 1] = y + radius * np.sin(theta)
                tags[corners] = RANGE
                corners += 1
        angle = until

    lx, ly = _end_point(segments, angles, piece_segment, 4.0, 1.0, 0.0, radius)
    corners = add_open_piece(
        boundary,
        tags,
        corners,
        (x + lx, y + ly),
        (boundary[0, 0], boundary[0, 1]),
        edges[grazed[:grazed_count]],
        GRAZING_M,
        GRAZING_M,
        GAP,
    )
    return boundary[:corners].copy(), tags[:corners].copy(), clearance


@kernel
def _end_point(
    segments: FloatArray,
    angles: FloatArray,
    s: int,
    angle: float,
    ux: float,
    uy: float,
    radius: float,
) -> tuple[float, float]:
    # Where the ray (ux, uy) at pseudo-angle `angle` meets segment s, or the range for s < 0.
    # At a segment's own ends these are given as they are, without rounding.
    if s < 0:
        length = np.hypot(ux, uy)
        return radius * ux / length, radius * uy / length
    if angles[s, 0] == angle and angle != 0.0:
        return segments[s, 0], segments[s, 1]
    if angles[s, 1] == angle and angle != 4.0:
        return segments[s, 2], segments[s, 3]
    ex, ey = segments[s, 2] - segments[s, 0], segments[s, 3] - segments[s, 1]
    denominator = ux * ey - uy * ex
    if denominator == 0.0:
        # So short that rounding has turned it along the ray.
        return segments[s, 0], segments[s, 1]
    t = (segments[s, 0] * ey - segments[s, 1] * ex) / denominator
    return ux * t, uy * t
