"""What a person sees while an experiment runs, on a terminal: how far, how fast, how long yet."""

from __future__ import annotations

from typing import TYPE_CHECKING

from multisrt.terminal import LiveLine

if TYPE_CHECKING:
    from multisrt.experiments.runner import Progress


class LiveProgress(LiveLine):
    """A bar that `run_experiment` moves; nothing where there is no terminal.

    Parameters
    ----------
    shown : bool
        Whether to show it on a terminal.
    """

    def __init__(self, shown: bool = True) -> None:
        super().__init__(shown, "runs", "starting workers", counted=True)

    def __call__(self, now: Progress) -> None:
        """Take in how far it is."""
        self.update(total=now.total, completed=now.done, note=note_of(now))


def note_of(now: Progress) -> str:
    """Say how fast it goes, how long it will take yet, and how many runs failed."""
    said = []
    if now.per_hour is not None and now.left_s is not None:
        said.append(f"{now.per_hour:,.0f} an hour".replace(",", " "))
        if now.done < now.total:
            said.append(f"{duration(now.left_s)} left")
    elif now.done < now.total:
        said.append("starting workers")
    if now.failed:
        said.append(f"{now.failed} failed")
    return ", ".join(said)


def duration(seconds: float) -> str:
    """Say how long something takes, in the unit that suits it."""
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    minutes = seconds / 60.0
    if minutes < 99.5:
        return f"{minutes:.0f} min"
    hours = minutes / 60.0
    return f"{hours:.1f} h" if hours < 48.0 else f"{hours / 24.0:.1f} days"
