"""A line on the terminal that tells a person how far something is that takes long."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Any, Self


class LiveLine:
    """What is being done, a bar and a note; nothing where there is no terminal.

    Parameters
    ----------
    shown : bool
        Whether to show it on a terminal.
    what : str
        What is being done at first.
    note : str
        What stands behind the bar at first.
    counted : bool
        Whether the bar tells how many of how many, and not a percentage.

    Attributes
    ----------
    shown : bool
        Whether anybody sees it.
    """

    def __init__(
        self, shown: bool, what: str = "starting", note: str = "", *, counted: bool = False
    ) -> None:
        self.shown = shown and sys.stderr.isatty()
        self._first = {"description": what, "note": note}
        self._counted = counted
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> Self:
        if self.shown:
            from rich import progress
            from rich.console import Console

            self._bar = progress.Progress(
                progress.TextColumn("{task.description}"),
                progress.BarColumn(bar_width=24),
                progress.MofNCompleteColumn() if self._counted else progress.TaskProgressColumn(),
                progress.TextColumn("{task.fields[note]}"),
                console=Console(stderr=True),
                transient=True,
            )
            self._bar.start()
            self._task = self._bar.add_task(total=None, **self._first)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def say(self, note: str) -> None:
        """Write a note behind the bar."""
        self.update(note=note)

    def update(self, **said: Any) -> None:
        """Change what it shows: `description`, `total`, `completed`, `note`."""
        if self._bar is not None:
            self._bar.update(self._task, **said)
