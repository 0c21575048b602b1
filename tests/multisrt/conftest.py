"""Fixtures for events of recordings, and for tests of experiments.

A module with tests of experiments has an experiment `SPEC`.
"""

import contextlib
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from multisrt import terminal
from multisrt.events import Event
from multisrt.experiments.crossing import runs
from multisrt.experiments.mission import make_run
from multisrt.recording import Recording

RUNNER = """
import sys
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.runner import run_experiment
from multisrt.experiments.store import Store
from multisrt.geometry.errors import InvalidInputError

path, spec, cluster, workers = sys.argv[1:]
where = {"cluster": cluster} if cluster else {"workers": int(workers)}
try:
    with Store.create_or_open(path, ExperimentSpec.from_json(spec)) as store:
        run_experiment(store, progress=lambda p: print(p.done, flush=True), **where)
except InvalidInputError as error:
    sys.exit(str(error))
except KeyboardInterrupt:
    sys.exit(130)
"""


def _events_of(recording: Recording, kind: type[Event], robot: int | None = None) -> list[Any]:
    return [
        event
        for event in recording.events
        if isinstance(event, kind) and robot in (None, event.robot)
    ]


@pytest.fixture(scope="session")
def events_of() -> Callable[..., list[Any]]:
    """List the events of a kind in a recording: those of all robots, or of one."""
    return _events_of


@pytest.fixture(autouse=True)
def unhurried(monkeypatch):
    """Write no line of progress because a machine is slow."""
    monkeypatch.setattr(terminal, "FIRST_S", 3600.0)


@pytest.fixture
def forgotten(monkeypatch, tmp_path_factory):
    """Forget after a test which modules it imported."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        file = getattr(sys.modules[name], "__file__", None)
        if file is not None and Path(file).is_relative_to(tmp_path_factory.getbasetemp()):
            del sys.modules[name]


@pytest.fixture
def path(tmp_path) -> Path:
    """Path of a store that does not exist yet."""
    return tmp_path / "results.sqlite"


@pytest.fixture(scope="module")
def undisturbed(request) -> dict[str, str]:
    """Digests of all runs of the module's experiment, made in this process."""
    spec = request.module.SPEC
    return {run.key: make_run(run, spec.limits).digest for run in runs(spec)}


@contextlib.contextmanager
def _killed_at_the_end(command: list[str], **options):
    with subprocess.Popen(command, text=True, **options) as process:
        try:
            yield process
        finally:
            process.kill()


@pytest.fixture(scope="session")
def killed_at_the_end():
    """Start a process that is killed when its block ends."""
    return _killed_at_the_end


@pytest.fixture
def runner(request):
    """Start a process that makes an experiment's runs and prints their number after each.

    With two local workers, or on the cluster at an address; the code `before` is run first.
    """

    def started(
        path: Path, spec=request.module.SPEC, *, cluster="", workers=2, before="", **options
    ):
        command = [sys.executable, "-c", before + RUNNER, str(path), spec.to_json(), cluster]
        command.append(str(workers))
        return _killed_at_the_end(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options
        )

    return started
