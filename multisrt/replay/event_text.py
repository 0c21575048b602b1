"""The events of a replay and the explanations of decisions, as text."""

from __future__ import annotations

from typing import Final

from multisrt.events import Decided, Decision, GoalChosen, Motion
from multisrt.explain.moments import moments
from multisrt.explain.words import in_words
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
        words = "" if decides and isinstance(event, Motion) else in_words(event)
        if words:
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
