"""The separate parts of a world: its connected components of free space."""

from __future__ import annotations

from typing import NamedTuple

import shapely
from shapely import Polygon

from multisrt.environments.environment import Environment

MIN_INSIDE = 0.5
"""Minimum area inside, as a share of the area around it.

Closed rooms and hollow walls have less inside.
"""


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


def pieces(environment: Environment) -> tuple[Polygon, ...]:
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
    >>> [piece.area for piece in pieces(Environment("two rooms", two))]
    [6.0, 4.0]
    """
    return tuple(sorted(environment.components, key=lambda piece: -piece.area))


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
        Of several such parts, the one with the largest area inside.

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
    border = environment.bounds
    found = []
    for piece in environment.components:
        if piece.interiors and any(a == b for a, b in zip(piece.bounds, border, strict=True)):
            outline = Polygon(piece.exterior)
            shapely.prepare(outline)
            inside = [p for p in pieces(environment) if p is not piece and outline.contains(p)]
            if sum(p.area for p in inside) >= MIN_INSIDE * piece.area:
                found.append(Enclosing(piece, tuple(inside)))
    return max(found, key=lambda one: sum(p.area for p in one.inside), default=None)


def is_minor(environment: Environment, x: float, y: float) -> bool:
    """Return whether a place is outside the largest part that is not around a building.

    Parameters
    ----------
    environment : Environment
        The world.
    x, y : float
        The place, in metres.

    Returns
    -------
    bool
        True in the part around a building, whatever its size.

    Raises
    ------
    ClearanceError
        If the place is not in free space.

    Examples
    --------
    >>> import shapely
    >>> two = shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 6, 2)])
    >>> rooms = Environment("two rooms", two)
    >>> is_minor(rooms, 1.0, 1.0), is_minor(rooms, 4.0, 1.0)
    (True, False)
    """
    here, outside = environment.component(x, y), enclosing(environment)
    if outside is not None and here is outside.area:
        return True
    return here.area < max(
        p.area for p in pieces(environment) if not (outside and p is outside.area)
    )
