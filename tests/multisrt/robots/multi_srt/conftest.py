"""Builders that tests of Multi-SRT share."""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.planners.motion.kinematics import Differential
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.multi_srt.conflicts import Prospect
from multisrt.robots.multi_srt.messages import RobotState
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.robot import SrtRobot

RADIUS_M = 0.25
REACH_M = 8.0

Place = tuple[float, float]
Box = tuple[float, float, float, float]


def _robot_self(**more: Any) -> RobotSelf:
    given: dict[str, Any] = {
        "robot": 0,
        "start": Configuration(0.0, 0.0, 0.0),
        "footprint": Footprint.disc(RADIUS_M),
        "kinematics": Differential(),
        "range_m": 4.0,
        "rng": np.random.default_rng(0),
        "team": 3,
    }
    return RobotSelf(**given | more)


def _robot_state(
    robot: int = 1,
    path: Sequence[tuple[float, float]] = ((0.0, 0.0),),
    *,
    moving: bool = False,
    **more: Any,
) -> RobotState:
    given: dict[str, Any] = {
        "said": 1,
        "step": 0,
        "phase": "moving" if moving else "waiting",
        "key": (),
        "path": tuple((float(k), x, y, 0.0) for k, (x, y) in enumerate(path)),
        "arrival_s": 0.0,
        "node": None,
        "frontier_m": 0.0,
        "waited": 0,
        "tree": None,
        "footprint": f"disc:{RADIUS_M}",
        "kinematics": Differential(),
        "range_m": 4.0,
        "have": (),
    }
    return RobotState(robot=robot, **given | more)


def _box_node(serial: int, place: Place, box: Box) -> Node:
    x0, y0, x1, y1 = box
    region = LocalSafeRegion(
        x=place[0],
        y=place[1],
        range_m=REACH_M,
        boundary=np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], float),
        tags=np.full(4, OBSTACLE, np.int8),
    )
    return Node(
        id=NodeId(0, serial),
        configuration=Configuration(*place),
        region=region,
        parent=None,
        time_s=0.0,
    )


def _robot_in(*rooms: tuple[Place, Box], **more: Any) -> SrtRobot:
    me = _robot_self(start=Configuration(*rooms[0][0]), range_m=REACH_M, team=2, **more)
    robot = SrtRobot(me, "star", MultiSrtOptions())
    for number, (place, box) in enumerate(rooms):
        robot.map.add(_box_node(number, place, box))
    robot.roadmap.extend()
    robot.at.here = NodeId(0, 0)
    return robot


@pytest.fixture(scope="session")
def robot_self() -> Callable[..., RobotSelf]:
    """Build what a robot knows of itself: the first of three discs, at the origin."""
    return _robot_self


@pytest.fixture(scope="session")
def robot_state() -> Callable[..., RobotState]:
    """Build a state: a robot that goes along some places, one a second, or plans to."""
    return _robot_state


@pytest.fixture(scope="session")
def box_node() -> Callable[..., Node]:
    """Build a node of robot 0 by its serial number, its place and its region, a rectangle."""
    return _box_node


@pytest.fixture(scope="session")
def robot_in() -> Callable[..., SrtRobot]:
    """Build a robot at the first of some nodes, given by their places and rectangles."""
    return _robot_in


@pytest.fixture(scope="session")
def line() -> Callable[..., Trajectory]:
    """Build a motion along straight lines at 1 m/s, with one heading."""

    def build(*places: Place, heading: float = 0.0) -> Trajectory:
        time_s, (x, y) = 0.0, places[0]
        waypoints = [Waypoint(time_s, x, y, heading)]
        for a, b in itertools.pairwise(places):
            time_s += math.dist(a, b)
            waypoints.append(Waypoint(time_s, b[0], b[1], heading))
        return Trajectory(tuple(waypoints))

    return build


@pytest.fixture(scope="session")
def prospect(line) -> Callable[..., Prospect]:
    """Build what a robot, a disc unless a body is given, would do: go along straight lines."""

    def build(
        robot: int,
        *places: Place,
        frontier_m: float = 1.0,
        body: Footprint | None = None,
        heading: float = 0.0,
        waited: int = 0,
    ) -> Prospect:
        return Prospect(
            robot=robot,
            footprint=body or Footprint.disc(RADIUS_M),
            motion=line(*places, heading=heading),
            frontier_m=frontier_m,
            waited=waited,
        )

    return build
