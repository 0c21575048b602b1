import math
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.distances import (
    distance_to_boundary,
    distance_to_segments,
    inside,
    nearest_point,
    nearest_points,
)
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.frontier_arcs import arc_labels, frontier_candidates
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic
from multisrt.planners.srt import Draws, SrtOptions, SrtPlanner, Way, arc_points

NONE = np.empty((0, 2))
D_MIN = 0.5


def planner(footprint: str = "disc:0.25", drive=None, **options) -> SrtPlanner:
    chosen = SrtOptions(**options)
    body = PlanningBody(Footprint.parse(footprint), chosen.margin_m)
    return SrtPlanner(body, Holonomic() if drive is None else drive, chosen, D_MIN)


def region(polygon: shapely.Polygon, x: float, y: float, range_m: float = 4.0) -> LocalSafeRegion:
    boundary = np.asarray(shapely.orient_polygons(polygon).exterior.coords)[:-1].copy()
    tags = np.full(len(boundary), OBSTACLE, np.int8)
    return LocalSafeRegion(x=x, y=y, range_m=range_m, boundary=boundary, tags=tags)


SQUARE = region(shapely.box(0, 0, 4, 4), 2.0, 2.0)
MIDDLE = Configuration(2.0, 2.0, 0.0)
# Three metres of frontier in two pieces on the right, one on the left.
RIGHT = np.array([(4.0, 0.5, 4.0, 1.5), (4.0, 1.5, 4.0, 3.5)])
LEFT = np.array([(0.0, 2.5, 0.0, 1.5)])
BOTH = np.vstack([RIGHT, LEFT])


def drawn(chosen: SrtPlanner, frontier: np.ndarray, count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    places = [chosen.draw(MIDDLE, SQUARE, frontier, NONE, [], rng)[0] for _ in range(count)]
    return np.array(places)


def test_arcs_are_drawn_in_proportion_to_their_length():
    places = drawn(planner(), BOTH, 2000, seed=1)
    right = int((places[:, 0] > 2.0).sum())
    assert stats.binomtest(right, len(places), 0.75).pvalue > 1e-3


def test_points_of_an_arc_are_drawn_uniformly():
    places = drawn(planner(), BOTH, 2000, seed=2)
    right = places[places[:, 0] > 2.0]
    # The ray through a candidate meets the wall at x = 4, twice as far as one at x = 3.
    heights = 2.0 + (right[:, 1] - 2.0) * 2.0 / (right[:, 0] - 2.0)
    assert stats.kstest(heights, stats.uniform(0.5, 3.0).cdf).pvalue > 1e-3


def test_without_bias_directions_are_drawn_uniformly():
    places = drawn(planner(frontier_bias=False), np.empty((0, 4)), 2000, seed=3)
    directions = np.arctan2(places[:, 1] - 2.0, places[:, 0] - 2.0)
    assert stats.kstest(directions, stats.uniform(-math.pi, 2.0 * math.pi).cdf).pvalue > 1e-3


def test_a_candidate_lies_at_its_share_of_the_way_to_the_boundary():
    for x, y in drawn(planner(alpha=0.6), RIGHT, 50, seed=4):
        ahead = distance_to_boundary(SQUARE.boundary, 2.0, 2.0, *_unit(x - 2.0, y - 2.0))
        assert math.hypot(x - 2.0, y - 2.0) == pytest.approx(0.6 * ahead)


def _unit(dx: float, dy: float) -> tuple[float, float]:
    length = math.hypot(dx, dy)
    return dx / length, dy / length


def test_a_candidate_stops_where_the_body_no_longer_fits():
    # To the right the room goes on as a slit 0.3 m wide, up to x = 6: the disc stops before it.
    polygon = shapely.union(shapely.box(0, 0, 4, 4), shapely.box(4, 1.85, 6, 2.15))
    slit = np.array([(6.0, 1.999, 6.0, 2.001)])
    (x, y), draws = planner().draw(
        MIDDLE, region(polygon, 2.0, 2.0), slit, NONE, [], np.random.default_rng(0)
    )
    # It touches the corners (4, 1.85) and (4, 2.15), each 0.15 m off its way, with 0.27 m.
    assert x == pytest.approx(4.0 - math.sqrt(0.27**2 - 0.15**2), abs=2e-3)
    assert y == pytest.approx(2.0, abs=2e-3)
    assert (draws.drawn, draws.refused) == (1, {})


def test_no_frontier_no_draws():
    place, draws = planner().draw(
        MIDDLE, SQUARE, np.empty((0, 4)), NONE, [], np.random.default_rng(0)
    )
    assert place is None
    assert (draws.drawn, draws.refused) == (0, {})


def test_refused_near_a_node():
    # With alpha = 0.8 every candidate to the left lies on x = 0.4, y from 1.6 to 2.4.
    nodes = np.array([(0.4, 2.0)])
    place, draws = planner(max_draws=7).draw(
        MIDDLE, SQUARE, LEFT, nodes, [], np.random.default_rng(0)
    )
    assert place is None
    assert (draws.drawn, draws.refused) == (7, {"near a node": 7})


@pytest.mark.parametrize(("offset", "accepted"), [(D_MIN - 1e-6, False), (D_MIN + 1e-6, True)])
def test_a_candidate_is_d_min_from_every_node(offset, accepted):
    point = np.array([(4.0, 2.0 - 1e-9, 4.0, 2.0 + 1e-9)])
    nodes = np.array([(3.6, 2.0 + offset), (2.0, 2.0)])
    place, _ = planner().draw(MIDDLE, SQUARE, point, nodes, [], np.random.default_rng(0))
    assert (place is not None) is accepted


def test_refused_for_want_of_room():
    # 0.6 m to the wall: at 0.8 of it the candidate is nearer than d_min.
    at = Configuration(3.4, 2.0, 0.0)
    point = np.array([(4.0, 1.99, 4.0, 2.01)])
    place, draws = planner().draw(
        at, region(shapely.box(0, 0, 4, 4), 3.4, 2.0), point, NONE, [], np.random.default_rng(0)
    )
    assert place is None
    assert draws.refused == {"no room": 10}


def test_refused_by_whoever_asks_for_the_places():
    asked = []

    def accept(x, y):
        asked.append((x, y))
        return "blocked by a robot" if len(asked) < 4 else None

    place, draws = planner().draw(
        MIDDLE, SQUARE, BOTH, NONE, [], np.random.default_rng(0), accept=accept
    )
    assert place == asked[3]
    assert (draws.drawn, draws.refused) == (4, {"blocked by a robot": 3})
    assert draws.candidates == [(*xy, "blocked by a robot") for xy in asked[:3]]
    # What is refused already is not asked about.
    nodes = np.array(asked)
    place, draws = planner(max_draws=4).draw(
        MIDDLE, SQUARE, BOTH, nodes, [], np.random.default_rng(0), accept=lambda x, y: 1 / 0
    )
    assert place is None
    assert draws.candidates == [(*xy, "near a node") for xy in asked]


def test_candidates_without_room_are_put_down_where_they_were_drawn():
    at = Configuration(3.4, 2.0, 0.0)
    point = np.array([(4.0, 1.99, 4.0, 2.01)])
    _, draws = planner(max_draws=1).draw(
        at, region(shapely.box(0, 0, 4, 4), 3.4, 2.0), point, NONE, [], np.random.default_rng(0)
    )
    ((x, y, reason),) = draws.candidates
    assert (x, y) == pytest.approx((3.4 + 0.8 * 0.6, 2.0), abs=0.01)
    assert reason == "no room"


def test_a_car_draws_where_it_fits_along_its_way():
    # It cannot turn in place, but curves may lead there, which are asked for apart.
    corridor = region(shapely.box(0, 0, 4, 0.5), 2.0, 0.25)
    ends = np.array([(4.0, 0.2, 4.0, 0.3), (0.0, 0.3, 0.0, 0.2)])
    chosen = planner("box:0.6x0.4", Car())
    rng = np.random.default_rng(0)
    at = Configuration(2.0, 0.25, 0.0)
    places = [chosen.draw(at, corridor, ends, NONE, [], rng)[0] for _ in range(20)]
    assert {place[0] > 2.0 for place in places} == {True, False}


def test_refused_in_another_region_only_without_bias():
    whole = region(shapely.box(-1, -1, 5, 5), 2.0, 2.0)
    rng = np.random.default_rng(0)
    place, draws = planner(frontier_bias=False).draw(
        MIDDLE, SQUARE, np.empty((0, 4)), NONE, [whole], rng
    )
    assert place is None
    assert draws.refused == {"in another region": 10}
    place, _ = planner().draw(MIDDLE, SQUARE, RIGHT, NONE, [whole], rng)
    assert place is not None


def test_a_body_that_cannot_turn_draws_only_where_it_looks():
    # A box of 0.6 x 0.4 m in a corridor 0.5 m wide, a frontier at both ends.
    corridor = region(shapely.box(0, 0, 4, 0.5), 2.0, 0.25)
    ends = np.array([(4.0, 0.2, 4.0, 0.3), (0.0, 0.3, 0.0, 0.2)])
    chosen = planner("box:0.6x0.4", Differential())
    rng = np.random.default_rng(0)
    at = Configuration(2.0, 0.25, 0.0)
    places = [chosen.draw(at, corridor, ends, NONE, [], rng)[0] for _ in range(20)]
    assert all(place is not None and place[0] > 2.0 for place in places)


def test_equal_streams_draw_alike():
    assert np.array_equal(drawn(planner(), BOTH, 20, 5), drawn(planner(), BOTH, 20, 5))
    assert not np.array_equal(drawn(planner(), BOTH, 20, 5), drawn(planner(), BOTH, 20, 6))


# Two rooms of 6 x 6 m, a wall of 0.15 m between them, a door in it from y = 4 to y = 5.
ROOMS = shapely.box(0, 0, 12.15, 6).difference(
    shapely.union(shapely.box(6, 0, 6.15, 4), shapely.box(6, 5, 6.15, 6))
)


def looking(x: float, y: float) -> tuple[LocalSafeRegion, list[np.ndarray]]:
    coords = [np.asarray(ring.coords) for ring in [shapely.orient_polygons(ROOMS).exterior]]
    edges = np.vstack([np.hstack([ring[:-1], ring[1:]]) for ring in coords])
    scan = take_scan(EdgeIndex(edges, 1.5), Configuration(x, y), 0.0, 4.5)
    seen = local_safe_region(scan, "radial")
    segments = frontier_candidates(seen.boundary, seen.tags)
    labels, count = arc_labels(segments)
    return seen, [segments[labels == k] for k in range(count)]


def test_a_door_seen_edge_on_is_approached():
    # Close to the wall, the disc hits it right away on every line through the door.
    at = Configuration(5.74, 1.0)
    seen, arcs = looking(*at[:2])
    door = [arc for arc in arcs if (arc[:, 0] > 5.9).any() and (arc[:, 1] > 3.9).any()]
    assert door
    chosen = planner()
    place, draws = chosen.draw(at, seen, door[0], NONE, [], np.random.default_rng(0))
    assert place is None
    assert set(draws.refused) == {"no room"}
    x, y = chosen.approach(at, seen, door, NONE)
    # The nearest place to the door: beside it, as near to the wall as the body gets.
    target = shapely.MultiLineString([arc.reshape(-1, 2, 2)[k] for arc in door for k in [0, -1]])
    there = shapely.Point(x, y).distance(target)
    assert there < 0.5 * shapely.Point(at[:2]).distance(target)
    assert y > 3.0
    assert seen.polygon().exterior.distance(shapely.Point(x, y)) >= 0.25
    way = shapely.LineString([at[:2], (x, y)])
    assert way.buffer(0.25).difference(seen.polygon()).area < 1e-6


def test_the_next_place_where_an_approach_is_refused():
    draws = Draws()
    first = planner().approach(MIDDLE, SQUARE, [RIGHT], NONE)
    second = planner().approach(
        MIDDLE,
        SQUARE,
        [RIGHT],
        NONE,
        lambda x, y: "blocked by a robot" if (x, y) == first else None,
        draws,
    )
    assert draws.candidates == [(*first, "blocked by a robot")]
    assert draws.refused == {"blocked by a robot": 1}
    # Not close to the one that was refused, but still among the nearest.
    assert math.dist(first, second) >= 0.5 * D_MIN
    assert second[0] > 3.5


def test_an_approach_is_given_up_after_so_many_refusals():
    draws = Draws()
    chosen = planner(max_draws=3)
    assert chosen.approach(MIDDLE, SQUARE, [RIGHT], NONE, lambda x, y: "no way", draws) is None
    assert draws.refused == {"no way": 3}


def test_no_approach_without_arcs():
    assert planner().approach(MIDDLE, SQUARE, [], NONE) is None


def test_no_approach_where_all_places_are_near_nodes():
    grid = np.stack(np.meshgrid(np.arange(0, 4.1, 0.4), np.arange(0, 4.1, 0.4)), -1).reshape(-1, 2)
    assert planner().approach(MIDDLE, SQUARE, [RIGHT], NONE) is not None
    assert planner().approach(MIDDLE, SQUARE, [RIGHT], grid) is None


def test_no_approach_by_less_than_half_of_d_min():
    # In the room beside the slit, the disc stands as near to its end as it can but for 0.2 m.
    polygon = shapely.union(shapely.box(0, 0, 4, 4), shapely.box(4, 1.85, 6, 2.15))
    arc = np.array([(6.0, 1.85, 6.0, 2.15)])
    nearest = 4.0 - math.sqrt(0.27**2 - 0.15**2)
    for back, found in ((0.2, False), (0.7, True)):
        at = Configuration(nearest - back, 2.0)
        place = planner().approach(at, region(polygon, *at[:2]), [arc], NONE)
        assert (place is not None) is found


def test_no_approach_without_room_to_move():
    closet = region(shapely.box(0, 0, 0.7, 0.7), 0.35, 0.35)
    arc = np.array([(0.7, 0.1, 0.7, 0.6)])
    assert planner().approach(Configuration(0.35, 0.35), closet, [arc], NONE) is None


ARC = np.array([(6.0, 1.0, 6.0, 2.0), (6.0, 2.0, 6.0, 3.0)])


def viewing_place(arc, free, range_m, nodes, *leads, window=(-1.0, -1.0, 9.0, 9.0)):
    """Where the arc can be seen from, if what is known is pieces that meet along lines."""
    pieces = shapely.get_parts(shapely.constrained_delaunay_triangles(free))
    rings = [np.array(shapely.orient_polygons(piece).exterior.coords)[:-1] for piece in pieces]
    known = KnownSpace(Rings(rings), np.arange(len(rings)), window)
    return planner().viewing_place(arc, known, range_m, nodes, *leads)


def standing_at(*places):
    """Nodes with an open view of 4 m, where the body has room for any heading."""
    return [
        SimpleNamespace(
            configuration=Configuration(x, y, 0.0),
            region=SimpleNamespace(
                boundary=np.array(shapely.Point(x, y).buffer(4).exterior.coords)[:-1]
            ),
        )
        for x, y in places
    ]


def test_a_viewing_place():
    # The lattice has steps of d_min / 4 = 0.125 m around (6, 2). At x = 5.75 the disc of 0.252 m
    # does not fit; at x = 5.625 there is the whole margin.
    found = viewing_place(ARC, shapely.box(0, 0, 6, 4), 3.0, standing_at((1.0, 2.0)))
    assert found == Way(5.625, 2.0, 0, roomy=True)


def test_a_viewing_place_keeps_off_nodes_and_names_the_nearest():
    # Half of d_min, 0.25 m, from the node: two steps of the lattice to a side.
    nodes = standing_at((1.0, 2.0), (5.625, 2.0))
    x, y, k, _ = viewing_place(ARC, shapely.box(0, 0, 6, 4), 3.0, nodes)
    assert math.hypot(x - 5.625, y - 2.0) >= 0.25
    assert k == 1


def test_a_viewing_place_sees_the_arc():
    # A screen stands in front of the arc's middle: places right behind it do not see it.
    free = shapely.box(0, 0, 6, 4).difference(shapely.box(5.2, 1.5, 5.3, 2.5))
    x, y, *_ = viewing_place(ARC, free, 3.0, standing_at((1.0, 2.0)))
    assert shapely.LineString([(x, y), (6.0 - 1e-3, 2.0)]).within(free)
    assert free.boundary.distance(shapely.Point(x, y)) >= 0.252 - 1e-6


def test_a_viewing_place_to_which_other_ways_lead_than_straight_ones():
    nodes = standing_at((1.0, 2.0), (5.0, 1.0))
    free = shapely.box(0, 0, 6, 4)
    asked = []

    def leads(node, x, y):
        asked.append((node, x, y))
        return node == 0 and len(asked) > 2

    found = viewing_place(ARC, free, 3.0, nodes, leads)
    assert found == Way(*asked[3][1:], 0, roomy=False)
    # Nearest nodes first, place by place.
    assert [node for node, *_ in asked] == [1, 0, 1, 0]
    asked.clear()
    assert viewing_place(ARC, free, 3.0, nodes, lambda *_: False) == "not reachable"


@given(
    places=st.lists(
        st.tuples(st.floats(0.3, 5.7), st.floats(0.3, 3.7)), min_size=1, max_size=3, unique=True
    ),
    half_width=st.floats(0.5, 3.0),
)
def test_where_no_way_may_be_found_none_is(places, half_width):
    nodes = standing_at(*places)
    window = shapely.box(6 - half_width, 2 - half_width, 6 + half_width, 2 + half_width)
    free = shapely.box(0, 0, 6, 4).intersection(window)
    if not planner().may_find_way(6.0, 2.0, half_width, nodes):
        assert isinstance(viewing_place(ARC, free, half_width, nodes), str)


def test_a_way_may_begin_at_a_node_inside_the_window_or_at_a_narrow_one():
    inside, outside = standing_at((5.0, 2.0), (2.0, 2.0))
    slit = shapely.box(1.0, 1.8, 3.0, 2.2)
    narrow = SimpleNamespace(
        configuration=Configuration(2.0, 2.0),
        region=SimpleNamespace(boundary=np.array(slit.exterior.coords)[:-1]),
    )
    box = planner("box:0.5x0.3")
    assert box.may_find_way(6.0, 2.0, 1.5, [outside, inside])
    assert not box.may_find_way(6.0, 2.0, 1.5, [outside])
    assert box.may_find_way(6.0, 2.0, 1.5, [outside, narrow])
    assert not box.may_find_way(6.0, 2.0, 1.5, [])


def test_refused_too_narrow():
    arc = np.array([(6.0, 0.0, 6.0, 0.4)])
    nodes = standing_at((1.0, 0.2))
    assert viewing_place(arc, shapely.box(0, 0, 6, 0.4), 3.0, nodes) == "too narrow"


def test_refused_too_narrow_where_the_room_does_not_see_the_arc():
    # Round the corner of a slit: the room beside it is wide, but sees none of the arc's middle.
    free = shapely.union_all(
        [shapely.box(0, 0, 2, 2), shapely.box(2, 0, 3, 0.2), shapely.box(2.8, 0, 3, 2)]
    )
    arc = np.array([(3.0, 2.0, 2.8, 2.0)])
    assert viewing_place(arc, free, 3.0, standing_at((1.0, 1.0))) == "too narrow"


def test_refused_not_reachable():
    # The pocket before the arc has room for the body, but only a slit, round a corner, leads there.
    rooms = shapely.box(0, 0, 4, 4), shapely.box(4.5, 1, 6, 3)
    slit = shapely.box(4, 0, 5.2, 0.2), shapely.box(5, 0, 5.2, 1)
    free = shapely.union_all([*rooms, *slit])
    assert viewing_place(ARC, free, 3.0, standing_at((1.0, 2.0))) == "not reachable"
    assert viewing_place(ARC, free, 3.0, []) == "not reachable"


def test_refused_seen_from_near():
    # A niche with room for places within 0.1 m of its middle, where there was a scan already.
    free = shapely.box(5.3, 1.65, 6.0, 2.35)
    arc = np.array([(6.0, 1.9, 6.0, 2.1)])
    nodes = standing_at((5.65, 2.0))
    assert viewing_place(arc, free, 3.0, nodes) == "seen from near"


def test_points_of_an_arc_beyond_the_window_are_no_help():
    # In the window all places are near a node; from the arc's ends others could be seen.
    arc = np.array([(6.0, 0.2, 6.0, 3.8)])
    nodes = standing_at((5.3, 2.0), (5.65, 2.0), (4.0, 0.7))
    free = shapely.box(0, 0, 6, 4)
    assert isinstance(viewing_place(arc, free, 1.0, nodes), Way)
    window = (5.0, 1.6, 7.0, 2.4)
    assert viewing_place(arc, free, 1.0, nodes, window=window) == "seen from near"


def test_refused_where_the_arc_is_not_at_known_space():
    away = ARC + 50.0
    free = shapely.box(0, 0, 6, 4)
    assert viewing_place(away, free, 3.0, standing_at((1.0, 2.0))) == "too narrow"


def test_points_of_an_arc_its_middle_first():
    # One metre up, then three to the left: its middle is one metre along the second piece.
    arc = np.array([(4.0, 0.0, 4.0, 1.0), (4.0, 1.0, 1.0, 1.0)])
    assert np.array(arc_points(arc, 9.0)) == pytest.approx(np.array([(3.0, 1.0, 0.0, -1.0)]))
    assert np.array(arc_points(arc, 1.5)) == pytest.approx(
        np.array([(3.0, 1.0, 0.0, -1.0), (4.0, 0.5, -1.0, 0.0), (1.5, 1.0, 0.0, -1.0)])
    )
    assert len(arc_points(arc, 0.01)) == 7


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("alpha", 0.0),
        ("alpha", 1.1),
        ("alpha", math.nan),
        ("max_draws", 0),
        ("d_min_m", -1.0),
        ("d_min_m", math.inf),
        ("cones", 2),
        ("contact_tolerance_m", -0.1),
        ("margin_m", -0.1),
        ("margin_m", 0.0),
        ("margin_m", math.nan),
        ("max_views", 0),
        ("completion_spacing", 0.0),
    ],
)
def test_options_out_of_bounds_are_refused_by_name(name, value):
    with pytest.raises(InvalidInputError, match=name):
        SrtOptions(**{name: value})


@st.composite
def stars(draw):
    radii = np.array(draw(st.lists(st.floats(0.5, 3.0), min_size=5, max_size=20)))
    angles = np.arange(len(radii)) * (2.0 * math.pi / len(radii))
    return radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


coordinates = st.integers(-3500, 3500).map(lambda n: n / 1000)
points = st.lists(st.tuples(coordinates, coordinates), max_size=6).map(
    lambda p: np.array(p).reshape(-1, 2)
)
segments = st.lists(
    st.tuples(coordinates, coordinates, coordinates, coordinates), min_size=1, max_size=6
).map(np.array)


@given(stars(), st.floats(-math.pi, math.pi))
def test_distance_to_boundary(boundary, direction):
    ux, uy = math.cos(direction), math.sin(direction)
    ray = shapely.LineString([(0, 0), (10 * ux, 10 * uy)])
    expected = ray.intersection(shapely.Polygon(boundary).exterior).distance(shapely.Point(0, 0))
    assert distance_to_boundary(boundary, 0.0, 0.0, ux, uy) == pytest.approx(expected, abs=1e-9)


def test_no_boundary_ahead():
    assert distance_to_boundary(SQUARE.boundary, 9.0, 2.0, 1.0, 0.0) == math.inf
    assert distance_to_boundary(SQUARE.boundary, 9.0, 2.0, -1.0, 0.0) == 5.0


@given(stars(), coordinates, coordinates)
def test_inside(boundary, x, y):
    polygon = shapely.Polygon(boundary)
    if polygon.exterior.distance(shapely.Point(x, y)) > 1e-9:
        assert inside(boundary, x, y) == shapely.contains_xy(polygon, x, y)


@given(points, points)
def test_nearest_points(nodes, places):
    expected = [
        shapely.MultiPoint(nodes).distance(shapely.Point(place)) if len(nodes) else math.inf
        for place in places
    ]
    assert nearest_points(nodes, places) == pytest.approx(expected)
    for place, distance in zip(places, expected, strict=True):
        assert nearest_point(nodes, *place) == pytest.approx(distance)


@given(segments, points)
def test_distance_to_segments(lines, places):
    shape = shapely.MultiLineString(list(lines.reshape(-1, 2, 2)))
    expected = [shape.distance(shapely.Point(place)) for place in places]
    assert distance_to_segments(places, lines) == pytest.approx(expected, abs=1e-9)
