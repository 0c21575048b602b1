"""`multisrt experiment`: describe, check, run and export many runs that are compared."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from multisrt.cli import candidates
from multisrt.cli.experiment_check import check
from multisrt.cli.imports import import_all, import_option, imports_again
from multisrt.cli.mistakes import CommandGroup
from multisrt.cli.output_options import force_option, quiet_option, store_option
from multisrt.cli.outputs import require_no_file
from multisrt.cli.running import Running, make_runs, print_gaps, running_options
from multisrt.cli.spec_files import read_experiment

if TYPE_CHECKING:
    from multisrt.experiments.results import Results

NO_SUCCESS = 3
"""Exit code if some runs did not succeed."""

MAX_FAILURES = 10
"""Runs without success that are printed; the others are only counted."""

EXAMPLES = """
\b
Examples, in the order of the work:
  multisrt experiment new star.toml
  multisrt experiment check star.toml
  multisrt experiment run star.toml --workers 2
  multisrt report star.sqlite --out report
  multisrt experiment export star.sqlite star.csv
"""


def _meant(words: Sequence[str]) -> Sequence[str]:
    return ("run", *words) if Path(words[0]).suffix == ".toml" else ()


@click.group(cls=CommandGroup, meant=_meant, epilog=EXAMPLES)
def experiment() -> None:
    """Describe, run and export comparisons of strategies.

    A TOML file describes the conditions: environments, strategies, teams, radios, faults. They
    are crossed, repeated with different seeds, and the results stored in one SQLite file.
    """


@experiment.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.option(
    "--like",
    metavar="PAPER",
    shell_complete=candidates.papers,
    help="Copy the experiment of 'multisrt reproduce PAPER'.",
)
@click.option(
    "--schema/--no-schema",
    default=True,
    show_default=True,
    help="Write a JSON Schema next to FILE, for completion and checks in editors.",
)
def new(file: Path, like: str | None, schema: bool) -> None:
    """Write an experiment file to start from.

    FILE (.toml) explains every field. Editors with Taplo or Even Better TOML find the schema by
    its first line. An existing file is not overwritten.

    \b
    Examples:
      multisrt experiment new star.toml
      multisrt experiment new papers/minpos.toml --like minpos --no-schema
    """
    from multisrt.experiments.template import write_new
    from multisrt.presets import preset_named

    if file.suffix != ".toml":
        raise click.BadParameter(f"{file} must have the suffix .toml", param_hint="FILE")
    preset = None if like is None else preset_named(like).experiment(False)
    for path in write_new(file, like=preset, with_schema=schema):
        click.echo(path)
    click.echo(f"next: multisrt experiment check {shlex.quote(str(file))}")


experiment.add_command(check)


@experiment.command()
@click.argument(
    "file",
    metavar="FILE",
    type=click.Path(path_type=Path),
    shell_complete=candidates.files_named(".toml"),
)
@store_option()
@running_options
@click.option(
    "--recordings",
    type=click.Choice(["none", "failed", "all"]),
    help="Recordings to keep in addition to the results.  [default: as in FILE]",
)
@import_option
@click.option(
    "--remake", is_flag=True, help="Repeat runs of strategies of your own that have changed since."
)
def run(
    file: Path,
    store: Path | None,
    recordings: str | None,
    imports: tuple[str, ...],
    remake: bool,
    running: Running,
) -> None:
    """Execute the runs of an experiment that have no result yet.

    Each run is stored when it ends; after an interruption of any kind the same command continues.
    Repetitions or conditions may be added to the experiment at any time. If only the reference is
    added, only plans are computed.

    \b
    Examples:
      multisrt experiment run star.toml
      multisrt experiment run star.toml --workers 2 --recordings all
      multisrt experiment run star.toml --cluster tcp://node1:8786
      multisrt experiment run star.toml --reference informed
      multisrt experiment run mine.toml --import mine.py --retry

    \b
    Exit code:
      0  all runs succeeded: enough covered, no collision   2    bad input
      3  some runs did not succeed                          130  interrupted
    """
    import msgspec

    import_all(imports)
    running = replace(running, remake=remake)
    spec = read_experiment(file)
    if recordings is not None:
        spec = msgspec.structs.replace(spec, recordings=recordings)
    path = file.with_suffix(".sqlite") if store is None else store
    results = make_runs(path, spec, file.parent, running=running, modules=imports)
    if not running.quiet:
        _print_results(results, path, imports)
    if any(result.failed for result in results):
        raise SystemExit(NO_SUCCESS)


def _print_results(results: Results, path: Path, imports: tuple[str, ...]) -> None:
    from multisrt.reporting.overview import overview_table
    from multisrt.reporting.words import totals
    from multisrt.terminal import terminal_width

    click.echo(f"{results.experiment.name}: {totals(results)}, in {path}\n")
    if any(result.metrics is not None for result in results):
        click.echo(overview_table(results).text(terminal_width()))
        print_gaps(results)
    _print_failures(results, path)
    store, out = shlex.quote(str(path)), shlex.quote(f"{path.with_suffix('')}-report")
    click.echo(f"next: multisrt report {store} --out {out}{imports_again(imports)}")


def _print_failures(results: Results, path: Path) -> None:
    from multisrt.experiments.store import UNFINISHED

    failed = [result for result in results if result.failed and result.same_as is None]
    for result in failed[:MAX_FAILURES]:
        ended = f"{result.status}, unsuccessful" if result.status == "complete" else result.status
        where = f"[{result.condition}] repetition {result.repetition}"
        click.echo(f"{ended}: {where}: {result.account}")
    if len(failed) > MAX_FAILURES:
        click.echo(f"... and {len(failed) - MAX_FAILURES} more, which {path} and the report list")
    if any(result.status in UNFINISHED for result in failed):
        click.echo("--retry repeats runs that failed without a result")


@experiment.command()
@click.argument(
    "results",
    metavar="RESULTS",
    type=click.Path(path_type=Path),
    shell_complete=candidates.files_named(".sqlite"),
)
@click.argument("out", metavar="OUT", type=click.Path(path_type=Path))
@force_option("OUT")
@quiet_option()
def export(results: Path, out: Path, force: bool, quiet: bool) -> None:
    """Write results as a table (.csv or .parquet).

    OUT has one row for each run. Parquet needs pyarrow: pip install 'multisrt[parquet]'.

    \b
    Examples:
      multisrt experiment export star.sqlite star.csv
      multisrt experiment export star.sqlite star.parquet
    """
    from multisrt.experiments.frames import export as write
    from multisrt.terminal import LiveLine

    require_no_file(out, force=force)
    with LiveLine(not quiet, "reading", str(results)):
        many = write(results, out)
    if not quiet:
        click.echo(f"{out}: {many} runs")
