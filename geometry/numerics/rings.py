"""Many rings in a few growing arrays, with a box around each ring and each of its stretches."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray, IntArray, grown, roomier
from multisrt.geometry.numerics.kernel import kernel

STRETCH: Final = 32
"""Number of consecutive edges that share a box, which rules them out together."""


class RingArrays(NamedTuple):
    """Rings as kernels take them; the arrays may have spare rows at their ends.

    Attributes
    ----------
    starts : (n + 1,) array of int
        Ring k has the corners ``corners[starts[k]:starts[k + 1]]``.
    corners : (c, 2) array
        The corners of all rings in metres, each ring counter-clockwise.
    boxes : (n, 4) array
        x0, y0, x1, y1 of every ring in metres.
    stretches : (s, 4) array
        Boxes around each `STRETCH` edges of a ring, from row `first_stretch` on.
    """

    starts: IntArray
    corners: FloatArray
    boxes: FloatArray
    stretches: FloatArray


class Rings:
    """A growing sequence of rings.

    Parameters
    ----------
    rings : iterable of (m, 2) arrays
        The first rings in metres, each counter-clockwise.

    Attributes
    ----------
    arrays : RingArrays
        All rings. Adding one changes nothing of those that are there.

    Examples
    --------
    >>> rings = Rings([np.array([(0.0, 0.0), (2.0, 0.0), (0.0, 1.0)])])
    >>> rings.add(np.array([(5.0, 5.0), (6.0, 5.0), (6.0, 6.0)]))
    1
    >>> rings.ring(0).tolist()
    [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]]
    >>> rings.arrays.boxes[1].tolist()
    [5.0, 5.0, 6.0, 6.0]
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
        """Add a ring, ``(m, 2)`` counter-clockwise, and return its index."""
        index, last = self._count, self._end + len(ring)
        if index == len(self.arrays.boxes) or last > len(self.arrays.corners):
            self._make_room(last)
        _add(index, ring, self.arrays)
        self._count, self._end = index + 1, last
        return index

    def ring(self, index: int) -> FloatArray:
        """Return the corners of a ring, ``(m, 2)``, as a view."""
        first, last = self.arrays.starts[index : index + 2].tolist()
        return self.arrays.corners[first:last]

    def _make_room(self, corners: int) -> None:
        held = self.arrays
        count, room = len(held.boxes), len(held.corners)
        if self._count == count:
            count = roomier(count, count + 1)
        if corners > room:
            room = roomier(room, corners)
        self.arrays = RingArrays(
            starts=grown(held.starts, count + 1),
            corners=grown(held.corners, room),
            boxes=grown(held.boxes, count),
            stretches=grown(held.stretches, room // STRETCH + count),
        )


@kernel
def first_stretch(index: int, start: int) -> int:
    """Return the row of a ring's first stretch.

    Parameters
    ----------
    index : int
        Index of the ring.
    start : int
        Index of its first corner.
    """
    # No ring needs more rows than lie between this and the first of the next ring.
    return start // STRETCH + index


@kernel
def _add(
    index: int,
    ring: FloatArray,
    arrays: RingArrays,
) -> None:
    # Write a ring's corners, its box and those of its stretches. The edges of a stretch are
    # those that end at its corners: the first of them begins at the corner before.
    starts, corners, boxes, stretches = arrays
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
