"""What is broken: a small experiment and a small campaign, their stores and all their files."""

from __future__ import annotations

import json
import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

EXPERIMENT: Final = """\
name = "machines"
environments = [{ name = "open", parameters = { size_m = 12.0 } }]
strategies = ["closest", "srt-star"]
repetitions = 6
recordings = "all"
"""
"""One run of `closest` is that of all its repetitions, those of `srt-star` differ."""

MISSIONS: Final = 6
"""Missions of the campaign."""

SEED: Final = 12
"""Seed of the campaign: its missions are short, and all invariants hold in them."""


class Row(NamedTuple):
    """A run or mission in a store.

    Attributes
    ----------
    result : (str, str)
        How it ended, and the digest of its recording.
    elapsed_s : float
        Elapsed time of making it (s): another if it was made again.
    recorded : (int, int)
        Which file its recording is, and when that was written; zeros without one.
    """

    result: tuple[str, str]
    elapsed_s: float
    recorded: tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """An experiment or a campaign.

    Attributes
    ----------
    name : str
        What it is.
    words : tuple of str
        The command that makes it, as words after ``multisrt``.
    store : str
        Name of its store.
    query : str
        Selects from the store what identifies a row, how it ended, its digest and its elapsed time.
    files : dict of str to str
        Files that the command reads, with their contents.
    retry : tuple of str
        Words that let the command make again what failed without a result.
    """

    name: str
    words: tuple[str, ...]
    store: str
    query: str
    files: dict[str, str]
    retry: tuple[str, ...] = ()

    def prepare(self, folder: Path) -> None:
        """Make a folder with what the command reads."""
        folder.mkdir(parents=True)
        for name, text in self.files.items():
            (folder / name).write_text(text)

    def stored(self, folder: Path) -> int:
        """Return the number of rows in the store, even while it is written; -1 without a store."""
        uri = f"{(folder / self.store).resolve().as_uri()}?mode=ro"
        try:
            with closing(sqlite3.connect(uri, uri=True, timeout=0.0)) as connection:
                (number,) = connection.execute(f"SELECT count(*) FROM ({self.query})").fetchone()
        except sqlite3.Error:  # there is none yet, or it has no tables yet
            return -1
        return int(number)

    def rows(self, folder: Path) -> dict[str, Row]:
        """Return what the store holds, by key or number; a key of two rows counts as two.

        The store is not touched: what a process that was killed left beside it stays there.
        """
        store, found = folder / self.store, {}
        with tempfile.TemporaryDirectory(prefix="machines-") as other:
            for end in ("", "-wal"):
                if (path := store.with_name(store.name + end)).exists():
                    shutil.copy(path, Path(other) / path.name)
            if not (Path(other) / store.name).exists():
                return {}
            with closing(sqlite3.connect(Path(other) / store.name)) as connection:
                try:
                    rows = connection.execute(self.query).fetchall()
                except sqlite3.OperationalError:  # a killed process did not write the tables
                    return {}
        for key, status, digest, elapsed_s in rows:
            name = f"{key}, twice" if str(key) in found else str(key)
            recorded = _file_of(self._recording(folder, str(key)))
            found[name] = Row((status, digest), elapsed_s, recorded)
        return found

    def _recording(self, folder: Path, key: str) -> Path:
        return folder / f"{self.store}.recordings" / f"{key}.jsonl"

    def left_over(self, folder: Path) -> list[str]:
        """Return the files that are neither read by the command nor whole results."""
        whole = {self.store, *self.files}
        return sorted(
            _below(path, folder)
            for path in _files(folder)
            if _below(path, folder) not in whole and not self._is_whole(path, folder)
        )

    def _is_whole(self, path: Path, folder: Path) -> bool:
        # A recording of a run that is stored, with its digest.
        row = self.rows(folder).get(path.stem)
        if row is None or path != self._recording(folder, path.stem):
            return False
        last = path.read_bytes().rpartition(b"\n{")[2]
        try:
            return bool(json.loads(b"{" + last)["digest"] == row.result[1])
        except (ValueError, KeyError):
            return False


def _files(folder: Path) -> Iterator[Path]:
    return (path for path in folder.rglob("*") if not path.is_dir())


def _below(path: Path, folder: Path) -> str:
    return path.relative_to(folder).as_posix()


def _file_of(path: Path) -> tuple[int, int]:
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_ino, found.st_mtime_ns


SUBJECTS: Final = {
    subject.name: subject
    for subject in (
        Subject(
            name="experiment",
            words=("experiment", "run", "small.toml", "--quiet"),
            store="small.sqlite",
            query="SELECT key, status, digest, wall_s FROM runs",
            files={"small.toml": EXPERIMENT},
            retry=("--retry",),
        ),
        Subject(
            name="campaign",
            words=(
                *("campaign", "run", "--missions", str(MISSIONS), "--seed", str(SEED)),
                *("--store", "small.sqlite", "--quiet"),
            ),
            store="small.sqlite",
            query="SELECT number, outcome, digest, run_s FROM missions",
            files={},
        ),
    )
}
