"""Which robot the summary of a run points at."""

import multisrt as ms
from multisrt.cli.summary import robot_to_ask
from multisrt.events import Ended


def test_the_robot_that_ended_last_is_asked():
    run = ms.explore("open", robots=2, strategy="closest", seed=1)
    ends = {event.robot: event.time_s for event in run.recording.of(Ended)}
    assert ends[robot_to_ask(run)] == max(ends.values())


def test_a_robot_that_did_not_end_is_asked_first():
    death = ms.Death(robot=1, time_s=1.0)
    run = ms.explore("open", robots=2, strategy="closest", seed=1, faults=[death])
    assert robot_to_ask(run) == 1
