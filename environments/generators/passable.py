"""The guarantee of generators: free space is connected for a robot and has no cracks.

Cracks are closed by a morphological opening of free space: places where no disc of 0.7 m fits
become solid. Corners are mitred, so that square rooms stay square.
"""

from collections.abc import Sequence

import shapely
from shapely import Point, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import nearest_points

CRACK_M = 0.7
"""Gaps narrower than this are closed, in metres."""

BODY_SHARE = 0.9
"""Width of a body that can reach everything, as a share of the narrowest passage."""

GRID_M = 1e-3
"""Grid of the coordinates in metres; removes edges that are rounding errors."""

SPECK_M2 = 0.02
"""Area below which a remainder of the erosion does not count as a pocket, in square metres."""


def passable(free: BaseGeometry, passage_m: float) -> Polygon:
    """Return free space without cracks and without parts that a robot cannot reach.

    Parameters
    ----------
    free : Polygon or MultiPolygon
        Free space as drawn, in metres.
    passage_m : float
        Width of the narrowest door or passage that robots must pass, at least 0.8 m.

    Returns
    -------
    Polygon
        The largest part of `free` in which a disc of diameter ``0.9 * passage_m`` reaches
        everything except niches too small for it.
    """
    inset = CRACK_M / 2
    while True:
        opened = free.buffer(-inset, join_style="mitre").buffer(inset, join_style="mitre")
        drawn = _largest(shapely.set_precision(opened.simplify(GRID_M / 2), GRID_M))
        pockets = _pockets(drawn, BODY_SHARE * passage_m / 2)
        if not pockets:
            return drawn
        free = drawn.difference(shapely.union_all(pockets))


def starts_near(
    free: Polygon, wanted: Sequence[tuple[float, float]], clearance_m: float = 0.6
) -> tuple[tuple[float, float], ...]:
    """Return, for each wanted start, the nearest place with room for a robot.

    Parameters
    ----------
    free : Polygon
        Free space in metres.
    wanted : sequence of (x, y)
        Wanted starts in metres; they need not be free.
    clearance_m : float
        Distance to obstacles in metres; reduced if no place has as much.

    Returns
    -------
    tuple of (x, y)
        The starts in metres, in the order of `wanted`, without repetitions.
    """
    roomy = free.buffer(-clearance_m)
    while roomy.is_empty:
        clearance_m *= 0.8
        roomy = free.buffer(-clearance_m)
    nearest = (nearest_points(roomy, Point(place))[0] for place in wanted)
    return tuple(dict.fromkeys((round(place.x, 3), round(place.y, 3)) for place in nearest))


def _largest(free: BaseGeometry) -> Polygon:
    parts = [part for part in shapely.get_parts(free) if isinstance(part, Polygon)]
    return max(parts, key=lambda part: part.area)


def _pockets(free: Polygon, body_radius_m: float) -> list[Polygon]:
    """Return the parts of free space with room for the body that it cannot reach."""
    places = shapely.get_parts(free.buffer(-body_radius_m))
    areas = shapely.area(places)
    main = int(areas.argmax())
    roomy = areas > SPECK_M2
    roomy[main] = False
    cut_off = places[roomy]
    if not cut_off.size:
        return []
    reached = places[main].buffer(body_radius_m)
    if not reached.is_valid:  # buffers of GEOS rarely touch themselves where rings nearly meet
        reached = reached.buffer(0.0)
    beyond = shapely.get_parts(shapely.difference(free, reached, grid_size=GRID_M))
    return [part for part in beyond if shapely.intersects(cut_off, part).any()]
