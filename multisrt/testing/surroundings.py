"""Surroundings of a run that explorers must not depend on: global random states and clocks."""

from __future__ import annotations

import datetime
import random
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import count
from types import ModuleType
from typing import Any

import numpy as np

CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
"""Clocks of the module `time`; each has a variant with `_ns` that counts nanoseconds."""


@contextmanager
def surroundings(
    modules: Sequence[ModuleType], *, seed: int, clock_s: float
) -> Iterator[Callable[[], bool]]:
    """Replace the states of the global random generators and all clocks within a context.

    Parameters
    ----------
    modules : sequence of module
        Modules that may have names of their own for clocks.
    seed : int
        Seed of the global random generators.
    clock_s : float
        Where clocks start, in seconds; they advance by a millisecond whenever they are read.

    Yields
    ------
    callable
        Returns whether one of the global random generators has been drawn from.
    """
    states = random.getstate(), np.random.get_state()  # noqa: NPY002
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    seeded = _global_states()
    replaced = _clocks(clock_s)
    with ExitStack() as stack:
        stack.callback(np.random.set_state, states[1])
        stack.callback(random.setstate, states[0])
        for module in (time, datetime, *modules):
            for name, value in list(vars(module).items()):
                if (other := replaced.get(id(value))) is not None:
                    stack.callback(setattr, module, name, value)
                    setattr(module, name, other)
        yield lambda: _global_states() != seeded


def _global_states() -> tuple[object, ...]:
    name, key, *rest = np.random.get_state(legacy=True)  # noqa: NPY002
    return random.getstate(), name, np.asarray(key).tobytes(), *rest


def _clocks(clock_s: float) -> dict[int, Any]:
    # The replacement of each clock, by the id of the clock.
    ticks = count()

    def seconds() -> float:
        return clock_s + 1e-3 * next(ticks)

    class Datetime(datetime.datetime):
        @classmethod
        def now(cls, tz: datetime.tzinfo | None = None) -> Datetime:
            return cls.fromtimestamp(seconds(), tz)

        @classmethod
        def utcnow(cls) -> Datetime:
            return cls.fromtimestamp(seconds(), datetime.UTC).replace(tzinfo=None)

        @classmethod
        def today(cls) -> Datetime:
            return cls.fromtimestamp(seconds())

    replaced: dict[int, Any] = {id(datetime.datetime): Datetime}
    for name in CLOCKS:
        replaced[id(getattr(time, name))] = seconds
        replaced[id(getattr(time, f"{name}_ns"))] = lambda: int(1e9 * seconds())
    return replaced
