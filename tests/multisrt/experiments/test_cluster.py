"""Runs on a cluster of dask.distributed, whose processes run on this machine."""

import contextlib
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import msgspec
import pytest

from multisrt.experiments.runner import run_experiment
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from multisrt.extras import MissingExtraError
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording

needs_distributed = pytest.mark.skipif(
    find_spec("distributed") is None, reason="needs the extra 'cluster'"
)

SPEC = ExperimentSpec(
    name="small",
    environments=("open",),
    strategies=("srt-star",),
    robots=(2,),
    repetitions=8,
    recordings="all",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder for the scheduler's and the workers' files."""
    return tmp_path_factory.mktemp("cluster")


@pytest.fixture(scope="module", autouse=True)
def own_temporary_files(folder):
    """Let killed processes leave their temporary files in the folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TMPDIR", str(folder))
        yield


@pytest.fixture(scope="module")
def scheduler(folder, killed_at_the_end):
    """Address of a scheduler."""
    file = folder / "scheduler.json"
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--no-dashboard"]
    command += ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file)]
    with killed_at_the_end(command, stderr=subprocess.DEVNULL):
        deadline = time.monotonic() + 60.0
        while True:
            with contextlib.suppress(OSError, msgspec.DecodeError):
                yield msgspec.json.decode(file.read_bytes())["address"]
                return
            assert time.monotonic() < deadline
            time.sleep(0.05)


@pytest.fixture(scope="module")
def cluster_worker(folder, scheduler, killed_at_the_end):
    """Start a worker of the scheduler."""

    def started():
        command = [sys.executable, "-m", "distributed.cli.dask_worker", scheduler, "--no-nanny"]
        command += ["--nthreads", "1", "--no-dashboard", "--local-directory", str(folder)]
        return killed_at_the_end(command, stderr=subprocess.DEVNULL)

    return started


@pytest.fixture(scope="module")
def lasting_worker(cluster_worker):
    """A worker of the scheduler that lives as long."""
    with cluster_worker() as process:
        yield process


def require_all(path: Path, undisturbed: dict[str, str]) -> None:
    with Store.open(path) as store:
        results = store.results()
        assert {result.key: result.digest for result in results} == undisturbed
        assert len(results) == len(undisturbed)
        for key, digest in undisturbed.items():
            assert Recording.load(store.recording_path(key)).footer.digest == digest


@pytest.mark.slow
@needs_distributed
@pytest.mark.usefixtures("lasting_worker")
def test_a_killed_runner_can_continue_and_killing_a_worker_loses_no_run(
    path, scheduler, cluster_worker, runner, undisturbed
):
    with cluster_worker() as doomed:
        with runner(path, cluster=scheduler) as process:
            for line in process.stdout:
                if int(line) == 2:
                    process.kill()
        with Store.open(path) as store:
            before = store.done
        assert 2 <= before < len(undisturbed) - 2
        with runner(path, cluster=scheduler) as process:
            for line in process.stdout:
                if int(line) == before + 1:
                    doomed.kill()
            process.wait()
            assert process.returncode == 0, process.stderr.read()
    require_all(path, undisturbed)


@pytest.mark.slow
@needs_distributed
def test_losing_the_scheduler_is_reported(path, runner, killed_at_the_end):
    code = """
import sys, signal, os
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=1, processes=False, dashboard_address=None,
                      scheduler_port=0, protocol="tcp") as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""
    command = [sys.executable, "-c", code]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with killed_at_the_end(command, **pipes) as cluster:
        address = cluster.stdout.readline().strip()
        with runner(path, cluster=address) as process:
            for line in process.stdout:
                if int(line) == 2:
                    cluster.kill()
            process.wait()
            assert process.returncode == 1
            errors = process.stderr.read()
    assert f"lost the scheduler at '{address}'; finished runs are stored" in errors
    assert len(errors.splitlines()) == 1
    with Store.open(path) as store:
        assert store.done >= 2


@pytest.mark.slow
@needs_distributed
@pytest.mark.usefixtures("lasting_worker")
def test_workers_of_another_version_are_refused(path, scheduler, runner):
    pretend = """
import msgspec
import multisrt.experiments.user_source as user_source
mine = msgspec.structs.replace(user_source.provenance(), program="0123")
user_source.provenance = lambda: mine
"""
    with runner(path, cluster=scheduler, before=pretend) as process:
        _, errors = process.communicate()
        assert process.returncode == 1
    assert f"the cluster at '{scheduler}': a worker runs another program" in errors
    assert "another source of multisrt, 0123 and " in errors
    assert len(errors.splitlines()) == 1


@pytest.mark.slow
@needs_distributed
def test_a_cluster_that_does_not_answer_is_reported(path, runner):
    address = "tcp://127.0.0.1:1"
    few = "import multisrt.experiments.cluster as cluster; cluster.TIMEOUT_S = 1.0"
    with runner(path, cluster=address, before=few) as process:
        _, errors = process.communicate()
        assert process.returncode == 1
    assert errors.startswith(f"no scheduler of dask.distributed answers at '{address}'")
    assert len(errors.splitlines()) == 1


@pytest.mark.slow
@needs_distributed
@pytest.mark.parametrize(
    "address", ["localhost", "localhost:8786", "tcp://", "tcp://host", "tcp://host:http"]
)
def test_bad_addresses_are_refused(path, address):
    with (
        Store.create_or_open(path, SPEC) as store,
        pytest.raises(InvalidInputError, match=rf"like tcp://host:8786, not '{address}'"),
    ):
        run_experiment(store, cluster=address)


def test_a_missing_distributed_package_is_reported(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        Store.create_or_open(path, SPEC) as store,
        pytest.raises(MissingExtraError, match=r"pip install 'multisrt\[cluster\]'"),
    ):
        run_experiment(store, cluster="tcp://127.0.0.1:1")
