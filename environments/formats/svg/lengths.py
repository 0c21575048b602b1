"""Numbers, lengths and transforms in attributes of SVG."""

import math
import re
from functools import lru_cache
from typing import Final

import numpy as np

from multisrt.environments.cleaning import ZERO_M
from multisrt.geometry.errors import shortened, shown
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

MAX_NUMBER: Final = 1e12
"""Upper bound of the absolute value of numbers, so that their products are finite."""

MAX_NUMBERS: Final = 400_000
"""Upper bound of the numbers in a list: two for each point of the largest drawing."""

MAX_FUNCTIONS: Final = 20
"""Upper bound of the functions of a transform."""

MAX_LENGTH_CHARACTERS: Final = 100
"""Upper bound of the text of a length, whose pattern takes quadratic time."""

PX_PER_UNIT: Final = {
    "": 1.0,
    "px": 1.0,
    "pt": 96 / 72,
    "pc": 16.0,
    "in": 96.0,
    "cm": 96 / 2.54,
    "mm": 96 / 25.4,
    "q": 96 / 101.6,
}
"""Size of each unit in CSS pixels, of which an inch has 96."""

NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_LENGTH: Final = re.compile(rf"\s*({NUMBER.pattern})\s*([a-zA-Z]*|%)\s*\Z")
_SEPARATORS: Final = " \t\r\n\f,"
_FUNCTION: Final = re.compile(r"[\s,]*([a-zA-Z]+)\s*\(([^()]*)\)[\s,]*")


class SvgError(ValueError):
    """Part of an element cannot be read; the message states it, and what is allowed."""


def number(text: str) -> float:
    """Return a number of at most `MAX_NUMBER`; those nearer to 0 than `ZERO_M` are 0.

    Raises
    ------
    SvgError
        If it is not a number or too large.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not abs(value) <= MAX_NUMBER:
        raise SvgError(f"{shown(text)} is not a number up to {MAX_NUMBER:g}")
    return value if abs(value) >= ZERO_M else 0.0


def numbers(text: str) -> list[float]:
    """Return numbers that are separated by spaces and commas.

    Examples
    --------
    >>> numbers("1,2 -3.5e1")
    [1.0, 2.0, -35.0]
    """
    values: list[float] = []
    at = 0
    for found in NUMBER.finditer(text):
        if text[at : found.start()].strip(_SEPARATORS) or len(values) >= MAX_NUMBERS:
            break
        values.append(number(found.group()))
        at = found.end()
    if text[at:].strip(_SEPARATORS):
        raise SvgError(
            f"{shown(text[at : at + 40].strip())} is not part of a list of at most {MAX_NUMBERS:,} "
            "numbers"
        )
    return values


def length_and_unit(text: str) -> tuple[float, str]:
    """Return the number and the unit of a length, in lower case.

    Examples
    --------
    >>> length_and_unit("12.5 MM")
    (12.5, 'mm')
    """
    found = _LENGTH.match(text) if len(text) <= MAX_LENGTH_CHARACTERS else None
    unit = found.group(2).lower() if found else ""
    if found is None or not (unit == "%" or unit in PX_PER_UNIT):
        raise SvgError(f"{shown(text)} is not a length in px, mm, cm, in, pt, pc or %")
    return number(found.group(1)), unit


def length(text: str, whole: float) -> float:
    """Return a length in user units.

    Parameters
    ----------
    text : str
        The length.
    whole : float
        The length of 100 %, in user units.

    Examples
    --------
    >>> length("2in", 0.0), length("50%", 30.0)
    (192.0, 15.0)
    """
    value, unit = length_and_unit(text)
    return value * whole / 100 if unit == "%" else value * PX_PER_UNIT[unit]


@lru_cache(maxsize=256)
def matrix(text: str) -> FloatArray:
    """Return a transform as a ``(3, 3)`` matrix for column vectors x, y, 1.

    Examples
    --------
    >>> matrix("translate(1 2) scale(3)") @ (1, 1, 1)
    array([4., 5., 1.])
    """
    result = np.eye(3)
    at = functions = 0
    text = text.rstrip()
    while at < len(text):
        found = _FUNCTION.match(text, at)
        functions += 1
        if functions > MAX_FUNCTIONS:
            raise SvgError(f"a transform has more than {MAX_FUNCTIONS} functions")
        if found is None:
            raise SvgError(f"{shown(text[at : at + 40])} is not a transform")
        result = libm.product(result, _function(found.group(1), numbers(found.group(2))))
        at = found.end()
        if not np.abs(result).max() <= MAX_NUMBER:
            raise SvgError(f"the transform {shown(text)} is beyond {MAX_NUMBER:g}")
    result.setflags(write=False)
    return result


def _function(name: str, values: list[float]) -> FloatArray:
    match name, values:
        case "matrix", [a, b, c, d, e, f]:
            return np.array([[a, c, e], [b, d, f], [0, 0, 1]])
        case "translate", [x]:
            return _moved(x, 0.0)
        case "translate", [x, y]:
            return _moved(x, y)
        case "scale", [x]:
            return np.diag([x, x, 1.0])
        case "scale", [x, y]:
            return np.diag([x, y, 1.0])
        case "rotate", [angle]:
            return _turned(angle)
        case "rotate", [angle, x, y]:
            return libm.product(libm.product(_moved(x, y), _turned(angle)), _moved(-x, -y))
        case "skewX", [angle]:
            return np.array([[1, math.tan(math.radians(angle)), 0], [0, 1, 0], [0, 0, 1]])
        case "skewY", [angle]:
            return np.array([[1, 0, 0], [math.tan(math.radians(angle)), 1, 0], [0, 0, 1]])
    raise SvgError(f"{shortened(name)} with {len(values)} numbers is not a transform")


def _moved(x: float, y: float) -> FloatArray:
    return np.array([[1, 0, x], [0, 1, y], [0, 0, 1.0]])


def _turned(degrees: float) -> FloatArray:
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1.0]])


def fitted(
    view_box: tuple[float, float, float, float], width: float, height: float, aspect: str
) -> FloatArray:
    """Return the transform from a view box to a viewport with its corner at the origin.

    Parameters
    ----------
    view_box : (x, y, width, height)
        The part of user space that is shown; its sides are positive.
    width, height : float
        Sides of the viewport.
    aspect : str
        The attribute ``preserveAspectRatio``.

    Examples
    --------
    >>> fitted((0, 0, 10, 5), 20, 20, "xMidYMid meet") @ (10, 5, 1)
    array([20., 15.,  1.])
    """
    x, y, w, h = view_box
    sx, sy = width / w, height / h
    words = aspect.split() or ["xMidYMid"]
    dx = dy = 0.0
    if words[0] != "none":
        if not re.fullmatch(r"x(Min|Mid|Max)Y(Min|Mid|Max)", words[0]):
            raise SvgError(f"{shown(aspect)} is not a preserveAspectRatio")
        sx = sy = max(sx, sy) if "slice" in words[1:] else min(sx, sy)
        share = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
        dx = (width - sx * w) * share[words[0][1:4]]
        dy = (height - sy * h) * share[words[0][5:8]]
    return libm.product(libm.product(_moved(dx, dy), np.diag([sx, sy, 1.0])), _moved(-x, -y))
