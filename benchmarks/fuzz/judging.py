"""Result of one input: read, refused with an error of the package, or a defect of the reader."""

from __future__ import annotations

import time
import traceback
import warnings
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Final

import numpy as np
import shapely

from benchmarks.fuzz.targets import Input, Target
from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.geometry.errors import InvalidInputError

MAX_SECONDS: Final = 5.0
"""Processor time in seconds after which reading counts as a hang."""

MAX_MEMORY: Final = 2**30
"""Upper bound of what an input may add to the memory of the process, in bytes (1 GiB)."""

MAX_MESSAGE: Final = 1000
"""Upper bound of the length of an error message, in characters."""


class Verdict(Enum):
    """Verdict on the reading of an input."""

    READ = "read"
    REFUSED = "refused"
    CRASH = "crash"
    HANG = "hang"
    MEMORY = "memory"
    MESSAGE = "bad message"
    WORLD = "bad world"
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
        world = target.read(path, **one.options)
    except InvalidInputError as error:
        if _ran_out_of_memory(error):
            return Verdict.MEMORY, "MemoryError"
        if fault := flaw_of_message(str(error), path.parent):
            return Verdict.MESSAGE, f"{fault}: {str(error)!r}"
        return Verdict.REFUSED, ""
    except MemoryError as error:
        return Verdict.MEMORY, _place(error)
    except Exception as error:
        return Verdict.CRASH, _place(error)
    fault = flaw_of_world(world)
    return (Verdict.WORLD, fault) if fault else (Verdict.READ, "")


def flaw_of_message(message: str, folder: Path) -> str:
    """Return what is wrong with an error message; empty if it is one line that names a file.

    Parameters
    ----------
    message : str
        The message.
    folder : Path
        The folder of the file, which the message must contain.
    """
    if not message.isprintable():
        return "not one line of printable text"
    if str(folder) not in message:
        return "names no file"
    if "Traceback" in message or " object at 0x" in message:
        return "text of a program"
    return "too long" if len(message) > MAX_MESSAGE else ""


def flaw_of_world(world: Environment) -> str:
    """Return what is wrong with a world; empty if it can be explored."""
    points = shapely.get_coordinates(world.free)
    if world.free.is_empty or not len(points):
        return "free space is empty"
    if not np.isfinite(points).all() or np.abs(points).max() > MAX_COORDINATE_M * (1 + 1e-9):
        return "a coordinate is not finite or too large"
    if not world.free.is_valid:
        return f"free space is not valid: {shapely.is_valid_reason(world.free)}"
    if not all(world.contains(x, y) for x, y in world.starts):
        return "a suggested start is not in free space"
    # A name is kept as it is given; what writes it makes it printable.
    if not f"{world.origin}{world.cleaning}".isprintable():
        return f"origin or cleaning is not printable: {world.origin!r}, {str(world.cleaning)!r}"
    return ""


def _ran_out_of_memory(error: BaseException | None) -> bool:
    while error is not None:
        if isinstance(error, MemoryError):
            return True
        error = error.__cause__ or error.__context__
    return False


def _place(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    place = f"{frames[-1].filename}:{frames[-1].lineno}" if frames else "?"
    ours = [frame for frame in frames if "/environments/" in frame.filename]
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
