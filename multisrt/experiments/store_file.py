"""SQLite files that hold results: their formats, how they are opened, what their errors mean."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self, TypeVar

import msgspec

from multisrt.experiments.lock import WriteLock
from multisrt.geometry.errors import InvalidInputError, escaped, reason_of, shown
from multisrt.recording import make_folder

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

MAX_NUMBER = 1e15
"""Upper bound of numbers that are read, far above any time, area or count of a run."""

OR_ANOTHER = "take a copy of it from before, or begin another one"
"""What to do about a damaged file."""

PLANS: Final = """
CREATE TABLE IF NOT EXISTS plans (
    run TEXT PRIMARY KEY,
    reference TEXT,
    reason TEXT NOT NULL
) WITHOUT ROWID
"""
"""SQL of the table of plans, which a file of results gets with the first of them."""


def connect(path: Path, mode: str) -> sqlite3.Connection:
    """Connect to a file, for reading (mode "ro") or writing ("rw", "rwc").

    Python begins a transaction before the first change; ``with connection`` ends it.
    """
    return sqlite3.connect(_uri(path, mode), uri=True, timeout=BUSY_S)


@dataclass(frozen=True, slots=True, kw_only=True)
class FileKind:
    """What a file holds, and in which format.

    Attributes
    ----------
    application : int
        Application id in the header of the file.
    version : int
        Version of the tables, stored as the `user_version` of the file.
    tables : str
        SQL statements that create them; one is `meta`, of names and values.
    later : str
        SQL statement of a table that there may be besides.
    contents : str
        What is in them, in a word.
    belongs_to : str
        What such a file is one of, in a few words.
    """

    application: int
    version: int
    tables: str
    contents: str
    belongs_to: str
    later: str = ""

    def begin(
        self, path: Path, connection: sqlite3.Connection, meta: Sequence[tuple[str, str]]
    ) -> None:
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
            If the file holds something else, or the same in another format, or is damaged.
        """
        is_new = _is_new(connection)
        if not is_new:
            self.require(path, connection)
            self._require_sound(path, connection)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        if is_new:
            with connection as transaction:
                transaction.execute("BEGIN IMMEDIATE")
                for statement in self._statements:
                    transaction.execute(statement)
                transaction.execute(f"PRAGMA application_id = {self.application}")
                transaction.execute(f"PRAGMA user_version = {self.version}")
                transaction.executemany("INSERT INTO meta (name, value) VALUES (?, ?)", meta)

    def require(self, path: Path, connection: sqlite3.Connection) -> None:
        """Raise InvalidInputError unless a file is of this kind and version."""
        if _pragma(connection, "application_id") != self.application:
            raise InvalidInputError(
                f"{path}: an SQLite file, but not one of {self.belongs_to}; name another one"
            )
        version = _pragma(connection, "user_version")
        if version != self.version:
            which = "a newer" if version > self.version else "an older"
            raise InvalidInputError(
                f"{path}: {self.contents} in format {version}, of {which} version of multisrt; "
                f"this one reads format {self.version}: use the version that made them, or another "
                "file"
            )
        self._require_tables(path, connection)

    def _require_sound(self, path: Path, connection: sqlite3.Connection) -> None:
        # Before anything is computed of which the file could not take the result.
        (found,) = connection.execute("PRAGMA quick_check(1)").fetchone()
        if found != "ok":
            raise InvalidInputError(
                f"{path}: a damaged file of {self.contents} ({reason_of(ValueError(found))}); "
                f"{OR_ANOTHER}"
            )

    @property
    def _statements(self) -> list[str]:
        return self.tables.split(";")[:-1]

    def _require_tables(self, path: Path, connection: sqlite3.Connection) -> None:
        # Views and triggers are code of who made the file: some of them never end.
        rows = connection.execute("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL")
        found = {_words(str(sql)) for (sql,) in rows}
        needed = set(map(_words, self._statements))
        if not needed <= found <= needed | {_words(self.later)}:
            raise InvalidInputError(
                f"{path}: a damaged file of {self.contents}: its tables are not those that "
                f"multisrt makes; {OR_ANOTHER}"
            )


RESULTS: Final = FileKind(
    application=APPLICATION,
    version=FORMAT,
    tables=_TABLES,
    contents="results",
    belongs_to="results",
    later=PLANS,
)
"""Files of the results of an experiment."""


class StoreFile:
    """A file that is open, for writing if it is locked.

    As a context manager it closes itself.

    Parameters
    ----------
    path : Path
        The file.
    connection : sqlite3.Connection
        A connection to it.
    lock : WriteLock, optional
        The lock against other writers.
    """

    def __init__(
        self, path: Path, connection: sqlite3.Connection, lock: WriteLock | None = None
    ) -> None:
        self.path = path
        self._connection = connection
        self._lock = lock

    def damaged(self, what: str) -> InvalidInputError:
        """Return the error of a file that holds what this program does not write."""
        return InvalidInputError(f"{self.path}: damaged: {escaped(what)}; {OR_ANOTHER}")

    def _meta(self) -> dict[str, str]:
        """Return the values of the table `meta` by their names."""
        with errors_of(self.path):
            rows = self._connection.execute("SELECT name, value FROM meta").fetchall()
        if not all(isinstance(text, str) for row in rows for text in row):
            raise self.damaged("a value of its table meta is no text")
        return dict(rows)

    def close(self) -> None:
        """Close the file and release the lock; what was added stays."""
        if self._lock is not None:
            fold_in(self._connection)
        self._connection.close()
        if self._lock is None:
            fold_in_left(self.path)
        else:
            self._lock.release()
            self._lock = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


Opened = TypeVar("Opened", bound=StoreFile)


def open_to_read(
    path: Path, kind: FileKind, make: Callable[[Path, sqlite3.Connection], Opened]
) -> Opened:
    """Open a file for reading, even while another process writes it.

    Parameters
    ----------
    path : Path
        The file.
    kind : FileKind
        What it is to hold.
    make : callable
        Makes what is returned, of the file and a connection to it, which is closed if it raises.

    Raises
    ------
    InvalidInputError
        If the file cannot be read, or holds something else.
    """
    require_store(path)
    with errors_of(path):
        connection = connect(path, "ro")
        try:
            kind.require(path, connection)
            return make(path, connection)
        except BaseException:
            connection.close()
            raise


def open_to_write(
    path: Path,
    kind: FileKind,
    meta: Sequence[tuple[str, str]],
    make: Callable[[Path, sqlite3.Connection, WriteLock], Opened],
) -> Opened:
    """Open a file for writing, locked against other writers; create it if there is none.

    Missing folders above it are created, too.

    Parameters
    ----------
    path : Path
        The file.
    kind : FileKind
        What it is to hold.
    meta : sequence of (str, str)
        Names and values for the table `meta` of a new file.
    make : callable
        Makes what is returned, of the file, a connection to it and the lock; if it raises, the one
        is closed and the other released.

    Raises
    ------
    InvalidInputError
        If the file holds something else, another process writes it, or its folder cannot be made.
    """
    if path.exists():
        require_store(path, or_empty=True)
    make_folder(path.parent)
    lock = WriteLock(path)
    try:
        with errors_of(path):
            connection = connect(path, "rwc")
            try:
                kind.begin(path, connection, meta)
                return make(path, connection, lock)
            except BaseException:
                connection.close()
                raise
    except BaseException:
        lock.release()
        raise


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


def _words(sql: str) -> tuple[str, ...]:
    return tuple(sql.replace("IF NOT EXISTS", "").split())


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


def labels_in(path: Path) -> list[str]:
    """Return the labels of the strategies in a file of results; empty if it cannot be read.

    Nothing is written, and no file appears beside it.
    """
    # Without a log beside it the file holds all; to read one in use, SQLite needs its log.
    quiet = "" if path.with_name(path.name + LOG[0]).exists() else "&immutable=1"
    try:
        with closing(sqlite3.connect(_uri(path, f"ro{quiet}"), uri=True, timeout=0.0)) as found:
            RESULTS.require(path, found)
            ordered = "SELECT strategy FROM runs GROUP BY strategy ORDER BY min(position)"
            return [str(label) for (label,) in found.execute(ordered)]
    except (OSError, sqlite3.Error, UnicodeDecodeError, InvalidInputError):
        return []


def sane(plain: Any) -> Any:
    r"""Return plain data of a file with printable text and finite numbers.

    Parameters
    ----------
    plain : object
        Text, numbers, and lists and dictionaries of them.

    Returns
    -------
    object
        The same, with characters that a terminal would obey as escapes.

    Raises
    ------
    msgspec.ValidationError
        If a number is not finite, or larger than `MAX_NUMBER`.

    Examples
    --------
    >>> sane({"reason": "a\tb", "times_s": [1.0, None]})
    {'reason': 'a\\tb', 'times_s': [1.0, None]}
    """
    match plain:
        case str():
            return escaped(plain)
        case int() | float() if not abs(plain) <= MAX_NUMBER:
            raise msgspec.ValidationError(f"a number of {shown(plain)}")
        case list() | tuple():
            return [sane(part) for part in plain]
        case dict():
            return {sane(key): sane(part) for key, part in plain.items()}
    return plain


@contextmanager
def errors_of(path: Path) -> Iterator[None]:
    """Turn errors of SQLite inside into InvalidInputError, with the remedy."""
    try:
        yield
    except UnicodeDecodeError as error:  # of the names of tables, and of text
        raise InvalidInputError(
            f"{path}: a damaged file of results ({reason_of(error)}); {OR_ANOTHER}"
        ) from None
    except sqlite3.Error as error:
        message = reason_of(error)  # it may cite the file
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
                f"{path}: a damaged file of results ({message}); {OR_ANOTHER}"
            ) from None
        raise InvalidInputError(f"{path}: {message}") from None
