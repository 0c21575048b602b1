from typing import cast

import msgspec
import numpy as np
import pytest

import multisrt as ms
from multisrt.events import Sent
from multisrt.planners.motion.steering import turn_and_drive
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.explorer import Done, Move, Moved, Receive, Received, Send
from multisrt.robots.frontier.messages import GiveWayMessage, ReportMessage
from multisrt.robots.messages import Message
from multisrt.robots.registry import registered


class MapPart(Message, frozen=True):
    places: np.ndarray
    names: tuple[str, ...] = ()


class WakeUpMessage(Message, frozen=True):
    wakes = True


def test_a_kind_is_made_of_the_name_of_the_class():
    class Named(MapPart, frozen=True):
        kind = "other"

    class Derived(Named, frozen=True):
        pass

    assert MapPart.kind == "map part"
    assert WakeUpMessage.kind == "wake up"
    assert (Named.kind, Derived.kind, Message.kind) == ("other", "other", "message")
    assert (ReportMessage.kind, GiveWayMessage.kind) == ("report", "give way")


def test_arrays_are_copied_and_cannot_be_written():
    places = np.zeros((2, 2))
    message = MapPart(places, sender=0)
    places[0] = 7.0
    assert message.places.sum() == 0.0
    with pytest.raises(ValueError, match="read-only"):
        message.places[0] = 1.0
    with pytest.raises(AttributeError):
        message.names = ("a",)  # type: ignore[misc]
    kept = MapPart(message.places, sender=1)
    assert kept.places is message.places


def test_its_size_is_that_of_its_encoding():
    few, many = (MapPart(np.zeros((n, 2)), sender=0).size_bytes for n in (0, 5))
    assert many == few + 5 * 2 * 8
    assert msgspec.msgpack.encode({"sender": 0}) == b"\x81\xa6sender\x00"
    assert WakeUpMessage(sender=0).size_bytes == 9


class Options(msgspec.Struct, frozen=True):
    pass


class Talker:
    """Robot 0 drives and listens; robot 1 sends it what it is given."""

    def __init__(self, me, message):
        self.me, self.message, self.heard = me, message, []

    def run(self):
        if self.me.robot == 1:
            yield Receive(timeout_s=0.5)
            yield Send(self.message, to=0)
            yield Done(complete=False, reason="has said it")
            return
        motion = turn_and_drive(self.me.kinematics, self.me.start, 5.0, 5.0)
        told = yield Move(trajectory=motion, listen=True)
        if isinstance(told, Received):
            reason = f"was woken at {told.time_s}: {told.messages[0].kind}"
            while not isinstance(told, Moved):
                told = yield Receive()
        else:
            told = yield Receive(timeout_s=0.0)
            reason = f"heard then: {told.messages[0].kind}"
        yield Done(complete=False, reason=reason)


def talk(message):
    strategy = ms.Strategy(
        name="talker",
        summary="Talks",
        options=Options,
        explorer=lambda me, options: Talker(me, message),
    )
    with registered(strategy):
        return ms.explore("open", strategy="talker", robots=2, starts=[(5.0, 4.0), (7.0, 6.0)])


def test_messages_of_ones_own_go_through_the_radio():
    run = talk(MapPart(np.zeros((3, 2)), sender=1))
    [sent] = run.recording.of(Sent)
    assert (sent.kind, sent.reached) == ("map part", (0,))
    assert sent.size_bytes == MapPart(np.zeros((3, 2)), sender=1).size_bytes
    assert run.metrics.messages_by_kind == {"map part": 1}


@pytest.mark.parametrize(
    ("message", "told"),
    [
        (MapPart(np.zeros((3, 2)), sender=1), "heard then: map part"),
        (WakeUpMessage(sender=1), "was woken at 0.5: wake up"),
    ],
)
def test_a_message_that_wakes_reaches_a_robot_that_moves(message, told):
    run = talk(message)
    reasons = [e.reason for e in run.recording.events if type(e).__name__ == "Ended"]
    assert told in reasons


def test_what_cannot_be_encoded_is_named_with_its_place():
    with pytest.raises(ExplorerDefect) as defect:
        talk(MapPart(np.zeros(2), names=("a", cast(str, object())), sender=1))
    assert "MapPart.names[1] is <object>" in str(defect.value)
    assert "messages hold numbers, text, tuples" in str(defect.value)
