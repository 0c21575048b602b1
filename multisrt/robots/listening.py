"""Listening while time passes, and exchanging the nodes that one robot has and another lacks.

All strategies whose robots share nodes by messages have this in common. Some messages say how many
entries of the map their sender has; a robot that lacks some of them asks for these, and gets them.
So does a base station, which acknowledges what it has learned.
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
    RadioSelf,
    Receive,
    Received,
    Send,
    Steps,
    TimedOut,
)
from multisrt.robots.knowledge import (
    AcknowledgementMessage,
    Counts,
    CountsByRobot,
    Entries,
    EntriesMessage,
    Entry,
    EntryKey,
    NodeId,
    WantMessage,
    key_of,
)
from multisrt.robots.messages import Message
from multisrt.robots.robot_self import RadioMember

Heard = Generator[Action, Outcome, Moved | None]


class Clocked(Protocol):
    """Something that keeps the time."""

    time_s: float


class Listener(ABC):
    """Receives messages for one robot, and answers them.

    Parameters
    ----------
    robot : Clocked
        The clock, which is set to the time of every outcome.
    me : RadioMember
        What the robot knows of itself.
    entries : Entries
        The entries of its map.
    ask_period_s : float
        Time after which a question is repeated, in seconds, besides the round trip.

    Attributes
    ----------
    number : int
        Number of the robot.
    size : int
        Number of robots in its team.
    base : int or None
        Number of the base station; None if there is none.
    base_has : mapping of int to (nodes, closings)
        What the base station had when it was last heard from, as `Entries.have` returns it.
    base_beyond : frozenset of EntryKey
        What it has told that it has besides, as `Entries.beyond` returns it.
    base_heard_s : float
        When the base station was last heard from, in seconds; ``-inf`` if never.
    round_trip_s : float
        Latency of a question and its answer in seconds.
    period_s : float
        Time after which a question is repeated, in seconds.
    """

    ends_pauses_on_time: ClassVar[bool]
    """Whether a pause ends on time even if something was heard at that very moment. If not, it goes
    on until nothing more comes."""

    def __init__(
        self, robot: Clocked, me: RadioMember, entries: Entries, ask_period_s: float
    ) -> None:
        self.number = me.robot
        self.size = me.team
        self.base = None if me.base is None else me.team
        self.base_has: CountsByRobot = {}
        self.base_beyond: frozenset[EntryKey] = frozenset()
        self.base_heard_s = -math.inf
        self.round_trip_s = 2.0 * me.radio.latency_s
        self.period_s = question_period_s(me.radio, ask_period_s)
        self._clock = robot
        self._entries = entries
        # By robot, when its entries were asked for without an answer yet, and what was heard of
        # more of them since: from whom, and how many entries it has.
        self._wanted: dict[int, float] = {}
        self._put_off: dict[int, tuple[int, Counts]] = {}

    @property
    def is_alone(self) -> bool:
        """Whether the team is this robot; a base station is no robot."""
        return self.size == 1

    @property
    def has_receivers(self) -> bool:
        """Whether there is anything to report to: other robots, or a base station."""
        return not self.is_alone or self.base is not None

    @property
    def carries(self) -> bool:
        """Whether there is a base station that lacks, as far as is known, what this robot knows."""
        if self.base is None:
            return False
        return self._entries.has_more_than(self.base_has, self.base_beyond)

    def carried(self) -> tuple[Entry, ...]:
        """Return what the base station lacks, as far as is known, of what this robot knows.

        Returns
        -------
        tuple of Node or Closing
            Ordered by robot, nodes first, by number; empty without a base station.
        """
        if self.base is None:
            return ()
        return self._entries.missing_from(self.base_has, self.base_beyond)

    def ask_base(self) -> Steps:
        """Ask the base station what it has, and send what it would not ask for; see `offer`."""
        if self.base is not None:
            have = self._entries.counts()
            yield Send(WantMessage(sender=self.number, have=have), self.base)
            yield from self.offer()

    def offer(self) -> Steps:
        """Send the base station what it lacks beyond gaps in the numbers known here.

        It does not ask for that: how many entries are known without a gap does not tell of it.
        """
        if self.base is None:
            return
        beyond = frozenset(self._entries.beyond())
        entries = tuple(e for e in self.carried() if key_of(e) in beyond) if beyond else ()
        if entries:
            yield Send(EntriesMessage(sender=self.number, entries=entries), self.base)

    def hear(self, timeout_s: float | None = 0.0) -> Heard:
        """Receive until the motion ends, something is heard, or time is up; answer questions.

        Parameters
        ----------
        timeout_s : float or None
            Time in seconds; None: no limit.

        Returns
        -------
        Moved or None
            The end of the motion in progress; None if it has not ended.
        """
        outcome = yield Receive(timeout_s)
        return (yield from self.take(outcome))

    def take(self, outcome: Outcome) -> Heard:
        """Take an outcome, and answer the messages in it; return it if a motion ended."""
        if isinstance(outcome, Received):
            self._clock.time_s = outcome.time_s
            for message in outcome.messages:
                if message.sender == self.base and self.number != self.base:
                    yield from self._take_from_base(message)
                else:
                    yield from self._take_message(message)
            return None
        if isinstance(outcome, Moved):
            return outcome
        assert isinstance(outcome, TimedOut)
        self._clock.time_s = outcome.time_s
        return None

    def pause(self, seconds: float) -> Steps:
        """Let time pass, listening.

        Parameters
        ----------
        seconds : float
            How long; 0: until nothing more comes at this moment.
        """
        until = self._clock.time_s + seconds
        on_time = self.ends_pauses_on_time and seconds > 0.0
        while True:
            outcome = yield Receive(max(0.0, until - self._clock.time_s))
            yield from self.take(outcome)
            if isinstance(outcome, TimedOut) or (on_time and self._clock.time_s >= until):
                return

    def learn(self, entries: tuple[Entry, ...]) -> Steps:
        """Add entries of others to the map, and record which nodes were new."""
        new = self._merge(entries)
        if new:
            yield Note(Learned(time_s=self._clock.time_s, robot=self.number, nodes=new))
        yield from self._take_as_answer(entries)

    def _take_as_answer(self, entries: tuple[Entry, ...]) -> Steps:
        """Take entries as answers to the questions for those of their robots.

        Whatever was heard of meanwhile is asked for now.
        """
        for robot in sorted({entry.id.robot for entry in entries}):
            self._wanted.pop(robot, None)
            put_off = self._put_off.pop(robot, None)
            if put_off is not None:
                yield from self._ask_for_missing(*put_off)

    def ask_again(self) -> Generator[Action, Outcome, bool]:
        """Wait until unanswered questions expire, and ask for what was reported meanwhile.

        Call it before resting, as no other report may come.

        Returns
        -------
        bool
            Whether anything had been reported meanwhile.
        """
        has_waited = False
        while self._put_off:
            has_waited = True
            robot = min(self._put_off, key=lambda robot: (self._wanted[robot], robot))
            over_s = self._wanted[robot] + self.period_s
            yield from self.pause(max(0.0, over_s - self._clock.time_s))
            put_off = self._put_off.pop(robot, None)
            if put_off is not None:
                del self._wanted[robot]
                yield from self._ask_for_missing(*put_off)
        return has_waited

    @abstractmethod
    def _merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        """Add entries to the map; return the nodes that were new."""

    @abstractmethod
    def _take_message(self, message: Message) -> Steps:
        """Take one message, and answer it."""

    def _take_from_base(self, message: Message) -> Steps:
        """Take a message of the base station, which is none of the robots."""
        self.base_heard_s = self._clock.time_s
        match message:
            case WantMessage():
                yield from self._answer_want(message)
            case EntriesMessage():
                yield from self.learn(message.entries)
            case AcknowledgementMessage():
                self.base_has = most_of(self.base_has, have_of(message.have))
                self.base_beyond |= frozenset(message.beyond)

    def _answer_want(self, message: WantMessage) -> Steps:
        """Send the entries that the sender of a question lacks."""
        entries = self._entries.missing_from(have_of(message.have))
        if entries:
            yield Send(EntriesMessage(sender=self.number, entries=entries), message.sender)

    def _ask_for_missing(self, other: int, theirs: Counts) -> Generator[Action, Outcome, bool]:
        """Ask another robot for the entries that it has and this one lacks.

        Not if a question for them is under way, that is, for the time in which it is not repeated.

        Returns
        -------
        bool
            Whether it was asked.
        """
        robot = first_beyond(theirs, self._entries.have())
        if robot is None:
            return False
        if self._clock.time_s < self._wanted.get(robot, -math.inf) + self.period_s:
            self._put_off[robot] = other, theirs
            return False
        self._wanted[robot] = self._clock.time_s
        yield Send(WantMessage(sender=self.number, have=self._entries.counts()), other)
        return True


def question_period_s(radio: RadioSelf, ask_period_s: float) -> float:
    """Return the time after which a question is repeated, the round trip included, in seconds.

    Examples
    --------
    >>> question_period_s(RadioSelf(latency_s=0.25), 0.5)
    1.0
    """
    return ask_period_s + 2.0 * radio.latency_s


def have_of(counts: Counts) -> CountsByRobot:
    """Return the counts in a message as a dictionary from robots to (nodes, closings).

    Examples
    --------
    >>> have_of(((0, 7, 1), (2, 3, 0)))
    {0: (7, 1), 2: (3, 0)}
    """
    return {robot: (nodes, closings) for robot, nodes, closings in counts}


def first_beyond(theirs: Counts, mine: CountsByRobot) -> int | None:
    """Return the first robot of which others know more nodes or closings; None for none.

    Examples
    --------
    >>> first_beyond(((0, 7, 1), (2, 3, 0)), {0: (8, 1)})
    2
    """
    for robot, nodes, closings in theirs:
        known = mine.get(robot, (0, 0))
        if nodes > known[0] or closings > known[1]:
            return robot
    return None


def counts_beyond(theirs: Counts, mine: CountsByRobot) -> bool:
    """Whether others know more nodes or closings of any robot.

    Examples
    --------
    >>> counts_beyond(((0, 7, 1),), {0: (7, 1)}), counts_beyond(((0, 7, 1),), {})
    (False, True)
    """
    return first_beyond(theirs, mine) is not None


def most_of(one: CountsByRobot, other: CountsByRobot) -> CountsByRobot:
    """Return the larger of two counts for every robot: counts never fall, messages may overtake.

    Examples
    --------
    >>> most_of({0: (7, 1)}, {0: (5, 2), 2: (3, 0)})
    {0: (7, 2), 2: (3, 0)}
    """
    most = dict(one)
    for robot, (nodes, closings) in other.items():
        known = most.get(robot, (0, 0))
        most[robot] = max(nodes, known[0]), max(closings, known[1])
    return most
