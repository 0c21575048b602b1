"""A limit on the time that an explorer may compute before it yields an action.

It is for the checker alone: in a simulation no decision depends on a clock.
"""

from __future__ import annotations

import gc
import signal
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import monotonic, thread_time
from types import FrameType, TracebackType
from typing import Any, ParamSpec, Self, TypeVar

MAX_WALL_FACTOR = 3.0
"""Maximum wall time of a call as a multiple of the limit, if it waits or the machine is busy."""

RETRY_INTERVAL_S = 0.01
"""Seconds after which an explorer is interrupted again if it caught the interruption."""

WEAK_REFERENCES = ("weakref", "_weakrefset")
"""The modules of the standard library whose functions are called when an object is gone."""

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """By when an explorer must be done.

    Attributes
    ----------
    max_time_s : float
        In the time of the run, in seconds.
    max_actions : int
        In number of actions of each robot.
    max_decision_s : float
        Computing time before an explorer yields, in seconds.
    """

    max_time_s: float
    max_actions: int
    max_decision_s: float


class ComputesTooLong(BaseException):
    """Raised to end a computation that takes too long; not caught by `except Exception`.

    Attributes
    ----------
    frame : frame or None
        Where it was.
    """

    def __init__(self, frame: FrameType | None) -> None:
        super().__init__("computes too long")
        self.frame = frame


class Watchdog:
    """Interrupts calls that take too long, within a ``with`` block.

    It needs the timers of Unix, and works in the main thread of a process; elsewhere calls are
    not interrupted.

    Parameters
    ----------
    limit_s : float
        Computing time in seconds that a call may take. Compilation by numba does not count. A
        call that waits instead of computing is interrupted after `MAX_WALL_FACTOR` times as long.
    """

    def __init__(self, limit_s: float) -> None:
        self.limit_s = limit_s
        self._watches = False
        self._began = 0.0, 0.0
        self._before: Any = None
        self._timer_before = 0.0, 0.0
        self._armed = False

    def __enter__(self) -> Self:
        is_main = threading.current_thread() is threading.main_thread()
        self._watches = is_main and hasattr(signal, "setitimer")
        if self._watches:
            self._before = signal.signal(signal.SIGALRM, self._ring)
            self._timer_before = signal.setitimer(signal.ITIMER_REAL, 0.0)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._watches:
            signal.signal(signal.SIGALRM, self._before)
            signal.setitimer(signal.ITIMER_REAL, *self._timer_before)
            self._watches = False

    def call(self, what: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a function.

        Raises
        ------
        ComputesTooLong
            If it takes too long.
        """
        if not self._watches:
            return what(*args, **kwargs)
        self._began = thread_time(), monotonic()
        self._armed = True
        signal.setitimer(signal.ITIMER_REAL, self.limit_s)
        try:
            return what(*args, **kwargs)
        finally:
            self._armed = False
            signal.setitimer(signal.ITIMER_REAL, 0.0)

    def _ring(self, _: int, frame: FrameType | None) -> None:
        if not self._armed:
            return
        if frame is None or frame.f_code.co_filename == __file__ or _loses_errors(frame):
            signal.setitimer(signal.ITIMER_REAL, RETRY_INTERVAL_S)
            return
        began_cpu_s, began_s = self._began
        if _compiles(frame):
            self._began = thread_time(), monotonic()
            signal.setitimer(signal.ITIMER_REAL, self.limit_s)
            return
        left_s = self.limit_s - (thread_time() - began_cpu_s)
        if left_s > 0.0 and monotonic() - began_s < MAX_WALL_FACTOR * self.limit_s:
            signal.setitimer(signal.ITIMER_REAL, max(left_s, RETRY_INTERVAL_S))
            return
        signal.setitimer(signal.ITIMER_REAL, RETRY_INTERVAL_S)
        raise ComputesTooLong(frame)


def _loses_errors(frame: FrameType) -> bool:
    # Errors of a callback of the garbage collection or of a weak reference, which are functions of
    # libraries, are discarded with a warning. Those of finalizers are, too, but these may be what
    # takes too long.
    callbacks = [getattr(callback, "__code__", None) for callback in gc.callbacks]
    return any(
        caller.f_code in callbacks or caller.f_globals.get("__name__") in WEAK_REFERENCES
        for caller in _with_callers(frame)
    )


def _compiles(frame: FrameType) -> bool:
    names = (str(caller.f_globals.get("__name__", "")) for caller in _with_callers(frame))
    return any(name.startswith("numba.core") for name in names)


def _with_callers(frame: FrameType | None) -> Iterator[FrameType]:
    while frame is not None:
        yield frame
        frame = frame.f_back
