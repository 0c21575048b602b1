"""The trajectories of robots over the true map, as in figures 13 to 15 of SBX-R."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from multisrt.drawing.axes import POINTS_PER_MM
from multisrt.drawing.colours import RobotStyles
from multisrt.drawing.figures.panels import panels
from multisrt.drawing.figures.style import FigureStyle, listed
from multisrt.drawing.figures.world import draw_numbers, draw_world, world_handles
from multisrt.drawing.traces import traces_of
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_trajectories(
    recording: Recording, ax: Axes, map_mm: float, robots: Sequence[int] | None = None
) -> list[Any]:
    """Draw the path of each robot, its start with its number and its end.

    Parameters
    ----------
    recording : Recording
        The run.
    ax : Axes
        Where to draw.
    map_mm : float
        Width of the map on paper, in millimetres.
    robots : sequence of int, optional
        The robots; by default all.

    Returns
    -------
    list of Line2D
        The paths, with labels.
    """
    draw_world(ax, recording.environment(), map_mm)
    traces = [t for t in traces_of(recording) if robots is None or t.robot in robots]
    lines = []
    for trace in traces:
        edge = RobotStyles.of(trace.robot).edge
        width = edge.width_mm * POINTS_PER_MM
        (line,) = ax.plot(
            *_with_gaps(trace.stretches).T,
            color=edge.stroke,
            linewidth=width,
            label=f"robot {trace.robot}",
            zorder=2.0,
            gid=f"path of robot {trace.robot}",
        )
        if edge.dashes_mm:
            line.set_dashes([length * POINTS_PER_MM / width for length in edge.dashes_mm])
        lines.append(line)
        if trace.is_away:
            died = trace.death is not None
            ax.plot(
                *trace.end[:2],
                "X" if died else "s",
                color=edge.stroke,
                markersize=5.5 if died else 4.5,
                markeredgecolor="black",
                markeredgewidth=0.5,
                zorder=3.0,
            )
    draw_numbers(ax, [t.start[:2] for t in traces], [t.robot for t in traces], map_mm)
    return lines


def _with_gaps(lines: Sequence[FloatArray]) -> FloatArray:
    # The points of some lines, with a point that is drawn nowhere after each but the last.
    gap = np.full((1, 2), np.nan)
    parts = [part for line in lines for part in (gap, line)]
    return np.vstack(parts[1:]) if parts else np.empty((0, 2))


def trajectories_figure(
    recordings: Sequence[Recording], style: FigureStyle, robots: Sequence[int] | None = None
) -> Figure:
    """Return a figure with the trajectories of each of some runs of one world."""
    found: dict[str, Any] = {}

    def draw(recording: Recording, ax: Axes, map_mm: float) -> None:
        for line in draw_trajectories(recording, ax, map_mm, robots):
            found.setdefault(str(line.get_label()), line)

    def legend() -> list[Any]:
        return [*listed(list(found.values())), *_marks(), *world_handles()]

    return panels(recordings, style, draw, legend)


def _marks() -> list[Any]:
    from matplotlib.lines import Line2D

    edge = {"linestyle": "none", "markeredgecolor": "black", "markerfacecolor": "white"}
    return [
        Line2D([], [], marker="o", markersize=5.5, label="start", **edge),  # type: ignore[arg-type]
        Line2D([], [], marker="s", markersize=4.5, label="end", **edge),  # type: ignore[arg-type]
    ]
