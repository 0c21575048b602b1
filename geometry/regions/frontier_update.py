"""How a new region changes the frontier arcs of the regions near it, and what its own are."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.kernel import (
    BoolArray,
    FloatArray,
    IntArray,
    inlined_kernel,
    kernel,
)
from multisrt.geometry.numerics.rings import RingArrays
from multisrt.geometry.regions.frontier_arcs import MIN_ARC_M, in_long_arcs
from multisrt.geometry.regions.segment_difference import (
    OUTWARD_M,
    beside,
    intersect_pieces,
    uncovered,
)

SHARED_BORDER_M: Final = 0.5 * OUTWARD_M
"""Borders of two regions at most this far apart, in metres, are one.

If they are more than twice as far apart, the region of the outer border covers the inner one.
"""

APART_M: Final = 2.0 * OUTWARD_M
"""Regions whose boxes are further apart than this, in metres, subtract nothing from each other."""


class PieceArrays(NamedTuple):
    """The frontier pieces of many regions, as kernels take them.

    Attributes
    ----------
    spans : (n, 4) array of int
        For every region two ranges of rows of `pieces`: first and end of what other regions
        leave of its arcs, and first and end of what of this was not given up.
    lengths_m : (n, 2) array
        The shortest and the longest arc of every region that was not given up; -1 without any.
    pieces : (c, 4) array
        Segments x0, y0, x1, y1 in metres.
    wholes : (c, 4) array
        The segment of a region's boundary that each piece comes from.
    border_spans : (n, 2) array of int
        For every region first and end of its rows of `borders`.
    borders : (b, 4) array
        All candidates for frontier of every region, whatever is left of them.
    """

    spans: IntArray
    lengths_m: FloatArray
    pieces: FloatArray
    wholes: FloatArray
    border_spans: IntArray
    borders: FloatArray


class FrontierChanges(NamedTuple):
    """New frontier pieces of some regions.

    Attributes
    ----------
    owners : (c,) array of int
        The regions whose pieces change.
    begins : (c + 1,) array of int
        Region ``owners[k]`` has the rows from ``begins[k]`` to ``begins[k + 1]``.
    pieces, wholes : (r, 4) arrays
        As in `PieceArrays`.
    """

    owners: IntArray
    begins: IntArray
    pieces: FloatArray
    wholes: FloatArray


@kernel
def frontier_changes(
    index: int,
    border: FloatArray,
    neighbours: IntArray,
    ids: IntArray,
    rings: RingArrays,
    held: PieceArrays,
) -> FrontierChanges:
    """Compute whose frontier a new region changes, and what remains of each.

    The regions near by are subtracted from the new one's open boundary, and it from their
    pieces. Where several regions on one side end at one border, the one with the lowest id keeps
    the frontier; regions on two sides of it subtract it from each other. What a region keeps of a
    border does not depend on what others have left of theirs: with borders that are hardly apart,
    the first and the second being one, and the second and the third, but not the first and the
    third, it would depend on the order in which the regions are added.

    Parameters
    ----------
    index : int
        The new region.
    border : (p, 4) array
        Its candidates for frontier, x0, y0, x1, y1 in metres, counter-clockwise.
    neighbours : (k,) array of int
        The regions near by, without the new one.
    ids : (m, 2) array of int
        An id for every region, compared by its first column, then by its second.
    rings : RingArrays
        All regions, with the corners of the new one and those near by.
    held : PieceArrays
        The pieces of all others.

    Returns
    -------
    FrontierChanges
        Of the new region first, then of the neighbours that lose something, in their order.
    """
    own, source = uncovered(border, rings, neighbours)
    own_wholes = _rows(border, source)
    near, is_earlier = _with_pieces_near(index, neighbours, ids, rings.boxes, held)
    theirs, their_wholes, owners = _gathered(near, held)
    shared = _borders_of_earlier(index, neighbours, ids, own_wholes, held)
    if shared.shape[0] > 0:
        everywhere = np.ones(own.shape[0], np.bool_)
        rest, source = beside(own_wholes, everywhere, shared, SHARED_BORDER_M)
        own, source = intersect_pieces(own, own_wholes, rest, source)
        own_wholes = _rows(own_wholes, source)
    is_long = in_long_arcs(own, MIN_ARC_M)
    own, own_wholes = _rows_where(own, is_long), _rows_where(own_wholes, is_long)

    rest, source = uncovered(their_wholes, rings, np.array([index]))
    left, origin = intersect_pieces(theirs, their_wholes, rest, source)
    if not is_earlier.all():
        left_wholes = _rows(their_wholes, origin)
        selected = ~is_earlier[owners[origin]]
        rest, source = beside(left_wholes, selected, border, SHARED_BORDER_M)
        left, source = intersect_pieces(left, left_wholes, rest, source)
        origin = origin[source]
    parts, is_cut = pieces_by_owner(theirs, owners, near.shape[0], left, origin)

    changed = np.concatenate((np.array([index]), near[is_cut]))
    begins = np.zeros(changed.shape[0] + 1, np.int64)
    begins[1] = own.shape[0]
    kept = np.empty(left.shape[0], np.int64)
    count, owner = 0, 1
    for k in np.flatnonzero(is_cut):
        is_long = in_long_arcs(left[parts[k] : parts[k + 1]], MIN_ARC_M)
        for i in np.flatnonzero(is_long):
            kept[count] = parts[k] + i
            count += 1
        owner += 1
        begins[owner] = own.shape[0] + count
    kept = kept[:count]
    return FrontierChanges(
        changed,
        begins,
        np.concatenate((own, _rows(left, kept))),
        np.concatenate((own_wholes, _rows(their_wholes, origin[kept]))),
    )


@kernel
def pieces_by_owner(
    segments: FloatArray, owners: IntArray, count: int, rest: FloatArray, source: IntArray
) -> tuple[IntArray, BoolArray]:
    """Divide the remainders of segments among the owners of the segments.

    Parameters
    ----------
    segments : (m, 4) array
        The segments before the subtraction.
    owners : (m,) array of int
        The owner of each segment, counted from 0, ascending.
    count : int
        Number of owners.
    rest : (r, 4) array
        Remainders of the segments.
    source : (r,) array of int
        The segment that each remainder comes from, ascending.

    Returns
    -------
    begins : (count + 1,) array of int
        The remainders of owner k are ``rest[begins[k]:begins[k + 1]]``.
    is_cut : (count,) array of bool
        Which owners have lost something.
    """
    begins = np.zeros(count + 1, np.int64)
    is_cut = np.zeros(count, np.bool_)
    r = 0
    for i in range(segments.shape[0]):
        k = owners[i]
        is_whole = False
        pieces = 0
        while r < rest.shape[0] and source[r] == i:
            is_whole = True
            for c in range(4):
                is_whole = is_whole and rest[r, c] == segments[i, c]
            pieces += 1
            r += 1
        if pieces != 1 or not is_whole:
            is_cut[k] = True
        begins[k + 1] = r
    for k in range(count):
        begins[k + 1] = max(begins[k], begins[k + 1])
    return begins, is_cut


@kernel
def _with_pieces_near(
    index: int, neighbours: IntArray, ids: IntArray, boxes: FloatArray, held: PieceArrays
) -> tuple[IntArray, BoolArray]:
    # The neighbours with arcs near a region, and which of them have lower ids than it.
    near = np.empty_like(neighbours)
    is_earlier = np.empty(neighbours.shape[0], np.bool_)
    spans, wholes = held.spans, held.wholes
    count = 0
    for k in neighbours:
        for i in range(spans[k, 0], spans[k, 1]):
            if _is_near(wholes, i, boxes[index]):
                near[count], is_earlier[count] = k, _is_before(ids, k, index)
                count += 1
                break
    return near[:count], is_earlier[:count]


@inlined_kernel
def _is_near(segments: FloatArray, i: int, box: FloatArray) -> bool:
    # Whether segment i is near a box.
    x0, y0, x1, y1 = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
    return bool(
        min(x0, x1) <= box[2] + APART_M
        and max(x0, x1) >= box[0] - APART_M
        and min(y0, y1) <= box[3] + APART_M
        and max(y0, y1) >= box[1] - APART_M
    )


@kernel
def _is_before(ids: IntArray, k: int, index: int) -> bool:
    # Whether region k has a lower id than another one.
    if ids[k, 0] != ids[index, 0]:
        return bool(ids[k, 0] < ids[index, 0])
    return bool(ids[k, 1] < ids[index, 1])


@kernel
def _borders_of_earlier(
    index: int, neighbours: IntArray, ids: IntArray, segments: FloatArray, held: PieceArrays
) -> FloatArray:
    # The borders near segments of a region, of its neighbours with lower ids.
    box = np.array([np.inf, np.inf, -np.inf, -np.inf])
    for i in range(segments.shape[0]):
        for c in range(4):
            box[c % 2] = min(box[c % 2], segments[i, c])
            box[2 + c % 2] = max(box[2 + c % 2], segments[i, c])
    total = 0
    for k in neighbours:
        total += held.border_spans[k, 1] - held.border_spans[k, 0]
    rows, count = np.empty(total, np.int64), 0
    for k in neighbours:
        if not _is_before(ids, k, index):
            continue
        for row in range(held.border_spans[k, 0], held.border_spans[k, 1]):
            if _is_near(held.borders, row, box):
                rows[count] = row
                count += 1
    return _rows(held.borders, rows[:count])


@kernel
def _gathered(indices: IntArray, held: PieceArrays) -> tuple[FloatArray, FloatArray, IntArray]:
    # The pieces of some regions one after the other, their wholes, and which of the regions each
    # belongs to.
    total = 0
    for k in indices:
        total += held.spans[k, 1] - held.spans[k, 0]
    rows, owners = np.empty(total, np.int64), np.empty(total, np.int64)
    count = 0
    for k in range(indices.shape[0]):
        for row in range(held.spans[indices[k], 0], held.spans[indices[k], 1]):
            rows[count], owners[count] = row, k
            count += 1
    return _rows(held.pieces, rows), _rows(held.wholes, rows), owners


@kernel
def _rows(values: FloatArray, indices: IntArray) -> FloatArray:
    rows = np.empty((indices.shape[0], 4))
    for i in range(indices.shape[0]):
        for c in range(4):
            rows[i, c] = values[indices[i], c]
    return rows


@kernel
def _rows_where(values: FloatArray, selected: BoolArray) -> FloatArray:
    return _rows(values, np.flatnonzero(selected))
