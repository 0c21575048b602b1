"""What this machine is good for: by it figures of two machines can be compared.

Ratios hardly depend on it; times do, and most of all on how long memory lets wait that the
second-level cache does not hold. Who shares a processor with others may wait several times as long.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable

import numpy as np

from multisrt.geometry.numerics.kernel import IntArray, kernel

CALLS = 1_000_000
FAR_MB = 16
LINE = 8
"""Numbers in a line of the cache."""

REPEATS = 5


def account() -> str:
    """Say in one line what runs the benchmarks, and how fast it does simple things."""
    return (
        f"{os.cpu_count()} processors, Python {platform.python_version()}; "
        f"a call of a function {_call_s() * 1e9:.0f} ns, "
        f"memory anywhere in {FAR_MB} MB {_access_s() * 1e9:.0f} ns"
    )


def _call_s() -> float:
    def nothing() -> None:
        pass

    def calls() -> None:
        for _ in range(CALLS):
            nothing()

    return _best_s(calls) / CALLS


def _access_s() -> float:
    # One line after the other in an order that no processor foresees.
    lines = FAR_MB * 1_000_000 // (8 * LINE)
    order = np.random.default_rng(0).permutation(lines) * LINE
    following = np.zeros(lines * LINE, np.int64)
    following[order] = np.roll(order, -1)
    _follow(following, 1)
    return _best_s(lambda: _follow(following, lines)) / lines


@kernel
def _follow(following: IntArray, steps: int) -> int:
    place = 0
    for _ in range(steps):
        place = following[place]
    return place


def _best_s(task: Callable[[], object]) -> float:
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        task()
        times.append(time.perf_counter() - begin)
    return min(times)
