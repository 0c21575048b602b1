"""Progress of an experiment on the terminal: runs made, rate and remaining time."""

from __future__ import annotations

import threading
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from multisrt.analysis.progress import compiling_note
from multisrt.terminal import LiveLine

if TYPE_CHECKING:
    from multisrt.experiments.runner import Progress

NOTE_S: Final = 0.5
"""Time after which the note of a bar is renewed, as kernels are compiled between two runs (s)."""


class LiveProgress(LiveLine):
    """Progress of an experiment, given to `run_experiment` as its `progress`.

    It is a bar on a terminal and in a notebook. Elsewhere the line on standard error also names the
    run that has taken longest so far.

    Parameters
    ----------
    shown : bool
        Whether to show it.
    """

    def __init__(self, shown: bool = True) -> None:
        super().__init__(shown, "runs", "starting workers", counted=True)
        self._renewer: threading.Thread | None = None
        self._latest: Progress | None = None
        if self.rewritten:
            self._renewer = threading.Thread(target=self._renew, daemon=True)

    def __enter__(self) -> Self:
        super().__enter__()
        if self._renewer is not None:
            self._renewer.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ends.set()
        if self._renewer is not None:
            self._renewer.join()
        super().__exit__(kind, error, trace)

    def __call__(self, now: Progress) -> None:
        """Show the progress."""
        self._latest = now
        self.update(description=now.what, total=now.total, completed=now.done, note=note_of(now))

    def _renew(self) -> None:
        while not self._ends.wait(NOTE_S):
            if self._latest is not None:
                self.say(note_of(self._latest))

    def logged(self) -> str:
        """Return the line that is written where none can be rewritten."""
        return super().logged() if self._latest is None else line_of(self._latest)


def line_of(now: Progress) -> str:
    """Return the progress as a line of text, with the run that has taken longest so far.

    While kernels are compiled, it has their number instead of the run.

    Parameters
    ----------
    now : Progress
        The progress.

    Returns
    -------
    str
        Such as "35 of 36 runs; apartment, mine, 3 robots, repetition 2 has run for 200 s".
    """
    told = f"{now.done} of {now.total} {now.what}"
    if now.failed:
        told += f", {now.failed} unsuccessful"
    if (kernels := now.under_way.compiling()) is not None:
        return f"{told}; {compiling_note(kernels.done, kernels.about)}"
    longest = now.under_way.longest()
    return told if longest is None else f"{told}; {longest}"


def note_of(now: Progress) -> str:
    """Return rate, remaining time, kernels being compiled and number of failures, in words.

    Parameters
    ----------
    now : Progress
        The progress.

    Returns
    -------
    str
        Such as "1 200 an hour, 5 min left, 2 unsuccessful".
    """
    parts = []
    kernels = now.under_way.compiling()
    if now.per_hour is not None and now.left_s is not None:
        parts.append(f"{now.per_hour:,.0f} an hour".replace(",", " "))
        if now.done < now.total:
            parts.append(f"{duration(now.left_s)} left")
    elif now.done < now.total and not now.under_way.has_compiled:
        parts.append("starting workers")
    if kernels is not None:
        parts.append(compiling_note(kernels.done, kernels.about))
    if now.failed:
        parts.append(f"{now.failed} unsuccessful")
    return ", ".join(parts)


def duration(seconds: float) -> str:
    """Return a duration in the unit that suits it.

    Parameters
    ----------
    seconds : float
        The duration (s).

    Returns
    -------
    str
        Seconds, minutes, hours or days.

    Examples
    --------
    >>> duration(42.0), duration(600.0), duration(200_000.0)
    ('42 s', '10 min', '2.3 days')
    """
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    minutes = seconds / 60.0
    if minutes < 99.5:
        return f"{minutes:.0f} min"
    hours = minutes / 60.0
    return f"{hours:.1f} h" if hours < 48.0 else f"{hours / 24.0:.1f} days"
