"""The map of a run: trees or paths, nodes, and areas by the robot that saw them first."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from multisrt.drawing.axes import POINTS_PER_MM, legend_handle, on_axes
from multisrt.drawing.colours import RobotStyles
from multisrt.drawing.figures.panels import panels
from multisrt.drawing.figures.style import FigureStyle, listed
from multisrt.drawing.figures.world import FINER, MIN_LETTERS_PT, frame, sheet_bounds
from multisrt.drawing.layers import left_out
from multisrt.drawing.sheet import LegendEntry, Sheet
from multisrt.drawing.tree_svg import run_sheet
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHORT: Final = {
    "free space that is on no map": "on no map",
    "bridge between two nodes": "bridge",
    "border of what the base knows": "known to the base",
    "start, with the robot's number": "start",
    "path in support of others": "support of others",
}
"""Labels that are shorter than those of sheets, for narrow columns."""

SEEN_FIRST: Final = LegendEntry(label="seen first by a robot", style=RobotStyles.of_any().area)
"""Entry for the areas of a team."""

MAX_LARGE_NUMBERS: Final = 12
"""Team size up to which the numbers of robots are not made smaller."""


def draw_map(
    recording: Recording, ax: Axes, map_mm: float, without: Iterable[str] = ("outlines",)
) -> Sheet:
    """Draw the map of a run on axes for a width on paper, and return its sheet."""
    is_large = len(recording.starts) > MAX_LARGE_NUMBERS
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
    robots: dict[str, Any] = {}
    others: dict[str, Any] = {}

    def draw(recording: Recording, ax: Axes, map_mm: float) -> None:
        sheet = draw_map(recording, ax, map_mm, without)
        for number, swatch in enumerate(sheet.swatches):
            label = f"robot {number}"
            if label not in robots:
                pair = [LegendEntry(label=label, style=one) for one in (swatch.area, swatch.line)]
                robots[label] = tuple(map(legend_handle, pair))
        areas = [SEEN_FIRST] if sheet.swatches and "areas" not in left_out(without) else []
        for entry in (*areas, *sheet.legend):
            label = SHORT.get(entry.label, entry.label)
            others.setdefault(label, legend_handle(replace(entry, label=label)))

    return panels(
        recordings, style, draw, lambda: [*listed(list(robots.values())), *others.values()]
    )
