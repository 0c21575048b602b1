"""Executing the runs of a competition in processes of their own."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from multisrt.competition.clone import Clone
from multisrt.competition.jobs import Job, JobResult
from multisrt.competition.policies import PolicySource
from multisrt.competition.published import budget
from multisrt.competition.simulator import simulate
from multisrt.geometry.errors import InvalidInputError


def planned(
    clone: Clone,
    maps: Sequence[str],
    teams: Sequence[int],
    starts: Sequence[tuple[int, int]],
    *,
    number: int,
    seed: int,
    steps: int | None = None,
) -> tuple[Job, ...]:
    """Return the runs on some maps with some teams.

    Parameters
    ----------
    clone : Clone
        The competition.
    maps : sequence of str
        Names of maps.
    teams : sequence of int
        Numbers of robots.
    starts : sequence of (column, row)
        Where all robots start, on one map; none to draw starts.
    number, seed : int
        How many starts are drawn on each map, and the seed.
    steps : int, optional
        Number of steps; by default that of the competition.

    Raises
    ------
    InvalidInputError
        If starts are given for several maps, or one is not free.
    """
    if starts and len(maps) != 1:
        raise InvalidInputError(
            f"a start is a cell of one map, and {len(maps)} are to be run: give one with --maps"
        )
    jobs = []
    for name in maps:
        for start in starts:
            clone.require_start(name, start)
        places = tuple(starts) or clone.starts(name, number, seed)
        jobs += [
            Job(map=name, robots=n, start=start, steps=steps or budget(name, n))
            for n in teams
            for start in places
        ]
    return tuple(jobs)


def execute(
    folder: Path,
    any_version: bool,
    source: PolicySource,
    jobs: Sequence[Job],
    workers: int,
    *,
    as_it_is: bool = False,
) -> Iterator[tuple[Job, JobResult]]:
    """Make runs in some processes, and yield each with its result as it ends.

    Parameters
    ----------
    folder, any_version
        As for `Clone`.
    source : PolicySource
        The policy.
    jobs : sequence of Job
        The runs.
    workers : int
        Number of processes.
    as_it_is : bool
        As for `simulate`.

    Raises
    ------
    InvalidInputError
        If the policy fails, or a process ends.
    """
    if not jobs:
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(workers, len(jobs)), mp_context=context)
    try:
        waiting, running = list(reversed(jobs)), dict[Future[JobResult], Job]()
        while waiting or running:
            while waiting and len(running) < workers:
                job = waiting.pop()
                running[pool.submit(simulate, folder, any_version, source, job, as_it_is)] = job
            ended, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in ended:
                yield running.pop(future), future.result()
    except BrokenProcessPool as error:
        raise InvalidInputError(
            "a process of the runs ended: out of memory? try fewer --workers; the same command "
            "goes on"
        ) from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
