"""Batches of inputs in processes of their own, which may crash, hang or run out of memory.

A process takes one input after the other and reports each. If it ends before its batch does, its
current input caused that, and another process continues with the next input. The system ends a
process whose input takes too long, so that compiled code is interrupted, too.
"""

from __future__ import annotations

import multiprocessing
import resource
import signal
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Final

from benchmarks.fuzz.judging import MAX_MEMORY, MAX_SECONDS, Outcome, Verdict, judge
from benchmarks.fuzz.target import Target

MAX_IDLE_S: Final = 120.0
"""Time in seconds without a report after which a process is ended, even if it is idle."""

ROOM: Final = 3 * MAX_MEMORY
"""Memory that a process may allocate in addition to its initial size, in bytes."""

_FORK: Final = multiprocessing.get_context("fork")


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """Inputs of one reader.

    Attributes
    ----------
    target : Target
        The reader.
    seed : int
        Seed of the campaign.
    numbers : range
        Numbers of the inputs.
    workers : int
        Number of processes at a time.
    """

    target: Target
    seed: int
    numbers: range
    workers: int = 1


@dataclass(slots=True)
class _Batch:
    """Numbers of the inputs that are still to be read, and the process that reads the first."""

    numbers: range
    folder: Path
    process: BaseProcess
    reports: Connection


def run(campaign: Campaign) -> Iterator[tuple[int, Outcome]]:
    """Yield the results of the inputs of a campaign, with their numbers.

    Parameters
    ----------
    campaign : Campaign
        The inputs, and how they are read.
    """
    campaign.target.warm_up()
    numbers, workers = campaign.numbers, campaign.workers
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        batches = [
            _started(campaign, numbers[first::workers], Path(folder) / str(first))
            for first in range(min(workers, len(numbers)))
        ]
        try:
            while batches:
                yield from _reports(campaign, batches)
        finally:
            for batch in batches:
                batch.process.kill()
                batch.process.join()


def _reports(campaign: Campaign, batches: list[_Batch]) -> Iterator[tuple[int, Outcome]]:
    """Yield the results reported since, and restart processes that have ended too early."""
    ready = wait([batch.reports for batch in batches], MAX_IDLE_S)
    for batch in list(batches):
        has_ended = False
        if batch.reports in ready:
            try:
                outcome = batch.reports.recv()
            except EOFError:
                outcome, has_ended = _ended(batch), True
        elif not ready:
            batch.process.kill()
            outcome = Outcome(Verdict.HANG, detail=f"no answer in {MAX_IDLE_S:g} s")
            has_ended = True
        else:
            continue
        yield batch.numbers[0], outcome
        batch.numbers = batch.numbers[1:]
        if has_ended or not batch.numbers:
            batches.remove(batch)
            batch.reports.close()
            batch.process.join()
            if batch.numbers:
                batches.append(_started(campaign, batch.numbers, batch.folder))


def _started(campaign: Campaign, numbers: range, folder: Path) -> _Batch:
    folder.mkdir(exist_ok=True)
    reports, reported = _FORK.Pipe(duplex=False)
    process = _FORK.Process(target=_work, args=(campaign, numbers, folder, reported), daemon=True)
    process.start()
    reported.close()
    return _Batch(numbers, folder, process, reports)


def _ended(batch: _Batch) -> Outcome:
    batch.process.join()
    code = batch.process.exitcode or 0
    if code == -signal.SIGPROF:
        return Outcome(Verdict.HANG, MAX_SECONDS, detail=f"more than {MAX_SECONDS:g} s")
    if code == -signal.SIGKILL:
        return Outcome(Verdict.MEMORY, detail="killed by the system")
    name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    return Outcome(Verdict.CRASH, detail=f"the process ended: {name}")


def _work(campaign: Campaign, numbers: range, folder: Path, reported: Connection) -> None:
    target = campaign.target
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + ROOM, size + ROOM))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    target.prepare(folder)
    for number in numbers:
        one = target.input(campaign.seed, number)
        signal.setitimer(signal.ITIMER_PROF, MAX_SECONDS)
        outcome = judge(target, one, folder)
        signal.setitimer(signal.ITIMER_PROF, 0)
        reported.send(outcome)
