"""What the summary of a run says of its end, and which robot it points at."""

import msgspec
import pytest

import multisrt as ms
from multisrt.cli.summary import print_summary, robot_to_ask
from multisrt.events import Ended


def test_the_robot_that_ended_last_is_asked():
    run = ms.explore("open", robots=2, strategy="closest", seed=1)
    ends = {event.robot: event.time_s for event in run.recording.of(Ended)}
    assert ends[robot_to_ask(run)] == max(ends.values())


def test_a_robot_that_did_not_end_is_asked_first():
    death = ms.Death(robot=1, time_s=1.0)
    run = ms.explore("open", robots=2, strategy="closest", seed=1, faults=[death])
    assert robot_to_ask(run) == 1


@pytest.mark.parametrize(
    ("measured", "said"),
    [
        ({}, "complete"),
        ({"collisions": 1}, "complete, but with a collision: no success"),
        ({"coverage": 0.5}, "complete, but only 50.0 % covered: no success"),
        ({"coverage": 0.5, "collisions": 1}, "complete, but only 50.0 % covered: no success"),
    ],
)
def test_the_first_line_says_why_a_run_is_no_success(measured, said, capsys, tmp_path):
    run = ms.explore("open", strategy="closest", seed=1)
    run.__dict__["metrics"] = msgspec.structs.replace(run.metrics, **measured)
    print_summary([run], [tmp_path])
    assert capsys.readouterr().out.splitlines()[0] == f"closest in open, seed 1: {said}"
