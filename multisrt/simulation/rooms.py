"""Whether a body fits at a start, and where it would fit near by."""

from __future__ import annotations

import shapely
from shapely import Point

from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError

MARGIN_M = 0.01
"""Clearance beyond the radius of a body at a place that is suggested to users, in metres.

It is more than rounding to centimetres moves the place.
"""

MARGIN_SHARE = 0.02
"""Additional margin as a share of the radius, where arcs of the eroded area are not exact enough.

GEOS simplifies boundaries by up to a hundredth of the distance before it moves them.
"""

ARC_SEGMENTS = 32
"""Segments of a quarter of a circle in the boundary of the places at which a body fits."""


def body_fits(environment: Environment, footprint: Footprint, start: Configuration) -> bool:
    """Return whether a body at a start is in the interior of free space.

    Parameters
    ----------
    environment : Environment
        The world.
    footprint : Footprint
        The body.
    start : Configuration
        Position and heading of the body, in metres and radians.

    Examples
    --------
    >>> hall = Environment("hall", shapely.box(0, 0, 8, 5))
    >>> body_fits(hall, Footprint.disc(0.25), Configuration(0.3, 2.0))
    True
    """
    if footprint.is_disc:
        return environment.clearance(start.x, start.y) > footprint.radius_m
    return environment.contains(start.x, start.y) and bool(
        shapely.contains_properly(environment.free, footprint.placed(start))
    )


def misfit(environment: Environment, footprint: Footprint, start: Configuration) -> ClearanceError:
    """Return the error that a body does not fit at a start, with the nearest place where it does.

    Parameters
    ----------
    environment, footprint, start
        As for `body_fits`.

    Examples
    --------
    >>> hall = Environment("hall", shapely.box(0, 0, 8, 5))
    >>> print(misfit(hall, Footprint.disc(0.25), Configuration(-1.0, 2.0)))
    the start (-1, 2) is not in the free space of 'hall': it is in an obstacle or outside the \
outline, 1 m from free space; the nearest place where the body disc:0.25 fits is (0.26, 2), 1.26 m \
from there
    """
    x, y = start.x, start.y
    instead = _elsewhere(environment, footprint, start)
    try:
        environment.component(x, y)
    except ClearanceError as error:
        return ClearanceError(f"the start {error}; {instead}", error.clearance_m)
    clearance = environment.clearance(x, y)
    return ClearanceError(
        f"the body {footprint} does not fit at the start ({x:g}, {y:g}) of "
        f"{environment.name!r}: the clearance there is {clearance:.6g} m, and it needs "
        f"{needed_clearance(footprint)}; {instead}",
        clearance,
    )


def needed_clearance(footprint: Footprint) -> str:
    """Return the clearance that a body needs at a start as text.

    Examples
    --------
    >>> needed_clearance(Footprint.disc(0.25)), needed_clearance(Footprint.parse("box:0.6x0.4"))
    ('more than 0.25 m', '0.2 to 0.361 m, by its heading')
    """
    if footprint.is_disc:
        return f"more than {footprint.radius_m:g} m"
    return (
        f"{footprint.inscribed_radius_m:.3g} to {footprint.circumscribed_radius_m:.3g} m, "
        "by its heading"
    )


def nearest_room(
    environment: Environment, footprint: Footprint, x: float, y: float
) -> tuple[float, float] | None:
    """Return the place nearest to a point at which a body fits in any heading.

    Parameters
    ----------
    environment : Environment
        The world.
    footprint : Footprint
        The body.
    x, y : float
        The point, in metres; it need not be in free space.

    Returns
    -------
    (x, y) or None
        The place in whole centimetres, in metres; None if the body fits nowhere with a margin of
        `MARGIN_M`.

    Examples
    --------
    >>> hall = Environment("hall", shapely.box(0, 0, 8, 5))
    >>> nearest_room(hall, Footprint.disc(0.25), 9.0, 2.0)
    (7.74, 2.0)
    >>> nearest_room(hall, Footprint.disc(3.0), 9.0, 2.0) is None
    True
    """
    radius = footprint.circumscribed_radius_m
    # Distances of points beyond all worlds may overflow.
    x, y = (min(max(value, -MAX_COORDINATE_M), MAX_COORDINATE_M) for value in (x, y))
    for margin in (MARGIN_M, MARGIN_M + MARGIN_SHARE * radius):
        room = environment.free.buffer(-(radius + margin), quad_segs=ARC_SEGMENTS)
        if room.is_empty:
            break
        found = shapely.get_coordinates(shapely.shortest_line(room, Point(x, y)))[0]
        place = round(float(found[0]), 2), round(float(found[1]), 2)
        if environment.clearance(*place) > radius:
            return place
    return None


def _elsewhere(environment: Environment, footprint: Footprint, start: Configuration) -> str:
    place = nearest_room(environment, footprint, start.x, start.y)
    if place is None:
        return f"the body {footprint} has room in every heading nowhere: choose a smaller body"
    heading = "" if footprint.is_disc else " in every heading"
    away = start.distance(Configuration(*place))
    return (
        f"the nearest place where the body {footprint} fits{heading} is ({_metres(place[0])}, "
        f"{_metres(place[1])}), {away:.3g} m from there"
    )


def _metres(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".")
