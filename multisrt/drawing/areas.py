"""The areas of a map by the robot that saw them first."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
import numpy.typing as npt
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics.kernel import FloatArray

Shapes = npt.NDArray[np.object_]


def seen_first(
    regions: Sequence[BaseGeometry], robots: Sequence[int], grid_m: float
) -> dict[int, list[FloatArray]]:
    """Partition the union of regions among the robots that saw its parts first.

    Parameters
    ----------
    regions : sequence of polygons
        In the order in which they were seen.
    robots : sequence of int
        The robot that saw each region.
    grid_m : float
        Width in metres of the grid that corners are rounded to. Parts narrower than it are
        dropped.

    Returns
    -------
    dict from int to list of (n, 2) array
        The rings of the area of each robot, of all its parts; robots without an area are left
        out. Areas do not overlap.

    Examples
    --------
    >>> first, second = shapely.box(0, 0, 2, 1), shapely.box(1, 0, 4, 1)
    >>> areas = seen_first([first, second], [7, 3], 0.001)
    >>> [float(shapely.Polygon(areas[robot][0]).area) for robot in (7, 3)]
    [2.0, 2.0]
    """
    # Differences of shapes need valid shapes with corners on the grid.
    shapes = shapely.set_precision(shapely.make_valid(np.asarray(regions, object)), grid_m)
    new = [
        _without_earlier(shapes, index, earlier) for index, earlier in _earlier_neighbours(shapes)
    ]
    areas: dict[int, list[FloatArray]] = {}
    for robot in sorted(set(robots)):
        own = [piece for piece, by in zip(new, robots, strict=True) if by == robot]
        if rings := _rings(shapely.union_all(own, grid_size=grid_m)):
            areas[robot] = rings
    return areas


def _earlier_neighbours(shapes: Shapes) -> list[tuple[int, list[int]]]:
    later, earlier = shapely.STRtree(shapes).query(shapes)
    pairs = sorted((a, b) for a, b in zip(later.tolist(), earlier.tolist(), strict=True) if b < a)
    found = {index: [b for _, b in group] for index, group in groupby(pairs, lambda pair: pair[0])}
    return [(index, found.get(index, [])) for index in range(len(shapes))]


def _without_earlier(shapes: Shapes, index: int, earlier: list[int]) -> BaseGeometry:
    shape: BaseGeometry = shapes[index]
    return shape.difference(shapely.union_all(shapes[earlier])) if earlier else shape


def _rings(area: BaseGeometry) -> list[FloatArray]:
    parts = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon"]
    return [
        shapely.get_coordinates(ring)
        for part in parts
        for ring in (part.exterior, *part.interiors)
        if len(ring.coords)
    ]
