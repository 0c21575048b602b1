"""Executing the missing runs of an experiment, on this machine or on a cluster."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from multisrt.experiments.crossing import PlannedRun
from multisrt.experiments.distinct import Twins
from multisrt.experiments.job import Job
from multisrt.experiments.modules import import_modules, worker_references
from multisrt.experiments.references import MissingPlans
from multisrt.experiments.results import Result
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from multisrt.experiments.threads import Shared, from_threads
from multisrt.experiments.under_way import JobsUnderWay
from multisrt.experiments.worker import Worker
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.loading import being_imported


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Progress of an experiment.

    Attributes
    ----------
    total : int
        Number of runs of the experiment.
    done : int
        Number of stored runs, of earlier calls and of this one.
    failed : int
        Number of stored runs that did not succeed.
    made : int
        Number of runs made by this call; copies of them do not count.
    elapsed_s : float
        Elapsed time of this call (s).
    latest : Result or None
        The result that was stored last; None at the beginning.
    what : str
        What is made: "runs", or then "informed plans" if the experiment asks for them.
    under_way : JobsUnderWay
        The runs that are being made meanwhile, and the kernels that are compiled for them; empty
        on a cluster.

    Examples
    --------
    >>> progress = Progress(total=40, done=10, failed=0, made=10, elapsed_s=60.0, latest=None)
    >>> progress.per_hour, progress.left_s
    (600.0, 180.0)
    """

    total: int
    done: int
    failed: int
    made: int
    elapsed_s: float
    latest: Result | None
    what: str = "runs"
    under_way: JobsUnderWay = field(default_factory=JobsUnderWay, compare=False)

    @property
    def per_hour(self) -> float | None:
        """Runs made per hour; None before the first."""
        return self.made / self.elapsed_s * 3600.0 if self.made and self.elapsed_s > 0.0 else None

    @property
    def left_s(self) -> float | None:
        """Remaining time at this rate (s); None before the first run."""
        rate = self.per_hour
        return None if rate is None else (self.total - self.done) / rate * 3600.0


Watch = Callable[[Progress], None]
"""Called at the beginning and after every run, in the caller's thread."""


def run_experiment(
    store: Store,
    *,
    workers: int | None = None,
    cluster: str | None = None,
    modules: Sequence[str] = (),
    progress: Watch | None = None,
) -> None:
    """Execute the runs of an experiment that have no result yet.

    Each result is stored as its run ends: an interruption loses only runs under way, and the next
    call continues. Results do not depend on the number of workers or on the machine that made
    them, except for computing time and memory. Repetitions that differ by their seed alone wait
    for the first of them that comes to an end: if it draws no random number, it is their result,
    too. If the experiment asks for a reference, the plans that stored runs lack are made then.

    Parameters
    ----------
    store : Store
        The store of the experiment, open for writing.
    workers : int, optional
        Number of processes on this machine; by default one for each core. 0: this process makes
        the runs, one after another and without limits of computing time and memory.
    cluster : str, optional
        Address of a `dask.distributed` scheduler instead, such as ``tcp://host:8786``.
    modules : sequence of str
        Modules and files that this process and workers import because they have strategies.
        Strategies that are known here without are imported by workers where that is possible.
    progress : callable, optional
        Called with the `Progress` at the beginning and after every run.

    Raises
    ------
    InvalidInputError
        If workers cannot start or cannot import a strategy, the cluster cannot be reached or runs
        another version of this program, or the store or a recording cannot be written. Stored
        results stay.
    KeyboardInterrupt
        If interrupted; workers are stopped and finished runs stored.

    Examples
    --------
    >>> import multisrt as ms
    >>> spec = ms.ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
    >>> with Store.create_or_open("x.sqlite", spec) as store:  # doctest: +SKIP
    ...     run_experiment(store, progress=lambda now: print(now.done, "of", now.total))
    """
    if workers is not None and workers < 0:
        raise InvalidInputError(f"a number of workers is at least 0, not {workers}")
    if cluster is not None and workers is not None:
        raise InvalidInputError("give workers or a cluster, not both: a cluster has its own")
    require_no_import()
    import_modules(modules)
    under_way = JobsUnderWay()
    tally = _Tally(store, progress, under_way)
    tally.tell(None)
    makers = _Makers(store, workers, cluster, modules, under_way)
    if missing := len(store.missing()):
        with makers.of(missing) as make:
            _make_missing(store, make, tally)
    if store.experiment.reference == "informed":
        plans = MissingPlans(store)
        if jobs := plans.jobs:
            with makers.of(len(jobs)) as make:
                _make_plans(plans, make, progress, under_way)


def require_no_import() -> None:
    """Raise InvalidInputError if a module or file that is being imported asks for runs.

    A script that compares strategies which it defines is imported by workers, and must not begin
    another comparison in each of them.
    """
    if place := being_imported():
        raise InvalidInputError(
            f"{place} runs an experiment when it is imported; put what it does as a "
            "script under if __name__ == '__main__':"
        )


def _make_missing(store: Store, make: Make, tally: _Tally) -> None:
    twins = Twins(store)
    tally.add_copies(twins.copies())
    while batch := twins.next_batch():
        with closing(make(_jobs(store, batch))) as results:
            for result in results:
                tally.add(result)
        tally.add_copies(twins.copies())


def _make_plans(
    plans: MissingPlans, make: Make, progress: Watch | None, under_way: JobsUnderWay
) -> None:
    begin, total = time.perf_counter(), len(plans.jobs)

    def tell(made: int, latest: Result | None) -> None:
        if progress is not None:
            elapsed_s = time.perf_counter() - begin
            progress(
                Progress(
                    total=total,
                    done=made,
                    failed=0,
                    made=made,
                    elapsed_s=elapsed_s,
                    latest=latest,
                    what="informed plans",
                    under_way=under_way,
                )
            )

    tell(0, None)
    with closing(make(iter(plans.jobs))) as results:
        for made, result in enumerate(results, start=1):
            plans.add(result)
            tell(made, result)


class _Tally:
    """Stores results and reports the progress."""

    def __init__(self, store: Store, progress: Watch | None, under_way: JobsUnderWay) -> None:
        self._store = store
        self._under_way = under_way
        self._progress = progress
        self._done, self._failed, self._made = store.done, store.failed, 0
        self._begin = time.perf_counter()

    def add(self, result: Result) -> None:
        """Store the result of a run that was made."""
        self._made += 1
        self._add(result)

    def add_copies(self, copies: Sequence[Result]) -> None:
        """Store the results of runs that need not be made."""
        for result in copies:
            self._add(result)

    def _add(self, result: Result) -> None:
        self._store.add(result)
        self._done += 1
        self._failed += result.failed
        self.tell(result)

    def tell(self, latest: Result | None) -> None:
        """Report the progress."""
        if self._progress is None:
            return
        self._progress(
            Progress(
                total=self._store.planned,
                done=self._done,
                failed=self._failed,
                made=self._made,
                elapsed_s=time.perf_counter() - self._begin,
                latest=latest,
                under_way=self._under_way,
            )
        )


def cores() -> int:
    """Return the number of cores that this process may use.

    Returns
    -------
    int
        At least 1.

    Examples
    --------
    >>> cores() >= 1
    True
    """
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def job_of(run: PlannedRun, experiment: ExperimentSpec, recording: str = "") -> Job:
    """Return the job that executes a run.

    Parameters
    ----------
    run : PlannedRun
        The run.
    experiment : ExperimentSpec
        Its experiment.
    recording : str
        File for the recording, if the experiment keeps it.

    Returns
    -------
    Job
        The job, with the limits of the experiment.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.experiments.crossing import runs
    >>> spec = ms.ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
    >>> job_of(runs(spec)[0], spec).limits.computing_s
    900.0
    """
    return Job(
        key=run.key,
        condition=run.condition,
        repetition=run.repetition,
        spec=run.spec,
        limits=experiment.limits,
        recording="" if experiment.recordings == "none" else recording,
        only_failed=experiment.recordings == "failed",
        success_coverage=experiment.success_coverage,
        horizon_s=experiment.horizon_s,
    )


def _jobs(store: Store, missing: Sequence[PlannedRun]) -> Iterator[Job]:
    for run in missing:
        yield job_of(run, store.experiment, str(store.recording_path(run.key)))


Make = Callable[[Iterator[Job]], Generator[Result, None, None]]
"""Executes runs; their results come in the order in which they end."""


class _Makers:
    """What makes runs, as a user chose: this process, workers on this machine, or a cluster."""

    def __init__(
        self,
        store: Store,
        workers: int | None,
        cluster: str | None,
        modules: Sequence[str],
        under_way: JobsUnderWay,
    ) -> None:
        self._under_way = under_way
        self._workers = cores() if workers is None else workers
        self._cluster = cluster
        self._made_by = store.provenance
        self._modules: tuple[str, ...] = ()
        if self._workers or cluster is not None:
            by_name = cluster is not None
            self._modules = worker_references(store.experiment, modules, by_name=by_name)

    @contextmanager
    def of(self, number: int) -> Iterator[Make]:
        """Provide what makes a number of runs; workers are kept meanwhile."""
        if (cluster := self._cluster) is not None:
            from multisrt.experiments.cluster import made_on_cluster

            yield lambda jobs: made_on_cluster(jobs, cluster, self._made_by, self._modules)
            return
        if not self._workers:
            yield lambda jobs: _made_in_this_process(jobs, self._under_way)
            return
        handles = [Worker(self._modules, self._made_by) for _ in range(min(self._workers, number))]
        try:
            yield lambda jobs: _made_here(jobs, handles, self._under_way)
        finally:
            for handle in handles:
                handle.stop()


def _made_in_this_process(
    jobs: Iterator[Job], under_way: JobsUnderWay
) -> Generator[Result, None, None]:
    from multisrt.experiments.mission import compilation_told, make_run

    for job in jobs:
        with under_way.making(job) as tell, compilation_told(tell):
            result = make_run(
                job.run,
                None,
                Path(job.recording) if job.recording else None,
                only_failed=job.only_failed,
                success_coverage=job.success_coverage,
                horizon_s=job.horizon_s,
            )
        yield result


def _made_here(
    jobs: Iterator[Job], workers: Sequence[Worker], under_way: JobsUnderWay
) -> Generator[Result, None, None]:
    """Yield results as runs end; a thread for each worker gives it one job after another."""
    waiting = Shared(jobs)

    def made_by(worker: Worker) -> Iterator[Result]:
        for job in waiting:
            with under_way.making(job) as tell:
                result = worker.make(job, tell)
            yield result

    def stop() -> None:
        for worker in workers:
            worker.stop()

    return from_threads([made_by(worker) for worker in workers], stop)
