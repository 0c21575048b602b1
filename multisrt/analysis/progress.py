"""Progress of a run on the terminal or in a notebook."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from multisrt.terminal import LiveLine

if TYPE_CHECKING:
    from multisrt.environments.environment import Environment
    from multisrt.events import AnyEvent
    from multisrt.simulation.journal import Watcher
    from multisrt.spec import RunSpec


class Progress(LiveLine):
    """Progress bar of a run: the share of the environment that was seen.

    Parameters
    ----------
    quiet : bool
        Whether to show nothing; with neither a terminal nor a notebook nothing is shown either.
    """

    def __init__(self, quiet: bool) -> None:
        super().__init__(not quiet)

    def say(self, note: str) -> None:
        """Show an activity without a share."""
        self.update(description=note, total=None, note="")

    def planning(self, what: str) -> Callable[[float], None] | None:
        """Return a callback that moves the bar with the planning on a known map.

        Parameters
        ----------
        what : str
            What is planned.

        Returns
        -------
        callable or None
            Takes the share that is done; None if the bar is hidden.
        """
        if not self.shown:
            return None

        def show(share: float) -> None:
            self.update(description=what, total=1.0, completed=share, note="planned")

        return show

    def watcher(
        self, spec: RunSpec, world: Environment, watch: Watcher | None = None
    ) -> Watcher | None:
        """Return a callback that moves the bar with the events of a run.

        Parameters
        ----------
        spec : RunSpec
            The run.
        world : Environment
            Its environment.
        watch : callable, optional
            Called with every event as well.

        Returns
        -------
        callable or None
            The callback, for `simulate`; `watch` if the bar is hidden.
        """
        if not self.shown:
            return watch
        from multisrt.analysis.coverage import SeenMeter
        from multisrt.events import Sensed
        from multisrt.simulation.starts import starts_of

        self.say(f"{spec.strategy}: preparing (the first run compiles, up to a minute)")
        meter = SeenMeter(spec, world, starts_of(spec, world))
        scans = 0

        def show(event: AnyEvent) -> None:
            nonlocal scans
            if watch is not None:
                watch(event)
            if isinstance(event, Sensed):
                scans += 1
                meter.add(event)
                self.update(
                    description=spec.strategy,
                    total=1.0,
                    completed=meter.share,
                    note=f"seen, {scans} scans, {event.time_s:.0f} s",
                )

        return show
