"""Multi-SRT in the two worlds of its paper, over many seeds: ``python -m benchmarks.multi_srt``.

Teams of 1 to 16 robots explore the garden and the clutter with SRT-Star and SRT-Radial, from
scattered and clustered starts, with an unlimited and a limited radio. Results go line by line to
a JSONL file beside the report: called again, only the runs that are missing are made. The exit
code is 1 where a run failed or is missing.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import platform
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from multiprocessing import get_context
from pathlib import Path
from types import FrameType

import msgspec

import multisrt.environments
import multisrt.geometry
import multisrt.planners
from benchmarks.multi_srt_report import SURE, Case, Measures, Row, Starts, Status, findings, table
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.metrics import measure
from multisrt.recording import written_whole
from multisrt.simulation import simulate
from multisrt.spec import (
    CatalogEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

WORLDS = ("garden", "clutter")
STRATEGIES = ("srt-star", "srt-radial")
TEAMS = (1, 2, 4, 8, 16)
STARTS: tuple[Starts, ...] = ("scattered", "clustered")
RANGE_M = 4.0
RADIO_RANGES_M = (None, 15.0)
MAX_TIME_S = 14_400.0
"""Of the run's own clock: several times what a robot alone needs."""

SEEDS, QUICK_SEEDS, QUICK_TEAMS = 20, 2, (1, 2, 4)

Advance = Callable[[Row], None]


class OverLimitError(BaseException):
    """A run took longer than it may; no handler of errors may take it for one."""


def main() -> None:
    """Make the runs that are missing, print the report and write it."""
    given = _arguments()
    cases = grid(QUICK_SEEDS if given.quick else given.seeds, QUICK_TEAMS if given.quick else TEAMS)
    raw = given.out.with_suffix(".jsonl")
    given.out.parent.mkdir(parents=True, exist_ok=True)
    rows = read(raw)
    missing = [case for case in cases if case not in rows or (given.retry and rows[case].failed)]
    try:
        for row in run_all(missing, given.workers, given.limit):
            append(raw, row)
            rows[row.case] = row
    except KeyboardInterrupt:
        print("interrupted; the same command goes on where it stopped", file=sys.stderr)
    made = [rows[case] for case in cases if case in rows]
    text = report(made, len(cases), _command(given))
    print(text)
    with written_whole(given.out) as file:
        file.write(text.encode())
    sys.exit(0 if len(made) == len(cases) and not any(row.failed for row in made) else 1)


# Runs ---------------------------------------------------------------------------------------


def grid(seeds: int, teams: Sequence[int] = TEAMS) -> list[Case]:
    """Give all runs, seed by seed, so that a grid that is cut short has something of each cell.

    For a robot alone neither starts nor radio make a difference: it explores once for each seed.
    """
    return [
        Case(
            world=world,
            strategy=strategy,
            starts=starts,
            radio_range_m=radio,
            robots=robots,
            seed=seed,
        )
        for seed in range(seeds)
        for robots in teams
        for world in WORLDS
        for strategy in STRATEGIES
        for starts in STARTS
        for radio in RADIO_RANGES_M
        if robots > 1 or (starts, radio) == (STARTS[0], RADIO_RANGES_M[0])
    ]


def spec_of(case: Case) -> RunSpec:
    """Describe a run of the grid."""
    robot = RobotSpec(range_finder=RangeFinderSpec(range_m=RANGE_M))
    return RunSpec(
        environment=CatalogEnvironment(name=case.world),
        strategy=case.strategy,
        robots=(robot,) * case.robots,
        starts=case.starts,
        radio=RadioSpec(range_m=case.radio_range_m),
        stop=StopRule(max_time_s=MAX_TIME_S),
        seed=case.seed,
    )


def run_all(cases: Sequence[Case], workers: int, limit_s: float) -> Iterator[Row]:
    """Make runs in several processes; give them as they end."""
    if not cases:
        return
    program = program_digest()
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
    try:
        futures = [pool.submit(run, case, limit_s, program) for case in cases]
        with _progress(len(cases)) as advance:
            for future in as_completed(futures):
                row = future.result()
                advance(row)
                yield row
    finally:
        pool.shutdown(cancel_futures=True)


def run(case: Case, limit_s: float, program: str) -> Row:
    """Make one run; what goes wrong is told in the row."""
    begin = time.perf_counter()
    status: Status = "error"
    measures = None
    try:
        with time_limit(limit_s):
            recording = simulate(spec_of(case), _world(case.world))
            metrics = measure(recording, _world(case.world))
        status, reason = recording.footer.outcome, recording.footer.reason
        measures = Measures(**{name: getattr(metrics, name) for name in Measures.__struct_fields__})
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


@cache
def _world(name: str) -> Environment:
    return environment(name)


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


# Raw results --------------------------------------------------------------------------------


def read(path: Path) -> dict[Case, Row]:
    """Read the rows that are there; of a run that was repeated, the last counts.

    Raises
    ------
    InvalidInputError
        If a line is no row. A last line that was cut short by an interruption is left out.
    """
    rows: dict[Case, Row] = {}
    if not path.exists():
        return rows
    lines = path.read_bytes().splitlines(keepends=True)
    for number, line in enumerate(lines, 1):
        try:
            row = msgspec.json.decode(line, type=Row)
        except msgspec.MsgspecError as error:
            if number == len(lines) and not line.endswith(b"\n"):
                break
            raise InvalidInputError(
                f"{path}:{number}: not a result of this benchmark: {error}; remove the line, or "
                "write to another file with --out"
            ) from None
        rows[row.case] = row
    return rows


def append(path: Path, row: Row) -> None:
    """Write a row at the end, in place of a last line that was cut short."""
    with path.open("ab+") as file:
        if file.tell() > 0:
            file.seek(0)
            file.truncate(file.read().rfind(b"\n") + 1)
        file.write(msgspec.json.encode(row) + b"\n")


# The report ---------------------------------------------------------------------------------


def report(rows: Sequence[Row], asked: int, command: str) -> str:
    """Write what came out in Markdown."""
    sections = [
        "# Multi-SRT in the garden and the clutter",
        f"Made with `{command}`.",
        "\n".join(_account(rows, asked)),
        "## The paper's claims",
        *(
            f"**{finding.claim}** {finding.verdict[0].upper()}{finding.verdict[1:]}.\n\n"
            + "\n".join(f"- {ground}" for ground in finding.grounds)
            for finding in findings(rows)
        ),
        "The claims compare means over complete runs; p is that of Welch's test, and what is "
        f"below {SURE:g} is called beyond chance.",
        "## Tables",
        "Mean ± standard deviation over all runs that came to an end, complete or not; that of the "
        "exploration time over those in which a robot came to know that its map is complete. "
        "Collisions, deadlocks and protective stops are sums.",
    ]
    for world in WORLDS:
        if any(row.case.world == world for row in rows):
            sections += [f"### {world.capitalize()}", table(rows, world)]
    sections += ["## Runs that failed", "\n".join(failures(rows))]
    return "\n\n".join(section.rstrip() for section in sections if section) + "\n"


def failures(rows: Iterable[Row]) -> list[str]:
    """List the runs that are not complete or had a collision, with what repeats them."""
    lines = []
    for row in rows:
        if row.failed:
            touched = row.measures is not None and row.measures.collisions > 0
            what = "collision" if touched else row.status.replace("_", " ")
            lines.append(f"- {what}: {row.reason}\n  `{row.case.command(MAX_TIME_S)}`")
    return lines or ["None."]


def _account(rows: Sequence[Row], asked: int) -> list[str]:
    packages = ("multisrt", "numpy", "numba", "scipy", "shapely", "simpy", "python-fcl")
    versions = [f"Python {platform.python_version()} ({platform.machine()})"]
    versions += [f"{package} {version(package)}" for package in packages]
    programs = sorted({row.program for row in rows})
    seconds = sum(row.seconds for row in rows)
    lines = [
        f"- Runs: {len(rows)} of {asked}; {sum(row.status == 'complete' for row in rows)} "
        f"complete, {sum(row.failed for row in rows)} failed.",
        f"- Time of all runs together: {seconds / 3600:.2f} h on one core, "
        f"{seconds / max(1, len(rows)):.1f} s a run.",
        f"- Robots: discs of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} m, exact; "
        f"limited radio {RADIO_RANGES_M[1]:g} m, relayed.",
        "- Worlds: those of the catalogue with their default parameters. A robot alone starts "
        "where the world suggests.",
        f"- Versions: {', '.join(versions)}.",
        f"- Digest of the program's source: {', '.join(programs)}.",
    ]
    if len(programs) > 1:
        lines.append(
            f"- **{len(programs)} states of the program made these results; remove the raw "
            "results and repeat all runs before they are relied upon.**"
        )
    return lines


# What a person sees and says ----------------------------------------------------------------


@contextmanager
def _progress(total: int) -> Iterator[Advance]:
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

        def advance(row: Row) -> None:
            nonlocal failed
            if row.failed:
                failed += 1
                bar.console.print(f"{row.status}: {row.case.command(MAX_TIME_S)}", soft_wrap=True)
            bar.update(task, advance=1, description=f"exploring, {failed} failed")

        yield advance


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.multi_srt", description=__doc__)
    parser.add_argument("--seeds", type=int, default=SEEDS, help=f"for each cell ({SEEDS})")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes (all cores)")
    parser.add_argument(
        "--out", type=Path, help="the report (docs/results/multi-srt.md); raw results go beside it"
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"{QUICK_SEEDS} seeds, teams of {', '.join(map(str, QUICK_TEAMS))}, "
        "to out/multi-srt-quick.md unless --out is given",
    )
    parser.add_argument(
        "--limit", type=float, default=300.0, help="seconds that a run may take (300)"
    )
    parser.add_argument("--retry", action="store_true", help="repeat runs that failed")
    given = parser.parse_args()
    if given.out is None:
        given.out = Path("out/multi-srt-quick.md" if given.quick else "docs/results/multi-srt.md")
    if given.out.suffix == ".jsonl":
        parser.error("--out names the report; the raw results beside it end in .jsonl")
    for name in ("seeds", "workers", "limit"):
        if getattr(given, name) <= 0:
            parser.error(f"--{name} is a positive number, not {getattr(given, name)}")
    return given


def _command(given: argparse.Namespace) -> str:
    what = "--quick" if given.quick else f"--seeds {given.seeds}"
    return f"python -m benchmarks.multi_srt {what} --limit {given.limit:g}"


if __name__ == "__main__":
    main()
