"""The map of each robot at some times, as in figures 10 to 12 of SBX-R."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import shapely

from multisrt.analysis.known_maps import areas_known, known_regions
from multisrt.analysis.poses import poses
from multisrt.drawing.colours import RobotStyles
from multisrt.drawing.figures.style import (
    MAX_LISTED,
    MIN_MAP_IN,
    FigureStyle,
    fit_maps,
    legend_below,
    listed,
    new_figure,
    too_small,
)
from multisrt.drawing.figures.world import draw_area, draw_world, width_mm, world_handles
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIRST_S = 2.0
"""The first of the default times: after the first exchange of maps, as in the paper."""

ENTRY_IN: Final = 1.45
"""Upper estimate of the width of an entry of the legend, in inches."""

GAP_IN: Final = 0.08
"""Distance of maps beside each other, in inches."""

TITLE_LINES: Final = 1.5
"""Upper estimate of the height of a title with its distances, in lines."""

SMALLER: Final = "robots (--robot), fewer times (--time) or a wider style (--style)"
"""What makes maps larger."""


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
        The robots, by default all. Each has a row, or a part of one where rows of a single robot
        would be smaller.

    Returns
    -------
    Figure
        The figure, laid out.

    Raises
    ------
    InvalidInputError
        If a time is not within the run, or maps would be too small.
    """
    times = tuple(times_s) or default_times(recording)
    for time_s in times:
        if not 0.0 <= time_s <= recording.footer.time_s:
            raise InvalidInputError(
                f"{time_s:g} s is not within the run, which lasts from 0 to "
                f"{recording.footer.time_s:.2f} s"
            )
    team = list(range(len(recording.starts)) if robots is None else robots)
    environment = recording.environment()
    entries = min(len(recording.starts), MAX_LISTED) + 2
    abreast = robots_abreast(environment, style, len(team), len(times), entries)
    known = known_regions(recording, environment)
    areas = {
        (robot, time_s): own
        for robot in team
        for time_s, own in zip(
            sorted(times), areas_known(known[robot], sorted(times), environment), strict=True
        )
    }
    at = poses(recording, times)
    columns = abreast * len(times)
    figure, axes = new_figure(style, -(-len(team) // abreast), columns)
    map_mm = width_mm(axes[0], columns)
    last_row = (len(team) - 1) // abreast * columns
    shown = axes[: len(team) * len(times)]
    for number, ax in enumerate(shown):
        place, column = divmod(number, len(times))
        robot, time_s = team[place], times[column]
        draw_world(ax, environment, map_mm, scale_bar=number == last_row)
        share = draw_robot_map(ax, environment, robot, areas[robot, time_s])
        draw_pose(ax, robot, at[robot, column])
        time = f"{time_s:,.0f} s: " if place < abreast else ""
        ax.set_title(f"{time}{100.0 * share:.0f} %", pad=2.0)
        if column == 0:
            ax.set_ylabel(f"robot {robot}")
    for ax in axes[len(shown) :]:
        ax.set_visible(False)
    makers = sorted({maker for own in areas.values() for maker in own})
    makers_listed = listed(_makers(makers))
    legend_below(figure, [*makers_listed, *world_handles(unknown="not on the map")], style)
    grid = [shown[first : first + columns] for first in range(0, len(shown), columns)]
    fit_maps(figure, grid, style.max_height_in, SMALLER)
    return figure


def robots_abreast(
    environment: Environment, style: FigureStyle, robots: int, times: int, entries: int
) -> int:
    """Return of how many robots maps stand side by side, so that they are as large as can be.

    Parameters
    ----------
    environment : Environment
        The world.
    style : FigureStyle
        The style.
    robots, times : int
        The numbers of robots and of times.
    entries : int
        The number of entries of the legend.

    Returns
    -------
    int
        The number of robots in a row.

    Raises
    ------
    InvalidInputError
        If maps would be too small all the same.
    """
    x0, y0, x1, y1 = environment.bounds
    aspect = (x1 - x0) / (y1 - y0)
    line_in = 1.6 * style.text_pt / 72.0
    lines_below = 1 + -(-entries // max(1, int(style.width_in / ENTRY_IN)))
    height_in = style.max_height_in - lines_below * line_in

    def width_in(abreast: int, robots: int) -> float:
        columns, rows = abreast * times, -(-robots // abreast)
        wide_in = (style.width_in - abreast * line_in) / columns - GAP_IN
        return min(wide_in, aspect * (height_in / rows - TITLE_LINES * line_in))

    def best(robots: int) -> tuple[float, int]:
        width, minus_abreast = max((width_in(n, robots), -n) for n in range(1, robots + 1))
        return max(1.0, 1.0 / aspect) * width, -minus_abreast

    longer_in, abreast = best(robots)
    if longer_in < MIN_MAP_IN:
        fitting = [number for number in range(1, robots) if best(number)[0] >= MIN_MAP_IN]
        remedy = f"at most {fitting[-1]} {SMALLER}" if fitting else SMALLER
        raise too_small(robots * times, style.width_in, style.max_height_in, remedy)
    return abreast


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

    styles = {maker: RobotStyles.of(maker).area for maker in makers}
    return [
        Patch(label=f"seen by robot {m}", facecolor=s.fill, edgecolor=s.stroke, linewidth=0.4)
        for m, s in styles.items()
    ]
