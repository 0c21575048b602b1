"""Where cells have changed, revision by revision."""

from __future__ import annotations

from collections import deque
from typing import Final

from multisrt.geometry.grids.raster import Corners

MAX_CHANGES: Final = 64
"""Number of latest changes whose windows are stored; those of older ones are merged into one."""


class ChangeLog:
    """The windows in which cells have changed, each with its revision.

    Attributes
    ----------
    revision : int
        Number of changes so far.

    Examples
    --------
    >>> log = ChangeLog()
    >>> log.add((0, 2, 0, 3))
    >>> log.add((5, 6, 1, 2))
    >>> log.since(0), log.since(1), log.since(2)
    ((0, 6, 0, 3), (5, 6, 1, 2), None)
    """

    __slots__ = ("_older", "_windows", "revision")

    def __init__(self) -> None:
        self.revision = 0
        self._windows: deque[tuple[int, Corners]] = deque()
        self._older: tuple[int, Corners] | None = None

    def add(self, window: Corners) -> None:
        """Record a change under the next revision."""
        self.revision += 1
        self._windows.append((self.revision, window))
        if len(self._windows) > MAX_CHANGES:
            revision, oldest = self._windows.popleft()
            merged = None if self._older is None else self._older[1]
            self._older = revision, _union(merged, oldest)

    def since(self, revision: int) -> Corners | None:
        """Return a window that holds every change after a revision, None if there was none.

        For a revision more than `MAX_CHANGES` ago it holds all changes ever.
        """
        union: Corners | None = None
        for number, window in reversed(self._windows):
            if number <= revision:
                return union
            union = _union(union, window)
        if self._older is not None and self._older[0] > revision:
            union = _union(union, self._older[1])
        return union


def _union(union: Corners | None, window: Corners) -> Corners:
    if union is None:
        return window
    return (
        min(union[0], window[0]),
        max(union[1], window[1]),
        min(union[2], window[2]),
        max(union[3], window[3]),
    )
