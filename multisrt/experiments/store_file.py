"""The SQLite file behind a `Store`: its tables, its format and what its errors mean."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from multisrt.geometry.errors import InvalidInputError

APPLICATION = 0x4D535254
"""Application id in the header of the file: "MSRT"."""

FORMAT = 2
"""Version of the tables, stored as the `user_version` of the file."""

LOG = ("-wal", "-shm")
"""Ends of the names of the write-ahead log and its index, beside a file that is written."""

BUSY_S = 30.0
"""Timeout of a connection while others hold the file (s)."""

_TABLES = """
CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE runs (
    key TEXT PRIMARY KEY,
    position INTEGER NOT NULL,
    environment TEXT NOT NULL,
    strategy TEXT NOT NULL,
    robots INTEGER NOT NULL,
    team TEXT NOT NULL,
    starts TEXT NOT NULL,
    radio TEXT NOT NULL,
    body TEXT NOT NULL,
    faults TEXT NOT NULL,
    repetition INTEGER NOT NULL,
    status TEXT NOT NULL,
    reason TEXT NOT NULL,
    digest TEXT NOT NULL,
    metrics TEXT,
    horizon_s REAL,
    chance INTEGER NOT NULL,
    same_as INTEGER,
    covered_at_s TEXT NOT NULL,
    computing_s REAL NOT NULL,
    wall_s REAL NOT NULL,
    memory_mb REAL NOT NULL
);
"""


def connect(path: Path, mode: str) -> sqlite3.Connection:
    """Connect to a file, for reading (mode "ro") or writing ("rw", "rwc").

    Python begins a transaction before the first change; ``with connection`` ends it.
    """
    return sqlite3.connect(_uri(path, mode), uri=True, timeout=BUSY_S)


def begin(path: Path, connection: sqlite3.Connection, meta: Sequence[tuple[str, str]]) -> None:
    """Prepare a file for writing; a new one gets its tables, all at once or not at all.

    Parameters
    ----------
    path : Path
        The file.
    connection : sqlite3.Connection
        A connection to it, for writing.
    meta : sequence of (str, str)
        Names and values for the table `meta` of a new file.

    Raises
    ------
    InvalidInputError
        If the file holds no results, or results in another format.
    """
    if _is_new(connection):
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        with connection as transaction:
            transaction.execute("BEGIN IMMEDIATE")
            for statement in _TABLES.split(";")[:-1]:
                transaction.execute(statement)
            transaction.execute(f"PRAGMA application_id = {APPLICATION}")
            transaction.execute(f"PRAGMA user_version = {FORMAT}")
            transaction.executemany("INSERT INTO meta (name, value) VALUES (?, ?)", meta)
        return
    require_format(path, connection)
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = NORMAL")


def fold_in(connection: sqlite3.Connection) -> None:
    """Fold the write-ahead log into its file, which is then all that there is.

    SQLite refuses where another connection is open; the last one to close does it. On a full disk
    or one that cannot be written, the log stays.
    """
    with suppress(sqlite3.Error):
        connection.execute("PRAGMA busy_timeout = 0")
        connection.execute("PRAGMA journal_mode = DELETE")


def fold_in_left(path: Path) -> None:
    """Fold in the log that a killed writer or an earlier reader left beside a file."""
    if any(path.with_name(path.name + end).exists() for end in LOG):
        with suppress(sqlite3.Error), closing(connect(path, "rw")) as connection:
            fold_in(connection)


def _is_new(connection: sqlite3.Connection) -> bool:
    (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    return not tables and _pragma(connection, "application_id") == 0


def _uri(path: Path, mode: str) -> str:
    return f"{path.resolve().as_uri()}?mode={mode}"


def _pragma(connection: sqlite3.Connection, name: str) -> int:
    return int(connection.execute(f"PRAGMA {name}").fetchone()[0])


def require_store(path: Path, *, or_empty: bool = False) -> None:
    """Raise InvalidInputError unless a file is one of SQLite, or empty where that is allowed."""
    if path.is_dir():
        raise InvalidInputError(f"{path} is a folder; name the file of results in it (.sqlite)")
    try:
        with path.open("rb") as file:
            first = file.read(16)
    except OSError as error:
        raise InvalidInputError(
            f"{path}: {error.strerror or error}; name a file of results"
        ) from None
    if first != b"SQLite format 3\0" and not (or_empty and not first):
        raise InvalidInputError(f"{path}: not a file of results; name another one")


def require_format(path: Path, connection: sqlite3.Connection) -> None:
    """Raise InvalidInputError unless a file holds results in the format of this version."""
    if _pragma(connection, "application_id") != APPLICATION:
        raise InvalidInputError(f"{path}: an SQLite file, but not one of results; name another one")
    version = _pragma(connection, "user_version")
    if version != FORMAT:
        which = "a newer" if version > FORMAT else "an older"
        raise InvalidInputError(
            f"{path}: results in format {version}, of {which} version of multisrt; this one "
            f"reads format {FORMAT}: use the version that made them, or another file"
        )


def labels_in(path: Path) -> list[str]:
    """Return the labels of the strategies in a file of results; empty if it cannot be read.

    Nothing is written, and no file appears beside it.
    """
    # Without a log beside it the file holds all; to read one in use, SQLite needs its log.
    quiet = "" if path.with_name(path.name + LOG[0]).exists() else "&immutable=1"
    try:
        with closing(sqlite3.connect(_uri(path, f"ro{quiet}"), uri=True, timeout=0.0)) as found:
            ordered = "SELECT strategy FROM runs GROUP BY strategy ORDER BY min(position)"
            return [str(label) for (label,) in found.execute(ordered)]
    except (OSError, sqlite3.Error):
        return []


@contextmanager
def errors_of(path: Path) -> Iterator[None]:
    """Turn errors of SQLite inside into InvalidInputError, with the remedy."""
    try:
        yield
    except sqlite3.Error as error:
        message = str(error)
        name = getattr(error, "sqlite_errorname", "")
        if name == "SQLITE_FULL":
            raise InvalidInputError(
                f"{path}: the disk is full; what was stored before is sound: make room, and the "
                "same command continues"
            ) from None
        if name.startswith("SQLITE_IOERR"):
            raise InvalidInputError(
                f"{path}: cannot be read or written ({message}): the disk may be full or a limit "
                "of file sizes reached; what was stored before is sound, and the same command "
                "continues"
            ) from None
        if name in ("SQLITE_CORRUPT", "SQLITE_NOTADB"):
            raise InvalidInputError(
                f"{path}: a damaged file of results ({message}); take a copy of it from before, or "
                "begin another one"
            ) from None
        raise InvalidInputError(f"{path}: {message}") from None
