"""Runs in steps: the same runs to the byte, to be looked at and acted on between actions."""

import json
import weakref
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.environments.environment import Environment
from multisrt.events import MapComplete, Motion
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.scan import ExactScan
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.recording import Recording
from multisrt.robots import registry
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.explorer import Done, Move, Note, Receive, Send, Sense
from multisrt.robots.strategy import Strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.stepping import Step, Stepping
from multisrt.simulation.worlds import inline
from multisrt.spec import CatalogEnvironment, Death, RadioSpec, RobotSpec, RunSpec, StopRule

GOLDEN = Path(__file__).parents[2] / "golden"
END = Done(complete=True, reason="enough")

STEPPED = [
    "srt-radial team",
    "srt-radial bad radio, death, silence",
    "srt-radial late start, master dies",
    "srt-radial sensing on the way",
    "srt-star laser, holonomic",
    "closest together, no radio",
    "minpos laser, faults",
    "utility bad radio, leader dies",
    "rules crowd",
]


class NoOptions(msgspec.Struct, frozen=True, kw_only=True):
    pass


def drive(x0: float, y0: float, x1: float, seconds: float) -> Move:
    return Move(trajectory=Trajectory((Waypoint(0.0, x0, y0, 0.0), Waypoint(seconds, x1, y0, 0.0))))


@pytest.fixture
def stepping(monkeypatch, hall):
    """Return a function that steps through a run of robots that are given as generators."""

    def make(*scripts, world: Environment = hall, max_time_s: float = 100.0, **more) -> Stepping:
        class Actor:
            def __init__(self, me, options):
                self.me = me
                self.decision = None

            def run(self):
                return scripts[self.me.robot](self)

        strategy = Strategy(name="script", summary="", options=NoOptions, explorer=Actor)
        monkeypatch.setitem(registry._registry(), "script", strategy)
        spec = RunSpec(
            environment=inline(world),
            strategy="script",
            robots=tuple(RobotSpec(start=(1.0, 1.0 + 2.0 * k)) for k in range(len(scripts))),
            stop=StopRule(max_time_s=max_time_s),
            **more,
        )
        return Stepping(spec, world)

    return make


@pytest.fixture(scope="module")
def golden_runs(load_module):
    return load_module(GOLDEN / "golden_runs.py").RUNS


@pytest.mark.slow
@pytest.mark.parametrize("name", STEPPED)
def test_a_run_in_steps_is_the_same_to_the_byte(golden_runs, name):
    run = Stepping(golden_runs[name])
    for step in run:
        assert step.time_s == run.time_s
    digests = json.loads((GOLDEN / "digests.json").read_text())
    assert run.recording.footer.digest == digests[name]["recording"]
    assert run.recording.footer.outcome == digests[name]["outcome"]


SMALL = RunSpec(
    environment=CatalogEnvironment(name="open", parameters={"size_m": 10.0, "columns": 2}),
    strategy="srt-star",
    robots=(RobotSpec(),) * 2,
    radio=RadioSpec(latency_s=0.5, jitter_s=0.2, loss=0.1),
    faults=(Death(robot=1, time_s=9.0, when="moving"),),
    seed=1,
)


@pytest.fixture(scope="module")
def whole() -> Recording:
    return simulate(SMALL)


@settings(max_examples=15, deadline=None)
@given(steps=st.integers(0, 400))
def test_whatever_is_read_after_any_step_changes_nothing(whole, steps):
    run = Stepping(SMALL)
    for _, _step in zip(range(steps), run, strict=False):
        pass
    before = run.recording
    assert before.events[:1] == whole.events[:1] or not before.events
    assert [robot.robot for robot in run.robots] == [0, 1]
    assert run.messages_in_flight >= 0
    for _step in run:
        pass
    assert run.recording.footer == whole.footer
    assert run.recording.events == whole.events


def test_a_step_comes_before_its_action_is_carried_out(stepping):
    def acts(me):
        yield Sense()
        yield drive(1.0, 1.0, 3.0, 4.0)
        yield END

    run = stepping(acts)
    first = next(run)
    assert first == Step(robot=0, time_s=0.0, outcome=None, action=Sense())
    assert run.recording.events == ()
    second = next(run)
    assert isinstance(second.outcome, ExactScan)
    assert isinstance(second.action, Move)
    assert run.robots[0].motion is None
    third = next(run)
    assert (third.time_s, third.action) == (4.0, END)
    assert third.outcome.configuration == Configuration(3.0, 1.0, 0.0)
    assert not run.is_over
    with pytest.raises(StopIteration):
        next(run)
    assert run.is_over
    assert run.recording.footer.outcome == "complete"
    assert list(run) == []


def test_an_explorer_can_be_handed_a_decision_while_paused(stepping):
    def acts(me):
        yield Note(MapComplete(time_s=0.0, robot=0))
        yield me.decision
        yield END

    run = stepping(acts)
    for step in run:
        if isinstance(step.action, Note):
            run.explorers[0].decision = drive(1.0, 1.0, 5.0, 8.0)
    (motion,) = run.recording.of(Motion)
    assert motion.waypoints[-1] == (8.0, 5.0, 1.0, 0.0)


def test_the_true_state_can_be_read_between_steps(stepping, word):
    def drives(me):
        yield drive(1.0, 1.0, 5.0, 8.0)
        yield END

    def talks(me):
        yield Receive(2.0)
        yield Send(word(sender=1, text="halfway"))
        yield Receive(1.0)
        yield Send(word(sender=1, text="on the air"))
        yield Receive(1.0)
        yield END

    run = stepping(drives, talks, radio=RadioSpec(latency_s=0.5))
    steps = [step for _, step in zip(range(5), run, strict=False)]
    assert [step.robot for step in steps] == [0, 1, 1, 1, 1]
    assert run.time_s == 3.0
    driver, talker = run.robots
    assert driver.configuration == Configuration(2.5, 1.0, 0.0)
    assert driver.motion is steps[0].action.trajectory
    assert (driver.mailbox, talker.mailbox) == (1, 0)
    assert (driver.state, talker.motion) == ("on", None)
    assert run.messages_in_flight == 0
    next(run)
    assert run.messages_in_flight == 1
    next(run)
    assert run.messages_in_flight == 0
    assert (run.time_s, run.robots[0].mailbox) == (4.0, 2)


def test_the_recording_so_far_has_the_motions_under_way(stepping, tmp_path):
    def drives(me):
        yield drive(1.0, 1.0, 5.0, 8.0)
        yield END

    def waits(me):
        yield Receive(2.0)
        yield END

    run = stepping(drives, waits)
    for step in run:
        if step.time_s == 2.0:
            break
    so_far = run.recording
    (motion,) = so_far.of(Motion)
    assert motion.waypoints == ((0.0, 1.0, 1.0, 0.0), (2.0, 2.0, 1.0, 0.0))
    assert (so_far.footer.time_s, so_far.footer.outcome) == (2.0, "out_of_time")
    assert so_far.footer.reason == "stepped up to 2 s"
    so_far.save(tmp_path / "recording.jsonl")
    assert Recording.load(tmp_path / "recording.jsonl").events == so_far.events


def test_a_run_in_steps_ends_when_its_time_is_over(stepping):
    def acts(me):
        yield drive(1.0, 1.0, 5.0, 8.0)
        yield END

    run = stepping(acts, max_time_s=4.0)
    assert len(list(run)) == 1
    assert run.recording.footer.outcome == "out_of_time"
    assert run.time_s == 4.0


def test_a_collision_ends_a_run_in_steps(stepping):
    def acts(me):
        yield drive(1.0, 1.0, 50.0, 8.0)
        yield END

    run = stepping(acts)
    assert len(list(run)) == 1
    assert "touched an obstacle" in run.recording.footer.reason


def test_a_defect_is_raised_by_the_step_after_it(stepping):
    def acts(me):
        yield Sense()
        yield "forward"

    run = stepping(acts)
    assert next(run).action == Sense()
    assert next(run).action == "forward"
    with pytest.raises(ExplorerDefect, match="which is no action"):
        next(run)
    assert [event.time_s for event in run.recording.events] == [0.0]
    assert list(run) == []
    assert not run.is_over


def test_an_error_of_an_explorer_is_told_with_its_place(stepping):
    def acts(me):
        yield Sense()
        raise KeyError("goal")

    run = stepping(acts)
    next(run)
    with pytest.raises(ExplorerDefect, match=r"KeyError: 'goal' \(test_stepping\.py:\d+, in acts"):
        next(run)


def test_a_closed_run_has_no_more_steps_but_its_record(stepping):
    def acts(me):
        while True:
            yield Sense()
            yield Receive(1.0)

    with stepping(acts) as run:
        for step in run:
            if step.time_s == 3.0:
                break
    assert list(run) == []
    assert (run.time_s, run.is_over) == (3.0, False)
    assert len(run.recording.events) == 3


@pytest.mark.parametrize("close", [True, False])
def test_explorers_are_freed_with_a_run_that_is_given_up(stepping, close):
    ended = []

    def acts(me):
        try:
            while True:
                yield Receive(1.0)
        finally:
            ended.append(me.me.robot)

    run = stepping(acts, acts)
    for step in run:
        if step.time_s == 2.0:
            break
    kept = [weakref.ref(explorer) for explorer in run.explorers]
    if close:
        run.close()
        assert sorted(ended) == [0, 1]
    del run
    assert sorted(ended) == [0, 1]
    assert [reference() for reference in kept] == [None, None]


def test_a_spec_that_cannot_be_run_is_refused_at_once():
    with pytest.raises(InvalidInputError, match="unknown"):
        Stepping(msgspec.structs.replace(SMALL, strategy="unknown"))
