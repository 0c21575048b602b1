import math
from typing import NamedTuple

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from multisrt.geometry.bodies.clearance import disc_clearance, rings_of
from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic
from multisrt.planners.navigation.nearness_diagram import (
    BEAMS,
    Command,
    command,
    in_frame_of,
    known_clearance,
    motion,
    nearer,
    region_ranges,
    safe_time,
)

RANGE_M = 4.0
DRIVE = Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2)
ANYWAYS = Holonomic(speed_m_s=0.5)


def ordered(ranges, goal, **options) -> Command:
    return command(ranges, 0.25, goal, 0.5, 1.5, range_m=RANGE_M, **options)


OPEN = np.full(360, math.inf)


# One command, worked out by hand -------------------------------------------------------------


def test_in_the_open_it_drives_at_the_goal():
    assert ordered(OPEN, (2.0, 0.0)) == pytest.approx(
        Command(0.5, 0.0, 0.0, "goal", 0.0, math.nan, math.nan), nan_ok=True
    )


def test_it_slows_down_for_a_turn_and_near_the_goal():
    # 15 degrees to the left: half the speed, and a sixth of the greatest turn rate.
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


def test_a_closed_room_has_no_way_to_a_goal_outside():
    closed = np.full(360, 2.0)
    found = ordered(closed, (0.0, 3.0))
    assert (found.situation, found.speed_m_s) == ("blocked", 0.0)
    assert found.turn_rate_rad_s == pytest.approx(1.5)


def test_the_corridor_to_the_goal_is_as_wide_as_the_body_and_as_long_as_the_way():
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


def test_past_the_corner_of_the_gap_nearest_to_the_goal():
    found = ordered(blocked_ahead(2.0), (3.0, 0.0))
    # The gap lies between the beams at -20 and -21 degrees; D + R = 1.25 m of the corner's 2 m.
    assert found.situation == "gap"
    assert found.gap_rad == pytest.approx(math.radians(-20.5))
    assert found.desired_rad == pytest.approx(math.radians(-20.5) - math.asin(1.25 / 2.0))
    # The valley has all that is open: 279 beams.
    assert found.valley_rad == pytest.approx(-math.radians(279))
    # Nothing is within D + R: no push.
    assert found.heading_rad == found.desired_rad
    # A near corner is passed at a right angle, and a goal on the left has the other gap.
    assert ordered(blocked_ahead(1.25), (3.0, 0.0)).desired_rad == pytest.approx(
        math.radians(-110.5)
    )
    assert ordered(blocked_ahead(2.0), (3.0, 1.5)).gap_rad == pytest.approx(math.radians(60.5))


def test_the_middle_of_a_narrow_valley():
    # Walls all around at 3 m, open for 40 degrees on the left.
    ranges = np.full(360, 3.0)
    ranges[70:110] = math.inf
    found = ordered(ranges, (3.5, 0.5))
    assert found.situation == "middle"
    assert found.desired_rad == pytest.approx(math.radians(89.5))
    assert abs(found.valley_rad) == pytest.approx(math.radians(40))


def test_a_gap_that_is_too_narrow_is_passed_over():
    # Openings between points 3 m away: 2 * 3 * sin(5 deg) = 0.52 m is less than 2.2 R = 0.55 m.
    ranges = np.full(360, 3.0)
    ranges[10:19] = math.inf
    assert ordered(ranges, (3.5, 0.0)).situation == "blocked"
    ranges[250:270] = math.inf
    assert ordered(ranges, (3.5, 0.0)).gap_rad == pytest.approx(math.radians(-90.5))
    ranges[10:20] = math.inf  # 0.575 m
    assert ordered(ranges, (3.5, 0.0)).gap_rad == pytest.approx(math.radians(9.5))


def test_only_the_valley_behind_a_jump_is_one():
    # A step of 0.6 m in a closed room: the far side is the valley, from there the gap rises.
    ranges = np.full(360, 2.0)
    ranges[90:180] = 2.6
    found = ordered(ranges, (3.0, 0.2))
    assert found.gap_rad == pytest.approx(math.radians(89.5))
    assert found.valley_rad == pytest.approx(math.radians(90))
    # 0.5 m is no more than the body's width.
    ranges[90:180] = 2.5
    assert ordered(ranges, (3.0, 0.2)).situation == "blocked"


def test_an_obstacle_within_reach_pushes_the_heading_away():
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
    # Speed: distance 0.2 m of D = 1 m, and the turn to be made.
    clipped = max(0.0, 1.0 - 6.0 * abs(push) / math.pi)
    assert ordered(ranges, (3.0, 0.0)).speed_m_s == pytest.approx(0.5 * 0.2 * clipped)


def test_touching_something_it_does_not_drive():
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
def test_what_it_refuses(change, message):
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


@given(runs_of_beams, goals)
def test_a_mirrored_world_is_driven_in_mirrored(runs, goal):
    ranges = fan(runs)
    left = ordered(ranges, goal)
    right = ordered(np.roll(ranges[::-1], 1), (goal[0], -goal[1]))
    # Of two gaps on either side that are equally near the first is taken, and what is met
    # exactly where it wants to go turns it to the right.
    assume(not abs(left.gap_rad - right.gap_rad) < 1e-9)
    beam = math.degrees(left.desired_rad)
    assume(abs(beam - round(beam)) > 1e-6)
    assume(abs(left.heading_rad) < math.pi - 1e-6)
    assert right.situation == left.situation
    assert right.speed_m_s == pytest.approx(left.speed_m_s, abs=1e-9)
    assert right.heading_rad == pytest.approx(-left.heading_rad, abs=1e-6)
    assert right.turn_rate_rad_s == pytest.approx(-left.turn_rate_rad_s, abs=1e-6)


@given(runs_of_beams, goals)
def test_commands_keep_the_limits(runs, goal):
    for any_direction in (False, True):
        found = ordered(fan(runs), goal, any_direction=any_direction)
        assert 0.0 <= found.speed_m_s <= 0.5
        assert abs(found.turn_rate_rad_s) <= 1.5
        assert -math.pi < found.heading_rad <= math.pi
        assert math.isnan(found.gap_rad) == (found.situation in ("goal", "turn", "blocked"))


# Motions -------------------------------------------------------------------------------------


def test_a_differential_drive_follows_the_arc_of_its_twist():
    held = Command(0.5, 1.0, 0.4, "goal", 0.4, math.nan, math.nan)
    way = motion(held, DRIVE, Configuration(1.0, 2.0, 0.3), 0.5)
    assert way.length_m == pytest.approx(0.25)
    assert way.duration_s == 0.5
    assert way.waypoints[-1].heading == pytest.approx(0.8)
    # About the centre that lies v / w = 0.5 m to the left.
    centre = (1.0 - 0.5 * math.sin(0.3), 2.0 + 0.5 * math.cos(0.3))
    assert math.dist(way.end[:2], centre) == pytest.approx(0.5)
    straight = motion(held._replace(turn_rate_rad_s=0.0), DRIVE, Configuration(1.0, 2.0, 0.0), 0.5)
    assert straight.end == pytest.approx((1.25, 2.0, 0.0))


def test_a_holonomic_drive_goes_where_it_heads_without_turning():
    held = Command(0.5, 0.0, math.pi / 2, "goal", 0.4, math.nan, math.nan)
    assert motion(held, ANYWAYS, Configuration(1.0, 2.0, math.pi / 2), 0.2).end == pytest.approx(
        (0.9, 2.0, math.pi / 2)
    )


def test_cars_are_refused_and_so_is_no_time():
    held = ordered(OPEN, (2.0, 0.0))
    with pytest.raises(InvalidInputError, match="car cannot turn in place"):
        motion(held, Car(), Configuration(0.0, 0.0), 0.2)
    with pytest.raises(InvalidInputError, match="positive time"):
        motion(held, DRIVE, Configuration(0.0, 0.0), 0.0)


def test_safe_time():
    held = ordered(OPEN, (2.0, 0.0))
    assert safe_time(held, 0.45, 0.25) == pytest.approx(0.4)
    assert safe_time(held, 0.45, 0.25, margin_m=0.1) == pytest.approx(0.2)
    assert safe_time(held, 0.2, 0.25) == 0.0
    assert safe_time(held._replace(speed_m_s=0.0), 0.2, 0.25) == math.inf


@given(runs_of_beams, goals)
def test_a_command_may_be_held_for_as_long_as_promised(runs, goal):
    # Made for the radius with the margin, from beams that show what is nearest.
    ranges = fan(runs)
    found = ordered(ranges, goal)
    assert safe_time(found, float(ranges.min()), 0.25) >= 4 * 0.25 / 0.5 - 1e-9


# Beams ---------------------------------------------------------------------------------------


def test_the_frame_of_a_robot():
    assert in_frame_of(Configuration(1.0, 2.0, math.pi / 2), 1.0, 5.0) == pytest.approx((3.0, 0.0))
    assert in_frame_of(Configuration(1.0, 2.0, math.pi / 2), 0.0, 2.0) == pytest.approx((0.0, 1.0))


@given(
    st.lists(
        st.tuples(st.floats(-4, 4), st.floats(-4, 4), st.floats(0.05, 1.0)), min_size=1, max_size=3
    )
)
@settings(max_examples=30)
def test_discs_and_polygons_shorten_beams(discs):
    assume(all(abs(math.hypot(x, y) - r) > 0.01 for x, y, r in discs))
    count = 32
    ranges = np.linspace(1.0, 4.0, count)
    shapes = [shapely.Point(x, y).buffer(r, quad_segs=64) for x, y, r in discs]
    bodies = shapely.union_all(shapes)
    expected = []
    for k in range(count):
        t = k * 2.0 * math.pi / count
        ray = shapely.LineString([(0, 0), (ranges[k] * math.cos(t), ranges[k] * math.sin(t))])
        met = ray.intersection(bodies)
        expected.append(ranges[k] if met.is_empty else met.distance(shapely.Point(0, 0)))
    polygons = [np.asarray(shape.exterior.coords)[:-1] for shape in shapes]
    if bodies.contains(shapely.Point(0, 0)):
        expected = [0.0] * count
    assert nearer(ranges, polygons=polygons) == pytest.approx(expected, abs=1e-9)
    # Chords lie inside the circle by 0.3 mm a metre; a grazing beam meets one and not the other.
    round_ = nearer(ranges, np.array(discs))
    assert (np.abs(round_ - expected) < 0.02).mean() > 0.9
    assert (round_ <= np.array(expected) + 1e-9).all()


def test_a_disc_straight_ahead():
    cut = nearer(OPEN, np.array([[2.0, 0.0, 0.5]]))
    assert cut[0] == pytest.approx(1.5)
    hit = np.flatnonzero(np.isfinite(cut))
    # asin(0.5 / 2) = 14.48 degrees to either side.
    assert sorted(hit) == [*range(15), *range(346, 360)]
    assert cut is not OPEN
    assert np.isinf(OPEN).all()


@pytest.mark.parametrize("world", ["rooms", "office", "clutter"])
@pytest.mark.parametrize("exact", [True, False])
def test_a_region_shows_the_surfaces_that_a_laser_sees(worlds, world, exact):
    free = worlds.WORLDS[world]()
    index = worlds.index(free, RANGE_M)
    for x, y in worlds.viewpoints(free, 12).tolist():
        at = Configuration(x, y, 0.7)
        scan = take_scan(index, at, 0.0, RANGE_M, None if exact else 720)
        region = local_safe_region(scan, "radial")
        seen = region_ranges(region, at, 360)
        true = laser_ranges(index, x, y, RANGE_M, 360, first_rad=0.7)
        hit, seen_there, there = np.isfinite(seen), seen[np.isfinite(true)], true[np.isfinite(true)]
        if exact:
            # But for beams that meet a corner, and surfaces right at the range.
            assert (hit == np.isfinite(true)).mean() > 0.98
            assert np.isclose(seen, true, rtol=0.0, atol=1e-6).mean() > 0.98
        else:
            # The region ends before the surfaces, but for stones' sharp corners.
            found = np.isfinite(seen_there)
            assert found.mean() > 0.7
            assert (seen_there <= there + 1e-9)[found].mean() > 0.98


def test_a_region_from_another_place_in_it(worlds):
    free = worlds.pillar()
    region = local_safe_region(
        take_scan(worlds.index(free, 20.0), Configuration(2.0, 5.0), 0.0, 20.0), "radial"
    )
    at = Configuration(2.0, 8.0, 0.0)
    seen = region_ranges(region, at, 8)
    # Walls to the left and above, the pillar's shadow's edge below, open; the scan's place.
    shadow = math.inf
    expected = [shadow, math.hypot(2, 2), 2.0, math.hypot(2, 2), 2.0, math.hypot(2, 2), 8.0]
    assert seen[:7] == pytest.approx(expected)
    # Down to the right the pillar's left side is met beside its corner.
    assert seen[7] == pytest.approx(math.hypot(2.0, 2.0))
    assert region.tags.min() == OBSTACLE
    # Over the shadow lies another part of the region, with a wall behind it: the opening counts.
    assert region_ranges(region, Configuration(9.0, 9.2, -math.pi / 2), 8)[0] == math.inf
    assert region_ranges(region, Configuration(9.0, 0.8, math.pi / 2), 8)[0] == math.inf


def test_a_robot_is_in_its_region(worlds):
    region = local_safe_region(
        take_scan(worlds.index(worlds.hall()), Configuration(2.0, 5.0), 0.0, 4.0), "radial"
    )
    with pytest.raises(InvalidInputError, match="not in the region"):
        region_ranges(region, Configuration(9.0, 9.0))
    with pytest.raises(InvalidInputError, match="at least 8"):
        region_ranges(region, Configuration(2.0, 5.0), 4)


def test_known_clearance():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    at = Configuration(1.0, 2.0)
    assert known_clearance(square, at) == 1.0
    assert known_clearance(square, at, np.array([[2.0, 2.0, 0.3]])) == pytest.approx(0.7)
    assert known_clearance(square, at, np.array([[1.2, 2.0, 0.3]])) == 0.0
    assert known_clearance(square, at, np.empty((0, 3))) == 1.0
    assert known_clearance(square, Configuration(5.0, 2.0)) == 0.0


# Driving in closed loop ----------------------------------------------------------------------

RADIUS_M, MARGIN_M = 0.25, 0.02


class Driven(NamedTuple):
    arrived: bool
    clearance_m: float
    way: shapely.LineString


def drive(worlds, free, start, goal, kinematics, *, range_m=RANGE_M, hold_s=0.2, steps=900):
    """Drive a disc by true beams until it is 0.1 m from its goal."""
    index, rings = worlds.index(free, range_m), rings_of(free)
    at = start
    way = [start[:2]]
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
        way += [step.at(share * held)[:2] for share in (0.25, 0.5, 0.75, 1.0)]
        at = step.end
    line = shapely.LineString(way if len(way) > 1 else way * 2)
    return Driven(math.dist(at[:2], goal) < 0.1, free.boundary.distance(line), line)


def box(*bounds: float) -> shapely.Polygon:
    return shapely.box(*bounds)


def without(free, *obstacles):
    return free.difference(shapely.union_all(obstacles))


def disc(x: float, y: float, radius: float) -> shapely.Polygon:
    return shapely.Point(x, y).buffer(radius)


BENT_CORRIDOR = box(0, 0, 10, 1.2).union(box(8.8, 0, 10, 8))
# A door as wide as two bodies.
DOORWAY = without(box(0, 0, 8, 6), box(3.9, 0, 4.1, 2.5), box(3.9, 3.5, 4.1, 6))
# A niche that is open to the left, and a goal behind its wall and further up.
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
def test_it_arrives_and_never_touches(worlds, name, kinematics):
    free, start, goal = WAYS[name]
    driven = drive(worlds, free, Configuration(*start), goal, kinematics)
    assert driven.arrived
    assert driven.clearance_m > RADIUS_M


@pytest.mark.parametrize("hold_s", [0.1, 0.25])
def test_commands_may_be_held_longer_or_shorter(worlds, hold_s):
    free, start, goal = WAYS["slalom"]
    driven = drive(worlds, free, Configuration(*start), goal, DRIVE, hold_s=hold_s)
    assert driven.arrived
    assert driven.clearance_m > RADIUS_M


def test_out_of_the_niche_by_its_opening(worlds):
    free, start, goal = WAYS["out of a niche"]
    way = drive(worlds, free, Configuration(*start), goal, DRIVE).way
    assert way.intersects(box(1.0, 3.2, 2.0, 4.8))


@pytest.mark.parametrize("kinematics", [DRIVE, ANYWAYS], ids=["differential", "holonomic"])
def test_alone_it_does_not_get_round_a_wall_right_before_its_goal(worlds, kinematics):
    # Out of the niche the ways round above and below are equally good: it cannot decide.
    driven = drive(worlds, NICHE, Configuration(3.2, 4.0, 0.0), (6.0, 4.2), kinematics)
    assert not driven.arrived
    assert driven.clearance_m > RADIUS_M


def test_before_a_door_that_is_shut_it_stays(worlds):
    # Beside the robot that stands in it there are 0.25 m.
    driven = drive(worlds, SHUT_DOOR, Configuration(1.0, 3.0, 0.0), (7.0, 3.0), DRIVE)
    assert not driven.arrived
    assert driven.clearance_m > RADIUS_M


spots = st.tuples(st.floats(0.6, 7.4), st.floats(0.6, 5.4))


@given(
    st.lists(st.tuples(spots, st.floats(0.1, 0.6)), max_size=5),
    spots,
    spots,
    st.floats(-3.14, 3.14),
    st.sampled_from([DRIVE, ANYWAYS]),
)
@settings(max_examples=60)
def test_it_never_touches_anything(worlds, discs, start, goal, heading, kinematics):
    free = without(DOORWAY, *(disc(*spot, radius) for spot, radius in discs))
    free = next(
        (p for p in shapely.get_parts(free) if p.contains(shapely.Point(start))), shapely.Polygon()
    )
    assume(free.boundary.distance(shapely.Point(start)) > RADIUS_M + MARGIN_M)
    at = Configuration(*start, wrap_angle(heading))
    driven = drive(worlds, free, at, goal, kinematics, steps=200)
    assert driven.clearance_m > RADIUS_M
