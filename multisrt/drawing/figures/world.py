"""What all maps of figures share: walls, limits, a scale bar, and numbers at starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import shapely

from multisrt.analysis.known_maps import polygons_of
from multisrt.drawing.axes import POINTS_PER_MM, on_axes, path_of_rings
from multisrt.drawing.badges import spread
from multisrt.drawing.colours import FREE_SAMPLE, INK, OBSTACLE, WHITE, RobotStyles, Style
from multisrt.drawing.figures.style import MM_PER_IN
from multisrt.drawing.sheet import Sheet, round_length
from multisrt.drawing.svg import length
from multisrt.environments.environment import Environment
from multisrt.events import Point

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FINER: Final = 1.3
"""Factor by which maps of figures are drawn larger, as sheets: lines and markers are finer."""

BAR_SHARE: Final = 0.25
"""Upper bound of the length of the scale bar, as a share of the width of the map."""

SIMPLER_MM: Final = 0.03
"""Tolerance of the outlines of areas, in millimetres on paper."""

BADGE_PT: Final = 3.9
"""Radius of the badge of a robot, in points."""

MIN_LETTERS_PT: Final = 6.0
"""Size of the smallest letters of figures, the numbers of robots, in points."""


def width_mm(ax: Axes, columns: int = 1) -> float:
    """Return about how wide a map will be on paper, in millimetres."""
    return float(ax.figure.bbox.width / ax.figure.dpi) * MM_PER_IN / columns * 0.97


def sheet_bounds(map_mm: float) -> tuple[tuple[float, float]]:
    """Return the bounds of a sheet for a map of a width on paper; see `Sheet`."""
    return ((FINER * map_mm, 1e6),)


def draw_world(
    ax: Axes, environment: Environment, map_mm: float, *, scale_bar: bool = True
) -> None:
    """Draw free space and obstacles, a scale bar below, and set the limits of the axes.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    environment : Environment
        The world.
    map_mm : float
        Width of the map on paper, in millimetres.
    scale_bar : bool, optional
        Whether there is a scale bar.
    """
    sheet = Sheet(environment, ["world"], "", sheet_bounds(map_mm))
    sheet.draw_obstacles(environment)
    on_axes(sheet, ax, scale=1.0 / FINER)
    frame(ax, sheet, map_mm, scale_bar=scale_bar)


def frame(ax: Axes, sheet: Sheet, map_mm: float, *, scale_bar: bool = True) -> None:
    """Set the limits of axes to a map, without ticks, and draw a scale bar below it."""
    x0, y0, x1, y1 = sheet.bounds
    ax.set(xlim=(x0, x1), ylim=(y0, y1), xticks=[], yticks=[])
    ax.set_aspect("equal")
    ax.spines[:].set_visible(False)
    ax.grid(False)
    if scale_bar:
        _draw_scale_bar(ax, map_mm)


def _draw_scale_bar(ax: Axes, map_mm: float) -> None:
    (x0, x1), y0 = ax.get_xlim(), ax.get_ylim()[0]
    metres_per_mm = (x1 - x0) / map_mm
    end = x0 + round_length(BAR_SHARE * (x1 - x0))
    y, tip = y0 - 1.8 * metres_per_mm, 0.6 * metres_per_mm
    ax.plot(
        [x0, x0, x0, end, end, end],
        [y - tip, y + tip, y, y, y - tip, y + tip],
        color=INK,
        linewidth=0.8,
        clip_on=False,
        gid="scale bar",
    )
    ax.annotate(
        length(end - x0),
        (end, y),
        (4, 0),
        textcoords="offset points",
        va="center",
        fontsize=0.9 * float(ax.yaxis.label.get_fontsize()),
        annotation_clip=False,
    )


def draw_area(ax: Axes, area: shapely.MultiPolygon, style: Style, zorder: float) -> Any:
    """Fill an area on axes whose limits are set, and return its patch; None if it is empty."""
    from matplotlib.patches import PathPatch

    box = ax.get_window_extent()
    metres_per_mm = (ax.get_xlim()[1] - ax.get_xlim()[0]) / box.width * ax.figure.dpi / MM_PER_IN
    area = polygons_of(shapely.simplify(area, SIMPLER_MM * metres_per_mm))
    if area.is_empty:
        return None
    rings = [
        np.asarray(shapely.get_coordinates(ring))
        for part in shapely.orient_polygons(area, exterior_cw=False).geoms
        for ring in (part.exterior, *part.interiors)
    ]
    patch = PathPatch(
        path_of_rings(rings),
        facecolor=style.fill or "none",
        edgecolor=style.stroke or "none",
        linewidth=style.width_mm * POINTS_PER_MM,
        zorder=zorder,
    )
    patch.set_in_layout(False)
    # Unlike a patch that is added as such, it does not change the limits, which are set.
    ax.add_artist(patch)
    return patch


def draw_numbers(ax: Axes, starts: Sequence[Point], robots: Sequence[int], map_mm: float) -> None:
    """Write the numbers of robots at their starts, apart from one another."""
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    radius_m = BADGE_PT / POINTS_PER_MM * (x1 - x0) / map_mm
    places = spread(starts, 0.9 * radius_m, within=(x0, y0, x1, y1))
    for robot, start, place in zip(robots, starts, places.tolist(), strict=True):
        colour = RobotStyles.of(robot).edge.stroke
        if math.dist(start, place) > 0.5 * radius_m:
            ax.plot(*zip(start, place, strict=True), color=colour, linewidth=0.6, zorder=3.5)
        ax.plot(
            *place,
            "o",
            markersize=2.0 * BADGE_PT,
            markerfacecolor=WHITE,
            markeredgecolor=colour,
            markeredgewidth=0.9,
            zorder=4.0,
        )
        ax.annotate(
            str(robot),
            place,
            ha="center",
            va="center_baseline",
            fontsize=MIN_LETTERS_PT,
            zorder=4.1,
        )


def world_handles(*, unknown: str | None = None) -> list[Any]:
    """Return entries of a legend for what is no robot's."""
    from matplotlib.patches import Patch

    def patch(label: str, style: Style) -> Any:
        return Patch(label=label, facecolor=style.fill, edgecolor=INK, linewidth=0.4)

    free = [] if unknown is None else [patch(unknown, FREE_SAMPLE)]
    return [*free, patch("obstacle", OBSTACLE)]
