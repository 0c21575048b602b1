"""The map of each robot at some times, as in figures 10 to 12 of SBX-R."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import shapely

from multisrt.analysis.known_maps import areas_known, known_regions
from multisrt.analysis.poses import poses
from multisrt.drawing.colours import RobotStyles
from multisrt.drawing.figures.style import FigureStyle, fit_maps, legend_below, new_figure
from multisrt.drawing.figures.world import draw_area, draw_world, width_mm, world_handles
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIRST_S = 2.0
"""The first of the default times: after the first exchange of maps, as in the paper."""

MAX_PANELS = 60
"""Upper bound of the panels of a figure."""


def default_times(recording: Recording) -> tuple[float, ...]:
    """Return the times of the paper's figures: 2 s, half of the run, and its end."""
    end_s = recording.footer.time_s
    return tuple(dict.fromkeys((min(FIRST_S, end_s), end_s / 2.0, end_s)))


def robot_maps_figure(
    recording: Recording,
    style: FigureStyle,
    times_s: Sequence[float] = (),
    robots: Sequence[int] | None = None,
) -> Figure:
    """Return a figure with the map of each robot at each time, over the true one.

    Parameters
    ----------
    recording : Recording
        The run.
    style : FigureStyle
        The style, whose settings hold.
    times_s : sequence of float
        Times in seconds, one for each column; by default those of `default_times`.
    robots : sequence of int, optional
        The robots, one for each row; by default all.

    Returns
    -------
    Figure
        The figure, laid out.

    Raises
    ------
    InvalidInputError
        If a time is not within the run, or there would be too many maps.
    """
    times = tuple(times_s) or default_times(recording)
    for time_s in times:
        if not 0.0 <= time_s <= recording.footer.time_s:
            raise InvalidInputError(
                f"{time_s:g} s is not within the run, which lasts from 0 to "
                f"{recording.footer.time_s:.2f} s"
            )
    rows = list(range(len(recording.starts)) if robots is None else robots)
    if len(rows) * len(times) > MAX_PANELS:
        raise InvalidInputError(
            f"{len(rows)} robots at {len(times)} times are {len(rows) * len(times)} maps; at most "
            f"{MAX_PANELS} fit a figure: choose robots or fewer times"
        )
    environment = recording.environment()
    known = known_regions(recording, environment)
    areas = {
        (robot, time_s): own
        for robot in rows
        for time_s, own in zip(
            sorted(times), areas_known(known[robot], sorted(times), environment), strict=True
        )
    }
    at = poses(recording, times)
    figure, axes = new_figure(style, len(rows), len(times))
    map_mm = width_mm(axes[0], len(times))
    for number, ax in enumerate(axes):
        row, column = divmod(number, len(times))
        robot, time_s = rows[row], times[column]
        draw_world(ax, environment, map_mm, scale_bar=number == (len(rows) - 1) * len(times))
        share = draw_robot_map(ax, environment, robot, areas[robot, time_s])
        draw_pose(ax, robot, at[robot, column])
        time = f"{time_s:,.0f} s: " if row == 0 else ""
        ax.set_title(f"{time}{100.0 * share:.0f} %", pad=2.0)
        if column == 0:
            ax.set_ylabel(f"robot {robot}")
    makers = sorted({region.maker for robot in rows for region in known[robot]})
    legend_below(figure, [*_makers(makers), *world_handles(unknown="not on the map")], style)
    width = len(times)
    grid = [axes[row * width : (row + 1) * width] for row in range(len(rows))]
    fit_maps(figure, grid, style.max_height_in)
    return figure


def draw_robot_map(
    ax: Axes,
    environment: Environment,
    robot: int,
    areas: Mapping[int, shapely.MultiPolygon],
) -> float:
    """Draw what a robot knows, in the colours of the robots that saw it.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    environment : Environment
        The true world.
    robot : int
        The robot, whose own area is drawn above those that it learned of.
    areas : mapping of int to MultiPolygon
        What it knows, by the robot that saw it.

    Returns
    -------
    float
        Share of the free space that is on its map, from 0 to 1.
    """
    for level, maker in enumerate(sorted(areas, key=lambda maker: (maker == robot, maker))):
        style = RobotStyles.of(maker).area.scaled(0.6)
        patch = draw_area(ax, areas[maker], style, zorder=0.3 + 0.6 * level / len(areas))
        if patch is not None:
            patch.set_gid(f"seen by robot {maker}")
    return float(shapely.union_all(list(areas.values())).area) / environment.area_m2


def draw_pose(ax: Axes, robot: int, pose: Sequence[float]) -> None:
    """Mark where a robot is, and its heading."""
    x, y, heading = map(float, pose)
    colour = RobotStyles.of(robot).edge.stroke
    marker = (3, 0, math.degrees(heading) - 90.0)
    drawn: dict[str, Any] = {"markersize": 6.0, "markeredgecolor": "black", "markeredgewidth": 0.5}
    ax.plot(x, y, marker=marker, color=colour, zorder=3.0, **drawn)


def _makers(makers: Sequence[int]) -> list[Any]:
    from matplotlib.patches import Patch

    if len(makers) > 12:
        return []
    styles = {maker: RobotStyles.of(maker).area for maker in makers}
    return [
        Patch(label=f"seen by robot {m}", facecolor=s.fill, edgecolor=s.stroke, linewidth=0.4)
        for m, s in styles.items()
    ]
