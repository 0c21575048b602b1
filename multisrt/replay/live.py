"""The replay of runs that go on: a page that is rewritten and reloads itself."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from multisrt.geometry.errors import MultiSrtError
from multisrt.geometry.numerics.compilation import watch_compilation
from multisrt.recording import Recording, atomic_write
from multisrt.replay.packing import Packed
from multisrt.replay.page import MAX_BYTES, Status, page_html, save_replay, title_of
from multisrt.replay.payload import Detail, assembled, compressed, packed_run

PAUSE_S: Final = 2.0
"""Minimum time between two pages (s)."""

MAX_RELOAD_S: Final = 10.0
"""Upper bound of the time after which a page reloads itself (s)."""

GUESS_S: Final = 0.3
"""Assumed time to make a page, until one has been measured (s)."""

MAX_SHARE: Final = 0.08
"""Upper bound of the share of the time that pages take, from the second on."""

DETAIL: Final = Detail(tolerance_m=0.02, explanations=False)
"""What a page shows while a run goes on: what takes long to make is left to the last page."""

NOTE: Final = (
    "Outlines of regions are 2 cm off at most, and explanations are missing: the page of the "
    "finished run has both in full."
)
UNEXPLAINED: Final = "Explanations come with the page of the finished run."

LEFT_NOTE: Final = "Outlines of regions are 2 cm off at most, and explanations are missing."
LEFT_UNEXPLAINED: Final = "The page of a run that did not end has no explanations."


class LiveReplay:
    """A page that replays runs while they go on, as a context manager.

    Parameters
    ----------
    path : str or Path
        The file. It is replaced as a whole each time; at the end it is the page that
        `save_replay` writes. After an interrupt or an error it shows what happened until then,
        and says so.
    when_shown : callable, optional
        Called without arguments when there is a page for the first time.

    Attributes
    ----------
    pages : int
        How many pages were written, without that of the finished runs.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.replay import LiveReplay
    >>> spec = ms.RunSpec(environment=ms.CatalogEnvironment(name="apartment"), seed=1)
    >>> with LiveReplay("replay.html") as live:
    ...     live.add(ms.simulate(spec, look=live.look))
    """

    def __init__(self, path: str | Path, *, when_shown: Callable[[], None] | None = None) -> None:
        self._path, self._when_shown = Path(path), when_shown
        self._finished: list[Recording] = []
        self._packed: list[Packed] = []
        self._so_far: Callable[[], Recording] | None = None
        self._titles: list[str] = []
        self._data = ""
        self._time_s = 0.0
        self._next_s = 0.0
        self.pages = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is not None:
            self._leave(error)
            return
        try:
            save_replay(self._finished, self._path)
        except BaseException as late:
            self._leave(late)
            raise

    def look(self, so_far: Callable[[], Recording]) -> None:
        """Write a page if the last one is old enough, by what it took to make; see `simulate`.

        Parameters
        ----------
        so_far : callable
            Returns the recording of the run up to now.

        Raises
        ------
        InvalidInputError
            If the first page cannot be written. A later one that cannot be is left out.
        """
        self._so_far = so_far
        if time.monotonic() < self._next_s:
            return
        begun_s, compiled = time.monotonic(), []
        with watch_compilation(lambda done, about: compiled.append(done)):
            self._pack(so_far())
        took_s = time.monotonic() - begun_s
        # The first page has nothing to show, and kernels are compiled once: neither tells what the
        # pages to come will cost.
        cost_s = took_s if self.pages and not compiled else GUESS_S
        pause_s = max(PAUSE_S, cost_s / MAX_SHARE)
        said = f"The run goes on: {self._time_s:.1f} s of {self._titles[-1]} so far."
        self._write_one_more(Status(said, min(pause_s, MAX_RELOAD_S), self.pages))
        self._next_s = time.monotonic() + pause_s

    def add(self, recording: Recording) -> None:
        """Add a run that has ended; the one that begins next is shown beside it."""
        self._so_far = None
        self._next_s = 0.0
        self._finished.append(recording)
        self._packed.append(_packed(recording, UNEXPLAINED))

    def _pack(self, recording: Recording) -> None:
        current = _packed(recording, UNEXPLAINED) | {
            "outcome": "still going on",
            "reason": "so far",
        }
        self._put([*self._packed, current], NOTE, [*self._finished, recording])

    def _pack_last(self, outcome: str) -> None:
        # After this page there is no other one.
        runs = [run | {"unexplained": LEFT_UNEXPLAINED} for run in self._packed]
        recordings = list(self._finished)
        if self._so_far is not None:
            recordings.append(self._so_far())
            current = _packed(recordings[-1], LEFT_UNEXPLAINED)
            runs.append(current | {"outcome": outcome, "reason": ""})
        if runs:
            self._put(runs, LEFT_NOTE, recordings)

    def _put(self, runs: Sequence[Packed], note: str, recordings: Sequence[Recording]) -> None:
        data = compressed(assembled(runs, [note]))
        if len(data) > MAX_BYTES:
            return
        self._data, self._time_s = data, recordings[-1].footer.time_s
        self._titles = list(map(title_of, recordings))

    def _write_one_more(self, status: Status) -> None:
        try:
            self._write(status)
        except MultiSrtError:
            # Such as a file that some systems do not replace while a browser reads it.
            if self.pages == 0:
                raise
            return
        self.pages += 1
        if self.pages == 1 and self._when_shown is not None:
            self._when_shown()

    def _write(self, status: Status) -> None:
        page = page_html(self._titles, self._data, status)
        with atomic_write(self._path) as file:
            file.write(page.encode())

    def _leave(self, error: BaseException) -> None:
        # The last page must not wait for another one.
        if self.pages == 0:
            return
        with suppress(MultiSrtError):
            outcome = "ended with an error" if isinstance(error, Exception) else "interrupted"
            self._pack_last(outcome)
            run = self._titles[-1]
            shown = f"the replay ends at {self._time_s:.1f} s of {run}."
            if round(self._time_s, 1) == 0.0:
                shown = f"nothing had happened yet in {run}; the replay shows its start."
            said = f"The run was interrupted: {shown}"
            if isinstance(error, Exception):
                said = f"The run ended with an error: {str(error).rstrip('.')}; {shown}"
            self._write(Status(said))


def _packed(recording: Recording, unexplained: str) -> Packed:
    return packed_run(recording, DETAIL) | {"unexplained": unexplained}
