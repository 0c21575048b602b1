"""Regions on thin parallel strips: along the middle of each strip they are intervals.

The ends of the intervals are exact, so that unions, differences and overlaps of regions are exact
along the middles of strips; the area of an interval is its length times the height of its strip.
That is the area itself, to rounding, where the borders of regions run straight through the strip.
Where they have corners within it, it is wrong by about the square of its height, one way or the
other. Unlike polygons, intervals know no degenerate cases: walls that many regions share are
shared ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel

Number = TypeVar("Number", bound=np.generic)


class Strips(NamedTuple):
    """A cut of a part of the plane into parallel strips.

    Attributes
    ----------
    middles : (n,) array
        Distance of the middle of each strip from the line through the origin along the strips,
        in metres, ascending.
    heights : (n,) array
        Height of each strip in metres.
    tilt_rad : float
        Direction of the strips; 0: along the x axis.
    """

    middles: FloatArray
    heights: FloatArray
    tilt_rad: float = 0.0

    def frame(self, points: FloatArray) -> FloatArray:
        """Return points ``(n, 2)`` with their coordinates along and across the strips."""
        cos, sin = math.cos(self.tilt_rad), math.sin(self.tilt_rad)
        turned: FloatArray = libm.product(points, np.array([[cos, -sin], [sin, cos]]))
        return turned


def strips(edges: FloatArray, height_m: float, tilt_rad: float = 0.0) -> Strips:
    """Return strips over a world, with borders at its walls that run along them.

    Parameters
    ----------
    edges : (n, 4) array
        x0, y0, x1, y1 of every wall in metres.
    height_m : float
        Upper bound of the height of a strip in metres.
    tilt_rad : float
        Direction of the strips. Borders of regions that run along a strip without being walls are
        wrong by up to half of its height; few do so at an odd angle.

    Returns
    -------
    Strips
        From the lowest to the highest corner.

    Examples
    --------
    >>> room = np.array([(0, 0, 4, 0), (4, 0, 4, 1), (4, 1, 0, 1), (0, 1, 0, 0)], float)
    >>> cut = strips(room, 0.3)
    >>> cut.middles.tolist(), cut.heights.tolist()
    ([0.125, 0.375, 0.625, 0.875], [0.25, 0.25, 0.25, 0.25])
    """
    flat = Strips(np.empty(0), np.empty(0), tilt_rad)
    across = flat.frame(np.asarray(edges, np.float64).reshape(-1, 2))[:, 1].reshape(-1, 2)
    along = np.abs(across[:, 0] - across[:, 1]) < height_m
    borders = np.unique([across.min(), across.max(), *across[along].ravel()])
    gaps = np.diff(borders)
    counts = np.maximum(1, np.ceil(gaps / height_m)).astype(np.int64)
    heights = np.repeat(gaps / counts, counts)
    first = np.repeat(np.cumsum(counts) - counts, counts)
    middles = np.repeat(borders[:-1], counts) + (np.arange(len(first)) - first + 0.5) * heights
    return Strips(middles, heights, tilt_rad)


class Runs(NamedTuple):
    """The intervals of some regions on strips.

    Attributes
    ----------
    starts : (n + 1,) array of int
        Those of region i are at indices ``starts[i]`` to ``starts[i + 1]``.
    strip : (m,) array of int
        The strip of each interval.
    begin, end : (m,) array
        Its ends: distance along the strips in metres.
    """

    starts: IntArray
    strip: IntArray
    begin: FloatArray
    end: FloatArray


def runs_of(cut: Strips, regions: Sequence[FloatArray], wanted: Runs | None = None) -> Runs:
    """Return the intervals of regions on strips, by the even-odd rule.

    Parameters
    ----------
    cut : Strips
        The strips.
    regions : sequence of (k, 2) array
        Corners of each region in metres; the last is joined to the first. A region without
        corners has no intervals.
    wanted : Runs, optional
        A single region, its intervals by strip: on strips on which none of them overlaps the
        extent of a region, that region is left out. Default: no strip is left out.

    Returns
    -------
    Runs
        In the order of the regions, by strip, each from its begin to its end.

    Examples
    --------
    >>> triangle = np.array([(0.0, 0.0), (2.0, 0.0), (0.0, 2.0)])
    >>> walls = np.hstack([triangle, np.roll(triangle, -1, axis=0)])
    >>> runs = runs_of(strips(walls, 1.0), [triangle])
    >>> runs.strip.tolist(), runs.begin.tolist(), runs.end.tolist()
    ([0, 1], [0.0, 0.0], [1.5, 0.5])
    """
    sizes = [len(region) for region in regions]
    corners = cut.frame(np.concatenate(regions)) if sizes else np.empty((0, 2))
    return Runs(*_runs(corners, np.cumsum([0, *sizes]), cut.middles, wanted))


def runs_of_polygon(cut: Strips, polygon: Polygon) -> Runs:
    """Return the intervals of a polygon with holes on strips, as one region."""
    rings = [shapely.get_coordinates(r)[:-1] for r in (polygon.exterior, *polygon.interiors)]
    starts = np.cumsum([0, *map(len, rings)])
    return Runs(*_runs_of_rings(cut.frame(np.concatenate(rings)), starts, cut.middles))


def clipped(runs: Runs, masks: IntArray) -> Runs:
    """Return regions, some of them as far as they lie in another region.

    Parameters
    ----------
    runs : Runs
        The regions.
    masks : (n,) array of int
        For each region the number of the region in which it counts; -1: it counts whole, -2: not
        at all.

    Returns
    -------
    Runs
        As many regions.

    Examples
    --------
    >>> walls = np.array([(0.0, 0.0, 0.0, 1.0)])
    >>> boxes = [np.array([(x, 0), (x + 2, 0), (x + 2, 1), (x, 1)], float) for x in (0, 1)]
    >>> both = clipped(runs_of(strips(walls, 1.0), boxes), np.array([-1, 0]))
    >>> both.begin.tolist(), both.end.tolist()
    ([0.0, 1.0], [2.0, 2.0])
    """
    if np.all(masks == -1):
        return runs
    return Runs(*_clipped(runs, masks))


@kernel
def _runs(
    corners: FloatArray, starts: IntArray, middles: FloatArray, wanted: Runs | None
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    regions = starts.shape[0] - 1
    firsts = np.zeros(regions + 1, np.int64)
    room = 1024
    strip, begin, end = np.empty(room, np.int64), np.empty(room), np.empty(room)
    n = 0
    ring = np.zeros(2, np.int64)
    for k in range(regions):
        region = corners[starts[k] : starts[k + 1]]
        ring[1] = region.shape[0]
        rows = _rows_of(region, middles, wanted)
        low, offsets, crossings = _crossings(region, ring, middles[rows])
        needed = n + crossings.shape[0] // 2
        while needed > room:
            room *= 2
            strip = _longer(strip, room)
            begin, end = _longer(begin, room), _longer(end, room)
        for r in range(offsets.shape[0] - 1):
            for i in range(offsets[r], offsets[r + 1] - 1, 2):
                if crossings[i + 1] > crossings[i]:
                    strip[n], begin[n], end[n] = rows[low + r], crossings[i], crossings[i + 1]
                    n += 1
        firsts[k + 1] = n
    return firsts, strip[:n].copy(), begin[:n].copy(), end[:n].copy()


@kernel
def _rows_of(corners: FloatArray, middles: FloatArray, wanted: Runs | None) -> IntArray:
    # The strips on which a region has intervals that are wanted, or more.
    if corners.shape[0] == 0:
        return np.empty(0, np.int64)
    low = np.searchsorted(middles, corners[:, 1].min())
    high = np.searchsorted(middles, corners[:, 1].max())
    if wanted is None:
        return np.arange(low, high)
    left, right = corners[:, 0].min(), corners[:, 0].max()
    rows = np.empty(high - low, np.int64)
    n = 0
    for i in range(np.searchsorted(wanted.strip, low), np.searchsorted(wanted.strip, high)):
        overlaps = wanted.begin[i] < right and left < wanted.end[i]
        if overlaps and (n == 0 or rows[n - 1] < wanted.strip[i]):
            rows[n] = wanted.strip[i]
            n += 1
    return rows[:n].copy()


@kernel
def _runs_of_rings(
    corners: FloatArray, rings: IntArray, middles: FloatArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    low, offsets, crossings = _crossings(corners, rings, middles)
    room = crossings.shape[0] // 2
    strip, begin, end = np.empty(room, np.int64), np.empty(room), np.empty(room)
    n = 0
    for r in range(offsets.shape[0] - 1):
        for i in range(offsets[r], offsets[r + 1] - 1, 2):
            if crossings[i + 1] > crossings[i]:
                strip[n], begin[n], end[n] = low + r, crossings[i], crossings[i + 1]
                n += 1
    return np.array([0, n]), strip[:n].copy(), begin[:n].copy(), end[:n].copy()


@kernel
def _longer(values: NDArray[Number], room: int) -> NDArray[Number]:
    longer = np.empty(room, values.dtype)
    longer[: values.shape[0]] = values
    return longer


@kernel
def _crossings(
    corners: FloatArray, rings: IntArray, middles: FloatArray
) -> tuple[int, IntArray, FloatArray]:
    # Where the middles of strips cross rings: the first strip, and for those from there on where
    # its crossings begin, sorted.
    if corners.shape[0] == 0:
        return 0, np.zeros(1, np.int64), np.empty(0)
    low = np.searchsorted(middles, corners[:, 1].min())
    high = np.searchsorted(middles, corners[:, 1].max())
    spans = np.empty((corners.shape[0], 2), np.int64)
    offsets = np.zeros(high - low + 1, np.int64)
    for ring in range(rings.shape[0] - 1):
        at = np.searchsorted(middles, corners[rings[ring + 1] - 1, 1])
        for i in range(rings[ring], rings[ring + 1]):
            to = np.searchsorted(middles, corners[i, 1])
            spans[i, 0], spans[i, 1] = min(at, to), max(at, to)
            for r in range(spans[i, 0], spans[i, 1]):
                offsets[r - low + 1] += 1
            at = to
    for r in range(high - low):
        offsets[r + 1] += offsets[r]
    crossings, filled = np.empty(offsets[high - low]), offsets.copy()
    for ring in range(rings.shape[0] - 1):
        before = rings[ring + 1] - 1
        for i in range(rings[ring], rings[ring + 1]):
            if spans[i, 0] < spans[i, 1]:
                ax, ay = corners[before, 0], corners[before, 1]
                bx, by = corners[i, 0], corners[i, 1]
                # Edges that regions share give the same x in both directions.
                if ay > by:
                    ax, ay, bx, by = bx, by, ax, ay
                slope = (bx - ax) / (by - ay)
                for r in range(spans[i, 0], spans[i, 1]):
                    x = ax + (middles[r] - ay) * slope
                    k = filled[r - low]
                    while k > offsets[r - low] and crossings[k - 1] > x:
                        crossings[k] = crossings[k - 1]
                        k -= 1
                    crossings[k] = x
                    filled[r - low] += 1
            before = i
    return low, offsets, crossings


@kernel
def _clipped(runs: Runs, masks: IntArray) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    regions = masks.shape[0]
    firsts = np.zeros(regions + 1, np.int64)
    room = 2 * runs.strip.shape[0] + 16
    strip, begin, end = np.empty(room, np.int64), np.empty(room), np.empty(room)
    n = 0
    for k in range(regions):
        mask = masks[k]
        at, stop = (runs.starts[mask], runs.starts[mask + 1]) if mask >= 0 else (0, 0)
        for i in range(runs.starts[k], runs.starts[k + 1] if mask > -2 else runs.starts[k]):
            while at < stop and (
                runs.strip[at] < runs.strip[i]
                or (runs.strip[at] == runs.strip[i] and runs.end[at] <= runs.begin[i])
            ):
                at += 1
            j = at
            while mask == -1 or (
                j < stop and runs.strip[j] == runs.strip[i] and runs.begin[j] < runs.end[i]
            ):
                if n == room:
                    room *= 2
                    strip = _longer(strip, room)
                    begin, end = _longer(begin, room), _longer(end, room)
                strip[n], begin[n], end[n] = runs.strip[i], runs.begin[i], runs.end[i]
                if mask >= 0:
                    begin[n] = max(begin[n], runs.begin[j])
                    end[n] = min(end[n], runs.end[j])
                n += 1
                j += 1
                if mask == -1:
                    break
        firsts[k + 1] = n
    return firsts, strip[:n].copy(), begin[:n].copy(), end[:n].copy()
