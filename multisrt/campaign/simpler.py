"""Simpler variants of a spec: fewer robots, faults and options, a smaller world, a shorter time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import Any, Final, TypeVar

import msgspec
import shapely
from shapely import affinity

from multisrt.environments.catalog import default_parameters
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import (
    CatalogEnvironment,
    DriveSpec,
    InlineEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)
from multisrt.spec.environments import EnvironmentSpec
from multisrt.spec.faults import Fault

Item = TypeVar("Item")

HALLS_M: Final = (5.0, 8.0, 12.0, 16.0)
"""Widths of the empty halls that are tried in place of a world, in metres."""

MIN_PARAMETER: Final = 0.5
"""Smallest value of a parameter of a world that is tried in place of a larger one."""

MIN_TIME_S: Final = 1.0
"""Shortest time limit that is tried, in seconds."""


def simplifications(spec: RunSpec, time_s: float | None = None) -> Iterator[RunSpec]:
    """Yield specs that are simpler than one, those that leave out most of each kind first.

    Specs that are impossible are left out where that is seen at once.

    Parameters
    ----------
    spec : RunSpec
        The run.
    time_s : float, optional
        When something happened, after which the run need not go on, in seconds.

    Yields
    ------
    RunSpec
        A run that differs in one thing.

    Examples
    --------
    >>> spec = RunSpec(environment=CatalogEnvironment(name="open"), options={"alpha": 0.5}, seed=4)
    >>> [simpler.seed for simpler in simplifications(spec) if not simpler.options]
    [4]
    """
    kinds = (_teams, _worlds, _faults, _bases, _radios, _options, _robots, _rest)
    for changed in chain(_times(spec, time_s), *(kind(spec) for kind in kinds)):
        try:
            simpler = changed()
        except InvalidInputError:
            continue
        if simpler != spec:
            yield simpler


Change = Callable[[], RunSpec]
"""Returns a changed spec; raises InvalidInputError if that is impossible."""


def _with(spec: RunSpec, **changes: Any) -> Change:
    return lambda: msgspec.structs.replace(spec, **changes)


def subsets(items: Sequence[Item]) -> Iterator[tuple[Item, ...]]:
    """Yield subsets of items: none, each half, each quarter and its complement, ..., all but one.

    Examples
    --------
    >>> list(subsets("ab"))
    [(), ('a',), ('b',)]
    """
    items = tuple(items)
    if not items:
        return
    yield ()
    seen: set[tuple[int, ...]] = {()}
    size = len(items) // 2
    while size >= 1:
        for begin in range(0, len(items), size):
            inside = tuple(range(begin, min(begin + size, len(items))))
            outside = tuple(i for i in range(len(items)) if i not in inside)
            for left in (inside, outside) if size > 1 or len(items) <= 3 else (outside,):
                if left not in seen and len(left) < len(items):
                    seen.add(left)
                    yield tuple(items[i] for i in left)
        size //= 2


# Time and team ------------------------------------------------------------------------------


def _times(spec: RunSpec, time_s: float | None) -> Iterator[Change]:
    limit_s = spec.stop.max_time_s
    wanted = [float(f"{share * limit_s:.3g}") for share in (0.5, 0.8)]
    if time_s is not None:
        wanted.insert(0, math.ceil(time_s + 1.0))
    for shorter_s in wanted:
        shorter_s = max(MIN_TIME_S, shorter_s)
        if shorter_s < limit_s:
            stop = StopRule(max_time_s=shorter_s, max_idle_s=spec.stop.max_idle_s)
            faults = tuple(fault for fault in spec.faults if fault.time_s < shorter_s)
            yield _with(spec, stop=stop, faults=faults)


def _teams(spec: RunSpec) -> Iterator[Change]:
    for kept in subsets(range(len(spec.robots))):
        if kept:
            yield _with(spec, **_team_of(spec, kept))


def _team_of(spec: RunSpec, kept: Sequence[int]) -> dict[str, Any]:
    number = {robot: new for new, robot in enumerate(kept)}
    faults: list[Fault] = [
        msgspec.structs.replace(fault, robot=number[fault.robot])
        for fault in spec.faults
        if fault.robot in number
    ]
    return {"robots": tuple(spec.robots[robot] for robot in kept), "faults": tuple(faults)}


# World --------------------------------------------------------------------------------------


def _worlds(spec: RunSpec) -> Iterator[Change]:
    for world in _simpler_worlds(spec.environment):
        yield _with(spec, environment=world)


def _simpler_worlds(world: EnvironmentSpec) -> Iterator[EnvironmentSpec]:
    is_hall = isinstance(world, CatalogEnvironment) and world.name == "open"
    if not is_hall:
        for side_m in HALLS_M:
            yield CatalogEnvironment(name="open", parameters={"size_m": side_m})
    if isinstance(world, CatalogEnvironment):
        yield from _simpler_parameters(world)
    elif isinstance(world, InlineEnvironment):
        yield from _simpler_shapes(world)


def _simpler_parameters(world: CatalogEnvironment) -> Iterator[CatalogEnvironment]:
    replace = msgspec.structs.replace
    defaults = dict(default_parameters(world.name))
    for name, value in world.parameters.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or name not in defaults:
            continue
        for smaller in (value / 2, 0.8 * value):
            shown = int(smaller) if isinstance(value, int) else float(f"{smaller:.2g}")
            if shown != value and shown >= MIN_PARAMETER:
                yield replace(world, parameters=world.parameters | {name: shown})
    for name in world.parameters:
        left = {other: value for other, value in world.parameters.items() if other != name}
        if not name.endswith("_m") or defaults.get(name, 0.0) < 10.0:
            yield replace(world, parameters=left)
    if world.seed:
        yield replace(world, seed=None)


def _simpler_shapes(world: InlineEnvironment) -> Iterator[InlineEnvironment]:
    free = shapely.from_wkt(world.wkt)
    x0, y0, x1, y1 = free.bounds
    shapes = [shapely.box(x0, y0, x1, y1), free.convex_hull, free.buffer(0.5).buffer(-0.5)]
    if isinstance(free, shapely.Polygon):
        holes = list(free.interiors)
        shapes += [shapely.Polygon(free.exterior, left) for left in subsets(holes)]
    for step_m in (1.0, 0.3, 0.1, 0.03):
        shapes.append(free.simplify(step_m))
        shapes.append(shapely.set_precision(free, step_m))
    if (x0, y0) != (0.0, 0.0):
        shapes.append(affinity.translate(free, -x0, -y0))
    for shape in shapes:
        parts = [part for part in shapely.get_parts(shape) if isinstance(part, shapely.Polygon)]
        if parts:
            wkt = shapely.to_wkt(max(parts, key=lambda part: part.area), rounding_precision=-1)
            if len(wkt) <= len(world.wkt) and wkt != world.wkt:
                yield InlineEnvironment(name=world.name, wkt=wkt)


# All else -----------------------------------------------------------------------------------


def _faults(spec: RunSpec) -> Iterator[Change]:
    for left in subsets(spec.faults):
        yield _with(spec, faults=left)


def _bases(spec: RunSpec) -> Iterator[Change]:
    if spec.base is not None:
        options = {name: v for name, v in spec.options.items() if name != "home"}
        starts = "clustered" if spec.starts == "base" else spec.starts
        yield _with(spec, base=None, starts=starts)
        yield _with(spec, base=None, starts=starts, options=options)


def _radios(spec: RunSpec) -> Iterator[Change]:
    yield _with(spec, radio=RadioSpec())
    usual = RadioSpec()
    for name in RadioSpec.__struct_fields__:
        default = getattr(usual, name)
        if getattr(spec.radio, name) != default:
            changes = {name: default}
            yield lambda changes=changes: msgspec.structs.replace(  # type: ignore[misc]
                spec, radio=msgspec.structs.replace(spec.radio, **changes)
            )


def _options(spec: RunSpec) -> Iterator[Change]:
    for left in subsets(list(spec.options)):
        yield _with(spec, options={name: spec.options[name] for name in left})


def _robots(spec: RunSpec) -> Iterator[Change]:
    usual = RobotSpec()
    first = spec.robots[0]
    yield _with(spec, robots=(usual,) * len(spec.robots))
    yield _with(spec, robots=(first,) * len(spec.robots))
    for name, values in _PLAIN.items():
        for value in values:
            yield _with(spec, robots=tuple(_plainer(r, name, value) for r in spec.robots))
    for number, robot in enumerate(spec.robots):
        for name, values in _PLAIN.items():
            for value in values:
                robots = list(spec.robots)
                robots[number] = _plainer(robot, name, value)
                yield _with(spec, robots=tuple(robots))


_PLAIN: Final[dict[str, tuple[Any, ...]]] = {
    "start": (None,),
    "footprint": (RobotSpec().footprint,),
    "drive": (DriveSpec(), DriveSpec(kind="holonomic")),
    "range_finder": (RangeFinderSpec(), RangeFinderSpec(range_m=2.0)),
}
"""Values of the fields of a robot, the plainest first."""


def _plainer(robot: RobotSpec, name: str, value: Any) -> RobotSpec:
    """Return a robot with another value of a field, unless the present one is at least as plain."""
    now, plain = getattr(robot, name), _PLAIN[name]
    if now in plain and plain.index(now) <= plain.index(value):
        return robot
    return msgspec.structs.replace(robot, **{name: value})


def _rest(spec: RunSpec) -> Iterator[Change]:
    yield _with(spec, stop=StopRule(max_time_s=spec.stop.max_time_s))
    if spec.starts != "clustered":
        yield _with(spec, starts="clustered")
    for seed in range(min(3, spec.seed)):
        yield _with(spec, seed=seed)
    for number, fault in enumerate(spec.faults):
        moment = float(f"{fault.time_s:.1g}")
        if moment != fault.time_s:
            faults = list(spec.faults)
            faults[number] = msgspec.structs.replace(fault, time_s=moment)
            yield _with(spec, faults=tuple(faults))
