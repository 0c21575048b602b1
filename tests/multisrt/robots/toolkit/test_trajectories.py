import math

import numpy as np
import pytest
import shapely

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic
from multisrt.planners.motion.sweep import Sweep
from multisrt.robots.toolkit import places_of, trajectory, trajectory_inside
from multisrt.testing.motion_rules import trajectory_flaw

START = Configuration(1.0, 1.0, 0.3)
DRIVES = [Holonomic(), Differential(), Car(), Car(reverse=False)]
FORMS = [
    [(3.0, 1.0), (3.0, 4.0)],
    ((3.0, 1.0), (3.0, 4.0)),
    np.array([[3.0, 1.0], [3.0, 4.0]]),
    np.array([[3, 1], [3, 4]]),
    np.array([[3.0, 1.0, 9.0], [3.0, 4.0, 9.0]], np.float32),
    [np.array([3.0, 1.0]), np.array([3.0, 4.0, 0.5])],
    [Configuration(3.0, 1.0), (np.float64(3.0), 4)],
]


@pytest.mark.parametrize("places", FORMS)
def test_places_are_taken_in_any_form(places):
    assert places_of(places).tolist() == [[3.0, 1.0], [3.0, 4.0]]
    assert trajectory(Holonomic(), START, places).waypoints == (
        trajectory(Holonomic(), START, FORMS[0]).waypoints
    )


@pytest.mark.parametrize(
    "one", [(3, 4), [3.0, 4.0], np.array([3.0, 4.0, 1.0]), Configuration(3, 4)]
)
def test_a_single_place_is_taken_in_any_form(one):
    assert places_of(one).tolist() == [[3.0, 4.0]]
    assert trajectory(Differential(), START, one).end[:2] == (3.0, 4.0)


@pytest.mark.parametrize(
    "wrong",
    [3.0, "here", [(1.0,)], np.zeros((2, 4)), np.zeros((2, 2, 2)), [(1.0, "x")], {1: 2}, None],
)
def test_what_is_no_place_is_refused(wrong):
    with pytest.raises(InvalidInputError, match="give x, y of one place"):
        places_of(wrong)


def test_the_place_that_is_not_finite_is_named():
    with pytest.raises(InvalidInputError, match=r"goals\[1\] is \(2, inf\)"):
        places_of([(1.0, 2.0), (2.0, math.inf)], "goals")


@pytest.mark.parametrize("drive", DRIVES)
def test_every_drive_can_follow(drive):
    places = [(3.0, 1.0), (3.0, 4.0), (3.0, 4.0), (1.0, 1.0)]
    motion = trajectory(drive, START, places)
    assert trajectory_flaw(motion, START, drive) is None
    passed = motion.points()
    for place in places:
        assert np.hypot(*(passed - place).T).min() < 1e-6
    assert motion.end[:2] == places[-1]


@pytest.mark.parametrize("drive", DRIVES)
def test_nowhere_to_go_is_a_single_waypoint(drive):
    assert len(trajectory(drive, START, []).waypoints) == 1
    assert trajectory(drive, START, START).length_m == 0.0


@pytest.mark.parametrize("drive", DRIVES[1:])
def test_headings_are_taken_where_they_are_asked_for(drive):
    motion = trajectory(drive, START, [(4.0, 2.0, 2.0)], headings=True)
    assert motion.end.heading == pytest.approx(2.0)
    assert trajectory_flaw(motion, START, drive) is None


def test_headings_that_cannot_be_taken_are_refused(robot):
    with pytest.raises(InvalidInputError, match="a holonomic body"):
        trajectory(Holonomic(), START, (1.0, 2.0, 3.0), headings=True)
    with pytest.raises(InvalidInputError, match="no headings"):
        trajectory(Differential(), START, (1.0, 2.0), headings=True)
    with pytest.raises(InvalidInputError, match="a differential body"):
        trajectory_inside(robot(), START, (1.0, 2.0, 3.0), shapely.box(0, 0, 9, 9), headings=True)


ROOM = shapely.box(0.0, 0.0, 8.0, 6.0).difference(shapely.box(3.9, 0.0, 4.1, 3.0))
AROUND = [(2.0, 4.5), (6.0, 4.5), (6.0, 1.5)]


@pytest.mark.parametrize("shape", ["disc:0.25", "box:0.6x0.4"])
@pytest.mark.parametrize("drive", DRIVES)
def test_motions_inside_a_region_stay_in_it(robot, drive, shape):
    me = robot(kinematics=drive, footprint=Footprint.parse(shape))
    start = Configuration(2.0, 1.5, 1.57)
    motion = trajectory_inside(me, start, AROUND, ROOM)
    assert motion is not None
    assert trajectory_flaw(motion, start, drive) is None
    assert motion.end[:2] == AROUND[-1]
    sweep = Sweep(me.footprint, motion)
    assert ROOM.buffer(1e-6).contains(sweep.shape.buffer(sweep.pad_m - 0.005))


@pytest.mark.parametrize("drive", DRIVES[:2])
def test_a_path_out_of_the_region_ends_before_its_border(robot, drive):
    me = robot(kinematics=drive)
    motion = trajectory_inside(me, START, [(3.0, 1.0), (30.0, 1.0)], ROOM)
    assert motion is not None
    assert motion.end.x == pytest.approx(3.9 - 0.25 - 0.01, abs=1e-6)
    limited = trajectory_inside(me, START, [(3.0, 1.0), (30.0, 1.0)], ROOM, limit_m=0.5)
    assert limited is not None
    assert limited.length_m == pytest.approx(0.5)


def test_a_car_ends_at_the_last_place_that_it_can_reach(robot):
    me = robot(kinematics=Car())
    start = Configuration(1.0, 4.5, 0.0)
    motion = trajectory_inside(me, start, [(6.0, 4.5), (30.0, 4.5)], ROOM)
    assert motion is not None
    assert motion.end[:2] == (6.0, 4.5)
    assert trajectory_inside(me, start, [(30.0, 4.5)], ROOM) is None


def test_a_region_is_given_in_any_form(robot, hall):
    me = robot()
    region = local_safe_region(hall(10.0, 1.5), "radial")
    motions = [
        trajectory_inside(me, me.start, (30.0, 1.5), form)
        for form in (region, region.boundary, region.polygon())
    ]
    assert [motion.end.x for motion in motions if motion is not None] == pytest.approx(
        [14.0 - 0.26] * 3, abs=0.05
    )


def test_no_place_to_go_to_is_told(robot):
    with pytest.raises(InvalidInputError, match="no place to go to"):
        trajectory_inside(robot(), START, [], ROOM)


def test_a_region_with_a_hole_is_for_cars_alone(robot):
    holed = shapely.box(0, 0, 8, 6).difference(shapely.box(3, 2, 4, 3))
    with pytest.raises(InvalidInputError, match="without holes"):
        trajectory_inside(robot(), START, (7.0, 5.0), holed)
    motion = trajectory_inside(robot(kinematics=Car()), START, (7.0, 5.0), holed)
    assert motion is not None
    assert motion.end[:2] == (7.0, 5.0)
    with pytest.raises(InvalidInputError, match="at least 3 finite corners"):
        trajectory_inside(robot(), START, (7.0, 5.0), np.zeros((2, 2)))
