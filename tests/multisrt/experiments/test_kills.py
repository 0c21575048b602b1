"""Killed processes and full disks lose no stored results."""

import contextlib
import os
import resource
import signal
import subprocess
import time
from pathlib import Path

import msgspec
import pytest

from multisrt.experiments.runner import run_experiment
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from multisrt.experiments.store_file import LOG
from multisrt.geometry.errors import InvalidInputError

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="looks after processes as Linux tells of them"
)

SPEC = ExperimentSpec(
    name="small",
    environments=("open",),
    strategies=("srt-radial", "srt-star"),
    robots=(2,),
    repetitions=5,
    recordings="all",
)


def wait_for(process: subprocess.Popen[str], done: int) -> None:
    assert process.stdout is not None
    assert process.stderr is not None
    for line in process.stdout:
        if int(line) >= done:
            return
    raise AssertionError(f"ended before: {process.stderr.read()}")


def parents() -> dict[int, int]:
    """Return the parent of each process that is no zombie."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            state, parent = (folder / "stat").read_text().rpartition(")")[2].split()[:2]
            if state != "Z":
                found[int(folder.name)] = int(parent)
    return found


def workers_of(process: subprocess.Popen[str]) -> list[int]:
    return [pid for pid, parent in parents().items() if parent == process.pid]


def logs(path: Path) -> list[Path]:
    return [log for end in LOG if (log := path.with_name(path.name + end)).exists()]


def require_end(pids: list[int]) -> None:
    deadline = time.monotonic() + 20.0
    while alive := [pid for pid in pids if pid in parents()]:
        assert time.monotonic() < deadline, f"still there: {alive}"
        time.sleep(0.02)


@pytest.fixture
def finish(undisturbed):
    """Continue the experiment in this process and check that all results are as if undisturbed."""

    def go_on(path: Path, spec: ExperimentSpec = SPEC) -> None:
        with Store.create_or_open(path, spec) as store:
            before = {result.key: result.wall_s for result in store.results()}
            run_experiment(store, workers=0)
        with Store.open(path) as store:
            results = store.results()
            assert {result.key: result.digest for result in results} == undisturbed
            assert len(results) == len(undisturbed)
            # Stored runs were not repeated: even their times on the clock are the same.
            assert all(before.get(r.key, r.wall_s) == r.wall_s for r in results)
        if spec.recordings == "all":
            recordings = {store.recording_path(key) for key in undisturbed}
            assert set(Path(f"{path}.recordings").iterdir()) == recordings

    return go_on


@pytest.mark.slow
def test_killed_and_interrupted_runners_lose_only_runs_under_way(path, undisturbed, finish, runner):
    with runner(path) as process:
        wait_for(process, 1)
        workers = workers_of(process)
        process.kill()
        process.wait()
    assert len(workers) == 2
    require_end(workers)
    assert logs(path)
    with Store.open(path) as store:
        assert 1 <= store.done < len(undisturbed)
    assert not logs(path)
    with runner(path) as process:
        wait_for(process, 4)
        workers = workers_of(process)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
        assert process.returncode == 130, (out, err)
    require_end(workers)
    assert not logs(path)
    with Store.open(path) as store:
        assert 4 <= store.done < len(undisturbed)
    finish(path)
    assert not logs(path)


@pytest.mark.slow
def test_workers_end_with_their_runner(path, runner):
    # Runs are long, so that one is under way.
    spec = msgspec.structs.replace(SPEC, environments=("hospital",), robots=(8,))
    with runner(path, spec) as process:
        wait_for(process, 0)
        while len(workers := workers_of(process)) < 2:
            time.sleep(0.02)
        time.sleep(3.0)
        process.kill()
    require_end(workers)


@pytest.mark.slow
def test_killing_a_worker_loses_no_run(path, finish, runner):
    with runner(path) as process:
        wait_for(process, 1)
        os.kill(workers_of(process)[0], signal.SIGKILL)
        _, errors = process.communicate()
        assert process.returncode == 0, errors
    finish(path)


# Full disks ----------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_file_at_its_size_limit(path, undisturbed, finish, runner):
    # The operating system refuses longer files, as it does on a full disk.
    spec = msgspec.structs.replace(SPEC, recordings="none")

    def allow_little():
        resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, resource.RLIM_INFINITY))

    with runner(path, spec, workers=0, preexec_fn=allow_little) as process:
        _, errors = process.communicate()
        assert process.returncode == 1
    assert "the disk may be full" in errors
    assert len(errors.splitlines()) == 1
    with Store.open(path) as store:
        assert 0 < store.done < len(undisturbed)
    finish(path, spec)


@pytest.fixture
def small_disk(tmp_path):
    """A disk of a few pages, and a function that enlarges it."""
    folder = tmp_path / "disk"
    folder.mkdir()

    def mount(*options: str) -> bool:
        command = ["mount", "-t", "tmpfs", "-o", ",".join(options), "tmpfs", str(folder)]
        return subprocess.run(command, capture_output=True, check=False).returncode == 0

    if not mount("size=96k"):
        pytest.skip("disks cannot be mounted here")
    try:
        yield folder, mount
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.slow
def test_a_full_disk(small_disk, undisturbed, finish, runner):
    folder, mount = small_disk
    path = folder / "results.sqlite"
    spec = msgspec.structs.replace(SPEC, recordings="none")
    with runner(path, spec, workers=0) as process:
        _, errors = process.communicate()
        assert process.returncode == 1
    assert "the disk is full" in errors
    assert len(errors.splitlines()) == 1
    with runner(path, spec, workers=0) as process:  # still full
        _, errors = process.communicate()
        assert process.returncode == 1
    assert "the disk is full" in errors
    assert mount("remount", "size=100m")
    with Store.open(path) as store:
        assert 0 < store.done < len(undisturbed)
    finish(path, spec)


@pytest.mark.slow
def test_a_full_disk_for_recordings(small_disk, finish, runner):
    folder, mount = small_disk
    path = folder / "results.sqlite"
    with runner(path, workers=1) as process:
        _, errors = process.communicate()
        assert process.returncode == 1
    assert "No space left on device" in errors or "the disk is full" in errors
    assert len(errors.splitlines()) == 1
    assert mount("remount", "size=100m")
    with pytest.raises(InvalidInputError), Store.open(folder / "results.sqlite.recordings"):
        pass
    finish(path)
