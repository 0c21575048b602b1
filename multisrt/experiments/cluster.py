"""Making runs on a cluster of `dask.distributed`.

Each thread of a cluster's workers has a worker process of our own, which makes one run after
another as on a single machine: limits hold, and crashes are told, in the same way. Jobs carry all
that a run depends on, so that machines of the cluster need no file of the experiment, but they
need the same packages: another program is refused. If a machine is lost, the scheduler gives its
runs to others; as every run has its key, none is there twice.
"""

from __future__ import annotations

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
from multisrt.experiments.provenance import Provenance, provenance
from multisrt.experiments.results import Result
from multisrt.experiments.worker import Worker
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import written_whole

if TYPE_CHECKING:
    from distributed import Client

TIMEOUT_S = 10.0
"""How long a scheduler may take to answer."""

LOOK_S = 1.0
"""How often to look after the cluster while no run ends."""

AT_A_TIME = 2
"""Runs that are handed out for each thread of the cluster: the one that it makes and the next."""

FEWEST_HANDED_OUT = 8
"""Runs that are handed out at least, so that workers that join later find some."""


def made_on_cluster(
    jobs: Iterator[Job], address: str, modules: Sequence[str] = ()
) -> Generator[Result, None, None]:
    """Make runs on a cluster and give their results as they end; recordings are written here.

    Parameters
    ----------
    jobs : iterator of Job
        What to make; taken as there is room.
    address : str
        The scheduler's, such as ``tcp://host:8786``.
    modules : sequence of str
        What workers import at their start.

    Raises
    ------
    InvalidInputError
        If `distributed` is not installed here, if the scheduler cannot be reached or is lost, or
        if its workers are not the program that asks.
    """
    client = _client(address)
    try:
        yield from _made(client, jobs, address, tuple(modules))
    finally:
        client.close(timeout=TIMEOUT_S)


def _client(address: str) -> Client:
    try:
        from distributed import Client
    except ImportError:
        raise InvalidInputError(
            "a cluster needs the package 'distributed'; pip install 'multisrt[cluster]'"
        ) from None
    if re.fullmatch(r"(tcp|tls|ws|wss|ucx)://.+:\d{1,5}/?", address) is None:
        raise InvalidInputError(
            f"the address of a scheduler is like tcp://host:8786, not {address!r}"
        )
    try:
        return Client(address, timeout=TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise InvalidInputError(
            f"no scheduler of dask.distributed answers at {address!r} ({error}); begin one by "
            "'dask scheduler', and workers by 'dask worker ADDRESS'"
        ) from None


def _made(
    client: Client, jobs: Iterator[Job], address: str, modules: tuple[str, ...]
) -> Iterator[Result]:
    mine = msgspec.json.encode(provenance())
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
    under_way: dict[Any, Job] = {}

    def hand_out() -> None:
        with _told_when_lost(address):
            threads = sum(client.ncores().values())
        most = max(FEWEST_HANDED_OUT, AT_A_TIME * threads)
        for job in islice(jobs, max(0, most - len(under_way))):
            future = client.submit(make_there, msgspec.json.encode(job), mine, modules, pure=False)
            under_way[future] = job
            future.add_done_callback(ended.put)

    hand_out()
    while under_way:
        try:
            future = ended.get(timeout=LOOK_S)
        except queue.Empty:
            if client.status != "running":
                raise _lost(address) from None
            hand_out()  # there may be more workers by now
            continue
        job = under_way.pop(future)
        with _told_when_lost(address):
            result, recording = _outcome(future, job, address)
        if recording is not None:
            with written_whole(Path(job.recording)) as file:
                file.write(recording)
        hand_out()
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
        reason = "every worker of the cluster that was to make it was lost"
        return job.without_result("crashed", reason), None
    if isinstance(error, InvalidInputError):
        raise InvalidInputError(f"the cluster at {address!r}: {error}") from None
    raise InvalidInputError(
        f"the cluster at {address!r} cannot make runs ({type(error).__name__}: {error}); install "
        "the same multisrt there as here"
    ) from None


@contextmanager
def _told_when_lost(address: str) -> Iterator[None]:
    # A scheduler may be lost at any question that is put to it.
    try:
        yield
    except (OSError, CancelledError):
        raise _lost(address) from None


def _lost(address: str) -> InvalidInputError:
    return InvalidInputError(
        f"lost the scheduler at {address!r}; finished runs are stored, and the same command "
        "continues"
    )


# On the cluster -----------------------------------------------------------------------------


def make_there(job: bytes, expected: bytes, modules: tuple[str, ...]) -> tuple[bytes, bytes | None]:
    """Make a run within a thread of a cluster's worker; bytes in and out.

    Parameters
    ----------
    job : bytes
        The `Job`, as JSON.
    expected : bytes
        The `Provenance` of who asks, as JSON.
    modules : tuple of str
        What our worker imports at its start.

    Returns
    -------
    result : bytes
        The `Result`, as JSON.
    recording : bytes or None
        The recording, if it is kept.

    Raises
    ------
    InvalidInputError
        If our worker cannot begin here, or is not the program of who asks.
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
    # Kept between runs; it ends with the process whose pipes it reads.
    worker: Worker
    if getattr(_kept, "given", None) == (expected, modules):
        worker = _kept.worker
        return worker
    if hasattr(_kept, "worker"):
        _kept.worker.stop()
    worker = Worker(modules, msgspec.json.decode(expected, type=Provenance))
    _kept.worker, _kept.given = worker, (expected, modules)
    return worker
