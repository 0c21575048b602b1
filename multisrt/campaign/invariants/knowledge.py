"""Robots know only what they scanned or received in messages."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from typing import Final

from multisrt.campaign.judged_run import JudgedRun, silences
from multisrt.campaign.violations import Violation
from multisrt.events import (
    AnyEvent,
    ArcClosed,
    ArcReopened,
    BaseLearned,
    Coordinated,
    Decision,
    GoalChosen,
    Learned,
    NodeAdded,
    NodeName,
    Organized,
    Pose,
    Sensed,
    Sent,
)

NAME: Final = "knowledge-by-scan-or-message"

SAME_PLACE_M: Final = 1e-6
"""Places closer together than this, in metres, are the same."""

ROUNDING_S: Final = 1e-6
"""Maximum time by which a message may be early, in seconds."""


def knowledge_by_scan_or_message(run: JudgedRun) -> Violation | None:
    """Check that robots know only what they scanned or received in messages.

    A node is recorded where its robot has taken a scan, to 1e-6 m. A node of another robot is
    learned, or named in arcs, in decisions and as a parent, only after a message to the robot from
    one that knew the node when it sent the message, and only after the latency. The receiver's
    radio must have worked when the message arrived. The same holds for robots named in groups,
    orders and tables of goals. The base station learns from messages of the robot that it names,
    at the moment at which they arrive: within the jitter after the latency.

    Recordings do not contain the contents of messages, so any message may have contained all that
    its sender knew.

    Cost: one pass over the events.
    """
    return next(_Knowledge(run).violations(), None)


class _Knowledge:
    """The nodes that each robot, and the base station, can know at a point of a recording."""

    def __init__(self, run: JudgedRun) -> None:
        self._run = run
        spec = run.recording.spec
        members = len(spec.robots) + 1
        self._latency_s, self._jitter_s = spec.radio.latency_s, spec.radio.jitter_s
        self._silences = [silences(spec.faults, robot) for robot in run.robots]
        # In which order each came to know nodes; a message holds the first n of them.
        self._order: list[dict[NodeName, int]] = [{} for _ in range(members)]
        self._knowers: dict[NodeName, list[int]] = defaultdict(list)
        # For each receiver and sender the messages: how many nodes the sender knew, and when.
        self._counts: dict[tuple[int, int], list[int]] = defaultdict(list)
        self._times_s: dict[tuple[int, int], list[float]] = defaultdict(list)
        # For each robot since when it may have heard of each other one.
        self._heard_of: list[dict[int, float]] = [{n: 0.0} for n in range(members)]
        self._scans: dict[int, dict[tuple[int, int], list[Pose]]] = defaultdict(dict)

    def violations(self) -> Iterator[Violation]:
        """Yield nodes known without a scan or message, in the order of the recording."""
        for event in self._run.recording.events:
            for what in self._wrong(event):
                member = self._base if isinstance(event, BaseLearned) else event.robot
                yield Violation(
                    invariant=NAME,
                    says=f"{self._run.named(member)} {what}, {event.time_s:.2f} s",
                    robot=event.robot,
                    time_s=event.time_s,
                )

    @property
    def _base(self) -> int:
        return len(self._run.robots)

    def _wrong(self, event: AnyEvent) -> Iterator[str]:
        match event:
            case Sensed():
                x, y, _ = event.configuration
                cells = self._scans[event.robot]
                cells.setdefault(_cell(x, y), []).append(event.configuration)
            case NodeAdded():
                if not self._has_scanned(event.robot, event.configuration):
                    yield f"notes node {event.serial} at a place where it has taken no scan"
                if event.parent is not None:
                    yield from self._unknown(event.robot, event.parent, "goes on from")
                self._know(event.robot, (event.robot, event.serial))
            case Sent():
                self._send(event)
            case Learned():
                yield from self._learn(event.robot, event.nodes, event.time_s, None)
            case BaseLearned():
                yield from self._learn(self._base, event.nodes, event.time_s, event.robot)
            case ArcClosed() | ArcReopened() | Decision():
                yield from self._unknown(event.robot, event.node, "names")
        yield from self._strangers(event)

    def _has_scanned(self, robot: int, place: Pose) -> bool:
        x, y, _ = place
        column, row = _cell(x, y)
        near = [
            pose
            for dx in (-1, 0, 1)
            for dy in (-1, 0, 1)
            for pose in self._scans[robot].get((column + dx, row + dy), ())
        ]
        return any(math.dist(pose[:2], (x, y)) <= SAME_PLACE_M for pose in near)

    # Nodes ----------------------------------------------------------------------------------

    def _know(self, member: int, name: NodeName) -> None:
        order = self._order[member]
        if name not in order:
            order[name] = len(order)
            self._knowers[name].append(member)

    def _unknown(self, robot: int, name: NodeName, does: str) -> Iterator[str]:
        if (name[0], name[1]) not in self._order[robot]:
            yield f"{does} node {name[1]} of robot {name[0]}, which it does not know"

    def _send(self, sent: Sent) -> None:
        count = len(self._order[sent.robot])
        arrival_s = sent.time_s + self._latency_s
        heard = [n for n, since_s in self._heard_of[sent.robot].items() if since_s <= sent.time_s]
        for receiver in sent.reached:
            key = receiver, sent.robot
            self._counts[key].append(count)
            self._times_s[key].append(sent.time_s)
            known = self._heard_of[receiver]
            for number in heard:
                known[number] = min(known.get(number, math.inf), arrival_s)

    def _learn(
        self, member: int, nodes: tuple[NodeName, ...], time_s: float, by: int | None
    ) -> Iterator[str]:
        for node in nodes:
            name = node[0], node[1]
            knowers = [by] if by is not None else self._knowers[name]
            if not any(self._was_told(member, knower, name, time_s) for knower in knowers):
                told = f" by robot {by}" if by is not None else ""
                yield (
                    f"learns of node {name[1]} of robot {name[0]}, which no message can have "
                    f"brought{told}"
                )
                return
            self._know(member, name)

    def _was_told(self, member: int, sender: int, name: NodeName, time_s: float) -> bool:
        """Whether a message that contained a node can have come from a robot by a time."""
        place = self._order[sender].get(name)
        if place is None:
            return False
        counts, times_s = self._counts[member, sender], self._times_s[member, sender]
        for k in range(bisect_right(counts, place), len(counts)):
            if times_s[k] + self._latency_s > time_s + ROUNDING_S:
                return False
            if self._may_hear(member, times_s[k], time_s):
                return True
        return False

    def _is_late(self, sent_s: float, time_s: float) -> bool:
        # Whether a message should have come before a time.
        return time_s > sent_s + self._latency_s + self._jitter_s + ROUNDING_S

    def _may_hear(self, member: int, sent_s: float, until_s: float) -> bool:
        # Whether the radio worked at any time at which a message can have come. The base station
        # takes it at that very moment, as it does nothing else.
        if member == self._base:
            return not self._is_late(sent_s, until_s)
        begin_s = sent_s + self._latency_s
        last_s = min(begin_s + self._jitter_s, until_s) + ROUNDING_S
        on_s, dead_s = self._run.present_s(member)
        if last_s < on_s or begin_s > dead_s + ROUNDING_S:
            return False
        return not any(
            silent_s + ROUNDING_S < begin_s and last_s < again_s - ROUNDING_S
            for silent_s, again_s in self._silences[member]
        )

    # Other robots ---------------------------------------------------------------------------

    def _strangers(self, event: AnyEvent) -> Iterator[str]:
        if event.robot >= self._base:
            return
        known = self._heard_of[event.robot]
        for number in sorted(_others(event)):
            if known.get(number, math.inf) > event.time_s + ROUNDING_S:
                yield f"counts with robot {number}, of which it cannot have heard"
                return


def _others(event: AnyEvent) -> set[int]:
    match event:
        case GoalChosen():
            return {*event.robots}
        case Decision():
            return {*event.gpr, *event.ger}
        case Coordinated():
            return {*event.ger, event.master, *event.feasible, *event.unfeasible}
        case Organized():
            return {*event.before, *event.after, *event.orders}
    return set()


def _cell(x: float, y: float) -> tuple[int, int]:
    return math.floor(x / SAME_PLACE_M / 10.0), math.floor(y / SAME_PLACE_M / 10.0)
