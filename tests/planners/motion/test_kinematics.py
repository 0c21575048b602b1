import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic, turns_between
from multisrt.spec import DriveSpec


def test_a_holonomic_body_keeps_its_heading():
    motion = Holonomic(speed_m_s=0.5).drive(Configuration(1.0, 1.0, 0.3), 4.0, 5.0)
    assert motion.duration_s == 10.0
    assert motion.end == (4.0, 5.0, 0.3)


def test_a_differential_body_turns_at_its_rate():
    drive = Differential(turn_rate_rad_s=0.5)
    left = drive.turn(Configuration(1.0, 2.0, 3.0), 1.0)
    right = drive.turn(Configuration(1.0, 2.0, 3.0), -1.0)
    assert left.duration_s == right.duration_s == 2.0
    assert [w.heading for w in left.waypoints] == [3.0, 4.0]
    assert [w.heading for w in right.waypoints] == [3.0, 2.0]
    assert left.length_m == 0.0


def test_driving_backwards_takes_as_long_as_forwards():
    drive = Differential(speed_m_s=0.25)
    assert drive.drive(Configuration(0.0, 0.0, 0.0), -1.0, 0.0).duration_s == 4.0
    assert drive.drive(Configuration(0.0, 0.0, 0.0), -1.0, 0.0).end == (-1.0, 0.0, 0.0)


DRIVE = Differential(speed_m_s=0.5, turn_rate_rad_s=1.0)
"""Its turning circle has a radius of 0.5 m."""


@pytest.mark.parametrize(
    ("place", "backwards"),
    [
        ((0.2, 0.6), False),  # inside the turning circle
        ((-0.1, 0.05), False),  # behind: more than half a circle
        ((0.1, 0.05), True),
    ],
)
def test_there_is_no_curve_to_places_that_are_too_near(place, backwards):
    assert DRIVE.curve(Configuration(0.0, 0.0, 0.0), *place, backwards=backwards) is None


def test_a_curve_backwards_is_one_forwards_of_a_body_that_faces_the_other_way():
    forwards = DRIVE.curve(Configuration(0.0, 0.0, 0.0), 1.0, 3.0)
    backwards = DRIVE.curve(Configuration(0.0, 0.0, -math.pi), 1.0, 3.0, backwards=True)
    assert forwards is not None
    assert backwards is not None
    for one, other in zip(forwards.waypoints, backwards.waypoints, strict=True):
        assert other[:3] == pytest.approx(one[:3])
        assert other.heading == pytest.approx(one.heading - math.pi)


@given(st.floats(-math.pi, math.pi))
def test_a_curve_to_a_place_straight_ahead_is_straight(heading):
    start = Configuration(1.0, 2.0, heading)
    x, y = 1.0 + 2.0 * math.cos(heading), 2.0 + 2.0 * math.sin(heading)
    motion = DRIVE.curve(start, x, y)
    assert motion is not None
    assert motion.duration_s == pytest.approx(4.0)
    assert motion.waypoints[-1][1:] == pytest.approx((x, y, heading), abs=1e-6)


def test_motions_of_no_length_take_no_time():
    here = Configuration(1.0, 2.0, 0.5)
    for motion in (
        Holonomic().drive(here, 1.0, 2.0),
        Differential().drive(here, 1.0, 2.0),
        Differential().turn(here, 0.0),
    ):
        assert motion.duration_s == 0.0
        assert motion.start == motion.end == here


@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
@pytest.mark.parametrize(
    ("drive", "name"),
    [
        (Holonomic, "speed_m_s"),
        (Differential, "speed_m_s"),
        (Differential, "turn_rate_rad_s"),
        (Car, "speed_m_s"),
        (Car, "turning_radius_m"),
        (DriveSpec, "turning_radius_m"),
    ],
)
def test_limits_are_positive_and_finite(drive, name, value):
    with pytest.raises(InvalidInputError, match=name):
        drive(**{name: value})


@pytest.mark.parametrize(
    ("heading", "wanted", "short", "long"),
    [
        (0.0, 1.0, 1.0, 1.0 - 2.0 * math.pi),
        (0.0, -1.0, -1.0, 2.0 * math.pi - 1.0),
        (3.0, -3.0, 2.0 * math.pi - 6.0, -6.0),
        (0.5, 0.5, 0.0, -2.0 * math.pi),
    ],
)
def test_turns_between_two_headings(heading, wanted, short, long):
    assert turns_between(heading, wanted) == pytest.approx((short, long))


@pytest.mark.parametrize(("kind", "reverse"), [("reeds-shepp", True), ("dubins", False)])
def test_a_spec_describes_a_car(kind, reverse):
    drive = DriveSpec(kind=kind, speed_m_s=2.0, turning_radius_m=1.5)
    assert drive.kinematics() == Car(speed_m_s=2.0, turning_radius_m=1.5, reverse=reverse)


angles = st.floats(-20.0, 20.0)


@given(angles, angles)
def test_both_turns_lead_there_the_shorter_first(heading, wanted):
    short, long = turns_between(heading, wanted)
    for turn in (short, long):
        assert math.cos(heading + turn - wanted) == pytest.approx(1.0)
    assert abs(short) <= math.pi <= abs(long)
    assert abs(short) + abs(long) == pytest.approx(2.0 * math.pi)
