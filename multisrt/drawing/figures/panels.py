"""Figures of one panel for each run, side by side where they fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any, Final

from multisrt.drawing.figures.style import FigureStyle, fit_maps, legend_below, new_figure
from multisrt.drawing.figures.world import width_mm
from multisrt.drawing.svg import printable
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MIN_PANEL_IN: Final = 1.6
"""Least width of a panel, in inches."""


def panels(
    recordings: Sequence[Recording],
    style: FigureStyle,
    draw: Callable[[Recording, Axes, float], None],
    legend: Callable[[], Sequence[Any]],
) -> Figure:
    """Return a figure with a map for each run.

    Parameters
    ----------
    recordings : sequence of Recording
        The runs.
    style : FigureStyle
        The style, whose settings hold.
    draw : callable
        Draws a run on axes, for a width of the map in millimetres.
    legend : callable
        Returns the entries of the legend once all maps are drawn.

    Returns
    -------
    Figure
        The figure, laid out.
    """
    columns = min(len(recordings), max(1, int(style.width_in / MIN_PANEL_IN)))
    rows = -(-len(recordings) // columns)
    figure, axes = new_figure(style, rows, columns)
    for number, (recording, ax) in enumerate(zip(recordings, axes, strict=False)):
        draw(recording, ax, width_mm(ax, columns))
        if len(recordings) > 1:
            ax.set_title(
                f"{panel_letter(number)} {label_of_run(recording, recordings)}", loc="left"
            )
    for ax in axes[len(recordings) :]:
        ax.set_visible(False)
    legend_below(figure, legend(), style)
    in_rows = [axes[row * columns : (row + 1) * columns] for row in range(rows)]
    shown = [[ax for ax in row if ax.get_visible()] for row in in_rows]
    fit_maps(figure, shown, style.max_height_in)
    return figure


def panel_letter(number: int) -> str:
    """Return the letter of a panel in brackets, or its number from the 27th on."""
    return f"({ascii_lowercase[number] if number < len(ascii_lowercase) else number + 1})"


def label_of_run(recording: Recording, others: Sequence[Recording]) -> str:
    """Return what tells a run from others: the strategy, and what else differs of it."""
    spec = recording.spec
    parts = [spec.strategy]
    for differs, text in (
        (lambda one: len(one.spec.robots), f"{len(spec.robots)} robots"),
        (lambda one: one.spec.radio.range_m, _radio(spec.radio.range_m)),
        (lambda one: one.spec.seed, f"seed {spec.seed}"),
    ):
        alike = [one for one in others if one.spec.strategy == spec.strategy]
        if len({differs(one) for one in alike}) > 1:
            parts.append(text)
    return printable(", ".join(parts))


def _radio(range_m: float | None) -> str:
    return "unlimited radio" if range_m is None else f"radio {range_m:g} m"
