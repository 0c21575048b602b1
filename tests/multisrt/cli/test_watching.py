"""`explore --watch` on a terminal of its own: what is drawn, what stays, and what it costs."""

import fcntl
import os
import pty
import re
import select
import signal
import struct
import sys
import termios
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path

import pytest

import multisrt as ms
from multisrt.cli import watching
from multisrt.cli.watching import HIDE_CURSOR, SHOW_CURSOR, Watching
from multisrt.events import Sensed
from multisrt.run import spec_and_world
from tests.multisrt.cli.commands import Call

COLUMNS, ROWS = 60, 20
RUN = ("explore", "room.wkt", "--robots", "2", "--watch", "--out", "run")
CONTROL = re.compile(r"\x1b\[[\d;?]*[A-Za-z]")


def on_terminal(
    folder: Path, *words: str, interrupt_at: str = "", **variables: str
) -> tuple[int, str]:
    """Run `multisrt` on a terminal; return its exit code and all that it wrote there.

    It is interrupted once it has written `interrupt_at`.
    """
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(folder)
        os.environ.update({"TERM": "xterm-256color", "PYTHONUTF8": "1", **variables})
        fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
        os.execv(sys.executable, [sys.executable, "-m", "multisrt", *words])
    written, deadline_s = b"", time.monotonic() + 300.0
    interrupted = not interrupt_at
    while time.monotonic() < deadline_s:
        if not select.select([terminal], [], [], 0.5)[0]:
            continue
        try:
            part = os.read(terminal, 1 << 16)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        written += part
        if not interrupted and interrupt_at.encode() in written:
            os.kill(child, signal.SIGINT)
            interrupted = True
    os.close(terminal)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), written.decode()


def pictures(written: str) -> list[str]:
    """Return what was written for each picture; the bar before them is none."""
    begins = r"\x1b\[\?25l(?=(?:\x1b\[\d+A)?\r(?!\x1b\[2K))"
    return [part.partition(SHOW_CURSOR)[0] for part in re.split(begins, written)[1:]]


def last_picture(written: str) -> list[str]:
    """Return the texts of the lines of the last picture."""
    after = pictures(written)[-1]
    return CONTROL.sub("", after).replace("\r", "").splitlines()


@pytest.mark.slow
def test_the_last_picture_stays_before_the_summary(folder):
    code, written = on_terminal(folder, *RUN, COLORTERM="truecolor")
    assert code == 0, written
    *picture, key, account = last_picture(written)
    assert len(picture) <= ROWS - 3
    assert len({len(line) for line in picture}) == 1
    assert len(picture[0]) < COLUMNS
    text = "".join(picture)
    assert "0" in text
    assert "1" in text
    assert re.fullmatch(r"\d+ s, 100 % seen, \d+ scans: srt-radial in \w+, 2 robots", account)
    for meaning in ("wall", "not seen", "seen first by a robot", "robots"):
        assert meaning in key
    assert "dead" not in key
    assert len(key) < COLUMNS
    assert len(pictures(written)) > 1
    assert written.rfind(SHOW_CURSOR) < written.rfind("run/recording.jsonl")
    # Each picture but the first is drawn over the one before.
    again = pictures(written)[1:]
    assert all(part.startswith(f"\x1b[{len(picture) + 2}A") for part in again)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("variables", "colour"),
    [
        ({"COLORTERM": ""}, "48;5;"),
        ({"TERM": "dumb"}, ""),
        ({"NO_COLOR": "1"}, ""),
    ],
)
def test_colours_are_those_that_the_terminal_can_show(folder, variables, colour):
    code, written = on_terminal(folder, *RUN, **variables)
    assert code == 0, written
    picture = pictures(written)[-1]
    assert ("48;" in picture) == bool(colour)
    assert colour in picture
    if variables.get("TERM") == "dumb":
        assert picture.isascii()


@pytest.mark.slow
@pytest.mark.parametrize("seen", ["starting", "% seen"])
def test_an_interrupted_picture_leaves_the_terminal_in_order(folder, seen):
    words = ("explore", "museum", "--robots", "3", "--watch", "--out", "run")
    code, written = on_terminal(folder, *words, interrupt_at=seen)
    assert code == 130, written
    assert written.rfind(SHOW_CURSOR) > written.rfind(HIDE_CURSOR) >= 0
    assert "Traceback" not in written
    assert not (folder / "run").exists()


@pytest.mark.slow
def test_strategies_have_a_picture_each(folder):
    code, written = on_terminal(
        folder, *RUN, "--strategy", "srt-radial", "--strategy", "closest", "--max-time", "60"
    )
    assert code in (0, 3), written
    plain = CONTROL.sub("", written)
    assert re.search(r"\d+ s, \d+ % seen, \d+ scans: srt-radial in \w+, 2 robots", plain)
    assert re.search(r"\d+ s, \d+ % seen, \d+ scans: closest in \w+, 2 robots", plain)


def test_without_a_terminal_it_is_an_error(call: Call, folder):
    code, out, err = call(*RUN)
    assert (code, out) == (2, "")
    assert "--watch draws on a terminal, and standard error is not one" in err
    assert not (folder / "run").exists()


def test_a_quiet_picture_is_an_error(call: Call):
    code, _, err = call(*RUN, "--quiet")
    assert code == 2
    assert "--quiet" in err


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """Return the number of pictures drawn so far, on a terminal of 60 x 20."""
    written: list[str] = []
    monkeypatch.setattr(watching, "_write", written.append)
    monkeypatch.setattr(watching, "_size", lambda: (COLUMNS, ROWS))
    monkeypatch.setattr(watching, "ink", lambda: "true")
    return lambda: "".join(written).count(HIDE_CURSOR)


def test_pictures_are_apart_in_time_whatever_happens(screen, monkeypatch):
    spec, world = spec_and_world("open", {})
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    with Watching() as live:
        show = live.watcher(spec, world)
        assert show is not None
        for k in range(200):
            now[0] += 0.01
            show(Sensed(time_s=float(k), robot=0, configuration=(2.0, 2.0, 0.0)))
        assert 15 <= screen() <= 20
        # A picture that takes long is followed by a longer pause.
        seconds = count()
        monkeypatch.setattr(time, "thread_time", lambda: float(next(seconds)))
        before = screen()
        for _ in range(200):
            now[0] += 0.04
            show(Sensed(time_s=300.0, robot=0, configuration=(2.0, 2.0, 0.0)))
        assert screen() == before + 1


def test_a_watched_run_is_the_same_run(screen):
    spec, world = spec_and_world("open", {"robots": 2, "max_time_s": 60.0})
    with Watching() as live:
        watched = ms.simulate(spec, world, watch=live.watcher(spec, world))
    assert screen() > 0
    assert watched.footer.digest == ms.simulate(spec, world).footer.digest
