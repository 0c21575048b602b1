"""A small map with a caption line of samples below: what all pictures of the algorithms are."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np
import shapely

from multisrt.drawing.colours import ROBOT_COLOURS, VERMILION, tint
from multisrt.environments.environment import Environment

WIDTH, MARGIN = 440, 8
"""Width of a picture and of its margin in pixels."""

LINE = 20
"""Height of a line of samples."""

STYLES = {
    "wall": "fill:#a3a3a3;stroke:#303030;stroke-width:1",
    "region": "fill:#e3ecf4;stroke:none",
    "other": "fill:#f1ece0;stroke:none",
    "known": "fill:#eef3f0;stroke:none",
    "outline": "fill:none;stroke:#7b93a8;stroke-width:1.2",
    "obstacle": "stroke:#303030;stroke-width:3",
    "range": "stroke:#0072b2;stroke-width:3",
    "gap": "stroke:#cc79a7;stroke-width:3",
    "cut": "stroke:#e69f00;stroke-width:3",
    "free": "stroke:#009e73;stroke-width:3",
    "frontier": f"stroke:{VERMILION};stroke-width:3.5",
    "path": "stroke:#303030;stroke-width:1.4;stroke-dasharray:4 3",
    "bold": "stroke:#303030;stroke-width:2",
    "thin": "stroke:#8a8a8a;stroke-width:1",
    "circle": "fill:none;stroke:#8a8a8a;stroke-width:1;stroke-dasharray:2 3",
    "cell": f"fill:{VERMILION};stroke:none",
    "refused": "stroke:#a3a3a3;stroke-width:2.5",
    "chosen": "fill:#009e73;stroke:#fff;stroke-width:1.2",
    "robot": "fill:#303030;stroke:#fff;stroke-width:1.2",
    "target": "fill:#fff;stroke:#303030;stroke-width:1.6",
}
for _number, _colour in enumerate(ROBOT_COLOURS):
    STYLES[f"r{_number}"] = f"fill:{_colour};stroke:#fff;stroke-width:1.2"
    STYLES[f"l{_number}"] = f"stroke:{_colour};stroke-width:2.2"
    STYLES[f"d{_number}"] = f"stroke:{_colour};stroke-width:1.6;stroke-dasharray:5 3"
    STYLES[f"a{_number}"] = f"fill:{tint(_colour, 0.22)};stroke:{_colour};stroke-width:0.8"
DOTS = {"outline", "circle", "robot", "target", "chosen"}
LINES = {"obstacle", "range", "gap", "cut", "free", "frontier", "path", "bold", "thin", "refused"}

Bounds = tuple[float, float, float, float]


class Sketch:
    """A picture of a part of a plane.

    Parameters
    ----------
    title : str
        What it shows, for those who cannot see it.
    bounds : (x0, y0, x1, y1)
        The part, in metres.
    """

    def __init__(self, title: str, bounds: Bounds) -> None:
        self._title = title
        self._bounds = bounds
        self._scale = (WIDTH - 2 * MARGIN) / (bounds[2] - bounds[0])
        self._height = round((bounds[3] - bounds[1]) * self._scale + 2 * MARGIN)
        self._parts: list[str] = []
        self._used: set[str] = set()
        self._samples: list[tuple[str, str]] = []

    def walls(self, environment: Environment) -> None:
        """Draw what is not free."""
        x0, y0, x1, y1 = self._bounds
        solid = shapely.box(x0, y0, x1, y1).difference(environment.free)
        self.area(solid, "wall")

    def area(self, shape: shapely.Geometry, style: str) -> None:
        """Draw a polygon, or several."""
        path = self._rings(shape)
        self._add(f'<path class="{style}" fill-rule="evenodd" d="{path}"/>', style)

    def line(self, points: Any, style: str, *, arrow: bool = False) -> None:
        """Draw a line through points, ``(n, 2)``."""
        tip = ' marker-end="url(#tip)"' if arrow else ""
        self._add(f'<path class="{style}" fill="none" d="{self._path(points)}"{tip}/>', style)

    def segments(self, segments: Any, style: str) -> None:
        """Draw segments, ``(n, 4)``."""
        path = "".join(self._path([s[:2], s[2:]]) for s in np.asarray(segments).reshape(-1, 4))
        self._add(f'<path class="{style}" fill="none" d="{path}"/>', style)

    def dot(self, x: float, y: float, style: str, size: float = 5.0) -> None:
        """Draw a dot of a size in pixels."""
        px, py = self._at(x, y)
        self._add(f'<circle class="{style}" cx="{px}" cy="{py}" r="{size:g}"/>', style)

    def circle(self, x: float, y: float, radius_m: float, style: str = "circle") -> None:
        """Draw a circle of a radius in metres."""
        self.dot(x, y, style, round(radius_m * self._scale, 1))

    def cross(self, x: float, y: float, style: str = "refused", size: float = 4.0) -> None:
        """Draw a cross."""
        r = size / self._scale
        self.segments([[x - r, y - r, x + r, y + r], [x - r, y + r, x + r, y - r]], style)

    def cells(self, centres: Any, cell_m: float, style: str) -> None:
        """Fill cells around centres, ``(n, 2)``."""
        self.area(squares(centres, cell_m), style)

    def fill(self, shape: shapely.Geometry, colour: str) -> None:
        """Draw a polygon in its own colour."""
        self._parts.append(f'<path fill="{colour}" fill-rule="evenodd" d="{self._rings(shape)}"/>')

    def text(self, x: float, y: float, text: str, *, dx: float = 0.0, dy: float = 0.0) -> None:
        """Write a text, with a white halo, centred at a place plus an offset in pixels."""
        px, py = self._at(x, y)
        self._parts.append(f'<text x="{px + dx:g}" y="{py + dy + 4.5:g}">{escape(text)}</text>')

    def sample(self, style: str, label: str) -> None:
        """Explain a style below the map."""
        self._used.add(style)
        self._samples.append((style, label))

    def svg(self) -> str:
        """Return the picture."""
        below, height = self._legend()
        styles = "".join(f".{name}{{{STYLES[name]}}}" for name in sorted(self._used))
        return "\n".join(
            [
                f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
                f'viewBox="0 0 {WIDTH} {height}" role="img">',
                f"<title>{escape(self._title)}</title>",
                "<style>text{font:600 13px system-ui,sans-serif;text-anchor:middle;fill:#202020;"
                "paint-order:stroke;stroke:#fff;stroke-width:3px}"
                ".key{font-weight:400;text-anchor:start}" + styles + "</style>",
                '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="5" '
                'markerHeight="5" orient="auto-start-reverse">'
                '<path d="M0 0 8 4 0 8z" fill="#303030"/></marker>'
                f'<clipPath id="map"><rect width="{WIDTH}" height="{self._height}"/></clipPath>'
                "</defs>",
                f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
                '<g clip-path="url(#map)">',
                *self._parts,
                "</g>",
                *below,
                "</svg>\n",
            ]
        )

    def _legend(self) -> tuple[list[str], int]:
        parts, x, y = [], MARGIN, self._height + 12
        for style, label in self._samples:
            width = 30 + round(7.2 * len(label)) + 8
            if x > MARGIN and x + width > WIDTH:
                x, y = MARGIN, y + LINE
            of_robot = style[0] if style[1:].isdigit() else ""
            if style in LINES or of_robot in ("l", "d"):
                parts.append(f'<path class="{style}" fill="none" d="M{x} {y}h22"/>')
            elif style in DOTS or of_robot == "r":
                parts.append(f'<circle class="{style}" cx="{x + 11}" cy="{y}" r="5"/>')
            else:
                parts.append(f'<rect class="{style}" x="{x}" y="{y - 6}" width="22" height="12"/>')
            parts.append(f'<text class="key" x="{x + 28}" y="{y + 4.5:g}">{escape(label)}</text>')
            x += width
        return parts, y + 14 if self._samples else self._height

    def _add(self, part: str, style: str) -> None:
        self._used.add(style)
        self._parts.append(part)

    def _at(self, x: float, y: float) -> tuple[float, float]:
        x0, _, _, y1 = self._bounds
        return (
            round(MARGIN + (x - x0) * self._scale, 1),
            round(MARGIN + (y1 - y) * self._scale, 1),
        )

    def _rings(self, shape: shapely.Geometry) -> str:
        return "".join(
            self._path(ring.coords, closed=True)
            for polygon in shapely.get_parts(shape)
            if isinstance(polygon, shapely.Polygon)
            for ring in (polygon.exterior, *polygon.interiors)
        )

    def _path(self, points: Iterable[Sequence[float]], *, closed: bool = False) -> str:
        places = dict.fromkeys(self._at(p[0], p[1]) for p in points)
        return "M" + " ".join(f"{x:g} {y:g}" for x, y in places) + ("z" if closed else "")


def squares(centres: Any, width: float) -> shapely.Geometry:
    """Return the union of the cells of a grid around centres, ``(n, 2)``."""
    places = np.asarray(centres, np.float64).reshape(-1, 2)
    corner = places.min(axis=0) - 0.5 * width
    x, y = np.rint((places - corner) / width - 0.5).T
    union = shapely.simplify(shapely.union_all(shapely.box(x, y, x + 1, y + 1)), 0.0)
    return shapely.transform(union, lambda corners: corner + width * corners)


def plan(name: str, outline: shapely.Geometry, walls: Iterable[shapely.Geometry]) -> Environment:
    """Return a world: an outline, less its walls."""
    return Environment(name, outline.difference(shapely.union_all(list(walls))))


def wall(x0: float, y0: float, x1: float, y1: float) -> shapely.Polygon:
    """Return a box from corner to corner."""
    return shapely.box(x0, y0, x1, y1)
