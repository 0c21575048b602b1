"""A worker: a program that makes runs, one after another, and the handle that others have of it.

`python -m multisrt.experiments.worker [MODULE ...]` reads jobs and writes answers, each a JSON
object on a line, over the pipes that it was started with. What strategies print goes elsewhere.
The modules are imported at its start, for the strategies that they register. It ends when nobody
is left who could give it jobs, also in the middle of a run.

A process of its own is what makes limits hold: a run that crashes or is ended by the kernel takes
nothing else down, and the handle begins a fresh worker for the next one.
"""

from __future__ import annotations

import faulthandler
import gc
import os
import queue
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import IO

import msgspec

from multisrt.experiments.crossing import Condition, PlannedRun
from multisrt.experiments.description import Limits
from multisrt.experiments.limits import GRACE_S
from multisrt.experiments.memory import Thrift
from multisrt.experiments.provenance import Provenance, provenance
from multisrt.experiments.results import Result, Status
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import RunSpec

FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Signals that end a worker without the run's own doing."""

BEGINNINGS = 3
"""How often a worker is begun that is ended from outside before it is ready."""

LAST_WORDS_BYTES = 8192
"""How much is kept of what a worker wrote at last."""

THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""What libraries take for the number of their threads: a worker has one core."""


GARBAGE_AFTER = 50_000
"""Allocations between two passes of the garbage collector in a worker's process."""


class Job(msgspec.Struct, frozen=True, kw_only=True):
    """A run to make.

    Attributes
    ----------
    key, condition, repetition, spec
        The planned run.
    limits : Limits
        What it may take.
    recording : str
        Where to write its recording; empty: nowhere.
    only_failed : bool
        Write it only if the run has to be looked at.
    """

    key: str
    condition: Condition
    repetition: int
    spec: RunSpec
    limits: Limits
    recording: str = ""
    only_failed: bool = False

    @property
    def run(self) -> PlannedRun:
        """The planned run."""
        return PlannedRun(
            key=self.key, condition=self.condition, repetition=self.repetition, spec=self.spec
        )

    def without_result(
        self, status: Status, reason: str, *, wall_s: float = 0.0, computing_s: float = 0.0
    ) -> Result:
        """Tell of a run whose process ended before it did."""
        return Result(
            key=self.key,
            condition=self.condition,
            repetition=self.repetition,
            status=status,
            reason=reason,
            wall_s=wall_s,
            computing_s=computing_s,
        )


class _Ready(msgspec.Struct, frozen=True, tag="ready"):
    """A worker's first answer: what it is."""

    provenance: Provenance


class _Unable(msgspec.Struct, frozen=True, tag="unable"):
    """The answer of a worker that cannot do what it is for."""

    reason: str


class _Made(msgspec.Struct, frozen=True, tag="made"):
    """The answer to a job."""

    result: Result


_ANSWERS = msgspec.json.Decoder(_Ready | _Unable | _Made)


class StoppedError(Exception):
    """A worker was stopped while it made a run."""


# The handle ---------------------------------------------------------------------------------


class Worker:
    """A worker process, begun when it is needed and replaced when it ends.

    For one thread; `stop` may be called by another one.

    Parameters
    ----------
    modules : sequence of str
        What it imports before all else.
    expected : Provenance, optional
        What makes the other results: a worker that is anything else is refused.
    """

    def __init__(self, modules: Sequence[str] = (), expected: Provenance | None = None) -> None:
        self._modules = tuple(modules)
        self._expected = provenance() if expected is None else expected
        self._process: _Process | None = None
        self._stopped = threading.Event()

    @property
    def pid(self) -> int | None:
        """The process's number, while there is one."""
        return None if self._process is None else self._process.pid

    def make(self, job: Job) -> Result:
        """Make a run.

        A worker that somebody else ends, as a kernel does that lacks memory, may not be the
        run's fault: the run is made once more.

        Raises
        ------
        InvalidInputError
            If workers cannot begin here, or the recording cannot be written.
        StoppedError
            If the worker is stopped meanwhile.
        """
        begin = time.perf_counter()
        first = ""
        while True:
            process = self._ready()
            answer = process.ask(msgspec.json.encode(job))
            if isinstance(answer, _Made):
                if answer.result.status in ("over_time", "over_memory"):
                    self._end()  # what is left of such a run may be anything
                return answer.result
            if isinstance(answer, _Unable):
                raise InvalidInputError(answer.reason)
            code, last_words = process.end()
            self._process = None
            if self._stopped.is_set():
                raise StoppedError
            wall_s = time.perf_counter() - begin
            if code == -signal.SIGXCPU:
                most_s = job.limits.computing_s + GRACE_S
                reason = f"not done after {most_s:g} s of computing"
                return job.without_result("over_time", reason, wall_s=wall_s, computing_s=most_s)
            how = _how_it_ended(code)
            if -code not in FROM_OUTSIDE:
                place = _place_in(last_words)
                return job.without_result("crashed", f"its process {how}{place}", wall_s=wall_s)
            if first:
                reason = f"its process {first}, and when it was made once more, {how}"
                return job.without_result("crashed", reason, wall_s=wall_s)
            first = how

    def stop(self) -> None:
        """End the process for good, whatever it does."""
        self._stopped.set()
        process = self._process
        if process is not None:
            process.kill()
            process.end()

    def _ready(self) -> _Process:
        # Who ends a worker from outside may meet one that is only beginning.
        for more in reversed(range(BEGINNINGS)):
            if self._stopped.is_set():
                raise StoppedError
            if self._process is not None:
                break
            self._process = process = _Process(self._modules)
            if self._stopped.is_set():  # by another thread, which did not see the process yet
                process.kill()
            answer = process.hear()
            if isinstance(answer, _Ready):
                self._require_same(answer.provenance)
            elif isinstance(answer, _Unable):
                self._end()
                raise InvalidInputError(answer.reason)
            else:
                code, last_words = process.end()
                self._process = None
                if not self._stopped.is_set() and not (more and -code in FROM_OUTSIDE):
                    raise InvalidInputError(
                        f"a worker ended before it could begin: it {_how_it_ended(code)}"
                        + _last_line(last_words)
                    )
        assert self._process is not None
        return self._process

    def _require_same(self, other: Provenance) -> None:
        if what := differences(self._expected, other):
            self._end()
            raise InvalidInputError(
                f"a worker is another program than the one that asks ({what}); install the "
                "same on every machine, and leave it as it is while runs are made"
            )

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.end()
            self._process = None


class _Process:
    """A worker's process and its pipes."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._popen = subprocess.Popen(
            # What lies about in the working directory must not stand in for a library (-P).
            [sys.executable, "-P", "-m", "multisrt.experiments.worker", *modules],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | dict.fromkeys(THREADS, "1"),
            # An interrupt from the keyboard is for who gives the jobs.
            start_new_session=True,
        )
        self.pid = self._popen.pid
        assert self._popen.stdin is not None
        assert self._popen.stdout is not None
        assert self._popen.stderr is not None
        self._jobs: IO[bytes] = self._popen.stdin
        self._answers: IO[bytes] = self._popen.stdout
        self._last_words = b""
        self._listener = threading.Thread(
            target=self._listen, args=(self._popen.stderr,), daemon=True
        )
        self._listener.start()
        self._ending = threading.Lock()

    def ask(self, job: bytes) -> _Ready | _Unable | _Made | None:
        """Give a job and wait for the answer; None if the process ends."""
        try:
            self._jobs.write(job + b"\n")
            self._jobs.flush()
        except (OSError, ValueError):  # ended, or closed by whoever stops it
            return None
        return self.hear()

    def hear(self) -> _Ready | _Unable | _Made | None:
        """Wait for an answer; None if the process ends."""
        try:
            line = self._answers.readline()
        except (OSError, ValueError):
            return None
        return _ANSWERS.decode(line) if line.endswith(b"\n") else None

    def kill(self) -> None:
        """End it, and what it may have begun, without waiting."""
        if self._popen.poll() is None:
            with suppress(ProcessLookupError):
                os.killpg(self.pid, signal.SIGKILL)

    def end(self) -> tuple[int, bytes]:
        """Wait until it has ended; give its exit code and its last words."""
        code = self._popen.wait()
        # What the run left running may hold the pipe open.
        self._listener.join(timeout=1.0)
        with self._ending:
            with suppress(OSError):  # what was not written yet has nobody to read it
                self._jobs.close()
            self._answers.close()
        return code, self._last_words

    def _listen(self, errors: IO[bytes]) -> None:
        with errors:
            while piece := os.read(errors.fileno(), 65_536):
                self._last_words = (self._last_words + piece)[-LAST_WORDS_BYTES:]


def differences(one: Provenance, other: Provenance) -> str:
    """Say in what two programs differ; empty if they are the same."""
    told = [
        f"{name} {one.versions.get(name, 'none')} and {other.versions.get(name, 'none')}"
        for name in dict.fromkeys((*one.versions, *other.versions))
        if one.versions.get(name) != other.versions.get(name)
    ]
    told += [
        f"{what} {a} and {b}"
        for what, a, b in (
            ("processor", one.machine, other.machine),
            ("system", one.system, other.system),
        )
        if a != b
    ]
    if not told and one.program != other.program:
        told = [f"another source of multisrt, {one.program} and {other.program}"]
    return ", ".join(told)


def _how_it_ended(code: int) -> str:
    if code >= 0:
        return f"ended by itself with exit code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        return f"was ended by signal {-code}"
    said = signal.strsignal(-code)
    return f"was ended by {name}" + (f" ({said})" if said else "")


def _place_in(last_words: bytes) -> str:
    # Where a process was that a signal ended, as the interpreter's fault handler tells it.
    found = re.search(rb"most recent call first\):\n  File \"([^\"]+)\", line (\d+)", last_words)
    if found is None:
        return ""
    return f" ({Path(os.fsdecode(found[1])).name}:{int(found[2])})"


def _last_line(last_words: bytes) -> str:
    lines = last_words.decode(errors="replace").strip().splitlines()
    return f": {lines[-1].strip()}" if lines else ""


# The program --------------------------------------------------------------------------------


def main(modules: Sequence[str]) -> None:
    """Make runs until nobody is left who gives jobs."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    jobs, answers = _own_pipes()
    faulthandler.enable(all_threads=False)
    try:
        import_modules(modules)
    except InvalidInputError as error:
        _answer(answers, _Unable(str(error)))
        return
    import multisrt.experiments.mission

    make_run = multisrt.experiments.mission.make_run
    # What has been made by importing stays, and so does most of what a run makes until it ends:
    # there is little use in looking through it for garbage often.
    gc.collect()
    gc.freeze()
    gc.set_threshold(GARBAGE_AFTER, 20, 50)
    lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(jobs, lines), daemon=True).start()
    _answer(answers, _Ready(provenance()))
    decoder = msgspec.json.Decoder(Job)
    thrift = Thrift()
    while True:
        job = decoder.decode(lines.get())
        path = Path(job.recording) if job.recording else None
        try:
            result = make_run(job.run, job.limits, path, only_failed=job.only_failed)
        except InvalidInputError as error:
            _answer(answers, _Unable(str(error)))
        else:
            _answer(answers, _Made(result))
            thrift.look()


def import_modules(modules: Sequence[str]) -> None:
    """Import modules for the strategies that they register; also from the working directory.

    Raises
    ------
    InvalidInputError
        If one cannot be imported; the message says why.
    """
    here = os.getcwd()
    if modules and here not in sys.path:
        sys.path.append(here)
    for module in modules:
        try:
            import_module(module)
        except Exception as error:  # whatever another package's code raises
            raise InvalidInputError(
                f"cannot import {module!r}: {type(error).__name__}: {error}; name a module of the "
                "working directory, or of a package that is installed"
            ) from None


def _own_pipes() -> tuple[IO[bytes], IO[bytes]]:
    # The pipes under other numbers: what is printed goes where errors go, and nobody reads jobs.
    jobs = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return jobs, answers


def _read(jobs: IO[bytes], lines: queue.SimpleQueue[bytes]) -> None:
    # In a thread of its own, so that it hears of the end in the middle of a run.
    while line := jobs.readline():
        lines.put(line)
    os._exit(0)


def _answer(answers: IO[bytes], answer: _Ready | _Unable | _Made) -> None:
    answers.write(msgspec.json.encode(answer) + b"\n")
    answers.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
