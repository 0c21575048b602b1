"""What a person sees while a run goes on."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multisrt.environments.environment import Environment
    from multisrt.events import AnyEvent
    from multisrt.simulation import Watcher
    from multisrt.spec import RunSpec


class Progress:
    """What a person sees while a run goes on: the share covered, on a terminal only."""

    def __init__(self, quiet: bool) -> None:
        self.shown = not quiet and sys.stderr.isatty()

    def __enter__(self) -> Progress:
        if self.shown:
            from rich import progress
            from rich.console import Console

            self.bar = progress.Progress(
                progress.TextColumn("{task.description}"),
                progress.BarColumn(),
                progress.TaskProgressColumn(),
                progress.TextColumn("{task.fields[note]}"),
                console=Console(stderr=True),
                transient=True,
            )
            self.bar.start()
            self.task = self.bar.add_task("starting", total=None, note="")
        return self

    def __exit__(self, *_: object) -> None:
        if self.shown:
            self.bar.stop()

    def say(self, what: str) -> None:
        """Tell what is being done."""
        if self.shown:
            self.bar.update(self.task, description=what, total=None, note="")

    def watcher(self, spec: RunSpec, world: Environment) -> Watcher | None:
        """Give what watches a run, where anybody does."""
        if not self.shown:
            return None
        from multisrt.coverage import CoverageMeter
        from multisrt.events import NodeAdded
        from multisrt.starts import starts_of

        self.say(f"{spec.strategy}: preparing (the first run compiles, up to a minute)")
        meter = CoverageMeter(spec, world, starts_of(spec, world))
        nodes = 0

        def watch(event: AnyEvent) -> None:
            nonlocal nodes
            if isinstance(event, NodeAdded):
                nodes += 1
                meter.add(event)
                self.bar.update(
                    self.task,
                    description=spec.strategy,
                    total=1.0,
                    completed=meter.share,
                    note=f"covered, {nodes} scans, {event.time_s:.0f} s",
                )

        return watch
