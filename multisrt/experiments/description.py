"""What describes an experiment: conditions that are crossed, and how often each is repeated.

The design is paired: repetition k has the same seed whatever the strategy, so that it meets the
same world, the same starts, the same faults and the same draws of the radio.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from multisrt.experiments.schema import for_editors
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import DriveSpec, Fault, RadioSpec, RangeFinderSpec, Scalar, StopRule
from multisrt.validation_errors import explained

LONGEST_FILE = 16_000_000
"""Characters of an experiment file: a longer one is none."""

Count = Annotated[int, Meta(ge=1, le=1_000_000)]
Seed = Annotated[int, Meta(ge=0)]
Label = Annotated[str, Meta(min_length=1, max_length=80)]
NameOrPath = Annotated[str, Meta(min_length=1, max_length=4096)]


class _Part(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A part of an experiment: immutable, keyword-only, with no unknown fields."""


class EnvironmentChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """An environment, or one for each of some seeds.

    Attributes
    ----------
    name : str
        A name of the catalogue, or a file; a path is relative to the experiment's file.
    label : str or None
        What tables call it; None: its name, and that of a file without folder and suffix.
    parameters : dict
        A generator's parameters, where they are not its defaults.
    seed : int, "repetition" or None
        A generator's seed. "repetition": a world of its own for each repetition, by its seed.
    seeds : str or tuple of int
        Instead of one: a world of its own, as one more condition, for each of these seeds;
        "0-9" is all from 0 to 9.
    resolution_m : float or None
        Metres per pixel of an image without its own.
    threshold : float or None
        Lightness in [0, 1] above which a pixel of a plain image is free.
    wkt : str or None
        Instead of a name of the catalogue or a file: free space as well-known text, in metres.
    starts : tuple of (x, y)
        Starts that a world given as text suggests.
    """

    name: NameOrPath
    label: Label | None = None
    parameters: dict[str, Scalar] = {}
    seed: Seed | Literal["repetition"] | None = None
    seeds: str | tuple[Seed, ...] = ()
    resolution_m: float | None = None
    threshold: float | None = None
    wkt: str | None = None
    starts: tuple[tuple[float, float], ...] = ()


class StrategyChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A strategy with its options.

    Attributes
    ----------
    name : str
        A name of the registry.
    label : str or None
        What tables call it; None: its name.
    options : dict
        Its parameters, where they are not its defaults.
    """

    name: Label
    label: Label | None = None
    options: dict[str, Scalar] = {}


class MemberChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A robot of a team whose robots are not all alike.

    Attributes
    ----------
    start : (x, y) or (x, y, heading) or None
        Where it starts; None: as the experiment's starts say.
    footprint : str
        Its outline, as `Footprint.parse` reads it.
    drive : DriveSpec or None
        How it moves; None: as the experiment says.
    range_finder : RangeFinderSpec or None
        What it sees with; None: as the experiment says.
    """

    start: tuple[float, ...] | None = None
    footprint: str = "disc:0.25"
    drive: DriveSpec | None = None
    range_finder: RangeFinderSpec | None = None


class TeamChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A team whose robots are not all alike.

    Attributes
    ----------
    label : str
        What tables call it.
    members : tuple of MemberChoice
        Its robots; the experiment's bodies do not concern them.
    """

    label: Label
    members: Annotated[tuple[MemberChoice, ...], Meta(min_length=1, max_length=1000)]


class StartsChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """Where teams start.

    Attributes
    ----------
    how : {"scattered", "clustered"}
        Far apart from one another, or together.
    first : {"any", "drawn"}
        "drawn": a place and a heading are drawn uniformly for the first robot, anew for each
        repetition, and the others stand around it or far from it. "any": as a single run does
        it, where a robot alone starts where the world suggests.
    places : tuple of (x, y) or (x, y, heading)
        Instead: where the robots start, as many as the team has or more.
    label : str or None
        What tables call it; None: made from what is above.
    """

    how: Literal["scattered", "clustered"] = "scattered"
    first: Literal["any", "drawn"] = "any"
    places: tuple[tuple[float, ...], ...] = ()
    label: Label | None = None


class RadioChoice(RadioSpec, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A radio, with a name for tables.

    Attributes
    ----------
    label : str or None
        What tables call it; None: its range.
    """

    label: Label | None = None


class BodyChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A body: its outline, how it moves and what it sees with.

    Attributes
    ----------
    footprint : str
        Its outline, as `Footprint.parse` reads it.
    drive : DriveSpec or None
        How it moves; None: as the experiment says.
    range_finder : RangeFinderSpec or None
        What it sees with; None: as the experiment says.
    label : str or None
        What tables call it; None: its outline.
    """

    footprint: str = "disc:0.25"
    drive: DriveSpec | None = None
    range_finder: RangeFinderSpec | None = None
    label: Label | None = None


class FaultsChoice(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """What goes wrong: faults as they are, and others drawn anew for each repetition.

    Attributes
    ----------
    label : str
        What tables call it.
    faults : tuple of Death, Silence or LateStart
        Those of every run.
    deaths, silences, late_starts : int
        How many robots, drawn by the repetition's seed, die, fall silent or begin late; nobody
        has two faults, and at least one robot of the team has none.
    between_s : (float, float)
        When, uniformly.
    silence_s : float
        How long a drawn silence lasts.
    """

    label: Label
    faults: tuple[Fault, ...] = ()
    deaths: Annotated[int, Meta(ge=0)] = 0
    silences: Annotated[int, Meta(ge=0)] = 0
    late_starts: Annotated[int, Meta(ge=0)] = 0
    between_s: tuple[float, float] = (0.0, 120.0)
    silence_s: float = 30.0


class Limits(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """What a single run may take; beyond, it is given up as failed.

    Attributes
    ----------
    computing_s : float
        Computing time, in seconds of one core.
    memory_mb : int
        Memory, in megabytes.
    """

    computing_s: Annotated[float, Meta(gt=0.0)] = 900.0
    memory_mb: Annotated[int, Meta(ge=64)] = 4096


class Only(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """Conditions by their labels: a run is meant if it agrees in all that are given.

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
Starts = Annotated[tuple[Literal["scattered", "clustered"] | StartsChoice, ...], Meta(min_length=1)]
Radios = Annotated[tuple[Literal["unlimited"] | RadioChoice, ...], Meta(min_length=1)]
Bodies = Annotated[tuple[str | BodyChoice, ...], Meta(min_length=1)]
Faults = Annotated[tuple[Literal["none"] | FaultsChoice, ...], Meta(min_length=1)]


class Block(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """A part of an experiment that is crossed by itself.

    Attributes
    ----------
    environments, strategies, robots, starts, radios, bodies, faults
        Conditions; what is not given is taken from the experiment.
    """

    environments: Environments | None = None
    strategies: Strategies | None = None
    robots: Teams | None = None
    starts: Starts | None = None
    radios: Radios | None = None
    bodies: Bodies | None = None
    faults: Faults | None = None


class ExperimentSpec(_Part, frozen=True, kw_only=True, omit_defaults=True):
    """An experiment.

    Attributes
    ----------
    name : str
        What reports call it.
    about : str
        What it is to find out.
    environments : tuple of str or EnvironmentChoice
        Names of the catalogue, files, or generators with their parameters and seeds.
    strategies : tuple of str or StrategyChoice
        Names of the registry, or tables with options.
    robots : tuple of int or TeamChoice
        Team sizes, or tables of teams whose robots differ.
    starts : tuple of str or StartsChoice
        "scattered", "clustered", or tables.
    radios : tuple of str or RadioChoice
        "unlimited", or tables.
    bodies : tuple of str or BodyChoice
        Outlines, or tables.
    faults : tuple of str or FaultsChoice
        "none", or tables.
    blocks : tuple of Block
        Instead of crossing all of the above: parts that are crossed each by itself.
    exclude : tuple of Only
        Conditions that are left out.
    repetitions : int
        How often every condition is repeated.
    first_seed : int
        The seed of repetition 0; repetition k has this plus k.
    drive : DriveSpec
        How bodies move that do not say it themselves.
    range_finder : RangeFinderSpec
        What they see with.
    stop : StopRule
        When a run ends although its robots would go on.
    limits : Limits
        What a run may take of the computer.
    recordings : {"none", "failed", "all"}
        Which are kept.
    """

    name: Label
    about: str = ""
    environments: Environments = ()
    strategies: Strategies = ()
    robots: Teams = (1,)
    starts: Starts = ("scattered",)
    radios: Radios = ("unlimited",)
    bodies: Bodies = ("disc:0.25",)
    faults: Faults = ("none",)
    blocks: tuple[Block, ...] = ()
    exclude: tuple[Only, ...] = ()
    repetitions: Count = 20
    first_seed: Seed = 0
    drive: DriveSpec = DriveSpec()
    range_finder: RangeFinderSpec = RangeFinderSpec()
    stop: StopRule = StopRule()
    limits: Limits = Limits()
    recordings: Literal["none", "failed", "all"] = "failed"

    def to_toml(self) -> str:
        """Write it as TOML."""
        return msgspec.toml.encode(self).decode()

    def to_json(self) -> str:
        """Write it as JSON."""
        return msgspec.json.format(msgspec.json.encode(self), indent=2).decode()

    @classmethod
    def from_toml(cls, text: str) -> ExperimentSpec:
        """Read an experiment from TOML.

        Raises
        ------
        InvalidInputError
            If it is no TOML, or a field is unknown or of the wrong kind; the message names the
            place, and what would be right there.
        """
        return _decoded(lambda: msgspec.toml.decode(text, type=cls), len(text))

    @classmethod
    def from_json(cls, text: str | bytes) -> ExperimentSpec:
        """Read an experiment from JSON; see `from_toml`."""
        return _decoded(lambda: msgspec.json.decode(text, type=cls), len(text))

    @classmethod
    def from_dict(cls, plain: dict[str, Any]) -> ExperimentSpec:
        """Read an experiment from plain dictionaries, lists and scalars; see `from_toml`."""
        return _decoded(lambda: msgspec.convert(plain, type=cls), 0)


def _decoded(decode: Callable[[], ExperimentSpec], length: int) -> ExperimentSpec:
    if length > LONGEST_FILE:
        raise InvalidInputError(
            f"not an experiment: {length} characters, where {LONGEST_FILE} are allowed"
        )
    try:
        return decode()
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
        raise InvalidInputError(f"not an experiment: {explained(error, ExperimentSpec)}") from None


def schema() -> dict[str, Any]:
    """Give the JSON Schema of experiment files, for editors.

    The fields are described as their classes' docstrings describe them.
    """
    return for_editors(
        msgspec.json.schema(ExperimentSpec), bases={"RadioChoice": RadioSpec.__doc__ or ""}
    )
