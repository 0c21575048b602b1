"""Runs of which nothing comes any more although events go on."""

import pytest

from multisrt.events import Learned, NodeAdded
from multisrt.robots.explorer import Done, Note, Receive, Sense
from multisrt.spec import Death, LateStart, Silence, StopRule

END = Done(complete=True, reason="enough")


def waits(action=None):
    """Build a script that waits for ever, a second at a time."""

    def acts():
        while True:
            yield Receive(1.0)
            if action is not None:
                yield action

    return acts


def test_robots_that_wait_again_and_again_end_the_run(play):
    recording, told = play([END], waits(), waits(), max_time_s=1e5)
    footer = recording.footer
    assert (footer.outcome, footer.time_s) == ("stalled", 3600.0)
    assert footer.reason == (
        "no robot moved, sensed or learned anything new for 3,600 s: robot 0 is done and robots 1 "
        "and 2 wait"
    )
    assert len(told[1]) == 3600


def test_the_limit_is_part_of_the_spec(play):
    recording, _ = play(waits(), stop=StopRule(max_time_s=900.0, max_idle_s=60.0))
    assert (recording.footer.outcome, recording.footer.time_s) == ("stalled", 60.0)
    recording, _ = play(waits(), stop=StopRule(max_time_s=50.0, max_idle_s=60.0))
    assert (recording.footer.outcome, recording.footer.time_s) == ("out_of_time", 50.0)


def test_a_robot_that_is_stopped_again_and_again_is_named(play, straight):
    def pushes():
        at = (1.0, 3.0)
        while True:
            moved = yield straight(*at, 1.0, 6.0 - 0.5, heading=0.0, guard_m=0.05)
            at = moved.configuration[:2]
            yield Receive(1.0)

    stop = StopRule(max_idle_s=100.0)
    recording, _ = play([END], pushes, [END], stop=stop)
    assert recording.footer.outcome == "stalled"
    assert recording.footer.reason.endswith(
        "for 100 s: robots 0 and 2 are done and robot 1 stopped before robot 2"
    )


def test_motions_keep_a_run_going_and_standing_ones_do_not(play, straight):
    def drives(length):
        def acts():
            for _ in range(10):
                yield straight(1.0, 1.0, 1.0 + length, 1.0, seconds=30.0)
                yield straight(1.0 + length, 1.0, 1.0, 1.0, seconds=30.0)
            yield END

        return acts

    stop = StopRule(max_idle_s=100.0)
    assert play(drives(1.0), stop=stop)[0].footer.outcome == "complete"
    stands = play(drives(0.0), stop=stop)[0].footer
    assert (stands.outcome, stands.time_s) == ("stalled", 100.0)


def test_a_long_motion_is_under_way(play, straight):
    slow = [straight(1.0, 1.0, 2.0, 1.0, seconds=500.0), END]
    recording, _ = play(slow, waits(), stop=StopRule(max_idle_s=100.0))
    assert (recording.footer.outcome, recording.footer.time_s) == ("stalled", 600.0)


def test_a_scan_from_the_same_place_shows_nothing_new(play):
    recording, _ = play(waits(Sense()), stop=StopRule(max_idle_s=100.0))
    # The first scan is taken after a second.
    assert recording.footer.time_s == 101.0


def test_a_single_long_wait_is_waited_for(play):
    acts = [Receive(5000.0), Receive(10.0), END]
    recording, _ = play(acts, waits(), stop=StopRule(max_idle_s=100.0))
    assert recording.footer.reason.endswith("robot 0 is done and robot 1 waits")
    assert recording.footer.time_s == 5110.0


@pytest.mark.parametrize(
    ("fault", "last_s"),
    [
        (LateStart(robot=1, time_s=500.0), 500.0),
        (Death(robot=1, time_s=700.0), 700.0),
        (Silence(robot=1, time_s=300.0, duration_s=50.0), 350.0),
    ],
)
def test_faults_to_come_are_waited_for(play, fault, last_s):
    recording, _ = play(waits(), waits(), faults=(fault,), stop=StopRule(max_idle_s=100.0))
    assert recording.footer.outcome == "stalled"
    assert recording.footer.time_s == last_s + 100.0


def test_nodes_count_when_they_are_new(play):
    def node(serial, time_s):
        return NodeAdded(
            time_s=time_s,
            robot=0,
            serial=serial,
            parent=None,
            configuration=(1.0, 1.0, 0.0),
            stage="scan",
            boundary=((0.5, 0.5), (1.5, 0.5), (1.0, 1.5)),
            tags="000",
        )

    def adds():
        for serial in range(3):
            yield Receive(40.0)
            yield Note(node(serial, 40.0 * (serial + 1)))
        yield END

    def learns():
        yield Receive(130.0)
        time_s = 130.0
        while True:
            yield Note(Learned(time_s=time_s, robot=1, nodes=((0, 0),)))
            outcome = yield Receive(10.0)
            time_s = outcome.time_s

    recording, _ = play(adds, learns, stop=StopRule(max_idle_s=50.0))
    assert recording.footer.time_s == 180.0
