"""Boundaries of regions: chains of pieces, each tagged with why the region ends there."""

from __future__ import annotations

import math
from typing import Final

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
"""Largest distance between an arc and the chords that stand for it, which lie inside it."""

ARC_TOLERANCE: Final = 0.0025
"""The same as a share of the arc's radius, for short ranges."""


def arc_tolerance(radius_m: float) -> float:
    """How far chords may lie inside an arc, where nothing else is asked for."""
    return min(ARC_TOLERANCE_M, ARC_TOLERANCE * radius_m)


def arc_divisions(radius_m: float, arc_tolerance_m: float) -> int:
    """How many equal chords a full circle needs to lie within a tolerance of it."""
    if arc_tolerance_m >= radius_m:
        return 8
    return max(8, math.ceil(math.pi / math.acos(1.0 - arc_tolerance_m / radius_m)))


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
