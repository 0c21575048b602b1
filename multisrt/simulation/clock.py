"""The discrete-event clock of a run."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any

import simpy

FIRST, PROMPT, LATE = -1, 1, 2
"""Priorities of what is scheduled for one moment: a pause is over before all else happens, also
before a process begins (0), and timeouts come after all else."""

ROUNDING_S = 1e-9
"""Tolerance within which two computed times are the same moment, in seconds."""


class Clock:
    """The time of a run, and what is scheduled.

    Attributes
    ----------
    now_s : float
        Time since the start of the run, in seconds.
    """

    def __init__(self) -> None:
        self.now_s = 0.0
        self._schedule = simpy.Environment()

    @property
    def next_s(self) -> float:
        """Time of the next scheduled event in seconds; infinite if there is none."""
        return float(self._schedule.peek())

    def step(self) -> None:
        """Advance to the next scheduled event and process it."""
        self.now_s = self.next_s
        self._schedule.step()

    def event(self) -> simpy.Event:
        """Return a new event that a process can wait for."""
        return self._schedule.event()

    def pause(self) -> simpy.Event:
        """Return an event that is over at the next step, which changes no order of all others."""
        return _Call(self._schedule, 0.0, None, FIRST)

    def start(self, process: Generator[Any, Any, None]) -> None:
        """Schedule a process to begin now."""
        self._schedule.process(process)

    def later(
        self, delay_s: float, then: Callable[[], None], priority: int = PROMPT
    ) -> simpy.Event:
        """Schedule a call after a delay in seconds; return the event that makes it."""
        return _Call(self._schedule, delay_s, then, priority)


class _Call(simpy.Event):  # type: ignore[misc]
    """A scheduled call of a function; without one, it only happens."""

    def __init__(
        self,
        schedule: simpy.Environment,
        delay_s: float,
        then: Callable[[], None] | None,
        priority: int,
    ) -> None:
        super().__init__(schedule)
        # An event that will succeed, as simpy.Timeout is, which has no choice of a priority.
        self._ok = True
        self._value = None
        if then is not None:
            self.callbacks.append(lambda _: then())
        schedule.schedule(self, priority, delay_s)
