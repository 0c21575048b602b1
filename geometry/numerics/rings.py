"""Many rings in few growing arrays, with boxes around each and around its stretches."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.arrays import grown
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel

STRETCH: Final = 32
"""So many edges on end have a box around them: what lies off the box is off all of them."""


class RingArrays(NamedTuple):
    """Rings as kernels take them; there may be room for more behind the last.

    Attributes
    ----------
    starts : (n + 1,) array of int
        Ring k has the corners ``corners[starts[k]:starts[k + 1]]``.
    corners : (c, 2) array
        The corners of all, in metres, each ring counter-clockwise.
    boxes : (n, 4) array
        x0, y0, x1, y1 of every ring.
    stretches : (s, 4) array
        The boxes of every ring's stretches, from `first_stretch` on.
    """

    starts: IntArray
    corners: FloatArray
    boxes: FloatArray
    stretches: FloatArray


class Rings:
    """Rings to which others can be added.

    Parameters
    ----------
    rings : iterable of (m, 2) arrays
        The first, each counter-clockwise.

    Attributes
    ----------
    arrays : RingArrays
        All of them. Rings that are added change none of those that are there.
    """

    __slots__ = ("_count", "_end", "arrays")

    def __init__(self, rings: Iterable[FloatArray] = ()) -> None:
        self.arrays = RingArrays(
            starts=np.zeros(1, np.int64),
            corners=np.empty((4096, 2)),
            boxes=np.empty((0, 4)),
            stretches=np.empty((0, 4)),
        )
        self._count = self._end = 0
        for ring in rings:
            self.add(ring)

    def __len__(self) -> int:
        return self._count

    def add(self, ring: FloatArray) -> int:
        """Add a ring and give its index."""
        index, last = self._count, self._end + len(ring)
        if index == len(self.arrays.boxes) or last > len(self.arrays.corners):
            self._make_room(last)
        _add(index, ring, *self.arrays)
        self._count, self._end = index + 1, last
        return index

    def ring(self, index: int) -> FloatArray:
        """Give a ring's corners, (m, 2)."""
        first, last = self.arrays.starts[index : index + 2].tolist()
        return self.arrays.corners[first:last]

    def _make_room(self, corners: int) -> None:
        held = self.arrays
        count, most = len(held.boxes), len(held.corners)
        if self._count == count:
            count = max(64, 2 * count)
        if corners > most:
            most = max(corners, 2 * most)
        self.arrays = RingArrays(
            starts=grown(held.starts, count + 1),
            corners=grown(held.corners, most),
            boxes=grown(held.boxes, count),
            stretches=grown(held.stretches, most // STRETCH + count),
        )


@kernel
def first_stretch(index: int, start: int) -> int:
    """Give the row of a ring's first stretch.

    Parameters
    ----------
    index : int
        Which ring.
    start : int
        Its first corner.
    """
    # No ring needs more rows than there are until the next one's first.
    return start // STRETCH + index


@kernel
def _add(
    index: int,
    ring: FloatArray,
    starts: IntArray,
    corners: FloatArray,
    boxes: FloatArray,
    stretches: FloatArray,
) -> None:
    # Writes a ring's corners, its box and those of its stretches. The edges of a stretch are
    # those that end at its corners: the first of them begins at the corner before.
    start = starts[index]
    stop = start + ring.shape[0]
    starts[index + 1] = stop
    for c in range(ring.shape[0]):
        corners[start + c, 0], corners[start + c, 1] = ring[c, 0], ring[c, 1]
    row = first_stretch(index, start)
    low_x, low_y, high_x, high_y = np.inf, np.inf, -np.inf, -np.inf
    before = stop - 1
    for first in range(start, stop, STRETCH):
        x0 = x1 = corners[before, 0]
        y0 = y1 = corners[before, 1]
        for c in range(first, min(first + STRETCH, stop)):
            x0, x1 = min(x0, corners[c, 0]), max(x1, corners[c, 0])
            y0, y1 = min(y0, corners[c, 1]), max(y1, corners[c, 1])
            before = c
        stretches[row, 0], stretches[row, 1] = x0, y0
        stretches[row, 2], stretches[row, 3] = x1, y1
        row += 1
        low_x, high_x = min(low_x, x0), max(high_x, x1)
        low_y, high_y = min(low_y, y0), max(high_y, y1)
    boxes[index, 0], boxes[index, 1] = low_x, low_y
    boxes[index, 2], boxes[index, 3] = high_x, high_y
