"""The breakages of a cluster of `dask.distributed`, whose processes run on this machine."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from benchmarks.machines.breakages import LeftOutError, kill, workers
from benchmarks.machines.cases import Case, in_words
from benchmarks.machines.processes import Command, started

WORKER: Final = (
    *("-m", "distributed.cli.dask_worker", "--no-nanny", "--nthreads", "1", "--no-dashboard"),
    "--local-directory",
)
"""Starts a worker; a folder for its files and the address of its scheduler follow."""


def killed_cluster_worker(case: Case) -> None:
    """Kill a worker of a cluster, and the process that makes runs for another."""
    with _scheduler(case) as (_, address), _worker(case, address) as doomed:
        with case.running(cluster=address) as command:
            moments = [case.reach(command)]
            doomed.send(signal.SIGKILL)
            doomed.end()
            with _worker(case, address) as worker:
                moments.append(case.reach(command, 1))
                kill(case.draws.choice(workers(worker)))
                case.require_success(command.end())
        case.look()
    case.did.append(f"SIGKILL {in_words(moments)}")


def killed_scheduler(case: Case) -> None:
    """Kill the scheduler of a cluster while the command runs; continue on another."""
    with (
        _scheduler(case) as (scheduler, address),
        _worker(case, address),
        case.running(cluster=address) as command,
    ):
        stored = case.reach(command)
        scheduler.send(signal.SIGKILL)
        case.require_error(command.end(), "lost the scheduler|no scheduler")
    case.require_tidy()
    case.look()
    with (
        _scheduler(case) as (_, address),
        _worker(case, address),
        case.running(cluster=address) as command,
    ):
        case.require_success(command.end())
    case.look()
    case.did.append(f"SIGKILL {in_words([stored])}")


ON_CLUSTER: Final[dict[str, Callable[[Case], None]]] = {
    "cluster-worker": killed_cluster_worker,
    "cluster-scheduler": killed_scheduler,
}
"""The breakages of a cluster, of experiments alone."""


@contextmanager
def _scheduler(case: Case) -> Iterator[tuple[Command, str]]:
    """Start a scheduler, and provide its process and its address."""
    if find_spec("distributed") is None:
        raise LeftOutError("needs the extra 'cluster'")
    file = _files(case) / "scheduler.json"
    file.unlink(missing_ok=True)
    words = ("-m", "distributed.cli.dask_scheduler", "--no-dashboard", "--host", "127.0.0.1")
    with started((*words, "--port", "0", "--scheduler-file", str(file)), file.parent) as command:
        command.wait_until(lambda: _address_in(file) != "", "the scheduler had an address")
        yield command, _address_in(file)


@contextmanager
def _worker(case: Case, address: str) -> Iterator[Command]:
    folder = _files(case)
    variables = {"TMPDIR": str(folder)}
    with started((*WORKER, str(folder), address), folder, environment=variables) as command:
        yield command


def _files(case: Case) -> Path:
    folder = case.folder.with_name(f"{case.folder.name}-cluster")
    folder.mkdir(exist_ok=True)
    return folder


def _address_in(file: Path) -> str:
    try:
        return str(json.loads(file.read_bytes())["address"])
    except (OSError, ValueError, KeyError):
        return ""
