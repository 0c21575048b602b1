"""Explore an environment from Python: `explore` and the `Run` that it returns."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import msgspec

from multisrt.analysis.measuring import measure
from multisrt.analysis.metrics import Metrics
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording, RunOutcome, atomic_write
from multisrt.robots.explorer import Explorer
from multisrt.robots.registry import register
from multisrt.robots.strategy import Strategy, as_strategy
from multisrt.simulation.journal import Watcher
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import build_environment, environment_spec, inline
from multisrt.spec import (
    DriveSpec,
    Fault,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Scalar,
    StopRule,
)
from multisrt.spec.keywords import checked, start_of

RECORDING_NAME = "recording.jsonl"
RUN_NAME = "run.json"
TREE_NAME = "tree.svg"
SPEC_NAME = "spec.toml"

Starts = Literal["scattered", "clustered"] | Sequence[Sequence[float]]
"""Start configurations of a team: how to draw them, or one for each robot."""


class Run:
    """A finished run: its recording and the environment it took place in.

    Parameters
    ----------
    recording : Recording
        The recording of the run.
    environment : Environment, optional
        The environment of the run. By default it is built from the recording's spec.

    Raises
    ------
    InvalidInputError
        If `environment` is not given and cannot be built from the recording.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", seed=1)
    >>> run.outcome, run.reason
    ('complete', 'robot 0: every frontier arc is explored or closed')
    >>> run.spec.seed
    1
    >>> run.save_svg("tree.svg")

    A saved recording can be measured and drawn again:

    >>> run.recording.save("recording.jsonl")
    >>> again = ms.Run(ms.Recording.load("recording.jsonl"))
    """

    def __init__(self, recording: Recording, environment: Environment | None = None) -> None:
        self.recording = recording
        self.environment = recording.environment() if environment is None else environment

    @property
    def spec(self) -> RunSpec:
        """The spec of the run."""
        return self.recording.spec

    @property
    def outcome(self) -> RunOutcome:
        """How the run ended: `complete`, `stalled` or `out_of_time`."""
        return self.recording.footer.outcome

    @property
    def reason(self) -> str:
        """Why the run ended, in words."""
        return self.recording.footer.reason

    @property
    def digest(self) -> str:
        """SHA-256 of spec, environment and events; runs of equal specs have equal digests."""
        return self.recording.footer.digest

    @cached_property
    def metrics(self) -> Metrics:
        """The metrics of the run, computed on first use."""
        return measure(self.recording, self.environment)

    def why(self, robot: int, time_s: float | None = None) -> str:
        """Explain in words what a robot knew and decided.

        Parameters
        ----------
        robot : int
            Index of the robot, from 0.
        time_s : float, optional
            Time (s); the last decision up to this time is explained. By default the end of the
            run.

        Returns
        -------
        str
            The explanation, of several lines.

        Raises
        ------
        InvalidInputError
            If there is no such robot, or it had made no decision by `time_s`.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1)
        >>> print(run.why(robot=0, time_s=30.0))  # doctest: +ELLIPSIS
        Robot 0 at 30.00 s...
        """
        from multisrt.explain.srt import explain

        return explain(self.recording, robot, time_s)

    def save_svg(self, path: str | Path) -> None:
        """Draw the exploration trees as SVG.

        Parameters
        ----------
        path : str or Path
            The file; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).save_svg("tree.svg")
        """
        from multisrt.drawing import save_tree_svg

        save_tree_svg(self.recording, path)

    def save_recording(self, path: str | Path) -> None:
        """Write the recording, one JSON object a line.

        Parameters
        ----------
        path : str or Path
            The file; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1, max_time_s=10.0)
        >>> run.save_recording("recording.jsonl")
        >>> ms.Recording.load("recording.jsonl").footer.digest == run.digest
        True
        """
        self.recording.save(path)

    def save_spec(self, path: str | Path) -> None:
        """Write the spec as TOML, from which the run can be repeated.

        Parameters
        ----------
        path : str or Path
            The file; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).save_spec("spec.toml")
        >>> with open("spec.toml") as file:
        ...     spec = ms.RunSpec.from_toml(file.read())
        >>> spec.stop.max_time_s
        10.0
        """
        with atomic_write(Path(path)) as file:
            file.write(self.spec.to_toml().encode())

    def save_summary(self, path: str | Path) -> None:
        """Write spec, outcome, reason, digest and metrics as JSON.

        Parameters
        ----------
        path : str or Path
            The file; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written.

        Examples
        --------
        >>> import json
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).save_summary("run.json")
        >>> with open("run.json") as file:
        ...     print(list(json.load(file)))
        ['spec', 'outcome', 'reason', 'digest', 'metrics']
        """
        summary = {
            "spec": self.spec,
            "outcome": self.outcome,
            "reason": self.reason,
            "digest": self.digest,
            "metrics": self.metrics,
        }
        text = msgspec.json.format(msgspec.json.encode(summary), indent=2)
        with atomic_write(Path(path)) as file:
            file.write(text + b"\n")

    def __repr__(self) -> str:
        return (
            f"Run({self.spec.strategy!r} in {self.environment.name!r}, seed {self.spec.seed}: "
            f"{self.outcome}, {self.metrics.coverage:.1%} covered in "
            f"{self.metrics.makespan_s:.0f} s)"
        )


def explore(
    environment: Environment | str | Path | RunSpec,
    *,
    strategy: str | Strategy | Callable[..., Explorer] | None = None,
    seed: int | None = None,
    options: Mapping[str, Scalar] | None = None,
    robots: int | Sequence[RobotSpec] | None = None,
    start: Sequence[float] | None = None,
    starts: Starts | None = None,
    footprint: str | None = None,
    range_m: float | None = None,
    beams: int | None = None,
    drive: DriveSpec | None = None,
    radio_range_m: float | None = None,
    radio: RadioSpec | None = None,
    faults: Sequence[Fault] | None = None,
    max_time_s: float | None = None,
    recording_path: str | Path | None = None,
    watch: Watcher | None = None,
) -> Run:
    """Explore an environment with one robot or a team.

    There are three forms. The short one describes a team of equal robots by keywords; the second
    takes `robots` as a sequence of `RobotSpec`, which may differ; the third takes a `RunSpec`,
    which describes the whole run. What is not given has the default of the spec that it belongs
    to: `RunSpec`, `RobotSpec`, `RangeFinderSpec`, `RadioSpec` or `StopRule`.

    Parameters
    ----------
    environment : Environment, str, Path or RunSpec
        The environment, its name in the catalogue, or a map file; or the spec of the run, with
        which only `recording_path` and `watch` may be given.
    strategy : str, Strategy, class or function, optional
        Name of a registered strategy, see `strategies`; or one of one's own, as `Strategy.of`
        takes it, which is registered by this in place of one of its name.
    seed : int, optional
        Seed of all random streams of the run.
    options : mapping, optional
        Options of the strategy that differ from its defaults.
    robots : int or sequence of RobotSpec, optional
        Number of equal robots, or one spec for each robot. By default one robot, or as many as
        `starts` has configurations.
    start : (x, y) or (x, y, heading), optional
        Start configuration (m, rad) of a single robot.
    starts : {"scattered", "clustered"} or sequence of configurations, optional
        How the start configurations of a team are drawn, far apart or close together; or one
        configuration (m, rad) for each robot.
    footprint : str, optional
        Body of every robot, in the notation of `Footprint.parse`.
    range_m : float, optional
        Range of every range finder (m).
    beams : int, optional
        Number of beams of every range finder; by default it returns the exact visibility
        polygon.
    drive : DriveSpec, optional
        Kinematics and speed of every robot.
    radio_range_m : float, optional
        Range of the radio (m), all else as in `RadioSpec`.
    radio : RadioSpec, optional
        The complete description of the radio, instead of `radio_range_m`.
    faults : sequence of Death, Silence or LateStart, optional
        Faults of robots during the run.
    max_time_s : float, optional
        Simulated time (s) at which the run is stopped.
    recording_path : str or Path, optional
        File to which the recording is written while the run goes on.
    watch : callable, optional
        Called with every event as it happens.

    Returns
    -------
    Run
        The finished run. An exploration that stalls or runs out of time is a result, no error.

    Raises
    ------
    InvalidInputError
        If the arguments contradict each other or describe a run that is impossible.

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

    A spec repeats the run exactly:

    >>> ms.explore(run.spec).digest == run.digest
    True
    """
    if strategy is not None and not isinstance(strategy, str):
        own = as_strategy(strategy)
        register(own, replace=True)
        strategy = own.name
    robot = {"footprint": footprint, "range_m": range_m, "beams": beams, "drive": drive}
    team = {"robots": robots, "start": start, "starts": starts}
    rest = {
        "strategy": strategy,
        "seed": seed,
        "options": options,
        "radio_range_m": radio_range_m,
        "radio": radio,
        "faults": faults,
        "max_time_s": max_time_s,
    }
    given = {name: value for name, value in (rest | team | robot).items() if value is not None}
    spec, world = spec_and_world(environment, given)
    return Run(simulate(spec, world, path=recording_path, watch=watch), world)


def spec_and_world(
    environment: Environment | str | Path | RunSpec, given: Mapping[str, Any]
) -> tuple[RunSpec, Environment]:
    """Return the spec and the world that the arguments of `explore` describe.

    Parameters
    ----------
    environment : Environment, str, Path or RunSpec
        As for `explore`.
    given : mapping
        The arguments of `explore` that describe the run and that are given, by name.

    Raises
    ------
    InvalidInputError
        As `explore`.
    """
    if isinstance(environment, RunSpec):
        if given:
            raise InvalidInputError(
                "a RunSpec describes the run: with it, give only recording_path and watch, and "
                f"leave out {', '.join(given)}"
            )
        return environment, build_environment(environment.environment)
    if isinstance(environment, Environment):
        return RunSpec(environment=inline(environment), **_run_fields(given)), environment
    where = environment_spec(str(environment))
    world = build_environment(where)
    return RunSpec(environment=where, **_run_fields(given)), world


def _run_fields(given: Mapping[str, Any]) -> dict[str, Any]:
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
    if "faults" in given:
        fields["faults"] = tuple(given["faults"])
    if "max_time_s" in given:
        fields["stop"] = StopRule(max_time_s=given["max_time_s"])
    starts = given.get("starts")
    if isinstance(starts, str):
        if starts not in ("scattered", "clustered"):
            raise InvalidInputError(
                f'starts is "scattered", "clustered" or a sequence of configurations, not '
                f"{starts!r}"
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
            f"{len(places)} starts for {robots} robots: give one for each of them"
        )
    return places
