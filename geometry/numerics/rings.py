"""Many rings, with a box around each, and arrays with the corners of those that are in use."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray, Int32Array, IntArray, grown, roomier
from multisrt.geometry.numerics.boxes import bounds_of, intersecting_boxes
from multisrt.geometry.numerics.kernel import inlined_kernel, kernel

STRETCH: Final = 32
"""Number of consecutive edges that share a box, which rules them out together."""

ROOM: Final = 1 << 17
"""Number of corners that are held in arrays, unless more are needed at once."""

ABSENT: Final = -1


class RingArrays(NamedTuple):
    """Rings as kernels take them; the arrays may have spare rows at their ends.

    Attributes
    ----------
    spans : (n, 3) array of int
        For each ring, the row of its first corner, `ABSENT` if its corners are not in the arrays;
        the number of its corners; and the row of its first stretch.
    corners : (c, 2) array
        The corners of rings in metres, each ring counter-clockwise.
    boxes : (n, 4) array
        x0, y0, x1, y1 of every ring in metres.
    stretches : (s, 4) array
        Boxes around each `STRETCH` edges of a ring.
    """

    spans: Int32Array
    corners: FloatArray
    boxes: FloatArray
    stretches: FloatArray


class Rings:
    """A growing sequence of rings.

    The rings are held as they were given, so that several sequences share those that they have in
    common. Kernels take arrays with the corners of the rings that are asked for together; those
    of others stay there as long as there is room.

    Parameters
    ----------
    rings : iterable of (m, 2) arrays
        The first rings in metres, each counter-clockwise.

    Examples
    --------
    >>> rings = Rings([np.array([(0.0, 0.0), (2.0, 0.0), (0.0, 1.0)])])
    >>> rings.add(np.array([(5.0, 5.0), (6.0, 5.0), (6.0, 6.0)]))
    1
    >>> rings.ring(0).tolist()
    [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]]
    >>> rings.boxes[1].tolist()
    [5.0, 5.0, 6.0, 6.0]
    >>> arrays = rings.arrays(np.array([1]))
    >>> first, count, _ = arrays.spans[1].tolist()
    >>> arrays.corners[first : first + count].tolist()
    [[5.0, 5.0], [6.0, 5.0], [6.0, 6.0]]
    """

    __slots__ = ("_arrays", "_corners", "_rings", "_stretches")

    def __init__(self, rings: Iterable[FloatArray] = ()) -> None:
        self._rings: list[FloatArray] = []
        self._arrays = RingArrays(
            spans=np.empty((0, 3), np.int32),
            corners=np.empty((0, 2)),
            boxes=np.empty((0, 4)),
            stretches=np.empty((0, 4)),
        )
        # Rows of corners and of stretches that are taken.
        self._corners = self._stretches = 0
        for ring in rings:
            self.add(ring)

    def __len__(self) -> int:
        return len(self._rings)

    @property
    def boxes(self) -> FloatArray:
        """The boxes of all rings, ``(n, 4)``; there may be spare rows at the end."""
        return self._arrays.boxes

    @property
    def sizes(self) -> Int32Array:
        """The numbers of corners of all rings; there may be spare rows at the end."""
        return self._arrays.spans[:, 1]

    def add(self, ring: FloatArray) -> int:
        """Add a ring, ``(m, 2)`` counter-clockwise, which must not change, and return its index."""
        index, held = len(self._rings), self._arrays
        if index == len(held.boxes):
            self._make_room(roomier(index, index + 1), len(held.corners))
        ring = np.ascontiguousarray(ring, np.float64)
        self._rings.append(ring)
        self._arrays.spans[index] = ABSENT, len(ring), ABSENT
        self._arrays.boxes[index] = bounds_of(ring)
        return index

    def ring(self, index: int) -> FloatArray:
        """Return the corners of a ring, ``(m, 2)``."""
        return self._rings[index]

    def meeting(
        self, indices: IntArray, box: tuple[float, float, float, float], apart_m: float = 0.0
    ) -> IntArray:
        """Return those of some rings whose boxes are at most `apart_m` from another box.

        Parameters
        ----------
        indices : (k,) array of int
            The rings.
        box : (x0, y0, x1, y1)
            The other box, in metres.
        apart_m : float
            In metres.

        Returns
        -------
        (m,) array of int
            In their order.
        """
        found = np.empty_like(indices)
        slacks = np.full(len(indices), apart_m)
        return indices[found[: intersecting_boxes(self.boxes[indices], slacks, box, found)]]

    def arrays(self, indices: IntArray) -> RingArrays:
        """Return all rings as kernels take them, with the corners of some.

        Parameters
        ----------
        indices : (k,) array of int
            The rings whose corners are needed, each once.

        Returns
        -------
        RingArrays
            Valid until corners of other rings are asked for, or a ring is added.
        """
        missing = indices[self._arrays.spans[indices, 0] == ABSENT]
        if len(missing):
            for index in self._lacking(missing, indices).tolist():
                self._corners, self._stretches = _load(
                    index, self._rings[index], self._arrays, self._corners, self._stretches
                )
        return self._arrays

    def _lacking(self, missing: IntArray, indices: IntArray) -> IntArray:
        # Make room for the corners of the missing rings among some, and return those to be
        # written: all of them if those of other rings had to be dropped.
        held = self._arrays
        corners = self._corners + int(self.sizes[missing].sum())
        if corners > ROOM:
            missing, corners = indices, max(ROOM, int(self.sizes[indices].sum()))
            self._corners = self._stretches = 0
            held.spans[:, 0] = ABSENT
            if corners != len(held.corners):
                self._arrays = held._replace(corners=held.corners[:0])
                self._make_room(len(held.boxes), corners)
        elif corners > len(held.corners):
            self._make_room(len(held.boxes), min(roomier(len(held.corners), corners), ROOM))
        return missing

    def _make_room(self, count: int, corners: int) -> None:
        held = self._arrays
        # No ring has more stretches than whole ones and one that ends with it.
        stretches = max(len(held.stretches), corners // STRETCH + count)
        self._arrays = RingArrays(
            spans=grown(held.spans, count),
            corners=grown(held.corners, corners),
            boxes=grown(held.boxes, count),
            stretches=grown(held.stretches, stretches),
        )


@inlined_kernel
def corners_of(rings: RingArrays, index: int) -> FloatArray:
    """Return the corners of a ring that are in the arrays."""
    first = rings.spans[index, 0]
    return rings.corners[first : first + rings.spans[index, 1]]


@kernel
def _load(
    index: int, ring: FloatArray, arrays: RingArrays, corner: int, stretch: int
) -> tuple[int, int]:
    # Write a ring's corners and the boxes of its stretches from given rows on, and return the rows
    # behind them. The edges of a stretch are those that end at its corners: the first of them
    # begins at the corner before.
    spans, corners, _, stretches = arrays
    spans[index, 0], spans[index, 2] = corner, stretch
    before = ring.shape[0] - 1
    for first in range(0, ring.shape[0], STRETCH):
        x0 = x1 = ring[before, 0]
        y0 = y1 = ring[before, 1]
        for c in range(first, min(first + STRETCH, ring.shape[0])):
            x, y = ring[c, 0], ring[c, 1]
            corners[corner, 0], corners[corner, 1] = x, y
            x0, x1 = min(x0, x), max(x1, x)
            y0, y1 = min(y0, y), max(y1, y)
            corner += 1
            before = c
        stretches[stretch, 0], stretches[stretch, 1] = x0, y0
        stretches[stretch, 2], stretches[stretch, 3] = x1, y1
        stretch += 1
    return corner, stretch
