"""The map of a run: trees or paths, nodes, and areas by the robot that saw them first."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from multisrt.drawing.axes import POINTS_PER_MM, legend_handle, on_axes
from multisrt.drawing.figures.style import FigureStyle
from multisrt.drawing.figures.world import FINER, MIN_LETTERS_PT, frame, sheet_bounds
from multisrt.drawing.sheet import LegendEntry, Sheet
from multisrt.drawing.tree_svg import run_sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

from multisrt.drawing.figures.panels import panels
from multisrt.recording import Recording

SHORT: Final = {
    "free space that is on no map": "on no map",
    "bridge between two nodes": "bridge",
    "start, with the robot's number": "start",
    "path in support of others": "support of others",
}
"""Labels that are shorter than those of sheets, for narrow columns."""

MAX_SWATCHES: Final = 12
"""Team size up to which the legend lists the robots, and their numbers are not made smaller."""


def draw_map(
    recording: Recording, ax: Axes, map_mm: float, without: Iterable[str] = ("outlines",)
) -> Sheet:
    """Draw the map of a run on axes for a width on paper, and return its sheet."""
    is_large = len(recording.starts) > MAX_SWATCHES
    sheet = run_sheet(
        recording,
        without=without,
        bounds_mm=sheet_bounds(map_mm),
        min_number_mm=0.0 if is_large else FINER * MIN_LETTERS_PT / POINTS_PER_MM,
    )
    on_axes(sheet, ax, scale=1.0 / FINER)
    frame(ax, sheet, map_mm)
    return sheet


def map_figure(
    recordings: Sequence[Recording], style: FigureStyle, without: Iterable[str] = ("outlines",)
) -> Figure:
    """Return a figure with the map of each of some runs of one world; see `draw_map`."""
    legend: dict[str, Any] = {}

    def draw(recording: Recording, ax: Axes, map_mm: float) -> None:
        sheet = draw_map(recording, ax, map_mm, without)
        team = sheet.swatches if len(sheet.swatches) <= MAX_SWATCHES else []
        robots = [
            LegendEntry(label=f"robot {number}", style=swatch.line)
            for number, swatch in enumerate(team)
        ]
        for entry in (*robots, *sheet.legend):
            label = SHORT.get(entry.label, entry.label)
            legend.setdefault(label, legend_handle(replace(entry, label=label)))

    return panels(recordings, style, draw, lambda: list(legend.values()))
