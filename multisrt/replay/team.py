"""What robots said to one another and how they were coordinated, in a replay."""

from __future__ import annotations

import numpy as np

from multisrt.analysis.radio_links import radio_links
from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    ArcReopened,
    Blocked,
    Coordinated,
    Decision,
    Sent,
)
from multisrt.recording import Recording
from multisrt.replay.packing import UNIT_M, UNIT_S, Packed, Table, lists, points, whole


def packed_messages(recording: Recording) -> Packed:
    """Pack the messages: sender, and the sets of robots that they reached or not."""
    sent = recording.of(Sent)
    sets = Table()
    return {
        "t": whole([event.time_s for event in sent], UNIT_S),
        "robot": [event.robot for event in sent],
        "reached": [sets.index(event.reached) for event in sent],
        "lost": [sets.index(event.lost) for event in sent],
        "sets": lists(sets.values),
    }


def packed_links(recording: Recording, environment: Environment) -> Packed | None:
    """Pack when each pair of robots had a radio link; None if the radio reaches everywhere."""
    if recording.spec.radio.reaches_everywhere:
        return None
    rows = [
        (begin, end, i, j)
        for (i, j), spells in radio_links(recording, environment).items()
        for begin, end in spells
    ]
    return {
        "begin": whole([row[0] for row in rows], UNIT_S),
        "end": whole([row[1] for row in rows], UNIT_S),
        "one": [row[2] for row in rows],
        "other": [row[3] for row in rows],
    }


def packed_groups(recording: Recording) -> Packed:
    """Pack the groups of robots, as they stood at their decisions, and the orders of masters."""
    sets = Table()
    decisions = recording.of(Decision)
    orders = recording.of(Coordinated)
    return {
        "t": whole([event.time_s for event in decisions], UNIT_S),
        "robot": [event.robot for event in decisions],
        "gpr": [sets.index(event.gpr) for event in decisions],
        "ger": [sets.index(event.ger) for event in decisions],
        "orders": {
            "t": whole([event.time_s for event in orders], UNIT_S),
            "robot": [event.robot for event in orders],
            "master": [event.master for event in orders],
        },
        "sets": lists(sets.values),
    }


def packed_stops(recording: Recording) -> Packed:
    """Pack the protective stops: who stopped, when and where."""
    stops = recording.of(Blocked)
    places = np.array([event.configuration for event in stops]).reshape(-1, 3)
    return {
        "t": whole([event.time_s for event in stops], UNIT_S),
        "robot": [event.robot for event in stops],
        "x": whole(places[:, 0], UNIT_M),
        "y": whole(places[:, 1], UNIT_M),
    }


def packed_arcs(recording: Recording) -> Packed:
    """Pack the frontier arcs that robots gave up, from when until when."""
    rows: list[list[float]] = []
    arcs, open_rows = [], {}
    for event in recording.events:
        if isinstance(event, ArcClosed):
            open_rows[event.robot, event.node, event.arc] = len(rows)
            rows.append([event.time_s, -1.0, event.robot])
            arcs.append(np.array(event.arc).reshape(-1, 2))
        elif isinstance(event, ArcReopened):
            number = open_rows.pop((event.robot, event.node, event.arc), None)
            if number is not None:
                rows[number][1] = event.time_s
    return {
        "begin": whole([row[0] for row in rows], UNIT_S),
        "end": whole([row[1] for row in rows], UNIT_S),
        "robot": [int(row[2]) for row in rows],
        # Pairs of points: the segments of an arc.
        "arc": points(arcs),
    }
