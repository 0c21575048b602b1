"""`multisrt report`: a page, figures and tables from the results of an experiment."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("results", metavar="RESULTS", type=click.Path(path_type=Path))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("report"),
    show_default=True,
    metavar="DIR",
    help="Where the report goes; one that is there already is replaced.",
)
@click.option("--latex", is_flag=True, help="Write the tables as LaTeX, too.")
@click.option(
    "--measure",
    "measures",
    multiple=True,
    metavar="NAME",
    help="What to report on; repeat for several.  [default: time, distance and coverage]",
)
@click.option(
    "--baseline",
    metavar="STRATEGY",
    help="Which strategy the others are compared with.  [default: the first]",
)
@click.option("--no-gallery", is_flag=True, help="Draw no trees: nothing is simulated again.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
def report(
    results: Path,
    out: Path,
    *,
    latex: bool,
    measures: tuple[str, ...],
    baseline: str | None,
    no_gallery: bool,
    quiet: bool,
) -> None:
    """Write a report on an experiment: one page to read and send, figures and tables beside it.

    RESULTS is the file that 'multisrt experiment run' fills. It may go on filling meanwhile.

    \b
    Examples:
      multisrt report results.sqlite --out report
      multisrt report results.sqlite --baseline srt-star --measure makespan_s --latex
    """
    from multisrt.experiments.store import Store
    from multisrt.terminal import LiveLine

    with LiveLine(not quiet, "report", "reading") as live:
        with Store.open(results) as store:
            found, folder = store.results(), store.folder
        from multisrt.reporting.page import write_report

        page = write_report(
            found,
            out,
            latex=latex,
            gallery=not no_gallery,
            measures=measures,
            baseline=baseline,
            folder=folder,
            progress=live.say,
        )
    if not quiet:
        click.echo(f"{page}: {len(found)} of {found.asked} runs")
