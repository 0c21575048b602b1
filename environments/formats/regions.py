"""Areas of drawn rings and lines; the cost of overlays is bounded before they are computed."""

from __future__ import annotations

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

MAX_MAP_POINTS: Final = 5_000_000
"""Upper bound of the points of a map of several polygons."""

MAX_COMPARED: Final = 1_000_000_000
"""Upper bound of the pairs of edges that are compared, which takes about a second."""

MAX_NEAR: Final = 20_000_000
"""Upper bound of the pairs of edges whose bounding boxes meet.

Overlays test each of them, which takes about two seconds.
"""

MAX_CROSSINGS: Final = 100_000
"""Upper bound of the pairs of edges that touch in more than a common end.

Overlays with as many take two to seven seconds.
"""

MAX_OVERLAPS: Final = 1_000_000
"""Upper bound of the pairs of polygons whose bounding boxes meet."""

MAX_WINDINGS: Final = 300_000_000
"""Upper bound of the product of faces and edges of one shape."""

PIECE_POINTS: Final = 100
"""Number of points of the pieces into which long lines are cut for stroking."""

FillRule = Literal["nonzero", "evenodd"]

GeometryArray = NDArray[np.object_]


class Pen(NamedTuple):
    """Caps and joins of a stroke, as `shapely.buffer` names them."""

    cap_style: Literal["flat", "round", "square"]
    join_style: Literal["mitre", "round", "bevel"]
    mitre_limit: float = 5.0
    quad_segs: int = 8


class EdgePairs(NamedTuple):
    """Numbers of pairs of edges.

    Attributes
    ----------
    compared : int
        Those that are compared to find the others.
    near : int
        Those whose bounding boxes meet.
    crossing : int
        Those that touch in more than a common end.
    """

    compared: int
    near: int
    crossing: int

    def plus(self, more: EdgePairs) -> EdgePairs:
        """Return the sum of two counts."""
        return EdgePairs(*(a + b for a, b in zip(self, more, strict=True)))

    @property
    def are_too_many(self) -> bool:
        """Whether a number exceeds its bound in `MAX_PAIRS`."""
        return any(count > bound for count, bound in zip(self, MAX_PAIRS, strict=True))


MAX_PAIRS: Final = EdgePairs(MAX_COMPARED, MAX_NEAR, MAX_CROSSINGS)
"""Upper bounds of the numbers."""


def require_few_crossings(
    path: Path,
    geometries: Sequence[BaseGeometry],
    sides: Sequence[FloatArray] = (),
    *,
    max_points: int = MAX_POINTS,
) -> None:
    """Reject drawings whose edges cross so often that overlays would take too long.

    Parameters
    ----------
    path : Path
        The file, for messages.
    geometries : sequence of geometries
        Lines and polygons that are to be overlaid.
    sides : sequence of float arrays, shape (n, 2, 2)
        Further edges, as `sides_of_stroke` returns them.
    max_points : int
        Upper bound of the points.

    Raises
    ------
    MapFormatError
        If there are more points, or more pairs of edges than `MAX_PAIRS`.
    """
    edges = np.concatenate([_edges(path, geometries, max_points), *sides]).reshape(-1, 4)
    if count_pairs(edges).are_too_many:
        raise too_many_crossings(path)


def require_few_overlaps(path: Path, polygons: Sequence[BaseGeometry]) -> None:
    """Reject polygons of a map whose union, difference or repair would take too long.

    Parameters
    ----------
    path : Path
        The file, for messages.
    polygons : sequence of Polygon or MultiPolygon
        All polygons of the map, with finite coordinates. One that is valid is never rejected.

    Raises
    ------
    MapFormatError
        If there are more pairs of edges than `MAX_PAIRS`, or more than `MAX_OVERLAPS` pairs of
        polygons whose bounding boxes meet.
    """
    shapes = np.asarray(polygons, np.object_)
    if len(shapes) == 1 and shapes[0].is_valid:
        return
    boxes = shapely.bounds(shapes)
    if _overlap_too_often(boxes[np.argsort(boxes[:, 0])], MAX_COMPARED, MAX_OVERLAPS):
        raise MapFormatError(f"{path}: its polygons overlap too often; unite overlapping polygons")
    require_few_crossings(path, polygons, max_points=MAX_MAP_POINTS)


def too_many_crossings(path: Path) -> MapFormatError:
    """Return the error of a file whose edges cross too often."""
    return MapFormatError(
        f"{path}: its lines cross too often; leave out hatchings and patterns, and simplify it"
    )


def count_pairs(edges: FloatArray) -> EdgePairs:
    """Return the numbers of pairs of edges that an overlay has to treat.

    Counting stops soon after a bound of `MAX_PAIRS` is exceeded.

    Parameters
    ----------
    edges : float array, shape (n, 4)
        Their ends x0, y0, x1, y1.

    Examples
    --------
    >>> import numpy as np
    >>> count_pairs(np.array([[0.0, 0.0, 4.0, 4.0], [0.0, 4.0, 4.0, 0.0]])).crossing
    1
    """
    low, high = np.minimum(edges[:, :2], edges[:, 2:]), np.maximum(edges[:, :2], edges[:, 2:])
    extent = high.max(axis=0, initial=-np.inf) - low.min(axis=0, initial=np.inf)
    # Sort along the axis on which edges extend less: fewer pairs overlap there.
    cover = (high - low).mean(axis=0) / np.maximum(extent, 1e-9) if len(edges) else extent
    if cover[1] < cover[0]:
        edges = edges[:, [1, 0, 3, 2]]
    order = np.argsort(np.minimum(edges[:, 0], edges[:, 2]), kind="stable")
    return EdgePairs(*_count_pairs(edges[order], *MAX_PAIRS))


def union_of(areas: Sequence[BaseGeometry]) -> BaseGeometry:
    """Return the union of areas, group by group of those that meet.

    Of thousands of areas of which few meet, as the walls and obstacles of drawings, it takes a
    fraction of the time of `shapely.union_all`.

    Parameters
    ----------
    areas : sequence of Polygon or MultiPolygon
        Valid areas; some may be empty.

    Examples
    --------
    >>> union_of([shapely.box(0, 0, 2, 1), shapely.box(1, 0, 3, 1), shapely.box(5, 0, 6, 1)]).area
    4.0
    >>> union_of([]).is_empty
    True
    """
    shapes: GeometryArray = np.asarray(areas, np.object_)
    # Empty ones would become parts of the result.
    return shapely.disjoint_subset_union_all(shapes[~shapely.is_empty(shapes)])


def opened(walls: BaseGeometry, openings: BaseGeometry) -> BaseGeometry:
    """Return walls without the openings in them.

    Openings are dilated by half a millimetre, so that one that ends at the face of a wall leaves
    no film of wall as thin as the rounding of coordinates.

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
        The line; a line of equal points is a dot.
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
    # The buffer of a long line takes quadratic time. Consecutive pieces share a segment, so that
    # each join is within one of them, and have flat caps; the caps of the line are added.
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


def edges_of(geometries: Sequence[BaseGeometry]) -> FloatArray:
    """Return the edges of lines and polygons as ``(n, 4)`` ends x0, y0, x1, y1.

    Parameters
    ----------
    geometries : sequence of geometries
        Lines and polygons, single or in collections.

    Examples
    --------
    >>> edges_of([shapely.box(0, 0, 4, 3)])[0].tolist()
    [4.0, 0.0, 4.0, 3.0]
    """
    rings = shapely.get_parts(shapely.get_parts(np.asarray(geometries, np.object_)))
    polygons = shapely.get_type_id(rings) == shapely.GeometryType.POLYGON
    lines = np.concatenate([rings[~polygons], shapely.get_rings(rings[polygons])])
    points, owner = shapely.get_coordinates(lines, return_index=True)
    inner = owner[1:] == owner[:-1]
    return np.hstack([points[:-1][inner], points[1:][inner]])


def _edges(
    path: Path, geometries: Sequence[BaseGeometry], max_points: int = MAX_POINTS
) -> FloatArray:
    """Return the edges of geometries as ``(n, 2, 2)`` points."""
    count = int(shapely.get_num_coordinates(np.asarray(geometries, np.object_)).sum())
    if count > max_points:
        raise MapFormatError(
            f"{path} has {count:,} points, with curves as polylines; drawings are read up "
            f"to {max_points:,}, so simplify it"
        )
    return edges_of(geometries).reshape(-1, 2, 2)


def filled(path: Path, rings: Sequence[FloatArray], rule: FillRule) -> BaseGeometry:
    """Return the area of closed rings, which may cross themselves and each other.

    Parameters
    ----------
    path : Path
        The file, for messages.
    rings : sequence of float arrays, shape (n, 2)
        Points of each ring; the last is joined to the first.
    rule : {"nonzero", "evenodd"}
        Which points are inside: those with a winding number other than zero, or those with an odd
        one.

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
    faces, turns = wound_faces(path, solid)
    chosen = faces[turns % 2 == 1 if rule == "evenodd" else turns != 0]
    return shapely.union_all(chosen) if chosen.size else Polygon()


def wound_faces(path: Path, rings: Sequence[FloatArray]) -> tuple[GeometryArray, IntArray]:
    """Return the areas that closed rings bound, and how often they wind around each.

    Parameters
    ----------
    path, rings
        As for `filled`.

    Returns
    -------
    faces : array of Polygon
        The areas without the unbounded one.
    turns : int array
        The winding number of each.

    Raises
    ------
    MapFormatError
        If the rings cross too often.

    Examples
    --------
    >>> import numpy as np
    >>> from pathlib import Path
    >>> bow = np.array([[0, 0], [2, 2], [2, 0], [0, 2]], float)
    >>> sorted(wound_faces(Path("plan.svg"), [bow])[1].tolist())
    [-1, 1]
    """
    loops = [shapely.LineString(np.vstack([ring, ring[:1]])) for ring in rings]
    require_few_crossings(path, loops)
    noded = shapely.union_all(np.asarray(loops, np.object_))
    faces: GeometryArray = shapely.get_parts(shapely.polygonize(shapely.get_parts(noded)))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    edges = _edges(path, loops)
    if len(inside) * len(edges) > MAX_WINDINGS:
        raise MapFormatError(
            f"{path}: a shape with {len(edges):,} edges has {len(inside):,} parts; split it"
        )
    return faces, _windings(inside, np.ascontiguousarray(edges.reshape(-1, 4)))


def crossing_of(path: Path, ring: FloatArray) -> tuple[float, float] | None:
    """Return a point at which a closed ring crosses itself; None if it at most touches itself.

    A ring that does not cross itself winds around every point at most once, and around all of them
    in the same direction. Areas that are nowhere 1 mm wide do not count.

    Parameters
    ----------
    path, ring
        As for `filled`.

    Raises
    ------
    MapFormatError
        If the ring crosses itself too often.

    Examples
    --------
    >>> import numpy as np
    >>> from pathlib import Path
    >>> crossing_of(Path("plan.json"), np.array([[0, 0], [2, 2], [2, 0], [0, 2]], float))
    (1.0, 1.0)
    >>> spike = np.array([[0, 0], [4, 0], [6, 0], [4, 0], [4, 4]], float)
    >>> crossing_of(Path("plan.json"), spike) is None
    True
    """
    faces, turns = wound_faces(path, [ring])
    wide = ~shapely.is_empty(shapely.buffer(faces, -SLIVER_WIDTH_M / 2))
    faces, turns = faces[wide], turns[wide]
    if not turns.any():
        return None
    way = turns[np.argmax(np.where(turns, shapely.area(faces), 0.0))]
    way //= abs(way)
    wrong = (turns != 0) & (turns != way)
    if not wrong.any():
        return None
    # Where a ring crosses itself, areas with three winding numbers meet.
    beyond = shapely.box(*shapely.total_bounds(faces)).buffer(1.0) - shapely.union_all(faces)
    corners = np.unique(shapely.get_coordinates(faces[wrong]), axis=0)
    areas = shapely.STRtree([*faces, beyond])
    corner, face = areas.query(shapely.points(corners), predicate="intersects")
    meeting = np.unique(np.column_stack([corner, np.append(turns, 0)[face]]), axis=0)
    x, y = corners[np.argmax(np.bincount(meeting[:, 0]))]
    return float(x), float(y)


@kernel
def _count_pairs(
    edges: FloatArray, max_compared: int, max_near: int, max_crossing: int
) -> tuple[int, int, int]:
    """Return the numbers of `EdgePairs`, stopping after one exceeds its bound.

    The edges x0, y0, x1, y1 are sorted by their smaller x.
    """
    compared = near = crossing = 0
    for i in range(len(edges)):
        ax, ay, bx, by = edges[i]
        right, low, high = max(ax, bx), min(ay, by), max(ay, by)
        for j in range(i + 1, len(edges)):
            cx, cy, dx, dy = edges[j]
            if min(cx, dx) > right:
                break
            compared += 1
            if max(cy, dy) < low or min(cy, dy) > high:
                continue
            near += 1
            c = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
            d = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
            a = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
            b = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
            if (c > 0.0 and d > 0.0) or (c < 0.0 and d < 0.0):
                continue
            if (a > 0.0 and b > 0.0) or (a < 0.0 and b < 0.0):
                continue
            have_common_end = (
                (ax == cx and ay == cy)
                or (ax == dx and ay == dy)
                or (bx == cx and by == cy)
                or (bx == dx and by == dy)
            )
            overlap = (
                c == 0.0
                and d == 0.0
                and (
                    min(right, max(cx, dx)) > max(min(ax, bx), min(cx, dx))
                    or min(high, max(cy, dy)) > max(low, min(cy, dy))
                )
            )
            if have_common_end and not overlap:
                continue
            crossing += 1
        if compared > max_compared or near > max_near or crossing > max_crossing:
            break
    return compared, near, crossing


@kernel
def _overlap_too_often(boxes: FloatArray, max_compared: int, max_overlaps: int) -> bool:
    """Return whether more pairs of boxes meet, or have to be compared, than is allowed.

    The boxes x0, y0, x1, y1 are sorted by x0.
    """
    compared = overlaps = 0
    for i in range(len(boxes)):
        for j in range(i + 1, len(boxes)):
            if boxes[j, 0] > boxes[i, 2]:
                break
            compared += 1
            if boxes[j, 1] <= boxes[i, 3] and boxes[j, 3] >= boxes[i, 1]:
                overlaps += 1
        if compared > max_compared or overlaps > max_overlaps:
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
