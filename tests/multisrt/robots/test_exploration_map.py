"""The map of a robot: nodes, frontiers, rasters and unions."""

import math
from collections.abc import Callable, Sequence
from itertools import permutations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.raster import Raster
from multisrt.geometry.regions.boundary import GAP, OBSTACLE
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.frontier_arcs import frontier_candidates, total_length
from multisrt.geometry.regions.overlay import GRID_M
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.geometry.regions.shapes import Shape
from multisrt.robots.exploration_map import ExplorationMap, Node, NodeId

REACH = 3.0
WIDTH = 0.5


@pytest.fixture(scope="module")
def scanned(node_of) -> Callable[..., list[Node]]:
    """Build the nodes of robot 0 at some places in free space."""

    def build(
        free: BaseGeometry, places: Sequence[Sequence[float]], shape: Shape = "radial"
    ) -> list[Node]:
        assert isinstance(free, shapely.Polygon)
        rings = [np.asarray(r.coords) for r in (free.exterior, *free.interiors)]
        index = EdgeIndex(np.vstack([np.hstack([r[:-1], r[1:]]) for r in rings]), 1.0)
        scans = [take_scan(index, Configuration(x, y), 0.0, REACH) for x, y in places]
        return [node_of(k, local_safe_region(scan, shape)) for k, scan in enumerate(scans)]

    return build


@pytest.fixture(scope="module")
def rooms(scanned, worlds):
    free = shapely.orient_polygons(worlds.rooms(width=12.0, count=2, door=1.2))
    return scanned(free, worlds.viewpoints(free, 14, clearance=0.3, seed=4).tolist())


@pytest.fixture(scope="module")
def starry_office(scanned, worlds):
    free = shapely.orient_polygons(worlds.office(width=12.0, count=3))
    places = worlds.viewpoints(free, 25, clearance=0.3, seed=5).tolist()
    return scanned(free, places, "star")


def length_outside(a: np.ndarray, b: np.ndarray) -> float:
    """Return the length of segments a that lie further than 0.1 mm from all segments b."""
    lines, others = (shapely.MultiLineString(list(s.reshape(-1, 2, 2))) for s in (a, b))
    return float(lines.difference(others.buffer(1e-4)).length)


def same(a: np.ndarray, b: np.ndarray) -> bool:
    return length_outside(a, b) < 1e-6 and length_outside(b, a) < 1e-6


def test_an_empty_map(new_map):
    empty = new_map()
    assert len(empty) == 0
    assert empty.nodes == ()
    assert empty.is_complete()
    assert empty.open_nodes() == []
    assert empty.open_frontier_m() == 0.0
    assert empty.near(0.0, 0.0, 100.0) == []
    assert empty.region_union().is_empty
    assert empty.local_union(0.0, 0.0, 5.0).is_empty
    assert empty.raster(0.1).area_m2() == 0.0


def test_added_nodes_are_found_again(map_of, rooms):
    known = map_of(rooms)
    assert len(known) == len(rooms)
    assert known.nodes == tuple(rooms)
    assert known[rooms[3].id] is rooms[3]
    assert rooms[3].id in known
    assert NodeId(7, 7) not in known


def test_adding_twice_changes_nothing(map_of, rooms):
    known = map_of(rooms)
    known.raster(0.1)
    before = [known.frontier(n.id).copy() for n in rooms]
    cells = known.raster(0.1).cells.copy()
    assert [known.add(n) for n in rooms] == [False] * len(rooms)
    assert len(known) == len(rooms)
    assert all(np.array_equal(known.frontier(n.id), f) for n, f in zip(rooms, before, strict=True))
    assert np.array_equal(known.raster(0.1).cells, cells)


def test_one_scan_in_the_open(map_of, scanned):
    # The frontier is the whole circle of the range, 2 pi 3 m long.
    alone = scanned(shapely.box(-20, -20, 20, 20), [(0.0, 0.0)])
    known = map_of(alone)
    assert known.open_frontier_m() == pytest.approx(2.0 * math.pi * REACH, rel=1e-3)
    assert known.open_nodes() == [NodeId(0, 0)]
    assert not known.is_complete()


def test_two_scans_take_from_each_other(map_of, scanned):
    # Circles of radius 3 m, 3 m apart: each has 120 degrees of its rim in the other.
    pair = scanned(shapely.box(-20, -20, 20, 20), [(0.0, 0.0), (3.0, 0.0)])
    known = map_of(pair)
    for each in pair:
        length = total_length(known.frontier(each.id))
        assert length == pytest.approx(2.0 / 3.0 * 2.0 * math.pi * REACH, rel=5e-3)
    left = known.frontier(pair[0].id)
    assert left[:, [0, 2]].max() == pytest.approx(1.5, abs=0.02)


def test_a_room_seen_whole_has_no_frontier(map_of, scanned):
    known = map_of(scanned(shapely.box(0, 0, 4, 3), [(2.0, 1.5)]))
    assert known.is_complete()
    assert not known.has_frontier(NodeId(0, 0))
    assert known.frontier_arcs(NodeId(0, 0)) == []


def test_gaps_count_unless_excluded(map_of, scanned):
    # Behind the wall's end at (3, 2) nothing is seen: the gap goes from there to the range's end.
    free = shapely.box(0, 0, 8, 8).difference(shapely.box(3, 0, 3.2, 2))
    seen = scanned(shapely.orient_polygons(free), [(2.0, 1.0)])
    assert (seen[0].region.tags == GAP).any()
    with_gaps, without = map_of(seen), map_of(seen, gaps_count=False)
    gap = frontier_candidates(seen[0].region.boundary, seen[0].region.tags)
    gap = gap[(seen[0].region.tags == GAP)[seen[0].region.tags != OBSTACLE]]
    assert with_gaps.open_frontier_m() - without.open_frontier_m() == pytest.approx(
        total_length(gap)
    )


def test_an_opening_seen_in_parts_counts_as_a_whole(new_map, rectangle_node):
    # Each of three sees 0.2 m of an opening of 0.6 m; the body is 0.5 m wide.
    parts = [rectangle_node(k, 0.0, 0.2 * k, 2.0, 0.2 * k + 0.2, "right") for k in range(3)]
    for order in permutations(parts):
        known = new_map()
        counts = []
        for part in order:
            known.add(part)
            counts.append(len(known.open_nodes()))
        assert counts == [0, 0, 3]
        assert known.open_frontier_m() == pytest.approx(0.6)


def test_an_opening_as_wide_as_the_body_counts(map_of, rectangle_node):
    assert map_of([rectangle_node(0, 0, 0, 2, WIDTH, "right")]).open_frontier_m() == WIDTH
    assert map_of([rectangle_node(0, 0, 0, 2, WIDTH - 1e-6, "right")]).is_complete()


def test_parts_that_do_not_meet_are_not_one_opening(map_of, rectangle_node):
    # A post of 0.02 m stands between two openings of 0.3 m.
    apart = [rectangle_node(0, 0, 0, 2, 0.3, "right"), rectangle_node(1, 0, 0.32, 2, 0.62, "right")]
    assert map_of(apart).is_complete()


def test_an_opening_narrows_when_a_part_of_it_is_seen(map_of, rectangle_node):
    parts = [rectangle_node(k, 0.0, 0.3 * k, 2.0, 0.3 * k + 0.3, "right") for k in range(2)]
    known = map_of(parts)
    assert known.open_nodes() == [NodeId(0, 0), NodeId(0, 1)]
    known.add(rectangle_node(2, 1.5, 0.3, 3.0, 0.6, ""))
    assert known.is_complete()
    assert known.open_nodes() == []


def test_an_opening_may_narrow_far_from_its_node(map_of, rectangle_node):
    # The first node sees 4 m of an opening of 8 m, another one the rest. A third takes from the
    # other's part; it is 2.4 ranges away from the first, which no longer counts either.
    parts = [
        rectangle_node(0, 0.0, 0.0, 4.0, 0.3, "above"),
        rectangle_node(1, -4.0, 0.0, 0.0, 0.3, "above"),
    ]
    known = map_of(parts, min_arc_m=7.0)
    assert known.open_nodes() == [NodeId(0, 0), NodeId(0, 1)]
    known.add(rectangle_node(2, -8.0, 0.2, -2.2, 1.0, ""))
    assert known.open_nodes() == map_of([*known.nodes], min_arc_m=7.0).open_nodes() == []


def test_a_region_may_not_exceed_the_reach_of_the_map(new_map, rectangle_node):
    with pytest.raises(InvalidInputError, match="largest range of the team"):
        new_map(reach_m=2.0).add(rectangle_node(0, 0, 0, 2, 2, "right"))


def test_a_border_that_two_nodes_share_counts_once(map_of, rectangle_node):
    # Both end at x = 2: the first from 0 to 2, the second from 1 to 3.
    pair = [rectangle_node(0, 0, 0, 2, 2, "right"), rectangle_node(1, 0, 1, 2, 3, "right")]
    for order in permutations(pair):
        known = map_of(order)
        assert known.open_frontier_m() == pytest.approx(3.0)
        assert known.frontier(NodeId(0, 0)) == pytest.approx(np.array([[2.0, 0.0, 2.0, 2.0]]))
        assert known.frontier(NodeId(0, 1)) == pytest.approx(np.array([[2.0, 2.0, 2.0, 3.0]]))


def test_a_border_with_regions_on_both_sides_is_no_frontier(map_of, rectangle_node):
    pair = [rectangle_node(0, 0, 0, 2, 2, "right"), rectangle_node(1, 2, 0, 4, 2, "left")]
    for order in permutations(pair):
        assert map_of(order).is_complete()


def test_a_border_that_another_node_sees_as_a_wall_stays_open(map_of, rectangle_node):
    # What one takes for a wall may be a robot's body; nothing that is open is lost.
    known = map_of([rectangle_node(0, 0, 0, 2, 2, ""), rectangle_node(1, 0, 0, 2, 2, "right")])
    assert known.open_nodes() == [NodeId(0, 1)]


def check_against_a_map_without_history(known: ExplorationMap, fresh: ExplorationMap) -> None:
    lengths = []
    for each in known.nodes:
        assert np.array_equal(known.frontier(each.id), fresh.frontier(each.id))
        assert known.has_frontier(each.id) == (len(fresh.frontier(each.id)) > 0)
        lengths.append(total_length(fresh.frontier(each.id)))
        arcs = known.frontier_arcs(each.id)
        assert sum(map(len, arcs)) == len(known.frontier(each.id))
    opened = [n.id for n, length in zip(known.nodes, lengths, strict=True) if length]
    assert known.open_nodes() == sorted(opened)
    assert known.is_complete() == (not opened)
    assert known.open_frontier_m() == pytest.approx(math.fsum(lengths))


@pytest.mark.parametrize("width", [0.0, WIDTH, 3.0, 8.0])
@pytest.mark.parametrize("source", ["rooms", "starry_office"])
def test_queries_between_additions_make_no_difference(new_map, map_of, source, width, request):
    # Everything is asked, and so remembered, after every addition.
    known = new_map(min_arc_m=width)
    for each in request.getfixturevalue(source):
        known.add(each)
        check_against_a_map_without_history(known, map_of(known.nodes, min_arc_m=width))


@given(st.randoms(use_true_random=False))
@settings(max_examples=15)
def test_the_order_of_additions_makes_no_difference(new_map, map_of, rooms, random):
    expected = map_of(rooms)
    shuffled = list(rooms)
    random.shuffle(shuffled)
    known = new_map()
    for each in shuffled:
        known.add(each)
        known.is_complete()
    assert known.open_nodes() == expected.open_nodes()
    for each in rooms:
        assert same(known.frontier(each.id), expected.frontier(each.id))
    assert known.region_union().equals_exact(expected.region_union(), 1e-9, normalize=True) or (
        known.region_union().symmetric_difference(expected.region_union()).area < 1e-9
    )


@pytest.mark.parametrize("source", ["rooms", "starry_office"])
def test_a_frontier_is_on_its_boundary_and_in_no_other_region(map_of, source, request):
    nodes = request.getfixturevalue(source)
    known = map_of(nodes, min_arc_m=0.0)
    seen = 0
    for each in nodes:
        segments = known.frontier(each.id)
        if not len(segments):
            continue
        seen += 1
        lines = shapely.linestrings(segments.reshape(-1, 2, 2))
        assert shapely.distance(each.region.polygon().exterior, lines).max() < 1e-9
        for other in nodes:
            if other is not each:
                inner = other.region.polygon().buffer(-1e-5)
                assert shapely.length(shapely.intersection(lines, inner)).sum() < 1e-6
    assert seen > 3


@pytest.mark.parametrize("source", ["rooms", "starry_office"])
def test_nothing_that_is_open_is_forgotten(map_of, source, request):
    nodes = request.getfixturevalue(source)
    known = map_of(nodes, min_arc_m=0.0)
    for each in nodes:
        candidates = frontier_candidates(each.region.boundary, each.region.tags)
        lines = shapely.MultiLineString(list(candidates.reshape(-1, 2, 2)))
        others = shapely.union_all([n.region.polygon() for n in nodes if n is not each])
        found = known.frontier(each.id).reshape(-1, 2, 2)
        missing = shapely.MultiLineString(list(found)).buffer(1e-4)
        # What is left out is inside other regions, or shorter than a millimetre.
        rest = lines.difference(others.buffer(1e-5)).difference(missing)
        assert max((part.length for part in shapely.get_parts(rest)), default=0.0) < 2e-3


# In micrometres: squares of what is far smaller are 0, by which brute force finds too many.
coordinate = st.integers(-25_000_000, 25_000_000).map(lambda n: n / 1e6)


@given(
    st.lists(st.tuples(coordinate, coordinate), max_size=30),
    coordinate,
    coordinate,
    st.floats(0, 30),
)
def test_near_is_what_is_within_the_radius(new_map, rectangle_node, places, x, y, radius):
    known = new_map()
    for serial, (px, py) in enumerate(places):
        known.add(rectangle_node(serial, px - 0.1, py - 0.1, px + 0.1, py + 0.1, ""))
    found = [n.id.serial for n in known.near(x, y, radius)]
    positions = [n.configuration for n in known.nodes]
    expected = [
        serial
        for serial, at in enumerate(positions)
        if (at.x - x) ** 2 + (at.y - y) ** 2 <= radius**2
    ]
    assert found == expected


def test_near_is_in_the_order_of_ids(map_of, rectangle_node, node_of):
    regions = [rectangle_node(k, k, 0, k + 1, 1, "").region for k in range(3)]
    known = map_of(
        [node_of(2, regions[0]), node_of(0, regions[1], robot=1), node_of(1, regions[2])]
    )
    assert [n.id for n in known.near(0, 0, 9)] == [NodeId(0, 1), NodeId(0, 2), NodeId(1, 0)]


def test_pairs_are_with_earlier_nodes_ordered_by_id(map_of, rectangle_node, node_of):
    regions = [rectangle_node(k, k, 0, k + 1, 1, "").region for k in range(4)]
    first, far = node_of(2, regions[0]), node_of(3, regions[3])
    known = map_of([first, far, node_of(0, regions[1], robot=1), node_of(1, regions[1]), first])
    assert known.pairs_near(0, 2.0).tolist() == [[2, 0], [2, 1], [3, 0], [3, 1], [3, 2]]
    assert known.pairs_near(0, 1.5).tolist() == [[2, 0], [3, 0], [3, 2]]
    assert known.pairs_near(3, 1.5).tolist() == [[3, 0], [3, 2]]
    assert known.pairs_near(4, 2.0).tolist() == []
    assert known.places.tolist() == [[n.configuration.x, n.configuration.y] for n in known.nodes]
    for number, each in enumerate(known.nodes):
        assert (known.rings.ring(number) == each.region.boundary).all()


def test_a_raster_painted_node_by_node_is_the_same(new_map, map_of, rooms):
    late, early = map_of(rooms), new_map()
    early.raster(0.1)
    for each in rooms:
        early.add(each)
    scratch = Raster(0.1)
    for each in rooms:
        scratch.paint(each.region.boundary)
    for raster in (late.raster(0.1), early.raster(0.1)):
        assert painted(raster) == painted(scratch)
        assert raster.area_m2() == pytest.approx(late.region_union().area, rel=0.02)
    assert late.raster(0.05).cell_m == 0.05
    assert late.raster(0.05).area_m2() == pytest.approx(late.region_union().area, rel=0.01)


def painted(raster: Raster) -> set[tuple[int, int]]:
    rows, columns = np.nonzero(raster.cells)
    return set(zip((rows + raster.row).tolist(), (columns + raster.column).tolist(), strict=True))


@pytest.mark.parametrize("half_width", [0.5, 2.0, 20.0])
def test_a_local_union_is_the_union_in_its_window(map_of, rooms, half_width):
    known = map_of(rooms)
    for x, y in ((3.0, 3.0), (6.0, 6.0), (11.0, 1.0)):
        window = shapely.box(x - half_width, y - half_width, x + half_width, y + half_width)
        exact = shapely.union_all([n.region.polygon() for n in rooms]).intersection(window)
        found = known.local_union(x, y, half_width)
        # Corners are rounded.
        assert shapely.symmetric_difference(found, exact, grid_size=GRID_M).area < 1e-7


def test_the_union_of_all_regions(map_of, rectangle_node, rooms):
    known = map_of(rooms)
    union = known.region_union()
    assert union.is_valid
    assert all(union.buffer(1e-9).covers(n.region.polygon()) for n in rooms)
    pair = map_of([rectangle_node(0, 0, 0, 2, 2, ""), rectangle_node(1, 1, 1, 3, 3, "")])
    assert pair.region_union().area == pytest.approx(7.0)
