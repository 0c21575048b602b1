"""Many runs over a grid of conditions and seeds, resumable, in several processes.

A benchmark describes itself by an `Experiment` and hands it to `main`. Results go line by line to
a JSONL file beside the report: called again, only the runs that are missing are made. The exit
code is 1 where a run failed or is missing.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from types import FrameType
from typing import Any, Generic

import msgspec
import numpy as np
import shapely

import multisrt.environments
import multisrt.geometry
import multisrt.planners
from benchmarks.rows import CaseT, MeasuresT, Row, Status, append, read
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.metrics import measure
from multisrt.recording import written_whole
from multisrt.simulation import simulate
from multisrt.spec import EnvironmentSpec, RunSpec, build_environment

Advance = Callable[[Row[Any, Any]], None]

START_CLEARANCE_M = 0.3
"""From a drawn start to the nearest wall: a little more than the default body's radius."""

WORLDS_KEPT = 4


class OverLimitError(BaseException):
    """A run took longer than it may; no handler of errors may take it for one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment(Generic[CaseT, MeasuresT]):
    """A benchmark that makes many runs and reports on them.

    Attributes
    ----------
    name : str
        Of its module in `benchmarks`.
    about : str
        What its help says.
    case, measures : type
        What describes a run of the grid, and what is kept of its metrics.
    grid : callable
        Gives the runs for so many seeds and, of the team sizes, all or a few (quick).
    spec_of : callable
        Describes a run.
    report : callable
        Writes the report from the rows, the number of runs asked for and the command.
    command_of : callable or None
        The command that repeats a run; None: by a spec that the benchmark writes.
    seeds, quick_seeds : int
        How many, unless told otherwise.
    limit_s : float
        How long a run may take, unless told otherwise.
    add_options : callable or None
        Adds options of its own to the parser.
    own_options : callable or None
        Repeats them, as given, for the report's command.
    """

    name: str
    about: str
    case: type[CaseT]
    measures: type[MeasuresT]
    grid: Callable[[int, argparse.Namespace], list[CaseT]]
    spec_of: Callable[[CaseT], RunSpec]
    report: Callable[[Sequence[Row[CaseT, MeasuresT]], int, str], str]
    command_of: Callable[[CaseT], str] | None = None
    seeds: int
    quick_seeds: int = 2
    limit_s: float = 300.0
    add_options: Callable[[argparse.ArgumentParser], None] | None = None
    own_options: Callable[[argparse.Namespace], str] | None = None

    def repeat(self, case: CaseT) -> str:
        """Give the command that repeats a run."""
        if self.command_of is not None:
            return self.command_of(case)
        return repeat_by_spec(self.name, case)


def main(experiment: Experiment[CaseT, MeasuresT]) -> None:
    """Make the runs that are missing, print the report and write it; or write a run's spec."""
    given = _arguments(experiment)
    try:
        if given.spec is None:
            _make(experiment, given)
        else:
            print(experiment.spec_of(case_of(given.spec, experiment.case)).to_toml())
    except InvalidInputError as error:
        sys.exit(f"error: {error}")


def _make(experiment: Experiment[CaseT, MeasuresT], given: argparse.Namespace) -> None:
    cases = experiment.grid(experiment.quick_seeds if given.quick else given.seeds, given)
    raw = given.out.with_suffix(".jsonl")
    given.out.parent.mkdir(parents=True, exist_ok=True)
    rows = read(raw, experiment.case, experiment.measures)
    missing = [case for case in cases if case not in rows or (given.retry and rows[case].failed)]
    try:
        for row in run_all(experiment, missing, given.workers, given.limit):
            append(raw, row)
            rows[row.case] = row
    except KeyboardInterrupt:
        print("interrupted; the same command goes on where it stopped", file=sys.stderr)
    made = [rows[case] for case in cases if case in rows]
    text = experiment.report(made, len(cases), _command(experiment, given))
    print(text)
    with written_whole(given.out) as file:
        file.write(text.encode())
    sys.exit(0 if len(made) == len(cases) and not any(row.failed for row in made) else 1)


# Runs ---------------------------------------------------------------------------------------


def run_all(
    experiment: Experiment[CaseT, MeasuresT], cases: Sequence[CaseT], workers: int, limit_s: float
) -> Iterator[Row[CaseT, MeasuresT]]:
    """Make runs in several processes; give them as they end."""
    if not cases:
        return
    program = program_digest()
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
    try:
        futures = [
            pool.submit(run, case, experiment.spec_of, experiment.measures, limit_s, program)
            for case in cases
        ]
        with _progress(len(cases), experiment.repeat) as advance:
            for future in as_completed(futures):
                row = future.result()
                advance(row)
                yield row
    finally:
        pool.shutdown(cancel_futures=True)


def run(
    case: CaseT,
    spec_of: Callable[[CaseT], RunSpec],
    kept: type[MeasuresT],
    limit_s: float,
    program: str,
) -> Row[CaseT, MeasuresT]:
    """Make one run; what goes wrong is told in the row."""
    begin = time.perf_counter()
    status: Status = "error"
    measures = None
    try:
        with time_limit(limit_s):
            spec = spec_of(case)
            world = world_of(spec.environment)
            recording = simulate(spec, world)
            metrics = measure(recording, world)
        status, reason = recording.footer.outcome, recording.footer.reason
        measures = kept(**{name: getattr(metrics, name) for name in kept.__struct_fields__})
    except OverLimitError:
        status, reason = "over_limit", f"not done after {limit_s:g} s"
    except Exception as error:  # every defect of a run is a result of this benchmark
        place = traceback.extract_tb(error.__traceback__)[-1]
        reason = f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"
    return Row(
        case=case,
        status=status,
        reason=reason,
        measures=measures,
        seconds=time.perf_counter() - begin,
        program=program,
    )


@contextmanager
def time_limit(limit_s: float) -> Iterator[None]:
    """Raise `OverLimitError` in the main thread after a time."""

    def stop(_signal: int, _frame: FrameType | None) -> None:
        raise OverLimitError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, limit_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def world_of(spec: EnvironmentSpec) -> Environment:
    """Build a world, or give it again if it was built not long ago."""
    return _world(msgspec.json.encode(spec))


@lru_cache(maxsize=WORLDS_KEPT)
def _world(spec: bytes) -> Environment:
    described: EnvironmentSpec = msgspec.json.decode(spec, type=EnvironmentSpec)
    return build_environment(described)


def drawn_start(world: Environment, seed: int) -> tuple[float, float, float]:
    """Draw a place, uniformly, and a heading for the first robot of a team.

    Strategies that decide without chance do the same from the same start: here it is the start
    in which the runs of a series differ.
    """
    inner = world.free.buffer(-START_CLEARANCE_M)
    room = max(shapely.get_parts(inner), key=lambda part: float(part.area))
    shapely.prepare(room)
    x0, y0, x1, y1 = room.bounds
    rng = np.random.default_rng(seed)
    while True:
        x, y = rng.uniform((x0, y0), (x1, y1))
        heading = rng.uniform(-np.pi, np.pi)
        if shapely.contains_xy(room, x, y):
            # To the millimetre, so that it can be told in a few digits.
            return round(float(x), 3), round(float(y), 3), round(float(heading), 3)


def program_digest() -> str:
    """Digest of the package's source: rows that share it were made by one program."""
    digest = hashlib.sha256()
    packages = (multisrt, multisrt.geometry, multisrt.planners, multisrt.environments)
    for package in packages:
        folder = Path(package.__path__[0]).resolve()
        for path in sorted(folder.rglob("*.py")):
            digest.update(f"{package.__name__}/{path.relative_to(folder)}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


# A single run -------------------------------------------------------------------------------


def repeat_by_spec(name: str, case: msgspec.Struct) -> str:
    """Give the command that writes a run's spec and repeats the run."""
    text = "/".join(
        f"{value:g}" if isinstance(value, float) else str(value)
        for value in msgspec.structs.astuple(case)
    )
    return (
        f"python -m benchmarks.{name} --spec {text} > run.toml && multisrt explore --spec run.toml"
    )


def case_of(text: str, case: type[CaseT]) -> CaseT:
    """Read what `repeat_by_spec` wrote.

    Raises
    ------
    InvalidInputError
        If it does not describe a run of the benchmark.
    """
    names = case.__struct_fields__
    parts = text.split("/")
    try:
        if len(parts) != len(names):
            raise ValueError(f"{len(parts)} parts")
        return msgspec.convert(dict(zip(names, parts, strict=True)), case, strict=False)
    except ValueError as error:  # msgspec's own is one
        raise InvalidInputError(f"--spec takes {'/'.join(names)}, not {text!r}: {error}") from None


# What a person sees and says ----------------------------------------------------------------


@contextmanager
def _progress(total: int, repeat: Callable[[CaseT], str]) -> Iterator[Advance]:
    from rich import progress
    from rich.console import Console

    failed = 0
    with progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TimeElapsedColumn(),
        progress.TimeRemainingColumn(),
        console=Console(stderr=True),
    ) as bar:
        task = bar.add_task("exploring", total=total)

        def advance(row: Row[Any, Any]) -> None:
            nonlocal failed
            if row.failed:
                failed += 1
                bar.console.print(f"{row.status}: {repeat(row.case)}", soft_wrap=True)
            bar.update(task, advance=1, description=f"exploring, {failed} failed")

        yield advance


def _arguments(experiment: Experiment[CaseT, MeasuresT]) -> argparse.Namespace:
    file = experiment.name.replace("_", "-")
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks.{experiment.name}", description=experiment.about
    )
    parser.add_argument(
        "--seeds", type=int, default=experiment.seeds, help=f"for each cell ({experiment.seeds})"
    )
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes (all cores)")
    parser.add_argument(
        "--out", type=Path, help=f"the report (docs/results/{file}.md); raw results go beside it"
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"a few cells only and seeds: {experiment.quick_seeds}, to out/{file}-quick.md unless "
        "--out is given",
    )
    parser.add_argument(
        "--limit",
        type=float,
        default=experiment.limit_s,
        help=f"seconds that a run may take ({experiment.limit_s:g})",
    )
    parser.add_argument("--retry", action="store_true", help="repeat runs that failed")
    parser.add_argument(
        "--spec",
        metavar="/".join(experiment.case.__struct_fields__).upper(),
        help="only write the spec of one run, for 'multisrt explore --spec'",
    )
    if experiment.add_options is not None:
        experiment.add_options(parser)
    given = parser.parse_args()
    if given.out is None:
        given.out = Path(f"out/{file}-quick.md" if given.quick else f"docs/results/{file}.md")
    if given.out.suffix == ".jsonl":
        parser.error("--out names the report; the raw results beside it end in .jsonl")
    for name in ("seeds", "workers", "limit"):
        if getattr(given, name) <= 0:
            parser.error(f"--{name} is a positive number, not {getattr(given, name)}")
    return given


def _command(experiment: Experiment[CaseT, MeasuresT], given: argparse.Namespace) -> str:
    what = "--quick" if given.quick else f"--seeds {given.seeds}"
    own = f" {experiment.own_options(given)}" if experiment.own_options is not None else ""
    return f"python -m benchmarks.{experiment.name} {what} --limit {given.limit:g}{own}"
