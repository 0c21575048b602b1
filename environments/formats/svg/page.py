"""The size and the scale of an SVG document."""

import math
import re
from typing import Final, NamedTuple

import numpy as np
import shapely
from shapely import Polygon

from multisrt.environments.formats.files import (
    RESOLUTION_OPTION,
    refuse_resolution,
    require_length,
    require_resolution,
)
from multisrt.environments.formats.svg.lengths import (
    PX_PER_UNIT,
    SvgError,
    fitted,
    length_and_unit,
)
from multisrt.environments.formats.svg.tree import Document, view_box
from multisrt.environments.formats.xml_text import Element
from multisrt.geometry.errors import MapFormatError, shown
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

MIN_REAL_SIZE_M: Final = 1.2
"""A page whose sides are both shorter is paper: the longer side of A0 has 1.189 m."""

MIN_RESOLUTION_M: Final = 1e-6
"""Smallest size of a user unit, in metres."""

OWN_COORDINATES: Final = re.compile(
    r"Coordinates of the layer 'map' are metres(?: from \((-?\d{1,9}), (-?\d{1,9})\))?, y up\."
)
"""Sentence in the description of pictures of this package, whose layer ``map`` is in metres."""

_PX_M: Final = 0.0254 / 96


class Page(NamedTuple):
    """The page of a document.

    Attributes
    ----------
    element : Element
        The element that is read: the root, or the layer ``map`` of a picture of this package.
    matrix : float array, shape (3, 3)
        Transform from its user space to metres, y up.
    viewport : (width, height)
        Size of its viewport, in user units.
    frame : Polygon or None
        The rectangle of the page in metres, with its lower left corner at the origin; None if
        the document has no page.
    px_m : float
        Metres per CSS pixel.
    scale : str
        The scale in words.
    is_own : bool
        Whether the document is a picture of this package.
    """

    element: Element
    matrix: FloatArray
    viewport: tuple[float, float]
    frame: Polygon | None
    px_m: float
    scale: str
    is_own: bool = False


def page_of(document: Document, resolution_m: float | None) -> Page:
    """Return the page of a document.

    Parameters
    ----------
    document : Document
        The document.
    resolution_m : float or None
        Metres per user unit, if given.

    Raises
    ------
    MapFormatError
        If the document has no scale and none is given, or has its own and one is given.
    SvgError
        If a size is wrong.
    """
    path, root = document.path, document.root
    box = view_box(root)
    sizes = {side: _size(root, side) for side in ("width", "height")}
    own, corner = document.by_id.get("map"), _own_corner(root)
    if own is not None and corner is not None:
        refuse_resolution(path, resolution_m)
        viewport = box[2:] if box else (0.0, 0.0)
        x, y = corner
        placed = np.array([[1, 0, x], [0, 1, y], [0, 0, 1.0]])
        return Page(own, placed, viewport, None, 1.0, "in metres", is_own=True)
    width, height = sizes["width"], sizes["height"]
    aspect = root.attributes.get("preserveAspectRatio", "xMidYMid meet")
    px = [None if one is None else one[0] * PX_PER_UNIT[one[1]] for one in (width, height)]
    if resolution_m is None and _is_paper(width, height):
        raise MapFormatError(f"{path} {_paper_scale(px, box)}")
    units = {one[1] for one in (width, height) if one is not None}
    if resolution_m is None and units and not units & {"", "px"}:
        # A side that is missing follows from the view box.
        ratio = box[2] / box[3] if box else 0.0
        w = (px[0] if px[0] is not None else (px[1] or 0.0) * ratio) * _PX_M
        h = (px[1] if px[1] is not None else (px[0] or 0.0) / (ratio or math.inf)) * _PX_M
        if not (w > 0 and h > 0):
            raise SvgError("width and height are not both given, and positive")
        inner = fitted(box, w, h, aspect) if box else np.diag([_PX_M, _PX_M, 1.0])
        viewport = box[2:] if box else (w / _PX_M, h / _PX_M)
        frame = _frame(document, w, h)
        placed = libm.product(_flipped(h), inner)
        return Page(root, placed, viewport, frame, _PX_M, "at its own size")
    scale = require_resolution(path, resolution_m, unit="user unit", min_m=MIN_RESOLUTION_M)
    said = f"at {scale:g} m per user unit"
    if box is None and (px[0] is None or px[1] is None):
        return Page(root, np.diag([scale, -scale, 1.0]), (0.0, 0.0), None, scale, said)
    if box is None:
        box = (0.0, 0.0, px[0] or 0.0, px[1] or 0.0)
        if not (box[2] > 0 and box[3] > 0):
            raise SvgError("width and height are positive")
    w, h = box[2] * scale, box[3] * scale
    px_m = w / px[0] if px[0] else h / px[1] if px[1] else scale
    frame = _frame(document, w, h)
    placed = libm.product(_flipped(h), fitted(box, w, h, "none"))
    return Page(root, placed, box[2:], frame, px_m, said)


def _own_corner(root: Element) -> tuple[float, float] | None:
    """Return the origin of the coordinates of a picture of this package; None for others."""
    for one in root.children:
        found = OWN_COORDINATES.search(one.text) if one.name == "desc" else None
        if found:
            return float(found.group(1) or 0), float(found.group(2) or 0)
    return None


def _frame(document: Document, width_m: float, height_m: float) -> Polygon:
    place = document.place(document.root)
    require_length(place, "the width of the page", width_m)
    require_length(place, "the height of the page", height_m)
    return shapely.box(0, 0, width_m, height_m)


def _flipped(height: float) -> FloatArray:
    return np.array([[1, 0, 0], [0, -1, height], [0, 0, 1.0]])


def _size(root: Element, side: str) -> tuple[float, str] | None:
    """Return the number and unit of a side; None if it is missing or relative to the window."""
    text = root.attributes.get(side, "auto").strip()
    if text == "auto":
        return None
    value, unit = length_and_unit(text)
    if unit == "%":
        return None
    if value < 0:
        raise SvgError(f"the {side} {shown(text)} is negative")
    return value, unit


def _is_paper(width: tuple[float, str] | None, height: tuple[float, str] | None) -> bool:
    given = [one for one in (width, height) if one is not None]
    is_physical = bool(given) and all(unit not in ("", "px") for _, unit in given)
    sides = [value * PX_PER_UNIT[unit] * _PX_M for value, unit in given]
    return is_physical and max(sides) < MIN_REAL_SIZE_M


def _paper_scale(px: list[float | None], box: tuple[float, float, float, float] | None) -> str:
    sides = " x ".join("?" if one is None else f"{one * _PX_M * 1000:.4g}" for one in px)
    ratios = [one / side for one, side in zip(px, (box or (0, 0, 1, 1))[2:], strict=True) if one]
    unit_m = (min(ratios) if box else 1.0) * _PX_M if ratios else _PX_M
    return (
        f"is a page of {sides} mm, which is paper: it does not say at which scale it is drawn; "
        f"give the metres per user unit with {RESOLUTION_OPTION}. A user unit is "
        f"{unit_m * 1000:.4g} mm on paper: {unit_m:.4g} at full size, {100 * unit_m:.4g} at 1:100"
    )
