"""The complete description of a run: equal specs give equal recordings, byte for byte."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, Literal, cast

import msgspec

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic, Kinematics
from multisrt.validation_errors import explained

Scalar = bool | int | float | str

MIN_RANGE_M, MAX_RANGE_M = 0.01, 1e6
"""Bounds of the range of a range finder, in metres."""

MIN_BEAMS, MAX_BEAMS = 5, 100_000
"""Bounds of the number of beams of a laser; far more would exhaust the memory."""


class _Spec(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True
):
    """A part of a spec: immutable, keyword-only, with no unknown fields."""


class CatalogEnvironment(_Spec, frozen=True, kw_only=True, tag_field="from", tag="catalog"):
    """An environment of the catalogue.

    Attributes
    ----------
    name : str
        Name in the catalogue.
    parameters : dict
        Parameters of a generator that are not its defaults.
    seed : int or None
        Seed of a generator, independent of the seed of the run; None for the generator's default.

    Examples
    --------
    >>> CatalogEnvironment(name="rooms", parameters={"size_m": 18.0}, seed=3).name
    'rooms'
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
        Metres per pixel, for an image whose file does not give them.
    threshold : float or None
        Lightness in [0, 1] above which a pixel of a plain image is free.
    """

    path: str
    resolution_m: float | None = None
    threshold: float | None = None


class InlineEnvironment(_Spec, frozen=True, kw_only=True, tag_field="from", tag="wkt"):
    """An environment written out in the spec.

    Attributes
    ----------
    name : str
        Its name.
    wkt : str
        Free space as well-known text, in metres.
    starts : tuple of (x, y)
        Suggested starts, in metres.
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
        A differential drive turns in place and drives along its heading; a holonomic one drives
        in any direction and keeps its heading; a Reeds-Shepp car drives forwards and backwards, a
        Dubins car forwards only.
    speed_m_s : float
        The maximum speed.
    turn_rate_rad_s : float
        The maximum turn rate of a differential drive.
    turning_radius_m : float
        The minimum turning radius of a car.

    Raises
    ------
    InvalidInputError
        If a number is not positive and finite.

    Examples
    --------
    >>> DriveSpec(kind="dubins", turning_radius_m=0.4).kinematics().reverse
    False
    """

    kind: Literal["differential", "holonomic", "reeds-shepp", "dubins"] = "differential"
    speed_m_s: float = 0.5
    turn_rate_rad_s: float = math.pi / 2
    turning_radius_m: float = 0.6

    def __post_init__(self) -> None:
        Differential(speed_m_s=self.speed_m_s, turn_rate_rad_s=self.turn_rate_rad_s)
        Car(speed_m_s=self.speed_m_s, turning_radius_m=self.turning_radius_m)

    def kinematics(self) -> Kinematics:
        """Return the kinematics that this describes."""
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
    """The range finder of a robot.

    Attributes
    ----------
    range_m : float
        Its range in metres (paper: R_p), from 0.01 to 1e6.
    beams : int or None
        Number of beams of a laser, from 5 to 100,000; None for the exact visibility polygon.

    Raises
    ------
    InvalidInputError
        If a number is outside of its bounds.

    Examples
    --------
    >>> RangeFinderSpec(range_m=3.0, beams=180).beams
    180
    """

    range_m: float = 4.0
    beams: int | None = None

    def __post_init__(self) -> None:
        if not MIN_RANGE_M <= self.range_m <= MAX_RANGE_M:
            raise InvalidInputError(
                "the range of a range finder is a positive number of metres, from "
                f"{MIN_RANGE_M:g} to {MAX_RANGE_M:g}, not {self.range_m:g}"
            )
        if self.beams is not None and not MIN_BEAMS <= self.beams <= MAX_BEAMS:
            raise InvalidInputError(
                f"a laser has {MIN_BEAMS} to {MAX_BEAMS} beams, not {self.beams}"
            )


class RobotSpec(_Spec, frozen=True, kw_only=True):
    """One robot.

    Attributes
    ----------
    start : (x, y) or (x, y, heading) or None
        Where it starts, in metres and radians; None to let the run place it, see `RunSpec.starts`.
    footprint : str
        Its body, as `Footprint.parse` reads it: ``disc:0.25``, ``box:0.5x0.3`` or
        ``polygon:x,y x,y x,y``.
    drive : DriveSpec
        How it moves.
    range_finder : RangeFinderSpec
        Its range finder.

    Raises
    ------
    InvalidInputError
        If the footprint is none, or the start is not finite.

    Examples
    --------
    >>> RobotSpec(start=(1, 2), footprint="box:0.5x0.3").start
    (1.0, 2.0)
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
        Range of the radio without walls, in metres (paper: R_c); None for an unlimited one.
    multi_hop : bool
        Whether robots relay messages.
    latency_s : float
        Time that a message takes, relayed or not.
    jitter_s : float
        Upper bound of an additional time, drawn uniformly for each message and receiver.
    loss : float
        Probability, from 0 to below 1, that a message is lost; drawn for each receiver.
    walls : {"pass", "block", "weaken"}
        Whether a wall between two robots does nothing, breaks the link, or weakens the signal.
    path_loss_exponent : float
        Exponent of the path loss where walls weaken; at `range_m` the signal just suffices.
    wall_loss_db : float
        Attenuation by one wall where walls weaken, in decibels.

    Raises
    ------
    InvalidInputError
        If a number is outside of its bounds, or walls weaken a signal without a range.

    Examples
    --------
    >>> RadioSpec(range_m=12.0, walls="block", loss=0.1).multi_hop
    True
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
    """A robot dies; its body stays where it is.

    Attributes
    ----------
    robot : int
        The robot, from 0.
    time_s : float
        The earliest time, in seconds from the start of the run.
    when : {"any", "moving", "waiting", "master"}
        What the robot is doing when it dies: anything, or the first time from `time_s` on that
        it moves, waits, or organises a group as its master.
    """

    robot: int
    time_s: float
    when: Literal["any", "moving", "waiting", "master"] = "any"


class Silence(_Spec, frozen=True, kw_only=True, tag_field="fault", tag="silence"):
    """The radio of a robot fails for a while.

    Attributes
    ----------
    robot : int
        The robot, from 0.
    time_s : float
        When it fails, in seconds from the start of the run.
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
        The robot, from 0.
    time_s : float
        When it begins, in seconds from the start of the run.
    """

    robot: int
    time_s: float


Fault = Death | Silence | LateStart


class StopRule(_Spec, frozen=True, kw_only=True):
    """When a run ends although its robots would go on.

    Attributes
    ----------
    max_time_s : float
        The maximum duration of the run, in the time of the run.
    """

    max_time_s: float = 86_400.0

    def __post_init__(self) -> None:
        if not 0.0 < self.max_time_s < math.inf:
            raise InvalidInputError(f"max_time_s is a positive time, not {self.max_time_s:g} s")


class RunSpec(_Spec, frozen=True, kw_only=True):
    """Everything that a run depends on.

    Attributes
    ----------
    environment : CatalogEnvironment, FileEnvironment or InlineEnvironment
        The world.
    strategy : str
        Name of a registered strategy; `multisrt.strategies` lists them.
    options : dict
        Options of the strategy that are not its defaults.
    robots : tuple of RobotSpec
        The team.
    starts : {"scattered", "clustered"}
        Where robots without a `start` are placed: far apart or close together. A single robot
        starts where the environment suggests, or at a random place.
    radio : RadioSpec
        How messages travel.
    faults : tuple of Death, Silence or LateStart
        What goes wrong.
    stop : StopRule
        When the run ends although its robots would go on.
    seed : int
        Seed of all random streams of the run, 0 or positive.

    Raises
    ------
    InvalidInputError
        If the team is empty, the seed is negative, or a fault does not fit the team and the run.

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
            name = str(fault.__struct_config__.tag).replace("_", " ")
            what = f"fault {number + 1} ({name} of robot {fault.robot})"
            if not 0 <= fault.robot < len(self.robots):
                raise InvalidInputError(
                    f"{what}: there is no such robot; the {len(self.robots)} count from 0"
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
        """Return the equal spec whose written form is the same for all specs equal to it.

        Examples
        --------
        >>> world = CatalogEnvironment(name="rooms")
        >>> same = RunSpec(environment=world, stop=StopRule(max_time_s=86400))
        >>> same.canonical().to_json() == RunSpec(environment=world).canonical().to_json()
        True
        """
        return cast(RunSpec, _less_defaults(RunSpec.from_json(msgspec.json.encode(self))))

    def to_json(self) -> str:
        """Return the spec as indented JSON."""
        return msgspec.json.format(msgspec.json.encode(self), indent=2).decode()

    def to_toml(self) -> str:
        """Return the spec as TOML."""
        return msgspec.toml.encode(self).decode()

    def to_dict(self) -> dict[str, Any]:
        """Return the spec as dictionaries, lists and scalars."""
        return cast(dict[str, Any], msgspec.to_builtins(self))

    @classmethod
    def from_json(cls, text: str | bytes) -> RunSpec:
        """Read a spec from JSON.

        Raises
        ------
        InvalidInputError
            If the text is not JSON, or a field is unknown or invalid; the message names it.
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
            If the text is not TOML, or a field is unknown or invalid; the message names it.
        """
        try:
            return msgspec.toml.decode(text, type=cls)
        except (msgspec.MsgspecError, RecursionError) as error:
            raise InvalidInputError(f"not a run spec: {explained(error, cls)}") from None


def _less_defaults(part: Any) -> Any:
    # Encoding omits a field only if it is the default object itself: equal values become that.
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
