import math
from itertools import permutations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.raster import Raster
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.frontier_arcs import frontier_candidates, total_length
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.robots.exploration_map import Closing, ClosingId, ExplorationMap, Node, NodeId

REACH = 3.0
WIDTH = 0.5


def node(serial: int, region: LocalSafeRegion, robot: int = 0) -> Node:
    return Node(
        id=NodeId(robot, serial),
        configuration=Configuration(region.x, region.y),
        region=region,
        parent=None if serial == 0 else NodeId(robot, serial - 1),
        time_s=float(serial),
    )


def box_node(serial: int, x0: float, y0: float, x1: float, y1: float, open_sides: str) -> Node:
    """Return a node that sees a rectangle: its open sides are range, the others walls."""
    sides = ("below", "right", "above", "left")
    region = LocalSafeRegion(
        x=(x0 + x1) / 2,
        y=(y0 + y1) / 2,
        range_m=REACH,
        boundary=np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]),
        tags=np.array([RANGE if side in open_sides else OBSTACLE for side in sides], np.int8),
    )
    return node(serial, region)


def new_map(**options) -> ExplorationMap:
    return ExplorationMap(**{"reach_m": REACH, "min_arc_m": WIDTH} | options)


def map_of(nodes, **options) -> ExplorationMap:
    result = new_map(**options)
    for each in nodes:
        result.add(each)
    return result


def scanned(free: shapely.Polygon, places, shape: str = "radial", range_m: float = REACH):
    rings = [np.asarray(r.coords) for r in (free.exterior, *free.interiors)]
    index = EdgeIndex(np.vstack([np.hstack([r[:-1], r[1:]]) for r in rings]), 1.0)
    scans = [take_scan(index, Configuration(x, y), 0.0, range_m) for x, y in places]
    return [node(serial, local_safe_region(scan, shape)) for serial, scan in enumerate(scans)]


@pytest.fixture(scope="module")
def rooms(worlds):
    free = shapely.orient_polygons(worlds.rooms(width=12.0, count=2, door=1.2))
    return scanned(free, worlds.viewpoints(free, 14, clearance=0.3, seed=4).tolist())


@pytest.fixture(scope="module")
def starry_office(worlds):
    free = shapely.orient_polygons(worlds.office(width=12.0, count=3))
    places = worlds.viewpoints(free, 25, clearance=0.3, seed=5).tolist()
    return scanned(free, places, "star")


def length_outside(a: np.ndarray, b: np.ndarray) -> float:
    """Return the length of segments a that lie further than 0.1 mm from all segments b."""
    lines, others = (shapely.MultiLineString(list(s.reshape(-1, 2, 2))) for s in (a, b))
    return float(lines.difference(others.buffer(1e-4)).length)


def same(a: np.ndarray, b: np.ndarray) -> bool:
    return length_outside(a, b) < 1e-6 and length_outside(b, a) < 1e-6


def test_an_empty_map():
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


def test_added_nodes_are_found_again(rooms):
    known = map_of(rooms)
    assert len(known) == len(rooms)
    assert known.nodes == tuple(rooms)
    assert known[rooms[3].id] is rooms[3]
    assert rooms[3].id in known
    assert NodeId(7, 7) not in known


def test_adding_twice_changes_nothing(rooms):
    known = map_of(rooms)
    known.raster(0.1)
    before = [known.frontier(n.id).copy() for n in rooms]
    cells = known.raster(0.1).cells.copy()
    assert [known.add(n) for n in rooms] == [False] * len(rooms)
    assert len(known) == len(rooms)
    assert all(np.array_equal(known.frontier(n.id), f) for n, f in zip(rooms, before, strict=True))
    assert np.array_equal(known.raster(0.1).cells, cells)


def test_one_scan_in_the_open():
    # The frontier is the whole circle of the range, 2 pi 3 m long.
    alone = scanned(shapely.box(-20, -20, 20, 20), [(0.0, 0.0)])
    known = map_of(alone)
    assert known.open_frontier_m() == pytest.approx(2.0 * math.pi * REACH, rel=1e-3)
    assert known.open_nodes() == [NodeId(0, 0)]
    assert not known.is_complete()


def test_two_scans_take_from_each_other():
    # Circles of radius 3 m, 3 m apart: each has 120 degrees of its rim in the other.
    pair = scanned(shapely.box(-20, -20, 20, 20), [(0.0, 0.0), (3.0, 0.0)])
    known = map_of(pair)
    for each in pair:
        length = total_length(known.frontier(each.id))
        assert length == pytest.approx(2.0 / 3.0 * 2.0 * math.pi * REACH, rel=5e-3)
    left = known.frontier(pair[0].id)
    assert left[:, [0, 2]].max() == pytest.approx(1.5, abs=0.02)


def test_a_room_seen_whole_has_no_frontier():
    known = map_of(scanned(shapely.box(0, 0, 4, 3), [(2.0, 1.5)]))
    assert known.is_complete()
    assert not known.has_frontier(NodeId(0, 0))
    assert known.frontier_arcs(NodeId(0, 0)) == []


def test_gaps_count_unless_excluded():
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


def test_an_opening_seen_in_parts_counts_as_a_whole():
    # Each of three sees 0.2 m of an opening of 0.6 m; the body is 0.5 m wide.
    parts = [box_node(k, 0.0, 0.2 * k, 2.0, 0.2 * k + 0.2, "right") for k in range(3)]
    for order in permutations(parts):
        known = new_map()
        counts = []
        for part in order:
            known.add(part)
            counts.append(len(known.open_nodes()))
        assert counts == [0, 0, 3]
        assert known.open_frontier_m() == pytest.approx(0.6)


def test_an_opening_as_wide_as_the_body_counts():
    assert map_of([box_node(0, 0, 0, 2, WIDTH, "right")]).open_frontier_m() == WIDTH
    assert map_of([box_node(0, 0, 0, 2, WIDTH - 1e-6, "right")]).is_complete()


def test_parts_that_do_not_meet_are_not_one_opening():
    # A post of 0.02 m stands between two openings of 0.3 m.
    apart = [box_node(0, 0, 0, 2, 0.3, "right"), box_node(1, 0, 0.32, 2, 0.62, "right")]
    assert map_of(apart).is_complete()


def test_an_opening_narrows_when_a_part_of_it_is_seen():
    parts = [box_node(k, 0.0, 0.3 * k, 2.0, 0.3 * k + 0.3, "right") for k in range(2)]
    known = map_of(parts)
    assert known.open_nodes() == [NodeId(0, 0), NodeId(0, 1)]
    known.add(box_node(2, 1.5, 0.3, 3.0, 0.6, ""))
    assert known.is_complete()
    assert known.open_nodes() == []


def test_an_opening_may_narrow_far_from_its_node():
    # The first node sees 4 m of an opening of 8 m, another one the rest. A third takes from the
    # other's part; it is 2.4 ranges away from the first, which no longer counts either.
    parts = [
        box_node(0, 0.0, 0.0, 4.0, 0.3, "above"),
        box_node(1, -4.0, 0.0, 0.0, 0.3, "above"),
    ]
    known = map_of(parts, min_arc_m=7.0)
    assert known.open_nodes() == [NodeId(0, 0), NodeId(0, 1)]
    known.add(box_node(2, -8.0, 0.2, -2.2, 1.0, ""))
    assert known.open_nodes() == map_of([*known.nodes], min_arc_m=7.0).open_nodes() == []


def closing(number: int, arc, serial: int = 0, **fields) -> Closing:
    """Robot 1 gives up an arc of robot 0's."""
    given = {"reason": "seen from near", "width_m": WIDTH} | fields
    return Closing(
        id=ClosingId(1, number), node=NodeId(0, serial), arc=np.asarray(arc, float), **given
    )


def test_closing_an_arc():
    known = map_of([box_node(0, 0, 0, 2, 2, "right left")])
    arcs = known.frontier_arcs(NodeId(0, 0))
    assert [total_length(arc) for arc in arcs] == [2.0, 2.0]
    first, second = closing(0, arcs[0]), closing(1, arcs[1])
    assert known.close(first)
    assert np.array_equal(known.frontier(NodeId(0, 0)), arcs[1])
    assert not known.is_complete()
    assert not known.close(first)
    assert known.close(second)
    assert known.is_complete()
    assert known.open_nodes() == []
    assert known.open_frontier_m() == 0.0
    assert known.closings == (first, second)


def test_closing_a_part_of_an_opening_leaves_the_rest_too_narrow():
    parts = [box_node(k, 0.0, 0.3 * k, 2.0, 0.3 * k + 0.3, "right") for k in range(2)]
    known = map_of(parts)
    assert known.has_frontier(NodeId(0, 1))
    known.close(closing(0, known.frontier(NodeId(0, 0))))
    assert not known.has_frontier(NodeId(0, 1))
    assert known.is_complete()


@pytest.mark.parametrize("turned", [False, True])
def test_an_arc_takes_with_it_what_lies_along_it_and_no_more(turned):
    # The node's side runs from (2, 0) to (2, 4); the arc from 1 to 2.5, and beyond other sides.
    arc = np.array([[2.0, 1.0, 2.0, 2.0], [2.0, 2.0, 2.0, 2.5], [3.0, 0.0, 3.0, 4.0]])
    if turned:
        arc = arc[:, [2, 3, 0, 1]]
    known = map_of([box_node(0, 0, 0, 2, 4, "right above")])
    known.close(closing(0, arc))
    expected = [[2, 0, 2, 1], [2, 2.5, 2, 4], [2, 4, 0, 4]]
    assert known.frontier(NodeId(0, 0)) == pytest.approx(np.array(expected, float), abs=1e-9)
    known.close(closing(1, [[2, 2.4, 2, 9], [0, 4.00001, 2, 4.00001]]))
    assert known.open_frontier_m() == pytest.approx(3.0)


def test_an_arc_across_takes_nothing():
    known = map_of([box_node(0, 0, 0, 2, 2, "right")])
    known.close(closing(0, [[1, 1, 3, 1], [1.5, 0.5, 2.5, 1.5], [2, -1, 2, 0]]))
    assert np.array_equal(known.frontier(NodeId(0, 0)), [[2, 0, 2, 2]])


def test_an_arc_is_closed_before_its_node_is_known():
    known = new_map()
    assert known.close(closing(0, [[2, 0, 2, 1]]))
    assert known.is_complete()
    known.add(box_node(0, 0, 0, 2, 2, "right"))
    assert known.frontier(NodeId(0, 0)) == pytest.approx(np.array([[2.0, 1.0, 2.0, 2.0]]))


@pytest.mark.parametrize(
    ("reason", "width_m", "robot", "own_width_m", "closed"),
    [
        ("seen from near", 9.0, 0, 0.1, True),
        ("too narrow", 0.5, 0, 0.5, True),
        ("too narrow", 0.5, 0, 0.6, True),
        ("too narrow", 0.5, 0, 0.4, False),
        ("too narrow", 0.5, None, 0.4, False),
        ("not reachable", 0.5, 0, 0.5, False),
        ("not reachable", 0.5, 1, 0.5, True),
        ("not reachable", 0.5, None, 0.5, True),
        ("blocked by a robot", 0.5, 0, 0.5, False),
        ("blocked by a robot", 0.5, 1, 0.5, True),
        ("blocked by a robot", 0.5, None, 0.5, True),
    ],
)
def test_the_reason_of_a_closing_decides_for_whom_it_holds(
    reason, width_m, robot, own_width_m, closed
):
    known = map_of([box_node(0, 0, 0, 2, 2, "right")], width_m=own_width_m, robot=robot)
    known.close(closing(0, [[2, 0, 2, 2]], reason=reason, width_m=width_m))
    assert known.is_complete() == closed
    assert len(known.closings) == 1


def test_the_own_width_defaults_to_the_shortest_arc():
    known = map_of([box_node(0, 0, 0, 2, 2, "right")])
    known.close(closing(0, [[2, 0, 2, 2]], reason="too narrow", width_m=WIDTH))
    assert known.is_complete()


@pytest.mark.parametrize(
    ("fields", "message"),
    [({"reason": "too far"}, "not 'too far'"), ({"arc": [2, 0, 2, 2]}, r"shape \(4,\)")],
)
def test_refuses_a_closing_that_makes_no_sense(fields, message):
    given = {"number": 0, "arc": [[2, 0, 2, 2]]} | fields
    with pytest.raises(InvalidInputError, match=message):
        closing(**given)


def test_the_arc_of_a_closing_is_its_own():
    arc = np.array([[2.0, 0.0, 2.0, 2.0]])
    made = closing(0, arc)
    arc[0, 0] = 7.0
    assert made.arc[0, 0] == 2.0
    with pytest.raises(ValueError, match="read-only"):
        made.arc[0, 0] = 7.0


def test_a_region_may_not_exceed_the_reach_of_the_map():
    with pytest.raises(InvalidInputError, match="largest range of the team"):
        new_map(reach_m=2.0).add(box_node(0, 0, 0, 2, 2, "right"))


def test_a_border_that_two_nodes_share_counts_once():
    # Both end at x = 2: the first from 0 to 2, the second from 1 to 3.
    pair = [box_node(0, 0, 0, 2, 2, "right"), box_node(1, 0, 1, 2, 3, "right")]
    for order in permutations(pair):
        known = map_of(order)
        assert known.open_frontier_m() == pytest.approx(3.0)
        assert known.frontier(NodeId(0, 0)) == pytest.approx(np.array([[2.0, 0.0, 2.0, 2.0]]))
        assert known.frontier(NodeId(0, 1)) == pytest.approx(np.array([[2.0, 2.0, 2.0, 3.0]]))


def test_a_border_with_regions_on_both_sides_is_no_frontier():
    pair = [box_node(0, 0, 0, 2, 2, "right"), box_node(1, 2, 0, 4, 2, "left")]
    for order in permutations(pair):
        assert map_of(order).is_complete()


def test_a_border_that_another_node_sees_as_a_wall_stays_open():
    # What one takes for a wall may be a robot's body; nothing that is open is lost.
    known = map_of([box_node(0, 0, 0, 2, 2, ""), box_node(1, 0, 0, 2, 2, "right")])
    assert known.open_nodes() == [NodeId(0, 1)]


def check_against_a_map_without_history(known: ExplorationMap, **options) -> None:
    fresh = map_of(known.nodes, **options)
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
def test_queries_between_additions_make_no_difference(source, width, request):
    # Everything is asked, and so remembered, after every addition.
    known = new_map(min_arc_m=width)
    for each in request.getfixturevalue(source):
        known.add(each)
        check_against_a_map_without_history(known, min_arc_m=width)


@given(st.randoms(use_true_random=False))
@settings(max_examples=15)
def test_the_order_of_additions_makes_no_difference(rooms, random):
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
def test_a_frontier_is_on_its_boundary_and_in_no_other_region(source, request):
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
def test_nothing_that_is_open_is_forgotten(source, request):
    nodes = request.getfixturevalue(source)
    known = map_of(nodes, min_arc_m=0.0)
    for each in nodes:
        candidates = frontier_candidates(each.region.boundary, each.region.tags)
        lines = shapely.multilinestrings(shapely.linestrings(candidates.reshape(-1, 2, 2)))
        others = shapely.union_all([n.region.polygon() for n in nodes if n is not each])
        missing = shapely.multilinestrings(
            shapely.linestrings(known.frontier(each.id).reshape(-1, 2, 2))
        ).buffer(1e-4)
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
def test_near_is_what_is_within_the_radius(places, x, y, radius):
    known = new_map()
    for serial, (px, py) in enumerate(places):
        known.add(box_node(serial, px - 0.1, py - 0.1, px + 0.1, py + 0.1, ""))
    found = [n.id.serial for n in known.near(x, y, radius)]
    positions = [n.configuration for n in known.nodes]
    expected = [
        serial
        for serial, at in enumerate(positions)
        if (at.x - x) ** 2 + (at.y - y) ** 2 <= radius**2
    ]
    assert found == expected


def test_near_is_in_the_order_of_ids():
    regions = [box_node(k, k, 0, k + 1, 1, "").region for k in range(3)]
    known = map_of([node(2, regions[0]), node(0, regions[1], robot=1), node(1, regions[2])])
    assert [n.id for n in known.near(0, 0, 9)] == [NodeId(0, 1), NodeId(0, 2), NodeId(1, 0)]


def test_pairs_are_with_earlier_nodes_ordered_by_id():
    regions = [box_node(k, k, 0, k + 1, 1, "").region for k in range(4)]
    first, far = node(2, regions[0]), node(3, regions[3])
    known = map_of([first, far, node(0, regions[1], robot=1), node(1, regions[1]), first])
    assert known.pairs_near(0, 2.0).tolist() == [[2, 0], [2, 1], [3, 0], [3, 1], [3, 2]]
    assert known.pairs_near(0, 1.5).tolist() == [[2, 0], [3, 0], [3, 2]]
    assert known.pairs_near(3, 1.5).tolist() == [[3, 0], [3, 2]]
    assert known.pairs_near(4, 2.0).tolist() == []
    assert known.places.tolist() == [[n.configuration.x, n.configuration.y] for n in known.nodes]
    for number, each in enumerate(known.nodes):
        assert (known.rings.ring(number) == each.region.boundary).all()


def test_a_raster_painted_node_by_node_is_the_same(rooms):
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
def test_a_local_union_is_the_union_in_its_window(rooms, half_width):
    known = map_of(rooms)
    for x, y in ((3.0, 3.0), (6.0, 6.0), (11.0, 1.0)):
        window = shapely.box(x - half_width, y - half_width, x + half_width, y + half_width)
        exact = shapely.union_all([n.region.polygon() for n in rooms]).intersection(window)
        assert known.local_union(x, y, half_width).symmetric_difference(exact).area < 1e-9


def test_the_union_of_all_regions(rooms):
    known = map_of(rooms)
    union = known.region_union()
    assert union.is_valid
    assert all(union.buffer(1e-9).covers(n.region.polygon()) for n in rooms)
    pair = map_of([box_node(0, 0, 0, 2, 2, ""), box_node(1, 1, 1, 3, 3, "")])
    assert pair.region_union().area == pytest.approx(7.0)
