"""The way of a robot to its target: steps, orders of a master, and detours."""

from dataclasses import replace

import pytest

from multisrt.geometry.configuration import Configuration
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.messages import Order
from multisrt.robots.multi_srt.targets import KnownNode, NewPlace

HALL = (-1.0, -1.0, 5.0, 1.0)


@pytest.fixture
def robot(robot_in):
    """A robot at the first of three nodes in a hall, which are 2 m apart."""
    robot = robot_in(*(((x, 0.0), HALL) for x in (0.0, 2.0, 4.0)))
    for a, b in ((0, 1), (1, 2)):
        robot.roadmap.join(NodeId(0, a), NodeId(0, b))
    return robot


def nodes(*serials: int) -> tuple[NodeId, ...]:
    return tuple(NodeId(0, serial) for serial in serials)


def test_nodes_at_the_very_place_count_as_reached(robot_in):
    box = (-1.0, -1.0, 5.0, 1.0)
    robot = robot_in(*(((x, 0.0), box) for x in (0.0, 0.0, 0.0, 4.0)))
    first, second, third, last = (NodeId(0, k) for k in range(4))
    assert robot.journey.past_here(KnownNode((first, last))) == KnownNode((first, last))
    assert robot.at.here == first
    assert robot.journey.past_here(KnownNode((first, second, third, last))) == KnownNode(
        (third, last)
    )
    assert robot.at.here == third
    place = NewPlace(1.0, 0.0, "complete", (third, first))
    assert robot.journey.past_here(place) == replace(place, route=(first,))
    assert robot.journey.past_here(KnownNode((first, second))) is None
    assert robot.at.here == second


def test_a_known_node_is_reached_hop_by_hop(robot):
    target = KnownNode(nodes(0, 1, 2))
    step = robot.journey.step_to(target)
    assert (step.node, step.motion.end[:2]) == (NodeId(0, 1), (2.0, 0.0))
    assert step.rest == KnownNode(nodes(1, 2))
    assert robot.journey.step_to(KnownNode(nodes(0, 1))).rest is None


def test_a_new_place_is_reached_from_the_last_node_of_its_path(robot):
    far = NewPlace(3.0, 0.5, "complete", nodes(0, 1))
    assert robot.journey.step_to(far).rest == replace(far, route=nodes(1))
    near = NewPlace(1.0, 0.5, "draw", nodes(0))
    step = robot.journey.step_to(near, frontier_m=2.5)
    assert (step.node, step.rest, step.parent, step.frontier_m) == (None, None, nodes(0)[0], 2.5)
    assert step.motion.end[:2] == pytest.approx((1.0, 0.5))
    assert robot.journey.place_of(near) == (1.0, 0.5)
    assert robot.journey.place_of(KnownNode(nodes(0, 1))) == (2.0, 0.0)
    assert robot.journey.place_of(None) is None


def test_orders_are_carried_out(robot):
    journey, path = robot.journey, ((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.5, 0.0))
    planned = journey.step_to(KnownNode(nodes(0, 1)))
    assert journey.step_by(Order(order="keep"), planned) is planned
    assert journey.step_by(Order(order="wait"), planned) is None
    journey.target = KnownNode(nodes(0, 1, 2))
    detour = journey.step_by(Order(order="new target", path=path), planned)
    assert (detour.node, detour.gives_way) == (None, False)
    assert detour.rest == KnownNode(nodes(1, 2))
    aside = journey.step_by(Order(order="give way", path=path), planned)
    assert (aside.node, aside.gives_way, aside.rest) == (None, True, None)
    hop = journey.step_by(Order(order="give way", path=path, node=NodeId(0, 1)), planned)
    assert (hop.node, hop.gives_way) == (NodeId(0, 1), True)


@pytest.mark.parametrize("waits_for", [nodes(1, 2), nodes(2)])
def test_after_a_detour_the_old_target_is_gone_on_to(robot, box_node, waits_for):
    robot.map.add(box_node(3, (1.0, 0.5), HALL))
    robot.at.q_act, robot.at.here = Configuration(1.0, 0.5, 0.0), NodeId(0, 3)
    robot.journey.target = KnownNode(waits_for)
    robot.journey.resume()
    assert robot.journey.target == KnownNode((NodeId(0, 3), *waits_for))


def test_after_a_detour_out_of_sight_the_target_is_dropped(robot, box_node):
    robot.map.add(box_node(3, (1.0, 9.0), (0.0, 8.0, 2.0, 10.0)))
    robot.at.q_act, robot.at.here = Configuration(1.0, 9.0, 0.0), NodeId(0, 3)
    robot.journey.target = KnownNode(nodes(1, 2))
    robot.journey.resume()
    assert robot.journey.target is None
