import math
from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.curves import curve, curve_length, set_state, state_space
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.trajectory import leg_length

REEDS_SHEPP = Car(speed_m_s=0.5, turning_radius_m=0.6)
DUBINS = Car(speed_m_s=0.5, turning_radius_m=0.6, reverse=False)
ORIGIN = Configuration(0.0, 0.0, 0.0)


def turned(motion) -> list[float]:
    return [b.heading - a.heading for a, b in pairwise(motion.waypoints)]


@pytest.mark.parametrize("car", [REEDS_SHEPP, DUBINS])
def test_a_place_ahead_is_reached_straight(car):
    motion = curve(car, ORIGIN, Configuration(3.0, 0.0, 0.0))
    assert turned(motion) == pytest.approx([0.0], abs=1e-9)
    assert motion.length_m == pytest.approx(3.0)
    assert motion.duration_s == pytest.approx(6.0)


def test_a_place_behind_is_reached_in_reverse_or_around():
    motion = curve(REEDS_SHEPP, ORIGIN, Configuration(-2.0, 0.0, 0.0))
    assert motion.length_m == pytest.approx(2.0)
    # Without reverse it goes round: a full circle and two straight metres.
    there = curve(DUBINS, ORIGIN, Configuration(-2.0, 0.0, 0.0))
    assert there.length_m == pytest.approx(2.0 * math.pi * 0.6 + 2.0)


@pytest.mark.parametrize("car", [REEDS_SHEPP, DUBINS])
def test_a_quarter_circle_is_one_leg(car):
    motion = curve(car, ORIGIN, Configuration(0.6, 0.6, math.pi / 2))
    assert turned(motion) == pytest.approx([math.pi / 2])
    assert motion.length_m == pytest.approx(0.3 * math.pi)


def test_arcs_over_90_degrees_are_split():
    # 270 degrees to the left: three quarters.
    motion = curve(DUBINS, ORIGIN, Configuration(-0.6, 0.6, -math.pi / 2))
    assert turned(motion) == pytest.approx([math.pi / 2] * 3)


def test_a_reeds_shepp_car_turns_round_in_three_moves():
    motion = curve(REEDS_SHEPP, ORIGIN, Configuration(0.0, 0.0, math.pi))
    assert motion.length_m == pytest.approx(0.6 * math.pi)
    ahead = [
        (b.x - a.x) * math.cos((a.heading + b.heading) / 2)
        + (b.y - a.y) * math.sin((a.heading + b.heading) / 2)
        for a, b in pairwise(motion.waypoints)
    ]
    assert min(ahead) < 0.0 < max(ahead)
    assert sum(turned(motion)) == pytest.approx(math.copysign(math.pi, turned(motion)[0]))


@pytest.mark.parametrize("car", [REEDS_SHEPP, DUBINS])
def test_curves_of_no_length(car):
    motion = curve(car, Configuration(1.0, 2.0, 0.5), Configuration(1.0, 2.0, 0.5))
    assert motion.waypoints == ((0.0, 1.0, 2.0, 0.5),)
    near = Configuration(1.0 + 1e-8, 2.0, 0.5)
    assert curve(car, Configuration(1.0, 2.0, 0.5), near).end == near


scale = st.sampled_from([0.01, 1.0, 10.0])
unit = st.floats(-1.0, 1.0)
angle = st.floats(-3.14, 3.14)


@given(st.sampled_from([REEDS_SHEPP, DUBINS]), scale, unit, unit, angle, angle, unit)
@example(REEDS_SHEPP, 1.0, 0.9, 1e-9, 0.0, 1e-7, 0.0)
@example(DUBINS, 1.0, 0.9, 1e-5, 0.0, 0.0, 0.0)
@example(DUBINS, 10.0, 0.9, -1e-7, 0.0, 1e-5, 0.0)
def test_curves_agree_with_ompl(car, scale, x, y, heading, wanted, off):
    start = Configuration(5.0 * off, -5.0 * off, heading)
    goal = Configuration(start.x + scale * x, start.y + scale * y, wanted)
    motion = curve(car, start, goal)
    length = curve_length(car, start, goal)
    assert motion.start == start
    assert motion.end[:2] == goal[:2]
    assert motion.end.heading == pytest.approx(goal.heading, abs=1e-12)
    assert motion.length_m == pytest.approx(length, abs=1e-5)
    assert motion.duration_s == pytest.approx(length / car.speed_m_s)
    for a, b in pairwise(motion.waypoints):
        turn = abs(b.heading - a.heading)
        assert turn <= math.pi / 2 + 1e-6
        assert turn * car.turning_radius_m <= leg_length(a, b) + 1e-5
    # The curve agrees with OMPL's points everywhere.
    space = state_space(car.reverse, car.turning_radius_m)
    first, last, between = (space.allocState() for _ in range(3))
    set_state(first, start)
    set_state(last, goal)
    assert length == pytest.approx(space.distance(first, last))
    for k in range(21):
        space.interpolate(first, last, k / 20, between)
        here = motion.at(k / 20 * motion.duration_s)
        assert here[:2] == pytest.approx((between.getX(), between.getY()), abs=1e-5)
        assert math.cos(here.heading - between.getYaw()) == pytest.approx(1.0, abs=1e-9)
