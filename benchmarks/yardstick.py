"""A fixed portion of work, the unit in which the cost of whole runs is stated.

A time in seconds means little without the machine that it was measured on. The cost of a run is
therefore given in yardsticks, measured alternately with it on the same machine. A yardstick is made
of what a run is made of, in about the same shares of its time: Python objects (half), calls of
numpy on small arrays (a quarter), compiled loops over a grid and steps through memory that no
cache holds (a quarter). It calls nothing of the library, so that its cost stays the same when the
library changes.
"""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context

import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel

EVENTS = 4000
"""Events that one yardstick puts into a queue and takes out of it."""

ARRAY_CALLS = 200
"""Passes over a small array, of five calls of numpy each."""

SWEEPS = 2
"""Passes over the grid."""

STEPS = 10_000
"""Steps through memory, each to a line of the cache that cannot be foreseen."""

GRID = 400
"""Rows and columns of the grid."""

FAR_MB = 16
"""Memory that the steps go through; more than most caches of one core hold."""

CACHE_LINE = 8
"""Numbers of eight bytes in a line of the cache."""

BATCH = 5
"""Yardsticks that are timed as one, of which the mean is taken."""

Clock = Callable[[], float]


@dataclass(frozen=True, slots=True)
class _Event:
    time_s: float
    robot: int
    place: tuple[float, float]


def yardstick(place: int = 0) -> int:
    """Do the work of one yardstick.

    Parameters
    ----------
    place : int, optional
        Where the steps through memory begin.

    Returns
    -------
    int
        Where they end: the next yardstick begins there, in memory that no cache holds yet.
    """
    points, grid, following = _material()
    _objects()
    _arrays(points)
    _sweep(grid, SWEEPS)
    return follow(following, place, STEPS)


def yardstick_s(clock: Clock = time.process_time) -> float:
    """Return the time of one yardstick in seconds, the mean over a batch of them."""
    place = yardstick()
    begin = clock()
    for _ in range(BATCH):
        place = yardstick(place)
    return (clock() - begin) / BATCH


def yardstick_at_once_s(processes: int, batches: int = 20) -> float:
    """Return the time by the clock from one yardstick to the next in several processes at once.

    Two processes on two idle processors take half the time of one process; on processors that
    share caches, or that others use as well, they take more.

    Parameters
    ----------
    processes : int
        Number of processes that work at the same time.
    batches : int, optional
        Batches of yardsticks that every process works through.

    Returns
    -------
    float
        Seconds divided by the yardsticks of all processes together.
    """
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        list(pool.map(_work, [1] * processes))  # imports and compiles
        begin = time.perf_counter()
        list(pool.map(_work, [batches] * processes))
        return (time.perf_counter() - begin) / (processes * batches * BATCH)


def _work(batches: int) -> None:
    for _ in range(batches):
        yardstick_s()


@cache
def _material() -> tuple[FloatArray, FloatArray, IntArray]:
    rng = np.random.default_rng(0)
    return rng.uniform(size=(200, 2)), rng.uniform(size=(GRID, GRID)), chain(FAR_MB)


def chain(megabytes: int) -> IntArray:
    """Return indices that lead through memory in one cycle, one index in each line of the cache."""
    lines = megabytes * 1_000_000 // (8 * CACHE_LINE)
    order = np.random.default_rng(0).permutation(lines) * CACHE_LINE
    following = np.zeros(lines * CACHE_LINE, np.int64)
    following[order] = np.roll(order, -1)
    return following


def _objects() -> float:
    # A queue of events, small immutable objects, tuples as keys: what a simulation does.
    queue: list[tuple[float, int]] = []
    for number in range(EVENTS):
        heapq.heappush(queue, ((number * 7919 % EVENTS) / EVENTS, number))
    latest: dict[tuple[int, int], _Event] = {}
    total = 0.0
    while queue:
        time_s, number = heapq.heappop(queue)
        event = _Event(time_s, number % 8, (time_s, number / EVENTS))
        before = latest.get((event.robot, number % 50))
        latest[event.robot, number % 50] = event
        total += 0.0 if before is None else event.time_s - before.time_s
    return total + sum(place[0] for place in sorted(event.place for event in latest.values()))


def _arrays(points: FloatArray) -> float:
    total = 0.0
    for call in range(ARRAY_CALLS):
        distances = np.hypot(*(points - points[call]).T)
        near = np.flatnonzero(distances < 0.5)
        total += float(distances[near].sum()) + int(np.argmin(distances))
    return total


@kernel
def _sweep(grid: FloatArray, times: int) -> float:
    rows, columns = grid.shape
    total = 0.0
    for _ in range(times):
        for row in range(1, rows - 1):
            for column in range(1, columns - 1):
                a = min(grid[row - 1, column], grid[row + 1, column])
                b = min(grid[row, column - 1], grid[row, column + 1])
                if abs(a - b) < 0.5:
                    total += 0.5 * (a + b + np.sqrt(0.5 - (a - b) ** 2))
                else:
                    total += min(a, b)
    return total


@kernel
def follow(following: IntArray, place: int, steps: int) -> int:
    """Return the index that a number of steps along a chain leads to."""
    for _ in range(steps):
        place = following[place]
    return place
