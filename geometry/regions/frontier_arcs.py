"""Frontier arcs: pieces of a safe region's boundary beyond which no scan has reached.

Arcs are directed segments ``(m, 4)``, x0, y0, x1, y1 in metres, with their region on the left.
They only ever shrink: each region that becomes known takes from them what lies in its interior.
So the cost of one more region depends on the regions near it, not on the size of the map.

Source: Multi-SRT, section 2, "Frontier extraction" (local frontier). Differs in: free arcs are
subtracted one by one, not found from the union of all local safe regions, and radial pieces behind
corners (`GAP`) may count.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, TagArray

MIN_ARC_M: Final = 1e-3
"""Arcs shorter than this, in metres, come from regions that nearly touch."""

ENDS_MEET_M: Final = 5e-3
"""Arcs of different nodes are joined where one ends within this of the other's start, in metres
along either axis."""

JOINED_M: Final = 1e-6
"""Segments belong to one arc where one begins within this of the other's end, in metres."""


def frontier_candidates(
    boundary: FloatArray, tags: TagArray, *, include_gaps: bool = True
) -> FloatArray:
    """Return the pieces of a region's boundary that do not end at an obstacle.

    Parameters
    ----------
    boundary : (n, 2) array
        Corners of the region in metres, counter-clockwise, not closed.
    tags : (n,) array of int8
        Tag of the piece from corner i to corner i + 1.
    include_gaps : bool, default True
        Whether radial pieces behind corners (`GAP`) count.

    Returns
    -------
    (m, 4) array
        Segments x0, y0, x1, y1 in metres, in their order along the boundary, the region on
        their left.

    Examples
    --------
    >>> import numpy as np
    >>> from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE
    >>> boundary = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    >>> tags = np.array([OBSTACLE, RANGE, OBSTACLE, GAP], np.int8)
    >>> frontier_candidates(boundary, tags).tolist()
    [[2.0, 0.0, 2.0, 1.0], [0.0, 1.0, 0.0, 0.0]]
    >>> frontier_candidates(boundary, tags, include_gaps=False).tolist()
    [[2.0, 0.0, 2.0, 1.0]]
    """
    return open_pieces(boundary, tags, include_gaps)


@kernel
def open_pieces(boundary: FloatArray, tags: TagArray, include_gaps: bool) -> FloatArray:
    """Return what `frontier_candidates` returns, for kernels."""
    n = boundary.shape[0]
    pieces = np.empty((n, 4))
    kept = 0
    for i in range(n):
        if tags[i] == OBSTACLE or (tags[i] == GAP and not include_gaps):
            continue
        j = (i + 1) % n
        pieces[kept, 0], pieces[kept, 1] = boundary[i, 0], boundary[i, 1]
        pieces[kept, 2], pieces[kept, 3] = boundary[j, 0], boundary[j, 1]
        kept += 1
    return pieces[:kept]


@kernel
def arc_labels(segments: FloatArray) -> tuple[IntArray, int]:
    """Label the arcs of one node: runs of segments of which each begins where the last ends.

    Parameters
    ----------
    segments : (m, 4) array
        Segments x0, y0, x1, y1 in metres, in their order along the boundary, which closes: the
        last run and the first are one arc if they meet.

    Returns
    -------
    labels : (m,) array of int
        The arc of every segment, counted from 0.
    count : int
        Number of arcs.

    Examples
    --------
    >>> import numpy as np
    >>> labels, count = arc_labels(np.array([[0.0, 0, 1, 0], [1, 0, 1, 1], [5, 5, 6, 5]]))
    >>> labels.tolist(), count
    ([0, 0, 1], 2)
    """
    n = segments.shape[0]
    labels = np.zeros(n, np.int64)
    if n == 0:
        return labels, 0
    last = 0
    for i in range(1, n):
        if not _meets(segments, i - 1, i):
            last += 1
        labels[i] = last
    if last > 0 and _meets(segments, n - 1, 0):
        for i in range(n - 1, -1, -1):
            if labels[i] != last:
                break
            labels[i] = 0
        last -= 1
    return labels, last + 1


@kernel
def arc_ends(segments: FloatArray) -> FloatArray:
    """Return where the arcs of one node begin and end, and their lengths.

    Parameters
    ----------
    segments : (m, 4) array
        As for `arc_labels`.

    Returns
    -------
    (k, 5) array
        x and y of the start, x and y of the end, and the length of every arc in metres, in the
        order of `arc_labels`.
    """
    n = segments.shape[0]
    labels, count = arc_labels(segments)
    ends = np.zeros((count, 5))
    begun = np.zeros(count, np.bool_)
    # An arc over the boundary's closing begins in its last run; that run is visited first. It may
    # be the only arc, so that labels do not tell where it begins; around a whole ring none does.
    first = 0
    while first < n - 1 and _meets(segments, n - 1 - first, (n - first) % n):
        first += 1
    for step in range(n):
        i = (n - first + step) % n
        k = labels[i]
        if not begun[k]:
            begun[k] = True
            ends[k, 0], ends[k, 1] = segments[i, 0], segments[i, 1]
        ends[k, 2], ends[k, 3] = segments[i, 2], segments[i, 3]
        ends[k, 4] += np.hypot(segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1])
    return ends


@kernel
def _meets(segments: FloatArray, i: int, j: int) -> bool:
    # Whether segment j begins where segment i ends.
    gap = abs(segments[j, 0] - segments[i, 2]) + abs(segments[j, 1] - segments[i, 3])
    return bool(gap <= JOINED_M)


@kernel
def in_long_arcs(segments: FloatArray, min_length_m: float) -> BoolArray:
    """Return which segments, ``(m,)``, belong to arcs of at least a length in metres."""
    labels, count = arc_labels(segments)
    lengths = np.zeros(count)
    for i in range(segments.shape[0]):
        lengths[labels[i]] += np.hypot(
            segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
        )
    is_long = np.empty(segments.shape[0], np.bool_)
    for i in range(segments.shape[0]):
        is_long[i] = lengths[labels[i]] >= min_length_m
    return is_long


@kernel
def is_wide_chain(ends: FloatArray, first: int, min_length_m: float) -> bool:
    """Return whether an arc, with all that it is joined to, has at least some length.

    Parameters
    ----------
    ends : (k, 5) array
        Arcs of one or of many nodes, as `arc_ends` returns them. One is joined to another where
        it ends within `ENDS_MEET_M` of the other's begin.
    first : int
        The arc.
    min_length_m : float
        The length in metres.
    """
    chain = np.empty(ends.shape[0], np.int64)
    is_in = np.zeros(ends.shape[0], np.bool_)
    chain[0], is_in[first] = first, True
    count, done, length = 1, 0, ends[first, 4]
    while length < min_length_m and done < count:
        i = chain[done]
        done += 1
        for j in range(ends.shape[0]):
            if not is_in[j] and (_follows(ends, i, j) or _follows(ends, j, i)):
                chain[count], is_in[j] = j, True
                count += 1
                length += ends[j, 4]
    return bool(length >= min_length_m)


@kernel
def _follows(ends: FloatArray, i: int, j: int) -> bool:
    # Whether arc j begins where arc i ends.
    return bool(
        abs(ends[i, 2] - ends[j, 0]) <= ENDS_MEET_M and abs(ends[i, 3] - ends[j, 1]) <= ENDS_MEET_M
    )


def total_length(segments: FloatArray) -> float:
    """Return the sum of the lengths of segments, ``(m, 4)``, in metres."""
    if not len(segments):
        return 0.0
    return float(np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]).sum())
