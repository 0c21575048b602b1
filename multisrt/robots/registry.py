"""The registry of strategies: from a name to the factory of a robot's explorer.

Other packages add their own by an entry point in the group ``multisrt.strategies`` that names a
`Strategy`, or by `register`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any

import msgspec

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.validation_errors import allowed_words, explained

if TYPE_CHECKING:
    from multisrt.geometry.configuration import Configuration
    from multisrt.robots.explorer import Explorer, RobotSelf
    from multisrt.spec import RunSpec

    Plan = Callable[
        [RunSpec, Any, Sequence[Configuration], Callable[[float], None] | None], Sequence[object]
    ]
    """Plans a run on the truth; its second parameter is the environment, which robots do not
    know."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Strategy:
    """A strategy of exploration: a named factory of explorers.

    See `multisrt.robots.explorer` for a complete example.

    Attributes
    ----------
    name : str
        Its name in specs and on the command line.
    summary : str
        One line for lists.
    options : type
        A frozen msgspec structure: the parameters of the strategy and their defaults.
    explorer : callable
        Builds the `Explorer` of one robot from its `RobotSelf` and the options.
    fits : callable or None
        Takes a `RunSpec`, and raises `InvalidInputError` if the strategy cannot make that run.
    plan : callable or None
        For a strategy that sees the truth: takes the `RunSpec`, the environment, the starts and
        a callable that is told of its progress or None; returns for each robot what its
        `RobotSelf.orders` are to be. None: robots know what they sense and hear.

    Examples
    --------
    >>> from multisrt.robots.explorer import Done
    >>> class Options(msgspec.Struct, frozen=True, kw_only=True):
    ...     pass
    >>> class Stays:
    ...     def __init__(self, me, options):
    ...         self.me = me
    ...
    ...     def run(self):
    ...         yield Done(complete=False, reason=f"has stayed at {self.me.start[:2]}")
    >>> stays = Strategy(name="stays", summary="Does nothing", options=Options, explorer=Stays)
    >>> stays.parse_options({})
    Options()
    """

    name: str
    summary: str
    options: type[msgspec.Struct]
    explorer: Callable[[RobotSelf, Any], Explorer]
    fits: Callable[[RunSpec], None] | None = None
    plan: Plan | None = None

    @property
    def sees_truth(self) -> bool:
        """Whether its robots know the map: it is a reference then, and no competitor."""
        return self.plan is not None

    def require_fit(self, spec: RunSpec) -> None:
        """Check that this strategy can make a run.

        Parameters
        ----------
        spec : RunSpec
            The run.

        Raises
        ------
        InvalidInputError
            If it cannot; the message says why.

        Examples
        --------
        >>> import multisrt as ms
        >>> spec = ms.RunSpec(
        ...     environment=ms.CatalogEnvironment(name="open"),
        ...     robots=(ms.RobotSpec(), ms.RobotSpec()),
        ...     radio=ms.RadioSpec(range_m=5.0),
        ... )
        >>> strategy("srt-radial").require_fit(spec)  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ...
        multisrt.geometry.errors.InvalidInputError: srt-radial needs a radio range of at least ...
        """
        if self.fits is not None:
            self.fits(spec)

    def parse_options(self, options: Mapping[str, object]) -> msgspec.Struct:
        """Check values for the strategy's parameters, and fill in the defaults.

        Parameters
        ----------
        options : mapping of str to object
            Values by the name of the parameter; they may be written as text.

        Returns
        -------
        msgspec.Struct
            An instance of the strategy's `options`.

        Raises
        ------
        InvalidInputError
            If a parameter is unknown or its value is not allowed; the message names it.

        Examples
        --------
        >>> strategy("srt-star").parse_options({"cones": "8"}).cones
        8
        >>> strategy("srt-star").parse_options({"cone": 8})  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ...
        multisrt.geometry.errors.InvalidInputError: srt-star has no option 'cone' ...
        """
        known = {field.name: field for field in msgspec.structs.fields(self.options)}
        for key in options:
            if key not in known:
                raise InvalidInputError(
                    f"{self.name} has no option {key!r}{did_you_mean(key, known)}; "
                    f"it has: {', '.join(known)}"
                )
        values = {key: _none_read(value, known[key].type) for key, value in options.items()}
        for key, value in values.items():
            try:
                msgspec.convert(value, known[key].type, strict=False)
            except msgspec.ValidationError as error:
                wrong = explained(error, known[key].type)
                meant = did_you_mean(value, allowed_words(known[key].type))
                raise InvalidInputError(
                    f"option {key}={value!r} of {self.name}: {wrong}{meant}"
                ) from None
        try:
            return msgspec.convert(values, self.options, strict=False)
        except msgspec.ValidationError as error:
            wrong = explained(error, self.options)
            raise InvalidInputError(f"options of {self.name}: {wrong}") from None


def _none_read(value: object, kind: Any) -> object:
    # None as `multisrt strategies NAME` writes it; msgspec reads "null" only.
    is_none = isinstance(value, str) and value.lower() == "none" and "none" in allowed_words(kind)
    return None if is_none else value


def register(strategy: Strategy) -> None:
    """Add a strategy for this process.

    Parameters
    ----------
    strategy : Strategy
        The strategy.

    Raises
    ------
    InvalidInputError
        If there is a strategy of that name already.

    Examples
    --------
    >>> register(strategy("minpos"))
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: there is a strategy 'minpos' already
    """
    registered = _registry()
    if strategy.name in registered:
        raise InvalidInputError(f"there is a strategy {strategy.name!r} already")
    registered[strategy.name] = strategy


@contextmanager
def registered(strategy: Strategy) -> Iterator[None]:
    """Register a strategy within a ``with`` block, in place of one that has its name.

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
        del known[strategy.name]
        if before is not None:
            known[strategy.name] = before


def strategies() -> tuple[Strategy, ...]:
    """Return all strategies: those of this package first, then those of others.

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
    """Return the strategy of a name.

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
        If there is none; the message lists all.

    Examples
    --------
    >>> strategy("minpos").summary
    'To the frontier where fewest are nearer'
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
            f"there is no strategy {name!r}{did_you_mean(name, registered)}; "
            f"there are: {', '.join(registered)}"
        )
    return registered[name]


def broken_strategies() -> Mapping[str, str]:
    """Return why entry points of other packages could not be loaded, by name.

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
    from multisrt.robots.built_in import BUILT_IN

    found = {s.name: s for s in (*BUILT_IN, _INFORMED.load())}
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


_INFORMED = EntryPoint("informed", "multisrt.informed.registration:INFORMED", "multisrt.strategies")
"""The strategy that sees the truth. It is loaded by its name, as those of other packages are: what
runs on robots imports nothing of it."""
