"""Rings in a few arrays: corners are kept, and boxes are tight."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.numerics.rings import STRETCH, Rings, first_stretch
from multisrt.geometry.regions.segment_difference import uncovered

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
    starts, corners, boxes, stretches = rings.arrays
    free_row = 0
    for k, ring in enumerate(given_rings):
        assert np.array_equal(rings.ring(k), ring)
        assert np.array_equal(corners[starts[k] : starts[k + 1]], ring)
        assert boxes[k].tolist() == [*ring.min(axis=0), *ring.max(axis=0)]
        row = first_stretch(k, starts[k])
        assert row >= free_row
        for first in range(0, len(ring), STRETCH):
            # With the corner at which the first edge begins.
            points = ring[np.arange(first - 1, min(first + STRETCH, len(ring)))]
            assert stretches[row].tolist() == [*points.min(axis=0), *points.max(axis=0)]
            row += 1
        free_row = row


def test_adding_a_ring_changes_no_other():
    rings = Rings([wavy(40)])
    held, ring = rings.arrays, rings.ring(0)
    before = [array.copy() for array in (held.starts[:2], held.corners[:40], held.boxes[:1])]
    for k, size in enumerate(SIZES):
        assert rings.add(wavy(size, k)) == k + 1
    assert np.array_equal(ring, before[1])
    now = rings.arrays
    for array, old in zip((now.starts[:2], now.corners[:40], now.boxes[:1]), before, strict=True):
        assert np.array_equal(array, old)


@pytest.mark.parametrize("corners", SIZES)
def test_uncovered_agrees_with_shapely_for_long_rings(corners):
    around = [(0.0, 0.0), (2.5, 1.0), (-3.0, 4.0)]
    rings = [wavy(corners, seed, at) for seed, at in enumerate(around)]
    rng = np.random.default_rng(corners)
    segments = rng.uniform(-6.0, 6.0, (60, 4))
    # Some are vertical or horizontal, and only just miss the boxes.
    segments[:10, 2], segments[10:20, 3] = segments[:10, 0], segments[10:20, 1]
    rest, source = uncovered(segments, Rings(rings).arrays, np.arange(len(rings)))
    covered = shapely.union_all(shapely.polygons(rings))
    for k, segment in enumerate(segments):
        truth = shapely.LineString(segment.reshape(2, 2)).difference(covered)
        left = rest[source == k]
        length = np.hypot(left[:, 2] - left[:, 0], left[:, 3] - left[:, 1]).sum()
        assert length == pytest.approx(truth.length, abs=1e-3)
