"""The border of a growing union, against one that is computed at once."""

from unittest import mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions import union_border
from multisrt.geometry.regions.segment_difference import uncovered
from multisrt.geometry.regions.union_border import UnionBorder


def box(x, y, width, height):
    return np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)])


def star(rng):
    size = int(rng.integers(5, 60))
    angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, size))
    radii = rng.uniform(0.3, 3.0, size)
    corners = np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])
    return corners + rng.uniform(0.0, 8.0, 2)


def drawn(rng):
    """Boxes on a coarse grid, so that many edges are the same, and stars."""
    if rng.random() < 0.6:
        return box(*(0.5 * rng.integers(0, 12, 2)), *(0.5 * rng.integers(1, 8, 2)))
    return star(rng)


def meeting(rings, window):
    x0, y0, x1, y1 = window
    boxes = rings.boxes[: len(rings)]
    return np.flatnonzero(
        (boxes[:, 0] <= x1) & (boxes[:, 2] >= x0) & (boxes[:, 1] <= y1) & (boxes[:, 3] >= y0)
    )


def computed_at_once(rings, indices, window):
    """The pieces of the edges of some rings in a window that lie in no ring at all."""
    x0, y0, x1, y1 = window
    ends = [rings.ring(k) for k in indices.tolist()]
    edges = np.vstack([np.hstack([np.roll(ring, 1, axis=0), ring]) for ring in ends])
    low, high = np.minimum(edges[:, :2], edges[:, 2:]), np.maximum(edges[:, :2], edges[:, 2:])
    inside = (high >= (x0, y0)).all(axis=1) & (low <= (x1, y1)).all(axis=1)
    everything = np.arange(len(rings))
    segments = np.ascontiguousarray(edges[inside])
    return uncovered(segments, rings.arrays(everything), everything)[0]


@pytest.mark.parametrize("most_edges", [1, 60, union_border.MOST_EDGES])
@given(seed=st.integers(0, 100_000))
def test_a_border_kept_is_one_computed_at_once_to_the_bit(most_edges, seed):
    with mock.patch.object(union_border, "MOST_EDGES", most_edges):
        compare_with_those_computed_at_once(seed)


def compare_with_those_computed_at_once(seed):
    rng = np.random.default_rng(seed)
    rings = Rings([drawn(rng)])
    border = UnionBorder(rings)
    for _ in range(8):
        for _ in range(int(rng.integers(0, 5))):
            rings.add(drawn(rng))
        x, y = rng.uniform(0.0, 8.0, 2)
        half = rng.choice([0.5, 2.0, 9.0])
        window = (x - half, y - half, x + half, y + half)
        indices = rng.permutation(meeting(rings, window))
        if len(indices):
            found = border.within(indices, window).tolist()
            expected = computed_at_once(rings, indices, window).tolist()
            assert {*map(tuple, found)} == {*map(tuple, expected)}
            assert len(found) <= len(expected)


def test_edges_that_are_the_same_are_there_once():
    rings = Rings([box(0, 0, 2, 2), box(1, 0, 1, 2), box(0, 0, 2, 2)])
    border = UnionBorder(rings)
    window = (-9.0, -9.0, 9.0, 9.0)
    lower, right, upper, left = [0, 0, 2, 0], [2, 0, 2, 2], [2, 2, 0, 2], [0, 2, 0, 0]
    found = border.within(np.array([0, 2]), window)
    assert found.tolist() == [left, lower, right, upper]
    assert len(border.within(np.array([0, 1, 2]), window)) == 6


def test_edges_that_are_kept_are_bounded():
    boxes = [box(3.0 * k, 0.0, 2.0, 2.0) for k in range(300)]
    border = UnionBorder(Rings(boxes))
    with mock.patch.object(union_border, "MOST_EDGES", 100):
        for k in range(300):
            assert len(border.within(np.array([k]), (3.0 * k, 0.0, 3.0 * k + 2.0, 2.0))) == 4
            assert border._held <= 100


def test_there_is_room_for_many_edges_and_covers():
    # A comb of narrow boxes under a stack of wide ones: each edge is covered in many places.
    comb = [box(0.2 * k, 0.0, 0.1, 10.0) for k in range(100)]
    rows = [box(-1.0, 0.2 * k, 30.0, 0.1) for k in range(50)]
    rings = Rings(comb)
    border = UnionBorder(rings)
    everything = (-99.0, -99.0, 99.0, 99.0)
    assert len(border.within(np.arange(100), everything)) == 400
    for row in rows:
        rings.add(row)
    indices = np.arange(150)
    found = border.within(indices, everything)
    assert found.tolist() == computed_at_once(rings, indices, everything).tolist()
    assert len(found) > 2 * 100 * 49


def test_rings_beyond_the_window_cover_what_reaches_out_of_it():
    rings = Rings([box(0, 0, 4, 1), box(3, 0.5, 4, 1)])
    found = UnionBorder(rings).within(np.array([0]), (0.0, 0.0, 2.0, 1.0))
    assert found.tolist() == [[0, 1, 0, 0], [0, 0, 4, 0], [3, 1, 0, 1]]


def test_edges_that_many_rings_hide_together_take_no_room():
    # No box hides the line beneath them alone; all of them overlap on it.
    rings = Rings([box(0.0, 0.0, 10.0, 0.5)])
    border = UnionBorder(rings)
    everything = (-99.0, -99.0, 99.0, 99.0)
    for k in range(400):
        rings.add(box(0.025 * k - 0.5, -1.0 - 0.001 * k, 1.0, 3.0))
        border.within(np.arange(k + 2), everything)
    lower = [edge for edge in border.within(np.arange(401), everything) if edge[1] == edge[3] == 0]
    assert lower == []
    # The boxes hide all but the ends of each other's edges.
    assert border._covers.tally[0] < 3000
