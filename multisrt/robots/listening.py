"""How a robot listens while time passes, and how robots fill each other's gaps.

What all strategies have in common that share nodes by messages: each message that says how much
its sender has lets the others ask for what they lack, and answer who asks.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Generator
from typing import ClassVar, Protocol

from multisrt.events import Learned
from multisrt.robots.explorer import (
    Action,
    Moved,
    Note,
    Outcome,
    Receive,
    Received,
    RobotSelf,
    Send,
    TimedOut,
)
from multisrt.robots.knowledge import (
    Counts,
    Entries,
    EntriesMessage,
    Entry,
    Have,
    NodeId,
    WantMessage,
)
from multisrt.robots.messages import Message

Talk = Generator[Action, Outcome, None]
Heard = Generator[Action, Outcome, Moved | None]


class Clocked(Protocol):
    """A robot that knows what time it is."""

    time_s: float


class Listener(ABC):
    """One robot's ear: it takes in what comes while time passes, and answers.

    Parameters
    ----------
    robot : Clocked
        Whose; its clock is set by what is heard.
    me : RobotSelf
        What that robot knows of itself.
    entries : Entries
        What it knows of the world.
    ask_period_s : float
        After how long it asks again; a message's way there and back comes on top.

    Attributes
    ----------
    number, size : int
        The robot's number, and how many robots the team has.
    round_trip_s, period_s : float
        How long an answer takes at least, and after how long it is asked for again.
    """

    ends_pauses_on_time: ClassVar[bool]
    """Whether a pause is over at its end also where something was heard at that very moment; else
    it goes on until nothing more comes."""

    def __init__(
        self, robot: Clocked, me: RobotSelf, entries: Entries, ask_period_s: float
    ) -> None:
        self.number = me.robot
        self.size = me.team
        self.round_trip_s = 2.0 * me.radio.latency_s
        self.period_s = ask_period_s + self.round_trip_s
        self._clock = robot
        self._entries = entries
        self._wanted: dict[int, float] = {}

    @property
    def is_alone(self) -> bool:
        """Whether the team is this robot."""
        return self.size == 1

    def hear(self, timeout_s: float | None = 0.0) -> Heard:
        """Receive until a motion ends, something was heard, or time is up; answer questions.

        Returns
        -------
        Moved or None
            The end of the motion that went on.
        """
        outcome = yield Receive(timeout_s)
        return (yield from self.take(outcome))

    def take(self, outcome: Outcome) -> Heard:
        """Take in what came, and answer."""
        if isinstance(outcome, Received):
            self._clock.time_s = outcome.time_s
            for message in outcome.messages:
                yield from self._take_message(message)
            return None
        if isinstance(outcome, Moved):
            return outcome
        assert isinstance(outcome, TimedOut)
        self._clock.time_s = outcome.time_s
        return None

    def pause(self, seconds: float) -> Talk:
        """Let time pass, and listen meanwhile; no time: until all has come that comes now."""
        until = self._clock.time_s + seconds
        on_time = self.ends_pauses_on_time and seconds > 0.0
        while True:
            outcome = yield Receive(max(0.0, until - self._clock.time_s))
            yield from self.take(outcome)
            if isinstance(outcome, TimedOut) or (on_time and self._clock.time_s >= until):
                return

    def learn(self, entries: tuple[Entry, ...]) -> Talk:
        """Take in what others know."""
        new = self._merge(entries)
        if new:
            yield Note(Learned(time_s=self._clock.time_s, robot=self.number, nodes=new))

    @abstractmethod
    def _merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        # Take in entries; give the nodes that were new.
        ...

    @abstractmethod
    def _take_message(self, message: Message) -> Talk:
        # Take in one message, and answer.
        ...

    def _answer_want(self, message: WantMessage) -> Talk:
        entries = self._entries.lacks(have_of(message.have))
        if entries:
            yield Send(EntriesMessage(sender=self.number, entries=entries), message.sender)

    def _ask_for_what_lacks(self, other: int, theirs: Counts) -> Talk:
        mine = self._entries.have()
        for robot, nodes, closings in theirs:
            known = mine.get(robot, (0, 0))
            if nodes > known[0] or closings > known[1]:
                if self._clock.time_s >= self._wanted.get(robot, -math.inf) + self.period_s:
                    self._wanted[robot] = self._clock.time_s
                    have = self._entries.counts()
                    yield Send(WantMessage(sender=self.number, have=have), other)
                return


def have_of(counts: Counts) -> Have:
    """Read what a message says of how much its sender has."""
    return {robot: (nodes, closings) for robot, nodes, closings in counts}
