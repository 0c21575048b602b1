"""HTML for notebooks: tables and pictures that are readable in light and dark themes.

It has no scripts and no colours of its own: text inherits the colour of the theme, and lines are a
grey that is visible on white and on black.
"""

from __future__ import annotations

import base64
import sys
from collections.abc import Iterable, Sequence
from html import escape
from importlib import import_module
from typing import Any, Final

LINE: Final = "1px solid rgba(128, 128, 128, 0.45)"
_CELL: Final = "padding: 0.15em 0.8em 0.15em 0; background: transparent; vertical-align: baseline"


def table_html(
    title: str,
    columns: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    labels: int = 1,
    notes: Iterable[str] = (),
) -> str:
    """Return a table as HTML.

    Parameters
    ----------
    title : str
        Title above the table.
    columns : sequence of str
        Headings; without any the table has none.
    rows : iterable of sequence of str
        Texts of the cells.
    labels : int
        Number of leading columns with labels, flush left; the others are flush right.
    notes : iterable of str
        Paragraphs below the table.

    Returns
    -------
    str
        The HTML; all texts are escaped.

    Examples
    --------
    >>> "<td" in table_html("Times", ["world", "s"], [["maze", "12.0"]])
    True
    >>> table_html("<b>", [], []).count("<b>")
    0
    """
    line = f"; border-bottom: {LINE}"
    head = "".join(_cell(text, k < labels, "th", line) for k, text in enumerate(columns))
    body = "".join(
        f"<tr>{''.join(_cell(text, k < labels, 'td') for k, text in enumerate(row))}</tr>\n"
        for row in rows
    )
    below = "".join(f'<p style="margin: 0.3em 0; max-width: 60em">{_text(n)}</p>' for n in notes)
    return (
        f'<div style="font-weight: bold; margin: 0.3em 0">{_text(title)}</div>\n'
        f'<div style="overflow-x: auto" role="region" tabindex="0" aria-label="{_text(title)}">\n'
        '<table style="border-collapse: collapse; border: none; margin: 0">\n'
        + (f"<thead><tr>{head}</tr></thead>\n" if head else "")
        + f"<tbody>\n{body}</tbody>\n</table>\n</div>\n"
        + (f'<div style="font-size: 0.9em; opacity: 0.8">{below}</div>\n' if below else "")
    )


def picture_html(svg: str | bytes, alt: str) -> str:
    """Return an SVG document as HTML, as wide as there is room.

    It is embedded as an image: names within it cannot clash with those of other pictures on the
    page.

    Parameters
    ----------
    svg : str or bytes
        The document.
    alt : str
        Text for readers who cannot see it.

    Returns
    -------
    str
        The HTML.

    Examples
    --------
    >>> picture_html("<svg/>", 'a "map"').partition("alt=")[2]
    '"a &quot;map&quot;" style="max-width: 100%; height: auto">'
    """
    data = base64.b64encode(svg.encode() if isinstance(svg, str) else svg).decode()
    return (
        f'<img src="data:image/svg+xml;base64,{data}" alt="{_text(alt)}" '
        'style="max-width: 100%; height: auto">'
    )


class Text(str):
    r"""A text of several lines that shows itself as it reads, at the prompt and in a notebook.

    Examples
    --------
    >>> Text("one\ntwo")
    one
    two
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def is_notebook() -> bool:
    """Return whether this process is the kernel of a notebook."""
    ipython: Any = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return shell is not None and getattr(shell, "kernel", None) is not None


class RewrittenText:
    """A line of text in a notebook that is updated in place.

    Parameters
    ----------
    text : str
        The text at first.
    """

    def __init__(self, text: str) -> None:
        display: Any = import_module("IPython.display")
        self._text = text
        self._shown = display.DisplayHandle()
        self._shown.display(_plain(text), raw=True)

    def say(self, text: str) -> None:
        """Write another text in its place."""
        if text != self._text:
            self._text = text
            self._shown.update(_plain(text), raw=True)


def _plain(text: str) -> dict[str, str]:
    return {"text/plain": text}


def _cell(text: str, is_label: bool, tag: str, more: str = "") -> str:
    side = "left" if is_label else "right"
    return f'<{tag} style="text-align: {side}; {_CELL}{more}">{_text(text)}</{tag}>'


def _text(text: str) -> str:
    # What is neither printable nor a space has no place in a page.
    return escape("".join(letter if letter.isprintable() else " " for letter in text))
