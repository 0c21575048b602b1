"""MOVE_TO driven by hand: what a step changes when it is made, ordered, stopped or not made."""

from dataclasses import replace

import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.robots.explorer import Move, Moved, Outcome, Receive, Sighting, TimedOut
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.move_to import move_to
from multisrt.robots.multi_srt.progress import Event
from multisrt.robots.multi_srt.targets import KnownNode, NewPlace

HALL = (-1.0, -1.0, 5.0, 1.0)
BODY = Sighting(robot=1, configuration=Configuration(2.0, 0.0, 0.0), footprint=Footprint.disc(0.25))


@pytest.fixture
def robot(robot_in):
    """A robot that had a setback, at the first of two nodes in a hall, 4 m apart."""
    robot = robot_in(((0.0, 0.0), HALL), ((4.0, 0.0), HALL))
    robot.roadmap.join(NodeId(0, 0), NodeId(0, 1))
    robot.progress.note(Event.SETBACK)
    return robot


@pytest.fixture
def hop(robot):
    """The step to the second node."""
    return robot.journey.step_to(KnownNode((NodeId(0, 0), NodeId(0, 1))))


def make(robot, step, stopped_at=None) -> None:
    """Make a step; a body stops it at a place, if one is given. No robot answers."""
    steps = move_to(robot, step)
    outcome: Outcome = None
    while True:
        try:
            action = steps.send(outcome)
        except StopIteration:
            return
        outcome = None
        if isinstance(action, Move):
            end = action.trajectory.end if stopped_at is None else stopped_at
            time_s = robot.at.time_s + (end != robot.at.q_act)
            blocked_by = None if stopped_at is None else BODY
            outcome = Moved(configuration=end, time_s=time_s, blocked_by=blocked_by)
        elif isinstance(action, Receive):
            assert action.timeout_s is not None
            outcome = TimedOut(robot.at.time_s + action.timeout_s)


@pytest.mark.parametrize("been", [False, True])
def test_a_place_not_been_at_in_this_task_is_progress(robot, hop, been):
    if been:
        here = robot.at.q_act
        robot.at.q_act = Configuration(4.0, 0.01, 0.0)
        robot.journey.note_here()
        robot.at.q_act = here
    make(robot, hop)
    assert (robot.at.here, robot.at.q_act[:2]) == (NodeId(0, 1), (4.0, 0.0))
    assert robot.progress.setbacks == been
    robot.journey.begin("home")
    assert robot.journey.is_at_new_place


def test_a_new_place_is_progress_and_has_no_node_yet(robot):
    target = NewPlace(1.0, 0.5, "draw", (NodeId(0, 0),))
    make(robot, robot.journey.step_to(target))
    assert (robot.at.here, robot.progress.setbacks) == (None, 0)
    assert robot.journey.came.stage == "draw"


def test_a_place_is_new_once_however_many_nodes_are_added_there(robot):
    start = robot.at.q_act, robot.at.here
    target = NewPlace(1.0, 0.5, "bypass", (NodeId(0, 0),))
    make(robot, robot.journey.step_to(target))
    robot.journey.note_here()
    robot.progress.note(Event.SETBACK)
    robot.at.q_act, robot.at.here = start
    make(robot, robot.journey.step_to(target))
    assert robot.progress.setbacks == 1


@pytest.mark.parametrize("order", ["new target", "give way"])
def test_a_step_by_order_is_no_progress(robot, hop, order):
    make(robot, replace(hop, order=order))
    assert (robot.at.here, robot.progress.setbacks) == (NodeId(0, 1), 1)
    # A robot that gave way has stood aside for a while.
    assert (robot.at.time_s > 1.5) == (order == "give way")


def test_a_stop_is_a_setback_at_a_new_place(robot, hop):
    robot.journey.target = KnownNode((NodeId(0, 0), NodeId(0, 1)))
    make(robot, hop, stopped_at=Configuration(1.0, 0.0, 0.0))
    assert (robot.at.here, robot.at.q_act[:2]) == (None, (1.0, 0.0))
    assert (robot.progress.setbacks, robot.journey.target) == (2, None)
    assert robot.journey.came.parent == NodeId(0, 0)


def test_a_stop_before_the_motion_began_has_the_body_avoided(robot, hop):
    make(robot, hop, stopped_at=robot.at.q_act)
    assert (robot.at.here, robot.progress.setbacks) == (NodeId(0, 0), 2)
    assert robot.obstacles.avoided == {1: BODY}


def test_without_a_step_the_robot_waits(robot):
    for waits in (1, 2):
        make(robot, None)
        assert (robot.team.status.waited, robot.team.status.step) == (waits, waits)
    assert robot.at.time_s > 0.0
    assert robot.at.here == NodeId(0, 0)
