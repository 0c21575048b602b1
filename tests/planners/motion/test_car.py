import math
import subprocess
import sys

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.car import (
    Checks,
    car_out_and_back,
    car_trajectory,
    shortest_curves,
)
from multisrt.planners.motion.curves import curve_length
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.trajectory import Trajectory, leg_length

BODY = PlanningBody(Footprint.box(0.6, 0.4), 0.02)
DISC = PlanningBody(Footprint.disc(0.25), 0.02)
BACK = Car(turning_radius_m=0.6)
NO_BACK = Car(turning_radius_m=0.6, reverse=False)

HALL = shapely.box(0, 0, 8, 8)
# Two rooms, a wall between them with a door one metre wide.
ROOMS = shapely.box(0, 0, 8, 4).difference(
    shapely.union(shapely.box(3.9, 0, 4.1, 1.5), shapely.box(3.9, 2.5, 4.1, 4))
)
# A room with a corridor that ends after five metres.
DEAD_END = shapely.union(shapely.box(0, 0, 4, 4), shapely.box(4, 1.5, 9, 2.5))


def assert_drivable(driven: Trajectory, car: Car, body: PlanningBody, region: BaseGeometry) -> None:
    """Assert that the car can drive every leg, and that FCL finds no contact."""
    assert isinstance(region, shapely.Polygon | shapely.MultiPolygon)
    world = CollisionWorld(region)
    solid = world.body(body.footprint)
    for a, b in zip(driven.waypoints, driven.waypoints[1:], strict=False):
        turn, length = b.heading - a.heading, leg_length(a, b)
        assert b.time_s - a.time_s == pytest.approx(length / car.speed_m_s, abs=1e-6)
        assert abs(turn) * car.turning_radius_m <= length + 1e-5
        ahead = math.cos(math.atan2(b.y - a.y, b.x - a.x) - a.heading - 0.5 * turn)
        if length > 1e-3:
            assert abs(ahead) == pytest.approx(1.0, abs=1e-6)
            assert ahead > 0.0 or car.reverse
        assert world.first_contact(solid, a[1:], b[1:], turn, arc=True) is None


def out_and_back(
    car: Car, boundary: np.ndarray, start: Configuration, x: float, y: float
) -> tuple[Trajectory, Trajectory]:
    """Return the ways of a car to a place that it can reach, and back."""
    found = car_out_and_back(BODY, car, boundary, start, x, y, 0)
    assert found is not None
    return found


@pytest.mark.parametrize("car", [BACK, NO_BACK])
def test_without_obstacles_the_path_is_the_shortest_curve(car, ring):
    start, goal = Configuration(3.0, 3.0, 0.2), Configuration(5.0, 5.0, -2.0)
    curves = shortest_curves(BODY, car, ring(HALL), start, goal)
    assert curves is not None
    assert car_trajectory(BODY, car, ring(HALL), start, goal, 0) == curves[0]
    for driven, (begin, end) in zip(curves, [(start, goal), (goal, start)], strict=True):
        assert driven.length_m == pytest.approx(curve_length(car, begin, end))
        assert driven.start == begin
        assert driven.end == pytest.approx(end)
        assert_drivable(driven, car, BODY, HALL)


def test_shortest_curves_are_there_only_if_both_have_room(ring):
    # The curve back of a car without reverse is a loop, for which the corridor has no room.
    start, goal = Configuration(2.0, 0.6, 0.0), Configuration(3.0, 0.6, 0.0)
    assert car_trajectory(BODY, NO_BACK, ring(ROOMS), start, goal, 0) is not None
    assert shortest_curves(BODY, NO_BACK, ring(ROOMS), start, goal) is None
    assert shortest_curves(BODY, NO_BACK, ring(ROOMS), goal, start) is None
    assert shortest_curves(BODY, BACK, ring(ROOMS), start, goal) is not None


@pytest.mark.parametrize("car", [BACK, NO_BACK])
@pytest.mark.parametrize("body", [BODY, DISC])
def test_another_path_is_found_if_a_wall_blocks_the_curve(car, body, ring):
    start, goal = Configuration(2.0, 0.6, 0.0), Configuration(6.0, 0.6, 0.0)
    no_plans = Checks(0)
    assert car_trajectory(body, car, ring(ROOMS), start, goal, 1, checks=no_plans) is None
    assert shortest_curves(body, car, ring(ROOMS), start, goal) is None
    for region in (ring(ROOMS), ROOMS):
        driven = car_trajectory(body, car, region, start, goal, 1)
        assert driven is not None
        assert driven.start == start
        assert driven.end == pytest.approx(goal)
        assert driven.length_m > 4.0
        assert_drivable(driven, car, body, ROOMS)


def test_no_path_crosses_a_wall_or_leaves_the_region():
    walled = shapely.MultiPolygon([shapely.box(0, 0, 3.9, 4), shapely.box(4.1, 0, 8, 4)])
    start = Configuration(2.0, 2.0, 0.0)
    for goal in (Configuration(6.0, 2.0, 0.0), Configuration(9.0, 2.0, 0.0)):
        assert car_trajectory(BODY, BACK, walled, start, goal, 0) is None
    # Nor does a way begin or end in contact.
    assert car_trajectory(BODY, BACK, walled, Configuration(0.1, 2.0), start, 0) is None


def test_a_path_leads_round_a_pillar():
    region = HALL.difference(shapely.box(3, 3, 5, 5))
    # A heading of exactly pi is none to OMPL, which has -pi for it.
    for start, goal in (
        (Configuration(1.0, 4.0, 0.0), Configuration(7.0, 4.0, 0.0)),
        (Configuration(7.0, 4.0, math.pi), Configuration(1.0, 4.0, math.pi)),
    ):
        for car in (BACK, NO_BACK):
            driven = car_trajectory(BODY, car, region, start, goal, 0)
            assert driven is not None
            assert_drivable(driven, car, BODY, region)


def test_a_car_arrives_with_the_heading_of_the_direction(ring):
    start = Configuration(2.0, 4.0, 0.0)
    out, back = out_and_back(BACK, ring(HALL), start, 5.0, 5.0)
    assert out.end == pytest.approx((5.0, 5.0, math.atan2(1.0, 3.0)))
    assert back.waypoints == out.reversed().waypoints
    assert back.end == start


def test_a_car_without_reverse_returns_on_a_loop(ring):
    start = Configuration(2.0, 4.0, 0.3)
    out, back = out_and_back(NO_BACK, ring(HALL), start, 5.0, 5.0)
    assert back.start == pytest.approx(out.end)
    assert back.end == pytest.approx(start)
    for driven in (out, back):
        assert_drivable(driven, NO_BACK, BODY, HALL)


def test_a_car_arrives_with_another_heading_if_it_must(ring):
    # Beside the wall at the end of the room, the car fits only along the wall.
    region = shapely.box(0, 0, 4, 8)
    out, _ = out_and_back(BACK, ring(region), Configuration(2.0, 4.0, 1.6), 3.75, 4.0)
    assert abs(math.sin(out.end.heading)) == pytest.approx(1.0)
    assert_drivable(out, BACK, BODY, region)


def test_a_car_without_reverse_enters_no_dead_end(ring):
    start = Configuration(2.0, 2.0, 0.0)
    place = (7.5, 2.0)
    assert car_out_and_back(BODY, NO_BACK, ring(DEAD_END), start, *place, 0) is None
    goal = Configuration(*place, 0.0)
    assert car_trajectory(BODY, NO_BACK, ring(DEAD_END), start, goal, 0) is not None
    out, back = out_and_back(BACK, ring(DEAD_END), start, *place)
    assert out.end == pytest.approx(goal)
    assert back.end == start
    assert_drivable(back, BACK, BODY, DEAD_END)


def test_no_paths_exist_from_or_to_outside_the_region(ring):
    assert car_out_and_back(BODY, BACK, ring(HALL), Configuration(9.0, 4.0), 5.0, 5.0, 0) is None
    assert car_out_and_back(BODY, BACK, ring(HALL), Configuration(4.0, 4.0), 9.0, 5.0, 0) is None


blocks = st.tuples(
    st.floats(0.0, 7.0), st.floats(0.0, 7.0), st.floats(0.2, 1.5), st.floats(0.2, 1.5)
).map(lambda b: shapely.box(b[0], b[1], b[0] + b[2], b[1] + b[3]))
places = st.tuples(st.floats(0.5, 7.5), st.floats(0.5, 7.5), st.floats(-3.1, 3.1))


@pytest.mark.slow
@settings(max_examples=40)
@given(
    st.lists(blocks, max_size=8),
    st.sampled_from([BODY, DISC]),
    st.sampled_from([BACK, NO_BACK]),
    places,
    places,
    st.integers(0, 2**63),
)
def test_paths_stay_in_the_region(obstacles, body, car, start, goal, seed):
    region = HALL.difference(shapely.union_all(obstacles))
    start, goal = Configuration(*start), Configuration(*goal)
    out_and_back = (
        car_out_and_back(body, car, region, start, goal.x, goal.y, seed, checks=Checks(200)) or ()
    )
    driven = car_trajectory(body, car, region, start, goal, seed, checks=Checks(200))
    for motion in (*out_and_back, *(() if driven is None else (driven,))):
        assert_drivable(motion, car, body, region)
        for time in np.linspace(0.0, motion.duration_s, 100):
            assert region.contains(body.footprint.placed(motion.at(time)).buffer(-1e-3))
    if out_and_back:
        out, back = out_and_back
        assert out.start == start
        assert out.end[:2] == goal[:2]
        assert back.end == pytest.approx(start)
        assert back.start == pytest.approx(out.end)
    if driven is not None:
        assert driven.start == start
        assert driven.end == pytest.approx(goal)


SCRIPT = """
import shapely
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.car import car_trajectory
from multisrt.planners.motion.kinematics import Car

rooms = shapely.from_wkt({wkt!r})
start, goal = Configuration(2.0, 0.6, 0.0), Configuration(6.0, 0.6, 0.0)
body = PlanningBody(Footprint.box(0.6, 0.4), 0.02)
for reverse in (True, False):
    print(repr(car_trajectory(body, Car(reverse=reverse), rooms, start, goal, 7)))
"""


@pytest.mark.slow
def test_sampled_plans_repeat_in_any_process():
    start, goal = Configuration(2.0, 0.6, 0.0), Configuration(6.0, 0.6, 0.0)
    here = [repr(car_trajectory(BODY, car, ROOMS, start, goal, 7)) for car in (BACK, NO_BACK)]
    assert here == [
        repr(car_trajectory(BODY, car, ROOMS, start, goal, 7)) for car in (BACK, NO_BACK)
    ]
    assert here != [
        repr(car_trajectory(BODY, car, ROOMS, start, goal, 8)) for car in (BACK, NO_BACK)
    ]
    script = SCRIPT.format(wkt=ROOMS.wkt)
    there = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert there.stdout.splitlines() == here
