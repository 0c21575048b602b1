"""What robots said to one another and how they were coordinated, in a replay."""

from __future__ import annotations

import numpy as np

from multisrt.analysis.radio_links import radio_links
from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    ArcReopened,
    Blocked,
    Collision,
    Coordinated,
    Decision,
    Died,
    Joined,
    Organized,
    Sent,
)
from multisrt.recording import Recording
from multisrt.replay.packing import UNIT_M, UNIT_S, Packed, Table, lists, points, whole


def packed_messages(recording: Recording) -> Packed:
    """Pack the messages: sender, kind, size, and the sets of robots that they reached or not."""
    sent = recording.of(Sent)
    kinds, sets = Table(), Table()
    return {
        "t": whole([event.time_s for event in sent], UNIT_S),
        "robot": [event.robot for event in sent],
        "kind": [kinds.index(event.kind) for event in sent],
        "bytes": [event.size_bytes for event in sent],
        "reached": [sets.index(event.reached) for event in sent],
        "lost": [sets.index(event.lost) for event in sent],
        "kinds": kinds.values,
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
    sets, orders = Table(), Table()
    decisions = recording.of(Decision)
    told = recording.of(Coordinated)
    return {
        "t": whole([event.time_s for event in decisions], UNIT_S),
        "robot": [event.robot for event in decisions],
        "gpr": [sets.index(event.gpr) for event in decisions],
        "ger": [sets.index(event.ger) for event in decisions],
        "told": {
            "t": whole([event.time_s for event in told], UNIT_S),
            "robot": [event.robot for event in told],
            "master": [event.master for event in told],
            "ger": [sets.index(event.ger) for event in told],
            "order": [orders.index(event.order) for event in told],
            "orders": orders.values,
        },
        "organized": {
            "t": whole([event.time_s for event in recording.of(Organized)], UNIT_S),
            "robot": [event.robot for event in recording.of(Organized)],
        },
        "sets": lists(sets.values),
    }


def packed_stops(recording: Recording) -> Packed:
    """Pack protective stops, deaths, collisions, and when robots were switched on late."""
    stops = recording.of(Blocked)
    places = np.array([event.configuration for event in stops]).reshape(-1, 3)
    return {
        "t": whole([event.time_s for event in stops], UNIT_S),
        "robot": [event.robot for event in stops],
        "by": [event.by for event in stops],
        "x": whole(places[:, 0], UNIT_M),
        "y": whole(places[:, 1], UNIT_M),
        "died": [[event.robot, round(event.time_s / UNIT_S)] for event in recording.of(Died)],
        "joined": [[event.robot, round(event.time_s / UNIT_S)] for event in recording.of(Joined)],
        "collided": [
            [event.robot, round(event.time_s / UNIT_S)] for event in recording.of(Collision)
        ],
    }


def packed_arcs(recording: Recording) -> Packed:
    """Pack the frontier arcs that robots gave up, from when until when."""
    rows: list[list[float]] = []
    arcs, reasons, open_rows = [], Table(), {}
    for event in recording.events:
        if isinstance(event, ArcClosed):
            open_rows[event.robot, event.node, event.arc] = len(rows)
            rows.append([event.time_s, -1.0, event.robot, reasons.index(event.reason)])
            arcs.append(np.array(event.arc).reshape(-1, 2))
        elif isinstance(event, ArcReopened):
            number = open_rows.pop((event.robot, event.node, event.arc), None)
            if number is not None:
                rows[number][1] = event.time_s
    return {
        "begin": whole([row[0] for row in rows], UNIT_S),
        "end": whole([row[1] for row in rows], UNIT_S),
        "robot": [int(row[2]) for row in rows],
        "reason": [int(row[3]) for row in rows],
        "reasons": reasons.values,
        # Pairs of points: the segments of an arc.
        "arc": points(arcs),
    }
