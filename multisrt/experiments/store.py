"""An experiment's results on disk: one SQLite file with a row for each run.

A row is written in one transaction when its run has ended: whatever ends the program, the runs
that were stored are there, each once, and the others are made by the next call. The file is in
SQLite's write-ahead mode while it is written, so that reports can be made meanwhile; closed, it
is a single file. Writes are not waited for until they have come to the disk itself
(`synchronous=NORMAL`): if the machine's power fails, the runs of the last moments may have to be
made again, and the file is sound all the same.

Tables: `meta` (experiment, folder, provenance and the number of runs asked for), and `runs` (the
columns of a condition, and the fields of `Result`; what has parts is JSON).
"""

from __future__ import annotations

import fcntl
import os
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import IO, Any

import msgspec

from multisrt.analysis.metrics import Metrics
from multisrt.experiments.crossing import Condition, PlannedRun, runs
from multisrt.experiments.description import ExperimentSpec
from multisrt.experiments.provenance import Provenance, provenance
from multisrt.experiments.results import Result, Results, Status
from multisrt.experiments.worker import differences
from multisrt.geometry.errors import InvalidInputError

APPLICATION = 0x4D535254
"""What SQLite's header says of whose file it is: "MSRT"."""

FORMAT = 1

UNFINISHED: tuple[Status, ...] = ("over_time", "over_memory", "crashed", "refused", "error")
"""Statuses of runs that did not come to an end of their own; see `Store.forget`."""

BUSY_S = 30.0
"""How long to wait for readers that hold the file."""

_LABELS = Condition.__struct_fields__
_FIELDS = tuple(name for name in Result.__struct_fields__ if name != "condition")
_COLUMNS = ("position", *_LABELS, *_FIELDS)

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
    covered_at_s TEXT NOT NULL,
    computing_s REAL NOT NULL,
    wall_s REAL NOT NULL,
    memory_mb REAL NOT NULL
);
"""


class Store:
    """An experiment with the results that are there; see `create_or_open` and `open`.

    A context manager, which closes it.

    Attributes
    ----------
    path : Path
        The file.
    experiment : ExperimentSpec
        What was asked for.
    folder : Path
        What paths of environments are relative to.
    provenance : Provenance
        What makes the results.
    asked : int
        How many runs the experiment has.
    """

    def __init__(
        self, path: Path, connection: sqlite3.Connection, lock: _Lock | None = None
    ) -> None:
        self.path = path
        self._connection = connection
        self._lock = lock
        self._planned: dict[str, tuple[int, PlannedRun]] | None = None
        with _errors_of(path):
            meta = dict(connection.execute("SELECT name, value FROM meta"))
        try:
            self.experiment = ExperimentSpec.from_json(meta["experiment"])
            self.folder = Path(meta["folder"])
            self.provenance = msgspec.json.decode(meta["provenance"], type=Provenance)
            self.asked = int(meta["asked"])
        except (KeyError, ValueError, msgspec.MsgspecError) as error:
            raise InvalidInputError(f"{path}: a damaged file of results: {error}") from None

    # Opening --------------------------------------------------------------------------------

    @classmethod
    def open(cls, path: str | Path) -> Store:
        """Open results for reading, also while runs are made.

        Raises
        ------
        InvalidInputError
            If the file cannot be read or holds no results; the message says why.
        """
        path = Path(path)
        _require_store(path)
        with _errors_of(path):
            connection = _connect(path, "ro")
            try:
                _require_format(path, connection)
                return cls(path, connection)
            except BaseException:
                connection.close()
                raise

    @classmethod
    def create_or_open(
        cls, path: str | Path, spec: ExperimentSpec, folder: str | Path | None = None
    ) -> Store:
        """Open an experiment's results for writing; begin them if there are none.

        The experiment may have grown since: more repetitions, more conditions. Runs that were
        given up for want of time or memory are missing again if it now allows more.

        Parameters
        ----------
        path : path
            The file.
        spec : ExperimentSpec
            The experiment.
        folder : path, optional
            What paths of environments are relative to; by default the working directory.

        Raises
        ------
        InvalidInputError
            If the file is none of results, or of another experiment, of another version of this
            program, or being written by another process; or if a run of the experiment cannot
            be. The message says what differs, and the remedy.
        """
        path = Path(path)
        folder = Path.cwd() if folder is None else Path(folder).resolve()
        planned = {run.key: (k, run) for k, run in enumerate(runs(spec, folder))}
        if path.exists():
            _require_store(path, or_empty=True)
        lock = _Lock(path)
        try:
            with _errors_of(path):
                connection = _connect(path, "rwc")
                try:
                    _begin(path, connection, spec, folder, len(planned))
                    store = cls(path, connection, lock)
                    store._planned = planned
                    store._take_up(spec, folder)
                except BaseException:
                    connection.close()
                    raise
        except BaseException:
            lock.release()
            raise
        return store

    def close(self) -> None:
        """Close it; what was added is on disk."""
        with suppress(sqlite3.Error):
            if self._lock is not None:
                # One file instead of three, unless somebody reads it now or the disk is full.
                self._connection.execute("PRAGMA busy_timeout = 0")
                self._connection.execute("PRAGMA journal_mode = DELETE")
        self._connection.close()
        if self._lock is not None:
            with suppress(OSError):  # it holds recordings, or was not made
                _recordings(self.path).rmdir()
            self._lock.release()
            self._lock = None

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    # Runs -----------------------------------------------------------------------------------

    def missing(self) -> list[PlannedRun]:
        """Give the runs that have no result yet, in the experiment's order."""
        with _errors_of(self.path):
            there = {key for (key,) in self._connection.execute("SELECT key FROM runs")}
        return [run for _, run in self._plan().values() if run.key not in there]

    def add(self, result: Result) -> None:
        """Store a result; one of a run that has one already is left out.

        Raises
        ------
        InvalidInputError
            If it cannot be written, as on a full disk; what was stored before stays.
        """
        position, _ = self._plan()[result.key]
        row = _row(result, position)
        marks = ", ".join("?" * len(_COLUMNS))
        with _errors_of(self.path), self._connection as transaction:
            transaction.execute(
                f"INSERT INTO runs ({', '.join(_COLUMNS)}) VALUES ({marks}) "
                "ON CONFLICT (key) DO NOTHING",
                row,
            )

    def forget(self, statuses: Sequence[Status] = UNFINISHED) -> int:
        """Take out the results of some statuses, so that their runs are missing again.

        Returns
        -------
        int
            How many there were.
        """
        marks = ", ".join("?" * len(statuses))
        with _errors_of(self.path), self._connection as transaction:
            return transaction.execute(
                f"DELETE FROM runs WHERE status IN ({marks})", tuple(statuses)
            ).rowcount

    def results(self) -> Results:
        """Give the results that are there, in the experiment's order."""
        with _errors_of(self.path):
            rows = self._connection.execute(
                f"SELECT {', '.join(_COLUMNS)} FROM runs ORDER BY position"
            ).fetchall()
        return Results(
            self.experiment, map(self._result, rows), asked=self.asked, provenance=self.provenance
        )

    @property
    def done(self) -> int:
        """How many runs have a result."""
        with _errors_of(self.path):
            return int(self._connection.execute("SELECT count(*) FROM runs").fetchone()[0])

    @property
    def failed(self) -> int:
        """How many of the results have to be looked at."""
        with _errors_of(self.path):
            (count,) = self._connection.execute(
                "SELECT count(*) FROM runs WHERE status != 'complete' "
                "OR json_extract(metrics, '$.collisions') > 0"
            ).fetchone()
        return int(count)

    def recording_path(self, key: str) -> Path:
        """Where the recording of a run is, if it was kept."""
        return _recordings(self.path) / f"{key}.jsonl"

    def _plan(self) -> dict[str, tuple[int, PlannedRun]]:
        if self._planned is None:
            every = runs(self.experiment, self.folder)
            self._planned = {run.key: (k, run) for k, run in enumerate(every)}
        return self._planned

    def _result(self, row: tuple[Any, ...]) -> Result:
        given = dict(zip(_COLUMNS, row, strict=True))
        del given["position"]
        condition = Condition(**{label: given.pop(label) for label in _LABELS})
        try:
            metrics, curve = given.pop("metrics"), given.pop("covered_at_s")
            return Result(
                condition=condition,
                metrics=None if metrics is None else msgspec.json.decode(metrics, type=Metrics),
                covered_at_s=msgspec.json.decode(curve, type=tuple[float | None, ...]),
                **given,
            )
        except msgspec.MsgspecError as error:
            raise InvalidInputError(
                f"{self.path}: the result of run {given['key']} is damaged: {error}"
            ) from None

    # Going on with an experiment ------------------------------------------------------------

    def _take_up(self, spec: ExperimentSpec, folder: Path) -> None:
        # Compares the experiment asked for with the one stored, which may have grown.
        stored = self._stored_places()
        if stored and (other := differences(self.provenance, provenance())):
            raise InvalidInputError(
                f"{self.path}: its runs were made by another program ({other}), and new ones "
                "would not compare with them; choose another file, or install what made them"
            )
        plan, old = self._plan(), self.experiment
        gone = sum(key not in plan for key in stored)
        if gone:
            raise InvalidInputError(
                f"{self.path}: holds another experiment: {gone} of its {len(stored)} runs are none "
                f"of this one (what differs: {_what_differs(old, spec)}); choose another file, or "
                "ask for those runs, too"
            )
        less = [
            name
            for name in spec.limits.__struct_fields__
            if stored and getattr(spec.limits, name) < getattr(old.limits, name)
        ]
        if less:
            raise InvalidInputError(
                f"{self.path}: its runs were allowed more ({', '.join(f'limits.{n}' for n in less)}"
                "); choose another file, or allow as much again"
            )
        places = {
            key: (k, *_labels(run.condition), run.repetition) for key, (k, run) in plan.items()
        }
        moved = [(*places[key], key) for key, place in stored.items() if place != places[key]]
        columns = ", ".join(f"{name} = ?" for name in ("position", *_LABELS, "repetition"))
        with self._connection as transaction:
            transaction.executemany(f"UPDATE runs SET {columns} WHERE key = ?", moved)
            for status, name in (("over_time", "computing_s"), ("over_memory", "memory_mb")):
                if getattr(spec.limits, name) > getattr(old.limits, name):
                    transaction.execute("DELETE FROM runs WHERE status = ?", (status,))
            transaction.executemany(
                "UPDATE meta SET value = ? WHERE name = ?",
                [(value, name) for name, value in _meta(spec, folder, len(plan))],
            )
        self.experiment, self.folder, self.asked = spec, folder, len(plan)
        self.provenance = provenance()
        self._clear_recordings()

    def _stored_places(self) -> dict[str, tuple[str | int, ...]]:
        # By key: where a run stands, its labels and its repetition.
        rows = self._connection.execute(
            f"SELECT key, position, {', '.join(_LABELS)}, repetition FROM runs"
        )
        return {key: tuple(place) for key, *place in rows}

    def _clear_recordings(self) -> None:
        # What a run left that was cut off while it wrote.
        folder = _recordings(self.path)
        try:
            if self.experiment.recordings != "none":
                folder.mkdir(exist_ok=True)
            for part in folder.glob("*.part"):
                part.unlink()
        except OSError as error:
            raise InvalidInputError(
                f"cannot write recordings to {folder}: {error.strerror or error}"
            ) from None


def _what_differs(old: ExperimentSpec, new: ExperimentSpec) -> str:
    names = [name for name in old.__struct_fields__ if getattr(old, name) != getattr(new, name)]
    beside = ("name", "about", "limits", "recordings")
    return ", ".join(n for n in names if n not in beside) or "what its environments' files hold"


def _labels(condition: Condition) -> tuple[str | int, ...]:
    return tuple(getattr(condition, name) for name in _LABELS)


def _row(result: Result, position: int) -> tuple[Any, ...]:
    values = {name: getattr(result.condition, name) for name in _LABELS}
    values |= {name: getattr(result, name) for name in Result.__struct_fields__}
    values["position"] = position
    for name in ("metrics", "covered_at_s"):
        if values[name] is not None:
            values[name] = msgspec.json.encode(values[name]).decode()
    return tuple(values[name] for name in _COLUMNS)


def _meta(spec: ExperimentSpec, folder: Path, asked: int) -> list[tuple[str, str]]:
    return [
        ("experiment", msgspec.json.encode(spec).decode()),
        ("folder", str(folder)),
        ("provenance", msgspec.json.encode(provenance()).decode()),
        ("asked", str(asked)),
    ]


def _recordings(path: Path) -> Path:
    return path.with_name(path.name + ".recordings")


# The file -----------------------------------------------------------------------------------


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    # Transactions are begun by Python before the first change, and ended by `with`.
    uri = f"{path.resolve().as_uri()}?mode={mode}"
    return sqlite3.connect(uri, uri=True, timeout=BUSY_S)


def _begin(
    path: Path, connection: sqlite3.Connection, spec: ExperimentSpec, folder: Path, asked: int
) -> None:
    # Makes the tables of a new file, all at once or not at all.
    if _is_new(connection):
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        with connection as transaction:
            transaction.execute("BEGIN IMMEDIATE")
            for statement in _TABLES.split(";")[:-1]:
                transaction.execute(statement)
            transaction.execute(f"PRAGMA application_id = {APPLICATION}")
            transaction.execute(f"PRAGMA user_version = {FORMAT}")
            transaction.executemany(
                "INSERT INTO meta (name, value) VALUES (?, ?)", _meta(spec, folder, asked)
            )
        return
    _require_format(path, connection)
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = NORMAL")


def _is_new(connection: sqlite3.Connection) -> bool:
    (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    return not tables and _pragma(connection, "application_id") == 0


def _pragma(connection: sqlite3.Connection, name: str) -> int:
    return int(connection.execute(f"PRAGMA {name}").fetchone()[0])


def _require_store(path: Path, *, or_empty: bool = False) -> None:
    try:
        with path.open("rb") as file:
            first = file.read(16)
    except OSError as error:
        raise InvalidInputError(
            f"{path}: {error.strerror or error}; name a file of results"
        ) from None
    if first != b"SQLite format 3\0" and not (or_empty and not first):
        raise InvalidInputError(f"{path}: not a file of results; name another one")


def _require_format(path: Path, connection: sqlite3.Connection) -> None:
    if _pragma(connection, "application_id") != APPLICATION:
        raise InvalidInputError(f"{path}: an SQLite file, but not one of results; name another one")
    version = _pragma(connection, "user_version")
    if version != FORMAT:
        which = "a newer" if version > FORMAT else "an older"
        raise InvalidInputError(
            f"{path}: results in format {version}, of {which} version of multisrt; this one "
            f"reads format {FORMAT}: use the version that made them, or another file"
        )


@contextmanager
def _errors_of(path: Path) -> Iterator[None]:
    # What SQLite says, in words that help.
    try:
        yield
    except sqlite3.Error as error:
        said = str(error)
        name = getattr(error, "sqlite_errorname", "")
        if name == "SQLITE_FULL":
            raise InvalidInputError(
                f"{path}: the disk is full; what was stored before is sound: make room, and the "
                "same command continues"
            ) from None
        if name.startswith("SQLITE_IOERR"):
            raise InvalidInputError(
                f"{path}: cannot be read or written ({said}): the disk may be full or a limit of "
                "file sizes reached; what was stored before is sound, and the same command "
                "continues"
            ) from None
        if name in ("SQLITE_CORRUPT", "SQLITE_NOTADB"):
            raise InvalidInputError(
                f"{path}: a damaged file of results ({said}); take a copy of it from before, or "
                "begin another one"
            ) from None
        raise InvalidInputError(f"{path}: {said}") from None


class _Lock:
    """The right to write to a store, of one process at a time.

    The operating system takes it back when the process ends, however it ends.
    """

    def __init__(self, path: Path) -> None:
        self._path = path.with_name(path.name + ".lock")
        while True:
            try:
                file = self._path.open("a+")
            except OSError as error:
                raise InvalidInputError(f"cannot write {path}: {error.strerror}") from None
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                file.seek(0)
                holder = file.read().strip()
                file.close()
                raise InvalidInputError(
                    f"{path}: another process makes its runs now"
                    + (f" (process {holder})" if holder else "")
                    + "; wait for it, stop it, or choose another file"
                ) from None
            except OSError as error:
                file.close()
                raise InvalidInputError(
                    f"cannot lock {path}: {error.strerror}; choose a file on another disk"
                ) from None
            if self._is_mine(file):
                break
            file.close()  # the one who had it has just taken the file away
        self._file: IO[str] = file
        with suppress(OSError):  # of use to people only
            file.truncate(0)
            file.write(str(os.getpid()))
            file.flush()

    def _is_mine(self, file: IO[str]) -> bool:
        try:
            return os.path.samestat(os.fstat(file.fileno()), self._path.stat())
        except FileNotFoundError:
            return False

    def release(self) -> None:
        with suppress(OSError):
            self._path.unlink()
        with suppress(OSError):  # what could not be written on a full disk
            self._file.close()
