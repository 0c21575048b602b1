"""The areas of a map by the robot that saw them first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics.kernel import FloatArray


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
    seen = [
        _Seen({robot: _areal(shape)}, _areal(shape))
        for robot, shape in zip(robots, shapes, strict=True)
    ]
    whole = _in_sequence(seen, grid_m) if seen else _Seen({}, shapely.Polygon())
    rings = {robot: _rings(area) for robot, area in sorted(whole.first.items())}
    return {robot: of_robot for robot, of_robot in rings.items() if of_robot}


class _Seen(NamedTuple):
    """What was seen in a time: by each robot first, and in all."""

    first: dict[int, BaseGeometry]
    by_all: BaseGeometry


def _in_sequence(times: list[_Seen], grid_m: float) -> _Seen:
    # By halves, as shapes of few outlines are united and subtracted faster than many shapes.
    if len(times) == 1:
        return times[0]
    middle = len(times) // 2
    early, late = _in_sequence(times[:middle], grid_m), _in_sequence(times[middle:], grid_m)
    first = dict(early.first)
    for robot, area in late.first.items():
        new = _areal(shapely.difference(area, early.by_all, grid_size=grid_m))
        first[robot] = _united(first[robot], new, grid_m) if robot in first else new
    return _Seen(first, _united(early.by_all, late.by_all, grid_m))


def _united(one: BaseGeometry, other: BaseGeometry, grid_m: float) -> BaseGeometry:
    return _areal(shapely.union(one, other, grid_size=grid_m))


def _areal(shape: BaseGeometry) -> BaseGeometry:
    # Without the points and lines at which shapes touch.
    if shape.geom_type in ("Polygon", "MultiPolygon"):
        return shape
    return shapely.MultiPolygon([p for p in shapely.get_parts(shape) if p.geom_type == "Polygon"])


def _rings(area: BaseGeometry) -> list[FloatArray]:
    return [
        shapely.get_coordinates(ring)
        for part in shapely.get_parts(area)
        for ring in (part.exterior, *part.interiors)
        if len(ring.coords)
    ]
