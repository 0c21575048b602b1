"""Limits of computing time and memory of a run, enforced by the operating system.

Computing time is counted by a timer of the process (`ITIMER_PROF`), whose signal raises
`OverTimeError` in Python code. Compiled code does not see the signal: it is ended, with its
process, by the kernel's limit (`RLIMIT_CPU`), set some seconds later. Only the soft limit is set,
as a process cannot raise its hard limit again. A run that sleeps uses no computing time: it is
given up after two intervals in which it did nothing.

The kernel's limit is for all that the process has computed since it began, by a clock that counts
ticks (`charged_s`). Over a long life it goes ahead of the exact clock of `time.process_time`, or
falls behind, by more than the grace: with a limit set by the exact clock, the kernel would end a
process whose run has just begun.

Memory is limited by `RLIMIT_DATA`, counted from what the process has when the run begins: the
allocation beyond the limit fails, which Python, NumPy, Numba and GEOS report as `MemoryError`.
This holds on Linux; macOS counts only a part of what a process allocates.
"""

from __future__ import annotations

import math
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from multisrt.experiments.memory import counted_bytes
from multisrt.experiments.spec import Limits

GRACE_S = 5.0
"""Computing time beyond the limit after which compiled code is ended with its process (s)."""

REPEAT_S = 1.0
"""Interval at which `OverTimeError` is raised again if the run suppressed it (s)."""

MIN_INTERVAL_S, MAX_INTERVAL_S = 5.0, 60.0
"""Bounds of the interval at which idleness is checked (s); within them it is the time limit."""

IDLE_SHARE = 0.001
"""Share of computing in an interval below which the run slept, however busy the machine is."""


class OverTimeError(BaseException):
    """A run exceeded its time; a BaseException, so that handlers of errors let it pass."""


@contextmanager
def within(limits: Limits) -> Iterator[None]:
    """Enforce limits on the code inside; only in the main thread of a process.

    Parameters
    ----------
    limits : Limits
        Computing time (s) and memory (MB).

    Raises
    ------
    OverTimeError
        Inside, when the computing time is used up or nothing is computed.
    MemoryError
        Inside, where an allocation exceeds the memory.
    """
    armed = True  # whether handlers may raise: not while limits are taken back
    interval_s = min(max(limits.computing_s, MIN_INTERVAL_S), MAX_INTERVAL_S)
    slept, computed_s = 0, time.process_time()

    def over(_signal: int, _frame: FrameType | None) -> None:
        if armed:
            raise OverTimeError(f"not done after {limits.computing_s:g} s of computing")

    def look(_signal: int, _frame: FrameType | None) -> None:
        # Two idle intervals: a process that was suspended gets one signal for all it missed.
        nonlocal slept, computed_s
        now_s = time.process_time()
        slept = slept + 1 if now_s - computed_s < IDLE_SHARE * interval_s else 0
        computed_s = now_s
        if armed and slept >= 2:
            raise OverTimeError(f"did nothing for {2.0 * interval_s:g} s")

    handlers: dict[int, Callable[[int, FrameType | None], None] | signal.Handlers] = {
        signal.SIGPROF: over,
        signal.SIGALRM: look,
        signal.SIGXCPU: signal.SIG_DFL,
    }
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    allowed = {what: resource.getrlimit(what) for what in (_CPU, _DATA)}
    _set_soft(_CPU, math.ceil(charged_s() + limits.computing_s + GRACE_S))
    _set_soft(_DATA, counted_bytes() + limits.memory_mb * 1_000_000)
    try:
        signal.setitimer(signal.ITIMER_PROF, limits.computing_s, REPEAT_S)
        signal.setitimer(signal.ITIMER_REAL, interval_s, interval_s)
        try:
            yield
        finally:
            armed = False  # a signal right before this still finds the outer block
    finally:
        armed = False
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for what, values in allowed.items():
            resource.setrlimit(what, values)
        for number, handler in before.items():
            # To ignore a signal discards it where another thread has yet to take it: it would
            # end the process by the handler of before, which for these is the default.
            signal.signal(number, signal.SIG_IGN)
            signal.signal(number, handler)


def charged_s() -> float:
    """Return the computing time of this process that its limits count, in seconds."""
    return time.clock_gettime(_CHARGED)


_CPU, _DATA = resource.RLIMIT_CPU, resource.RLIMIT_DATA

_CHARGED = ~0 << 3 if sys.platform == "linux" else time.CLOCK_PROCESS_CPUTIME_ID
"""Linux's clock of this process (0, inverted) for `ITIMER_PROF` and `RLIMIT_CPU` (kind 0)."""


def _set_soft(what: int, value: int) -> None:
    soft, hard = resource.getrlimit(what)
    bounds = [bound for bound in (soft, hard) if bound != resource.RLIM_INFINITY]
    resource.setrlimit(what, (min([value, *bounds]), hard))
