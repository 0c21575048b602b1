"""The events of a replay and the explanations of decisions, as text."""

from __future__ import annotations

from typing import Final

from multisrt.events import (
    AnyEvent,
    ArcClosed,
    ArcReopened,
    Blocked,
    CameBack,
    Collision,
    Coordinated,
    Decided,
    Decision,
    DiagramLeft,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Joined,
    MapComplete,
    Motion,
    NodeAdded,
    Organized,
    PresumedLost,
    Supports,
)
from multisrt.explain.moments import moments
from multisrt.explain.words import listed, place, towards
from multisrt.recording import Recording
from multisrt.replay.packing import UNIT_S, Packed, Table, differences, lists, whole

MAX_TEXT: Final = 120
"""Upper bound of the characters of an event in words."""


def packed_log(recording: Recording) -> Packed:
    """Pack the events that can be stepped through, in words.

    Scans, messages, what was learned and motions are not among them; of a run without any
    decision motions are.
    """
    texts, kinds = Table(), Table()
    decides = any(recording.of(kind) for kind in (Decision, GoalChosen, Decided))
    rows = []
    for event in recording.events:
        words = None if decides and isinstance(event, Motion) else in_words(event)
        if words is not None:
            kind = kinds.index(str(type(event).__struct_config__.tag))
            rows.append((event.time_s, event.robot, kind, texts.index(words[:MAX_TEXT])))
    rows.sort(key=lambda row: row[0])
    return {
        "t": whole([row[0] for row in rows], UNIT_S),
        "robot": [row[1] for row in rows],
        "kind": [row[2] for row in rows],
        "text": differences(row[3] for row in rows),
        "kinds": kinds.values,
        "texts": texts.values,
    }


def in_words(event: AnyEvent) -> str | None:
    """Return what a robot did in an event, in words; None for what is not told.

    Examples
    --------
    >>> in_words(Blocked(time_s=2.0, robot=0, by=1, configuration=(1.0, 2.0, 0.0)))
    'protective stop before the body of robot 1'
    """
    match event:
        case NodeAdded():
            return f"added node {event.serial} ({event.stage})"
        case Decision():
            goal = "" if event.target is None else f" {towards(event.target)}"
            return f"decided: {event.choice}{goal}"
        case GoalChosen():
            return f"chose a goal ({event.rule}, {event.because}): {towards(event.goal)}"
        case Decided():
            return f"decided: {' '.join(event.text.split())}"
        case Motion():
            return f"set out {towards(event.waypoints[-1][1:3])}"
        case Supports():
            return "supports no tree" if event.tree is None else f"supports tree {event.tree}"
        case Ended():
            return f"ended: {event.reason}"
        case _:
            return _of_team(event) or _of_trouble(event)


def packed_explanations(recording: Recording, *, choices_only: bool) -> Packed:
    """Pack what `multisrt.explain` tells of each robot at every time; each line is stored once."""
    lines, texts, robots = Table(), Table(), []
    for robot in range(len(recording.starts)):
        told = list(moments(recording, robot, choices_only=choices_only))
        robots.append(
            {
                "t": whole([moment.time_s for moment in told], UNIT_S),
                "text": differences(
                    texts.index(tuple(map(lines.index, moment.lines))) for moment in told
                ),
            }
        )
    return {"robots": robots, "texts": lists(texts.values), "lines": lines.values}


def _of_team(event: AnyEvent) -> str | None:
    match event:
        case Coordinated():
            what = {"keep": "keep its target", "new target": "go to another target"}
            return f"was told by master {event.master} to {what.get(event.order, event.order)}"
        case Organized():
            which = " (deadlock)" if event.deadlock else ""
            return f"organised robots {listed(sorted(event.before))} as their master{which}"
        case ArcClosed():
            return f"gave up a frontier arc: {event.reason}"
        case ArcReopened():
            return "took up a frontier arc again"
        case DiagramLeft():
            return f"follows its path instead of the nearness diagram: {event.because}"
        case MapComplete():
            return "knows that its map is complete"
        case PresumedLost():
            return f"no longer waits for robot {event.other}, which does not answer"
        case _:
            return None


def _of_trouble(event: AnyEvent) -> str | None:
    match event:
        case Blocked():
            return f"protective stop before the body of robot {event.by}"
        case Died():
            return f"died at {place(event.configuration)}"
        case FellSilent():
            return "its radio failed"
        case CameBack():
            return "its radio works again"
        case Joined():
            return "was switched on, late"
        case Collision():
            return f"collided: {event.account}"
        case _:
            return None
