"""Views, lasers and lines of sight against CGAL, shapely and answers by hand."""

import math
from functools import partial

import numpy as np
import pytest
import pyvispoly
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon, affinity, box

from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE, arc_divisions
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.geometry.regions.line_of_sight import line_of_sight
from multisrt.geometry.regions.visibility import visibility_polygon

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
        sides = shapely.linestrings(np.stack([boundary, following], axis=1))
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
                assert room.covers(sides[i])
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


# Too little clearance


@pytest.mark.parametrize(
    ("x", "y", "clearance"),
    [
        (0.0, 0.0, 0.0),  # on a vertex of the outline
        (5.0, 0.0, 0.0),  # on an edge of the outline
        (4.0, 4.0, 0.0),  # on a vertex of the pillar
        (5.0, 4.0, 0.0),  # on an edge of the pillar
        (4.5, 4.0 + 1e-10, -1e-10),
        (4.5, 4.0 - 1e-10, 1e-10),
        (4.2, 4.9, -0.2),  # in the pillar
        (5.0, 5.0, -1.0),
        (-0.3, 5.0, -0.3),  # behind the outline
        (-0.3, -0.4, -0.5),  # behind its corner
        (-3.0, 5.0, -3.0),
    ],
)
@pytest.mark.parametrize("sense", [visibility_polygon, partial(laser_ranges, beams=90)])
def test_an_error_reports_too_little_clearance(worlds, x, y, clearance, sense):
    index = worlds.index(worlds.pillar())
    with pytest.raises(ClearanceError) as refused:
        sense(index, x, y, 4.0)
    assert refused.value.clearance_m == pytest.approx(clearance, abs=1e-14)
    assert f"clearance {clearance:.3g} m" in str(refused.value).replace("-0 m", "0 m")


@pytest.mark.parametrize(("x", "y"), [(50.0, 50.0), (-50.0, 50.0), (150.0, 50.0), (50.0, -7.0)])
def test_inside_an_obstacle_with_no_surface_in_range(x, y):
    free = box(0, 0, 100, 100).difference(box(20, 20, 80, 80))
    free = shapely.orient_polygons(free)
    corners = [np.asarray(ring.coords) for ring in (free.exterior, *free.interiors)]
    edges = np.vstack([np.hstack([c[:-1], c[1:]]) for c in corners])
    index = EdgeIndex(edges, 1.3)
    with pytest.raises(ClearanceError) as refused:
        visibility_polygon(index, x, y, 4.0)
    # How deep is not known beyond the range.
    assert refused.value.clearance_m == -4.0
    with pytest.raises(ClearanceError):
        laser_ranges(index, x, y, 4.0, 8)
    visibility_polygon(index, 10.0, 50.0, 4.0)


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


def test_sides_are_right_everywhere(worlds):
    free = worlds.clutter(8.0, 60)
    index = worlds.index(free, 1.0)
    rng = np.random.default_rng(5)
    sides = {True: 0, False: 0}
    for x, y in rng.uniform(-1.0, 9.0, (1500, 2)).tolist():
        inside = bool(shapely.contains_xy(free, x, y))
        sides[inside] += 1
        distance = free.boundary.distance(Point(x, y))
        if inside:
            laser_ranges(index, x, y, 1.0, 3)
        else:
            with pytest.raises(ClearanceError) as refused:
                laser_ranges(index, x, y, 1.0, 3)
            assert refused.value.clearance_m == pytest.approx(-min(distance, 1.0), abs=1e-12)
    assert min(sides.values()) > 300


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_refuses_viewpoints_that_are_not_finite(worlds, bad):
    index = worlds.index(worlds.hall())
    for place in ((bad, 5.0), (5.0, bad)):
        with pytest.raises(InvalidInputError, match="finite"):
            visibility_polygon(index, *place, 4.0)
        with pytest.raises(InvalidInputError, match="finite"):
            laser_ranges(index, *place, 4.0, 90)
        with pytest.raises(InvalidInputError, match="finite"):
            line_of_sight(index, 1.0, 1.0, *place)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, 1e8])
def test_refuses_ranges_that_cannot_be(worlds, bad):
    index = worlds.index(worlds.hall())
    with pytest.raises(InvalidInputError, match="range"):
        visibility_polygon(index, 5.0, 5.0, bad)
    with pytest.raises(InvalidInputError, match="range"):
        laser_ranges(index, 5.0, 5.0, bad, 90)


def test_refuses_two_beams(worlds):
    with pytest.raises(InvalidInputError, match="at least 3 beams, not 2"):
        laser_ranges(worlds.index(worlds.hall()), 5.0, 5.0, 4.0, 2)


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


# Lasers


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
def test_laser_measures_what_shapely_cuts(worlds, name):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    beams, first = 72, 0.3
    for x, y in worlds.viewpoints(free, 6, seed=26):
        ranges = laser_ranges(index, x, y, 4.0, beams, first_rad=first)
        for i, measured in enumerate(ranges):
            theta = first + 2 * np.pi * i / beams
            ray = LineString([(x, y), (x + 4 * np.cos(theta), y + 4 * np.sin(theta))])
            hits = free.boundary.intersection(ray)
            if hits.is_empty:
                assert measured == np.inf
            else:
                assert measured == pytest.approx(Point(x, y).distance(hits), abs=1e-9)


def test_laser_in_a_hall_by_hand(worlds):
    index = worlds.index(worlds.hall())
    ranges = laser_ranges(index, 2.0, 5.0, 4.0, 8)
    # East, north-east, north, ... ; the corners of the hall are beyond 4 m.
    assert ranges == pytest.approx(
        [np.inf, np.inf, np.inf, 2 * math.sqrt(2), 2.0, 2 * math.sqrt(2), np.inf, np.inf]
    )
    assert laser_ranges(index, 5.0, 5.0, 8.0, 8) == pytest.approx(
        [5.0, math.sqrt(50), 5.0, math.sqrt(50), 5.0, math.sqrt(50), 5.0, math.sqrt(50)]
    )


@pytest.mark.parametrize("turns", [-100.25, -0.5, 0.75, 7.0])
def test_laser_directions_may_be_any_angle(worlds, turns):
    index = worlds.index(worlds.office())
    plain = laser_ranges(index, 7.0, 8.0, 4.0, 60, first_rad=2 * math.pi * (turns % 1.0))
    turned = laser_ranges(index, 7.0, 8.0, 4.0, 60, first_rad=2 * math.pi * turns)
    assert turned == pytest.approx(plain, abs=1e-9)


# Lines of sight


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
def test_lines_of_sight_equal_shapely(worlds, name):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    shapely.prepare(free)
    places = worlds.viewpoints(free, 400, clearance=0.05, seed=27)
    answers = {True: 0, False: 0}
    for a, b in zip(places[:200], places[200:], strict=True):
        b = a + (b - a) * min(1.0, 5.0 / np.hypot(*(b - a)))
        if not shapely.contains_xy(free, *b):
            continue
        truth = bool(free.covers(LineString([a, b])))
        assert line_of_sight(index, *a, *b) == truth
        assert line_of_sight(index, *b, *a) == truth
        answers[truth] += 1
    assert min(answers.values()) > 30


GRAZING = [
    # (obstacles, from, to, visible)
    ([box(4, 4, 6, 6)], (2, 2), (3.9, 3.9), True),  # ends before the corner
    ([box(4, 4, 6, 6)], (2, 6), (6, 2), True),  # touches the corner (4, 4)
    ([box(4, 4, 6, 6)], (2, 8), (8, 2), False),  # through two opposite corners
    ([box(4, 4, 6, 6)], (2, 2), (8, 8), False),
    ([box(4, 4, 6, 6)], (2, 4), (8, 4), True),  # along the lower side
    ([box(4, 4, 6, 6)], (8, 4), (2, 4), True),
    ([box(4, 4, 6, 6)], (2, 6), (8, 6), True),  # along the upper side
    ([box(4, 4, 6, 6)], (4, 1), (4, 9), True),  # along the left side
    ([box(4, 4, 6, 6)], (6, 9), (6, 1), True),  # along the right side
    ([box(4, 4, 6, 6)], (4, 4), (6, 4), True),  # the side itself
    ([box(4, 4, 6, 6)], (2, 4), (4, 4), True),  # ends at the corner
    ([box(4, 4, 6, 6)], (5, 4), (5, 2), True),  # leaves from the middle of a side
    ([box(4, 4, 6, 6)], (2, 5), (8, 5), False),
    ([box(2, 5, 4, 6), box(6, 4, 8, 5)], (1, 5), (9, 5), True),  # a wall left, then one right
    ([box(2, 5, 4, 6), box(6, 4, 8, 5)], (9, 5), (1, 5), True),
    ([box(2, 5, 4, 6), box(6, 4, 8, 5), box(8.5, 4, 8.7, 6)], (1, 5), (9, 5), False),
    ([box(2, 5, 4, 6), box(6, 5, 8, 7)], (1, 5), (9, 5), True),  # two walls on one side
    ([box(4, 4, 5, 5), box(5, 5, 6, 6)], (2, 8), (8, 2), True),  # between two that touch
    ([box(4, 4, 5, 5), box(5, 5, 6, 6)], (2, 2), (8, 8), False),
    ([box(4, 4, 5, 5), box(5, 5, 6, 6)], (2, 5), (8, 5), True),  # along both
    ([Polygon([(4, 4), (6, 4), (5, 6)])], (2, 6), (8, 6), True),  # touches the tip
    ([Polygon([(4, 4), (6, 4), (5, 6)])], (5, 1), (5, 9), False),  # through the tip
]


@pytest.mark.parametrize(("obstacles", "here", "there", "visible"), GRAZING)
def test_grazing_lines_of_sight_by_hand(worlds, obstacles, here, there, visible):
    free = box(0, 0, 10, 10).difference(shapely.union_all(obstacles))
    assert free.covers(LineString([here, there])) == visible
    for cell in (0.5, 1.3, 20.0):
        index = EdgeIndex(worlds.edges(free), cell)
        assert line_of_sight(index, *here, *there) == visible
        assert line_of_sight(index, *there, *here) == visible


def test_a_place_sees_itself(worlds):
    assert line_of_sight(worlds.index(worlds.hall()), 3.0, 3.0, 3.0, 3.0)


@given(
    st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), min_size=2, max_size=2),
    st.integers(0, 5),
)
def test_lines_between_lattice_points_equal_shapely(worlds, ends, seed):
    # Corners and ends on one lattice of halves: grazing is the rule here.
    rng = np.random.default_rng(seed)
    lows = rng.integers(2, 16, (8, 2)) / 2
    sizes = rng.integers(1, 4, (8, 2)) / 2
    solid = shapely.union_all(
        [box(*low, *(low + size)) for low, size in zip(lows, sizes, strict=True)]
    )
    free = box(0, 0, 10, 10).difference(solid)
    (ax, ay), (bx, by) = ((x / 2, y / 2) for x, y in ends)
    inside = [shapely.contains_xy(free, ax, ay), shapely.contains_xy(free, bx, by)]
    if not all(inside):
        return
    line = LineString([(ax, ay), (bx, by)])
    truth = line.length == 0 or bool(free.covers(line))
    assert line_of_sight(worlds.index(free), ax, ay, bx, by) == truth


@pytest.mark.parametrize(
    ("radius", "tolerance", "divisions"), [(4.0, 0.01, 45), (1.0, 2.0, 8), (1.0, 0.5, 8)]
)
def test_arcs_have_as_many_chords_as_their_tolerance_needs(radius, tolerance, divisions):
    # A chord's middle is r (1 - cos(pi / n)) inside the arc.
    assert arc_divisions(radius, tolerance) == divisions
    if divisions > 8:
        assert radius * (1 - math.cos(math.pi / divisions)) <= tolerance
        assert radius * (1 - math.cos(math.pi / (divisions - 1))) > tolerance


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
    pieces = shapely.linestrings(np.stack([boundary, ends], axis=1))[tags != OBSTACLE]
    assert shapely.distance(pieces, shapely.Point(0.5, 0.26)).min() > 0.2
