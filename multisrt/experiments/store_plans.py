"""The table of a store with what the informed plan takes, for each run that it is compared with."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable
from pathlib import Path

import msgspec

from multisrt.experiments.store_file import OR_ANOTHER, PLANS, errors_of, sane
from multisrt.geometry.errors import InvalidInputError, reason_of, shown
from multisrt.informed.reference import Reference
from multisrt.validation_errors import UNREADABLE


class PlanTable:
    """References of runs, or why there is none.

    Parameters
    ----------
    path : Path
        The file of the store, for messages.
    connection : sqlite3.Connection
        A connection to it.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self._path = path
        self._connection = connection

    def read(self) -> dict[str, Reference | str]:
        """Return the references by the keys of their runs, or why a run has none.

        Returns
        -------
        dict of str to Reference or str
            Empty if none was asked for.

        Raises
        ------
        InvalidInputError
            If the file cannot be read, or a row is damaged.
        """
        with errors_of(self._path):
            there = self._connection.execute(
                "SELECT 1 FROM sqlite_master WHERE name = 'plans'"
            ).fetchone()
            rows = (
                self._connection.execute("SELECT run, reference, reason FROM plans").fetchall()
                if there
                else []
            )
        found: dict[str, Reference | str] = {}
        for run, reference, reason in rows:
            try:
                plan = None if reference is None else sane(msgspec.json.decode(reference))
                found[msgspec.convert(run, str)] = (
                    sane(msgspec.convert(reason, str))
                    if plan is None
                    else msgspec.convert(plan, Reference)
                )
            except (*UNREADABLE, TypeError) as error:
                raise InvalidInputError(
                    f"{self._path}: the plan of run {shown(run)} is damaged: {reason_of(error)}; "
                    f"{OR_ANOTHER}"
                ) from None
        return found

    def missing(self) -> set[str]:
        """Return the keys of the measured runs whose plan is not there.

        Returns
        -------
        set of str
            The keys.

        Raises
        ------
        InvalidInputError
            If the file cannot be read.
        """
        with errors_of(self._path):
            rows = self._connection.execute("SELECT key FROM runs WHERE metrics IS NOT NULL")
            return {key for (key,) in rows} - self.read().keys()

    def add(self, runs: Iterable[str], found: Reference | str) -> None:
        """Store what the informed plan takes for some runs.

        Parameters
        ----------
        runs : iterable of str
            Keys of the runs, which have the same world, team and starts.
        found : Reference or str
            The reference, or why there is none.

        Raises
        ------
        InvalidInputError
            If it cannot be written.
        """
        row = (None, found) if isinstance(found, str) else (msgspec.json.encode(found).decode(), "")
        with errors_of(self._path), self._connection as transaction:
            transaction.execute(PLANS)
            transaction.executemany(
                "INSERT OR REPLACE INTO plans (run, reference, reason) VALUES (?, ?, ?)",
                [(run, *row) for run in runs],
            )

    def forget(self) -> None:
        """Delete the plans that failed, and those of runs that are gone."""
        with errors_of(self._path), self._connection as transaction:
            transaction.execute(PLANS)
            transaction.execute(
                "DELETE FROM plans WHERE reference IS NULL OR run NOT IN (SELECT key FROM runs)"
            )
