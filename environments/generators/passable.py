"""The guarantee of every generator: free space is one piece that a robot can pass and see.

Closing the cracks is a morphological opening of free space with mitred corners, so that square
rooms stay square: what no disc of 0.7 m fits into becomes solid.
"""

from collections.abc import Sequence

import shapely
from shapely import Point, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import nearest_points

CRACK_M = 0.7
"""Gaps narrower than this are closed: things either touch or leave room between them."""

BODY_SHARE = 0.9
"""A body of this share of a passage's width gets everywhere."""

GRID_M = 1e-3
"""Coordinates are whole millimetres, so that rounding noise draws no edges."""

SPECK_M2 = 0.02
"""What erosion leaves in a corner and is smaller than this is no pocket."""


def passable(free: BaseGeometry, passage_m: float) -> Polygon:
    """Close cracks in free space and fill in what cannot be reached.

    Parameters
    ----------
    free : Polygon or MultiPolygon
        Free space as drawn, in metres.
    passage_m : float
        Width of the narrowest door or passage meant to be passed, at least 0.8 m.

    Returns
    -------
    Polygon
        The largest part of `free` in which a disc of diameter ``0.9 * passage_m`` gets
        everywhere, except into niches too small for it.
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
    """Move wanted starts to the nearest places with room for a robot.

    Parameters
    ----------
    free : Polygon
        Free space in metres.
    wanted : sequence of (x, y)
        Where starts would be best.
    clearance_m : float
        Distance that they keep from obstacles; less if no place has as much.

    Returns
    -------
    tuple of (x, y)
        In the order of `wanted`, without repetitions.
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
    """Parts of free space that hold a place for the body which it cannot get to."""
    places = shapely.get_parts(free.buffer(-body_radius_m))
    areas = shapely.area(places)
    main = int(areas.argmax())
    roomy = areas > SPECK_M2
    roomy[main] = False
    cut_off = places[roomy]
    if not cut_off.size:
        return []
    reached = places[main].buffer(body_radius_m)
    beyond = shapely.get_parts(shapely.difference(free, reached, grid_size=GRID_M))
    return [part for part in beyond if shapely.intersects(cut_off, part).any()]
