import numpy as np
import pytest
import shapely
from shapely import affinity
from shapely.geometry.base import BaseGeometry

from multisrt.analysis import explorable as explorable_module
from multisrt.analysis.explorable import (
    EXPLORABLE,
    TILTS_RAD,
    Explorable,
    explorable,
    reachable_area,
)
from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.strip_map import OUTSIDE
from multisrt.geometry.grids.strips import runs_of
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.geometry.regions.visibility import visibility_polygons
from multisrt.simulation.worlds import build_environment
from multisrt.spec import CatalogEnvironment

START = Configuration(0.8, 6.0)
DISC = Footprint.disc(0.25)
FAR = 50.0


def what(
    *free: BaseGeometry,
    start: tuple[float, float] = (1.0, 1.0),
    range_m: float = FAR,
    body: Footprint = DISC,
) -> Explorable:
    world = Environment("world", shapely.union_all(free))
    return explorable(world, ((body, range_m, Configuration(*start)),))


def test_an_empty_room_is_explorable_completely():
    room = what(shapely.box(0, 0, 6, 5))
    assert room.area_m2 == pytest.approx(30.0)
    # The centre of the disc keeps 0.25 m off the walls.
    assert room.reachable.area == pytest.approx(5.5 * 4.5, rel=1e-4)


def test_a_closed_room_behind_a_wall_does_not_count():
    rooms = shapely.box(0, 0, 6, 5), shapely.box(6.2, 0, 12, 5)
    assert what(*rooms).area_m2 == pytest.approx(30.0)
    assert what(*rooms, start=(8.0, 1.0)).area_m2 == pytest.approx(5.8 * 5.0)


def test_a_pillar_is_no_part_of_it():
    assert what(shapely.box(0, 0, 6, 5).difference(shapely.box(2, 2, 3, 4))).area_m2 == (
        pytest.approx(28.0)
    )


def test_a_nook_that_the_body_cannot_enter_but_sees_into_counts():
    nook = shapely.box(6, 2, 7, 2.3)
    with_nook = what(shapely.box(0, 0, 6, 5), nook)
    assert with_nook.area_m2 == pytest.approx(30.3, abs=0.1)
    # The disc gets only a little into its mouth.
    assert with_nook.reachable.area < 5.5 * 4.5 + 0.1


def test_a_slit_counts_as_far_as_the_range_goes_into_it():
    # Touching both corners of the mouth, 0.3 m apart, the disc's centre is sqrt(0.25^2 - 0.15^2)
    # = 0.2 m before it, and sees 3.8 m of the slit.
    slit = shapely.box(6, 2, 16, 2.3)
    alone = what(shapely.box(0, 0, 6, 5), range_m=4.0)
    with_slit = what(shapely.box(0, 0, 6, 5), slit, range_m=4.0)
    assert with_slit.area_m2 - alone.area_m2 == pytest.approx(3.8 * 0.3, abs=0.05)


def test_behind_the_corner_of_a_slit_nothing_counts():
    bent = shapely.box(6, 2, 8, 2.3), shapely.box(7.7, 2.3, 8, 6)
    seen = what(shapely.box(0, 0, 6, 5), *bent)
    # All of the slit, and round its corner a strip that is seen obliquely from the mouth.
    assert 30.0 + 0.6 - 0.05 <= seen.area_m2 <= 30.0 + 0.6 + 0.15


def test_a_door_is_passable_if_it_is_as_wide_as_the_body():
    for width, leads_on in ((0.52, True), (0.48, False)):
        door = shapely.box(6, 2, 6.2, 2 + width)
        rooms = what(shapely.box(0, 0, 6, 5), door, shapely.box(6.2, 0, 12, 5))
        assert (rooms.reachable.area > 40.0) is leads_on
        # Through the door that it cannot pass it still sees most of the other room.
        assert rooms.area_m2 > 45.0


def test_a_slim_body_gets_where_its_inscribed_disc_does():
    door = shapely.box(6, 2, 6.2, 2.4)
    room = shapely.box(0, 0, 6, 5), door, shapely.box(6.2, 0, 12, 5)
    assert what(*room, body=Footprint.box(0.6, 0.3)).reachable.area > 50.0
    assert what(*room, body=Footprint.box(0.6, 0.5)).reachable.area < 30.0


def test_a_body_that_barely_fits():
    lane = shapely.box(0, 0, 9, 0.5 + 1e-6)
    tight = what(lane, start=(1.0, 0.25 + 5e-7))
    assert tight.area_m2 == pytest.approx(4.5, abs=0.1)


def test_shapes_with_a_fixed_precision_are_worlds_like_others():
    # On this one, rounded to a millimetre as generators do it, GEOS gives an empty buffer.
    spec = CatalogEnvironment(
        name="clutter",
        parameters={"size_m": 18.9, "obstacle_m": 2.96, "passage_m": 0.883},
        seed=7447,
    )
    world = build_environment(spec)
    slim = Footprint.parse("polygon:-0.3,-0.113 0.065,0 -0.3,0.113")
    team = ((slim, 4.0, START),)
    again = Environment(world.name, shapely.from_wkb(shapely.to_wkb(world.free)))
    assert shapely.get_precision(world.components[0]) > 0.0
    assert explorable(world, team).area_m2 == explorable(again, team).area_m2 > 300.0


def test_reachable_places_are_those_around_the_start():
    hourglass = shapely.union_all(
        [shapely.box(0, 0, 4, 4), shapely.box(4, 1.9, 5, 2.1), shapely.box(5, 0, 9, 4)]
    )
    assert isinstance(hourglass, shapely.Polygon)
    left = reachable_area(hourglass, DISC, Configuration(1.0, 1.0))
    right = reachable_area(hourglass, DISC, Configuration(8.0, 1.0))
    assert left.bounds[2] < 4.5 < right.bounds[0]
    assert left.area == pytest.approx(3.5 * 3.5, abs=0.1)


def test_equal_teams_share_one_result():
    world = Environment("room", shapely.box(0, 0, 6, 5))
    start = Configuration(1.0, 1.0)
    team = ((DISC, 4.0, start),)
    assert explorable(world, team) is explorable(world, team)


def test_what_is_explorable_is_never_more_than_what_is_free():
    diamond = shapely.Polygon([(10, 0), (20, 10), (10, 20), (0, 10)])
    space = what(diamond, start=(10.0, 10.0))
    assert space.area_m2 <= diamond.area
    assert space.area_m2 == pytest.approx(200.0, rel=1e-9)
    pillar = shapely.box(0, 0, 6, 5).difference(shapely.Point(3, 2.5).buffer(1.0))
    assert what(pillar, range_m=2.0).area_m2 == pytest.approx(pillar.area, rel=1e-9)


def test_what_can_be_seen_agrees_with_a_union_of_views():
    """Views from dense places on the border of what can be reached, united by GEOS."""
    world = shapely.union_all(
        [shapely.box(0, 0, 6, 5), shapely.box(6, 2, 16, 2.3), shapely.box(0.5, 5, 0.9, 9)]
    )
    space = what(world, range_m=4.0)
    assert isinstance(world, shapely.Polygon)
    edges = shapely.get_coordinates(shapely.orient_polygons(world).exterior)
    index = EdgeIndex(np.hstack([edges[:-1], edges[1:]]), 1.0)
    border = shapely.get_coordinates(shapely.segmentize(space.reachable.boundary, 0.01))
    views = shapely.union_all([shapely.Polygon(v) for v in visibility_polygons(index, border, 4.0)])
    seen = shapely.union(views, space.reachable)
    assert space.area_m2 == pytest.approx(seen.area, rel=1e-4)
    assert space.area_m2 < world.area - 1.5


TWO_ROOMS = shapely.union(shapely.box(0, 0, 6, 5), shapely.box(6.2, 0, 12, 5))


def of_team(world: BaseGeometry, *team: tuple[Footprint, float, float, float]) -> Explorable:
    return explorable(
        Environment("world", world),
        tuple((body, range_m, Configuration(x, y, 0.0)) for body, range_m, x, y in team),
    )


def test_unseen_points_are_looked_at_in_blocks(monkeypatch):
    pillars = shapely.union_all([shapely.box(x, y, x + 2, y + 2) for x in (2, 7) for y in (2, 8)])
    hall = shapely.box(0, 0, 12, 12) - pillars
    at_once = what(hall, range_m=3.0)
    monkeypatch.setattr(explorable_module, "MAX_SAMPLES", 50)
    for cached in (explorable_module._explorable_from, explorable_module._seen_from):
        cached.cache_clear()
    in_blocks = what(hall, range_m=3.0)
    assert in_blocks is not at_once
    for found, expected in zip(
        in_blocks.plane.runs(EXPLORABLE), at_once.plane.runs(EXPLORABLE), strict=True
    ):
        np.testing.assert_array_equal(found, expected)


def test_a_team_can_explore_what_any_of_its_robots_can():
    # The disc of 0.6 m keeps to the lower room, and sees only a part of the upper one.
    door = shapely.box(2, 5, 3, 5.2)
    world = shapely.union_all([shapely.box(0, 0, 6, 5), door, shapely.box(0, 5.2, 6, 9)])
    large, small = (Footprint.disc(0.6), 2.0, 1.0, 1.0), (DISC, 2.0, 4.0, 1.0)
    alone, together = of_team(world, large), of_team(world, large, small)
    assert alone.area_m2 < world.area - 10.0
    assert together.area_m2 == pytest.approx(world.area, rel=1e-6)
    assert together.reachable.area > alone.reachable.area


def test_robots_in_one_room_can_explore_as_much_as_one_of_them():
    one = of_team(TWO_ROOMS, (DISC, 4.0, 1.0, 1.0))
    three = of_team(TWO_ROOMS, *((DISC, 4.0, x, 1.0) for x in (1.0, 2.0, 3.0)))
    assert three.area_m2 == one.area_m2


def test_a_team_of_different_bodies_and_ranges():
    # A slit that only the far-seeing robot sees to its end, and a door for the slim one only.
    slit, door = shapely.box(6, 2, 16, 2.3), shapely.box(0.5, 5, 1.0, 6)
    world = shapely.union_all([shapely.box(0, 0, 6, 5), slit, door, shapely.box(0, 6, 6, 9)])
    fat, slim = Footprint.disc(0.4), Footprint.disc(0.2)
    near = of_team(world, (slim, 4.0, 1.0, 1.0))
    far = of_team(world, (fat, 20.0, 1.0, 1.0))
    both = of_team(world, (slim, 4.0, 1.0, 1.0), (fat, 20.0, 3.0, 1.0))
    everything = near.plane.copy()
    everything.relabel(far.plane.runs(EXPLORABLE), [[EXPLORABLE, EXPLORABLE]])
    assert both.area_m2 == pytest.approx(float(everything.areas_m2[EXPLORABLE]), rel=1e-9)
    assert both.area_m2 > max(near.area_m2, far.area_m2) + 0.5


def comb(slits: int) -> BaseGeometry:
    teeth = [shapely.box(0.15 * k, 2, 0.15 * k + 0.05, 6) for k in range(slits)]
    return shapely.union_all([shapely.box(0, 0, 0.15 * slits, 2), *teeth])


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["radial", "star"])
@pytest.mark.parametrize("free", [shapely.box(0, 0, 50, 1), comb(40)], ids=["corridor", "comb"])
@pytest.mark.parametrize("turn_rad", [0.0, 0.19, *TILTS_RAD[::2]])
def test_areas_are_those_of_overlays_wherever_walls_run(free, turn_rad, shape):
    world = Environment("world", affinity.rotate(free, turn_rad, (0, 0), use_radians=True))
    inner = world.free.buffer(-0.2)
    shares = np.linspace(0.02, 0.98, 15)
    places = shapely.line_interpolate_point(inner.boundary, shares, normalized=True)
    index = EdgeIndex(world.edges, 2.0)
    scans = (take_scan(index, Configuration(p.x, p.y), 0.0, 6.0) for p in places)
    regions = [local_safe_region(scan, shape, cones=32).polygon() for scan in scans]

    plane = what(world.free, start=(places[0].x, places[0].y), body=Footprint.disc(0.01)).plane
    seen = plane.mapped([OUTSIDE, EXPLORABLE], 3)
    corners = [shapely.get_coordinates(region)[:-1] for region in regions]
    areas = seen.relabel(runs_of(seen.cut, corners), [[OUTSIDE, 2, 2]])[:, 2]
    overlays = [shapely.union_all(regions[: k + 1], grid_size=1e-7).area for k in range(15)]
    assert areas == pytest.approx(np.array(overlays), abs=1e-4 * world.area_m2)


@pytest.mark.parametrize(("gap_m", "fits"), [(0.4994, False), (0.5002, True)])
def test_a_gap_between_pointed_jambs_is_as_wide_as_it_is(gap_m, fits):
    # The disc is 0.5 m wide. Its way round a tip is an arc, not chords that come nearer to it.
    dx, dy = gap_m / 2 * np.sin(0.05), gap_m / 2 * np.cos(0.05)
    below = shapely.Polygon([(5, 0), (5.4, 0), (5.2 + dx, 2.5 - dy)])
    above = shapely.Polygon([(5.4, 5), (5, 5), (5.2 - dx, 2.5 + dy)])
    rooms = shapely.box(0, 0, 10, 5).difference(shapely.union_all([below, above]))
    found = what(rooms, range_m=2.0)
    assert (found.area_m2 == pytest.approx(rooms.area)) is fits
    assert found.area_m2 > 30.0
