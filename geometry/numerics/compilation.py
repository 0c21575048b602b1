"""Watching the compilation of kernels, which takes up to a minute where none are cached."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from numba.core import event

from multisrt.geometry.numerics.kernel import declared_kernels

USED_SHARE: Final = 0.45
"""Share of the kernels of all imported modules that a run uses, about."""

Report = Callable[[int, int], None]
"""Takes the number of kernels compiled so far, and about how many it will be."""


@contextmanager
def watch_compilation(report: Report, paused: Callable[[], None] | None = None) -> Iterator[None]:
    """Report the kernels that are compiled while a ``with`` block is executed.

    Calls of kernels are not slowed down: numba reports compilations, not calls, and none of a
    kernel that is in the cache.

    Parameters
    ----------
    report : callable
        Called before and after each compilation, in the thread that compiles, with the number of
        kernels compiled so far and an estimate of how many it will be: `USED_SHARE` of the kernels
        of the modules imported so far that were not in the cache.
    paused : callable, optional
        Called after those reports that leave no kernel being compiled.

    Examples
    --------
    >>> counts = []
    >>> with watch_compilation(lambda done, about: counts.append((done, about))):
    ...     pass
    >>> counts
    []
    """
    with event.install_listener("numba:compile", _Listener(report, paused)):
        yield


class _Listener(event.Listener):  # type: ignore[misc]
    """Counts compilations. That of a kernel includes those of the kernels that it calls."""

    def __init__(self, report: Report, paused: Callable[[], None] | None) -> None:
        self._report = report
        self._paused = paused
        self._begun = 0
        self._done = 0
        self._known = 0
        self._missing = 0

    def on_start(self, event: event.Event) -> None:
        if _is_kernel(event):
            # What is imported meanwhile adds kernels.
            new = declared_kernels()[self._known :]
            self._known += len(new)
            self._missing += sum(not is_cached(kernel) for kernel in new)
            self._begun += 1
            self._tell()

    def on_end(self, event: event.Event) -> None:
        if _is_kernel(event):
            self._done += 1
            self._tell()
            if self._done == self._begun and self._paused is not None:
                self._paused()

    def _tell(self) -> None:
        self._report(self._done, max(self._done, math.ceil(USED_SHARE * self._missing)))


def _is_kernel(event: event.Event) -> bool:
    # Parts of numba itself are compiled with it.
    return any(event.data["dispatcher"] is kernel for kernel in declared_kernels())


def is_cached(kernel: Any) -> bool:
    """Return whether a kernel is in the cache on disk, for any types.

    Parameters
    ----------
    kernel : dispatcher
        One of `declared_kernels`.
    """
    code, folder = kernel.py_func.__code__, kernel.stats.cache_path
    if folder is None or not os.path.isdir(folder):
        return False
    stem = Path(code.co_filename).stem
    name = f"{stem}.{kernel.py_func.__qualname__}-{code.co_firstlineno}."
    return any(file.startswith(name) for file in os.listdir(folder))
