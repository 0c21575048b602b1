"""The decisions of robots as a table: how often they chose what, and why."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, Final

from multisrt.analysis.decision_counts import DecisionRow, decision_rows
from multisrt.drawing.colours import INK
from multisrt.drawing.figures.style import FigureStyle, new_figure
from multisrt.drawing.svg import printable
from multisrt.explain.terms import meanings
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

MAX_ROBOTS: Final = 6
"""Upper bound of the team size up to which every robot has a column."""

MAX_ROWS: Final = 30
"""Upper bound of the rows; the rarest decisions of a strategy are added up beyond it."""

LINE_EM: Final = 1.5
"""Height of a row, in sizes of its letters."""

GAP_EM: Final = 0.9
"""Minimum distance of columns, in sizes of their letters."""

NOTE_SIZE: Final = 0.9
"""Size of the letters of notes, as a share of those of the table."""

WIDE_IN: Final = 5.0
"""Width of a figure from which notes stand in two columns, in inches."""

NOTE_LINE_EM: Final = 1.25
"""Height of a line of notes, in sizes of its letters."""


def decisions_figure(
    recordings: Sequence[Recording], style: FigureStyle, robots: Sequence[int] | None = None
) -> Figure:
    """Return a table of the decisions of runs; see `decision_rows`.

    Raises
    ------
    InvalidInputError
        If the runs hold no decision.
    """
    rows = decision_rows(recordings, robots)
    figure, (ax,) = new_figure(style)
    figure.set_layout_engine("none")
    ax.set_axis_off()
    ax.set_position((0.0, 0.0, 1.0, 1.0))
    team = range(len(rows[0].counts)) if robots is None else robots
    draw_decisions(rows, ax, style, team)
    return figure


def draw_decisions(
    rows: Sequence[DecisionRow], ax: Axes, style: FigureStyle, team: Sequence[int]
) -> None:
    """Write the table on axes without a frame, whose figure becomes as high as it needs.

    Parameters
    ----------
    rows : sequence of DecisionRow
        The rows, at least one.
    ax : Axes
        Where to write.
    style : FigureStyle
        The style, whose settings hold.
    team : sequence of int
        The robots that the counts are of.
    """
    columns = team if len(team) <= MAX_ROBOTS else []
    head = ["decision", "reason", *(f"r{robot}" for robot in columns), "all", "share"]
    lines: list[list[str]] = [head]
    for strategy, own in groupby(rows, key=lambda row: row.strategy):
        lines.append([printable(strategy)])
        lines += [_cells(row, bool(columns)) for row in _shortened(list(own))]
    line_in = LINE_EM * style.small_pt / 72.0
    notes = _notes(ax, rows, style)
    note_in = NOTE_LINE_EM * NOTE_SIZE * style.small_pt / 72.0
    columns_of_notes = 2 if style.width_in >= WIDE_IN else 1
    per_column = -(-len(notes) // columns_of_notes)
    table_in = (len(lines) + 1.2) * line_in
    height_in = table_in + (per_column + 0.6 * bool(notes)) * note_in
    ax.figure.set_size_inches(style.width_in, height_in)  # type: ignore[union-attr]
    ax.set(xlim=(0.0, style.width_in), ylim=(height_in, 0.0))
    written = [_write(ax, line, number, style) for number, line in enumerate(lines)]
    _align(written, style)
    for y, width in ((0.15, 0.9), (1.45, 0.5), (len(lines) + 0.9, 0.9)):
        ax.plot([0.02, style.width_in - 0.02], [y * line_in] * 2, color=INK, linewidth=width)
    for number, note in enumerate(notes):
        column, row = divmod(number, per_column)
        x = 0.03 + column * style.width_in / columns_of_notes
        y = table_in + (row + 0.5) * note_in
        ax.text(x, y, note, va="center_baseline", fontsize=NOTE_SIZE * style.small_pt)


def _notes(ax: Axes, rows: Sequence[DecisionRow], style: FigureStyle) -> list[str]:
    # What the names in the table mean, in lines that fit the width.
    shown = {name for row in rows for name in (row.choice, row.reason)}
    probe = ax.text(0.0, 0.0, "", fontsize=NOTE_SIZE * style.small_pt)
    room_in = style.width_in / (2 if style.width_in >= WIDE_IN else 1) - 0.1
    lines: list[str] = []
    for name, meaning in meanings().items():
        if name in shown:
            lines += _wrapped(probe, f"{name}: {meaning}", room_in)
    probe.remove()
    return lines


def _wrapped(probe: Text, note: str, width_in: float) -> list[str]:
    # Lines that fit a width as the probe would show them; all but the first are indented.
    lines = [""]
    for word in note.split():
        longer = f"{lines[-1]} {word}" if lines[-1].strip() else f"{lines[-1]}{word}"
        probe.set_text(longer)
        if _width_in(probe) <= width_in:
            lines[-1] = longer
        else:
            lines.append(f"    {word}")
    return lines


def _write(ax: Axes, cells: Sequence[str], number: int, style: FigureStyle) -> list[Text]:
    # The cells of a row, for now all at the left; headings and strategies are bold.
    line_in = LINE_EM * style.small_pt / 72.0
    y = (0.8 if number == 0 else number + 1.0) * line_in
    weight = "bold" if number == 0 or len(cells) == 1 else "normal"
    common: dict[str, Any] = {"va": "center_baseline", "fontsize": style.small_pt}
    return [
        ax.text(0.0, y, text, ha="left" if k < 2 else "right", weight=weight, **common)
        for k, text in enumerate(cells)
    ]


def _align(written: Sequence[Sequence[Text]], style: FigureStyle) -> None:
    # Words stand at the left of their columns and numbers at the right; what is left of the width
    # is shared between the columns. Where it is too narrow, words are cut: reasons first.
    rows = [row for row in written if len(row) > 1]
    widths = [max(_width_in(row[k]) for row in rows) for k in range(len(rows[0]))]
    gap = GAP_EM * style.small_pt / 72.0
    room = style.width_in - 0.06 - gap * (len(widths) - 1)
    numbers = sum(widths[2:])
    widths[0] = min(widths[0], 0.6 * (room - numbers))
    widths[1] = min(widths[1], room - numbers - widths[0])
    gap += (room - sum(widths)) / (len(widths) - 1)
    for row in written:
        row[0].set_x(0.03)
        _shorten(row[0], widths[0] if len(row) > 1 else style.width_in - 0.03)
    left = 0.03
    for k, width in enumerate(widths):
        for row in rows:
            row[k].set_x(left if k < 2 else left + width)
        left += width + gap
    for row in rows:
        _shorten(row[1], widths[1])


def _shorten(text: Text, width_in: float) -> None:
    # Measured widths differ by the position of the text within a pixel.
    whole = text.get_text()
    while len(whole) > 1 and _width_in(text) > width_in + 0.02:
        whole = whole[:-1]
        text.set_text(f"{whole}…")


def _width_in(text: Text) -> float:
    figure = text.figure
    assert figure is not None
    return float(text.get_window_extent().width / figure.dpi)


def _shortened(rows: list[DecisionRow]) -> list[DecisionRow]:
    if len(rows) <= MAX_ROWS:
        return rows
    rest = rows[MAX_ROWS - 1 :]
    counts = tuple(map(sum, zip(*(row.counts for row in rest), strict=True)))
    share = sum(row.share for row in rest)
    return [
        *rows[: MAX_ROWS - 1],
        DecisionRow(rest[0].strategy, f"{len(rest)} others", "", counts, share),
    ]


def _cells(row: DecisionRow, by_robot: bool) -> list[str]:
    counts = [f"{count:,}" for count in row.counts] if by_robot else []
    share = f"{100.0 * row.share:.0f} %" if row.share >= 0.005 else "< 1 %"
    return [printable(row.choice), printable(row.reason), *counts, f"{row.total:,}", share]
