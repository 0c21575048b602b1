"""Free space of generators whose worlds are passable by construction.

A generator that keeps all obstacles a passage apart, or moves a square over a grid, leaves neither
cracks nor pockets. `passable` would find none, but takes minutes for 10,000 obstacles.
"""

from collections.abc import Iterable, Sequence
from typing import TypeVar

import numpy as np
import shapely
from scipy.spatial import cKDTree
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics.kernel import FloatArray

Shape = TypeVar("Shape", bound=BaseGeometry)

DECIMALS = 3
"""Decimals of coordinates in metres, which hide rounding differences between machines."""


def polygon_around(ground: Polygon, obstacles: FloatArray | Iterable[Polygon]) -> Polygon:
    """Return the ground without obstacles that touch neither each other nor its border.

    Parameters
    ----------
    ground : Polygon
        The outline, in metres.
    obstacles : array, shape (n, corners, 2), or iterable of Polygon
        Corners of each obstacle in metres, or obstacles, whose holes are filled.

    Returns
    -------
    Polygon
        Free space, with coordinates rounded to millimetres.

    Examples
    --------
    >>> hall = polygon_around(shapely.box(0, 0, 9, 9), [shapely.box(2, 2, 4, 4)])
    >>> hall.area
    77.0
    """
    if isinstance(obstacles, np.ndarray):
        holes = [shapely.LinearRing(corners) for corners in np.round(obstacles, DECIMALS)]
    else:
        holes = [on_millimetres(obstacle.exterior) for obstacle in obstacles]
    return Polygon(on_millimetres(ground.exterior), holes)


def on_millimetres(shape: Shape) -> Shape:
    """Return a shape with all coordinates rounded to millimetres."""
    rounded: Shape = shapely.transform(shape, lambda points: np.round(points, DECIMALS))
    return rounded


def starts_among(
    places: FloatArray, wanted: Sequence[tuple[float, float]]
) -> tuple[tuple[float, float], ...]:
    """Return, for each wanted start, the nearest of some places.

    Parameters
    ----------
    places : array, shape (n, 2)
        Places with room for a robot, in metres; at least one.
    wanted : sequence of (x, y)
        Wanted starts in metres.

    Returns
    -------
    tuple of (x, y)
        The starts in the order of `wanted`, without repetitions, rounded to millimetres.

    Examples
    --------
    >>> starts_among(np.array([[1.0, 1.0], [5.0, 5.0]]), [(0, 0), (6, 6), (1, 0)])
    ((1.0, 1.0), (5.0, 5.0))
    """
    _, nearest = cKDTree(places).query(np.asarray(wanted))
    found = np.round(places[nearest], DECIMALS)
    return tuple(dict.fromkeys((float(x), float(y)) for x, y in found))
