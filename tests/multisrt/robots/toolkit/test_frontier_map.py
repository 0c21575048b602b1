import math

import numpy as np
import pytest

import multisrt as ms
from multisrt.events import GoalChosen, NodeAdded
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, UNKNOWN
from multisrt.geometry.numerics.distances import length_of
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.explorer import Sighting
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.toolkit import FrontierMap

# A room with a wall across it that leaves a door at its upper end.
ROOM = [(0, 0), (7, 0), (7, 5), (0, 5)]
WALL = [(3.4, 0), (3.4, 3.5), (3.6, 3.5), (3.6, 0.0)]


@pytest.fixture
def known(robot, hall):
    made = FrontierMap(robot())
    made.add(hall(10.0, 1.5))
    return made


def test_places_are_where_the_body_can_stand(known, robot):
    for frontier in known.frontiers(robot().start):
        row, column = known.raster.cell_of(*frontier.place)
        assert known.raster.passable[row - known.raster.row, column - known.raster.column]
        assert math.dist(frontier.place, frontier.cells.mean(axis=0)) < 0.2


def test_a_scan_that_shows_nothing_new_makes_no_node(known, hall):
    assert known.add(hall(10.0, 1.5)) is None
    assert known.add(hall(12.0, 1.5)).id == (0, 1)


def test_own_scans_and_those_of_others_make_one_map(known, robot, hall):
    node = known.add(hall(13.0, 1.5))
    other = FrontierMap(robot(robot=1))
    assert other.merge([node]) == (node.id,)
    assert other.merge([node]) == ()
    other.add(hall(10.0, 1.5))
    for a, b in zip(known.frontiers(), other.frontiers(), strict=True):
        assert a.place == b.place
        assert (a.cells == b.cells).all()


def test_frontiers_are_the_same_objects_until_they_change(known, hall):
    before = known.frontiers()
    known.add(hall(13.0, 1.5))
    after = known.frontiers()
    assert after[0] is before[0]
    assert after[1] is not before[1]


def test_a_map_that_grows_equals_one_made_at_once(robot, hall):
    places = [(10.0, 1.5), (13.0, 1.0), (7.5, 2.0), (16.0, 1.5)]
    grown = FrontierMap(robot())
    for place in places:
        grown.add(hall(*place))
        found = grown.frontiers(place)
        whole = FrontierMap(robot())
        for earlier in places[: places.index(place) + 1]:
            whole.add(hall(*earlier))
        same = whole.frontiers(place)
        assert [f.place for f in found] == [f.place for f in same]
        assert grown.costs(places, found).tolist() == whole.costs(places, same).tolist()


def test_costs_are_path_lengths_round_walls(robot, scans):
    world = scans(ROOM, WALL)
    known = FrontierMap(robot(start=Configuration(1.0, 1.0)))
    for place in [(1.0, 1.0), (3.0, 4.2), (5.0, 4.0), (5.5, 1.5)]:
        known.add(world(*place))
    start, end = (1.0, 1.0), (6.0, 1.0)
    cost = float(known.costs(start, [end])[0])
    # Round the upper end of the wall, 0.27 m off its corners.
    shortest = math.dist(start, (3.2, 3.7)) + math.dist((3.2, 3.7), (3.8, 3.7))
    shortest += math.dist((3.8, 3.7), end)
    assert cost == pytest.approx(shortest, rel=0.05)
    path = known.path(start, end)
    assert path is not None
    assert tuple(path[0]) == start
    assert math.dist(path[-1], end) < 0.1
    assert length_of(path) == pytest.approx(cost, rel=0.03)
    assert known.frontiers(start) == ()


def test_paths_lead_only_where_something_is_known(known):
    assert known.costs((10.0, 1.5), [(19.0, 1.5), (500.0, 0.0)]).tolist() == [math.inf] * 2
    assert known.costs((500.0, 0.0), [(10.0, 1.5)]).tolist() == [math.inf]
    assert known.path((10.0, 1.5), (19.0, 1.5)) is None
    assert known.path((500.0, 0.0), (10.0, 1.5)) is None
    assert known.frontiers((500.0, 0.0)) == ()


def test_costs_have_a_row_for_each_start(known):
    frontiers = known.frontiers()
    one = known.costs(Configuration(10.0, 1.5), frontiers)
    table = known.costs([(10.0, 1.5), (12.0, 1.0)], frontiers)
    assert one.shape == (2,)
    assert table.shape == (2, 2)
    assert table[0].tolist() == one.tolist()
    assert known.costs([], frontiers).shape == (0, 2)


def test_bodies_bar_the_path_as_long_as_they_count(known):
    start, frontiers = (10.0, 1.5), known.frontiers()
    free = known.costs(start, frontiers)
    wide = Footprint.parse("box:0.6x2.6")
    body = Sighting(robot=1, configuration=Configuration(12.0, 1.5), footprint=wide)
    with known.around([body]):
        barred = known.costs(start, frontiers)
        assert [f.place for f in known.frontiers(start)] == [frontiers[0].place]
        assert known.path(start, frontiers[1]) is None
    assert barred.tolist() == [free[0], math.inf]
    assert known.costs(start, frontiers).tolist() == free.tolist()
    assert len(known.frontiers(start)) == 2


def test_a_place_given_up_gives_way_to_another_of_its_group(known):
    first = known.frontiers()[0]
    known.give_up(first)
    again = known.frontiers()[0]
    assert (again.cells == first.cells).all()
    assert math.dist(again.place, first.place) > 0.25
    for _ in range(20):
        left = [f for f in known.frontiers() if f.x < 10.0]
        if not left:
            break
        known.give_up(left[0])
    assert not left
    assert len(known.frontiers()) == 1


def test_is_frontier_within_half_the_width(known):
    frontier = known.frontiers()[0]
    assert known.is_frontier(frontier)
    assert not known.is_frontier((10.0, 1.5))


def test_a_window_is_cut_from_the_cells_and_beyond(known):
    window = known.window((10.0, 1.5), 0.5)
    assert window.shape == (11, 11)
    assert (window == FREE).all()
    whole = known.window((10.0, 1.5), 20.0)
    assert whole.shape == (401, 401)
    assert (whole == FREE).sum() == (known.raster.cells == FREE).sum()
    assert (whole == OCCUPIED).sum() == (known.raster.cells == OCCUPIED).sum()
    assert (known.window((900.0, 900.0), 1.0) == UNKNOWN).all()


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda known: known.path([(1.0, 2.0), (2.0, 3.0)], (3.0, 4.0)), "from_ has 2 places"),
        (lambda known: known.give_up((math.nan, 0.0)), "place[0] is (nan, 0)"),
        (lambda known: known.costs("here", [(1.0, 2.0)]), "from_ is 'here'"),
    ],
)
def test_what_is_no_place_is_told(known, call, told):
    with pytest.raises(InvalidInputError) as error:
        call(known)
    assert told in str(error.value)


def test_cells_wider_than_the_body_are_refused(robot):
    with pytest.raises(InvalidInputError, match="choose at most 0"):
        FrontierMap(robot(), cell_m=0.6)


@pytest.mark.slow
def test_it_has_the_targets_of_the_family_all_along_a_run(robot):
    recording = ms.explore("apartment", strategy="closest", seed=1).recording
    known, compared = FrontierMap(robot()), 0
    for event in recording.events:
        if isinstance(event, NodeAdded):
            x, y, _ = event.configuration
            tags = np.frombuffer(event.tags.encode(), np.int8) - ord("0")
            region = LocalSafeRegion(
                x=x, y=y, range_m=4.0, boundary=event.region(), tags=tags.astype(np.int8)
            )
            node = Node(
                id=NodeId(event.robot, event.serial),
                configuration=Configuration(*event.configuration),
                region=region,
                parent=None,
                time_s=event.time_s,
            )
            known.merge([node])
        elif isinstance(event, GoalChosen) and event.goal is not None:
            assert tuple(f.place for f in known.frontiers()) == event.frontiers
            compared += 1
    assert compared > 20
