"""The separate parts of a world: its connected components of free space."""

from __future__ import annotations

import math
from typing import NamedTuple

import shapely
from shapely import Polygon

from multisrt.environments.environment import Environment

MIN_INSIDE = 0.5
"""Minimum area inside, as a share of the area around it.

Closed rooms and hollow walls have less inside.
"""

MIN_BORDER_SHARE = 0.9
"""Minimum share of the border of the map along which a part lies that may be a page."""

MIN_ROOMS_M2 = 4.0
"""Area of the parts on such a page above which it is told, in square metres."""

ROOM_RADIUS_M = 0.25
"""Radius of the disc that fits into each of these parts, in metres: that of the default body."""

PLACE_PRECISION = 1e-4
"""Precision of the place with the most room, as a share of the length of the boundary."""


class Enclosing(NamedTuple):
    """A part that touches the border of the map and encloses much of free space.

    On a drawn floor plan it is the white paper around the building.

    Attributes
    ----------
    area : Polygon
        The part itself, in metres.
    inside : tuple of Polygon
        The parts that it encloses, the largest first.
    """

    area: Polygon
    inside: tuple[Polygon, ...]


def parts_of(environment: Environment) -> tuple[Polygon, ...]:
    """Return the components of free space, the largest first.

    Parameters
    ----------
    environment : Environment
        The world.

    Returns
    -------
    tuple of Polygon
        At least one; the objects that `Environment.component` returns.

    Examples
    --------
    >>> import shapely
    >>> two = shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 6, 2)])
    >>> [part.area for part in parts_of(Environment("two rooms", two))]
    [6.0, 4.0]
    """
    return tuple(sorted(environment.components, key=lambda part: -part.area))


def enclosing(environment: Environment) -> Enclosing | None:
    """Return the part around a building, or None if there is none.

    It touches the border of the map, and the parts that it encloses have at least `MIN_INSIDE` of
    its own area.

    Parameters
    ----------
    environment : Environment
        The world.

    Returns
    -------
    Enclosing or None
        Of several such parts, the one with the largest area inside. None if what is inside may be
        obstacles (`Environment.outlined_obstacles`).

    Examples
    --------
    Paper of 10 x 10 m around a building with a wall of 1 m:

    >>> import shapely
    >>> wall = shapely.box(1, 1, 9, 9) - shapely.box(2, 2, 8, 8)
    >>> plan = Environment.from_outline("plan", shapely.box(0, 0, 10, 10), [wall])
    >>> around = enclosing(plan)
    >>> around.area.area, [area.area for area in around.inside]
    (36.0, [36.0])
    """
    if environment.outlined_obstacles:
        return None
    border = environment.bounds
    found = []
    for part in environment.components:
        if part.interiors and any(a == b for a, b in zip(part.bounds, border, strict=True)):
            enclosed = _enclosed_by(part, environment)
            if sum(p.area for p in enclosed) >= MIN_INSIDE * part.area:
                found.append(Enclosing(part, enclosed))
    return max(found, key=lambda one: sum(p.area for p in one.inside), default=None)


def inside(environment: Environment) -> tuple[Polygon, ...]:
    """Return the components of free space but the part around a building, the largest first.

    The first is the main part of a world without suggested starts: the one that is explored, and
    checked.

    Parameters
    ----------
    environment : Environment
        The world.

    Returns
    -------
    tuple of Polygon
        All components if there is no such part (see `enclosing`); at least one.

    Examples
    --------
    Paper of 11 x 11 m around a building with a wall of 1 m:

    >>> import shapely
    >>> wall = shapely.box(1, 1, 9, 9) - shapely.box(2, 2, 8, 8)
    >>> plan = Environment.from_outline("plan", shapely.box(0, 0, 11, 11), [wall])
    >>> [part.area for part in parts_of(plan)], [part.area for part in inside(plan)]
    ([57.0, 36.0], [36.0])
    """
    outside = enclosing(environment)
    return tuple(p for p in parts_of(environment) if outside is None or p is not outside.area)


def surrounding(environment: Environment) -> Enclosing | None:
    """Return a part that may be a page around a building; it may also be a hall with rooms.

    It is the part of `enclosing`, or else one that lies along most of the border of the map
    (`MIN_BORDER_SHARE`) and around rooms of more than `MIN_ROOMS_M2` in total, however large the
    page is. Since a hall with closed rooms in it does so, too, this is for messages only.

    Parameters
    ----------
    environment : Environment
        The world.

    Returns
    -------
    Enclosing or None
        The part, with the rooms inside: parts in which a disc of `ROOM_RADIUS_M` fits.

    Examples
    --------
    A building of 36 m2 on a page of 900 m2:

    >>> import shapely
    >>> wall = shapely.box(1, 1, 9, 9) - shapely.box(2, 2, 8, 8)
    >>> plan = Environment.from_outline("plan", shapely.box(0, 0, 30, 30), [wall])
    >>> enclosing(plan) is None, [area.area for area in surrounding(plan).inside]
    (True, [36.0])
    """
    careful = enclosing(environment)
    if careful is not None or environment.outlined_obstacles:
        return careful
    border = shapely.box(*environment.bounds).exterior
    for part in environment.components:
        if not part.interiors:
            continue
        if border.intersection(part.exterior).length < MIN_BORDER_SHARE * border.length:
            continue
        rooms = [
            room
            for room in _enclosed_by(part, environment)
            if room.area > math.pi * ROOM_RADIUS_M**2 and not room.buffer(-ROOM_RADIUS_M).is_empty
        ]
        if sum(room.area for room in rooms) > MIN_ROOMS_M2:
            return Enclosing(part, tuple(rooms))
    return None


def _enclosed_by(part: Polygon, environment: Environment) -> tuple[Polygon, ...]:
    """Return the other components within the outer ring of a component, the largest first."""
    outline = Polygon(part.exterior)
    shapely.prepare(outline)
    return tuple(p for p in parts_of(environment) if p is not part and outline.contains(p))


def start_in(part: Polygon) -> str:
    """Return the place of a part with the most room, as the option ``--start`` takes it.

    Examples
    --------
    >>> import shapely
    >>> start_in(shapely.box(0, 0, 4, 4) | shapely.box(4, 0, 9, 1))
    '2.00,2.00'
    """
    circle = shapely.maximum_inscribed_circle(part, tolerance=PLACE_PRECISION * part.length)
    (x, y), *_ = circle.coords
    return f"{x:.2f},{y:.2f}"


def is_poor_start(environment: Environment, x: float, y: float) -> bool:
    """Return whether a robot that starts at a place may miss what is to be explored.

    That is outside the largest part that is not around a building, and in a part that may be a page
    around a building (`surrounding`).

    Parameters
    ----------
    environment : Environment
        The world.
    x, y : float
        The place, in metres.

    Returns
    -------
    bool
        True in a part that `surrounding` finds, whatever its size.

    Raises
    ------
    ClearanceError
        If the place is not in free space.

    Examples
    --------
    >>> import shapely
    >>> two = shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 6, 2)])
    >>> rooms = Environment("two rooms", two)
    >>> is_poor_start(rooms, 1.0, 1.0), is_poor_start(rooms, 4.0, 1.0)
    (True, False)
    """
    here, outside = environment.component(x, y), surrounding(environment)
    if outside is not None and outside.area is here:
        return True
    return here.area < inside(environment)[0].area
