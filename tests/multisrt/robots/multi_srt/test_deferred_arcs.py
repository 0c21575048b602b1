"""Arcs that a robot leaves for later, in a corridor with a body in it."""

import contextlib
import math

import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    ArcReopened,
    Collision,
    Decision,
    Ended,
    Event,
    MapComplete,
    NodeAdded,
)
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.srt import Draws
from multisrt.robots.explorer import Note, Receive, Send, Sighting, TimedOut
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.build_multi_srt import SrtExplorer
from multisrt.robots.multi_srt.messages import StateMessage
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.planner import Planner
from multisrt.robots.multi_srt.support import ask_those_in_the_way
from multisrt.robots.multi_srt.targets import NewPlace
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    LateStart,
    RobotSpec,
    RunSpec,
    StopRule,
)

OPEN_M = 1.0
"""Width of the corridor: too narrow to pass a body in it."""

NEAR, FAR = NodeId(0, 0), NodeId(0, 1)
HERE = np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (0.0, 1.0)])
"""What the robot sees from its place, (1.5, 0.5)."""


def seen_at(x: float, y: float) -> Sighting:
    there = Configuration(x, y, 0.0)
    return Sighting(robot=1, configuration=there, footprint=Footprint.disc(0.25))


BODY = seen_at(2.5, 0.5)


@pytest.fixture
def explorer(robot_self, rectangle_node):
    """Build a robot at the first of two nodes of a corridor that goes on beyond the second."""

    def build(overlap_m=1.5, **options):
        me = robot_self(start=Configuration(1.5, 0.5, 0.0), range_m=3.0, team=2)
        built = SrtExplorer(me, "star", MultiSrtOptions(approach=False, **options))
        robot = built.robot
        robot.map.add(rectangle_node(0, 0.0, 0.0, 3.0, 1.0, "right"))
        robot.map.add(rectangle_node(1, 3.0 - overlap_m, 0.0, 5.5, 1.0, "right"))
        robot.roadmap.extend()
        robot.at.here = NEAR
        return built

    return build


def events_in(steps) -> list[Event]:
    """The events that a procedure puts on record; it does nothing else."""
    actions = [*steps]
    assert all(isinstance(action, Note) for action in actions)
    return [action.event for action in actions]


def choose(robot):
    """Let the robot choose in the third stage; return the choice and what it put on record."""
    actions, frontier = [], robot.deferred.frontier(robot.at.node)
    steps = Planner(robot, completing=True)(frontier, Draws())
    try:
        while True:
            actions.append(next(steps))
    except StopIteration as stop:
        return stop.value, events_in(iter(actions))


def blocked_by(explorer, robot_state, *, answers: bool):
    """The robot before a body that stands in the corridor, after it has left the arc for later."""
    robot = explorer.robot
    if answers:
        robot.team.roster.take(robot_state(1, [(2.5, 0.5)], phase="idle"), sender=1)
        robot.obstacles.avoided[1] = BODY
    else:
        robot.obstacles.silent[1] = BODY
    (choice, target), events = choose(robot)
    assert (choice, target) == ("end", None)
    (closed,) = events
    assert isinstance(closed, ArcClosed)
    assert (closed.node, closed.reason) == (FAR, "blocked by a robot")
    robot.obstacles.avoided.clear()
    return robot


@pytest.mark.parametrize("overlap_m", [0.5, 1.5], ids=["off the roadmap", "on the roadmap"])
@pytest.mark.parametrize("answers", [True, False])
def test_a_body_in_the_way_leaves_the_map_open(explorer, robot_state, answers, overlap_m):
    built = explorer(overlap_m)
    robot = blocked_by(built, robot_state, answers=answers)
    assert robot.map.closings == ()
    assert robot.map.has_frontier(FAR)
    assert not robot.trees.may_extend(FAR)
    assert robot.deferred.open_m(NEAR) == 0.0
    assert robot.deferred.left() == (OPEN_M, [1])
    assert events_in(robot.trees.tell_when_complete()) == []
    done = built.done()
    assert done.frontier == ((5.5, 0.0, 5.5, 1.0),)
    assert not done.complete
    said = "which does not give way" if answers else "which does not answer"
    assert done.reason.startswith(f"robot 1, {said}, stands in the way to 1.0 m of frontier")


@pytest.mark.parametrize("answers", [True, False])
def test_an_arc_stays_deferred_while_the_body_stands(explorer, robot_state, answers):
    robot = blocked_by(explorer(), robot_state, answers=answers)
    robot.notice((BODY,))
    if answers:
        robot.team.roster.take(robot_state(1, [(2.5, 0.5)], said=2, phase="idle"), sender=1)
    assert not robot.deferred.is_due()
    assert events_in(robot.trees.reopen()) == []
    assert not robot.trees.may_extend(FAR)


def is_seen_elsewhere(robot, state):
    robot.notice((seen_at(0.3, 0.5),))


def is_not_where_it_stood(robot, state):
    robot.at.here = NEAR
    robot.notice(())


def tells_that_it_moves(robot, state):
    robot.team.roster.take(state(1, [(2.5, 0.5), (4.0, 0.5)], said=2, moving=True), sender=1)


def tells_that_it_stands_elsewhere(robot, state):
    robot.team.roster.take(state(1, [(4.0, 0.5)], said=2, phase="idle"), sender=1)


def answers_again(robot, state):
    robot.team.roster.take(state(1, [(2.5, 0.5)], said=2, phase="idle"), sender=1)


@pytest.mark.parametrize(
    ("answers", "leave"),
    [
        (True, is_seen_elsewhere),
        (True, is_not_where_it_stood),
        (True, tells_that_it_moves),
        (True, tells_that_it_stands_elsewhere),
        (False, is_seen_elsewhere),
        (False, is_not_where_it_stood),
        (False, answers_again),
    ],
)
def test_an_arc_opens_again_when_the_body_is_gone(explorer, robot_state, answers, leave):
    robot = blocked_by(explorer(), robot_state, answers=answers)
    leave(robot, robot_state)
    assert robot.deferred.is_due()
    (reopened,) = events_in(robot.trees.reopen())
    assert isinstance(reopened, ArcReopened)
    assert (reopened.node, reopened.arc) == (FAR, ((5.5, 0.0, 5.5, 1.0),))
    assert not robot.deferred.is_due()
    assert robot.trees.may_extend(FAR)
    assert robot.deferred.left() == (0.0, [])
    (choice, target), _ = choose(robot)
    assert choice == "complete"
    assert isinstance(target, NewPlace)
    assert target.aim == FAR


def test_a_body_left_out_of_groups_is_asked_again_later(explorer, robot_state):
    robot = explorer().robot
    robot.team.roster.left_out_until_s[1] = 30.0
    blocked_by_one = robot_state(1, [(2.5, 0.5)], phase="idle")
    robot.team.roster.take(blocked_by_one, sender=1)
    robot.deferred.defer(FAR, robot.map.frontier(FAR), {1: BODY})
    robot.at.time_s = 29.0
    assert not robot.deferred.is_due()
    robot.at.time_s = 30.0
    assert robot.deferred.is_due()


def test_a_body_that_does_not_bar_the_path_does_not_matter(explorer, robot_state):
    robot = explorer().robot
    robot.obstacles.silent[2] = Sighting(
        robot=2, configuration=Configuration(0.2, 9.0, 0.0), footprint=Footprint.disc(0.25)
    )
    robot = blocked_by(explorer(), robot_state, answers=False)
    robot.team.roster.take(robot_state(2, [(9.0, 9.0)], moving=True), sender=2)
    assert not robot.deferred.is_due()


def test_robots_that_give_way_by_turns_come_to_an_end(explorer, robot_state):
    built = explorer(max_reopenings=3)
    robot = blocked_by(built, robot_state, answers=False)
    for turn in range(10):
        robot.notice(())
        assert robot.deferred.is_due() == (turn < 3)
        assert len(events_in(robot.trees.reopen())) == (turn < 3)
        if turn < 3:
            robot.deferred.defer(FAR, robot.map.frontier(FAR), {1: BODY})
    # It does not try any more, but knows that there is more to see.
    assert not robot.trees.may_extend(FAR)
    assert events_in(robot.trees.tell_when_complete()) == []
    assert built.done().frontier


def test_what_is_seen_of_a_deferred_arc_is_deferred_no_more(explorer, robot_state, rectangle_node):
    robot = blocked_by(explorer(), robot_state, answers=False)
    robot.map.add(rectangle_node(2, 5.0, 0.0, 7.0, 0.4, ""))
    assert robot.deferred.arcs(FAR) == []
    length_m, robots = robot.deferred.left()
    assert length_m == pytest.approx(0.6)
    assert robots == [1]
    robot.map.add(rectangle_node(3, 5.0, 0.0, 7.0, 1.0, ""))
    assert robot.deferred.left() == (0.0, [])
    assert robot.map.is_complete()
    assert len(events_in(robot.trees.tell_when_complete())) == 1


def test_only_the_arc_that_is_barred_is_deferred(explorer, rectangle_node):
    robot = explorer().robot
    robot.map.add(rectangle_node(2, 0.0, 3.0, 2.0, 5.0, "right above"))
    first, second = robot.map.frontier_arcs(NodeId(0, 2))[0], robot.map.frontier(NodeId(0, 2))
    assert len(first) == len(second) == 2  # one arc round the corner
    robot.deferred.defer(NodeId(0, 2), second[:1], {1: BODY})
    assert np.array_equal(robot.deferred.frontier(NodeId(0, 2)), second[1:])
    assert [arc.tolist() for arc in robot.deferred.arcs(NodeId(0, 2))] == [second[1:].tolist()]
    assert robot.deferred.has_frontier(NodeId(0, 2))
    assert robot.deferred.open_m(NodeId(0, 2)) == pytest.approx(OPEN_M + 2.0)


def test_the_robot_in_the_way_is_asked_once_if_it_is_still_there(explorer, robot_state):
    robot = blocked_by(explorer(), robot_state, answers=True)
    asked_s, sent = 10.0, []
    robot.at.time_s = asked_s
    steps = ask_those_in_the_way(robot)
    answer = None
    with contextlib.suppress(StopIteration):
        while True:
            action = steps.send(answer)
            answer = None
            if isinstance(action, Send):
                assert isinstance(action.message, StateMessage)
                sent.append(action.message.asked)
            elif isinstance(action, Receive):
                robot.at.time_s += action.timeout_s
                answer = TimedOut(robot.at.time_s)
    assert sent == [(1,)] * (1 + robot.team.roster.patience)
    assert not robot.team.roster.answers(1)
    assert [*ask_those_in_the_way(robot)] == []


# Runs ------------------------------------------------------------------------------------------

CORRIDOR = Environment("corridor", shapely.box(0, 0, 14, 1.0))


def in_the_corridor(strategy: str, fault, max_time_s: float = 3000.0):
    """Two robots in a corridor in which they cannot pass each other."""
    spec = RunSpec(
        environment=inline(CORRIDOR),
        strategy=strategy,
        robots=(RobotSpec(start=(1.0, 0.5)), RobotSpec(start=(6.0, 0.5))),
        faults=(fault,),
        stop=StopRule(max_time_s=max_time_s),
        seed=1,
    )
    return simulate(spec, CORRIDOR)


@pytest.mark.parametrize("strategy", ["srt-star", "srt-radial"])
def test_a_robot_goes_on_when_the_one_in_its_way_leaves(events_of, strategy):
    late_s = 200.0
    recording = in_the_corridor(strategy, LateStart(robot=1, time_s=late_s))
    blocked = [e for e in events_of(recording, ArcClosed, 0) if e.reason == "blocked by a robot"]
    assert blocked
    assert all(event.time_s < late_s for event in blocked)
    first = events_of(recording, Ended, 0)[0]
    assert first.time_s < late_s
    assert first.frontier
    assert "robot 1, which does not answer, stands in the way" in first.reason
    assert len(events_of(recording, ArcReopened, 0)) == len(blocked)
    known = events_of(recording, MapComplete)
    assert known
    assert all(event.time_s > late_s for event in known)
    assert recording.footer.outcome == "complete"
    assert events_of(recording, Collision) == []
    assert measure(recording, CORRIDOR).coverage > 0.9
    assert all(event.frontier == () for event in events_of(recording, Ended, 1)[-1:])


@pytest.mark.parametrize("strategy", ["srt-star", "srt-radial"])
def test_a_dead_robot_in_the_only_way_leaves_the_map_open(events_of, strategy):
    recording = in_the_corridor(strategy, Death(robot=1, time_s=0.0))
    assert events_of(recording, MapComplete, 0) == []
    assert events_of(recording, ArcReopened) == []
    last = events_of(recording, Ended, 0)[-1]
    assert last.frontier
    assert "robot 1, which does not answer, stands in the way" in last.reason
    assert recording.footer.outcome == "stalled"
    assert recording.footer.time_s < 600.0


@pytest.mark.slow
def test_jammed_balls_in_the_garden_do_not_call_their_map_complete(events_of):
    # They stand in each other's way at first, with most of the garden behind their neighbours, and
    # must not call their map complete then.
    # Nodes a whole body apart, as there are hardly any places between them.
    spec = RunSpec(
        environment=CatalogEnvironment(name="garden"),
        strategy="srt-ball",
        options={"d_min_m": 0.5},
        robots=(RobotSpec(),) * 6,
        starts="clustered",
        seed=11,
        stop=StopRule(max_time_s=300.0),
    )
    recording = simulate(spec, environment("garden"))
    assert recording.footer.outcome == "out_of_time"
    blocked = [e for e in events_of(recording, ArcClosed) if e.reason == "blocked by a robot"]
    reopened = events_of(recording, ArcReopened)
    assert {(e.robot, e.node, e.arc) for e in reopened} <= {
        (e.robot, e.node, e.arc) for e in blocked
    }
    assert events_of(recording, MapComplete) == []
    later = [e for e in events_of(recording, NodeAdded) if e.time_s > 127.0]
    assert {e.robot for e in later} == set(range(6))
    assert len(later) > 200
    assert all(math.isfinite(e.frontier_m) for e in events_of(recording, Decision))
