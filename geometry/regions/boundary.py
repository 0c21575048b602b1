"""Boundaries of regions: chains of pieces, each tagged with why the region ends there."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.numerics.kernel import FloatArray, kernel

OBSTACLE: Final = 0
"""Tag of a boundary piece where a surface was hit."""
RANGE: Final = 1
"""Tag of a boundary piece where nothing was hit within the range."""
GAP: Final = 2
"""Tag of a radial piece: the space behind a corner was not seen."""
CUT: Final = 3
"""Tag of a boundary piece inside space that the readings show to be free."""

TagArray = NDArray[np.int8]

ARC_TOLERANCE_M: Final = 0.01
"""Maximum distance in metres between an arc and its chords, which lie inside it."""

ARC_TOLERANCE: Final = 0.0025
"""Maximum distance between an arc and its chords as a share of the radius, for short ranges."""

MIN_PIECE_M: Final = 1e-9
"""Boundary pieces of at most this length in metres are rounding."""


class Chain(NamedTuple):
    """A boundary that is being written: room for corners, and for the piece behind each.

    Attributes
    ----------
    corners : (n, 2) array
        x and y in metres, counter-clockwise.
    tags : (n,) array of int8
        Tag of the piece from corner i to the next.
    """

    corners: FloatArray
    tags: TagArray


def arc_tolerance(radius_m: float) -> float:
    """Return the default distance in metres between an arc and its chords.

    Examples
    --------
    >>> arc_tolerance(2.0), arc_tolerance(10.0)
    (0.005, 0.01)
    """
    return min(ARC_TOLERANCE_M, ARC_TOLERANCE * radius_m)


def arc_divisions(radius_m: float, arc_tolerance_m: float) -> int:
    """Return the number of equal chords, at least 8, that lie within a tolerance of a circle.

    Parameters
    ----------
    radius_m : float
        Radius of the circle in metres.
    arc_tolerance_m : float
        Maximum distance in metres between the circle and its chords, which lie inside it.

    Examples
    --------
    >>> arc_divisions(4.0, 0.01)
    45
    """
    if arc_tolerance_m >= radius_m:
        return 8
    return max(8, math.ceil(math.pi / math.acos(1.0 - arc_tolerance_m / radius_m)))


@kernel
def add_open_piece(
    chain: Chain,
    count: int,
    start: tuple[float, float],
    end: tuple[float, float],
    walls: FloatArray,
    sides: tuple[float, float],
    open_tag: int,
) -> int:
    """Write a straight piece of a boundary, tagged as obstacle where it runs along walls.

    Parameters
    ----------
    chain : Chain
        What is written to, from row `count` on: at most two rows for every wall, and one.
    count : int
        Number of corners in the chain.
    start, end : (x, y)
        Ends of the piece in metres; the corner at its end is not written.
    walls : (k, 4) array
        Segments x0, y0, x1, y1 in metres.
    sides : (right, left)
        Maximum distances in metres of a wall to the right and to the left of the piece.
    open_tag : int
        Tag of the stretches without a wall; those with one are `OBSTACLE`.

    Returns
    -------
    int
        The new number of corners.
    """
    x, y = start
    length = np.hypot(end[0] - x, end[1] - y)
    if length <= MIN_PIECE_M:
        return count
    ux, uy = (end[0] - x) / length, (end[1] - y) / length
    lows, highs = _stretches_along(x, y, ux, uy, length, walls, sides)
    begin = 0.0
    while length - begin > MIN_PIECE_M:
        low, high = length, length
        for k in range(walls.shape[0]):
            if highs[k] - max(lows[k], begin) > MIN_PIECE_M and max(lows[k], begin) < low:
                low, high = max(lows[k], begin), highs[k]
        if low - begin > MIN_PIECE_M:
            chain.corners[count, 0], chain.corners[count, 1] = x + ux * begin, y + uy * begin
            chain.tags[count] = open_tag
            count += 1
        else:
            low = begin
        if high > low:
            chain.corners[count, 0], chain.corners[count, 1] = x + ux * low, y + uy * low
            chain.tags[count] = OBSTACLE
            count += 1
        begin = high
    return count


@kernel
def _stretches_along(
    x: float,
    y: float,
    ux: float,
    uy: float,
    length: float,
    walls: FloatArray,
    sides: tuple[float, float],
) -> tuple[FloatArray, FloatArray]:
    # Where each wall begins and ends along a piece; the begin lies behind the end for a wall
    # that is too far off.
    right, left = sides
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
    return lows, highs
