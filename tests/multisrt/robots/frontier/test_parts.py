"""The parts of a robot, each by itself: course, map, fields, targets, bodies, teammates."""

import itertools
import math

import numpy as np
import pytest
import shapely

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Look, Sighting
from multisrt.robots.frontier import fields as fields_module
from multisrt.robots.frontier.bodies import MOVED_M, Bodies, discs_of
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.fields import MAX_FIELDS, DistanceFields, indices_of
from multisrt.robots.frontier.frontiers import Frontiers
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.messages import RobotReport
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.frontier.teammates import Teammates

WIDTH_M = 0.5
DISC = Footprint.parse("disc:0.25")
HALL = shapely.box(0, 0, 20, 6)


def scan_at(x, y, time_s=0.0):
    corners = shapely.get_coordinates(HALL)
    edges = EdgeIndex(np.hstack([corners[:-1], corners[1:]]), 1.5)
    return take_scan(edges, Configuration(x, y, 0.0), time_s, 4.0)


def map_of(*places):
    """A map made of scans of the hall."""
    made = ScanMap(0, Occupancy(0.1, 0.3), "radial", 16)
    for place in places:
        made.add(scan_at(*place))
    return made


def seen_at(x, y, robot=1):
    return Sighting(robot=robot, configuration=Configuration(x, y, 0.0), footprint=DISC)


# Course ----------------------------------------------------------------------------------------


def test_a_course_follows_the_motion_in_progress():
    course = Course(Configuration(0.0, 0.0, 0.0), 10.0)
    assert course.remaining_m() == 0.0
    course.set_goal(Goal(4.0, 0.0, np.array([[0.0, 0.0], [4.0, 0.0]]), 4.0), revision=7)
    assert (course.goal_chosen_s, course.goal_revision) == (10.0, 7)
    course.set_out(Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(4.0, 2.0, 0.0, 0.0))))
    course.time_s = 11.0
    assert course.now_at()[:2] == pytest.approx((0.5, 0.0))
    assert course.remaining_m() == pytest.approx(3.5)
    course.arrive(Configuration(2.0, 0.0, 0.0), 14.0)
    assert course.now_at() == (2.0, 0.0, 0.0)
    assert course.remaining_m() == pytest.approx(2.0)
    course.set_out(Trajectory((Waypoint(0.0, 2.0, 0.0, 0.0), Waypoint(1.0, 2.0, 0.5, 0.0))))
    course.time_s = 15.0
    assert course.remaining_m() == pytest.approx(2.0)
    course.arrive(Configuration(3.5, 0.5, 0.0), 18.0)
    assert course.remaining_m() == pytest.approx(0.5)


# Map -------------------------------------------------------------------------------------------


def test_scans_that_show_nothing_new_make_no_node():
    made = map_of()
    root, again, beyond = (made.add(scan_at(*place)) for place in ((3, 3), (3, 3), (7, 3)))
    assert root.parent is None
    assert again is None
    assert beyond.parent == root.id
    assert made.region.x == 7.0


def test_a_view_leaves_the_map_as_it_is():
    made = map_of((3, 3))
    known = made.raster.revision
    made.view(scan_at(9, 3))
    assert made.raster.revision == known
    assert made.region.x == 9.0
    assert len(made.entries.nodes) == 1


def test_nodes_of_others_are_merged_once():
    nodes = tuple(map_of((3, 3), (7, 3)).entries.nodes.values())
    made = ScanMap(1, Occupancy(0.1, 0.3), "radial", 16)
    assert made.merge(nodes) == tuple(node.id for node in nodes)
    assert made.merge(nodes) == ()
    assert made.raster.is_known(7.0, 3.0)


# Fields ----------------------------------------------------------------------------------------


def test_a_kept_field_is_repaired_as_the_map_grows():
    made = map_of((3, 3), (6, 3))
    fields = DistanceFields(made.raster)
    before = fields.field(3.0, 3.0)
    assert fields.field(3.0, 3.0) is before
    made.add(scan_at(9, 3))
    index = indices_of(made.raster, np.array([[11.0, 3.0]]))
    after, fresh = fields.field(3.0, 3.0), DistanceFields(made.raster).field(3.0, 3.0)
    assert after is not None
    assert fresh is not None
    assert after.distance(index) == pytest.approx(fresh.distance(index), rel=0.03)
    assert math.isfinite(after.distance(index)[0])


def test_only_the_latest_fields_are_kept():
    fields = DistanceFields(map_of((3, 3)).raster)
    for k in range(MAX_FIELDS + 1):
        fields.field(2.0 + 0.1 * k, 3.0)
    assert len(fields._kept) == MAX_FIELDS


def test_large_fields_are_kept_as_far_as_memory_allows(monkeypatch):
    made = map_of((3, 3))
    fields = DistanceFields(made.raster)
    found = [fields.field(2.0 + 0.1 * k, 3.0) for k in range(3)]
    for field in found:
        assert field is not None
        field.distance(indices_of(made.raster, np.array([[3.0, 3.0]])))
    monkeypatch.setattr(
        fields_module, "MAX_BYTES", sum(f.nbytes for f in found[1:] if f is not None)
    )
    assert fields.field(2.2, 3.0) is found[2]
    assert fields.field(2.1, 3.0) is found[1]
    assert len(fields._kept) == 2
    assert fields.field(2.0, 3.0) is not found[0]


def test_a_robot_that_stands_repairs_its_field():
    """With the same bodies in its way; it equals a new one, to the bit."""
    made, here = map_of((3, 3)), (3.02, 3.01)
    raster, fields = made.raster, DistanceFields(made.raster)
    body, no_body = np.array([[4.0, 3.0, 0.4]]), np.empty((0, 3))
    seen = []
    for discs, place in ((body, None), (body, (6, 3)), (body, (4, 2)), (no_body, (8, 4))):
        if place is not None:
            made.add(scan_at(*place))
        with raster.blocked(discs):
            field = fields.own(here, discs.tobytes())
            fresh = fields.begin(here)
            field.complete()
            fresh.complete()
            assert np.array_equal(field.reached(), fresh.reached())
        seen.append(field)
    kept = [one is other for one, other in itertools.pairwise(seen)]
    assert kept == [False, True, False]
    assert fields.own((3.1, 3.0), b"") is not fields.own((3.1, 3.0), b"")


def test_there_is_no_field_far_from_all_passable_cells():
    assert DistanceFields(map_of((3, 3)).raster).field(15.0, 3.0) is None


# Targets ---------------------------------------------------------------------------------------


def frontiers_of(*places):
    made = map_of(*places)
    return Frontiers(made.raster, WIDTH_M), made.raster


def test_there_is_a_target_for_every_group():
    frontiers, _ = frontiers_of((10, 3))
    assert sorted(x > 10 for x, _ in frontiers.targets().tolist()) == [False, True]


def test_a_place_given_up_is_replaced_by_another_of_its_group():
    frontiers, _ = frontiers_of((10, 3))
    target, other = (tuple(place) for place in frontiers.targets().tolist())
    frontiers.give_up(target)
    places = [tuple(place) for place in frontiers.targets().tolist()]
    assert other in places
    assert target not in places
    assert all(math.dist(place, target) > 0.5 * WIDTH_M for place in places)


@pytest.mark.parametrize(("away_m", "stays"), [(0.1, False), (1.0, True)])
def test_a_goal_reached_in_vain_is_given_up_on_the_spot(away_m, stays):
    frontiers, _ = frontiers_of((10, 3))
    x, y = frontiers.targets()[0].tolist()
    frontiers.note_reached((x, y), (x + away_m, y))
    assert frontiers.was_seen_in_vain((x, y))
    assert ([x, y] in frontiers.targets().tolist()) is stays


def test_a_goal_that_is_explored_was_not_reached_in_vain():
    frontiers, _ = frontiers_of((10, 3))
    assert not frontiers.is_frontier(10.0, 3.0)
    frontiers.note_reached((10.0, 3.0), (10.0, 3.0))
    assert not frontiers.was_seen_in_vain((10.0, 3.0))


@pytest.mark.parametrize("blocked", [True, False])
def test_groups_out_of_reach_are_left_out_unless_bodies_bar_them(blocked):
    frontiers, raster = frontiers_of((10, 3))
    with raster.blocked(np.array([[12.5, y, 0.6] for y in np.arange(0.0, 6.1, 0.5)])):
        reach = DistanceFields(raster).begin((10.0, 3.0)).reachable()
        assert not frontiers.look_closer(reach, blocked=blocked)
    right = [x > 10 for x, _ in frontiers.targets().tolist()]
    assert right.count(True) == (1 if blocked else 0)
    assert right.count(False) == 1
    # Once there is a path, the group has a target again.
    reach = DistanceFields(raster).begin((10.0, 3.0)).reachable()
    assert frontiers.look_closer(reach, blocked=False) != blocked
    assert len(frontiers.targets()) == 2


# Bodies ----------------------------------------------------------------------------------------


def look(bodies, *seen):
    steps = bodies.look()
    assert isinstance(next(steps), Look)
    with pytest.raises(StopIteration) as end:
        steps.send(seen)
    return end.value.value


@pytest.mark.parametrize(
    ("seen", "time_s", "stays"),
    [
        ([seen_at(5, 3)], 0.0, True),
        ([seen_at(5 + 2 * MOVED_M, 3)], 0.0, False),
        ([], 0.0, False),
        ([seen_at(5, 3)], 9.0, False),
    ],
    ids=["stands there", "has moved", "is gone", "time is up"],
)
def test_a_body_bars_the_path_while_it_stands_there(seen, time_s, stays):
    course = Course(Configuration(3.0, 3.0, 0.0), 0.0)
    bodies = Bodies(course, map_of((3, 3)))
    bodies.add(seen_at(5, 3), until_s=9.0)
    course.time_s = time_s
    assert look(bodies, *seen) == tuple(seen)
    assert (1 in bodies) is stays


def test_a_body_out_of_sight_still_bars_the_path():
    bodies = Bodies(Course(Configuration(3.0, 3.0, 0.0), 0.0), map_of((3, 3)))
    bodies.add(seen_at(15, 3))
    look(bodies)
    assert bodies.numbers() == [1]


def test_a_robot_that_is_heard_of_is_not_lost():
    bodies = Bodies(Course(Configuration(3.0, 3.0, 0.0), 0.0), map_of((3, 3)))
    bodies.add(seen_at(5, 3))
    bodies.add(seen_at(6, 3, robot=2), until_s=9.0)
    assert not bodies.all_are_lost()
    for robot in (1, 2, 3):
        bodies.note_heard(robot)
    assert bodies.numbers() == [2]


def test_a_lost_robot_is_looked_for_once_until_it_is_heard():
    course = Course(Configuration(3.0, 3.0, 0.0), 0.0)
    bodies = Bodies(course, map_of((3, 3)))
    bodies.add(seen_at(5, 3))
    bodies.add(seen_at(6, 3, robot=2), until_s=99.0)  # it answers
    assert not bodies.seek_lost(15.0)  # seen just now
    course.time_s = 16.0
    assert bodies.seek_lost(15.0)
    assert bodies.numbers() == [2]
    bodies.add(seen_at(5, 3))  # it still stands there
    course.time_s = 40.0
    assert not bodies.seek_lost(15.0)
    assert bodies.numbers() == [2, 1]
    bodies.note_heard(1)
    bodies.add(seen_at(5, 3))
    course.time_s = 60.0
    assert bodies.seek_lost(15.0)


def test_discs_hold_the_bodies():
    assert discs_of([seen_at(5, 3)], 0.1).tolist() == [[5.0, 3.0, 0.35]]
    assert discs_of([]).shape == (0, 3)


# Teammates ---------------------------------------------------------------------------------


def report(robot=1, said=1, time_s=0.0, phase="driving"):
    return RobotReport(
        robot=robot,
        said=said,
        time_s=time_s,
        phase=phase,
        place=(0.0, 0.0, 0.0),
        goal=None,
        remaining_m=0.0,
        path=(),
        footprint="disc:0.25",
        have=(),
    )


def test_the_latest_report_of_each_teammate_counts():
    teammates = Teammates(0, lost_after_s=15.0, relay_for_s=15.0)
    for said in (2, 1):
        teammates.take(report(said=said, time_s=float(said)))
    teammates.take(report(robot=0))
    assert [(r.robot, r.said) for r in teammates.present(5.0)] == [(1, 2)]
    assert teammates.last_heard_s(1) == 2.0
    assert teammates.present(20.0) == []


def test_a_teammate_is_lost_after_long_silence_or_when_it_is_met_and_does_not_answer():
    teammates = Teammates(0, lost_after_s=600.0, relay_for_s=15.0)
    teammates.take(report(said=1, time_s=0.0))
    assert [r.robot for r in teammates.present(600.0)] == [1]
    assert teammates.present(600.1) == []
    assert [r.robot for r in teammates.worth_relaying(15.0)] == [1]
    assert teammates.worth_relaying(15.1) == []
    teammates.note_lost(1, 20.0)
    assert teammates.present(20.0) == []
    teammates.take(report(said=2, time_s=30.0))
    assert [r.said for r in teammates.present(30.0)] == [2]


def test_idle_teammates_are_not_present():
    teammates = Teammates(0, lost_after_s=15.0, relay_for_s=15.0)
    teammates.take(report(phase="idle"))
    assert teammates.present(0.0) == []


def test_a_teammate_is_deaf_until_it_is_heard_of():
    teammates = Teammates(0, lost_after_s=15.0, relay_for_s=15.0)
    teammates.note_deaf(1, 3.0)
    assert teammates.is_deaf(1)
    teammates.take(report(time_s=4.0))
    assert not teammates.is_deaf(1)
    assert not teammates.is_deaf(2)
