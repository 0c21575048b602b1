"""Pieces of segments: what is left of each after several takings, in whatever order these come.

A piece is kept with the whole segment that it is of. Every taking is worked out on the whole
segment, and pieces keep what all takings leave: so the order of the takings makes no difference,
not even in rounding.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from multisrt.geometry.numerics.arrays import grown
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel
from multisrt.geometry.numerics.rings import RingArrays
from multisrt.geometry.regions.boundary import TagArray
from multisrt.geometry.regions.frontier_arcs import (
    OUTWARD_M,
    SHORTEST_ARC_M,
    SHORTEST_CUT_M,
    arc_ends,
    arc_labels,
    joined_lengths,
    pieces_by_owner,
    pieces_tagged,
    uncovered,
)
from multisrt.geometry.regions.safe_region import LocalSafeRegion

ONE_BORDER_M: Final = 0.5 * OUTWARD_M
"""Borders of two regions within this of each other are one. Further apart than twice this, the
region of the outer one takes the inner one away."""

APART_M: Final = 2.0 * OUTWARD_M
"""Regions whose boxes are further apart than this take nothing from each other."""

LEAST_OVERLAP_M: Final = 1e-5
"""Segments that lie along each other for less than this only touch or cross."""


@kernel
def apart_from(
    segments: FloatArray, concerned: BoolArray, lines: FloatArray, tolerance_m: float
) -> tuple[FloatArray, IntArray]:
    """Take from segments what lies along other segments, whichever way these go.

    Parameters
    ----------
    segments : (m, 4) array
        x0, y0, x1, y1 in metres.
    concerned : (m,) array of bool
        From which segments is taken; the others are left whole.
    lines : (n, 4) array
        What takes from them.
    tolerance_m : float
        They lie along each other where they are no further apart than this.

    Returns
    -------
    rest : (r, 4) array
        What is left, in the order of the segments. Remains of at most `SHORTEST_CUT_M` are not.
    source : (r,) array
        Which segment each rest is of.
    """
    low, high = np.empty(lines.shape[0]), np.empty(lines.shape[0])
    room = max(16, 2 * segments.shape[0])
    while True:
        rest, source = np.empty((room, 4)), np.empty(room, np.int64)
        count = _apart_from(segments, concerned, lines, tolerance_m, low, high, rest, source)
        if count <= room:
            return rest[:count].copy(), source[:count].copy()
        room = count


@kernel
def _apart_from(
    segments: FloatArray,
    concerned: BoolArray,
    lines: FloatArray,
    tolerance_m: float,
    low: FloatArray,
    high: FloatArray,
    rest: FloatArray,
    source: IntArray,
) -> int:
    # Writes what is left of segments, as far as there is room. Tells how much is left. Low and
    # high are room to work in.
    kept = 0
    for i in range(segments.shape[0]):
        x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
        length = np.hypot(x1 - x0, y1 - y0)
        count = 0
        if concerned[i] and length > 0.0:
            ux, uy = (x1 - x0) / length, (y1 - y0) / length
            left, right = min(x0, x1) - tolerance_m, max(x0, x1) + tolerance_m
            bottom, top = min(y0, y1) - tolerance_m, max(y0, y1) + tolerance_m
            for k in range(lines.shape[0]):
                px, py, qx, qy = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
                if (
                    max(px, qx) < left
                    or min(px, qx) > right
                    or max(py, qy) < bottom
                    or min(py, qy) > top
                ):
                    continue
                # Along the segment and off it; then the part beside it, and how far off that is.
                a, b = ux * (px - x0) + uy * (py - y0), ux * (qx - x0) + uy * (qy - y0)
                off_a, off_b = ux * (py - y0) - uy * (px - x0), ux * (qy - y0) - uy * (qx - x0)
                if a > b:
                    a, b, off_a, off_b = b, a, off_b, off_a
                begin, end = max(0.0, a), min(length, b)
                if end - begin < LEAST_OVERLAP_M:
                    continue
                slope = (off_b - off_a) / (b - a)
                if (
                    abs(off_a + slope * (begin - a)) > tolerance_m
                    or abs(off_a + slope * (end - a)) > tolerance_m
                ):
                    continue
                z = count - 1
                while z >= 0 and low[z] > begin:
                    low[z + 1], high[z + 1] = low[z], high[z]
                    z -= 1
                low[z + 1], high[z + 1] = begin, end
                count += 1
        begin = 0.0
        for z in range(count + 1):
            end = low[z] if z < count else length
            if end - begin > SHORTEST_CUT_M or end - begin == length:
                if kept < rest.shape[0]:
                    rest[kept, 0], rest[kept, 1] = x0, y0
                    rest[kept, 2], rest[kept, 3] = x1, y1
                    if begin > 0.0:
                        share = begin / length
                        rest[kept, 0] = x0 + share * (x1 - x0)
                        rest[kept, 1] = y0 + share * (y1 - y0)
                    if end < length:
                        share = end / length
                        rest[kept, 2] = x0 + share * (x1 - x0)
                        rest[kept, 3] = y0 + share * (y1 - y0)
                    source[kept] = i
                kept += 1
            if z < count:
                begin = max(begin, high[z])
    return kept


@kernel
def common_pieces(
    pieces: FloatArray, wholes: FloatArray, rest: FloatArray, source: IntArray
) -> tuple[FloatArray, IntArray]:
    """Give what pieces of segments have in common with what a taking left of the segments.

    Parameters
    ----------
    pieces : (m, 4) array
        Pieces of the segments.
    wholes : (m, 4) array
        The whole segment that each piece is of.
    rest, source
        What the taking left of the whole segments, and of which one, rising.

    Returns
    -------
    common : (r, 4) array
        In the order of the pieces. Remains of at most `SHORTEST_CUT_M` are left out.
    origin : (r,) array
        The piece that each is of.
    """
    most = rest.shape[0]
    common, origin = np.empty((most, 4)), np.empty(most, np.int64)
    count = _common_pieces(pieces, wholes, rest, source, common, origin)
    return common[:count], origin[:count]


@kernel
def _common_pieces(
    pieces: FloatArray,
    wholes: FloatArray,
    rest: FloatArray,
    source: IntArray,
    common: FloatArray,
    origin: IntArray,
) -> int:
    kept, r = 0, 0
    for i in range(pieces.shape[0]):
        x, y = wholes[i, 0], wholes[i, 1]
        ux, uy = wholes[i, 2] - x, wholes[i, 3] - y
        length = np.hypot(ux, uy)
        if length > 0.0:
            ux, uy = ux / length, uy / length
        first = ux * (pieces[i, 0] - x) + uy * (pieces[i, 1] - y)
        last = ux * (pieces[i, 2] - x) + uy * (pieces[i, 3] - y)
        while r < rest.shape[0] and source[r] == i:
            begin = ux * (rest[r, 0] - x) + uy * (rest[r, 1] - y)
            end = ux * (rest[r, 2] - x) + uy * (rest[r, 3] - y)
            as_before = begin <= first and end >= last
            if as_before or min(end, last) - max(begin, first) > SHORTEST_CUT_M:
                for c in range(4):
                    common[kept, c] = pieces[i, c]
                if begin > first:
                    common[kept, 0], common[kept, 1] = rest[r, 0], rest[r, 1]
                if end < last:
                    common[kept, 2], common[kept, 3] = rest[r, 2], rest[r, 3]
                origin[kept] = i
                kept += 1
            r += 1
    return kept


@kernel
def in_long_arcs(segments: FloatArray, shortest_m: float) -> BoolArray:
    """Tell which segments belong to arcs that are at least this long."""
    labels, count = arc_labels(segments)
    long = np.empty(segments.shape[0], np.bool_)
    _note_long(segments, labels, np.zeros(count), shortest_m, long)
    return long


@kernel
def _note_long(
    segments: FloatArray, labels: IntArray, lengths: FloatArray, shortest_m: float, long: BoolArray
) -> None:
    for i in range(segments.shape[0]):
        lengths[labels[i]] += np.hypot(
            segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
        )
    for i in range(segments.shape[0]):
        long[i] = lengths[labels[i]] >= shortest_m


class ArcPieces:
    """What is left of the arcs of many regions: of each its pieces, in one growing array.

    Pieces that are replaced stay where they are until the array is full; then those in use move
    together.

    Attributes
    ----------
    pieces, wholes : (c, 4) arrays
        Pieces, and the whole segment that each is of.
    spans : (n, 4) array
        Which rows are a region's: first and end of what other regions left, and first and end of
        what of this was not given up.
    lengths_m : (n, 2) array
        The shortest and the longest arc of what was not given up; -1 where there is none.
    """

    __slots__ = ("_end", "lengths_m", "pieces", "spans", "wholes")

    def __init__(self) -> None:
        self.pieces: FloatArray = np.empty((1024, 4))
        self.wholes: FloatArray = np.empty((1024, 4))
        self.spans: IntArray = np.zeros((0, 4), np.int64)
        self.lengths_m: FloatArray = np.empty((0, 2))
        self._end = 0

    def make_room(self, count: int) -> None:
        """Have room for so many regions; the new ones have nothing."""
        more = count - len(self.spans)
        self.spans = grown(self.spans, count)
        self.lengths_m = np.concatenate([self.lengths_m, np.full((more, 2), -1.0)])

    def left(self, index: int) -> tuple[FloatArray, FloatArray]:
        """Give the pieces that other regions left of a region's arcs, and their wholes."""
        first, end = self.spans[index, :2].tolist()
        return self.pieces[first:end], self.wholes[first:end]

    def is_open(self, index: int) -> bool:
        """Whether anything is left that was not given up."""
        return bool(self.lengths_m[index, 1] >= 0.0)

    def take_in(
        self,
        index: int,
        region: LocalSafeRegion,
        include_gaps: bool,
        neighbours: IntArray,
        ids: IntArray,
        rings: RingArrays,
    ) -> IntArray:
        """Take in a new region; the other parameters are those of `changed_pieces`.

        Returns
        -------
        (c,) array
            Whose pieces changed, the new region first.
        """
        while True:
            owners, begins = _take_in(
                index,
                region.boundary,
                region.tags,
                include_gaps,
                neighbours,
                ids,
                *rings,
                self.spans,
                self.lengths_m,
                self.pieces,
                self.wholes,
                self._end,
            )
            end = self._end + int(begins[-1])
            if end <= len(self.pieces):
                self._end = end
                return owners
            self._move_together(end - self._end)

    def put(
        self, owners: IntArray, begins: IntArray, pieces: FloatArray, wholes: FloatArray
    ) -> None:
        """Replace what is left of some regions' arcs, as `changed_pieces` gives it."""
        self._put(owners, begins, pieces, wholes, given_up=False)

    def give_up(self, index: int, arcs: FloatArray, tolerance_m: float) -> None:
        """Take from what is open of a region whatever lies along some segments."""
        pieces, wholes = self.left(index)
        rest, source = apart_from(wholes, np.ones(len(wholes), np.bool_), arcs, tolerance_m)
        still, origin = common_pieces(pieces, wholes, rest, source)
        long = in_long_arcs(still, SHORTEST_ARC_M)
        still, wholes = still[long], wholes[origin[long]]
        owners, begins = np.array([index]), np.array([0, len(still)])
        self._put(owners, begins, still, wholes, given_up=True)

    def wide_enough(self, index: int, near: IntArray, shortest_m: float) -> FloatArray:
        """Give a region's open arcs that are long enough with those of others that they join.

        Parameters
        ----------
        index : int
            Whose arcs are asked for.
        near : (k,) array of int
            Whose arcs may join them.
        shortest_m : float
            Shorter arcs, with all that they are joined to, are left out.
        """
        return _wide_enough(index, near, self.spans, self.pieces, shortest_m)

    def _put(
        self,
        owners: IntArray,
        begins: IntArray,
        pieces: FloatArray,
        wholes: FloatArray,
        *,
        given_up: bool,
    ) -> None:
        if self._end + len(pieces) > len(self.pieces):
            self._move_together(len(pieces))
        self._end = _put(
            owners,
            begins,
            pieces,
            wholes,
            given_up,
            self.spans,
            self.lengths_m,
            self.pieces,
            self.wholes,
            self._end,
        )

    def _move_together(self, more: int) -> None:
        self.pieces, self.wholes, self._end = _moved_together(
            self.spans, self.pieces, self.wholes, more
        )


@kernel
def _take_in(
    index: int,
    boundary: FloatArray,
    tags: TagArray,
    include_gaps: bool,
    neighbours: IntArray,
    ids: IntArray,
    starts: IntArray,
    corners: FloatArray,
    boxes: FloatArray,
    stretches: FloatArray,
    spans: IntArray,
    lengths: FloatArray,
    pieces: FloatArray,
    wholes: FloatArray,
    end: int,
) -> tuple[IntArray, IntArray]:
    # Puts what `changed_pieces` gives, if there is room.
    owners, begins, left, left_wholes = changed_pieces(
        index,
        boundary,
        tags,
        include_gaps,
        neighbours,
        ids,
        starts,
        corners,
        boxes,
        stretches,
        spans,
        pieces,
        wholes,
    )
    if end + left.shape[0] <= pieces.shape[0]:
        _put(owners, begins, left, left_wholes, False, spans, lengths, pieces, wholes, end)
    return owners, begins


@kernel
def changed_pieces(
    index: int,
    boundary: FloatArray,
    tags: TagArray,
    include_gaps: bool,
    neighbours: IntArray,
    ids: IntArray,
    starts: IntArray,
    corners: FloatArray,
    boxes: FloatArray,
    stretches: FloatArray,
    spans: IntArray,
    pieces: FloatArray,
    wholes: FloatArray,
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Work out whose frontier a new region changes, and what is left of each.

    The regions near by take from the new one's boundary, and it takes from theirs. Of a border
    on which several regions end on one side, the one with the lowest id keeps the frontier;
    regions on two sides take it from each other.

    Parameters
    ----------
    index : int
        The new region.
    boundary, tags, include_gaps
        As `frontier_candidates` takes them.
    neighbours : (k,) array
        The regions near by, without the new one.
    ids : (n, 2) array
        The regions' ids, which have an order.
    starts, corners, boxes, stretches
        All regions, with the new one, as `uncovered` takes them.
    spans, pieces, wholes
        What is left of their arcs, as `ArcPieces` keeps it.

    Returns
    -------
    owners : (c,) array
        Whose pieces change, the new region first.
    begins : (c + 1,) array
        Owner k is left with ``left[begins[k]:begins[k + 1]]``.
    left, left_wholes : (r, 4) arrays
        Pieces, and the whole segment that each is of.
    """
    candidates = pieces_tagged(boundary, tags, include_gaps)
    own, source = uncovered(candidates, starts, corners, boxes, stretches, neighbours)
    own_wholes = _rows(candidates, source)
    near, earlier = _with_pieces_near(index, neighbours, ids, boxes, spans, wholes)
    theirs, their_wholes, owners = _gathered(near, spans, pieces, wholes)
    lines = _rows_where(their_wholes, earlier[owners])
    if lines.shape[0] > 0:
        everywhere = np.ones(own.shape[0], np.bool_)
        rest, source = apart_from(own_wholes, everywhere, lines, ONE_BORDER_M)
        own, source = common_pieces(own, own_wholes, rest, source)
        own_wholes = _rows(own_wholes, source)
    long = in_long_arcs(own, SHORTEST_ARC_M)
    own, own_wholes = _rows_where(own, long), _rows_where(own_wholes, long)

    rest, source = uncovered(their_wholes, starts, corners, boxes, stretches, np.array([index]))
    left, origin = common_pieces(theirs, their_wholes, rest, source)
    if not earlier.all():
        left_wholes = _rows(their_wholes, origin)
        concerned = ~earlier[owners[origin]]
        rest, source = apart_from(left_wholes, concerned, own_wholes, ONE_BORDER_M)
        left, source = common_pieces(left, left_wholes, rest, source)
        origin = origin[source]
    parts, cut = pieces_by_owner(theirs, owners, near.shape[0], left, origin)

    changed = np.concatenate((np.array([index]), near[cut]))
    begins = np.zeros(changed.shape[0] + 1, np.int64)
    begins[1] = own.shape[0]
    kept = np.empty(own.shape[0] + left.shape[0], np.int64)
    owner = 1
    count = 0
    for k in np.flatnonzero(cut):
        count = _add_long(left, parts[k], parts[k + 1], kept, count)
        owner += 1
        begins[owner] = own.shape[0] + count
    kept = kept[:count]
    return (
        changed,
        begins,
        np.concatenate((own, _rows(left, kept))),
        np.concatenate((own_wholes, _rows(their_wholes, origin[kept]))),
    )


@kernel
def _add_long(left: FloatArray, first: int, end: int, kept: IntArray, count: int) -> int:
    # Notes which of an owner's pieces are in arcs that are no rounding. Tells how many are noted.
    long = in_long_arcs(left[first:end], SHORTEST_ARC_M)
    for i in range(long.shape[0]):
        if long[i]:
            kept[count] = first + i
            count += 1
    return count


@kernel
def _rows(values: FloatArray, indices: IntArray) -> FloatArray:
    rows = np.empty((indices.shape[0], 4))
    _copy_rows(values, indices, rows)
    return rows


@kernel
def _rows_where(values: FloatArray, wanted: BoolArray) -> FloatArray:
    return _rows(values, np.flatnonzero(wanted))


@kernel
def _copy_rows(values: FloatArray, indices: IntArray, rows: FloatArray) -> None:
    for i in range(indices.shape[0]):
        for c in range(4):
            rows[i, c] = values[indices[i], c]


@kernel
def _with_pieces_near(
    index: int,
    neighbours: IntArray,
    ids: IntArray,
    boxes: FloatArray,
    spans: IntArray,
    wholes: FloatArray,
) -> tuple[IntArray, BoolArray]:
    # The neighbours with arcs that are not apart from a region, and whose ids are lower.
    near = np.empty_like(neighbours)
    earlier = np.empty(neighbours.shape[0], np.bool_)
    count = _note_near(index, neighbours, ids, boxes, spans, wholes, near, earlier)
    return near[:count], earlier[:count]


@kernel
def _note_near(
    index: int,
    neighbours: IntArray,
    ids: IntArray,
    boxes: FloatArray,
    spans: IntArray,
    wholes: FloatArray,
    near: IntArray,
    earlier: BoolArray,
) -> int:
    count = 0
    left, bottom = boxes[index, 0] - APART_M, boxes[index, 1] - APART_M
    right, top = boxes[index, 2] + APART_M, boxes[index, 3] + APART_M
    for k in neighbours:
        for i in range(spans[k, 0], spans[k, 1]):
            x0, y0, x1, y1 = wholes[i, 0], wholes[i, 1], wholes[i, 2], wholes[i, 3]
            if (
                min(x0, x1) <= right
                and max(x0, x1) >= left
                and min(y0, y1) <= top
                and max(y0, y1) >= bottom
            ):
                near[count] = k
                earlier[count] = ids[k, 0] < ids[index, 0] or (
                    ids[k, 0] == ids[index, 0] and ids[k, 1] < ids[index, 1]
                )
                count += 1
                break
    return count


@kernel
def _gathered(
    indices: IntArray, spans: IntArray, pieces: FloatArray, wholes: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    # The pieces of some regions one after the other, their wholes, and whose of these each is.
    total = 0
    for k in indices:
        total += spans[k, 1] - spans[k, 0]
    rows, owners = np.empty(total, np.int64), np.empty(total, np.int64)
    _note_rows(indices, spans, rows, owners)
    return _rows(pieces, rows), _rows(wholes, rows), owners


@kernel
def _note_rows(indices: IntArray, spans: IntArray, rows: IntArray, owners: IntArray) -> None:
    count = 0
    for k in range(indices.shape[0]):
        for row in range(spans[indices[k], 0], spans[indices[k], 1]):
            rows[count], owners[count] = row, k
            count += 1


@kernel
def _put(
    owners: IntArray,
    begins: IntArray,
    new_pieces: FloatArray,
    new_wholes: FloatArray,
    given_up: bool,
    spans: IntArray,
    lengths: FloatArray,
    pieces: FloatArray,
    wholes: FloatArray,
    end: int,
) -> int:
    # Writes owners' new pieces behind all others; after something was given up, the open ones
    # alone. Tells where they end.
    after: int = end + new_pieces.shape[0]
    pieces[end:after], wholes[end:after] = new_pieces, new_wholes
    for k in range(owners.shape[0]):
        owner = owners[k]
        spans[owner, 2], spans[owner, 3] = end + begins[k], end + begins[k + 1]
        if not given_up:
            spans[owner, :2] = spans[owner, 2:]
        lengths[owner] = -1.0
        if begins[k + 1] > begins[k]:
            arcs = arc_ends(new_pieces[begins[k] : begins[k + 1]])
            lengths[owner, 0], lengths[owner, 1] = arcs[:, 4].min(), arcs[:, 4].max()
    return after


@kernel
def _moved_together(
    spans: IntArray, pieces: FloatArray, wholes: FloatArray, more: int
) -> tuple[FloatArray, FloatArray, int]:
    # Copies of the pieces in use, with room for others. Tells where they end.
    used = 0
    for owner in range(spans.shape[0]):
        used += spans[owner, 1] - spans[owner, 0] + spans[owner, 3] - spans[owner, 2]
    capacity = max(pieces.shape[0], 2 * (used + more))
    moved, moved_wholes = np.empty((capacity, 4)), np.empty((capacity, 4))
    end = 0
    for owner in range(spans.shape[0]):
        one = spans[owner, 0] == spans[owner, 2] and spans[owner, 1] == spans[owner, 3]
        for k in (0, 2):
            if k == 2 and one:
                spans[owner, 2:] = spans[owner, :2]
                continue
            first, last = spans[owner, k], spans[owner, k + 1]
            after = end + last - first
            moved[end:after], moved_wholes[end:after] = pieces[first:last], wholes[first:last]
            spans[owner, k], spans[owner, k + 1] = end, after
            end = after
    return moved, moved_wholes, end


@kernel
def _wide_enough(
    index: int, near: IntArray, spans: IntArray, pieces: FloatArray, shortest: float
) -> FloatArray:
    arcs = pieces[spans[index, 2] : spans[index, 3]]
    own = arc_ends(arcs)
    total = own.shape[0]
    for k in near:
        if k != index:
            total += spans[k, 3] - spans[k, 2]
    ends = np.empty((total, 5))
    count = own.shape[0]
    ends[:count] = own
    for k in near:
        if k != index and spans[k, 3] > spans[k, 2]:
            others = arc_ends(pieces[spans[k, 2] : spans[k, 3]])
            ends[count : count + others.shape[0]] = others
            count += others.shape[0]
    lengths = joined_lengths(ends[:count])
    labels, _ = arc_labels(arcs)
    kept = np.empty(arcs.shape[0], np.bool_)
    for i in range(arcs.shape[0]):
        kept[i] = lengths[labels[i]] >= shortest
    return arcs[kept]
