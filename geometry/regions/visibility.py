"""Visibility from a point: the exact visibility polygon, cut at a range."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel, unsigned
from multisrt.geometry.regions.boundary import (
    GAP,
    OBSTACLE,
    RANGE,
    Chain,
    TagArray,
    add_open_piece,
    arc_divisions,
    arc_tolerance,
)
from multisrt.geometry.regions.edge_index import EdgeGrid, EdgeIndex, edges_within
from multisrt.geometry.regions.viewpoint import (
    MIN_CLEARANCE_M,
    check_clearance,
    check_view,
    signed_clearance,
)

MIN_INTERVAL: Final = 1e-14
"""Intervals of pseudo-angle of at most this size are rounding."""

GRAZING_M: Final = 1e-5
"""A gap that has a wall within this distance in metres runs along that wall: it is not a gap."""

NOTHING_YET: Final = -2
"""Stands for an edge before the boundary's first piece; -1 stands for the range."""


class _View(NamedTuple):
    # A viewpoint with its range, and the angle in radians between corners of the range's arc.
    x: float
    y: float
    radius: float
    step: float


class _Facing(NamedTuple):
    # Segments that face the viewpoint, relative to it: ends (n, 4); the edge of each (n,); the
    # pseudo-angles that it spans (n, 2); and the coefficients (n, 2) of the inverse of the
    # distance at which a ray meets it, which is linear in the ray's direction.
    ends: FloatArray
    edge: IntArray
    angles: FloatArray
    inverse: FloatArray


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
        The viewpoint in metres, strictly inside free space.
    range_m : float
        Range of the view in metres, at most `MAX_RANGE_M`.
    arc_tolerance_m : float, optional
        Maximum distance in metres between the arc at which the view ends at its range and its
        chords, which lie inside it. Default: `arc_tolerance` of the range.

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

    Examples
    --------
    In a room of 4 x 3 m all four walls are seen:

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    >>> room = EdgeIndex(np.hstack([corners, np.roll(corners, -1, axis=0)]), 1.0)
    >>> boundary, tags = visibility_polygon(room, 1.0, 1.0, 10.0)
    >>> boundary[tags == OBSTACLE][:3].tolist()
    [[4.0, 1.0], [4.0, 3.0], [0.0, 3.0]]

    A viewpoint in a wall has no view:

    >>> visibility_polygon(room, 4.0, 1.0, 10.0)
    Traceback (most recent call last):
        ...
    multisrt.geometry.errors.ClearanceError: (4, 1) is on or inside an obstacle ...
    """
    check_view(x, y, range_m)
    divisions = arc_divisions(range_m, arc_tolerance_m or arc_tolerance(range_m))
    boundary, tags, clearance = _visible(x, y, range_m, divisions, index.grid)
    check_clearance(x, y, clearance)
    return boundary, tags


def visibility_polygons(
    index: EdgeIndex,
    viewpoints: FloatArray,
    range_m: float,
    *,
    arc_tolerance_m: float | None = None,
) -> list[FloatArray]:
    """Compute the exact visibility polygons of many points, cut at a range.

    Parameters
    ----------
    index : EdgeIndex
        The edges of the world.
    viewpoints : (n, 2) array
        The viewpoints in metres, strictly inside free space.
    range_m, arc_tolerance_m
        As for `visibility_polygon`.

    Returns
    -------
    list of (k, 2) array
        For each viewpoint the corners in metres, counter-clockwise, not closed.

    Raises
    ------
    ClearanceError, InvalidInputError
        As `visibility_polygon`.

    Examples
    --------
    >>> import numpy as np
    >>> corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    >>> room = EdgeIndex(np.hstack([corners, np.roll(corners, -1, axis=0)]), 1.0)
    >>> views = visibility_polygons(room, np.array([[1.0, 1.0], [3.0, 2.0]]), 10.0)
    >>> [view.max(axis=0).tolist() for view in views]
    [[4.0, 3.0], [4.0, 3.0]]
    """
    viewpoints = np.ascontiguousarray(viewpoints, np.float64).reshape(-1, 2)
    for x, y in viewpoints.tolist():
        check_view(x, y, range_m)
    divisions = arc_divisions(range_m, arc_tolerance_m or arc_tolerance(range_m))
    corners, ends, clearances = _visible_from_each(
        viewpoints, float(range_m), divisions, index.grid
    )
    for k in np.flatnonzero(clearances < MIN_CLEARANCE_M).tolist():
        check_clearance(float(viewpoints[k, 0]), float(viewpoints[k, 1]), float(clearances[k]))
    cuts = ends.tolist()
    return [corners[a:b] for a, b in zip([0, *cuts], cuts, strict=False)]


@kernel
def _visible_from_each(
    viewpoints: FloatArray, radius: float, divisions: int, grid: EdgeGrid
) -> tuple[FloatArray, IntArray, FloatArray]:
    # The corners of all polygons, where each of them ends, and the viewpoints' clearances.
    count = viewpoints.shape[0]
    ends, clearances = np.empty(count, np.int64), np.empty(count)
    corners = np.empty((64 * count, 2))
    filled = 0
    for k in range(count):
        seen, _, clearances[k] = _visible(
            viewpoints[k, 0], viewpoints[k, 1], radius, divisions, grid
        )
        end = filled + seen.shape[0]
        if end > corners.shape[0]:
            longer = np.empty((2 * end, 2))
            longer[:filled] = corners[:filled]
            corners = longer
        corners[filled:end] = seen
        ends[k] = filled = end
    return corners[:filled], ends, clearances


@kernel
def _visible(
    x: float, y: float, radius: float, divisions: int, grid: EdgeGrid
) -> tuple[FloatArray, TagArray, float]:
    # Corners and tags of the visibility polygon, and the viewpoint's clearance.
    found = edges_within(x, y, radius, grid)
    clearance = signed_clearance(x, y, radius, grid, found)
    if clearance < MIN_CLEARANCE_M:
        return np.empty((0, 2)), np.empty(0, np.int8), clearance
    view = _View(x, y, radius, 2.0 * np.pi / divisions)
    facing, grazed = _facing_edges(view, grid.edges, found)
    most = 4 * facing.edge.shape[0] + divisions + 16 + 2 * grazed.shape[0]
    chain = Chain(np.empty((most, 2)), np.empty(most, np.int8))
    count = _sweep(view, facing, grid.edges[grazed], chain)
    return chain.corners[:count].copy(), chain.tags[:count].copy(), clearance


@kernel
def _facing_edges(view: _View, edges: FloatArray, found: IntArray) -> tuple[_Facing, IntArray]:
    # The edges that face the viewpoint, clipped to the disc of the range; one that crosses the
    # direction +x becomes two. And those that are seen along their length: gaps end at them.
    most = 2 * found.shape[0] + 1
    facing = _Facing(
        np.empty((most, 4)), np.empty(most, np.int64), np.empty((most, 2)), np.empty((most, 2))
    )
    grazed = np.empty(found.shape[0], np.int64)
    n, grazed_count = 0, 0
    radius2 = view.radius * view.radius
    for k in range(found.shape[0]):
        e = unsigned(found[k])
        ax, ay = edges[e, 0] - view.x, edges[e, 1] - view.y
        bx, by = edges[e, 2] - view.x, edges[e, 3] - view.y
        cross = ax * by - ay * bx
        dx, dy = bx - ax, by - ay
        length2 = dx * dx + dy * dy
        if cross * cross <= GRAZING_M * GRAZING_M * length2:
            grazed[grazed_count] = found[k]
            grazed_count += 1
        if cross <= 0.0 or cross * cross >= radius2 * length2:
            continue
        if ax * ax + ay * ay > radius2 or bx * bx + by * by > radius2:
            t0, t1 = _inside_disc(ax, ay, dx, dy, length2, cross, radius2)
            if t1 <= 0.0 or t0 >= 1.0:
                continue
            ox, oy = ax, ay
            if t0 > 0.0:
                ax, ay = ox + t0 * dx, oy + t0 * dy
            if t1 < 1.0:
                bx, by = ox + t1 * dx, oy + t1 * dy
        start, end = _pseudo_angle(ax, ay), _pseudo_angle(bx, by)
        # An edge spans less than half a circle, so one that ends before it begins and does not
        # cross the direction +x is seen along its length, up to rounding.
        if start == end or 0.0 < start - end < 2.0:
            continue
        last = n
        if end < start:
            if end > 0.0:
                last = n + 1
                facing.angles[last, 0], facing.angles[last, 1] = 0.0, end
            end = 4.0
        facing.angles[n, 0], facing.angles[n, 1] = start, end
        for s in range(n, last + 1):
            facing.ends[s, 0], facing.ends[s, 1] = ax, ay
            facing.ends[s, 2], facing.ends[s, 3] = bx, by
            facing.inverse[s, 0], facing.inverse[s, 1] = dy / cross, -dx / cross
            facing.edge[s] = found[k]
        n = last + 1
    kept = _Facing(facing.ends[:n], facing.edge[:n], facing.angles[:n], facing.inverse[:n])
    return kept, grazed[:grazed_count]


@kernel
def _inside_disc(
    ax: float, ay: float, dx: float, dy: float, length2: float, cross: float, radius2: float
) -> tuple[float, float]:
    # Where the line from a along d enters a disc around the origin and leaves it, as shares of
    # the length of d.
    middle = -(ax * dx + ay * dy) / length2
    half = np.sqrt(max(0.0, radius2 - cross * cross / length2) / length2)
    return middle - half, middle + half


@kernel
def _sweep(view: _View, facing: _Facing, walls: FloatArray, chain: Chain) -> int:
    # Write the boundary of what is seen, and return its number of corners. Between corners it
    # runs along an edge, or along the range.
    n = facing.edge.shape[0]
    # Event 2 s is the begin of segment s, event 2 s + 1 its end.
    events = facing.angles.copy().ravel()
    order = np.argsort(events)
    active = np.empty(n + 1, np.int64)
    active_count, next_event, count = 0, 0, 0
    edge, segment = NOTHING_YET, -1
    angle = 0.0
    while angle < 4.0:
        while next_event < 2 * n and events[order[next_event]] <= angle:
            active_count = _pass_event(order[next_event], active, active_count)
            next_event += 1
        # An interval ends at the next event, or at an axis, where pseudo-angles have a corner.
        until = min(4.0, np.floor(angle) + 1.0)
        if next_event < 2 * n:
            until = min(until, events[order[next_event]])
        # Between the ends of an edge that is seen along its length there may be a hair of angle
        # by rounding, in which no edge would stop the ray.
        if until - angle <= MIN_INTERVAL:
            angle = until
            continue
        u, v = _direction(angle), _direction(until)
        nearest = _nearest(facing, active, active_count, 0.5 * (u[0] + v[0]), 0.5 * (u[1] + v[1]))
        here = -1 if nearest < 0 else facing.edge[nearest]
        is_new = here != edge
        if is_new:
            start = _end_point(view, facing, nearest, angle, u)
            if edge != NOTHING_YET:
                last = _end_point(view, facing, segment, angle, u)
                count = add_open_piece(
                    chain, count, last, start, walls, (GRAZING_M, GRAZING_M), GAP
                )
            chain.corners[count, 0], chain.corners[count, 1] = start
            chain.tags[count] = RANGE if here < 0 else OBSTACLE
            count += 1
            edge = here
        segment = nearest
        if nearest < 0:
            count = _add_arc(view, u, v, is_new, chain, count)
        angle = until
    last = _end_point(view, facing, segment, 4.0, (1.0, 0.0))
    start = chain.corners[0, 0], chain.corners[0, 1]
    return add_open_piece(chain, count, last, start, walls, (GRAZING_M, GRAZING_M), GAP)


@kernel
def _pass_event(event: int, active: IntArray, count: int) -> int:
    # Add the segment of an event to the active ones or remove it; return their number.
    segment = event >> 1
    if not event & 1:
        active[count] = segment
        return count + 1
    for k in range(count):
        if active[k] == segment:
            active[k] = active[count - 1]
            return count - 1
    return count


@kernel
def _nearest(facing: _Facing, active: IntArray, count: int, mx: float, my: float) -> int:
    # The active segment that a ray meets first, or -1.
    nearest, largest = -1, 0.0
    for k in range(count):
        s = active[k]
        value = mx * facing.inverse[s, 0] + my * facing.inverse[s, 1]
        if value > largest:
            largest, nearest = value, s
    return nearest


@kernel
def _add_arc(
    view: _View,
    u: tuple[float, float],
    v: tuple[float, float],
    is_new: bool,
    chain: Chain,
    count: int,
) -> int:
    # Write the corners of the range's arc from direction u to v; return the new number. Corners
    # lie on one lattice of directions, whatever the interval; one on the border of two intervals
    # belongs to the second. Where the arc is new its first corner is written already.
    first, last = np.arctan2(u[1], u[0]), np.arctan2(v[1], v[0])
    if first < 0.0:
        first += 2.0 * np.pi
    if last <= 0.0:
        last += 2.0 * np.pi
    for i in range(int(np.ceil(first / view.step - 1e-9)), int(np.ceil(last / view.step - 1e-9))):
        theta = i * view.step
        if is_new and theta - first <= 1e-9 * view.step:
            continue
        chain.corners[count, 0] = view.x + view.radius * np.cos(theta)
        chain.corners[count, 1] = view.y + view.radius * np.sin(theta)
        chain.tags[count] = RANGE
        count += 1
    return count


@kernel
def _end_point(
    view: _View, facing: _Facing, s: int, angle: float, u: tuple[float, float]
) -> tuple[float, float]:
    # Where the ray along u, at a pseudo-angle, meets segment s, or the range for s < 0. The ends
    # of a segment are returned as they are, without rounding.
    ends = facing.ends
    ux, uy = u
    if s < 0:
        length = np.hypot(ux, uy)
        return view.x + view.radius * ux / length, view.y + view.radius * uy / length
    if facing.angles[s, 0] == angle and angle != 0.0:
        return view.x + ends[s, 0], view.y + ends[s, 1]
    if facing.angles[s, 1] == angle and angle != 4.0:
        return view.x + ends[s, 2], view.y + ends[s, 3]
    ex, ey = ends[s, 2] - ends[s, 0], ends[s, 3] - ends[s, 1]
    denominator = ux * ey - uy * ex
    if denominator == 0.0:
        # So short that rounding has turned it along the ray.
        return view.x + ends[s, 0], view.y + ends[s, 1]
    t = (ends[s, 0] * ey - ends[s, 1] * ex) / denominator
    return view.x + ux * t, view.y + uy * t


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
