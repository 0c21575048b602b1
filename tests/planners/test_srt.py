import math

import numpy as np
import pytest
import shapely
from scipy import stats
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.distances import distance_to_boundary
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.frontier_arcs import arc_labels, frontier_candidates
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic
from multisrt.planners.srt import Draws, SrtPlanner
from multisrt.planners.srt_options import SrtOptions

NONE = np.empty((0, 2))
D_MIN = 0.5


def planner(footprint: str = "disc:0.25", drive=None, **options) -> SrtPlanner:
    chosen = SrtOptions(**options)
    body = PlanningBody(Footprint.parse(footprint), chosen.margin_m)
    return SrtPlanner(body, Holonomic() if drive is None else drive, chosen, D_MIN)


def region(polygon: BaseGeometry, x: float, y: float, range_m: float = 4.0) -> LocalSafeRegion:
    assert isinstance(polygon, shapely.Polygon)
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


def test_a_candidate_is_at_alpha_of_the_way_to_the_boundary():
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
    place, draws = planner().draw(
        MIDDLE, region(polygon, 2.0, 2.0), slit, NONE, [], np.random.default_rng(0)
    )
    assert place is not None
    x, y = place
    # It touches the corners (4, 1.85) and (4, 2.15), each 0.15 m off its way, with 0.27 m.
    assert x == pytest.approx(4.0 - math.sqrt(0.27**2 - 0.15**2), abs=2e-3)
    assert y == pytest.approx(2.0, abs=2e-3)
    assert (draws.drawn, draws.refused) == (1, {})


def test_without_frontier_nothing_is_drawn():
    place, draws = planner().draw(
        MIDDLE, SQUARE, np.empty((0, 4)), NONE, [], np.random.default_rng(0)
    )
    assert place is None
    assert (draws.drawn, draws.refused) == (0, {})


def test_candidates_near_a_node_are_refused():
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


def test_candidates_without_room_are_refused():
    # 0.6 m to the wall: at 0.8 of it the candidate is nearer than d_min.
    at = Configuration(3.4, 2.0, 0.0)
    point = np.array([(4.0, 1.99, 4.0, 2.01)])
    place, draws = planner().draw(
        at, region(shapely.box(0, 0, 4, 4), 3.4, 2.0), point, NONE, [], np.random.default_rng(0)
    )
    assert place is None
    assert draws.refused == {"no room": 10}


def test_accept_is_asked_last_and_may_refuse():
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
    # Candidates refused for another reason are not asked about.
    nodes = np.array(asked)
    place, draws = planner(max_draws=4).draw(
        MIDDLE,
        SQUARE,
        BOTH,
        nodes,
        [],
        np.random.default_rng(0),
        accept=lambda x, y: pytest.fail("asked about a candidate that is refused"),
    )
    assert place is None
    assert draws.candidates == [(*xy, "near a node") for xy in asked]


def test_candidates_without_room_are_recorded_as_drawn():
    at = Configuration(3.4, 2.0, 0.0)
    point = np.array([(4.0, 1.99, 4.0, 2.01)])
    _, draws = planner(max_draws=1).draw(
        at, region(shapely.box(0, 0, 4, 4), 3.4, 2.0), point, NONE, [], np.random.default_rng(0)
    )
    ((x, y, reason),) = draws.candidates
    assert (x, y) == pytest.approx((3.4 + 0.8 * 0.6, 2.0), abs=0.01)
    assert reason == "no room"


def test_a_car_draws_where_it_fits_on_a_straight_path():
    # It cannot turn in place, but curves may lead there; `accept` decides on those.
    corridor = region(shapely.box(0, 0, 4, 0.5), 2.0, 0.25)
    ends = np.array([(4.0, 0.2, 4.0, 0.3), (0.0, 0.3, 0.0, 0.2)])
    chosen = planner("box:0.6x0.4", Car())
    rng = np.random.default_rng(0)
    at = Configuration(2.0, 0.25, 0.0)
    places = [chosen.draw(at, corridor, ends, NONE, [], rng)[0] for _ in range(20)]
    assert None not in places
    assert {place[0] > 2.0 for place in places if place is not None} == {True, False}


def test_other_regions_exclude_candidates_without_bias():
    whole = region(shapely.box(-1, -1, 5, 5), 2.0, 2.0)
    rng = np.random.default_rng(0)
    place, draws = planner(frontier_bias=False).draw(
        MIDDLE, SQUARE, np.empty((0, 4)), NONE, [whole], rng
    )
    assert place is None
    assert draws.refused == {"in another region": 10}
    place, _ = planner().draw(MIDDLE, SQUARE, RIGHT, NONE, [whole], rng)
    assert place is not None


def test_a_body_that_cannot_turn_draws_only_ahead():
    # A box of 0.6 x 0.4 m in a corridor 0.5 m wide, a frontier at both ends.
    corridor = region(shapely.box(0, 0, 4, 0.5), 2.0, 0.25)
    ends = np.array([(4.0, 0.2, 4.0, 0.3), (0.0, 0.3, 0.0, 0.2)])
    chosen = planner("box:0.6x0.4", Differential())
    rng = np.random.default_rng(0)
    at = Configuration(2.0, 0.25, 0.0)
    places = [chosen.draw(at, corridor, ends, NONE, [], rng)[0] for _ in range(20)]
    assert all(place is not None and place[0] > 2.0 for place in places)


def test_equal_random_streams_give_equal_draws():
    assert np.array_equal(drawn(planner(), BOTH, 20, 5), drawn(planner(), BOTH, 20, 5))
    assert not np.array_equal(drawn(planner(), BOTH, 20, 5), drawn(planner(), BOTH, 20, 6))


# Two rooms of 6 x 6 m, a wall of 0.15 m between them, a door in it from y = 4 to y = 5.
ROOMS = shapely.box(0, 0, 12.15, 6).difference(
    shapely.union(shapely.box(6, 0, 6.15, 4), shapely.box(6, 5, 6.15, 6))
)


def looking(worlds, x: float, y: float) -> tuple[LocalSafeRegion, list[np.ndarray]]:
    scan = take_scan(worlds.index(ROOMS, 4.5), Configuration(x, y), 0.0, 4.5)
    seen = local_safe_region(scan, "radial")
    segments = frontier_candidates(seen.boundary, seen.tags)
    labels, count = arc_labels(segments)
    return seen, [segments[labels == k] for k in range(count)]


def test_a_door_seen_edge_on_is_approached(worlds):
    # Close to the wall, the disc hits it at once on every line through the door.
    at = Configuration(5.74, 1.0)
    seen, arcs = looking(worlds, at.x, at.y)
    door = [arc for arc in arcs if (arc[:, 0] > 5.9).any() and (arc[:, 1] > 3.9).any()]
    assert door
    chosen = planner()
    place, draws = chosen.draw(at, seen, door[0], NONE, [], np.random.default_rng(0))
    assert place is None
    assert set(draws.refused) == {"no room"}
    place = chosen.approach(at, seen, door, NONE)
    assert place is not None
    x, y = place
    # The nearest place to the door: beside it, as near to the wall as the body gets.
    target = shapely.MultiLineString([arc.reshape(-1, 2, 2)[k] for arc in door for k in [0, -1]])
    there = shapely.Point(x, y).distance(target)
    assert there < 0.5 * shapely.Point(at[:2]).distance(target)
    assert y > 3.0
    assert seen.polygon().exterior.distance(shapely.Point(x, y)) >= 0.25
    path = shapely.LineString([at[:2], (x, y)])
    assert path.buffer(0.25).difference(seen.polygon()).area < 1e-6


def test_after_a_refusal_the_next_place_is_tried():
    draws = Draws()
    first = planner().approach(MIDDLE, SQUARE, [RIGHT], NONE)
    assert first is not None
    second = planner().approach(
        MIDDLE,
        SQUARE,
        [RIGHT],
        NONE,
        lambda x, y: "blocked by a robot" if (x, y) == first else None,
        draws,
    )
    assert second is not None
    assert draws.candidates == [(*first, "blocked by a robot")]
    assert draws.refused == {"blocked by a robot": 1}
    # Not close to the one that was refused, but still among the nearest.
    assert math.dist(first, second) >= 0.5 * D_MIN
    assert second[0] > 3.5


def test_max_draws_bounds_the_refusals_of_an_approach():
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
        place = planner().approach(at, region(polygon, at.x, at.y), [arc], NONE)
        assert (place is not None) is found


def test_no_approach_without_room_to_move():
    closet = region(shapely.box(0, 0, 0.7, 0.7), 0.35, 0.35)
    arc = np.array([(0.7, 0.1, 0.7, 0.6)])
    assert planner().approach(Configuration(0.35, 0.35), closet, [arc], NONE) is None


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
def test_invalid_options_are_rejected_by_name(name, value):
    with pytest.raises(InvalidInputError, match=name):
        SrtOptions(**{name: value})
