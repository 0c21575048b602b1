"""Decisions of all robots, and what was not planned, in one line each."""

from __future__ import annotations

from typing import NamedTuple

from multisrt.events import Decided, Decision, Ended, GoalChosen, MapComplete
from multisrt.explain.srt import planned
from multisrt.explain.words import in_words, trouble
from multisrt.recording import Recording

DECIDED = Decision | GoalChosen | Decided | MapComplete | Ended
"""What is told besides what was not planned."""


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
        Decisions read as in the table of `explain_all`, after ``decided:``.

    Examples
    --------
    >>> import multisrt as ms
    >>> found = notes(ms.explore("open", seed=1).recording)
    >>> found[-1].text
    'ended: every frontier arc is explored or closed'
    """
    found = []
    for index, event in enumerate(recording.events):
        if isinstance(event, Decision):
            text = f"decided: {planned(recording.events, index, event)}"
            found.append(Note(event.time_s, event.robot, text, False))
        elif isinstance(event, DECIDED):
            found.append(Note(event.time_s, event.robot, in_words(event), False))
        elif text := trouble(event):
            found.append(Note(event.time_s, event.robot, text, True))
    return found
