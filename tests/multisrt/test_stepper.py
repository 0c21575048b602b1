"""Stepping through runs from Python."""

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest

import multisrt as ms
from multisrt.events import Decision, GoalChosen, NodeAdded
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots import registry
from multisrt.robots.explorer import Done, Move, Note, Receive, Send, Sense
from multisrt.stepper import DECISIONS

SPEC = ms.RunSpec(
    environment=ms.CatalogEnvironment(name="apartment"),
    strategy="minpos",
    robots=(ms.RobotSpec(),) * 2,
    seed=1,
)


@pytest.fixture(scope="module")
def whole() -> ms.Run:
    return ms.explore(SPEC)


@pytest.mark.slow
def test_a_finished_stepper_is_the_run(whole):
    stepper = ms.Stepper("apartment", strategy="minpos", robots=2, seed=1)
    stepper.run_until(time_s=10.0)
    run = stepper.finish()
    assert run.digest == whole.digest
    assert stepper.is_over
    assert stepper.time_s == whole.recording.footer.time_s
    assert [step.robot for step in stepper.steps_of(1)] == [1] * len(stepper.steps_of(1))
    assert len(stepper.steps_of(0)) + len(stepper.steps_of(1)) == len(stepper.steps)
    assert repr(stepper).endswith(f"ended {stepper.time_s:.2f} s, {len(stepper.steps)} steps)")


def test_stepping_stops_where_all_conditions_are_met():
    stepper = ms.Stepper(SPEC)
    step: Any = stepper.run_until(time_s=3.0, robot=1, action=Move)
    assert step.time_s >= 3.0
    assert (step.robot, type(step.action)) == (1, Move)
    assert step is stepper.steps[-1]
    assert not any(
        s.time_s >= 3.0 and s.robot == 1 and isinstance(s.action, Move) for s in stepper.steps[:-1]
    )
    assert stepper.robots[1].motion is None  # before it is carried out
    chosen: Any = stepper.run_until(decision=True)
    assert isinstance(chosen.action.event, GoalChosen)
    sent: Any = stepper.run_until(where=lambda s: isinstance(s.action, Send) and s.robot == 0)
    assert (type(sent.action), sent.robot) == (Send, 0)
    again: Any = stepper.run_until()
    assert again is stepper.steps[-1]


def test_a_decision_can_be_of_one_class():
    stepper = ms.Stepper("apartment", seed=1)
    steps: list[Any] = list(stepper.until(decision=Decision))
    assert isinstance(steps[-1].action.event, Decision)
    assert stepper.steps == steps
    added: Any = stepper.run_until(decision=NodeAdded)
    assert isinstance(added.action.event, NodeAdded)


def test_what_tells_news_only_is_no_decision():
    assert Decision in DECISIONS
    assert GoalChosen in DECISIONS
    assert NodeAdded not in DECISIONS


def test_conditions_that_are_never_met_end_with_the_run():
    stepper = ms.Stepper("open", seed=1, max_time_s=4.0)
    assert stepper.run_until(time_s=100.0) is None
    assert stepper.is_over
    assert stepper.run_until() is None
    assert stepper.recording.footer.outcome == "out_of_time"


def test_an_unknown_condition_is_told_with_the_method():
    stepper = ms.Stepper("open", seed=1, max_time_s=4.0)
    with pytest.raises(InvalidInputError, match=r"run_until takes no argument 'robt' .*'robot'"):
        stepper.run_until(robt=1)


def test_the_explorer_and_its_code_are_at_hand(monkeypatch):
    class Idle:
        def __init__(self, me, options):
            self.count = 0

        def run(self):
            yield from self.wait(3)
            yield Done(complete=False, reason="enough")

        def wait(self, times):
            for k in range(times):
                self.count += 1
                yield Receive(float(k + 1))

    idle = ms.Strategy(
        name="idle", summary="", options=registry.strategy("closest").options, explorer=Idle
    )
    monkeypatch.setitem(registry._registry(), "idle", idle)
    stepper = ms.Stepper("open", strategy="idle", robots=1, seed=1)
    assert stepper.where(0) == ""
    stepper.run_until(time_s=1.0)
    explorer: Any = stepper.explorers[0]
    assert explorer.count == 2
    outer, inner = stepper.where(0).splitlines()
    here = Path.cwd()
    file = Path(__file__)
    shown = file.relative_to(here) if file.is_relative_to(here) else file
    assert outer.startswith(f"{shown}:")
    assert outer.endswith("in run")
    assert inner.endswith("in wait")
    assert stepper.variables(0)["k"] == 1
    run = stepper.finish()
    assert run.outcome == "stalled"
    assert stepper.where(0) == ""
    assert stepper.variables(0) == {}


def test_steps_are_told_in_a_line_each():
    stepper = ms.Stepper(SPEC)
    lines = [str(step) for step in stepper.until(time_s=2.0)]
    assert lines[0] == "0.00 s  robot 0  Sense"
    assert lines[1] == "0.00 s  robot 0  ExactScan -> Note(NodeAdded)"
    assert "0.00 s  robot 0  Send(report) to all" in lines
    assert any("-> Receive what has arrived" in line and "Moved to (" in line for line in lines)
    assert any(" Move to (" in line and line.endswith(" s") for line in lines)
    assert any("Received(report of 0" in line for line in lines)


def named(svg: str) -> set[str]:
    key = "{http://www.inkscape.org/namespaces/inkscape}label"
    return {group.get(key, "") for group in ET.fromstring(svg).iter()}


def test_the_present_state_is_drawn(tmp_path):
    stepper = ms.Stepper("apartment", robots=2, seed=1, faults=[ms.Death(robot=1, time_s=4.0)])
    stepper.run_until(time_s=6.0, robot=0, action=Sense)
    before = named(stepper.draw())
    assert {"robot 0: tree", "robot 0: body", "robot 1: body", "robot 1: death"} <= before
    assert "robot 0: path ahead" not in before
    stepper.save_svg(tmp_path / "state.svg")
    assert (tmp_path / "state.svg").read_text() == stepper._repr_svg_()
    assert f"at {stepper.time_s:,.1f} s" in stepper.draw()


def test_motions_under_way_are_drawn_with_their_ends():
    stepper = ms.Stepper(SPEC)
    stepper.run_until(where=lambda step: any(robot.motion for robot in stepper.robots))
    drawn = named(stepper.draw())
    moving = [robot.robot for robot in stepper.robots if robot.motion is not None]
    assert moving
    for robot in moving:
        assert {f"robot {robot}: path ahead", f"robot {robot}: end of the motion"} <= drawn
    ahead: Any = stepper.robots[moving[0]].ahead
    assert ahead.start == pytest.approx(stepper.robots[moving[0]].configuration)


def test_what_scans_show_is_drawn_where_no_node_is_recorded(monkeypatch):
    class Looks:
        def __init__(self, me, options):
            pass

        def run(self):
            yield Sense()
            yield Receive(1.0)
            yield Done(complete=False, reason="enough")

    looks = ms.Strategy(
        name="looks", summary="", options=registry.strategy("closest").options, explorer=Looks
    )
    monkeypatch.setitem(registry._registry(), "looks", looks)
    stepper = ms.Stepper("open", strategy="looks", robots=2, seed=1)
    assert "robot 0: scanned first" not in named(stepper.draw())
    stepper.run_until(time_s=1.0)
    assert {"robot 0: scanned first", "robot 1: scanned first"} <= named(stepper.draw())


def test_a_stepper_that_is_given_up_cannot_be_finished():
    with ms.Stepper(SPEC) as stepper:
        stepper.run_until(time_s=1.0)
    with pytest.raises(InvalidInputError, match=r"given up at 1 s.*make a new Stepper"):
        stepper.finish()
    assert stepper.recording.events


def test_robots_that_are_not_there_are_named():
    stepper = ms.Stepper(SPEC)
    for call in (
        stepper.steps_of,
        stepper.where,
        stepper.variables,
        lambda k: stepper.until(robot=k),
    ):
        with pytest.raises(InvalidInputError, match="no robot 2; robots are 0 to 1"):
            call(2)


def test_arguments_are_those_of_explore():
    with pytest.raises(InvalidInputError, match="leave out seed"):
        ms.Stepper(SPEC, seed=2)
    with pytest.raises(ms.InvalidInputError, match="no argument 'colour'"):
        ms.Stepper("open", colour="red")  # type: ignore[call-arg]
    noted: list[Any] = []
    stepper = ms.Stepper("open", seed=1, watch=noted.append)
    stepper.run_until(action=Note)
    assert noted == list(stepper.recording.events)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("decision", "x"), ("action", "Move"), ("time_s", "x"), ("where", 3), ("robot", "0")],
)
def test_wrong_conditions_are_refused_at_the_call(name, wrong):
    stepper = ms.Stepper("apartment", seed=1)
    with pytest.raises(ms.InvalidInputError, match=f"{name}|no robot 0"):
        stepper.until(**{name: wrong})
    assert stepper.steps == []
