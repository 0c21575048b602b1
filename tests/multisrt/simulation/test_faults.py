"""Faults of the spec: deaths, silences and late starts, with scripted robots."""

import pytest

from multisrt.events import (
    Blocked,
    CameBack,
    Collision,
    Died,
    Ended,
    FellSilent,
    Joined,
    Motion,
    Organized,
    Sent,
)
from multisrt.geometry.configuration import Configuration
from multisrt.robots.explorer import (
    Done,
    Look,
    Moved,
    Note,
    Receive,
    Received,
    Send,
    Sense,
    Stop,
    TimedOut,
)
from multisrt.spec import Death, LateStart, RadioSpec, Silence

END = Done(complete=True, reason="enough")


# Deaths --------------------------------------------------------------------------------------


def test_a_robot_that_dies_while_moving_stays_there(play, straight, events_of):
    recording, told = play(
        [straight(1, 1, 5, 1), Sense(), END], [END], faults=[Death(robot=0, time_s=3.0)]
    )
    here = (2.5, 1.0, 0.0)
    assert events_of(recording, Died) == [
        Died(time_s=3.0, robot=0, configuration=here, doing="moving")
    ]
    (motion,) = events_of(recording, Motion)
    assert motion.waypoints == ((0.0, 1.0, 1.0, 0.0), (3.0, *here))
    assert told[0] == []
    # The run ends when all living robots are done.
    assert recording.footer.outcome == "complete"
    assert recording.footer.reason == "robot 0 died; robot 1: enough"


def test_the_living_go_on_after_a_death(play, straight):
    recording, told = play(
        [straight(1, 1, 5, 1), END],
        [straight(1, 3, 5, 3), straight(5, 3, 9, 3), END],
        faults=[Death(robot=0, time_s=3.0)],
    )
    assert recording.footer.time_s == 16.0
    assert [moved.time_s for moved in told[1]] == [8.0, 16.0]


@pytest.mark.parametrize("guard_m", [0.5, None])
def test_the_body_of_a_dead_robot_is_an_obstacle(play, straight, events_of, guard_m):
    # It dies at (1, 2), in the path of robot 1, whose guard keeps 1 m between the centres.
    def pass_by():
        yield Receive(5.0)
        yield straight(3, 2, 0.5, 2, guard_m=guard_m)
        yield Look()
        yield END

    recording, told = play(
        [straight(1, 1, 1, 4), END],
        pass_by,
        starts=[(1.0, 1.0), (3.0, 2.0)],
        faults=[Death(robot=0, time_s=2.0)],
    )
    if guard_m is None:
        assert isinstance(recording.events[-1], Collision)
        assert "robot 0" in recording.footer.reason
        assert "robot 1" in recording.footer.reason
        return
    moved = told[1][1]
    assert moved.blocked_by.robot == 0
    assert moved.blocked_by.configuration == Configuration(1.0, 2.0, 0.0)
    assert moved.configuration.x == pytest.approx(2.0, abs=1e-3)
    assert [event.by for event in events_of(recording, Blocked)] == [0]
    assert [sighting.robot for sighting in told[1][2]] == [0]


def test_a_death_frees_the_path_that_would_have_been_crossed(play, straight):
    # Robot 0 would be in the path of robot 1 at 6 s, but dies at once.
    recording, told = play(
        [straight(1, 1, 1, 3), END],
        [straight(5, 3, 1, 3, guard_m=0.5), END],
        starts=[(1.0, 1.0), (5.0, 3.0)],
        faults=[Death(robot=0, time_s=1.0)],
    )
    assert told[1][0].blocked_by is None
    assert recording.footer.outcome == "complete"


def test_a_robot_that_waits_dies_waiting(play, events_of):
    recording, _ = play([Receive(), END], [END], faults=[Death(robot=0, time_s=3.0)])
    (died,) = events_of(recording, Died)
    assert (died.time_s, died.doing) == (3.0, "waiting")
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s == 3.0


def test_a_death_while_moving_waits_for_the_next_motion(play, straight, events_of):
    # At 1 s it waits; it sets out at 5 s for 4 s, and dies halfway.
    recording, _ = play(
        [Receive(5.0), straight(1, 1, 3, 1), END],
        [END],
        faults=[Death(robot=0, time_s=1.0, when="moving")],
    )
    (died,) = events_of(recording, Died)
    assert (died.time_s, died.doing, died.configuration) == (7.0, "moving", (2.0, 1.0, 0.0))


def test_a_death_while_moving_strikes_a_moving_robot_at_once(play, straight, events_of):
    recording, _ = play(
        [straight(1, 1, 3, 1), END], [END], faults=[Death(robot=0, time_s=1.0, when="moving")]
    )
    (died,) = events_of(recording, Died)
    assert (died.time_s, died.configuration) == (1.0, (1.5, 1.0, 0.0))


def test_a_death_while_moving_strikes_where_the_protective_stop_ends_the_motion(
    play, straight, events_of
):
    # It sets out at 1 s for 14 s, and has 4 m less two radii and the guard to the other.
    recording, _ = play(
        [Receive(1.0), straight(1, 3, 8, 3, guard_m=0.5), END],
        [END],
        starts=[(1.0, 3.0), (4.0, 3.0)],
        faults=[Death(robot=0, time_s=0.5, when="moving")],
    )
    (died,) = events_of(recording, Died)
    assert died.doing == "moving"
    assert 1.0 < died.time_s < 8.0
    assert not events_of(recording, Blocked)


def test_a_death_while_moving_strikes_where_the_robot_stops(play, straight, call, events_of):
    def explorer():
        yield Receive(1.0)
        yield straight(1, 1, 3, 1, listen=True)
        yield Stop()
        yield END

    def other():
        yield Receive(2.0)
        yield Send(call(sender=1))
        yield END

    recording, _ = play(explorer, other, faults=[Death(robot=0, time_s=0.5, when="moving")])
    (died,) = events_of(recording, Died)
    assert (died.time_s, died.doing, died.configuration) == (2.0, "moving", (1.5, 1.0, 0.0))


def test_a_death_while_waiting_waits_for_the_next_wait(play, straight, events_of):
    recording, told = play(
        [straight(1, 1, 3, 1), Receive(5.0), END],
        [END],
        faults=[Death(robot=0, time_s=1.0, when="waiting")],
    )
    (died,) = events_of(recording, Died)
    assert (died.time_s, died.doing, died.configuration) == (4.0, "waiting", (3.0, 1.0, 0.0))
    assert len(told[0]) == 1


def test_a_master_dies_when_it_has_organised(play, word, straight, events_of):
    note = Note(
        Organized(
            time_s=4.0,
            robot=0,
            feasible=(),
            unfeasible=(0, 1),
            before={},
            after={},
            orders={},
            conflicts=((0, 1),),
        )
    )
    recording, told = play(
        [straight(1, 1, 3, 1), note, Send(word(sender=0)), END],
        [Receive(9.0), END],
        faults=[Death(robot=0, time_s=1.0, when="master")],
    )
    (died,) = events_of(recording, Died)
    assert (died.time_s, died.doing) == (4.0, "master")
    # Its message is not sent any more.
    assert events_of(recording, Sent) == []
    assert told[1] == [TimedOut(9.0)]


def test_a_death_whose_condition_never_holds_does_not_happen(play, straight, events_of):
    recording, _ = play(
        [straight(1, 1, 3, 1), END], [END], faults=[Death(robot=0, time_s=1.0, when="master")]
    )
    assert events_of(recording, Died) == []
    assert recording.footer.outcome == "complete"


def test_the_dead_get_no_messages_and_relay_none(play, word, events_of):
    def call():
        yield Receive(1.0)
        yield Send(word(sender=0))
        yield Receive(2.0)
        yield Send(word(sender=0))
        yield END

    recording, told = play(
        call,
        [Receive(), Receive(), END],
        [Receive(), Receive(5.0), END],
        starts=[(1.0, 1.0), (5.0, 1.0), (9.0, 1.0)],
        radio=RadioSpec(range_m=5.0),
        faults=[Death(robot=1, time_s=2.0)],
    )
    assert [event.reached for event in events_of(recording, Sent)] == [(1, 2), ()]
    assert len(told[1]) == 1
    assert told[2] == [Received((word(sender=0),), 1.0), TimedOut(6.0)]
    assert recording.footer.outcome == "complete"


def test_a_message_to_a_dead_robot_does_not_prolong_the_run(play, word):
    recording, told = play(
        [Receive(1.0), Send(word(sender=0)), END],
        [Receive(), END],
        radio=RadioSpec(latency_s=3.0),
        faults=[Death(robot=1, time_s=2.0)],
    )
    assert told[1] == []
    assert recording.footer.outcome == "complete"


def test_a_run_in_which_all_die_is_stalled(play, straight, events_of):
    recording, _ = play(
        [straight(1, 1, 9, 1), END],
        [Receive(), END],
        faults=[Death(robot=0, time_s=3.0), Death(robot=1, time_s=2.0)],
    )
    assert recording.footer.outcome == "stalled"
    assert recording.footer.reason == "all robots died"
    assert recording.footer.time_s == 3.0
    assert [event.robot for event in events_of(recording, Died)] == [1, 0]


def test_an_end_of_one_that_died_afterwards_does_not_count(play, straight, events_of):
    on_call = Done(complete=True, reason="enough", on_call=True)
    recording, _ = play(
        [Done(complete=False, reason="tired", on_call=True)],
        [straight(1, 3, 5, 3), on_call],
        faults=[Death(robot=0, time_s=2.0)],
    )
    assert [event.robot for event in events_of(recording, Ended)] == [0, 1]
    assert recording.footer.outcome == "complete"


# Silences ------------------------------------------------------------------------------------


@pytest.fixture
def talk(word, straight):
    """Build a script: drive, and send a message every second, the first after half a second."""

    def build(robot, count):
        x, y = 1.0, 3.0
        yield straight(x, y, x + 0.25, y)
        x += 0.25
        for k in range(count):
            yield Send(word(sender=robot, text=str(k)))
            yield straight(x, y, x + 0.5, y)
            x += 0.5
        yield END

    return build


def test_a_silent_robot_neither_sends_nor_hears_and_comes_back(play, events_of, talk):
    recording, told = play(
        [Receive(10.0), Receive(10.0), END],
        lambda: talk(1, 6),
        faults=[Silence(robot=1, time_s=1.0, duration_s=3.0)],
    )
    sent = events_of(recording, Sent)
    assert [(event.time_s, event.reached) for event in sent] == [
        (0.5, (0,)),
        (1.5, ()),
        (2.5, ()),
        (3.5, ()),
        (4.5, (0,)),
        (5.5, (0,)),
    ]
    assert events_of(recording, FellSilent) == [FellSilent(time_s=1.0, robot=1)]
    assert events_of(recording, CameBack) == [CameBack(time_s=4.0, robot=1)]
    assert [outcome.messages[0].text for outcome in told[0][:2]] == ["0", "4"]


def test_messages_to_a_silent_robot_are_not_delivered(play, word, events_of, talk):
    recording, told = play(
        [Receive(10.0), END],
        lambda: talk(1, 6),
        faults=[Silence(robot=0, time_s=0.0, duration_s=3.0)],
    )
    assert told[0][0] == Received((word(sender=1, text="3"),), 3.5)
    assert [event.reached for event in events_of(recording, Sent)] == [(), (), (), (0,), (0,), (0,)]
    assert [event.time_s for event in events_of(recording, FellSilent)] == [0.0]
    assert [event.time_s for event in events_of(recording, CameBack)] == [3.0]


def test_a_message_that_arrives_in_a_silence_is_gone(play, events_of, talk):
    recording, told = play(
        [Receive(10.0), END],
        lambda: talk(1, 1),
        radio=RadioSpec(latency_s=1.0),
        faults=[Silence(robot=0, time_s=1.0, duration_s=2.0)],
    )
    assert events_of(recording, Sent)[0].reached == (0,)
    assert told[0] == [TimedOut(10.0)]
    assert recording.footer.outcome == "complete"


def test_a_silent_robot_goes_on(play, straight):
    recording, told = play(
        [straight(1, 1, 5, 1), Sense(), END],
        [END],
        faults=[Silence(robot=0, time_s=1.0, duration_s=100.0)],
    )
    assert told[0][0] == Moved(configuration=Configuration(5.0, 1.0, 0.0), time_s=8.0)
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s == 8.0


def test_a_run_ends_no_earlier_than_a_silence_on_record(play, events_of, talk):
    """The robot falls silent while the last message, which could call it on, is on its way."""
    recording, _ = play(
        [Done(complete=True, reason="enough", on_call=True)],
        lambda: talk(1, 1),
        radio=RadioSpec(latency_s=3.0),
        faults=[Silence(robot=0, time_s=2.0, duration_s=5.0)],
    )
    assert events_of(recording, FellSilent) == [FellSilent(time_s=2.0, robot=0)]
    assert events_of(recording, CameBack) == []
    assert recording.footer.time_s == 2.0


def test_silences_that_overlap_are_one(play, events_of, talk):
    recording, _ = play(
        [Receive(10.0), END],
        lambda: talk(1, 8),
        faults=[
            Silence(robot=0, time_s=1.0, duration_s=2.0),
            Silence(robot=0, time_s=2.0, duration_s=3.0),
        ],
    )
    reached = [event.time_s for event in events_of(recording, Sent) if event.reached]
    assert reached == [0.5, 5.5, 6.5, 7.5]
    assert [event.time_s for event in events_of(recording, CameBack)] == [5.0]
    assert len(events_of(recording, FellSilent)) == 1


def test_a_silent_robot_does_not_relay(play, events_of, talk):
    recording, _ = play(
        lambda: talk(0, 3),
        [Receive(5.0), END],
        [Receive(5.0), END],
        starts=[(1.0, 3.0), (4.0, 1.0), (7.0, 3.0)],
        radio=RadioSpec(range_m=3.8),
        faults=[Silence(robot=1, time_s=1.0, duration_s=1.0)],
    )
    assert [event.reached for event in events_of(recording, Sent)] == [(1, 2), (), (1, 2)]


# Late starts ---------------------------------------------------------------------------------


def test_a_late_robot_stands_at_its_start_from_the_beginning(play, straight, events_of):
    recording, told = play(
        [Look(), straight(1, 3, 9, 3, guard_m=0.5), Receive(10.0), END],
        [Sense(), straight(5, 3, 5, 5), END],
        starts=[(1.0, 3.0), (5.0, 3.0)],
        faults=[LateStart(robot=1, time_s=10.0)],
    )
    assert [sighting.robot for sighting in told[0][0]] == [1]
    assert told[0][1].blocked_by.robot == 1
    assert told[0][1].configuration.x == pytest.approx(4.0, abs=1e-3)
    assert events_of(recording, Joined) == [Joined(time_s=10.0, robot=1)]
    assert told[1][0].time_s == 10.0
    assert [motion.time_s for motion in events_of(recording, Motion, 1)] == [10.0]
    assert recording.footer.outcome == "complete"


def test_a_late_robot_hears_nothing_before(play, word, events_of, talk):
    recording, told = play(
        [Receive(30.0), END],
        lambda: talk(1, 6),
        faults=[LateStart(robot=0, time_s=3.0)],
    )
    assert [event.reached for event in events_of(recording, Sent)] == [(), (), (), (0,), (0,), (0,)]
    assert told[0][0] == Received((word(sender=1, text="3"),), 3.5)


def test_the_run_waits_for_a_late_robot(play, straight):
    recording, _ = play(
        [END], [straight(1, 3, 2, 3), END], faults=[LateStart(robot=1, time_s=100.0)]
    )
    assert recording.footer.time_s == 102.0
    assert recording.footer.outcome == "complete"


def test_a_robot_that_dies_before_its_late_start_never_begins(play, straight, events_of):
    recording, told = play(
        [END],
        [straight(1, 3, 2, 3), END],
        faults=[LateStart(robot=1, time_s=100.0), Death(robot=1, time_s=50.0)],
    )
    assert events_of(recording, Joined) == []
    assert told[1] == []
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s == 50.0


def test_one_that_joins_within_a_silence_is_silent_on_record(play, word, events_of, talk):
    recording, told = play(
        [Receive(10.0), END],
        lambda: talk(1, 6),
        faults=[LateStart(robot=0, time_s=2.0), Silence(robot=0, time_s=1.0, duration_s=3.0)],
    )
    assert told[0][0] == Received((word(sender=1, text="4"),), 4.5)
    assert [event.time_s for event in events_of(recording, CameBack)] == [4.0]
    assert [event.time_s for event in events_of(recording, FellSilent)] == [2.0]


def test_a_silence_over_before_a_late_start_is_not_recorded(play, events_of, talk):
    recording, _ = play(
        [Receive(10.0), END],
        lambda: talk(1, 6),
        faults=[LateStart(robot=0, time_s=4.0), Silence(robot=0, time_s=1.0, duration_s=2.0)],
    )
    assert events_of(recording, FellSilent) == events_of(recording, CameBack) == []
