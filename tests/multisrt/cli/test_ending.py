"""Commands that a signal ends, and whose output cannot be written."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from multisrt import cli
from multisrt.cli import ending
from multisrt.cli.ending import TERMINATIONS, Terminations
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.cli.test_process import ROOT, process

FULL = Path("/dev/full")

MULTISRT = [sys.executable, "-m", "multisrt"]

needs_full = pytest.mark.skipif(not FULL.exists(), reason="has no device that is always full")


@pytest.fixture(autouse=True)
def usual_signals():
    """Heed the signals that a test sends, whatever started the tests."""
    before = {number: signal.signal(number, signal.SIG_DFL) for number in TERMINATIONS}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", TERMINATIONS)
def test_a_signal_interrupts_once(number: signal.Signals, monkeypatch):
    with Terminations() as terminations:
        assert terminations.received is None
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
        for again in TERMINATIONS:  # a closed terminal sends several: nothing is raised
            signal.raise_signal(again)
        assert terminations.received is number
        monkeypatch.setattr(ending, "REPEATED_S", 0.0)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
    assert signal.getsignal(number) is signal.SIG_DFL


@pytest.mark.parametrize("made_of_it", [ImportError, SystemError, OSError])
@pytest.mark.parametrize("is_interrupted", [True, False])
def test_what_an_interrupt_becomes_is_an_interrupt(monkeypatch, capsys, is_interrupted, made_of_it):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def command(*_given: object, **_more: object) -> None:
        if is_interrupted:
            with contextlib.suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
        raise made_of_it("numpy._core.multiarray failed to import")

    monkeypatch.setattr(cli.cli, "main", command)
    try:
        with pytest.raises(SystemExit if is_interrupted else made_of_it) as ended:
            cli.main()
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert ("interrupted" in capsys.readouterr().err) is is_interrupted
    assert not is_interrupted or ended.value.code == 130


def test_an_error_that_blames_an_interrupt_on_the_input_is_an_interrupt(monkeypatch, capsys):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def command(*_given: object, **_more: object) -> None:
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        raise InvalidInputError("the policy raised SystemError")

    monkeypatch.setattr(cli.cli, "main", command)
    try:
        with pytest.raises(SystemExit) as ended:
            cli.main()
    finally:
        signal.signal(signal.SIGINT, before)
    assert (ended.value.code, capsys.readouterr().err) == (130, "interrupted\n")


def test_an_ignored_signal_stays_ignored():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with Terminations() as terminations:
        signal.raise_signal(signal.SIGHUP)
    assert terminations.received is None
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


@pytest.mark.slow
@pytest.mark.parametrize("number", [*TERMINATIONS, signal.SIGINT])
def test_a_run_that_a_signal_ends_leaves_nothing(tmp_path, number):
    out = tmp_path / "out"
    # It takes longer than several signals: one that comes in a call of a library may be dropped.
    words = ["explore", "city", "--set", "size_m=300", "--robots", "8", "--out", str(out)]
    with subprocess.Popen(
        [*MULTISRT, *words], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        while not (out / "unfinished" / "recording.jsonl.part").exists():
            assert running.poll() is None
            time.sleep(0.02)
        while running.poll() is None:
            running.send_signal(number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                running.wait(timeout=ending.REPEATED_S + 4.0)
        said = running.communicate()
    assert running.returncode == 128 + number
    told = "interrupted" if number == signal.SIGINT else f"interrupted by {number.name}"
    # A world that takes long to generate is told before.
    assert said[0] == ""
    assert said[1].strip().splitlines()[-1].endswith(told)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@needs_full
@pytest.mark.parametrize("words", [("environments",), ("--help",), ("completion", "bash")])
def test_a_full_output_is_told_in_one_line(words):
    with FULL.open("w") as full:
        done = subprocess.run(
            [*MULTISRT, *words], cwd=ROOT, stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert done.returncode == 1
    assert done.stderr == b"error: cannot write to standard output: No space left on device\n"


@pytest.mark.slow
def test_a_closed_output_is_told_before_anything_is_done(tmp_path):
    done = process(
        *("explore", "open", "--out", str(tmp_path / "out")), preexec_fn=lambda: os.close(1)
    )
    assert done.returncode == 1
    assert done.stderr == "error: standard output is closed; redirect it, if only to /dev/null\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_closed_standard_error_changes_nothing():
    done = process("--version", preexec_fn=lambda: os.close(2))
    assert done.returncode == 0
    assert "version" in done.stdout
