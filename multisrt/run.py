"""Explore an environment from Python."""

from __future__ import annotations

import inspect
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, ParamSpec, TypedDict, TypeVar, Unpack, get_args

from multisrt.analysis.progress import Progress
from multisrt.environments.environment import Environment
from multisrt.finished_run import Run
from multisrt.geometry.errors import InvalidInputError, counted
from multisrt.robots.explorer import Explorer
from multisrt.robots.loading import name_of
from multisrt.robots.strategy import Strategy
from multisrt.simulation.journal import Watcher
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import build_environment, environment_spec, inline
from multisrt.spec import (
    BaseSpec,
    DriveSpec,
    EnvironmentSpec,
    Fault,
    PlacedHow,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Scalar,
    StopRule,
)
from multisrt.spec.keywords import (
    OF_MAP_FILES,
    base_of,
    checked,
    refuse_unknown,
    require_use,
    start_of,
)

INSTEAD = {"stop": "max_time_s=SECONDS"} | OF_MAP_FILES
"""Arguments of other functions that `explore` takes in a different form."""

_P = ParamSpec("_P")
_R = TypeVar("_R")

Starts = PlacedHow | Sequence[Sequence[float]]
"""Start configurations of a team: how they are drawn, or one for each robot."""


class RunKeywords(TypedDict, total=False):
    """The keywords that describe a run; see `explore`."""

    strategy: str | Strategy | Callable[..., Explorer] | None
    seed: int | None
    options: Mapping[str, Scalar] | None
    robots: int | Sequence[RobotSpec] | None
    start: Sequence[float] | None
    starts: Starts | None
    footprint: str | None
    range_m: float | None
    beams: int | None
    drive: DriveSpec | None
    radio_range_m: float | None
    radio: RadioSpec | None
    base: BaseSpec | Sequence[float] | None
    faults: Sequence[Fault] | None
    max_time_s: float | None


def with_run_keywords(
    function: Callable[_P, _R],
) -> Callable[_P, _R]:
    """Show all `RunKeywords` in the signature of a function that takes them.

    Parameters
    ----------
    function : callable
        Its last parameter is ``**keywords: Unpack[RunKeywords]``.

    Returns
    -------
    callable
        The same function.
    """
    signature = inspect.signature(function)
    *own, _ = signature.parameters.values()
    first = [each for each in own if each.kind is not each.KEYWORD_ONLY]
    run = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind.__forward_arg__
        )
        for name, kind in RunKeywords.__annotations__.items()
    ]
    shown = signature.replace(parameters=[*first, *run, *own[len(first) :]])
    function.__signature__ = shown  # type: ignore[attr-defined]
    return function


@with_run_keywords
def explore(
    environment: Environment | str | Path | RunSpec,
    *,
    recording_path: str | Path | None = None,
    watch: Watcher | None = None,
    progress: bool = False,
    **keywords: Unpack[RunKeywords],
) -> Run:
    """Explore an environment with one robot or a team.

    There are three forms. The short one describes a team of equal robots by keywords; the second
    takes `robots` as a sequence of `RobotSpec`, which may differ; the third takes a `RunSpec`,
    which describes the whole run. Omitted arguments have the defaults of the specs that they belong
    to: `RunSpec`, `RobotSpec`, `RangeFinderSpec`, `RadioSpec` or `StopRule`.

    Parameters
    ----------
    environment : Environment, str, Path or RunSpec
        The environment, its name in the catalogue, or a map file (for an image, whose pixels have
        no size in metres, use `read_environment`); or the spec of the run, in which case only
        `recording_path`, `watch` and `progress` may be given as well.
    strategy : str, Strategy, class or function, optional
        Name of a registered strategy, see `strategies`; or a user-defined strategy, as accepted by
        `Strategy.of` or as a reference (``"mine.py:Mine"``), which is registered and replaces a
        strategy of the same name.
    seed : int, optional
        Seed of all random streams of the run.
    options : mapping, optional
        Options of the strategy that differ from its defaults.
    robots : int or sequence of RobotSpec, optional
        Number of equal robots, or one spec for each robot. By default one robot, or one for each
        configuration in `starts`.
    start : (x, y) or (x, y, heading), optional
        Start configuration (m, rad) of a single robot.
    starts : {"scattered", "clustered", "random", "suggested", "base"} or sequence, optional
        How the start configurations of a team are drawn: far apart, close together, or each
        uniformly among the places with enough room for the body; or the suggested starts of the
        environment; or around the base station; or one configuration (m, rad) for each robot.
    footprint : str, optional
        Body of every robot, in the notation of `Footprint.parse`.
    range_m : float, optional
        Range of every range finder (m).
    beams : int, optional
        Number of beams of every range finder; by default range finders return the exact
        visibility polygon.
    drive : DriveSpec, optional
        Kinematics and speed of every robot.
    radio_range_m : float, optional
        Range of the radio (m); other properties have the defaults of `RadioSpec`.
    radio : RadioSpec, optional
        The complete description of the radio, instead of `radio_range_m`.
    base : (x, y) or BaseSpec, optional
        Base station (m), which robots reach by radio; measures report what has been delivered.
    faults : sequence of Death, Silence or LateStart, optional
        Faults of robots during the run.
    max_time_s : float, optional
        Simulated time (s) at which the run is stopped.
    recording_path : str or Path, optional
        File to which the recording is written during the run.
    watch : callable, optional
        Called with every event as it happens.
    progress : bool
        Whether to show the simulated time and the share of the area seen so far, on one line; only
        on a terminal or in a notebook.

    Returns
    -------
    Run
        The finished run. An exploration that stalls or runs out of time is a result, not an error.

    Raises
    ------
    InvalidInputError
        If the arguments contradict each other or describe an impossible run.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", strategy="srt-radial", seed=1)
    >>> run.outcome
    'complete'

    A team of equal robots, and one of two kinds:

    >>> team = ms.explore("open", robots=2, starts="clustered", radio_range_m=15.0)
    >>> len(team.recording.starts)
    2
    >>> mixed = ms.explore(
    ...     "open",
    ...     robots=[ms.RobotSpec(), ms.RobotSpec(footprint="box:0.6x0.4")],
    ... )
    >>> [robot.footprint for robot in mixed.spec.robots]
    ['disc:0.25', 'box:0.6x0.4']

    A team with a base station, and the share of the map that the base station finally knows:

    >>> run = ms.explore("open", robots=2, radio_range_m=15.0, base=(5.0, 5.0))
    >>> 0.0 < run.metrics.delivered_coverage <= run.metrics.coverage
    True

    A spec repeats the run exactly:

    >>> ms.explore(run.spec).digest == run.digest
    True
    """
    known = inspect.signature(explore).parameters
    refuse_unknown("explore", keywords, known, INSTEAD)
    spec, world = spec_and_world(environment, keywords)
    with Progress(quiet=not progress) as live:
        watch = live.watcher(spec, world, watch)
        return Run(simulate(spec, world, path=recording_path, watch=watch), world)


def spec_and_world(
    environment: Environment | str | Path | RunSpec, keywords: Mapping[str, Any]
) -> tuple[RunSpec, Environment]:
    """Return the spec and the world that the arguments of `explore` describe.

    Parameters
    ----------
    environment : Environment, str, Path or RunSpec
        As for `explore`.
    keywords : mapping
        The given `RunKeywords`; None stands for an omitted one.

    Raises
    ------
    InvalidInputError
        As `explore`.
    """
    given = {name: value for name, value in keywords.items() if value is not None}
    if isinstance(environment, RunSpec):
        if given:
            raise InvalidInputError(
                "a RunSpec describes the run: with it, give only recording_path, watch and "
                f"progress, and leave out {', '.join(given)}"
            )
        return environment, build_environment(environment.environment)
    if isinstance(environment, Environment):
        where: EnvironmentSpec = inline(environment)
    else:
        where = environment_spec(str(environment))
    # Also of a world that is there already: as the spec alone would build it again.
    world = build_environment(where)
    return _run_spec(where, given), world


def _run_spec(environment: EnvironmentSpec, given: Mapping[str, Any]) -> RunSpec:
    if "strategy" in given:
        given = {**given, "strategy": name_of(given["strategy"])}
    spec = RunSpec(environment=environment, **run_fields(given))
    drawn = {"starts"} if isinstance(given.get("starts"), str) else set()
    of_team = {name: name for name in given if name in drawn | {"radio", "radio_range_m"}}
    sized = "robots" in given or "starts" in given.keys() - drawn
    require_use(spec, of_team, "robots", sized=sized)
    return spec


def run_fields(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a `RunSpec` that the keywords of `explore` set."""
    given = {name: checked(name, value) for name, value in given.items()}
    fields: dict[str, Any] = {
        name: given[name] for name in ("strategy", "seed", "radio") if name in given
    }
    if "options" in given:
        fields["options"] = dict(given["options"])
    if "radio_range_m" in given:
        if "radio" in given:
            raise InvalidInputError("give the radio's range in radio, or as radio_range_m alone")
        fields["radio"] = RadioSpec(range_m=given["radio_range_m"])
    if "base" in given:
        fields["base"] = base_of(given["base"])
    if "faults" in given:
        fields["faults"] = tuple(given["faults"])
    if "max_time_s" in given:
        fields["stop"] = StopRule(max_time_s=given["max_time_s"])
    starts = given.get("starts")
    if isinstance(starts, str):
        if starts not in get_args(PlacedHow):
            raise InvalidInputError(
                f'starts is "scattered", "clustered", "random", "suggested", "base" or a sequence '
                f"of configurations, not {starts!r}"
            )
        fields["starts"] = starts
    robots = given.get("robots")
    if isinstance(robots, Iterable):
        fields["robots"] = _own_robots(robots, given)
    else:
        fields["robots"] = _equal_robots(given)
    return fields


def _own_robots(robots: Iterable[object], given: Mapping[str, Any]) -> tuple[RobotSpec, ...]:
    named = ["start", "footprint", "range_m", "beams", "drive"]
    if not isinstance(given.get("starts"), str):
        named.append("starts")
    if twice := [name for name in named if name in given]:
        raise InvalidInputError(
            f"a RobotSpec says everything about its robot: leave out {', '.join(twice)}, or give "
            "robots as a number"
        )
    checked = []
    for number, robot in enumerate(robots):
        if not isinstance(robot, RobotSpec):
            raise InvalidInputError(
                f"robots is a number or a sequence of RobotSpec; robots[{number}] is {robot!r}"
            )
        checked.append(robot)
    return tuple(checked)


def _equal_robots(given: Mapping[str, Any]) -> tuple[RobotSpec, ...]:
    fields = {name: given[name] for name in ("footprint", "drive") if name in given}
    sensor = {name: given[name] for name in ("range_m", "beams") if name in given}
    if sensor:
        fields["range_finder"] = RangeFinderSpec(**sensor)
    return tuple(
        RobotSpec(**fields) if place is None else RobotSpec(start=start_of(place), **fields)
        for place in _start_configurations(given)
    )


def _start_configurations(given: Mapping[str, Any]) -> list[Sequence[float] | None]:
    # One for each robot; None where it is drawn.
    starts, start = given.get("starts"), given.get("start")
    places = None if starts is None or isinstance(starts, str) else list(starts)
    if start is not None and places is not None:
        raise InvalidInputError("give start for a single robot, or starts for a team, not both")
    robots = given.get("robots", 1 if places is None else len(places))
    try:
        robots = operator.index(robots)
    except TypeError:
        raise InvalidInputError(
            f"robots is a number or a sequence of RobotSpec, not {robots!r}"
        ) from None
    if robots < 1:
        raise InvalidInputError(f"a team has at least one robot, not {robots}")
    if start is not None:
        if robots > 1:
            raise InvalidInputError(
                f"start is where a single robot starts; for {robots} robots give starts"
            )
        return [start]
    if places is None:
        return [None] * robots
    if len(places) != robots:
        raise InvalidInputError(
            f"{counted(len(places), 'start')} for {counted(robots, 'robot')}: give one for each of "
            "them"
        )
    return places
