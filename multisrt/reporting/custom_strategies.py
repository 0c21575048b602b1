"""User-defined strategies in a report: whether they are those that made the runs, and a command."""

from __future__ import annotations

import os
from pathlib import Path

from multisrt.experiments.modules import reference_of
from multisrt.experiments.results import Results
from multisrt.experiments.user_source import source_digest
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.registry import is_built_in, is_known
from multisrt.robots.registry import strategy as strategy_named


def cautions(results: Results) -> list[str]:
    """Return which user-defined strategies are not those that made the runs.

    Parameters
    ----------
    results : Results
        Results of an experiment.

    Returns
    -------
    list of str
        A sentence for each strategy that is unknown here, or whose source has changed since.
    """
    told = []
    for name, made_by in results.provenance.strategies.items():
        if not is_known(name):
            told.append(
                f"The strategy {name!r} is not known here, and its runs are not drawn: import the "
                "file that has it (--import FILE.py)."
            )
        elif _digest(name) != made_by:
            told.append(
                f"The source of the strategy {name!r} has changed since these runs were made: the "
                "numbers are those of the old one, and runs that the new one makes otherwise are "
                "not drawn."
            )
    return told


def _digest(name: str) -> str | None:
    try:
        return source_digest(strategy_named(name))
    except InvalidInputError:  # its file has changed since it was imported
        return None


def imported(name: str, folder: Path) -> str:
    """Return the reference by which a user-defined strategy is imported again.

    Parameters
    ----------
    name : str
        Name of a strategy.
    folder : Path
        The folder that the path of its file starts from.

    Returns
    -------
    str
        Empty for a built-in strategy, and for one that cannot be imported, as of a notebook.
    """
    if is_built_in(name):
        return ""
    try:
        reference = reference_of(strategy_named(name))
    except InvalidInputError:
        return ""
    return os.path.relpath(reference, folder.resolve()) if os.path.isabs(reference) else reference


def imports(results: Results, folder: Path) -> list[str]:
    """Return the references of all user-defined strategies in an experiment; see `imported`."""
    found = (imported(name, folder) for name in results.provenance.strategies)
    return [reference for reference in found if reference]
