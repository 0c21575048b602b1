"""Worker processes that execute runs, as seen by the process that uses them.

Each worker is a separate process (see `worker_program`), so that limits hold: a run that crashes
or is killed by the kernel takes nothing else down, and a new process makes the next run.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO

import msgspec

from multisrt.experiments.import_path import python_command
from multisrt.experiments.job import (
    ANSWERS,
    Answer,
    Compilation,
    Compiled,
    Compiling,
    Job,
    Made,
    Ready,
    Unable,
)
from multisrt.experiments.limits import GRACE_S
from multisrt.experiments.modules import reference_of
from multisrt.experiments.provenance import Provenance, changed_strategies, differences, provenance
from multisrt.experiments.results import Result
from multisrt.experiments.threads import StoppedError
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.registry import is_known, strategy

OUTSIDE_SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Signals that end a worker through no fault of its run."""

MAX_STARTS = 3
"""Attempts to start a worker that is killed from outside before it is ready."""

MAX_STDERR_BYTES = 8192
"""Length of the end of a worker's standard error that is kept."""

THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables with which libraries set their number of threads: a worker uses one core."""


PROGRAM = "multisrt.experiments.worker_program"
"""The program of a worker."""

# Where a thread is, as the fault handler writes it.
_PLACE = re.compile(rb"most recent call first\):\n  File \"([^\"]+)\", line (\d+)")


class Worker:
    """A worker process, started when it is needed and replaced when it ends.

    Use it from one thread; only `stop` may be called by another.

    Parameters
    ----------
    modules : sequence of str
        Modules and files that the process imports before anything else. It finds modules where
        this process does.
    expected : Provenance, optional
        Provenance that the process must have; by default that of this process, without
        user-defined strategies.
    """

    def __init__(self, modules: Sequence[str] = (), expected: Provenance | None = None) -> None:
        self._modules = tuple(modules)
        self._expected = provenance() if expected is None else expected
        self._process: _Process | None = None
        self._stopped = threading.Event()

    @property
    def pid(self) -> int | None:
        """Process id, or None while there is no process."""
        return None if self._process is None else self._process.pid

    def make(self, job: Job, tell: Callable[[Compilation], None] | None = None) -> Result:
        """Execute a run.

        If the process is killed from outside, as by a kernel short of memory, the run may not be
        at fault and is repeated once.

        Parameters
        ----------
        job : Job
            The run, its limits and where its recording goes.
        tell : callable, optional
            Called, in this thread, with what the process says about kernels that it compiles.

        Returns
        -------
        Result
            The result; a failure of the run is its status and reason.

        Raises
        ------
        InvalidInputError
            If workers cannot start here, or the recording cannot be written.
        StoppedError
            If `stop` is called meanwhile.
        """
        begin = time.perf_counter()
        first = ""
        while True:
            process = self._ready()
            answer = process.ask(msgspec.json.encode(job))
            while isinstance(answer, Compiling | Compiled):
                if tell is not None:
                    tell(answer)
                answer = process.hear()
            if isinstance(answer, Made):
                if answer.result.status in ("over_time", "over_memory"):
                    self._end()  # such a run may leave anything behind
                return answer.result
            if isinstance(answer, Unable):
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
            how = how_it_ended(code)
            if -code not in OUTSIDE_SIGNALS:
                place = place_in(last_words)
                return job.without_result("crashed", f"its process {how}{place}", wall_s=wall_s)
            if first:
                reason = f"its process {first}, and when it was repeated, {how}"
                return job.without_result("crashed", reason, wall_s=wall_s)
            first = how

    def stop(self) -> None:
        """Kill the process, even during a run; no other is started."""
        self._stopped.set()
        process = self._process
        if process is not None:
            process.kill()
            process.end()

    def _ready(self) -> _Process:
        """Return a process that is ready, started if necessary."""
        for more in reversed(range(MAX_STARTS)):
            if self._stopped.is_set():
                raise StoppedError
            if self._process is not None:
                break
            self._process = process = _Process(self._modules)
            if self._stopped.is_set():  # by a thread that has not seen this process
                process.kill()
            answer = process.hear()
            if isinstance(answer, Ready):
                self._require_same(answer.provenance)
            elif isinstance(answer, Unable):
                self._end()
                raise InvalidInputError(answer.reason)
            else:
                code, last_words = process.end()
                self._process = None
                if not self._stopped.is_set() and not (more and -code in OUTSIDE_SIGNALS):
                    raise InvalidInputError(
                        f"a worker ended before it was ready: it {how_it_ended(code)}"
                        + _last_line(last_words)
                    )
        assert self._process is not None
        return self._process

    def _require_same(self, other: Provenance) -> None:
        if what := differences(self._expected, other):
            self._end()
            raise InvalidInputError(
                f"a worker runs another program than this one ({what}); install the "
                "same on every machine, and do not change it during the experiment"
            )
        if missing := [name for name in self._expected.strategies if name not in other.strategies]:
            self._end()
            raise InvalidInputError(
                f"a worker has no strategy {missing[0]!r} after importing "
                f"{', '.join(self._modules) or 'nothing'}; {_remedy(missing[0])}"
            )
        if changed := changed_strategies(self._expected, other):
            self._end()
            raise InvalidInputError(
                f"the source of the strategy {changed[0]!r} differs between a worker and this "
                "process; do not change it during an experiment, and start again"
            )

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.end()
            self._process = None


class _Process:
    """The process of a worker and its pipes."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._popen = subprocess.Popen(
            python_command(PROGRAM, modules),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | dict.fromkeys(THREADS, "1"),
            # An interrupt from the keyboard is for this process alone.
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

    def ask(self, job: bytes) -> Answer | None:
        """Send a job and return the first answer; None if the process ends."""
        try:
            self._jobs.write(job + b"\n")
            self._jobs.flush()
        except (OSError, ValueError):  # ended, or closed by `end`
            return None
        return self.hear()

    def hear(self) -> Answer | None:
        """Return the next answer; None if the process ends."""
        try:
            line = self._answers.readline()
        except (OSError, ValueError):
            return None
        return ANSWERS.decode(line) if line.endswith(b"\n") else None

    def kill(self) -> None:
        """Kill the process and those it started, without waiting."""
        if self._popen.poll() is None:
            with suppress(ProcessLookupError):
                os.killpg(self.pid, signal.SIGKILL)

    def end(self) -> tuple[int, bytes]:
        """Wait for the process; return its exit code and the end of its standard error."""
        code = self._popen.wait()
        # Processes that the run started may keep the pipe open.
        self._listener.join(timeout=1.0)
        with self._ending:
            with suppress(OSError):  # a rest of a job has no reader
                self._jobs.close()
            self._answers.close()
        return code, self._last_words

    def _listen(self, errors: IO[bytes]) -> None:
        with errors:
            while piece := os.read(errors.fileno(), 65_536):
                self._last_words = (self._last_words + piece)[-MAX_STDERR_BYTES:]


def _remedy(missing: str) -> str:
    """Return what to do about a strategy that a worker does not know."""
    if is_known(missing):  # not so in a cluster's worker
        try:
            reference_of(strategy(missing))
        except InvalidInputError as error:  # `worker_references` left it to what the user named
            return str(error)
    return (
        "name the module or file that registers it: --import on the command line, imports=[...] "
        "in Python; or bind the Strategy to a name in its module"
    )


def how_it_ended(code: int) -> str:
    """Return how a process ended, by its exit code; as what follows "it"."""
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        return f"was ended by signal {-code}"
    meaning = signal.strsignal(-code)
    return f"was ended by {name}" + (f" ({meaning})" if meaning else "")


def place_in(last_words: bytes) -> str:
    """Return the file and line that the fault handler reported, in parentheses.

    Of several threads, that of the first one which does not read the input of the process.
    """
    for file, line in _PLACE.findall(last_words):
        name = Path(os.fsdecode(file)).name
        if name != "pipes.py":
            return f" ({name}:{int(line)})"
    return ""


def _last_line(last_words: bytes) -> str:
    lines = last_words.decode(errors="replace").strip().splitlines()
    return f": {lines[-1].strip()}" if lines else ""
