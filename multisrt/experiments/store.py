"""The results of an experiment on disk: one SQLite file with a row for each run.

A row is written in one transaction when its run has ended: however the program ends, stored runs
are there, each once, and the next call makes the others. While it is written the file is in
SQLite's write-ahead mode, so that reports can read it; closed, it is a single file. With
`synchronous=NORMAL` a power failure may lose the last runs, which are then made again, but cannot
damage the file. What a writer that was killed leaves beside the file is folded into it by the
next that closes it, reader or writer.

Tables: `meta` (experiment, folder, provenance, number of runs), `runs` (the labels of a condition
and the fields of `Result`; fields with parts are JSON), and `plans` (see `store_plans`).
"""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import msgspec

from multisrt.experiments.crossing import PlannedRun, runs
from multisrt.experiments.lock import WriteLock
from multisrt.experiments.modules import own_strategies
from multisrt.experiments.provenance import Provenance, changed_strategies
from multisrt.experiments.results import ENDED, Result, Results, Status, referred
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store_file import (
    RESULTS,
    StoreFile,
    errors_of,
    open_to_read,
    open_to_write,
)
from multisrt.experiments.store_growth import (
    Plan,
    meta_of,
    move,
    require_continuable,
    require_same_program,
    runs_of_changed,
)
from multisrt.experiments.store_plans import PlanTable
from multisrt.experiments.store_rows import COLUMNS, result_of, row_of
from multisrt.experiments.user_source import provenance_with
from multisrt.geometry.errors import InvalidInputError, reason_of

UNFINISHED: tuple[Status, ...] = ("over_time", "over_memory", "crashed", "refused", "error")
"""Statuses of runs that failed without a result; see `Store.forget`."""


class Store(StoreFile):
    """An experiment with its results so far, opened by `create_or_open` or `open`.

    As a context manager it closes itself.

    Attributes
    ----------
    path : Path
        The file.
    experiment : ExperimentSpec
        The experiment.
    folder : Path
        Folder that relative paths of environments refer to.
    provenance : Provenance
        Versions and machine that make the results.
    planned : int
        Number of runs of the experiment.
    plans : PlanTable
        What the informed plan takes, for the runs that are compared with it.

    Examples
    --------
    >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
    >>> with Store.create_or_open("minpos.sqlite", spec) as store:
    ...     print(store.done, "of", store.planned)
    0 of 20
    """

    def __init__(
        self, path: Path, connection: sqlite3.Connection, lock: WriteLock | None = None
    ) -> None:
        super().__init__(path, connection, lock)
        self._planned: Plan | None = None
        self.plans = PlanTable(path, connection)
        meta = self._meta()
        try:
            self.experiment = ExperimentSpec.from_json(meta["experiment"])
            self.folder = Path(meta["folder"])
            self.provenance = msgspec.json.decode(meta["provenance"], type=Provenance)
            self.planned = int(meta["asked"])
        except (KeyError, ValueError, msgspec.MsgspecError) as error:
            raise self.damaged(reason_of(error)) from None

    # Opening --------------------------------------------------------------------------------

    @classmethod
    def open(cls, path: str | Path) -> Store:
        """Open results for reading, even while another process writes them.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Store
            The store.

        Raises
        ------
        InvalidInputError
            If the file cannot be read or holds no results.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> Store.create_or_open("x.sqlite", spec).close()
        >>> with Store.open("x.sqlite") as store:
        ...     store.done, store.planned
        (0, 20)
        """
        return open_to_read(Path(path), RESULTS, cls)

    @classmethod
    def create_or_open(
        cls,
        path: str | Path,
        spec: ExperimentSpec,
        folder: str | Path | None = None,
        *,
        remake: bool = False,
    ) -> Store:
        """Open an experiment's results for writing; create the file if there is none.

        The experiment may have grown since, by repetitions or conditions. Runs that exceeded a
        limit are missing again if the experiment now allows more.

        Parameters
        ----------
        path : str or Path
            The file.
        spec : ExperimentSpec
            The experiment.
        folder : str or Path, optional
            Folder that relative paths of environments refer to; by default the working directory.
        remake : bool, optional
            Whether the results of user-defined strategies that have changed since are deleted.

        Returns
        -------
        Store
            The store, locked against other writers until it is closed.

        Raises
        ------
        InvalidInputError
            If the file holds something else, another experiment, or results of another version of
            this program or of a strategy; if another process writes it; or if a run is
            impossible. The message says what differs, and the remedy.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> with Store.create_or_open("new.sqlite", spec) as store:
        ...     store.planned
        20
        """
        folder = Path.cwd() if folder is None else Path(folder).resolve()
        planned = {run.key: (k, run) for k, run in enumerate(runs(spec, folder))}
        made_by = provenance_with(own_strategies(spec))

        def make(path: Path, connection: sqlite3.Connection, lock: WriteLock) -> Store:
            store = cls(path, connection, lock)
            store._planned = planned
            store._continue(spec, folder, made_by, remake=remake)
            return store

        return open_to_write(
            Path(path), RESULTS, meta_of(spec, folder, made_by, len(planned)), make
        )

    def close(self) -> None:
        """Close the file and release the lock; results that were added stay.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> store = Store.create_or_open("c.sqlite", spec)
        >>> store.close()
        """
        if self._lock is not None:
            with suppress(OSError):  # not empty, or not there
                for part in _recordings(self.path).glob("*.part"):
                    part.unlink()  # of a run whose process was ended
                _recordings(self.path).rmdir()
        super().close()

    # Runs -----------------------------------------------------------------------------------

    def runs(self) -> list[PlannedRun]:
        """Return all runs of the experiment, in its order.

        Returns
        -------
        list of PlannedRun
            The runs.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> with Store.create_or_open("all.sqlite", spec) as store:
        ...     len(store.runs())
        20
        """
        return [run for _, run in self._plan().values()]

    def missing(self) -> list[PlannedRun]:
        """Return the runs that have no result yet.

        Returns
        -------
        list of PlannedRun
            The runs, in the experiment's order.

        Raises
        ------
        InvalidInputError
            If the file cannot be read.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> with Store.create_or_open("m.sqlite", spec) as store:
        ...     [run.spec.seed for run in store.missing()][:3]
        [0, 1, 2]
        """
        there = self._keys()
        return [run for _, run in self._plan().values() if run.key not in there]

    def add(self, result: Result) -> None:
        """Store the result of a run, unless it has one already.

        Parameters
        ----------
        result : Result
            The result; its key is that of a run of the experiment.

        Raises
        ------
        InvalidInputError
            If it cannot be written, as on a full disk; results stored before stay.

        Examples
        --------
        >>> from multisrt.experiments.mission import make_run
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> with Store.create_or_open("a.sqlite", spec) as store:
        ...     store.add(make_run(store.missing()[0], spec.limits))
        ...     store.done
        1
        """
        position, _ = self._plan()[result.key]
        row = row_of(result, position)
        marks = ", ".join("?" * len(COLUMNS))
        with errors_of(self.path), self._connection as transaction:
            transaction.execute(
                f"INSERT INTO runs ({', '.join(COLUMNS)}) VALUES ({marks}) "
                "ON CONFLICT (key) DO NOTHING",
                row,
            )

    def take_from(self, other: Store) -> int:
        """Store the results of runs that another experiment has as well.

        Parameters
        ----------
        other : Store
            The results of the other experiment, which has the same `horizon_s`. Runs that failed
            without a result are not taken.

        Returns
        -------
        int
            Number of results that were missing here.

        Raises
        ------
        InvalidInputError
            If another program made them, or they cannot be read or written.

        Examples
        --------
        >>> from multisrt.experiments.mission import make_run
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> more = msgspec.structs.replace(spec, name="y", robots=(1, 2))
        >>> with Store.create_or_open("own.sqlite", spec) as store:
        ...     store.add(make_run(store.missing()[0], spec.limits))
        ...     with Store.create_or_open("other.sqlite", more) as another:
        ...         another.take_from(store), another.take_from(store)
        (1, 0)
        """
        require_same_program(other.path, other.provenance, self.provenance)
        missing = {run.key: run for run in self.missing()}
        taken = [one for one in other._read() if one.key in missing and one.status in ENDED]
        for result in taken:
            run = missing[result.key]
            shift = run.repetition - result.repetition
            self.add(
                msgspec.structs.replace(
                    result,
                    condition=run.condition,
                    repetition=run.repetition,
                    same_as=None if result.same_as is None else result.same_as + shift,
                )
            )
        return len(taken)

    def forget(self, statuses: Sequence[Status] = UNFINISHED) -> int:
        """Delete the results of some statuses, and plans that failed: they are missing again.

        Parameters
        ----------
        statuses : sequence of str
            The statuses; by default those of runs that failed without a result.

        Returns
        -------
        int
            Number of deleted results.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> with Store.create_or_open("f.sqlite", spec) as store:
        ...     store.forget(["crashed"])
        0
        """
        marks = ", ".join("?" * len(statuses))
        with errors_of(self.path), self._connection as transaction:
            deleted = transaction.execute(
                f"DELETE FROM runs WHERE status IN ({marks})", tuple(statuses)
            ).rowcount
        self.plans.forget()
        return deleted

    def results(self) -> Results:
        """Return the results so far.

        Returns
        -------
        Results
            The results, in the experiment's order.

        Raises
        ------
        InvalidInputError
            If the file cannot be read, or a row is damaged.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> with Store.create_or_open("r.sqlite", spec) as store:
        ...     len(store.results())
        0
        """
        results = referred(self._read(), self.plans.read())
        try:
            return Results(
                self.experiment, results, planned=self.planned, provenance=self.provenance
            )
        except InvalidInputError as error:
            raise self.damaged(str(error)) from None

    def ended(self) -> set[str]:
        """Return the keys of the runs that did not fail without a result."""
        return self._keys(f"WHERE status IN {ENDED}")  # a tuple of texts is a list of SQL

    def of_no_chance(self) -> list[Result]:
        """Return the runs that were made and in which no random number was drawn.

        Returns
        -------
        list of Result
            Their results, in the experiment's order.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> with Store.create_or_open("n.sqlite", spec) as store:
        ...     store.of_no_chance()
        []
        """
        return self._read("WHERE chance = 0 AND same_as IS NULL")

    def _keys(self, where: str = "") -> set[str]:
        with errors_of(self.path):
            return {key for (key,) in self._connection.execute(f"SELECT key FROM runs {where}")}

    def _read(self, where: str = "") -> list[Result]:
        with errors_of(self.path):
            rows = self._connection.execute(
                f"SELECT {', '.join(COLUMNS)} FROM runs {where} ORDER BY position"
            ).fetchall()
        return [result_of(self.path, row, self.experiment.success_coverage) for row in rows]

    @property
    def done(self) -> int:
        """Number of runs that have a result."""
        with errors_of(self.path):
            return int(self._connection.execute("SELECT count(*) FROM runs").fetchone()[0])

    @property
    def failed(self) -> int:
        """Number of results that did not succeed."""
        return sum(result.failed for result in self._read())

    def recording_path(self, key: str) -> Path:
        """Return the path of a run's recording.

        Parameters
        ----------
        key : str
            Key of the run.

        Returns
        -------
        Path
            The path; the file exists only if the recording was kept.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
        >>> with Store.create_or_open("p.sqlite", spec) as store:
        ...     store.recording_path(store.missing()[0].key).suffix
        '.jsonl'
        """
        return _recordings(self.path) / f"{key}.jsonl"

    def _plan(self) -> Plan:
        if self._planned is None:
            every = runs(self.experiment, self.folder)
            self._planned = {run.key: (k, run) for k, run in enumerate(every)}
        return self._planned

    # Continuing an experiment ---------------------------------------------------------------

    def _continue(
        self, spec: ExperimentSpec, folder: Path, made_by: Provenance, *, remake: bool
    ) -> None:
        """Replace the stored experiment by one that contains it, or raise InvalidInputError."""
        plan, old = self._plan(), self.provenance
        outdated = self._outdated(spec, plan, made_by, remake=remake)
        with self._connection as transaction:
            transaction.executemany("DELETE FROM runs WHERE key = ?", [(key,) for key in outdated])
            try:
                move(transaction, plan)
            except KeyError as key:
                raise self.damaged(f"run {key} is in its table and not in its index") from None
            for status, name in (("over_time", "computing_s"), ("over_memory", "memory_mb")):
                if getattr(spec.limits, name) > getattr(self.experiment.limits, name):
                    transaction.execute("DELETE FROM runs WHERE status = ?", (status,))
            made_by = msgspec.structs.replace(
                made_by, strategies=old.strategies | made_by.strategies
            )
            transaction.executemany(
                "UPDATE meta SET value = ? WHERE name = ?",
                [(value, name) for name, value in meta_of(spec, folder, made_by, len(plan))],
            )
        self.experiment, self.folder, self.planned = spec, folder, len(plan)
        self.provenance = made_by
        self._clear_recordings(outdated)

    def require_continuable_by(self, spec: ExperimentSpec, planned: Sequence[PlannedRun]) -> None:
        """Raise InvalidInputError unless `create_or_open` continues this with an experiment."""
        plan = {run.key: (k, run) for k, run in enumerate(planned)}
        with errors_of(self.path):
            self._outdated(spec, plan, provenance_with(own_strategies(spec)), remake=False)

    def _outdated(
        self, spec: ExperimentSpec, plan: Plan, made_by: Provenance, *, remake: bool
    ) -> list[str]:
        """Return the keys of runs to be made again, or raise InvalidInputError."""
        if self.done:
            require_same_program(self.path, self.provenance, made_by)
        require_continuable(self.path, self._connection, self.experiment, spec, plan)
        changed = changed_strategies(self.provenance, made_by)
        return runs_of_changed(self.path, self._connection, changed, plan, remake=remake)

    def _clear_recordings(self, outdated: Sequence[str]) -> None:
        """Make the folder of recordings, and remove those of runs that are cut off or outdated."""
        folder = _recordings(self.path)
        try:
            if self.experiment.recordings != "none":
                folder.mkdir(exist_ok=True)
            for part in (*folder.glob("*.part"), *map(self.recording_path, outdated)):
                part.unlink(missing_ok=True)
        except OSError as error:
            raise InvalidInputError(
                f"cannot write recordings to {folder}: {error.strerror or error}"
            ) from None


def _recordings(path: Path) -> Path:
    return path.with_name(path.name + ".recordings")
