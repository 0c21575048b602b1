"""The explanations of a robot at every time of a run, each once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from multisrt.events import (
    AnyEvent,
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
    Motion,
    NodeAdded,
    Organized,
    PresumedLost,
    Sensed,
    Sent,
    Supports,
)
from multisrt.explain.srt import explain
from multisrt.recording import Recording

CHOICES = Decision | GoalChosen | Decided

TOLD = (
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
        yield Moment(0.0, _said(recording, robot, 0.0))
        return
    part = _needed(recording, robot)
    chosen = [event.time_s for event in part.events if _is_choice(event, robot)]
    if not chosen:
        return
    end = recording.footer.time_s
    times = chosen if choices_only else [t for t in _changes(part, robot) if t >= chosen[0]]
    last: tuple[str, ...] = ()
    for time_s in sorted({min(time_s, end) for time_s in times}):
        lines = _said(part, robot, time_s)
        if lines != last:
            yield Moment(time_s, lines)
        last = lines


def _said(recording: Recording, robot: int, time_s: float) -> tuple[str, ...]:
    first, *others = explain(recording, robot, time_s).splitlines()
    return first.split(" s: ", 1)[1], *others


def _is_choice(event: AnyEvent, robot: int) -> bool:
    return isinstance(event, CHOICES) and event.robot == robot


def _changes(part: Recording, robot: int) -> Iterator[float]:
    of_trees = any(
        _is_choice(event, robot) and isinstance(event, Decision) for event in part.events
    )
    for event in part.events:
        if event.robot != robot:
            continue
        if isinstance(event, TOLD):
            yield event.time_s
        elif isinstance(event, Motion) and of_trees:
            yield event.time_s
            yield event.waypoints[-1][0]


def _needed(recording: Recording, robot: int) -> Recording:
    # The part of the recording from which the same is explained: far less for a large team.
    own = [event for event in recording.events if event.robot == robot]
    places = {event.node for event in own if isinstance(event, Decision)}
    of_trees = not any(isinstance(event, GoalChosen | Decided) for event in own)
    idle = (Sensed, Sent) if of_trees else Sensed

    def is_needed(event: AnyEvent) -> bool:
        if event.robot == robot:
            return not isinstance(event, idle)
        if isinstance(event, NodeAdded):
            return (event.robot, event.serial) in places
        return isinstance(event, Organized) and robot in event.before

    events = tuple(event for event in recording.events if is_needed(event))
    return Recording(header=recording.header, events=events, footer=recording.footer)
