"""Experiments on machines that break: what is verified of them, and the cheapest breakages."""

import random
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.machines import breakages, command
from benchmarks.machines.cases import Case, Undisturbed, in_words
from benchmarks.machines.processes import Ended, LateError, started
from benchmarks.machines.subjects import EXPERIMENT, SUBJECTS

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="looks after processes as Linux tells of them"
)

SMALL = replace(
    SUBJECTS["experiment"],
    files={"small.toml": EXPERIMENT.replace('"closest", ', "")},
)

ROWS = {"a": ("complete", "1"), "b": ("complete", "2"), "c": ("stalled", "3")}


def store(case: Case, rows: dict[str, tuple[str, str]], wall_s: float = 1.5) -> None:
    with closing(sqlite3.connect(case.folder / case.subject.store)) as connection, connection:
        connection.execute("CREATE TABLE IF NOT EXISTS runs (key, status, digest, wall_s)")
        connection.execute("DELETE FROM runs")
        connection.executemany(
            "INSERT INTO runs VALUES (?, ?, ?, ?)",
            [(key, *result, wall_s) for key, result in rows.items()],
        )


def record(case: Case, key: str, digest: str) -> Path:
    path = case.folder / f"{case.subject.store}.recordings" / f"{key}.jsonl"
    path.parent.mkdir(exist_ok=True)
    path.write_text(f'{{"event":"header"}}\n{{"event":"footer","digest":"{digest}"}}\n')
    return path


@pytest.fixture
def case(tmp_path) -> Case:
    """A case whose store is as it should be."""
    made = Case(
        subject=SMALL,
        folder=tmp_path / "case",
        draws=random.Random(0),
        expected=Undisturbed(code=0, results=ROWS),
    )
    made.prepare()
    store(made, ROWS)
    return made


def test_a_store_as_expected_is_right(case):
    record(case, "b", "2")
    case.look()
    case.look()
    case.require_tidy()
    assert case.is_ok
    assert case.subject.left_over(case.folder) == []
    assert case.subject.stored(case.folder) == 3


def test_what_is_lost_is_told(case):
    case.look()
    store(case, {"a": ("complete", "1"), "b": ("complete", "other")})
    case.look()
    assert (case.lost, case.is_ok) == (["b", "c"], False)


def test_what_is_made_twice_is_told(case):
    path = record(case, "b", "2")
    case.look()
    path.rename(case.folder / "elsewhere")
    record(case, "b", "2")
    case.look()
    assert (case.lost, case.twice, case.is_ok) == ([], ["b"], False)
    store(case, ROWS, wall_s=1.6)
    case.look()
    assert case.twice == ["a", "b", "c"]


def test_a_row_more_is_told(case):
    with closing(sqlite3.connect(case.folder / SMALL.store)) as connection, connection:
        connection.execute("INSERT INTO runs VALUES ('a', 'complete', '1', 1.5)")
    case.look()
    assert case.twice == ["a, twice"]


def test_a_failure_may_be_made_again(case):
    store(case, ROWS | {"c": ("crashed", "")})
    case.look()
    store(case, ROWS)
    case.look()
    assert case.is_ok


def test_files_that_are_left_are_told(case):
    record(case, "b", "another digest")
    record(case, "d", "of no row")
    part = case.folder / f"{SMALL.store}.recordings" / "a.jsonl.part"
    part.write_text("{")
    assert [Path(name).name for name in SMALL.left_over(case.folder)] == [
        "a.jsonl.part",
        "b.jsonl",
        "d.jsonl",
    ]
    case.require_tidy()
    assert case.faults == [f"left behind: {SMALL.store}.recordings/a.jsonl.part"]


@pytest.mark.parametrize(
    ("code", "told"),
    [
        (1, ("error: no room",)),
        (2, ("Traceback (most recent call last):", "OSError: no room")),
        (2, ("error: no room", "error: no room")),
        (2, ()),
        (2, ("error: something else",)),
    ],
)
def test_errors_are_one_line_with_a_reason(case, code, told):
    case.require_error(Ended(2, ("error: no room",)), "no room")
    assert not case.faults
    case.require_error(Ended(code, told), "no room")
    assert case.faults


def test_moments_are_told_in_words():
    assert in_words([4]) == "when 4 were stored"
    assert in_words([0, 2, 5]) == "when 0, 2 and 5 were stored"


def test_the_clock_goes_back_and_monotonic_clocks_do_not(tmp_path):
    code = "import time; a = time.time(), time.monotonic(); time.sleep(0.6); "
    code += "print(time.time() - a[0], time.monotonic() - a[1])"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={
            "PYTHONPATH": str(breakages.CLOCK),
            "CLOCK_JUMPS": "0.4 0.5",
            "CLOCK_LOG": str(tmp_path / "log"),
        },
        capture_output=True,
        check=True,
        text=True,
    )
    clock_s, monotonic_s = map(float, done.stdout.split())
    assert 0.6 <= monotonic_s < 60.0
    assert -7200.0 < clock_s < -7100.0
    assert len((tmp_path / "log").read_text().split()) == 1


def test_processes_that_are_left_are_found(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.machines.processes.GONE_S", 0.1)
    with started(["-c", "import subprocess; subprocess.run(['sleep', '60'])"], tmp_path) as one:
        one.wait_until(lambda: bool(one.children()), "it had a child")
        one.send(signal.SIGKILL)
        assert one.end().code == -signal.SIGKILL
        assert len(one.left()) == 1
    monkeypatch.undo()
    assert one.left() == []  # killed with the block
    with started(["-c", "pass"], tmp_path) as one, pytest.raises(LateError, match="before it was"):
        one.wait_until(lambda: False, "it was there")


def test_breakages_are_listed(capsys):
    command.main(["--list"])
    listed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed] == list(command.EVERY)
    assert all(len(line.split()) > 5 for line in listed)


@pytest.mark.slow
def test_signals_lose_nothing(tmp_path, monkeypatch, capsys):
    def breaks(case: Case) -> None:
        breakages.signalled(case, signal.SIGTERM, 1)

    monkeypatch.setattr(command, "SUBJECTS", {"experiment": SMALL})
    monkeypatch.setattr(command, "EVERY", {"signals": (breaks, ("experiment",))})
    is_right = command.tried(["signals"], 0, tmp_path / "out")
    told = capsys.readouterr().out
    assert is_right, told
    assert told.count(" yes ") == 1
    assert not list((tmp_path / "out").iterdir())
