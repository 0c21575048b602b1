"""Pieces of segments: what is left of each after several takings, in whatever order these come.

A piece is kept with the whole segment that it is of. Every taking is worked out on the whole
segment, and pieces keep what all takings leave: so the order of the takings makes no difference,
not even in rounding.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from multisrt.geometry.frontier_arcs import SHORTEST_CUT_M, arc_labels
from multisrt.geometry.kernel import BoolArray, FloatArray, IntArray, kernel

LEAST_OVERLAP_M: Final = 1e-5
"""Segments that lie along each other for less than this only touch or cross."""


@kernel
def apart_from(
    segments: FloatArray, concerned: BoolArray, lines: FloatArray, tolerance_m: float
) -> tuple[FloatArray, IntArray]:
    """Take from segments what lies along other segments, whichever way these go.

    Parameters
    ----------
    segments : (m, 4) array
        x0, y0, x1, y1 in metres.
    concerned : (m,) array of bool
        From which segments is taken; the others are left whole.
    lines : (n, 4) array
        What takes from them.
    tolerance_m : float
        They lie along each other where they are no further apart than this.

    Returns
    -------
    rest : (r, 4) array
        What is left, in the order of the segments. Remains of at most `SHORTEST_CUT_M` are not.
    source : (r,) array
        Which segment each rest is of.
    """
    capacity = max(16, 2 * segments.shape[0])
    rest, source = np.empty((capacity, 4)), np.empty(capacity, np.int64)
    low, high = np.empty(lines.shape[0]), np.empty(lines.shape[0])
    kept = 0
    for i in range(segments.shape[0]):
        x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
        length = np.hypot(x1 - x0, y1 - y0)
        count = 0
        if concerned[i] and length > 0.0:
            ux, uy = (x1 - x0) / length, (y1 - y0) / length
            left, right = min(x0, x1) - tolerance_m, max(x0, x1) + tolerance_m
            bottom, top = min(y0, y1) - tolerance_m, max(y0, y1) + tolerance_m
            for k in range(lines.shape[0]):
                px, py, qx, qy = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
                if (
                    max(px, qx) < left
                    or min(px, qx) > right
                    or max(py, qy) < bottom
                    or min(py, qy) > top
                ):
                    continue
                # Along the segment and off it; then the part beside it, and how far off that is.
                a, b = ux * (px - x0) + uy * (py - y0), ux * (qx - x0) + uy * (qy - y0)
                off_a, off_b = ux * (py - y0) - uy * (px - x0), ux * (qy - y0) - uy * (qx - x0)
                if a > b:
                    a, b, off_a, off_b = b, a, off_b, off_a
                begin, end = max(0.0, a), min(length, b)
                if end - begin < LEAST_OVERLAP_M:
                    continue
                slope = (off_b - off_a) / (b - a)
                if (
                    abs(off_a + slope * (begin - a)) > tolerance_m
                    or abs(off_a + slope * (end - a)) > tolerance_m
                ):
                    continue
                z = count - 1
                while z >= 0 and low[z] > begin:
                    low[z + 1], high[z + 1] = low[z], high[z]
                    z -= 1
                low[z + 1], high[z + 1] = begin, end
                count += 1
        begin = 0.0
        for z in range(count + 1):
            end = low[z] if z < count else length
            if end - begin > SHORTEST_CUT_M or end - begin == length:
                if kept == capacity:
                    capacity *= 2
                    more, more_source = np.empty((capacity, 4)), np.empty(capacity, np.int64)
                    more[:kept], more_source[:kept] = rest, source
                    rest, source = more, more_source
                rest[kept] = segments[i]
                if begin > 0.0:
                    share = begin / length
                    rest[kept, 0], rest[kept, 1] = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
                if end < length:
                    share = end / length
                    rest[kept, 2], rest[kept, 3] = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
                source[kept] = i
                kept += 1
            if z < count:
                begin = max(begin, high[z])
    return rest[:kept].copy(), source[:kept].copy()


@kernel
def common_pieces(
    pieces: FloatArray, wholes: FloatArray, rest: FloatArray, source: IntArray
) -> tuple[FloatArray, IntArray]:
    """Give what pieces of segments have in common with what a taking left of the segments.

    Parameters
    ----------
    pieces : (m, 4) array
        Pieces of the segments.
    wholes : (m, 4) array
        The whole segment that each piece is of.
    rest, source
        What the taking left of the whole segments, and of which one, rising.

    Returns
    -------
    common : (r, 4) array
        In the order of the pieces. Remains of at most `SHORTEST_CUT_M` are left out.
    origin : (r,) array
        The piece that each is of.
    """
    capacity = pieces.shape[0] + rest.shape[0]
    common, origin = np.empty((capacity, 4)), np.empty(capacity, np.int64)
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
            as_before = begin <= first and end >= last
            if as_before or min(end, last) - max(begin, first) > SHORTEST_CUT_M:
                common[kept] = pieces[i]
                if begin > first:
                    common[kept, 0], common[kept, 1] = rest[r, 0], rest[r, 1]
                if end < last:
                    common[kept, 2], common[kept, 3] = rest[r, 2], rest[r, 3]
                origin[kept] = i
                kept += 1
            r += 1
    return common[:kept].copy(), origin[:kept].copy()


@kernel
def in_long_arcs(segments: FloatArray, shortest_m: float) -> BoolArray:
    """Tell which segments belong to arcs that are at least this long."""
    labels, count = arc_labels(segments)
    lengths = np.zeros(count)
    for i in range(segments.shape[0]):
        lengths[labels[i]] += np.hypot(
            segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
        )
    long: BoolArray = lengths[labels] >= shortest_m
    return long
