"""The explanations of a robot at every time are those that `explain` gives."""

from itertools import pairwise
from typing import get_args

import numpy as np
import pytest
from shapely import box, union

import multisrt as ms
from multisrt.environments.environment import Environment
from multisrt.events import Choice, Decision, Learned
from multisrt.explain.moments import moments
from multisrt.explain.srt import explain
from multisrt.explain.terms import CHOICES
from tests.multisrt.drawing.recordings import recorded


@pytest.fixture(scope="module", params=["srt-radial", "minpos"])
def run(request):
    return ms.explore(
        "apartment", robots=2, strategy=request.param, seed=1, radio_range_m=12.5, max_time_s=40.0
    )


def told(recording, robot, time_s):
    lines = [m for m in moments(recording, robot) if m.time_s <= time_s][-1].lines
    return f"Robot {robot} at {time_s:.2f} s: " + "\n".join(lines) + "\n"


@pytest.mark.slow
def test_at_any_time_the_last_moment_tells_the_same(run):
    rng = np.random.default_rng(1)
    for robot in range(2):
        for time_s in (0.0, *rng.uniform(0.0, run.recording.footer.time_s, 12)):
            assert told(run.recording, robot, time_s) == explain(run.recording, robot, time_s)


@pytest.mark.parametrize("strategy", ["srt-radial", "minpos"])
def test_what_is_to_be_delivered_is_told_from_the_whole_run(strategy):
    run = ms.explore(
        "apartment",
        robots=2,
        strategy=strategy,
        seed=1,
        radio=ms.RadioSpec(range_m=12.5, walls="block"),
        base=(2.5, 2.0),
        starts="base",
        options={"home": "in-time"},
        max_time_s=60.0,
    )
    recording = run.recording
    assert recording.of(Learned)
    said = set()
    for robot in range(2):
        for moment in moments(recording, robot):
            text = f"Robot {robot} at {moment.time_s:.2f} s: " + "\n".join(moment.lines) + "\n"
            assert text == explain(recording, robot, moment.time_s)
            said |= {line for line in moment.lines if "the base station in fact lacked" in line}
    assert len(said) > 3


@pytest.mark.slow
def test_moments_rise_and_differ(run):
    found = list(moments(run.recording, 0))
    times = [moment.time_s for moment in found]
    assert times == sorted(set(times))
    assert all(a.lines != b.lines for a, b in pairwise(found))


def test_those_of_choices_only_are_fewer():
    recording = ms.explore("open", seed=1, max_time_s=30.0).recording
    few, all_of_them = list(moments(recording, 0, choices_only=True)), list(moments(recording, 0))
    assert len(few) == len({event.time_s for event in recording.of(Decision)}) < len(all_of_them)


def test_a_robot_without_decisions_has_none():
    recording = recorded([(2.0, 4.0), (6.0, 4.0)], [])
    assert [list(moments(recording, robot)) for robot in range(2)] == [[], []]


def test_a_robot_that_drives_a_plan_has_one():
    corner = Environment("corner", union(box(0.0, 0.0, 10.0, 1.0), box(9.0, 0.0, 10.0, 10.0)))
    recording = ms.explore(corner, strategy="informed", start=(0.5, 0.5), seed=1).recording
    (moment,) = moments(recording, 0)
    assert "a route that was planned on the true map" in moment.lines[0]
    assert explain(recording, 0, 2.0) == f"Robot 0 at 2.00 s: {moment.lines[0]}\n"


def test_every_choice_has_words():
    assert set(CHOICES) == set(get_args(Choice))
