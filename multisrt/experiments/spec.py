"""The description of an experiment: what is crossed, and how often it is repeated.

The design is paired: repetition k has the same seed for all strategies, so that they meet the same
world, starts, faults and draws of the radio.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from multisrt.analysis.metrics import SUCCESS_COVERAGE
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import (
    BaseSpec,
    DriveSpec,
    Fault,
    PlacedHow,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    Scalar,
    StopRule,
)
from multisrt.validation_errors import UNREADABLE, explained

MAX_FILE_LENGTH = 16_000_000
"""Maximum length of an experiment file, in characters."""

FOOTPRINT = RobotSpec().footprint
"""Default footprint of all bodies."""

Count = Annotated[int, Meta(ge=1, le=1_000_000)]
Seed = Annotated[int, Meta(ge=0)]
PRINTABLE = r"^[^\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]*$"
"""Text without characters that end a line or that a terminal obeys."""

Label = Annotated[str, Meta(min_length=1, max_length=80, pattern=PRINTABLE)]
NameOrPath = Annotated[str, Meta(min_length=1, max_length=4096)]


class _Part(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A part of an experiment: immutable, keyword-only, without unknown fields."""


class EnvironmentChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """An environment, or one for each of several seeds or of the worlds of a suite.

    Attributes
    ----------
    name : str
        Name in the catalogue, of a suite ("indoor-30") or of one of its worlds ("indoor-30/07"), or
        a map file; paths are relative to the experiment's file.
    label : str or None
        Label in tables; None: the name, of a file without folder and suffix.
    parameters : dict
        Parameters of a generator that differ from its defaults.
    seed : int, "repetition" or None
        Seed of a generator; "repetition" uses the seed of each repetition, so that every
        repetition has another world.
    seeds : str or tuple of int
        Several seeds of a generator, such as "0-9", each of which is a separate condition.
    resolution_m : float or None
        Metres per pixel of an image without its own resolution.
    threshold : float or None
        Lightness in [0, 1] above which a pixel of a plain image is free.
    starts_from : str or None
        A team file of MRESim that gives a plain image its suggested starts; the path is relative
        to the experiment's file.
    wkt : str or None
        Free space as well-known text (m), instead of an environment of this name.
    starts : tuple of (x, y)
        Suggested starts (m) of an environment given as text.
    """

    name: NameOrPath
    label: Label | None = None
    parameters: dict[str, Scalar] = {}
    seed: Seed | Literal["repetition"] | None = None
    seeds: str | tuple[Seed, ...] = ()
    resolution_m: float | None = None
    threshold: float | None = None
    starts_from: NameOrPath | None = None
    wkt: str | None = None
    starts: tuple[tuple[float, float], ...] = ()


class StrategyChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A strategy with options.

    Attributes
    ----------
    name : str
        Name of a registered strategy.
    label : str or None
        Label in tables; None: the name, and the options, if the experiment has others of that name.
    options : dict
        Options that differ from the strategy's defaults.

    Examples
    --------
    >>> choice = StrategyChoice(name="minpos", options={"home": "in-time"})
    >>> choice.shown, choice.told_apart
    ('minpos', 'minpos (home=in-time)')
    """

    name: Label
    label: Label | None = None
    options: dict[str, Scalar] = {}

    @property
    def shown(self) -> str:
        """What it is called in tables."""
        return self.label or self.name

    @property
    def told_apart(self) -> str:
        """What it is called beside others of its name with other options."""
        if self.label is not None or not self.options:
            return self.shown
        given = ", ".join(f"{name}={value}" for name, value in self.options.items())
        return f"{self.name} ({given})"


class MemberChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A robot of a team whose robots differ.

    Attributes
    ----------
    start : (x, y) or (x, y, heading) or None
        Start configuration (m, rad); None: as the experiment's `starts` say.
    footprint : str
        Body, in the notation of `Footprint.parse`.
    drive : DriveSpec or None
        Kinematics and speed; None: the experiment's `drive`.
    range_finder : RangeFinderSpec or None
        Range finder; None: the experiment's `range_finder`.
    """

    start: tuple[float, ...] | None = None
    footprint: str = FOOTPRINT
    drive: DriveSpec | None = None
    range_finder: RangeFinderSpec | None = None


class TeamChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A team whose robots differ.

    Attributes
    ----------
    label : str
        Label in tables.
    members : tuple of MemberChoice
        The robots; the experiment's `bodies` do not apply to them.
    """

    label: Label
    members: Annotated[tuple[MemberChoice, ...], Meta(min_length=1, max_length=1000)]


class StartsChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """The starts of teams.

    Attributes
    ----------
    how : {"scattered", "clustered", "random", "suggested", "base"}
        Whether starts are drawn far apart, close together, or uniformly where bodies have room, or
        are those that the environment suggests, or lie around the base station.
    first : {"any", "drawn"}
        "drawn": the first robot's start and heading are drawn uniformly in each repetition, and
        the others placed as `how` says. "any": as in a single run, where a robot alone
        starts where the environment suggests.
    places : tuple of (x, y) or (x, y, heading)
        Start configurations (m, rad) instead, at least as many as the team has robots.
    label : str or None
        Label in tables; None: made from the fields above.
    """

    how: PlacedHow = "scattered"
    first: Literal["any", "drawn"] = "any"
    places: tuple[tuple[float, ...], ...] = ()
    label: Label | None = None


class RadioChoice(RadioSpec, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A radio with a label.

    Attributes
    ----------
    label : str or None
        Label in tables; None: the range.
    """

    label: Label | None = None


class BodyChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A body: footprint, drive and range finder.

    Attributes
    ----------
    footprint : str
        Body, in the notation of `Footprint.parse`.
    drive : DriveSpec or None
        Kinematics and speed; None: the experiment's `drive`.
    range_finder : RangeFinderSpec or None
        Range finder; None: the experiment's `range_finder`.
    label : str or None
        Label in tables; None: the footprint.
    """

    footprint: str = FOOTPRINT
    drive: DriveSpec | None = None
    range_finder: RangeFinderSpec | None = None
    label: Label | None = None


class FaultsChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """Faults, given or drawn in each repetition.

    Attributes
    ----------
    label : str
        Label in tables.
    faults : tuple of Death, Silence or LateStart
        Faults of every run.
    deaths, silences, late_starts : int
        Number of robots, drawn in each repetition, that die, fall silent or start late. No robot
        is drawn twice, and at least one robot has no fault.
    between_s : (float, float)
        Interval of simulated time (s) in which drawn faults occur, uniformly.
    silence_s : float
        Duration of a drawn silence (s).
    """

    label: Label
    faults: tuple[Fault, ...] = ()
    deaths: Annotated[int, Meta(ge=0)] = 0
    silences: Annotated[int, Meta(ge=0)] = 0
    late_starts: Annotated[int, Meta(ge=0)] = 0
    between_s: tuple[float, float] = (0.0, 120.0)
    silence_s: float = 30.0


class Limits(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """Limits of a single run, beyond which it is given up as failed.

    Attributes
    ----------
    computing_s : float
        Computing time (s of one core).
    memory_mb : int
        Memory (MB).
    """

    computing_s: Annotated[float, Meta(gt=0.0)] = 900.0
    memory_mb: Annotated[int, Meta(ge=64)] = 4096


class Only(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A selection of conditions by their labels.

    A condition is selected if it agrees with all fields that are given; of several labels in one
    field any will do.

    Attributes
    ----------
    environment, strategy, starts, radio, body, faults : str or tuple of str
        Labels.
    robots : int, str or tuple of them
        Team sizes, or labels of teams.
    """

    environment: str | tuple[str, ...] = ()
    strategy: str | tuple[str, ...] = ()
    robots: int | str | tuple[int | str, ...] = ()
    starts: str | tuple[str, ...] = ()
    radio: str | tuple[str, ...] = ()
    body: str | tuple[str, ...] = ()
    faults: str | tuple[str, ...] = ()


Environments = Annotated[tuple[str | EnvironmentChoice, ...], Meta(min_length=1)]
Strategies = Annotated[tuple[str | StrategyChoice, ...], Meta(min_length=1)]
Teams = Annotated[tuple[Annotated[int, Meta(ge=1, le=1000)] | TeamChoice, ...], Meta(min_length=1)]
Starts = Annotated[tuple[PlacedHow | StartsChoice, ...], Meta(min_length=1)]
Radios = Annotated[tuple[Literal["unlimited"] | RadioChoice, ...], Meta(min_length=1)]
Bodies = Annotated[tuple[str | BodyChoice, ...], Meta(min_length=1)]
Faults = Annotated[tuple[Literal["none"] | FaultsChoice, ...], Meta(min_length=1)]


class Block(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A part of an experiment that is crossed on its own.

    Attributes
    ----------
    environments, strategies, robots, starts, radios, bodies, faults
        Choices; those not given are taken from the experiment.
    """

    environments: Environments | None = None
    strategies: Strategies | None = None
    robots: Teams | None = None
    starts: Starts | None = None
    radios: Radios | None = None
    bodies: Bodies | None = None
    faults: Faults | None = None


class ExperimentSpec(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """An experiment: choices that are crossed, repetitions and limits.

    Attributes
    ----------
    name : str
        Title of reports.
    about : str
        The question that the experiment answers.
    environments : tuple of str or EnvironmentChoice
        Names in the catalogue, suites, map files, or generators with parameters and seeds.
    strategies : tuple of str or StrategyChoice
        Names of strategies, or tables with options.
    robots : tuple of int or TeamChoice
        Team sizes, or tables of teams whose robots differ.
    starts : tuple of str or StartsChoice
        "scattered", "clustered", "random", "suggested", "base", or tables.
    radios : tuple of str or RadioChoice
        "unlimited", or tables.
    bodies : tuple of str or BodyChoice
        Footprints, or tables.
    faults : tuple of str or FaultsChoice
        "none", or tables.
    blocks : tuple of Block
        Parts that are crossed separately, instead of all choices above.
    exclude : tuple of Only
        Conditions to leave out.
    repetitions : int
        Repetitions of every condition.
    first_seed : int
        Seed of repetition 0; repetition k has this seed plus k.
    drive, range_finder : DriveSpec, RangeFinderSpec
        Those of bodies without a drive or a range finder of their own.
    base : BaseSpec or None
        The base station of every run; None: there is none.
    stop : StopRule
        When a run is stopped.
    limits : Limits
        Computing time and memory of a run.
    success_coverage : float
        Share of the explorable area that a run must cover to be a success.
    horizon_s : float or None
        Time to which integrals run (s); None: that of the longest run of each setting.
    reference : {"none", "informed"}
        Whether times are also reported as multiples of those of the informed plan.
    recordings : {"none", "failed", "all"}
        Recordings to keep; a run failed if it is not a success.

    Raises
    ------
    InvalidInputError
        If `success_coverage` or `horizon_s` is out of range.

    Examples
    --------
    >>> spec = ExperimentSpec(
    ...     name="Star against Radial",
    ...     environments=("garden", "clutter"),
    ...     strategies=("srt-star", "srt-radial"),
    ...     robots=(1, 4),
    ...     repetitions=10,
    ... )
    >>> ExperimentSpec.from_toml(spec.to_toml()) == spec
    True
    >>> from multisrt.experiments.crossing import runs
    >>> len(runs(spec))
    80
    """

    name: Label
    about: str = ""
    environments: Environments = ()
    strategies: Strategies = ()
    robots: Teams = (1,)
    starts: Starts = ("scattered",)
    radios: Radios = ("unlimited",)
    bodies: Bodies = (FOOTPRINT,)
    faults: Faults = ("none",)
    blocks: tuple[Block, ...] = ()
    exclude: tuple[Only, ...] = ()
    repetitions: Count = 20
    first_seed: Seed = 0
    drive: DriveSpec = DriveSpec()
    range_finder: RangeFinderSpec = RangeFinderSpec()
    base: BaseSpec | None = None
    stop: StopRule = StopRule()
    limits: Limits = Limits()
    success_coverage: float = SUCCESS_COVERAGE
    horizon_s: float | None = None
    reference: Literal["none", "informed"] = "none"
    recordings: Literal["none", "failed", "all"] = "failed"

    def __post_init__(self) -> None:
        share, horizon_s, last_s = self.success_coverage, self.horizon_s, self.stop.max_time_s
        if not 0.0 < share <= 1.0:
            raise InvalidInputError(f"success_coverage is above 0 and at most 1, not {share:g}")
        if horizon_s is not None and not 0.0 < horizon_s <= last_s:
            raise InvalidInputError(
                "horizon_s is a time after the start and at most max_time_s of the stop rule "
                f"({last_s:g} s), not {horizon_s:g} s"
            )

    def to_toml(self) -> str:
        """Return the experiment as TOML.

        Returns
        -------
        str
            The text, without fields that have their default.

        Examples
        --------
        >>> spec = ExperimentSpec(name="x", strategies=("minpos",))
        >>> spec.to_toml().splitlines()[0]
        'name = "x"'
        """
        return msgspec.toml.encode(self).decode()

    def to_json(self) -> str:
        """Return the experiment as JSON.

        Returns
        -------
        str
            The text, indented, without fields that have their default.

        Examples
        --------
        >>> ExperimentSpec.from_json(ExperimentSpec(name="x").to_json()).name
        'x'
        """
        return msgspec.json.format(msgspec.json.encode(self), indent=2).decode()

    @classmethod
    def from_toml(cls, text: str) -> ExperimentSpec:
        """Read an experiment from TOML.

        Parameters
        ----------
        text : str
            The text.

        Returns
        -------
        ExperimentSpec
            The experiment.

        Raises
        ------
        InvalidInputError
            If the text is not TOML, or a field is unknown or has a wrong value; the message names
            the field and what is allowed.

        Examples
        --------
        >>> ExperimentSpec.from_toml('name = "x"').repetitions
        20
        """
        return _decoded(lambda: msgspec.toml.decode(text, type=cls), len(text))

    @classmethod
    def from_json(cls, text: str | bytes) -> ExperimentSpec:
        """Read an experiment from JSON.

        Parameters
        ----------
        text : str or bytes
            The text.

        Returns
        -------
        ExperimentSpec
            The experiment.

        Raises
        ------
        InvalidInputError
            As in `from_toml`.

        Examples
        --------
        >>> ExperimentSpec.from_json('{"name": "x", "robots": [1, 2]}').robots
        (1, 2)
        """
        return _decoded(lambda: msgspec.json.decode(text, type=cls), len(text))

    @classmethod
    def from_dict(cls, plain: dict[str, Any]) -> ExperimentSpec:
        """Read an experiment from plain data.

        Parameters
        ----------
        plain : dict
            Dictionaries, lists and scalars, as a TOML file holds them.

        Returns
        -------
        ExperimentSpec
            The experiment.

        Raises
        ------
        InvalidInputError
            As in `from_toml`.

        Examples
        --------
        >>> ExperimentSpec.from_dict({"name": "x", "limits": {"memory_mb": 512}}).limits.memory_mb
        512
        """
        return _decoded(lambda: msgspec.convert(plain, type=cls), 0)


def _decoded(decode: Callable[[], ExperimentSpec], length: int) -> ExperimentSpec:
    most = MAX_FILE_LENGTH
    if length > most:
        raise InvalidInputError(f"not an experiment: {length} characters, where {most} are allowed")
    try:
        return decode()
    except UNREADABLE as error:
        raise InvalidInputError(f"not an experiment: {explained(error, ExperimentSpec)}") from None
