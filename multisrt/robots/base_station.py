"""A base station: it collects what robots report, and tells them what it knows.

It is reactive: it takes messages, answers them, and has no timer.
"""

from __future__ import annotations

from typing import Final

from multisrt.events import BaseLearned
from multisrt.robots.explorer import Done, Note, Send, Steps
from multisrt.robots.knowledge import (
    AcknowledgementMessage,
    Closing,
    Counts,
    Entries,
    Entry,
    EntryKey,
    NodeId,
    WantMessage,
)
from multisrt.robots.listening import Listener
from multisrt.robots.message_contents import counts_in, entries_in
from multisrt.robots.messages import Message
from multisrt.robots.robot_self import BaseSelf

ASK_PERIOD_S: Final = 0.5
"""Time after which a question is repeated, in seconds, besides the round trip: that of robots with
their default options."""


class BaseStation(Listener):
    """The explorer of a base station, which explores nothing.

    It merges the nodes and closings of every message that reaches it, whatever its kind. Where a
    message tells that its sender has more, it asks for the rest. It acknowledges what it has
    learned: a robot is told what the base station has when it reports, unless it was told the same
    before, and whenever it asks (`WantMessage`).

    Parameters
    ----------
    me : BaseSelf
        What the base station knows of itself.

    Attributes
    ----------
    entries : Entries
        What it has learned.
    time_s : float
        The time of the last message.

    Examples
    --------
    >>> from multisrt.robots.explorer import Received
    >>> class Report(Message):
    ...     have: Counts
    >>> steps = BaseStation(BaseSelf(team=1, base=(0.0, 0.0))).run()
    >>> next(steps).on_call
    True
    >>> steps.send(Received((Report(((0, 2, 0),), sender=0),), time_s=3.0))
    Send(message=WantMessage(sender=1, have=()), to=0)
    """

    ends_pauses_on_time = True

    def __init__(self, me: BaseSelf) -> None:
        self.entries = Entries()
        self.time_s = 0.0
        super().__init__(self, me, self.entries, ASK_PERIOD_S)
        self._told: dict[int, tuple[Counts, tuple[EntryKey, ...]]] = {}

    def run(self) -> Steps:
        """Take messages, one after another, for as long as the run goes on."""
        while True:
            outcome = yield Done(complete=True, reason="it is a base station", on_call=True)
            yield from self.take(outcome)

    def _merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        new = []
        for entry in entries:
            if isinstance(entry, Closing):
                self.entries.add_closing(entry)
            elif self.entries.add_node(entry):
                new.append(entry.id)
        return tuple(new)

    def _take_message(self, message: Message) -> Steps:
        sender = message.sender
        entries = entries_in(message)
        new = self._merge(entries)
        if new:
            yield Note(BaseLearned(time_s=self.time_s, robot=sender, nodes=new))
        yield from self._take_as_answer(entries)
        if isinstance(message, WantMessage):
            yield from self._answer_want(message)
            yield from self._acknowledge(sender)
            return
        has_asked = yield from self._ask_for_missing(sender, counts_in(message))
        has_news = self._told.get(sender, ((), ())) != self._known()
        if not has_asked and has_news:
            yield from self._acknowledge(sender)

    def _acknowledge(self, robot: int) -> Steps:
        have, beyond = self._told[robot] = self._known()
        yield Send(AcknowledgementMessage(sender=self.number, have=have, beyond=beyond), robot)

    def _known(self) -> tuple[Counts, tuple[EntryKey, ...]]:
        return self.entries.counts(), self.entries.beyond()
