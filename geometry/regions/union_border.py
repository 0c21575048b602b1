"""The border of a growing union of regions, computed once for every piece of it."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.arrays import (
    BoolArray,
    ByteArray,
    FloatArray,
    Int32Array,
    IntArray,
    grown,
)
from multisrt.geometry.numerics.kernel import inlined_kernel, kernel
from multisrt.geometry.numerics.rings import RingArrays, Rings
from multisrt.geometry.regions.segment_difference import (
    MIN_SEGMENT_M,
    Intervals,
    Remainders,
    add_remainders,
    crossings_with,
    insert_interval,
    shifted_line,
)

Window = tuple[float, float, float, float]

NEW: Final = 0
KEPT: Final = 1
GONE: Final = 2

ENOUGH: Final = 0
ROOM_FOR_COVERS: Final = 1
ROOM_IN_TABLE: Final = 2

SLACK_M: Final = 1e-5
"""Boxes of rings are widened by this length in metres, as edges are compared beside their rings."""


class UnionBorder:
    """The border of the union of rings, whose number may grow.

    It consists of the edges of the rings less what lies inside other rings. Each edge is compared
    once with each ring: what rings cover of it is kept, and only the rings that have been added
    since are compared when it is asked for again.

    Parameters
    ----------
    rings : Rings
        The rings. Those that are there never change.

    Examples
    --------
    >>> room = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> rings = Rings([room])
    >>> border = UnionBorder(rings)
    >>> len(border.within(np.array([0]), (-9.0, -9.0, 9.0, 9.0)))
    4
    >>> index = rings.add(room + [1.0, 0.0])
    >>> len(border.within(np.array([0, 1]), (-9.0, -9.0, 9.0, 9.0)))
    6
    """

    __slots__ = ("_covers", "_edges", "_known", "_rings", "_table", "_used")

    def __init__(self, rings: Rings) -> None:
        self._rings = rings
        self._edges = _Edges(
            compared=np.zeros(0, np.int32), state=np.zeros(0, np.uint8), last=np.zeros(0, np.int32)
        )
        self._covers = _Covers(
            ring=np.zeros(256, np.int32), span=np.zeros((256, 2)), before=np.zeros(256, np.int32)
        )
        self._used = 0
        # The ends of the edges that have been compared, by their hash.
        self._table: FloatArray = np.full((256, 4), np.nan)
        self._known = 0

    def within(self, indices: IntArray, window: Window) -> FloatArray:
        """Return the border of the union of some rings in a window.

        Parameters
        ----------
        indices : (k,) array of int
            The rings: all that have a part in the window.
        window : (x0, y0, x1, y1)
            In metres.

        Returns
        -------
        (b, 4) array
            Segments x0, y0, x1, y1 in metres with a part in the window, in the order of the rings
            and their edges, each once. Pieces shorter than 0.1 mm may be missing.
        """
        arrays, held = self._rings.arrays, len(self._edges.state)
        if held < len(arrays.corners):
            edges, room = self._edges, len(arrays.corners)
            self._edges = _Edges(
                compared=grown(edges.compared, room),
                state=grown(edges.state, room),
                last=grown(edges.last, room),
            )
        lacks = self._compare(indices, window)
        while lacks != ENOUGH:
            self._make_room(lacks)
            lacks = self._compare(indices, window)
        is_one = np.zeros(len(self._rings), np.bool_)
        is_one[indices] = True
        pieces: FloatArray = _pieces(indices, window, arrays, self._edges, self._covers, is_one)
        return pieces

    def _compare(self, indices: IntArray, window: Window) -> int:
        self._used, self._known, lacks = _compare(
            (indices, window, self._rings.arrays, len(self._rings)),
            self._edges,
            self._covers,
            self._used,
            self._table,
            self._known,
        )
        return lacks

    def _make_room(self, lacks: int) -> None:
        if lacks == ROOM_FOR_COVERS:
            covers, room = self._covers, 2 * len(self._covers.ring)
            self._covers = _Covers(
                ring=grown(covers.ring, room),
                span=grown(covers.span, room),
                before=grown(covers.before, room),
            )
        else:
            table = np.full((2 * len(self._table), 4), np.nan)
            _rehash(self._table, table)
            self._table = table


class _Edges(NamedTuple):
    # By the index of the corner at which an edge ends: with how many rings it has been compared,
    # `NEW`, `KEPT` or `GONE`, and 1 + the number of the last interval that was noted.
    compared: Int32Array
    state: ByteArray
    last: Int32Array


class _Covers(NamedTuple):
    # Intervals of edges that lie in rings: the ring, where it begins and ends in metres along the
    # edge, and 1 + the number of the interval of the edge that was noted before.
    ring: Int32Array
    span: FloatArray
    before: Int32Array


@kernel
def _compare(
    asked: tuple[IntArray, Window, RingArrays, int],
    edges: _Edges,
    covers: _Covers,
    used: int,
    table: FloatArray,
    known: int,
) -> tuple[int, int, int]:
    # Compare edges in the window with the rings that they have not been compared with. Return the
    # number of intervals and of edges in the table, and what there is not enough room for.
    indices, window, rings, count = asked
    starts, corners = rings.starts, rings.corners
    others, longest = _rings_around(indices, rings, count)
    crossings = np.empty(longest + 1)
    for k in indices:
        px, py = corners[starts[k + 1] - 1]
        for c in range(starts[k], starts[k + 1]):
            qx, qy = corners[c]
            if (
                edges.state[c] != GONE
                and edges.compared[c] < count
                and _meets(px, py, qx, qy, window)
            ):
                if edges.state[c] == NEW:
                    if 2 * known >= table.shape[0]:
                        return used, known, ROOM_IN_TABLE
                    is_first = _enter(table, px, py, qx, qy)
                    is_long = np.hypot(qx - px, qy - py) > MIN_SEGMENT_M
                    edges.state[c] = KEPT if is_first and is_long else GONE
                    known += is_first
                if edges.state[c] == KEPT:
                    ends = px, py, qx, qy
                    used_now = _cover(c, ends, rings, others, edges, covers, used, crossings)
                    if used_now < 0:
                        return used, known, ROOM_FOR_COVERS
                    used = used_now
                    edges.compared[c] = count
            px, py = qx, qy
    return used, known, ENOUGH


@inlined_kernel
def _meets(px: float, py: float, qx: float, qy: float, window: Window) -> bool:
    x0, y0, x1, y1 = window
    return max(px, qx) >= x0 and min(px, qx) <= x1 and max(py, qy) >= y0 and min(py, qy) <= y1


@kernel
def _rings_around(indices: IntArray, rings: RingArrays, count: int) -> tuple[IntArray, int]:
    # The rings that may meet some rings, the last first, and the most corners that one has.
    boxes = rings.boxes
    left, low, right, high = np.inf, np.inf, -np.inf, -np.inf
    for k in indices:
        left, low = min(left, boxes[k, 0]), min(low, boxes[k, 1])
        right, high = max(right, boxes[k, 2]), max(high, boxes[k, 3])
    left, low, right, high = left - SLACK_M, low - SLACK_M, right + SLACK_M, high + SLACK_M
    found = np.empty(count, np.int64)
    held, longest = 0, 0
    for n in range(count - 1, -1, -1):
        if (
            boxes[n, 0] <= right
            and boxes[n, 2] >= left
            and boxes[n, 1] <= high
            and boxes[n, 3] >= low
        ):
            found[held] = n
            held += 1
            longest = max(longest, rings.starts[n + 1] - rings.starts[n])
    return found[:held], longest


@kernel
def _cover(
    edge: int,
    ends: tuple[float, float, float, float],
    rings: RingArrays,
    others: IntArray,
    edges: _Edges,
    covers: _Covers,
    used: int,
    crossings: FloatArray,
) -> int:
    # Note what rings cover of an edge, from the first on with which it has not been compared.
    # Return the number of intervals then; -1, with nothing noted, if there is no room.
    x0, y0, x1, y1 = ends
    line = shifted_line(x0, y0, x1, y1, np.hypot(x1 - x0, y1 - y0))
    end_x, end_y = line.x + x1 - x0, line.y + y1 - y0
    left, right = min(line.x, end_x), max(line.x, end_x)
    low, high = min(line.y, end_y), max(line.y, end_y)
    last, free = edges.last[edge], used
    for n in others:
        if n < edges.compared[edge]:
            break
        if (
            rings.boxes[n, 0] > right
            or rings.boxes[n, 2] < left
            or rings.boxes[n, 1] > high
            or rings.boxes[n, 3] < low
        ):
            continue
        crossed = crossings_with(line, rings, n, crossings)
        # Between the first and the second crossing the line is inside, and so on.
        for z in range(0, crossed - 1, 2):
            begin, end = max(0.0, crossings[z]), min(line.length, crossings[z + 1])
            if begin == 0.0 and end == line.length:
                edges.state[edge] = GONE
                return used
            if end > begin:
                if free == covers.ring.shape[0]:
                    return -1
                covers.ring[free], covers.before[free] = n, last
                covers.span[free, 0], covers.span[free, 1] = begin, end
                free += 1
                last = free
    edges.last[edge] = last
    return free


@kernel
def _enter(table: FloatArray, px: float, py: float, qx: float, qy: float) -> bool:
    # Enter an edge into a table with room for it; return whether it was not there.
    mask = table.shape[0] - 1
    i = hash((px, py, qx, qy)) & mask
    while not np.isnan(table[i, 0]):
        if table[i, 0] == px and table[i, 1] == py and table[i, 2] == qx and table[i, 3] == qy:
            return False
        i = (i + 1) & mask
    table[i, 0], table[i, 1], table[i, 2], table[i, 3] = px, py, qx, qy
    return True


@kernel
def _rehash(table: FloatArray, larger: FloatArray) -> None:
    for px, py, qx, qy in table:
        if not np.isnan(px):
            _enter(larger, px, py, qx, qy)


@kernel
def _pieces(
    indices: IntArray,
    window: Window,
    rings: RingArrays,
    edges: _Edges,
    covers: _Covers,
    is_one: BoolArray,
) -> FloatArray:
    # What the rings that are asked for leave of the edges in the window.
    starts, corners = rings.starts, rings.corners
    total = 0
    for k in indices:
        total += starts[k + 1] - starts[k]
    segments, numbers = np.empty((total, 4)), np.empty(total, np.int64)
    count, most = 0, 0
    for k in indices:
        px, py = corners[starts[k + 1] - 1]
        for c in range(starts[k], starts[k + 1]):
            qx, qy = corners[c]
            if edges.state[c] == KEPT and _meets(px, py, qx, qy, window):
                segments[count, 0], segments[count, 1] = px, py
                segments[count, 2], segments[count, 3] = qx, qy
                numbers[count] = c
                count += 1
                size, interval = 0, edges.last[c]
                while interval:
                    size, interval = size + 1, covers.before[interval - 1]
                most = max(most, size)
            px, py = qx, qy
    covered = Intervals(np.empty(most), np.empty(most))
    room = max(16, 2 * count)
    while True:
        found = Remainders(np.empty((room, 4)), np.empty(room, np.int64))
        kept = 0
        for i in range(count):
            size, interval = 0, edges.last[numbers[i]]
            while interval:
                if is_one[covers.ring[interval - 1]]:
                    begin, end = covers.span[interval - 1, 0], covers.span[interval - 1, 1]
                    size = insert_interval(covered, size, begin, end)
                interval = covers.before[interval - 1]
            x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
            length = np.hypot(x1 - x0, y1 - y0)
            direction = (x1 - x0) / length, (y1 - y0) / length
            kept = add_remainders(segments, i, direction, 1.0, covered, size, found, kept)
        if kept <= room:
            return found.rest[:kept].copy()
        room = kept
