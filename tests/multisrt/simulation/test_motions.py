"""Motions of one robot: walls, turns, and the end of time."""

import math

import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import Collision, Motion
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Done, Move, Sense
from multisrt.spec import RobotSpec


@pytest.mark.parametrize(
    ("x", "y", "heading"), [(1.001, 1.0, 0.0), (1.0, 0.999, 0.0), (1.0, 1.0, 0.01)]
)
def test_a_trajectory_from_elsewhere_is_refused(drive, straight, x, y, heading):
    with pytest.raises(InvalidInputError, match="robot 0") as error:
        drive(straight(x, y, 4.0, 1.0, heading=heading))
    assert "1.0" in str(error.value)


def test_headings_that_differ_by_a_full_turn_are_equal(drive, straight):
    recording, _ = drive(
        straight(1, 1, 3, 1, heading=2.0 * math.pi), Done(complete=True, reason="")
    )
    assert recording.footer.outcome == "complete"


def test_a_motion_into_a_wall_ends_the_run(drive, hall, straight):
    recording, explorer = drive(Sense(), straight(1, 1, 12, 1), Sense(), Done(True, "unseen"))
    collision = recording.events[-1]
    assert isinstance(collision, Collision)
    assert collision.configuration == (1.0, 1.0, 0.0)
    assert recording.footer.outcome == "stalled"
    assert "touched an obstacle" in recording.footer.reason
    assert len(explorer.told) == 1
    metrics = measure(recording, hall)
    assert metrics.collisions == 1
    assert metrics.outcome == "stalled"


def test_a_thin_wall_is_not_passed(drive, hall, straight):
    world = Environment("two", hall.free.difference(shapely.box(5, 0, 5.001, 6)))
    recording, _ = drive(straight(1, 1, 9, 1), world=world)
    assert recording.footer.outcome == "stalled"


def test_the_second_leg_of_a_trajectory_collides(drive):
    bent = Move(
        trajectory=Trajectory(
            (Waypoint(0, 1, 1, 0.0), Waypoint(4, 3, 1, 0.0), Waypoint(8, 3, -1, 0.0)),
        )
    )
    recording, _ = drive(bent)
    assert recording.events[-1].time_s == 4.0
    assert recording.events[-1].configuration == (3.0, 1.0, 0.0)


def test_a_body_that_touches_a_wall_collides(drive, straight):
    # At 0.25 m from the wall the disc touches it, a micrometre farther away it does not.
    for y, outcome in ((0.25, "stalled"), (0.250001, "complete")):
        recording, _ = drive(straight(1, 1, 1, y), Done(complete=True, reason=""))
        assert recording.footer.outcome == outcome


def test_turns_are_checked(drive):
    # Half a metre from the wall above, a box whose corners reach 0.36 m turns; at 0.3 m it hits.
    turn = 0.5 * math.pi
    for gap, outcome in ((0.37, "complete"), (0.3, "stalled")):
        at = 6.0 - gap
        robot = RobotSpec(start=(2.0, at), footprint="box:0.6x0.4")
        spin = Move(trajectory=Trajectory((Waypoint(0, 2, at, 0.0), Waypoint(1, 2, at, turn))))
        recording, _ = drive(spin, Done(complete=True, reason=""), robot=robot)
        assert recording.footer.outcome == outcome


def test_turning_while_driving_is_checked(drive):
    # Along the wall, 0.25 m from it: straight on it fits. On a half circle of 0.1 m radius that
    # leads away from the wall a corner comes as near to it as 0.2 cos a + (0.3 - 0.1) sin a,
    # which is 0.28 m at 45 degrees; a circle of 1 m is wide enough.
    robot = RobotSpec(start=(2.0, 5.75), footprint="box:0.6x0.4")
    for x, turn, outcome in (
        (2.2, 0.0, "complete"),
        (2.2, math.pi, "stalled"),
        (4.0, math.pi, "complete"),
    ):
        bend = Move(trajectory=Trajectory((Waypoint(0, 2, 5.75, 0.0), Waypoint(4, x, 5.75, turn))))
        recording, _ = drive(bend, Done(complete=True, reason=""), robot=robot)
        assert recording.footer.outcome == outcome


def test_the_stop_rule_ends_a_motion_where_the_robot_is(drive, hall, straight, events_of):
    # Two metres take four seconds; after three the robot has gone one metre and a half.
    recording, explorer = drive(
        straight(1, 1, 3, 1), Done(complete=True, reason=""), max_time_s=3.0
    )
    assert recording.footer.outcome == "out_of_time"
    assert recording.footer.time_s == 3.0
    assert "3 s" in recording.footer.reason
    assert events_of(recording, Motion)[-1].waypoints == (
        (0.0, 1.0, 1.0, 0.0),
        (3.0, 2.5, 1.0, 0.0),
    )
    assert explorer.told == []
    assert measure(recording, hall).total_distance_m == 1.5


@pytest.mark.parametrize("end", [0.6, 0.82, 0.85, 2.31, 2.4])
def test_the_stop_rule_ends_a_later_motion_exactly_at_its_time(drive, straight, events_of, end):
    # With 2.31 and 2.4, the time plus the remaining time is not exactly the end.
    recording, _ = drive(
        straight(1, 1, 1.1, 1, seconds=0.1),
        straight(1.1, 1, 3, 1, seconds=0.2),
        straight(3, 1, 5, 1, seconds=17.0),
        max_time_s=end,
    )
    assert recording.footer.time_s == end
    assert events_of(recording, Motion)[-1].waypoints[-1][0] <= end
    assert events_of(recording, Motion)[-1].waypoints[-1][0] == pytest.approx(end, rel=1e-12)
    assert recording.footer.outcome == "out_of_time"


def test_a_motion_that_ends_with_the_time_is_complete(drive, straight):
    recording, explorer = drive(
        straight(1, 1, 3, 1), Sense(), Done(complete=True, reason=""), max_time_s=4.0
    )
    assert recording.footer.outcome == "complete"
    assert explorer.told[0].configuration == (3.0, 1.0, 0.0)


def test_nothing_moves_when_the_time_is_over(drive, straight, events_of):
    recording, _ = drive(straight(1, 1, 3, 1), straight(3, 1, 5, 1), max_time_s=4.0)
    assert recording.footer.outcome == "out_of_time"
    assert recording.footer.time_s == 4.0
    assert events_of(recording, Motion)[-1].waypoints == ((4.0, 3.0, 1.0, 0.0),)


def test_a_wall_behind_the_end_of_time_is_not_hit(drive, straight):
    recording, _ = drive(straight(1, 1, 12, 1), max_time_s=4.0)
    assert recording.footer.outcome == "out_of_time"
