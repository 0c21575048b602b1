"""`multisrt reproduce`: the experiments of the papers, beside their published figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from multisrt.cli import candidates
from multisrt.cli.output_options import out_folder
from multisrt.cli.own_map import OwnMap, map_options
from multisrt.cli.running import Running, make_runs, missing_runs, print_gaps, running_options

if TYPE_CHECKING:
    from multisrt.experiments.results import Results
    from multisrt.experiments.spec import ExperimentSpec
    from multisrt.presets import Preset
    from multisrt.reporting.claims import Claim, PrintedTable

STORE_NAME, REPORT_NAME, SUMMARY_NAME = "results.sqlite", "report", "summary.md"
ABLATIONS = "-ablations"
"""What is added to the name of the store, for that of the ablations."""

RUNS_FAILED = 3
"""Exit code if a run is not a success."""


@dataclass(frozen=True, slots=True)
class Omitted:
    """What is left out on request."""

    ablations: bool
    gallery: bool


def omit_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options --no-ablations and --no-gallery, which the command takes as `omitted`."""

    @wraps(command)
    def with_omitted(*args: Any, no_ablations: bool, no_gallery: bool, **others: Any) -> None:
        command(*args, omitted=Omitted(ablations=no_ablations, gallery=no_gallery), **others)

    decorated = click.option(
        "--no-gallery", is_flag=True, help="Omit the trees, which need some runs repeated."
    )(with_omitted)
    return click.option("--no-ablations", is_flag=True, help="Omit the ablations.")(decorated)


@click.command()
@click.argument("name", metavar="PAPER", shell_complete=candidates.papers)
@click.option(
    "--quick", is_flag=True, help="Fewer conditions and repetitions: takes a few minutes."
)
@click.option(
    "--seeds",
    type=click.IntRange(1, 100_000),
    metavar="N",
    help="Repetitions of every condition, except in ablations.  [default: see above]",
)
@map_options
@running_options
@out_folder("all files", "reproduced/PAPER, PAPER-quick, or PAPER-on-MAP")
@click.option(
    "--store",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help=f"File for the results.  [default: {STORE_NAME} in DIR]",
)
@omit_options
def reproduce(
    name: str,
    *,
    quick: bool,
    seeds: int | None,
    own_map: OwnMap | None,
    out: Path | None,
    store: Path | None,
    omitted: Omitted,
    running: Running,
) -> None:
    """Repeat a paper's experiment and check its claims.

    PAPER is multi-srt, sbx-r, minpos or alvarez. After an interruption the same command executes
    the missing runs; with a larger --seeds it adds repetitions.

    \b
    Examples:
      multisrt reproduce multi-srt --quick
      multisrt reproduce sbx-r --seeds 31 --workers 2
      multisrt reproduce minpos --cluster tcp://node1:8786
      multisrt reproduce alvarez --quick --reference informed
      multisrt reproduce sbx-r --map floor.yaml --seeds 10
      multisrt reproduce minpos --map hospital_section.png --resolution 0.037

    \b
    Repetitions:   full   --quick   in the paper
      multi-srt      20        10             20
      sbx-r          31         6             31
      minpos         40         8     not stated
      alvarez        20         7             40

    Ablations change one thing in a few conditions, to show the effect of a difference from the
    paper or why a claim does not hold. They are run after the experiment; with --map, only those
    in worlds that the map does not replace.

    \b
    Files written to DIR:
      results.sqlite            every run, for report and experiment
      results-ablations.sqlite  every run of the ablations, if there are any
      report                    the report: page, figures and tables
      summary.md                claims, figures and ablations, as text

    \b
    Exit code:
      0  all runs succeeded: enough covered, no collision       2    bad input
      3  some did not; the claims are judged anyway             130  interrupted
    Ablations do not count: some of them are expected to fail.
    """
    import msgspec

    from multisrt.presets import preset_named
    from multisrt.presets.summary import summary
    from multisrt.recording import atomic_write, make_folder
    from multisrt.reporting.page import write_report
    from multisrt.terminal import LiveLine

    preset = preset_named(name)
    if own_map is not None:
        preset = preset.with_map(own_map.path, own_map.resolution_m, own_map.starts_from)
    experiment = preset.experiment(quick)
    if seeds is not None:
        experiment = msgspec.structs.replace(experiment, repetitions=seeds)
    out = out or Path("reproduced") / _folder_name(name, quick, own_map)
    path = store or out / STORE_NAME
    _require_own_summary(out / SUMMARY_NAME, path)
    make_folder(out, "choose another with --out")
    ablations = None
    if preset.ablations is not None and not omitted.ablations:
        ablations = preset.ablations.experiment(preset.experiment(quick), quick=quick)
    results, ablated = _make_both(path, experiment, ablations, preset, running, quick=quick)
    claims, tables = preset.claims(results), preset.tables(results)
    command = f"multisrt reproduce {name}{' --quick' * quick}"
    if own_map is not None:
        command += f" {own_map}"
    if seeds is not None:
        command += f" --seeds {seeds}"
    if running.reference is not None:
        command += f" --reference {running.reference}"
    if omitted.ablations:
        command += " --no-ablations"
    text = summary(preset, results, command, claims=claims, tables=tables, ablations=ablated)
    with atomic_write(out / SUMMARY_NAME) as file:
        file.write(text.encode())
    with LiveLine(not running.quiet, "report") as live:
        page = write_report(
            results,
            out / REPORT_NAME,
            claims=claims,
            comparisons=[*tables, *_ablation_tables(preset, ablated)],
            gallery=not omitted.gallery,
            progress=live.say,
        )
    if not running.quiet:
        _print_verdicts(preset, results, claims)
        click.echo(f"{page}\n{out / SUMMARY_NAME}")
    if any(result.failed for result in results):
        raise SystemExit(RUNS_FAILED)


def _make_both(
    path: Path,
    experiment: ExperimentSpec,
    ablations: ExperimentSpec | None,
    preset: Preset,
    running: Running,
    *,
    quick: bool,
) -> tuple[Results, Results | None]:
    """Execute the runs of an experiment, and those of its ablations in a store beside it.

    Runs without a change that the experiment has are not made again.
    """
    beside = path.with_name(f"{path.stem}{ABLATIONS}{path.suffix}")
    ablation_s = None if preset.ablations is None else preset.ablations.run_s

    def afterwards() -> tuple[int, float]:
        if ablations is None or ablation_s is None:
            return 0, 0.0
        return missing_runs(beside, ablations, experiment), ablation_s

    results = make_runs(
        path,
        experiment,
        running=running,
        run_s=preset.quick_run_s if quick else preset.run_s,
        afterwards=afterwards,
    )
    if ablations is None:
        return results, None
    return results, make_runs(
        beside,
        ablations,
        running=replace(running, reference=None, made=path),
        run_s=ablation_s,
        what="runs of ablations",
    )


def _ablation_tables(preset: Preset, ablated: Results | None) -> list[PrintedTable]:
    if preset.ablations is None or ablated is None:
        return []
    return preset.ablations.tables(ablated)


def _folder_name(name: str, quick: bool, own_map: OwnMap | None) -> str:
    return name + ("" if own_map is None else f"-on-{own_map.path.stem}") + "-quick" * quick


def _require_own_summary(summary: Path, store: Path) -> None:
    # A summary is replaced beside the results that it sums up, and nowhere else.
    from multisrt.geometry.errors import InvalidInputError

    if summary.is_file() and not store.exists():
        raise InvalidInputError(
            f"{summary} exists already, and there are no results in {store}: choose another folder "
            "with --out"
        )


def _print_verdicts(preset: Preset, results: Results, claims: list[Claim]) -> None:
    from multisrt.cli.tables import show, table
    from multisrt.reporting.words import totals

    click.echo(f"{preset.name}: {totals(results)}")
    verdicts = table("claim", "verdict")
    for claim in claims:
        verdicts.add_row(claim.text, claim.told)
    show(verdicts)
    print_gaps(results)
