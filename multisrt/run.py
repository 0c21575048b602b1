"""The Python door: explore a world, and look at what came out."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Literal

import msgspec

from multisrt.analysis.metrics import Metrics, measure
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording, RunOutcome, written_whole
from multisrt.simulation.journal import Watcher
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import build_environment, environment_spec, inline
from multisrt.spec import (
    DriveSpec,
    EnvironmentSpec,
    Fault,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Scalar,
    StopRule,
)

RECORDING_NAME = "recording.jsonl"
RUN_NAME = "run.json"
TREE_NAME = "tree.svg"
SPEC_NAME = "spec.toml"

Starts = Literal["scattered", "clustered"] | Sequence[Sequence[float]]
"""Where a team starts: how its places are drawn, or the places."""


class Run:
    """A run that has ended: its recording and the world it took place in.

    Parameters
    ----------
    recording : Recording
        What happened.
    environment : Environment, optional
        The world, if it is at hand; else it is taken from the recording.
    """

    def __init__(self, recording: Recording, environment: Environment | None = None) -> None:
        self.recording = recording
        self.environment = recording.environment() if environment is None else environment

    @property
    def spec(self) -> RunSpec:
        """What the run depended on."""
        return self.recording.spec

    @property
    def outcome(self) -> RunOutcome:
        """How it ended: `complete`, `stalled` or `out_of_time`."""
        return self.recording.footer.outcome

    @property
    def reason(self) -> str:
        """Why it ended, in words."""
        return self.recording.footer.reason

    @property
    def digest(self) -> str:
        """SHA-256 of spec, world and events: equal specs have equal digests."""
        return self.recording.footer.digest

    @cached_property
    def metrics(self) -> Metrics:
        """What is measured of the run."""
        return measure(self.recording, self.environment)

    def why(self, robot: int, time_s: float | None = None) -> str:
        """Tell in plain words what a robot knew and decided at its last decision by a time.

        Parameters
        ----------
        robot : int
            Which, from 0.
        time_s : float, optional
            When; the end of the run by default.

        Raises
        ------
        InvalidInputError
            If there is no such robot, or it had not decided anything by then.
        """
        from multisrt.explain.srt import explain

        return explain(self.recording, robot, time_s)

    def save_svg(self, path: str | Path) -> None:
        """Draw the tree, wholly or not at all."""
        from multisrt.drawing import save_tree_svg

        save_tree_svg(self.recording, path)

    def save_recording(self, path: str | Path) -> None:
        """Write the recording, wholly or not at all."""
        self.recording.save(path)

    def save_spec(self, path: str | Path) -> None:
        """Write the spec as TOML, wholly or not at all; it repeats the run."""
        with written_whole(Path(path)) as file:
            file.write(self.spec.to_toml().encode())

    def save_summary(self, path: str | Path) -> None:
        """Write spec, outcome, reason, digest and metrics as JSON, wholly or not at all."""
        summary = {
            "spec": self.spec,
            "outcome": self.outcome,
            "reason": self.reason,
            "digest": self.digest,
            "metrics": self.metrics,
        }
        text = msgspec.json.format(msgspec.json.encode(summary), indent=2)
        with written_whole(Path(path)) as file:
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
    strategy: str = "srt-radial",
    seed: int = 0,
    options: dict[str, Scalar] | None = None,
    robots: int = 1,
    start: Sequence[float] | None = None,
    starts: Starts = "scattered",
    footprint: str = "disc:0.25",
    range_m: float = 4.0,
    beams: int | None = None,
    drive: DriveSpec | None = None,
    radio_range_m: float | None = None,
    radio: RadioSpec | None = None,
    faults: Sequence[Fault] = (),
    max_time_s: float | None = None,
    recording_path: str | Path | None = None,
    watch: Watcher | None = None,
) -> Run:
    """Explore a world with one robot or a team of equal robots.

    For a team of different robots build a `RunSpec` and explore that.

    Parameters
    ----------
    environment : Environment, str, Path or RunSpec
        A world; or the name of one in the catalogue, or a map file; or a spec, which says
        everything, so that nothing else may be given but where to write and who watches.
    strategy : str
        A name of the registry.
    seed : int
        Seeds every random stream of the run.
    options : dict, optional
        The strategy's parameters.
    robots : int
        How many; where `starts` gives the places, as many as there are.
    start : (x, y) or (x, y, heading), optional
        Where a single robot starts; see `RobotSpec`.
    starts : {"scattered", "clustered"} or sequence of starts
        Where a team starts: far apart from one another, together, or at these places.
    footprint : str
        Their bodies, as `Footprint.parse` reads it.
    range_m, beams
        Their range finders; see `RangeFinderSpec`.
    drive : DriveSpec, optional
        How they move; differential by default.
    radio_range_m : float, optional
        How far their radios reach; everywhere by default.
    radio : RadioSpec, optional
        How messages travel, in full; not together with `radio_range_m`.
    faults : sequence of Death, Silence or LateStart
        What goes wrong.
    max_time_s : float, optional
        When the run ends although the robots would go on.
    recording_path : path, optional
        Where to write the recording as the run goes.
    watch : callable, optional
        Is given every event as it happens.

    Returns
    -------
    Run
        What came out. An exploration that stalls or runs out of time is a result, too.

    Raises
    ------
    InvalidInputError
        If what was given cannot be run; the message says why.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore(ms.environment("open"), seed=1)
    >>> run.outcome
    'complete'
    """
    if isinstance(environment, RunSpec):
        given = (strategy, seed, options, robots, start, starts, footprint, range_m, beams, drive)
        if (*given, radio_range_m, radio, tuple(faults), max_time_s) != _NOTHING_GIVEN:
            raise InvalidInputError(
                "a RunSpec says everything: with it, give only recording_path and watch"
            )
        world = build_environment(environment.environment)
        return Run(simulate(environment, world, path=recording_path, watch=watch), world)
    if radio is not None and radio_range_m is not None:
        raise InvalidInputError("give the radio's range in radio, or as radio_range_m alone")
    places, how = _placing(robots, start, starts)
    where: EnvironmentSpec
    if isinstance(environment, Environment):
        world, where = environment, inline(environment)
    else:
        where = environment_spec(str(environment))
        world = build_environment(where)
    spec = RunSpec(
        environment=where,
        strategy=strategy,
        options=options or {},
        robots=tuple(
            RobotSpec(
                start=None if place is None else tuple(place),
                footprint=footprint,
                drive=DriveSpec() if drive is None else drive,
                range_finder=RangeFinderSpec(range_m=range_m, beams=beams),
            )
            for place in places
        ),
        starts=how,
        radio=RadioSpec(range_m=radio_range_m) if radio is None else radio,
        faults=tuple(faults),
        stop=StopRule() if max_time_s is None else StopRule(max_time_s=max_time_s),
        seed=seed,
    )
    return Run(simulate(spec, world, path=recording_path, watch=watch), world)


_NOTHING_GIVEN = (
    *("srt-radial", 0, None, 1, None, "scattered", "disc:0.25", 4.0, None, None),
    *(None, None, (), None),
)
"""The defaults of `explore`."""


def _placing(
    robots: int, start: Sequence[float] | None, starts: Starts
) -> tuple[list[Sequence[float] | None], Literal["scattered", "clustered"]]:
    # Every robot's place, None where it is to be drawn, and how to draw it.
    if robots < 1:
        raise InvalidInputError(f"a team has at least one robot, not {robots}")
    if isinstance(starts, str):
        if starts not in ("scattered", "clustered"):
            raise InvalidInputError(
                f'starts is "scattered", "clustered" or a sequence of places, not {starts!r}'
            )
        if start is not None and robots > 1:
            raise InvalidInputError(
                f"start is where a single robot starts; for {robots} give starts"
            )
        return ([start] if start is not None else [None] * robots), starts
    if start is not None:
        raise InvalidInputError("give start for a single robot, or starts for a team, not both")
    if len(starts) == 0 or robots not in (1, len(starts)):
        raise InvalidInputError(
            f"{len(starts)} starts for {robots} robots: give as many as there are robots"
        )
    return list(starts), "scattered"
