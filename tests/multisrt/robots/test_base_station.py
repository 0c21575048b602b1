"""A base station by hand: what it merges, asks and acknowledges; and what robots keep of it."""

import numpy as np
import pytest

from multisrt.events import BaseLearned
from multisrt.robots.base_station import BaseStation
from multisrt.robots.explorer import Done, Note, RadioSelf, Received, Send
from multisrt.robots.frontier.messages import ReportMessage, RobotReport
from multisrt.robots.knowledge import (
    AcknowledgementMessage,
    Closing,
    ClosingId,
    Counts,
    Entries,
    EntriesMessage,
    EntryKey,
    Node,
    NodeId,
    WantMessage,
)
from multisrt.robots.listening import Listener, most_of
from multisrt.robots.message_contents import counts_in, entries_in
from multisrt.robots.messages import Message
from multisrt.robots.robot_self import BaseSelf

BASE = 2


@pytest.fixture
def station():
    """A base station of two robots that waits, as a function from a message to its actions."""
    made = BaseStation(BaseSelf(team=BASE, base=(0.0, 0.0)))
    steps = made.run()
    assert isinstance(next(steps), Done)

    def take(message: Message, time_s: float = 0.0) -> list:
        actions: list = []
        outcome: Received | None = Received((message,), time_s)
        while not isinstance(action := steps.send(outcome), Done):
            actions.append(action)
            outcome = None
        assert action.on_call
        return actions

    take.entries = made.entries  # type: ignore[attr-defined]
    return take


def report(*nodes: Node, have: Counts, sender: int = 0) -> ReportMessage:
    own = RobotReport(
        robot=sender, said=0, time_s=0.0, phase="driving", place=(0.0, 0.0, 0.0), goal=None,
        remaining_m=0.0, path=(), footprint="disc:0.25", have=have,
    )  # fmt: skip
    return ReportMessage(sender=sender, reports=(own,), entries=nodes)


def closing(number: int) -> Closing:
    arc = np.array([[0.0, 0.0, 0.0, 0.2]])
    return Closing(
        id=ClosingId(0, number), node=NodeId(0, 0), arc=arc, reason="too narrow", width_m=0.5
    )


@pytest.fixture
def nodes(rectangle_node):
    """Nodes 0 to 3 of robot 0."""
    return [rectangle_node(k, 0, 0, 2, 2, "right") for k in range(4)]


def acknowledged(have: Counts, to: int = 0, beyond: tuple[EntryKey, ...] = ()) -> Send:
    return Send(AcknowledgementMessage(sender=BASE, have=have, beyond=beyond), to)


def learned(*serials: int, by: int = 0, at_s: float = 0.0) -> Note:
    names = tuple(NodeId(0, serial) for serial in serials)
    return Note(BaseLearned(time_s=at_s, robot=by, nodes=names))


def test_it_learns_and_acknowledges_once(station, nodes):
    first = report(*nodes[:2], have=((0, 2, 0),))
    assert station(first, 3.0) == [learned(0, 1, at_s=3.0), acknowledged(((0, 2, 0),))]
    assert station(first, 4.0) == []


def test_it_asks_for_what_it_lacks_and_then_acknowledges(station, nodes):
    want = Send(WantMessage(sender=BASE, have=()), 0)
    assert station(report(have=((0, 3, 1),)), 1.0) == [want]
    # Within the period it does not ask again, and has nothing to tell.
    assert station(report(have=((0, 3, 1),)), 1.2) == []
    assert station(report(have=((0, 3, 1),)), 1.6) == [want]
    answer = EntriesMessage(sender=0, entries=(*nodes[:3], closing(0)))
    assert station(answer, 1.7) == [learned(0, 1, 2, at_s=1.7), acknowledged(((0, 3, 1),))]


def test_it_asks_with_an_answer_for_what_it_heard_of_meanwhile(station, nodes):
    want = Send(WantMessage(sender=BASE, have=()), 0)
    assert station(report(have=((0, 2, 0),)), 1.0) == [want]
    # Robot 1 knows more, but the question is under way.
    assert station(report(have=((0, 3, 0),), sender=1), 1.1) == []
    answer = EntriesMessage(sender=0, entries=tuple(nodes[:2]))
    rest = Send(WantMessage(sender=BASE, have=((0, 2, 0),)), 1)
    assert station(answer, 1.2) == [learned(0, 1, at_s=1.2), rest, acknowledged(((0, 2, 0),))]


def test_a_node_beyond_a_gap_is_learned_and_the_gap_asked_for(station, nodes):
    late = report(nodes[3], have=((0, 4, 0),))
    assert station(late) == [learned(3), Send(WantMessage(sender=BASE, have=((0, 0, 0),)), 0)]


def test_what_lies_beyond_a_gap_that_nobody_can_fill_is_acknowledged(station, nodes):
    # Node 1 was lost with robot 0: robot 1 does not have it either.
    have = ((0, 1, 0),)
    told = acknowledged(have, to=1, beyond=((0, 0, 2),))
    assert station(report(nodes[0], nodes[2], have=have, sender=1)) == [learned(0, 2, by=1), told]
    assert station(report(have=have, sender=1)) == []
    more = station(report(nodes[3], have=have, sender=1))
    assert more == [
        learned(3, by=1),
        acknowledged(have, to=1, beyond=((0, 0, 2), (0, 0, 3))),
    ]


def test_an_acknowledgement_without_gaps_is_as_small_as_its_counts():
    have = ((0, 1, 0),)
    plain = AcknowledgementMessage(sender=BASE, have=have)
    assert plain.size_bytes == WantMessage(sender=BASE, have=have).size_bytes
    beyond = AcknowledgementMessage(sender=BASE, have=have, beyond=((0, 0, 2),))
    assert beyond.size_bytes > plain.size_bytes


def test_each_robot_is_told_what_has_changed_since(station, nodes):
    station(report(*nodes[:2], have=((0, 2, 0),)))
    # Robot 1 knows less than the base, and is told; then there is nothing new to it.
    assert station(report(have=((0, 1, 0),), sender=1)) == [acknowledged(((0, 2, 0),), to=1)]
    assert station(report(have=((0, 1, 0),), sender=1)) == []


def test_a_robot_that_asks_gets_entries_and_counts(station, nodes):
    station(report(*nodes[:2], have=((0, 2, 0),)))
    answer = EntriesMessage(sender=BASE, entries=(nodes[1],))
    for _ in range(2):
        asked = station(WantMessage(sender=1, have=((0, 1, 0),)))
        assert [type(action.message) for action in asked] == [
            EntriesMessage,
            AcknowledgementMessage,
        ]
        assert asked[0].message == answer
    assert station(WantMessage(sender=1, have=((0, 2, 0),))) == [acknowledged(((0, 2, 0),), to=1)]


def test_an_acknowledgement_does_not_wake(nodes):
    assert not AcknowledgementMessage(sender=BASE, have=()).wakes


class Envelope(Message, frozen=True, kw_only=True):
    letters: tuple[object, ...]


class Odd(Message, frozen=True, kw_only=True):
    entries: tuple[str, ...] = ("left", "right")
    have: str = "all"


def test_nodes_in_messages_of_any_kind_are_delivered(station, nodes):
    envelope = Envelope(sender=1, letters=({"here": nodes[0]}, (closing(0), 3.0)))
    assert entries_in(envelope)[0] is nodes[0]
    first, told = station(envelope)
    assert first == learned(0, by=1)
    assert told == acknowledged(((0, 1, 1),), to=1)
    assert list(station.entries.closings) == [ClosingId(0, 0)]


def test_messages_with_fields_of_the_same_names_tell_nothing(station):
    assert entries_in(Odd(sender=0)) == ()
    assert counts_in(Odd(sender=0)) == ()
    assert station(Odd(sender=0)) == []


# What robots keep of it ------------------------------------------------------------------------


class Ears(Listener):
    ends_pauses_on_time = True

    def __init__(self, me):
        self.time_s = 0.0
        self.heard = []
        self.entries = Entries()
        super().__init__(self, me, self.entries, 0.5)

    def _merge(self, entries):
        return tuple(entry.id for entry in entries if self.entries.add_node(entry))

    def _take_message(self, message):
        self.heard.append(message)
        yield from ()


class Me:
    def __init__(self, robot=0, team=1, base=None):
        self.robot, self.team, self.base, self.radio = robot, team, base, RadioSelf()


@pytest.mark.parametrize(
    ("me", "is_alone", "has_receivers"),
    [
        (Me(), True, False),
        (Me(base=(1.0, 1.0)), True, True),
        (Me(team=2), False, True),
        (Me(team=2, base=(1.0, 1.0)), False, True),
    ],
)
def test_a_base_is_a_receiver_but_no_robot(me, is_alone, has_receivers):
    ears = Ears(me)
    assert (ears.is_alone, ears.has_receivers) == (is_alone, has_receivers)


def test_a_robot_knows_what_it_carries(nodes):
    ears = Ears(Me(base=(1.0, 1.0)))
    assert not ears.carries
    for node in nodes[:3]:
        ears.entries.add_node(node)
    assert ears.carries
    assert ears.carried() == tuple(nodes[:3])
    told = AcknowledgementMessage(sender=1, have=((0, 2, 0),))
    assert list(ears.take(Received((told,), 1.0))) == []
    assert ears.carried() == (nodes[2],)
    # One that was overtaken changes nothing, and none is for the strategy.
    older = AcknowledgementMessage(sender=1, have=((0, 1, 0),))
    assert list(ears.take(Received((older,), 2.0))) == []
    assert ears.carried() == (nodes[2],)
    assert ears.heard == []


def test_a_robot_does_not_carry_what_the_base_has_beyond_a_gap(nodes):
    ears = Ears(Me(base=(1.0, 1.0)))
    for node in (nodes[0], nodes[2], nodes[3]):
        ears.entries.add_node(node)
    # A closing of the same number is another entry.
    told = AcknowledgementMessage(sender=1, have=((0, 1, 0),), beyond=((0, 0, 2), (0, 1, 3)))
    assert list(ears.take(Received((told,), 1.0))) == []
    assert ears.carries
    assert ears.carried() == (nodes[3],)
    rest = AcknowledgementMessage(sender=1, have=((0, 1, 0),), beyond=((0, 0, 3),))
    assert list(ears.take(Received((rest,), 2.0))) == []
    assert not ears.carries
    assert ears.carried() == ()


def test_a_robot_offers_what_the_base_lacks_beyond_a_gap(nodes):
    ears = Ears(Me(base=(1.0, 1.0)))
    assert list(ears.offer()) == []
    ears.entries.add_node(nodes[0])
    ears.entries.add_node(nodes[2])
    # The base asks for what lies before the gap by itself.
    [offer] = ears.offer()
    assert isinstance(offer, Send)
    assert isinstance(offer.message, EntriesMessage)
    assert (offer.to, offer.message.entries) == (1, (nodes[2],))
    told = AcknowledgementMessage(sender=1, have=((0, 1, 0),), beyond=((0, 0, 2),))
    assert list(ears.take(Received((told,), 1.0))) == []
    assert list(ears.offer()) == []


def test_a_robot_answers_the_base(nodes):
    ears = Ears(Me(base=(1.0, 1.0)))
    for node in nodes[:2]:
        ears.entries.add_node(node)
    want = WantMessage(sender=1, have=((0, 1, 0),))
    [answer] = ears.take(Received((want,), 1.0))
    assert isinstance(answer, Send)
    assert isinstance(answer.message, EntriesMessage)
    assert (answer.to, answer.message.entries) == (1, (nodes[1],))


def test_without_a_base_nothing_is_carried(nodes):
    ears = Ears(Me(team=2))
    ears.entries.add_node(nodes[0])
    assert not ears.carries
    assert ears.carried() == ()
    # A message of a robot with the number that a base would have is for the strategy.
    word = AcknowledgementMessage(sender=2, have=())
    assert list(ears.take(Received((word,), 1.0))) == []
    assert ears.heard == [word]


def test_most_of_is_commutative_and_never_falls():
    one, other = {0: (7, 1), 1: (0, 4)}, {0: (5, 2), 2: (3, 0)}
    assert most_of(one, other) == {0: (7, 2), 1: (0, 4), 2: (3, 0)}
    assert most_of(one, other) == dict(sorted(most_of(other, one).items()))
