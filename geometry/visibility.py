"""What can be seen from a point: the exact visibility polygon, laser beams, lines of sight."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.edge_index import EdgeIndex, edges_within, winding_number
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.kernel import FloatArray, kernel

OBSTACLE: Final = 0
"""Tag of a boundary piece where a surface was hit."""
RANGE: Final = 1
"""Tag of a boundary piece where nothing was hit within the range."""
GAP: Final = 2
"""Tag of a radial piece: the space behind a corner was not seen."""
CUT: Final = 3
"""Tag of a boundary piece inside space that the readings show to be free."""

TagArray = NDArray[np.int8]

MIN_CLEARANCE_M: Final = 1e-9
"""A viewpoint nearer to an edge than this would leak through it."""

MAX_RANGE_M: Final = 1e7
"""As far as coordinates may lie from the origin: a range beyond it reaches no further."""

GRAZING_M: Final = 1e-5
"""A gap that has a wall behind it within this runs along that wall: it is no gap."""

ARC_TOLERANCE_M: Final = 0.01
"""Largest distance between an arc and the chords that stand for it, which lie inside it."""

ARC_TOLERANCE: Final = 0.0025
"""The same as a share of the arc's radius, for short ranges."""


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
        _refuse_range(range_m)
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
        _refuse_clearance(x, y, clearance)
    return boundary, tags


def laser_ranges(
    index: EdgeIndex, x: float, y: float, range_m: float, beams: int, *, first_rad: float = 0.0
) -> FloatArray:
    """Measure the distance to the nearest obstacle along equally spaced beams.

    Parameters
    ----------
    index, x, y, range_m
        As for `visibility_polygon`.
    beams : int
        How many beams share the full circle.
    first_rad : float
        Direction of the first beam; the others follow counter-clockwise.

    Returns
    -------
    (beams,) array
        Distances in metres; ``inf`` where nothing is hit within the range.

    Raises
    ------
    ClearanceError, InvalidInputError
        As for `visibility_polygon`; also for fewer than 3 beams.
    """
    if not (-math.inf < x < math.inf and -math.inf < y < math.inf):
        raise InvalidInputError(f"the viewpoint is finite, not ({x}, {y})")
    if not 0.0 < range_m <= MAX_RANGE_M:
        _refuse_range(range_m)
    if beams < 3:
        raise InvalidInputError(f"a laser has at least 3 beams, not {beams}")
    scratch = index.scratch
    ranges, clearance = _z_buffer(
        x,
        y,
        range_m,
        _beam_directions(beams, first_rad),
        first_rad,
        index.free_winding,
        index.edges,
        index.grid,
        index.bins,
        scratch.memory,
        scratch.next_query(),
    )
    if clearance < MIN_CLEARANCE_M:
        _refuse_clearance(x, y, clearance)
    return ranges


def line_of_sight(index: EdgeIndex, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether two points of free space see each other: no obstacle lies between them.

    Touching a corner or running along a wall does not block the view.
    """
    if not (math.isfinite(ax + ay) and math.isfinite(bx + by)):
        raise InvalidInputError(f"points are finite, not ({ax}, {ay}) and ({bx}, {by})")
    return bool(
        _line_of_sight(
            ax,
            ay,
            bx,
            by,
            index.edges,
            index.grid,
            index.bins,
            index.scratch.memory,
            index.scratch.next_query(),
        )
    )


def arc_tolerance(radius_m: float) -> float:
    """How far chords may lie inside an arc, where nothing else is asked for."""
    return min(ARC_TOLERANCE_M, ARC_TOLERANCE * radius_m)


def arc_divisions(radius_m: float, arc_tolerance_m: float) -> int:
    """How many equal chords a full circle needs to lie within a tolerance of it."""
    if arc_tolerance_m >= radius_m:
        return 8
    return max(8, math.ceil(math.pi / math.acos(1.0 - arc_tolerance_m / radius_m)))


@lru_cache(maxsize=32)
def _beam_directions(beams: int, first_rad: float) -> FloatArray:
    angles = first_rad + np.arange(beams) * (2.0 * np.pi / beams)
    directions = np.array([np.cos(angles), np.sin(angles)])
    directions.setflags(write=False)
    return directions


def _refuse_range(range_m: float) -> NoReturn:
    raise InvalidInputError(
        f"a range is a positive number of metres, at most {MAX_RANGE_M:g}, not {range_m:g}"
    )


def _refuse_clearance(x: float, y: float, clearance: float) -> NoReturn:
    raise ClearanceError(
        f"({x:g}, {y:g}) is on or inside an obstacle (clearance {clearance:.3g} m): "
        f"a viewpoint needs more than {MIN_CLEARANCE_M:g} m",
        clearance,
    )


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
def _signed_clearance(
    x: float,
    y: float,
    radius: float,
    free_winding: int,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: NDArray[np.int64],
    stamps: NDArray[np.int64],
    query: int,
    found: NDArray[np.int64],
    count: int,
) -> float:
    # Distance to the nearest of the edges found, negative inside an obstacle. The side is that
    # of the nearest edge; of edges that meet in the nearest corner, that of the one which faces
    # the point most, for another may be seen edge-on or from the wrong side.
    nearest, facing = np.inf, 0.0
    free = True
    for k in range(count):
        e = found[k]
        ax, ay = edges[e, 0] - x, edges[e, 1] - y
        dx, dy = edges[e, 2] - edges[e, 0], edges[e, 3] - edges[e, 1]
        length2 = dx * dx + dy * dy
        cross = ax * dy - ay * dx
        if length2 == 0.0 or cross * cross > nearest * (1.0 + 1e-9) * length2:
            continue
        t = min(1.0, max(0.0, -(ax * dx + ay * dy) / length2))
        px, py = ax + t * dx, ay + t * dy
        distance = px * px + py * py
        if distance > nearest * (1.0 + 1e-9):
            continue
        face = cross * cross / length2
        if distance < nearest * (1.0 - 1e-9) or face > facing:
            nearest, facing = min(nearest, distance), face
            free = cross > 0.0
    clearance = math.sqrt(nearest)
    if clearance > radius:
        # There may be nearer edges that were not looked up.
        winding = winding_number(x, y, edges, grid, bins, stamps, query + 1)
        clearance = radius
        free = winding >= free_winding
    return clearance if free else -clearance


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
    clearance = _signed_clearance(
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
        e = found[k]
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
        if until <= angle:
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
def add_open_piece(
    boundary: FloatArray,
    tags: TagArray,
    corners: int,
    start: tuple[float, float],
    end: tuple[float, float],
    walls: FloatArray,
    right: float,
    left: float,
    open_tag: int,
) -> int:
    """Write a straight piece of a boundary, open but for the stretches that run along walls.

    Parameters
    ----------
    boundary, tags : arrays
        What is written to, from index `corners` on: up to two entries a wall, and one.
    corners : int
        How many corners there are already.
    start, end : (x, y)
        The piece; the corner at its end is not written.
    walls : (k, 4) array
        Segments x0, y0, x1, y1.
    right, left : float
        A wall counts where it lies no further from the piece than this to either side.
    open_tag : int
        Tag of the stretches without a wall; those with one are `OBSTACLE`.

    Returns
    -------
    int
        How many corners there are now.
    """
    x, y = start
    length = np.hypot(end[0] - x, end[1] - y)
    if length <= 1e-9:
        return corners
    ux, uy = (end[0] - x) / length, (end[1] - y) / length
    count = walls.shape[0]
    lows, highs = np.empty(count), np.empty(count)
    for k in range(count):
        ax, ay, bx, by = walls[k, 0] - x, walls[k, 1] - y, walls[k, 2] - x, walls[k, 3] - y
        along_a, along_b = ax * ux + ay * uy, bx * ux + by * uy
        off_a, off_b = ux * ay - uy * ax, ux * by - uy * bx
        # The wall's part between the two parallels of the piece.
        t0, t1 = 0.0, 1.0
        if off_a != off_b:
            first, second = (-right - off_a) / (off_b - off_a), (left - off_a) / (off_b - off_a)
            t0, t1 = max(0.0, min(first, second)), min(1.0, max(first, second))
        elif off_a < -right or off_a > left:
            t1 = -1.0
        if t1 >= t0:
            p, q = along_a + t0 * (along_b - along_a), along_a + t1 * (along_b - along_a)
            lows[k], highs[k] = max(0.0, min(p, q)), min(length, max(p, q))
        else:
            lows[k], highs[k] = length, 0.0
    begin = 0.0
    while length - begin > 1e-9:
        low, high = length, length
        for k in range(count):
            if highs[k] - max(lows[k], begin) > 1e-9 and max(lows[k], begin) < low:
                low, high = max(lows[k], begin), highs[k]
        if low - begin > 1e-9:
            boundary[corners, 0], boundary[corners, 1] = x + ux * begin, y + uy * begin
            tags[corners] = open_tag
            corners += 1
        else:
            low = begin
        if high > low:
            boundary[corners, 0], boundary[corners, 1] = x + ux * low, y + uy * low
            tags[corners] = OBSTACLE
            corners += 1
        begin = high
    return corners


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


@kernel
def _z_buffer(
    x: float,
    y: float,
    radius: float,
    directions: FloatArray,
    first_rad: float,
    free_winding: int,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: NDArray[np.int64],
    scratch: NDArray[np.int64],
    query: int,
) -> tuple[FloatArray, float]:
    stamps, found = scratch[0], scratch[1]
    # Every edge that faces the viewpoint visits only the beams that it spans. They keep the
    # largest inverse distance: it is linear in the direction, so that this takes no division.
    # `ranges` holds it until the end.
    beams = directions.shape[1]
    count = edges_within(x, y, radius, grid, bins, stamps, query, found)
    ranges = np.zeros(beams)
    clearance = _signed_clearance(
        x, y, radius, free_winding, edges, grid, bins, stamps, query, found, count
    )
    if clearance < MIN_CLEARANCE_M:
        return ranges, clearance
    radius2 = radius * radius
    per_rad = beams / (2.0 * np.pi)
    last_x, last_y, last_angle = 0.0, 0.0, 0.0
    for k in range(count):
        e = found[k]
        ax, ay = edges[e, 0] - x, edges[e, 1] - y
        bx, by = edges[e, 2] - x, edges[e, 3] - y
        cross = ax * by - ay * bx
        if cross <= 0.0:
            continue
        dx, dy = bx - ax, by - ay
        if cross * cross >= radius2 * (dx * dx + dy * dy):
            continue
        leaves_range = ax * dx + ay * dy >= 0.0 and ax * ax + ay * ay > radius2
        never_enters = bx * dx + by * dy <= 0.0 and bx * bx + by * by > radius2
        if leaves_range or never_enters:
            continue
        # Edges of one wall follow each other: an end's direction is computed once.
        angle_a = last_angle if ax == last_x and ay == last_y else np.arctan2(ay, ax)
        angle_b = np.arctan2(by, bx)
        last_x, last_y, last_angle = bx, by, angle_b
        start = (angle_a - first_rad) * per_rad
        end = (angle_b - first_rad) * per_rad
        if end < start:
            end += beams
        begin, until = int(np.ceil(start - 1e-9)), int(np.floor(end + 1e-9)) + 1
        along_x, along_y = dy / cross, -dx / cross
        turn = begin // beams * beams
        for low, high in (
            (begin - turn, min(until - turn, beams)),
            (0, until - turn - beams),
        ):
            for i in range(low, high):
                value = directions[0, i] * along_x + directions[1, i] * along_y
                ranges[i] = value if value > ranges[i] else ranges[i]
    for i in range(beams):
        ranges[i] = 1.0 / ranges[i] if ranges[i] * radius >= 1.0 else np.inf
    return ranges, clearance


@kernel
def _line_of_sight(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: NDArray[np.int64],
    scratch: NDArray[np.int64],
    query: int,
) -> bool:
    stamps, found = scratch[0], scratch[1]
    # Walk the cells along the segment and add up how much of it lies inside obstacles: minus
    # the distance of every crossing into one, plus that of every crossing out of one. An end
    # exactly on the line counts as right of it in one sum and as left of it in the other; what
    # is only touched, or run along on one side, leaves one of the two at zero.
    x0, y0, cell, columns, rows = grid
    length = np.hypot(bx - ax, by - ay)
    if length == 0.0:
        return True
    ux, uy = (bx - ax) / length, (by - ay) / length
    i, j = int(np.floor((ax - x0) / cell)), int(np.floor((ay - y0) / cell))
    step_i, step_j = (1 if ux > 0.0 else -1), (1 if uy > 0.0 else -1)
    next_x = np.inf if ux == 0.0 else (x0 + (i + (step_i > 0)) * cell - ax) / ux
    next_y = np.inf if uy == 0.0 else (y0 + (j + (step_j > 0)) * cell - ay) / uy
    width_x = np.inf if ux == 0.0 else cell / abs(ux)
    width_y = np.inf if uy == 0.0 else cell / abs(uy)
    inside_right = inside_left = 0.0
    touched = False
    count = 0
    travelled = 0.0
    while travelled <= length:
        if 0 <= i < columns and 0 <= j < rows:
            for k in range(bins[i * rows + j], bins[i * rows + j + 1]):
                e = bins[k]
                if stamps[e] == query:
                    continue
                stamps[e] = query
                px, py = edges[e, 0] - ax, edges[e, 1] - ay
                qx, qy = edges[e, 2] - ax, edges[e, 3] - ay
                side_p, side_q = ux * py - uy * px, ux * qy - uy * qx
                if side_p == side_q:
                    continue
                fraction = side_p / (side_p - side_q)
                t = ux * (px + fraction * (qx - px)) + uy * (py + fraction * (qy - py))
                if 0.0 < t < length:
                    found[count] = e
                    count += 1
                    touched = touched or side_p == 0.0 or side_q == 0.0
                    left = length - t if side_q > side_p else t - length
                    if (side_p > 0.0) != (side_q > 0.0):
                        inside_right += left
                    if (side_p < 0.0) != (side_q < 0.0):
                        inside_left += left
        if next_x < next_y:
            travelled = next_x
            next_x += width_x
            i += step_i
        else:
            travelled = next_y
            next_y += width_y
            j += step_j
    if min(inside_right, inside_left) <= 1e-9:
        return True
    if not touched:
        return False
    return _inside_on_both_sides(ax, ay, ux, uy, edges, found[:count]) <= 1e-9


@kernel
def _inside_on_both_sides(
    ax: float,
    ay: float,
    ux: float,
    uy: float,
    edges: FloatArray,
    crossed: NDArray[np.int64],
) -> float:
    # How much of a segment has obstacles on its left and on its right. One that runs along a
    # wall on its left and later along one on its right has none.
    n = crossed.shape[0]
    at = np.empty(n)
    right, left = np.zeros(n, np.int64), np.zeros(n, np.int64)
    for k in range(n):
        e = crossed[k]
        px, py = edges[e, 0] - ax, edges[e, 1] - ay
        qx, qy = edges[e, 2] - ax, edges[e, 3] - ay
        side_p, side_q = ux * py - uy * px, ux * qy - uy * qx
        fraction = side_p / (side_p - side_q)
        at[k] = ux * (px + fraction * (qx - px)) + uy * (py + fraction * (qy - py))
        into = 1 if side_q > side_p else -1
        right[k] = into if (side_p > 0.0) != (side_q > 0.0) else 0
        left[k] = into if (side_p < 0.0) != (side_q < 0.0) else 0
    inside = 0.0
    depth_right = depth_left = 0
    previous = 0.0
    for k in np.argsort(at):
        if depth_right > 0 and depth_left > 0:
            inside += at[k] - previous
        depth_right += right[k]
        depth_left += left[k]
        previous = at[k]
    return inside
