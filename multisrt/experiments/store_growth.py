"""Requirements for continuing a store with an experiment that contains its own."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import msgspec

from multisrt.experiments.crossing import Condition, PlannedRun
from multisrt.experiments.provenance import Provenance, differences
from multisrt.experiments.results import can_move_horizon
from multisrt.experiments.spec import ExperimentSpec
from multisrt.geometry.errors import MAX_REASON, InvalidInputError, shortened

Plan = dict[str, tuple[int, PlannedRun]]
"""The runs of an experiment by key, each with its position."""

OTHER_FILE = "choose another file (--store on the command line, store=... in Python)"
"""What to do about results that an experiment cannot continue."""

_LABELS = Condition.__struct_fields__
_PLACE = ("position", *_LABELS, "repetition")


def meta_of(
    spec: ExperimentSpec, folder: Path, made_by: Provenance, planned: int
) -> list[tuple[str, str]]:
    """Return names and values for the table `meta` of an experiment with a number of runs."""
    return [
        ("experiment", msgspec.json.encode(spec).decode()),
        ("folder", str(folder)),
        ("provenance", msgspec.json.encode(made_by).decode()),
        ("asked", str(planned)),
    ]


def require_continuable(
    path: Path, connection: sqlite3.Connection, old: ExperimentSpec, new: ExperimentSpec, plan: Plan
) -> None:
    """Raise InvalidInputError unless stored runs are runs of another experiment, too.

    Parameters
    ----------
    path : Path
        The file, for messages.
    connection : sqlite3.Connection
        A connection to it.
    old, new : ExperimentSpec
        The stored experiment and the one that replaces it.
    plan : dict
        The runs of the new experiment.
    """
    stored = [key for (key,) in connection.execute("SELECT key FROM runs")]
    gone = sum(key not in plan for key in stored)
    if gone:
        raise InvalidInputError(
            f"{path}: holds another experiment: {gone} of its {len(stored)} runs do not "
            f"belong to this one (what differs: {_what_differs(old, new)}); {OTHER_FILE}, "
            "or extend the experiment by those runs"
        )
    less = [
        name
        for name in new.limits.__struct_fields__
        if stored and getattr(new.limits, name) < getattr(old.limits, name)
    ]
    if less:
        raise InvalidInputError(
            f"{path}: its runs were allowed more ({', '.join(f'limits.{n}' for n in less)}"
            f"); {OTHER_FILE}, or allow as much again"
        )
    _require_horizon(path, connection, old, new)


def require_same_program(path: Path, old: Provenance, new: Provenance) -> None:
    """Raise InvalidInputError unless new runs are made by the program that made the stored ones.

    Parameters
    ----------
    path : Path
        The file, for messages.
    old, new : Provenance
        What made the stored runs, and what makes new ones.
    """
    if other := differences(old, new):
        raise InvalidInputError(
            f"{path}: its runs were made by another program ({shortened(other, MAX_REASON)}), and "
            f"new ones would not be comparable; {OTHER_FILE}, or install what made them"
        )


def runs_of_changed(
    path: Path, connection: sqlite3.Connection, changed: list[str], plan: Plan, *, remake: bool
) -> list[str]:
    """Return the stored runs of user-defined strategies that have changed since.

    Parameters
    ----------
    path : Path
        The file, for messages.
    connection : sqlite3.Connection
        A connection to it.
    changed : list of str
        Names of the strategies.
    plan : dict
        The runs of the new experiment; all stored runs are among them.
    remake : bool
        Whether there may be any.

    Returns
    -------
    list of str
        Keys of the runs.

    Raises
    ------
    InvalidInputError
        If there are any that are not to be made again.
    """
    stored = [key for (key,) in connection.execute("SELECT key FROM runs")]
    found = [key for key in stored if plan[key][1].spec.strategy in changed]
    if found and not remake:
        names = ", ".join(repr(name) for name in changed)
        raise InvalidInputError(
            f"{path}: the source of {names} has changed since {len(found)} of these runs were "
            "made, and new ones would not be comparable; make those again (--remake on the "
            f"command line, remake=True in Python), or {OTHER_FILE}"
        )
    return found


def move(transaction: sqlite3.Connection, plan: Plan) -> None:
    """Give stored runs the positions, labels and repetitions that they have in a plan.

    Parameters
    ----------
    transaction : sqlite3.Connection
        A connection to the store, in a transaction.
    plan : dict
        The runs of the experiment; all stored runs are among them.
    """
    places = {
        key: (position, *(getattr(run.condition, name) for name in _LABELS), run.repetition)
        for key, (position, run) in plan.items()
    }
    rows = transaction.execute(f"SELECT key, {', '.join(_PLACE)} FROM runs").fetchall()
    columns = ", ".join(f"{name} = :{name}" for name in _PLACE)
    transaction.executemany(
        # Twins move by the same number; a right-hand side has the values from before.
        f"UPDATE runs SET same_as = same_as + :repetition - repetition, {columns} WHERE key = :key",
        [
            dict(zip(_PLACE, places[key], strict=True)) | {"key": key}
            for key, *place in rows
            if tuple(place) != places[key]
        ],
    )


def _require_horizon(
    path: Path, connection: sqlite3.Connection, old: ExperimentSpec, new: ExperimentSpec
) -> None:
    """Raise InvalidInputError if stored integrals cannot be brought to the new horizon."""
    if new.horizon_s == old.horizon_s:
        return
    ends = connection.execute(
        "SELECT json_extract(metrics, '$.makespan_s'), horizon_s FROM runs "
        "WHERE metrics IS NOT NULL"
    ).fetchall()
    cut = sum(
        not can_move_horizon(end_s, at_s, end_s if new.horizon_s is None else new.horizon_s)
        for end_s, at_s in ends
    )
    if cut:
        raise InvalidInputError(
            f"{path}: the integrals of {cut} of its runs cannot be brought from horizon_s = "
            f"{old.horizon_s} to {new.horizon_s}; {OTHER_FILE}, or leave it as it was"
        )


def _what_differs(old: ExperimentSpec, new: ExperimentSpec) -> str:
    names = [name for name in old.__struct_fields__ if getattr(old, name) != getattr(new, name)]
    beside = ("name", "about", "limits", "success_coverage", "horizon_s", "reference", "recordings")
    return ", ".join(n for n in names if n not in beside) or "what its environments' files hold"
