"""Executing the missing missions of a campaign in one or more processes."""

from __future__ import annotations

import math
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from multisrt.campaign.lane import Found, Lane, Mission
from multisrt.campaign.store import CampaignStore, row_of
from multisrt.experiments.threads import Shared, from_threads
from multisrt.geometry.errors import InvalidInputError

SHRUNK_EACH = 3
"""Failures of one invariant and one strategy that are shrunk in one call."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """How far a campaign is.

    Attributes
    ----------
    done, total : int
        Number of missions that are stored, and that there are to be; the latter is None if a time
        limits the campaign alone.
    made, failed : int
        Number of missions that this call made, and of those of them that failed.
    elapsed_s : float
        Elapsed time of this call (s).
    latest : Mission, Found or None
        The mission that was stored last, or what one violates whose failures are to be shrunk;
        None at the beginning.
    """

    done: int
    total: int | None
    made: int
    failed: int
    elapsed_s: float
    latest: Mission | Found | None


Watch = Callable[[Progress], None]
"""Called at the beginning, after every mission, and when one fails, in the caller's thread."""


def run_campaign(
    store: CampaignStore,
    *,
    missions: int | None = None,
    for_s: float | None = None,
    workers: int = 1,
    folder: Path | None = None,
    shrunk_each: int = SHRUNK_EACH,
    stop_at_first: bool = False,
    progress: Watch | None = None,
) -> None:
    """Make the missions of a campaign that are not stored yet.

    Each mission is stored as it is judged: an interruption loses only those under way, and the next
    call continues.

    Parameters
    ----------
    store : CampaignStore
        The store of the campaign, open for writing.
    missions : int, optional
        Number of missions of the campaign, those that are stored included.
    for_s : float, optional
        Time after which no more missions begin (s).
    workers : int
        Number of processes that make missions.
    folder : Path, optional
        Folder for the failures; by default beside the store.
    shrunk_each : int
        Failures of one invariant and strategy that are shrunk; others are left as drawn.
    stop_at_first : bool
        Whether to end with the first mission that fails; if one has failed already, none is made.
    progress : callable, optional
        Called with the `Progress` at the beginning, after every mission, and when one fails.

    Raises
    ------
    InvalidInputError
        If neither a number nor a time is given, or something cannot be written.
    KeyboardInterrupt
        If interrupted; processes are ended, and missions that were judged are stored.
    """
    if missions is None and for_s is None:
        raise InvalidInputError("a campaign needs an end: give a number of missions, or a time")
    if workers < 1:
        raise InvalidInputError(f"a number of workers is at least 1, not {workers}")
    begin_s = time.monotonic()
    there = store.done()
    numbers = _missing(there, missions, begin_s + (math.inf if for_s is None else for_s))
    quota = _Quota(shrunk_each)
    where = failures_of(store.path) if folder is None else folder
    lanes = [Lane(store.seed, where, quota.takes) for _ in range(workers)]
    done, made, failed = len(there), 0, 0

    def tell(latest: Mission | Found | None) -> None:
        if progress is not None:
            elapsed_s = time.monotonic() - begin_s
            progress(
                Progress(
                    done=done,
                    total=missions,
                    made=made,
                    failed=failed,
                    elapsed_s=elapsed_s,
                    latest=latest,
                )
            )

    tell(None)
    if stop_at_first and any(row.violations for row in store.rows()):
        return
    with closing(_made(lanes, numbers)) as missions_made:
        for mission in missions_made:
            if isinstance(mission, Found):
                tell(mission)
                continue
            store.add(row_of(mission))
            done, made = done + 1, made + 1
            failed += bool(mission.verdict.violations)
            tell(mission)
            if failed and stop_at_first:
                return


def failures_of(store: Path) -> Path:
    """Return the folder for the failures of a campaign.

    Examples
    --------
    >>> failures_of(Path("runs/campaign.sqlite")).as_posix()
    'runs/campaign-failures'
    """
    return store.with_name(f"{store.stem}-failures")


def _missing(there: set[int], missions: int | None, end_s: float) -> Iterator[int]:
    number = 0
    while (missions is None or number < missions) and time.monotonic() < end_s:
        if number not in there:
            yield number
        number += 1


class _Quota:
    """Counts the failures that are shrunk."""

    def __init__(self, each: int) -> None:
        self._each = each
        self._shrunk: Counter[tuple[str, str]] = Counter()
        self._lock = threading.Lock()

    def takes(self, invariant: str, strategy: str) -> bool:
        """Whether one more of an invariant and a strategy is to be shrunk; it is counted then."""
        with self._lock:
            if self._shrunk[invariant, strategy] >= self._each:
                return False
            self._shrunk[invariant, strategy] += 1
            return True


def _made(lanes: list[Lane], numbers: Iterator[int]) -> Generator[Found | Mission, None, None]:
    """Yield missions as they are judged; a thread for each lane makes one after another."""
    waiting = Shared(numbers)

    def made_by(lane: Lane) -> Iterator[Found | Mission]:
        try:
            for number in waiting:
                yield from lane.make(number)
        finally:
            lane.close()

    def stop() -> None:
        for lane in lanes:
            lane.stop()

    return from_threads([made_by(lane) for lane in lanes], stop)
