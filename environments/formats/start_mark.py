"""Marked starts in images: a small square in free space, of a level used nowhere else."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from multisrt.environments.formats.row_blocks import row_blocks
from multisrt.geometry.numerics.kernel import BoolArray

MIN_SIDE: Final = 4
"""Minimum side of a mark in pixels; smaller spots are noise."""

MAX_SHARE: Final = 0.02
"""Maximum area of a mark, as a share of the image."""

MAX_LEVELS: Final = 8
"""Maximum number of levels of an image with a mark: one with more is a scan or a photograph."""


def marked_starts(
    levels: NDArray[np.uint32], free: BoolArray, resolution_m: float
) -> tuple[tuple[float, float], ...]:
    """Return the centre of the square that marks the start in an image, if there is one.

    A mark is a square of all pixels of one level, which are free, in an image of at most
    `MAX_LEVELS` levels. Its side is at least `MIN_SIDE` and its area at most `MAX_SHARE` of the
    image. It does not touch the border of the image. More than half of the pixels around it are
    free and of one level, which is more frequent than the mark's; the others are not free, as
    where it touches a wall. There is no start if several squares satisfy this.

    Parameters
    ----------
    levels : uint32 array, shape (rows, columns)
        Lightness of each pixel.
    free : bool array, shape (rows, columns)
        Whether a pixel is free.
    resolution_m : float
        Side of a pixel in metres.

    Returns
    -------
    tuple of (float, float)
        The centre of the mark in metres from the lower left corner of the image, y up; empty if
        there is no mark.

    Notes
    -----
    Source: the images of dungeons of ARiADNE and IR2 (Y. Cao et al., 2023; Tan et al., 2024),
    where 127 is wall, 195 is free and a square of 208 or 203 is where the robots start.

    Examples
    --------
    >>> levels = np.full((40, 60), 195, np.uint32)
    >>> levels[:, :5] = 127
    >>> levels[20:25, 30:35] = 208
    >>> marked_starts(levels, levels > 127, 0.1)
    ((3.25, 1.75),)
    """
    found = [
        mark for value in _few_values(levels) if (mark := _mark(levels, free, value)) is not None
    ]
    if len(found) != 1:
        return ()
    ((column, row),) = found
    return ((column * resolution_m, (len(levels) - row) * resolution_m),)


def _few_values(levels: NDArray[np.uint32]) -> list[int]:
    # Block by block, to stop early at a photograph, which has no mark.
    values: set[int] = set()
    for rows in row_blocks(levels.shape):
        values.update(np.unique(levels[rows]).tolist())
        if len(values) > MAX_LEVELS:
            return []
    return sorted(values)


def _mark(levels: NDArray[np.uint32], free: BoolArray, value: int) -> tuple[float, float] | None:
    # Column and row of the centre of the mark of a level, from the upper left corner.
    mask = levels == value
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, left, side = int(rows[0]), int(columns[0]), len(rows)
    bottom, right = top + side, left + side
    if not side >= MIN_SIDE or side**2 > MAX_SHARE * levels.size:
        return None
    if rows[-1] != bottom - 1 or len(columns) != side or columns[-1] != right - 1:
        return None
    if not mask[top:bottom, left:right].all():
        return None
    around = (slice(top - 1, bottom + 1), slice(left - 1, right + 1))
    if top == 0 or left == 0 or bottom == levels.shape[0] or right == levels.shape[1]:
        return None
    if not free[top:bottom, left:right].all():
        return None
    others = levels[around][free[around] & ~mask[around]]
    if 2 * len(others) <= 4 * (side + 1) or (others != others[0]).any():
        return None
    if np.count_nonzero(levels == others[0]) <= side**2:
        return None
    return (left + right) / 2, (top + bottom) / 2
