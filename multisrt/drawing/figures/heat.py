"""Heat maps: how often places were visited or seen, and where robots were isolated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from multisrt.analysis.heat_maps import HeatMap, VisitCount, isolated_times, visits
from multisrt.drawing.figures.panels import MIN_PANEL_IN, label_of_run, panel_letter
from multisrt.drawing.figures.style import FigureStyle, fit_maps, new_figure
from multisrt.drawing.figures.world import draw_world, width_mm
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COUNT_LABELS: Final[dict[VisitCount, str]] = {
    "passes": "times a robot drove here",
    "robots": "robots that drove here",
    "scans": "scans that showed it",
    "viewers": "robots that saw it",
}
"""Labels of the colour bar, by what is counted."""

ISOLATED: Final = "time in isolation (s/m²)"
"""Label of the colour bar of times, which do not depend on the width of cells."""

COLOURS: Final = "viridis_r"
"""Colours from light to dark, so that they are ordered in grey as well."""

MAX_COLOURS: Final = 10
"""Upper bound of the colours of counts; beyond it a colour stands for several counts."""

WIDE: Final = 30.0
"""Ratio of the largest to the smallest time from which the scale is logarithmic."""


def draw_heat(ax: Axes, found: HeatMap, recording: Recording, map_mm: float, norm: Any) -> Any:
    """Draw a heat map over the true map, and return its image; cells of 0 are left white."""
    draw_world(ax, recording.environment(), map_mm)
    limits = ax.get_xlim(), ax.get_ylim()
    shown = np.ma.masked_less_equal(found.values, 0.0)
    image = ax.imshow(
        shown,
        extent=found.extent,
        origin="lower",
        cmap=COLOURS,
        norm=norm,
        interpolation="nearest",
        zorder=0.5,
    )
    ax.set(xlim=limits[0], ylim=limits[1])
    return image


def visits_figure(
    recordings: Sequence[Recording], style: FigureStyle, count: VisitCount = "passes"
) -> Figure:
    """Return heat maps of visits of runs of one world; see `multisrt.analysis.heat_maps.visits`."""
    return _figure(
        recordings, style, lambda one: visits(one, count), COUNT_LABELS[count], "no visits", True
    )


def isolation_figure(recordings: Sequence[Recording], style: FigureStyle) -> Figure:
    """Return heat maps of where robots were isolated, of runs of one world."""
    return _figure(recordings, style, _per_area, ISOLATED, "never isolated", False)


def _per_area(recording: Recording) -> HeatMap:
    found = isolated_times(recording)
    return replace(found, values=found.values / found.cell_m**2)


def _figure(
    recordings: Sequence[Recording],
    style: FigureStyle,
    heat_of: Callable[[Recording], HeatMap],
    label: str,
    nothing: str,
    whole: bool,
) -> Figure:
    found = [heat_of(recording) for recording in recordings]
    norm = _norm(np.concatenate([one.values.ravel() for one in found]), whole)
    columns = min(len(recordings), max(1, int(style.width_in / MIN_PANEL_IN)))
    rows = -(-len(recordings) // columns)
    figure, axes = new_figure(style, rows, columns)
    image = None
    for number, (recording, own, ax) in enumerate(zip(recordings, found, axes, strict=False)):
        image = draw_heat(ax, own, recording, width_mm(ax, columns) * 0.9, norm)
        parts = [] if own.values.any() else [nothing]
        if len(recordings) > 1:
            parts.insert(0, f"{panel_letter(number)} {label_of_run(recording, recordings)}")
        ax.set_title(": ".join(parts), loc="left")
    for ax in axes[len(recordings) :]:
        ax.set_visible(False)
    if norm is not None:
        shown = [ax for ax in axes if ax.get_visible()]
        _bar(figure, image, shown, label)
    in_rows = [axes[row * columns : (row + 1) * columns] for row in range(rows)]
    kept = [[ax for ax in row if ax.get_visible()] for row in in_rows]
    fit_maps(figure, kept, style.max_height_in)
    return figure


def _norm(values: np.ndarray[Any, np.dtype[np.float64]], whole: bool) -> Any:
    # One scale for all panels; None if there is nothing to show.
    from matplotlib.colors import BoundaryNorm, LogNorm, Normalize

    positive = values[values > 0.0]
    if not len(positive):
        return None
    least, most = float(positive.min()), float(positive.max())
    if whole:
        return BoundaryNorm(np.array(bins(round(most))) - 0.5, 256)
    least = max(least, most / 200.0)
    if most / least > WIDE:
        return LogNorm(least, most)
    return Normalize(0.0, most)


def bins(most: int) -> list[int]:
    """Return the first count of each colour, and the first beyond the last colour.

    Parameters
    ----------
    most : int
        The largest count, at least 1.

    Returns
    -------
    list of int
        From 1. Each count has a colour of its own up to `MAX_COLOURS`. Of more, colours stand for
        equally many counts, or from three times as many on for ever more.

    Examples
    --------
    >>> bins(4), bins(13)
    ([1, 2, 3, 4, 5], [1, 3, 5, 7, 9, 11, 13, 15])
    >>> bins(500)
    [1, 2, 4, 8, 16, 32, 64, 128, 256, 512]
    """
    if most <= 3 * MAX_COLOURS:
        step = -(-most // MAX_COLOURS)
        return list(range(1, most + step + 1, step))
    return [2**k for k in range(most.bit_length() + 1)]


def _bar(figure: Figure, image: Any, axes: Sequence[Axes], label: str) -> None:
    from matplotlib.colors import BoundaryNorm, LogNorm
    from matplotlib.ticker import FuncFormatter, NullFormatter

    bar = figure.colorbar(
        image, ax=axes, location="bottom", label=label, fraction=0.05, aspect=40.0, pad=0.03
    )
    bar.outline.set_linewidth(0.4)
    if isinstance(image.norm, BoundaryNorm):
        firsts = [round(edge + 0.5) for edge in image.norm.boundaries]
        labels = [
            str(first) if after == first + 1 else f"{first}\u2013{after - 1}"
            for first, after in pairwise(firsts)
        ]
        middles = [0.5 * (first + after - 1) for first, after in pairwise(firsts)]
        bar.set_ticks(middles, labels=labels)
        bar.ax.tick_params(axis="x", length=0)
        bar.minorticks_off()
    elif isinstance(image.norm, LogNorm):
        bar.ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        bar.ax.xaxis.set_minor_formatter(NullFormatter())
