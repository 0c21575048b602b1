"""Each message arrives once, at its addressees only, at the time that the radio model defines."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Final

from multisrt.campaign.judged_run import ROUNDING_S, silences
from multisrt.campaign.violations import Violation
from multisrt.events import Sent
from multisrt.robots.explorer import Outcome, Receive, Received, TimedOut
from multisrt.robots.messages import Message
from multisrt.spec import RunSpec

NAME: Final = "messages-arrive"

MIN_DELAYS: Final = 5
"""Minimum number of observed delays for the jitter to be tested."""

MIN_SPREAD: Final = 1e-3
"""Minimum spread of these delays, as a share of the jitter. Five uniform delays are closer together
in one of 2e11 runs."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Letter:
    """A message on its way, and when it may arrive; that of the base station is not known."""

    sender: int
    kind: str
    message: Message | None
    sent_s: float
    first_s: float
    last_s: float

    @property
    def known_by(self) -> Hashable:
        return (self.sender, self.kind) if self.message is None else id(self.message)

    def is_of(self, message: Message) -> bool:
        if self.message is not None:
            return self.message is message
        return (self.sender, self.kind) == (message.sender, message.kind)

    def __str__(self) -> str:
        sender = "the base station" if self.message is None else f"robot {self.sender}"
        return f"the message of {sender} at {self.sent_s:.2f} s ({self.kind})"


class Arrivals:
    """Follows each message from the explorer that sends it to those that receive it.

    - A message to one robot reaches no other.
    - A message is received once, and not earlier than the latency after it was sent.
    - A robot that waits receives it at once: not later than latency and jitter after it was sent,
      or when the wait began. A robot that moves does, if the message wakes it.
    - Whoever receives something, or waits in vain, has then received all that has arrived.
    - What arrives while a radio is silent is not received. A message of which the same was sent to
      the robot when its radio may have been silent is not judged.
    - Delays vary if the radio has jitter.
    - Waits end when their explorers say, if nothing ends them before.

    All times to 1e-6 s. Of messages of the base station the kind identifies them.

    Parameters
    ----------
    spec : RunSpec
        The run.

    Attributes
    ----------
    last_s : float
        Time in seconds until which a message may be on its way.
    """

    def __init__(self, spec: RunSpec) -> None:
        self._base = len(spec.robots)
        self._radio = spec.radio
        self._silent_s = [silences(spec.faults, robot) for robot in range(self._base)]
        self._due: list[list[_Letter]] = [[] for _ in spec.robots]
        # For each robot what it may not have heard. Letters keep their messages alive: the identity
        # of a message that is gone may be that of a later one.
        self._doubtful: list[dict[Hashable, _Letter]] = [{} for _ in spec.robots]
        self._delays_s: list[float] = []
        self._found: Violation | None = None
        self.last_s = 0.0

    def sent(self, event: Sent, message: Message | None, to: int | None) -> None:
        """Take the recorded event of a message: whom it reaches.

        Parameters
        ----------
        event : Sent
            The event.
        message : Message or None
            The message; None if the base station sent it.
        to : int or None
            The robot that it is for; None for all.
        """
        for receiver in (*event.reached, *event.lost):
            if to is not None and receiver != to:
                says = f"a message ({event.kind}) for robot {to} reaches robot {receiver}"
                self._violated(says, event.robot, event.time_s)
        first_s = event.time_s + self._radio.latency_s
        letter = _Letter(
            sender=event.robot,
            kind=event.kind,
            message=message,
            sent_s=event.time_s,
            first_s=first_s,
            last_s=first_s + self._radio.jitter_s,
        )
        if event.reached:
            self.last_s = max(self.last_s, letter.last_s)
        for receiver in event.reached:
            if receiver == self._base:
                continue
            self._due[receiver].append(letter)
            if self._may_be_silent(receiver, letter):
                self._doubtful[receiver][letter.known_by] = letter

    def ended(
        self, robot: int, begin_s: float, outcome: Outcome, now_s: float, *, moves: bool
    ) -> None:
        """Judge what ended a wait.

        Parameters
        ----------
        robot : int
            The robot.
        begin_s, now_s : float
            When the wait began and when it ended, in seconds.
        outcome : Outcome
            What its explorer was sent.
        moves : bool
            Whether it is on its way meanwhile.
        """
        if isinstance(outcome, Received):
            for message in outcome.messages:
                self._received(robot, message, begin_s, now_s, moves=moves)
        if isinstance(outcome, Received | TimedOut):
            for letter in self._overdue(robot, now_s):
                self._violated(f"{letter} is not received by {now_s:.3f} s", robot, now_s)

    def timed(
        self, robot: int, begin_s: float, receive: Receive, outcome: Outcome, now_s: float
    ) -> None:
        """Judge whether a wait ended in time; parameters as for `ended`."""
        if receive.timeout_s is None:
            return
        end_s = begin_s + max(0.0, receive.timeout_s)
        is_early = isinstance(outcome, TimedOut) and now_s < end_s - ROUNDING_S
        if is_early or now_s > end_s + ROUNDING_S:
            says = f"robot {robot} waits from {begin_s:.3f} s to {now_s:.3f} s"
            self._violated(f"{says} instead of {end_s:.3f} s", robot, now_s)

    def over(self, robot: int, begin_s: float, end_s: float) -> None:
        """Judge what a robot has not received that stands and waits when the run ends."""
        if begin_s < end_s - ROUNDING_S:
            for letter in self._overdue(robot, end_s):
                self._violated(f"{letter} is never received", robot, end_s)

    def violations(self) -> Iterator[Violation]:
        """Yield the first violation, if there is one."""
        delays_s, jitter_s = self._delays_s, self._radio.jitter_s
        if self._found is None and len(delays_s) >= MIN_DELAYS:
            spread_s = max(delays_s) - min(delays_s)
            if spread_s < MIN_SPREAD * jitter_s:
                says = f"the delays of {len(delays_s)} messages differ by {spread_s:.2g} s at most"
                self._violated(f"{says}, with a jitter of {jitter_s:g} s", None, None)
        if self._found is not None:
            yield self._found

    def _received(
        self, robot: int, message: Message, begin_s: float, now_s: float, *, moves: bool
    ) -> None:
        at_once = not moves or message.wakes
        sent = [letter for letter in self._due[robot] if letter.is_of(message)]
        if not sent:
            says = f"robot {robot} receives a message ({message.kind}) that was not sent to it"
            self._violated(f"{says}, or receives it again", robot, now_s)
            return
        fitting = (
            letter
            for letter in sent
            if letter.first_s <= now_s + ROUNDING_S
            and (not at_once or now_s <= max(begin_s, letter.last_s) + ROUNDING_S)
            and not self._is_silent(robot, letter)
        )
        letter = next(fitting, None)
        if letter is None:
            letter = sent[0]
            if letter.known_by in self._doubtful[robot] and not self._is_silent(robot, letter):
                self._due[robot].remove(letter)
                return
            says = f"{letter} is received {now_s - letter.sent_s:.3f} s later"
            self._violated(f"{says} by robot {robot}", robot, now_s)
        self._due[robot].remove(letter)
        if at_once and self._radio.jitter_s > 0.0 and begin_s < letter.first_s:
            self._delays_s.append(now_s - letter.sent_s)

    def _overdue(self, robot: int, now_s: float) -> list[_Letter]:
        """Take out what was to arrive by a moment; return what must have."""
        overdue = [n for n in self._due[robot] if n.last_s < now_s - ROUNDING_S]
        self._due[robot] = [n for n in self._due[robot] if n.last_s >= now_s - ROUNDING_S]
        return [n for n in overdue if n.known_by not in self._doubtful[robot]]

    def _is_silent(self, robot: int, letter: _Letter) -> bool:
        return any(
            begin_s + ROUNDING_S < letter.first_s and letter.last_s < end_s - ROUNDING_S
            for begin_s, end_s in self._silent_s[robot]
        )

    def _may_be_silent(self, robot: int, letter: _Letter) -> bool:
        return any(
            begin_s - ROUNDING_S <= letter.last_s and letter.first_s <= end_s + ROUNDING_S
            for begin_s, end_s in self._silent_s[robot]
        )

    def _violated(self, says: str, robot: int | None, time_s: float | None) -> None:
        if self._found is None:
            self._found = Violation(invariant=NAME, says=says, robot=robot, time_s=time_s)
