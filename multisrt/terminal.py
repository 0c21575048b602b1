"""The terminal: its width, and a line of progress on it or in a notebook."""

from __future__ import annotations

import sys
import threading
import time
from shutil import get_terminal_size
from types import TracebackType
from typing import Any, Final, Self, TextIO

from multisrt.extras.notebook import RewrittenText, is_notebook

PAUSE_S: Final = 0.1
"""Minimum time between two changes of a line in a notebook (s)."""

FIRST_S, EVERY_S = 10.0, 30.0
"""Time until the first line and between two of them, where none can be rewritten (s)."""

WIDTH = 100
"""Columns of output that does not go to a terminal."""


def terminal_width() -> int:
    """Return the width of what is printed, in characters: of the terminal, or `WIDTH`."""
    return get_terminal_size((WIDTH, 24)).columns if sys.stdout.isatty() else WIDTH


class LiveLine:
    """An activity, a bar and a note, as a context manager.

    It is shown on standard error if that is a terminal, and there vanishes at the end. In a
    notebook it is a line of text that is rewritten in place. Elsewhere it is a new line on standard
    error after `FIRST_S` seconds, and every `EVERY_S` seconds another if it has changed.

    Parameters
    ----------
    shown : bool
        Whether to show the line.
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
    rewritten : bool
        Whether it is shown in place, on a terminal or in a notebook.
    """

    def __init__(
        self, shown: bool, what: str = "starting", note: str = "", *, counted: bool = False
    ) -> None:
        self.shown = shown
        self.rewritten = shown and (sys.stderr.isatty() or is_notebook())
        self._counted = counted
        self._now: dict[str, Any] = {"description": what, "note": note, "total": None}
        self._bar: Any = None
        self._task: Any = None
        self._text: RewrittenText | None = None
        self._told: list[str] = []
        self._written_s = 0.0
        self._logger: threading.Thread | None = None
        self._ends = threading.Event()

    def __enter__(self) -> Self:
        if not self.shown:
            return self
        if is_notebook():
            self._text = RewrittenText(self._line())
        elif self.rewritten:
            self.start()
        else:
            self._logger = threading.Thread(target=self._log, args=(sys.stderr,), daemon=True)
            self._logger.start()
        return self

    def start(self) -> None:
        """Write the line on the terminal."""
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
        self._task = self._bar.add_task(**self._now)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()
        if self._logger is not None:
            self._ends.set()
            self._logger.join()
        if self._text is not None:
            self._text.say(self._line())

    def stop(self) -> None:
        """Remove the line from the terminal; `start` writes it again."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def say(self, note: str) -> None:
        """Change the note after the bar."""
        self.update(note=note)

    def tell(self, line: str) -> None:
        """Write a line that stays: on a terminal above the activity, elsewhere before it.

        Where no line can be rewritten, it comes with the first line, after `FIRST_S` seconds. In a
        notebook it is not shown.
        """
        if self._bar is None:
            self._told.append(line)
        else:
            self._bar.console.print(line, markup=False, highlight=False, soft_wrap=True)

    def update(self, **shown: Any) -> None:
        """Change `description`, `total`, `completed` or `note`."""
        self._now |= shown
        if self._bar is not None:
            self._bar.update(self._task, **shown)
        if self._text is not None and time.monotonic() - self._written_s > PAUSE_S:
            self._written_s = time.monotonic()
            self._text.say(self._line())

    def logged(self) -> str:
        """Return the line that is written where none can be rewritten."""
        return self._line()

    def _log(self, file: TextIO) -> None:
        pause_s, last = FIRST_S, ""
        while not self._ends.wait(pause_s):
            pause_s = EVERY_S
            told, self._told = self._told, []
            for line in told:
                print(line, file=file, flush=True)
            if (line := self.logged()) != last:
                print(line, file=file, flush=True)
                last = line

    def _line(self) -> str:
        # The line as text: activity, share or count, note.
        total, done = self._now["total"], self._now.get("completed", 0)
        parts = [self._now["description"], self._now["note"]]
        if total:
            parts.insert(1, f"{done}/{total}" if self._counted else f"{100.0 * done / total:.0f} %")
        return "  ".join(part for part in parts if part)
