"""Known space, which computes no union, against the union that shapely computes."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Point, box

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan

WINDOW = (0.0, 0.0, 6.0, 6.0)
CLOSE_M = 1e-3
"""Distance in metres from the border within which either answer is right."""


def space(polygons, window=WINDOW):
    rings = [np.array(shapely.orient_polygons(p).exterior.coords)[:-1] for p in polygons]
    return KnownSpace(Rings(rings), np.arange(len(rings)), window)


def union(polygons, window=WINDOW):
    """Return the union in the window, with cracks of rounding closed."""
    return shapely.union_all(polygons).intersection(box(*window)).buffer(1e-7, join_style="mitre")


def steps(low, high):
    return st.integers(low, high).map(lambda k: 0.5 * k)


@st.composite
def many_boxes(draw):
    """Boxes on a coarse grid: borders that lie along each other are the rule."""
    corner = st.tuples(steps(-1, 10), steps(-1, 10), steps(1, 6), steps(1, 6))
    return [
        box(x, y, x + w, y + h) for x, y, w, h in draw(st.lists(corner, min_size=1, max_size=6))
    ]


@st.composite
def many_stars(draw):
    polygons = []
    for _ in range(draw(st.integers(1, 5))):
        x, y = draw(st.floats(0.0, 6.0)), draw(st.floats(0.0, 6.0))
        radii = np.array(draw(st.lists(st.floats(0.3, 2.5), min_size=5, max_size=12)))
        angles = np.arange(len(radii)) * (2.0 * np.pi / len(radii))
        corners = np.column_stack([x + radii * np.cos(angles), y + radii * np.sin(angles)])
        polygons.append(shapely.Polygon(corners))
    return polygons


worlds_of_polygons = st.one_of(many_boxes(), many_stars())
places = st.tuples(st.floats(0.01, 5.99), st.floats(0.01, 5.99))


@pytest.mark.slow
@given(worlds_of_polygons, st.lists(places, min_size=1, max_size=8))
def test_clearance_inside_is_that_of_the_union(polygons, some):
    known, exact = space(polygons), union(polygons)
    points = np.array(some)
    for (x, y), holds, clearance in zip(
        some, known.holds(points), known.clearances(points, 2.0), strict=True
    ):
        away = exact.boundary.distance(Point(x, y))
        if away > CLOSE_M:
            assert holds == exact.contains(Point(x, y))
        if holds and away > CLOSE_M:
            assert clearance == pytest.approx(min(away, 2.0), abs=CLOSE_M)


@pytest.mark.slow
@given(worlds_of_polygons, st.lists(places, min_size=2, max_size=12), st.floats(0.01, 0.6))
def test_a_path_is_free_where_the_union_holds_its_swath(polygons, stops, radius):
    known, exact = space(polygons), union(polygons)
    for start, end in pairwise(stops):
        gap = exact.boundary.distance(LineString([start, end]))
        if exact.contains(Point(start).buffer(radius)) and abs(gap - radius) > CLOSE_M:
            assert known.passes(np.array([[*start, *end]]), radius)[0] == (gap > radius)


@given(worlds_of_polygons, st.lists(places, min_size=2, max_size=12))
def test_lines_of_sight_lie_inside_the_union(polygons, some):
    known, exact = space(polygons), union(polygons)
    for eye in some:
        if exact.buffer(-CLOSE_M).contains(Point(eye)):
            require_sight(known, exact, eye, np.array(some))


def require_sight(known, exact, eye, some):
    """Assert that places are in sight exactly if the line to them lies inside the union."""
    clearly, hardly = exact.buffer(-CLOSE_M), exact.buffer(CLOSE_M)
    for place, sees in zip(some, known.sees(*eye, some), strict=True):
        line = LineString([eye, place])
        if clearly.contains(line):
            assert sees
        elif not hardly.contains(line):
            assert not sees


def test_regions_on_two_sides_of_a_line_have_no_border():
    known = space([box(1, 1, 3, 3), box(3, 1, 5, 3)])
    assert known.passes(np.array([[1.5, 2.0, 4.5, 2.0]]), 0.4)[0]
    assert known.sees(1.5, 2.0, np.array([[4.5, 2.0]]))[0]
    assert shapely.multilinestrings(known.border[:-4].reshape(-1, 2, 2)).length == pytest.approx(12)


def test_a_wall_at_which_regions_end_from_one_side_stays():
    # Both end at the line y = 3 from below: nothing is known beyond.
    known = space([box(1, 1, 3, 3), box(2, 1, 5, 3)])
    assert known.clearances(np.array([[2.5, 2.7]]), 1.0)[0] == pytest.approx(0.3)
    assert not known.sees(2.5, 2.7, np.array([[2.5, 3.2]]))[0]


def test_a_hole_between_regions_is_seen_round():
    ring = [box(1, 1, 5, 2), box(4, 1, 5, 5), box(1, 4, 5, 5), box(1, 1, 2, 5)]
    known = space(ring)
    assert not known.holds(np.array([[3.0, 3.0]]))[0]
    assert known.sees(1.5, 1.5, np.array([[1.5, 4.5], [4.5, 1.5], [4.5, 4.5]])).tolist() == [
        True,
        True,
        False,
    ]


def test_beyond_the_window_nothing_is_known():
    known = space([box(-5, -5, 11, 11)])
    inside = np.array([[5.8, 3.0], [3.0, 3.0]])
    np.testing.assert_allclose(known.clearances(inside, 1.0), [0.2, 1.0])
    assert not known.passes(np.array([[3.0, 3.0, 5.8, 3.0]]), 0.3)[0]
    assert known.holds(np.array([[3.0, 3.0], [7.0, 3.0], [3.0, -1.0]])).tolist() == [
        True,
        False,
        False,
    ]


def test_nothing_known_holds_nothing():
    known = KnownSpace(Rings([]), np.empty(0, np.int64), WINDOW)
    assert not known.holds(np.array([[3.0, 3.0]]))[0]
    assert len(known.border) == 4


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
@pytest.mark.parametrize("seed", range(4))
def test_regions_that_robots_see(worlds, name, seed):
    # Radial regions of one world share its walls, up to rounding.
    free = worlds.WORLDS[name]()
    index = worlds.index(free, 4.0)
    views = worlds.viewpoints(free, 12, seed=seed)
    scans = [take_scan(index, Configuration(x, y), 0.0, 4.0) for x, y in views]
    polygons = [local_safe_region(scan, "radial").polygon() for scan in scans]
    x0, y0, x1, y1 = free.bounds
    window = (x0 - 1.0, y0 - 1.0, x1 + 1.0, y1 + 1.0)
    known, exact = space(polygons, window), union(polygons, window)
    points = worlds.viewpoints(free, 200, seed=seed + 100)
    require_sight(known, exact, views[0], points)
    for place, holds, clearance in zip(
        points, known.holds(points), known.clearances(points, 5.0), strict=True
    ):
        away = exact.boundary.distance(Point(place))
        if away > CLOSE_M:
            assert holds == exact.contains(Point(place))
            assert not holds or clearance == pytest.approx(away, abs=CLOSE_M)
