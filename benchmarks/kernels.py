"""The kernels against CGAL, VisiLibity, embreex, shapely, rasterio and scikit-fmm.

Targets are well below what was measured, so that noise alone misses none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree
from shapely.geometry.base import BaseGeometry

from benchmarks import worlds
from benchmarks.harness import Benchmark, Claim, in_turns, installed, show, skipped
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.distance_field import distance_field
from multisrt.geometry.grids.raster import Raster
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.boundary import TagArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.frontier_arcs import frontier_candidates
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.geometry.regions.segment_difference import uncovered
from multisrt.geometry.regions.visibility import visibility_polygon
from multisrt.robots.exploration_map import ExplorationMap, Node, NodeId

R = 4.0
"""Range of the sensor in metres."""

CELL = 0.1
"""Width of the rasters' cells in metres."""

WHOLE_WORLD_M = 60.0
"""A range that no wall of the office is beyond."""


def main() -> None:
    """Print the table of the kernels."""
    show(BENCHMARKS)


class Office:
    """The world of the visibility polygons, as the sides need it.

    Attributes
    ----------
    places : (n, 2) array
        Viewpoints.
    rings : list of list of [x, y]
        The boundary of free space: counterclockwise outside, clockwise around obstacles.
    """

    def __init__(self) -> None:
        free = worlds.office()
        self.places = worlds.viewpoints(free, 60, seed=21)
        self._index = EdgeIndex(worlds.edges(free), R / 3.0)
        free = shapely.orient_polygons(free)
        self.rings: list[list[list[float]]] = [
            np.asarray(ring.coords)[:-1, :2].tolist() for ring in (free.exterior, *free.interiors)
        ]

    def ours(self, place: list[float]) -> tuple[FloatArray, TagArray]:
        """Return our visibility polygon of a place."""
        x, y = place
        return visibility_polygon(self._index, x, y, WHOLE_WORLD_M, arc_tolerance_m=1.0)


def visibility_by_cgal() -> Iterator[Claim | str]:
    """Measure visibility polygons of the whole office against CGAL's."""
    text = "visibility polygon, unlimited, office: CGAL"
    if not installed("pyvispoly"):
        yield skipped(text, "pyvispoly")
        return
    import pyvispoly as cgal

    def polygon(ring: list[list[float]]) -> object:
        return cgal.Polygon([cgal.Point(x, y) for x, y in ring])

    office = Office()
    outer, *inner = map(polygon, office.rings)
    calculator = cgal.VisibilityPolygonCalculator(cgal.PolygonWithHoles(outer, inner))

    def theirs(place: list[float]) -> cgal.Polygon:
        return calculator.compute_visibility_polygon(cgal.Point(*place))

    times = in_turns(office.places.tolist(), {"ours": office.ours, "theirs": theirs})
    worst = 0.0
    for place in office.places[:10].tolist():
        corners = [(float(p.x()), float(p.y())) for p in theirs(place).boundary()]
        truth, seen = shapely.Polygon(corners), shapely.Polygon(office.ours(place)[0])
        worst = max(worst, seen.symmetric_difference(truth).area / truth.area)
    yield Claim(
        text=text,
        ours=times["ours"],
        theirs=times["theirs"],
        at_least=18.0,
        holds=worst < 1e-9,
        note=f"areas differ by {worst:.0e} at most",
    )


def visibility_by_visilibity() -> Iterator[Claim | str]:
    """Measure visibility polygons of the whole office against VisiLibity's."""
    text = "visibility polygon, unlimited, office: VisiLibity"
    if not installed("visilibity"):
        yield skipped(text, "visilibity")
        return
    import visilibity

    office = Office()
    environment = visilibity.Environment(
        [visilibity.Polygon([visilibity.Point(x, y) for x, y in ring]) for ring in office.rings]
    )

    def theirs(place: list[float]) -> object:
        return visilibity.Visibility_Polygon(visilibity.Point(*place), environment, 1e-7)

    times = in_turns(office.places[:20].tolist(), {"ours": office.ours, "theirs": theirs})
    yield Claim(text=text, ours=times["ours"], theirs=times["theirs"], at_least=50.0)


def beams(count: int = 720) -> Iterator[Claim | str]:
    """Measure laser ranges against embreex."""
    text = f"{count} beams, office: embreex"
    if not installed("embreex"):
        yield skipped(text, "embreex")
        return
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    free = worlds.office()
    edges = worlds.edges(free)
    a = np.column_stack([edges[:, :2], np.full(len(edges), -1.0)])
    b = np.column_stack([edges[:, 2:], np.full(len(edges), -1.0)])
    up = np.array([0.0, 0.0, 2.0])
    walls = np.concatenate([np.stack([a, b, b + up], 1), np.stack([a, b + up, a + up], 1)])
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, walls.astype(np.float32))
    angles = np.arange(count) * (2.0 * np.pi / count)
    directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(count)])
    directions = directions.astype(np.float32)
    places = worlds.viewpoints(free, 60, seed=22)
    index = EdgeIndex(edges, R / 3.0)

    def theirs(place: list[float]) -> NDArray[np.float32]:
        origins = np.broadcast_to(np.array([*place, 0.0], np.float32), (count, 3))
        ranges: NDArray[np.float32] = scene.run(
            np.ascontiguousarray(origins), directions, dists=R, query="DISTANCE"
        )
        return ranges

    def ours(place: list[float]) -> FloatArray:
        x, y = place
        return laser_ranges(index, x, y, R, count)

    times = in_turns(places.tolist(), {"ours": ours, "theirs": theirs})
    off = np.concatenate(
        [
            np.abs(np.minimum(ours(place), R) - np.minimum(theirs(place), R))
            for place in places.tolist()
        ]
    )
    yield Claim(
        text=text,
        ours=times["ours"],
        theirs=times["theirs"],
        at_least=12.0,
        holds=float(np.mean(off < 1e-3)) > 0.999,
        note=f"{100 * np.mean(off < 1e-3):.2f} % of the beams within 1 mm",
    )


def regions_of(
    free: shapely.Polygon, places: np.ndarray, beams: int | None = None
) -> list[LocalSafeRegion]:
    """Return the radial local safe regions of places, sensed exactly or by a laser."""
    index = EdgeIndex(worlds.edges(free), R / 3.0)
    return [
        local_safe_region(take_scan(index, Configuration(x, y), 0.0, R, beams), "radial")
        for x, y in places.tolist()
    ]


def exact_frontier() -> Iterator[Claim]:
    """Measure the frontier of a node that was sensed exactly."""
    yield frontier(None, at_least=9.0)


def laser_frontier() -> Iterator[Claim]:
    """Measure the frontier of a node that was sensed by a laser."""
    yield frontier(360, at_least=40.0)


def frontier(beams: int | None, at_least: float, nodes: int = 3000) -> Claim:
    """Compare one node's frontier among its neighbours with shapely's fastest form."""
    free = worlds.office(120.0, 24, seed=3)
    places = worlds.viewpoints(free, nodes, seed=5)
    known = regions_of(free, places, beams)
    polygons = np.array([region.polygon() for region in known])
    rings = Rings([region.boundary for region in known])
    tree = cKDTree(places)
    queries = list(range(nodes - 150, nodes))
    neighbours = {
        i: np.array([k for k in tree.query_ball_point(places[i], 2 * R) if k < i], np.int64)
        for i in queries
    }

    def ours(i: int) -> np.ndarray:
        candidates = frontier_candidates(known[i].boundary, known[i].tags)
        return uncovered(candidates, rings.arrays(neighbours[i]), neighbours[i])[0]

    def theirs(i: int) -> BaseGeometry:
        # The tagged pieces as lines, minus the neighbours that touch them, one by one: faster
        # than minus their union, and far faster than boundaries minus buffered obstacles.
        candidates = frontier_candidates(known[i].boundary, known[i].tags)
        rest: BaseGeometry = lines(candidates)
        near = neighbours[i]
        for k in near[shapely.intersects(polygons[near], rest)]:
            rest = shapely.difference(rest, polygons[k])
            if rest.is_empty:
                break
        return rest

    times = in_turns(queries, {"ours": ours, "theirs": theirs})
    lost = 0.0
    for i in queries:
        lost = max(lost, theirs(i).difference(lines(ours(i)).buffer(2e-4)).length)
    return Claim(
        text=f"frontier of a node{'' if beams is None else f' of {beams} beams'}, "
        f"{np.median([len(n) for n in neighbours.values()]):.0f} neighbours: shapely",
        ours=times["ours"],
        theirs=times["theirs"],
        at_least=at_least,
        holds=lost < 1e-3,
        note=f"{lost:.0e} m of shapely's frontier missing at most",
    )


def lines(pieces: FloatArray) -> shapely.MultiLineString:
    """Return pieces of a frontier, rows of x0, y0, x1, y1, as one geometry."""
    each = np.asarray(shapely.linestrings(pieces.reshape(-1, 2, 2)))
    joined = shapely.multilinestrings(each)
    assert isinstance(joined, shapely.MultiLineString)
    return joined


def raster() -> Iterator[Claim | str]:
    """Measure the painting of regions into a raster against rasterio."""
    text = "raster of a region, 0.1 m: rasterio"
    if not installed("rasterio"):
        yield skipped(text, "rasterio")
        return
    from rasterio.features import rasterize
    from rasterio.transform import Affine

    free = worlds.office()
    known = regions_of(free, worlds.viewpoints(free, 60, seed=23))
    boundaries = [np.array(region.boundary) for region in known]
    polygons = [region.polygon() for region in known]
    mine = Raster(CELL, free.bounds)
    rows, columns = mine.cells.shape
    x0, y0 = mine.x0, mine.y0
    grid = np.zeros((rows, columns), np.uint8)

    def ours(i: int) -> object:
        return mine.paint(boundaries[i])

    def theirs(i: int) -> object:
        low = np.floor((boundaries[i].min(axis=0) - (x0, y0)) / CELL).astype(int)
        high = np.ceil((boundaries[i].max(axis=0) - (x0, y0)) / CELL).astype(int) + 1
        (c0, r0), (c1, r1) = np.maximum(low, 0), np.minimum(high, (columns, rows))
        grid[r0:r1, c0:c1] |= rasterize(
            [polygons[i]],
            out_shape=(r1 - r0, c1 - c0),
            transform=Affine(CELL, 0, x0 + c0 * CELL, 0, CELL, y0 + r0 * CELL),
            dtype="uint8",
        )
        return grid

    times = in_turns(list(range(len(known))), {"ours": ours, "theirs": theirs})
    x, y = np.meshgrid(*mine.centres())
    wrong = wrong_theirs = 0
    for i, polygon in enumerate(polygons):
        shapely.prepare(polygon)
        truth = shapely.contains_xy(polygon, x, y)
        mine.cells[:], grid[:] = False, 0
        ours(i), theirs(i)
        wrong += int(np.count_nonzero(mine.cells != truth))
        wrong_theirs += int(np.count_nonzero(grid.astype(bool) != truth))
    yield Claim(
        text=text,
        ours=times["ours"],
        theirs=times["theirs"],
        at_least=25.0,
        holds=wrong == 0,
        note=f"cells wrong: {wrong}, theirs {wrong_theirs}",
    )


def geodesic_field() -> Iterator[Claim | str]:
    """Measure fields of geodesic distances against scikit-fmm, in time and in error."""
    text = "geodesic field, 400 x 400 cells, rooms: scikit-fmm order 2"
    if not installed("skfmm"):
        yield skipped(text, "scikit-fmm")
        return
    import skfmm

    free = worlds.rooms()
    size = round(40.0 / CELL)
    centres = (np.arange(size, dtype=np.float64) + 0.5) * CELL
    x, y = np.meshgrid(centres, centres)
    cells = shapely.contains_xy(free, x, y)
    targets = np.floor(worlds.viewpoints(free, 200, seed=24) / CELL).astype(int)
    sources, targets = targets[:6], targets[6:]
    speed = np.ones((size, size))

    def ours(source: np.ndarray) -> np.ndarray:
        return distance_field(cells, CELL, [centres[source]])

    def theirs(source: np.ndarray) -> np.ndarray:
        front = np.ones((size, size))
        front[source[1], source[0]] = -1.0
        masked = np.ma.MaskedArray(front, ~cells)
        times = skfmm.travel_time(masked, speed, dx=CELL, order=2)
        # Its front starts half a cell from the centre of the source.
        return np.ma.filled(times, np.inf) + 0.5 * CELL

    times = in_turns(list(sources), {"ours": ours, "theirs": theirs})
    errors: dict[str, list[float]] = {"ours": [], "theirs": []}
    for source in sources[:2]:
        truth = shortest_paths(free, centres[source], centres[targets])
        far = truth > 10 * CELL
        for name, side in (("ours", ours), ("theirs", theirs)):
            field = side(source)[targets[:, 1], targets[:, 0]]
            errors[name].append(np.abs(field[far] / truth[far] - 1.0).mean())
    mine, other = float(np.mean(errors["ours"])), float(np.mean(errors["theirs"]))
    yield Claim(
        text=text,
        ours=times["ours"],
        theirs=times["theirs"],
        at_least=1.0,
        holds=mine <= other,
        note=f"mean error {100 * mine:.2f} %, theirs {100 * other:.2f} %",
    )


def shortest_paths(free: shapely.Polygon, source: FloatArray, targets: FloatArray) -> FloatArray:
    """Return the exact lengths of shortest paths, by a visibility graph of all corners."""
    corners = np.unique(worlds.edges(free)[:, :2], axis=0)
    points = np.vstack([source, corners, targets])
    first, second = np.triu_indices(len(points), 1)
    first, second = first[first <= len(corners)], second[first <= len(corners)]
    room = free.buffer(1e-7)
    shapely.prepare(room)
    sees = shapely.covers(
        room, shapely.linestrings(np.stack([points[first], points[second]], axis=1))
    )
    i, j = first[sees], second[sees]
    lengths = np.hypot(*(points[i] - points[j]).T)
    graph = csr_array((lengths, (i, j)), shape=(len(points), len(points)))
    return dijkstra(graph, directed=False, indices=[0])[0, 1 + len(corners) :]


def node_at(index: EdgeIndex, x: float, y: float, node_id: NodeId) -> Node:
    """Sense at a place, and return the node with its local safe region."""
    at = Configuration(x, y)
    region = local_safe_region(take_scan(index, at, 0.0, R), "radial")
    return Node(id=node_id, configuration=at, region=region, parent=None, time_s=0.0)


def map_of(index: EdgeIndex, places: np.ndarray) -> ExplorationMap:
    """Return a map with a node at every place, with a raster."""
    known = ExplorationMap(reach_m=R, min_arc_m=0.3)
    known.raster(CELL)
    for serial, (x, y) in enumerate(places.tolist()):
        known.add(node_at(index, x, y, NodeId(0, serial)))
    return known


def node_in_large_map(small: int = 100, large: int = 10_000) -> Iterator[Claim]:
    """Measure the same new nodes in the middle of two maps that differ in their extent only."""
    width = 240.0
    free = worlds.office(width, 48, seed=4)
    index = EdgeIndex(worlds.edges(free), R / 3.0)
    places = worlds.viewpoints(free, large, seed=6)
    places = places[np.argsort(np.hypot(*(places - width / 2).T), kind="stable")]
    little, big = map_of(index, places[:small]), map_of(index, places)
    middle = np.hypot(*(worlds.viewpoints(free, 40_000, seed=7) - width / 2).T) < 5.0
    new = worlds.viewpoints(free, 40_000, seed=7)[middle]
    serial = iter(range(10**9))

    def in_map(known: ExplorationMap) -> Callable[[list[float]], object]:
        def add(place: list[float]) -> object:
            x, y = place
            return known.add(node_at(index, x, y, NodeId(1, next(serial))))

        return add

    # A second addition of a node would be another task: one run per place and map.
    times = in_turns(new.tolist(), {"large": in_map(big), "small": in_map(little)}, repeats=1)
    yield Claim(
        text=f"one node more, map of {large:,} against map of {small}",
        ours=times["large"],
        theirs=times["small"],
        at_most=1.3,
        note=f"{len(new)} nodes added",
    )


def node_against_global_union(nodes: int = 3000) -> Iterator[Claim]:
    """Measure a new node against shapely's union of it with all regions before it."""
    free = worlds.office(120.0, 24, seed=3)
    index = EdgeIndex(worlds.edges(free), R / 3.0)
    places = worlds.viewpoints(free, nodes + 100, seed=5)
    known = map_of(index, places[:nodes])
    union = known.region_union()

    def ours(i: int) -> object:
        x, y = places[i].tolist()
        return known.add(node_at(index, x, y, NodeId(0, i)))

    def theirs(i: int) -> object:
        nonlocal union
        x, y = places[i]
        view, _ = visibility_polygon(index, x, y, R)
        union = union.union(shapely.Polygon(view))
        return union

    queries = list(range(nodes, nodes + 100))
    times = in_turns(queries, {"ours": ours, "theirs": theirs}, repeats=1)
    yield Claim(
        text=f"one node more at {nodes:,}: incremental union of all regions",
        ours=times["ours"],
        theirs=times["theirs"],
        at_least=100.0,
        note=f"ours with frontier arcs and raster; open frontier {known.open_frontier_m():.0f} m",
    )


BENCHMARKS: dict[str, Benchmark] = {
    "visibility by CGAL": visibility_by_cgal,
    "visibility by VisiLibity": visibility_by_visilibity,
    "beams": beams,
    "exact frontier": exact_frontier,
    "frontier of a laser": laser_frontier,
    "raster": raster,
    "geodesic field": geodesic_field,
    "node in a large map": node_in_large_map,
    "node against a union": node_against_global_union,
}


if __name__ == "__main__":
    main()
