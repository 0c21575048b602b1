"""What a team outside the simulation did, as a recording."""

import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.driving import Body, Driver, recording_of, scan_of_polygon
from multisrt.events import Motion
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.kinematics import Differential
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Done, Move, Moved, RobotSelf, Sense

ROOM = ms.Environment("room", shapely.box(0.0, 0.0, 6.0, 4.0))
CORNERS = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)]


class Crosses:
    def __init__(self, me, options):
        self.me = me

    def run(self):
        yield Sense()
        x, y, heading = self.me.start
        motion = Trajectory((Waypoint(0.0, x, y, heading), Waypoint(4.0, x + 2.0, y, heading)))
        yield Move(trajectory=motion)
        yield Done(complete=True, reason="has crossed the room")


def driver_of(robot: int, team: int) -> Driver:
    start = Configuration(1.0, 1.0 + robot, 0.0)
    me = RobotSelf(
        robot=robot,
        start=start,
        footprint=ms.Footprint.disc(0.2),
        kinematics=Differential(),
        range_m=9.0,
        rng=np.random.default_rng(0),
        team=team,
    )
    drifted = Configuration(3.0, start.y + 0.1, 0.05)
    return Driver(
        Crosses,
        me,
        Body(
            sense=lambda: scan_of_polygon(CORNERS, start, time_s=0.0, range_m=9.0),
            move=lambda move: Moved(configuration=drifted, time_s=5.0 + robot),
        ),
    )


@pytest.fixture
def team() -> list[Driver]:
    drivers = [driver_of(robot, 2) for robot in range(2)]
    for driver in drivers:
        assert not driver.poll()
    return drivers


def test_a_team_leaves_a_recording_that_is_measured_and_drawn(team, tmp_path):
    recording = recording_of(team, ROOM)
    assert (recording.footer.outcome, recording.footer.time_s) == ("complete", 6.0)
    motions = recording.of(Motion)
    assert [motion.waypoints[-1] for motion in motions] == [
        (5.0, 3.0, 1.1, 0.05),
        (6.0, 3.0, 2.1, 0.05),
    ]
    run = ms.Run(recording)
    assert run.metrics.coverage == pytest.approx(1.0)
    run.save_recording(tmp_path / "recording.jsonl")
    run.save_svg(tmp_path / "tree.svg")
    assert ms.Recording.load(tmp_path / "recording.jsonl").events == recording.events
    assert [robot.footprint for robot in recording.spec.robots] == ["disc:0.2"] * 2


def test_a_recording_of_robots_that_explore_is_not_complete():
    drivers = [driver_of(0, 1)]
    recording = recording_of(drivers, ROOM)
    assert recording.footer.outcome == "out_of_time"
    assert recording.footer.reason == "robot 0: explores"


def test_a_recording_is_of_a_whole_team(team):
    for numbers in ([1], [1, 0], []):
        with pytest.raises(InvalidInputError, match="give those of 0, 1"):
            recording_of([team[number] for number in numbers], ROOM)
