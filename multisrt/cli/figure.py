"""`multisrt figure`: figures of runs for papers, pages and slides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from multisrt.cli.layers import without_option
from multisrt.cli.output_options import FIGURE_NAME, force_option, out_file, quiet_option
from multisrt.cli.outputs import require_place
from multisrt.cli.recordings import file_beside, recordings_in

if TYPE_CHECKING:
    from multisrt.drawing.figures import FigureOptions
    from multisrt.recording import Recording

    Writer = Callable[[str, Sequence[Recording], Path, str, FigureOptions], None]

# Their import would delay the help; a test compares these words with `multisrt.drawing.figures`.
KINDS: Final = (
    *("map", "maps", "trajectories", "coverage", "activity", "visits", "isolation", "decisions"),
)
STYLES: Final = ("ieee", "ieee-wide", "springer", "springer-wide", "screen")
COUNTS: Final = ("passes", "robots", "scans", "viewers")
TABLES: Final = (".csv", ".md", ".tex")
"""Suffixes of files that the table of decisions is written to as text."""


@click.command()
@click.argument("kind", metavar="KIND", type=click.Choice(KINDS))
@click.argument(
    "recordings", metavar="RECORDING...", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@out_file(
    "the figure: .pdf, .svg or .png; decisions also .csv, .md or .tex",
    FIGURE_NAME.format(kind="KIND"),
    several=True,
)
@force_option()
@click.option(
    "--style",
    type=click.Choice(STYLES),
    default="screen",
    show_default=True,
    metavar="STYLE",
    help=f"Width and font: {', '.join(STYLES)}.",
)
@click.option(
    "--time",
    "times_s",
    type=float,
    multiple=True,
    metavar="S",
    help="A time of 'maps' (s); repeatable.  [default: 2 s, half of the run, its end]",
)
@click.option(
    "--robot",
    "robots",
    type=int,
    multiple=True,
    metavar="N",
    help="A robot to show, from 0; repeatable: maps, trajectories, activity, decisions.  "
    "[default: all]",
)
@click.option(
    "--count",
    type=click.Choice(COUNTS),
    metavar="WHAT",
    help="What 'visits' counts: times that robots drove over a place (passes), robots that did, "
    "scans that showed it, or robots that saw it (viewers).  [default: passes]",
)
@without_option("map", "  For 'map' only; replaces the default.  [default: outlines]")
@quiet_option()
def figure(
    kind: str,
    recordings: tuple[Path, ...],
    out: Path | None,
    force: bool,
    style: str,
    quiet: bool,
    **given: Any,
) -> None:
    """Draw a figure of one or several runs.

    Each RECORDING is the folder that 'multisrt explore' wrote, of one run or several, or a file
    recording.jsonl. Several runs are drawn side by side or in one diagram. All kinds except
    decisions need runs of the same world; maps and activity show one run.

    \b
    Kinds:
      map           trees or paths, nodes, and the area that each robot saw first
      maps          each robot's own map at given times, over the true one
      trajectories  the paths of the robots
      coverage      coverage against time; median and quartiles of several runs
      activity      what each robot was doing, against time
      visits        how often places were driven over or seen
      isolation     where robots were isolated from all others, and for how long
      decisions     how often robots chose what, and why, as a table

    \b
    Styles:
      ieee, ieee-wide          3.5 in and 7.16 in, a typeface like Times, 8 pt
      springer, springer-wide  84 mm and 174 mm, sans serif, 8 pt
      screen                   6.4 in, sans serif, 9 pt

    \b
    Examples:
      multisrt figure trajectories runs/museum --style ieee --out paths.pdf
      multisrt figure maps runs/museum --time 2 --time 120 --robot 0 --robot 2
      multisrt figure coverage runs/office-* --out coverage.svg
      multisrt figure visits runs/museum --count viewers --out seen.png
      multisrt figure decisions runs/museum --out decisions.tex
    """
    from multisrt.drawing.figures import FigureOptions
    from multisrt.recording import Recording
    from multisrt.terminal import LiveLine

    paths = recordings_in(recordings)
    target = out or file_beside(recordings[0], FIGURE_NAME.format(kind=kind))
    write = _writer(kind, target)
    require_place(target, force=force)
    options = FigureOptions(
        **{name: value for name, value in given.items() if value not in ((), None)}
    )
    with LiveLine(not quiet, "reading", str(paths[0])) as live:
        runs = []
        for path in paths:
            live.update(description="reading", note=str(path))
            runs.append(Recording.load(path))
        live.update(description="drawing", note=str(target))
        write(kind, runs, target, style, options)
    if not quiet:
        click.echo(str(target))


def _writer(kind: str, target: Path) -> Writer:
    # What writes the file; a suffix that names no kind of file is an error.
    if kind == "decisions" and target.suffix.lower() in TABLES:
        return _write_table
    from multisrt.drawing.figures import format_of

    format_of(target)
    return _write_figure


def _write_figure(
    kind: str, runs: Sequence[Recording], target: Path, style: str, options: FigureOptions
) -> None:
    from multisrt.drawing.figures import save_figure

    save_figure(kind, runs, target, style=style, options=options)


def _write_table(
    kind: str, runs: Sequence[Recording], target: Path, style: str, options: FigureOptions
) -> None:
    from multisrt.drawing.figures import require_fit
    from multisrt.recording import atomic_write
    from multisrt.reporting.decisions import decision_table

    require_fit(kind, runs, options)
    table = decision_table(runs, options.robots or None)
    as_text = {".csv": table.csv, ".md": table.markdown, ".tex": table.latex}
    text = as_text[target.suffix.lower()]()
    with atomic_write(target) as file:
        file.write(text.encode())
