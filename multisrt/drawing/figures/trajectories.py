"""The trajectories of robots over the true map, as in figures 13 to 15 of SBX-R."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from multisrt.drawing.axes import POINTS_PER_MM
from multisrt.drawing.colours import RobotStyles
from multisrt.drawing.figures.panels import panels
from multisrt.drawing.figures.style import FigureStyle, listed
from multisrt.drawing.figures.world import draw_numbers, draw_world, world_handles
from multisrt.drawing.svg import CORNERS
from multisrt.drawing.traces import traces_of
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.markers import MarkerStyle

END_PT: Final = 7.5
"""Length of the marker of an end, in points."""


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
                marker="X" if died else arrow(trace.end.heading),
                linestyle="none",
                color=edge.stroke,
                markersize=5.5 if died else END_PT,
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


def arrow(heading: float) -> MarkerStyle:
    """Return the marker of ends on maps of runs, for a heading in radians."""
    from matplotlib.markers import MarkerStyle
    from matplotlib.path import Path
    from matplotlib.transforms import Affine2D

    corners = [*CORNERS["arrow"], CORNERS["arrow"][0]]
    turn = Affine2D().rotate(heading)
    return MarkerStyle(Path(turn.transform(corners), closed=True))


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
        Line2D([], [], marker=arrow(0.0), markersize=END_PT, label="end", **edge),  # type: ignore[arg-type]
    ]
