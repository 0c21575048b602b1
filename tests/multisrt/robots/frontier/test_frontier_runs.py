"""Frontier bidding as a whole: runs end well, and options do what they say."""

import dataclasses
import math
from collections import Counter
from typing import get_args

import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import (
    Collision,
    DiagramEnd,
    DiagramLeft,
    Ended,
    GoalChosen,
    MapComplete,
    Motion,
    NodeAdded,
    Sensed,
    Sent,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots import registry
from multisrt.robots.explorer import Done, Receive, Received, Send
from multisrt.robots.frontier.messages import (
    GiveWayMessage,
    ReportMessage,
    StopMessage,
)
from multisrt.robots.registry import strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import CatalogEnvironment, DriveSpec, RadioSpec, RobotSpec, RunSpec, StopRule

FAMILY = ["closest", "greedy", "minpos", "utility", "self-bidding", "rules"]

WALL = shapely.union_all([shapely.box(5, 0, 5.2, 1.5), shapely.box(5, 2.7, 5.2, 5)])
TWO_ROOMS = Environment(
    "two rooms",
    shapely.box(0, 0, 10, 5).difference(WALL),
    starts=[(1, 1), (1, 2.5), (1, 4)],
)
PILLARS = shapely.union_all(
    [shapely.box(x, y, x + 1, y + 1) for x, y in ((6, 3), (13, 8), (18, 4))]
)
PLAZA = Environment("plaza", shapely.box(0, 0, 26, 14).difference(PILLARS))


def simulated(name, robots=1, *, world=TWO_ROOMS, options=None, robot=None, **spec):
    return simulate(
        RunSpec(
            environment=inline(world),
            strategy=name,
            options=options or {},
            robots=(robot or RobotSpec(),) * robots,
            stop=StopRule(max_time_s=600.0),
            **spec,
        ),
        world,
    )


def events(recording, kind, robot=None):
    return [e for e in recording.events if isinstance(e, kind) and robot in (None, e.robot)]


@pytest.mark.parametrize("robots", [1, 3])
@pytest.mark.parametrize("name", FAMILY)
def test_a_team_completes_two_rooms(name, robots):
    run = simulated(name, robots, seed=3)
    assert run.footer.outcome == "complete"
    assert measure(run, TWO_ROOMS).coverage > 0.98
    assert not events(run, Collision)
    assert sorted(e.robot for e in events(run, MapComplete)) == [*range(robots)]
    assert simulated(name, robots, seed=3).footer == run.footer


@pytest.mark.parametrize("name", ["closest", "greedy", "minpos"])
def test_robots_without_radio_explore_independently(name):
    run = simulated(name, 2, radio=RadioSpec(range_m=0.0), seed=1)
    assert run.footer.outcome == "complete"
    for robot in range(2):
        regions = [shapely.Polygon(e.boundary) for e in events(run, NodeAdded, robot)]
        assert shapely.union_all(regions).area > 0.98 * TWO_ROOMS.free.area


@pytest.mark.parametrize("name", FAMILY)
def test_every_choice_of_a_goal_has_its_reason_on_record(name):
    run = simulated(name, 2, seed=5)
    for robot in range(2):
        chosen = events(run, GoalChosen, robot)
        assert chosen[0].because == "start"
        assert all(e.because != "start" for e in chosen[1:])
        assert chosen[0].time_s <= events(run, Motion, robot)[0].time_s
        assert {e.rule for e in chosen} <= {name, "random", "closest"}
        # A robot that is done has looked for a goal and found none.
        assert chosen[-1].goal is None


class Stopper:
    """Tells the other robot to stop once it has said where it goes."""

    def run(self):
        while True:
            outcome = yield Receive(None)
            assert isinstance(outcome, Received)
            for message in outcome.messages:
                goal = message.reports[0].goal if isinstance(message, ReportMessage) else None
                if goal is not None:
                    yield Receive(0.3)
                    yield Send(StopMessage(sender=1, goal=goal), 0)
                    yield Done(complete=True, reason="enough")
                    return


def test_a_robot_that_is_told_to_stop_chooses_again(monkeypatch):
    own = strategy("self-bidding")

    def explorer(me, options):
        return own.explorer(me, options) if me.robot == 0 else Stopper()

    monkeypatch.setitem(registry._registry(), own.name, dataclasses.replace(own, explorer=explorer))
    run = simulated("self-bidding", 2, seed=1)
    stopped = [e for e in events(run, GoalChosen, 0) if e.because == "stop signal"]
    assert len(stopped) == 1
    assert run.footer.outcome == "complete"


class Nagger:
    """Stands in a corridor and insists that the other robot gives way, for a long time."""

    LONG_S = 400.0

    def run(self):
        nag = GiveWayMessage(sender=1, path=((4.0, 0.35), (0.5, 0.35)), radius_m=0.25, firm=True)
        now_s = 0.0
        while now_s < self.LONG_S:
            yield Send(nag, 0)
            again_s = now_s + 1.0
            while now_s < again_s:
                now_s = (yield Receive(again_s - now_s)).time_s
        yield Done(complete=True, reason="enough")


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_a_jammed_robot_is_done_in_the_end(name, monkeypatch):
    own = strategy(name)

    def explorer(me, options):
        return own.explorer(me, options) if me.robot == 0 else Nagger()

    monkeypatch.setitem(registry._registry(), own.name, dataclasses.replace(own, explorer=explorer))
    corridor = Environment("corridor", shapely.box(0, 0, 12, 0.7), starts=[(1, 0.35), (4, 0.35)])
    robots = tuple(RobotSpec(start=start) for start in corridor.starts)
    run = simulate(RunSpec(environment=inline(corridor), strategy=name, robots=robots), corridor)
    boxed_in = [e for e in events(run, Ended, 0) if e.time_s < Nagger.LONG_S]
    assert [(e.complete, e.reason) for e in boxed_in] == [
        (False, "boxed in by robot 1, which does not give way")
    ]
    assert not events(run, MapComplete)
    assert run.footer.outcome == "stalled"


def ends_of(run, chosen):
    """Where the robot was when it chose, for every choice."""
    for event in chosen:
        before = [m for m in events(run, Motion, event.robot) if m.time_s < event.time_s]
        yield before[-1].waypoints[-1][1:3] if before else run.starts[event.robot][:2]


@pytest.mark.parametrize("name", FAMILY)
def test_scans_at_targets_only_make_nodes_at_targets_only(name):
    run = simulated(name, options={"sense": "targets", "reached": "cell"}, seed=2)
    assert run.footer.outcome == "complete"
    assert measure(run, TWO_ROOMS).coverage > 0.98
    goals = [e.goal for e in events(run, GoalChosen) if e.goal is not None]
    root, *nodes = events(run, NodeAdded)
    assert root.stage == "root"
    assert nodes
    # It also looks where it would give a goal up, and chooses anew there. By its rules a robot goes
    # to where its goal is seen from, which is not on record.
    barred = [e.time_s for e in events(run, GoalChosen) if e.because == "no way"]
    for node in nodes if name != "rules" else ():
        at_goal = min(math.dist(node.configuration[:2], goal) for goal in goals) < 0.02
        assert at_goal or node.time_s in barred
    assert len(nodes) <= len(goals)
    moving = simulated(name, options={"reached": "cell"}, seed=2)
    assert len(events(moving, NodeAdded)) > len(nodes) + 1


@pytest.mark.parametrize("reached", ["cell", "sight"])
def test_a_goal_is_reached_at_its_cell_or_in_sight(reached):
    # Without scans on the way only arrival ends a drive.
    run = simulated(
        "closest", options={"sense": "targets", "reached": reached, "replan": "target"}, seed=2
    )
    assert run.footer.outcome == "complete"
    chosen = events(run, GoalChosen)
    gaps = [
        math.dist(place, before.goal)
        for before, event, place in zip(
            chosen[:-1], chosen[1:], [*ends_of(run, chosen[1:])], strict=True
        )
        if event.because == "reached"
    ]
    assert gaps
    if reached == "cell":
        assert max(gaps) < 0.02
    else:
        assert max(gaps) > 0.5
        assert max(gaps) <= 2.0 + 1e-9


@pytest.mark.parametrize(("replan", "chosen_anew"), [("news", True), ("target", False)])
def test_goals_are_chosen_anew_on_news_only_with_that_option(replan, chosen_anew):
    run = simulated("minpos", 3, options={"replan": replan}, seed=1)
    assert any(e.because == "news" for e in events(run, GoalChosen)) is chosen_anew


@pytest.mark.parametrize("name", ["closest", "minpos", "utility", "self-bidding"])
def test_with_arrival_goals_are_chosen_at_goals(name):
    options = {"replan": "arrival", "reached": "sight", "drive": "path"}
    early, late = (
        simulated(name, 2, options=options | {"replan": replan}, seed=1)
        for replan in ("target", "arrival")
    )
    for run in (early, late):
        assert run.footer.outcome == "complete"
        assert measure(run, TWO_ROOMS).coverage > 0.98
    before, reasons = ([e.because for e in events(run, GoalChosen)] for run in (early, late))
    # A goal in what turned out to be a wall cannot be reached: the drive ends before it.
    assert reasons.count("nothing left") < before.count("nothing left") / 3
    assert reasons.count("reached") > reasons.count("nothing left")
    assert ("stop signal" in reasons) <= (name == "self-bidding")


def test_a_robot_with_a_goal_keeps_it_when_another_asks_the_leader():
    run = simulated("utility", 3, seed=1)
    assert run.footer.outcome == "complete"
    assert not any(e.because == "assigned" for e in events(run, GoalChosen))
    assert measure(run, TWO_ROOMS).messages_by_kind["assignment"] > 3
    # The leader answers at the very moment.
    asked = [e for e in events(run, Sent) if e.kind == "assignment"]
    chosen = {(e.robot, e.time_s) for e in events(run, GoalChosen) if e.robot != 0}
    assert all(any((robot, e.time_s) in chosen for robot in e.reached) for e in asked)


@pytest.mark.parametrize("name", FAMILY)
def test_cells_wider_than_the_body_are_refused(name):
    options = {"cell_m": 0.51, "search_cell_m": 1.0} if name == "rules" else {"cell_m": 0.51}
    with pytest.raises(InvalidInputError, match=r"cell_m is 0\.51.*choose at most 0\.5$") as caught:
        simulated(name, options=options)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_body_that_is_no_disc_keeps_room_to_turn():
    # Through some gaps among the stones its narrow side would fit, but it could not turn there.
    spec = RunSpec(
        environment=CatalogEnvironment(name="clutter"),
        strategy="utility",
        robots=(RobotSpec(footprint="box:0.6x0.4"),),
        seed=877,
    )
    recording = simulate(spec)
    assert recording.footer.outcome == "complete"
    assert measure(recording, environment("clutter")).coverage > 0.99


def test_holonomic_bodies_are_not_refused():
    run = simulated("self-bidding", 2, robot=RobotSpec(drive=DriveSpec(kind="holonomic")))
    assert run.footer.outcome == "complete"


@pytest.mark.parametrize("name", ["utility", "self-bidding", "rules"])
def test_robots_that_decide_together_need_a_radio(name):
    with pytest.raises(InvalidInputError, match="the radio range is 0"):
        simulated(name, 2, radio=RadioSpec(range_m=0.0))


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("closest", {"cel_m": 0.1}, "closest has no option 'cel_m'"),
        ("minpos", {"beta": 1.0}, "minpos has no option 'beta'"),
        ("utility", {"beta": -1.0}, "beta is -1.0; it must be 0 or more"),
        ("self-bidding", {"phi_step": 0.0}, "phi_step is 0.0; it must be positive"),
        ("greedy", {"sense": "never"}, "sense='never' of greedy"),
        ("rules", {"patience": 0}, "patience is 0; it must be at least 1"),
    ],
)
def test_invalid_options_are_refused(name, options, message):
    with pytest.raises(InvalidInputError, match=message):
        simulated(name, options=options)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["closest", "greedy", "minpos", "utility"])
def test_all_that_bid_can_drive_by_the_diagram(name):
    paths, diagram = (
        simulated(name, 2, world=PLAZA, options={"drive": drive}, seed=1)
        for drive in ("path", "nearness-diagram")
    )
    for recording in (paths, diagram):
        assert recording.footer.outcome == "complete"
        assert not events(recording, Collision)
    assert not events(paths, DiagramLeft)
    left = Counter(e.because for e in events(diagram, DiagramLeft))
    assert measure(diagram, PLAZA).diagram_left == dict(left)
    assert set(left) <= set(get_args(DiagramEnd))
    # It looks for every command, but maps what it sees at most once in a period of sensing.
    sensed = len(events(diagram, Sensed))
    assert len(events(diagram, NodeAdded)) < 0.7 * sensed
    assert sensed >= len(events(diagram, Motion))
    # It drives in arcs, and slows down near walls.
    assert diagram.footer.time_s > paths.footer.time_s
    assert len(events(diagram, Motion)) > len(events(paths, Motion))
