"""Rings, and arrays of those in use: corners are kept, and boxes are tight."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.numerics.rings import ABSENT, ROOM, STRETCH, RingArrays, Rings
from multisrt.geometry.regions.segment_difference import uncovered

ALL = np.arange(3)
SIZES = [3, STRETCH - 1, STRETCH, STRETCH + 1, 4 * STRETCH, 360, 3, 5000]


def wavy(corners: int, seed: int = 0, at: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Return a ring around a place with a random distance in every direction."""
    rng = np.random.default_rng(seed)
    angle = np.arange(corners) * 2 * np.pi / corners
    waves = 3.0 + np.sin(7 * angle + seed) + 0.3 * rng.random(corners)
    return np.column_stack((np.cos(angle), np.sin(angle))) * waves[:, None] + at


@settings(max_examples=40, deadline=None)
@given(st.lists(st.sampled_from(SIZES[:-1]), max_size=90))
def test_boxes_of_rings_and_stretches_are_tight(sizes):
    given_rings = [wavy(size, seed) for seed, size in enumerate(sizes)]
    rings = Rings(given_rings)
    assert len(rings) == len(sizes)
    spans, corners, boxes, stretches = rings.arrays(np.arange(len(sizes)))
    free_row = free_corner = 0
    for k, ring in enumerate(given_rings):
        assert np.array_equal(rings.ring(k), ring)
        first, count, row = spans[k].tolist()
        assert (first, count) == (free_corner, len(ring))
        assert np.array_equal(corners[first : first + count], ring)
        assert boxes[k].tolist() == [*ring.min(axis=0), *ring.max(axis=0)]
        assert row >= free_row
        for first in range(0, len(ring), STRETCH):
            # With the corner at which the first edge begins.
            points = ring[np.arange(first - 1, min(first + STRETCH, len(ring)))]
            assert stretches[row].tolist() == [*points.min(axis=0), *points.max(axis=0)]
            row += 1
        free_row, free_corner = row, free_corner + count


def corners_in(arrays: RingArrays, index: int) -> np.ndarray:
    first, count, _ = arrays.spans[index].tolist()
    return arrays.corners[first : first + count]


def test_adding_a_ring_changes_no_other():
    rings = Rings([wavy(40)])
    first = rings.arrays(np.array([0]))
    ring, box = corners_in(first, 0).copy(), first.boxes[0].copy()
    for k, size in enumerate(SIZES):
        assert rings.add(wavy(size, k)) == k + 1
    now = rings.arrays(np.array([0, len(SIZES)]))
    assert np.array_equal(corners_in(now, 0), ring)
    assert np.array_equal(now.boxes[0], box)
    assert np.array_equal(rings.ring(0), ring)


def test_rings_of_several_sequences_are_held_once():
    ring = wavy(100)
    assert Rings([ring]).ring(0) is Rings([ring]).ring(0) is ring


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000))
def test_corners_are_there_when_asked_for_and_take_bounded_room(seed):
    rng = np.random.default_rng(seed)
    given_rings = [wavy(int(size), k) for k, size in enumerate(rng.integers(3, ROOM // 4, 24))]
    rings, most = Rings(given_rings), ROOM
    for _ in range(12):
        asked = rng.permutation(24)[: int(rng.integers(1, 12))]
        arrays = rings.arrays(asked)
        most = max(most, sum(len(given_rings[k]) for k in asked.tolist()))
        assert len(arrays.corners) <= most
        for k in range(24):
            if k in asked:
                assert np.array_equal(corners_in(arrays, k), given_rings[k])
            elif arrays.spans[k, 0] != ABSENT:
                assert np.array_equal(corners_in(arrays, k), given_rings[k])
                row = int(arrays.spans[k, 2])
                points = given_rings[k][np.arange(-1, min(STRETCH, len(given_rings[k])))]
                assert arrays.stretches[row].tolist() == [*points.min(axis=0), *points.max(axis=0)]


@pytest.mark.parametrize("corners", SIZES)
def test_uncovered_agrees_with_shapely_for_long_rings(corners):
    around = [(0.0, 0.0), (2.5, 1.0), (-3.0, 4.0)]
    rings = [wavy(corners, seed, at) for seed, at in enumerate(around)]
    rng = np.random.default_rng(corners)
    segments = rng.uniform(-6.0, 6.0, (60, 4))
    # Some are vertical or horizontal, and only just miss the boxes.
    segments[:10, 2], segments[10:20, 3] = segments[:10, 0], segments[10:20, 1]
    rest, source = uncovered(segments, Rings(rings).arrays(ALL), ALL)
    covered = shapely.union_all(shapely.polygons(rings))
    for k, segment in enumerate(segments):
        truth = shapely.LineString(segment.reshape(2, 2)).difference(covered)
        left = rest[source == k]
        length = np.hypot(left[:, 2] - left[:, 0], left[:, 3] - left[:, 1]).sum()
        assert length == pytest.approx(truth.length, abs=1e-3)
