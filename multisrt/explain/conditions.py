"""What a run was made with, and which robots died in it, in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from multisrt.events import Died
from multisrt.explain.words import listed
from multisrt.recording import Recording
from multisrt.spec import Fault, LateStart, RadioSpec, RobotSpec, RunSpec, Silence, StopRule


def conditions(spec: RunSpec, *, repeated: bool = False) -> list[str]:
    """Return what a run was made with, besides its strategy, world and seed, in words.

    Parameters
    ----------
    spec : RunSpec
        The spec of the run.
    repeated : bool
        Leave out what may differ among repetitions of a run: the faults, and where the base
        station is.

    Returns
    -------
    list of str
        Phrases: the team, its radio, range finders, bodies and drives, options of the strategy,
        faults, and limits of the time that are not the defaults.

    Examples
    --------
    >>> import multisrt as ms
    >>> conditions(ms.RunSpec(environment=ms.CatalogEnvironment(name="open")))
    ['1 robot', 'range finder 4 m', 'body disc:0.25', 'differential drive, 0.5 m/s']
    """
    robots = spec.robots
    count = len(robots)
    at_base = spec.starts == "base"
    starts = "starts at the base" if at_base else f"{spec.starts} starts"
    phrases = ["1 robot", *[starts] * at_base]
    if count > 1:
        phrases = [f"{count} robots", starts, _radio(spec.radio)]
    if spec.base is not None:
        x, y = spec.base.place
        phrases += [] if count > 1 else [_radio(spec.radio)]
        phrases.append("base station" if repeated else f"base station at ({x:g}, {y:g})")
    phrases += [
        _of_all(robots, _range_finder),
        _of_all(robots, lambda robot: f"body {robot.footprint}"),
        _of_all(robots, _drive),
    ]
    phrases += [f"{name} = {_value(value)}" for name, value in spec.options.items()]
    if not repeated:
        phrases += map(_fault, sorted(spec.faults, key=lambda fault: (fault.time_s, fault.robot)))
    if spec.stop.max_time_s != StopRule().max_time_s:
        phrases.append(f"at most {spec.stop.max_time_s:g} s")
    return phrases


def deaths(recording: Recording) -> list[str]:
    """Return which robots died and when, in words."""
    return [f"robot {e.robot} died at {e.time_s:.1f} s" for e in recording.of(Died)]


def _radio(radio: RadioSpec) -> str:
    parts = ["radio unlimited" if radio.range_m is None else f"radio {radio.range_m:g} m"]
    if radio.walls_matter:
        parts.append(f"walls {radio.walls}" + (" it" if radio.walls == "block" else " its signal"))
    if not radio.multi_hop:
        parts.append("no relays")
    for name, value in (("latency", radio.latency_s), ("jitter", radio.jitter_s)):
        if value:
            parts.append(f"{name} {value:g} s")
    if radio.loss:
        parts.append(f"loss {100.0 * radio.loss:g} %")
    return ", ".join(parts)


def _range_finder(robot: RobotSpec) -> str:
    finder = robot.range_finder
    beams = "" if finder.beams is None else f", {finder.beams} beams"
    return f"range finder {finder.range_m:g} m{beams}"


def _drive(robot: RobotSpec) -> str:
    drive = robot.drive
    turning = f", turning radius {drive.turning_radius_m:g} m" if drive.is_car else ""
    return f"{drive.kind} drive, {drive.speed_m_s:g} m/s{turning}"


def _of_all(robots: Sequence[RobotSpec], words: Callable[[RobotSpec], str]) -> str:
    # What all robots have in common, or which robots have what.
    by_words: dict[str, list[int]] = {}
    for number, robot in enumerate(robots):
        by_words.setdefault(words(robot), []).append(number)
    if len(by_words) == 1:
        return next(iter(by_words))
    return "; ".join(
        f"{said} (robot{'s' if len(own) > 1 else ''} {listed(own)})"
        for said, own in by_words.items()
    )


def _value(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _fault(fault: Fault) -> str:
    who, when = f"robot {fault.robot}", f"{fault.time_s:g} s"
    if isinstance(fault, LateStart):
        return f"{who} starts at {when}"
    if isinstance(fault, Silence):
        return f"the radio of {who} fails at {when} for {fault.duration_s:g} s"
    doing = {"moving": " while it moves", "waiting": " while it waits", "master": " as a master"}
    return f"{who} dies at {when}{doing.get(fault.when, '')}"
