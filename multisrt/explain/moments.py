"""The explanations of a robot at every time of a run, each once."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

from multisrt.events import (
    AnyEvent,
    ArcClosed,
    ArcReopened,
    BaseLearned,
    Blocked,
    CameBack,
    Coordinated,
    Decided,
    Decision,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Joined,
    Learned,
    Motion,
    NodeAdded,
    NodeName,
    Organized,
    PresumedLost,
    Sensed,
    Sent,
    Supports,
)
from multisrt.explain.srt import explain
from multisrt.explain.words import SAME_MOMENT_S
from multisrt.recording import Recording

CHOICES = Decision | GoalChosen | Decided

EXPLANATION_CHANGES = (
    CHOICES
    | Coordinated
    | Supports
    | Ended
    | Blocked
    | CameBack
    | Died
    | FellSilent
    | Joined
    | PresumedLost
)
"""Events at which the explanation of a robot changes. For a robot of the SRT family it also does
when a motion begins or ends; all others tell at once what was done until the next choice."""


class Moment(NamedTuple):
    """An explanation, and since when it holds.

    Attributes
    ----------
    time_s : float
        When it begins to hold, in seconds; it does until the next one.
    lines : tuple of str
        What `explain` says, without "Robot 0 at 31.50 s: " at the beginning of its first line.
    """

    time_s: float
    lines: tuple[str, ...]


def moments(recording: Recording, robot: int, *, choices_only: bool = False) -> Iterator[Moment]:
    """Yield the explanations of a robot in the order of their times, each when it begins to hold.

    Parameters
    ----------
    recording : Recording
        The run.
    robot : int
        The robot, from 0.
    choices_only : bool, optional
        Whether to leave out what changes between two decisions of the robot.

    Yields
    ------
    Moment
        None before its first decision.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
    >>> first = next(moments(recording, 0))
    >>> first.time_s, first.lines[0]
    (0.0, 'its last decision was at 0.00 s.')
    """
    if recording.spec.strategy == "informed":
        yield Moment(0.0, _said(recording, robot, 0.0, recording))
        return
    own = _needed(recording, robot)
    chosen = [event.time_s for event in own if _is_choice(event, robot)]
    if not chosen:
        return
    parts = [
        Recording(header=recording.header, events=tuple(events), footer=recording.footer)
        for events in _windows(own, robot, chosen)
    ]
    end = recording.footer.time_s
    times = chosen if choices_only else [t for t in _changes(own, robot) if t >= chosen[0]]
    last: tuple[str, ...] = ()
    for time_s in sorted({min(time_s, end) for time_s in times}):
        part = parts[bisect_right(chosen, time_s + SAME_MOMENT_S) - 1]
        lines = _said(part, robot, time_s, recording)
        if lines != last:
            yield Moment(time_s, lines)
        last = lines


def _said(part: Recording, robot: int, time_s: float, whole: Recording) -> tuple[str, ...]:
    first, *others = explain(part, robot, time_s, whole=whole).splitlines()
    return first.split(" s: ", 1)[1], *others


def _is_choice(event: AnyEvent, robot: int) -> bool:
    return isinstance(event, CHOICES) and event.robot == robot


def _changes(own: Sequence[AnyEvent], robot: int) -> Iterator[float]:
    of_trees = any(isinstance(event, Decision) and event.robot == robot for event in own)
    for event in own:
        if event.robot != robot:
            continue
        if isinstance(event, EXPLANATION_CHANGES):
            yield event.time_s
        elif isinstance(event, Motion) and of_trees:
            yield event.time_s
            yield event.waypoints[-1][0]


class _Shared(NamedTuple):
    """The events of a recording with their places in it, found once for all robots."""

    of_robots: list[list[tuple[int, AnyEvent]]]
    nodes: dict[NodeName, tuple[int, AnyEvent]]
    organized: list[tuple[int, Organized]]


_SHARED: WeakKeyDictionary[Recording, _Shared] = WeakKeyDictionary()


def _shared(recording: Recording) -> _Shared:
    if recording not in _SHARED:
        found = _Shared([[] for _ in recording.starts], {}, [])
        for place, event in enumerate(recording.events):
            if event.robot < len(recording.starts):  # not one of the base station
                found.of_robots[event.robot].append((place, event))
            if isinstance(event, NodeAdded):
                found.nodes[event.robot, event.serial] = place, event
            elif isinstance(event, Organized):
                found.organized.append((place, event))
        _SHARED[recording] = found
    return _SHARED[recording]


def _needed(recording: Recording, robot: int) -> list[AnyEvent]:
    # The events from which the choices of a robot are explained: few of those of a large team.
    shared = _shared(recording)
    own = [event for _, event in shared.of_robots[robot]]
    of_trees = not any(isinstance(event, GoalChosen | Decided) for event in own)
    idle = (Sensed, Sent) if of_trees else (Sensed,)
    found = {place: e for place, e in shared.of_robots[robot] if not isinstance(e, idle)}
    found |= dict(shared.nodes[event.node] for event in own if isinstance(event, Decision))
    found |= {place: event for place, event in shared.organized if robot in event.before}
    return [found[place] for place in sorted(found)]


def _windows(
    own: Sequence[AnyEvent], robot: int, chosen: Sequence[float]
) -> Iterator[list[AnyEvent]]:
    # For each choice the events from which it is explained, in the order of the recording: all
    # from it to the next one, and of those before it what is counted or still matters.
    begins = [place for place, event in enumerate(own) if _is_choice(event, robot)]
    stops = [*(begin + 1 for begin in begins[1:]), len(own)]
    for place, event in enumerate(own):
        # Motions are recorded when they end, perhaps after the next choice.
        if isinstance(event, Motion):
            number = max(0, bisect_right(chosen, event.time_s + SAME_MOMENT_S) - 1)
            stops[number] = max(stops[number], place + 1)
    past = _Past(own, robot)
    for begin, stop, time_s in zip(begins, stops, chosen, strict=True):
        yield [*past.until(begin, time_s), *own[begin:stop]]


NOT_COUNTED = (Sent, BaseLearned, Coordinated, Ended, ArcClosed, ArcReopened)
"""Events that explain nothing of a later choice."""


class _Past:
    """What matters of the events before a choice, for choices one after the other."""

    def __init__(self, own: Sequence[AnyEvent], robot: int) -> None:
        self.own, self.robot = own, robot
        self.place = 0
        self.counted: list[int] = []
        self.last: dict[type, int] = {}
        self.learned: list[int] = []

    def until(self, begin: int, time_s: float) -> list[AnyEvent]:
        while self.place < begin:
            self._take(self.place, self.own[self.place])
            self.place += 1
        recent = self._recent(begin, time_s)
        kept = sorted({*self.counted, *self.last.values(), *recent})
        old = [place for place in self.learned if place not in recent]
        return [*self._together(old), *(self.own[place] for place in kept)]

    def _take(self, place: int, event: AnyEvent) -> None:
        if isinstance(event, Learned):
            self.learned.append(place)
        elif isinstance(event, CHOICES | Motion | Supports) and event.robot == self.robot:
            self.last[type(event)] = place
        elif not isinstance(event, NOT_COUNTED):
            self.counted.append(place)

    def _recent(self, begin: int, time_s: float) -> set[int]:
        # Those of the same moment.
        found = set()
        for place in range(begin - 1, -1, -1):
            event = self.own[place]
            if event.time_s >= time_s - SAME_MOMENT_S:
                found.add(place)
            elif not isinstance(event, Motion):
                break
        return found

    def _together(self, places: Sequence[int]) -> Iterator[Learned]:
        if places:
            several = [event for p in places if isinstance(event := self.own[p], Learned)]
            nodes = tuple(name for event in several for name in event.nodes)
            yield Learned(time_s=several[-1].time_s, robot=self.robot, nodes=nodes)
