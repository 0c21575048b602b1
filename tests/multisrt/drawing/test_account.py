"""How pictures and summaries say that a run ended."""

from dataclasses import replace

import msgspec
import pytest

import multisrt as ms
from multisrt.drawing.account import outcome_told
from multisrt.drawing.tree_svg import tree_svg
from multisrt.events import AnyEvent, BaseLearned, Died, Ended
from multisrt.recording import Recording
from tests.multisrt.drawing.pictures import texts

STARTS = [(1.0, 1.0), (2.0, 1.0)]


def going_home(strategy: str, robots: int) -> ms.Run:
    """Robots that deliver data in time, from a hall that takes longer."""
    return ms.explore(
        "open",
        strategy=strategy,
        starts=STARTS[:robots],
        base=STARTS[0],
        radio_range_m=6.0,
        options={"home": "in-time"},
        max_time_s=60.0,
        seed=1,
    )


@pytest.fixture(scope="module")
def in_time() -> ms.Run:
    return going_home("minpos", 2)


def with_events(recording: Recording, *events: AnyEvent, without: type | None = None) -> Recording:
    kept = [e for e in recording.events if without is None or not isinstance(e, without)]
    return replace(recording, events=(*kept, *events))


def test_a_robot_of_trees_that_went_home_in_time_did_not_stall():
    run = going_home("srt-radial", 1)
    assert (run.outcome, outcome_told(run.recording)) == ("stalled", "home in time")


def test_robots_that_went_home_in_time_did_not_stall(in_time):
    assert in_time.outcome == "stalled"
    assert outcome_told(in_time.recording) == "home in time"
    assert texts(tree_svg(in_time.recording))[1].startswith("home in time after ")


def test_a_dead_robot_need_not_come_home(in_time):
    died = Died(robot=1, time_s=1.0, configuration=(2.0, 1.0, 0.0), doing="moving")
    assert outcome_told(with_events(in_time.recording, died)) == "home in time"


def test_a_run_stalled_whose_news_are_not_home(in_time):
    assert outcome_told(with_events(in_time.recording, without=BaseLearned)) == "stalled"


def test_a_run_stalled_in_which_a_robot_never_ended_or_had_another_reason(in_time):
    recording = in_time.recording
    first = next(event for event in recording.of(Ended) if event.robot == 0)
    blocked = msgspec.structs.replace(first, reason="boxed in by robot 1", complete=False)
    assert outcome_told(with_events(recording, blocked)) == "stalled"
    assert outcome_told(with_events(recording, without=Ended)) == "stalled"
    done = msgspec.structs.replace(first, reason="no frontier is left", complete=True)
    assert outcome_told(with_events(recording, done)) == "home in time"


def test_other_outcomes_are_told_as_recorded():
    run = ms.explore("open", strategy="closest", seed=1, max_time_s=5.0)
    assert (run.outcome, outcome_told(run.recording)) == ("out_of_time", "out of time")
