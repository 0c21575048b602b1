"""The spec of a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, Literal, cast

import msgspec

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import builtin
from multisrt.spec.base import BaseSpec
from multisrt.spec.environments import EnvironmentSpec
from multisrt.spec.faults import Death, Fault, LateStart
from multisrt.spec.numbering import numbers_of
from multisrt.spec.part import Part, Scalar
from multisrt.spec.radio import RadioSpec
from multisrt.spec.robots import RobotSpec
from multisrt.validation_errors import UNREADABLE, explained

PlacedHow = Literal["scattered", "clustered", "random", "suggested", "base"]
"""How a team is placed: far apart, close together, at random, where the map suggests, or around the
base station."""


class StopRule(Part, frozen=True, kw_only=True):
    """Limits at which a run ends although its robots would continue.

    Attributes
    ----------
    max_time_s : float
        The maximum duration of the run, in simulated seconds.
    max_idle_s : float
        The maximum time without progress, in simulated seconds: no robot moves, scans at a new
        place, adds a node or learns one. The run then ends as `stalled`, because its robots wait
        for each other repeatedly. The run does not end before pending late starts and faults, and
        before the end of single waits that are longer.

    Raises
    ------
    InvalidInputError
        If a time is not positive and finite.

    Examples
    --------
    >>> import multisrt as ms
    >>> world, stop = ms.CatalogEnvironment(name="open"), ms.StopRule(max_time_s=10.0)
    >>> run = ms.explore(ms.RunSpec(environment=world, stop=stop, seed=1))
    >>> run.outcome, run.recording.footer.time_s
    ('out_of_time', 10.0)
    """

    max_time_s: float = 86_400.0
    max_idle_s: float = 3_600.0

    def __post_init__(self) -> None:
        for name in ("max_time_s", "max_idle_s"):
            if not 0.0 < (time_s := getattr(self, name)) < math.inf:
                raise InvalidInputError(f"{name} is a positive time, not {time_s:g} s")


class RunSpec(Part, frozen=True, kw_only=True):
    """Everything that a run depends on.

    Attributes
    ----------
    environment : CatalogEnvironment, SuiteEnvironment, FileEnvironment or InlineEnvironment
        The world.
    strategy : str
        Name of a registered strategy; `multisrt.strategies` lists them.
    options : dict
        Options of the strategy that differ from its defaults.
    robots : tuple of RobotSpec
        The team.
    starts : {"scattered", "clustered", "random", "suggested", "base"}
        How robots without a `start` are placed: far apart, close together, each at a random place,
        at the suggested starts of the environment, or around the base station. A single robot
        starts at a suggested start if there is one, otherwise at a random place; with "base", at
        the base station.
    radio : RadioSpec
        The radio.
    base : BaseSpec or None
        The base station, if any.
    faults : tuple of Death, Silence or LateStart
        The faults.
    stop : StopRule
        Limits at which the run ends although its robots would continue.
    seed : int
        Seed of all random streams of the run, 0 or positive.

    Raises
    ------
    InvalidInputError
        If the team is empty, the seed is negative, or a fault does not fit the team and the run.

    Examples
    --------
    >>> import multisrt as ms
    >>> spec = ms.RunSpec(environment=ms.CatalogEnvironment(name="rooms"), seed=7)
    >>> ms.RunSpec.from_toml(spec.to_toml()) == spec
    True
    """

    environment: EnvironmentSpec
    strategy: str = "srt-radial"
    options: dict[str, Scalar] = {}
    robots: tuple[RobotSpec, ...] = (RobotSpec(),)
    starts: PlacedHow = "scattered"
    radio: RadioSpec = RadioSpec()
    base: BaseSpec | None = None
    faults: tuple[Fault, ...] = ()
    stop: StopRule = StopRule()
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.robots:
            raise InvalidInputError("a team has at least one robot")
        if self.seed < 0:
            raise InvalidInputError(f"a seed is 0 or a positive whole number, not {self.seed}")
        if self.starts == "base" and self.base is None:
            raise InvalidInputError("starts='base' needs a base station: give base (--base X,Y)")
        self._check_faults()

    def _check_faults(self) -> None:
        for number, fault in enumerate(self.faults):
            name = str(fault.__struct_config__.tag).replace("_", " ")
            what = f"fault {number + 1} ({name} of robot {fault.robot})"
            if not 0 <= fault.robot < len(self.robots):
                raise InvalidInputError(
                    f"{what}: there is no such robot; {numbers_of(len(self.robots))}"
                )
            if not 0.0 <= fault.time_s < self.stop.max_time_s:
                raise InvalidInputError(
                    f"{what}: at {fault.time_s:g} s, which is not within the run; it ends at "
                    f"{self.stop.max_time_s:g} s (stop.max_time_s)"
                )
        for name, kind in (("late_start", LateStart), ("death", Death)):
            robots = [fault.robot for fault in self.faults if isinstance(fault, kind)]
            for robot in sorted(set(robots)):
                if robots.count(robot) > 1:
                    raise InvalidInputError(f"robot {robot} has more than one fault {name}")

    def canonical(self) -> RunSpec:
        """Return an equal spec in canonical form: equal specs have the same text.

        Returns
        -------
        RunSpec
            The spec; fields equal to their defaults are omitted from its text, and numbers of numpy
            are converted to builtin ones.

        Raises
        ------
        InvalidInputError
            If a field has a value of the wrong type; the message names it.

        Examples
        --------
        >>> from multisrt.spec import CatalogEnvironment
        >>> world = CatalogEnvironment(name="rooms")
        >>> same = RunSpec(environment=world, stop=StopRule(max_time_s=86400))
        >>> same.canonical().to_json() == RunSpec(environment=world).canonical().to_json()
        True
        """
        return cast(RunSpec, _less_defaults(RunSpec.from_json(_written(self, msgspec.json.encode))))

    def to_json(self) -> str:
        """Return the spec as indented JSON.

        Returns
        -------
        str
            The text; fields left at their defaults are omitted.

        Examples
        --------
        >>> import multisrt as ms
        >>> spec = ms.RunSpec(environment=ms.CatalogEnvironment(name="open"), seed=7)
        >>> print(spec.to_json())
        {
          "environment": {
            "from": "catalog",
            "name": "open"
          },
          "seed": 7
        }
        """
        text: bytes = msgspec.json.format(_written(self, msgspec.json.encode), indent=2)
        return text.decode()

    def to_toml(self) -> str:
        """Return the spec as TOML.

        Returns
        -------
        str
            The text; fields left at their defaults are omitted.

        Examples
        --------
        >>> import multisrt as ms
        >>> spec = ms.RunSpec(environment=ms.CatalogEnvironment(name="open"), seed=7)
        >>> print(spec.to_toml())
        seed = 7
        <BLANKLINE>
        [environment]
        from = "catalog"
        name = "open"
        <BLANKLINE>
        """
        text: bytes = _written(self, msgspec.toml.encode)
        return text.decode()

    def to_dict(self) -> dict[str, Any]:
        """Return the spec as dictionaries, lists and scalars.

        Returns
        -------
        dict
            The fields by name; those left at their defaults are omitted.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.RunSpec(environment=ms.CatalogEnvironment(name="open"), seed=7).to_dict()
        {'environment': {'from': 'catalog', 'name': 'open'}, 'seed': 7}
        """
        return cast(dict[str, Any], _written(self, msgspec.to_builtins))

    @classmethod
    def from_json(cls, text: str | bytes) -> RunSpec:
        """Read a spec from JSON.

        Parameters
        ----------
        text : str or bytes
            The text, in UTF-8 if it is given as bytes.

        Returns
        -------
        RunSpec
            The spec.

        Raises
        ------
        InvalidInputError
            If the text is not JSON, or a field is unknown or invalid; the message names it.

        Examples
        --------
        >>> text = '{"environment": {"from": "catalog", "name": "open"}, "seed": 7}'
        >>> RunSpec.from_json(text).environment
        CatalogEnvironment(name='open', parameters={}, seed=None)
        """
        try:
            return msgspec.json.decode(text, type=cls)
        except UNREADABLE as error:
            raise InvalidInputError(f"not a run spec: {explained(error, cls)}") from None

    @classmethod
    def from_toml(cls, text: str) -> RunSpec:
        """Read a spec from TOML.

        Parameters
        ----------
        text : str
            The text.

        Returns
        -------
        RunSpec
            The spec.

        Raises
        ------
        InvalidInputError
            If the text is not TOML, or a field is unknown or invalid; the message names it.

        Examples
        --------
        >>> text = 'environment = { from = "catalog", name = "open" }'
        >>> RunSpec.from_toml(text).strategy
        'srt-radial'
        >>> RunSpec.from_toml("sed = 7")
        Traceback (most recent call last):
        ...
        multisrt.geometry.errors.InvalidInputError: not a run spec: there is no field 'sed'...
        """
        try:
            return msgspec.toml.decode(text, type=cls)
        except UNREADABLE as error:
            raise InvalidInputError(f"not a run spec: {explained(error, cls)}") from None


def _written(spec: RunSpec, write: Callable[..., Any]) -> Any:
    # Written by msgspec, with numbers of numpy as builtin ones.
    try:
        return write(spec, enc_hook=builtin)
    except TypeError as error:
        raise InvalidInputError(
            f"a run spec holds text, numbers and its parts: {error}; convert numbers by float(x) "
            "or int(x)"
        ) from None


def _less_defaults(part: Any) -> Any:
    # Encoding omits a field only if it is the default object itself: equal values become that.
    if isinstance(part, tuple):
        return tuple(map(_less_defaults, part))
    if not isinstance(part, Part):
        return part
    defaults = _defaults(type(part))
    given = {name: getattr(part, name) for name in defaults}
    return type(part)(
        **{name: _less_defaults(v) for name, v in given.items() if v != defaults[name]}
    )


@cache
def _defaults(kind: type[Part]) -> dict[str, Any]:
    return {field.name: field.default for field in msgspec.structs.fields(kind)}
