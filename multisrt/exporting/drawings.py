"""Maps as drawings of polygons: SVG, and DXF for programs of computer-aided design."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Final
from xml.sax.saxutils import escape

import shapely
from shapely import LinearRing, Polygon

from multisrt.environments.environment import Environment
from multisrt.exporting.polygon_text import digits, printable

OUTLINE, OBSTACLES, STARTS = "OUTLINE", "OBSTACLES", "STARTS"
"""Layers of a DXF file: rings around free space, rings around obstacles in it, and points."""

LAYER_COLOURS: Final = {OUTLINE: 7, OBSTACLES: 1, STARTS: 3}
"""Colours of the layers by their number in AutoCAD: black or white, red, green."""

MARGIN: Final = 0.02
"""Margin around a drawing, as a share of its larger side."""

_OPTIONS_LOCK = threading.Lock()


def svg_bytes(environment: Environment) -> bytes:
    """Return a world as an SVG document of its outlines alone, with metres as user units.

    Free space is one path of class ``free`` for each component, filled by the even-odd rule, with
    the obstacles as further rings; suggested starts are circles of class ``start``. SVG counts y
    downwards: a corner (x, y) is written as x, -y, with all digits, and no element is transformed.
    For a picture with legend see `multisrt.drawing.environment_svg`.

    Parameters
    ----------
    environment : Environment
        The world.

    Examples
    --------
    >>> hall = Environment("hall", shapely.box(0, 0, 4, 3))
    >>> print(svg_bytes(hall).decode().splitlines()[-2].partition(" d=")[2])
    "M0 0L4 0L4 -3L0 -3Z"/>

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
        f'viewBox="{" ".join(f"{value:.6g}" for value in box)}">',
        f"<title>{escape(printable(environment.name))}</title>",
        "<desc>User units are metres, y is negated.</desc>",
    ]
    pen = f"{side / 400.0:.3g}"
    style = f'fill="#f2f2f2" fill-rule="evenodd" stroke="#1a1a1a" stroke-width="{pen}"'
    for part in environment.free.geoms:
        data = "".join(_ring(ring) for ring in (part.exterior, *part.interiors))
        lines.append(f'<path class="free" {style} d="{data}"/>')
    style = f'fill="#d55e00" r="{side / 150.0:.3g}"'
    for x, y in environment.starts:
        place = f'cx="{digits(x)}" cy="{digits(0.0 - y)}"'
        lines.append(f'<circle class="start" {style} {place}/>')
    return ("\n".join([*lines, "</svg>"]) + "\n").encode()


def _ring(ring: LinearRing) -> str:
    corners = shapely.get_coordinates(ring)[:-1].tolist()
    return "M" + "L".join(f"{digits(x)} {digits(0.0 - y)}" for x, y in corners) + "Z"


def dxf_bytes(environment: Environment) -> bytes:
    """Return a world as a DXF file of AutoCAD 2010, in metres.

    Rings are closed LWPOLYLINE entities: those around free space on the layer `OUTLINE`, those
    around obstacles on the layer `OBSTACLES`. Suggested starts are POINT entities on the layer
    `STARTS`, in their order. Coordinates have all digits.

    Parameters
    ----------
    environment : Environment
        The world.

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
    import ezdxf
    from ezdxf import units

    with _constant_metadata():
        document = ezdxf.new("R2010", units=units.M)
        for name, colour in LAYER_COLOURS.items():
            document.layers.add(name, color=colour)
        model = document.modelspace()
        for layer, rings in (
            (OUTLINE, [part.exterior for part in environment.free.geoms]),
            (OBSTACLES, _holes(environment.free.geoms)),
        ):
            for ring in rings:
                corners = shapely.get_coordinates(ring)[:-1].tolist()
                model.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
        for start in environment.starts:
            model.add_point(start, dxfattribs={"layer": STARTS})
        text = io.StringIO()
        document.write(text)
    return document.encode(text.getvalue())


def _holes(parts: Iterable[Polygon]) -> list[LinearRing]:
    return [hole for part in parts for hole in part.interiors]


@contextmanager
def _constant_metadata() -> Iterator[None]:
    # The only way that ezdxf offers to leave out the time of writing and random identifiers.
    import ezdxf

    with _OPTIONS_LOCK:
        before = ezdxf.options.write_fixed_meta_data_for_testing
        ezdxf.options.write_fixed_meta_data_for_testing = True
        try:
            yield
        finally:
            ezdxf.options.write_fixed_meta_data_for_testing = before
