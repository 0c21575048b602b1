"""The terminal: its width, and a line of progress on it."""

from __future__ import annotations

import sys
from shutil import get_terminal_size
from types import TracebackType
from typing import Any, Self

WIDTH = 100
"""Columns of output that does not go to a terminal."""


def terminal_width() -> int:
    """Return the width of what is printed, in characters: of the terminal, or `WIDTH`."""
    return get_terminal_size((WIDTH, 24)).columns if sys.stdout.isatty() else WIDTH


class LiveLine:
    """An activity, a bar and a note, as a context manager; hidden without a terminal.

    Parameters
    ----------
    shown : bool
        Whether to show the line if standard error is a terminal.
    what : str
        The activity at first.
    note : str
        The note at first, behind the bar.
    counted : bool
        Whether the bar shows "3/8" instead of a percentage.

    Attributes
    ----------
    shown : bool
        Whether the line is shown.
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
        """Change the note after the bar."""
        self.update(note=note)

    def update(self, **shown: Any) -> None:
        """Change `description`, `total`, `completed` or `note`."""
        if self._bar is not None:
            self._bar.update(self._task, **shown)
