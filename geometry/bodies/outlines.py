"""Simple outlines of polygons around a reference point: checks, convexity, partition."""

from __future__ import annotations

from typing import Final

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely import Polygon

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray

MIN_INSCRIBED_RADIUS_M: Final = 1e-6
"""Minimum distance from the reference point of a body to its outline, in metres."""

MAX_SIZE_M: Final = 1e6
"""Maximum coordinate of a corner, and maximum length of a body, in metres."""


def checked_outline(vertices: ArrayLike) -> FloatArray:
    """Return the corners of a simple outline around the reference point, in standard order.

    Parameters
    ----------
    vertices : (n, 2) array_like
        Corners in order, in either direction, in metres; some may be repeated.

    Returns
    -------
    (m, 2) array
        Counter-clockwise from the first, without repetitions.

    Raises
    ------
    InvalidInputError
        If the corners are not pairs of finite numbers, fewer than three or too far away, if the
        outline is not simple, or the origin is not inside.
    """
    try:
        corners = np.array(vertices, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInputError("a polygon's corners are pairs of numbers of metres") from None
    if corners.ndim != 2 or corners.shape[1] != 2:
        raise InvalidInputError(
            f"a polygon's corners have shape (n, 2), not {corners.shape}: give x and y of each"
        )
    bad = np.flatnonzero(~(np.abs(corners) <= MAX_SIZE_M).all(axis=1))
    if bad.size:
        x, y = corners[bad[0]]
        raise InvalidInputError(
            f"corner {bad[0]} of a polygon is ({x:g}, {y:g}); corners are finite and within "
            f"{MAX_SIZE_M:g} m"
        )
    corners += 0.0  # -0.0 and 0.0 are the same place and must have the same text
    repeated = (corners == np.roll(corners, 1, axis=0)).all(axis=1)
    corners = np.ascontiguousarray(corners[~repeated] if not repeated.all() else corners[:1])
    if len(corners) > 1 and repeated[0]:
        # The first corner was repeated at the end; the outline still begins with it.
        corners = np.roll(corners, 1, axis=0)
    if len(corners) < 3:
        raise InvalidInputError(
            f"a polygon has at least three different corners; this one has {len(corners)}"
        )
    shape = Polygon(corners)
    if not shape.is_valid:
        raise InvalidInputError(
            f"a polygon's outline is not simple: {shapely.is_valid_reason(shape)}; list the "
            "corners in order, so that it neither crosses nor touches itself"
        )
    if not shape.exterior.is_ccw:
        corners = np.roll(corners[::-1], 1, axis=0)
    gap = distance_to_outline(corners)
    if not shapely.contains_xy(shape, 0.0, 0.0) or gap < MIN_INSCRIBED_RADIUS_M:
        where = "outside" if not shapely.intersects_xy(shape, 0.0, 0.0) else "at the edge of"
        raise InvalidInputError(
            f"the reference point (0, 0) is {where} the polygon, {gap:g} m from its outline; "
            "it has to be inside: give the corners about a point of the body"
        )
    return corners


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products of ``(..., 2)`` vectors."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def distance_to_outline(vertices: FloatArray) -> float:
    """Return the distance from the origin to an outline, ``(n, 2)``, in metres."""
    return float(shapely.distance(Polygon(vertices).exterior, shapely.Point(0.0, 0.0)))


def convex_hull(vertices: FloatArray) -> FloatArray:
    """Return the corners of the convex hull of ``(n, 2)`` points, counter-clockwise."""
    hull = shapely.orient_polygons(shapely.convex_hull(shapely.multipoints(vertices)))
    return np.ascontiguousarray(shapely.get_coordinates(hull)[:-1])


def is_convex(corners: FloatArray) -> bool:
    """Whether a simple counter-clockwise outline turns left, or goes straight on, everywhere."""
    ahead = np.roll(corners, -1, axis=0) - corners
    behind = corners - np.roll(corners, 1, axis=0)
    slack = 1e-12 * np.hypot(*ahead.T) * np.hypot(*behind.T)
    return bool((cross(behind, ahead) >= -slack).all())


def convex_partition(vertices: FloatArray) -> list[list[int]]:
    """Cut a polygon into convex pieces.

    Parameters
    ----------
    vertices : (n, 2) array
        Corners of a simple outline, counter-clockwise.

    Returns
    -------
    list of list of int
        Indices of the corners of each piece, counter-clockwise. There are at most four times as
        many pieces as in the smallest partition.

    Notes
    -----
    The polygon is triangulated, and every diagonal that convexity does not need is removed.

    Source: S. Hertel and K. Mehlhorn, Fast triangulation of simple polygons, Foundations of
    Computation Theory (1983); differs in: a constrained Delaunay triangulation.
    """
    number = {(x, y): i for i, (x, y) in enumerate(vertices.tolist())}
    triangles = shapely.constrained_delaunay_triangles(Polygon(vertices))
    pieces = [
        [number[x, y] for x, y in shapely.get_coordinates(triangle)[:-1].tolist()]
        for triangle in shapely.get_parts(shapely.orient_polygons(triangles))
    ]
    sides = {(a, b) for piece in pieces for a, b in _sides(piece)}
    for a, b in sorted(side for side in sides if side[0] < side[1] and side[::-1] in sides):
        left = next(piece for piece in pieces if (a, b) in _sides(piece))
        right = next(piece for piece in pieces if (b, a) in _sides(piece))
        merged = _from(left, b) + _from(right, a)[1:-1]
        if is_convex(vertices[merged]):
            pieces = [piece for piece in pieces if piece is not left and piece is not right]
            pieces.append(merged)
    return pieces


def _sides(piece: list[int]) -> list[tuple[int, int]]:
    return list(zip(piece, piece[1:] + piece[:1], strict=True))


def _from(piece: list[int], first: int) -> list[int]:
    at = piece.index(first)
    return piece[at:] + piece[:at]


def sweep_convex(polygon: FloatArray, step: FloatArray) -> FloatArray:
    """Return the outline that a convex polygon sweeps when it is moved.

    Edges that face the motion are moved, the others are not; two edges as long as the step join
    them.

    Parameters
    ----------
    polygon : (n, 2) array
        Corners in metres, counter-clockwise.
    step : (2,) array
        Displacement x, y in metres.

    Returns
    -------
    (m, 2) array
        Corners of a convex polygon, counter-clockwise.

    Examples
    --------
    >>> square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    >>> sweep_convex(square, np.array([2.0, 0.0])).tolist()
    [[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [0.0, 1.0]]
    """
    edges = np.roll(polygon, -1, axis=0) - polygon
    ahead = step[0] * edges[:, 1] - step[1] * edges[:, 0] > 0.0
    outline = []
    for vertex, here, before in zip(polygon, ahead, np.roll(ahead, 1), strict=True):
        if here != before:
            outline.append(vertex + step if before else vertex)
        outline.append(vertex + step if here else vertex)
    return np.array(outline)
