"""The events that a running simulation records."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import msgspec

from multisrt.events import AnyEvent, BaseLearned, NodeAdded, NodeName
from multisrt.recording import Recorder, Recording, RunOutcome
from multisrt.recording.flaws import flaw_of
from multisrt.simulation.standstill import Standstill

Watcher = Callable[[AnyEvent], None]
"""A function that is called with every event as it is recorded."""


class Journal:
    """Passes events on to the recorder, to a watcher, and to what tells a standstill.

    Parameters
    ----------
    recorder : Recorder
        Where events are recorded.
    standstill : Standstill
        What tells whether anything new happens.
    watch : callable, optional
        Called with every event.

    Attributes
    ----------
    last_s : float
        Time in seconds of the last thing that happened to a robot.
    """

    def __init__(
        self, recorder: Recorder, standstill: Standstill, watch: Watcher | None = None
    ) -> None:
        self._recorder = recorder
        self._standstill = standstill
        self._watch = watch
        self.last_s = 0.0
        self._nodes: set[NodeName] = set()

    def flaw(self, event: AnyEvent) -> str:
        """Return what is wrong with an event at this point of the run; empty if nothing is."""
        if isinstance(event, NodeAdded) and (event.robot, event.serial) in self._nodes:
            return f"node {event.serial} of robot {event.robot} is on record already"
        return flaw_of(event, self._recorder.header.spec, self._nodes)

    def record(self, event: AnyEvent) -> None:
        """Record an event."""
        if isinstance(event, NodeAdded):
            self._nodes.add((event.robot, event.serial))
        self._recorder.record(event)
        self._standstill.take(event)
        if self._watch is not None:
            self._watch(event)

    def record_learned(self, learned: BaseLearned) -> None:
        """Record what a base station learned, as far as the nodes are on record themselves."""
        nodes = tuple(name for name in learned.nodes if tuple(name) in self._nodes)
        if nodes:
            self.record(msgspec.structs.replace(learned, nodes=nodes))

    def note_time(self, time_s: float) -> None:
        """Note that something happened at a time, whether or not it is recorded."""
        if self.last_s < time_s:
            self.last_s = time_s

    def finish(self, time_s: float, outcome: RunOutcome, reason: str, *, chance: bool) -> Recording:
        """Return the recording of a run that ended; `chance`: whether a number was drawn."""
        return self._recorder.finish(time_s, outcome, reason, chance=chance)

    def cut_off(
        self, time_s: float, reason: str, under_way: Iterable[AnyEvent], *, chance: bool
    ) -> Recording:
        """Return the recording of the run as if it were cut off now; see `Recorder.cut_off`."""
        return self._recorder.cut_off(time_s, reason, under_way, chance=chance)
