"""The area that a run left uncovered, and why: by the frontier behind which it lies."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from multisrt.analysis.coverage import Coverage
from multisrt.analysis.evidence import Evidence
from multisrt.analysis.explorable import EXPLORABLE
from multisrt.analysis.remaining_frontier import arcs_given_up
from multisrt.events import BLOCKED, Segment
from multisrt.geometry.grids.strip_map import OUTSIDE
from multisrt.geometry.grids.strips import Runs, Strips
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel

LEFT_OPEN: Final = "left open"
"""Why an area is left whose frontier no robot gave up."""

NO_FRONTIER: Final = "no frontier"
"""Why an area is left that borders on no frontier: robots took what lies there for covered, as
between regions that nearly touch."""

SAMPLE_M: Final = 0.1
"""Maximum length of a part of a frontier that counts for one area, in metres."""

MAX_SAMPLES: Final = 10_000
"""Upper bound of the parts of one segment."""

MIN_AREA_M2: Final = 1e-6
"""Smaller areas are rounding."""


def given_up_m2(
    proof: Evidence, covered: Coverage, left_open: Sequence[Segment]
) -> dict[str, float]:
    """Return the explorable area that was not covered in the end, by reason, in square metres.

    Each connected part counts for the reasons for which the frontier on its border was given up,
    in proportion to the lengths.

    Parameters
    ----------
    proof : Evidence
        What the run is judged by.
    covered : Coverage
        What it covered.
    left_open : sequence of (x0, y0, x1, y1)
        The frontier that was left open in the end; see `remaining_frontier`.

    Returns
    -------
    dict of str to float
        By the reasons of `multisrt.events.ArcClosed`, `LEFT_OPEN` and `NO_FRONTIER`; their sum is
        all that was not covered. Sorted by reason; areas of rounding are left out.
    """
    plane = covered.plane.mapped([OUTSIDE, EXPLORABLE, EXPLORABLE, OUTSIDE], 2)
    left = plane.runs(EXPLORABLE)
    if not len(left.strip):
        return {}
    parts = _parts(left)
    areas = np.bincount(parts, (left.end - left.begin) * plane.cut.heights[left.strip])
    lengths: dict[str, FloatArray] = {}
    for reason, segments in _frontier(proof, left_open).items():
        lengths[reason] = _lengths_by_part(segments, left, parts, plane.cut)
    if BLOCKED in lengths and LEFT_OPEN in lengths:
        # What was blocked to the end is left open, too.
        lengths[LEFT_OPEN] = np.maximum(0.0, lengths[LEFT_OPEN] - lengths[BLOCKED])
    total = sum(lengths.values(), np.zeros(len(areas)))
    lengths[NO_FRONTIER] = np.where(total > 0.0, 0.0, 1.0)
    shares = np.where(total > 0.0, total, 1.0)
    found = {reason: float((areas * m / shares).sum()) for reason, m in lengths.items()}
    return {reason: found[reason] for reason in sorted(found) if found[reason] > MIN_AREA_M2}


def _frontier(proof: Evidence, left_open: Sequence[Segment]) -> dict[str, list[Segment]]:
    # The frontier that robots gave up, by reason, and what they left open.
    segments: dict[str, list[Segment]] = defaultdict(list)
    for closed in arcs_given_up(proof.recording):
        segments[closed.reason] += closed.arc
    segments[LEFT_OPEN] += left_open
    return {reason: arcs for reason, arcs in segments.items() if arcs}


def _parts(left: Runs) -> IntArray:
    # The number of the connected part of each interval.
    pairs = _touching(left.strip, left.begin, left.end)
    n = len(left.strip)
    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    _, parts = connected_components(graph, directed=False)
    return np.asarray(parts, np.int64)


@kernel
def _touching(strip: IntArray, begin: FloatArray, end: FloatArray) -> IntArray:
    # The pairs of intervals in neighbouring strips that overlap; intervals are sorted by strip,
    # then along it.
    n = strip.shape[0]
    pairs = np.empty((2 * n, 2), np.int64)
    count, below = 0, 0
    for i in range(n):
        while below < i and (
            strip[below] < strip[i] - 1 or (strip[below] == strip[i] - 1 and end[below] <= begin[i])
        ):
            below += 1
        k = below
        while k < i and strip[k] == strip[i] - 1 and begin[k] < end[i]:
            if count == pairs.shape[0]:
                longer = np.empty((2 * count, 2), np.int64)
                longer[:count] = pairs
                pairs = longer
            pairs[count, 0], pairs[count, 1] = k, i
            count += 1
            k += 1
    return pairs[:count]


def _lengths_by_part(
    segments: list[Segment], left: Runs, parts: IntArray, cut: Strips
) -> FloatArray:
    # The length of frontier on the border of each part: where it begins just outside.
    ends = np.array(segments)
    along = ends[:, 2:] - ends[:, :2]
    lengths = np.hypot(*along.T)
    ends, along, lengths = ends[lengths > 0.0], along[lengths > 0.0], lengths[lengths > 0.0]
    if not len(ends):
        return np.zeros(int(parts.max()) + 1)
    count = np.minimum(np.ceil(lengths / SAMPLE_M), MAX_SAMPLES).astype(np.int64)
    which = np.repeat(np.arange(len(lengths)), count)
    share = (np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[
        which
    ]
    # The region lies on the left.
    outwards = np.column_stack([along[:, 1], -along[:, 0]]) / lengths[:, None]
    step_m = 1.01 * float(cut.heights.max())
    at = ends[which, :2] + share[:, None] * along[which] + step_m * outwards[which]
    part = parts_at(at, left, parts, cut)
    inside = part >= 0
    weights = (lengths / count)[which][inside]
    return np.bincount(part[inside], weights, minlength=int(parts.max()) + 1).astype(np.float64)


def parts_at(points: FloatArray, left: Runs, parts: IntArray, cut: Strips) -> IntArray:
    """Return the number of the part in which each point lies, ``(n,)``; -1 where in none."""
    points = cut.frame(points)
    borders = (cut.middles[1:] + cut.middles[:-1]) / 2.0
    strip = np.searchsorted(borders, points[:, 1])
    # Intervals are sorted by strip, then along it: one number sorts them alike.
    low = min(float(left.begin.min()), float(points[:, 0].min()))
    width = max(float(left.end.max()), float(points[:, 0].max())) - low + 1.0
    order = left.strip * width + (left.begin - low)
    found = np.searchsorted(order, strip * width + (points[:, 0] - low), side="right") - 1
    at = np.maximum(found, 0)
    inside = (found >= 0) & (left.strip[at] == strip) & (points[:, 0] < left.end[at])
    return np.where(inside, parts[at], -1)
