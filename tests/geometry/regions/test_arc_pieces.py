"""Frontier pieces after many subtractions, against single subtractions and by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.arc_pieces import ArcPieces
from multisrt.geometry.regions.frontier_arcs import (
    ENDS_MEET_M,
    MIN_ARC_M,
    arc_ends,
    arc_labels,
    frontier_candidates,
    in_long_arcs,
)
from multisrt.geometry.regions.frontier_update import FrontierChanges
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.geometry.regions.segment_difference import uncovered

Pieces = tuple[np.ndarray, np.ndarray]
"""Pieces of frontier, and the whole segments they are parts of."""


class Regions:
    """Regions as kernels take them, with an id for each."""

    def __init__(self, regions, ids):
        self.regions = regions
        self.rings = Rings([r.boundary for r in regions])
        self.ids = np.asarray(ids)

    def uncovered(self, segments, ids):
        ids = np.asarray(ids, np.int64)
        return uncovered(segments, self.rings.arrays(ids), ids)

    def candidates(self, index):
        return frontier_candidates(self.regions[index].boundary, self.regions[index].tags)

    def add_to(self, arcs: ArcPieces, index: int) -> np.ndarray:
        """Add region `index` after those before it; return the regions whose pieces changed."""
        rings = self.rings.arrays(np.arange(index + 1))
        return arcs.add(index, self.regions[index], True, np.arange(index), self.ids, rings)


def without_short_arcs(pieces, wholes):
    long = in_long_arcs(pieces, MIN_ARC_M)
    return pieces[long], wholes[long]


def one_by_one(subtracting, regions: Regions, index: int, held: dict[int, Pieces]) -> None:
    """Do what `ArcPieces.add` does, one owner and one subtraction after the other."""
    candidates = regions.candidates(index)
    own = candidates, candidates
    for k in range(index):
        own = subtracting.remainder(lambda wholes, k=k: regions.uncovered(wholes, [k]), *own)
    before = tuple(regions.ids[index])
    for k in range(index):
        if tuple(regions.ids[k]) < before:
            own = subtracting.remainder(subtracting.along(regions.candidates(k)), *own)
    own = without_short_arcs(*own)
    for k in range(index):
        theirs = subtracting.remainder(lambda wholes: regions.uncovered(wholes, [index]), *held[k])
        if tuple(regions.ids[k]) > before:
            theirs = subtracting.remainder(subtracting.along(candidates), *theirs)
        if not np.array_equal(theirs[0], held[k][0]):
            held[k] = without_short_arcs(*theirs)
    held[index] = own


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
@pytest.mark.parametrize("shape", ["radial", "star"])
def test_a_region_changes_what_single_subtractions_change(subtracting, worlds, name, shape):
    free = worlds.WORLDS[name]()
    index = worlds.index(free, 4.0)
    places = worlds.viewpoints(free, 24, seed=45).tolist()
    # Some places occur twice: their regions share all borders.
    places = [*places, *places[::5]]
    scans = [take_scan(index, Configuration(x, y), 0.0, 4.0) for x, y in places]
    numbers = np.random.default_rng(7).permutation(len(places))
    regions = Regions(
        [local_safe_region(scan, shape) for scan in scans], np.c_[numbers % 3, numbers // 3]
    )
    arcs = ArcPieces()
    held: dict[int, Pieces] = {}
    arcs.make_room(len(places))
    cut = 0
    for k in range(len(places)):
        before = {i: pieces for i, (pieces, _) in held.items()}
        one_by_one(subtracting, regions, k, held)
        changed = regions.add_to(arcs, k)
        differ = [i for i in before if not np.array_equal(before[i], held[i][0])]
        cut += len(differ)
        assert changed.tolist() == [k, *differ]
        for i, (pieces, wholes) in held.items():
            left, left_wholes = arcs.left(i)
            assert np.allclose(left, pieces, rtol=0.0, atol=1e-9)
            assert np.array_equal(left_wholes, wholes)
    assert cut > 10
    assert any(len(pieces) for pieces, _ in held.values())


def sides(count: int, serial: int) -> np.ndarray:
    """Upright segments of 1 m, far from each other and from those of another serial."""
    x, y = 10.0 * np.arange(count), np.full(count, 10.0 * serial)
    return np.column_stack([x, y, x, y + 1.0])


def lengthened(segments: np.ndarray) -> np.ndarray:
    return segments + np.array([0.0, -1.0, 0.0, 1.0])


@given(
    st.lists(
        st.lists(st.tuples(st.integers(0, 9), st.integers(0, 60)), min_size=1, max_size=4),
        max_size=40,
    ),
    st.integers(0, 9),
)
@settings(max_examples=30)
def test_the_last_pieces_are_found_after_compaction(batches, giver):
    # One of the owners gives up every other piece at once.
    arcs = ArcPieces()
    arcs.make_room(10)
    held = dict.fromkeys(range(10), np.empty((0, 4)))
    for serial, batch in enumerate(batches):
        parts = {owner: sides(size, serial) for owner, size in batch}
        begins = np.cumsum([0, *map(len, parts.values())])
        pieces = np.concatenate([*parts.values()])
        arcs.replace(FrontierChanges(np.array([*parts]), begins, pieces, lengthened(pieces)))
        if giver in parts:
            arcs.give_up(giver, parts[giver][::2], 1e-6)
        held |= parts
    for owner, pieces in held.items():
        left, wholes = arcs.left(owner)
        assert np.array_equal(left, pieces)
        assert np.array_equal(wholes, lengthened(pieces))
        still = pieces[1::2] if owner == giver else pieces
        assert arcs.is_open(owner) == bool(len(still))
        assert np.array_equal(arcs.wide_enough(owner, np.arange(10), 0.0), still)


def test_what_is_given_up_is_left_but_not_open():
    arcs = ArcPieces()
    arcs.make_room(2)
    sides = np.array([[0.0, 0, 2, 0], [5, 0, 8, 0]])
    arcs.replace(FrontierChanges(np.array([1, 0]), np.array([0, 2, 2]), sides, sides))
    assert arcs.arrays.lengths_m.tolist() == [[-1.0, -1.0], [2.0, 3.0]]
    arcs.give_up(1, np.array([[6.0, 0, 9, 0]]), 1e-6)
    assert arcs.arrays.lengths_m.tolist() == [[-1.0, -1.0], [1.0, 2.0]]
    assert arcs.left(1)[0].tolist() == sides.tolist()
    assert arcs.wide_enough(1, np.array([0, 1]), 0.0).tolist() == [[0, 0, 2, 0], [5, 0, 6, 0]]
    arcs.give_up(1, np.array([[8.0, 0, -1, 0]]), 1e-6)
    assert not arcs.is_open(1)
    assert not arcs.is_open(0)
    arcs.replace(FrontierChanges(np.array([1]), np.array([0, 1]), sides[:1], sides[:1]))
    assert arcs.is_open(1)
    assert arcs.left(1)[0].tolist() == arcs.wide_enough(1, np.array([1]), 0.0).tolist()


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 6.0))
def test_arcs_count_with_all_that_they_are_joined_to(seed, shortest):
    # Runs of a walk on a coarse grid: arcs of several owners meet often.
    random = np.random.default_rng(seed)
    arcs, owners = ArcPieces(), 5
    arcs.make_room(owners)
    steps = random.integers(-1, 2, (40, 2)) * 0.5 + random.choice([0.0, 2e-3], (40, 2))
    walk = np.cumsum(steps, axis=0)
    segments = np.hstack([walk[:-1], walk[1:]])
    segments = segments[np.hypot(*(segments[:, 2:] - segments[:, :2]).T) > 0.01]
    whose = np.sort(random.integers(0, owners, len(segments)))
    random.shuffle(whose[: len(whose) // 2])
    parts = [segments[whose == k] for k in range(owners)]
    begins = np.cumsum([0, *map(len, parts)])
    arcs.replace(FrontierChanges(np.arange(owners), begins, np.concatenate(parts), segments))
    ends = np.concatenate([arc_ends(part) for part in parts])
    meet = (np.abs(ends[:, None, 2:4] - ends[None, :, 0:2]) <= ENDS_MEET_M).all(axis=2)
    _, group = connected_components(meet, directed=False)
    joined = np.bincount(group, ends[:, 4])[group]
    first = 0
    for k, part in enumerate(parts):
        labels, count = arc_labels(part)
        lengths = joined[first : first + count]
        first += count
        if (np.abs(lengths - shortest) < 1e-9).any():
            continue
        expected = part[(lengths >= shortest)[labels]]
        assert np.array_equal(arcs.wide_enough(k, np.arange(owners), shortest), expected)
