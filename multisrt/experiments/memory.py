"""The memory of this process: in use, peak, and returning freed memory to the system."""

from __future__ import annotations

import ctypes
import gc
import re
import resource
import sys
from contextlib import suppress
from pathlib import Path

COLLECT_MB = 100.0
"""Growth since the last full garbage collection after which there is another (MB)."""

TRIM_MB = 500.0
"""Growth since the last trim, after a collection, after which the heap is trimmed (MB)."""

# Fields of /proc/self/statm: resident memory, and what counts towards RLIMIT_DATA, in pages.
_RESIDENT, _COUNTED = 1, 5

# glibc keeps freed memory between blocks in use until it is trimmed; elsewhere there is no such
# function.
_trim = getattr(ctypes.CDLL(None), "malloc_trim", None)


def memory_mb() -> float:
    """Return the resident memory of this process (MB); its peak where the system has no statm."""
    return _bytes(_RESIDENT) / 1e6


def counted_bytes() -> int:
    """Return the bytes that count towards `RLIMIT_DATA`; the peak where there is no statm."""
    return _bytes(_COUNTED)


def peak_memory_mb() -> float:
    """Return the peak of resident memory since `reset_peak_memory`.

    Returns
    -------
    float
        The peak (MB); since the start of the process where resetting has no effect, as on macOS.
    """
    with suppress(OSError):
        most = re.search(r"^VmHWM:\s*(\d+) kB$", Path("/proc/self/status").read_text(), re.M)
        if most:
            return int(most[1]) * 1024 / 1e6
    ever = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return ever / 1e6 if sys.platform == "darwin" else ever * 1024 / 1e6


def reset_peak_memory() -> None:
    """Let `peak_memory_mb` count from now on."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


class MemoryTrimmer:
    """Returns memory to the system between tasks, when this process has grown much."""

    def __init__(self) -> None:
        self._after_collection_mb = self._after_trim_mb = memory_mb()

    def tidy(self) -> None:
        """Collect garbage and trim the heap if memory has grown; called between two tasks."""
        if memory_mb() < self._after_collection_mb + COLLECT_MB:
            return
        gc.collect()
        if _trim is not None and memory_mb() >= self._after_trim_mb + TRIM_MB:
            _trim(0)
            self._after_trim_mb = memory_mb()
        self._after_collection_mb = memory_mb()


def _bytes(field: int) -> int:
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[field])
    except OSError:
        return int(peak_memory_mb() * 1e6)
    return pages * resource.getpagesize()
