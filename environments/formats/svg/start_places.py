"""Places of the starts that a drawing marks."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from multisrt.environments.formats.svg.lengths import numbers
from multisrt.environments.formats.svg.shapes import Outline
from multisrt.environments.formats.svg.tree import Drawn
from multisrt.environments.own_pictures import LINES_TO_STARTS, START_SYMBOLS, TO_START
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

Point = tuple[float, float]

MAX_MISFIT: Final = 0.02
"""Maximum distance of a corner of a symbol from its place, in sizes of the symbol."""


def _numbers(points: FloatArray) -> NDArray[np.complex128]:
    """Return points ``(n, 2)`` as complex numbers."""
    found: NDArray[np.complex128] = points[:, 0] + 1.0j * points[:, 1]
    return found


_SYMBOLS: Final = [_numbers(np.asarray(corners)) for corners in START_SYMBOLS.values()]


def start_places(drawn: Drawn, lines: Outline) -> list[Point]:
    """Return the places of the starts that a shape marks, in metres.

    It is the centre of each subpath: of its bounding box, or of the disc if it is a symbol with a
    tip as in pictures of runs. A symbol that stands beside its start says where that is.

    Parameters
    ----------
    drawn : Drawn
        The shape.
    lines : Outline
        Its lines.

    Raises
    ------
    SvgError
        If the attribute that says where the start is has no numbers.
    """
    if drawn.named == LINES_TO_STARTS:  # to symbols, which are starts themselves
        return []
    beside = numbers(drawn.element.attributes.get(TO_START, ""))
    if len(beside) != 2:
        beside = [0.0, 0.0]
    offset = libm.product(drawn.matrix[:2, :2], np.array([beside]).T)[:, 0]
    places = []
    for points, _ in lines.metres:
        x, y = _centre(points) + offset
        places.append((float(x), float(y)))
    return places


def _centre(points: FloatArray) -> FloatArray:
    """Return the centre of a line: that of a symbol, turned and scaled, or of its bounding box."""
    corners = _numbers(points)
    for symbol in _SYMBOLS:
        if len(corners) != len(symbol):
            continue
        # Similarity of the least squares, in complex numbers: turn by its angle, scale by its size.
        around, at = symbol - symbol.mean(), corners - corners.mean()
        turn = (around.conj() * at).sum() / (np.abs(around) ** 2).sum()
        if np.abs(at - turn * around).max() <= MAX_MISFIT * abs(turn):
            centre = corners.mean() - turn * symbol.mean()
            return np.array([centre.real, centre.imag])
    middle: FloatArray = (points.min(axis=0) + points.max(axis=0)) / 2
    return middle
