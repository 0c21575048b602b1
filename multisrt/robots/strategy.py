"""A strategy: a named factory of explorers, with its options."""

from __future__ import annotations

import inspect
import re
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, wraps
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import msgspec

from multisrt.geometry.errors import InvalidInputError, did_you_mean, shown
from multisrt.robots.frontier.pursuit_options import require_pursuit
from multisrt.robots.homing.options import require_home
from multisrt.robots.strategy_fields import require_fields
from multisrt.validation_errors import allowed_words, explained

if TYPE_CHECKING:
    from multisrt.geometry.configuration import Configuration
    from multisrt.robots.explorer import Explorer, RobotSelf
    from multisrt.spec import RunSpec

    Plan = Callable[
        [RunSpec, Any, Sequence[Configuration], Callable[[float], None] | None], Sequence[object]
    ]
    """Plans a run on the true map; its second parameter is the environment, which robots do not
    know."""


MAX_OPTIONS = 8
"""Maximum number of options named in the message about an unknown one."""


class NoOptions(msgspec.Struct, frozen=True, kw_only=True):
    """The options of a strategy that has none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Strategy:
    """An exploration strategy: a named factory of explorers.

    See `multisrt.robots.explorer` for a complete example.

    Attributes
    ----------
    name : str
        Its name in specs and on the command line: lower-case letters, digits and hyphens.
    summary : str
        One line for lists.
    options : type
        A frozen msgspec structure: the parameters of the strategy and their defaults.
    explorer : callable
        Builds the `Explorer` of one robot from its `RobotSelf` and the options.
    fits : callable or None
        Takes a `RunSpec`, and raises `InvalidInputError` if the strategy cannot execute it.
    plan : callable or None
        For a strategy that knows the true map: takes the `RunSpec`, the environment, the starts and
        a callable that receives its progress or None; returns the `RobotSelf.orders` of each robot.
        None: robots know only what they sense and receive.

    Raises
    ------
    InvalidInputError
        If a field is invalid; the message names it and states what to give.

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

    def __post_init__(self) -> None:
        require_fields(
            self.name, self.summary, self.options, self.explorer, fits=self.fits, plan=self.plan
        )

    @classmethod
    def of(
        cls,
        explorer: Callable[..., Explorer],
        *,
        name: str | None = None,
        summary: str | None = None,
        options: type[msgspec.Struct] | None = None,
    ) -> Strategy:
        """Return a strategy made from the class of an explorer.

        Parameters
        ----------
        explorer : type or callable
            The class of the explorer, or a function that builds one. It takes the robot's
            `RobotSelf` and the options, or only the former if there are no options.
        name : str, optional
            Name of the strategy; by default the name of the class with hyphens:
            ``NearestFrontier`` becomes ``nearest-frontier``.
        summary : str, optional
            One line for lists; by default the first line of the docstring.
        options : type, optional
            The structure of options; by default the annotation of the second parameter, otherwise
            the attribute `Options` of the class, otherwise there are no options.

        Returns
        -------
        Strategy
            The strategy; `register` makes it available by name.

        Raises
        ------
        InvalidInputError
            If `explorer` is not a class or function, does not take these arguments, or its
            annotation cannot be resolved.

        Examples
        --------
        >>> from multisrt.robots.explorer import Done
        >>> class StaysAtHome:
        ...     '''Does nothing.'''
        ...
        ...     def __init__(self, me):
        ...         self.me = me
        ...
        ...     def run(self):
        ...         yield Done(complete=False, reason=f"has stayed at {self.me.start[:2]}")
        >>> stays = Strategy.of(StaysAtHome)
        >>> stays.name, stays.summary
        ('stays-at-home', 'Does nothing')
        """
        is_maker = inspect.isclass(explorer) or inspect.isroutine(explorer)
        if not is_maker:
            made = type(explorer).__name__
            is_built = hasattr(explorer, "run")
            raise InvalidInputError(
                "a strategy is made of the class of an explorer, or of a function that builds one: "
                f"give {made}, not one that is built already; each robot of a run gets its own"
                if is_built
                else "a strategy is made of the class of an explorer, or of a function that builds "
                f"one, not of {explorer!r}"
                + ("; write def my_rule(me, options): return ..." if callable(explorer) else "")
            )
        if name is None and explorer.__name__ == "<lambda>":
            raise InvalidInputError(
                "a strategy is called as its class or function, and a lambda has no name: give "
                "name=, as in Strategy.of(..., name='my-rule')"
            )
        parameters = _positional(explorer)
        alone = len(parameters) == 1
        if options is None:
            options = NoOptions if alone else _options_of(explorer, parameters[1])
        if summary is None:
            first_line = (explorer.__doc__ or "").strip().partition("\n")[0].rstrip(". ")
            summary = first_line or f"{explorer.__name__} of {explorer.__module__}"
        return cls(
            name=kebab_case(explorer.__name__) if name is None else name,
            summary=summary,
            options=options,
            explorer=_without_options(explorer) if alone else explorer,
        )

    @property
    def sees_truth(self) -> bool:
        """Whether its robots know the true map; it then serves as a reference only."""
        return self.plan is not None

    def require_fit(self, spec: RunSpec) -> None:
        """Check that this strategy can execute a run.

        Parameters
        ----------
        spec : RunSpec
            The run.

        Raises
        ------
        InvalidInputError
            If it cannot; the message states the reason.

        Examples
        --------
        >>> import multisrt as ms
        >>> from multisrt.robots.registry import strategy
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
        require_home(spec, self.options, spec.options)
        require_pursuit(spec, self.options, spec.options)
        if self.fits is not None:
            self.fits(spec)

    def parse_options(self, options: Mapping[str, object]) -> msgspec.Struct:
        """Check the values of options, and fill in the defaults.

        Parameters
        ----------
        options : mapping of str to object
            Values by name; they may be given as text.

        Returns
        -------
        msgspec.Struct
            An instance of the strategy's `options`.

        Raises
        ------
        InvalidInputError
            If an option is unknown or its value is not allowed; the message names it.

        Examples
        --------
        >>> from multisrt.robots.registry import strategy
        >>> strategy("srt-star").parse_options({"cones": "8"}).cones
        8
        >>> strategy("srt-star").parse_options({"cone": 8})  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ...
        multisrt.geometry.errors.InvalidInputError: srt-star has no option 'cone' ...
        """
        known = {field.name: field for field in fields_own_first(self.options)}
        for key in options:
            if key not in known:
                raise InvalidInputError(
                    f"{self.name} has no option {shown(key)}{did_you_mean(key, known)}; "
                    f"{self._options_there(list(known))}"
                )
        values = {key: _none_read(value, known[key].type) for key, value in options.items()}
        for key, value in values.items():
            try:
                msgspec.convert(value, known[key].type, strict=False)
            except msgspec.ValidationError as error:
                wrong = explained(error, known[key].type)
                meant = did_you_mean(value, allowed_words(known[key].type))
                raise InvalidInputError(
                    f"option {key}={shown(value)} of {self.name}: {wrong}{meant}"
                ) from None
        try:
            return msgspec.convert(values, self.options, strict=False)
        except msgspec.ValidationError as error:
            wrong = explained(error, self.options)
            raise InvalidInputError(f"options of {self.name}: {wrong}") from None

    def _options_there(self, known: list[str]) -> str:
        if len(known) <= MAX_OPTIONS:
            return f"it has: {', '.join(known) or 'none'}"
        return (
            f"it has {len(known)}, such as {', '.join(known[:MAX_OPTIONS])}; 'multisrt strategies "
            f"{self.name}' lists them"
        )


def fields_own_first(options: type[msgspec.Struct]) -> list[msgspec.structs.FieldInfo]:
    """Return the fields of a class of options: its own, new or changed, before inherited ones.

    Examples
    --------
    >>> from multisrt.robots.frontier.options import GainOptions
    >>> [field.name for field in fields_own_first(GainOptions)][:2]
    ['power', 'return_area_m2']
    """
    depths: dict[str, int] = {}
    for depth, kind in enumerate(reversed(options.__mro__)):
        depths |= dict.fromkeys(inspect.get_annotations(kind), depth)
    return sorted(msgspec.structs.fields(options), key=lambda field: -depths[field.name])


def _none_read(value: object, kind: Any) -> object:
    # None as `multisrt strategies NAME` writes it; msgspec reads "null" only.
    is_none = isinstance(value, str) and value.lower() == "none" and "none" in allowed_words(kind)
    return None if is_none else value


def as_strategy(given: Strategy | Callable[..., Explorer]) -> Strategy:
    """Return the strategy that is given as such, as the class of an explorer or as a function.

    Parameters
    ----------
    given : Strategy, type or callable
        The strategy, or an argument of `Strategy.of`.

    Returns
    -------
    Strategy
        The strategy.

    Raises
    ------
    InvalidInputError
        If it is none of these.

    Examples
    --------
    >>> import multisrt as ms
    >>> as_strategy(ms.strategies()[0]).name
    'srt-ball'
    """
    return given if isinstance(given, Strategy) else Strategy.of(given)


def kebab_case(name: str) -> str:
    """Return the name of a class or function in lower case, with words joined by hyphens.

    Parameters
    ----------
    name : str
        The name, such as ``NearestFrontier`` or ``nearest_frontier``.

    Returns
    -------
    str
        The name of a strategy.

    Examples
    --------
    >>> kebab_case("NearestFrontier"), kebab_case("SRTWalker2"), kebab_case("my_rule")
    ('nearest-frontier', 'srt-walker2', 'my-rule')
    """
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "-", name)
    return re.sub(r"[_-]+", "-", words).strip("-").lower()


def _positional(explorer: Callable[..., Explorer]) -> list[inspect.Parameter]:
    """Return the parameters for the robot and, if there is one, for the options."""
    try:
        parameters = list(inspect.signature(explorer).parameters.values())
    except (TypeError, ValueError):  # built in, without a signature
        parameters = []
    taken = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    if any(p.kind is p.VAR_POSITIONAL for p in parameters):
        taken += [inspect.Parameter(n, inspect.Parameter.POSITIONAL_ONLY) for n in ("me", "o")]
        taken = taken[:2]
    needed = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY and p.default is p.empty]
    needed += [p.name for p in taken[2:] if p.default is p.empty]
    if not taken or needed:
        takes = f"it needs {', '.join(needed)}, too" if needed else "it takes no argument"
        raise InvalidInputError(
            f"{_title(explorer)} must take the robot (a RobotSelf) and the options, and nothing "
            f"else: {takes}; write 'def __init__(self, me, options)'"
        )
    return taken[:2]


def _options_of(explorer: Any, parameter: inspect.Parameter) -> type[msgspec.Struct]:
    annotation = parameter.annotation
    if isinstance(annotation, str):
        made_by = inspect.unwrap(explorer.__init__ if inspect.isclass(explorer) else explorer)
        # Other annotations may name what is imported for type checkers alone.
        only = SimpleNamespace(__annotations__={"options": annotation})
        own = vars(explorer) if inspect.isclass(explorer) else {}
        try:
            annotation = typing.get_type_hints(only, made_by.__globals__, dict(own))["options"]
        except Exception as error:  # an annotation may be any expression
            if not hasattr(explorer, "Options"):
                raise InvalidInputError(
                    f"the annotation {parameter.annotation!r} of {parameter.name!r}, the options "
                    f"of {_title(explorer)}, cannot be resolved ({error}); define it in the "
                    "module, or give Strategy.of(..., options=...)"
                ) from None
            annotation = parameter.empty
    if annotation in (parameter.empty, Any, object):
        annotation = getattr(explorer, "Options", NoOptions)
    found: type[msgspec.Struct] = annotation
    return found


@cache  # so that strategies of one class are equal
def _without_options(explorer: Callable[..., Explorer]) -> Callable[[RobotSelf, Any], Explorer]:
    @wraps(explorer, updated=())
    def built(me: RobotSelf, options: NoOptions) -> Explorer:
        return explorer(me)

    return built


def _title(explorer: Any) -> str:
    return f"{explorer.__module__}.{explorer.__qualname__}"
