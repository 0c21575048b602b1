"""What describes a run, wholly: the same spec gives the same bytes."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, Literal, cast

import msgspec
import numpy as np

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic, Kinematics
from multisrt.validation_errors import explained

Scalar = bool | int | float | str


SHORTEST_RANGE_M, LONGEST_RANGE_M = 0.01, 1e6
MOST_BEAMS = 100_000
"""What a range finder may be: far beyond these a run takes all memory before it begins."""


class _Spec(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True
):
    """A part of a spec: immutable, keyword-only, with no unknown fields."""


class CatalogEnvironment(_Spec, frozen=True, kw_only=True, tag_field="from", tag="catalog"):
    """An environment of the catalog.

    Attributes
    ----------
    name : str
        Its name there.
    parameters : dict
        A generator's parameters, where they are not the defaults.
    seed : int or None
        A generator's seed; it does not depend on the run's.
    """

    name: str
    parameters: dict[str, Scalar] = {}
    seed: int | None = None


class FileEnvironment(_Spec, frozen=True, kw_only=True, tag_field="from", tag="file"):
    """An environment read from a file.

    Attributes
    ----------
    path : str
        The file.
    resolution_m : float or None
        Metres per pixel of an image without its own.
    threshold : float or None
        Lightness in [0, 1] above which a pixel of a plain image is free.
    """

    path: str
    resolution_m: float | None = None
    threshold: float | None = None


class InlineEnvironment(_Spec, frozen=True, kw_only=True, tag_field="from", tag="wkt"):
    """An environment written out.

    Attributes
    ----------
    name : str
        What it is called.
    wkt : str
        Free space as well-known text, in metres.
    starts : tuple of (x, y)
        Suggested starts.
    """

    name: str
    wkt: str
    starts: tuple[tuple[float, float], ...] = ()


EnvironmentSpec = CatalogEnvironment | FileEnvironment | InlineEnvironment


class DriveSpec(_Spec, frozen=True, kw_only=True):
    """How a body moves.

    Attributes
    ----------
    kind : {"differential", "holonomic", "reeds-shepp", "dubins"}
        Turns in place and drives along its heading; drives in any direction; is a car that
        drives forwards and backwards; or is a car that only drives forwards.
    speed_m_s, turn_rate_rad_s : float
        Its limits; only a differential body turns in place.
    turning_radius_m : float
        Radius of a car's tightest curve.
    """

    kind: Literal["differential", "holonomic", "reeds-shepp", "dubins"] = "differential"
    speed_m_s: float = 0.5
    turn_rate_rad_s: float = math.pi / 2
    turning_radius_m: float = 0.6

    def __post_init__(self) -> None:
        Differential(speed_m_s=self.speed_m_s, turn_rate_rad_s=self.turn_rate_rad_s)
        Car(speed_m_s=self.speed_m_s, turning_radius_m=self.turning_radius_m)

    def kinematics(self) -> Kinematics:
        """Build the kinematics that this describes."""
        if self.kind == "holonomic":
            return Holonomic(speed_m_s=self.speed_m_s)
        if self.kind == "differential":
            return Differential(speed_m_s=self.speed_m_s, turn_rate_rad_s=self.turn_rate_rad_s)
        return Car(
            speed_m_s=self.speed_m_s,
            turning_radius_m=self.turning_radius_m,
            reverse=self.kind == "reeds-shepp",
        )


class RangeFinderSpec(_Spec, frozen=True, kw_only=True):
    """What a robot sees with.

    Attributes
    ----------
    range_m : float
        How far it sees (paper: R_p).
    beams : int or None
        Beams of a laser; None: the exact visibility polygon.
    """

    range_m: float = 4.0
    beams: int | None = None

    def __post_init__(self) -> None:
        if not SHORTEST_RANGE_M <= self.range_m <= LONGEST_RANGE_M:
            raise InvalidInputError(
                "the range of a range finder is a positive number of metres, from "
                f"{SHORTEST_RANGE_M:g} to {LONGEST_RANGE_M:g}, not {self.range_m:g}"
            )
        if self.beams is not None and not 5 <= self.beams <= MOST_BEAMS:
            raise InvalidInputError(f"a laser has 5 to {MOST_BEAMS} beams, not {self.beams}")


class RobotSpec(_Spec, frozen=True, kw_only=True):
    """One robot.

    Attributes
    ----------
    start : (x, y) or (x, y, heading) or None
        Where it starts; None: the environment's first suggestion, or else a place drawn
        uniformly by the run's seed.
    footprint : str
        Its body, as `Footprint.parse` reads it.
    drive : DriveSpec
        How it moves.
    range_finder : RangeFinderSpec
        What it sees with.
    """

    start: tuple[float, ...] | None = None
    footprint: str = "disc:0.25"
    drive: DriveSpec = DriveSpec()
    range_finder: RangeFinderSpec = RangeFinderSpec()

    def __post_init__(self) -> None:
        Footprint.parse(self.footprint)
        if self.start is None:
            return
        if len(self.start) not in (2, 3):
            raise InvalidInputError(f"a start is (x, y) or (x, y, heading), not {self.start!r}")
        numbers = tuple(map(float, self.start))
        if not all(map(math.isfinite, numbers)):
            raise InvalidInputError(f"a start is finite, not {numbers}")
        msgspec.structs.force_setattr(self, "start", numbers)


class RadioSpec(_Spec, frozen=True, kw_only=True):
    """How messages travel.

    Attributes
    ----------
    range_m : float or None
        How far a message reaches in the open (paper: R_c); None: everywhere.
    multi_hop : bool
        Whether robots that are in range of one another relay messages.
    latency_s : float
        Time that a message takes, relayed or not.
    jitter_s : float
        Additional time, uniform from 0 to this, for each message and receiver anew.
    loss : float
        Probability that a message does not come to a receiver, for each anew.
    walls : {"pass", "block", "weaken"}
        Whether a wall between two robots is nothing to the radio, stops it, or takes
        `wall_loss_db` each from the strength of the signal.
    path_loss_exponent : float
        With walls that weaken: how fast the signal fades, 2 in the open. At `range_m` without
        a wall it is just strong enough.
    wall_loss_db : float
        With walls that weaken: what a wall takes, in decibels.
    """

    range_m: float | None = None
    multi_hop: bool = True
    latency_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    walls: Literal["pass", "block", "weaken"] = "pass"
    path_loss_exponent: float = 2.0
    wall_loss_db: float = 5.0

    def __post_init__(self) -> None:
        for name, ok, allowed in (
            ("range_m", self.range_m is None or 0.0 <= self.range_m < math.inf, "0 or more"),
            ("latency_s", 0.0 <= self.latency_s < math.inf, "0 or more"),
            ("jitter_s", 0.0 <= self.jitter_s < math.inf, "0 or more"),
            ("loss", 0.0 <= self.loss < 1.0, "from 0 to below 1"),
            ("path_loss_exponent", 1.0 <= self.path_loss_exponent <= 10.0, "from 1 to 10"),
            ("wall_loss_db", 0.0 <= self.wall_loss_db < math.inf, "0 or more"),
        ):
            if not ok:
                raise InvalidInputError(
                    f"{name} of a radio is {getattr(self, name)}; it must be {allowed}"
                )
        if self.walls == "weaken" and self.range_m is None:
            raise InvalidInputError(
                "walls weaken a signal that has a range: give range_m, or let walls pass or block"
            )


class Death(_Spec, frozen=True, kw_only=True, tag_field="fault", tag="death"):
    """A robot dies for good; its body stays where it is.

    Attributes
    ----------
    robot : int
        Which.
    time_s : float
        When.
    when : {"any", "moving", "waiting", "master"}
        Not before it does this: moves, waits, or organises a group as its master.
    """

    robot: int
    time_s: float
    when: Literal["any", "moving", "waiting", "master"] = "any"


class Silence(_Spec, frozen=True, kw_only=True, tag_field="fault", tag="silence"):
    """A robot's radio fails for a while; the robot goes on.

    Attributes
    ----------
    robot : int
        Which.
    time_s : float
        When.
    duration_s : float
        For how long.
    """

    robot: int
    time_s: float
    duration_s: float

    def __post_init__(self) -> None:
        if not 0.0 < self.duration_s < math.inf:
            raise InvalidInputError(
                f"a silence lasts a positive number of seconds, not {self.duration_s:g}"
            )


class LateStart(_Spec, frozen=True, kw_only=True, tag_field="fault", tag="late_start"):
    """A robot stands switched off at its start and begins late.

    Attributes
    ----------
    robot : int
        Which.
    time_s : float
        When it begins.
    """

    robot: int
    time_s: float


Fault = Death | Silence | LateStart


class StopRule(_Spec, frozen=True, kw_only=True):
    """When a run ends although its robots would go on.

    Attributes
    ----------
    max_time_s : float
        At this time of the run's own clock.
    """

    max_time_s: float = 86_400.0

    def __post_init__(self) -> None:
        if not 0.0 < self.max_time_s < math.inf:
            raise InvalidInputError(
                f"max_time_s is a positive number of seconds, not {self.max_time_s:g}"
            )


class RunSpec(_Spec, frozen=True, kw_only=True):
    """Everything that a run depends on.

    Attributes
    ----------
    environment : CatalogEnvironment, FileEnvironment or InlineEnvironment
        The world.
    strategy : str
        A name of the registry.
    options : dict
        The strategy's parameters, where they are not its defaults.
    robots : tuple of RobotSpec
        The team.
    starts : {"scattered", "clustered"}
        Where robots start that are not told where: far apart from one another, or together.
    radio : RadioSpec
        How messages travel.
    faults : tuple of Death, Silence or LateStart
        What goes wrong.
    stop : StopRule
        When the run ends although its robots would go on.
    seed : int
        Seeds every random stream of the run.

    Examples
    --------
    >>> spec = RunSpec(environment=CatalogEnvironment(name="rooms"), seed=7)
    >>> RunSpec.from_toml(spec.to_toml()) == spec
    True
    """

    environment: EnvironmentSpec
    strategy: str = "srt-radial"
    options: dict[str, Scalar] = {}
    robots: tuple[RobotSpec, ...] = (RobotSpec(),)
    starts: Literal["scattered", "clustered"] = "scattered"
    radio: RadioSpec = RadioSpec()
    faults: tuple[Fault, ...] = ()
    stop: StopRule = StopRule()
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.robots:
            raise InvalidInputError("a team has at least one robot")
        if self.seed < 0:
            raise InvalidInputError(f"a seed is 0 or a positive whole number, not {self.seed}")
        self._check_faults()

    def _check_faults(self) -> None:
        for number, fault in enumerate(self.faults):
            what = f"fault {number + 1} ({_FAULTS[type(fault)]} of robot {fault.robot})"
            if not 0 <= fault.robot < len(self.robots):
                raise InvalidInputError(
                    f"{what}: there is no such robot; the {len(self.robots)} count from 0"
                )
            if not 0.0 <= fault.time_s < self.stop.max_time_s:
                raise InvalidInputError(
                    f"{what}: at {fault.time_s:g} s, which is not within the run; it ends at "
                    f"{self.stop.max_time_s:g} s (stop.max_time_s)"
                )
        late = [fault.robot for fault in self.faults if isinstance(fault, LateStart)]
        dead = [fault.robot for fault in self.faults if isinstance(fault, Death)]
        for name, robots in (("late_start", late), ("death", dead)):
            for robot in sorted(set(robots)):
                if robots.count(robot) > 1:
                    raise InvalidInputError(f"robot {robot} has more than one fault {name}")

    def canonical(self) -> RunSpec:
        """Give this spec in the one form that all specs equal to it have when they are written."""
        return cast(RunSpec, _less_defaults(RunSpec.from_json(msgspec.json.encode(self))))

    def to_json(self) -> str:
        """Write the spec as JSON."""
        return msgspec.json.format(msgspec.json.encode(self), indent=2).decode()

    def to_toml(self) -> str:
        """Write the spec as TOML."""
        return msgspec.toml.encode(self).decode()

    def to_dict(self) -> dict[str, Any]:
        """Give the spec as plain dictionaries, lists and scalars."""
        return cast(dict[str, Any], msgspec.to_builtins(self))

    @classmethod
    def from_json(cls, text: str | bytes) -> RunSpec:
        """Read a spec from JSON.

        Raises
        ------
        InvalidInputError
            If it is no JSON, or a field is unknown or of the wrong kind; the message names it.
        """
        try:
            return msgspec.json.decode(text, type=cls)
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            raise InvalidInputError(f"not a run spec: {explained(error, cls)}") from None

    @classmethod
    def from_toml(cls, text: str) -> RunSpec:
        """Read a spec from TOML.

        Raises
        ------
        InvalidInputError
            If it is no TOML, or a field is unknown or of the wrong kind; the message names it.
        """
        try:
            return msgspec.toml.decode(text, type=cls)
        except (msgspec.MsgspecError, RecursionError) as error:
            raise InvalidInputError(f"not a run spec: {explained(error, cls)}") from None


def _less_defaults(part: Any) -> Any:
    # What is written leaves out a default itself, but not what equals it: so leave that out here.
    if isinstance(part, tuple):
        return tuple(map(_less_defaults, part))
    if not isinstance(part, _Spec):
        return part
    defaults = _defaults(type(part))
    given = {name: getattr(part, name) for name in defaults}
    return type(part)(
        **{name: _less_defaults(v) for name, v in given.items() if v != defaults[name]}
    )


@cache
def _defaults(kind: type[_Spec]) -> dict[str, Any]:
    return {field.name: field.default for field in msgspec.structs.fields(kind)}


_FAULTS = {Death: "death", Silence: "silence", LateStart: "late start"}


STREAMS = {"starts": 0, "radio": 1, "faults": 2, "robots": 3}
"""What draws random numbers in a run; each has a stream of its own."""


def random_stream(seed: int, stream: str, number: int = 0) -> np.random.Generator:
    """Give the random stream of a part of the run, independent of all others."""
    key = (STREAMS[stream], number)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
