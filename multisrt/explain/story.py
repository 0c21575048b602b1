"""Events before and after one choice of a robot, for the explanations of all strategies."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator
from itertools import groupby, pairwise
from typing import Generic, TypeVar

from multisrt.events import (
    AnyEvent,
    BaseLearned,
    Decided,
    Decision,
    Ended,
    GoalChosen,
    Learned,
    MapComplete,
    Motion,
    NodeAdded,
    Pose,
    Sent,
)
from multisrt.explain.home import home_lines
from multisrt.explain.words import SAME_MOMENT_S, by_robot, many, place, titled, troubles
from multisrt.planners.motion.trajectory import leg_length
from multisrt.recording import Recording

ChoiceT = TypeVar("ChoiceT", GoalChosen, Decided, Decision)


class ChoiceStory(ABC, Generic[ChoiceT]):
    """One choice of a robot, with what it knew, did and heard until the next.

    Parameters
    ----------
    recording : Recording
        The run.
    index : int
        Index of the choice among its events.
    choice : GoalChosen or Decided or Decision
        The choice.
    asked_s : float
        The time that was asked for, in seconds.
    whole : Recording, optional
        The run, if `recording` is the part of it from which the choice is explained.

    Attributes
    ----------
    before, after : list of Event
        What the robot recorded before the choice, and after it.
    meanwhile : list of Event
        What it recorded after the choice until the next.
    next : GoalChosen or Decided or Decision or None
        Its next choice.
    """

    things = "scan"
    """Name for the robot's nodes."""
    happened: str
    """What the robot last did, as the first line says it with the time."""

    def __init__(
        self,
        recording: Recording,
        index: int,
        choice: ChoiceT,
        asked_s: float,
        whole: Recording | None = None,
    ) -> None:
        self.choice: ChoiceT = choice
        self.whole = recording if whole is None else whole
        self.robot, self.asked_s, self.time_s = choice.robot, asked_s, choice.time_s
        self.team = range(len(recording.spec.robots))
        self.home = str(recording.spec.options.get("home", "never"))
        self.start = recording.starts[choice.robot]
        of_robot = [event.robot == choice.robot for event in recording.events]
        self.before = [e for e, own in zip(recording.events[:index], of_robot, strict=False) if own]
        later = [e for e, own in zip(recording.events, of_robot, strict=True) if own]
        self.after: list[AnyEvent] = later[len(self.before) + 1 :]
        self.meanwhile: list[AnyEvent] = self.after
        self.next: GoalChosen | Decided | Decision | None = None
        for number, event in enumerate(self.after):
            if isinstance(event, GoalChosen | Decided | Decision):
                self.next, self.meanwhile = event, self.after[:number]
                break

    @abstractmethod
    def sections(self) -> Iterator[tuple[str, Iterator[str]]]:
        """Yield the title and the lines of each section about the choice."""

    def lines(self) -> Iterator[str]:
        """Yield the lines of the whole explanation."""
        yield f"Robot {self.robot} at {self.asked_s:.2f} s: {self.happened} at {self.time_s:.2f} s."
        for title, lines in self.sections():
            yield from titled(title, lines)
        yield from self.endings()

    def standing(self) -> Iterator[str]:
        """Describe where the robot stood."""
        x, y, heading = self._pose()
        yield f"at {place((x, y))}, heading {math.degrees(heading):.0f} degrees"

    def learned(self) -> Iterator[str]:
        """Describe what it had learned of others by then."""
        learned = [event for event in self.before if isinstance(event, Learned)]
        names = [name for event in learned for name in event.nodes]
        if names:
            yield (
                f"it had learned {many(len(names), self.things)} of others: {by_robot(names)}; "
                f"last at {learned[-1].time_s:.2f} s"
            )

    def to_deliver(self) -> Iterator[str]:
        """Describe what it had to deliver, and whether it knew where."""
        return home_lines(self.whole, self.robot, self.time_s, self.things)

    def own_nodes(self) -> int:
        """Return how many nodes it had made by then."""
        return sum(isinstance(event, NodeAdded) for event in self.before)

    def complete(self) -> Iterator[str]:
        """Report since when it knew its map complete."""
        complete = [event for event in self.before if isinstance(event, MapComplete)]
        if complete:
            yield f"it knew since {complete[0].time_s:.2f} s that its map was complete"

    def afterwards(self) -> Iterator[str]:
        """Describe what it did until the next choice."""
        motions = [event for event in self.meanwhile if isinstance(event, Motion)]
        for purpose, group in groupby(motions, key=lambda motion: motion.purpose):
            several = list(group)
            legs = [leg for motion in several for leg in pairwise(motion.waypoints)]
            length_m = math.fsum(leg_length(*leg) for leg in legs)
            begin, end = several[0].time_s, several[-1].waypoints[-1]
            did = "gave way and drove" if purpose == "give way" else "drove"
            yield (
                f"from {begin:.2f} s on it {did} {length_m:.2f} m in {end[0] - begin:.2f} s, "
                f"to {place(end[1:3])}"
            )
        for event in self.meanwhile:
            if isinstance(event, Ended):
                yield f"{event.time_s:.2f} s: it ended: {event.reason}"

    def messages(self) -> Iterator[str]:
        """Describe what it sent and received until the next choice."""
        kinds = Counter(event.kind for event in self.meanwhile if isinstance(event, Sent))
        if kinds:
            told = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
            yield f"it sent {many(kinds.total(), 'message')}: {told}"
        names = [n for event in self.meanwhile if isinstance(event, Learned) for n in event.nodes]
        if names:
            yield f"it learned {many(len(names), self.things)} of others: {by_robot(names)}"
        brought = [e for e in self.meanwhile if isinstance(e, BaseLearned)]
        if brought:
            names = [name for event in brought for name in event.nodes]
            yield f"the base station learned {many(len(names), self.things)} of it"

    def endings(self) -> Iterator[str]:
        """Describe its messages and its problems: the last sections of every explanation."""
        until = max(self.asked_s, self.time_s) + SAME_MOMENT_S
        past = (e for e in (*self.before, *self.meanwhile) if e.time_s <= until)
        yield from titled("Messages until the next choice", self.messages())
        yield from titled("What did not go as planned", troubles(past))

    def _pose(self) -> Pose:
        # Goals are chosen between motions, which are recorded when they end.
        motions = [event for event in self.before if isinstance(event, Motion)]
        if not motions:
            return self.start.x, self.start.y, self.start.heading
        return motions[-1].waypoints[-1][1:]
