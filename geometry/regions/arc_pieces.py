"""Remaining frontier arcs of many regions, in arrays that grow with their number."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.arrays import grown, roomier
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel
from multisrt.geometry.numerics.rings import RingArrays
from multisrt.geometry.regions.frontier_arcs import (
    MIN_ARC_M,
    arc_ends,
    arc_labels,
    in_long_arcs,
    is_wide_chain,
    open_pieces,
)
from multisrt.geometry.regions.frontier_update import (
    FrontierChanges,
    PieceArrays,
    frontier_changes,
)
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.geometry.regions.segment_difference import beside, intersect_pieces

MIN_CAPACITY = 1024
"""Number of rows of `PieceArrays.pieces` to begin with."""


class ArcPieces:
    """Remaining frontier arcs of many regions.

    New pieces of a region are written after all others. When the arrays are full, the pieces in
    use are compacted into new ones.

    Attributes
    ----------
    arrays : PieceArrays
        The pieces, as kernels take them.

    Examples
    --------
    >>> import numpy as np
    >>> from multisrt.geometry.regions.frontier_update import FrontierChanges
    >>> arcs = ArcPieces()
    >>> arcs.make_room(1)
    >>> side = np.array([[0.0, 0.0, 3.0, 0.0]])
    >>> arcs.replace(FrontierChanges(np.array([0]), np.array([0, 1]), side, side))
    >>> arcs.give_up(0, np.array([[1.0, 0.0, 3.0, 0.0]]), 1e-6)
    >>> arcs.wide_enough(0, np.array([0]), 0.5).tolist()
    [[0.0, 0.0, 1.0, 0.0]]
    """

    __slots__ = ("_borders_end", "_end", "arrays")

    def __init__(self) -> None:
        self.arrays = PieceArrays(
            spans=np.zeros((0, 4), np.int64),
            lengths_m=np.empty((0, 2)),
            pieces=np.empty((MIN_CAPACITY, 4)),
            wholes=np.empty((MIN_CAPACITY, 4)),
            border_spans=np.zeros((0, 2), np.int64),
            borders=np.empty((MIN_CAPACITY, 4)),
        )
        self._end = 0
        self._borders_end = 0

    def make_room(self, count: int) -> None:
        """Make room for a number of regions; new ones have no pieces."""
        held = self.arrays
        more = count - len(held.spans)
        self.arrays = held._replace(
            spans=grown(held.spans, count),
            lengths_m=np.concatenate([held.lengths_m, np.full((more, 2), -1.0)]),
            border_spans=grown(held.border_spans, count),
        )

    def left(self, index: int) -> tuple[FloatArray, FloatArray]:
        """Return what other regions leave of a region's arcs.

        Returns
        -------
        pieces, wholes : (m, 4) arrays
            The pieces, given up or not, and the segments that they come from.
        """
        first, end = self.arrays.spans[index, :2].tolist()
        return self.arrays.pieces[first:end], self.arrays.wholes[first:end]

    def is_open(self, index: int) -> bool:
        """Whether a region has a piece that was not given up."""
        return bool(self.arrays.lengths_m[index, 1] >= 0.0)

    def add(
        self,
        index: int,
        region: LocalSafeRegion,
        include_gaps: bool,
        neighbours: IntArray,
        ids: IntArray,
        rings: RingArrays,
    ) -> IntArray:
        """Add the arcs of a new region, and trim those of its neighbours.

        Parameters
        ----------
        index : int
            The new region.
        region : LocalSafeRegion
            Its boundary and tags.
        include_gaps : bool
            Whether radial pieces behind corners are frontier.
        neighbours, ids, rings
            As for `frontier_changes`.

        Returns
        -------
        (c,) array of int
            The regions whose pieces changed, the new one first.
        """
        border = open_pieces(region.boundary, region.tags, include_gaps)
        new = index, border, neighbours, ids, rings
        owners, end = _add(*new, self.arrays, self._end)
        if end > len(self.arrays.pieces):
            self._compact(end - self._end)
            owners, end = _add(*new, self.arrays, self._end)
        self._end = end
        self._keep_borders(index, border)
        return owners

    def replace(self, changes: FrontierChanges) -> None:
        """Replace the pieces of some regions; none of the new ones is given up."""
        self._write(changes, given_up=False)

    def give_up(self, index: int, arcs: FloatArray, tolerance_m: float) -> None:
        """Take from a region's open arcs whatever lies along given segments.

        Parameters
        ----------
        index : int
            The region.
        arcs : (k, 4) array
            Segments x0, y0, x1, y1 in metres, in any direction.
        tolerance_m : float
            A piece lies along a segment where they are at most this far apart.
        """
        pieces, wholes = self.left(index)
        rest, source = beside(wholes, np.ones(len(wholes), np.bool_), arcs, tolerance_m)
        still, origin = intersect_pieces(pieces, wholes, rest, source)
        is_long = in_long_arcs(still, MIN_ARC_M)
        still, wholes = still[is_long], wholes[origin[is_long]]
        begins = np.array([0, len(still)])
        self._write(FrontierChanges(np.array([index]), begins, still, wholes), given_up=True)

    def wide_enough(self, index: int, near: IntArray, min_length_m: float) -> FloatArray:
        """Return a region's open arcs that are long enough with those that they are joined to.

        Parameters
        ----------
        index : int
            The region.
        near : (k,) array of int
            Regions whose open arcs may be joined to its own.
        min_length_m : float
            Minimum length in metres of an arc together with all that it is joined to.

        Returns
        -------
        (m, 4) array
            Segments x0, y0, x1, y1 in metres, in their order along the boundary.
        """
        return _wide_enough(index, near, self.arrays.spans, self.arrays.pieces, min_length_m)

    def _keep_borders(self, index: int, borders: FloatArray) -> None:
        begin, end = self._borders_end, self._borders_end + len(borders)
        if end > len(self.arrays.borders):
            room = grown(self.arrays.borders, roomier(len(self.arrays.borders), end))
            self.arrays = self.arrays._replace(borders=room)
        self.arrays.borders[begin:end] = borders
        self.arrays.border_spans[index] = begin, end
        self._borders_end = end

    def _write(self, changes: FrontierChanges, *, given_up: bool) -> None:
        if self._end + len(changes.pieces) > len(self.arrays.pieces):
            self._compact(len(changes.pieces))
        self._end = _write(changes, given_up, self.arrays, self._end)

    def _compact(self, more: int) -> None:
        """Move the pieces in use into arrays with room for more."""
        self.arrays, self._end = _compacted(self.arrays, more)


@kernel
def _add(
    index: int,
    border: FloatArray,
    neighbours: IntArray,
    ids: IntArray,
    rings: RingArrays,
    held: PieceArrays,
    end: int,
) -> tuple[IntArray, int]:
    # Compute the changes and write them behind row `end`. Return whose pieces change, and the
    # row behind the last; if there is no room up to it, nothing was written.
    changes = frontier_changes(index, border, neighbours, ids, rings, held)
    if end + changes.pieces.shape[0] > held.pieces.shape[0]:
        return changes.owners, end + changes.pieces.shape[0]
    return changes.owners, _write(changes, False, held, end)


@kernel
def _write(changes: FrontierChanges, given_up: bool, held: PieceArrays, end: int) -> int:
    # Write new pieces behind row `end`, where they are, and how long their arcs are. Return the
    # row behind the last. After something was given up only open ones are new.
    begins, pieces = changes.begins, changes.pieces
    after: int = end + pieces.shape[0]
    for i in range(pieces.shape[0]):
        for c in range(4):
            held.pieces[end + i, c] = pieces[i, c]
            held.wholes[end + i, c] = changes.wholes[i, c]
    spans, lengths = held.spans, held.lengths_m
    for k in range(changes.owners.shape[0]):
        owner = changes.owners[k]
        spans[owner, 2], spans[owner, 3] = end + begins[k], end + begins[k + 1]
        if not given_up:
            spans[owner, :2] = spans[owner, 2:]
        lengths[owner] = -1.0
        if begins[k + 1] > begins[k]:
            arcs = arc_ends(pieces[begins[k] : begins[k + 1]])
            lengths[owner, 0], lengths[owner, 1] = arcs[:, 4].min(), arcs[:, 4].max()
    return after


@kernel
def _compacted(held: PieceArrays, more: int) -> tuple[PieceArrays, int]:
    # Arrays with the pieces in use and room for more, and the row behind the last piece.
    spans = held.spans.copy()
    used = 0
    for owner in range(spans.shape[0]):
        used += spans[owner, 1] - spans[owner, 0] + spans[owner, 3] - spans[owner, 2]
    capacity = max(MIN_CAPACITY, used + used // 2 + more)
    pieces, wholes = np.empty((capacity, 4)), np.empty((capacity, 4))
    end = 0
    for owner in range(spans.shape[0]):
        is_one = spans[owner, 0] == spans[owner, 2] and spans[owner, 1] == spans[owner, 3]
        for k in (0, 2):
            if k == 2 and is_one:
                spans[owner, 2:] = spans[owner, :2]
                continue
            first, last = spans[owner, k], spans[owner, k + 1]
            after = end + last - first
            pieces[end:after], wholes[end:after] = held.pieces[first:last], held.wholes[first:last]
            spans[owner, k], spans[owner, k + 1] = end, after
            end = after
    borders = held.border_spans, held.borders
    return PieceArrays(spans, held.lengths_m, pieces, wholes, *borders), end


@kernel
def _wide_enough(
    index: int, near: IntArray, spans: IntArray, pieces: FloatArray, min_length: float
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
    is_wide = np.empty(own.shape[0], np.bool_)
    for k in range(own.shape[0]):
        is_wide[k] = is_wide_chain(ends[:count], k, min_length)
    labels, _ = arc_labels(arcs)
    kept = np.empty(arcs.shape[0], np.bool_)
    for i in range(arcs.shape[0]):
        kept[i] = is_wide[labels[i]]
    return arcs[kept]
