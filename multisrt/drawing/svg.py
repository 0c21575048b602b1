"""Writing SVG: path data from coordinates, and elements that hold any text."""

from __future__ import annotations

import math
import re
import unicodedata
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from multisrt.environments.own_pictures import START_SYMBOLS
from multisrt.geometry.numerics.kernel import FloatArray

Bounds = tuple[float, float, float, float]
Marker = Literal[
    "disc",
    "triangle",
    "wedge",
    "diamond",
    "square",
    "star",
    "octagon",
    "house",
    "pin",
    "arrow",
    "cross",
]

FINEST = 1 / 5000
"""Coordinates are rounded to a power of ten of at most this share of the extent of the map."""

FAR_M = 10_000.0
"""Coordinates beyond this (m) are written relative to a corner of the map.

Browsers compute with 24 binary digits, which resolve millimetres up to here.
"""

CORNERS: dict[Marker, tuple[tuple[float, float], ...]] = {
    "triangle": ((-1.1, -0.75), (1.1, -0.75), (0.0, 1.25)),
    "wedge": ((-1.1, 0.75), (0.0, -1.25), (1.1, 0.75)),
    "diamond": ((0.0, -1.25), (1.25, 0.0), (0.0, 1.25), (-1.25, 0.0)),
    "square": ((-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)),
    "star": tuple(
        (1.5 * math.cos(a), 1.5 * math.sin(a))
        if k % 2 == 0
        else (0.55 * math.cos(a), 0.55 * math.sin(a))
        for k, a in enumerate(math.pi / 4 * n for n in range(8))
    ),
    "octagon": tuple(
        (math.cos(a), math.sin(a)) for a in (math.pi / 8 * n for n in range(1, 17, 2))
    ),
    "house": (
        (-0.8, -0.9),
        (0.8, -0.9),
        (0.8, 0.15),
        (1.2, 0.15),
        (0.0, 1.3),
        (-1.2, 0.15),
        (-0.8, 0.15),
    ),
    "pin": START_SYMBOLS["pin"],
    "arrow": START_SYMBOLS["arrow"],
}
"""Corners of markers of size 1 around (0, 0)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pen:
    """Writer of path data from coordinates in metres: rounded, in relative commands.

    Attributes
    ----------
    origin : (x, y)
        Point that is written as 0, 0, in metres.
    decimals : int
        Number of decimals.
    """

    origin: tuple[float, float] = (0.0, 0.0)
    decimals: int = 3

    @classmethod
    def for_bounds(cls, bounds: Bounds) -> Pen:
        """Return the pen for a map, with as many decimals as zooming in needs."""
        x0, y0, x1, y1 = bounds
        extent = max(x1 - x0, y1 - y0)
        far = max(map(abs, bounds)) > FAR_M
        return cls(
            origin=(float(math.floor(x0)), float(math.floor(y0))) if far else (0.0, 0.0),
            decimals=max(0, math.ceil(-math.log10(extent * FINEST))),
        )

    def line(self, points: ArrayLike) -> str:
        """Return the path data of an open line through ``(n, 2)`` points."""
        return self._path(points, closed=False)

    def rings(self, rings: Iterable[ArrayLike]) -> str:
        """Return the path data of closed rings of ``(n, 2)`` corners, without vanishing rings."""
        return "".join(self._path(ring, closed=True) for ring in rings)

    def marker(self, marker: Marker, x: float, y: float, size: float, turn: float = 0.0) -> str:
        """Return the path data of a marker.

        Parameters
        ----------
        marker : Marker
            Shape of the marker.
        x, y : float
            Its centre, in metres.
        size : float
            Radius of a disc in metres; the other shapes look equally large.
        turn : float, optional
            Counterclockwise rotation, in radians.

        Returns
        -------
        str
            Path data.
        """
        fine = Pen(origin=self.origin, decimals=max(self.decimals, 1 - _exponent(size)) + 1)
        if marker == "disc":
            start = fine.line([(x - size, y)])
            r, d = number(fine._steps(size), fine.decimals), fine._steps(size) * 2
            there, back = number(d, fine.decimals), number(-d, fine.decimals)
            return f"{start}a{r} {r} 0 1 0 {there} 0a{r} {r} 0 1 0 {back} 0z"
        c, s = size * math.cos(turn), size * math.sin(turn)
        if marker == "cross":
            arms = (((-1.0, -1.0), (1.0, 1.0)), ((-1.0, 1.0), (1.0, -1.0)))
            return "".join(
                fine.line([(x + c * u - s * v, y + s * u + c * v) for u, v in arm]) for arm in arms
            )
        corners = [(x + c * u - s * v, y + s * u + c * v) for u, v in CORNERS[marker]]
        return fine._path(corners, closed=True)

    def _path(self, points: ArrayLike, *, closed: bool) -> str:
        # Points are rounded before differences are taken, so that errors do not add up.
        places: FloatArray = np.asarray(points, np.float64).reshape(-1, 2) - self.origin
        steps = np.rint(places * 10.0**self.decimals).astype(np.int64)
        moves = np.diff(steps, axis=0)
        moves = moves[moves.any(axis=1)]
        if closed:
            if len(moves) and not moves.sum(axis=0).any():
                moves = moves[:-1]
            if len(moves) < 2:
                return ""
        text = "M" + _joined(steps[0].tolist(), self.decimals)
        if len(moves):
            text += "l" + _joined(moves.ravel().tolist(), self.decimals)
        return text + "z" if closed else text

    def _steps(self, length: float) -> int:
        return round(length * 10.0**self.decimals)


def number(steps: int, decimals: int) -> str:
    """Return the shortest text of a whole number of steps of ``10**-decimals``."""
    whole, rest = divmod(abs(steps), 10**decimals)
    fraction = f"{rest:0{decimals}d}".rstrip("0") if rest else ""
    text = (str(whole) if whole or not fraction else "") + (f".{fraction}" if fraction else "")
    return f"-{text}" if steps < 0 else text


def plain(value: float) -> str:
    """Return a number with eight significant digits, without an exponent."""
    if value == 0.0:
        return "0"
    decimals = max(0, 7 - _exponent(value))
    return number(round(value * 10.0**decimals), decimals)


def length(metres: float) -> str:
    """Return a length in metres as text for readers.

    Examples
    --------
    >>> length(0.05), length(36.4567), length(1234.56)
    ('0.05 m', '36.46 m', '1,234.6 m')
    """
    text = f"{metres:,.{max(1, 3 - _exponent(metres))}f}"
    return text.rstrip("0").rstrip(".") + " m"


def child(parent: ET.Element, tag: str, text: str = "", /, **attributes: str | float) -> ET.Element:
    """Add an element with a text and attributes and return it; see `set_attributes`."""
    element = ET.SubElement(parent, tag)
    set_attributes(element, attributes)
    if text:
        element.text = printable(text)
    return element


def layer(parent: ET.Element, label: str) -> ET.Element:
    """Add a named group that is a layer in Inkscape, and return it."""
    group = child(parent, "g", id=identifier(label))
    group.set("inkscape:groupmode", "layer")
    group.set("inkscape:label", label)
    return group


def set_attributes(element: ET.Element, attributes: Mapping[str, str | float]) -> None:
    """Set attributes; ``stroke_width`` is written as ``stroke-width``."""
    for name, value in attributes.items():
        element.set(name.replace("_", "-"), value if isinstance(value, str) else plain(value))


def identifier(label: str) -> str:
    """Return the id of a label: lower case letters, digits and hyphens."""
    return re.sub(r"[^A-Za-z0-9]+", "-", label).strip("-").lower()


def printable(text: str) -> str:
    """Return text on one line, with a replacement for characters that XML does not allow."""
    text = " ".join(text.split())
    return "".join("�" if unicodedata.category(c) in ("Cc", "Cs", "Cn") else c for c in text)


def text_width(text: str, size: float) -> float:
    """Return an upper estimate of the width of text, in units of `size`, for any font."""
    wide = sum(unicodedata.east_asian_width(c) in "WF" for c in text)
    return size * (0.6 * (len(text) - wide) + wide)


def _joined(values: Iterable[int], decimals: int) -> str:
    # Before a minus sign no space is needed.
    words = (number(value, decimals) for value in values)
    return "".join(w if w[0] == "-" else f" {w}" for w in words).removeprefix(" ")


def _exponent(value: float) -> int:
    return math.floor(math.log10(abs(value)))
