"""Processes that are broken: commands in a folder, and the processes that they start."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Final, NamedTuple

ROOT: Final = Path(__file__).parents[2]
"""The checkout."""

MAX_S: Final = 120.0
"""Time within which a process does what is expected of it (s); kernels are compiled before."""

GONE_S: Final = 20.0
"""Time within which processes end whose parent has ended (s)."""

LOOK_S: Final = 0.01
"""Interval at which processes and stores are looked at (s)."""

OF_ROOT: Final = (1, 2, 3)
"""Linux's numbers of what lets root write where no permission is given: CAP_DAC_OVERRIDE, ..."""

PR_CAPBSET_DROP: Final = 24


class LateError(Exception):
    """What was to be broken had ended, or did not come about in time."""


class Ended(NamedTuple):
    """How a command ended.

    Attributes
    ----------
    code : int
        Its exit code, negative for a signal.
    told : tuple of str
        The lines that it wrote to standard error.
    """

    code: int
    told: tuple[str, ...]


@dataclass(slots=True)
class Command:
    """A command that runs, or has run.

    Attributes
    ----------
    popen : subprocess.Popen
        Its process.
    errors : binary file
        What it writes to standard error.
    started : set of int
        Numbers of the processes that it was seen to have started.
    """

    popen: subprocess.Popen[bytes]
    errors: IO[bytes]
    started: set[int] = field(default_factory=set)

    @property
    def is_there(self) -> bool:
        """Whether it has not ended."""
        return self.popen.poll() is None

    def wait_until(self, holds: Callable[[], bool], what: str) -> None:
        """Wait until something holds; raise LateError if the command ends before."""
        end_s = time.monotonic() + MAX_S
        while not holds():
            if not self.is_there:
                raise LateError(f"had ended before {what}")
            if time.monotonic() > end_s:
                raise LateError(f"in {MAX_S:g} s not {what}")
            time.sleep(LOOK_S)

    def children(self) -> list[int]:
        """Return the numbers of the processes that it has started and that are there, by age."""
        found = [pid for pid, parent in parents().items() if parent == self.popen.pid]
        self.started |= set(found)
        return sorted(found)

    def send(self, number: signal.Signals) -> None:
        """Send it a signal; raise LateError if it has ended."""
        if not self.is_there:
            raise LateError(f"had ended before {number.name}")
        self.children()
        self.popen.send_signal(number)

    def end(self) -> Ended:
        """Wait for its end, or kill it when it takes too long."""
        late: tuple[str, ...] = ()
        try:
            self.popen.wait(timeout=MAX_S)
        except subprocess.TimeoutExpired:
            self.popen.kill()
            self.popen.wait()
            late = (f"did not end in {MAX_S:g} s",)
        self.errors.seek(0)
        lines = self.errors.read().decode(errors="replace").splitlines()
        return Ended(self.popen.returncode, (*filter(None, lines), *late))

    def left(self) -> list[int]:
        """Return the processes that it started and that outlive it, after some time to end."""
        end_s = time.monotonic() + GONE_S
        while left := sorted(self.started & set(parents())):
            if time.monotonic() > end_s:
                return left
            time.sleep(LOOK_S)
        return []


class Limits(NamedTuple):
    """What a process is denied.

    Attributes
    ----------
    file_bytes : int
        Length of its files; 0: any.
    as_anyone : bool
        Whether permissions of files bind it even if it is root's.
    closed : int
        A standard stream that is closed; -1: none.
    """

    file_bytes: int = 0
    as_anyone: bool = False
    closed: int = -1


@contextmanager
def started(
    words: Sequence[str],
    folder: Path,
    *,
    limits: Limits = Limits(),  # noqa: B008, a constant
    environment: dict[str, str] | None = None,
    output: Path = Path("/dev/null"),
) -> Iterator[Command]:
    """Start a program of Python in a folder; it is killed at the end if it is still there.

    Parameters
    ----------
    words : sequence of str
        Words after the interpreter.
    folder : Path
        Its working directory.
    limits : Limits
        What it is denied.
    environment : dict of str to str, optional
        Variables besides those of this process; folders of `PYTHONPATH` come before its own.
    output : Path
        Its standard output.

    Yields
    ------
    Command
        The process.
    """
    given = environment or {}
    paths = given.get("PYTHONPATH"), str(ROOT), os.environ.get("PYTHONPATH")
    variables = os.environ | given | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
    with output.open("wb") as opened, tempfile.TemporaryFile() as errors:
        popen = subprocess.Popen(
            [sys.executable, *words],
            cwd=folder,
            env=variables,
            stdin=subprocess.DEVNULL,
            stdout=opened,
            stderr=errors,
            preexec_fn=lambda: _denied(limits),
        )
        command = Command(popen, errors)
        try:
            yield command
        finally:
            command.children()
            popen.kill()
            popen.wait()
            for pid in command.started & set(parents()):
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)


def _denied(limits: Limits) -> None:
    # In the new process: what it is denied, and signals as usual, whatever started this one.
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    if limits.file_bytes:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limits.file_bytes, resource.RLIM_INFINITY))
    if limits.as_anyone and os.geteuid() == 0:
        for capability in OF_ROOT:
            ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)
    if limits.closed >= 0:
        os.close(limits.closed)


def parents() -> dict[int, int]:
    """Return the parent of each process that is no zombie."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            state, parent = (folder / "stat").read_text().rpartition(")")[2].split()[:2]
            if state != "Z":
                found[int(folder.name)] = int(parent)
    return found
