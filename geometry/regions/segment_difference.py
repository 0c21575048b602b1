"""Differences of segments: what remains of them outside polygons, or beside other segments.

A remainder knows the segment that it comes from. Each difference is computed on whole segments,
and `intersect_pieces` combines the results of several: then the order in which polygons or
segments are subtracted makes no difference, not even in rounding.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.kernel import (
    BoolArray,
    FloatArray,
    IntArray,
    inlined_kernel,
    kernel,
    unsigned,
)
from multisrt.geometry.numerics.rings import STRETCH, RingArrays

OUTWARD_M: Final = 1e-6
"""Distance in metres by which segments are shifted to their right before they are compared.

Two regions that end at one line would otherwise take it from each other: the line is on the
boundary of both, and shapely's difference deletes it although no robot has seen behind it.
"""

MIN_SEGMENT_M: Final = 1e-7
"""Segments of at most this length in metres are rounding, and dropped."""

MIN_REMAINDER_M: Final = 1e-4
"""Remainders of a cut segment of at most this length in metres are dropped.

Where a segment meets a wall at a flat angle, its shifted double enters the wall before the
segment ends; no scan will ever reach that last bit.
"""

MIN_OVERLAP_M: Final = 1e-5
"""Segments that lie along each other for less than this length in metres only touch or cross."""


class Line(NamedTuple):
    """A directed segment: its origin, its unit vector and its length."""

    x: float
    y: float
    ux: float
    uy: float
    length: float


@inlined_kernel
def shifted_line(x0: float, y0: float, x1: float, y1: float, length: float) -> Line:
    """Return the line that is compared with polygons in place of a segment."""
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    return Line(x0 + uy * OUTWARD_M, y0 - ux * OUTWARD_M, ux, uy, length)


class Intervals(NamedTuple):
    """Room for intervals along a segment, kept in the order of their lower ends."""

    low: FloatArray
    high: FloatArray


class Remainders(NamedTuple):
    """Room for remainders, and for the index of the segment that each comes from."""

    rest: FloatArray
    source: IntArray


@kernel
def uncovered(
    segments: FloatArray, rings: RingArrays, ids: IntArray
) -> tuple[FloatArray, IntArray]:
    """Subtract the interiors of polygons from segments.

    Parameters
    ----------
    segments : (m, 4) array
        Directed segments x0, y0, x1, y1 in metres; the region that they bound is on their left.
        What is compared with the polygons lies `OUTWARD_M` to their right.
    rings : RingArrays
        Polygons, with the corners of those to subtract.
    ids : (k,) array of int
        Indices of the polygons to subtract.

    Returns
    -------
    rest : (r, 4) array
        Remainders in the order of the segments, longer than `MIN_REMAINDER_M` unless the segment
        is whole.
    source : (r,) array of int
        Index of the segment that each remainder comes from, ascending.

    Examples
    --------
    >>> import numpy as np
    >>> from multisrt.geometry.numerics.rings import Rings
    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> segments = np.array([[-1.0, 1.0, 3.0, 1.0], [5.0, 1.0, 6.0, 1.0]])
    >>> rest, source = uncovered(segments, Rings([square]).arrays(np.array([0])), np.array([0]))
    >>> rest.tolist()
    [[-1.0, 1.0, 0.0, 1.0], [2.0, 1.0, 3.0, 1.0], [5.0, 1.0, 6.0, 1.0]]
    >>> source.tolist()
    [0, 0, 1]
    """
    order = ids.copy()
    longest, total = 0, 0
    for k in range(ids.shape[0]):
        size = rings.spans[ids[k], 1]
        longest = max(longest, size)
        total += size
    crossings = np.empty(longest + 1)
    covered = Intervals(np.empty(total + 1), np.empty(total + 1))
    room = max(16, 2 * segments.shape[0])
    while True:
        found = Remainders(np.empty((room, 4)), np.empty(room, np.int64))
        kept = 0
        for i in range(segments.shape[0]):
            x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
            length = np.hypot(x1 - x0, y1 - y0)
            if length <= MIN_SEGMENT_M:
                continue
            line = shifted_line(x0, y0, x1, y1, length)
            end = line.x + x1 - x0, line.y + y1 - y0
            count = _covered_by_rings(line, end, rings, order, crossings, covered)
            if count >= 0:
                direction = line.ux, line.uy
                kept = add_remainders(segments, i, direction, 1.0, covered, count, found, kept)
        if kept <= room:
            return found.rest[:kept].copy(), found.source[:kept].copy()
        room = kept


@inlined_kernel
def _covered_by_rings(
    line: Line,
    line_end: tuple[float, float],
    rings: RingArrays,
    order: IntArray,
    crossings: FloatArray,
    covered: Intervals,
) -> int:
    # Note the intervals of a line that rings cover, and return their number, or -1 if one ring
    # covers the whole line. That ring moves to the front of the order: it often covers the next
    # line, too.
    left, right = min(line.x, line_end[0]), max(line.x, line_end[0])
    bottom, top = min(line.y, line_end[1]), max(line.y, line_end[1])
    count = 0
    for k in range(order.shape[0]):
        p = unsigned(order[k])
        if (
            rings.boxes[p, 0] > right
            or rings.boxes[p, 2] < left
            or rings.boxes[p, 1] > top
            or rings.boxes[p, 3] < bottom
        ):
            continue
        crossed = crossings_with(line, rings, order[k], crossings)
        whole = False
        # Between the first and the second crossing the line is inside, and so on.
        for z in range(0, crossed - 1, 2):
            begin, end = max(0.0, crossings[z]), min(line.length, crossings[z + 1])
            if end > begin:
                count = insert_interval(covered, count, begin, end)
                whole = begin == 0.0 and end == line.length
        if whole:
            order[0], order[k] = order[k], order[0]
            return -1
    return count


@inlined_kernel
def crossings_with(line: Line, rings: RingArrays, index: int, crossings: FloatArray) -> int:
    """Note where a ring crosses a line, in metres along it, ascending; return the number."""
    ux, uy = line.ux, line.uy
    p = unsigned(index)
    first_corner = rings.spans[p, 0]
    ring = rings.corners[first_corner : first_corner + rings.spans[p, 1]]
    boxes, row = rings.stretches, unsigned(rings.spans[p, 2])
    # Columns of the corners of a box that lie farthest to the left and to the right of the line.
    left_x, left_y = unsigned(0 if uy > 0.0 else 2), unsigned(3 if ux > 0.0 else 1)
    right_x, right_y = unsigned(2) - left_x, unsigned(4) - left_y
    count = 0
    for first in range(0, ring.shape[0], STRETCH):
        most = ux * (boxes[row, left_y] - line.y) - uy * (boxes[row, left_x] - line.x)
        least = ux * (boxes[row, right_y] - line.y) - uy * (boxes[row, right_x] - line.x)
        row += unsigned(1)
        if most <= 0.0 or least > 0.0:
            continue
        # Before the first corner comes the last one: the index -1.
        px, py = ring[first - 1, 0] - line.x, ring[first - 1, 1] - line.y
        side_p = ux * py - uy * px
        for c in range(first, min(first + STRETCH, ring.shape[0])):
            qx, qy = ring[c, 0] - line.x, ring[c, 1] - line.y
            side_q = ux * qy - uy * qx
            if (side_p > 0.0) != (side_q > 0.0):
                along_p, along_q = ux * px + uy * py, ux * qx + uy * qy
                t = along_p + side_p / (side_p - side_q) * (along_q - along_p)
                z = count - 1
                while z >= 0 and crossings[z] > t:
                    crossings[z + 1] = crossings[z]
                    z -= 1
                crossings[z + 1] = t
                count += 1
            px, py, side_p = qx, qy, side_q
    return count


@kernel
def beside(
    segments: FloatArray, selected: BoolArray, lines: FloatArray, tolerance_m: float
) -> tuple[FloatArray, IntArray]:
    """Subtract from segments what lies along other segments, whichever way these point.

    Parameters
    ----------
    segments : (m, 4) array
        x0, y0, x1, y1 in metres.
    selected : (m,) array of bool
        The segments to subtract from; the others stay whole.
    lines : (n, 4) array
        The segments that are subtracted.
    tolerance_m : float
        Segments lie along each other where they are at most this far apart.

    Returns
    -------
    rest : (r, 4) array
        Remainders in the order of the segments, longer than `MIN_REMAINDER_M` unless the segment
        is whole.
    source : (r,) array of int
        Index of the segment that each remainder comes from, ascending.

    Examples
    --------
    >>> import numpy as np
    >>> segments, lines = np.array([[0.0, 0, 4, 0]]), np.array([[3.0, 0, 1, 0]])
    >>> beside(segments, np.array([True]), lines, 1e-6)[0].tolist()
    [[0.0, 0.0, 1.0, 0.0], [3.0, 0.0, 4.0, 0.0]]
    """
    covered = Intervals(np.empty(lines.shape[0]), np.empty(lines.shape[0]))
    room = max(16, 2 * segments.shape[0])
    while True:
        found = Remainders(np.empty((room, 4)), np.empty(room, np.int64))
        kept = 0
        for i in range(segments.shape[0]):
            x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
            length = np.hypot(x1 - x0, y1 - y0)
            count = 0
            if selected[i] and length > 0.0:
                line = Line(x0, y0, (x1 - x0) / length, (y1 - y0) / length, length)
                count = _covered_by_lines(line, (x1, y1), lines, tolerance_m, covered)
            kept = add_remainders(
                segments, i, (x1 - x0, y1 - y0), length, covered, count, found, kept
            )
        if kept <= room:
            return found.rest[:kept].copy(), found.source[:kept].copy()
        room = kept


@inlined_kernel
def _covered_by_lines(
    line: Line,
    line_end: tuple[float, float],
    lines: FloatArray,
    tolerance_m: float,
    covered: Intervals,
) -> int:
    # Note the intervals of a line along which others lie, and return their number.
    left, right = min(line.x, line_end[0]) - tolerance_m, max(line.x, line_end[0]) + tolerance_m
    bottom, top = min(line.y, line_end[1]) - tolerance_m, max(line.y, line_end[1]) + tolerance_m
    count = 0
    for k in range(lines.shape[0]):
        px, py, qx, qy = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
        if max(px, qx) < left or min(px, qx) > right or max(py, qy) < bottom or min(py, qy) > top:
            continue
        # Coordinates of the ends along the line and off it, the lower end first.
        px, py, qx, qy = px - line.x, py - line.y, qx - line.x, qy - line.y
        a, b = line.ux * px + line.uy * py, line.ux * qx + line.uy * qy
        off_a, off_b = line.ux * py - line.uy * px, line.ux * qy - line.uy * qx
        if a > b:
            a, b, off_a, off_b = b, a, off_b, off_a
        begin, end = max(0.0, a), min(line.length, b)
        if end - begin < MIN_OVERLAP_M:
            continue
        slope = (off_b - off_a) / (b - a)
        if (
            abs(off_a + slope * (begin - a)) <= tolerance_m
            and abs(off_a + slope * (end - a)) <= tolerance_m
        ):
            count = insert_interval(covered, count, begin, end)
    return count


@inlined_kernel
def insert_interval(intervals: Intervals, count: int, begin: float, end: float) -> int:
    """Insert an interval into those that are sorted by their lower ends; return the new number."""
    low, high = intervals.low, intervals.high
    z = count - 1
    while z >= 0 and low[z] > begin:
        low[z + 1], high[z + 1] = low[z], high[z]
        z -= 1
    low[z + 1], high[z + 1] = begin, end
    return count + 1


@inlined_kernel
def add_remainders(
    segments: FloatArray,
    i: int,
    direction: tuple[float, float],
    unit: float,
    covered: Intervals,
    count: int,
    found: Remainders,
    kept: int,
) -> int:
    """Write what intervals leave of segment i behind the `kept` remainders, if there is room.

    Return the new number. A point at t metres along the segment is its origin plus t / unit times
    the direction.
    """
    x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
    dx, dy = direction
    rest = found.rest
    length = np.hypot(x1 - x0, y1 - y0)
    begin = 0.0
    for z in range(count + 1):
        end = covered.low[z] if z < count else length
        if end - begin > MIN_REMAINDER_M or end - begin == length:
            if kept < rest.shape[0]:
                rest[kept, 0], rest[kept, 1] = x0, y0
                rest[kept, 2], rest[kept, 3] = x1, y1
                if begin > 0.0:
                    t = begin / unit
                    rest[kept, 0], rest[kept, 1] = x0 + t * dx, y0 + t * dy
                if end < length:
                    t = end / unit
                    rest[kept, 2], rest[kept, 3] = x0 + t * dx, y0 + t * dy
                found.source[kept] = i
            kept += 1
        if z < count:
            begin = max(begin, covered.high[z])
    return kept


@kernel
def intersect_pieces(
    pieces: FloatArray, wholes: FloatArray, rest: FloatArray, source: IntArray
) -> tuple[FloatArray, IntArray]:
    """Intersect pieces of segments with the remainders of the segments that they come from.

    Parameters
    ----------
    pieces : (m, 4) array
        Pieces x0, y0, x1, y1 of segments, in metres.
    wholes : (m, 4) array
        The whole segment that each piece comes from.
    rest : (n, 4) array
        Remainders of these whole segments.
    source : (n,) array of int
        Row of `wholes` that each remainder comes from, ascending.

    Returns
    -------
    common : (r, 4) array
        Intersections in the order of the pieces, longer than `MIN_REMAINDER_M` unless the piece
        is whole.
    origin : (r,) array of int
        Row of `pieces` that each intersection comes from, ascending.
    """
    common, origin = np.empty((rest.shape[0], 4)), np.empty(rest.shape[0], np.int64)
    kept, r = 0, 0
    for i in range(pieces.shape[0]):
        x, y = wholes[i, 0], wholes[i, 1]
        ux, uy = wholes[i, 2] - x, wholes[i, 3] - y
        length = np.hypot(ux, uy)
        if length > 0.0:
            ux, uy = ux / length, uy / length
        first = ux * (pieces[i, 0] - x) + uy * (pieces[i, 1] - y)
        last = ux * (pieces[i, 2] - x) + uy * (pieces[i, 3] - y)
        while r < rest.shape[0] and source[r] == i:
            begin = ux * (rest[r, 0] - x) + uy * (rest[r, 1] - y)
            end = ux * (rest[r, 2] - x) + uy * (rest[r, 3] - y)
            is_whole = begin <= first and end >= last
            if is_whole or min(end, last) - max(begin, first) > MIN_REMAINDER_M:
                for c in range(4):
                    common[kept, c] = pieces[i, c]
                if begin > first or (begin == first and _is_on(pieces[i, :2], rest[r, :2], ux, uy)):
                    common[kept, 0], common[kept, 1] = rest[r, 0], rest[r, 1]
                if end < last or (end == last and _is_on(rest[r, 2:], pieces[i, 2:], ux, uy)):
                    common[kept, 2], common[kept, 3] = rest[r, 2], rest[r, 3]
                origin[kept] = i
                kept += 1
            r += 1
    return common[:kept], origin[:kept]


@inlined_kernel
def _is_on(a: FloatArray, b: FloatArray, ux: float, uy: float) -> bool:
    # Whether a point b is farther on in a direction than a, where rounding makes them equally far.
    # Points at two lengths along a segment never differ in both coordinates in opposite ways, but
    # points that are computed in different ways may: x decides, so that any order finds the same.
    if b[0] != a[0]:
        return bool((b[0] > a[0]) == (ux > 0.0))
    return bool(b[1] != a[1] and (b[1] > a[1]) == (uy > 0.0))
