"""Places of the starts that a drawing marks."""

import math
from typing import Final

import numpy as np

from multisrt.environments.formats.svg.lengths import numbers
from multisrt.environments.formats.svg.shapes import Outline
from multisrt.environments.formats.svg.tree import Drawn
from multisrt.environments.own_pictures import LINES_TO_STARTS, START_SYMBOLS, TO_START
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

Point = tuple[float, float]

MAX_MISFIT: Final = 0.02
"""Maximum distance of a corner of a symbol from its place, in sizes of the symbol."""


_SYMBOLS: Final = [np.asarray(corners, np.float64) for corners in START_SYMBOLS.values()]


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
    for symbol in _SYMBOLS:
        if len(points) != len(symbol):
            continue
        # Similarity of the least squares: turns by its angle, scales by its size.
        around, at = symbol - symbol.mean(axis=0), points - points.mean(axis=0)
        square = (around * around).sum()
        along = (around * at).sum() / square
        across = (around[:, 0] * at[:, 1] - around[:, 1] * at[:, 0]).sum() / square
        turn = np.array([[along, across], [-across, along]])
        misfits = np.hypot(*(at - libm.product(around, turn)).T)
        if misfits.max() <= MAX_MISFIT * math.hypot(along, across):
            centre: FloatArray = (
                points.mean(axis=0) - libm.product(symbol.mean(axis=0)[None], turn)[0]
            )
            return centre
    middle: FloatArray = (points.min(axis=0) + points.max(axis=0)) / 2
    return middle
