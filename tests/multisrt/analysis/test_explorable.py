import math

import numpy as np
import pytest
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.analysis.explorable import Explorable, cell_width, explorable, reachable_area
from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration

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
    # Cell centres lie at (c + 0.118) / 10: 60 of them in 6 m, 50 in 5 m.
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


def test_the_farthest_point():
    # From one corner region to the other, round a wall: 1 m to its end, then on to (10, 0).
    free = shapely.box(0, 0, 10, 4).difference(shapely.box(5, 0, 5.1, 3))
    space = what(free, start=(5.5, 1.0))
    expected = math.hypot(0.4, 2.0) + 0.1 + math.hypot(5.0, 3.0)
    assert space.farthest_m(Configuration(5.5, 1.0)) == pytest.approx(expected, rel=0.02)
    corridor = what(shapely.box(0, 0, 20, 1), start=(1.0, 0.5))
    assert corridor.farthest_m(Configuration(1.0, 0.5)) == pytest.approx(19.0, rel=0.01)


def test_a_body_that_barely_fits():
    lane = shapely.box(0, 0, 9, 0.5 + 1e-6)
    tight = what(lane, start=(1.0, 0.25 + 5e-7))
    assert tight.area_m2 == pytest.approx(4.5, abs=0.1)


def test_reachable_places_are_those_around_the_start():
    hourglass = shapely.union_all(
        [shapely.box(0, 0, 4, 4), shapely.box(4, 1.9, 5, 2.1), shapely.box(5, 0, 9, 4)]
    )
    assert isinstance(hourglass, shapely.Polygon)
    left = reachable_area(hourglass, DISC, Configuration(1.0, 1.0))
    right = reachable_area(hourglass, DISC, Configuration(8.0, 1.0))
    assert left.bounds[2] < 4.5 < right.bounds[0]
    assert left.area == pytest.approx(3.5 * 3.5, abs=0.1)


def test_huge_worlds_are_counted_in_larger_cells():
    assert cell_width(Environment("small", shapely.box(0, 0, 40, 40))) == 0.1
    assert cell_width(Environment("huge", shapely.box(0, 0, 4000, 4000))) == 1.0


def test_equal_teams_share_one_result():
    world = Environment("room", shapely.box(0, 0, 6, 5))
    start = Configuration(1.0, 1.0)
    team = ((DISC, 4.0, start),)
    assert explorable(world, team) is explorable(world, team)


def test_nothing_outside_of_the_component_is_marked():
    world = shapely.box(0, 0, 6, 5).difference(shapely.Point(3, 2.5).buffer(1.0))
    space = what(world, start=(1.0, 1.0), range_m=2.0)
    x, y = space.raster.centres()
    marked = np.stack(np.meshgrid(x, y), axis=-1)[space.raster.cells]
    assert shapely.contains_xy(world.buffer(1e-9), marked).all()


TWO_ROOMS = shapely.union(shapely.box(0, 0, 6, 5), shapely.box(6.2, 0, 12, 5))


def of_team(world: BaseGeometry, *team: tuple[Footprint, float, float, float]) -> Explorable:
    return explorable(
        Environment("world", world),
        tuple((body, range_m, Configuration(x, y, 0.0)) for body, range_m, x, y in team),
    )


def test_a_team_can_explore_what_any_of_its_robots_can():
    one = of_team(TWO_ROOMS, (DISC, FAR, 1.0, 1.0))
    both = of_team(TWO_ROOMS, (DISC, FAR, 1.0, 1.0), (DISC, FAR, 8.0, 1.0))
    assert one.area_m2 == pytest.approx(30.0)
    assert both.area_m2 == pytest.approx(30.0 + 29.0)
    assert both.reachable.area == pytest.approx(5.5 * 4.5 + 5.3 * 4.5, rel=1e-4)
    assert both.area_m2 == pytest.approx(both.cell_m2 * both.raster.cells.sum())


def test_robots_in_one_room_can_explore_as_much_as_one_of_them():
    one = of_team(TWO_ROOMS, (DISC, 4.0, 1.0, 1.0))
    three = of_team(TWO_ROOMS, *((DISC, 4.0, x, 1.0) for x in (1.0, 2.0, 3.0)))
    assert three.area_m2 == one.area_m2
    assert (three.raster.cells == one.raster.cells).all()


def test_a_team_of_different_bodies_and_ranges():
    # A slit that only the far-seeing robot sees to its end, and a door for the slim one only.
    slit, door = shapely.box(6, 2, 16, 2.3), shapely.box(0.5, 5, 1.0, 6)
    world = shapely.union_all([shapely.box(0, 0, 6, 5), slit, door, shapely.box(0, 6, 6, 9)])
    fat, slim = Footprint.disc(0.4), Footprint.disc(0.2)
    near = of_team(world, (slim, 4.0, 1.0, 1.0))
    far = of_team(world, (fat, 20.0, 1.0, 1.0))
    both = of_team(world, (slim, 4.0, 1.0, 1.0), (fat, 20.0, 3.0, 1.0))
    assert (both.raster.cells == near.raster.cells | far.raster.cells).all()
    assert both.area_m2 > max(near.area_m2, far.area_m2) + 0.5


def test_the_farthest_point_is_far_from_the_nearest_start():
    corridor = of_team(shapely.box(0, 0, 20, 1), (DISC, FAR, 1.0, 0.5), (DISC, FAR, 15.0, 0.5))
    left, right = Configuration(1.0, 0.5), Configuration(15.0, 0.5)
    assert corridor.farthest_m(left) == pytest.approx(19.0, rel=0.01)
    assert corridor.farthest_m(left, right) == pytest.approx(7.0, rel=0.02)
    rooms = of_team(TWO_ROOMS, (DISC, FAR, 1.0, 1.0), (DISC, FAR, 7.0, 1.0))
    apart = rooms.farthest_m(Configuration(1.0, 1.0), Configuration(7.0, 1.0))
    assert apart == pytest.approx(math.hypot(5.0, 4.0), rel=0.02)
