"""What passes between explorers and the simulation, of which recordings have only a part."""

from __future__ import annotations

from collections.abc import Iterator

from multisrt.campaign.arrivals import Arrivals
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.sightings import Looked, bodies_in_sight
from multisrt.campaign.violations import Violation
from multisrt.events import Died, Event, Sent
from multisrt.robots.explorer import (
    Action,
    Done,
    Look,
    Move,
    Moved,
    Outcome,
    Receive,
    Send,
)
from multisrt.spec import RunSpec


class Witness:
    """Sees what explorers yield and what they are sent, and judges messages and sightings.

    Parameters
    ----------
    spec : RunSpec
        The run.
    """

    def __init__(self, spec: RunSpec) -> None:
        self._arrivals = Arrivals(spec)
        self._looks: list[Looked] = []
        self._last: dict[int, tuple[float, Action]] = {}
        self._moving: set[int] = set()
        self._dead: set[int] = set()

    def overhear(self, robot: int, now_s: float, outcome: Outcome, action: Action) -> None:
        """Take what an explorer was sent for its last action, and what it yielded then."""
        begin_s, last = self._last.get(robot, (now_s, None))
        moves = robot in self._moving
        match last:
            case Move():
                self._moving.add(robot)
                moves = True
            case Look():
                assert isinstance(outcome, tuple)
                self._looks.append(Looked(robot, now_s, outcome))
            case Receive():
                self._arrivals.timed(robot, begin_s, last, outcome, now_s)
        if isinstance(outcome, Moved):
            self._moving.discard(robot)
        self._arrivals.ended(robot, begin_s, outcome, now_s, moves=moves)
        if isinstance(action, Send):
            self._arrivals.sends(robot, action.message, action.to)
        self._last[robot] = now_s, action

    def watch(self, event: Event) -> None:
        """Take an event that is recorded."""
        match event:
            case Sent():
                self._arrivals.sent(event)
            case Died():
                self._dead.add(event.robot)

    def violations(self, run: JudgedRun) -> Iterator[Violation]:
        """Yield the first violation of each kind in a run that has ended."""
        for robot, (begin_s, last) in self._last.items():
            waits = isinstance(last, Receive) or (isinstance(last, Done) and last.on_call)
            if waits and robot not in self._moving | self._dead:
                self._arrivals.over(robot, begin_s, run.end_s)
        yield from self._arrivals.violations()
        first = next(bodies_in_sight(run, self._looks), None)
        if first is not None:
            yield first
