"""`multisrt view`: replay runs in a browser."""

from __future__ import annotations

import webbrowser
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from multisrt.cli.imports import import_all, import_option
from multisrt.cli.output_options import REPLAY_NAME, force_option, out_file, quiet_option
from multisrt.cli.outputs import require_place
from multisrt.cli.recordings import file_beside, recordings_in

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from multisrt.recording import Recording
    from multisrt.replay import LiveReplay

MAX_RUNS = 4
"""Upper bound of the runs on a page; a test compares it with that of `multisrt.replay`."""


@click.command()
@click.argument(
    "recordings",
    metavar="RECORDING...",
    nargs=-1,
    required=True,
    type=click.Path(path_type=Path),
)
@out_file("the page", REPLAY_NAME, several=True)
@force_option()
@click.option("--no-open", is_flag=True, help="Do not open the page in a browser.")
@import_option
@quiet_option()
def view(
    recordings: tuple[Path, ...],
    *,
    out: Path | None,
    force: bool,
    no_open: bool,
    imports: tuple[str, ...],
    quiet: bool,
) -> None:
    """Replay a run in a browser, or up to four side by side.

    Writes one HTML file that needs no network and no server, and opens it.

    RECORDING is the folder that 'multisrt explore' wrote, of one run or several, or a file
    recording.jsonl.

    \b
    Examples:
      multisrt view runs/office-srt-radial-0
      multisrt view runs/office-0
      multisrt view out/srt-radial out/minpos --out both.html
      multisrt view out/recording.jsonl --no-open --force
    """
    from multisrt.recording import Recording
    from multisrt.terminal import LiveLine

    require_few(len(recordings))
    import_all(imports)
    paths = recordings_in(recordings)
    require_few(len(paths))
    page = out or file_beside(recordings[0], REPLAY_NAME)
    require_place(page, force=force)
    with LiveLine(not quiet, "reading") as line:
        loaded = []
        for path in paths:
            line.update(description="reading", note=str(path))
            loaded.append(Recording.load(path))
        line.update(description="writing", note=str(page))
        write_page(loaded, page)
    if not quiet:
        click.echo(page)
    open_page(page, opens=not no_open)


def require_few(runs: int) -> None:
    """Check that this number of runs can be shown side by side."""
    if runs > MAX_RUNS:
        raise click.UsageError(f"a replay shows at most {MAX_RUNS} runs, not {runs}")


def write_page(recordings: Sequence[Recording], page: Path) -> None:
    """Write the replay of some runs."""
    from multisrt.replay import save_replay

    save_replay(recordings, page)


@contextmanager
def live_page(page: Path | None, *, opens: bool) -> Iterator[LiveReplay | None]:
    """Write the replay of runs while they go on, if there is a page for it.

    Parameters
    ----------
    page : Path or None
        The page; None to write nothing.
    opens : bool
        Whether it is opened in a browser at once.

    Yields
    ------
    LiveReplay or None
        What looks at the runs.
    """
    if page is None:
        yield None
        return
    from multisrt.replay import LiveReplay

    def show() -> None:
        if opens:
            open_page(page)
        else:
            click.echo(f"the runs as they go on: open {page} in a browser", err=True)

    live = LiveReplay(page, when_shown=show)
    try:
        with live:
            yield live
    except BaseException:
        if live.pages:
            click.echo(f"the replay up to here: {page}", err=True)
        raise


def open_page(page: Path, *, opens: bool = True) -> None:
    """Open a page in the user's browser if it `opens`, or report that there is none."""
    if opens and not webbrowser.open(page.resolve().as_uri()):
        click.echo(f"no browser could be opened: open {page} in one", err=True)
