"""What explorers may yield, what they may do while they move, and how runs end."""

import pytest

from multisrt.events import Ended, Motion
from multisrt.geometry.configuration import Configuration
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.explorer import Done, Moved, Receive, Received, Send, Sense, Stop, TimedOut
from multisrt.spec import RadioSpec

END = Done(complete=True, reason="enough")
ON_CALL = Done(complete=True, reason="enough", on_call=True)
TWO = [(1.0, 1.0), (1.0, 5.0)]


def test_an_explorer_ends_with_done(drive):
    with pytest.raises(ExplorerDefect, match="Done"):
        drive(Sense())


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (None, "yielded None, which is no action"),
        ("sense", "yielded 'sense', which is no action"),
        (Sense, r"the class Sense; yield an instance: Sense\("),
    ],
)
def test_an_explorer_yields_actions(drive, action, said):
    with pytest.raises(ExplorerDefect, match=said):
        drive(action, Done(complete=True, reason=""))


def test_a_run_that_is_no_generator_is_refused(drive, monkeypatch):
    monkeypatch.setattr("tests.multisrt.simulation.conftest.Actor.run", lambda _: [Sense()])
    with pytest.raises(ExplorerDefect, match=r"run\(\) returned a list, not a generator"):
        drive()


def test_an_explorers_own_error_is_told_with_its_place(play):
    def script():
        yield Sense()
        raise ZeroDivisionError

    place = (
        r"it raised ZeroDivisionError \(test_interpreter\.py:\d+, in script: raise Zero.*\); "
        "correct that line: .*check FILE"
    )
    with pytest.raises(ExplorerDefect, match=place) as caught:
        play(script)
    # The clock raises a copy, whose cause is the defect itself.
    assert isinstance(caught.value.__cause__.__cause__, ZeroDivisionError)  # type: ignore[union-attr]


def test_an_interrupt_of_compiled_code_is_no_error_of_the_explorer(play):
    def script():
        yield Sense()
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    with pytest.raises(KeyboardInterrupt):
        play(script)


def test_an_error_before_the_first_action_is_told_alike(drive, monkeypatch):
    monkeypatch.setattr("tests.multisrt.simulation.conftest.Actor.run", lambda _: 1 / 0)
    with pytest.raises(
        ExplorerDefect, match=r"ZeroDivisionError: .*\(test_interpreter\.py:\d+, in <l"
    ):
        drive()


def test_a_moving_robot_receives_messages_that_wake(
    play, word, call, straight, sends_each_second, events_of
):
    a, b, c, d = (
        kind(sender=0, text=text)
        for kind, text in ((word, "a"), (call, "b"), (word, "c"), (call, "d"))
    )
    recording, (_, told) = play(
        sends_each_second(a, b, c, d),
        [straight(1, 5, 5, 5, listen=True), Receive(), Receive(), Receive(0), END],
        starts=TWO,
    )
    assert told[:3] == [
        Received((a, b), 2.0),
        Received((c, d), 4.0),
        Moved(configuration=Configuration(5.0, 5.0, 0.0), time_s=8.0),
    ]
    assert told[3] == TimedOut(8.0)
    assert [m.waypoints[-1] for m in events_of(recording, Motion)] == [(8.0, 5.0, 5.0, 0.0)]


def test_a_moving_robot_does_not_receive_other_messages(play, word, straight, sends_each_second):
    a, b = word(sender=0, text="a"), word(sender=0, text="b")
    _, (_, told) = play(
        sends_each_second(a, b), [straight(1, 5, 5, 5, listen=True), Receive(), END], starts=TWO
    )
    assert told[:2] == [
        Moved(configuration=Configuration(5.0, 5.0, 0.0), time_s=8.0),
        Received((a, b), 8.0),
    ]


def test_a_robot_that_does_not_listen_receives_on_arrival(
    play, word, call, straight, sends_each_second
):
    message = call(sender=0)
    _, (_, told) = play(
        sends_each_second(message), [straight(1, 5, 5, 5), Receive(), END], starts=TWO
    )
    assert told[:2] == [
        Moved(configuration=Configuration(5.0, 5.0, 0.0), time_s=8.0),
        Received((message,), 8.0),
    ]


def test_a_moving_robot_can_scan_send_and_wait(play, word, call, straight):
    def on_the_way():
        yield straight(1, 5, 5, 5, listen=True)
        assert (yield Receive(1.0)) == TimedOut(2.0)
        scan = yield Sense()
        assert (scan.configuration, scan.time_s) == (Configuration(2.0, 5.0, 0.0), 2.0)
        yield Send(word(sender=1))
        moved = yield Receive()
        assert moved == Moved(configuration=Configuration(5.0, 5.0, 0.0), time_s=8.0)
        yield END

    recording, (told, _) = play(
        [Receive(1.0), Send(call(sender=0)), Receive(), END], on_the_way, starts=TWO
    )
    assert told[2] == Received((word(sender=1),), 2.0)
    assert recording.footer.outcome == "complete"


def test_a_robot_stops_where_it_is(play, call, straight, sends_each_second, events_of):
    def on_the_way():
        yield straight(1, 5, 5, 5, listen=True)
        moved = yield Stop()
        assert moved == Moved(configuration=Configuration(1.5, 5.0, 0.0), time_s=1.0)
        # It stands there now; the old motion is forgotten.
        assert (yield Receive(20.0)) == TimedOut(21.0)
        yield straight(1.5, 5, 1.5, 4)
        yield END

    recording, _ = play(sends_each_second(call(sender=0)), on_the_way, starts=TWO)
    assert [motion.waypoints for motion in events_of(recording, Motion)] == [
        ((0.0, 1.0, 5.0, 0.0), (1.0, 1.5, 5.0, 0.0)),
        ((21.0, 1.5, 5.0, 0.0), (23.0, 1.5, 4.0, 0.0)),
    ]


def test_an_explorer_that_lets_no_time_pass_is_refused(play, call, straight, monkeypatch):
    monkeypatch.setattr("multisrt.simulation.protocol.MAX_ACTIONS", 50)

    def waits_for_nothing():
        yield straight(1, 5, 2, 5)
        while True:
            yield Receive(0.0)

    with pytest.raises(
        ExplorerDefect, match=r"robot 0 .*: it yielded 50 actions at 2 s and lets no"
    ):
        play(waits_for_nothing(), starts=[(1.0, 5.0)])

    def answers(robot):
        yield Send(call(sender=robot))
        while True:
            yield Receive()
            yield Send(call(sender=robot))

    with pytest.raises(ExplorerDefect, match=r"yielded 50 actions at 0 s and lets no time"):
        play(answers(0), answers(1), starts=TWO)


def test_actions_are_counted_separately_at_each_time(play, monkeypatch):
    monkeypatch.setattr("multisrt.simulation.protocol.MAX_ACTIONS", 5)

    def waits():
        for _ in range(40):
            yield Receive(0.1)
        yield END

    recording, _ = play(waits(), starts=[(1.0, 5.0)])
    assert recording.footer.outcome == "complete"


def test_moments_without_end_are_refused(play, monkeypatch):
    monkeypatch.setattr("multisrt.simulation.protocol.MAX_ACTIONS", 50)
    monkeypatch.setattr("multisrt.simulation.protocol.MAX_RATE_HZ", 4)

    def waits(timeout_s):
        yield Receive(2.0)
        while True:
            yield Receive(timeout_s)

    for timeout_s in (1e-9, 0.1):
        with pytest.raises(ExplorerDefect, match=r"yielded \d+ actions by .* of which 4 in a"):
            play(waits(timeout_s), starts=[(1.0, 5.0)])
    recording, _ = play(waits(0.25), starts=[(1.0, 5.0)])
    assert recording.footer.outcome != "complete"


def test_stop_requires_a_motion_and_move_a_standing_robot(play, call, straight, sends_each_second):
    with pytest.raises(ExplorerDefect, match=r"robot 1 .* at 0 s: it yielded Stop, but it stands"):
        play([END], [Stop(), END], starts=TWO)
    with pytest.raises(ExplorerDefect, match=r"robot 1 .*: it yielded Move while a motion goes on"):
        play(
            sends_each_second(call(sender=0)),
            [straight(1, 5, 5, 5, listen=True), straight(1.5, 5, 5, 5, listen=True)],
            starts=TWO,
        )


def test_an_explorer_that_gives_up_is_stalled(drive):
    recording, _ = drive(Done(complete=False, reason="tired"))
    assert recording.footer.outcome == "stalled"
    assert "tired" in recording.footer.reason


def test_a_robot_on_call_is_called_on_again(play, word, straight, events_of):
    def on_call():
        received = yield Done(complete=False, reason="nothing known", on_call=True)
        assert received == Received((word(sender=0),), 5.0)
        yield straight(1, 5, 3, 5)
        yield ON_CALL
        raise AssertionError("nobody calls again")

    recording, _ = play([Receive(5.0), Send(word(sender=0)), END], on_call, starts=TWO)
    assert [(e.time_s, e.reason) for e in events_of(recording, Ended, 1)] == [
        (0.0, "nothing known"),
        (9.0, "enough"),
    ]
    # The last end counts.
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s == 9.0


def test_a_message_under_way_to_a_robot_on_call_prolongs_the_run(play, word, straight):
    def on_call():
        yield ON_CALL
        yield straight(1, 5, 3, 5)
        yield ON_CALL

    recording, told = play(
        [Send(word(sender=0)), END], on_call, starts=TWO, radio=RadioSpec(latency_s=3.0)
    )
    assert told[1][0].time_s == 3.0
    assert recording.footer.time_s == 7.0
    assert recording.footer.outcome == "complete"


def test_an_equal_second_end_is_not_recorded(play, word, sends_each_second, events_of):
    recording, told = play(
        sends_each_second(word(sender=0), word(sender=0)), [ON_CALL, ON_CALL, ON_CALL], starts=TWO
    )
    assert len(told[1]) == 2
    assert len(events_of(recording, Ended, 1)) == 1


def test_a_robot_that_is_done_for_good_does_not_delay_the_end(play, word, sends_each_second):
    recording, _ = play(sends_each_second(word(sender=0)), [END], starts=TWO)
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s == 1.0


def test_a_robot_that_waits_forever_stalls_the_run(play, straight):
    recording, told = play(
        [straight(1, 1, 3, 1), END], [Receive(), END], [Receive(2.0), Receive(), END],
        starts=[(1.0, 1.0), (1.0, 5.0), (9.0, 5.0)],
    )  # fmt: skip
    assert recording.footer.outcome == "stalled"
    assert recording.footer.reason == "robots 1 and 2 wait for a message that never comes"
    assert told[1] == []
    assert recording.footer.time_s == 4.0


def test_a_robot_that_gives_up_stalls_the_run(play):
    recording, _ = play([END], [Done(complete=False, reason="tired")], starts=TWO)
    assert recording.footer.outcome == "stalled"
    assert recording.footer.reason == "robot 0: enough; robot 1: tired"


def test_the_stop_rule_cuts_the_motions_of_all_robots(play, straight, events_of):
    recording, told = play(
        [straight(1, 1, 9, 1), END],
        [straight(5, 5, 3, 5), straight(3, 5, 9, 5), END],
        [Receive(), END],
        starts=[(1.0, 1.0), (5.0, 5.0), (9.0, 3.0)],
        max_time_s=6.0,
    )
    assert recording.footer.outcome == "out_of_time"
    assert recording.footer.time_s == 6.0
    assert {(m.robot, m.waypoints) for m in events_of(recording, Motion)} == {
        (0, ((0.0, 1.0, 1.0, 0.0), (6.0, 4.0, 1.0, 0.0))),
        (1, ((0.0, 5.0, 5.0, 0.0), (4.0, 3.0, 5.0, 0.0))),
        (1, ((4.0, 3.0, 5.0, 0.0), (6.0, 4.0, 5.0, 0.0))),
    }
    assert told[0] == []
