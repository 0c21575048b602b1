"""Runs to animate: of trees, of frontier bidding, and one whose motions are given."""

import pytest
import shapely

import multisrt as ms
from multisrt.environments.environment import Environment
from multisrt.events import (
    AnyEvent,
    CameBack,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Joined,
    Motion,
    NodeAdded,
    Sensed,
)
from multisrt.geometry.configuration import Configuration
from multisrt.recording import Recorder, Recording, header_of
from multisrt.simulation.worlds import inline
from multisrt.spec import LateStart, RobotSpec, RunSpec

HALL = Environment("hall", shapely.box(0, 0, 20, 10))


@pytest.fixture(scope="session")
def trees() -> Recording:
    """Two robots that grow trees."""
    return ms.explore("apartment", robots=2, starts="clustered", seed=1, max_time_s=60.0).recording


@pytest.fixture(scope="session")
def bidding() -> Recording:
    """Two robots that bid for frontiers."""
    return ms.explore(
        "apartment", strategy="minpos", robots=2, starts="clustered", seed=1, max_time_s=30.0
    ).recording


def node(time_s: float, robot: int, serial: int, x: float, y: float) -> NodeAdded:
    corners = ((x - 2, y - 2), (x + 2, y - 2), (x + 2, y + 2), (x - 2, y + 2))
    return NodeAdded(
        time_s=time_s,
        robot=robot,
        serial=serial,
        parent=(robot, serial - 1) if serial else None,
        configuration=(x, y, 0.0),
        stage="draw" if serial else "root",
        boundary=corners,
        tags="1111",
    )


def moved(robot: int, *waypoints: tuple[float, float, float, float]) -> Motion:
    return Motion(time_s=waypoints[0][0], robot=robot, waypoints=waypoints)


@pytest.fixture(scope="session")
def told() -> Recording:
    """Three robots in a hall of 20 x 10 m, for 40 s.

    Robot 0 drives from (3, 3) to (13, 3) from 10 to 20 s and is done at 30 s. Robot 1, a box, is
    switched on at 12 s, turns by half a turn from 20 to 30 s, and is cut off from 32 to 36 s.
    Robot 2 dies at 16 s at (15, 7).
    """
    robots = (
        RobotSpec(start=(3.0, 3.0, 0.0)),
        RobotSpec(start=(4.0, 7.0, 0.0), footprint="box:0.8x0.4"),
        RobotSpec(start=(15.0, 7.0, 0.0)),
    )
    spec = RunSpec(
        environment=inline(HALL), robots=robots, faults=(LateStart(robot=1, time_s=12.0),)
    )
    starts = tuple(Configuration(*robot.start) for robot in robots)  # type: ignore[misc]
    events: list[AnyEvent] = [
        Sensed(time_s=0.0, robot=0, configuration=(3.0, 3.0, 0.0)),
        node(0.0, 0, 0, 3.0, 3.0),
        node(0.0, 2, 0, 15.0, 7.0),
        GoalChosen(time_s=8.0, robot=2, rule="x", because="start", goal=(16.0, 5.0)),
        Joined(time_s=12.0, robot=1),
        node(12.0, 1, 0, 4.0, 7.0),
        Died(time_s=16.0, robot=2, configuration=(15.0, 7.0, 0.0), doing="waiting"),
        moved(0, (10.0, 3.0, 3.0, 0.0), (20.0, 13.0, 3.0, 0.0)),
        node(20.0, 0, 1, 13.0, 3.0),
        moved(1, (20.0, 4.0, 7.0, 0.0), (30.0, 4.0, 7.0, 3.0)),
        Ended(time_s=30.0, robot=0, reason="done", complete=True, frontier=()),
        FellSilent(time_s=32.0, robot=1),
        CameBack(time_s=36.0, robot=1),
    ]
    recorder = Recorder(header_of(spec, HALL, starts))
    for event in events:
        recorder.record(event)
    return recorder.finish(40.0, "complete", "")
