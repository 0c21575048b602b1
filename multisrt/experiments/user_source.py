"""The source code of user-defined strategies, as far as results depend on it."""

from __future__ import annotations

import hashlib
import inspect
import sys
from collections.abc import Iterable, Iterator
from types import CodeType
from typing import Any

from multisrt.experiments.modules import TO_A_FILE, home_modules, own_strategies
from multisrt.experiments.provenance import Provenance, code_of, provenance
from multisrt.experiments.spec import ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.strategy import Strategy
from multisrt.robots.user_modules import files_behind, require_current


def provenance_with(own: Iterable[Strategy]) -> Provenance:
    """Return the provenance of results that this process makes with user-defined strategies.

    Parameters
    ----------
    own : iterable of Strategy
        The strategies.

    Returns
    -------
    Provenance
        Versions, machine, program, and the digests of the strategies' source.
    """
    base = provenance()
    return Provenance(
        versions=base.versions,
        program=base.program,
        machine=base.machine,
        system=base.system,
        strategies={strategy.name: source_digest(strategy) for strategy in own},
    )


def source_digest(own: Strategy) -> str:
    """Return a digest of the source of a strategy.

    That is the code of the file that defines it and of what it imports, directly or not, from
    files that are neither libraries nor part of this package. Docstrings, blank lines, comments
    and the messages of raised errors do not count, nor where the files are.

    Parameters
    ----------
    own : Strategy
        The strategy.

    Returns
    -------
    str
        Equal for equal source; empty if there is no file, as for a notebook's cell.

    Raises
    ------
    InvalidInputError
        If a file cannot be read, or has changed since this process imported it.
    """
    files = sorted(_code_behind(own))
    if not files:
        return ""
    digest = hashlib.sha256()
    for code in files:
        digest.update(f"{len(code)}\n".encode())
        digest.update(code)
    return digest.hexdigest()[:16]


def require_files(spec: ExperimentSpec) -> None:
    """Check that changes of user-defined strategies can be noticed when results are kept.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.

    Raises
    ------
    InvalidInputError
        If a strategy is defined in a notebook's cell or at the prompt.
    """
    for own in own_strategies(spec):
        if next(iter(files_behind(home_modules(own))), None) is None:
            raise InvalidInputError(
                f"the strategy {own.name!r} is in no file, and results in a store could be of "
                f"several versions of it; {TO_A_FILE}, or keep results in memory alone: leave out "
                "store"
            )


def _code_behind(own: Strategy) -> Iterator[bytes]:
    modules = home_modules(own)
    for module in modules:
        require_current(module)
    _require_latest(own)
    contents = {file.path: file.content for file in files_behind(modules)}
    for path, content in contents.items():
        try:
            yield code_of(content)
        except (SyntaxError, UnicodeDecodeError) as error:
            raise InvalidInputError(f"{path}: cannot be read as Python: {error}") from None


def _require_latest(own: Strategy) -> None:
    """Check that an explorer's class or function is not of an earlier import of its module."""
    explorer: Any = inspect.unwrap(own.explorer)
    home = sys.modules.get(explorer.__module__)
    name = getattr(explorer, "__qualname__", "")
    latest: Any = None if home is None or not hasattr(home, "__file__") else vars(home).get(name)
    told = [getattr(latest, field, None) for field in ("__module__", "__qualname__")]
    if told != [explorer.__module__, name]:
        return
    # Classes that one import makes in a loop share their code; imports do not.
    codes = {id(code) for code in _codes(latest)}
    if latest is not explorer and codes and codes.isdisjoint(map(id, _codes(explorer))):
        raise InvalidInputError(
            f"{name}, of the strategy {own.name!r}, is of an earlier import of "
            f"{explorer.__module__}: import it from there again"
        )


def _codes(explorer: Any) -> list[CodeType]:
    functions = vars(explorer).values() if inspect.isclass(explorer) else [explorer]
    return [each.__code__ for each in functions if inspect.isfunction(each)]
