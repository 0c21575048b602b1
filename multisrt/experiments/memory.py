"""The memory of this process: what it takes, the most it took, and giving back what is free."""

from __future__ import annotations

import ctypes
import gc
import re
import resource
import sys
from contextlib import suppress
from pathlib import Path

GARBAGE_MB = 100.0
"""A process that takes so much more than after it last did looks for garbage among all objects."""

FREE_MB = 500.0
"""A process that still takes so much more than after it last did gives back what it keeps free."""

# Fields of /proc/self/statm: what is taken, and what the kernel counts towards RLIMIT_DATA.
_RESIDENT, _COUNTED = 1, 5

# The C library of Linux keeps what was freed between blocks in use, until it is told otherwise;
# those of other systems have no such function.
_trim = getattr(ctypes.CDLL(None), "malloc_trim", None)


def memory_mb() -> float:
    """Give the memory that this process takes now (megabytes); the most so far, if none tells."""
    return _bytes(_RESIDENT) / 1e6


def counted_bytes() -> int:
    """Give what counts towards this process's `RLIMIT_DATA`; the most memory, if none tells."""
    return _bytes(_COUNTED)


def most_memory_mb() -> float:
    """Give the most memory (megabytes) that this process took since `forget_most_memory`.

    Where that has no effect, as on macOS, it is the most that the process ever took.
    """
    with suppress(OSError):
        most = re.search(r"^VmHWM:\s*(\d+) kB$", Path("/proc/self/status").read_text(), re.M)
        if most:
            return int(most[1]) * 1024 / 1e6
    ever = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return ever / 1e6 if sys.platform == "darwin" else ever * 1024 / 1e6


def forget_most_memory() -> None:
    """Have `most_memory_mb` count from now on."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


class Thrift:
    """Gives back to the system what tasks of this process have left, when it has become much."""

    def __init__(self) -> None:
        self._after_garbage_mb = self._after_free_mb = memory_mb()

    def look(self) -> None:
        """Look how much is taken, between two tasks."""
        if memory_mb() < self._after_garbage_mb + GARBAGE_MB:
            return
        gc.collect()
        if _trim is not None and memory_mb() >= self._after_free_mb + FREE_MB:
            _trim(0)
            self._after_free_mb = memory_mb()
        self._after_garbage_mb = memory_mb()


def _bytes(field: int) -> int:
    # What the kernel tells of this process's memory; where it does not, the most so far.
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[field])
    except OSError:
        return int(most_memory_mb() * 1e6)
    return pages * resource.getpagesize()
