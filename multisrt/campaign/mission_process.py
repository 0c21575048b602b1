"""A process that makes missions, as seen by the process that uses it.

It is separate, so that a mission which hangs or takes its process down is a finding and takes
nothing else down.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import tempfile
import threading
import time
from contextlib import suppress
from typing import Final, NamedTuple

import msgspec

from multisrt.campaign.jobs import ANSWERS, Answer, Attempt, Job
from multisrt.campaign.mission import NO_ERROR, OVER_MEMORY, Verdict
from multisrt.campaign.violations import Violation
from multisrt.experiments.import_path import python_command
from multisrt.experiments.threads import StoppedError
from multisrt.experiments.worker import THREADS, how_it_ended, place_in
from multisrt.geometry.errors import InvalidInputError

PROGRAM: Final = "multisrt.campaign.mission_program"

HANGS: Final = "hangs"
"""Name of the invariant that a mission ends within `HANG_S`, whatever it does."""

HANG_S: Final = 600.0
"""Time within which a process answers a job (s)."""

COMPILATION_S: Final = 600.0
"""Added to the time of the first answer, as kernels may have to be compiled (s)."""

LAST_WORDS_S: Final = 1.0
"""Time for which a process that hangs may write where it is, before it is killed (s)."""

MAX_JOBS: Final = 500
"""Missions after which a process is replaced."""


class Told(NamedTuple):
    """What a process answered to a job.

    Attributes
    ----------
    verdict : Verdict
        What is judged; of a process that ended or hung, that it did.
    tried : Attempt or None
        The draw that was set up last.
    """

    verdict: Verdict
    tried: Attempt | None


class MissionProcess:
    """A process that makes missions, started when it is needed and replaced when it ends.

    Use it from one thread; only `stop` may be called by another.

    Parameters
    ----------
    hash_seed : int
        Seed of the order of sets of text in the process; two processes of different seeds make
        equal recordings only if nothing depends on it.
    """

    def __init__(self, hash_seed: int) -> None:
        self._hash_seed = hash_seed
        self._popen: subprocess.Popen[bytes] | None = None
        self._rest = b""
        self._jobs = 0
        self._has_answered = False
        self._stopped = threading.Event()

    def ask(self, job: Job, limit_s: float = HANG_S) -> Told:
        """Return the answer to a job.

        A process that ends, hangs or lacks memory is replaced, and the job repeated once: the
        machine may have been at fault, or what the process holds of earlier jobs.

        Parameters
        ----------
        job : Make or Judge
            The job.
        limit_s : float
            Time for each of both, in seconds, without that for compiling kernels.

        Returns
        -------
        Told
            What it answered.

        Raises
        ------
        StoppedError
            If `stop` is called before the answer.
        InvalidInputError
            If the recording or the replay cannot be written.
        """
        first = self._ask(job, limit_s)
        if first.verdict.outcome not in ("lost", OVER_MEMORY):
            return first
        self.close()
        return self._ask(job, limit_s)

    def stop(self) -> None:
        """Kill the process, even at a job; no other is started."""
        self._stopped.set()
        if (popen := self._popen) is not None:
            _kill(popen)

    def close(self) -> None:
        """End the process; the next job starts another one."""
        if self._popen is None:
            return
        popen, self._popen = self._popen, None
        _kill(popen)
        popen.wait()
        for pipe in (popen.stdin, popen.stdout):
            assert pipe is not None
            with suppress(OSError):  # a rest of a job has no reader
                pipe.close()
        self._errors.close()

    def _ask(self, job: Job, limit_s: float) -> Told:
        popen = self._started()
        assert popen.stdin is not None
        tried: Attempt | None = None
        end_s = time.monotonic() + limit_s + (0.0 if self._has_answered else COMPILATION_S)
        try:
            popen.stdin.write(msgspec.json.encode(job) + b"\n")
            popen.stdin.flush()
            while True:
                answer = self._hear(popen, end_s)
                if isinstance(answer, Answer):
                    break
                tried = answer
            self._has_answered = True
            if answer.unwritten:
                raise InvalidInputError(answer.unwritten)
            return Told(answer.verdict, tried)
        except TimeoutError:
            invariant, says = HANGS, f"not done after {limit_s:g} s{self._place(popen)}"
        except OSError:
            code = popen.wait()
            invariant, says = NO_ERROR, f"its process {how_it_ended(code)}{self._last_place()}"
        self.close()
        if self._stopped.is_set():
            raise StoppedError
        violation = Violation(invariant=invariant, says=says)
        return Told(Verdict(outcome="lost", violations=(violation,), reason=says), tried)

    def _started(self) -> subprocess.Popen[bytes]:
        if self._stopped.is_set():
            raise StoppedError
        self._jobs += 1
        if self._popen is not None and self._jobs > MAX_JOBS:
            self.close()
        if self._popen is None:
            self._jobs, self._rest = 1, b""
            self._errors = tempfile.TemporaryFile()  # noqa: SIM115, closed with the process
            self._popen = subprocess.Popen(
                python_command(PROGRAM, []),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                env=os.environ
                | dict.fromkeys(THREADS, "1")
                | {"PYTHONHASHSEED": str(self._hash_seed)},
                # An interrupt from the keyboard is for this process alone.
                start_new_session=True,
            )
            if self._stopped.is_set():  # by a thread that has not seen this process
                _kill(self._popen)
        return self._popen

    def _hear(self, popen: subprocess.Popen[bytes], end_s: float) -> Answer | Attempt:
        assert popen.stdout is not None
        while b"\n" not in self._rest:
            left_s = end_s - time.monotonic()
            if left_s <= 0.0 or not select.select([popen.stdout], [], [], left_s)[0]:
                raise TimeoutError
            piece = os.read(popen.stdout.fileno(), 65_536)
            if not piece:
                raise BrokenPipeError
            self._rest += piece
        line, _, self._rest = self._rest.partition(b"\n")
        answer: Answer | Attempt = ANSWERS.decode(line)
        return answer

    def _place(self, popen: subprocess.Popen[bytes]) -> str:
        with suppress(ProcessLookupError):
            popen.send_signal(signal.SIGUSR1)
        time.sleep(LAST_WORDS_S)
        return self._last_place()

    def _last_place(self) -> str:
        self._errors.seek(0)
        return place_in(self._errors.read())


def _kill(popen: subprocess.Popen[bytes]) -> None:
    if popen.poll() is None:
        with suppress(ProcessLookupError):
            os.killpg(popen.pid, signal.SIGKILL)
