"""Making one mission and judging it."""

from typing import Any

import msgspec
import pytest

from multisrt.campaign import mission
from multisrt.campaign.mission import described, judge, judge_recorded, make, max_steps
from multisrt.campaign.violations import MAX_LENGTH, Violation
from multisrt.events import Decided
from multisrt.robots.explorer import Done, Note, Receive
from multisrt.robots.registry import registered
from multisrt.robots.strategy import Strategy
from multisrt.spec import CatalogEnvironment, RangeFinderSpec, RobotSpec, RunSpec, StopRule

HALL = CatalogEnvironment(name="open", parameters={"size_m": 6.0})


class Own:
    """An explorer that fails in some way, by its option."""

    class Options(msgspec.Struct, frozen=True, kw_only=True):
        """How it fails."""

        way: str = "raise"

    def __init__(self, me, options):
        self.way = options.way
        if self.way == "begin":
            raise KeyError(me.robot)

    def run(self):
        """Fail."""
        if self.way == "raise":
            raise ValueError("no such place")
        if self.way == "wait":
            while True:
                yield Receive(timeout_s=1e-4)
        if self.way == "note":
            while True:
                yield Note(Decided(robot=0, time_s=0.0, text="again"))
        yield Done(complete=True, reason="all is well")


@pytest.fixture
def own():
    """The spec of a run that fails in a way."""
    with registered(Strategy.of(Own, name="own")):
        yield lambda way, **more: RunSpec(
            environment=HALL,
            strategy="own",
            options={"way": way},
            stop=StopRule(max_time_s=10.0),
            **more,
        )


def test_a_run_that_is_well_has_no_violation():
    verdict = judge(RunSpec(environment=HALL, strategy="closest"))
    assert (verdict.outcome, verdict.violations) == ("complete", ())
    assert len(verdict.digest) == 64
    assert verdict.events > 5
    assert verdict.steps > 5
    assert verdict.run_s > 0.0


def test_an_error_of_an_explorer_is_a_violation(own):
    verdict = judge(own("raise"))
    assert verdict.outcome == "error"
    (found,) = verdict.violations
    assert found.invariant == "no-error"
    assert found.says.startswith("ValueError in test_mission.py:")
    assert found.says.endswith(": no such place")


def test_long_messages_of_errors_are_cut_in_what_a_violation_says(own, monkeypatch):
    monkeypatch.setattr(mission, "described", lambda error: f"ValueError in x.py:1: {'a' * 300}")
    verdict = judge(own("raise"))
    (found,) = verdict.violations
    assert (len(found.says), found.says[-4:]) == (MAX_LENGTH, "a...")
    assert len(verdict.reason) > 300


def test_an_error_in_setting_up_is_a_violation(own):
    verdict = judge(own("begin"))
    assert (verdict.outcome, verdict.violations[0].invariant) == ("error", "no-error")
    assert verdict.violations[0].says.startswith("KeyError in test_mission.py:")


def test_what_is_recorded_of_a_run_that_fails_is_kept(own):
    judged = judge_recorded(own("raise", robots=(RobotSpec(), RobotSpec())))
    assert judged.recording is not None
    assert judged.recording.spec.strategy == "own"


@pytest.mark.parametrize("way", ["wait", "note"])
def test_a_run_without_end_is_a_violation(own, way, monkeypatch):
    monkeypatch.setattr(mission, "MIN_STEPS", 50)
    monkeypatch.setattr(mission, "STEPS_PER_ROBOT_S", 0)
    verdict = judge(own(way))
    assert verdict.outcome == "endless"
    assert verdict.violations[0].invariant == "ends"


def test_the_limit_on_events_grows_with_what_robots_tell_one_another():
    # Ten robots in an office had 52,422 in 20 s, most of them messages that arrived.
    spec = RunSpec(environment=HALL, robots=(RobotSpec(),) * 10, stop=StopRule(max_time_s=20.0))
    assert max_steps(spec) > 52_422


def test_an_impossible_run_is_refused():
    wide = RobotSpec(footprint="disc:4", range_finder=RangeFinderSpec(range_m=5.0))
    verdict = judge(RunSpec(environment=HALL, robots=(wide,)))
    assert (verdict.outcome, verdict.violations) == ("refused", ())
    assert "disc:4" in verdict.reason


def test_violations_of_invariants_are_told(monkeypatch):
    broke = Violation(invariant="planted", says="it broke", time_s=3.0)
    monkeypatch.setattr(mission, "check", lambda run: [broke])
    assert judge(RunSpec(environment=HALL, strategy="closest")).violations == (broke,)


def test_an_invariant_that_raises_is_a_violation_of_its_own(monkeypatch):
    def check(run):
        raise ZeroDivisionError("area")

    monkeypatch.setattr(mission, "check", check)
    verdict = judge(RunSpec(environment=HALL, strategy="closest"))
    assert verdict.outcome == "complete"
    assert verdict.violations[0].invariant == "can-be-judged"
    assert verdict.violations[0].says.startswith("ZeroDivisionError in test_mission.py")


def test_a_mission_is_judged_as_its_spec_is():
    seen: list[Any] = []
    made = make(4, 2, lambda spec, refused: seen.append(spec))
    judged = judge(seen[-1])
    assert (made.digest, made.outcome) == (judged.digest, judged.outcome)
    assert made.digest


def test_messages_of_errors_are_one_line_and_not_long():
    text = described(ValueError("a\nb" * 1000))
    assert text.startswith("ValueError: a ba b")
    assert len(text) < 450


def test_want_of_memory_is_told_from_other_errors(monkeypatch):
    def lacks(*args, **options):
        raise MemoryError

    with monkeypatch.context() as patch:
        patch.setattr(mission, "check", lacks)
        judged = judge(RunSpec(environment=HALL, strategy="closest"))
    monkeypatch.setattr(mission, "set_up", lacks)
    for verdict in (judged, judge(RunSpec(environment=HALL, strategy="closest"))):
        assert (verdict.outcome, verdict.digest) == ("over_memory", "")
        (found,) = verdict.violations
        assert found.invariant == "no-error"
        assert found.says.startswith("MemoryError in test_mission.py:")


def test_an_error_in_drawing_is_a_violation(monkeypatch):
    def fails(seed, number, on_draw):
        raise RuntimeError("a hole without a shell")

    monkeypatch.setattr(mission, "drawn", fails)
    verdict = make(4, 2)
    assert (verdict.outcome, verdict.violations[0].invariant) == ("error", "no-error")
    assert verdict.reason.endswith(": a hole without a shell")
