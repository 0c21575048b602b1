"""Planning the runs of a competition, and executing them in separate processes."""

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


def planned_jobs(
    clone: Clone,
    maps: Sequence[str],
    teams: Sequence[int],
    starts: Sequence[tuple[int, int]],
    *,
    draws: int,
    seed: int,
    steps: int | None = None,
) -> tuple[Job, ...]:
    """Return the runs of all given teams on all given maps.

    Parameters
    ----------
    clone : Clone
        The clone of the competition.
    maps : sequence of str
        Names of maps.
    teams : sequence of int
        Numbers of robots.
    starts : sequence of (column, row)
        Cells of a single map in which all robots of a run start; empty to draw them.
    draws, seed : int
        Number of starts drawn on each map, and the seed of the draws.
    steps : int, optional
        Number of steps of a run; that of the competition by default.

    Raises
    ------
    InvalidInputError
        If starts are given and there are several maps, or a start is not a free cell.
    """
    if starts and len(maps) != 1:
        raise InvalidInputError(
            f"a start is a cell of one map, and {len(maps)} are to be run: give one with --maps"
        )
    jobs = []
    for name in maps:
        for start in starts:
            clone.require_start(name, start)
        places = tuple(starts) or clone.starts(name, draws, seed)
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
    """Execute runs in parallel processes, and yield each with its result as it ends.

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
        If the policy fails, or a process is killed.
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
