"""Tables as plain data, with their text for the terminal, HTML, LaTeX and spreadsheets."""

from __future__ import annotations

import csv
import html
import io
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from multisrt.drawing.svg import printable
from multisrt.extras.notebook import table_html
from multisrt.terminal import WIDTH

MIN_LABEL_COLUMN: Final = 12
"""Minimum width of a column of labels, in characters."""

LONG_LABEL: Final = 20
"""Length of a label from which it may be broken into lines, in characters."""

MINUS: Final = "\N{MINUS SIGN}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """A cell of a table.

    Attributes
    ----------
    text : str
        The main text.
    detail : str
        Text in smaller letters.
    mark : {"+", "-", ""}
        Significantly better, significantly worse, or neither.
    sort : float or None
        Key for sorting rows; None to sort by the text.
    data : dict or None
        Columns of a spreadsheet in place of text and detail, by name.
    """

    text: str
    detail: str = ""
    mark: str = ""
    sort: float | None = None
    data: dict[str, str | int | float] | None = None

    @property
    def line(self) -> str:
        """Text, mark and detail in one line."""
        return " ".join(part for part in (self.text, self.mark, self.detail) if part)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table.

    Attributes
    ----------
    name : str
        Stem of file names: letters, digits and hyphens.
    title : str
        Title above the table.
    columns : tuple of str
        Headings of the columns.
    rows : tuple of tuple of Cell
        Rows with one cell per column.
    labels : int
        Number of leading columns with labels; the others have numbers.
    notes : tuple of str
        Paragraphs below the table.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    labels: int = 1
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return the text for a terminal of default width."""
        return self.text()

    def text(self, width: int = WIDTH) -> str:
        """Return the text for a terminal.

        Columns that do not fit side by side follow below the others.

        Parameters
        ----------
        width : int, optional
            Width of the terminal in characters.

        Examples
        --------
        >>> rows = ((Cell(text="maze"), Cell(text="12.0")),)
        >>> print(Table(name="t", title="Times", columns=("World", "srt"), rows=rows).text())
        Times
        <BLANKLINE>
        World   srt
        -----  ----
        maze   12.0
        <BLANKLINE>
        """
        head = [_cut(column, width // 2) for column in self.columns]
        body = [[cell.line for cell in row] for row in self.rows]
        widths = [
            max(map(len, (head[i], *(row[i] for row in body)))) for i in range(len(self.columns))
        ]
        for i in range(self.labels):
            widths[i] = min(widths[i], max(MIN_LABEL_COLUMN, width // (2 * self.labels) - 2))
        lines = [self.title, ""]
        for block in self._blocks(widths, width):
            shown = [*range(self.labels), *block]
            lines.append(self._text_row(head, shown, widths))
            lines.append("  ".join("-" * widths[i] for i in shown))
            lines += [self._text_row(row, shown, widths) for row in body]
            lines.append("")
        lines += [part for note in self.notes for part in _wrapped(note, width)]
        return "\n".join(lines).rstrip() + "\n"

    def html(self, notes: Footnotes | None = None) -> str:
        """Return HTML; the headings are buttons, for a script that sorts the table.

        Parameters
        ----------
        notes : Footnotes, optional
            The notes of the page, so that each note is written once. By default the table has all
            of its notes below it.
        """
        head = "".join(
            f'<th scope="col"><button type="button">{_escaped(column)}</button></th>'
            for column in self.columns
        )
        body = "\n".join(
            f"<tr>{''.join(self._html_cell(i, cell) for i, cell in enumerate(row))}</tr>"
            for row in self.rows
        )
        below = (Footnotes() if notes is None else notes).html(self.notes)
        long = " long" * any(len(row[0].text) > LONG_LABEL for row in self.rows)
        return (
            f'<div class="scroll table" role="region" tabindex="0" '
            f'aria-label="{_escaped(self.title)}">\n'
            f'<table id="table-{self.name}" class="sorts{long}">\n'
            f"<caption>{_escaped(self.title)}</caption>\n"
            f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>\n</div>\n"
            f'<div class="notes">{below}</div>'
        )

    def notebook_html(self, *more: str) -> str:
        """Return HTML for a notebook, in which no script sorts the table.

        Parameters
        ----------
        *more : str
            Paragraphs above the notes.
        """
        rows = [[cell.line for cell in row] for row in self.rows]
        notes = (*more, *self.notes)
        return table_html(self.title, self.columns, rows, labels=self.labels, notes=notes)

    def latex(self) -> str:
        """Return LaTeX, which needs the package booktabs."""
        columns = "l" * self.labels + "r" * (len(self.columns) - self.labels)
        head = " & ".join(map(latex_escaped, self.columns))
        body = "\n".join("    " + " & ".join(map(_latex_cell, row)) + r" \\" for row in self.rows)
        notes = latex_escaped(" ".join((f"{self.title}.", *self.notes)))
        return (
            "% needs \\usepackage{booktabs}\n"
            "\\begin{table}\n  \\centering\n  \\small\n"
            f"  \\caption{{{notes}}}\n  \\label{{tab:{self.name}}}\n"
            f"  \\begin{{tabular}}{{{columns}}}\n    \\toprule\n    {head} \\\\\n    \\midrule\n"
            f"{body}\n    \\bottomrule\n  \\end{{tabular}}\n\\end{{table}}\n"
        )

    def markdown(self) -> str:
        r"""Return Markdown, as code hosts read it.

        Examples
        --------
        >>> rows = ((Cell(text="a|b"), Cell(text="12.0")),)
        >>> print(Table(name="t", title="Times", columns=("World", "s"), rows=rows).markdown())
        Times
        <BLANKLINE>
        | World | s |
        |---|---:|
        | a\|b | 12.0 |
        <BLANKLINE>
        """
        aligned = ["---"] * self.labels + ["---:"] * (len(self.columns) - self.labels)
        rows = [self.columns, *(tuple(cell.line for cell in row) for row in self.rows)]
        written = [
            "| " + " | ".join(printable(text).replace("|", r"\|") for text in row) + " |"
            for row in rows
        ]
        lines = [self.title, "", written[0], f"|{'|'.join(aligned)}|", *written[1:]]
        notes = [line for note in self.notes for line in ("", printable(note))]
        return "\n".join((*lines, *notes)) + "\n"

    def csv(self) -> str:
        """Return CSV with unrounded numbers in separate columns."""
        keys = [
            list(dict.fromkeys(key for row in self.rows for key in (row[i].data or {})))
            for i in range(len(self.columns))
        ]
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            name
            for column, own in zip(self.columns, keys, strict=True)
            for name in ([f"{column} {key}" for key in own] or [column])
        )
        for row in self.rows:
            writer.writerow(
                value
                for cell, own in zip(row, keys, strict=True)
                for value in ([(cell.data or {}).get(key, "") for key in own] or [cell.line])
            )
        return file.getvalue()

    def _blocks(self, widths: Sequence[int], width: int) -> list[list[int]]:
        # Groups of columns that fit beside the labels.
        room = width - sum(widths[i] + 2 for i in range(self.labels))
        blocks: list[list[int]] = [[]]
        used = 0
        for i in range(self.labels, len(self.columns)):
            if blocks[-1] and used + widths[i] > room:
                blocks.append([])
                used = 0
            blocks[-1].append(i)
            used += widths[i] + 2
        return blocks

    def _text_row(self, row: Sequence[str], shown: Iterable[int], widths: Sequence[int]) -> str:
        cells = [
            _cut(row[i], widths[i]).ljust(widths[i]) if i < self.labels else row[i].rjust(widths[i])
            for i in shown
        ]
        return "  ".join(cells).rstrip()

    def _html_cell(self, column: int, cell: Cell) -> str:
        is_label = column < self.labels
        sort = "" if cell.sort is None else f' data-sort="{_number(cell.sort)}"'
        text = _escaped(cell.text)
        if cell.mark:
            better = "better" if cell.mark == "+" else "worse"
            sign = "+" if cell.mark == "+" else MINUS
            text += f' <b class="{better}" title="significantly {better}">{sign}</b>'
        if cell.detail:
            text += f"<small>{_escaped(cell.detail)}</small>"
        if is_label:
            return f'<th scope="row"{sort}>{text}</th>'
        return f"<td{sort}>{text}</td>"


class Footnotes:
    """Numbered notes of a page, each of which is written once and then referred to."""

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def html(self, notes: Sequence[str]) -> str:
        """Return paragraphs with the notes that are new, and links to those already written.

        Parameters
        ----------
        notes : sequence of str
            Notes of a table.

        Examples
        --------
        >>> notes = Footnotes()
        >>> notes.html(["Medians.", "Few runs."])
        '<p id="note-1"><sup>1</sup> Medians.</p><p id="note-2"><sup>2</sup> Few runs.</p>'
        >>> notes.html(["Few runs."])
        '<p>See note <a href="#note-2">2</a>.</p>'
        """
        written = [self._numbers[note] for note in notes if note in self._numbers]
        new = [note for note in notes if note not in self._numbers]
        for note in new:
            self._numbers[note] = len(self._numbers) + 1
        paragraphs = [
            f'<p id="note-{self._numbers[note]}"><sup>{self._numbers[note]}</sup> '
            f"{_escaped(note)}</p>"
            for note in new
        ]
        if written:
            links = [f'<a href="#note-{number_}">{number_}</a>' for number_ in written]
            many = "s" * (len(written) > 1)
            paragraphs.append(f"<p>See note{many} {', '.join(links)}.</p>")
        return "".join(paragraphs)


def number(value: float, digits: int) -> str:
    """Return a number as text for readers, without decimals from 1000 on.

    Examples
    --------
    >>> number(12.345, 1), number(12345.6, 1), number(float("inf"), 1)
    ('12.3', '12,346', '∞')
    """
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if abs(value) >= 1000.0:
        digits = 0
    text = f"{value:,.{digits}f}"
    return text.replace("-", MINUS) if float(text.replace(",", "")) else text.lstrip("-")


def slug(text: str) -> str:
    """Return a text as part of a file name: lower case letters, digits and hyphens.

    Examples
    --------
    >>> slug("../Garden, 4 robots"), slug("")
    ('garden-4-robots', 'x')
    """
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:60].strip("-") or "x"


def latex_escaped(text: str) -> str:
    """Return text with the special letters of LaTeX escaped."""
    return "".join(_LATEX.get(letter, letter) for letter in printable(text))


_LATEX: Final = {
    **{letter: f"\\{letter}" for letter in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "∞": r"$\infty$",
    "≤": r"$\leq$",
    "²": r"$^2$",
    MINUS: r"$-$",
    "\N{EN DASH}": "--",
    "…": r"\ldots{}",
}


def _latex_cell(cell: Cell) -> str:
    mark = {"+": " $+$", "-": " $-$"}.get(cell.mark, "")
    detail = f" {{\\footnotesize {latex_escaped(cell.detail)}}}" if cell.detail else ""
    return f"{latex_escaped(cell.text)}{mark}{detail}"


def _escaped(text: str) -> str:
    return html.escape(printable(text))


def _number(value: float) -> str:
    # In the notation of JavaScript.
    return ("Infinity" if value > 0 else "-Infinity") if math.isinf(value) else f"{value:.10g}"


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width - 1]}…"


def _wrapped(text: str, width: int) -> list[str]:
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
