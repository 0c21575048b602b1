"""The Python door: explore a world, and look at what came out."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import msgspec

from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.metrics import Metrics, measure
from multisrt.recording import Recording, RunOutcome, written_whole
from multisrt.simulation import Watcher, simulate
from multisrt.spec import (
    DriveSpec,
    EnvironmentSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Scalar,
    StopRule,
    build_environment,
    environment_spec,
    inline,
)

RECORDING_NAME = "recording.jsonl"
RUN_NAME = "run.json"
TREE_NAME = "tree.svg"


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

    def save_svg(self, path: str | Path) -> None:
        """Draw the tree, wholly or not at all."""
        from multisrt.drawing import save_tree_svg

        save_tree_svg(self.recording, path)

    def save_recording(self, path: str | Path) -> None:
        """Write the recording, wholly or not at all."""
        self.recording.save(path)

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
    start: Sequence[float] | None = None,
    footprint: str = "disc:0.25",
    range_m: float = 4.0,
    beams: int | None = None,
    drive: DriveSpec | None = None,
    max_time_s: float | None = None,
    recording_path: str | Path | None = None,
    watch: Watcher | None = None,
) -> Run:
    """Explore a world with one robot.

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
    start : (x, y) or (x, y, heading), optional
        Where the robot starts; see `RobotSpec`.
    footprint : str
        Its body, as `Footprint.parse` reads it.
    range_m, beams
        Its range finder; see `RangeFinderSpec`.
    drive : DriveSpec, optional
        How it moves; differential by default.
    max_time_s : float, optional
        When the run ends although the robot would go on.
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
        given = strategy, seed, options, start, footprint, range_m, beams, drive, max_time_s
        if given != _NOTHING_GIVEN:
            raise InvalidInputError(
                "a RunSpec says everything: with it, give only recording_path and watch"
            )
        world = build_environment(environment.environment)
        return Run(simulate(environment, world, path=recording_path, watch=watch), world)
    where: EnvironmentSpec
    if isinstance(environment, Environment):
        world, where = environment, inline(environment)
    else:
        where = environment_spec(str(environment))
        world = build_environment(where)
    robot = RobotSpec(
        start=None if start is None else tuple(start),
        footprint=footprint,
        drive=DriveSpec() if drive is None else drive,
        range_finder=RangeFinderSpec(range_m=range_m, beams=beams),
    )
    spec = RunSpec(
        environment=where,
        strategy=strategy,
        options=options or {},
        robots=(robot,),
        stop=StopRule() if max_time_s is None else StopRule(max_time_s=max_time_s),
        seed=seed,
    )
    return Run(simulate(spec, world, path=recording_path, watch=watch), world)


_NOTHING_GIVEN = "srt-radial", 0, None, None, "disc:0.25", 4.0, None, None, None
"""The defaults of `explore`."""
