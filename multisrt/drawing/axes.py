"""Pictures on axes of matplotlib: the map of a sheet, in the same layers and colours.

The paths of the sheet are drawn as they are in its SVG. What has a size on paper there, such as the
width of a line, has the same size in relation to the map here.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import shapely

from multisrt.drawing.sheet import LegendEntry, Sheet
from multisrt.drawing.svg import Pen
from multisrt.extras import extra
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path

MM_PER_IN: Final = 25.4
POINTS_PER_MM: Final = 72.0 / MM_PER_IN

WIDTH_IN: Final = 8.0
"""Width of a figure that is made for a map, in inches."""

MAX_HEIGHT_IN: Final = 8.0

MIN_SCALE: Final = 0.35
"""Lower bound of the scale of lines, so that they stay visible on small axes."""

Attributes = Mapping[str, str]


def on_axes(sheet: Sheet, ax: Axes | None, scale: float | None = None) -> Axes:
    """Draw the map of a sheet on axes, and return them.

    Parameters
    ----------
    sheet : Sheet
        The sheet; all layers of its map are drawn.
    ax : matplotlib.axes.Axes or None
        Where to draw; their aspect becomes equal. None for a new figure of pyplot, with the
        heading and the legend of the sheet.
    scale : float, optional
        Size of the map on the axes over its size on paper; by default as the axes are now.

    Returns
    -------
    matplotlib.axes.Axes
        The axes that were given, or those of a new figure.

    Raises
    ------
    InvalidInputError
        If `ax` is something else.
    MissingExtraError
        If matplotlib is not installed.
    """
    _require_axes(ax)
    if ax is None:
        ax = _with_legend(sheet)
    ax.set_aspect("equal")
    scale = _scale(sheet, ax) if scale is None else scale
    for layer in sheet.map:
        for shape in layer:
            _draw(sheet, ax, {**layer.attrib, **shape.attrib}, shape, scale)
    ax.autoscale_view()
    return ax


def plot_steps(
    times_s: Sequence[float] | FloatArray,
    shares: Sequence[float] | FloatArray,
    ax: Axes | None,
    **line: Any,
) -> Axes:
    """Draw shares that hold from a time until the next as a line of steps; see `on_axes`."""
    _require_axes(ax)
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots(layout="constrained")
    ax.step(times_s, shares, where="post", **line)
    if ax.get_autoscaley_on():
        ax.set_ylim(0.0, 1.02)
    label_axes(ax, "time (s)", "covered share of the explorable area")
    return ax


def _require_axes(ax: object) -> None:
    with extra("plots", "a plot"):
        from matplotlib.axes import Axes
    if not isinstance(ax, Axes | None):
        raise InvalidInputError(
            f"plots are drawn on axes of matplotlib, such as those of plt.subplots(), not {ax!r}"
        )


def label_axes(ax: Axes, x: str, y: str) -> None:
    """Set the labels of axes that have none."""
    if not ax.get_xlabel():
        ax.set_xlabel(x)
    if not ax.get_ylabel():
        ax.set_ylabel(y)


def _with_legend(sheet: Sheet) -> Axes:
    # Axes of a new figure with the heading above the map, and the legend below it.
    import matplotlib.pyplot as plt

    wide, high = sheet.map_mm
    height_in = min(MAX_HEIGHT_IN, WIDTH_IN * high / wide)
    handles = [legend_handle(entry) for entry in sheet.legend]
    handles += [
        legend_handle(LegendEntry(label=one.label, style=one.line)) for one in sheet.swatches
    ]
    rows = -(-len(handles) // 3)
    figure, ax = plt.subplots(
        figsize=(WIDTH_IN, height_in + 0.25 * rows + 0.9), layout="constrained"
    )
    title, *more = sheet.heading
    ax.set_title("\n".join((title, *more[:1])), loc="left", fontsize="medium", parse_math=False)
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")
    ax.margins(0.0)
    figure.legend(
        handles=handles, loc="outside lower left", ncols=3, frameon=False, fontsize="small"
    )
    return ax


def legend_handle(entry: LegendEntry) -> Any:
    """Return an entry of a legend of matplotlib."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    style, points = entry.style, POINTS_PER_MM
    if entry.marker is not None:
        shape = _path(Pen(decimals=3).marker(entry.marker, 0.0, 0.0, 1.0), (0.0, 0.0))
        return Line2D(
            [],
            [],
            label=entry.label,
            linestyle="none",
            marker=shape,
            markersize=2.0 * entry.size_mm * points,
            markerfacecolor=style.fill or "none",
            markeredgecolor=style.stroke or "none",
            markeredgewidth=style.width_mm * points,
        )
    width = style.width_mm * points
    if style.fill is not None:
        edge = style.stroke or "none"
        return Patch(label=entry.label, facecolor=style.fill, edgecolor=edge, linewidth=width)
    line = Line2D([], [], label=entry.label, color=style.stroke, linewidth=width)
    if style.dashes_mm:
        line.set_dashes([length * points / width for length in style.dashes_mm])
    return line


def _scale(sheet: Sheet, ax: Axes) -> float:
    # Size of the map on the axes over its size on paper.
    box = ax.get_window_extent()
    wide_mm = box.width / ax.figure.dpi * MM_PER_IN
    high_mm = box.height / ax.figure.dpi * MM_PER_IN
    return max(MIN_SCALE, min(wide_mm / sheet.map_mm[0], high_mm / sheet.map_mm[1]))


def _draw(sheet: Sheet, ax: Axes, style: Attributes, shape: ET.Element, scale: float) -> None:
    from matplotlib.patches import PathPatch

    if shape.tag == "text":
        path = _text_path(sheet, shape)
        style = {"fill": style["fill"]}
    elif not shape.get("d"):
        return
    else:
        path = _path(style["d"], sheet.pen.origin, is_even_odd=style.get("fill-rule") == "evenodd")
    points = scale * POINTS_PER_MM / sheet.mm
    width = float(style.get("stroke-width", 0.0)) * points
    patch = PathPatch(
        path,
        facecolor=_colour(style, "fill"),
        edgecolor=_colour(style, "stroke"),
        linewidth=width,
        joinstyle="round",
        capstyle="butt" if "stroke-dasharray" in style else "round",
    )
    if "stroke-dasharray" in style:
        dashes = [float(one) * points / width for one in style["stroke-dasharray"].split()]
        patch.set_linestyle((0.0, dashes))
    ax.add_patch(patch)


def _colour(style: Attributes, what: str) -> tuple[str, float]:
    return style.get(what, "none"), float(style.get(f"{what}-opacity", 1.0))


def _path(data: str, origin: tuple[float, float], *, is_even_odd: bool = False) -> Path:
    """Return the path of the path data that `Pen` writes."""
    from matplotlib.path import Path

    lines: list[FloatArray] = []
    paths: list[Path] = []
    for part in re.findall(r"M[^M]+", data):
        numbers = [float(text) for text in re.findall(r"-?(?:\d+\.?\d*|\.\d+)", part)]
        start = np.array(numbers[:2]) + origin
        if "a" in part:
            radius = numbers[2]
            paths.append(Path.circle((start[0] + radius, start[1]), radius))
            continue
        moves = np.reshape(numbers[2:], (-1, 2))
        points = start + np.vstack([[0.0, 0.0], np.cumsum(moves, axis=0)])
        if part.endswith("z"):
            lines.append(np.vstack([points, points[:1]]))
        else:
            paths.append(Path(points))
    if is_even_odd:
        lines = _oriented(lines)
    return Path.make_compound_path(*paths, *(Path(ring, closed=True) for ring in lines))


def path_of_rings(rings: Sequence[FloatArray]) -> Path:
    """Return the path of closed rings, each ``(n, 2)`` with the first point at its end again."""
    from matplotlib.path import Path

    return Path.make_compound_path(*(Path(ring, closed=True) for ring in rings))


def _oriented(rings: list[FloatArray]) -> list[FloatArray]:
    # Matplotlib fills by the winding number: rings within an odd number of others turn clockwise.
    shapes = np.array([shapely.Polygon(ring) for ring in rings], np.object_)
    areas = shapely.area(shapes)
    within = np.zeros(len(rings), np.int64)
    point, ring = shapely.STRtree(shapes).query(shapely.point_on_surface(shapes), "within")
    np.add.at(within, point, areas[ring] > areas[point])
    return [
        np.asarray(shapely.get_coordinates(shapely.orient_polygons(shape, exterior_cw=n % 2 == 1)))
        for shape, n in zip(shapes, within.tolist(), strict=True)
    ]


def _text_path(sheet: Sheet, shape: ET.Element) -> Path:
    # As large in relation to the map as on paper, centred at its place.
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath
    from matplotlib.transforms import Affine2D

    x, y = (float(n) for n in re.findall(r"-?[\d.]+", shape.attrib["transform"])[:2])
    size_m = float(shape.attrib["font-size"]) * sheet.mm
    path = TextPath((0.0, 0.0), shape.text or "", prop=FontProperties(weight="bold"), size=1.0)
    box = path.get_extents()
    centred = Affine2D().translate(-(box.x0 + box.x1) / 2.0, -(box.y0 + box.y1) / 2.0)
    place = (x + sheet.pen.origin[0], y + sheet.pen.origin[1])
    return centred.scale(size_m).translate(*place).transform_path(path)
