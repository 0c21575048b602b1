"""Making all runs of an experiment that are missing, on this machine's cores or on a cluster's."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass

from multisrt.experiments.crossing import PlannedRun
from multisrt.experiments.description import ExperimentSpec
from multisrt.experiments.job import Job
from multisrt.experiments.modules import import_modules
from multisrt.experiments.results import Result
from multisrt.experiments.store import Store
from multisrt.experiments.worker import StoppedError, Worker
from multisrt.geometry.errors import InvalidInputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """How far an experiment is.

    Attributes
    ----------
    total : int
        Runs that it has.
    done : int
        Runs that are stored, those of earlier calls among them.
    failed : int
        Those of them that have to be looked at.
    made : int
        Runs made by this call.
    elapsed_s : float
        How long it has been at it.
    latest : Result or None
        The run that was stored last; None at the beginning.
    """

    total: int
    done: int
    failed: int
    made: int
    elapsed_s: float
    latest: Result | None

    @property
    def per_hour(self) -> float | None:
        """Runs in an hour; None before the first."""
        return self.made / self.elapsed_s * 3600.0 if self.made and self.elapsed_s > 0.0 else None

    @property
    def left_s(self) -> float | None:
        """How long the rest will take at this rate; None before the first run."""
        rate = self.per_hour
        return None if rate is None else (self.total - self.done) / rate * 3600.0


Watch = Callable[[Progress], None]
"""Is told of the progress at the beginning and after every run, in the caller's thread."""


def run_experiment(
    store: Store,
    *,
    workers: int | None = None,
    cluster: str | None = None,
    modules: Sequence[str] = (),
    progress: Watch | None = None,
) -> None:
    """Make all runs of an experiment that are missing.

    Each is stored as it ends, so that nothing but the runs under way is lost if this is
    interrupted, whatever by; called again, it goes on. The results are the same with any number
    of workers and on a cluster, but for what the runs took of the computer.

    Parameters
    ----------
    store : Store
        The experiment's, open for writing.
    workers : int, optional
        Processes on this machine; by default one for each core.
    cluster : str, optional
        Address of a scheduler of `dask.distributed` instead, such as ``tcp://host:8786``.
    modules : sequence of str
        What workers import at their start, for the strategies that it registers.
    progress : callable, optional
        Is told of the progress.

    Raises
    ------
    InvalidInputError
        If workers cannot begin, the cluster cannot be reached or runs another program, or the
        store or a recording cannot be written. What is stored by then stays.
    KeyboardInterrupt
        As it came; the workers have been stopped, and what has ended is stored.
    """
    if workers is not None and workers < 1:
        raise InvalidInputError(f"runs are made by at least one worker, not {workers}")
    if cluster is not None and workers is not None:
        raise InvalidInputError("give workers or a cluster, not both: a cluster has its own")
    import_modules(modules)
    missing = store.missing()
    total, failed = store.asked, store.failed
    earlier = total - len(missing)
    begin = time.perf_counter()

    def tell(made: int, latest: Result | None) -> None:
        if progress is not None:
            progress(
                Progress(
                    total=total,
                    done=earlier + made,
                    failed=failed,
                    made=made,
                    elapsed_s=time.perf_counter() - begin,
                    latest=latest,
                )
            )

    tell(0, None)
    if not missing:
        return
    jobs = _jobs(store, missing)
    if cluster is None:
        results = _made_here(jobs, min(workers or cores(), len(missing)), modules)
    else:
        from multisrt.experiments.cluster import made_on_cluster

        results = made_on_cluster(jobs, cluster, modules)
    with closing(results):
        for made, result in enumerate(results, start=1):
            store.add(result)
            failed += result.failed
            tell(made, result)


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def job_of(run: PlannedRun, experiment: ExperimentSpec, recording: str = "") -> Job:
    """Give the job that makes a run.

    Parameters
    ----------
    run : PlannedRun
        The run.
    experiment : ExperimentSpec
        What it is of.
    recording : str
        Where the recording goes if it is kept.
    """
    return Job(
        key=run.key,
        condition=run.condition,
        repetition=run.repetition,
        spec=run.spec,
        limits=experiment.limits,
        recording="" if experiment.recordings == "none" else recording,
        only_failed=experiment.recordings == "failed",
    )


def _jobs(store: Store, missing: Sequence[PlannedRun]) -> Iterator[Job]:
    for run in missing:
        yield job_of(run, store.experiment, str(store.recording_path(run.key)))


def _made_here(
    jobs: Iterator[Job], workers: int, modules: Sequence[str]
) -> Generator[Result, None, None]:
    # Every worker has a thread that hands it one job after another; results come as they end.
    waiting = _Shared(jobs)
    answers: queue.SimpleQueue[Result | BaseException | None] = queue.SimpleQueue()

    def serve(worker: Worker) -> None:
        try:
            while (job := waiting.next()) is not None:
                answers.put(worker.make(job))
            answers.put(None)
        except StoppedError:
            pass  # nobody waits for more
        except BaseException as error:
            answers.put(error)

    handles = [Worker(modules) for _ in range(workers)]
    threads = [threading.Thread(target=serve, args=(handle,), daemon=True) for handle in handles]
    try:
        for thread in threads:
            thread.start()
        busy = workers
        while busy:
            answer = answers.get()
            if isinstance(answer, BaseException):
                raise answer
            if answer is None:
                busy -= 1
            else:
                yield answer
    finally:
        for handle in handles:
            handle.stop()
        for thread in threads:
            thread.join()


class _Shared:
    """An iterator that several threads take from."""

    def __init__(self, jobs: Iterator[Job]) -> None:
        self._jobs = jobs
        self._lock = threading.Lock()

    def next(self) -> Job | None:
        with self._lock:
            return next(self._jobs, None)
