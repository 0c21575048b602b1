"""Paths through the known space where the roadmap has none: round bodies, and from tree to tree."""

import math

import pytest
import shapely

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.kinematics import Car
from multisrt.robots.explorer import Sighting
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.bypass import Bypass
from multisrt.robots.multi_srt.targets import NewPlace

RADIUS = 0.25
BERTH = 2 * RADIUS + 1.2 * 0.1


def seen_at(x: float, y: float) -> Sighting:
    """Robot 1, seen at a place."""
    footprint = Footprint.parse(f"disc:{RADIUS}")
    return Sighting(robot=1, configuration=Configuration(x, y, 0.0), footprint=footprint)


def stand(robot, x: float, y: float) -> None:
    """Robot 1 stands at a place and does not answer."""
    robot.obstacles.silent[1] = seen_at(x, y)


@pytest.fixture
def stand_at(box_node):
    """Let the robot come to a place, straight from where it was, and add a node."""

    def stand_at(robot, serial, place, box):
        before = robot.at.here
        robot.map.add(box_node(serial, place, box))
        robot.at.q_act, robot.at.here = Configuration(*place), NodeId(0, serial)
        robot.roadmap.extend()
        robot.roadmap.join(before, robot.at.here)

    return stand_at


@pytest.fixture
def corridor(robot_in):
    """Build a corridor along y = 0 with nodes at both ends, 4 m apart, and a body half way."""

    def corridor(width, body_y):
        low, high = -width / 2, width / 2
        ends = ((0.0, 0.0), (-1.0, low, 5.0, high)), ((4.0, 0.0), (-1.0, low, 5.0, high))
        robot = robot_in(*ends)
        stand(robot, 2.0, body_y)
        return robot

    return corridor


def at_end(node: NodeId) -> bool:
    return node == NodeId(0, 1)


@pytest.mark.parametrize("body_y", [0.0, 0.2, -0.2])
def test_a_robot_gets_round_a_body_step_by_step(corridor, stand_at, body_y):
    width = 2.2
    robot = corridor(width, body_y)
    known = shapely.box(-1, -width / 2, 5, width / 2)
    body = shapely.Point(2.0, body_y)
    assert robot.routes.route(robot.at.here, NodeId(0, 1)) is None
    serial = 2
    while robot.routes.route(robot.at.here, NodeId(0, 1)) is None:
        target = robot.bypass.to(at_end)
        assert isinstance(target, NewPlace)
        assert target.stage == "bypass"
        start = robot.map[target.route[-1]].configuration
        line = shapely.LineString([start[:2], (target.x, target.y)])
        assert line.distance(body) >= BERTH
        assert known.buffer(-RADIUS).covers(line)
        stand_at(robot, serial, (target.x, target.y), known.bounds)
        serial += 1
        assert serial < 6


def test_a_track_is_followed_without_searching_again(corridor, stand_at, monkeypatch):
    robot = corridor(2.2, -0.1)
    searches: list[object] = []
    search = Bypass._search

    def counted(*arguments):
        searches.append(arguments)
        return search(*arguments)

    monkeypatch.setattr(Bypass, "_search", counted)
    serial = 2
    while robot.routes.route(robot.at.here, NodeId(0, 1)) is None:
        target = robot.bypass.to(at_end)
        # A robot that has to wait, and asks again, is told the same.
        assert robot.bypass.to(at_end) == target
        stand_at(robot, serial, (target.x, target.y), (-1.0, -1.1, 5.0, 1.1))
        serial += 1
    assert serial > 3
    assert len(searches) == 1


def test_a_track_is_forgotten_where_a_body_stands_on_it(corridor):
    robot = corridor(2.2, -0.2)
    target = robot.bypass.to(at_end)
    stand(robot, target.x, target.y)
    other = robot.bypass.to(at_end)
    assert other is None or math.dist((other.x, other.y), (target.x, target.y)) > BERTH - 0.01


def test_a_track_is_forgotten_when_another_goal_is_wanted(corridor):
    robot = corridor(2.2, -0.2)
    assert robot.bypass.to(at_end) is not None
    assert robot.bypass.to(lambda node: False) is None
    assert robot.bypass.to_place(0.5, 0.5, NodeId(0, 1)).aim == NodeId(0, 1)


def test_there_is_no_path_where_there_is_no_room(corridor):
    # On either side it takes the body's berth and the own radius.
    room = BERTH + RADIUS
    assert corridor(2 * room - 0.02, 0.0).bypass.to(at_end) is None
    assert corridor(2 * room + 0.2, 0.0).bypass.to(at_end) is not None
    # With the body at one wall there is room at the other.
    assert corridor(2 * room - 0.02, 0.3).bypass.to(at_end) is not None


def test_a_place_behind_a_body_is_reached(corridor):
    robot = corridor(2.4, 0.0)
    target = robot.bypass.to_place(3.5, 0.1, NodeId(0, 1))
    assert target is not None
    assert target.stage == "bypass"
    del robot.obstacles.silent[1]
    target = robot.bypass.to_place(3.5, 0.1, NodeId(0, 1))
    assert (target.x, target.y, target.stage) == (3.5, 0.1, "complete")


def test_trees_are_joined_round_a_corner(robot_in, stand_at):
    # Two corridors that meet in a corner, each seen from its far end: no straight way joins them.
    known = shapely.box(-1, -0.5, 4, 0.5).union(shapely.box(3, -0.5, 4, 6))
    robot = robot_in(((0.0, 0.0), (-1.0, -0.5, 4.0, 0.5)), ((3.5, 5.5), (3.0, -0.5, 4.0, 6.0)))
    assert robot.routes.route(robot.at.here, NodeId(0, 1)) is None
    start, (x, y) = robot.bypass.first_leg(at_end)
    assert start == robot.at.here
    assert known.buffer(-RADIUS).covers(shapely.LineString([(0, 0), (x, y)]))
    for serial in range(2, 6):
        target = robot.bypass.to(at_end)
        if not isinstance(target, NewPlace):
            break
        stand_at(robot, serial, (target.x, target.y), (-1.0, -0.5, 4.0, 0.5))
    # Now the roadmap leads there, and there is nothing to look for off it.
    assert robot.routes.route(robot.at.here, NodeId(0, 1))[-1] == NodeId(0, 1)
    assert robot.bypass.to(at_end) is None


def test_a_car_and_a_robot_without_a_node_have_no_bypass(corridor, robot_in):
    robot = corridor(2.4, 0.0)
    robot.at.here = None
    assert robot.bypass.first_leg(at_end) is None
    ends = ((0.0, 0.0), (-1.0, -2, 5.0, 2)), ((4.0, 0.0), (-1.0, -2, 5.0, 2))
    car = robot_in(*ends, kinematics=Car(turning_radius_m=0.5))
    stand(car, 2.0, 0.0)
    assert car.bypass.first_leg(at_end) is None
