"""Outlines of regions with fewer corners, which keep what their edges are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from multisrt.geometry.numerics.kernel import FloatArray, IntArray


def simplified(
    outlines: Sequence[FloatArray], tags: Sequence[IntArray] | None, tolerance_m: float
) -> tuple[list[FloatArray], list[IntArray]]:
    """Return outlines with fewer corners.

    Parameters
    ----------
    outlines : sequence of (n, 2) array
        Corners of polygons in metres, not closed.
    tags : sequence of (n,) array of int or None
        A tag for the edge from each corner to the next. Corners between edges of different tags
        are kept; None for no tags.
    tolerance_m : float
        How far an outline may move, in metres.

    Returns
    -------
    outlines, tags : list of array
        Outlines of fewer than three corners become empty.

    Examples
    --------
    >>> square = np.array([[0, 0], [1, 0.001], [2, 0], [2, 2], [0, 2.0]])
    >>> kept, tags = simplified([square], [np.array([0, 0, 0, 1, 0])], 0.002)
    >>> kept[0].tolist(), tags[0].tolist()
    ([[2.0, 2.0], [0.0, 2.0], [0.0, 0.0], [2.0, 0.0]], [1, 0, 0, 0])
    """
    lines: list[FloatArray] = []
    of_line: list[int] = []
    tag_of_line: list[int] = []
    for number, outline in enumerate(outlines):
        if len(outline) < 3:
            continue
        of_edges = np.zeros(len(outline), np.int64) if tags is None else tags[number]
        for first, last in _stretches(of_edges):
            lines.append(np.take(outline, range(first, last + 1), axis=0, mode="wrap"))
            of_line.append(number)
            tag_of_line.append(int(of_edges[first]))
    if not lines:
        return [np.empty((0, 2))] * len(outlines), [np.empty(0, np.int64)] * len(outlines)
    along = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    made = shapely.simplify(shapely.linestrings(np.vstack(lines), indices=along), tolerance_m)
    corners, line = shapely.get_coordinates(made, return_index=True)
    # The last point of a line is the first one of the next.
    kept = np.append(line[1:] == line[:-1], False)
    corners, line = corners[kept], line[kept]
    borders = np.searchsorted(np.asarray(of_line)[line], np.arange(1, len(outlines)))
    kinds = np.asarray(tag_of_line)[line]
    return np.split(corners, borders), np.split(kinds, borders)


def _stretches(tags: IntArray) -> list[tuple[int, int]]:
    # First and last corner of each stretch of edges of one tag, beyond n where it wraps; an
    # outline of one tag is halved, as a line between equal ends would be simplified to nothing.
    n = len(tags)
    breaks = np.flatnonzero(tags != np.roll(tags, 1))
    if len(breaks) < 2:
        breaks = np.array([0, n // 2])
    return list(zip(breaks.tolist(), [*breaks[1:].tolist(), int(breaks[0]) + n], strict=True))
