"""Maps as drawings of polygons: SVG, and DXF for CAD programs."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Final
from xml.sax.saxutils import escape

import shapely
from shapely import LinearRing, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.exporting.polygon_text import digits, printable
from multisrt.extras import extra

OUTLINE, OBSTACLES, STARTS = "OUTLINE", "OBSTACLES", "STARTS"
"""Layers of a DXF file: rings around free space, rings around obstacles in it, and starts."""

LAYER_COLOURS: Final = {OUTLINE: 7, OBSTACLES: 1, STARTS: 3}
"""Colours of the layers by their number in AutoCAD: black or white, red, green."""

COORDINATES: Final = "Coordinates of the layer 'map' are metres, y up."
"""Description of an SVG document, as in the pictures of the package."""

MARGIN: Final = 0.02
"""Margin around a drawing, as a share of its larger side."""

_OPTIONS_LOCK = threading.Lock()


def svg_bytes(environment: Environment) -> bytes:
    """Return a world as an SVG document of its outlines alone, with metres as user units.

    In the group ``map``, which turns y up, free space is one path of class ``free`` for each
    component, filled by the even-odd rule, with the obstacles as further rings; suggested starts
    are circles of class ``start``. Coordinates are those of the world, with all digits. For a
    picture with legend see `multisrt.drawing.environment_svg`.

    Parameters
    ----------
    environment : Environment
        The world.

    Examples
    --------
    >>> hall = Environment("hall", shapely.box(0, 0, 4, 3))
    >>> print(svg_bytes(hall).decode().splitlines()[-3].partition(" d=")[2])
    "M0 0L4 0L4 3L0 3Z"/>

    Notes
    -----
    Source: W3C, Scalable Vector Graphics (SVG) 1.1.
    """
    x0, y0, x1, y1 = environment.bounds
    side = max(x1 - x0, y1 - y0)
    margin = MARGIN * side
    box = (x0 - margin, -y1 - margin, x1 - x0 + 2.0 * margin, y1 - y0 + 2.0 * margin)
    lines = [
        '<svg xmlns="http://www.w3.org/2000/svg" '
        f'viewBox="{" ".join(f"{value:.9g}" for value in box)}">',
        f"<title>{escape(printable(environment.name))}</title>",
        f"<desc>{COORDINATES}</desc>",
        '<g id="map" transform="scale(1 -1)">',
    ]
    style = f'fill="#f2f2f2" fill-rule="evenodd" stroke="#1a1a1a" stroke-width="{side / 400.0:.3g}"'
    for part in environment.free.geoms:
        data = "".join(_ring(ring) for ring in (part.exterior, *part.interiors))
        lines.append(f'<path class="free" {style} d="{data}"/>')
    style = f'fill="#d55e00" r="{side / 150.0:.3g}"'
    for x, y in environment.starts:
        lines.append(f'<circle class="start" {style} cx="{digits(x)}" cy="{digits(y)}"/>')
    return ("\n".join([*lines, "</g>", "</svg>"]) + "\n").encode()


def _ring(ring: LinearRing) -> str:
    corners = shapely.get_coordinates(ring)[:-1].tolist()
    return "M" + "L".join(f"{digits(x)} {digits(y)}" for x, y in corners) + "Z"


def dxf_bytes(environment: Environment) -> bytes:
    """Return a world as a DXF file of AutoCAD 2010, in metres.

    Rings are closed LWPOLYLINE entities: those around free space on the layer `OUTLINE`, those
    around obstacles on the layer `OBSTACLES`; an obstacle around another component of free space is
    cut into several rings. Suggested starts are POINT entities on the layer `STARTS`, in their
    order. Coordinates have all digits.

    Parameters
    ----------
    environment : Environment
        The world.

    Raises
    ------
    MissingExtraError
        If ezdxf is not installed (``multisrt[dxf]``).

    Examples
    --------
    >>> hall = Environment("hall", shapely.box(0, 0, 4, 3))
    >>> dxf_bytes(hall) == dxf_bytes(hall)
    True

    Notes
    -----
    Source: Autodesk, DXF Reference; the file is written by ezdxf. Times and identifiers of the
    file are constant, so that equal worlds give equal bytes.
    """
    with extra("dxf", "a DXF file"):
        import ezdxf
        from ezdxf import units

    with _constant_metadata():
        document = ezdxf.new("R2010", units=units.M)
        for name, colour in LAYER_COLOURS.items():
            document.layers.add(name, color=colour)
        model = document.modelspace()
        for layer, rings in (
            (OUTLINE, [part.exterior for part in environment.free.geoms]),
            (OBSTACLES, _obstacle_rings(environment.free.geoms)),
        ):
            for ring in rings:
                corners = shapely.get_coordinates(ring)[:-1].tolist()
                model.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
        for start in environment.starts:
            model.add_point(start, dxfattribs={"layer": STARTS})
        text = io.StringIO()
        document.write(text)
    return document.encode(text.getvalue())


def _obstacle_rings(parts: Iterable[Polygon]) -> list[LinearRing]:
    """Return rings around obstacles; an obstacle with free space inside is cut into several."""
    outlines = [Polygon(part.exterior) for part in parts]
    rings: list[LinearRing] = []
    for hole in (Polygon(ring) for part in parts for ring in part.interiors):
        inner = [outline for outline in outlines if hole.contains(outline)]
        if not inner:
            rings.append(hole.exterior)
            continue
        pieces: list[BaseGeometry] = [hole.difference(shapely.union_all(inner))]
        while pieces:
            piece = pieces.pop()
            if not isinstance(piece, Polygon):
                pieces += [one for one in shapely.get_parts(piece) if one.area > 0.0]
            elif piece.interiors:
                pieces += _halves(piece)
            else:
                rings.append(piece.exterior)
    return rings


def _halves(polygon: Polygon) -> list[BaseGeometry]:
    """Return a polygon cut at an upright line through the middle of one of its holes."""
    x0, y0, x1, y1 = polygon.bounds
    low, _, high, _ = polygon.interiors[0].bounds
    middle = 0.5 * (low + high)
    sides = shapely.box(x0, y0, middle, y1), shapely.box(middle, y0, x1, y1)
    return [polygon.intersection(side) for side in sides]


@contextmanager
def _constant_metadata() -> Iterator[None]:
    # ezdxf has no other way to leave out the time of writing and random identifiers.
    import ezdxf

    with _OPTIONS_LOCK:
        before = ezdxf.options.write_fixed_meta_data_for_testing
        ezdxf.options.write_fixed_meta_data_for_testing = True
        try:
            yield
        finally:
            ezdxf.options.write_fixed_meta_data_for_testing = before
