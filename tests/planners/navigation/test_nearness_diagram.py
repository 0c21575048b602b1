import math
from typing import NamedTuple

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import box

from multisrt.geometry.bodies.clearance import disc_clearance, rings_of
from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.planners.motion.kinematics import Differential, Holonomic
from multisrt.planners.navigation.beams import BEAMS, in_frame_of
from multisrt.planners.navigation.held_command import motion, safe_time
from multisrt.planners.navigation.nearness_diagram import Command, command

RANGE_M = 4.0
DRIVE = Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2)
ANYWAYS = Holonomic(speed_m_s=0.5)


def ordered(ranges, goal, **options) -> Command:
    return command(ranges, 0.25, goal, 0.5, 1.5, range_m=RANGE_M, **options)


OPEN = np.full(360, math.inf)


# One command, worked out by hand -------------------------------------------------------------


def test_open_space_leads_straight_to_the_goal():
    assert ordered(OPEN, (2.0, 0.0)) == pytest.approx(
        Command(0.5, 0.0, 0.0, "goal", 0.0, math.nan, math.nan), nan_ok=True
    )


def test_speed_falls_for_turns_and_near_the_goal():
    # 15 degrees to the left: half the speed, and a sixth of the maximum turn rate.
    t = math.radians(15.0)
    aside = ordered(OPEN, (2.0 * math.cos(t), 2.0 * math.sin(t)))
    assert aside.speed_m_s == pytest.approx(0.25)
    assert aside.turn_rate_rad_s == pytest.approx(1.5 / 6.0)
    assert ordered(OPEN, (0.0, 2.0)).speed_m_s == 0.0
    assert ordered(OPEN, (0.0, 2.0)).turn_rate_rad_s == pytest.approx(1.5)
    assert ordered(OPEN, (0.2, 0.0)).speed_m_s == pytest.approx(0.2)


def test_a_goal_right_behind_makes_it_turn_in_place():
    behind = ordered(OPEN, (-2.0, 0.0))
    assert (behind.situation, behind.speed_m_s) == ("turn", 0.0)
    assert behind.turn_rate_rad_s == pytest.approx(1.5)
    # A drive in any direction has no front.
    there = ordered(OPEN, (-2.0, 0.0), any_direction=True)
    assert there[:4] == pytest.approx((0.5, 0.0, math.pi, "goal"))


def test_a_closed_room_is_blocked():
    closed = np.full(360, 2.0)
    found = ordered(closed, (0.0, 3.0))
    assert (found.situation, found.speed_m_s) == ("blocked", 0.0)
    assert found.turn_rate_rad_s == pytest.approx(1.5)


def test_corridor_to_the_goal_is_as_wide_as_the_body():
    post = OPEN.copy()
    post[10] = 1.4  # 0.243 m aside, 1.379 m ahead
    assert ordered(post, (2.0, 0.0)).situation != "goal"
    assert ordered(post, (1.37, 0.0)).situation == "goal"
    post[10], post[11] = math.inf, 1.4  # 0.267 m aside
    assert ordered(post, (2.0, 0.0)).situation == "goal"


def blocked_ahead(near: float) -> np.ndarray:
    """A wall from 20 degrees on the right to 60 on the left, as an arc about the robot."""
    ranges = OPEN.copy()
    ranges[: 60 + 1] = ranges[-20:] = near
    return ranges


def test_heading_passes_the_corner_of_the_nearest_gap():
    found = ordered(blocked_ahead(2.0), (3.0, 0.0))
    # The gap lies between the beams at -20 and -21 degrees; D + R = 1.25 m of the corner's 2 m.
    assert found.situation == "gap"
    assert found.gap_rad == pytest.approx(math.radians(-20.5))
    assert found.desired_rad == pytest.approx(math.radians(-20.5) - math.asin(1.25 / 2.0))
    # The valley holds all open beams, 279 of them.
    assert found.valley_rad == pytest.approx(-math.radians(279))
    # Nothing is within D + R: no repulsion.
    assert found.heading_rad == found.desired_rad
    # A near corner is passed at a right angle, and a goal on the left has the other gap.
    assert ordered(blocked_ahead(1.25), (3.0, 0.0)).desired_rad == pytest.approx(
        math.radians(-110.5)
    )
    assert ordered(blocked_ahead(2.0), (3.0, 1.5)).gap_rad == pytest.approx(math.radians(60.5))


def test_heading_is_the_middle_of_a_narrow_valley():
    # Walls all around at 3 m, open for 40 degrees on the left.
    ranges = np.full(360, 3.0)
    ranges[70:110] = math.inf
    found = ordered(ranges, (3.5, 0.5))
    assert found.situation == "middle"
    assert found.desired_rad == pytest.approx(math.radians(89.5))
    assert abs(found.valley_rad) == pytest.approx(math.radians(40))


def test_gaps_too_narrow_for_the_body_are_skipped():
    # Openings between points 3 m away: 2 * 3 * sin(5 deg) = 0.52 m is less than 2.2 R = 0.55 m.
    ranges = np.full(360, 3.0)
    ranges[10:19] = math.inf
    assert ordered(ranges, (3.5, 0.0)).situation == "blocked"
    ranges[250:270] = math.inf
    assert ordered(ranges, (3.5, 0.0)).gap_rad == pytest.approx(math.radians(-90.5))
    ranges[10:20] = math.inf  # 0.575 m
    assert ordered(ranges, (3.5, 0.0)).gap_rad == pytest.approx(math.radians(9.5))


def test_valley_is_on_the_far_side_of_a_jump():
    # A step of 0.6 m in a closed room: the far side is the valley, from there the gap rises.
    ranges = np.full(360, 2.0)
    ranges[90:180] = 2.6
    found = ordered(ranges, (3.0, 0.2))
    assert found.gap_rad == pytest.approx(math.radians(89.5))
    assert found.valley_rad == pytest.approx(math.radians(90))
    # 0.5 m is no more than the body's width.
    ranges[90:180] = 2.5
    assert ordered(ranges, (3.0, 0.2)).situation == "blocked"


def test_near_obstacles_turn_the_heading_away():
    # One beam hits, 0.45 m away on the left: Ds = 5 * 0.2 = 1 m, s = (1 + 0.25 - 0.45) / 1 = 0.8;
    # away from it is -90 degrees.
    ranges = OPEN.copy()
    ranges[90] = 0.45
    found = ordered(ranges, (3.0, 0.0))
    assert found.desired_rad == 0.0
    assert found.heading_rad == pytest.approx(-0.8 * math.pi / 2)
    # A second on the other side, 0.65 m away: s = 0.6.
    ranges[270] = 0.65
    push = (-(0.8**3) + 0.6**3) / (0.8**2 + 0.6**2) * math.pi / 2
    assert ordered(ranges, (3.0, 0.0)).heading_rad == pytest.approx(push)
    # Speed: distance 0.2 m of D = 1 m, reduced for the turn.
    clipped = max(0.0, 1.0 - 6.0 * abs(push) / math.pi)
    assert ordered(ranges, (3.0, 0.0)).speed_m_s == pytest.approx(0.5 * 0.2 * clipped)


def test_speed_is_zero_in_contact():
    ranges = OPEN.copy()
    ranges[180] = 0.25
    found = ordered(ranges, (3.0, 0.0))
    assert found.speed_m_s == 0.0
    assert found.heading_rad == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ranges": np.full(7, 1.0)}, "at least 8"),
        ({"ranges": np.full((8, 2), 1.0)}, "at least 8"),
        ({"ranges": np.array([1.0] * 9 + [math.nan])}, "reading"),
        ({"ranges": np.array([1.0] * 9 + [-0.1])}, "reading"),
        ({"goal": (math.nan, 0.0)}, "goal"),
        ({"radius_m": 0.0}, "radius_m"),
        ({"v_max_m_s": math.inf}, "v_max_m_s"),
        ({"w_max_rad_s": -1.0}, "w_max_rad_s"),
        ({"range_m": math.nan}, "range_m"),
        ({"avoid_m": 0.0}, "avoid_m"),
    ],
)
def test_invalid_input_is_rejected(change, message):
    given_ = {
        "ranges": OPEN,
        "radius_m": 0.25,
        "goal": (1.0, 0.0),
        "v_max_m_s": 0.5,
        "w_max_rad_s": 1.0,
        "range_m": 4.0,
    } | change
    with pytest.raises(InvalidInputError, match=message):
        command(**given_)


runs_of_beams = st.lists(
    st.tuples(st.integers(1, 40), st.one_of(st.just(math.inf), st.floats(0.3, 4.5))),
    min_size=1,
    max_size=12,
)
goals = st.tuples(st.floats(-5, 5), st.floats(0.013, 5))


def fan(runs) -> np.ndarray:
    ranges = np.concatenate([np.full(count, distance) for count, distance in runs])
    return np.resize(ranges, 360)


@pytest.mark.slow
@given(runs_of_beams, goals)
def test_mirrored_readings_give_mirrored_commands(runs, goal):
    ranges = fan(runs)
    left = ordered(ranges, goal)
    right = ordered(np.roll(ranges[::-1], 1), (goal[0], -goal[1]))
    # Of two equally near gaps the first is taken, and an obstacle exactly in the desired
    # direction turns the heading to the right.
    assume(not abs(left.gap_rad - right.gap_rad) < 1e-9)
    beam = math.degrees(left.desired_rad)
    assume(abs(beam - round(beam)) > 1e-6)
    assume(abs(left.heading_rad) < math.pi - 1e-6)
    assert right.situation == left.situation
    assert right.speed_m_s == pytest.approx(left.speed_m_s, abs=1e-9)
    assert right.heading_rad == pytest.approx(-left.heading_rad, abs=1e-6)
    assert right.turn_rate_rad_s == pytest.approx(-left.turn_rate_rad_s, abs=1e-6)


@given(runs_of_beams, goals)
def test_commands_respect_the_limits(runs, goal):
    for any_direction in (False, True):
        found = ordered(fan(runs), goal, any_direction=any_direction)
        assert 0.0 <= found.speed_m_s <= 0.5
        assert abs(found.turn_rate_rad_s) <= 1.5
        assert -math.pi < found.heading_rad <= math.pi
        assert math.isnan(found.gap_rad) == (found.situation in ("goal", "turn", "blocked"))


@given(runs_of_beams, goals)
def test_safe_time_has_a_lower_bound(runs, goal):
    # The command is made for the radius with the margin, from beams that see the nearest obstacle.
    ranges = fan(runs)
    found = ordered(ranges, goal)
    assert safe_time(found, float(ranges.min()), 0.25) >= 4 * 0.25 / 0.5 - 1e-9


# Driving in closed loop ----------------------------------------------------------------------

RADIUS_M, MARGIN_M = 0.25, 0.02


class Driven(NamedTuple):
    arrived: bool
    clearance_m: float
    driven: shapely.LineString


def drive(worlds, free, start, goal, kinematics, *, range_m=RANGE_M, hold_s=0.2, steps=900):
    """Drive a disc by true readings until it is 0.1 m from its goal."""
    index, rings = worlds.index(free, range_m), rings_of(free)
    at = start
    driven = [start[:2]]
    for _ in range(steps):
        towards = in_frame_of(at, *goal)
        if math.hypot(*towards) < 0.1:
            break
        found = command(
            laser_ranges(index, at.x, at.y, range_m, BEAMS, first_rad=at.heading),
            RADIUS_M + MARGIN_M,
            towards,
            0.5,
            math.pi / 2,
            range_m=range_m,
            any_direction=isinstance(kinematics, Holonomic),
        )
        clearance = disc_clearance(rings, at.x, at.y)
        held = min(hold_s, safe_time(found, clearance, RADIUS_M, margin_m=MARGIN_M / 2))
        step = motion(found, kinematics, at, held)
        assert step.length_m <= clearance - RADIUS_M
        driven += [step.at(share * held)[:2] for share in (0.25, 0.5, 0.75, 1.0)]
        at = step.end
    line = shapely.LineString(driven if len(driven) > 1 else driven * 2)
    return Driven(math.dist(at[:2], goal) < 0.1, free.boundary.distance(line), line)


def without(free, *obstacles):
    return free.difference(shapely.union_all(obstacles))


def disc(x: float, y: float, radius: float) -> shapely.Polygon:
    return shapely.Point(x, y).buffer(radius)


BENT_CORRIDOR = box(0, 0, 10, 1.2).union(box(8.8, 0, 10, 8))
# A door as wide as two bodies.
DOORWAY = without(box(0, 0, 8, 6), box(3.9, 0, 4.1, 2.5), box(3.9, 3.5, 4.1, 6))
# A niche that is open to the left.
NICHE = without(box(0, 0, 8, 8), box(2, 3, 4, 3.2), box(2, 4.8, 4, 5), box(3.8, 3, 4, 5))
SLALOM = without(
    box(0, 0, 12, 4),
    *(disc(x, y, 0.5) for x, y in [(2.5, 1.7), (4.5, 2.4), (6.5, 1.6), (8.5, 2.3)]),
)
STANDING_ROBOT = without(box(0, 0, 8, 3), disc(4, 1.5, RADIUS_M))
SHUT_DOOR = without(DOORWAY, disc(4.0, 3.0, RADIUS_M))

WAYS = {
    "corridor": (box(0, 0, 10, 1.0), (0.6, 0.4, 2.0), (9.4, 0.5)),
    "bent corridor": (BENT_CORRIDOR, (0.6, 0.5, 2.0), (9.4, 7.0)),
    "doorway": (DOORWAY, (1.0, 1.0, 0.0), (7.0, 1.0)),
    "straight through a doorway": (DOORWAY, (1.0, 3.0, 0.0), (7.0, 3.0)),
    "out of a niche": (NICHE, (3.2, 4.0, 0.0), (6.0, 6.5)),
    "slalom": (SLALOM, (0.8, 2.0, 0.0), (11.0, 2.0)),
    "past a robot": (STANDING_ROBOT, (1.0, 1.5, 0.0), (7.0, 1.5)),
}


@pytest.mark.parametrize("kinematics", [DRIVE, ANYWAYS], ids=["differential", "holonomic"])
@pytest.mark.parametrize("name", WAYS)
def test_driving_arrives_without_contact(worlds, name, kinematics):
    free, start, goal = WAYS[name]
    driven = drive(worlds, free, Configuration(*start), goal, kinematics)
    assert driven.arrived
    assert driven.clearance_m > RADIUS_M


@pytest.mark.parametrize("hold_s", [0.1, 0.25])
def test_driving_arrives_at_other_control_periods(worlds, hold_s):
    free, start, goal = WAYS["slalom"]
    driven = drive(worlds, free, Configuration(*start), goal, DRIVE, hold_s=hold_s)
    assert driven.arrived
    assert driven.clearance_m > RADIUS_M


def test_driving_leaves_the_niche_by_its_opening(worlds):
    free, start, goal = WAYS["out of a niche"]
    driven = drive(worlds, free, Configuration(*start), goal, DRIVE).driven
    assert driven.intersects(box(1.0, 3.2, 2.0, 4.8))


@pytest.mark.parametrize("kinematics", [DRIVE, ANYWAYS], ids=["differential", "holonomic"])
def test_driving_fails_behind_a_wall_before_the_goal(worlds, kinematics):
    # The ways round above and below are equally good, and the robot goes back and forth.
    driven = drive(worlds, NICHE, Configuration(3.2, 4.0, 0.0), (6.0, 4.2), kinematics)
    assert not driven.arrived
    assert driven.clearance_m > RADIUS_M


def test_driving_stops_before_a_shut_door(worlds):
    # A gap of 0.25 m remains beside the robot in the door.
    driven = drive(worlds, SHUT_DOOR, Configuration(1.0, 3.0, 0.0), (7.0, 3.0), DRIVE)
    assert not driven.arrived
    assert driven.clearance_m > RADIUS_M


spots = st.tuples(st.floats(0.6, 7.4), st.floats(0.6, 5.4))


@pytest.mark.slow
@given(
    st.lists(st.tuples(spots, st.floats(0.1, 0.6)), max_size=5),
    spots,
    spots,
    st.floats(-3.14, 3.14),
    st.sampled_from([DRIVE, ANYWAYS]),
)
@settings(max_examples=60)
def test_driving_never_touches_anything(worlds, discs, start, goal, heading, kinematics):
    free = without(DOORWAY, *(disc(x, y, radius) for (x, y), radius in discs))
    free = next(
        (p for p in shapely.get_parts(free) if p.contains(shapely.Point(start))), shapely.Polygon()
    )
    assume(free.boundary.distance(shapely.Point(start)) > RADIUS_M + MARGIN_M)
    x, y = start
    at = Configuration(x, y, wrap_angle(heading))
    driven = drive(worlds, free, at, goal, kinematics, steps=200)
    assert driven.clearance_m > RADIUS_M
