"""Figures for papers: maps, trajectories, curves, strips, heat maps and tables of runs."""

from multisrt.drawing.figures.kinds import (
    KINDS,
    FigureKind,
    FigureOptions,
    draw_figure,
    figure_bytes,
    format_of,
    kind_named,
    require_fit,
    save_figure,
)
from multisrt.drawing.figures.style import STYLES, FigureStyle, figure_style

__all__ = [
    "KINDS",
    "STYLES",
    "FigureKind",
    "FigureOptions",
    "FigureStyle",
    "draw_figure",
    "figure_bytes",
    "figure_style",
    "format_of",
    "kind_named",
    "require_fit",
    "save_figure",
]
