"""The page of a replay: one file, which needs neither a network nor a server."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Final, NamedTuple

from multisrt.drawing.svg import printable
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording, atomic_write
from multisrt.replay.payload import compressed, payloads

MAX_BYTES: Final = 20_000_000
"""Upper bound of the size of a page, in bytes."""

MAX_RUNS: Final = 4
"""Upper bound of the runs on a page."""

SCRIPTS: Final = (
    "decode",
    "geometry",
    "colours",
    "run",
    "frontier",
    "camera",
    "pictures",
    "tiles",
    "view",
    "ground",
    "brush",
    "bodies",
    "marks",
    "plots",
    "curves",
    "strips",
    "legend",
    "symbols",
    "panel",
    "player",
    "address",
    "live",
    "main",
)
"""The parts of the script, in the order in which they follow one another."""


class Status(NamedTuple):
    """What the page says of a run that goes on or was interrupted.

    Attributes
    ----------
    said : str
        The text.
    reload_s : float or None
        Time after which the page reloads itself, in seconds; None if it does not.
    number : int
        Number of the page, which tells a new one from an old one.
    """

    said: str
    reload_s: float | None = None
    number: int = 0


def replay_html(recordings: Recording | Sequence[Recording]) -> str:
    """Return a page that replays runs in a browser.

    Parameters
    ----------
    recordings : Recording or sequence of Recording
        One run, or up to four that are shown side by side on one clock.

    Returns
    -------
    str
        An HTML document of at most 20 MB that loads nothing else. Equal recordings give equal
        documents. To stay below that size, outlines of regions are simplified and explanations
        reduced, as the page then says.

    Raises
    ------
    InvalidInputError
        If there are no runs or more than four, a recording contradicts itself, or the page would
        be larger.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.replay import replay_html
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> replay_html(run.recording).startswith("<!doctype html>")
    True
    """
    runs = [recordings] if isinstance(recordings, Recording) else list(recordings)
    if not 1 <= len(runs) <= MAX_RUNS:
        raise InvalidInputError(f"a replay shows 1 to {MAX_RUNS} runs, not {len(runs)}")
    titles = [title_of(run) for run in runs]
    for data in payloads(runs):
        page = page_html(titles, compressed(data))
        size = len(page.encode())
        if size <= MAX_BYTES:
            return page
    several = " fewer runs, or" if len(runs) > 1 else ""
    raise InvalidInputError(
        f"the replay would have {size / 1e6:.0f} MB, more than {MAX_BYTES / 1e6:.0f}: "
        f"show{several} runs of less time (--max-time) or fewer robots"
    )


def save_replay(recordings: Recording | Sequence[Recording], path: str | Path) -> None:
    """Write a page that replays runs in a browser; see `replay_html`.

    Parameters
    ----------
    recordings : Recording or sequence of Recording
        One run, or up to four.
    path : str or Path
        The file; it is written completely or not at all.

    Raises
    ------
    InvalidInputError
        As `replay_html` does, or if the file cannot be written.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.replay import save_replay
    >>> run = ms.explore("open", seed=1, max_time_s=10.0)
    >>> save_replay(run.recording, "replay.html")
    """
    page = replay_html(recordings)
    with atomic_write(Path(path)) as file:
        file.write(page.encode())


def title_of(recording: Recording) -> str:
    """Return the name of a run in the title of a page."""
    return f"{recording.spec.strategy} in {recording.header.world}"


def page_html(titles: Sequence[str], data: str, status: Status | None = None) -> str:
    """Return the page with data of runs.

    Parameters
    ----------
    titles : sequence of str
        Names of the runs.
    data : str
        Their data, compressed.
    status : Status, optional
        That of a run that goes on or was interrupted.

    Returns
    -------
    str
        An HTML document.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    template = Environment(
        loader=PackageLoader("multisrt", "replay"), autoescape=True, undefined=StrictUndefined
    ).get_template("page.html.j2")
    style, script = _source("page.css"), _script()
    return template.render(
        title=printable(" | ".join(titles)),
        style=style,
        script=script,
        style_hash=_hash(style),
        script_hash=_hash(script),
        data=data,
        status=status and status._replace(said=printable(status.said)),
    )


def _script() -> str:
    parts = [_source(f"{name}.js") for name in SCRIPTS]
    return '\n(() => {\n"use strict";\n' + "\n".join(parts) + "})();\n"


def _source(name: str) -> str:
    return files("multisrt.replay").joinpath(name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    # As Content-Security-Policy names what may run.
    return f"'sha256-{b64encode(sha256(text.encode()).digest()).decode()}'"
