"""The witness of a run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, islice
from typing import Final

from multisrt.campaign.judged_run import ROUNDING_S, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.campaign.witness.arrivals import Arrivals
from multisrt.campaign.witness.datasheets import told_what_they_are
from multisrt.campaign.witness.news import News
from multisrt.campaign.witness.sample import Sample
from multisrt.campaign.witness.scans import Scanned, scans_show_walls
from multisrt.campaign.witness.sightings import (
    EndOfMotion,
    Looked,
    bodies_in_sight,
    ends_of_motions,
)
from multisrt.events import BaseLearned, Blocked, Died, Event, Learned, Sent
from multisrt.geometry.regions.scan import ExactScan, LaserScan
from multisrt.robots.explorer import (
    Action,
    Done,
    Move,
    Moved,
    Outcome,
    Receive,
    Received,
    Send,
)
from multisrt.robots.messages import Message
from multisrt.simulation.setting_up import SetUp

OVER: Final = "ends-when-all-are-done"

MAX_LOOKS: Final = 200
MAX_SCANS: Final = 40
"""Capacity of the samples of looks and ends of motions, and of scans; when one is full, every
second item is dropped."""


class Witness:
    """Sees what explorers yield and what they are sent, and judges what recordings do not have.

    Parameters
    ----------
    setup : SetUp
        The run, before it begins.
    """

    def __init__(self, setup: SetUp) -> None:
        self._wrongly_told = list(islice(told_what_they_are(setup), 1))
        self._arrivals, self._news = Arrivals(setup.spec), News(setup.spec)
        self._looks = Sample[Looked](MAX_LOOKS)
        self._ends = Sample[EndOfMotion](MAX_LOOKS)
        self._scans = Sample[Scanned](MAX_SCANS)
        self._last: dict[int, tuple[float, Action]] = {}
        # What an explorer sends; the recorded event follows.
        self._sends: tuple[int, Send] | None = None
        self._blocked_by: dict[int, int] = {}
        self._moving: set[int] = set()
        self._died_s: dict[int, float] = {}

    def overhear(self, robot: int, now_s: float, outcome: Outcome, action: Action) -> None:
        """Take what an explorer was sent for its last action, and what it yielded then."""
        begin_s, last = self._last.get(robot, (now_s, None))
        if isinstance(last, Move):
            self._moving.add(robot)
        moves = robot in self._moving
        match outcome:
            case tuple():
                self._looks.add(Looked(robot, now_s, outcome))
            case ExactScan() | LaserScan():
                self._scans.add(Scanned(robot, now_s, outcome))
            case Moved():
                self._moving.discard(robot)
                by = self._blocked_by.pop(robot, None)
                self._ends.add(EndOfMotion(robot, now_s, outcome, by))
            case Received():
                self._news.received(robot, outcome.messages)
        self._arrivals.ended(robot, begin_s, outcome, now_s, moves=moves)
        if isinstance(last, Receive):
            self._arrivals.timed(robot, begin_s, last, outcome, now_s)
        if isinstance(action, Send):
            self._sends = robot, action
        self._last[robot] = now_s, action

    def watch(self, event: Event) -> None:
        """Take an event that is recorded."""
        match event:
            case Sent():
                message, to = self._taken(event.robot)
                self._news.sent(event, message)
                self._arrivals.sent(event, message, to)
            case Learned():
                self._news.learned(event)
            case BaseLearned():
                self._news.base_learned(event)
            case Blocked():
                self._blocked_by[event.robot] = event.by
            case Died():
                self._died_s[event.robot] = event.time_s

    def _taken(self, sender: int) -> tuple[Message | None, int | None]:
        """Return what was sent last, and for whom, if by this sender: not by the base station."""
        sends, self._sends = self._sends, None
        if sends is None or sends[0] != sender:
            return None, None
        return sends[1].message, sends[1].to

    def violations(self, run: JudgedRun) -> Iterator[Violation]:
        """Yield the first violation of each invariant in a run that has ended."""
        for robot, (begin_s, last) in self._last.items():
            waits = isinstance(last, Receive) or (isinstance(last, Done) and last.on_call)
            if waits and robot not in self._moving and robot not in self._died_s:
                self._arrivals.over(robot, begin_s, run.end_s)
        yield from self._wrongly_told
        yield from self._arrivals.violations()
        yield from self._news.violations(run.end_s)
        yield from islice(scans_show_walls(run, self._scans.items), 1)
        seen = bodies_in_sight(run, self._looks.items)
        yield from islice(chain(seen, ends_of_motions(run, self._ends.items)), 1)
        yield from self._is_late(run)

    def _is_late(self, run: JudgedRun) -> Iterator[Violation]:
        living = [robot for robot in run.robots if robot not in self._died_s]
        last = [self._last.get(robot) for robot in living]
        if not living or not all(one is not None and isinstance(one[1], Done) for one in last):
            return
        ended_s = [one[0] for one in last if one is not None]
        over_s = max(self._arrivals.last_s, *ended_s, *self._died_s.values())
        if run.end_s > over_s + ROUNDING_S:
            says = f"the run ends at {run.end_s:.3f} s, and all robots at {over_s:.3f} s"
            yield Violation(invariant=OVER, says=says, time_s=over_s)
