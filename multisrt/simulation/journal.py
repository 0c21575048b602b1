"""What a running simulation puts on record."""

from __future__ import annotations

from collections.abc import Callable

from multisrt.events import AnyEvent
from multisrt.recording import Recorder, Recording, RunOutcome

Watcher = Callable[[AnyEvent], None]
"""A function that is called with every event as it is recorded."""


class Journal:
    """Passes events on to the recorder and to a watcher.

    Parameters
    ----------
    recorder : Recorder
        Where events are recorded.
    watch : callable or None
        Called with every event.

    Attributes
    ----------
    last_s : float
        Time in seconds of the last thing that happened to a robot.
    """

    def __init__(self, recorder: Recorder, watch: Watcher | None) -> None:
        self._recorder = recorder
        self._watch = watch
        self.last_s = 0.0

    def record(self, event: AnyEvent) -> None:
        """Record an event."""
        self._recorder.record(event)
        if self._watch is not None:
            self._watch(event)

    def note_time(self, time_s: float) -> None:
        """Note that something happened at a time, whether or not it is recorded."""
        if self.last_s < time_s:
            self.last_s = time_s

    def finish(self, time_s: float, outcome: RunOutcome, reason: str, *, chance: bool) -> Recording:
        """Return the recording of a run that ended; `chance`: whether a number was drawn."""
        return self._recorder.finish(time_s, outcome, reason, chance=chance)
