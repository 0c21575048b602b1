"""From the options of `multisrt explore` to a spec."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

import click

from multisrt.geometry.errors import InvalidInputError, counted, did_you_mean

if TYPE_CHECKING:
    from multisrt.spec import BaseSpec, EnvironmentSpec, Fault, RobotSpec, RunSpec

T = TypeVar("T")

DRIVES = ("differential", "holonomic", "reeds-shepp", "dubins")

DEFAULT_STRATEGY = "srt-radial"
"""The strategy of `RunSpec`, for completion."""

USUAL = "usual"
"""Value of `--robot` for a robot that does not differ."""

RADIO = ("radio_range", "no_multi_hop", "latency", "jitter", "loss", "walls")
"""Parameters of the command that are about the radio."""

OPTIONS_OF_RADIO = {
    "range_m": "--radio-range",
    "latency_s": "--latency",
    "jitter_s": "--jitter",
    "loss": "--loss",
}
"""Options by the fields of `RadioSpec` that they set."""

OVERRIDES = ("footprint", "range", "beams", "drive", "speed", "turning-radius", "start")
"""Keys of `--robot`."""

FAULTS = "death:ROBOT@TIME[:moving|waiting|master], silence:ROBOT@TIME+DURATION or late:ROBOT@TIME"
_FAULT = re.compile(
    r"(?P<what>death|silence|late):(?P<robot>\d+)@(?P<time>[^:+]+)"
    r"(?:\+(?P<duration>[^:+]+))?(?::(?P<when>any|moving|waiting|master))?"
)


def spec_of_options(environment: str, strategy: str | None, given: Mapping[str, Any]) -> RunSpec:
    """Build the spec of a run from the options of `multisrt explore`.

    Parameters
    ----------
    environment : str
        Name in the catalogue, or a map file.
    strategy : str or None
        Name of the strategy; None: the default of `RunSpec`.
    given : mapping
        Values of the other options by parameter name; None where an option was not given.

    Returns
    -------
    RunSpec
        The spec, with its own defaults for what was not given.

    Raises
    ------
    InvalidInputError
        If a value is out of range, or options contradict each other.
    click.BadParameter
        If a value cannot be parsed.
    """
    from multisrt.spec import RadioSpec, RunSpec, StopRule
    from multisrt.spec.keywords import require_use

    radio = _renamed(
        given,
        radio_range="range_m",
        latency="latency_s",
        jitter="jitter_s",
        loss="loss",
        walls="walls",
    )
    if given["no_multi_hop"]:
        radio["multi_hop"] = False
    fields = _renamed(given, starts="starts", seed="seed")
    if strategy is not None:
        fields["strategy"] = strategy
    spec = RunSpec(
        environment=world_of_options(environment, given),
        options=options_of(given["options"]),
        robots=_team(given),
        radio=_built(RadioSpec, radio, OPTIONS_OF_RADIO),
        faults=tuple(_fault(text) for text in given["faults"]),
        base=None if given["base"] is None else _base(given["base"]),
        stop=_built(StopRule, _renamed(given, max_time="max_time_s"), {"max_time_s": "--max-time"}),
        **fields,
    )
    of_team = {name: f"--{name.replace('_', '-')}" for name in ("starts", *RADIO) if given[name]}
    sized = given["robots"] is not None or bool(given["robot"])
    require_use(spec, of_team, "--robots", sized=sized)
    return spec


def world_of_options(environment: str, given: Mapping[str, Any]) -> EnvironmentSpec:
    """Return the spec of a world from the options of `multisrt.cli.own_map.world_options`.

    Parameters
    ----------
    environment : str
        Name in the catalogue or of a world of a suite, or a map file.
    given : mapping
        Values of the options by parameter name; None where an option was not given.

    Raises
    ------
    InvalidInputError
        If there is no such world, or an option does not apply to it.
    click.BadParameter
        If a value cannot be parsed.
    """
    from multisrt.simulation.worlds import environment_spec

    if os.path.isdir(environment):  # False where it may not be looked at, too
        _require_no_run(environment)
    return environment_spec(
        environment,
        parameters=parameters_of(given["parameters"]),
        resolution_m=given["resolution"],
        threshold=given["threshold"],
        starts_from=given["starts_from"],
    )


def _require_no_run(folder: str) -> None:
    from multisrt.finished_run import RECORDING_NAME

    if os.path.isfile(os.path.join(folder, RECORDING_NAME)):
        raise InvalidInputError(
            f"{folder} is the folder of a run and no map: 'multisrt export "
            f"{shlex.quote(folder)} --what world --out world.geojson' writes its world as one"
        )


def options_of(texts: Iterable[str]) -> dict[str, Any]:
    """Return the values of ``--option KEY=VALUE`` by key.

    Raises
    ------
    click.BadParameter
        If a text is not KEY=VALUE, or a key is given twice.
    """
    return dict(_by_key(texts, "--option"))


def parameters_of(texts: Iterable[str]) -> dict[str, Any]:
    """Return the values of ``--set NAME=VALUE`` by name: numbers, or true and false, if they are.

    Raises
    ------
    click.BadParameter
        If a text is not NAME=VALUE, or a name is given twice.

    Examples
    --------
    >>> parameters_of(["cells=20", "loops=0.5", "furnished=false"])
    {'cells': 20, 'loops': 0.5, 'furnished': False}
    """
    return {name: _scalar(text) for name, text in _by_key(texts, "--set").items()}


def start_of(text: str, option: str) -> tuple[float, ...]:
    """Return a start ``X,Y`` or ``X,Y,HEADING``, in metres and radians.

    Raises
    ------
    click.BadParameter
        If a text is neither; it names the option.

    Examples
    --------
    >>> start_of("2.5,4", "--start")
    (2.5, 4.0)
    """
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) in (2, 3):
        return numbers
    raise click.BadParameter(f"{text!r} is not X,Y or X,Y,HEADING", param_hint=option)


def _scalar(text: str) -> int | float | bool | str:
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        with suppress(ValueError):
            number: int | float = kind(text)
            return number
    return text


def _built(kind: Callable[..., T], fields: Mapping[str, Any], options: Mapping[str, str]) -> T:
    # What is wrong with a value is told of the option that gave it, not of the spec's field.
    try:
        return kind(**fields)
    except InvalidInputError as error:
        text = str(error)
        for field, option in options.items():
            text = re.sub(rf"\b{field}\b( of a radio)?", option, text)
        raise InvalidInputError(text) from None


def _renamed(given: Mapping[str, Any], /, **fields: str) -> dict[str, Any]:
    """Return the given values by field name, without those that are None."""
    return {field: given[name] for name, field in fields.items() if given.get(name) is not None}


def _team(given: Mapping[str, Any]) -> tuple[RobotSpec, ...]:
    places = [start_of(text, "--start") for text in given["start"]]
    differing = [_overrides(text) for text in given["robot"]]
    count = given["robots"]
    if count is None:
        count = max(1, len(places), len(differing))
    if count < 1:
        raise InvalidInputError(f"a team has at least one robot, not {count}")
    if places and len(places) != count:
        raise InvalidInputError(
            f"{counted(len(places), 'start')} for {counted(count, 'robot')}: give --start for "
            "each of them or for none; --robot start=X,Y gives one robot a start of its own"
        )
    if differing and len(differing) != count:
        raise InvalidInputError(
            f"--robot describes one robot and is given {_times(len(differing))} for {count}: give "
            f"it once for each, '--robot {USUAL}' where nothing differs; for what all have in "
            "common there are options such as --range"
        )
    usual = {
        "footprint": given["footprint"],
        "range": given["range_m"],
        "beams": given["beams"],
        "drive": given["drive"],
        "speed": given["speed"],
        "turning-radius": given["turning_radius"],
    }
    if places and any("start" in own for own in differing):
        raise InvalidInputError("give starts with --start or with --robot start=..., not both")
    team = [
        _of_drive(usual, own) | {"start": places[number] if places else None} | own
        for number, own in enumerate(differing or [{}] * count)
    ]
    for key, value in usual.items():
        if value is not None and all(one[key] is not value for one in team):
            raise InvalidInputError(
                f"--{key} is used by no robot: "
                + ("none is a car" if key == "turning-radius" else f"each has its own {key}")
            )
    return tuple(map(_robot, team, differing or [{}] * count))


def _of_drive(usual: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    # What one robot has in common with the others: a turning radius only if it is a car.
    from multisrt.spec import DriveSpec

    kind = own.get("drive") or usual["drive"]
    is_car = kind is not None and DriveSpec(kind=kind).is_car
    if "turning-radius" in own and not is_car:
        raise InvalidInputError(
            f"--robot turning-radius={own['turning-radius']:g}: this robot is not a car; give it "
            "drive=reeds-shepp or drive=dubins"
        )
    return {key: None if key == "turning-radius" and not is_car else usual[key] for key in usual}


def _times(number: int) -> str:
    return "once" if number == 1 else f"{number} times"


def _robot(given: Mapping[str, Any], own: Mapping[str, Any]) -> RobotSpec:
    from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec

    drive = {"drive": "kind", "speed": "speed_m_s", "turning-radius": "turning_radius_m"}
    return RobotSpec(
        **_renamed(given, start="start", footprint="footprint"),
        drive=_built(
            DriveSpec,
            _renamed(given, **drive),
            {field: f"--robot {key}" if key in own else f"--{key}" for key, field in drive.items()},
        ),
        range_finder=RangeFinderSpec(**_renamed(given, range="range_m", beams="beams")),
    )


def _overrides(text: str) -> dict[str, Any]:
    # Commas separate the keys, and also occur within a start or a footprint.
    values: dict[str, Any] = {}
    if text == USUAL:
        return values
    if text.isdecimal():
        raise click.BadParameter(
            f"{text!r} is not KEY=VALUE (did you mean --robots {text}?)", param_hint="--robot"
        )
    for part in re.split(r",\s*(?=[a-z-]+=)", text):
        key, value = _key_and_value(part, "--robot")
        if key not in OVERRIDES:
            raise click.BadParameter(
                f"{key!r} is not one of {', '.join(OVERRIDES)}{did_you_mean(key, OVERRIDES)}",
                param_hint="--robot",
            )
        if key in ("range", "speed", "turning-radius"):
            values[key] = _number(value, float, "--robot")
        elif key == "beams":
            values[key] = _number(value, int, "--robot")
        elif key == "drive" and value not in DRIVES:
            raise InvalidInputError(
                f"--robot: there is no drive {value!r}{did_you_mean(value, DRIVES)}; there are: "
                f"{', '.join(DRIVES)}"
            )
        else:
            values[key] = start_of(value, "--robot") if key == "start" else value
    return values


def _fault(text: str) -> Fault:
    from multisrt.spec import Death, LateStart, Silence

    found = _FAULT.fullmatch(text.strip())
    what = found["what"] if found else None
    if (
        found is None
        or (found["duration"] is not None) != (what == "silence")
        or (found["when"] is not None and what != "death")
    ):
        raise click.BadParameter(f"{text!r} is not {FAULTS}", param_hint="--fault")
    robot, time_s = int(found["robot"]), _number(found["time"], float, "--fault")
    if what == "death":
        when: Any = found["when"] or "any"
        return Death(robot=robot, time_s=time_s, when=when)
    if what == "late":
        return LateStart(robot=robot, time_s=time_s)
    return Silence(
        robot=robot, time_s=time_s, duration_s=_number(found["duration"], float, "--fault")
    )


def _base(text: str) -> BaseSpec:
    from multisrt.spec import BaseSpec

    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise click.BadParameter(f"{text!r} is not X,Y", param_hint="--base") from None
    return BaseSpec(x=x, y=y)


def _by_key(texts: Iterable[str], option: str) -> dict[str, str]:
    given: dict[str, str] = {}
    for text in texts:
        key, value = _key_and_value(text, option)
        if key in given:
            raise click.BadParameter(
                f"{key} is given twice, as {given[key]} and {value}; give it once",
                param_hint=option,
            )
        given[key] = value
    return given


def _key_and_value(text: str, option: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals or not key or not value:
        raise click.BadParameter(f"{text!r} is not KEY=VALUE", param_hint=option)
    return key.strip(), value.strip()


def _number(text: str, kind: Any, option: str) -> Any:
    try:
        return kind(text)
    except ValueError:
        raise click.BadParameter(f"{text!r} is not a number", param_hint=option) from None
