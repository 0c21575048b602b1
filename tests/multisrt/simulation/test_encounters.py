"""Other bodies, discs of 0.25 m: protective stops, collisions and sightings."""

import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import Blocked, Collision, Motion
from multisrt.geometry.configuration import Configuration
from multisrt.robots.explorer import Done, Look, Moved, Receive

END = Done(complete=True, reason="enough")
FACING = [(1.0, 3.0), (9.0, 3.0)]


def test_robots_that_meet_head_on_stop_and_can_leave(play, straight, events_of):
    # 8 m between them, 1 m when bodies are half a metre apart: 3.5 m each, in 7 s.
    def drive(x0, x1):
        moved = yield straight(x0, 3, x1, 3, guard_m=0.5)
        assert moved.time_s == pytest.approx(7.0, abs=1e-3)
        assert moved.blocked_by is not None
        here = moved.configuration
        yield Receive(1.0)
        assert here.x == pytest.approx(x0 + 3.5 if x1 > x0 else x0 - 3.5, abs=1e-3)
        moved = yield straight(*here[:2], x0, 3, guard_m=0.5)
        assert moved.time_s == pytest.approx(15.0, abs=2e-3)
        assert moved == Moved(configuration=Configuration(x0, 3.0, 0.0), time_s=moved.time_s)
        yield END

    recording, told = play(lambda: drive(1.0, 9.0), lambda: drive(9.0, 1.0), starts=FACING)
    assert recording.footer.outcome == "complete"
    blocked = events_of(recording, Blocked)
    assert sorted((event.robot, event.by) for event in blocked) == [(0, 1), (1, 0)]
    for robot, other in ((0, 1), (1, 0)):
        sighting = told[robot][0].blocked_by
        assert sighting.robot == other
        assert str(sighting.footprint) == "disc:0.25"
        (event,) = events_of(recording, Blocked, robot)
        assert event.configuration == told[robot][0].configuration
        assert event.time_s == told[robot][0].time_s
    apart = told[1][0].configuration.x - told[0][0].configuration.x
    assert apart == pytest.approx(1.0, abs=1e-3)
    assert apart >= 1.0


def test_the_protective_stop_before_a_body_that_stands(play, straight, events_of):
    def drive():
        moved = yield straight(1, 3, 8, 3, guard_m=0.5)
        # The other stands at 5: 4 m less two radii and the guard.
        assert moved.configuration.x == pytest.approx(4.0, abs=1e-3)
        assert moved.configuration.x <= 4.0
        assert moved.time_s == pytest.approx(6.0, abs=1e-3)
        # It is within the guard now: the next stop is at half the distance.
        moved = yield straight(*moved.configuration[:2], 8, 3, guard_m=0.5)
        assert moved.configuration.x == pytest.approx(4.25, abs=2e-3)
        assert moved.blocked_by.robot == 1
        yield END

    recording, _ = play(drive, [END], starts=[(1.0, 3.0), (5.0, 3.0)])
    assert recording.footer.outcome == "complete"
    assert len(events_of(recording, Blocked)) == 2


def test_a_robot_that_leaves_in_time_blocks_no_other(play, straight, events_of):
    # Robot 1 has left the path before robot 0 arrives.
    recording, told = play(
        [straight(1, 3, 8, 3, guard_m=0.5), END],
        [straight(5, 3, 5, 5.5, guard_m=0.5), END],
        starts=[(1.0, 3.0), (5.0, 3.0)],
    )
    assert told[0][0].blocked_by is None
    assert events_of(recording, Blocked) == []


def test_a_robot_that_sets_out_later_can_block_a_moving_one(play, straight):
    # Robot 1 crosses at 6 s, when robot 0 is at 4: it stops before the crossing.
    def cross():
        yield Receive(2.0)
        yield straight(5, 5, 5, 3)
        yield END

    recording, told = play(
        [straight(1, 3, 8, 3, guard_m=0.5), END], cross, starts=[(1.0, 3.0), (5.0, 5.0)]
    )
    assert told[0][0].blocked_by.robot == 1
    assert told[0][0].configuration.x < 5.0
    assert recording.footer.outcome == "complete"


@pytest.mark.parametrize("other", ["stands", "comes"])
def test_bodies_that_touch_end_the_run(play, hall, word, straight, other):
    move = straight(9, 3, 1, 3)
    recording, told = play(
        [straight(1, 3, 9, 3), END],
        [Receive(), END] if other == "stands" else [move, END],
        starts=FACING,
    )
    collision = recording.events[-1]
    assert isinstance(collision, Collision)
    assert recording.footer.outcome == "stalled"
    for word in ("touched", "robot 0", "robot 1"):
        assert word in recording.footer.reason
    # Centres are half a metre apart then.
    time = 15.0 if other == "stands" else 7.5
    assert collision.time_s == pytest.approx(time, abs=1e-3)
    assert recording.footer.time_s == collision.time_s
    assert told[0] == []
    assert measure(recording, hall).collisions == 1


def test_all_motions_before_a_collision_are_recorded(play, straight, events_of):
    recording, _ = play(
        [straight(1, 3, 9, 3), END],
        [straight(9, 3, 1, 3), END],
        [straight(1, 1, 9, 1), END],
        starts=[*FACING, (1.0, 1.0)],
    )
    ends = {motion.robot: motion.waypoints[-1] for motion in events_of(recording, Motion)}
    assert {robot: end[1] for robot, end in ends.items()} == pytest.approx(
        {0: 4.75, 1: 5.25, 2: 4.75}, abs=1e-3
    )


def test_look_returns_the_bodies_in_sight_and_range(play, hall):
    wall = Environment("wall", hall.free.difference(shapely.box(1.5, 2.9, 3, 3.1)))
    starts = [(2.0, 1.0), (5.0, 1.0), (2.0, 5.0), (9.0, 1.0)]
    _, told = play([Look(), END], *[[END]] * 3, starts=starts, world=wall)
    (sighting,) = told[0][0]
    assert (sighting.robot, sighting.configuration) == (1, Configuration(5.0, 1.0, 0.0))
    assert str(sighting.footprint) == "disc:0.25"


def test_look_sees_where_the_others_are_now(play, straight):
    _, told = play(
        [Receive(2.0), Look(), END], [straight(1, 5, 3, 5), END], starts=[(1.0, 3.0), (1.0, 5.0)]
    )
    assert told[0][1][0].configuration == Configuration(2.0, 5.0, 0.0)
