"""Colours and bodies of robots, as in the pictures of the package."""

from __future__ import annotations

from typing import Final

import numpy as np
from mapbox_earcut import triangulate_float64

from multisrt.drawing.colours import INK, VERMILION, RobotStyles, channels
from multisrt.exporting.contents import Colour, State
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.numerics.arrays import FloatArray


def _rgba(colour: str, opacity: float = 1.0) -> Colour:
    red, green, blue = channels(colour)
    return red / 255.0, green / 255.0, blue / 255.0, opacity


FRONTIER: Final = _rgba(VERMILION)
LINK: Final = _rgba("#5c5c5c", 0.6)
OFF: Final = _rgba("#c9c9c9")
DEAD: Final = _rgba(INK)

SILENT_OPACITY: Final = 0.4
"""Opacity of the body of a robot whose radio is silent."""


def colour_of(robot: int) -> Colour:
    """Return the colour of a robot, by its number."""
    stroke = RobotStyles.of(robot).edge.stroke
    assert stroke is not None
    return _rgba(stroke)


def body_colour(robot: int, state: State) -> Colour:
    """Return the colour of the body of a robot."""
    match state:
        case "not started":
            return OFF
        case "dead":
            return DEAD
        case "silent":
            return (*colour_of(robot)[:3], SILENT_OPACITY)
        case "on":
            return colour_of(robot)


def outline_of(footprint: str) -> FloatArray:
    """Return the corners of a body in its own frame in metres, ``(n, 2)``, counter-clockwise."""
    return Footprint.parse(footprint).vertices


def triangles_of(outline: FloatArray) -> FloatArray:
    """Return the corners of triangles that fill an outline, ``(3 k, 2)``, counter-clockwise.

    Examples
    --------
    >>> square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    >>> triangles_of(square).shape
    (6, 2)
    """
    corners = np.array(outline, np.float64)  # the triangulation needs a writeable array
    indices = triangulate_float64(corners, np.array([len(corners)], np.uint32))
    triangles = corners[indices].reshape(-1, 3, 2)
    (ax, ay), (bx, by) = (triangles[:, k].T - triangles[:, 0].T for k in (1, 2))
    clockwise = ax * by - ay * bx < 0.0
    triangles[clockwise] = triangles[clockwise][:, ::-1]
    return triangles.reshape(-1, 2)
