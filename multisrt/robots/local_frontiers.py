"""The local frontiers of the nodes that a robot knows, kept up to date as regions arrive."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.arrays import grown, roomier
from multisrt.geometry.numerics.boxes import bounds_of
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.geometry.regions.arc_pieces import ArcPieces
from multisrt.geometry.regions.frontier_arcs import total_length
from multisrt.geometry.regions.frontier_update import APART_M
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.knowledge import NodeId
from multisrt.robots.node_regions import NodeRegions

ON_ARC_M: Final = 1e-6
"""Frontier within this distance in metres of an arc that was given up is part of it."""

NO_FRONTIER: Final[FloatArray] = np.empty((0, 4))
NO_FRONTIER.setflags(write=False)


class _Frontier(NamedTuple):
    # A node's local frontier: the revision at which it was last found valid, and that of the
    # newest change to a node whose arcs may be joined to its own.
    asked: int
    newest: int
    segments: FloatArray
    length_m: float


class LocalFrontiers:
    """The local frontier of every node: arcs that lie in no other region and are wide enough.

    The arcs of a node count with the length of all arcs that they are joined to. They are
    trimmed when a region becomes known near by; what was asked for is kept until a node near by
    changes.

    Parameters
    ----------
    regions : NodeRegions
        The nodes.
    min_length_m : float
        Joined arcs shorter than this, in metres, are not frontier.
    include_gaps : bool
        Whether radial pieces behind corners are frontier.
    """

    __slots__ = (
        "_arcs",
        "_changed",
        "_given_up",
        "_include_gaps",
        "_known",
        "_min_length_m",
        "_regions",
        "_revision",
    )

    def __init__(self, regions: NodeRegions, min_length_m: float, include_gaps: bool) -> None:
        self._regions = regions
        self._min_length_m = min_length_m
        self._include_gaps = include_gaps
        self._arcs = ArcPieces()
        self._given_up: dict[NodeId, list[FloatArray]] = {}
        self._known: dict[int, _Frontier] = {}
        # The number of changes, and by node the number of the last one that concerned it.
        self._revision = 0
        self._changed: IntArray = np.zeros(0, np.int64)

    @property
    def longest_m(self) -> FloatArray:
        """The longest open arc of every node in metres; -1 without any."""
        return self._arcs.arrays.lengths_m[: len(self._regions), 1]

    def add(self, number: int, region: LocalSafeRegion, neighbours: IntArray) -> IntArray:
        """Add the frontier of a node that `regions` has already.

        Parameters
        ----------
        number : int
            The node.
        region : LocalSafeRegion
            Its region.
        neighbours : (k,) array of int
            Other nodes, all whose regions may overlap with it.

        Returns
        -------
        (c,) array of int
            The nodes whose arcs changed, this one first.
        """
        if number == len(self._changed):
            count = roomier(number, number + 1)
            self._arcs.make_room(count)
            self._changed = grown(self._changed, count)
        rings = self._regions.rings
        neighbours = rings.meeting(neighbours, bounds_of(region.boundary), APART_M)
        changed = self._arcs.add(
            number,
            region,
            self._include_gaps,
            neighbours,
            self._regions.id_rows,
            rings.arrays(np.append(neighbours, number)),
        )
        self._note_changed(changed)
        return changed

    def give_up(self, node_id: NodeId, arc: FloatArray) -> IntArray:
        """Remove what lies along an arc, ``(k, 4)``, from a node's frontier, now and later.

        Returns
        -------
        (c,) array of int
            The node, if it is known.
        """
        self._given_up.setdefault(node_id, []).append(arc)
        number = self._regions.numbers.get(node_id)
        changed = np.array([] if number is None else [number], np.int64)
        if len(changed):
            self._note_changed(changed)
        return changed

    def is_wide(self, number: int) -> bool:
        """Whether a single arc of a node is long enough on its own."""
        return bool(self._arcs.arrays.lengths_m[number, 1] >= self._min_length_m)

    def is_open(self, number: int) -> bool:
        """Whether a node has a local frontier."""
        longest_m = self._arcs.arrays.lengths_m[number, 1]
        if longest_m < 0.0 or longest_m >= self._min_length_m:
            return bool(longest_m >= 0.0)
        return len(self.segments(number)) > 0

    def segments(self, number: int) -> FloatArray:
        """Return a node's local frontier, ``(m, 4)``, read-only."""
        return self._frontier(number).segments if self._arcs.is_open(number) else NO_FRONTIER

    def length_m(self, number: int) -> float:
        """Return the length of a node's local frontier in metres."""
        return self._frontier(number).length_m if self._arcs.is_open(number) else 0.0

    def _frontier(self, number: int) -> _Frontier:
        known = self._known.get(number)
        if known is not None and known.asked == self._revision:
            return known
        near, newest = np.array([number]), int(self._changed[number])
        if self._arcs.arrays.lengths_m[number, 0] < self._min_length_m:
            # Arcs of others that are joined to its own count, too.
            near = self._regions.places.around(near, 2.0 * self._regions.reach_m)
            newest = int(self._changed[near].max())
        if known is None or known.newest != newest:
            segments = self._arcs.wide_enough(number, near, self._min_length_m)
            segments.setflags(write=False)
            known = _Frontier(self._revision, newest, segments, total_length(segments))
        else:
            known = known._replace(asked=self._revision)
        self._known[number] = known
        return known

    def _note_changed(self, numbers: IntArray) -> None:
        self._revision += 1
        self._changed[numbers] = self._revision
        for number in numbers.tolist():
            given_up = self._given_up.get(self._regions.ids[number])
            if given_up:
                self._arcs.give_up(number, np.concatenate(given_up), ON_ARC_M)
