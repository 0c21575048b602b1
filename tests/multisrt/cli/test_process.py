"""Commands in a process of their own."""

import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[3]


def process(*words: str, cwd: Path = ROOT, **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "multisrt", *words],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


@pytest.mark.slow
def test_exit_codes_of_a_process(folder):
    out = str(folder / "out")
    room = str(folder / "room.wkt")
    assert process("explore", room, "--out", out).returncode == 0
    late = process("explore", room, "--range", "1", "--max-time", "1", cwd=folder)
    assert late.returncode == 3
    bad = process("explore", str(folder / "nothing.wkt"), "--out", str(folder / "new"))
    assert bad.returncode == 2
    assert bad.stdout == ""
    assert bad.stderr.count("\n") == 1
    assert not (folder / "new").exists()


@pytest.mark.slow
def test_a_full_disk(folder):
    def small_files_only():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    done = process(
        *("explore", str(folder / "pillar.wkt"), "--out", str(folder / "out"), "--range", "2"),
        preexec_fn=small_files_only,
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error: cannot write ")
    assert done.stderr.count("\n") == 1
    assert not (folder / "out").exists()


@pytest.mark.slow
def test_a_closed_pipe_raises_no_traceback():
    command = [sys.executable, "-m", "multisrt.cli", "environments"]
    with subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        assert "Traceback" not in running.stderr.read()
