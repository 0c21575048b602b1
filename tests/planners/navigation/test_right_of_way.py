import dataclasses
import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.navigation.right_of_way import (
    Claim,
    Party,
    leader_of,
    place_aside,
    right_of_way,
    stands_in_the_way,
)
from multisrt.planners.navigation.sector import is_in_sector

CONFLICT_M = 3.0


def party(robot: int, *corners: tuple[float, float], heading: float | None = None, **more) -> Party:
    """Return a robot of radius 0.25 m at the first corner of its path, looking along it."""
    path = np.array(corners, dtype=float)
    if heading is None:
        (x0, y0), (x1, y1) = corners[:2]
        heading = math.atan2(y1 - y0, x1 - x0)
    x, y = path[0].tolist()
    at = Configuration(x, y, heading)
    return Party(robot=robot, configuration=at, path=path, radius_m=0.25, **more)


def ruling(me: Party, *others: Party) -> tuple:
    return tuple(right_of_way(me, others, CONFLICT_M, margin_m=0.1))


# In a corridor along x, two metres apart, each on its way to where the other comes from.
EAST = party(1, (0, 0), (8, 0))
WEST = party(2, (2, 0), (-6, 0))
# The same, in lanes 0.7 m apart: bodies and margin need 0.6 m.
WEST_BESIDE = party(2, (2.9, 0.7), (-6, 0.7))


def changed(robot: Party, **more) -> Party:
    return dataclasses.replace(robot, **more)


def test_a_robot_goes_on_if_no_other_is_near():
    assert ruling(EAST) == (False, ())
    assert ruling(EAST, party(2, (3.7, 0), (-6, 0))) == (False, ())


def test_flag_falls_when_the_sector_is_clear():
    assert ruling(changed(EAST, leader=True)) == (False, ())
    passed = party(2, (-1, 0), (-6, 0))
    assert ruling(changed(EAST, leader=True), passed) == (False, ())


def test_the_robot_behind_waits_for_the_one_before():
    behind, before = party(1, (0, 0), (8, 0)), party(2, (1, 0), (9, 0))
    assert ruling(behind, before) == (False, (2,))
    assert ruling(before, behind) == (False, ())


def test_nobody_waits_for_an_inactive_robot():
    inactive = changed(WEST, inactive=True)
    assert is_in_sector(EAST.configuration, inactive.configuration, CONFLICT_M)
    assert ruling(EAST, inactive) == (False, ())


def test_face_to_face_the_first_to_see_leads():
    assert ruling(EAST, WEST_BESIDE) == (True, ())
    assert ruling(WEST_BESIDE, changed(EAST, leader=True)) == (False, (1,))
    # Likewise if the other decides first.
    assert ruling(WEST_BESIDE, EAST) == (True, ())
    assert ruling(EAST, changed(WEST_BESIDE, leader=True)) == (False, (2,))


def test_of_two_flags_the_lower_number_keeps_its_own():
    east, west = changed(EAST, leader=True), changed(WEST_BESIDE, leader=True)
    assert ruling(east, west) == (True, ())
    assert ruling(west, east) == (False, (1,))


def test_a_leader_goes_on_towards_a_robot_in_its_way():
    assert ruling(EAST, WEST) == (True, ())
    assert ruling(WEST, changed(EAST, leader=True)) == (False, (1,))


def test_after_the_retreat_the_leader_passes():
    # The other stands in a side room at (1, 1) and wants to go on to the west.
    aside = party(2, (1, 1), (1, 0), (-6, 0))
    coming = changed(EAST, leader=True)
    assert ruling(coming, aside) == (False, ())
    # The leader stands on its way, though not ahead of it.
    assert not is_in_sector(aside.configuration, coming.configuration, CONFLICT_M)
    assert ruling(aside, coming) == (False, (1,))
    past = party(1, (1.7, 0), (8, 0))
    assert ruling(aside, past) == (False, ())


def test_three_in_a_ring_have_one_leader():
    corners = [(2 * math.cos(t), 2 * math.sin(t)) for t in np.arange(3) * 2 * math.pi / 3]
    ring = [
        party(k, corners[k], corners[(k + 1) % 3], heading=math.radians(150 + 120 * k))
        for k in range(3)
    ]
    assert right_of_way(ring[1], [ring[0], ring[2]], 4.0).leader
    ring[1] = changed(ring[1], leader=True)
    assert right_of_way(ring[0], ring[1:], 4.0) == (False, (1,))
    assert right_of_way(ring[2], ring[:2], 4.0) == (False, (1,))


def test_two_conflicts_have_a_leader_each():
    east, west = party(3, (0, 9), (8, 9)), party(4, (2.9, 9.7), (-6, 9.7))
    assert ruling(EAST, WEST_BESIDE, east, west) == (True, ())
    first = changed(EAST, leader=True)
    assert ruling(west, first, WEST_BESIDE, east) == (True, ())


def test_a_leader_waits_for_a_robot_that_crosses():
    # A third robot crosses between the two and sees neither.
    crossing = party(3, (1.5, 0), (1.5, 8))
    west = changed(WEST_BESIDE, leader=False)
    assert ruling(changed(EAST, leader=True), west, crossing) == (True, (3,))


def test_equal_numbers_are_rejected():
    with pytest.raises(InvalidInputError, match=r"\[1, 1\]"):
        ruling(EAST, EAST)


def test_cornered_robots_lead_before_raised_flags():
    assert leader_of([Claim(1, leader=True), Claim(2, cornered=True)]) == 2
    # Of cornered robots one with its flag raised, then the lowest number.
    assert leader_of([Claim(1, cornered=True), Claim(2, leader=True, cornered=True)]) == 2
    assert leader_of([Claim(2, cornered=True), Claim(1, cornered=True)]) == 1


def test_of_raised_flags_the_lowest_number_leads():
    assert leader_of([Claim(3, leader=True), Claim(1), Claim(2, leader=True)]) == 2
    assert leader_of([Claim(3), Claim(1)]) is None
    assert leader_of([]) is None


def test_a_path_that_leads_away_is_free():
    teammate = Configuration(0.0, 0.5)
    assert not stands_in_the_way(np.array([[0.0, 0.0], [5.0, 0.0]]), teammate, 0.6)
    assert not stands_in_the_way(np.array([[0.0, 0.0]]), teammate, 0.6)
    assert stands_in_the_way(np.array([[-0.2, 0.0], [5.0, 0.0]]), teammate, 0.6)
    assert not stands_in_the_way(np.array([[-5.0, 0.0], [5.0, 0.0]]), teammate, 0.6, within_m=4.6)
    assert stands_in_the_way(np.array([[-5.0, 0.0], [5.0, 0.0]]), teammate, 0.6, within_m=4.7)


def test_place_aside_is_the_nearest_off_the_path():
    path = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 5.0]])
    places = np.array([[3.0, 0.5], [4.0, 0.6], [5.0, 2.0], [7.5, 4.0], [6.0, -0.6]])
    costs = np.array([0.5, 3.0, 1.5, 0.1, 1.5])
    assert place_aside(places, costs, path, 0.6) == (5.0, 2.0)
    assert place_aside(places[:2], costs[:2], path, 0.6) == (4.0, 0.6)
    assert place_aside(places[:2], np.array([0.5, math.inf]), path, 0.6) is None
    assert place_aside(places, costs, path, 3.1) is None
    assert place_aside(np.empty((0, 2)), np.empty(0), path, 0.6) is None


coordinates = st.tuples(st.floats(-5, 5), st.floats(-5, 5))


@given(
    st.lists(coordinates, min_size=1, max_size=20),
    st.lists(coordinates, min_size=1, max_size=5),
    st.floats(0.1, 4.0),
)
def test_place_aside_against_shapely(places, path, apart):
    costs = np.array([round(math.hypot(*place), 1) for place in places])
    line = shapely.LineString(path) if len(path) > 1 else shapely.Point(path[0])
    distances = [line.distance(shapely.Point(place)) for place in places]
    found = place_aside(np.array(places), costs, np.array(path), apart)
    if found is None:
        assert all(d < apart + 1e-9 for d in distances)
        return
    chosen = places.index(found)
    assert distances[chosen] >= apart - 1e-9
    better = costs < costs[chosen]
    assert all(d < apart + 1e-9 for d, b in zip(distances, better, strict=True) if b)


@st.composite
def teams(draw):
    count = draw(st.integers(2, 4))
    return [
        party(
            k,
            draw(coordinates),
            *draw(st.lists(coordinates, max_size=3)),
            heading=draw(st.floats(-math.pi, math.pi)),
            leader=draw(st.booleans()),
            inactive=draw(st.integers(0, 4)) == 0,
        )
        for k in range(count)
    ]


@given(teams())
def test_robots_that_see_each_other_do_not_all_wait(team):
    # The robots decide in turn, each knowing the decisions before.
    active = [k for k, robot in enumerate(team) if not robot.inactive]
    rulings = {}
    for _ in range(3):
        for k in active:
            others = [teammate for teammate in team if teammate is not team[k]]
            rulings[k] = right_of_way(team[k], others, CONFLICT_M, margin_m=0.1)
            team[k] = changed(team[k], leader=rulings[k].leader)
    assert all(k not in waits_for for k, (_, waits_for) in rulings.items())
    assert not active or any(not waits_for for _, waits_for in rulings.values())
