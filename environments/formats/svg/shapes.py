"""Areas and lines of shapes, in metres."""

import math
from pathlib import Path
from typing import Final, Literal, NamedTuple, cast

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import flushed
from multisrt.environments.environment import MAX_COORDINATE_M
from multisrt.environments.formats.curves import FLATNESS_M, arc_points
from multisrt.environments.formats.regions import FillRule, Pen, filled, sides_of_stroke, stroked
from multisrt.environments.formats.svg.lengths import SvgError, length, numbers
from multisrt.environments.formats.svg.path_data import Subpath, subpaths
from multisrt.environments.formats.svg.tree import Drawn
from multisrt.geometry.errors import shown
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

MIN_RADIUS_M: Final = 1e-6
"""Half the width of a stroke below which it covers nothing, in metres."""

CAPS: Final[dict[str, Literal["flat", "round", "square"]]] = {
    "butt": "flat",
    "round": "round",
    "square": "square",
}
JOINS: Final[dict[str, Literal["mitre", "round", "bevel"]]] = {
    "miter": "mitre",
    "miter-clip": "mitre",
    "arcs": "mitre",
    "round": "round",
    "bevel": "bevel",
}


class Outline(NamedTuple):
    """The lines of a shape.

    Attributes
    ----------
    local : list of Subpath
        In its user space, where its stroke is drawn.
    metres : list of Subpath
        In metres.
    scale : float
        Maximum number of metres per user unit, over all directions.
    """

    local: list[Subpath]
    metres: list[Subpath]
    scale: float


def outline(drawn: Drawn) -> Outline:
    """Return the lines of a shape, with curves as polylines within `FLATNESS_M`.

    Raises
    ------
    SvgError
        If an attribute is wrong, or a coordinate exceeds `MAX_COORDINATE_M`.
    """
    linear = drawn.matrix[:2, :2]
    (a, b), (c, d) = linear
    scale = float(math.hypot(a + d, b - c) + math.hypot(a - d, b + c)) / 2  # its norm
    if scale < 1e-12:
        return Outline([], [], 0.0)
    local = _local(drawn, FLATNESS_M / scale)
    metres = []
    for points, closed in local:
        placed = flushed(libm.product(points, linear.T) + drawn.matrix[:2, 2])
        if not np.abs(placed).max() <= MAX_COORDINATE_M:
            raise SvgError(f"a point is further than {MAX_COORDINATE_M:g} m away; check the scale")
        metres.append(Subpath(placed, closed))
    return Outline(local, metres, scale)


def fill_area(path: Path, drawn: Drawn, lines: Outline, rule: str = "fill-rule") -> BaseGeometry:
    """Return the area inside a shape in metres; open lines are closed."""
    return filled(path, [points for points, _ in lines.metres], _fill_rule(drawn, rule))


def closed_area(path: Path, drawn: Drawn, lines: Outline) -> BaseGeometry:
    """Return the area inside those lines of a shape that are closed, or that end at their start."""
    rings = [points for points, closed in lines.metres if closed or (points[0] == points[-1]).all()]
    return filled(path, rings, _fill_rule(drawn, "fill-rule"))


def stroke_area(drawn: Drawn, lines: Outline, px_m: float) -> BaseGeometry:
    """Return the area that a stroke covers, without dashes, in metres.

    Parameters
    ----------
    drawn : Drawn
        The shape.
    lines : Outline
        Its lines.
    px_m : float
        Metres per CSS pixel, for strokes with ``non-scaling-stroke``.

    Raises
    ------
    SvgError
        If a property of the stroke is wrong.
    """
    style = drawn.style
    radius, radius_m = _stroke_radius(drawn, lines, px_m)
    is_fixed = style["vector-effect"] == "non-scaling-stroke"
    if not lines.local:
        return Polygon()
    try:
        cap, join = CAPS[style["stroke-linecap"]], JOINS[style["stroke-linejoin"]]
    except KeyError as error:
        raise SvgError(f"a stroke has no cap or join {shown(error.args[0])}") from error
    limit = max(numbers(style["stroke-miterlimit"])[:1] or [4.0])
    if radius_m < MIN_RADIUS_M:
        return Polygon()
    step = 2 * math.acos(max(0.0, 1 - FLATNESS_M / radius_m))
    quarter = min(max(math.ceil(math.pi / 2 / step), 2), 64)
    pen = Pen(cap, join, max(limit, 1.0), quarter)
    strokes = [
        stroked(points, closed, radius, pen)
        for points, closed in (lines.metres if is_fixed else lines.local)
    ]
    area = shapely.union_all(np.asarray(strokes, np.object_))
    if is_fixed:
        return area
    linear, shift = drawn.matrix[:2, :2], drawn.matrix[:2, 2]
    placed = shapely.transform(area, lambda points: libm.product(points, linear.T) + shift)
    # A transform that flattens leaves no area.
    return placed if placed.is_valid else shapely.buffer(placed, 0)


def stroke_sides(drawn: Drawn, lines: Outline, px_m: float) -> list[FloatArray]:
    """Return the edges of the stroke of a shape, without its joins, in metres.

    They are computed as if its transform had the same scale in all directions.
    """
    if drawn.style["stroke"].strip().lower() in ("none", "transparent"):
        return []
    _, radius_m = _stroke_radius(drawn, lines, px_m)
    return [
        sides_of_stroke(np.vstack([points, points[:1]]) if closed else points, radius_m)
        for points, closed in lines.metres
    ]


def _stroke_radius(drawn: Drawn, lines: Outline, px_m: float) -> tuple[float, float]:
    """Return half the width of a stroke, in the space that it is drawn in and in metres."""
    style = drawn.style
    diagonal = math.hypot(*drawn.viewport) / math.sqrt(2)
    width = length(style["stroke-width"], diagonal)
    if width < 0:
        raise SvgError(f"the stroke-width is {width:g}; it must not be negative")
    is_fixed = style["vector-effect"] == "non-scaling-stroke"
    radius = width * px_m / 2 if is_fixed else width / 2
    radius_m = radius if is_fixed else radius * lines.scale
    if radius_m > MAX_COORDINATE_M:
        raise SvgError(f"a stroke is wider than {MAX_COORDINATE_M:g} m; check the scale")
    return radius, radius_m


def _fill_rule(drawn: Drawn, name: str) -> FillRule:
    rule = drawn.style[name]
    if rule not in ("nonzero", "evenodd"):
        raise SvgError(f"the {name} is {shown(rule)}; it must be nonzero or evenodd")
    return cast(FillRule, rule)


def _local(drawn: Drawn, tolerance: float) -> list[Subpath]:
    attributes = drawn.element.attributes
    width, height = drawn.viewport
    wholes = {
        **dict.fromkeys(("x", "x1", "x2", "cx", "width", "rx"), width),
        **dict.fromkeys(("y", "y1", "y2", "cy", "height", "ry"), height),
        "r": math.hypot(width, height) / math.sqrt(2),
    }

    def sizes(*names: str) -> list[float]:
        return [length(attributes.get(name, "0"), wholes[name]) for name in names]

    match drawn.element.name:
        case "path":
            return subpaths(attributes.get("d", ""), tolerance)
        case "polyline" | "polygon":
            points = numbers(attributes.get("points", ""))
            if len(points) % 2:
                raise SvgError("points are pairs of numbers; one is alone")
            closed = drawn.element.name == "polygon"
            return [Subpath(np.reshape(points, (-1, 2)), closed)] if points else []
        case "line":
            return [Subpath(np.reshape(sizes("x1", "y1", "x2", "y2"), (2, 2)), False)]
        case "rect":
            x, y, w, h = sizes("x", "y", "width", "height")
            rounds = [attributes.get(name, "auto").strip() for name in ("rx", "ry")]
            # A radius that is not given equals the other.
            own = [one for one in rounds if one != "auto"] or ["0"]
            radii = [
                length(own[0] if one == "auto" else one, whole)
                for one, whole in zip(rounds, (width, height), strict=True)
            ]
            return _rectangle((x, y), (w, h), radii, tolerance)
    cx, cy = sizes("cx", "cy")
    if drawn.element.name == "circle":
        (rx,) = (ry,) = sizes("r")
    else:
        rx, ry = sizes("rx", "ry")
    if rx < 0 or ry < 0:
        raise SvgError("a radius is negative")
    if rx == 0 or ry == 0:
        return []
    return [Subpath(arc_points((cx, cy), (rx, ry), (0.0, 2 * math.pi), tolerance), True)]


def _rectangle(
    corner: tuple[float, float], sides: tuple[float, float], radii: list[float], tolerance: float
) -> list[Subpath]:
    (x, y), (w, h) = corner, sides
    if w < 0 or h < 0 or min(radii) < 0:
        raise SvgError("a side or radius of a rectangle is negative")
    if w == 0 or h == 0:
        return []
    rx, ry = min(radii[0], w / 2), min(radii[1], h / 2)
    if rx == 0 or ry == 0:
        return [Subpath(np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]]), True)]
    quarter = math.pi / 2
    pieces = []
    for k, (cx, cy) in enumerate(
        [(x + w - rx, y + h - ry), (x + rx, y + h - ry), (x + rx, y + ry), (x + w - rx, y + ry)]
    ):
        first = (cx + rx * (1, 0, -1, 0)[k], cy + ry * (0, 1, 0, -1)[k])
        arc = arc_points((cx, cy), (rx, ry), (k * quarter, quarter), tolerance)
        pieces += [np.array([first]), arc]
    return [Subpath(np.concatenate(pieces), True)]
