"""Frontier arcs: the pieces of a safe region's boundary beyond which nobody has seen.

Arcs are kept as directed segments, their region on the left, and only ever shrink: a region
that arrives takes from each what lies in its interior. Nothing is recomputed from the union of
all regions, so the cost depends on the regions near by.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from multisrt.geometry.numerics.kernel import (
    BoolArray,
    FloatArray,
    IntArray,
    kernel,
    unsigned,
)
from multisrt.geometry.numerics.rings import STRETCH, first_stretch
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, TagArray

OUTWARD_M: Final = 1e-6
"""How far outside its region a segment is asked whether another region covers it.

Two regions that end at one line would otherwise take it from each other: the line is on the
boundary of both, and shapely's difference deletes it although nobody has seen behind it.
"""

ROUNDING_M: Final = 1e-7
"""Shorter segments are rounding."""

SHORTEST_CUT_M: Final = 1e-4
"""Shorter remains of a segment that was cut are dropped.

Where a segment meets a wall at a flat angle, its shifted double enters the wall before its end;
nobody will ever see that last bit.
"""

SHORTEST_ARC_M: Final = 1e-3
"""Shorter arcs come from regions that nearly touch."""

ENDS_MEET_M: Final = 5e-3
"""Arcs of different nodes meet where one ends within this of the other's begin."""

JOINED_M: Final = 1e-6
"""Segments are of one arc where one begins within this of the other's end."""


def frontier_candidates(
    boundary: FloatArray, tags: TagArray, *, include_gaps: bool = True
) -> FloatArray:
    """Give the pieces of a region's boundary that do not end at an obstacle.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the region, counter-clockwise.
    tags : (n,) array
        Why the region ends at each piece.
    include_gaps : bool
        Whether radial pieces behind corners count.

    Returns
    -------
    (m, 4) array
        Segments x0, y0, x1, y1 in their order along the boundary, the region on their left.
    """
    return pieces_tagged(boundary, tags, include_gaps)


@kernel
def pieces_tagged(boundary: FloatArray, tags: TagArray, include_gaps: bool) -> FloatArray:
    """Do what `frontier_candidates` does, for kernels that call it."""
    pieces = np.empty((boundary.shape[0], 4))
    return pieces[: _tagged(boundary, tags, include_gaps, pieces)]


@kernel
def _tagged(boundary: FloatArray, tags: TagArray, include_gaps: bool, pieces: FloatArray) -> int:
    n = boundary.shape[0]
    kept = 0
    for i in range(n):
        if tags[i] == OBSTACLE or (tags[i] == GAP and not include_gaps):
            continue
        j = (i + 1) % n
        pieces[kept, 0], pieces[kept, 1] = boundary[i, 0], boundary[i, 1]
        pieces[kept, 2], pieces[kept, 3] = boundary[j, 0], boundary[j, 1]
        kept += 1
    return kept


@kernel
def uncovered(
    segments: FloatArray,
    starts: IntArray,
    corners: FloatArray,
    boxes: FloatArray,
    stretches: FloatArray,
    ids: IntArray,
) -> tuple[FloatArray, IntArray]:
    """Take from segments what lies in the interior of given polygons.

    Parameters
    ----------
    segments : (m, 4) array
        Directed segments, the region that they bound on their left.
    starts, corners, boxes, stretches
        The polygons, as `RingArrays` has them.
    ids : (k,) array
        Which polygons take from the segments.

    Returns
    -------
    rest : (r, 4) array
        What is left, in the order of the segments.
    source : (r,) array
        Which segment each rest is of.
    """
    ids = ids.copy()
    longest, total = 0, 0
    for k in range(ids.shape[0]):
        size = starts[ids[k] + 1] - starts[ids[k]]
        longest = max(longest, size)
        total += size
    crossings = np.empty(longest + 1)
    low, high = np.empty(total + 1), np.empty(total + 1)
    room = max(16, 2 * segments.shape[0])
    while True:
        rest, source = np.empty((room, 4)), np.empty(room, np.int64)
        count = _uncovered(
            segments, starts, corners, boxes, stretches, ids, crossings, low, high, rest, source
        )
        if count <= room:
            return rest[:count].copy(), source[:count].copy()
        room = count


@kernel
def _uncovered(
    segments: FloatArray,
    starts: IntArray,
    corners: FloatArray,
    boxes: FloatArray,
    stretches: FloatArray,
    ids: IntArray,
    crossings: FloatArray,
    low: FloatArray,
    high: FloatArray,
    rest: FloatArray,
    source: IntArray,
) -> int:
    # Writes what is left of segments, as far as there is room. Tells how much is left. The
    # polygons change their order; crossings, low and high are room to work in.
    kept = 0
    for i in range(segments.shape[0]):
        x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
        length = np.hypot(x1 - x0, y1 - y0)
        if length <= ROUNDING_M:
            continue
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        ox, oy = x0 + uy * OUTWARD_M, y0 - ux * OUTWARD_M
        left, right = min(ox, ox + x1 - x0), max(ox, ox + x1 - x0)
        bottom, top = min(oy, oy + y1 - y0), max(oy, oy + y1 - y0)
        # The corners of a box that lie farthest to the left and to the right of the segment.
        leftmost = (unsigned(0 if uy > 0.0 else 2), unsigned(3 if ux > 0.0 else 1))
        rightmost = (unsigned(2) - leftmost[0], unsigned(4) - leftmost[1])
        covered = 0
        whole = False
        for k in range(ids.shape[0]):
            p = unsigned(ids[k])
            if (
                boxes[p, 0] > right
                or boxes[p, 2] < left
                or boxes[p, 1] > top
                or boxes[p, 3] < bottom
            ):
                continue
            # Where the polygon's boundary crosses the segment's line, in order: between the
            # first and the second crossing the line is inside, and so on.
            ring = corners[starts[p] : starts[p + unsigned(1)]]
            row = unsigned(first_stretch(ids[k], starts[p]))
            count = 0
            for first in range(0, ring.shape[0], STRETCH):
                most = ux * (stretches[row, leftmost[1]] - oy) - uy * (
                    stretches[row, leftmost[0]] - ox
                )
                least = ux * (stretches[row, rightmost[1]] - oy) - uy * (
                    stretches[row, rightmost[0]] - ox
                )
                row += unsigned(1)
                if most <= 0.0 or least > 0.0:
                    continue
                # Before the first corner comes the last one: the index -1.
                px, py = ring[first - 1, 0] - ox, ring[first - 1, 1] - oy
                side_p = ux * py - uy * px
                for c in range(first, min(first + STRETCH, ring.shape[0])):
                    qx, qy = ring[c, 0] - ox, ring[c, 1] - oy
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
            for z in range(0, count - 1, 2):
                begin, end = max(0.0, crossings[z]), min(length, crossings[z + 1])
                if end > begin:
                    y = covered - 1
                    while y >= 0 and low[y] > begin:
                        low[y + 1], high[y + 1] = low[y], high[y]
                        y -= 1
                    low[y + 1], high[y + 1] = begin, end
                    covered += 1
                    whole = begin == 0.0 and end == length
            if whole:
                # It mostly takes the next segment, too: then no other one is asked.
                ids[0], ids[k] = ids[k], ids[0]
                break
        if whole:
            continue
        begin = 0.0
        for z in range(covered + 1):
            end = low[z] if z < covered else length
            if end - begin > SHORTEST_CUT_M or end - begin == length:
                if kept < rest.shape[0]:
                    rest[kept, 0], rest[kept, 1] = x0 + ux * begin, y0 + uy * begin
                    rest[kept, 2], rest[kept, 3] = x0 + ux * end, y0 + uy * end
                    if begin == 0.0:
                        rest[kept, 0], rest[kept, 1] = x0, y0
                    if end == length:
                        rest[kept, 2], rest[kept, 3] = x1, y1
                    source[kept] = i
                kept += 1
            if z < covered:
                begin = max(begin, high[z])
    return kept


@kernel
def arc_labels(segments: FloatArray) -> tuple[IntArray, int]:
    """Tell arcs of one node apart: runs of segments of which each begins where the last ends.

    Parameters
    ----------
    segments : (m, 4) array
        Segments in their order along the boundary, which closes.

    Returns
    -------
    labels : (m,) array
        The arc of every segment, counted from 0.
    count : int
        How many arcs there are.
    """
    labels = np.zeros(segments.shape[0], np.int64)
    return labels, _label_arcs(segments, labels)


@kernel
def _label_arcs(segments: FloatArray, labels: IntArray) -> int:
    # Writes the labels over zeros. Tells how many there are.
    n = segments.shape[0]
    if n == 0:
        return 0
    count = 0
    for i in range(1, n):
        gap = abs(segments[i, 0] - segments[i - 1, 2]) + abs(segments[i, 1] - segments[i - 1, 3])
        if gap > JOINED_M:
            count += 1
        labels[i] = count
    closing = abs(segments[0, 0] - segments[n - 1, 2]) + abs(segments[0, 1] - segments[n - 1, 3])
    if count > 0 and closing <= JOINED_M:
        for i in range(n - 1, -1, -1):
            if labels[i] != count:
                break
            labels[i] = 0
        count -= 1
    return count + 1


@kernel
def arc_ends(segments: FloatArray) -> FloatArray:
    """Give the arcs of one node as ``(k, 5)``: x and y of begin and end, and the length.

    Arcs are in the order of `arc_labels`.
    """
    labels, count = arc_labels(segments)
    ends = np.zeros((count, 5))
    _note_ends(segments, labels, count, np.zeros(count, np.bool_), ends)
    return ends


@kernel
def _note_ends(
    segments: FloatArray, labels: IntArray, count: int, begun: BoolArray, ends: FloatArray
) -> None:
    n = segments.shape[0]
    # An arc over the boundary's closing begins in its last run; that run is visited first.
    first = 0
    if count > 0:
        while first < n and labels[n - 1 - first] == 0 and labels[0] == 0 and count > 1:
            first += 1
    for step in range(n):
        i = (n - first + step) % n
        k = labels[i]
        if not begun[k]:
            begun[k] = True
            ends[k, 0], ends[k, 1] = segments[i, 0], segments[i, 1]
        ends[k, 2], ends[k, 3] = segments[i, 2], segments[i, 3]
        ends[k, 4] += np.hypot(segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1])


@kernel
def joined_lengths(ends: FloatArray) -> FloatArray:
    """Give for every arc the length of all arcs that it is joined to, with its own.

    Parameters
    ----------
    ends : (k, 5) array
        Arcs of one or of many nodes, as `arc_ends` gives them.
    """
    n = ends.shape[0]
    parent = np.arange(n)
    # Where arcs begin, from left to right: only those right there are compared with an end.
    order = np.argsort(ends[:, 0])
    begins = ends[order, 0]
    for i in range(n):
        k = np.searchsorted(begins, ends[i, 2] - ENDS_MEET_M)
        while k < n and begins[k] <= ends[i, 2] + ENDS_MEET_M:
            j = order[k]
            k += 1
            if i != j and abs(ends[i, 3] - ends[j, 1]) <= ENDS_MEET_M:
                a, b = i, j
                while parent[a] != a:
                    a = parent[a]
                while parent[b] != b:
                    b = parent[b]
                parent[max(a, b)] = min(a, b)
    lengths = np.zeros(n)
    roots = np.empty(n, np.int64)
    for i in range(n):
        root = i
        while parent[root] != root:
            root = parent[root]
        roots[i] = root
        lengths[root] += ends[i, 4]
    return lengths[roots]


@kernel
def pieces_by_owner(
    segments: FloatArray, owners: IntArray, count: int, rest: FloatArray, source: IntArray
) -> tuple[IntArray, BoolArray]:
    """Sort what `uncovered` left by the owners of the segments.

    Parameters
    ----------
    segments : (m, 4) array
        What was given to `uncovered`.
    owners : (m,) array
        Whose each segment is, from 0 and never falling.
    count : int
        How many owners there are.
    rest, source
        What `uncovered` gave.

    Returns
    -------
    begins : (count + 1,) array
        Owner k is left with ``rest[begins[k]:begins[k + 1]]``.
    cut : (count,) array of bool
        Who lost something.
    """
    begins = np.zeros(count + 1, np.int64)
    cut = np.zeros(count, np.bool_)
    _sort_by_owner(segments, owners, rest, source, begins, cut)
    return begins, cut


@kernel
def _sort_by_owner(
    segments: FloatArray,
    owners: IntArray,
    rest: FloatArray,
    source: IntArray,
    begins: IntArray,
    cut: BoolArray,
) -> None:
    r = 0
    for i in range(segments.shape[0]):
        k = owners[i]
        whole = False
        pieces = 0
        while r < rest.shape[0] and source[r] == i:
            whole = True
            for c in range(4):
                whole = whole and rest[r, c] == segments[i, c]
            pieces += 1
            r += 1
        if pieces != 1 or not whole:
            cut[k] = True
        begins[k + 1] = r
    for k in range(cut.shape[0]):
        begins[k + 1] = max(begins[k], begins[k + 1])


def total_length(segments: FloatArray) -> float:
    """Sum of the segments' lengths in metres."""
    if not len(segments):
        return 0.0
    return float(np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]).sum())
