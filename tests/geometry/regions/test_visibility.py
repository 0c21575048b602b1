"""Views against CGAL, shapely and answers by hand."""

import math

import numpy as np
import pytest
import pyvispoly
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon, affinity, box

from multisrt.geometry.errors import ClearanceError
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE, arc_divisions
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.geometry.regions.visibility import visibility_polygon

RAD = math.pi / 360.0
"""Half a degree."""

UNLIMITED = 60.0
"""A range in metres beyond the size of every test world."""


class Cgal:
    """CGAL's visibility polygon, exact, without a range."""

    def __init__(self, free):
        free = shapely.orient_polygons(free)
        self.calculator = pyvispoly.VisibilityPolygonCalculator(
            pyvispoly.PolygonWithHoles(
                self.polygon(free.exterior), [self.polygon(ring) for ring in free.interiors]
            )
        )

    @staticmethod
    def polygon(ring):
        corners = np.asarray(ring.coords)[:-1, :2].tolist()
        return pyvispoly.Polygon([pyvispoly.Point(x, y) for x, y in corners])

    def view(self, x, y):
        seen = self.calculator.compute_visibility_polygon(pyvispoly.Point(float(x), float(y)))
        return Polygon([(float(p.x()), float(p.y())) for p in seen.boundary()])


def assert_same_area(seen, truth, relative):
    assert seen.is_valid
    assert seen.symmetric_difference(truth).area <= relative * truth.area


@pytest.mark.parametrize(("name", "count"), [("rooms", 30), ("office", 20), ("clutter", 6)])
def test_unlimited_view_equals_cgal(worlds, name, count):
    free = worlds.WORLDS[name]()
    index, cgal = worlds.index(free), Cgal(free)
    for x, y in worlds.viewpoints(free, count, seed=21):
        boundary, tags = visibility_polygon(index, x, y, UNLIMITED)
        assert_same_area(Polygon(boundary), cgal.view(x, y), 1e-9)
        assert RANGE not in tags


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rooms", "office", "clutter", "crates"])
@pytest.mark.parametrize("range_m", [0.5, 4.0])
def test_range_cuts_the_view_with_a_disc(worlds, name, range_m):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    for x, y in worlds.viewpoints(free, 15, seed=22):
        whole, _ = visibility_polygon(index, x, y, UNLIMITED)
        boundary, _ = visibility_polygon(index, x, y, range_m, arc_tolerance_m=1e-7)
        truth = Polygon(whole).intersection(worlds.disc(x, y, range_m))
        assert_same_area(Polygon(boundary), truth, 1e-6)


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
def test_chords_lie_inside_the_arc_within_their_tolerance(worlds, name):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    for x, y in worlds.viewpoints(free, 10, seed=23):
        coarse, tags = visibility_polygon(index, x, y, 4.0, arc_tolerance_m=0.05)
        fine, _ = visibility_polygon(index, x, y, 4.0, arc_tolerance_m=1e-6)
        assert Polygon(coarse).difference(Polygon(fine)).area < 1e-5
        middles = ((coarse + np.roll(coarse, -1, axis=0)) / 2)[tags == RANGE]
        depth = 4.0 - np.hypot(*(middles - (x, y)).T)
        assert (depth > -1e-9).all()
        assert (depth < 0.05 + 1e-9).all()


@pytest.mark.parametrize("name", ["rooms", "office", "clutter", "crates"])
def test_tags_say_why_the_view_ends(worlds, name):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    room = free.buffer(1e-7)
    shapely.prepare(room)
    counts = {OBSTACLE: 0, RANGE: 0, GAP: 0}
    for x, y in worlds.viewpoints(free, 20, seed=24):
        boundary, tags = visibility_polygon(index, x, y, 4.0)
        following = np.roll(boundary, -1, axis=0)
        radii = np.hypot(*(boundary - (x, y)).T)
        to_wall = shapely.distance(free.boundary, shapely.points((boundary + following) / 2))
        for i, tag in enumerate(tags):
            counts[int(tag)] += 1
            j = (i + 1) % len(tags)
            if tag == OBSTACLE:
                assert to_wall[i] < 1e-9
            elif tag == RANGE:
                assert radii[i] == pytest.approx(4.0, abs=1e-9)
                assert radii[j] == pytest.approx(4.0, abs=1e-9)
            else:
                # Radial, in free space, and its near end is the corner that hides.
                (ax, ay), (bx, by) = boundary[i] - (x, y), following[i] - (x, y)
                assert abs(ax * by - ay * bx) < 1e-8
                near = boundary[i] if radii[i] < radii[j] else following[i]
                assert free.boundary.distance(Point(near)) < 1e-9
                assert room.covers(LineString([boundary[i], following[i]]))
    assert min(counts.values()) > 10


def test_view_of_an_empty_hall_by_hand(worlds):
    boundary, tags = visibility_polygon(worlds.index(worlds.hall()), 5.0, 5.0, 20.0)
    assert Polygon(boundary).equals(worlds.hall())
    assert (tags == OBSTACLE).all()
    boundary, tags = visibility_polygon(worlds.index(worlds.hall()), 5.0, 5.0, 4.0)
    assert (tags == RANGE).all()
    assert len(boundary) == arc_divisions(4.0, 0.01)


@pytest.mark.parametrize("divisions", [8, 9, 10, 11, 12, 45])
def test_a_whole_circle_has_all_its_corners(worlds, divisions):
    # Among them those on the axes, where the sweep passes from one quadrant to the next.
    tolerance = 4.0 * (1 - math.cos(math.pi / divisions)) * (1 + 1e-9)
    boundary, _ = visibility_polygon(
        worlds.index(worlds.hall()), 5.0, 5.0, 4.0, arc_tolerance_m=tolerance
    )
    angles = 2 * np.pi * np.arange(divisions) / divisions
    assert boundary == pytest.approx(
        5.0 + 4.0 * np.column_stack([np.cos(angles), np.sin(angles)]), abs=1e-12
    )


def test_view_past_a_pillar_by_hand(worlds):
    # From (2, 5) the pillar's near corners (4, 4) and (4, 6) throw shadows onto the right wall
    # at y = 1 and y = 9: the view loses the trapezium between them.
    boundary, tags = visibility_polygon(worlds.index(worlds.pillar()), 2.0, 5.0, UNLIMITED)
    shadow = Polygon([(4, 4), (10, 1), (10, 9), (4, 6)])
    assert_same_area(Polygon(boundary), box(0, 0, 10, 10).difference(shadow), 1e-12)
    assert np.count_nonzero(tags == GAP) == 2
    following = np.roll(boundary, -1, axis=0)
    lengths = np.hypot(*(following - boundary)[tags == GAP].T)
    assert lengths == pytest.approx([math.hypot(6, 3)] * 2)


def test_open_surroundings_are_seen_up_to_the_range():
    clockwise = np.array([[0.0, 0, 0, 1], [0, 1, 1, 1], [1, 1, 1, 0], [1, 0, 0, 0]])
    index = EdgeIndex(clockwise, 1.0)
    _, tags = visibility_polygon(index, -50.0, 0.5, 4.0)
    assert (tags == RANGE).all()
    assert np.isinf(laser_ranges(index, -50.0, 0.5, 4.0, 8)).all()


@pytest.mark.parametrize(
    ("x", "y"), [(5.0, 1e-9), (1e-9, 1e-9), (5.0, 4.0 - 2e-9), (4.0 - 2e-9, 4.0 - 2e-9)]
)
def test_a_hair_off_a_wall_the_view_is_right(worlds, x, y):
    free = worlds.pillar()
    boundary, _ = visibility_polygon(worlds.index(free), x, y, UNLIMITED)
    assert_same_area(Polygon(boundary), Cgal(free).view(x, y), 1e-8)
    assert Polygon(boundary).difference(free).area < 1e-7


def test_a_thin_wall_does_not_leak(worlds):
    free = worlds.hall().difference(box(4.9, 0, 5.1, 8))
    index = worlds.index(free)
    with pytest.raises(ClearanceError):
        visibility_polygon(index, 4.9, 4.0, UNLIMITED)
    boundary, _ = visibility_polygon(index, 4.9 - 2e-9, 4.0, UNLIMITED)
    assert Polygon(boundary).area == pytest.approx(49.0, abs=1e-6)


@given(st.floats(0.0, 360.0), st.floats(0.001, 3.0), st.integers(0, 3), st.booleans())
def test_in_line_with_an_edge_the_side_is_certain(worlds, angle, away, corner, along):
    # On the prolongation of a turned box's side the nearest corner belongs to one edge that is
    # seen edge-on and to one that is not.
    turned = affinity.rotate(box(-0.7, -0.4, 0.7, 0.4), angle, origin=(0, 0))
    corners = np.asarray(turned.exterior.coords)[:-1]
    here, other = corners[corner], corners[(corner + (1 if along else -1)) % 4]
    x, y = here + away * (here - other) / np.hypot(*(here - other))
    index = worlds.index(box(-6, -6, 6, 6).difference(turned))
    boundary, _ = visibility_polygon(index, float(x), float(y), 4.0)
    assert Polygon(boundary).intersection(turned).area < 1e-9


# Degenerate worlds


def test_subdivided_walls_change_nothing(worlds):
    free = worlds.pillar()
    pieces = worlds.index(shapely.segmentize(free, 0.05))
    whole = worlds.index(free)
    for x, y in ((2.0, 2.0), (5.0, 2.0), (4.0, 1.0), (2.0, 4.0), (8.1, 3.3)):
        a, _ = visibility_polygon(pieces, x, y, UNLIMITED)
        b, _ = visibility_polygon(whole, x, y, UNLIMITED)
        assert_same_area(Polygon(a), Polygon(b), 1e-12)


@pytest.mark.parametrize(
    "pair",
    [
        (box(4, 4, 5, 6), box(5, 4, 6, 6)),  # share an edge
        (box(4, 4, 5, 5), box(5, 5, 6, 6)),  # share a vertex
        (box(4, 4, 5, 5), box(5, 4.5, 6, 5.5)),  # share a part of an edge
    ],
)
def test_obstacles_that_touch_are_as_their_union(worlds, pair):
    outward = [worlds.edges(obstacle)[:, [2, 3, 0, 1]] for obstacle in pair]
    index = EdgeIndex(np.vstack([worlds.edges(worlds.hall()), *outward]), 1.3)
    clean = worlds.index(box(0, 0, 10, 10).difference(shapely.union_all(pair)))
    for x, y in ((2.0, 2.0), (2.0, 8.1), (5.5, 2.0), (8.0, 2.0), (3.0, 5.0), (9.0, 5.25)):
        a, _ = visibility_polygon(index, x, y, UNLIMITED)
        b, _ = visibility_polygon(clean, x, y, UNLIMITED)
        assert_same_area(Polygon(a), Polygon(b), 1e-12)


def test_views_from_round_coordinates_are_valid(worlds):
    free = worlds.rooms()
    index = worlds.index(free)
    inner = free.buffer(-0.05)
    lattice = [(x, y) for x in np.arange(0.5, 18, 1.0) for y in np.arange(0.5, 18, 1.0)]
    seen = 0
    for x, y in lattice:
        if shapely.contains_xy(inner, x, y):
            boundary, _ = visibility_polygon(index, x, y, 4.0)
            view = Polygon(boundary)
            assert view.is_valid
            assert view.difference(free).area < 1e-12
            seen += 1
    assert seen > 200


def test_utm_coordinates_keep_millimetres(worlds):
    free = worlds.office()
    there = affinity.translate(free, 5e5, 4.5e6)
    near, far = worlds.index(free), worlds.index(there)
    for x, y in worlds.viewpoints(free, 20, seed=25):
        a, _ = visibility_polygon(near, x, y, 4.0)
        b, tags = visibility_polygon(far, x + 5e5, y + 4.5e6, 4.0)
        moved = affinity.translate(Polygon(b), -5e5, -4.5e6)
        assert Polygon(b).is_valid
        assert moved.symmetric_difference(Polygon(a)).area < 1e-6
        assert set(tags.tolist()) <= {OBSTACLE, RANGE, GAP}
        assert np.allclose(
            laser_ranges(near, x, y, 4.0, 30),
            laser_ranges(far, x + 5e5, y + 4.5e6, 4.0, 30),
            atol=1e-6,
        )


def test_same_query_gives_the_same_bits(worlds):
    index = worlds.index(worlds.clutter())
    first, _ = visibility_polygon(index, 8.0, 8.2, 4.0)
    visibility_polygon(index, 3.0, 3.0, 4.0)
    again, _ = visibility_polygon(index, 8.0, 8.2, 4.0)
    assert np.array_equal(first, again)


def test_nothing_is_seen_through_an_edge_seen_edge_on(worlds):
    # The edge from (0.74, 0) to (0.29, 0.49) points at the viewpoint but for rounding; the floor
    # ends where it begins.
    corners = [
        (0.7400528586779441, 0.0),
        (0.29134328615842636, 0.4859010818264945),
        (1.184421098299711, 1.310621540991217),
        (2.0210350826795813, 0.40466440306171425),
        (1.5828298754220365, 0.0),
    ]
    free = shapely.box(0, 0, 6, 12).difference(shapely.Polygon(corners))
    index = worlds.index(free, 1.5)
    boundary, tags = visibility_polygon(index, 0.1895792364227318, 0.596099893899906, 1.5)
    assert boundary.min() >= -1e-9
    seen = shapely.Polygon(boundary)
    assert seen.difference(free.buffer(1e-9)).area < 1e-9
    # What lies at the edge is a wall, so no frontier.
    ends = np.roll(boundary, -1, axis=0)
    pieces = np.stack([boundary, ends], axis=1)[tags != OBSTACLE]
    assert shapely.multilinestrings(pieces).distance(shapely.Point(0.5, 0.26)) > 0.2


@settings(max_examples=40)
@given(
    step=st.sampled_from([0.05, 0.1, 0.3, 0.4, 0.8]),
    place=st.tuples(st.integers(-12, 12), st.integers(-12, 12)),
    along=st.tuples(st.integers(-5, 5), st.integers(-5, 5)).filter(any),
    ends=st.sampled_from([(1, 2), (1, 4), (2, 3), (3, 5)]),
    side=st.sampled_from([-1, 1]),
)
@example(step=0.4, place=(20, 14), along=(-1, 2), ends=(2, 7), side=1)
@example(step=0.4, place=(20, 14), along=(-1, 2), ends=(2, 7), side=-1)
def test_edges_that_point_at_the_viewpoint(worlds, step, place, along, ends, side):
    # On a lattice, so that they point at it but for rounding.
    (i, j), (di, dj), (first, last) = place, along, ends
    cells = (
        (i, j),
        (i + first * di, j + first * dj),
        (i + last * di, j + last * dj),
        (i + last * di - side * dj, j + last * dj + side * di),
    )
    (x, y), *corners = [(round(step * column, 3), round(step * row, 3)) for column, row in cells]
    free = box(-50, -50, 50, 50).difference(Polygon(corners))
    boundary, _ = visibility_polygon(worlds.index(free, 2.0), x, y, 2.0)
    assert np.hypot(*(boundary - (x, y)).T).max() <= 2.0 + 1e-9
    seen = Polygon(boundary)
    assert seen.is_valid
    disc = Polygon([(x + 2 * math.cos(t), y + 2 * math.sin(t)) for t in np.arange(720) * RAD])
    truth = Cgal(free).view(x, y).intersection(disc)
    assert seen.symmetric_difference(truth).area < 0.01 * truth.area
