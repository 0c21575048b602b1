"""Executing runs on a cluster of `dask.distributed`.

Each thread of a cluster's workers keeps a worker process of ours, which makes one run after
another as on a single machine, with the same limits and the same reports of crashes. Jobs hold
everything that a run depends on: machines of the cluster need no file of the experiment, but the
same packages; other versions are refused. If a machine is lost, the scheduler gives its runs to
others; keys of runs keep results from being stored twice.
"""

from __future__ import annotations

import logging
import queue
import re
import tempfile
import threading
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from multisrt.experiments.job import Job
from multisrt.experiments.provenance import Provenance
from multisrt.experiments.results import Result
from multisrt.experiments.worker import Worker
from multisrt.extras import extra
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import atomic_write

if TYPE_CHECKING:
    from distributed import Client

TIMEOUT_S = 10.0
"""Time within which a scheduler must answer (s)."""

POLL_S = 1.0
"""Interval at which the cluster is looked at while no run ends (s)."""

RUNS_PER_THREAD = 2
"""Runs submitted for each thread of the cluster: the one it makes and the next."""

MIN_SUBMITTED = 8
"""Runs submitted at least, so that workers that join later find some."""


def made_on_cluster(
    jobs: Iterator[Job],
    address: str,
    made_by: Provenance,
    modules: Sequence[str] = (),
) -> Generator[Result, None, None]:
    """Execute runs on a cluster; recordings are written on this machine.

    Parameters
    ----------
    jobs : iterator of Job
        The runs, taken as the cluster has room.
    address : str
        Address of the scheduler, such as ``tcp://host:8786``.
    made_by : Provenance
        Provenance that workers must have.
    modules : sequence of str
        Modules that workers import.

    Yields
    ------
    Result
        Results in the order in which runs end.

    Raises
    ------
    InvalidInputError
        If the scheduler cannot be reached or is lost, or if its workers run another version of
        this program.
    MissingExtraError
        If `distributed` is not installed here.
    """
    client = _client(address)
    with _unlogged():
        try:
            mine = msgspec.json.encode(made_by)
            yield from _made(client, jobs, address, mine, tuple(modules))
        finally:
            client.close(timeout=TIMEOUT_S)


@contextmanager
def _unlogged() -> Iterator[None]:
    """Leave it to the errors raised here to tell of a loss, which the client logs at length."""
    log = logging.getLogger("distributed.client")
    was_disabled, log.disabled = log.disabled, True
    try:
        yield
    finally:
        log.disabled = was_disabled


def _client(address: str) -> Client:
    with extra("cluster", "a cluster"):
        from distributed import Client
    if re.fullmatch(r"(tcp|tls|ws|wss|ucx)://.+:\d{1,5}/?", address) is None:
        raise InvalidInputError(
            f"the address of a scheduler is like tcp://host:8786, not {address!r}"
        )
    try:
        return Client(address, timeout=TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise InvalidInputError(
            f"no scheduler of dask.distributed answers at {address!r} ({error}); start one with "
            "'dask scheduler', and workers with 'dask worker ADDRESS'"
        ) from None


def _made(
    client: Client, jobs: Iterator[Job], address: str, mine: bytes, modules: tuple[str, ...]
) -> Iterator[Result]:
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
    under_way: dict[Any, Job] = {}

    def submit() -> None:
        with _reported_when_lost(address):
            threads = sum(client.ncores().values())
        most = max(MIN_SUBMITTED, RUNS_PER_THREAD * threads)
        for job in islice(jobs, max(0, most - len(under_way))):
            future = client.submit(
                run_job_remotely, msgspec.json.encode(job), mine, modules, pure=False
            )
            under_way[future] = job
            future.add_done_callback(ended.put)

    submit()
    while under_way:
        try:
            future = ended.get(timeout=POLL_S)
        except queue.Empty:
            if client.status != "running":
                raise _lost(address) from None
            submit()  # workers may have joined
            continue
        job = under_way.pop(future)
        with _reported_when_lost(address):
            result, recording = _outcome(future, job, address)
        if recording is not None:
            with atomic_write(Path(job.recording)) as file:
                file.write(recording)
        submit()
        yield result


def _outcome(future: Any, job: Job, address: str) -> tuple[Result, bytes | None]:
    from distributed import KilledWorker

    if future.status == "cancelled":
        raise _lost(address)
    error = future.exception()
    if error is None:
        made, recording = future.result()
        return msgspec.json.decode(made, type=Result), recording
    if isinstance(error, KilledWorker):
        reason = "every worker of the cluster that tried it was lost"
        return job.without_result("crashed", reason), None
    if isinstance(error, InvalidInputError):
        raise InvalidInputError(f"the cluster at {address!r}: {error}") from None
    raise InvalidInputError(
        f"the cluster at {address!r} cannot start runs ({type(error).__name__}: {error}); install "
        "the same multisrt there as here"
    ) from None


@contextmanager
def _reported_when_lost(address: str) -> Iterator[None]:
    """Turn the loss of the scheduler, at any call, into InvalidInputError."""
    try:
        yield
    except (OSError, CancelledError):
        raise _lost(address) from None


def _lost(address: str) -> InvalidInputError:
    return InvalidInputError(
        f"lost the scheduler at {address!r}; finished runs are stored, and the same command "
        "continues"
    )


# On the cluster ------------------------------------------------------------------------------


def run_job_remotely(
    job: bytes, expected: bytes, modules: tuple[str, ...]
) -> tuple[bytes, bytes | None]:
    """Execute a run in a thread of a cluster's worker.

    Parameters
    ----------
    job : bytes
        A `Job`, as JSON.
    expected : bytes
        The `Provenance` of the process that submits it, as JSON.
    modules : tuple of str
        Modules that our worker process imports.

    Returns
    -------
    result : bytes
        The `Result`, as JSON.
    recording : bytes or None
        The recording, if it is kept.

    Raises
    ------
    InvalidInputError
        If our worker process cannot start here, or has another provenance.
    """
    asked = msgspec.json.decode(job, type=Job)
    worker = _worker_of_thread(expected, modules)
    if not asked.recording:
        return msgspec.json.encode(worker.make(asked)), None
    with tempfile.TemporaryDirectory(prefix="multisrt-") as folder:
        path = Path(folder) / "recording.jsonl"
        result = worker.make(msgspec.structs.replace(asked, recording=str(path)))
        return msgspec.json.encode(result), path.read_bytes() if path.exists() else None


_kept = threading.local()


def _worker_of_thread(expected: bytes, modules: tuple[str, ...]) -> Worker:
    """Return the worker of this thread, kept between runs; it ends with this process."""
    worker: Worker
    if getattr(_kept, "given", None) == (expected, modules):
        worker = _kept.worker
        return worker
    if hasattr(_kept, "worker"):
        _kept.worker.stop()
    worker = Worker(modules, msgspec.json.decode(expected, type=Provenance))
    _kept.worker, _kept.given = worker, (expected, modules)
    return worker
