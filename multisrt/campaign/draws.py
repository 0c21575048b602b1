"""Missions of a campaign: specs of runs, all parts of which are drawn.

Mission `number` of a seed is the same in every campaign, however many missions it has. A draw that
the program refuses as impossible (a body that does not fit, a radio that is too short for the
strategy) is drawn again: from the streams of the next attempt.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Final, NamedTuple, get_args

from multisrt.campaign.chance import Chance
from multisrt.campaign.options import draw_options
from multisrt.campaign.teams import draw_base, draw_faults, draw_radio, draw_robots
from multisrt.campaign.worlds import POOL, world, world_of
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.home_options import Home
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.registry import is_built_in, strategies, strategy
from multisrt.simulation.setting_up import SetUp, set_up
from multisrt.spec import BaseSpec, PlacedHow, RadioSpec, RunSpec, Scalar, StopRule
from multisrt.spec.environments import EnvironmentSpec

STREAM: Final = 1
"""Key of the random streams of missions, after the seed of the campaign."""

MAX_ATTEMPTS: Final = 200
"""Number of draws of one mission after which drawing it is an error."""

AMPLE_S: Final = 6000.0
"""Time limit of a run times its number of robots, in seconds, if it is to end by itself."""

MAX_AMPLE_VIEWS: Final = 25.0
"""Bound of robots times area, in squares of the shortest range, of runs that are to end by
themselves. Teams with cars never are: their motions take longer to compute than all else."""

BALL_M: Final = 1.5
"""Reach in metres of balls, which end at the nearest wall, for `MAX_AMPLE_VIEWS`."""

WORK_S: Final = 200.0
"""Upper bound of time limit times number of robots in the other runs, mostly."""

MAX_PLANNED_VIEWS: Final = 25.0
"""Bound of robots times area, in squares of the shortest range, for strategies that plan on the
true map: their plans take longer than all else."""

HOMES: Final = get_args(Home)

STARTS: Final[dict[PlacedHow, float]] = {
    "clustered": 0.4,
    "scattered": 0.35,
    "random": 0.2,
    "suggested": 0.05,
}
"""How teams are placed, with weights."""

AT_BASE: Final[dict[PlacedHow, float]] = {"base": 0.4}
"""The same, if there is a base station."""


OnDraw = Callable[[RunSpec | None, int], None]
"""Is told a run that is set up next, None if it is drawn next, and the number of draws before."""


class Drawn(NamedTuple):
    """A mission as it is drawn.

    Attributes
    ----------
    spec : RunSpec
        The run.
    environment : Environment
        Its world.
    setup : SetUp or None
        The run, ready to begin; None if setting it up failed with an error of the program.
    refused : int
        Number of draws before this one that the program refused as impossible.
    """

    spec: RunSpec
    environment: Environment
    setup: SetUp | None
    refused: int


def draw(seed: int, number: int) -> RunSpec:
    """Return a mission of a campaign.

    Parameters
    ----------
    seed : int
        Seed of the campaign, 0 or positive.
    number : int
        Number of the mission, from 0.

    Returns
    -------
    RunSpec
        The run; the program takes it as possible, unless it fails in setting it up.

    Examples
    --------
    >>> draw(1, 5) == draw(1, 5)
    True
    """
    return drawn(seed, number).spec


def drawn(seed: int, number: int, on_draw: OnDraw | None = None) -> Drawn:
    """Return a mission of a campaign with its world; see `draw`.

    Parameters
    ----------
    seed, number : int
        As for `draw`.
    on_draw : callable, optional
        Called before every draw, and again with the run before it is set up: so it is known what
        takes a process down.

    Returns
    -------
    Drawn
        The mission.

    Raises
    ------
    RuntimeError
        If no draw of many is possible.
    """
    for refused in range(MAX_ATTEMPTS):
        if on_draw is not None:
            on_draw(None, refused)
        try:
            spec = candidate(seed, number, refused)
            environment = world_of(spec.environment)
        except InvalidInputError:
            continue
        if on_draw is not None:
            on_draw(spec, refused)
        try:
            return Drawn(spec, environment, set_up(spec, environment), refused)
        except Exception as error:  # whatever else it is, running the spec raises it again
            if is_refusal(error):
                continue
            return Drawn(spec, environment, None, refused)
    raise RuntimeError(f"no draw of mission {number} of seed {seed} is possible")


def is_refusal(error: BaseException) -> bool:
    """Whether an error in setting up a run says that the run is impossible, and is no defect."""
    return isinstance(error, InvalidInputError) and not isinstance(error, ExplorerDefect)


def candidate(seed: int, number: int, attempt: int) -> RunSpec:
    """Return a draw of a mission, which may be impossible.

    All attempts have the strategy of the first: those that refuse more are drawn as often.

    Parameters
    ----------
    seed, number : int
        As for `draw`.
    attempt : int
        Number of draws before.

    Returns
    -------
    RunSpec
        The run.

    Raises
    ------
    InvalidInputError
        If the world cannot be built, or a part of the spec is impossible.
    """
    names = _strategy_names()
    name = names[Chance(seed, STREAM, number).whole(0, len(names) - 1)]
    chance = Chance(seed, STREAM, number, attempt)
    where = _pool_world(seed, chance.whole(0, POOL - 1))
    environment = world_of(where)
    robots = draw_robots(chance, environment)
    reach_m = min(robot.range_finder.range_m for robot in robots)
    if name == "srt-ball":
        reach_m = min(reach_m, BALL_M)
    views = len(robots) * environment.area_m2 / reach_m**2
    if strategy(name).sees_truth and views > MAX_PLANNED_VIEWS:
        raise InvalidInputError("a plan for so many robots in such a world takes too long")
    radio = draw_radio(chance, robots)
    base = draw_base(chance, environment)
    has_cars = any(robot.drive.is_car for robot in robots)
    ends = not has_cars and views <= MAX_AMPLE_VIEWS and chance.happens(0.7)
    max_time_s = _time_limit_s(chance, len(robots), ends=ends)
    spec = RunSpec(
        environment=where,
        strategy=name,
        options=draw_options(strategy(name), chance, _tasks(chance, len(robots), radio, base)),
        robots=robots,
        starts=chance.weighted(STARTS | (AT_BASE if base is not None else {})),
        radio=radio,
        base=base,
        faults=draw_faults(chance, len(robots), max_time_s),
        stop=StopRule(
            max_time_s=max_time_s,
            max_idle_s=chance.magnitude(20.0, 600.0) if chance.happens(0.15) else 3600.0,
        ),
        seed=chance.whole(0, 2**31 - 1),
    )
    return spec.canonical()


def _time_limit_s(chance: Chance, team: int, *, ends: bool) -> float:
    """Return the time limit of a run: ample if it is to end by itself, else any."""
    if ends:
        return round(AMPLE_S / team, 1)
    limit_s = chance.magnitude(25.0, 1200.0 if chance.happens(0.9) else 3000.0)
    if chance.happens(0.05):
        return limit_s
    return max(10.0, round(min(limit_s, WORK_S / team), 1))


def _tasks(chance: Chance, team: int, radio: RadioSpec, base: BaseSpec | None) -> dict[str, Scalar]:
    """Return options that say what robots are to do, which would be drawn too seldom otherwise."""
    tasks: dict[str, Scalar] = {"effort": chance.magnitude(1e-4, 5e-3)}
    if base is not None and chance.happens(0.7):
        tasks["home"] = chance.one_of(HOMES)
    if team > 1 and not radio.reaches_everywhere and chance.happens(0.25):
        tasks["pursue"] = True
    return tasks


@cache
def _strategy_names() -> tuple[str, ...]:
    return tuple(each.name for each in strategies() if is_built_in(each.name))


@lru_cache(maxsize=2 * POOL)
def _pool_world(seed: int, number: int) -> EnvironmentSpec:
    return world(seed, number)
