"""Result of one input: read, refused with an error of the package, or a defect of the reader."""

from __future__ import annotations

import re
import time
import traceback
import warnings
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Final

from benchmarks.fuzz.flaws import flaw_of_message
from benchmarks.fuzz.target import Input, Target
from multisrt.geometry.errors import InvalidInputError

MAX_SECONDS: Final = 5.0
"""Processor time in seconds after which reading counts as a hang."""

MAX_MEMORY: Final = 2**30
"""Upper bound of what an input may add to the memory of the process, in bytes (1 GiB)."""


class Verdict(Enum):
    """Verdict on the reading of an input."""

    READ = "read"
    REFUSED = "refused"
    CRASH = "crash"
    HANG = "hang"
    MEMORY = "memory"
    MESSAGE = "bad message"
    CONTENT = "bad content"
    WARNING = "warning"

    @property
    def is_right(self) -> bool:
        """Whether this is correct behaviour of a reader."""
        return self in (Verdict.READ, Verdict.REFUSED)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of reading an input.

    Attributes
    ----------
    verdict : Verdict
        The verdict.
    seconds : float
        Processor time in seconds.
    memory : int
        Peak of the memory that it added to the process, in bytes; 0 if not known.
    detail : str
        The error and its place.
    """

    verdict: Verdict
    seconds: float = 0.0
    memory: int = 0
    detail: str = ""


def judge(target: Target, one: Input, folder: Path) -> Outcome:
    """Read an input and return the result.

    Parameters
    ----------
    target : Target
        The reader.
    one : Input
        The input.
    folder : Path
        Folder in which its file is written, with its companions.
    """
    path = folder / f"input{one.suffix}"
    path.write_bytes(one.content)
    before = _reset_peak()
    begin = time.process_time()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        verdict, detail = _verdict(target, one, path)
    seconds = time.process_time() - begin
    memory = max(_memory("VmHWM") - before, 0) if before else 0
    if memory > MAX_MEMORY:
        verdict, detail = Verdict.MEMORY, f"{memory / 2**20:,.0f} MB; {detail}"
    elif seconds > MAX_SECONDS:
        verdict, detail = Verdict.HANG, f"{seconds:.1f} s; {detail}"
    elif told and verdict.is_right:
        place = told[0]
        verdict = Verdict.WARNING
        detail = f"{place.category.__name__}: {place.message} ({place.filename}:{place.lineno})"
    return Outcome(verdict, seconds, memory, detail)


def _verdict(target: Target, one: Input, path: Path) -> tuple[Verdict, str]:
    try:
        found = target.read(path, **one.options)
    except InvalidInputError as error:
        if _ran_out_of_memory(error):
            return Verdict.MEMORY, "MemoryError"
        if fault := flaw_of_message(str(error), target.must_name or (str(path.parent),)):
            return Verdict.MESSAGE, f"{fault}: {str(error)!r}"
        return Verdict.REFUSED, ""
    except MemoryError as error:
        return Verdict.MEMORY, _place(error)
    except Exception as error:
        return Verdict.CRASH, _place(error)
    fault = target.flaw(found)
    return (Verdict.CONTENT, fault) if fault else (Verdict.READ, "")


def _ran_out_of_memory(error: BaseException | None) -> bool:
    while error is not None:
        if isinstance(error, MemoryError):
            return True
        error = error.__cause__ or error.__context__
    return False


_OURS: Final = re.compile("/(environments|geometry|multisrt|planners)/")


def _place(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    place = f"{frames[-1].filename}:{frames[-1].lineno}" if frames else "?"
    ours = [frame for frame in frames if _OURS.search(frame.filename)]
    if ours and ours[-1] is not frames[-1]:
        place = f"{ours[-1].filename}:{ours[-1].lineno} > {place}"
    return f"{type(error).__name__}: {str(error)[:200]} ({place})"


def _reset_peak() -> int:
    """Begin to measure the peak of memory, and return the present size; 0 if unknown."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return 0
    return _memory("VmRSS")


def _memory(key: str) -> int:
    try:
        with open("/proc/self/status", "rb") as file:
            for line in file:
                if line.startswith(key.encode()):
                    return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0
