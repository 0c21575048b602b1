"""The border of a growing union of regions, computed once for every piece of it."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.arrays import (
    ByteArray,
    FloatArray,
    Int32Array,
    IntArray,
    grown,
    roomier,
)
from multisrt.geometry.numerics.kernel import inlined_kernel, kernel
from multisrt.geometry.numerics.rings import ABSENT, RingArrays, Rings, corners_of
from multisrt.geometry.regions.segment_difference import (
    MIN_REMAINDER_M,
    MIN_SEGMENT_M,
    Intervals,
    Remainders,
    add_remainders,
    crossings_with,
    shifted_line,
)

Window = tuple[float, float, float, float]

NEW: Final = 0
KEPT: Final = 1
GONE: Final = 2

ENOUGH: Final = 0
ROOM_FOR_COVERS: Final = 1
ROOM_IN_TABLE: Final = 2

NO_ROW: Final = -1
FREE: Final = -1
HASHES: Final = (1 << 31) - 1

MOST_EDGES: Final = 1 << 18
"""Number of edges of which is kept what is covered, unless more are asked for at once."""

SLACK_M: Final = 1e-5
"""Boxes of rings are widened by this length in metres, as edges are compared beside their rings."""


class UnionBorder:
    """The border of the union of rings, whose number may grow.

    It consists of the edges of the rings less what lies inside other rings. Each edge is compared
    once with each ring, when it is asked for: what all rings together cover of it is kept, and
    only those that have been added since are compared when it is asked for again. When the rings
    that were asked for have more than `MOST_EDGES` edges, all that was kept is dropped, and what
    is asked for from then on is compared anew.

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

    __slots__ = ("_covers", "_edges", "_first", "_held", "_known", "_rings", "_table")

    def __init__(self, rings: Rings) -> None:
        self._rings = rings
        self._begin()

    def _begin(self) -> None:
        # Begin anew, with nothing compared.
        # The row of the first edge of every ring; those that were never asked for have none.
        self._first: Int32Array = np.zeros(0, np.int32)
        self._held = 0
        self._edges = _Edges(
            compared=np.zeros(0, np.int32), state=np.zeros(0, np.uint8), last=np.zeros(0, np.int32)
        )
        self._covers = _Covers(
            span=np.zeros((256, 2)), before=np.zeros(256, np.int32), tally=np.zeros(2, np.int64)
        )
        # The edges that have been compared: the hash of the ends of each, its ring, and the number
        # of the corner there at which it ends.
        self._table: Int32Array = np.full((256, 3), FREE, np.int32)
        self._known = 0

    def within(self, indices: IntArray, window: Window) -> FloatArray:
        """Return the border of the union in a window.

        Parameters
        ----------
        indices : (k,) array of int
            The rings that have a part in the window, all of them.
        window : (x0, y0, x1, y1)
            In metres.

        Returns
        -------
        (b, 4) array
            Segments x0, y0, x1, y1 in metres, from edges with a part in the window, in the order
            of the rings and their edges, each once. Pieces shorter than 0.1 mm may be missing.
        """
        self._number(indices)
        others: IntArray = _rings_around(indices, self._rings.boxes, len(self._rings))
        rings = self._rings.arrays(others)
        lacks = self._compare(indices, others, window, rings)
        while lacks != ENOUGH:
            self._make_room(lacks)
            lacks = self._compare(indices, others, window, rings)
        pieces: FloatArray = _pieces(indices, window, rings, self._first, self._edges, self._covers)
        return pieces

    def _number(self, indices: IntArray) -> None:
        # Give rows to the edges of rings that have none.
        count = len(self._rings)
        if len(self._first) < count:
            held = len(self._first)
            self._first = grown(self._first, roomier(held, count))
            self._first[held:] = NO_ROW
        new = indices[self._first[indices] == NO_ROW]
        if not len(new):
            return
        sizes = self._rings.sizes[new]
        if self._held and self._held + int(sizes.sum()) > MOST_EDGES:
            self._begin()
            self._number(indices)
            return
        ends = self._held + np.cumsum(sizes)
        self._first[new] = ends - sizes
        self._held = int(ends[-1])
        if self._held > len(self._edges.state):
            edges, room = self._edges, roomier(len(self._edges.state), self._held)
            self._edges = _Edges(
                compared=grown(edges.compared, room),
                state=grown(edges.state, room),
                last=grown(edges.last, room),
            )

    def _compare(
        self, indices: IntArray, others: IntArray, window: Window, rings: RingArrays
    ) -> int:
        self._known, lacks = _compare(
            (indices, others, window, len(self._rings), self._first),
            rings,
            self._edges,
            self._covers,
            self._table,
            self._known,
        )
        return lacks

    def _make_room(self, lacks: int) -> None:
        if lacks == ROOM_FOR_COVERS:
            covers, held = self._covers, len(self._covers.before)
            room = roomier(held, held + 1)
            self._covers = covers._replace(
                span=grown(covers.span, room), before=grown(covers.before, room)
            )
        else:
            table: Int32Array = np.full((2 * len(self._table), 3), FREE, np.int32)
            _rehash(self._table, table)
            self._table = table


class _Edges(NamedTuple):
    # By the row of an edge: with how many rings it has been compared, `NEW`, `KEPT` or `GONE`, and
    # 1 + the row of the last interval of it that is covered.
    compared: Int32Array
    state: ByteArray
    last: Int32Array


class _Covers(NamedTuple):
    # Intervals of edges that lie in rings, apart from each other: where each begins and ends in
    # metres along the edge, and 1 + the row of the one before it. `tally` has the number of rows
    # that were ever used, and 1 + the first of those that are free again.
    span: FloatArray
    before: Int32Array
    tally: IntArray


@kernel
def _compare(
    asked: tuple[IntArray, IntArray, Window, int, Int32Array],
    rings: RingArrays,
    edges: _Edges,
    covers: _Covers,
    table: Int32Array,
    known: int,
) -> tuple[int, int]:
    # Compare edges in the window with the rings that they have not been compared with. Return the
    # number of edges in the table, and what there is not enough room for.
    indices, others, window, count, first = asked
    longest = 0
    for n in others:
        longest = max(longest, rings.spans[n, 1])
    crossings = np.empty(longest + 1)
    for k in indices:
        corners = corners_of(rings, k)
        px, py = corners[-1]
        for c in range(corners.shape[0]):
            qx, qy = corners[c]
            e = first[k] + c
            if (
                edges.state[e] != GONE
                and edges.compared[e] < count
                and _meets(px, py, qx, qy, window)
            ):
                if edges.state[e] == NEW:
                    if 2 * known >= table.shape[0]:
                        return known, ROOM_IN_TABLE
                    is_first = _enter(table, k, c, rings)
                    is_long = np.hypot(qx - px, qy - py) > MIN_SEGMENT_M
                    edges.state[e] = KEPT if is_first and is_long else GONE
                    known += is_first
                if edges.state[e] == KEPT:
                    ends = px, py, qx, qy
                    if not _cover(e, ends, rings, others, edges, covers, crossings):
                        return known, ROOM_FOR_COVERS
                    edges.compared[e] = count
            px, py = qx, qy
    return known, ENOUGH


@inlined_kernel
def _meets(px: float, py: float, qx: float, qy: float, window: Window) -> bool:
    x0, y0, x1, y1 = window
    return max(px, qx) >= x0 and min(px, qx) <= x1 and max(py, qy) >= y0 and min(py, qy) <= y1


@kernel
def _rings_around(indices: IntArray, boxes: FloatArray, count: int) -> IntArray:
    # The rings that may meet some rings, the last first.
    left, low, right, high = np.inf, np.inf, -np.inf, -np.inf
    for k in indices:
        left, low = min(left, boxes[k, 0]), min(low, boxes[k, 1])
        right, high = max(right, boxes[k, 2]), max(high, boxes[k, 3])
    left, low, right, high = left - SLACK_M, low - SLACK_M, right + SLACK_M, high + SLACK_M
    found = np.empty(count, np.int64)
    held = 0
    for n in range(count - 1, -1, -1):
        if (
            boxes[n, 0] <= right
            and boxes[n, 2] >= left
            and boxes[n, 1] <= high
            and boxes[n, 3] >= low
        ):
            found[held] = n
            held += 1
    return found[:held]


@kernel
def _cover(
    edge: int,
    ends: tuple[float, float, float, float],
    rings: RingArrays,
    others: IntArray,
    edges: _Edges,
    covers: _Covers,
    crossings: FloatArray,
) -> bool:
    # Note what rings cover of an edge, from the first on with which it has not been compared.
    # Return False, with nothing noted, if there is no room.
    x0, y0, x1, y1 = ends
    length = np.hypot(x1 - x0, y1 - y0)
    line = shifted_line(x0, y0, x1, y1, length)
    end_x, end_y = line.x + x1 - x0, line.y + y1 - y0
    left, right = min(line.x, end_x), max(line.x, end_x)
    low, high = min(line.y, end_y), max(line.y, end_y)
    covered, size = _covered(edge, edges, covers)
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
            if end > begin:
                if size == covered.low.shape[0]:
                    covered = _wider(covered)
                size = _unite(covered, size, begin, end)
        if size == 1 and covered.low[0] == 0.0 and covered.high[0] == line.length:
            break
    return _note(edge, length, covered, size, edges, covers)


@kernel
def _covered(edge: int, edges: _Edges, covers: _Covers) -> tuple[Intervals, int]:
    # The intervals of an edge that are covered, in their order, with room for more.
    size, interval = 0, edges.last[edge]
    while interval:
        size, interval = size + 1, covers.before[interval - 1]
    covered = Intervals(np.empty(2 * size + 8), np.empty(2 * size + 8))
    z, interval = size, edges.last[edge]
    while interval:
        z -= 1
        covered.low[z] = covers.span[interval - 1, 0]
        covered.high[z] = covers.span[interval - 1, 1]
        interval = covers.before[interval - 1]
    return covered, size


@kernel
def _wider(covered: Intervals) -> Intervals:
    size = covered.low.shape[0]
    wider = Intervals(np.empty(2 * size), np.empty(2 * size))
    wider.low[:size], wider.high[:size] = covered.low, covered.high
    return wider


@kernel
def _unite(covered: Intervals, count: int, begin: float, end: float) -> int:
    # Unite an interval with those that are sorted and apart; return their new number.
    low, high = covered.low, covered.high
    first = count
    while first > 0 and high[first - 1] >= begin:
        first -= 1
    last = first
    while last < count and low[last] <= end:
        last += 1
    # Intervals first to last, without the last one, meet the new one, which takes their place.
    if last > first:
        begin, end = min(begin, low[first]), max(end, high[last - 1])
        for z in range(last, count):
            low[z - last + first + 1], high[z - last + first + 1] = low[z], high[z]
    else:
        for z in range(count, first, -1):
            low[z], high[z] = low[z - 1], high[z - 1]
    low[first], high[first] = begin, end
    return count - (last - first) + 1


@kernel
def _note(
    edge: int, length: float, covered: Intervals, size: int, edges: _Edges, covers: _Covers
) -> bool:
    # Keep the intervals of an edge that are covered in place of those before, none if nothing is
    # left of it. Return False, with nothing changed, if there is no room.
    if _is_covered(covered, size, length):
        edges.state[edge] = GONE
        size = 0
    span, before, tally = covers.span, covers.before, covers.tally
    if tally[0] + size > before.shape[0]:
        return False
    interval = edges.last[edge]
    while interval:
        following = before[interval - 1]
        before[interval - 1] = tally[1]
        tally[1] = interval
        interval = following
    last = 0
    for z in range(size):
        if tally[1]:
            row = tally[1] - 1
            tally[1] = before[row]
        else:
            row = tally[0]
            tally[0] += 1
        span[row, 0], span[row, 1] = covered.low[z], covered.high[z]
        before[row] = last
        last = row + 1
    edges.last[edge] = last
    return True


@kernel
def _is_covered(covered: Intervals, size: int, length: float) -> bool:
    # Whether intervals leave nothing of an edge that counts.
    if size == 0:
        return False
    begin = 0.0
    for z in range(size):
        if covered.low[z] - begin > MIN_REMAINDER_M:
            return False
        begin = covered.high[z]
    return length - begin <= MIN_REMAINDER_M


@kernel
def _enter(table: Int32Array, ring: int, corner: int, rings: RingArrays) -> bool:
    # Enter an edge into a table with room for it; return whether none with its ends was there.
    px, py, qx, qy = _ends(ring, corner, rings)
    key = hash((px, py, qx, qy)) & HASHES
    i = key & (table.shape[0] - 1)
    while table[i, 0] != FREE:
        # The rings of edges that are equal meet, so that the corners of both are there.
        if table[i, 0] == key and rings.spans[table[i, 1], 0] != ABSENT:
            ax, ay, bx, by = _ends(table[i, 1], table[i, 2], rings)
            if ax == px and ay == py and bx == qx and by == qy:
                return False
        i = (i + 1) & (table.shape[0] - 1)
    table[i, 0], table[i, 1], table[i, 2] = key, ring, corner
    return True


@inlined_kernel
def _ends(ring: int, corner: int, rings: RingArrays) -> tuple[float, float, float, float]:
    # The ends of the edge of a ring that ends at one of its corners.
    corners = corners_of(rings, ring)
    px, py = corners[corner - 1]
    qx, qy = corners[corner]
    return px, py, qx, qy


@kernel
def _rehash(table: Int32Array, larger: Int32Array) -> None:
    for row in range(table.shape[0]):
        if table[row, 0] != FREE:
            i = table[row, 0] & (larger.shape[0] - 1)
            while larger[i, 0] != FREE:
                i = (i + 1) & (larger.shape[0] - 1)
            larger[i] = table[row]


@kernel
def _pieces(
    indices: IntArray,
    window: Window,
    rings: RingArrays,
    first: Int32Array,
    edges: _Edges,
    covers: _Covers,
) -> FloatArray:
    # What rings leave of the edges in the window.
    total = 0
    for k in indices:
        total += rings.spans[k, 1]
    segments, numbers = np.empty((total, 4)), np.empty(total, np.int64)
    count = 0
    for k in indices:
        corners = corners_of(rings, k)
        px, py = corners[-1]
        for c in range(corners.shape[0]):
            qx, qy = corners[c]
            e = first[k] + c
            if edges.state[e] == KEPT and _meets(px, py, qx, qy, window):
                segments[count, 0], segments[count, 1] = px, py
                segments[count, 2], segments[count, 3] = qx, qy
                numbers[count] = e
                count += 1
            px, py = qx, qy
    room = max(16, 2 * count)
    while True:
        found = Remainders(np.empty((room, 4)), np.empty(room, np.int64))
        kept = 0
        for i in range(count):
            covered, size = _covered(numbers[i], edges, covers)
            x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
            length = np.hypot(x1 - x0, y1 - y0)
            direction = (x1 - x0) / length, (y1 - y0) / length
            kept = add_remainders(segments, i, direction, 1.0, covered, size, found, kept)
        if kept <= room:
            return found.rest[:kept].copy()
        room = kept
