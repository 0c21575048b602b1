import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.bodies.motion import Motion
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.trajectory import (
    Trajectory,
    Waypoint,
    leg_length,
    leg_points,
    leg_pose,
    standing_at,
)

# Two metres along x in four seconds, a quarter turn to the left in one, one metre along y in two.
CORNER = Trajectory(
    (
        Waypoint(0.0, 1.0, 1.0, 0.0),
        Waypoint(4.0, 3.0, 1.0, 0.0),
        Waypoint(5.0, 3.0, 1.0, math.pi / 2),
        Waypoint(7.0, 3.0, 2.0, math.pi / 2),
    )
)


def test_duration_length_and_ends_of_a_motion():
    assert CORNER.duration_s == 7.0
    assert CORNER.length_m == 3.0
    assert CORNER.start == Configuration(1.0, 1.0, 0.0)
    assert CORNER.end == Configuration(3.0, 2.0, math.pi / 2)


@given(st.floats(0.3, 9.0))
def test_sections_add_up_to_the_motion(duration_s):
    sections = CORNER.sections(duration_s)
    assert math.fsum(section.duration_s for section in sections) == pytest.approx(7.0)
    assert all(s.duration_s == pytest.approx(duration_s) for s in sections[:-1])
    assert sections[-1].duration_s <= duration_s * (1.0 + 1e-6)
    begun = 0.0
    for section in sections:
        assert section.waypoints[0].time_s == 0.0
        middle = 0.5 * section.duration_s
        assert section.at(middle) == pytest.approx(CORNER.at(begun + middle))
        begun += section.duration_s
    assert CORNER.after(2.0).start == CORNER.at(2.0)
    assert CORNER.after(2.0).end == CORNER.end


@pytest.mark.parametrize(
    ("time_s", "expected"),
    [
        (-1.0, (1.0, 1.0, 0.0)),
        (0.0, (1.0, 1.0, 0.0)),
        (1.0, (1.5, 1.0, 0.0)),
        (4.0, (3.0, 1.0, 0.0)),
        (4.5, (3.0, 1.0, math.pi / 4)),
        (6.0, (3.0, 1.5, math.pi / 2)),
        (7.0, (3.0, 2.0, math.pi / 2)),
        (99.0, (3.0, 2.0, math.pi / 2)),
    ],
)
def test_configuration_at_a_time(time_s, expected):
    assert CORNER.at(time_s) == pytest.approx(expected)


def test_headings_are_wrapped_and_turns_are_signed():
    # From 3 rad by +1 rad: over pi, so to 4 - 2 pi.
    turn = Trajectory((Waypoint(0.0, 0.0, 0.0, 3.0), Waypoint(2.0, 0.0, 0.0, 4.0)))
    assert turn.end.heading == pytest.approx(4.0 - 2.0 * math.pi)
    assert turn.at(1.0).heading == pytest.approx(3.5 - 2.0 * math.pi)
    assert turn.waypoints[-1].heading == 4.0


def test_two_waypoints_may_share_a_time():
    # A leg of no duration is skipped.
    twice = Trajectory(
        (Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(2.0, 1.0, 0.0, 0.0))
    )
    assert twice.at(0.0) == (0.0, 0.0, 0.0)
    assert twice.at(1.0) == (0.5, 0.0, 0.0)
    assert twice.until(1.0).end == (0.5, 0.0, 0.0)


def test_a_single_waypoint_takes_no_time():
    still = Trajectory((Waypoint(0.0, 2.0, 3.0, 1.0),))
    assert (still.duration_s, still.length_m) == (0.0, 0.0)
    assert still.at(0.0) == still.at(5.0) == (2.0, 3.0, 1.0)
    assert still.until(0.0) == still.until(5.0) == still


@pytest.mark.parametrize(
    ("time_s", "end", "count"),
    [
        (0.0, (1.0, 1.0, 0.0), 1),
        (-3.0, (1.0, 1.0, 0.0), 1),
        (2.0, (2.0, 1.0, 0.0), 2),
        (4.0, (3.0, 1.0, 0.0), 2),
        (4.5, (3.0, 1.0, math.pi / 4), 3),
        (7.0, (3.0, 2.0, math.pi / 2), 4),
        (8.0, (3.0, 2.0, math.pi / 2), 4),
    ],
)
def test_until_cuts_off_the_rest(time_s, end, count):
    cut = CORNER.until(time_s)
    assert cut.end == pytest.approx(end)
    assert len(cut.waypoints) == count
    assert cut.duration_s == max(0.0, min(time_s, 7.0))


def test_then_adds_times_and_shifts_headings():
    first = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(3.0, 0.0, 0.0, 4.0)))
    # The heading at the joint is 4 in the first motion and 4 - 2 pi in the second.
    heading = 4.0 - 2.0 * math.pi
    second = Trajectory((Waypoint(0.0, 0.0, 0.0, heading), Waypoint(1.0, 0.0, 0.0, heading - 1.0)))
    joined = first.then(second)
    assert [w.time_s for w in joined.waypoints] == [0.0, 3.0, 4.0]
    assert [w.heading for w in joined.waypoints] == pytest.approx([0.0, 4.0, 3.0])


# A quarter circle to the left about (0, 1), from the origin.
QUARTER = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(2.0, 1.0, 1.0, math.pi / 2)))


def test_a_body_that_translates_and_turns_follows_an_arc():
    root = math.sqrt(0.5)
    assert QUARTER.at(1.0) == pytest.approx((root, 1.0 - root, math.pi / 4))
    assert QUARTER.length_m == pytest.approx(math.pi / 2)
    half = QUARTER.until(1.0)
    assert half.end == pytest.approx((root, 1.0 - root, math.pi / 4))
    assert half.length_m == pytest.approx(math.pi / 4)


def test_points_of_an_arc_are_on_it():
    points = QUARTER.points(spacing_rad=0.1)
    assert points.shape == (17, 2)
    assert np.hypot(points[:, 0], points[:, 1] - 1.0) == pytest.approx(1.0)
    assert points[[0, -1]].tolist() == [[0.0, 0.0], [1.0, 1.0]]


def test_points_of_straight_legs_and_turns_are_their_ends():
    # The turn in place counts with both ends.
    assert CORNER.points().tolist() == [[1.0, 1.0], [3.0, 1.0], [3.0, 1.0], [3.0, 2.0]]
    assert Trajectory(CORNER.waypoints[:1]).points().tolist() == [[1.0, 1.0]]


def test_reversed_runs_back_at_the_same_speeds():
    back = CORNER.reversed()
    assert back.start == CORNER.end
    assert back.end == CORNER.start
    assert [w.time_s for w in back.waypoints] == [0.0, 2.0, 3.0, 7.0]
    for time in (0.0, 1.0, 2.5, 6.9):
        assert back.at(time) == pytest.approx(CORNER.at(7.0 - time))


def test_arcs_of_more_than_half_a_circle_are_rejected():
    first = Waypoint(0.0, 0.0, 0.0, 0.0)
    with pytest.raises(InvalidInputError, match="half a circle"):
        Trajectory((first, Waypoint(1.0, 0.1, 0.0, 3.2)))
    # A turn in place may be longer.
    assert Trajectory((first, Waypoint(1.0, 0.0, 0.0, 6.0))).length_m == 0.0


turns = st.one_of(st.just(0.0), st.floats(1e-8, math.pi), st.floats(-math.pi, -1e-8))
numbers = st.floats(-50.0, 50.0)
steps = st.tuples(st.floats(0.0, 9.0), numbers, numbers, turns)


@given(numbers, numbers, numbers, numbers, numbers, turns, st.floats(0.0, 1.0))
def test_arcs_agree_with_collision_checks(x0, y0, heading, x1, y1, turn, fraction):
    a, b = (0.0, x0, y0, heading), (1.0, x1, y1, heading + turn)
    motion = Motion.between(a[1:], b[1:], b[3] - a[3], arc=True)
    assert leg_pose(a, b, fraction) == pytest.approx(motion.pose(fraction), abs=1e-5)
    assert leg_length(a, b) == pytest.approx(motion.length, abs=1e-6)
    line = shapely.LineString(leg_points(a, b, 0.01))
    assert line.length == pytest.approx(leg_length(a, b), rel=1e-4, abs=1e-9)


@given(numbers, numbers, turns)
def test_twist_of_a_leg_is_constant(x, y, turn):
    # In the body's frame the direction of motion is the same everywhere.
    a, b = (0.0, 0.0, 0.0, 0.3), (1.0, x, y, 0.3 + turn)
    step = 1e-4
    seen = []
    for fraction in (0.0, 0.4, 1.0 - step):
        x0, y0, heading = leg_pose(a, b, fraction)
        x1, y1, _ = leg_pose(a, b, fraction + step)
        c, s = math.cos(heading), math.sin(heading)
        dx, dy = x1 - x0, y1 - y0
        seen.append((c * dx + s * dy, c * dy - s * dx))
    assert seen[1] == pytest.approx(seen[0], abs=1e-9)
    assert seen[2] == pytest.approx(seen[0], abs=1e-9)


@st.composite
def trajectories(draw):
    time, heading = 0.0, 0.0
    waypoints: list[Waypoint] = []
    for wait, x, y, turn in draw(st.lists(steps, min_size=1, max_size=6)):
        time = time + wait if waypoints else 0.0
        heading += turn
        waypoints.append(Waypoint(time, x, y, heading))
    return Trajectory(tuple(waypoints))


@given(trajectories(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_parts_of_a_motion_agree_with_the_motion(trajectory, share, part):
    end = share * trajectory.duration_s
    cut = trajectory.until(end)
    assert cut.duration_s <= end
    assert all(a.time_s <= b.time_s for a, b in pairwise(cut.waypoints))
    assert cut.length_m <= trajectory.length_m + 1e-9
    time = part * cut.duration_s
    before, after = trajectory.at(time), cut.at(time)
    # Where two waypoints share a time the motion jumps, and the cut ends before the jump.
    times = [w.time_s for w in trajectory.waypoints]
    if (
        len(set(times)) == len(times)
        and min((b - a for a, b in pairwise(times)), default=1.0) > 1e-6
    ):
        assert after[:2] == pytest.approx(before[:2], abs=1e-6)
        assert math.cos(after.heading - before.heading) == pytest.approx(1.0, abs=1e-6)


@given(st.floats(1e-11, 1e-6), st.floats(0.01, 0.9), st.floats(0.1, 0.9))
def test_parts_of_a_leg_that_hardly_turns_are_where_the_leg_is(turn, share, part):
    leg = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(10.0, 5.0, 1.0, turn)))
    rest = leg.after(10.0 * share)
    time_s = part * rest.duration_s
    assert math.dist(rest.at(time_s)[:2], leg.at(10.0 * share + time_s)[:2]) < 1e-13


@given(trajectories(), trajectories())
def test_joined_motions_add_up(first, second):
    last, begin = first.waypoints[-1], second.waypoints[0]
    moved = Trajectory(
        tuple(
            Waypoint(w.time_s, w.x - begin.x + last.x, w.y - begin.y + last.y, w.heading)
            for w in second.waypoints
        )
    )
    joined = first.then(moved)
    assert joined.start == first.start
    assert joined.duration_s == pytest.approx(first.duration_s + moved.duration_s)
    assert joined.length_m == pytest.approx(first.length_m + moved.length_m, abs=1e-9)
    turn = moved.waypoints[-1].heading - begin.heading
    assert joined.waypoints[-1].heading == pytest.approx(last.heading + turn, abs=1e-9)


def test_ends_of_a_trajectory_follow_from_its_waypoints():
    motion = standing_at(Configuration(1.0, 2.0, 0.5))
    assert not hasattr(motion, "__dict__")
    for name in ("start", "end"):
        with pytest.raises(AttributeError):
            object.__setattr__(motion, name, Configuration(3.0, 4.0, 0.0))
    assert motion.end == (1.0, 2.0, 0.5)
