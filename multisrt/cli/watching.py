"""`multisrt explore --watch`: the team in the terminal while it runs."""

from __future__ import annotations

import os
import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Final, Literal

from multisrt.analysis.progress import Progress, compiling_note
from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    from multisrt.drawing.console import ConsoleMap, Ink
    from multisrt.environments.environment import Environment
    from multisrt.events import AnyEvent, Point
    from multisrt.geometry.numerics.arrays import FloatArray
    from multisrt.simulation.journal import Watcher
    from multisrt.spec import RunSpec

PAUSE_S: Final = 0.1
"""Minimum time between two pictures (s)."""

MAX_SHARE: Final = 0.05
"""Upper bound of the share of the time that pictures take."""

MIN_COLUMNS, MIN_ROWS = 20, 6
"""Size of the smallest terminal on which a map can be read."""

MIN_ROWS_WITH_KEY: Final = 12
"""Lines of a terminal from which one explains the signs of the map."""

HIDE_CURSOR, SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"
CLEAR_LINE, CLEAR_BELOW = "\x1b[K", "\x1b[J"


def require_terminal() -> None:
    """Check that a picture can be drawn where progress is shown: on standard error.

    Raises
    ------
    InvalidInputError
        If standard error is not a terminal, or one that is too small.
    """
    if not sys.stderr.isatty():
        raise InvalidInputError(
            "--watch draws on a terminal, and standard error is not one: leave out --watch, or do "
            "not redirect it"
        )
    columns, rows = _size()
    if columns < MIN_COLUMNS or rows < MIN_ROWS:
        raise InvalidInputError(
            f"--watch needs a terminal of {MIN_COLUMNS} columns and {MIN_ROWS} lines, and this one "
            f"has {columns} and {rows}: make it larger, or leave out --watch"
        )


class Watching(Progress):
    """Progress of a run as a picture of its team, on standard error.

    It is drawn from the events that the simulation records, after them: no robot can see it. The
    last picture stays.
    """

    def __init__(self) -> None:
        super().__init__(quiet=False)
        self._picture: _Picture | None = None

    def say(self, note: str) -> None:
        """Show an activity: in the line below the picture if there is one."""
        if self._picture is None:
            super().say(note)
        else:
            self._picture.note = note
            self._picture.draw()

    def watcher(
        self, spec: RunSpec, world: Environment, watch: Watcher | None = None
    ) -> Watcher | None:
        """Return a callback that draws the team with the events of a run; see `Progress`."""
        from multisrt.analysis.coverage import SeenMeter
        from multisrt.events import Sensed
        from multisrt.simulation.starts import starts_of

        if self._picture is not None:
            self._finish_picture()
            self.start()
        self.say(f"{spec.strategy}: preparing")
        starts = starts_of(spec, world)
        meter = SeenMeter(spec, world, starts)
        places = {robot: (start.x, start.y) for robot, start in enumerate(starts)}
        picture = _Picture(spec.strategy, world, places)

        def show(event: AnyEvent) -> None:
            if watch is not None:
                watch(event)
            if self._picture is None:
                self.stop()
                self._picture = picture
            if isinstance(event, Sensed):
                picture.add_seen(event.robot, meter.add(event), meter.share)
            picture.take_in(event)

        return show

    def compiling(self, done: int, about: int) -> None:
        """Show how many kernels have been compiled."""
        if self._picture is None:
            super().compiling(done, about)
        else:
            self._picture.note = compiling_note(done, about)
            self._picture.draw_at_times()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._finish_picture()
        super().__exit__(kind, error, trace)

    def _finish_picture(self) -> None:
        if self._picture is not None:
            picture, self._picture = self._picture, None
            picture.finish()


class _Picture:
    """The picture of one run, redrawn in place.

    Attributes
    ----------
    note : str
        What is going on besides; empty while robots move.
    """

    def __init__(self, strategy: str, world: Environment, places: dict[int, Point]) -> None:
        self.note = ""
        self._strategy, self._world, self._places = strategy, world, places
        self._ink = ink()
        self._dead: set[int] = set()
        self._time_s, self._share, self._scans = 0.0, 0.0, 0
        # Regions that were seen; the map has those before `_drawn`.
        self._regions: list[tuple[int, FloatArray]] = []
        self._drawn = 0
        self._lines = 0
        self._next_s = 0.0
        self._size = _size()
        self._map = self._empty_map()

    def add_seen(self, robot: int, region: FloatArray, share: float) -> None:
        """Take in what a scan showed, and the share of the world seen by now."""
        self._regions.append((robot, region))
        self._share = share
        self._scans += 1

    def take_in(self, event: AnyEvent) -> None:
        """Take in an event, and draw if the last picture is old enough."""
        from multisrt.events import Died, Motion, Sensed

        self.note = ""
        self._time_s = max(self._time_s, event.time_s)
        match event:
            case Motion() if event.waypoints:
                time_s, x, y, _ = event.waypoints[-1]
                self._time_s = max(self._time_s, time_s)
                self._places[event.robot] = (x, y)
            case Sensed():
                self._places[event.robot] = (event.configuration[0], event.configuration[1])
            case Died():
                self._dead.add(event.robot)
                self._places[event.robot] = (event.configuration[0], event.configuration[1])
        self.draw_at_times()

    def draw_at_times(self) -> None:
        """Draw if the last picture is old enough, by what it took to draw."""
        if time.monotonic() >= self._next_s:
            # Computing time: on a machine with other work to do, waiting is no cost of a picture.
            begun_s = time.thread_time()
            self.draw()
            took_s = time.thread_time() - begun_s
            self._next_s = time.monotonic() + max(PAUSE_S, took_s / MAX_SHARE)

    def draw(self) -> None:
        """Draw the picture over the last one."""
        size = _size()
        if again := size != self._size:
            self._size, self._drawn = size, 0
            self._map = self._empty_map()
        for robot, region in self._regions[self._drawn :]:
            self._map.add_seen(robot, region)
        self._drawn = len(self._regions)
        lines = [
            *self._map.lines(self._places, self._dead),
            *self._key(),
            self._account()[: size[0] - 1],
        ]
        # In a terminal of another size the last picture is no longer where it was.
        up = f"\x1b[{self._lines}A" if self._lines and not again else ""
        _write(HIDE_CURSOR + up + "".join(f"\r{line}{CLEAR_LINE}\n" for line in lines))
        self._lines = len(lines)

    def finish(self) -> None:
        """Draw the last picture, and leave it."""
        self.note = ""
        try:
            self.draw()
        finally:
            _write(f"{CLEAR_BELOW}{SHOW_CURSOR}")

    def _empty_map(self) -> ConsoleMap:
        from multisrt.drawing.console import ConsoleMap

        # One line is for the account, one for the cursor, and one for the key if there is one.
        columns, rows = self._size
        others = 3 if rows >= MIN_ROWS_WITH_KEY else 2
        return ConsoleMap(self._world, columns - 1, rows - others, self._ink)

    def _key(self) -> list[str]:
        columns, rows = self._size
        if rows < MIN_ROWS_WITH_KEY:
            return []
        return [self._map.key(columns - 1, team=len(self._places) > 1, dead=bool(self._dead))]

    def _account(self) -> str:
        robots = len(self._places)
        team = f", {robots} robots" if robots > 1 else ""
        seen = f"{self._time_s:.0f} s, {100.0 * self._share:.0f} % seen, {self._scans} scans"
        note = f", {self.note}" if self.note else ""
        # In a narrow terminal the end is cut off: what does not change.
        return f"{seen}{note}: {self._strategy} in {self._world.name}{team}"


def ink() -> Ink:
    """Return what the terminal of standard error can show."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.encoding.startswith("utf") or console.is_dumb_terminal:
        return "ascii"
    if console.no_color:
        return "plain"
    by_system: dict[str | None, Literal["256", "true"]] = {"256": "256", "truecolor": "true"}
    return by_system.get(console.color_system, "plain")


def _size() -> tuple[int, int]:
    # Of the terminal that is drawn on: standard output may be redirected. Some know no size.
    size = os.get_terminal_size(sys.stderr.fileno())
    return size.columns or 80, size.lines or 24


def _write(text: str) -> None:
    sys.stderr.write(text)
    sys.stderr.flush()
