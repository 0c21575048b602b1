"""Runs of which nothing comes any more, although events go on."""

from __future__ import annotations

import math
from collections.abc import Sequence

from multisrt.events import (
    AnyEvent,
    BaseLearned,
    Blocked,
    CameBack,
    Died,
    Ended,
    FellSilent,
    Joined,
    Learned,
    Motion,
    NodeAdded,
    NodeName,
    Sensed,
)
from multisrt.events.event import Pose
from multisrt.robots.naming import joined, named_robots
from multisrt.simulation.robot import Robot
from multisrt.spec import Fault, Silence

NOTHING_NEW = "no robot moved, sensed or learned anything new"
"""Begin of the reason of a run that ends in this way."""

WAITS_FOR_EVER = "for a message that never comes"
"""End of the reason of a run in which robots wait, and nothing can come any more."""

STANDS_M = 1e-3
"""A motion that leads no farther is none, in metres and in radians."""


class Standstill:
    """Tells when robots have stood still for too long without anything new to them.

    Something has happened when a robot has moved or turned, has taken a scan at another place
    than before, has added a node or learned one, has ended for the first time, when the base
    station has learned of a node, or when a fault has struck. A fault that is due later, and the
    end of a single wait that is longer than the limit, count as something to come.

    Parameters
    ----------
    max_idle_s : float
        The limit, in seconds.
    faults : sequence of Death, Silence or LateStart
        The faults of the run.
    """

    def __init__(self, max_idle_s: float, faults: Sequence[Fault]) -> None:
        self._max_idle_s = max_idle_s
        self._since_s = max((_last_s(fault) for fault in faults), default=0.0)
        self._scanned_at: dict[int, Pose] = {}
        # Nodes are numbered as they are learned of; for each robot whether it knows each of them.
        self._numbers: dict[NodeName, int] = {}
        self._known: dict[int, bytearray] = {}
        self._ended: set[int] = set()
        self._blocked_by: dict[int, int] = {}

    @property
    def end_s(self) -> float:
        """Time in seconds at which the run ends unless something happens before."""
        return self._since_s + self._max_idle_s

    def take(self, event: AnyEvent) -> None:
        """Take notice of an event that is recorded."""
        if isinstance(event, Blocked):
            self._blocked_by[event.robot] = event.by
        elif self._is_new(event):
            end_s = event.waypoints[-1][0] if isinstance(event, Motion) else event.time_s
            self._since_s = max(self._since_s, end_s)
            self._blocked_by.pop(event.robot, None)

    def expect(self, time_s: float, wait_s: float) -> None:
        """Take notice of a wait that is over at a time at the latest, and of its length."""
        if wait_s > self._max_idle_s:
            self._since_s = max(self._since_s, time_s)

    def is_over(self, time_s: float, robots: Sequence[Robot]) -> bool:
        """Whether nothing has happened for too long, and no robot moves, when a time comes."""
        if time_s <= self.end_s:
            return False
        return not any(
            robot.motion is not None and _leads_on(robot.motion.move.trajectory.waypoints)
            for robot in robots
        )

    def reason(self, robots: Sequence[Robot]) -> str:
        """Return why the run ends: for how long nothing has happened, and what the robots do."""
        doing: dict[str, list[int]] = {}
        for robot in robots:
            doing.setdefault(self._doing(robot), []).append(robot.number)
        told = [
            f"{named_robots(numbers)} {what if len(numbers) == 1 else PLURAL.get(what, what)}"
            for what, numbers in doing.items()
        ]
        return f"{NOTHING_NEW} for {self._max_idle_s:,g} s: {joined(told)}"

    def _doing(self, robot: Robot) -> str:
        if robot.state in DOING:
            return DOING[robot.state]
        if (by := self._blocked_by.get(robot.number)) is not None:
            return f"stopped before robot {by}"
        return "waits"

    def _is_new(self, event: AnyEvent) -> bool:
        # Each of these sets what it compares with: an event is asked about once.
        match event:
            case Motion():
                return _leads_on(event.waypoints)
            case Sensed():
                before = self._scanned_at.get(event.robot)
                self._scanned_at[event.robot] = event.configuration
                return before is None or _differ(before, event.configuration)
            case Learned():
                return self._learns(event)
            case Ended():
                is_first = event.robot not in self._ended
                self._ended.add(event.robot)
                return is_first
        return isinstance(event, NodeAdded | BaseLearned | Joined | Died | FellSilent | CameBack)

    def _learns(self, event: Learned) -> bool:
        # Each robot of a large team learns of nearly all nodes: a byte for each, not a set.
        known, is_new = self._known.setdefault(event.robot, bytearray()), False
        for name in event.nodes:
            number = self._numbers.setdefault(name, len(self._numbers))
            if number >= len(known):
                known.extend(bytes(len(self._numbers) - len(known)))
            is_new |= not known[number]
            known[number] = 1
        return is_new


DOING = {"off": "is switched off", "done": "is done", "dead": "is dead"}
PLURAL = {
    "is switched off": "are switched off",
    "is done": "are done",
    "is dead": "are dead",
    "waits": "wait",
}


def _last_s(fault: Fault) -> float:
    # When a fault strikes or ends; a death may wait for what its robot does.
    return fault.time_s + (fault.duration_s if isinstance(fault, Silence) else 0.0)


def _leads_on(waypoints: Sequence[tuple[float, float, float, float]]) -> bool:
    first = waypoints[0]
    return any(_differ(first[1:], waypoint[1:]) for waypoint in waypoints[1:])


def _differ(a: Pose, b: Pose) -> bool:
    return math.dist(a[:2], b[:2]) > STANDS_M or abs(a[2] - b[2]) > STANDS_M
