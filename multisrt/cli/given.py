"""From the words of `multisrt explore` to specs."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    from multisrt.spec import Fault, RobotSpec, RunSpec

Described = TypeVar("Described")

DRIVES = ("differential", "holonomic", "reeds-shepp", "dubins")

OVERRIDES = ("footprint", "range", "beams", "drive", "speed", "turning-radius", "start")
"""What `--robot` may say of one robot."""

FAULTS = "death:ROBOT@TIME[:moving|waiting|master], silence:ROBOT@TIME+DURATION or late:ROBOT@TIME"
_FAULT = re.compile(
    r"(?P<what>death|silence|late):(?P<robot>\d+)@(?P<time>[^:+]+)"
    r"(?:\+(?P<duration>[^:+]+))?(?::(?P<when>any|moving|waiting|master))?"
)


def spec_of_file(path: Path) -> RunSpec:
    """Read a spec from a TOML file, or from JSON if it is called so.

    Raises
    ------
    InvalidInputError
        If it cannot be read or is no spec; the message says what is wrong.
    """
    from multisrt.spec import RunSpec

    return described(path, RunSpec.from_toml, RunSpec.from_json)


def described(
    path: Path, from_toml: Callable[[str], Described], from_json: Callable[[str], Described]
) -> Described:
    """Read what a TOML file describes, or a JSON file if it is called so.

    Raises
    ------
    InvalidInputError
        If it cannot be read, or by `from_toml` or `from_json`; the message names the file.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        said = error.strerror if isinstance(error, OSError) else "not a text file"
        raise InvalidInputError(f"{path}: {said or error}") from None
    try:
        return from_json(text) if path.suffix == ".json" else from_toml(text)
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from None


def spec_of_words(environment: str, strategy: str, given: dict[str, Any]) -> RunSpec:
    """Build a spec from what was given on the command line."""
    from multisrt.simulation.worlds import environment_spec
    from multisrt.spec import RadioSpec, RunSpec, StopRule

    max_time = given["max_time"]
    return RunSpec(
        environment=environment_spec(
            environment, resolution_m=given["resolution"], threshold=given["threshold"]
        ),
        strategy=strategy,
        options=dict(_key_and_value(text, "--option") for text in given["options"]),
        robots=_team(given),
        starts=given["starts"],
        radio=RadioSpec(
            range_m=given["radio_range"],
            multi_hop=not given["no_multi_hop"],
            latency_s=given["latency"],
            jitter_s=given["jitter"],
            loss=given["loss"],
            walls=given["walls"],
        ),
        faults=tuple(_fault(text) for text in given["faults"]),
        stop=StopRule() if max_time is None else StopRule(max_time_s=max_time),
        seed=given["seed"],
    )


def _team(given: dict[str, Any]) -> tuple[RobotSpec, ...]:
    places = [_start(text, "--start") for text in given["start"]]
    differing = [_overrides(text) for text in given["robot"]]
    count = given["robots"]
    if count is None:
        count = max(1, len(places), len(differing))
    if count < 1:
        raise InvalidInputError(f"a team has at least one robot, not {count}")
    if places and len(places) != count:
        raise InvalidInputError(
            f"{len(places)} starts for {count} robots: give --start for each of them, or for none"
        )
    if len(differing) > count:
        raise InvalidInputError(f"--robot is given {len(differing)} times for {count} robots")
    usual = {
        "footprint": given["footprint"],
        "range": given["range_m"],
        "beams": given["beams"],
        "drive": given["drive"],
        "speed": given["speed"],
        "turning-radius": given["turning_radius"],
    }
    return tuple(
        _robot(
            usual
            | {"start": places[number] if places else None}
            | (differing[number] if number < len(differing) else {})
        )
        for number in range(count)
    )


def _robot(said: dict[str, Any]) -> RobotSpec:
    import msgspec

    from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec

    drive = {
        "kind": said["drive"],
        "speed_m_s": said["speed"],
        "turning_radius_m": said["turning-radius"],
    }
    eyes = {"range_m": said["range"], "beams": said["beams"]}
    try:
        return RobotSpec(
            start=said["start"],
            footprint=said["footprint"],
            drive=msgspec.convert({k: v for k, v in drive.items() if v is not None}, DriveSpec),
            range_finder=msgspec.convert(eyes, RangeFinderSpec),
        )
    except msgspec.ValidationError as error:
        # The message of our own check, without the path that msgspec puts behind it.
        raise InvalidInputError(str(error).partition(" - at `")[0]) from None


def _overrides(text: str) -> dict[str, Any]:
    # Commas stand between what is said, and within a start or a footprint.
    said: dict[str, Any] = {}
    for part in re.split(r",\s*(?=[a-z-]+=)", text):
        key, value = _key_and_value(part, "--robot")
        if key not in OVERRIDES:
            raise click.BadParameter(
                f"{key!r} is none of {', '.join(OVERRIDES)}", param_hint="--robot"
            )
        if key in ("range", "speed", "turning-radius"):
            said[key] = _number(value, float, "--robot")
        elif key == "beams":
            said[key] = _number(value, int, "--robot")
        elif key == "drive" and value not in DRIVES:
            raise InvalidInputError(
                f"--robot: there is no drive {value!r}; there are: {', '.join(DRIVES)}"
            )
        else:
            said[key] = _start(value, "--robot") if key == "start" else value
    return said


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


def _start(text: str, option: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) in (2, 3):
        return numbers
    raise click.BadParameter(f"{text!r} is not X,Y or X,Y,HEADING", param_hint=option)


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
