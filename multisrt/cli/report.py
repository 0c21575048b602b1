"""`multisrt report`: a page, figures and tables of an experiment's results."""

from __future__ import annotations

from pathlib import Path

import click

from multisrt.cli import candidates
from multisrt.cli.imports import import_all, import_option
from multisrt.cli.output_options import out_folder, quiet_option


@click.command()
@click.argument(
    "results",
    metavar="RESULTS",
    type=click.Path(path_type=Path),
    shell_complete=candidates.files_named(".sqlite"),
)
@out_folder("the report; a report that is already there is replaced", "report")
@click.option("--latex", is_flag=True, help="Also write the tables as LaTeX.")
@click.option(
    "--measure",
    "measures",
    multiple=True,
    metavar="NAME",
    help="Measure to report; repeatable.  [default: times, distance and coverage]",
)
@click.option(
    "--baseline",
    metavar="STRATEGY",
    shell_complete=candidates.labels,
    help="Strategy that the others are compared with.  [default: the first]",
)
@import_option
@click.option("--no-gallery", is_flag=True, help="Omit the trees, which need some runs repeated.")
@click.option(
    "--no-replays", is_flag=True, help="Omit the replays of these runs, which are separate pages."
)
@quiet_option()
def report(
    results: Path,
    out: Path | None,
    *,
    latex: bool,
    measures: tuple[str, ...],
    baseline: str | None,
    imports: tuple[str, ...],
    quiet: bool,
    **left_out: bool,
) -> None:
    """Write a report of an experiment's results.

    The report is one self-contained HTML page, with files of its figures and tables. RESULTS is the
    file written by 'multisrt experiment run', which may still be running. Times relative to a
    team that knows the map are included if that command had --reference informed. Pictures of
    strategies of your own need --import.

    \b
    Examples:
      multisrt report star.sqlite --out report
      multisrt report star.sqlite --no-replays
      multisrt report star.sqlite --baseline srt-star --measure makespan_s
      multisrt report mine.sqlite --import mine.py
    """
    if results.suffix == ".toml":
        raise click.BadParameter(
            f"{results} describes an experiment; its results are in "
            f"{results.with_suffix('.sqlite')}, which 'multisrt experiment run {results}' writes",
            param_hint="RESULTS",
        )
    import_all(imports)
    from multisrt.experiments.store import Store
    from multisrt.terminal import LiveLine

    with LiveLine(not quiet, "report", "reading") as live:
        with Store.open(results) as store:
            found, folder = store.results(), store.folder
        from multisrt.reporting.custom_strategies import cautions
        from multisrt.reporting.page import write_report

        page = write_report(
            found,
            out or Path("report"),
            latex=latex,
            gallery=not left_out["no_gallery"],
            replays=not left_out["no_replays"],
            measures=measures,
            baseline=baseline,
            folder=folder,
            progress=live.say,
        )
    if not quiet:
        for caution in cautions(found):
            click.echo(f"warning: {caution}", err=True)
        click.echo(f"{page}: {len(found)} of {found.planned} runs")
