"""Teams of a campaign, and what surrounds them: radios, base stations, faults."""

from __future__ import annotations

import math
from typing import Final, Literal

import shapely

from multisrt.campaign.chance import Chance
from multisrt.campaign.lasers import MAX_BEAMS, SPACINGS_M, are_found
from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.regions.beams import MIN_BEAMS
from multisrt.spec import (
    BaseSpec,
    Death,
    DriveSpec,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    Silence,
)
from multisrt.spec.faults import Fault

Walls = Literal["pass", "block", "weaken"]

TEAMS: Final = {1: 20, 2: 26, 3: 20, 4: 14, 5: 6, 6: 5, 7: 2, 8: 3, 9: 1, 10: 1, 11: 1, 12: 1}
"""Numbers of robots, with weights."""

BODIES: Final = {"disc": 0.5, "box": 0.25, "triangle": 0.1, "polygon": 0.1, "u": 0.05}
"""Kinds of bodies, with weights."""

DRIVES: Final = {"differential": 0.5, "holonomic": 0.28, "reeds-shepp": 0.13, "dubins": 0.09}
"""Kinds of drives, with weights."""

PLACE_TRIES: Final = 30
"""Points that are drawn to find one in free space."""


def draw_robots(chance: Chance, environment: Environment) -> tuple[RobotSpec, ...]:
    """Return a team: all alike, of two kinds, or each of a kind of its own.

    Parameters
    ----------
    chance : Chance
        Where random choices come from.
    environment : Environment
        The world, in which some teams have given starts.

    Returns
    -------
    tuple of RobotSpec
        The robots.

    Examples
    --------
    >>> from multisrt.environments.catalog import environment
    >>> 1 <= len(draw_robots(Chance(1), environment("open"))) <= 12
    True
    """
    team = chance.weighted(TEAMS)
    kinds = {"alike": 1, "two": 2, "mixed": team}[
        chance.weighted({"alike": 0.5, "two": 0.2, "mixed": 0.3})
    ]
    made = [_robot(chance, environment) for _ in range(kinds)]
    robots = [made[i % kinds] for i in range(team)]
    if chance.happens(0.12):
        share = chance.one_of((0.5, 1.0))
        robots = [
            _started(robot, chance, environment) if chance.happens(share) else robot
            for robot in robots
        ]
    return tuple(robots)


def _robot(chance: Chance, environment: Environment) -> RobotSpec:
    footprint, drive = _footprint(chance), _drive(chance)
    range_finder = _range_finder(chance, environment)
    if range_finder.free_reach_m <= Footprint.parse(footprint).circumscribed_radius_m:
        range_finder = RangeFinderSpec(range_m=range_finder.range_m)  # too few beams for this body
    return RobotSpec(footprint=footprint, drive=drive, range_finder=range_finder)


def _started(robot: RobotSpec, chance: Chance, environment: Environment) -> RobotSpec:
    place = _place(chance, environment)
    start = (*place, chance.number(-math.pi, math.pi)) if chance.happens(0.7) else place
    return RobotSpec(
        start=start,
        footprint=robot.footprint,
        drive=robot.drive,
        range_finder=robot.range_finder,
    )


def _footprint(chance: Chance) -> str:
    size_m = chance.number(0.1, 0.35)
    match chance.weighted(BODIES):
        case "disc":
            return f"disc:{size_m:g}"
        case "box":
            return f"box:{2 * size_m:g}x{chance.number(0.1, 0.6):g}"
        case "triangle":
            half_m, nose_m = chance.number(0.05, 0.25), chance.number(0.05, 0.45)
            corners = [(-size_m, -half_m), (nose_m, 0.0), (-size_m, half_m)]
        case "polygon":
            number, turn = chance.whole(4, 8), chance.number(0.0, math.pi)
            angles = [turn + math.tau * i / number for i in range(number)]
            corners = [(size_m * math.cos(a), 0.8 * size_m * math.sin(a)) for a in angles]
        case _:
            a, b = size_m, size_m * chance.number(0.3, 0.7)
            corners = [(-a, -a), (a, -a), (a, a), (b, a), (b, -b), (-b, -b), (-b, a), (-a, a)]
            # The reference point lies in the middle of the bar that joins the arms.
            corners = [(x, y + 0.5 * (a + b)) for x, y in corners]
    return "polygon:" + " ".join(f"{x:.3f},{y:.3f}" for x, y in corners)


def _drive(chance: Chance) -> DriveSpec:
    speed_m_s = chance.magnitude(0.2, 1.6)
    match chance.weighted(DRIVES):
        case "differential":
            return DriveSpec(speed_m_s=speed_m_s, turn_rate_rad_s=chance.magnitude(0.3, 5.0))
        case "holonomic":
            return DriveSpec(kind="holonomic", speed_m_s=speed_m_s)
        case "reeds-shepp":
            radius_m = chance.magnitude(0.15, 1.2)
            return DriveSpec(kind="reeds-shepp", speed_m_s=speed_m_s, turning_radius_m=radius_m)
    radius_m = chance.magnitude(0.15, 1.2)
    return DriveSpec(kind="dubins", speed_m_s=speed_m_s, turning_radius_m=radius_m)


def _range_finder(chance: Chance, environment: Environment) -> RangeFinderSpec:
    range_m = chance.magnitude(0.8, 8.0)
    spacing_m = chance.one_of(SPACINGS_M)
    if chance.happens(0.5) and are_found(environment, spacing_m):
        beams = max(MIN_BEAMS, math.ceil(math.tau * range_m / spacing_m))
        if beams <= MAX_BEAMS:
            return RangeFinderSpec(range_m=range_m, beams=beams)
    return RangeFinderSpec(range_m=range_m)


def draw_radio(chance: Chance, robots: tuple[RobotSpec, ...]) -> RadioSpec:
    """Return a radio: of any range or none, with walls, loss, latency and jitter or without.

    Examples
    --------
    >>> draw_radio(Chance(3), (RobotSpec(),)) == draw_radio(Chance(3), (RobotSpec(),))
    True
    """
    seen_m = max(robot.range_finder.range_m for robot in robots)
    match chance.weighted({"everywhere": 0.35, "none": 0.03, "any": 0.22, "far": 0.4}):
        case "everywhere":
            range_m = None
        case "none":
            range_m = 0.0
        case "any":
            range_m = chance.magnitude(1.0, 15.0)
        case _:
            # Robots that may meet have to hear one another before.
            range_m = 3.0 * seen_m * chance.number(1.0, 2.5)
    weights: dict[Walls, float] = {"pass": 0.4, "block": 0.4, "weaken": 0.2 if range_m else 0.0}
    walls = chance.weighted(weights)
    return RadioSpec(
        range_m=range_m,
        multi_hop=chance.happens(0.7),
        walls=walls,
        latency_s=chance.magnitude(0.01, 3.0) if chance.happens(0.35) else 0.0,
        jitter_s=chance.magnitude(0.01, 2.0) if chance.happens(0.35) else 0.0,
        loss=chance.number(0.0, 0.9 if chance.happens(0.1) else 0.5)
        if chance.happens(0.4)
        else 0.0,
        path_loss_exponent=chance.number(1.0, 6.0) if walls == "weaken" else 2.0,
        wall_loss_db=chance.number(0.0, 20.0) if walls == "weaken" else 5.0,
    )


def draw_base(chance: Chance, environment: Environment) -> BaseSpec | None:
    """Return a base station somewhere in a world, or none.

    Examples
    --------
    >>> from multisrt.environments.catalog import environment
    >>> base = draw_base(Chance(1), environment("open", size_m=8))
    >>> base is None or 0.0 <= base.x <= 8.0
    True
    """
    if not chance.happens(0.35):
        return None
    x, y = _place(chance, environment)
    return BaseSpec(x=x, y=y)


def draw_faults(chance: Chance, team: int, max_time_s: float) -> tuple[Fault, ...]:
    """Return what goes wrong: nothing, one thing, or several, some of them at once.

    Parameters
    ----------
    chance : Chance
        Where random choices come from.
    team : int
        Number of robots.
    max_time_s : float
        Time limit of the run, in seconds.

    Examples
    --------
    >>> all(fault.time_s < 60.0 for fault in draw_faults(Chance(2), 3, 60.0))
    True
    """
    if not chance.happens(0.5):
        return ()
    at_once_s = _moment(chance, max_time_s) if chance.happens(0.25) else None
    faults: list[Fault] = []
    for robot in range(team):
        if not chance.happens(0.5):
            continue
        time_s = _moment(chance, max_time_s) if at_once_s is None else at_once_s
        late = chance.happens(0.2)
        if late:
            faults.append(LateStart(robot=robot, time_s=time_s))
        for _ in range(chance.weighted({0: 0.6, 1: 0.3, 2: 0.1})):
            duration_s = chance.magnitude(0.5, 100.0 if chance.happens(0.8) else 1000.0)
            begin_s = _moment(chance, max_time_s) if at_once_s is None else at_once_s
            faults.append(Silence(robot=robot, time_s=begin_s, duration_s=duration_s))
        if chance.happens(0.4):
            dies_s = _moment(chance, max_time_s) if at_once_s is None else at_once_s
            faults.append(Death(robot=robot, time_s=dies_s, when=_doing(chance)))
    return tuple(faults)


def _doing(chance: Chance) -> Literal["any", "moving", "waiting", "master"]:
    weights: dict[Literal["any", "moving", "waiting", "master"], float] = {
        "any": 0.3,
        "moving": 0.3,
        "waiting": 0.25,
        "master": 0.15,
    }
    return chance.weighted(weights)


def _moment(chance: Chance, max_time_s: float) -> float:
    if chance.happens(0.1):
        return 0.0
    latest_s = math.floor(900.0 * max_time_s) / 1000.0
    if chance.happens(0.2):
        return chance.number(0.0, latest_s)
    return min(chance.magnitude(0.5, 120.0), latest_s)


def _place(chance: Chance, environment: Environment) -> tuple[float, float]:
    # With more digits than other numbers: far from the origin three are too few.
    x0, y0, x1, y1 = environment.bounds
    x, y = x0, y0
    for _ in range(PLACE_TRIES):
        x = round(x0 + (x1 - x0) * chance.number(0.0, 1.0), 3)
        y = round(y0 + (y1 - y0) * chance.number(0.0, 1.0), 3)
        if shapely.contains_xy(environment.free, x, y):
            break
    return x, y
