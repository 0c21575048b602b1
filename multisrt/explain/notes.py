"""Decisions of all robots, and what was not planned, in one line each."""

from __future__ import annotations

from typing import NamedTuple

from multisrt.events import AnyEvent, Collision, Decided, Decision, Ended, GoalChosen, MapComplete
from multisrt.explain.custom import own_choice
from multisrt.explain.frontier import bid_choice
from multisrt.explain.srt import planned
from multisrt.explain.words import trouble
from multisrt.recording import Recording


class Note(NamedTuple):
    """What a robot decided, or what happened to it, in one line.

    Attributes
    ----------
    time_s : float
        When, in seconds.
    robot : int
        The robot.
    text : str
        What, in words.
    is_trouble : bool
        Whether it was not planned: a protective stop, a failure, a death, a collision.
    """

    time_s: float
    robot: int
    text: str
    is_trouble: bool


def notes(recording: Recording) -> list[Note]:
    """Return the decisions of all robots, and what was not planned, in the order of recording.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    list of Note
        Decisions read as in the table of `explain_all`.

    Examples
    --------
    >>> import multisrt as ms
    >>> found = notes(ms.explore("open", seed=1).recording)
    >>> found[-1].text
    'it ended: every frontier arc is explored or closed'
    """
    found = []
    for index, event in enumerate(recording.events):
        if text := _decision(recording, index, event):
            found.append(Note(event.time_s, event.robot, text, False))
        elif text := _trouble(event):
            found.append(Note(event.time_s, event.robot, text, True))
    return found


def _decision(recording: Recording, index: int, event: AnyEvent) -> str:
    match event:
        case Decision():
            return planned(recording.events, index, event)
        case GoalChosen():
            return bid_choice(event)
        case Decided():
            return own_choice(event)
        case MapComplete():
            return "its map is complete"
        case Ended():
            return f"it ended: {event.reason}"
    return ""


def _trouble(event: AnyEvent) -> str:
    return f"collision: {event.account}" if isinstance(event, Collision) else trouble(event)
