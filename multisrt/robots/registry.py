"""The registry of strategies: from a name to the factory of a robot's explorer.

Other packages add strategies with `register`, or with an entry point in the group
``multisrt.strategies`` that refers to a `Strategy`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING

from multisrt.geometry.errors import InvalidInputError, did_you_mean, shown
from multisrt.robots.strategy import Strategy, as_strategy

if TYPE_CHECKING:
    from multisrt.robots.explorer import Explorer


def register(strategy: Strategy | Callable[..., Explorer], *, replace: bool = False) -> None:
    """Make a strategy available by its name in this process.

    Parameters
    ----------
    strategy : Strategy, type or callable
        The strategy, or an argument of `Strategy.of`: the class of an explorer, or a function that
        builds one.
    replace : bool
        Whether it replaces a strategy registered before under the same name, for example when a
        notebook cell is executed again. Built-in strategies cannot be replaced.

    Raises
    ------
    InvalidInputError
        If there already is another strategy with that name.

    Examples
    --------
    >>> register(strategy("minpos"))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: there is a strategy 'minpos' already, and it ...
    """
    added, known = as_strategy(strategy), _registry()
    if is_built_in(added.name):
        raise InvalidInputError(
            f"there is a strategy {added.name!r} already, and it is built in; choose another "
            "name, as by Strategy.of(..., name=...)"
        )
    if known.get(added.name, added) != added and not replace:
        raise InvalidInputError(
            f"there is another strategy {added.name!r} already; to replace it, as when a cell runs "
            "again, give register(..., replace=True)"
        )
    known[added.name] = added


def is_built_in(name: str) -> bool:
    """Whether a name is that of a strategy of this package.

    Parameters
    ----------
    name : str
        The name.

    Returns
    -------
    bool
        False for strategies of other packages and for registered ones.

    Examples
    --------
    >>> is_built_in("minpos"), is_built_in("mine")
    (True, False)
    """
    return any(name == own.name for own in _built_in())


def is_known(name: str) -> bool:
    """Whether there is a strategy with a name, built in or not.

    Parameters
    ----------
    name : str
        The name.

    Returns
    -------
    bool
        Whether `strategy` finds it.

    Examples
    --------
    >>> is_known("minpos"), is_known("nowhere-nearest")
    (True, False)
    """
    return name in _registry()


@contextmanager
def registered(strategy: Strategy) -> Iterator[None]:
    """Register a strategy within a ``with`` block, replacing one with the same name.

    Parameters
    ----------
    strategy : Strategy
        The strategy.
    """
    known = _registry()
    before = known.get(strategy.name)
    known[strategy.name] = strategy
    try:
        yield
    finally:
        if before is not None:
            known[strategy.name] = before  # in its old place: `strategies` keeps its order
        else:
            del known[strategy.name]


def strategies() -> tuple[Strategy, ...]:
    """Return all strategies: first those of this package, then all others.

    Returns
    -------
    tuple of Strategy
        The strategies that can be loaded; see `broken_strategies` for the others.

    Examples
    --------
    >>> "srt-radial" in {strategy.name for strategy in strategies()}
    True
    """
    return tuple(_registry().values())


def strategy(name: str) -> Strategy:
    """Return the strategy with a name.

    Parameters
    ----------
    name : str
        Its name.

    Returns
    -------
    Strategy
        The strategy.

    Raises
    ------
    InvalidInputError
        If there is none; the message lists all names.

    Examples
    --------
    >>> strategy("minpos").summary
    'Each robot goes to the frontier to which the fewest others are nearer'
    """
    registered = _registry()
    if name not in registered:
        broken = broken_strategies()
        if name in broken:
            raise InvalidInputError(
                f"the strategy {name!r} of another package could not be loaded "
                f"({broken[name]}); fix or uninstall that package"
            )
        raise InvalidInputError(
            f"there is no strategy {shown(name)}{did_you_mean(name, registered)}; "
            f"there are: {', '.join(registered)}; one of your own is imported by --import FILE.py "
            "on the command line, or registered by multisrt.register"
        )
    return registered[name]


def broken_strategies() -> Mapping[str, str]:
    """Return the errors of entry points that could not be loaded, by name.

    Returns
    -------
    mapping of str to str
        The error of each such entry point, by its name.

    Examples
    --------
    >>> "srt-radial" in broken_strategies()
    False
    """
    return _from_entry_points()[1]


@cache
def _registry() -> dict[str, Strategy]:
    found = {s.name: s for s in _built_in()}
    for entry, loaded in _from_entry_points()[0].items():
        if loaded.name in found:
            raise InvalidInputError(
                f"entry point {entry!r} gives a second strategy {loaded.name!r}"
            )
        found[loaded.name] = loaded
    return found


def _from_entry_points() -> tuple[dict[str, Strategy], dict[str, str]]:
    # A broken package does not take away the strategies of the others.
    loaded: dict[str, Strategy] = {}
    broken: dict[str, str] = {}
    for entry in sorted(entry_points(group="multisrt.strategies"), key=lambda e: e.name):
        try:
            given = entry.load()
        except Exception as error:  # whatever another package's code raises
            broken[entry.name] = f"{type(error).__name__}: {error}"
            continue
        if isinstance(given, Strategy):
            loaded[entry.name] = given
        else:
            broken[entry.name] = f"it gives a {type(given).__name__}, not a Strategy"
    return loaded, broken


def _built_in() -> tuple[Strategy, ...]:
    from multisrt.robots.built_in import BUILT_IN

    return (*BUILT_IN, _INFORMED.load())


_INFORMED = EntryPoint("informed", "multisrt.informed.registration:INFORMED", "multisrt.strategies")
"""The strategy that sees the truth. It is loaded by its name, as those of other packages are: what
runs on robots imports nothing of it."""
