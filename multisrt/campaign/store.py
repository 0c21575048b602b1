"""The missions of a campaign on disk: one SQLite file with a row for each.

A row is written in one transaction when its mission is judged and the folders of its failures are
there: however the program ends, stored missions are there, each once, and the next call makes the
others. The file is opened and closed like that of an experiment; see `multisrt.experiments.store`.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import msgspec

from multisrt.campaign.lane import Mission
from multisrt.campaign.violations import Violation
from multisrt.experiments.lock import WriteLock
from multisrt.experiments.provenance import program_digest, provenance
from multisrt.experiments.store_file import (
    FileKind,
    StoreFile,
    errors_of,
    open_to_read,
    open_to_write,
    sane,
)
from multisrt.geometry.errors import InvalidInputError, reason_of, shown
from multisrt.validation_errors import UNREADABLE

NOT_DRAWN: Final = "(not drawn)"
"""The strategy of a mission whose drawing failed."""

MISSIONS: Final = FileKind(
    application=0x4D534343,  # "MSCC"
    version=1,
    contents="missions",
    belongs_to="a campaign",
    tables="""
CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE missions (
    number INTEGER PRIMARY KEY,
    strategy TEXT NOT NULL,
    world TEXT NOT NULL,
    robots INTEGER NOT NULL,
    refused INTEGER NOT NULL,
    outcome TEXT NOT NULL,
    reason TEXT NOT NULL,
    time_s REAL NOT NULL,
    events INTEGER NOT NULL,
    steps INTEGER NOT NULL,
    digest TEXT NOT NULL,
    repeated INTEGER NOT NULL,
    violations TEXT NOT NULL,
    folders TEXT NOT NULL,
    run_s REAL NOT NULL,
    check_s REAL NOT NULL
);
""",
)
"""Files of the missions of a campaign."""


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """A mission that is stored.

    Attributes
    ----------
    number : int
        Its number.
    strategy, world : str
        Its strategy, and the name of its world.
    robots, refused : int
        Number of robots, and of draws that the program refused as impossible.
    outcome, reason : str
        How the run ended, and why; see `multisrt.campaign.mission.Verdict`.
    time_s : float
        When it ended, in seconds of the run.
    events, steps : int
        Numbers of recorded events and of events of the clock.
    digest : str
        Digest of the recording.
    repeated : bool
        Whether it was repeated in another process.
    violations : tuple of Violation
        The invariants that do not hold.
    folders : tuple of str
        Folders of its failures.
    run_s, check_s : float
        Elapsed time of the run and of the invariants (s).
    """

    number: int
    strategy: str
    world: str
    robots: int
    refused: int
    outcome: str
    reason: str
    time_s: float
    events: int
    steps: int
    digest: str
    repeated: bool
    violations: tuple[Violation, ...]
    folders: tuple[str, ...]
    run_s: float
    check_s: float


def row_of(mission: Mission) -> Row:
    """Return what is stored of a mission."""
    verdict, spec = mission.verdict, mission.spec
    return Row(
        number=mission.number,
        strategy=NOT_DRAWN if spec is None else spec.strategy,
        world="" if spec is None else getattr(spec.environment, "name", ""),
        robots=0 if spec is None else len(spec.robots),
        refused=mission.refused,
        repeated=mission.repeated,
        folders=mission.folders,
        outcome=verdict.outcome,
        reason=verdict.reason,
        time_s=verdict.time_s,
        events=verdict.events,
        steps=verdict.steps,
        digest=verdict.digest,
        violations=verdict.violations,
        run_s=verdict.run_s,
        check_s=verdict.check_s,
    )


class CampaignStore(StoreFile):
    """The missions of a campaign so far, opened by `create_or_open` or `open`.

    As a context manager it closes itself.

    Attributes
    ----------
    path : Path
        The file.
    seed : int
        Seed of the campaign.
    program : str
        Digest of the program that made it.

    Examples
    --------
    >>> with CampaignStore.create_or_open("campaign.sqlite", seed=7) as store:
    ...     store.done()
    set()
    >>> with CampaignStore.open("campaign.sqlite") as store:
    ...     store.seed
    7
    """

    def __init__(
        self, path: Path, connection: sqlite3.Connection, lock: WriteLock | None = None
    ) -> None:
        super().__init__(path, connection, lock)
        meta = self._meta()
        missing = [name for name in ("seed", "program") if name not in meta]
        if missing:
            raise self.damaged(f"it does not say the {missing[0]} of its campaign")
        try:
            self.seed = int(meta["seed"])
        except ValueError:
            raise self.damaged(f"its seed is {shown(meta['seed'])}, no whole number") from None
        if self.seed < 0:
            raise self.damaged(f"the seed of a campaign is 0 or positive, not {self.seed}")
        self.program = meta["program"]

    @classmethod
    def open(cls, path: str | Path) -> CampaignStore:
        """Open the missions of a campaign for reading, even while another process writes them.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        CampaignStore
            The store.

        Raises
        ------
        InvalidInputError
            If the file cannot be read or holds no missions.
        """
        return open_to_read(Path(path), MISSIONS, cls)

    @classmethod
    def create_or_open(cls, path: str | Path, seed: int | None = None) -> CampaignStore:
        """Open the missions of a campaign for writing; create the file if there is none.

        Parameters
        ----------
        path : str or Path
            The file.
        seed : int, optional
            Seed of the campaign; by default that of the file, and 0 for a new one.

        Returns
        -------
        CampaignStore
            The store, locked against other writers until it is closed.

        Raises
        ------
        InvalidInputError
            If the file holds something else, missions of another seed or of another version of
            this program, or another process writes it.
        """

        def make(path: Path, connection: sqlite3.Connection, lock: WriteLock) -> CampaignStore:
            store = cls(path, connection, lock)
            store._require_same(seed)
            return store

        meta = (
            ("seed", str(0 if seed is None else seed)),
            ("program", _program()),
            ("provenance", msgspec.json.encode(provenance()).decode()),
        )
        return open_to_write(Path(path), MISSIONS, meta, make)

    def _require_same(self, seed: int | None) -> None:
        if seed not in (None, self.seed):
            raise InvalidInputError(
                f"{self.path} holds missions of seed {self.seed}, not {seed}: leave out the seed, "
                "or name another file"
            )
        if self.program != _program():
            raise InvalidInputError(
                f"{self.path}: its missions were made by another version of this program, whose "
                "draws and results are not comparable: name another file"
            )

    @property
    def is_of_this_program(self) -> bool:
        """Whether this version of the program made it: whether it draws the same missions."""
        return self.program == _program()

    def add(self, row: Row) -> None:
        """Store a mission, unless it is stored already.

        Parameters
        ----------
        row : Row
            What is stored of it.

        Raises
        ------
        InvalidInputError
            If it cannot be written, as on a full disk; missions stored before stay.
        """
        names = Row.__struct_fields__
        values = {name: getattr(row, name) for name in names}
        for name in ("violations", "folders"):
            values[name] = msgspec.json.encode(values[name]).decode()
        with errors_of(self.path), self._connection as transaction:
            transaction.execute(
                f"INSERT INTO missions ({', '.join(names)}) "
                f"VALUES ({', '.join('?' * len(names))}) ON CONFLICT (number) DO NOTHING",
                tuple(values[name] for name in names),
            )

    def done(self) -> set[int]:
        """Return the numbers of the missions that are stored."""
        with errors_of(self.path):
            return {number for (number,) in self._connection.execute("SELECT number FROM missions")}

    def rows(self) -> Iterator[Row]:
        """Yield the missions that are stored, by their numbers.

        Yields
        ------
        Row
            What is stored of each.

        Raises
        ------
        InvalidInputError
            If the file cannot be read, or a row is damaged.
        """
        names = Row.__struct_fields__
        with errors_of(self.path):
            found = self._connection.execute(
                f"SELECT {', '.join(names)} FROM missions ORDER BY number"
            )
            for values in found:
                yield self._row(dict(zip(names, values, strict=True)))

    def _row(self, values: dict[str, object]) -> Row:
        try:
            for name in ("violations", "folders"):
                values[name] = msgspec.json.decode(str(values[name]))
            row = msgspec.convert(sane(values), Row, strict=False)
        except (*UNREADABLE, TypeError) as error:
            raise self.damaged(f"a mission: {reason_of(error)}") from None
        if len(row.violations) != len(row.folders):
            raise self.damaged(f"mission {row.number} has not one folder for each violation")
        return row


def _program() -> str:
    return program_digest("campaign")
