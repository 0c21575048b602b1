"""Progress of an experiment on the terminal: runs made, rate and remaining time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from multisrt.terminal import LiveLine

if TYPE_CHECKING:
    from multisrt.experiments.runner import Progress


class LiveProgress(LiveLine):
    """Progress bar of an experiment, given to `run_experiment` as its `progress`.

    Parameters
    ----------
    shown : bool
        Whether to show it; without a terminal nothing is shown.
    """

    def __init__(self, shown: bool = True) -> None:
        super().__init__(shown, "runs", "starting workers", counted=True)

    def __call__(self, now: Progress) -> None:
        """Show the progress."""
        self.update(description=now.what, total=now.total, completed=now.done, note=note_of(now))


def note_of(now: Progress) -> str:
    """Return rate, remaining time and number of failures, in words.

    Parameters
    ----------
    now : Progress
        The progress.

    Returns
    -------
    str
        Such as "1 200 an hour, 5 min left, 2 failed".
    """
    parts = []
    if now.per_hour is not None and now.left_s is not None:
        parts.append(f"{now.per_hour:,.0f} an hour".replace(",", " "))
        if now.done < now.total:
            parts.append(f"{duration(now.left_s)} left")
    elif now.done < now.total:
        parts.append("starting workers")
    if now.failed:
        parts.append(f"{now.failed} failed")
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
