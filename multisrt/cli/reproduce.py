"""`multisrt reproduce`: the experiments of the papers, beside their printed figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from multisrt.cli.running import make_runs, running_options

if TYPE_CHECKING:
    from multisrt.experiments.results import Results
    from multisrt.presets import Preset
    from multisrt.reporting.claims import Claim

STORE_NAME, REPORT_NAME, SUMMARY_NAME = "results.sqlite", "report", "summary.md"

RUNS_FAILED = 3
"""Exit code where a run is not complete, or had a collision."""


@click.command()
@click.argument("name", metavar="PAPER")
@click.option("--quick", is_flag=True, help="A few cells and repetitions: some minutes.")
@click.option(
    "--seeds",
    type=click.IntRange(1, 100_000),
    metavar="N",
    help="Repetitions of every condition.  [default: see below]",
)
@running_options
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Where everything goes.  [default: reproduced/PAPER, with -quick]",
)
@click.option(
    "--store",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help=f"Where results are stored.  [default: {STORE_NAME} in DIR]",
)
@click.option("--no-gallery", is_flag=True, help="Draw no trees: nothing is simulated again.")
def reproduce(
    name: str,
    *,
    quick: bool,
    seeds: int | None,
    workers: int | None,
    cluster: str | None,
    out: Path | None,
    store: Path | None,
    retry: bool,
    no_gallery: bool,
    quiet: bool,
) -> None:
    """Repeat a paper's experiment, and say which of its claims hold here.

    PAPER is one of multi-srt, sbx-r, minpos and alvarez. Interrupted, the same command goes on
    with the runs that are missing; more repetitions can be asked for later.

    \b
    Examples:
      multisrt reproduce multi-srt --quick
      multisrt reproduce sbx-r --seeds 31 --workers 2
      multisrt reproduce minpos --cluster tcp://node1:8786

    \b
    Repetitions, in full and quick, and those of the paper:
      multi-srt    20   10    20
      sbx-r        10    5    31
      minpos       20    8    not told
      alvarez      10    7    40

    \b
    The folder gets:
      results.sqlite   every run; multisrt report and multisrt experiment read it
      report           the page, its figures and tables
      summary.md       claims and figures beside the paper's, as text

    \b
    Exit code: 0 all runs complete, 3 some are not or had a collision (the claims are judged all
    the same), 2 bad input, 130 interrupted.
    """
    import msgspec

    from multisrt.presets import preset_named
    from multisrt.presets.summary import summary
    from multisrt.recording import written_whole
    from multisrt.reporting.page import write_report
    from multisrt.terminal import LiveLine

    preset = preset_named(name)
    experiment = preset.experiment(quick)
    if seeds is not None:
        experiment = msgspec.structs.replace(experiment, repetitions=seeds)
    out = out or Path("reproduced") / (name + ("-quick" if quick else ""))
    path = store or out / STORE_NAME
    _make_folder(out)
    results = make_runs(
        path, experiment, workers=workers, cluster=cluster, retry=retry, quiet=quiet
    )
    claims, tables = preset.claims(results), preset.tables(results)
    command = f"multisrt reproduce {name}{' --quick' * quick}"
    if seeds is not None:
        command += f" --seeds {seeds}"
    text = summary(preset, results, command, claims=claims, tables=tables)
    with written_whole(out / SUMMARY_NAME) as file:
        file.write(text.encode())
    with LiveLine(not quiet, "report") as live:
        page = write_report(
            results,
            out / REPORT_NAME,
            claims=claims,
            comparisons=tables,
            gallery=not no_gallery,
            progress=live.say,
        )
    if not quiet:
        _tell(preset, results, claims)
        click.echo(f"{page}\n{out / SUMMARY_NAME}")
    if any(result.failed for result in results):
        raise SystemExit(RUNS_FAILED)


def _make_folder(folder: Path) -> None:
    from multisrt.geometry.errors import InvalidInputError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInputError(
            f"cannot make the folder {folder}: {error.strerror or error}; name another with --out"
        ) from None


def _tell(preset: Preset, results: Results, claims: list[Claim]) -> None:
    from multisrt.cli.tables import show, table

    complete = sum(result.status == "complete" for result in results)
    click.echo(f"{preset.name}: {complete} of {results.asked} runs complete")
    verdicts = table("claim", "verdict")
    for claim in claims:
        verdicts.add_row(claim.text, claim.verdict)
    show(verdicts)
