"""Runs that are being made now, and for how long already."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from multisrt.experiments.job import Compilation, Compiling, Job


class Underway(NamedTuple):
    """A run that is being made.

    Attributes
    ----------
    job : Job
        The run.
    elapsed_s : float
        For how long it has been made, in seconds.
    """

    job: Job
    elapsed_s: float

    def __str__(self) -> str:
        """Return which run it is, and for how long it has run."""
        where = self.job.condition
        robots = f"{where.robots} robot{'s' * (where.robots != 1)}"
        return (
            f"{where.environment}, {where.strategy}, {robots}, repetition {self.job.repetition} "
            f"has run for {self.elapsed_s:.0f} s"
        )


class JobsUnderWay:
    """The runs that are being made now, by any number of threads.

    Attributes
    ----------
    has_compiled : bool
        Whether kernels have been compiled for any run.
    """

    def __init__(self) -> None:
        self.has_compiled = False
        self._began: dict[int, tuple[float, Job]] = {}
        self._compiling: dict[int, Compiling] = {}
        self._lock = threading.Lock()

    @contextmanager
    def making(self, job: Job) -> Iterator[Callable[[Compilation], None]]:
        """Count a run as being made within the block, which gets what to tell of compilations."""
        with self._lock:
            self._began[id(job)] = time.perf_counter(), job

        def tell(now: Compilation) -> None:
            with self._lock:
                self.has_compiled = True
                if isinstance(now, Compiling):
                    self._compiling[id(job)] = now
                else:
                    self._compiling.pop(id(job), None)

        try:
            yield tell
        finally:
            with self._lock:
                del self._began[id(job)]
                self._compiling.pop(id(job), None)

    def longest(self) -> Underway | None:
        """Return the run that has taken longest so far; None if none is made here."""
        with self._lock:
            began_s, job = min(self._began.values(), key=lambda v: v[0], default=(0.0, None))
        return None if job is None else Underway(job, time.perf_counter() - began_s)

    def compiling(self) -> Compiling | None:
        """Return the kernels of the run that has compiled most; None if none compiles any now."""
        with self._lock:
            return max(self._compiling.values(), key=lambda now: now.done, default=None)
