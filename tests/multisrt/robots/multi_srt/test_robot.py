"""One robot: which bodies it plans around, and what ends its work."""

import msgspec
import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.robots.explorer import Sense, Sighting
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.build_srt import until_boxed_in
from multisrt.robots.multi_srt.progress import BoxedIn
from multisrt.robots.multi_srt.targets import KnownNode

HALL = (-1.0, -1.0, 5.0, 1.0)


def seen_at(x: float, y: float) -> Sighting:
    """Robot 1, seen at a place."""
    there = Configuration(x, y, 0.0)
    return Sighting(robot=1, configuration=there, footprint=Footprint.disc(0.25))


@pytest.fixture
def robot(robot_in):
    """A robot at the first of two nodes in a hall, 4 m apart."""
    return robot_in(((0.0, 0.0), HALL), ((4.0, 0.0), HALL))


@pytest.mark.parametrize(
    ("seen", "stands"),
    [
        ((seen_at(2.0, 0.0),), True),
        ((seen_at(2.0, 0.5),), False),
        ((), False),
    ],
    ids=["there", "elsewhere", "gone"],
)
def test_a_robot_is_avoided_only_while_it_stands(robot_in, robot_state, seen, stands):
    robot = robot_in(((0.0, 0.0), (-1.0, -1.0, 5.0, 1.0)), ((4.0, 0.0), (-1.0, -1.0, 5.0, 1.0)))
    robot.team.roster.states[1] = robot_state(1, [(2.0, 0.0)], phase="idle")
    robot.obstacles.avoided[1] = seen_at(2.0, 0.0)
    robot.notice(seen)
    assert (1 in robot.obstacles.avoided) == stands
    assert robot.routes.goes_straight(4.0, 0.0) == (not stands)


def test_a_body_out_of_view_is_believed_to_stand(robot_in):
    robot = robot_in(((0.0, 0.0), (-1.0, -1.0, 1.0, 1.0)))
    robot.obstacles.avoided[1] = robot.obstacles.silent[2] = seen_at(2.0, 0.0)
    robot.notice(())
    assert robot.obstacles.avoided
    assert robot.obstacles.silent


def test_a_protective_stop_says_nothing_of_other_bodies(robot):
    robot.obstacles.silent[1] = seen_at(2.0, 0.0)
    robot.team.roster.lost[2] = None
    robot.heed(msgspec.structs.replace(seen_at(1.0, 0.0), robot=2))
    assert sorted(robot.obstacles.silent) == [1, 2]


def test_a_robot_that_says_it_moves_is_not_avoided(robot, robot_in):
    other = robot_in(((0.0, 0.0), HALL))
    other.team.number = 1
    for phase, stands in (("idle", True), ("moving", False)):
        robot.obstacles.avoided[1] = seen_at(2.0, 0.0)
        other.team.status.phase = phase
        robot.team.roster.take(other.team.state(), sender=1)
        assert (1 in robot.obstacles.avoided) == stands


def test_a_boxed_in_robot_gives_up_its_target_alone(robot):
    robot.journey.target = KnownNode((NodeId(0, 0), NodeId(0, 1)))

    def steps():
        yield Sense()
        raise BoxedIn

    assert [*until_boxed_in(robot, steps())] == [Sense()]
    assert robot.journey.target is None


def test_a_candidate_behind_a_body_is_refused(robot):
    assert robot.refuse(4.0, 0.0) is None
    robot.obstacles.silent[1] = seen_at(2.0, 0.0)
    assert robot.refuse(4.0, 0.0) == "blocked by a robot"
    assert robot.refuse(0.5, 0.5) is None


def test_jammed_robots_avoid_those_of_their_group_that_stand(robot, robot_state):
    states = robot.team.roster.states
    states[1] = robot_state(1, [(2.0, 0.0)], phase="idle")
    states[2] = robot_state(2, [(3.0, 0.0)], phase="waiting")
    robot.team.status.key = ((0, 0), (1, 0), (2, 0))
    robot.avoid_idle_robots()
    assert robot.obstacles.avoided == {1: seen_at(2.0, 0.0)}
