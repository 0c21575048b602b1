"""Paths of a body through a world that is known: a roadmap, and paths pulled tight.

A body that turns needs the room of its circumscribed disc. The roadmap joins the points of a
lattice and the corners of the area in which the centre of this disc can be. A shortest path on it
is pulled tight by lines of sight in that area, so that it is nearly a shortest path of the plane.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel
from multisrt.geometry.regions.edge_index import EdgeGrid, EdgeIndex
from multisrt.geometry.regions.line_of_sight import segment_is_free

MARGIN_M = 0.01
"""Distance in metres that nodes keep from obstacles beyond the radius of the body."""

WAY_MARGIN_M = 0.004
"""Distance in metres that the lines between nodes keep; less, so that nodes see one another."""

MIN_SPACING_M, MAX_LATTICE = 0.25, 5_000
"""Minimum spacing of the lattice in metres, and maximum number of its points."""

SIMPLIFIED_SHARE = 0.012
"""Share of the radius that both keep besides: GEOS simplifies what it buffers by one hundredth of
the distance."""

NEIGHBOUR_SPACINGS = 2.3
"""Maximum distance of joined nodes, in spacings: 16 points of the lattice around each."""

MAX_REFINEMENTS = 3
"""Maximum number of reductions of the spacing if parts of the area are not connected."""

MIN_CONNECTED = 0.995
"""Share of the nodes that are to be connected."""

MAX_ROWS = 1_500
"""Number of nodes whose distances to all others are kept."""


class Tight(NamedTuple):
    """A path that is pulled tight: length in metres, turning in radians, and corners ``(k, 2)``.

    A robot may drive backwards: it turns by at most a right angle at each corner.
    """

    length_m: float
    turning_rad: float
    corners: FloatArray


class Roadmap:
    """The paths of a disc in one connected part of a world.

    Parameters
    ----------
    component : Polygon
        The part of free space, in metres.
    radius_m : float
        The radius of the disc.
    starts : sequence of Configuration
        Where robots start in this part; they are the first nodes.
    discs : sequence of (x, y, radius_m)
        Bodies that stand in the way.

    Attributes
    ----------
    places : (n, 2) array
        The nodes in metres.
    room : Polygon
        Where the centre of the disc can be.
    """

    def __init__(
        self,
        component: Polygon,
        radius_m: float,
        starts: Sequence[Configuration],
        discs: Sequence[tuple[float, float, float]] = (),
    ) -> None:
        free = _without(component, discs)
        near = shapely.MultiPoint([(s.x, s.y) for s in starts])
        least = (1.0 + SIMPLIFIED_SHARE) * radius_m
        self.room = _part_near(free.buffer(-(least + MARGIN_M), quad_segs=4), near)
        wide = _part_near(free.buffer(-(least + WAY_MARGIN_M), quad_segs=16), near)
        narrow = free.buffer(1e-6 - radius_m, quad_segs=16)
        # Of the component: bodies of different size share the points of the lattice.
        spacing = max(MIN_SPACING_M, math.sqrt(component.area / MAX_LATTICE))
        self._index = EdgeIndex(edges_of(component if wide.is_empty else wide), spacing)
        for _ in range(MAX_REFINEMENTS + 1):
            self._build(starts, wide, narrow, spacing)
            groups, group = connected_components(self._graph, directed=False)
            sizes = np.bincount(group, minlength=groups)
            if sizes.max(initial=0) >= MIN_CONNECTED * len(self.places):
                break
            spacing /= 1.5
        self._rows: OrderedDict[int, tuple[FloatArray, IntArray]] = OrderedDict()
        self._tight: dict[tuple[int, int], Tight | None] = {}

    def _build(
        self, starts: Sequence[Configuration], wide: Polygon, narrow: BaseGeometry, spacing: float
    ) -> None:
        lattice = _lattice(self.room, spacing)
        corners = _thinned(shapely.get_coordinates(self.room), 0.5 * spacing)
        first = np.array([(s.x, s.y) for s in starts], np.float64).reshape(-1, 2)
        shapely.prepare(wide)
        inner = np.vstack((lattice, corners))
        inner = inner[shapely.contains_xy(wide, inner)]
        self.places = np.ascontiguousarray(np.vstack((first, inner)))
        n = len(first)
        tree = KDTree(self.places)
        pairs = tree.query_pairs(NEIGHBOUR_SPACINGS * spacing, output_type="ndarray")
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].astype(np.int64)
        joined = _free_pairs(self.places, pairs, self._index.grid)
        # A start may be nearer to an obstacle than nodes are: any edge that has room counts.
        self._roomy = np.ones(len(self.places), np.bool_)
        self._roomy[:n] = shapely.contains_xy(wide, first)
        tight = ~(self._roomy[pairs[:, 0]] & self._roomy[pairs[:, 1]])
        edges = shapely.linestrings(self.places[pairs[tight]])
        joined[tight] = shapely.covers(narrow, edges)
        pairs = pairs[joined]
        lengths = np.hypot(*(self.places[pairs[:, 0]] - self.places[pairs[:, 1]]).T)
        size = len(self.places)
        half = coo_array((lengths, (pairs[:, 0], pairs[:, 1])), shape=(size, size)).tocsr()
        self._graph = (half + half.T).tocsr()

    def shuts_in(self, start: Configuration) -> bool:
        """Whether a body has room elsewhere, but none to leave its start."""
        node = int(np.argmin(np.hypot(*(self.places - start[:2]).T)))
        return not self.room.is_empty and self._graph.indptr[node] == self._graph.indptr[node + 1]

    def row(self, node: int) -> tuple[FloatArray, IntArray]:
        """Return the distances of all nodes from one along the roadmap, and where they lead.

        Returns
        -------
        distances : (n,) array
            Metres; inf where there is no path.
        before : (n,) array of int
            The node before each on its way from `node`; negative for none.
        """
        if node in self._rows:
            self._rows.move_to_end(node)
            return self._rows[node]
        distances, before = dijkstra(
            self._graph, indices=np.array([node]), return_predecessors=True
        )
        self._rows[node] = row = (distances[0].astype(np.float32), before[0].astype(np.int32))
        if len(self._rows) > MAX_ROWS:
            self._rows.popitem(last=False)
        return row

    def tight(self, a: int, b: int) -> Tight | None:
        """Return the path from a node to another, pulled tight; None if no path leads there.

        That from `b` to `a` is the same path reversed.
        """
        if a > b:
            back = self.tight(b, a)
            return None if back is None else back._replace(corners=back.corners[::-1])
        if (a, b) not in self._tight:
            # Of two rows that serve, one that is kept already is the quicker.
            root, other = (b, a) if b in self._rows and a not in self._rows else (a, b)
            distances, before = self.row(root)
            if not np.isfinite(distances[other]):
                self._tight[a, b] = None
            else:
                corners, length, turning = _pulled(
                    self.places, before, root, other, self._roomy, self._index.grid
                )
                corners = corners[::-1] if root == a else corners
                self._tight[a, b] = Tight(length, turning, corners)
        return self._tight[a, b]


def edges_of(area: Polygon) -> FloatArray:
    """Return the edges of a polygon with holes, ``(n, 4)``, the area on their left."""
    oriented = shapely.orient_polygons(area)
    rings = [shapely.get_coordinates(ring) for ring in (oriented.exterior, *oriented.interiors)]
    return np.concatenate([np.hstack((ring[:-1], ring[1:])) for ring in rings])


def line_angle(a: FloatArray, b: FloatArray) -> float:
    """Return the angle of the line through two points, in radians within [0, pi)."""
    return math.atan2(b[1] - a[1], b[0] - a[0]) % math.pi


def _without(
    component: Polygon, discs: Sequence[tuple[float, float, float]]
) -> Polygon | MultiPolygon:
    blocked = [shapely.Point(x, y).buffer(radius, quad_segs=8) for x, y, radius in discs]
    if not blocked:
        return component
    free = component.difference(shapely.union_all(blocked))
    assert isinstance(free, Polygon | MultiPolygon)
    return free


def _part_near(area: BaseGeometry, place: shapely.MultiPoint) -> Polygon:
    # The part of an area that is nearest to a start: where there is room, it holds it.
    parts = [part for part in shapely.get_parts(area) if isinstance(part, Polygon)]
    first = shapely.get_geometry(place, 0)
    return min(
        (part for part in parts if not part.is_empty),
        key=lambda part: float(part.distance(first)),
        default=Polygon(),
    )


def _lattice(room: Polygon, spacing: float) -> FloatArray:
    if room.is_empty:
        return np.empty((0, 2))
    x0, y0, x1, y1 = room.bounds
    x = spacing * np.arange(math.floor(x0 / spacing), math.ceil(x1 / spacing) + 1)
    y = spacing * np.arange(math.floor(y0 / spacing), math.ceil(y1 / spacing) + 1)
    points = np.column_stack([grid.ravel() for grid in np.meshgrid(x, y, indexing="ij")])
    shapely.prepare(room)
    return points[shapely.contains_xy(room, points[:, 0], points[:, 1])]


def _thinned(points: FloatArray, cell: float) -> FloatArray:
    # The first point in each cell of a grid.
    if not len(points):
        return points.reshape(0, 2)
    _, first = np.unique(np.floor(points / cell).astype(np.int64), axis=0, return_index=True)
    return points[np.sort(first)]


@kernel
def _free_pairs(places: FloatArray, pairs: IntArray, grid: EdgeGrid) -> BoolArray:
    free = np.empty(len(pairs), np.bool_)
    for k in range(len(pairs)):
        a, b = places[pairs[k, 0]], places[pairs[k, 1]]
        free[k] = segment_is_free(a[0], a[1], b[0], b[1], grid)
    return free


@kernel
def _pulled(
    places: FloatArray, before: IntArray, root: int, end: int, roomy: BoolArray, grid: EdgeGrid
) -> tuple[FloatArray, float, float]:
    # The path from end to root, pulled tight from both sides, with its length and turning.
    size = 1
    node = end
    while node != root:
        node = before[node]
        size += 1
    chain = np.empty(size, np.int64)
    node = end
    for k in range(size):
        chain[k] = node
        node = before[node]
    for _ in range(4):
        shorter = _shortcut(places, chain, roomy, grid)[::-1].copy()
        same = len(shorter) == len(chain)
        chain = shorter
        if same:
            break
    if chain[0] != end:
        chain = chain[::-1].copy()
    corners = places[chain]
    length = turning = 0.0
    for k in range(1, len(corners)):
        dx, dy = corners[k, 0] - corners[k - 1, 0], corners[k, 1] - corners[k - 1, 1]
        length += np.hypot(dx, dy)
        if k > 1:
            bx, by = corners[k - 1, 0] - corners[k - 2, 0], corners[k - 1, 1] - corners[k - 2, 1]
            turn = abs(np.arctan2(bx * dy - by * dx, bx * dx + by * dy))
            turning += min(turn, np.pi - turn)
    return corners, length, turning


@kernel
def _shortcut(places: FloatArray, chain: IntArray, roomy: BoolArray, grid: EdgeGrid) -> IntArray:
    # Leave out the nodes between two that see one another; what leads off a tight start stays.
    kept = np.empty(len(chain), np.int64)
    kept[0] = chain[0]
    count = 1
    anchor = 0
    last = len(chain) - 1
    while anchor < last:
        reach = anchor + 1
        a = places[chain[anchor]]
        if roomy[chain[anchor]]:
            for k in range(anchor + 2, last + 1):
                if not roomy[chain[k]]:
                    break
                b = places[chain[k]]
                if not segment_is_free(a[0], a[1], b[0], b[1], grid):
                    break
                reach = k
        kept[count] = chain[reach]
        count += 1
        anchor = reach
    return kept[:count]
