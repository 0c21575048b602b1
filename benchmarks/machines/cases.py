"""A subject on a machine that breaks, and what is verified of it."""

from __future__ import annotations

import random
import re
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from benchmarks.machines.processes import LOOK_S, Command, Ended, Limits, started
from benchmarks.machines.subjects import Row, Subject

DELAY_S: Final = 0.3
"""Maximum time between the result after which a moment comes and the moment (s)."""

MAX_FURTHER: Final = 2
"""Maximum number of results between two moments, besides those that come together."""

HALF: Final = re.compile(r"(\.part|-wal|-shm|-journal|\.lock)$|(^|/)unfinished(/|$)")
"""Names of what is written for a time, or not yet completely."""

ERROR: Final = re.compile(r"error: \S.*")
"""The one line of an error."""


@dataclass(frozen=True, slots=True)
class Undisturbed:
    """What a subject comes to on a machine that does not break.

    Attributes
    ----------
    code : int
        Exit code of its command.
    results : dict of str to (str, str)
        How each run or mission ended, and the digest of its recording.
    """

    code: int
    results: dict[str, tuple[str, str]]


@dataclass(slots=True, kw_only=True)
class Case:
    """A subject in a folder of its own, broken at some moments.

    Attributes
    ----------
    subject : Subject
        What is broken.
    folder : Path
        The folder.
    draws : random.Random
        Draws the moments.
    expected : Undisturbed
        What it is to come to.
    did : list of str
        What was done, in words.
    faults : list of str
        What is wrong; empty if all is right.
    seen : list of dict of str to Row
        What the store held after each breakage.
    is_finished : bool
        Whether the command was continued to its end.
    """

    subject: Subject
    folder: Path
    draws: random.Random
    expected: Undisturbed
    did: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    seen: list[dict[str, Row]] = field(default_factory=list)
    is_finished: bool = False

    def prepare(self) -> None:
        """Make the folder, and one for temporary files."""
        self.subject.prepare(self.folder)
        self._temporary.mkdir()

    @property
    def _temporary(self) -> Path:
        return self.folder.with_name(f"{self.folder.name}-temporary")

    @contextmanager
    def running(
        self,
        *more: str,
        limits: Limits = Limits(),  # noqa: B008, a constant
        environment: dict[str, str] | None = None,
        output: Path = Path("/dev/null"),
        cluster: str = "",
    ) -> Iterator[Command]:
        """Start the command of the subject, with more words; see `processes.started`.

        It makes runs by a process of its own, or on the cluster at an address.
        """
        where = ("--cluster", cluster) if cluster else ("--workers", "1")
        words = ("-m", "multisrt", *self.subject.words, *where, *more)
        variables = {"TMPDIR": str(self._temporary)} | (environment or {})
        with started(
            words, self.folder, limits=limits, environment=variables, output=output
        ) as command:
            yield command

    # Moments --------------------------------------------------------------------------------

    def reach(self, command: Command, least: int = 0) -> int:
        """Wait for a moment: until a drawn number of further results, and a drawn time more.

        Parameters
        ----------
        command : Command
            The command, which has taken the lock of the store by then.
        least : int
            The smallest number of further results.

        Returns
        -------
        int
            The number of results that were stored.
        """
        further = self.draws.randrange(least, least + MAX_FURTHER + 1)
        before = max(0, self.subject.stored(self.folder))
        most = len(self.expected.results) - 2  # something is left to be made
        target = min(before + further, most)
        command.wait_until(lambda: self.has_store(command), "it had the store")
        command.wait_until(
            lambda: self.subject.stored(self.folder) >= target, f"{target} results were stored"
        )
        end_s = time.monotonic() + self.draws.uniform(0.0, DELAY_S)
        while time.monotonic() < end_s and self.subject.stored(self.folder) <= most:
            time.sleep(LOOK_S)
        return self.subject.stored(self.folder)

    def has_store(self, command: Command) -> bool:
        """Whether a command has taken the lock of the store."""
        try:
            lock = (self.folder / f"{self.subject.store}.lock").read_text()
        except OSError:
            return False
        return lock == str(command.popen.pid)

    # What is verified -----------------------------------------------------------------------

    def require(self, holds: bool, fault: str) -> None:
        """Note a fault unless something holds."""
        if not holds:
            self.faults.append(fault)

    def require_error(self, ended: Ended, words: str = "", code: int = 2) -> None:
        """Note a fault unless a command ended with one line that begins "error: "."""
        self.require(ended.code == code, f"exit code {ended.code}, not {code}: {_said(ended)}")
        is_one = len(ended.told) == 1 and ERROR.fullmatch(ended.told[0]) is not None
        self.require(is_one, f"not one line of an error: {_said(ended)}")
        self.require(re.search(words, _said(ended)) is not None, f"not {words!r}: {_said(ended)}")

    def require_success(self, ended: Ended, codes: Iterable[int] = ()) -> None:
        """Note a fault unless a command ended as when it is undisturbed, and told nothing."""
        allowed = set(codes) or {self.expected.code}
        self.require(ended.code in allowed, f"exit code {ended.code}: {_said(ended)}")
        self.require(not ended.told, f"it wrote: {_said(ended)}")

    def require_gone(self, command: Command) -> None:
        """Note a fault if a process outlives the command that started it."""
        self.require(not (left := command.left()), f"processes are left: {left}")

    def require_tidy(self) -> None:
        """Note a fault if something is left that was written for a time only."""
        half = [name for name in self.subject.left_over(self.folder) if HALF.search(name)]
        self.require(not half, f"left behind: {', '.join(half)}")

    def look(self) -> dict[str, Row]:
        """Note and return what the store holds now."""
        self.seen.append(self.subject.rows(self.folder))
        return self.seen[-1]

    def finish(self) -> None:
        """Continue the command undisturbed, and verify all that it made; only once."""
        if self.is_finished:
            return
        self.is_finished = True
        with self.running(*self.subject.retry) as command:
            self.require_success(command.end())
            self.require_gone(command)
        self.look()
        left = self.subject.left_over(self.folder)
        left += [path.name for path in self._temporary.iterdir()]
        self.require(not left, f"left behind: {', '.join(left)}")

    @property
    def lost(self) -> list[str]:
        """What is not in the store as expected, or was there before."""
        end = self.seen[-1] if self.seen else {}
        gone = {key for rows in self.seen for key in rows if _is_whole(rows[key])} - set(end)
        wrong = {
            key
            for key, result in self.expected.results.items()
            if key not in end or end[key].result != result
        }
        return sorted(gone | wrong)

    @property
    def twice(self) -> list[str]:
        """What was made again although it was stored, or is stored again."""
        end = self.seen[-1] if self.seen else {}
        again = {
            key
            for rows in self.seen
            for key, row in rows.items()
            if _is_whole(row) and key in end and end[key] != row
        }
        return sorted(again | (set(end) - set(self.expected.results)))

    @property
    def is_ok(self) -> bool:
        """Whether nothing is wrong."""
        return not (self.faults or self.lost or self.twice)


def _is_whole(row: Row) -> bool:
    # What failed without a result may be made again.
    return bool(row.result[1])


def _said(ended: Ended) -> str:
    # Of a traceback, the first lines and the last ones.
    told = [*ended.told[:2], "...", *ended.told[-2:]] if len(ended.told) > 4 else ended.told
    return " / ".join(told) or "nothing was told"


def in_words(moments: Sequence[int]) -> str:
    """Return numbers of stored results as words.

    Examples
    --------
    >>> in_words([3]), in_words([0, 2, 5])
    ('when 3 were stored', 'when 0, 2 and 5 were stored')
    """
    *first, last = map(str, moments)
    return f"when {', '.join(first)}{' and ' if first else ''}{last} were stored"
