"""One line on the machine that runs the benchmarks: why its times differ from another machine's.

Times depend most of all on how long memory takes that no cache of the core holds. On a processor
that is shared with others this may be several times as long.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable

from benchmarks.yardstick import CACHE_LINE, FAR_MB, chain, follow, yardstick_s

CALLS = 1_000_000
"""Calls of a function that are timed together."""

REPEATS = 5
"""Measurements, of which the shortest counts."""


def account() -> str:
    """Return a line that says what runs the benchmarks, and how fast it does simple things."""
    return (
        f"{os.cpu_count()} processors, Python {platform.python_version()}; "
        f"a call of a function {_call_s() * 1e9:.0f} ns, "
        f"memory anywhere in {FAR_MB} MB {_access_s() * 1e9:.0f} ns, "
        f"a yardstick {min(yardstick_s() for _ in range(REPEATS)) * 1e3:.1f} ms"
    )


def _call_s() -> float:
    def nothing() -> None:
        pass

    def calls() -> None:
        for _ in range(CALLS):
            nothing()

    return _best_s(calls) / CALLS


def _access_s() -> float:
    following = chain(FAR_MB)
    lines = len(following) // CACHE_LINE
    follow(following, 0, 1)
    return _best_s(lambda: follow(following, 0, lines)) / lines


def _best_s(task: Callable[[], object]) -> float:
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        task()
        times.append(time.perf_counter() - begin)
    return min(times)
