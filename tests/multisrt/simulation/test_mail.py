"""Messages: latency, losses, relays, and the order in which they arrive."""

import pytest

from multisrt.analysis.measuring import measure
from multisrt.events import Ended, Sent
from multisrt.robots.explorer import Done, Receive, Received, Send, TimedOut
from multisrt.spec import RadioSpec

END = Done(complete=True, reason="enough")
TWO = [(1.0, 1.0), (1.0, 5.0)]
THREE = [(1.0, 1.0), (5.0, 1.0), (9.0, 1.0)]


def texts(outcome) -> list[str]:
    return [message.text for message in outcome.messages]


def test_a_message_arrives_after_its_latency(play, word):
    _, (_, told) = play(
        [Send(word(sender=0, text="hello")), END],
        [Receive(), END],
        starts=TWO,
        radio=RadioSpec(latency_s=0.75),
    )
    assert told[0] == Received((word(sender=0, text="hello"),), 0.75)


def test_jitter_is_drawn_for_each_receiver(play, word):
    times = []
    for seed in (0, 0, 1):
        _, told = play(
            [Send(word(sender=0)), END],
            [Receive(), END],
            [Receive(), END],
            starts=THREE,
            radio=RadioSpec(latency_s=0.5, jitter_s=2.0),
            seed=seed,
        )
        times.append([told[robot][0].time_s for robot in (1, 2)])
    assert times[0] == times[1] != times[2]
    assert all(0.5 <= time <= 2.5 for pair in times for time in pair)
    assert times[0][0] != times[0][1]


def test_jitter_can_reorder_messages(play, word):
    words = [word(sender=0, text=str(k)) for k in range(20)]

    def hear():
        heard: list[str] = []
        while len(heard) < 20:
            heard += texts((yield Receive()))
        assert sorted(heard) == sorted(word.text for word in words)
        assert heard != [word.text for word in words]
        yield END

    recording, _ = play([*map(Send, words), END], hear, starts=TWO, radio=RadioSpec(jitter_s=1.0))
    assert recording.footer.outcome == "complete"


def test_lost_messages_are_recorded_and_not_delivered(play, word, events_of):
    def hear():
        heard = 0
        while isinstance(received := (yield Receive(5.0)), Received):
            heard += len(received.messages)
        yield Done(complete=True, reason=str(heard))

    recording, _ = play(
        [*[Send(word(sender=0)) for _ in range(400)], END],
        hear,
        hear,
        starts=THREE,
        radio=RadioSpec(loss=0.3),
    )
    sent = events_of(recording, Sent)
    assert len(sent) == 400
    assert all(sorted(event.reached + event.lost) == [1, 2] for event in sent)
    for robot in (1, 2):
        came = sum(robot in event.reached for event in sent)
        # 280 are expected, with a standard deviation of 9.2.
        assert 240 < came < 320
        assert events_of(recording, Ended, robot)[0].reason == str(came)


@pytest.mark.parametrize(("multi_hop", "reached"), [(True, (1, 2)), (False, (1,))])
def test_robots_in_between_relay(play, word, events_of, multi_hop, reached):
    recording, told = play(
        [Send(word(sender=0)), END],
        [Receive(1.0), END],
        [Receive(1.0), END],
        starts=THREE,
        radio=RadioSpec(range_m=5.0, multi_hop=multi_hop),
    )
    assert events_of(recording, Sent)[0].reached == reached
    for robot in (1, 2):
        assert isinstance(told[robot][0], Received if robot in reached else TimedOut)


def test_the_position_at_the_time_of_sending_counts(play, word, straight, events_of):
    # Robot 1 comes into range (2 m) after 4 s, of a path of 3 m at 0.5 m/s.
    def caller():
        for _ in range(7):
            yield Send(word(sender=0), 1)
            yield Receive(1.0)
        yield END

    recording, _ = play(
        caller,
        [straight(5, 1, 2, 1), END],
        starts=THREE[:2],
        radio=RadioSpec(range_m=2.0 + 1e-9),
    )
    reached = [event.time_s for event in events_of(recording, Sent) if event.reached]
    assert reached == [4.0, 5.0, 6.0]


def test_a_message_to_one_robot_reaches_it_alone(play, word, events_of):
    recording, told = play(
        [Send(word(sender=0), 2), Send(word(sender=0), 1), Send(word(sender=0), 2), END],
        [Receive(1.0), Receive(1.0), END],
        [Receive(1.0), Receive(1.0), END],
        starts=THREE,
    )
    assert [event.reached for event in events_of(recording, Sent)] == [(2,), (1,), (2,)]
    assert [len(told[robot][0].messages) for robot in (1, 2)] == [1, 2]
    assert all(isinstance(told[robot][1], TimedOut) for robot in (1, 2))


def test_messages_sent_at_one_time_arrive_in_order(play, word):
    def sender(robot):
        yield Send(word(sender=robot, text=f"{robot}a"))
        yield Send(word(sender=robot, text=f"{robot}b"))
        yield END

    for latency in (0.0, 1.0):
        _, told = play(
            lambda: sender(0),
            lambda: sender(1),
            [Receive(latency + 1.0), END],
            starts=THREE,
            radio=RadioSpec(latency_s=latency),
        )
        first = told[2][0]
        assert texts(first)[0] == "0a"
        assert first.time_s == latency


def test_receive_returns_all_messages_of_that_time(play, word, straight):
    # Robot 2 acts before; at 1 s all messages have arrived.
    def talk(robot):
        yield Receive(1.0)
        yield Send(word(sender=robot, text=f"{robot}a"), 2)
        yield Send(word(sender=robot, text=f"{robot}b"), 2)
        yield END

    _, told = play(
        lambda: talk(0), lambda: talk(1), [straight(9, 1, 9, 2), Receive(0), END], starts=THREE
    )
    assert texts(told[2][1]) == ["0a", "0b", "1a", "1b"]


def test_a_timeout_of_zero_waits_for_all_messages_of_that_time(play, word):
    # Robot 0 acts first; it still receives what robot 1 sends at the same time, and the answer
    # to its answer.
    def first():
        for text in ("", "one", "two"):
            if text:
                yield Send(word(sender=0, text=text))
            received = yield Receive(0)
            assert isinstance(received, Received)
            assert received.time_s == 0.0
        assert (yield Receive(0)) == TimedOut(0.0)
        yield END

    def second():
        yield Send(word(sender=1, text="zero"))
        for _ in range(2):
            received = yield Receive()
            yield Send(word(sender=1, text=texts(received)[0] + " too"))
        yield END

    recording, told = play(first, second, starts=TWO)
    heard = [texts(outcome) for outcome in told[0] if isinstance(outcome, Received)]
    assert heard == [["zero"], ["one too"], ["two too"]]
    assert recording.footer.time_s == 0.0


def test_a_message_precedes_a_timeout_at_the_same_time(play, word):
    late, punctual, early = (
        play(
            [Send(word(sender=0)), END],
            [Receive(timeout), END],
            starts=TWO,
            radio=RadioSpec(latency_s=2.0),
        )[1][1][0]
        for timeout in (1.5, 2.0, 3.0)
    )
    assert late == TimedOut(1.5)
    assert punctual == early == Received((word(sender=0),), 2.0)


def test_a_message_that_arrived_earlier_is_received_at_once(play, word, straight):
    _, told = play(
        [Send(word(sender=0, text="a")), Receive(1.0), Send(word(sender=0, text="b")), END],
        [straight(1, 5, 3, 5), Receive(), Receive(3.0), END],
        starts=TWO,
    )
    assert told[1][1] == Received((word(sender=0, text="a"), word(sender=0, text="b")), 4.0)
    assert told[1][2] == TimedOut(7.0)


def test_messages_are_counted_with_their_sizes(play, hall, word, call, events_of):
    short, long = word(sender=0, text="a"), call(sender=0, text="a" * 1000)
    recording, _ = play([Send(short), Send(long, 2), END], [END], [END], starts=THREE)
    sent = events_of(recording, Sent)
    assert [(e.kind, e.size_bytes, e.reached) for e in sent] == [
        ("word", short.size_bytes, (1, 2)),
        ("call", long.size_bytes, (2,)),
    ]
    assert 1000 < long.size_bytes < 1050
    assert short.size_bytes < 40
    metrics = measure(recording, hall)
    assert metrics.messages == 2
    assert metrics.bytes_sent == short.size_bytes + long.size_bytes
    assert metrics.messages_by_kind == {"word": 1, "call": 1}
