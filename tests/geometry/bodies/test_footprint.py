"""Footprints: measures, pieces, text, and what they sweep."""

import copy
import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.bodies.footprint import DISC_SIDES, Footprint
from multisrt.geometry.errors import InvalidInputError

L_SHAPE = [(-0.2, -0.2), (0.6, -0.2), (0.6, 0.1), (0.1, 0.1), (0.1, 0.5), (-0.2, 0.5)]
U_SHAPE = [(-0.3, -0.4), (0.5, -0.4), (0.5, -0.2), (0.1, -0.2), (0.1, 0.2), (0.5, 0.2)]
U_SHAPE += [(0.5, 0.4), (-0.3, 0.4)]
PLUS = [(1, -1), (1, -3), (-1, -3), (-1, -1), (-3, -1), (-3, 1), (-1, 1), (-1, 3), (1, 3), (1, 1)]
PLUS += [(3, 1), (3, -1)]

sizes = st.floats(1e-3, 1e3)


def ragged(seed: int) -> Footprint:
    """Return a body with a random simple outline, with spikes and notches."""
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 12))
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    if gaps.max() > 3.0:
        angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    reach = rng.uniform(0.1, 1.0, 12)
    return Footprint.polygon(np.column_stack([reach * np.cos(angles), reach * np.sin(angles)]))


def test_a_disc_is_defined_by_its_radius():
    body = Footprint.disc(0.25)
    assert body.is_disc
    assert body.radius_m == body.inscribed_radius_m == body.circumscribed_radius_m == 0.25
    assert body.width_m == 0.5
    assert body.is_convex
    assert body.is_star_shaped


def test_the_polygon_of_a_disc_contains_it_tightly():
    outline = shapely.Polygon(Footprint.disc(2.0).vertices)
    assert len(Footprint.disc(2.0).vertices) == DISC_SIDES
    assert outline.exterior.is_ccw
    assert outline.buffer(1e-12).covers(shapely.Point(0, 0).buffer(2.0, quad_segs=500))
    assert shapely.hausdorff_distance(outline, shapely.Point(0, 0)) <= 2.0 * 1.000302


def test_a_box_lies_along_x_about_its_centre():
    body = Footprint.box(0.6, 0.4)
    assert body.vertices.tolist() == [[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.3, 0.2]]
    assert body.inscribed_radius_m == pytest.approx(0.2, abs=1e-15)
    assert body.circumscribed_radius_m == pytest.approx(math.hypot(0.3, 0.2), abs=1e-15)
    assert body.width_m == pytest.approx(0.4, abs=1e-15)
    assert not body.is_disc
    with pytest.raises(InvalidInputError, match="has no radius"):
        _ = body.radius_m


def test_width_of_a_triangle_is_its_smallest_height():
    body = Footprint.polygon([(-1, -1), (3, -1), (-1, 2)])  # 3-4-5: the height on 5 is 12 / 5
    assert body.width_m == pytest.approx(2.4, abs=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_width_is_the_smallest_extent_over_all_directions(seed):
    body = ragged(seed)
    angles = np.linspace(0, np.pi, 20000)
    along = body.vertices @ np.array([np.cos(angles), np.sin(angles)])
    extent = (along.max(axis=0) - along.min(axis=0)).min()
    assert extent - 1e-3 <= body.width_m <= extent + 1e-12


def test_convex_and_star_shaped_outlines_are_recognized():
    ell, bend, plus = (Footprint.polygon(shape) for shape in (L_SHAPE, U_SHAPE, PLUS))
    assert not ell.is_convex
    assert ell.is_star_shaped
    assert ell.planning_vertices is ell.vertices
    assert not bend.is_star_shaped
    assert plus.is_star_shaped
    hull = shapely.Polygon(bend.planning_vertices)
    assert hull.equals(shapely.box(-0.3, -0.4, 0.5, 0.4))
    assert hull.exterior.is_ccw
    assert Footprint.polygon([(-1, -1), (0, -1), (1, -1), (1, 1), (-1, 1)]).is_convex


@pytest.mark.parametrize("seed", range(20))
def test_convex_pieces_partition_the_body(seed):
    body = ragged(seed)
    pieces = [shapely.Polygon(piece) for piece in body.convex_pieces]
    assert all(piece.exterior.is_ccw for piece in pieces)
    for piece in pieces:
        assert piece.convex_hull.area == pytest.approx(piece.area, rel=1e-9)
    outline = shapely.Polygon(body.vertices)
    assert sum(piece.area for piece in pieces) == pytest.approx(outline.area, rel=1e-12)
    assert shapely.union_all(pieces).symmetric_difference(outline).area < 1e-12
    assert len(pieces) <= len(body.vertices) - 2


def test_simple_shapes_have_few_convex_pieces():
    assert len(Footprint.box(1, 1).convex_pieces) == 1
    assert len(Footprint.polygon(L_SHAPE).convex_pieces) == 2
    assert len(Footprint.polygon(U_SHAPE).convex_pieces) == 3


def test_corners_are_kept_counter_clockwise_from_the_first():
    corners = [(-0.2, -0.1), (0.3, 0.0), (-0.2, 0.1)]
    body = Footprint.polygon(corners)
    clockwise = Footprint.polygon([corners[0], corners[2], corners[1]])
    closed = Footprint.polygon([*corners, corners[0]])
    stuttering = Footprint.polygon([corners[0], *corners])
    assert body == clockwise == closed == stuttering
    assert body.vertices.tolist() == [list(corner) for corner in corners]
    with pytest.raises(ValueError, match="read-only"):
        body.vertices[0, 0] = 9.0


@pytest.mark.parametrize(
    "text",
    ["disc:0.25", "disc:1", "box:0.6x0.4", "box:2x1e-05", "polygon:-0.2,-0.1 0.3,0 -0.2,0.1"],
)
def test_text_round_trips(text):
    body = Footprint.parse(text)
    assert str(body) == text
    assert body == Footprint.parse(f"  {text} ")
    assert hash(body) == hash(Footprint.parse(str(body)))
    again = copy.deepcopy(body)
    assert again == body
    assert not again.vertices.flags.writeable


@given(sizes, sizes, st.lists(sizes, min_size=4, max_size=4))
def test_text_preserves_numbers_exactly(a, b, reach):
    quarter = [(reach[0], 0.0), (0.0, reach[1]), (-reach[2], 0.0), (0.0, -reach[3])]
    for body in (Footprint.disc(a), Footprint.box(a, b), Footprint.polygon(quarter)):
        again = Footprint.parse(str(body))
        assert again == body
        assert again.vertices.tobytes() == body.vertices.tobytes()


def test_footprints_of_other_form_or_size_are_not_equal():
    assert Footprint.disc(0.25) != Footprint.disc(0.26)
    assert Footprint.disc(0.25) != "disc:0.25"
    assert len({Footprint.box(1, 2), Footprint.box(2, 1), Footprint.box(1.0, 2.0)}) == 2


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "write disc:RADIUS, box:LENGTHxWIDTH or polygon"),
        ("ball:3", "footprint 'ball:3' is not known"),
        ("disc", "is not known"),
        ("disc:", "cannot be read"),
        ("disc:a", "footprint 'disc:a' cannot be read; write disc:RADIUS"),
        ("disc:0", "radius of a disc is 0 m"),
        ("disc:-1", "radius of a disc is -1 m"),
        ("disc:nan", "radius of a disc is nan m"),
        ("disc:inf", "radius of a disc is inf m"),
        ("box:1", "cannot be read"),
        ("box:1x2x3", "cannot be read"),
        ("box:1x0", "width of a box is 0 m"),
        ("box:1e400x1", "length of a box is inf m"),
        ("polygon:", "shape"),
        ("polygon:0,1 2", "cannot be read"),
        ("polygon:-1,-1 1,-1", "at least three"),
        ("polygon:1,1 1,1 1,1", "at least three"),
        ("polygon:-1,-1 0,0 1,1", "not simple"),
        ("polygon:-1,-1 1,nan 1,1", r"corner 1 of a polygon is \(1, nan\)"),
        ("polygon:-1,-1 1,1 1,-1 -1,1", "not simple: Self-intersection"),
        ("polygon:1,1 2,1 2,2", r"\(0, 0\) is outside the polygon, 1.41421 m from"),
        ("polygon:0,-1 1,-1 1,1 0,1", r"\(0, 0\) is at the edge of the polygon, 0 m from"),
        ("polygon:0,0 1,-1 1,1", "at the edge of the polygon"),
    ],
)
def test_unusable_footprints_are_refused_with_a_reason(text, says):
    with pytest.raises(InvalidInputError, match=says):
        Footprint.parse(text)


@pytest.mark.parametrize("corners", [[1, 2, 3], [(1, 2, 3)] * 3, [(1, 2), (3,)], "abc", None])
def test_corners_of_a_wrong_type_are_refused(corners):
    with pytest.raises(InvalidInputError, match="polygon's corners"):
        Footprint.polygon(corners)


@pytest.mark.parametrize("radius", [None, "wide", [1.0]])
def test_sizes_of_a_wrong_type_are_refused(radius):
    with pytest.raises(InvalidInputError, match="give a number of metres"):
        Footprint.disc(radius)


@pytest.mark.parametrize("where", [(0.0, 0.0), (0.0, math.nan, 0.0), (0.0, 0.0, math.inf), None])
def test_configurations_are_three_finite_numbers(where):
    with pytest.raises(InvalidInputError, match="configuration"):
        Footprint.disc(1.0).placed(where)


def test_a_body_is_placed_by_turning_then_moving():
    body = Footprint.polygon([(-1, -1), (2, 0), (-1, 1)]).placed((10.0, 20.0, math.pi / 2))
    expected = [(11, 19), (10, 22), (9, 19), (11, 19)]
    assert np.array(body.exterior.coords) == pytest.approx(np.array(expected), abs=1e-12)
    disc = Footprint.disc(1.0)
    assert disc.placed((1.0, 2.0, 0.3)).equals(disc.placed((1.0, 2.0, 2.0)))


def test_area_that_a_box_sweeps_by_hand():
    body = Footprint.box(2.0, 1.0)
    assert body.swept((0, 0, 0), (3, 0, 0)).equals(shapely.box(-1, -0.5, 4, 0.5))
    assert body.swept((0, 0, 0), (1, 1, 0)).area == pytest.approx(2.0 + 3.0, abs=1e-12)
    assert body.swept((5, 5, 0.3), (5, 5, 0.3)).area == pytest.approx(2.0, abs=1e-12)


def test_area_that_a_disc_sweeps_is_around_a_capsule():
    swept = Footprint.disc(0.5).swept((0, 0, 0), (4, 3, 1.0))
    capsule = shapely.LineString([(0, 0), (4, 3)]).buffer(0.5, quad_segs=500)
    assert swept.buffer(1e-9).covers(capsule)
    assert swept.area == pytest.approx(5.0 + math.pi * 0.25, rel=1e-3)
    assert swept.hausdorff_distance(capsule) < 0.5 * 3.03e-4


@pytest.mark.parametrize("shape", [L_SHAPE, U_SHAPE, PLUS])
@pytest.mark.parametrize("seed", range(3))
def test_a_swept_area_is_the_union_of_all_placements(shape, seed):
    rng = np.random.default_rng(seed)
    body = Footprint.polygon(np.array(shape) / np.abs(shape).max())
    heading = rng.uniform(-3, 3)
    start, end = ((*rng.uniform(-2, 2, 2), heading) for _ in range(2))
    swept = body.swept(start, end)
    steps = np.linspace(start, end, 400)
    places = shapely.union_all([body.placed(step) for step in steps])
    assert places.difference(swept).area < 1e-9
    assert swept.difference(places).area < 0.02


def test_a_straight_motion_that_turns_is_refused():
    with pytest.raises(InvalidInputError, match="the heading of a straight motion is constant"):
        Footprint.box(1, 1).swept((0, 0, 0), (1, 0, 0.1))
    assert Footprint.box(1, 1).swept((0, 0, 0), (1, 0, 2 * math.pi)).area == pytest.approx(2.0)
