"""Safe regions: never more than was seen, shaped as in the papers, with true tags."""

import math
from typing import Any, cast

import numpy as np
import pytest
import shapely
from shapely import Point, Polygon

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.boundary import ARC_TOLERANCE_M, CUT, GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import ExactScan, LaserScan, take_scan
from multisrt.geometry.regions.shapes import CONTACT_TOLERANCE_M
from multisrt.geometry.regions.visibility import visibility_polygon

R = 4.0


def scans(worlds, name, count, *, beams=None, seed=31, clearance=0.15, **options):
    free = worlds.WORLDS[name](**options)
    index = worlds.index(free)
    for x, y in worlds.viewpoints(free, count, clearance=clearance, seed=seed).tolist():
        yield free, index, take_scan(index, Configuration(x, y), 0.0, R, beams)


def sides(region):
    return shapely.linestrings(
        np.stack([region.boundary, np.roll(region.boundary, -1, axis=0)], axis=1)
    )


def just_outside(region):
    """Return a point 1e-6 m outside the middle of every side of a region."""
    following = np.roll(region.boundary, -1, axis=0)
    along = following - region.boundary
    outward = np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]
    return (region.boundary + following) / 2 + 1e-6 * outward


@pytest.mark.parametrize("name", ["office", "clutter"])
def test_radial_from_the_exact_sensor_is_what_it_saw(worlds, name):
    for _, _, scan in scans(worlds, name, 5):
        region = local_safe_region(scan, "radial")
        assert np.array_equal(region.boundary, scan.boundary)
        assert np.array_equal(region.tags, scan.tags)
        assert region.polygon().equals(Polygon(scan.boundary))
        assert (region.x, region.y, region.range_m) == (*scan.configuration[:2], R)


def smallest_readings(view, x, y, cones):
    """Return the distance from a place to the boundary of its view, per cone, by sampling."""
    points = shapely.get_coordinates(shapely.segmentize(view.exterior, 0.002))
    angles = np.arctan2(points[:, 1] - y, points[:, 0] - x) % (2 * np.pi)
    cone = np.minimum((angles / (2 * np.pi) * cones).astype(int), cones - 1)
    result = np.full(cones, np.inf)
    np.minimum.at(result, cone, np.hypot(points[:, 0] - x, points[:, 1] - y))
    return result


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
@pytest.mark.parametrize("cones", [3, 8, 16])
def test_star_cuts_every_cone_at_its_smallest_reading(worlds, name, cones):
    for _, index, scan in scans(worlds, name, 6):
        x, y, _ = scan.configuration
        view, _ = visibility_polygon(index, x, y, R, arc_tolerance_m=1e-6)
        region = local_safe_region(scan, "star", cones=cones)
        radii = np.hypot(*(region.boundary - (x, y)).T)
        truth = smallest_readings(Polygon(view), x, y, cones)
        angles = np.arctan2(*(region.boundary - (x, y)).T[::-1])
        for cone in range(cones):
            middle = (cone + 0.5) * 2 * np.pi / cones
            off = np.abs((angles - middle + np.pi) % (2 * np.pi) - np.pi)
            depth = radii[off < 0.99 * np.pi / cones]
            if not len(depth):
                depth = radii[[off.argmin()]]
            assert np.ptp(depth) < 1e-9
            assert depth[0] == pytest.approx(min(truth[cone], R), abs=0.004)


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
def test_ball_is_a_disc_up_to_the_nearest_obstacle(worlds, name):
    for free, _, scan in scans(worlds, name, 10):
        x, y, _ = scan.configuration
        region = local_safe_region(scan, "ball")
        radii = np.hypot(*(region.boundary - (x, y)).T)
        radius = min(R, free.boundary.distance(Point(x, y)))
        assert radii == pytest.approx(radius, abs=1e-9)
        assert region.polygon().area == pytest.approx(np.pi * radius**2, rel=0.02)


def test_ball_in_the_middle_of_a_hall_by_hand(worlds):
    index = worlds.index(worlds.hall())
    free_disc = local_safe_region(take_scan(index, Configuration(5, 5), 0, 4.0), "ball")
    assert (free_disc.tags == RANGE).all()
    # 3 m from the wall on the right: it is touched there, open everywhere else.
    near = local_safe_region(take_scan(index, Configuration(7, 5), 0, 4.0), "ball")
    middles = (near.boundary + np.roll(near.boundary, -1, axis=0)) / 2
    touching = near.tags == OBSTACLE
    assert 0 < touching.sum() < len(near.tags) / 4
    assert (middles[touching, 0] > 9.5).all()
    assert (near.tags[~touching] == CUT).all()


def test_star_in_a_corridor_by_hand():
    # 1 m wide, long: of four cones those along it meet the walls at 45 degrees.
    corridor = EdgeIndex(
        np.array([[0.0, 0, 40, 0], [40, 0, 40, 1], [40, 1, 0, 1], [0, 1, 0, 0]]), 1.3
    )
    scan = take_scan(corridor, Configuration(20.0, 0.5), 0.0, R)
    region = local_safe_region(scan, "star", cones=4)
    radii = np.hypot(*(region.boundary - (20.0, 0.5)).T)
    # Cones begin at +x: each holds one wall's nearest point, straight up or down.
    assert radii == pytest.approx(0.5)
    region = local_safe_region(scan, "star", cones=8)
    outer = np.hypot(*(region.boundary - (20.0, 0.5)).T)
    # A cone from 0 to 45 degrees sees the wall from its far side: 0.5 / sin 45.
    # The side between a deep and a shallow cone ends at the wall, which is within 5 cm of its
    # last stretch: there a corner is added where the wall comes that near.
    near_wall = 0.5 * math.sqrt(2) - 0.05
    assert np.unique(np.round(outer, 9)) == pytest.approx([0.5, near_wall, 0.5 * math.sqrt(2)])


@pytest.mark.parametrize("first", [0.0, math.pi / 4, math.pi / 2])
def test_a_cone_that_ends_where_a_wall_begins_ignores_it(first):
    # A long wall whose far end lies exactly on the border of two cones: the cone beside it
    # has nothing of the wall but that end.
    turn = np.array([[math.cos(first), math.sin(first)], [-math.sin(first), math.cos(first)]])
    exact = ExactScan(
        configuration=Configuration(0.0, 0.0),
        time_s=0.0,
        range_m=R,
        boundary=np.array([[2.0, 2.0], [-3.0, 2.0], [-3.0, -3.0], [1.0, -3.0], [0.1, 0.0]]) @ turn,
        tags=np.full(5, OBSTACLE, np.int8),
    )
    region = local_safe_region(exact, "star", cones=8)
    angles = np.arctan2(*region.boundary.T[::-1])
    # The wall runs from (0.1, 0) to (2, 2), up to 45 degrees; the next cone is free up to 2 m.
    beside = first + math.radians(45 + 22.5)
    off = np.abs((angles - beside + np.pi) % (2 * np.pi) - np.pi)
    depth = np.hypot(*region.boundary[off.argmin()])
    assert depth == pytest.approx(2.0)


@pytest.mark.parametrize("name", ["rooms", "office", "clutter", "crates"])
@pytest.mark.parametrize("shape", ["star", "ball"])
@pytest.mark.parametrize("beams", [None, 90])
def test_star_and_ball_keep_within_radial(worlds, name, shape, beams):
    for _, index, scan in scans(worlds, name, 6, beams=beams):
        region = local_safe_region(scan, shape)
        if beams is None:
            x, y, _ = scan.configuration
            view, _ = visibility_polygon(index, x, y, R, arc_tolerance_m=1e-7)
        else:
            view = local_safe_region(scan, "radial").boundary
        assert region.polygon().is_valid
        assert region.polygon().difference(Polygon(view)).area < 1e-5


@pytest.mark.parametrize(
    ("name", "options", "beams"),
    [
        ("crates", {}, 90),
        ("crates", {}, 360),
        ("crates", {}, 720),
        ("rooms", {"wall": 0.5}, 90),
        ("rooms", {"wall": 0.5}, 360),
        ("office", {}, 360),
        ("office", {}, 720),
    ],
)
@pytest.mark.parametrize("shape", ["radial", "star"])
def test_regions_from_beams_hold_free_space_only(worlds, name, options, beams, shape):
    for free, _, scan in scans(worlds, name, 60, beams=beams, clearance=0.1, **options):
        region = local_safe_region(scan, shape)
        assert region.polygon().is_valid
        assert region.polygon().difference(free).area < 1e-9


@pytest.mark.parametrize("sharp_deg", [45.0, 57.0, 90.0])
def test_a_corner_between_two_beams_within_range_stays_outside(worlds, sharp_deg):
    # Two beams miss a wedge, the corner of which is within the range, half way between them.
    half = math.pi / 90
    indent = 0.95 * R * math.sin(half) / math.tan(math.radians(0.5 * sharp_deg))
    corner = (R - indent) * np.array([math.cos(half), math.sin(half)])
    away = half + np.radians([-0.5 * sharp_deg, 0.5 * sharp_deg])
    crate = Polygon([corner, *(corner + 2.0 * np.column_stack([np.cos(away), np.sin(away)]))])
    index = worlds.index(shapely.box(-9, -9, 9, 9).difference(crate))
    scan = take_scan(index, Configuration(0.0, 0.0), 0.0, R, beams=90)
    assert isinstance(scan, LaserScan)
    assert np.isinf(scan.ranges).all()
    for shape in ("radial", "star", "ball"):
        assert local_safe_region(scan, shape).polygon().intersection(crate).area == 0.0


@pytest.mark.parametrize("body", ["disc:0.25", "box:0.6x0.4", "polygon:-0.2,-0.2 0.5,0 -0.2,0.2"])
@pytest.mark.parametrize("shape", ["radial", "star", "ball"])
@pytest.mark.parametrize("beams", [24, 90])
def test_regions_from_beams_hold_the_body_beside_a_wall(worlds, body, shape, beams):
    footprint = Footprint.parse(body)
    hall = shapely.box(0, 0, 8, 6)
    for heading in np.linspace(0.0, 2.0 * np.pi, 13):
        # The body stands 1 mm from the wall and from the corner.
        place = Configuration(0.0, 0.0, heading)
        left, low, _, _ = footprint.placed(place).bounds
        place = Configuration(0.001 - left, 0.001 - low, heading)
        bare = take_scan(worlds.index(hall), place, 0.0, R, beams)
        assert not local_safe_region(bare, shape).polygon().covers(footprint.placed(place))
        scan = take_scan(worlds.index(hall), place, 0.0, R, beams, footprint.outline_at(place))
        region, seen = local_safe_region(scan, shape), local_safe_region(bare, shape)
        polygon = region.polygon()
        assert polygon.is_valid
        assert shapely.equals(
            polygon.normalize(), seen.polygon().union(footprint.placed(place)).normalize()
        )
        assert hall.covers(polygon)
        arms = region.boundary - place[:2]
        following = np.roll(arms, -1, axis=0)
        assert (arms[:, 0] * following[:, 1] - arms[:, 1] * following[:, 0] > -1e-12).all()
        # Pieces of the old boundary keep their tags; what the body adds ends before a wall.
        middles = shapely.line_interpolate_point(sides(region), 0.5, normalized=True)
        apart = shapely.distance(middles, seen.polygon().exterior)
        kept = apart < 1e-9
        of = shapely.STRtree(sides(seen)).nearest(middles[kept])
        assert np.array_equal(region.tags[kept], seen.tags[of])
        before_walls = (OBSTACLE,) if shape == "radial" else (OBSTACLE, CUT)
        assert beams < 90 or np.isin(region.tags[~kept], before_walls).all()
        assert (~kept).any()


def test_a_body_that_a_reading_contradicts_is_not_taken_as_free():
    # A wall 0.2 m ahead is inside of the disc of 0.25 m that is said to cover it.
    ranges = np.full(90, 2.0)
    ranges[:3] = ranges[-2:] = 0.2
    place = Configuration(0.0, 0.0)
    covered = Footprint.disc(0.25).outline_at(place)
    scan = LaserScan(configuration=place, time_s=0.0, range_m=4.0, ranges=ranges, covered=covered)
    bare = LaserScan(configuration=place, time_s=0.0, range_m=4.0, ranges=ranges)
    for shape in ("radial", "star", "ball"):
        region, seen = local_safe_region(scan, shape), local_safe_region(bare, shape)
        assert np.array_equal(region.boundary, seen.boundary)
        assert np.array_equal(region.tags, seen.tags)


@pytest.mark.parametrize("name", ["rooms", "crates"])
def test_regions_from_many_beams_come_near_the_exact_one(worlds, name):
    for _, index, scan in scans(worlds, name, 5, beams=2880):
        x, y, _ = scan.configuration
        exact, _ = visibility_polygon(index, x, y, R)
        region = local_safe_region(scan, "radial")
        assert region.polygon().area > 0.985 * Polygon(exact).area


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rooms", "office", "clutter", "crates"])
@pytest.mark.parametrize("shape", ["radial", "star", "ball"])
@pytest.mark.parametrize("beams", [None, 360])
def test_tags_are_true(worlds, name, shape, beams):
    counts = dict.fromkeys((OBSTACLE, RANGE, GAP, CUT), 0)
    for free, _, scan in scans(worlds, name, 8, beams=beams):
        x, y, _ = scan.configuration
        region = local_safe_region(scan, shape)
        spacing = 0.0 if beams is None else R * 2 * np.pi / beams
        to_wall = shapely.distance(free.boundary, sides(region))
        radii = np.hypot(*(region.boundary - (x, y)).T)
        contact = 0.0 if shape == "radial" else CONTACT_TOLERANCE_M + ARC_TOLERANCE_M
        at_range = np.minimum(radii, np.roll(radii, -1)) >= R - 1.25 * spacing - 1e-9
        outside = just_outside(region)
        free_behind = shapely.contains_xy(free, outside[:, 0], outside[:, 1])
        for tag in counts:
            counts[tag] += int((region.tags == tag).sum())
        obstacle = region.tags == OBSTACLE
        assert (to_wall[obstacle] <= contact + 2 * spacing + 1e-9).all()
        assert at_range[region.tags == RANGE].all()
        if shape != "radial":
            assert GAP not in region.tags
            assert free_behind[region.tags == CUT].all()
        else:
            assert CUT not in region.tags
        # What touches a wall all along is not taken for open.
        walled = shapely.covers(free.boundary.buffer(1e-7), sides(region))
        assert obstacle[walled].all()
    assert counts[OBSTACLE] > 0
    if shape == "radial":
        assert counts[GAP] > 0
    else:
        assert counts[CUT] > 0


def test_star_sees_a_door_narrower_than_a_cone(worlds):
    # A room with a door in its right wall, seen from the middle: the star's cones there end at
    # the jambs, and the door between them is no obstacle.
    room = shapely.box(0, 0, 6, 6).union(shapely.box(6, 2.5, 12, 3.5))
    scan = take_scan(worlds.index(room), Configuration(3.0, 3.0), 0.0, R)
    region = local_safe_region(scan, "star", cones=8)
    middles = (region.boundary + np.roll(region.boundary, -1, axis=0)) / 2
    ahead = (middles[:, 0] > 5.5) & (np.abs(middles[:, 1] - 3.0) < 0.25)
    assert ahead.any()
    assert (region.tags[ahead] == CUT).all()


def test_regions_do_not_change(worlds):
    region = local_safe_region(
        take_scan(worlds.index(worlds.hall()), Configuration(5, 5), 0, R), "radial"
    )
    with pytest.raises(ValueError, match="read-only"):
        region.boundary[0, 0] = 1.0


def test_refuses_what_is_no_region(worlds):
    index = worlds.index(worlds.hall())
    scan = take_scan(index, Configuration(5, 5), 0.0, R)
    with pytest.raises(InvalidInputError, match="ball, star or radial, not 'cube'"):
        local_safe_region(scan, cast(Any, "cube"))
    with pytest.raises(InvalidInputError, match="at least 3 cones, not 2"):
        local_safe_region(scan, "star", cones=2)
    few = take_scan(index, Configuration(5, 5), 0.0, R, beams=4)
    with pytest.raises(InvalidInputError, match="at least 5 beams around the robot, not 4"):
        local_safe_region(few, "radial")


def test_utm_coordinates(worlds):
    free = worlds.office()
    there = shapely.affinity.translate(free, 5e5, 4.5e6)
    near, far = worlds.index(free), worlds.index(there)
    for x, y in worlds.viewpoints(free, 8, seed=33).tolist():
        for beams in (None, 90):
            for shape in ("radial", "star", "ball"):
                a = local_safe_region(take_scan(near, Configuration(x, y), 0, R, beams), shape)
                b = local_safe_region(
                    take_scan(far, Configuration(x + 5e5, y + 4.5e6), 0, R, beams), shape
                )
                moved = shapely.affinity.translate(b.polygon(), -5e5, -4.5e6)
                assert moved.symmetric_difference(a.polygon()).area < 1e-6
                assert set(a.tags.tolist()) == set(b.tags.tolist())
