"""Data that can be delivered is delivered to every robot that hears that it lacks it."""

from __future__ import annotations

import math
from typing import Final

from multisrt.campaign.judged_run import ROUNDING_S, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import (
    BaseLearned,
    CameBack,
    Died,
    FellSilent,
    Joined,
    Learned,
    Motion,
    NodeAdded,
    NodeName,
    Sent,
)

NAME: Final = "hearers-learn"

REPORTS: Final = ("report", "state")
"""Kinds of messages that say how much of the map their sender knows."""


def hearers_learn(run: JudgedRun) -> Violation | None:
    """Check that a robot receives all nodes of which it heard, if nothing prevents it.

    Reports state how many nodes their sender knows. In a complete run with a radio that loses
    nothing, each robot that is alive, and the base station, finally knows all nodes covered by the
    last report that it heard from each other robot, because missing nodes were sent with it or
    could be requested. If the radio does not reach everywhere, this holds only if no robot has
    moved since, so that the answer also arrives. No radio may have failed, recovered or been
    switched on since the report.

    Cost: one look at each event.
    """
    recording = run.recording
    judged = run.family != "other" and recording.footer.outcome == "complete"
    if not judged or recording.spec.radio.loss > 0.0:
        return None
    known = _Known(run)
    for (hearer, sender), (time_s, count) in sorted(known.reports.items()):
        if time_s < known.changed_s[sender] or time_s < known.changed_s[hearer]:
            continue
        if not recording.spec.radio.reaches_everywhere and time_s < known.settled_s:
            continue
        there = known.by_member[hearer]
        for name in list(known.by_member[sender])[:count]:
            if name not in there:
                return Violation(
                    invariant=NAME,
                    says=f"{run.named(hearer)} heard at {time_s:.2f} s from robot {sender}, which "
                    f"knew node {name[1]} of robot {name[0]}, but never learns of it",
                    robot=sender if hearer == len(run.robots) else hearer,
                    time_s=time_s,
                )
    return None


class _Known:
    """The nodes that each member knows in the end, and the contents of the last reports.

    Attributes
    ----------
    by_member : list of dict
        The nodes that each robot, and the base station, came to know, in their order.
    reports : dict
        By receiver and sender: when the last report came, and how many nodes its sender knew.
    changed_s : list of float
        By robot: when its radio last failed, recovered or was switched on; ``inf`` if it died.
    settled_s : float
        Time since which no robot has moved and no radio has changed.
    """

    def __init__(self, run: JudgedRun) -> None:
        members = len(run.robots) + 1
        self.by_member: list[dict[NodeName, None]] = [{} for _ in range(members)]
        self.reports: dict[tuple[int, int], tuple[float, int]] = {}
        self.changed_s = [0.0] * members
        self.settled_s = 0.0
        for event in run.recording.events:
            match event:
                case NodeAdded():
                    self.by_member[event.robot].setdefault((event.robot, event.serial))
                case Learned():
                    self._learn(event.robot, event.nodes)
                case BaseLearned():
                    self._learn(members - 1, event.nodes)
                case Sent() if event.kind in REPORTS:
                    count = len(self.by_member[event.robot])
                    for hearer in event.reached:
                        self.reports[hearer, event.robot] = event.time_s, count
                case Motion():
                    self.settled_s = max(self.settled_s, event.waypoints[-1][0])
                case FellSilent() | CameBack() | Joined() | Died():
                    is_dead = isinstance(event, Died)
                    # At that very moment a message may have come before, or after.
                    self.changed_s[event.robot] = math.inf if is_dead else event.time_s + ROUNDING_S
                    self.settled_s = max(self.settled_s, event.time_s + ROUNDING_S)

    def _learn(self, member: int, nodes: tuple[NodeName, ...]) -> None:
        self.by_member[member].update(dict.fromkeys((robot, serial) for robot, serial in nodes))
