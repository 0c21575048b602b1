"""Areas of drawn rings and lines, at a cost that is bounded before they are computed."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import SLIVER_WIDTH_M
from multisrt.geometry.errors import MapFormatError
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel

MAX_POINTS: Final = 200_000
"""Upper bound of the points of a drawing, with its curves as polylines."""

MAX_CANDIDATES: Final = 4_000_000_000
"""Upper bound of the pairs of edges that are compared."""

MAX_CROSSINGS: Final = 500_000
"""Upper bound of the pairs of edges that touch, but for those with a common end."""

MAX_WINDINGS: Final = 2_000_000_000
"""Upper bound of the product of faces and edges of one shape."""

PIECE_POINTS: Final = 100
"""Number of points of the pieces in which long lines are stroked."""

FillRule = Literal["nonzero", "evenodd"]

GeometryArray = NDArray[np.object_]


class Pen(NamedTuple):
    """Caps and joins of a stroke, as `shapely.buffer` names them."""

    cap_style: Literal["flat", "round", "square"]
    join_style: Literal["mitre", "round", "bevel"]
    mitre_limit: float = 5.0
    quad_segs: int = 8


def require_few_crossings(
    path: Path, geometries: Sequence[BaseGeometry], sides: Sequence[FloatArray] = ()
) -> None:
    """Reject drawings whose edges cross so often that overlays of them have no bound.

    Parameters
    ----------
    path : Path
        The file, for messages.
    geometries : sequence of geometries
        Lines and polygons that are to be overlaid.
    sides : sequence of float arrays, shape (n, 2, 2)
        Further edges, as `sides_of_stroke` returns them.

    Raises
    ------
    MapFormatError
        If there are more than `MAX_POINTS` points, or more than `MAX_CROSSINGS` pairs of edges
        touch.
    """
    edges = np.concatenate([_edges(path, geometries), *sides]).reshape(-1, 4)
    low, high = np.minimum(edges[:, :2], edges[:, 2:]), np.maximum(edges[:, :2], edges[:, 2:])
    extent = high.max(axis=0, initial=-np.inf) - low.min(axis=0, initial=np.inf)
    # Along the axis of which edges cover less, fewer pairs overlap.
    cover = (high - low).mean(axis=0) / np.maximum(extent, 1e-9) if len(edges) else extent
    if cover[1] < cover[0]:
        edges = edges[:, [1, 0, 3, 2]]
    order = np.argsort(np.minimum(edges[:, 0], edges[:, 2]), kind="stable")
    if _cross_too_often(edges[order], MAX_CANDIDATES, MAX_CROSSINGS):
        raise MapFormatError(
            f"{path}: lines of the drawing cross too often; "
            "leave out hatchings and patterns, and simplify it"
        )


def opened(walls: BaseGeometry, openings: BaseGeometry) -> BaseGeometry:
    """Return walls without the openings in them.

    Openings that end where a wall does leave no film of it, whose thickness would be that of the
    rounding of coordinates: they are taken half a millimetre larger.

    Parameters
    ----------
    walls, openings : Polygon or MultiPolygon
        Areas in metres.

    Examples
    --------
    >>> wall, door = shapely.box(0, 0, 4, 1), shapely.box(1, 1e-9, 2, 1)
    >>> len(opened(wall, door).geoms)
    2
    """
    if openings.is_empty:
        return walls
    return walls - shapely.buffer(openings, SLIVER_WIDTH_M / 2, join_style="mitre")


def sides_of_stroke(points: FloatArray, radius: float) -> FloatArray:
    """Return the edges of a stroke, without its joins, as ``(2 n, 2, 2)`` points.

    Parameters
    ----------
    points : float array, shape (n + 1, 2)
        The line.
    radius : float
        Half its width.

    Examples
    --------
    >>> import numpy as np
    >>> sides_of_stroke(np.array([[0.0, 0.0], [4.0, 0.0]]), 1.0).tolist()
    [[[0.0, 1.0], [4.0, 1.0]], [[0.0, -1.0], [4.0, -1.0]]]
    """
    along = np.diff(points, axis=0)
    lengths = np.hypot(*along.T)
    moved = lengths > 0
    unit = along[moved] / lengths[moved, np.newaxis]
    across = radius * np.column_stack([-unit[:, 1], unit[:, 0]])[:, np.newaxis]
    edges = np.stack([points[:-1][moved], points[1:][moved]], axis=1)
    return np.concatenate([edges + across, edges - across])


def stroked(points: FloatArray, closed: bool, radius: float, pen: Pen) -> BaseGeometry:
    """Return the area of a stroke along a line.

    Parameters
    ----------
    points : float array, shape (n, 2)
        The line; the same point again and again is a dot.
    closed : bool
        Whether the last point is joined to the first.
    radius : float
        Half the width of the stroke.
    pen : Pen
        Its caps and joins.

    Examples
    --------
    >>> import numpy as np
    >>> corner = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]])
    >>> stroked(corner, False, 0.5, Pen("flat", "mitre")).area
    7.0
    """
    style = pen._asdict()
    if len(points) <= PIECE_POINTS:
        line: BaseGeometry
        if closed and len(points) >= 3:
            line = shapely.LinearRing(points)
        else:
            line = shapely.LineString(points if len(points) > 1 else np.vstack([points, points]))
        return shapely.buffer(line, radius, **style)
    # The buffer of a long line takes quadratic time. Pieces have a segment in common, so that
    # each join is within one of them, and end bluntly; the caps are added.
    line_points = np.vstack([points, points[:2]]) if closed else points
    pieces = [
        shapely.LineString(line_points[first : first + PIECE_POINTS])
        for first in range(0, len(line_points) - 2, PIECE_POINTS - 2)
    ]
    areas = list(
        shapely.buffer(np.array(pieces, np.object_), radius, **style | {"cap_style": "flat"})
    )
    if not closed and pen.cap_style != "flat":
        areas += [_cap(points, radius, pen), _cap(points[::-1], radius, pen)]
    return shapely.union_all(np.array(areas, np.object_))


def _cap(points: FloatArray, radius: float, pen: Pen) -> BaseGeometry:
    """Return the cap at the start of a line."""
    start = points[0]
    apart = np.flatnonzero((points != start).any(axis=1))
    if pen.cap_style == "round" or not apart.size:
        return shapely.buffer(shapely.Point(start), radius, quad_segs=pen.quad_segs)
    back = start - points[apart[0]]
    end = start + radius * back / np.hypot(*back)
    return shapely.buffer(shapely.LineString([start, end]), radius, cap_style="flat")


def _edges(path: Path, geometries: Sequence[BaseGeometry]) -> FloatArray:
    """Return the edges of geometries as ``(n, 2, 2)`` points."""
    rings = shapely.get_parts(shapely.get_parts(np.asarray(geometries, np.object_)))
    polygons = shapely.get_type_id(rings) == shapely.GeometryType.POLYGON
    lines = np.concatenate([rings[~polygons], shapely.get_rings(rings[polygons])])
    points, owner = shapely.get_coordinates(lines, return_index=True)
    if len(points) > MAX_POINTS:
        raise MapFormatError(
            f"{path} has {len(points):,} points, with curves as polylines; drawings are read up "
            f"to {MAX_POINTS:,}, so simplify it"
        )
    inner = owner[1:] == owner[:-1]
    return np.stack([points[:-1][inner], points[1:][inner]], axis=1)


def filled(path: Path, rings: Sequence[FloatArray], rule: FillRule) -> BaseGeometry:
    """Return the area of closed rings, which may cross themselves and each other.

    Parameters
    ----------
    path : Path
        The file, for messages.
    rings : sequence of float arrays, shape (n, 2)
        Points of each ring; the last is joined to the first.
    rule : {"nonzero", "evenodd"}
        Which points are inside: those that the rings wind around, or those around which they wind
        an odd number of times.

    Returns
    -------
    Polygon or MultiPolygon
        Valid, and empty if the rings have no area.

    Raises
    ------
    MapFormatError
        If the rings cross too often.

    Examples
    --------
    >>> import numpy as np
    >>> from pathlib import Path
    >>> big = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], float)
    >>> small = big / 2 + 1
    >>> [filled(Path("plan.svg"), [big, small], rule).area for rule in ("nonzero", "evenodd")]
    [16.0, 12.0]
    """
    solid = [ring for ring in rings if len(ring) >= 3]
    if not solid:
        return Polygon()
    if len(solid) == 1:
        simple = Polygon(solid[0])
        if simple.is_valid:
            return simple
    loops = [shapely.LineString(np.vstack([ring, ring[:1]])) for ring in solid]
    require_few_crossings(path, loops)
    noded = shapely.union_all(np.asarray(loops, np.object_))
    faces: GeometryArray = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    if not faces.size:
        return Polygon()
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    edges = _edges(path, loops)
    if len(inside) * len(edges) > MAX_WINDINGS:
        raise MapFormatError(
            f"{path}: a shape with {len(edges):,} edges has {len(inside):,} parts; split it"
        )
    turns = _windings(inside, np.ascontiguousarray(edges.reshape(-1, 4)))
    chosen = faces[turns % 2 == 1 if rule == "evenodd" else turns != 0]
    return shapely.union_all(chosen) if chosen.size else Polygon()


@kernel
def _cross_too_often(edges: FloatArray, max_candidates: int, max_crossings: int) -> bool:
    """Return whether more pairs of edges touch, or have to be compared, than is allowed.

    The edges x0, y0, x1, y1 are in the order of their smaller x.
    """
    candidates = crossings = 0
    for i in range(len(edges)):
        ax, ay, bx, by = edges[i]
        right, low, high = max(ax, bx), min(ay, by), max(ay, by)
        for j in range(i + 1, len(edges)):
            cx, cy, dx, dy = edges[j]
            if min(cx, dx) > right:
                break
            candidates += 1
            if max(cy, dy) < low or min(cy, dy) > high:
                continue
            c = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
            d = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
            a = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
            b = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
            if (c > 0.0 and d > 0.0) or (c < 0.0 and d < 0.0):
                continue
            if (a > 0.0 and b > 0.0) or (a < 0.0 and b < 0.0):
                continue
            if (
                (ax == cx and ay == cy)
                or (ax == dx and ay == dy)
                or (bx == cx and by == cy)
                or (bx == dx and by == dy)
            ):
                continue
            crossings += 1
        if candidates > max_candidates or crossings > max_crossings:
            return True
    return False


@kernel
def _windings(points: FloatArray, edges: FloatArray) -> IntArray:
    """Return how often the edges x0, y0, x1, y1 of closed rings wind around each point."""
    turns = np.zeros(len(points), np.int64)
    for i in range(len(points)):
        x, y = points[i]
        for x0, y0, x1, y1 in edges:
            if (y0 <= y) != (y1 <= y):
                cross = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
                if y0 <= y and cross > 0.0:
                    turns[i] += 1
                elif y1 <= y and cross < 0.0:
                    turns[i] -= 1
    return turns
