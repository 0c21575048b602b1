"""Solids for FCL: obstacles that stand on the floor, and bodies that move over it.

Obstacles are prisms that stand on the floor z = 0; bodies reach through the floor, from below
it to above the obstacles.
"""

from collections.abc import Sequence

import fcl
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray

OBSTACLE_HEIGHT_M = 0.5
"""Height of obstacles above the floor."""

BODY_REACH_M = 1.0
"""Height of bodies above the floor and depth below it, larger than the obstacles' height."""

TILE_M = 8.0
"""Maximum width of the tiles into which obstacles are cut.

A triangle that reaches across a whole world would be met by every query.
"""

MAX_TILES = 32
"""Maximum number of tiles along a side of the world; in large worlds tiles are wider."""

MIN_TRIANGLE_HEIGHT_M = 1e-9
"""Triangles thinner than this are dropped: they have no reliable normal."""


def convex_prism(outline: FloatArray) -> fcl.Convex:
    """Return a solid over a convex outline, through the floor.

    Parameters
    ----------
    outline : (n, 2) array
        Corners in metres, counter-clockwise.
    """
    n = len(outline)
    vertices = np.empty((2 * n, 3))
    vertices[:n, :2] = vertices[n:, :2] = outline
    vertices[:n, 2], vertices[n:, 2] = -BODY_REACH_M, BODY_REACH_M
    # Faces as FCL lists them: number of corners, then the corners, seen from outside.
    faces = [n, *range(n - 1, -1, -1), n, *range(n, 2 * n)]
    for i in range(n):
        j = (i + 1) % n
        faces += [4, i, j, n + j, n + i]
    return fcl.Convex(vertices, n + 2, faces)


def tiles_of(polygon: Polygon, width: float) -> list[Polygon]:
    """Return a polygon cut into parts that are not wider or higher than a tile, in metres.

    Examples
    --------
    >>> [tile.bounds for tile in tiles_of(shapely.box(0, 0, 4, 2), 2.0)]
    [(0.0, 0.0, 2.0, 2.0), (2.0, 0.0, 4.0, 2.0)]
    """
    x0, y0, x1, y1 = polygon.bounds
    if max(x1 - x0, y1 - y0) <= width:
        return [polygon]
    if x1 - x0 >= y1 - y0:
        middle = (x0 + x1) / 2.0
        halves = shapely.box(x0, y0, middle, y1), shapely.box(middle, y0, x1, y1)
    else:
        middle = (y0 + y1) / 2.0
        halves = shapely.box(x0, y0, x1, middle), shapely.box(x0, middle, x1, y1)
    parts = [part for half in halves for part in polygons_of(polygon.intersection(half))]
    return [tile for part in parts for tile in tiles_of(part, width)]


def standing_prisms(polygons: Sequence[Polygon], name: str) -> fcl.BVHModel:
    """Return one mesh of closed prisms that stand on the floor over polygons.

    Parameters
    ----------
    polygons : sequence of Polygon
        The polygons, with holes or without, in metres.
    name : str
        What they are, for an error message.

    Raises
    ------
    InvalidInputError
        If triangulation fails to cover the polygons.
    """
    from trimesh.creation import extrude_polygon  # half a second to import

    solids = [extrude_polygon(part, OBSTACLE_HEIGHT_M, engine="earcut") for part in polygons]
    vertices = np.vstack([np.asarray(solid.vertices) for solid in solids])
    first = np.cumsum([0, *(len(solid.vertices) for solid in solids[:-1])])
    triangles = np.vstack(
        [np.asarray(solid.faces) + n for solid, n in zip(solids, first, strict=True)]
    )
    triangles = triangles[~_is_thin(vertices[triangles])]
    _require_whole(vertices[triangles], sum(part.area for part in polygons), name)
    # A model that is empty or not ended crashes at the first query.
    model = fcl.BVHModel()
    model.beginModel(len(triangles), len(vertices))
    model.addSubModel(vertices, triangles)
    model.endModel()
    return model


def _is_thin(triangles: FloatArray) -> NDArray[np.bool_]:
    """Whether each of ``(n, 3, 3)`` triangles is thinner than `MIN_TRIANGLE_HEIGHT_M`."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return np.asarray(area <= MIN_TRIANGLE_HEIGHT_M * longest)


def _require_whole(triangles: FloatArray, area: float, name: str) -> None:
    """Raise an `InvalidInputError` unless the triangles on the floor cover an area."""
    on_floor = triangles[(triangles[:, :, 2] == 0.0).all(axis=1)]
    sides = np.roll(on_floor, -1, axis=1) - on_floor
    covered = 0.5 * float(np.abs(np.cross(sides[:, 0], sides[:, 1])[:, 2]).sum())
    if not abs(covered - area) <= 1e-6 * area:
        raise InvalidInputError(
            f"{name}: obstacles of {area:g} m2 were cut into triangles of {covered:g} m2; "
            "a polygon that nearly touches itself can do that: simplify its outline"
        )


def polygons_of(geometry: BaseGeometry) -> list[Polygon]:
    """Return the polygons of a geometry, without its points and lines."""
    return [part for part in shapely.get_parts(geometry) if isinstance(part, Polygon)]
