import math
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Holonomic
from multisrt.planners.srt import SrtPlanner
from multisrt.planners.srt_options import SrtOptions
from multisrt.planners.viewing import MAX_ASKED, ViewingPlace, arc_points


def planner(footprint: str = "disc:0.25") -> SrtPlanner:
    options = SrtOptions()
    body = PlanningBody(Footprint.parse(footprint), options.margin_m)
    return SrtPlanner(body, Holonomic(), options, 0.5)


ARC = np.array([(6.0, 1.0, 6.0, 2.0), (6.0, 2.0, 6.0, 3.0)])


def viewing_place(arc, free, range_m, nodes, *leads, window=(-1.0, -1.0, 9.0, 9.0)):
    """Return the viewing place of an arc in known space made of adjacent triangles."""
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


def test_viewing_place_has_room_for_the_whole_margin():
    # The lattice has steps of d_min / 4 = 0.125 m around (6, 2). At x = 5.75 the disc of 0.252 m
    # does not fit; at x = 5.625 there is the whole margin.
    found = viewing_place(ARC, shapely.box(0, 0, 6, 4), 3.0, standing_at((1.0, 2.0)))
    assert found == ViewingPlace(5.625, 2.0, 0, roomy=True)


def test_viewing_place_is_away_from_nodes():
    # Half of d_min, 0.25 m, from the node: two steps of the lattice to a side.
    nodes = standing_at((1.0, 2.0), (5.625, 2.0))
    x, y, k, _ = viewing_place(ARC, shapely.box(0, 0, 6, 4), 3.0, nodes)
    assert math.hypot(x - 5.625, y - 2.0) >= 0.25
    assert k == 1


def test_viewing_place_sees_the_arc():
    # A screen stands in front of the arc's middle: places right behind it do not see it.
    free = shapely.box(0, 0, 6, 4).difference(shapely.box(5.2, 1.5, 5.3, 2.5))
    x, y, *_ = viewing_place(ARC, free, 3.0, standing_at((1.0, 2.0)))
    assert shapely.LineString([(x, y), (6.0 - 1e-3, 2.0)]).within(free)
    assert free.boundary.distance(shapely.Point(x, y)) >= 0.252 - 1e-6


def test_viewing_place_may_be_reached_on_curves():
    nodes = standing_at((1.0, 2.0), (5.0, 1.0))
    free = shapely.box(0, 0, 6, 4)
    asked = []

    def leads(node, x, y):
        asked.append((node, x, y))
        return node == 0 and len(asked) > 2

    found = viewing_place(ARC, free, 3.0, nodes, leads)
    assert found == ViewingPlace(*asked[3][1:], 0, roomy=False)
    # Nearest nodes first, place by place.
    assert [node for node, *_ in asked] == [1, 0, 1, 0]
    asked.clear()
    assert viewing_place(ARC, free, 3.0, nodes, lambda *_: False) == "not reachable"


def test_places_to_which_no_path_leads_are_not_asked_for_again_close_by():
    asked = []

    def leads(node, x, y):
        asked.append((x, y))
        return False

    nodes = standing_at((1.0, 2.0), (5.0, 1.0))
    viewing_place(ARC, shapely.box(0, 0, 6, 4), 3.0, nodes, leads)
    assert len(asked) == MAX_ASKED
    places = np.array(asked[::2])  # each is asked for from both nodes
    apart = np.hypot(*(places[:4, None] - places[None, :4]).transpose(2, 0, 1))
    assert apart[np.triu_indices(4, 1)].min() >= 0.25 - 1e-12


@given(
    places=st.lists(
        st.tuples(st.floats(0.3, 5.7), st.floats(0.3, 3.7)), min_size=1, max_size=3, unique=True
    ),
    half_width=st.floats(0.5, 3.0),
)
def test_no_path_is_found_where_none_may_begin(places, half_width):
    nodes = standing_at(*places)
    window = shapely.box(6 - half_width, 2 - half_width, 6 + half_width, 2 + half_width)
    free = shapely.box(0, 0, 6, 4).intersection(window)
    if not planner().may_find_path(6.0, 2.0, half_width, nodes):
        assert isinstance(viewing_place(ARC, free, half_width, nodes), str)


def test_paths_begin_inside_the_window_or_at_narrow_nodes():
    inside, outside = standing_at((5.0, 2.0), (2.0, 2.0))
    slit = shapely.box(1.0, 1.8, 3.0, 2.2)
    narrow = SimpleNamespace(
        configuration=Configuration(2.0, 2.0),
        region=SimpleNamespace(boundary=np.array(slit.exterior.coords)[:-1]),
    )
    box = planner("box:0.5x0.3")
    assert box.may_find_path(6.0, 2.0, 1.5, [outside, inside])
    assert not box.may_find_path(6.0, 2.0, 1.5, [outside])
    assert box.may_find_path(6.0, 2.0, 1.5, [outside, narrow])
    assert not box.may_find_path(6.0, 2.0, 1.5, [])


def test_too_narrow_for_the_body():
    arc = np.array([(6.0, 0.0, 6.0, 0.4)])
    nodes = standing_at((1.0, 0.2))
    assert viewing_place(arc, shapely.box(0, 0, 6, 0.4), 3.0, nodes) == "too narrow"


def test_too_narrow_where_only_the_slit_sees_the_arc():
    # Round the corner of a slit: the room beside it is wide, but sees none of the arc's middle.
    free = shapely.union_all(
        [shapely.box(0, 0, 2, 2), shapely.box(2, 0, 3, 0.2), shapely.box(2.8, 0, 3, 2)]
    )
    arc = np.array([(3.0, 2.0, 2.8, 2.0)])
    assert viewing_place(arc, free, 3.0, standing_at((1.0, 1.0))) == "too narrow"


def test_not_reachable_by_a_straight_path():
    # The pocket before the arc has room for the body, but only a slit, round a corner, leads there.
    rooms = shapely.box(0, 0, 4, 4), shapely.box(4.5, 1, 6, 3)
    slit = shapely.box(4, 0, 5.2, 0.2), shapely.box(5, 0, 5.2, 1)
    free = shapely.union_all([*rooms, *slit])
    assert viewing_place(ARC, free, 3.0, standing_at((1.0, 2.0))) == "not reachable"
    assert viewing_place(ARC, free, 3.0, []) == "not reachable"


def test_seen_from_near_by_a_node():
    # A niche with room for places within 0.1 m of its middle, where there was a scan already.
    free = shapely.box(5.3, 1.65, 6.0, 2.35)
    arc = np.array([(6.0, 1.9, 6.0, 2.1)])
    nodes = standing_at((5.65, 2.0))
    assert viewing_place(arc, free, 3.0, nodes) == "seen from near"


def test_points_of_an_arc_outside_the_window_are_ignored():
    # In the window all places are near a node; from the arc's ends others could be seen.
    arc = np.array([(6.0, 0.2, 6.0, 3.8)])
    nodes = standing_at((5.3, 2.0), (5.65, 2.0), (4.0, 0.7))
    free = shapely.box(0, 0, 6, 4)
    assert isinstance(viewing_place(arc, free, 1.0, nodes), ViewingPlace)
    window = (5.0, 1.6, 7.0, 2.4)
    assert viewing_place(arc, free, 1.0, nodes, window=window) == "seen from near"


def test_an_arc_away_from_known_space_has_no_place():
    away = ARC + 50.0
    free = shapely.box(0, 0, 6, 4)
    assert viewing_place(away, free, 3.0, standing_at((1.0, 2.0))) == "too narrow"


def test_points_of_an_arc_begin_at_its_middle():
    # One metre up, then three to the left: its middle is one metre along the second piece.
    arc = np.array([(4.0, 0.0, 4.0, 1.0), (4.0, 1.0, 1.0, 1.0)])
    assert np.array(arc_points(arc, 9.0)) == pytest.approx(np.array([(3.0, 1.0, 0.0, -1.0)]))
    assert np.array(arc_points(arc, 1.5)) == pytest.approx(
        np.array([(3.0, 1.0, 0.0, -1.0), (4.0, 0.5, -1.0, 0.0), (1.5, 1.0, 0.0, -1.0)])
    )
    assert len(arc_points(arc, 0.01)) == 7


def test_a_finer_lattice_where_all_other_places_have_been_looked_from():
    # The middle of the disc is at most at x = 5.748. At 5.625 it is 0.225 m from the node, nearer
    # than half of d_min; between there and the next step of the coarser lattice it is not.
    free = shapely.box(5.1, 1.74, 6.0, 2.26)
    arc = np.array([(6.0, 1.9, 6.0, 2.1)])
    found = viewing_place(arc, free, 3.0, standing_at((5.4, 2.0)))
    assert found == ViewingPlace(5.6875, 2.0, 0, roomy=True)
