import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.trajectory import Trajectory, Waypoint

# Two metres along x in four seconds, a quarter turn to the left in one, one metre along y in two.
CORNER = Trajectory(
    (
        Waypoint(0.0, 1.0, 1.0, 0.0),
        Waypoint(4.0, 3.0, 1.0, 0.0),
        Waypoint(5.0, 3.0, 1.0, math.pi / 2),
        Waypoint(7.0, 3.0, 2.0, math.pi / 2),
    )
)


def test_duration_length_and_ends():
    assert CORNER.duration_s == 7.0
    assert CORNER.length_m == 3.0
    assert CORNER.start == Configuration(1.0, 1.0, 0.0)
    assert CORNER.end == Configuration(3.0, 2.0, math.pi / 2)


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
def test_at(time_s, expected):
    assert CORNER.at(time_s) == pytest.approx(expected)


def test_headings_are_wrapped_when_asked_for_but_turns_stay_signed():
    # From 3 rad by +1 rad: over pi, so to 4 - 2 pi.
    turn = Trajectory((Waypoint(0.0, 0.0, 0.0, 3.0), Waypoint(2.0, 0.0, 0.0, 4.0)))
    assert turn.end.heading == pytest.approx(4.0 - 2.0 * math.pi)
    assert turn.at(1.0).heading == pytest.approx(3.5 - 2.0 * math.pi)
    assert turn.waypoints[-1].heading == 4.0


def test_two_waypoints_at_one_time():
    # A motion of no length takes no time; what comes after it counts.
    twice = Trajectory(
        (Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(2.0, 1.0, 0.0, 0.0))
    )
    assert twice.at(0.0) == (0.0, 0.0, 0.0)
    assert twice.at(1.0) == (0.5, 0.0, 0.0)
    assert twice.until(1.0).end == (0.5, 0.0, 0.0)


def test_a_single_waypoint_is_a_motion_of_no_time():
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
def test_until(time_s, end, count):
    cut = CORNER.until(time_s)
    assert cut.end == pytest.approx(end)
    assert len(cut.waypoints) == count
    assert cut.duration_s == max(0.0, min(time_s, 7.0))


def test_then_adds_times_and_keeps_turns_signed():
    first = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(3.0, 0.0, 0.0, 4.0)))
    # Where the first ends its heading is 4, which this one calls 4 - 2 pi.
    heading = 4.0 - 2.0 * math.pi
    second = Trajectory((Waypoint(0.0, 0.0, 0.0, heading), Waypoint(1.0, 0.0, 0.0, heading - 1.0)))
    joined = first.then(second)
    assert [w.time_s for w in joined.waypoints] == [0.0, 3.0, 4.0]
    assert [w.heading for w in joined.waypoints] == pytest.approx([0.0, 4.0, 3.0])


numbers = st.floats(-50.0, 50.0)
steps = st.tuples(st.floats(0.0, 9.0), numbers, numbers, numbers)


@st.composite
def trajectories(draw):
    time, waypoints = 0.0, []
    for wait, x, y, heading in draw(st.lists(steps, min_size=1, max_size=6)):
        time = time + wait if waypoints else 0.0
        waypoints.append(Waypoint(time, x, y, heading))
    return Trajectory(tuple(waypoints))


@given(trajectories(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_what_is_kept_of_a_motion_is_the_motion(trajectory, share, part):
    end = share * trajectory.duration_s
    cut = trajectory.until(end)
    assert cut.duration_s <= end
    assert all(a.time_s <= b.time_s for a, b in pairwise(cut.waypoints))
    assert cut.length_m <= trajectory.length_m + 1e-9
    time = part * cut.duration_s
    before, after = trajectory.at(time), cut.at(time)
    # Where two waypoints share a time, the motion jumps there, and the cut ends before the jump.
    times = [w.time_s for w in trajectory.waypoints]
    if (
        len(set(times)) == len(times)
        and min((b - a for a, b in pairwise(times)), default=1.0) > 1e-6
    ):
        assert after[:2] == pytest.approx(before[:2], abs=1e-6)
        assert math.cos(after.heading - before.heading) == pytest.approx(1.0, abs=1e-6)


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
