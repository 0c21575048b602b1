import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Differential, Holonomic
from multisrt.planners.motion.margin import MIN_MARGIN_M
from multisrt.planners.motion.steering import (
    clear_of,
    reach,
    steer,
    to_room_to_turn,
    turn_and_drive,
)
from multisrt.planners.motion.trajectory import Trajectory, leg_length


def box(width: float, height: float) -> np.ndarray:
    """Return the corners of a box with its lower left corner at the origin."""
    return np.array([(width, 0.0), (width, height), (0.0, height), (0.0, 0.0)])


def steered(
    body: PlanningBody,
    kinematics: Differential | Holonomic,
    boundary: np.ndarray,
    start: Configuration,
    x: float,
    y: float,
    *,
    saves_turns: bool = False,
) -> Trajectory:
    """Return the motion of a body to a place that it can reach."""
    motion = steer(body, kinematics, boundary, start, x, y, saves_turns=saves_turns)
    assert motion is not None
    return motion


def turns(motion: Trajectory) -> list[float]:
    return [b.heading - a.heading for a, b in pairwise(motion.waypoints) if a.heading != b.heading]


HALL = box(10.0, 10.0)
CORRIDOR = box(10.0, 0.5)
DISC = PlanningBody(Footprint.disc(0.25), 0.02)
BOX = PlanningBody(Footprint.box(0.6, 0.4), 0.02)
# Its nose is 0.8 m ahead of the reference point, its tail 0.2 m behind.
NOSE = PlanningBody(Footprint.polygon([(-0.2, -0.15), (0.8, -0.15), (0.8, 0.15), (-0.2, 0.15)]), 0)
DRIVE = Differential(speed_m_s=0.5, turn_rate_rad_s=1.0)


def test_a_holonomic_body_drives_sideways():
    motion = steered(BOX, Holonomic(), HALL, Configuration(5.0, 5.0, 0.0), 5.0, 8.0)
    assert motion.end == (5.0, 8.0, 0.0)
    assert turns(motion) == []


def test_a_goal_without_room_has_no_path():
    # 0.2 m of body and 0.02 m of margin do not fit between y = 9.9 and the wall at 10.
    assert steer(BOX, Holonomic(), HALL, Configuration(5.0, 5.0, 0.0), 5.0, 9.9) is None


def test_a_differential_body_turns_the_shorter_way():
    left = steered(DISC, DRIVE, HALL, Configuration(5.0, 5.0, 0.0), 5.0, 8.0)
    assert turns(left) == pytest.approx([math.pi / 2])
    assert left.end == pytest.approx((5.0, 8.0, math.pi / 2))
    assert left.duration_s == pytest.approx(math.pi / 2 + 6.0)
    right = steered(DISC, DRIVE, HALL, Configuration(5.0, 5.0, 0.0), 3.0, 3.0)
    assert turns(right) == pytest.approx([-0.75 * math.pi])


def test_a_place_ahead_needs_no_turn():
    motion = steered(BOX, DRIVE, HALL, Configuration(5.0, 5.0, 0.0), 7.0, 5.0)
    assert len(motion.waypoints) == 2


def test_a_body_without_room_to_turn_drives_backwards():
    start = Configuration(5.0, 0.25, 0.0)
    motion = steered(BOX, DRIVE, CORRIDOR, start, 2.0, 0.25)
    assert turns(motion) == []
    assert motion.end == pytest.approx((2.0, 0.25, 0.0))
    # A disc has room to turn, and drives forwards.
    assert turns(steered(DISC, DRIVE, box(10.0, 0.6), start, 2.0, 0.25)) == [math.pi]


def test_the_longer_turn_is_taken_if_the_shorter_is_blocked():
    # Below the wall at y = 10, to a place on the left: its nose turns through the open side.
    start = Configuration(5.0, 9.6, 0.0)
    motion = steered(NOSE, DRIVE, HALL, start, 4.0, 9.7)
    wanted = math.atan2(0.1, -1.0)
    assert turns(motion) == pytest.approx([wanted - 2.0 * math.pi])
    assert motion.end == pytest.approx((4.0, 9.7, wanted))


@pytest.mark.parametrize(
    ("to", "is_backwards"),
    [
        ((8.0, 5.0), False),
        ((2.0, 5.0), True),
        ((3.0, 3.0), True),
        ((3.0, 7.0), True),
        ((6.0, 8.0), False),
        ((4.0, 8.0), True),
        # At a right angle it turns to face the place.
        ((5.0, 8.0), False),
    ],
)
def test_driving_backwards_saves_turns(to, is_backwards):
    start = Configuration(5.0, 5.0, 0.0)
    motion = steered(DISC, DRIVE, HALL, start, *to, saves_turns=True)
    assert motion.end[:2] == pytest.approx(to)
    _, x, y, heading = motion.waypoints[-2]
    ahead = math.cos(heading) * (to[0] - x) + math.sin(heading) * (to[1] - y)
    assert (ahead < 0.0) == is_backwards


def test_a_curve_saves_the_turn():
    """A quarter of a circle of radius 0.5 m, and 1.5 m straight on."""
    start = Configuration(5.0, 5.0, 0.0)
    motion = steered(DISC, DRIVE, HALL, start, 5.5, 7.0, saves_turns=True)
    assert [w[1:] for w in motion.waypoints] == [
        start,
        pytest.approx((5.5, 5.5, 0.5 * math.pi)),
        pytest.approx((5.5, 7.0, 0.5 * math.pi)),
    ]
    assert motion.duration_s == pytest.approx(0.5 * math.pi + 3.0)


def test_without_room_for_the_curve_the_body_turns_in_place():
    cross = shapely.union_all([shapely.box(0, 4.7, 10, 5.3), shapely.box(4.7, 0, 5.3, 10)])
    boundary = shapely.get_coordinates(cross)
    start = Configuration(5.0, 5.0, 0.0)
    motion = steered(DISC, DRIVE, boundary, start, 5.0, 8.0, saves_turns=True)
    assert turns(motion) == pytest.approx([0.5 * math.pi])
    assert motion.waypoints[1][1:3] == start[:2]


ELL = shapely.box(0, 0, 10, 10).difference(shapely.box(4, 4, 11, 11))

coordinates = st.floats(0.5, 9.5)


@pytest.mark.parametrize("polygon", [shapely.Polygon(HALL), ELL])
@given(
    x=coordinates, y=coordinates, heading=st.floats(-3.0, 3.0), to_x=coordinates, to_y=coordinates
)
def test_saving_turns_is_no_slower_and_stays_inside(polygon, x, y, heading, to_x, to_y):
    assume(polygon.buffer(-0.28).contains(shapely.Point(x, y)))
    region, start = shapely.get_coordinates(polygon), Configuration(x, y, heading)
    plain = steer(DISC, DRIVE, region, start, to_x, to_y)
    saving = steer(DISC, DRIVE, region, start, to_x, to_y, saves_turns=True)
    if plain is not None:
        assert saving is not None
        assert saving.duration_s <= plain.duration_s + 1e-6
    if saving is not None:
        assert saving.start == pytest.approx(start)
        assert saving.end[:2] == pytest.approx((to_x, to_y))
        path = saving.points(0.01)
        swept = shapely.LineString([*path, path[-1]]).buffer(0.25)
        assert swept.difference(polygon).area < 1e-6
        for a, b in pairwise(saving.waypoints):
            assert leg_length(a, b) <= 0.5 * (b[0] - a[0]) + 1e-9
            assert abs(b[3] - a[3]) <= 1.0 * (b[0] - a[0]) + 1e-9


def test_places_that_cannot_be_reached_have_no_path():
    start = Configuration(5.0, 0.25, 0.0)
    assert steer(BOX, DRIVE, CORRIDOR, start, 5.0, 0.4) is None
    assert steer(BOX, DRIVE, CORRIDOR, start, 9.9, 0.25) is None
    assert steer(BOX, DRIVE, HALL, start, 15.0, 5.0) is None


def test_reach_in_a_corridor():
    at = Configuration(5.0, 0.25, 0.0)
    assert reach(BOX, DRIVE, CORRIDOR, at, 0.0, 99.0) == pytest.approx(4.7, abs=0.021)
    # It could drive there backwards, but reach is for driving forwards.
    assert reach(BOX, DRIVE, CORRIDOR, at, math.pi, 99.0) == 0.0
    assert reach(BOX, Holonomic(), CORRIDOR, at, math.pi, 99.0) == pytest.approx(4.7, abs=0.021)
    assert reach(BOX, DRIVE, CORRIDOR, at, math.pi / 2, 99.0) == 0.0
    assert reach(DISC, DRIVE, HALL, Configuration(5.0, 5.0), 1e-9, 2.0) == 2.0


def test_turn_and_drive_turns_first():
    start = Configuration(1.0, 1.0, math.pi)
    motion = turn_and_drive(DRIVE, start, 1.0, 0.0)
    assert turns(motion) == pytest.approx([math.pi / 2])
    assert motion.end == pytest.approx((1.0, 0.0, -math.pi / 2))
    assert turn_and_drive(Holonomic(), start, 1.0, 0.0).end == (1.0, 0.0, math.pi)
    assert turn_and_drive(DRIVE, start, 1.0, 1.0).duration_s == 0.0


bodies = st.sampled_from([DISC, BOX, NOSE])
places = st.tuples(st.floats(-2.5, 2.5), st.floats(-2.5, 2.5))


@given(
    st.lists(st.floats(0.9, 3.0), min_size=5, max_size=24),
    bodies,
    st.floats(-3.14, 3.14),
    places,
    st.sampled_from([DRIVE, Holonomic()]),
)
def test_motions_arrive_and_stay_in_the_region(radii, body, heading, goal, kinematics):
    angles = np.arange(len(radii)) * (2.0 * math.pi / len(radii))
    boundary = np.asarray(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    start = Configuration(0.0, 0.0, heading)
    motion = steer(body, kinematics, boundary, start, *goal)
    if motion is None:
        return
    assert motion.start == start
    assert motion.end[:2] == pytest.approx(goal)
    region = shapely.Polygon(boundary)
    for time in np.linspace(0.0, motion.duration_s, 100):
        at = motion.at(time)
        if body.is_disc:
            assert shapely.Point(at[:2]).distance(region.exterior) >= body.outer_radius_m
        else:
            assert region.contains(body.footprint.placed(at))


@given(
    st.floats(0.0, 2.0 * math.pi),
    st.floats(0.0, 2.0 * math.pi),
    st.floats(0.45, 2.0),
    st.floats(0.0, 2.0 * math.pi),
)
def test_a_region_clear_of_another_holds_the_body_and_keeps_its_distance(a, b, away_m, bearing):
    footprint = Footprint.parse("box:0.4x0.2")
    square = np.array([[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]])
    own = footprint.placed((0.0, 0.0, a))
    other = footprint.placed((away_m * math.cos(bearing), away_m * math.sin(bearing), b))
    distance_m = own.distance(other)
    region = clear_of(square, own, [other], apart_m=0.1)
    if distance_m <= 2.0 * MIN_MARGIN_M:
        assert region is None
        return
    assert region is not None
    left = shapely.Polygon(region)
    assert left.is_valid
    assert left.exterior.is_ccw
    assert left.covers(own)
    assert left.distance(other) > min(distance_m, 0.1) - 3.0 * MIN_MARGIN_M


def test_a_body_that_touches_another_is_clear_of_nothing():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    assert clear_of(square, shapely.box(1, 1, 2, 2), [shapely.box(2, 1, 3, 2)], 0.1) is None
    assert clear_of(square, shapely.box(1, 1, 2, 2), [], 0.1) is square


def test_a_body_beside_another_drives_straight_to_where_it_can_turn():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    body = PlanningBody(Footprint.parse("box:0.44x0.2"), margin_m=0.02)
    at = Configuration(2.0, 2.0, 0.0)
    own, other = body.footprint.placed(at), body.footprint.placed((2.0, 2.25, 0.0))
    region = clear_of(square, own, [other], apart_m=0.1)
    assert region is not None
    assert not body.has_room(region, at)
    motion = to_room_to_turn(body, Differential(), region, at)
    assert motion is not None
    assert motion.length_m > 0.3
    assert motion.end.heading == motion.start.heading
    assert body.has_room(region, motion.end)
