"""`multisrt experiment`: describe, check, run and export many runs that are compared."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from multisrt.cli.given import described
from multisrt.cli.running import make_runs, running_options

if TYPE_CHECKING:
    from collections.abc import Sequence

    from multisrt.experiments.crossing import Condition, PlannedRun
    from multisrt.experiments.description import ExperimentSpec, Limits
    from multisrt.experiments.estimate import Estimate
    from multisrt.experiments.results import Result, Results

NOT_COMPLETE = 3
"""Exit code where some runs are not complete."""

MOST_ROWS = 24
"""A longer table of conditions is cut."""

MOST_FAILURES = 10

EXAMPLES = """
\b
Examples:
  multisrt experiment new star.toml
  multisrt experiment check star.toml
  multisrt experiment run star.toml --workers 2
  multisrt report star.sqlite --out report
  multisrt experiment export star.sqlite star.csv
"""


@click.group(epilog=EXAMPLES)
def experiment() -> None:
    """Compare strategies over worlds, teams and repetitions, described in a file."""


# New ----------------------------------------------------------------------------------------


@experiment.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.option("--like", metavar="PRESET", help="Copy a preset of 'multisrt reproduce'.")
@click.option(
    "--schema/--no-schema",
    default=True,
    show_default=True,
    help="Write a JSON Schema beside it, by which editors complete and check.",
)
def new(file: Path, like: str | None, schema: bool) -> None:
    """Write an experiment to begin with: FILE, in TOML, with every part of it explained.

    Editors with Taplo or Even Better TOML find the schema by the file's first line. A file that
    is there already is left alone.

    \b
    Examples:
      multisrt experiment new star.toml
      multisrt experiment new papers/minpos.toml --like minpos --no-schema
    """
    from multisrt.experiments.template import write_new
    from multisrt.presets import preset_named

    if file.suffix != ".toml":
        raise click.BadParameter(f"{file} is to be TOML: call it .toml", param_hint="FILE")
    preset = None if like is None else preset_named(like).experiment(False)
    for path in write_new(file, like=preset, with_schema=schema):
        click.echo(path)
    click.echo(f"next: multisrt experiment check {file}")


# Check --------------------------------------------------------------------------------------


@experiment.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.option("--workers", type=click.IntRange(1), metavar="N", help="For how many to estimate.")
@click.option(
    "--seconds",
    default=30.0,
    show_default=True,
    type=click.FloatRange(0.0),
    help="How long to try runs for the estimate; 0 tries none.",
)
@click.option("--import", "modules", multiple=True, metavar="MODULE", help="As for 'run'.")
def check(file: Path, workers: int | None, seconds: float, modules: tuple[str, ...]) -> None:
    """Tell how many runs an experiment has, which, and about how long they take.

    For the estimate a few runs are made, the cheap ones first, and thrown away.

    \b
    Examples:
      multisrt experiment check star.toml
      multisrt experiment check star.toml --seconds 120 --workers 16
      multisrt experiment check star.toml --seconds 0
    """
    from multisrt.experiments.crossing import runs
    from multisrt.experiments.worker import import_modules

    import_modules(modules)
    spec = read_experiment(file)
    planned = runs(spec, file.parent)
    everything = list(dict.fromkeys(run.condition for run in planned))
    many = "s" * (spec.repetitions != 1)
    click.echo(
        f"{spec.name}: {len(planned)} runs, {len(everything)} conditions of "
        f"{spec.repetitions} repetition{many} (seeds {spec.first_seed} to "
        f"{spec.first_seed + spec.repetitions - 1})"
    )
    troubles = _impossible_starts(planned)
    found = _estimate(spec, planned, seconds, modules) if seconds else None
    _print_conditions(everything, {} if found is None else found.by_condition_s)
    if found is not None:
        _print_estimate(found, len(everything), workers)
        troubles |= _troubles(found.probes)
    elif seconds:
        click.echo("no estimate: none of the runs that were tried came to an end")
    for condition, reason in troubles.items():
        click.echo(f"warning: [{condition}]: {reason}", err=True)
    click.echo(f"next: multisrt experiment run {file}")


def read_experiment(path: Path) -> ExperimentSpec:
    """Read an experiment from a TOML file, or from JSON if it is called so.

    Raises
    ------
    InvalidInputError
        If it cannot be read or is no experiment; the message says what is wrong.
    """
    from multisrt.experiments.description import ExperimentSpec

    return described(path, ExperimentSpec.from_toml, ExperimentSpec.from_json)


def _impossible_starts(planned: Sequence[PlannedRun]) -> dict[Condition, str]:
    # Conditions whose first repetition has no room for its team.
    import msgspec

    from multisrt.experiments.mission import world_of
    from multisrt.geometry.errors import InvalidInputError
    from multisrt.simulation.starts import starts_of

    found: dict[Condition, str] = {}
    tried: dict[Condition, str] = {}
    for run in planned:
        if run.repetition:
            break
        alike = msgspec.structs.replace(run.condition, strategy="", radio="", faults="")
        if alike not in tried:
            try:
                starts_of(run.spec, world_of(run.spec.environment))
                tried[alike] = ""
            except InvalidInputError as error:
                tried[alike] = str(error)
        if tried[alike]:
            found[run.condition] = tried[alike]
    return found


def _estimate(
    spec: ExperimentSpec, planned: list[PlannedRun], seconds: float, modules: tuple[str, ...]
) -> Estimate | None:
    import msgspec

    from multisrt.experiments.estimate import estimate
    from multisrt.experiments.live import LiveProgress
    from multisrt.experiments.runner import job_of
    from multisrt.experiments.worker import Worker

    worker = Worker(modules)

    def make(run: PlannedRun, limits: Limits) -> Result:
        plain = msgspec.structs.replace(spec, limits=limits, recordings="none")
        return worker.make(job_of(run, plain))

    with LiveProgress() as live:
        try:
            return estimate(
                spec,
                planned,
                make,
                budget_s=seconds,
                watch=lambda run: live.say(f"trying [{run.condition}]"),
            )
        finally:
            worker.stop()


def _print_conditions(everything: list[Condition], took: dict[Condition, float]) -> None:
    from multisrt.cli.tables import show, table

    # A column for what varies; what does not is said once.
    names = ("environment", "strategy", "robots", "team", "starts", "radio", "body", "faults")
    varying = [
        name
        for name in names
        if len({getattr(one, name) for one in everything}) > 1
        or name in ("environment", "strategy", "robots")
    ]
    made = table(
        *(">robots" if name == "robots" else name for name in varying),
        *([">a run"] if took else []),
    )
    shown = everything if len(everything) <= MOST_ROWS else everything[: MOST_ROWS - 4]
    for one in shown:
        cells = [str(getattr(one, name)) for name in varying]
        made.add_row(*cells, *([f"{took[one]:.2g} s"] if took else []))
    show(made)
    if len(shown) < len(everything):
        click.echo(f"... and {len(everything) - len(shown)} more conditions")
    fixed = [f"{n} {getattr(everything[0], n)}" for n in names if n not in varying and n != "team"]
    if fixed:
        click.echo(f"all: {', '.join(fixed)}")


def _print_estimate(found: Estimate, conditions: int, workers: int | None) -> None:
    from multisrt.experiments.live import duration
    from multisrt.experiments.runner import cores

    number = workers or cores()
    told = [duration(s / number) for s in (found.computing_s, found.low_s, found.high_s)]
    tried = len(found.probes)
    click.echo(
        f"about {told[0]} with {number} worker{'s' * (number != 1)} ({told[1]} to {told[2]}), as "
        f"{tried} of {conditions} conditions took in one run each"
        + (", and the others by their labels and team sizes" if tried < conditions else "")
        + f" ({duration(found.took_s)} to find out)"
    )
    if found.cut_off:
        click.echo(
            f"{found.cut_off} of those runs did not end in time: it will take longer; "
            "allow more --seconds"
        )


def _troubles(probes: Sequence[Result]) -> dict[Condition, str]:
    return {
        probe.condition: f"{probe.status}: {probe.reason}"
        for probe in probes
        if probe.status not in ("complete", "over_time")
    }


# Run ----------------------------------------------------------------------------------------


@experiment.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.option(
    "--store",
    type=click.Path(path_type=Path),
    metavar="RESULTS",
    help="Where results go.  [default: FILE with .sqlite for its suffix]",
)
@running_options
@click.option(
    "--recordings",
    type=click.Choice(["none", "failed", "all"]),
    help="Which recordings are kept.  [default: as FILE says]",
)
@click.option(
    "--import",
    "modules",
    multiple=True,
    metavar="MODULE",
    help="A module that registers strategies; repeat for several.",
)
def run(
    file: Path,
    store: Path | None,
    workers: int | None,
    cluster: str | None,
    recordings: str | None,
    retry: bool,
    modules: tuple[str, ...],
    quiet: bool,
) -> None:
    """Make the runs of an experiment that have no result yet.

    Every run is stored as it ends: interrupted, whatever by, the same command goes on. The
    experiment may grow meanwhile, by more repetitions or conditions.

    \b
    Examples:
      multisrt experiment run star.toml
      multisrt experiment run star.toml --workers 2 --store results.sqlite --recordings all
      multisrt experiment run star.toml --cluster tcp://node1:8786
      multisrt experiment run mine.toml --import my_strategy --retry

    \b
    Exit code: 0 all complete, 3 some runs are not complete, 2 bad input, 130 interrupted.
    """
    import msgspec

    from multisrt.experiments.worker import import_modules

    import_modules(modules)
    spec = read_experiment(file)
    if recordings is not None:
        spec = msgspec.structs.replace(spec, recordings=recordings)
    path = file.with_suffix(".sqlite") if store is None else store
    results = make_runs(
        path,
        spec,
        file.parent,
        workers=workers,
        cluster=cluster,
        retry=retry,
        quiet=quiet,
        modules=modules,
    )
    if not quiet:
        _print_results(results, path)
    if any(result.status != "complete" for result in results):
        raise SystemExit(NOT_COMPLETE)


def _print_results(results: Results, path: Path) -> None:
    from multisrt.reporting.tables import summary_table

    complete = sum(result.status == "complete" for result in results)
    click.echo(
        f"{results.experiment.name}: {complete} of {results.asked} runs complete, in {path}\n"
    )
    if complete:
        click.echo(summary_table(results, "exploration_time_s").text(_width()))
    _print_failures(results, path)
    click.echo(f"next: multisrt report {path} --out {path.with_suffix('')}-report")


def _print_failures(results: Results, path: Path) -> None:
    from multisrt.experiments.store import UNFINISHED

    failed = [result for result in results if result.failed]
    for result in failed[:MOST_FAILURES]:
        said = result.reason if result.status != "complete" else "collided"
        click.echo(f"{result.status}: [{result.condition}] repetition {result.repetition}: {said}")
    if len(failed) > MOST_FAILURES:
        click.echo(f"... and {len(failed) - MOST_FAILURES} more, as {path} and the report tell")
    if any(result.status in UNFINISHED for result in failed):
        click.echo("what did not come to an end is made again by --retry")


def _width() -> int:
    import shutil
    import sys

    from multisrt.cli.tables import WIDTH

    return shutil.get_terminal_size((WIDTH, 24)).columns if sys.stdout.isatty() else WIDTH


# Export -------------------------------------------------------------------------------------


@experiment.command()
@click.argument("results", metavar="RESULTS", type=click.Path(path_type=Path))
@click.argument("out", metavar="OUT", type=click.Path(path_type=Path))
def export(results: Path, out: Path) -> None:
    """Write results as a table, a row for each run: OUT is .csv, or .parquet.

    Parquet needs pyarrow: pip install multisrt[frames].

    \b
    Examples:
      multisrt experiment export star.sqlite star.csv
      multisrt experiment export star.sqlite star.parquet
    """
    from multisrt.experiments.frames import export as write

    many = write(results, out)
    click.echo(f"{out}: {many} runs")
