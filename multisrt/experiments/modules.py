"""User-defined strategies in worker processes: from a strategy to what imports it there."""

from __future__ import annotations

import ast
import builtins
import inspect
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from multisrt.experiments.spec import ExperimentSpec, StrategyChoice
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.explorer import Explorer
from multisrt.robots.loading import import_reference, name_of
from multisrt.robots.registry import is_built_in, strategy
from multisrt.robots.strategy import Strategy
from multisrt.robots.user_modules import is_ours, path_of

Entrant = str | StrategyChoice | Strategy | Callable[..., Explorer]
"""A strategy to compare: its name, with or without options, or a user-defined one as an object."""

TO_A_FILE = "write it to a file and import it from there (in a notebook: %%writefile mine.py)"


def import_modules(references: Sequence[str]) -> None:
    """Import modules and files, and register the strategies in them.

    Parameters
    ----------
    references : sequence of str
        As `multisrt.robots.loading.import_reference` takes them.

    Raises
    ------
    InvalidInputError
        If one cannot be imported.
    """
    for reference in references:
        import_reference(reference)


def named(given: Entrant | Iterable[Entrant]) -> Sequence[str | StrategyChoice]:
    """Return the names of strategies, after registering those that are given as objects.

    Parameters
    ----------
    given : str, StrategyChoice, Strategy, class or function, or several
        The strategies.

    Returns
    -------
    sequence of str or StrategyChoice
        Their names, with options where they are given.

    Raises
    ------
    InvalidInputError
        If two different objects have the same name, or the name of a built-in strategy.
    """
    several = isinstance(given, Iterable) and not isinstance(given, str)
    each: Iterable[Any] = given if several else (given,)  # type: ignore[assignment]
    names: list[str | StrategyChoice] = []
    own: dict[str, Strategy] = {}
    for one in each:
        if isinstance(one, StrategyChoice | Mapping):
            names.append(one)  # type: ignore[arg-type]
            continue
        name = name_of(one)
        made = strategy(name)
        if own.setdefault(name, made) != made:
            raise InvalidInputError(
                f"two strategies are called {name!r}; give one of them another name: "
                "Strategy.of(..., name=...)"
            )
        names.append(name)
    return names


def own_strategies(spec: ExperimentSpec) -> list[Strategy]:
    """Return the strategies of an experiment that are not built in.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.

    Returns
    -------
    list of Strategy
        Those of other packages and of the user, in the experiment's order.

    Raises
    ------
    InvalidInputError
        If one is not known here.
    """
    names = [choice.name for choice in choices_of(spec)]
    return [strategy(name) for name in dict.fromkeys(names) if not is_built_in(name)]


def choices_of(spec: ExperimentSpec) -> list[StrategyChoice]:
    """Return the strategies that an experiment names, those of its blocks included."""
    choices = [*spec.strategies]
    for block in spec.blocks:
        choices += block.strategies or ()
    return [c if isinstance(c, StrategyChoice) else StrategyChoice(name=c) for c in choices]


def worker_references(
    spec: ExperimentSpec, given: Sequence[str] = (), *, by_name: bool = False
) -> tuple[str, ...]:
    """Return what worker processes import so that they know the strategies of an experiment.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.
    given : sequence of str
        What the user names; it is imported first.
    by_name : bool
        Whether workers have no files of this machine, as those of a cluster.

    Returns
    -------
    tuple of str
        References for `import_modules`.

    Raises
    ------
    InvalidInputError
        If a strategy cannot be imported by other processes; the message says what to do.
    """
    found = dict.fromkeys(given if by_name else (_absolute(reference) for reference in given))
    if by_name:
        for reference in given:
            if reference.partition(":")[0].endswith(".py"):
                raise InvalidInputError(
                    f"the workers of a cluster have no {reference}: install its module there, and "
                    "name that instead"
                )
    for own in own_strategies(spec):
        try:
            found[reference_of(own, by_name=by_name)] = None
        except InvalidInputError:
            if not given:  # what is given registers it, perhaps; `Worker` says this if it does not
                raise
    return tuple(found)


def reference_of(own: Strategy, *, by_name: bool = False) -> str:
    """Return a reference by which another process imports a strategy.

    Parameters
    ----------
    own : Strategy
        The strategy.
    by_name : bool
        Whether the reference is to a module, never to a file.

    Returns
    -------
    str
        ``MODULE:NAME``, or ``FILE.py:NAME`` for a module that belongs to no package. Without a
        name, if the module registers the strategy itself.

    Raises
    ------
    InvalidInputError
        If it cannot be imported; the message says why, and what to do.
    """
    module, name = _home_of(own)
    place, path = module.__name__, path_of(module)
    if is_ours(place):
        raise _not_importable(own, "no module has a name for it")
    if place == "__main__":
        started_as = module.__spec__.name if module.__spec__ is not None else ""
        if path is None:
            raise _not_importable(own, "it is defined in a notebook or at the prompt")
        if not _has_main_guard(path):
            raise _not_importable(
                own,
                f"it is defined in {path.name}, the script that is running, which would run again "
                "in each of them",
                "put what the script does under if __name__ == '__main__'",
            )
        place = started_as or str(path)
    elif path is not None and "." not in place and not hasattr(module, "__path__"):
        place = str(path)
    if by_name and place.endswith(".py"):
        stem = Path(place).stem
        if module.__name__ != stem:
            raise InvalidInputError(
                f"the workers of a cluster import strategies by the names of modules, and "
                f"{own.name!r} is in the file {Path(place).name}: install it there as a module"
            )
        place = stem
    return f"{place}:{name}" if name else place


def home_modules(own: Strategy) -> list[ModuleType]:
    """Return the modules that define a strategy: those of its explorer and of its options.

    Parameters
    ----------
    own : Strategy
        The strategy.

    Returns
    -------
    list of module
        Those that are not of this package; the module that has a name for the strategy, if both
        of them are.
    """
    names = dict.fromkeys((own.explorer.__module__, own.options.__module__))
    found = [sys.modules[name] for name in names if name in sys.modules and not is_ours(name)]
    return found or [module for module in _modules() if _bound_in(module, own)][:1]


def _modules() -> list[ModuleType]:
    """Return the imported modules by name, the main program last."""
    main = sys.modules["__main__"]
    known = [module for _, module in sorted(sys.modules.items()) if type(module) is ModuleType]
    return [*(module for module in known if module is not main), main]


def _home_of(own: Strategy) -> tuple[ModuleType, str]:
    """Return the module that another process is to import for a strategy, and its name there."""
    explorer: Any = inspect.unwrap(own.explorer)
    home = sys.modules.get(explorer.__module__)
    if home is None:
        raise _not_importable(own, f"its module {explorer.__module__!r} is not imported")
    *others, main = _modules()
    for module in (home, *others):
        if module is not main and (name := _bound_in(module, own)):
            return module, name
    name = getattr(explorer, "__qualname__", "")
    is_bound: bool = vars(home).get(name) is explorer
    if is_bound:
        made = Strategy.of(explorer)
        if made.options is own.options and own.fits is None:
            return home, name if made.name == own.name else f"{name}={own.name}"
    if bound := _bound_in(main, own):
        return main, bound
    if "<locals>" in name:
        raise _not_importable(
            own,
            f"{name} is defined within a function",
            f"name the module that registers it, or {TO_A_FILE}",
        )
    if home is builtins:  # what `exec` gives to classes of code that has no __name__
        raise _not_importable(own, "it is defined by exec, in no module")
    return home, ""  # the module registers it, perhaps


def _bound_in(module: ModuleType, own: Strategy) -> str:
    """Return the name that a module has for a strategy; empty for modules of this package."""
    if is_ours(module.__name__):
        return ""
    return next((name for name, value in list(vars(module).items()) if value is own), "")


def _has_main_guard(path: Path) -> bool:
    """Whether a script has a part that runs only if it is the main program."""
    for node in ast.parse(path.read_bytes()).body:
        if isinstance(node, ast.If) and isinstance(node.test, ast.Compare):
            words = [node.test.left, *node.test.comparators]
            if any(isinstance(word, ast.Name) and word.id == "__name__" for word in words):
                return True
    return False


def _absolute(reference: str) -> str:
    found = re.fullmatch(r"(?P<file>.*\.py)(?P<name>:.*)?", reference)
    if found is None:
        return reference
    return f"{Path(found['file']).expanduser().resolve()}{found['name'] or ''}"


def _not_importable(own: Strategy, why: str, remedy: str = TO_A_FILE) -> InvalidInputError:
    return InvalidInputError(
        f"the strategy {own.name!r} cannot be imported by worker processes: {why}; {remedy}, or "
        "give workers=0 (--workers 0), which makes the runs in this process, one after another"
    )
