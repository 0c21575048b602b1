"""Setting up a run: from its spec to the world, the robots' explorers and the random streams."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.recording import Header, header_of
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.homing.just_in_time import LimitTooShortError
from multisrt.robots.registry import strategy
from multisrt.robots.robot_self import BaseSelf
from multisrt.robots.strategy import Strategy
from multisrt.simulation import protocol
from multisrt.simulation.base_station import require_free
from multisrt.simulation.faults import late_starts
from multisrt.simulation.radio import Radio
from multisrt.simulation.random_streams import RandomStreams
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import build_environment, require_recorded, with_record
from multisrt.spec import RunSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class SetUp:
    """A run that is ready to begin.

    Attributes
    ----------
    spec : RunSpec
        The spec in its canonical form.
    environment : Environment
        The world.
    starts : tuple of Configuration
        Where the robots start.
    explorers : tuple of Explorer
        What decides for each robot.
    header : Header
        The first line of the recording.
    index : EdgeIndex
        The edges of the world.
    obstacles : CollisionWorld
        The same as solids.
    radio : Radio
        The radio.
    base : BaseSelf or None
        What the base station knows of itself, if there is one.
    streams : RandomStreams
        Where random numbers come from.
    """

    spec: RunSpec
    environment: Environment
    starts: tuple[Configuration, ...]
    explorers: tuple[Explorer, ...]
    header: Header
    index: EdgeIndex
    obstacles: CollisionWorld
    radio: Radio
    base: BaseSelf | None
    streams: RandomStreams


def set_up(
    spec: RunSpec,
    environment: Environment | None = None,
    *,
    planning: Callable[[float], None] | None = None,
) -> SetUp:
    """Return a run that is ready to begin.

    Parameters
    ----------
    spec, environment, planning
        As for `multisrt.simulate`.

    Raises
    ------
    InvalidInputError
        If the spec cannot be run (the world, its digest or starts, a start, the place of the base
        station, the strategy or its options).
    """
    # Equal specs give equal runs, also where one has whole numbers and the other has fractions.
    spec = spec.canonical()
    chosen = strategy(spec.strategy)
    options = chosen.parse_options(spec.options)
    chosen.require_fit(spec)
    if environment is None:
        environment = build_environment(spec.environment)
    else:
        require_recorded(spec.environment, environment)
    # A check of the file, on which the run does not depend: its recording is that without it.
    spec = with_record(spec, None, None)
    streams = RandomStreams(spec.seed)
    starts = starts_of(spec, environment, streams)
    team_range_m = max(robot.range_finder.range_m for robot in spec.robots)
    index = EdgeIndex(environment.edges, team_range_m / 3.0)
    radio = Radio(spec.radio, index, streams.of("radio"))
    joins = late_starts(spec.faults)
    base = None
    if spec.base is not None:
        require_free(spec.base, environment)
        base = BaseSelf(team=len(spec.robots), base=spec.base.place, radio=radio.datasheet())
    orders: Sequence[object] = [None] * len(spec.robots)
    if chosen.plan is not None:
        orders = chosen.plan(spec, environment, starts, planning)
    selves = [
        RobotSelf(
            robot=number,
            start=start,
            footprint=Footprint.parse(robot.footprint),
            kinematics=robot.drive.kinematics(),
            range_m=robot.range_finder.range_m,
            rng=streams.of("robots", number),
            team=len(spec.robots),
            radio=radio.datasheet(),
            base=None if base is None else base.base,
            time_s=joins.get(number, 0.0),
            limit_s=spec.stop.max_time_s,
            team_range_m=team_range_m,
            orders=orders[number],
        )
        for number, (robot, start) in enumerate(zip(spec.robots, starts, strict=True))
    ]
    explorers = _all_built(chosen, selves, options)
    return SetUp(
        spec=spec,
        environment=environment,
        starts=starts,
        explorers=explorers,
        header=header_of(spec, environment, starts),
        index=index,
        obstacles=_obstacles(environment),
        radio=radio,
        base=base,
        streams=streams,
    )


def _all_built(
    strategy: Strategy, selves: Sequence[RobotSelf], options: object
) -> tuple[Explorer, ...]:
    explorers: list[Explorer] = []
    too_short: list[LimitTooShortError] = []
    for me in selves:
        try:
            explorers.append(_built(strategy, me, options))
        except LimitTooShortError as error:
            too_short.append(error)
    if too_short:  # the limit that is named is enough for all robots
        raise max(too_short, key=lambda error: error.needed_s)
    return tuple(explorers)


def _built(strategy: Strategy, me: RobotSelf, options: object) -> Explorer:
    try:
        return protocol.build(strategy.explorer, me, options)
    except ExplorerDefect as defect:
        raise defect.in_run(strategy.name, me.time_s) from defect.__cause__


@lru_cache(maxsize=8)
def _obstacles(environment: Environment) -> CollisionWorld:
    # Solids are built once for many runs in one world.
    return CollisionWorld(environment.free)
