"""Areas on strips, against polygon unions by GEOS and against areas worked out by hand."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.grids.strip_map import OUTSIDE, StripMap
from multisrt.geometry.grids.strips import runs_of, runs_of_polygon, strips

FRAME = np.array([(0.0, 0.0, 20.0, 0.0), (20.0, 20.0, 0.0, 20.0)])
"""Walls of a world of 20 x 20 m."""


def box(x0, y0, x1, y1):
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], np.float64)


def edges_of(*rings):
    return np.vstack([np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in rings])


def union_area(cut, regions):
    plane = StripMap(cut, 2)
    plane.relabel(runs_of(cut, regions), [[1, 1]])
    return plane.areas_m2[1]


def test_borders_lie_at_walls_along_the_strips():
    cut = strips(edges_of(box(0, 0, 4, 3), box(1, 1.37, 2, 2.11)), 0.25)
    borders = cut.middles - cut.heights / 2
    for wall in (0.0, 1.37, 2.11):
        assert np.abs(borders - wall).min() < 1e-12
    assert cut.heights.sum() == pytest.approx(3.0)
    assert cut.heights.max() <= 0.25


@pytest.mark.parametrize("tilt_rad", [0.0, 0.19, -1.0])
def test_the_frame_turns_points_into_the_direction_of_the_strips(tilt_rad):
    cut = strips(FRAME, 0.1, tilt_rad)
    along = np.array([(np.cos(tilt_rad), np.sin(tilt_rad))])
    assert cut.frame(3.0 * along) == pytest.approx(np.array([(3.0, 0.0)]), abs=1e-12)


def test_rectangles_along_the_strips_are_exact():
    boxes = [box(1, 1, 5, 4), box(3, 2, 9, 6), box(1, 1, 5, 4), box(15, 0, 20, 20)]
    cut = strips(edges_of(*boxes), 0.3)
    assert union_area(cut, boxes) == pytest.approx(12 + 24 - 4 + 100, abs=1e-9)


def test_labels_count_how_often_a_place_was_covered():
    cut = strips(FRAME, 0.5)
    plane = StripMap(cut, 4)
    regions = [box(0, 0, 10, 10), box(5, 0, 15, 10), box(5, 0, 10, 10)]
    history = plane.relabel(runs_of(cut, regions), [[1, 2, 3, 3]])
    assert history[:, 1:] == pytest.approx(np.array([(100, 0, 0), (100, 50, 0), (100, 0, 50)]))
    twice = plane.mapped([OUTSIDE, OUTSIDE, 1, 1], 2)
    assert twice.areas_m2[1] == pytest.approx(50.0)
    assert plane.areas_m2[1] == pytest.approx(100.0)


def test_regions_may_come_in_any_order_and_more_than_once():
    cut = strips(FRAME, 0.5)
    runs = runs_of(cut, [box(0, 0, 4, 4), box(2, 0, 6, 4), np.empty((0, 2))])
    plane = StripMap(cut, 3)
    history = plane.relabel(runs, [[1, 1, 1], [2, 2, 2]], [1, 0, 2, 1], [0, 0, 1, 1])
    assert history[:, 1:] == pytest.approx(np.array([(16, 0), (24, 0), (24, 0), (8, 16)]))


@pytest.mark.parametrize("seed", range(8))
def test_intervals_that_are_not_wanted_change_nothing(seed):
    rng = np.random.default_rng(seed)
    cut = strips(FRAME, 0.3, 0.19)
    fans = [rng.uniform(0, 20, (5, 2)) for _ in range(12)]
    unseen, seen = 1, 2
    planes = [StripMap(cut, 3), StripMap(cut, 3)]
    for plane in planes:
        plane.relabel(runs_of(cut, [box(2, 3, 7, 5), box(4, 12, 19, 13)]), [[unseen, unseen, seen]])
    wanted = planes[0].runs(unseen)
    all_runs, some = runs_of(cut, fans), runs_of(cut, fans, wanted)
    assert len(some.strip) < 0.7 * len(all_runs.strip)
    histories = [
        plane.relabel(runs, [[OUTSIDE, seen, seen]])
        for plane, runs in zip(planes, (all_runs, some), strict=True)
    ]
    assert histories[0].tolist() == histories[1].tolist()
    assert histories[0][-1, seen] > 1.0
    for one, other in zip(planes[0].runs(seen), planes[1].runs(seen), strict=True):
        assert one.tolist() == other.tolist()


def test_what_has_a_label_is_one_region():
    cut = strips(FRAME, 0.5)
    plane = StripMap(cut, 2)
    plane.relabel(runs_of(cut, [box(0, 0, 4, 4), box(8, 0, 9, 4)]), [[1, 1]])
    again = StripMap(cut, 2)
    again.relabel(plane.runs(1), [[1, 1]])
    assert again.areas_m2[1] == pytest.approx(20.0)
    assert len(plane.runs(1).starts) == 2


def test_a_polygon_with_holes():
    polygon = shapely.box(1, 1, 9, 9) - shapely.box(2, 2, 5, 4) - shapely.box(6, 6, 7, 8)
    assert isinstance(polygon, shapely.Polygon)
    edges = edges_of(*(shapely.get_coordinates(r)[:-1] for r in polygon.interiors), box(1, 1, 9, 9))
    cut = strips(edges, 0.4)
    runs = runs_of_polygon(cut, polygon)
    assert ((runs.end - runs.begin) * cut.heights[runs.strip]).sum() == pytest.approx(56.0)


def test_shared_borders_leave_no_slits():
    """Fans of triangles about a point, whose sides are shared, cover their disc."""
    angles = np.linspace(0.0, 2.0 * np.pi, 38)
    rim = np.column_stack([np.cos(angles), np.sin(angles)]) * 5.0 + 10.0
    fans = [np.array([(10.0, 10.0), rim[k], rim[k + 1]]) for k in range(37)]
    cut = strips(FRAME, 0.05, 0.19)
    plane = StripMap(cut, 2)
    plane.relabel(runs_of(cut, fans), [[1, 1]])
    # One interval on each strip, and none between.
    assert np.unique(plane.runs(1).strip, return_counts=True)[1].max() == 1


BOXES = st.tuples(
    st.floats(0.0, 15.0), st.floats(0.0, 15.0), st.floats(0.1, 5.0), st.floats(0.1, 5.0)
)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(BOXES, st.floats(0.0, 3.0)), min_size=1, max_size=12))
def test_unions_of_turned_rectangles_agree_with_geos(drawn):
    polygons = [
        shapely.affinity.rotate(shapely.box(x, y, x + w, y + h), angle, use_radians=True)
        for (x, y, w, h), angle in drawn
    ]
    regions = [shapely.get_coordinates(p)[:-1] for p in polygons]
    world = np.array([(-10.0, -10.0, 30.0, -10.0), (30.0, 30.0, -10.0, 30.0)])
    for height_m, tolerance_m2 in ((0.05, 0.25), (0.01, 0.05)):
        plane = StripMap(strips(world, height_m, 0.19), 2)
        history = plane.relabel(runs_of(plane.cut, regions), [[1, 1]])
        for k, area in enumerate(history[:, 1], 1):
            assert area == pytest.approx(shapely.union_all(polygons[:k]).area, abs=tolerance_m2)
        assert (np.diff(history[:, 1]) >= -1e-9).all()


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 2), st.integers(0, 18), st.integers(1, 12)), max_size=30))
def test_labels_agree_with_columns_of_whole_metres(story):
    """Boxes of whole metres over the whole height, relabelled by one of three tables."""
    tables = [[0, 1, 2, 3], [1, 2, 3, 0], [3, 3, 1, 1]]
    cut = strips(FRAME, 7.0)
    plane = StripMap(cut, 4)
    columns = np.zeros(32, np.int64)
    regions = [box(x, 0, x + width, 20) for _, x, width in story]
    if story:
        history = plane.relabel(
            runs_of(cut, regions), tables, range(len(story)), [table for table, _, _ in story]
        )
    for k, (table, x, width) in enumerate(story):
        columns[x : x + width] = np.array(tables[table])[columns[x : x + width]]
        counted = [20.0 * np.count_nonzero(columns == label) for label in (1, 2, 3)]
        assert history[k, 1:] == pytest.approx(np.array(counted), abs=1e-6)
