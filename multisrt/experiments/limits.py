"""What a run may take of the computer, held by the kernel of the operating system.

Computing time is counted by a timer of the process (`ITIMER_PROF`), whose signal raises
`OverTimeError` wherever Python code runs. What sits in compiled code does not come to hear of it:
that is ended, with its process, by the kernel's own limit (`RLIMIT_CPU`), which is set some
seconds later. Only the soft limit is set, as no process may raise its hard limit again. A run that
sleeps takes no computing time: it is given up after it has done nothing for two spells.

Memory is held by `RLIMIT_DATA`, counted from what the process has when the run begins: the
allocation that goes beyond fails, and Python, NumPy, Numba and GEOS make that a `MemoryError`. So
it is on Linux; macOS counts only a part of what a process allocates, and holds less.
"""

from __future__ import annotations

import math
import resource
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from multisrt.experiments.description import Limits
from multisrt.experiments.memory import counted_bytes

GRACE_S = 5.0
"""How much longer compiled code may compute before its process is ended."""

AGAIN_S = 1.0
"""How soon a run is told again that its time is over, if it does not heed."""

SHORTEST_SPELL_S, LONGEST_SPELL_S = 5.0, 60.0
"""Bounds of a spell, which else lasts as long as the run may compute."""

IDLE_SHARE = 0.001
"""A spell with less computing than this was slept through, however busy the machine is."""


class OverTimeError(BaseException):
    """A run took longer than it may; no handler of errors may take it for one."""


@contextmanager
def within(limits: Limits) -> Iterator[None]:
    """Hold what is done inside to limits; for the main thread of a process.

    Raises
    ------
    OverTimeError
        Inside, when the computing time is over, or if nothing happens.
    MemoryError
        Inside, where an allocation goes beyond.
    """
    armed = True
    spell_s = min(max(limits.computing_s, SHORTEST_SPELL_S), LONGEST_SPELL_S)
    slept, computed_s = 0, time.process_time()

    def over(_signal: int, _frame: FrameType | None) -> None:
        if armed:
            raise OverTimeError(f"not done after {limits.computing_s:g} s of computing")

    def look(_signal: int, _frame: FrameType | None) -> None:
        # Twice, as a process that was stopped for a while hears once of all that it missed.
        nonlocal slept, computed_s
        now_s = time.process_time()
        slept = slept + 1 if now_s - computed_s < IDLE_SHARE * spell_s else 0
        computed_s = now_s
        if armed and slept >= 2:
            raise OverTimeError(f"did nothing for {2.0 * spell_s:g} s")

    handlers: dict[int, Callable[[int, FrameType | None], None] | signal.Handlers] = {
        signal.SIGPROF: over,
        signal.SIGALRM: look,
        signal.SIGXCPU: signal.SIG_DFL,
    }
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    allowed = {what: resource.getrlimit(what) for what in (_CPU, _DATA)}
    _set_soft(_CPU, math.ceil(time.process_time() + limits.computing_s + GRACE_S))
    _set_soft(_DATA, counted_bytes() + limits.memory_mb * 1_000_000)
    try:
        signal.setitimer(signal.ITIMER_PROF, limits.computing_s, AGAIN_S)
        signal.setitimer(signal.ITIMER_REAL, spell_s, spell_s)
        yield
    finally:
        armed = False
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for what, values in allowed.items():
            resource.setrlimit(what, values)
        for number, handler in before.items():
            signal.signal(number, handler)


_CPU, _DATA = resource.RLIMIT_CPU, resource.RLIMIT_DATA


def _set_soft(what: int, value: int) -> None:
    soft, hard = resource.getrlimit(what)
    bounds = [bound for bound in (soft, hard) if bound != resource.RLIM_INFINITY]
    resource.setrlimit(what, (min([value, *bounds]), hard))
