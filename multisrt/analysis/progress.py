"""Progress of a run on the terminal or in a notebook."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Self

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
        Whether to show nothing.
    """

    def __init__(self, quiet: bool) -> None:
        super().__init__(not quiet)
        self._watched = ExitStack()

    def __enter__(self) -> Self:
        try:
            super().__enter__()
            self._watch_compilation()
        except BaseException:
            # After an interrupt here nothing is left.
            self.stop()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._watched.close()
        super().__exit__(kind, error, trace)

    def _watch_compilation(self) -> None:
        if self.shown:
            from multisrt.geometry.numerics.compilation import watch_compilation

            self._watched.enter_context(watch_compilation(self.compiling))

    def compiling(self, done: int, about: int) -> None:
        """Show how many kernels have been compiled; see `watch_compilation`."""
        self.update(
            description="compiling kernels",
            total=float(about),
            completed=float(done),
            note=f"{done} of about {about}",
        )

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

        self.say(f"{spec.strategy}: preparing")
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


def compiling_note(done: int, about: int) -> str:
    """Return how many kernels have been compiled, in words.

    Examples
    --------
    >>> compiling_note(12, 41)
    'compiling kernels (12 of about 41)'
    """
    return f"compiling kernels ({done} of about {about})"
