import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.rings import Rings
from multisrt.planners.motion.body import TOUCH_M, PlanningBody
from multisrt.planners.motion.margin import MIN_MARGIN_M

HALL = np.array([(10.0, 0.0), (10.0, 4.0), (0.0, 4.0), (0.0, 0.0)])
DISC = PlanningBody(Footprint.disc(0.25), margin_m=0.02)
BOX = PlanningBody(Footprint.box(0.6, 0.4), margin_m=0.02)


def test_radii_of_a_disc_and_a_box():
    assert DISC.outer_radius_m == 0.25
    assert DISC.roomy_radius_m == pytest.approx(0.252)
    assert DISC.ample_radius_m == pytest.approx(0.27)
    assert BOX.outer_radius_m == pytest.approx(math.hypot(0.3, 0.2))
    assert DISC.is_disc
    assert not BOX.is_disc


def test_a_disc_with_room_keeps_the_margin():
    # The wall ahead is 8 m away; the radius is 0.25 m, the margin 0.02 m.
    assert DISC.travel(HALL, Configuration(2.0, 2.0), 0.0, 99.0) == pytest.approx(7.73)
    assert DISC.travel(HALL, Configuration(2.0, 2.0), math.pi, 99.0) == pytest.approx(1.73)
    assert DISC.travel(HALL, Configuration(2.0, 2.0), 0.0, 5.0) == 5.0


def test_a_disc_near_a_wall_keeps_its_distance():
    # 0.26 m from the wall below, less than radius and margin: it keeps 0.26 m from the next.
    at = Configuration(2.0, 0.26)
    assert DISC.travel(HALL, at, 0.0, 99.0) == pytest.approx(10.0 - 2.0 - 0.26, abs=1e-6)


def test_a_disc_in_contact_may_slide_along_a_wall():
    at = Configuration(2.0, 0.25)
    assert DISC.travel(HALL, at, 0.0, 99.0) == pytest.approx(10.0 - 2.0 - 0.25, abs=1e-6)
    assert DISC.travel(HALL, at, -math.pi / 2, 99.0) == 0.0


def test_motions_found_by_travel_pass():
    # Also if rotated by rounding, and where the margin could not be kept.
    for body in (DISC, BOX):
        for at in (Configuration(2.0, 2.0, 0.0), Configuration(2.0, 0.27, 0.0)):
            distance = body.travel(HALL, at, 0.0, 99.0)
            assert body.passes(HALL, at, 1e-12, distance)
            assert not body.passes(HALL, at, 0.0, distance + 0.03)


def test_a_box_with_room_keeps_the_margin():
    assert BOX.travel(HALL, Configuration(2.0, 2.0, 0.0), 0.0, 99.0) == pytest.approx(7.68)
    # Across its heading it is 0.4 m wide: 2 m to the wall less 0.2 m and the margin.
    at = Configuration(2.0, 2.0, 0.0)
    assert BOX.travel(HALL, at, math.pi / 2, 99.0) == pytest.approx(1.78)


@pytest.mark.parametrize(
    ("gap", "kept"), [(0.021, 0.02), (0.015, 0.01), (0.006, 0.004), (0.002, 0.0005 + 0.004)]
)
def test_a_box_near_a_wall_keeps_part_of_the_margin(gap, kept):
    # Half of the margin, or a fifth; if it stands nearer still, a fifth at the end.
    at = Configuration(2.0, 0.2 + gap, 0.0)
    assert BOX.travel(HALL, at, 0.0, 99.0) == pytest.approx(7.7 - kept)


def test_a_box_in_contact_does_not_move():
    assert BOX.travel(HALL, Configuration(2.0, 0.2, 0.0), 0.0, 99.0) == 0.0
    assert BOX.travel(HALL, Configuration(9.7, 2.0, 0.0), math.pi, 99.0) == 0.0


def test_a_box_in_contact_leaves_the_wall_and_does_not_move_along_it():
    at = Configuration(9.7, 2.0, 0.0)
    assert BOX.leaves(HALL, at, math.pi, 1.0)
    assert BOX.leaves(HALL, at, 0.75 * math.pi, 1.0)
    assert not BOX.leaves(HALL, at, 0.5 * math.pi, 1.0)
    assert not BOX.leaves(HALL, at, 0.0, 1.0)
    assert not BOX.leaves(HALL, at, math.pi, 9.4)


def test_room_for_any_heading():
    # The disc around the box, with a tenth of the margin, has a radius of 0.3626 m.
    assert BOX.has_room(HALL, Configuration(5.0, 0.3627))
    assert not BOX.has_room(HALL, Configuration(5.0, 0.3625))
    assert DISC.has_room(HALL, Configuration(5.0, 0.1))


def test_a_body_outside_the_region_does_not_move():
    for body in (DISC, BOX):
        assert body.travel(HALL, Configuration(2.0, 0.1), 0.0, 99.0) == 0.0


# A corridor 0.5 m wide: a box of 0.6 x 0.4 m gets along it but cannot turn round. Turned by t it
# is 0.6 sin t + 0.4 cos t high, which is 0.5 at t = asin(0.25 / 0.36056) - atan(2 / 3) = 0.1781;
# a little less with the minimum margin on all sides.
CORRIDOR = np.array([(10.0, 0.0), (10.0, 0.5), (0.0, 0.5), (0.0, 0.0)])
CRITICAL = math.asin(0.25 / math.hypot(0.3 + MIN_MARGIN_M, 0.2 + MIN_MARGIN_M)) - math.atan2(
    0.2 + MIN_MARGIN_M, 0.3 + MIN_MARGIN_M
)


@pytest.mark.parametrize(
    ("turn", "possible"),
    [
        (0.0, True),
        (CRITICAL - 1e-3, True),
        (CRITICAL - 1e-3 - 2.0 * math.pi, False),
        (CRITICAL + 1e-3, False),
        (math.pi / 2, False),
        (math.pi, False),
        (-math.pi, False),
    ],
)
def test_a_box_turns_in_a_corridor_up_to_an_angle(turn, possible):
    at = Configuration(5.0, 0.25, 0.0)
    assert BOX.can_turn(CORRIDOR, at, turn) is possible
    assert BOX.can_turn(HALL, Configuration(5.0, 2.0, 0.0), turn) is True


def test_a_disc_can_always_turn():
    assert DISC.can_turn(CORRIDOR, Configuration(5.0, 0.25), 6.0) is True


def test_bridges_pass_from_one_region_to_the_other(ring):
    hall = shapely.box(0.0, 0.0, 6.0, 4.0).difference(shapely.box(2.5, 0.0, 3.5, 2.0))
    rng = np.random.default_rng(5)
    for body in (PlanningBody(Footprint.disc(0.25), 0.02), PlanningBody(Footprint.box(1, 0.4), 0)):
        places = np.vstack([[[1.2, 1.1], [1.2, 1.1]], rng.uniform(0.0, (6.0, 4.0), (200, 2))])
        sizes = [1.5, *rng.uniform(0.3, 2.0, len(places) - 1)]
        regions = [
            hall.intersection(shapely.Point(place).buffer(size))
            for place, size in zip(places, sizes, strict=True)
        ]
        rings = [ring(max(shapely.get_parts(region), key=shapely.area)) for region in regions]
        pairs = np.array([(0, k) for k in range(1, len(places))] + [(9, 3), (3, 9)])
        joined = body.bridges(places, Rings(rings), pairs)
        for (a, b), is_joined in zip(pairs.tolist(), joined, strict=True):
            onwards = body.disc_reach(rings[a], *places[a], *places[b])
            back = body.disc_reach(rings[b], *places[b], *places[a])
            assert is_joined == (onwards + back >= math.dist(places[a], places[b]))
        assert 0.02 < joined.mean() < 0.5
        assert joined[0]


def test_disc_travel_holds_for_any_heading(ring):
    # The disc around the box, with a tenth of the margin, has a radius of 0.3626 m.
    corridor = ring(shapely.box(0, 0, 10, 0.73))
    assert BOX.disc_travel(corridor, 1.0, 0.365, 9.0, 0.365) is True
    assert BOX.disc_travel(corridor, 1.0, 0.365, 9.7, 0.365) is False
    assert BOX.disc_travel(CORRIDOR, 1.0, 0.25, 2.0, 0.25) is False
    assert BOX.disc_travel(CORRIDOR, 1.0, 0.25, 1.0, 0.25) is True


stars = st.lists(st.floats(0.7, 3.0), min_size=5, max_size=24)
bodies = st.sampled_from(
    [
        Footprint.disc(0.25),
        Footprint.box(0.6, 0.4),
        Footprint.polygon([(-0.2, -0.2), (0.4, 0.0), (-0.2, 0.2)]),
        Footprint.polygon(
            [(-0.1, -0.1), (0.4, -0.1), (0.4, 0.1), (0.1, 0.1), (0.1, 0.4), (-0.1, 0.4)]
        ),
    ]
)


@given(stars, bodies, st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_swept_areas_lie_in_the_region(radii, footprint, heading, direction):
    angles = np.arange(len(radii)) * (2.0 * math.pi / len(radii))
    boundary = np.asarray(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    region = shapely.Polygon(boundary)
    body = PlanningBody(footprint, 0.02)
    start = Configuration(0.0, 0.0, heading)
    travel = body.travel(boundary, start, direction, 5.0)
    if travel == 0.0:
        return
    x, y = travel * math.cos(direction), travel * math.sin(direction)
    path = shapely.LineString([(0, 0), (x, y)])
    if footprint.is_disc:
        assert path.distance(region.exterior) >= footprint.radius_m - 2.0 * TOUCH_M
    else:
        swept = footprint.swept(start, Configuration(x, y, heading))
        assert region.contains(swept)
        assert swept.distance(region.exterior) >= 0.9 * MIN_MARGIN_M
