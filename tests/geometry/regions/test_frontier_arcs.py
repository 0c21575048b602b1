"""Frontier arcs, piece by piece, against shapely and against dense sampling."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import box

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.boundary import CUT, GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.frontier_arcs import (
    arc_ends,
    arc_labels,
    frontier_candidates,
    in_long_arcs,
    is_wide_chain,
    total_length,
)
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.geometry.regions.segment_difference import uncovered

R = 4.0


def regions(worlds, free, places, shape="radial", range_m=R, beams=None):
    index = worlds.index(free, range_m)
    return [
        local_safe_region(take_scan(index, Configuration(x, y), 0.0, range_m, beams), shape)
        for x, y in np.asarray(places).tolist()
    ]


def frontier(subtracting, region, others):
    return subtracting.take(
        frontier_candidates(region.boundary, region.tags), [other.boundary for other in others]
    )


def lines(segments):
    return shapely.multilinestrings(shapely.linestrings(segments.reshape(-1, 2, 2)))


def samples_beside(segments, shift, step=0.01):
    """Return points along segments, shifted to their right, and the segment of each."""
    points, owner = [np.empty((0, 2))], [np.empty(0, int)]
    for k, (x0, y0, x1, y1) in enumerate(segments):
        length = np.hypot(x1 - x0, y1 - y0)
        if length < 1e-5:
            continue
        at = (np.arange(max(1, int(length / step))) + 0.5) / max(1, int(length / step))
        out = np.array([y1 - y0, x0 - x1]) / length * shift
        points.append(np.column_stack([x0 + at * (x1 - x0), y0 + at * (y1 - y0)]) + out)
        owner.append(np.full(len(at), k))
    return np.vstack(points), np.concatenate(owner)


def test_candidates_are_all_pieces_but_obstacles():
    boundary = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    tags = np.array([OBSTACLE, RANGE, GAP, CUT], np.int8)
    assert frontier_candidates(boundary, tags).tolist() == [
        [2, 0, 2, 1],
        [2, 1, 0, 1],
        [0, 1, 0, 0],
    ]
    assert frontier_candidates(boundary, tags, include_gaps=False).tolist() == [
        [2, 0, 2, 1],
        [0, 1, 0, 0],
    ]


def test_the_order_of_the_polygons_makes_no_difference(worlds):
    free = worlds.office()
    known = [r.boundary for r in regions(worlds, free, worlds.viewpoints(free, 12, seed=44))]
    segments = np.hstack([known[0], np.roll(known[0], -1, axis=0)])
    others = np.arange(1, len(known))
    rest, source = uncovered(segments, Rings(known).arrays(others), others)
    assert 0 < len(np.unique(source)) < len(segments)
    for seed in range(20):
        order = np.random.default_rng(seed).permutation(others)
        asked = order.copy()
        again, again_source = uncovered(segments, Rings(known).arrays(order), order)
        assert np.array_equal(again, rest)
        assert np.array_equal(again_source, source)
        assert np.array_equal(order, asked)


def test_a_frontier_collinear_with_a_neighbours_gap_is_kept(subtracting, worlds):
    # Both see past the obstacle's corner (3, 3) along the diagonal: neither has seen behind the
    # line from there to (4, 4). The difference of lines and polygons deletes it.
    free = box(0, 0, 10, 10).difference(box(3, 0, 3.5, 3))
    first, second = regions(worlds, free, [(1, 1), (2, 2)], range_m=5.0)
    arcs = frontier(subtracting, first, [second])
    gap = shapely.LineString([(3, 3), (4, 4)]).buffer(1e-4)
    assert lines(arcs).intersection(gap).length == pytest.approx(np.sqrt(2), abs=2e-4)
    deleted = lines(frontier_candidates(first.boundary, first.tags)).difference(second.polygon())
    assert deleted.intersection(gap).length < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
@pytest.mark.parametrize(("shape", "beams"), [("radial", None), ("star", None), ("radial", 360)])
def test_arcs_equal_those_of_shapely(subtracting, worlds, name, shape, beams):
    free = worlds.WORLDS[name]()
    known = regions(worlds, free, worlds.viewpoints(free, 14, seed=41), shape, beams=beams)
    lengths = 0.0
    for i, region in enumerate(known):
        others = known[:i] + known[i + 1 :]
        arcs = frontier(subtracting, region, others)
        truth = lines(frontier_candidates(region.boundary, region.tags))
        for other in others:
            truth = truth.difference(other.polygon())
        lengths += truth.length
        # More is left only where an arc meets a wall so flatly that its double enters the wall.
        assert lines(arcs).difference(truth.buffer(1e-4)).length < 1e-3
        assert truth.difference(lines(arcs).buffer(2e-4)).length < 1e-6
    assert lengths > 10.0


@pytest.mark.parametrize("name", ["office", "clutter"])
def test_arcs_by_dense_sampling(worlds, name):
    # A point beside a candidate is seen by another region, or belongs to the frontier: never both.
    free = worlds.WORLDS[name]()
    known = regions(worlds, free, worlds.viewpoints(free, 12, seed=42))
    checked = [0, 0]
    for i, region in enumerate(known):
        others = known[:i] + known[i + 1 :]
        polygons = [other.polygon() for other in others]
        candidates = frontier_candidates(region.boundary, region.tags)
        points, owner = samples_beside(candidates, 1e-6)
        seen = np.zeros(len(points), bool)
        for polygon in polygons:
            seen |= shapely.contains_xy(polygon, points[:, 0], points[:, 1])
        numbers = np.arange(len(others))
        rings = Rings([o.boundary for o in others]).arrays(numbers)
        rest, source = uncovered(candidates, rings, numbers)
        for k in range(len(candidates)):
            mine = owner == k
            if not mine.any():
                continue
            pieces = shapely.linestrings(rest[source == k].reshape(-1, 2, 2))
            distance = np.full(mine.sum(), np.inf)
            for piece in pieces:
                distance = np.minimum(
                    distance, shapely.distance(piece, shapely.points(points[mine]))
                )
            in_frontier = distance < 2e-6
            assert (in_frontier == ~seen[mine]).all()
            checked[0] += int(in_frontier.sum())
            checked[1] += int((~in_frontier).sum())
    assert min(checked) > 500


@given(st.integers(0, 10_000))
def test_more_regions_never_leave_more(subtracting, worlds, seed):
    free = worlds.pillar()
    known = regions(worlds, free, worlds.viewpoints(free, 5, seed=seed), range_m=3.0)
    before = np.inf
    covered = shapely.Polygon()
    for count in range(1, len(known)):
        arcs = frontier(subtracting, known[0], known[1 : 1 + count])
        assert total_length(arcs) <= before + 1e-9
        before = total_length(arcs)
        union = covered.union(known[count].polygon())
        assert union.area >= covered.area - 1e-9
        covered = union
        # What is left lies in the interior of no other region.
        if len(arcs):
            points, _ = samples_beside(arcs, 1e-6, step=0.1)
            for other in known[1 : 1 + count]:
                inner = other.polygon().buffer(-1e-6)
                assert not shapely.contains_xy(inner, points[:, 0], points[:, 1]).any()


def test_a_fully_seen_hall_has_no_frontier(subtracting, worlds):
    free = worlds.pillar()
    places = [(2, 2), (8, 2), (8, 8), (2, 8)]
    known = regions(worlds, free, places, range_m=15.0)
    for i, region in enumerate(known):
        assert total_length(frontier(subtracting, region, known[:i] + known[i + 1 :])) < 1e-4


def test_utm_coordinates_leave_the_same_lengths(subtracting, worlds):
    free = worlds.office()
    places = worlds.viewpoints(free, 10, seed=43)
    here = regions(worlds, free, places)
    there = regions(
        worlds, shapely.affinity.translate(free, 5e5, 4.5e6), places + np.array([5e5, 4.5e6])
    )
    for i in range(len(places)):
        a = total_length(frontier(subtracting, here[i], here[:i] + here[i + 1 :]))
        b = total_length(frontier(subtracting, there[i], there[:i] + there[i + 1 :]))
        assert a == pytest.approx(b, abs=1e-4)


# Arcs


def test_segments_that_follow_each_other_are_one_arc():
    segments = np.array(
        [[0.0, 0, 1, 0], [1, 0, 1, 1], [5, 5, 6, 5], [6, 5, 6, 6], [6, 6, 7, 6], [9, 9, 9, 8]]
    )
    labels, count = arc_labels(segments)
    assert labels.tolist() == [0, 0, 1, 1, 1, 2]
    assert count == 3


def test_an_arc_may_run_over_the_end_of_the_list():
    segments = np.array([[0.0, 0, 1, 0], [5, 5, 6, 5], [-1, 0, 0, 0]])
    labels, count = arc_labels(segments)
    assert labels.tolist() == [0, 1, 0]
    assert count == 2


def test_the_only_arc_may_run_over_the_end_of_the_list():
    # It begins with the last segment: another arc that begins at its end is joined to it.
    only = np.array([[1.0, 0, 2, 0], [2, 0, 3, 0], [0, 0, 1, 0]])
    assert arc_ends(only).tolist() == [[0.0, 0.0, 3.0, 0.0, 3.0]]
    following = arc_ends(np.array([[3.0, 0, 3, 2]]))
    ends = np.concatenate([arc_ends(only), following])
    assert is_wide_chain(ends, 0, 5.0)
    assert not is_wide_chain(ends, 0, 5.1)


def test_a_closed_arc_is_one():
    corners = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    labels, count = arc_labels(np.hstack([corners, np.roll(corners, -1, axis=0)]))
    assert labels.tolist() == [0, 0, 0, 0]
    assert count == 1


def test_no_segments_have_no_arcs():
    labels, count = arc_labels(np.empty((0, 4)))
    assert len(labels) == count == 0
    assert total_length(np.empty((0, 4))) == 0.0


def test_only_segments_in_arcs_that_are_long_enough():
    segments = np.array(
        [[0.0, 0, 0.3, 0], [0.3, 0, 0.3, 0.3], [5, 5, 5.5, 5], [-0.1, 0, 0, 0], [7, 7, 7, 9]]
    )
    # The first two are 0.6 m together; the fourth begins elsewhere than the third ends.
    assert in_long_arcs(segments, 0.55).tolist() == [True, True, False, False, True]
    assert in_long_arcs(segments, 0.0).all()
    assert in_long_arcs(np.empty((0, 4)), 1.0).tolist() == []
