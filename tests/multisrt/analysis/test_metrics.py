import cmath
import gc
import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.analysis import clearances
from multisrt.analysis.bounds import lower_bounds
from multisrt.analysis.clearances import smallest_clearance, smallest_distance_between_robots
from multisrt.analysis.coverage import CoverageMeter
from multisrt.analysis.metrics import METRIC_GROUPS, Metrics, measure
from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    Blocked,
    Collision,
    Decision,
    Died,
    Ended,
    Joined,
    Learned,
    MapComplete,
    Motion,
    NodeAdded,
    Organized,
    Sent,
)
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.recording import Recorder, Recording, header_of
from multisrt.run import explore
from multisrt.simulation.worlds import inline
from multisrt.spec import DriveSpec, LateStart, RangeFinderSpec, RobotSpec, RunSpec

HALF = math.pi / 2.0

HALL = Environment("hall", shapely.box(0, 0, 10, 10))


def recorded(
    *events,
    end_s=50.0,
    world=HALL,
    start=(1.0, 1.0, 0.0),
    footprint="disc:0.25",
    range_m=20.0,
) -> Recording:
    robot = RobotSpec(
        start=start, footprint=footprint, range_finder=RangeFinderSpec(range_m=range_m)
    )
    spec = RunSpec(environment=inline(world), robots=(robot,))
    recorder = Recorder(header_of(spec, world, (Configuration(*start),)))
    for event in events:
        recorder.record(event)
    return recorder.finish(end_s, "complete", "")


def seen(
    time_s: float, polygon: shapely.Polygon, stage: str = "draw", serial: int = 0, robot: int = 0
):
    corners = tuple(shapely.orient_polygons(polygon).exterior.coords)[:-1]
    return NodeAdded(
        time_s=time_s,
        robot=robot,
        serial=serial,
        parent=None,
        configuration=(1.0, 1.0, 0.0),
        stage=stage,
        boundary=corners,
        tags="0" * len(corners),
    )


def moved(*waypoints, robot: int = 0) -> Motion:
    return Motion(time_s=waypoints[0][0], robot=robot, waypoints=waypoints)


def team(*events, starts, end_s=50.0, footprints=None, faults=(), world=HALL) -> Recording:
    """A recording of a team in the hall, all of which is seen from anywhere."""
    robots = tuple(
        RobotSpec(start=start, footprint=body, range_finder=RangeFinderSpec(range_m=20.0))
        for start, body in zip(starts, footprints or ["disc:0.25"] * len(starts), strict=True)
    )
    spec = RunSpec(environment=inline(world), robots=robots, faults=faults)
    recorder = Recorder(header_of(spec, world, tuple(Configuration(*start) for start in starts)))
    for event in events:
        recorder.record(event)
    return recorder.finish(end_s, "complete", "")


# The hall is 100 columns of cells wide. The known part grows from the left.
GROWING = (
    seen(0.0, shapely.box(0, 0, 5, 10), "root"),
    seen(10.0, shapely.box(0, 0, 9.2, 10), serial=1),
    seen(30.0, shapely.box(4, 0, 9.6, 10), "approach", serial=2),
    seen(40.0, shapely.box(9, 0, 10, 10), "complete", serial=3),
)


def test_shares_and_times_of_coverage():
    metrics = measure(recorded(*GROWING), HALL)
    assert metrics.coverage == 1.0
    assert metrics.free_area_m2 == 100.0
    assert metrics.explorable_area_m2 == pytest.approx(100.0)
    assert metrics.covered_area_m2 == pytest.approx(100.0)
    assert (metrics.time_to_90_s, metrics.time_to_95_s, metrics.time_to_99_s) == (10.0, 30.0, 40.0)
    # Half is missing for 10 s, then 8 % for 20 s, then 4 % for 10 s.
    assert metrics.coverage_integral_s == pytest.approx(5.0 + 1.6 + 0.4)
    assert metrics.makespan_s == 50.0


def test_shares_that_are_never_covered_have_no_time():
    metrics = measure(recorded(*GROWING[:2]), HALL)
    assert metrics.coverage == pytest.approx(0.92)
    assert (metrics.time_to_90_s, metrics.time_to_95_s, metrics.time_to_99_s) == (10.0, None, None)
    assert metrics.coverage_integral_s == pytest.approx(5.0 + 0.08 * 40.0)


def test_a_run_that_saw_nothing():
    metrics = measure(recorded(end_s=3.0), HALL)
    assert metrics.coverage == 0.0
    assert metrics.coverage_integral_s == 3.0
    assert metrics.nodes == 0
    assert metrics.exploration_time_s is None
    assert metrics.total_distance_m == 0.0


def test_cells_count_once_and_cells_outside_never():
    twice = seen(0.0, shapely.box(0, 0, 5, 10)), seen(1.0, shapely.box(0, 0, 5, 10))
    assert measure(recorded(*twice), HALL).coverage == 0.5
    outside = seen(0.0, shapely.box(-50, -50, 5, 50))
    assert measure(recorded(outside), HALL).coverage == 0.5


def test_coverage_is_relative_to_what_the_body_can_see():
    rooms = Environment("rooms", shapely.union(HALL.free, shapely.box(10.5, 0, 14.5, 10)))
    metrics = measure(recorded(*GROWING, world=rooms), rooms)
    assert metrics.coverage == 1.0
    assert metrics.free_area_m2 == pytest.approx(140.0)
    assert metrics.explorable_area_m2 == pytest.approx(100.0)


def test_one_scan_of_a_small_room_covers_it():
    run = explore(Environment("closet", shapely.box(0, 0, 3, 2)), start=(1.5, 1.0))
    assert run.metrics.coverage == 1.0
    assert run.metrics.nodes == 1
    assert run.metrics.exploration_time_s == 0.0
    assert run.metrics.makespan_s == 0.0
    assert run.metrics.time_to_99_s == 0.0
    assert run.metrics.coverage_integral_s == 0.0
    assert run.metrics.total_distance_m == 0.0
    assert run.metrics.smallest_clearance_m == pytest.approx(0.75)


def test_counts():
    arc = ((0.0, 0.0, 3.0, 4.0),)
    left = ((0.0, 0.0, 0.0, 2.0), (0.0, 2.0, 1.5, 2.0))
    decision = Decision(time_s=0.0, robot=0, node=(0, 0), frontier_m=1.0, choice="end", target=None)
    metrics = measure(
        recorded(
            *GROWING,
            decision,
            decision,
            ArcClosed(time_s=1.0, robot=0, node=(0, 0), reason="too narrow", arc=arc),
            ArcClosed(time_s=1.0, robot=0, node=(0, 0), reason="not reachable", arc=arc),
            ArcClosed(time_s=1.0, robot=0, node=(0, 0), reason="too narrow", arc=arc),
            MapComplete(time_s=41.0, robot=0),
            MapComplete(time_s=42.0, robot=0),
            Collision(time_s=42.0, robot=0, configuration=(0.0, 0.0, 0.0), account=""),
            Ended(time_s=45.0, robot=0, reason="", complete=True, frontier=left),
        ),
        HALL,
    )
    assert metrics.nodes == 4
    assert metrics.nodes_by_stage == {"approach": 1, "complete": 1, "draw": 1, "root": 1}
    assert metrics.decisions == 2
    assert metrics.arcs_closed == {"not reachable": 1, "too narrow": 2}
    assert metrics.collisions == 1
    assert metrics.exploration_time_s == 41.0
    assert metrics.frontier_left_m == 3.5


def test_distances():
    there = moved((0, 1.0, 1.0, 0.0), (6, 4.0, 1.0, 0.0), (7, 4.0, 1.0, 1.0), (9, 4.0, 5.0, 1.0))
    back = moved((9, 4.0, 5.0, 1.0), (12, 1.0, 1.0, 1.0))
    metrics = measure(recorded(there, back), HALL)
    assert metrics.total_distance_m == 3.0 + 4.0 + 5.0
    assert metrics.distance_by_robot_m == (12.0,)


@pytest.mark.parametrize(
    ("footprint", "start", "motions", "clearance"),
    [
        # A disc stands, drives along a wall and comes near to another at the end.
        ("disc:0.25", (1.0, 2.0), [], 0.75),
        ("disc:0.25", (3.0, 1.0), [((0, 3.0, 1.0, 0), (9, 6.0, 1.0, 0))], 0.75),
        ("disc:0.25", (3.0, 1.0), [((0, 3.0, 1.0, 0), (9, 9.5, 1.0, 0))], 0.25),
        # A box of 0.6 x 0.4 m along the wall and across it.
        ("box:0.6x0.4", (3.0, 0.5), [((0, 3.0, 0.5, 0), (9, 6.0, 0.5, 0))], 0.3),
        ("box:0.6x0.4", (3.0, 5.0), [((0, 3.0, 5.0, 0), (9, 9.0, 5.0, 0))], 0.7),
        # Turning, its corners come to hypot(0.3, 0.2) = 0.3606 m of the centre.
        (
            "box:0.6x0.4",
            (3.0, 0.5),
            [((0, 3.0, 0.5, 0), (1, 3.0, 0.5, math.pi))],
            0.5 - math.hypot(0.3, 0.2),
        ),
        # A half circle of 2 m about (5, 3), from its left end over its lowest point.
        ("disc:0.25", (3.0, 3.0), [((0, 3.0, 3.0, -HALF), (9, 7.0, 3.0, HALF))], 0.75),
        # A quarter of it: the hind corner swings out, 2.2 and 0.3 m from the circle's centre.
        (
            "box:0.6x0.4",
            (3.0, 3.0),
            [((0, 3.0, 3.0, -HALF), (9, 5.0, 1.0, 0.0))],
            1.0 - (math.hypot(2.2, 0.3) - 2.0),
        ),
        # Driven backwards and clockwise, with the corners of the box outermost.
        (
            "box:0.6x0.4",
            (3.0, 3.0),
            [((0, 3.0, 3.0, HALF), (9, 7.0, 3.0, 3 * HALF))],
            1.0 - (math.hypot(2.2, 0.3) - 2.0),
        ),
        # Not convex: an L whose long arm points out of the circle.
        (
            "polygon:-0.1,-0.1 0.1,-0.1 0.1,0.1 0.6,0.1 0.6,0.2 -0.1,0.2",
            (3.0, 3.0),
            [((0, 3.0, 3.0, math.pi), (9, 7.0, 3.0, 2 * math.pi))],
            1.0 - (math.hypot(2.6, 0.2) - 2.0),
        ),
    ],
)
def test_smallest_clearance(footprint, start, motions, clearance):
    recording = recorded(*(moved(*w) for w in motions), footprint=footprint, start=(*start, 0.0))
    assert smallest_clearance(recording, HALL) == pytest.approx(clearance, abs=1e-4)
    assert measure(recording, HALL).smallest_clearance_m == pytest.approx(clearance, abs=1e-4)


def test_the_clearance_of_a_body_that_touched():
    into = moved((0, 1.0, 1.0, 0.0), (2, 1.0, 0.1, 0.0))
    assert smallest_clearance(recorded(into), HALL) == pytest.approx(0.1 - 0.25)


def test_the_least_clearance_of_any_robot_counts():
    # The large one keeps off by 0.4 m, the box by 0.3 m, and the small one by 0.2 m.
    bodies = {(1.9, 5.0): "disc:1.5", (5.0, 0.5): "box:0.6x0.4", (9.0, 5.0): "disc:0.1"}
    there = moved((0, 9.0, 5.0, 0.0), (2, 9.7, 5.0, 0.0), robot=2)
    assert clearance_of_team(bodies, there) == pytest.approx(0.2)
    assert clearance_of_team(bodies) == pytest.approx(0.3)
    # A body 1 m inside a wall counts more than one that touches it.
    into = moved((0, 1.9, 5.0, 0.0), (2, 0.5, 5.0, 0.0), robot=0)
    touching = moved((0, 9.0, 5.0, 0.0), (2, 10.0, 5.0, 0.0), robot=2)
    assert clearance_of_team(bodies, into, touching) == pytest.approx(-1.0)


def clearance_of_team(bodies, *motions):
    starts = [(*start, 0.0) for start in bodies]
    return smallest_clearance(team(*motions, starts=starts, footprints=[*bodies.values()]), HALL)


def bounds(world, *, start=(1.0, 0.5, 0.0), speed=0.5, range_m=4.0):
    robot = RobotSpec(
        start=start,
        drive=DriveSpec(speed_m_s=speed),
        range_finder=RangeFinderSpec(range_m=range_m),
    )
    spec = RunSpec(environment=inline(world), robots=(robot,))
    starts = (Configuration(*start),)
    meter = CoverageMeter(spec, world, starts)
    return lower_bounds(spec, meter.explorable, starts)


def test_lower_bounds_in_a_corridor():
    # The far end is 19 m away, 15 m of which have to be driven, at half a metre a second.
    reach, area = bounds(Environment("corridor", shapely.box(0, 0, 20, 1)))
    assert 0.97 * 30.0 <= reach <= 30.0
    assert area == 0.0


def test_lower_bounds_in_a_hall():
    # 400 m2, of which a disc of 4 m is seen at once; the rest in a swath 8 m wide.
    reach, area = bounds(Environment("hall", shapely.box(0, 0, 20, 20)), start=(10.0, 10.0, 0.0))
    assert area == pytest.approx((400.0 - 16.0 * math.pi) / (8.0 * 0.5), rel=0.01)
    assert reach == pytest.approx((math.hypot(10, 10) - 4.0) / 0.5, rel=0.03)
    assert reach <= (math.hypot(10, 10) - 4.0) / 0.5


def test_lower_bounds_fall_with_speed_and_range():
    hall = Environment("hall", shapely.box(0, 0, 20, 20))
    slow, fast = bounds(hall, speed=0.5), bounds(hall, speed=1.0)
    assert slow == pytest.approx((2.0 * fast[0], 2.0 * fast[1]))
    assert bounds(hall, range_m=40.0) == (0.0, 0.0)


def test_the_larger_bound_is_the_bound():
    hall = Environment("hall", shapely.box(0, 0, 20, 20), starts=[(10.0, 10.0)])
    metrics = explore(hall, seed=1).metrics
    assert metrics.lower_bound_s == max(metrics.lower_bound_reach_s, metrics.lower_bound_area_s)
    assert metrics.exploration_time_s > metrics.lower_bound_s > 0.0


ARC = ((0.0, 3.0, 3.0, -HALF), (9.0, 7.0, 3.0, HALF))


def test_distance_along_arcs_and_in_place():
    assert measure(recorded(moved(*ARC)), HALL).total_distance_m == pytest.approx(2.0 * math.pi)
    whole_turn = moved((0, 3.0, 3.0, 0.0), (9, 3.0, 3.0, 2.0 * math.pi))
    assert measure(recorded(whole_turn), HALL).total_distance_m == 0.0


def test_distances_of_a_team_and_their_spread():
    metrics = measure(
        team(
            moved((0, 1.0, 1.0, 0.0), (2, 2.0, 1.0, 0.0)),
            moved((0, 1.0, 5.0, 0.0), (2, 4.0, 5.0, 0.0), robot=1),
            moved((3, 4.0, 5.0, 0.0), (5, 6.0, 5.0, 0.0), robot=1),
            starts=[(1.0, 1.0, 0.0), (1.0, 5.0, 0.0), (1.0, 9.0, 0.0)],
        ),
        HALL,
    )
    assert metrics.distance_by_robot_m == (1.0, 5.0, 0.0)
    assert metrics.total_distance_m == 6.0
    assert metrics.distance_spread_m == pytest.approx(math.sqrt((1.0 + 9.0 + 4.0) / 3.0))


def ended(time_s: float, robot: int) -> Ended:
    return Ended(time_s=time_s, robot=robot, reason="", complete=True, frontier=())


def died(time_s: float, robot: int) -> Died:
    return Died(time_s=time_s, robot=robot, configuration=(1.0, 1.0, 0.0), doing="waiting")


def test_waiting():
    starts = [(1.0, y, 0.0) for y in (1.0, 3.0, 5.0, 7.0, 9.0)]
    metrics = measure(
        team(
            # Robot 0 drives from 10 to 12 and stands within that motion from 11 to 11.5; it is
            # done at 20, and again at 30 after a turn of 4 s.
            moved((10, 1, 1, 0), (11, 2, 1, 0), (11.5, 2, 1, 0), (12, 2.5, 1, 0)),
            ended(20.0, 0),
            moved((22, 2.5, 1, 0), (26, 2.5, 1, 3)),
            ended(30.0, 0),
            # Robot 1 never ends; robot 2 dies at 8, having driven from 1 to 3.
            moved((1, 1, 5, 0), (3, 2, 5, 0), robot=2),
            died(8.0, 2),
            # Robot 3 joins at 20 and is done at 45; robot 4 never joins.
            Joined(time_s=20.0, robot=3),
            ended(45.0, 3),
            starts=starts,
            faults=(LateStart(robot=3, time_s=20.0), LateStart(robot=4, time_s=60.0)),
        ),
        HALL,
    )
    assert metrics.waiting_time_by_robot_s == (30.0 - 1.5 - 4.0, 50.0, 6.0, 25.0, 0.0)
    assert metrics.waiting_time_s == pytest.approx(24.5 + 50.0 + 6.0 + 25.0)
    assert metrics.deaths == 1


def test_the_overlap_is_the_area_seen_by_several_robots():
    starts = [(1.0, 1.0, 0.0), (1.0, 5.0, 0.0), (1.0, 9.0, 0.0)]
    metrics = measure(
        team(
            seen(0.0, shapely.box(0, 0, 5, 10), "root"),
            seen(1.0, shapely.box(0, 0, 5, 10), serial=1),  # its own, again: no overlap
            seen(0.0, shapely.box(4, 0, 7, 10), "root", robot=1),
            seen(0.0, shapely.box(4, 0, 5, 5), "root", robot=2),  # a third one adds nothing
            seen(1.0, shapely.box(6, 0, 8, 20), serial=1, robot=2),  # partly outside
            starts=starts,
        ),
        HALL,
    )
    assert metrics.covered_area_m2 == pytest.approx(80.0)
    assert metrics.unseen_m2 == pytest.approx(20.0)
    assert metrics.overlap_area_m2 == pytest.approx(10.0 + 10.0)
    assert metrics.overlap_share == pytest.approx(0.25)
    assert metrics.coverage_integral_s == pytest.approx(0.3 * 1.0 + 0.2 * 49.0)


def test_a_single_robot_has_no_overlap():
    metrics = measure(recorded(*GROWING), HALL)
    assert (metrics.overlap_area_m2, metrics.overlap_share) == (0.0, 0.0)
    assert metrics.smallest_distance_between_robots_m is None
    assert (metrics.lost_area_m2, metrics.lost_area_by_robot_m2) == (0.0, (0.0,))
    assert measure(recorded(end_s=3.0), HALL).overlap_share == 0.0


def test_area_is_lost_with_robots_that_die():
    starts = [(1.0, y, 0.0) for y in (1.0, 4.0, 7.0, 9.0)]
    story = (
        seen(0.0, shapely.box(0, 0, 1, 10), "root"),
        # Robot 1 passes on one node of three; robot 0 sees a part of another for itself.
        seen(0.0, shapely.box(1, 0, 3, 10), "root", robot=1),
        seen(1.0, shapely.box(3, 0, 5, 10), serial=1, robot=1),
        seen(2.0, shapely.box(5, 0, 6, 10), serial=2, robot=1),
        Learned(time_s=2.0, robot=0, nodes=((1, 0),)),
        seen(3.0, shapely.box(3, 0, 4, 10), serial=1),
        # Robot 2 tells robot 1 alone, which dies, too; both saw the strip from 5 to 6.
        seen(3.0, shapely.box(5, 0, 8, 10), "root", robot=2),
        Learned(time_s=4.0, robot=1, nodes=((2, 0),)),
        died(5.0, 1),
        died(6.0, 2),
        seen(7.0, shapely.box(9, 0, 10, 10), "root", robot=3),
    )
    metrics = measure(team(*story, starts=starts), HALL)
    assert metrics.lost_area_by_robot_m2 == pytest.approx((0.0, 20.0, 30.0, 0.0))
    assert metrics.lost_area_m2 == pytest.approx(40.0)
    assert metrics.deaths == 2
    # What a survivor has learned is not lost, although the other ones do not know it.
    told = Learned(time_s=49.0, robot=3, nodes=((2, 0),))
    metrics = measure(team(*story, told, starts=starts), HALL)
    assert metrics.lost_area_by_robot_m2 == pytest.approx((0.0, 10.0, 0.0, 0.0))
    assert metrics.lost_area_m2 == pytest.approx(10.0)


def test_when_all_die_all_is_lost():
    starts = [(1.0, 1.0, 0.0), (1.0, 4.0, 0.0)]
    story = (seen(0.0, shapely.box(0, 0, 4, 10), "root"), died(5.0, 0), died(5.0, 1))
    metrics = measure(team(*story, starts=starts), HALL)
    assert metrics.lost_area_m2 == pytest.approx(40.0)
    assert metrics.lost_area_by_robot_m2 == pytest.approx((40.0, 0.0))


def sent(robot: int, kind: str, size: int, reached=(), lost=()) -> Sent:
    return Sent(time_s=1.0, robot=robot, kind=kind, size_bytes=size, reached=reached, lost=lost)


def test_messages_and_events_are_counted():
    def organized(deadlock: bool) -> Organized:
        return Organized(
            time_s=1.0,
            robot=1,
            feasible=(0,),
            unfeasible=(1,),
            before={},
            after={},
            orders={},
            conflicts=(),
            deadlock=deadlock,
        )

    blocked = Blocked(time_s=1.0, robot=0, by=1, configuration=(1.0, 1.0, 0.0))
    metrics = measure(
        team(
            sent(0, "hello", 10, reached=(1, 2)),
            sent(1, "map", 500, reached=(0,), lost=(2,)),
            sent(2, "map", 300),
            organized(False),
            organized(True),
            blocked,
            MapComplete(time_s=9.0, robot=2),
            MapComplete(time_s=7.0, robot=1),
            starts=[(1.0, 1.0, 0.0), (1.0, 5.0, 0.0), (1.0, 9.0, 0.0)],
        ),
        HALL,
    )
    assert metrics.messages == 3
    assert metrics.deliveries == 3
    assert metrics.lost_deliveries == 1
    assert metrics.bytes_sent == 810
    assert metrics.messages_by_kind == {"hello": 1, "map": 2}
    assert metrics.bytes_by_kind == {"hello": 10, "map": 800}
    assert (metrics.coordinations, metrics.deadlocks, metrics.protective_stops) == (2, 1, 1)
    assert metrics.exploration_time_s == 7.0


def test_the_reach_of_a_team_is_from_the_nearest_start():
    corridor = Environment("corridor", shapely.box(0, 0, 20, 1))
    spec = RunSpec(
        environment=inline(corridor),
        robots=(
            RobotSpec(range_finder=RangeFinderSpec(range_m=2.0)),
            RobotSpec(drive=DriveSpec(speed_m_s=1.0), range_finder=RangeFinderSpec(range_m=4.0)),
        ),
    )
    starts = Configuration(0.5, 0.5), Configuration(14.0, 0.5)
    meter = CoverageMeter(spec, corridor, starts)
    reach, _ = lower_bounds(spec, meter.explorable, starts)
    # The middle is 6.75 m from both; it comes into the longer range after 2.75 m.
    assert 0.9 * 2.75 <= reach <= 2.75


def approach(*events, starts, footprints=None, end_s=50.0) -> float:
    recording = team(*events, starts=starts, footprints=footprints, end_s=end_s)
    distance = smallest_distance_between_robots(recording)
    assert distance is not None
    return distance


def test_robots_that_stand():
    starts = [(1.0, 1.0, 0.0), (4.0, 5.0, 0.0), (9.0, 9.0, 0.0)]
    assert approach(starts=starts) == pytest.approx(4.5)
    assert approach(starts=starts, end_s=0.0) == pytest.approx(4.5)


def test_robots_that_drive_past_each_other():
    # Nearest at 4 s, between all waypoints: 1 m apart.
    there = moved((0, 1, 1, 0), (8, 9, 1, 0))
    back = moved((0, 9, 2, 0), (8, 1, 2, 0), robot=1)
    starts = [(1.0, 1.0, 0.0), (9.0, 2.0, 0.0)]
    assert approach(there, back, starts=starts) == pytest.approx(0.5, abs=1e-12)
    boxes = ["box:0.6x0.4", "box:0.6x0.4"]
    assert approach(there, back, starts=starts, footprints=boxes) == pytest.approx(0.6, abs=1e-4)


def test_paths_that_cross_at_different_times_are_no_approach():
    # Both come through (5, 5); the second when the first has stood at (9, 5) for a while.
    one = moved((0, 1, 5, 0), (8, 9, 5, 0))
    two = moved((20, 5, 1, 0), (28, 5, 9, 0), robot=1)
    starts = [(1.0, 5.0, 0.0), (5.0, 1.0, 0.0)]
    assert approach(one, two, starts=starts) == pytest.approx(4.0 - 0.5)
    # Before that, when the first came by the waiting second, they were 4 m apart as well.
    early = moved((4, 5, 1, 0), (12, 5, 9, 0), robot=1)
    assert approach(one, early, starts=starts) == pytest.approx(math.sqrt(8.0) - 0.5)


def test_bodies_that_touch_have_no_distance():
    into = moved((0, 1, 1, 0), (4, 5, 1, 0))
    assert approach(into, starts=[(1.0, 1.0, 0.0), (5.0, 1.0, 0.0)]) == 0.0


def test_a_turning_box_and_one_on_an_arc():
    # Its corner points at the disc after 45 degrees or so, for a moment.
    turn = moved((0, 5, 5, 0), (4, 5, 5, math.pi))
    starts = [(5.0, 5.0, 0.0), (5.0, 6.0, 0.0)]
    corner = math.hypot(0.3, 0.2)
    bodies = ["box:0.6x0.4", "disc:0.25"]
    assert approach(turn, starts=starts, footprints=bodies) == pytest.approx(
        0.75 - corner, abs=2e-4
    )
    # The lowest point of the half circle is (5, 1); a disc stands 0.7 m below it.
    starts = [(3.0, 3.0, -HALF), (5.0, 0.3, 0.0)]
    assert approach(moved(*ARC), starts=starts) == pytest.approx(0.2, abs=2e-4)


@st.composite
def stories(draw) -> Recording:
    """Two robots of any bodies that drive, turn and follow arcs at random."""
    bodies = draw(
        st.lists(
            st.sampled_from(["disc:0.25", "box:0.6x0.4", "polygon:-0.2,-0.1 0.3,0 -0.2,0.1"]),
            min_size=2,
            max_size=2,
        )
    )
    places = st.floats(1.0, 9.0)
    events, starts = [], []
    for robot in range(2):
        here = [draw(st.floats(0.0, 3.0)), draw(places), draw(places), draw(st.floats(-3.0, 3.0))]
        starts.append(tuple(here[1:]))
        for _ in range(draw(st.integers(0, 3))):
            waypoints = [tuple(here)]
            for kind in draw(st.lists(st.sampled_from(["drive", "turn", "arc"]), max_size=3)):
                here[0] += draw(st.floats(0.5, 6.0))
                if kind != "turn":
                    here[1], here[2] = draw(places), draw(places)
                if kind != "drive":
                    here[3] += draw(st.floats(-3.0, 3.0))
                waypoints.append(tuple(here))
            events.append(moved(*waypoints, robot=robot))
            here[0] += draw(st.floats(0.0, 3.0))
    return team(*events, starts=starts, footprints=bodies, end_s=70.0)


def by_dense_sampling(recording: Recording, steps: int) -> float:
    """The distance at many moments, each leg followed by turning its velocity step by step."""
    times = np.linspace(0.0, recording.footer.time_s, steps)
    outlines = []
    for robot, spec in enumerate(recording.spec.robots):
        poses = np.tile(recording.header.starts[robot], (steps, 1))
        for motion in recording.events:
            if motion.robot != robot:
                continue
            for a, b in itertools.pairwise(motion.waypoints):
                within = times >= a[0]
                share = np.clip((times[within] - a[0]) / (b[0] - a[0]), 0.0, 1.0)
                poses[within] = [on_leg(np.array(a[1:]), np.array(b[1:]), s) for s in share]
        body = Footprint.parse(spec.footprint)
        outlines.append([body.placed(pose) for pose in poses])
    return float(shapely.distance(*map(np.array, outlines)).min())


def on_leg(a: np.ndarray, b: np.ndarray, share: float) -> np.ndarray:
    """By the centre of rotation, which the method does not use."""
    turn = b[2] - a[2]
    if abs(turn) < 1e-6 or (a[:2] == b[:2]).all():
        return a + share * (b - a)
    start, end = complex(*a[:2]), complex(*b[:2])
    rotation = cmath.exp(1j * turn)
    centre = (end - rotation * start) / (1.0 - rotation)
    here = centre + cmath.exp(1j * turn * share) * (start - centre)
    return np.array([here.real, here.imag, a[2] + share * turn])


@given(stories())
@settings(max_examples=25)
def test_the_smallest_distance_is_that_of_dense_sampling(recording):
    found = smallest_distance_between_robots(recording)
    sampled = by_dense_sampling(recording, 1500)
    # Between two samples bodies come nearer by no more than their speeds allow.
    fastest = 2.0 * (fastest_point(recording)) * 70.0 / 1500
    assert sampled - fastest - 2e-4 <= found <= sampled + 2e-4


def fastest_point(recording: Recording) -> float:
    speeds = [0.0]
    for motion in recording.events:
        for a, b in itertools.pairwise(motion.waypoints):
            turn = abs(b[3] - a[3])
            chord = math.dist(a[1:3], b[1:3])
            arc = chord if turn < 1e-6 else chord * turn / 2.0 / math.sin(turn / 2.0)
            speeds.append((arc + 0.4 * turn) / (b[0] - a[0]))
    return max(speeds)


def test_tracks_are_computed_once_and_live_with_the_recording():
    gc.collect()
    before = len(clearances._TRACKS)
    recording = team(starts=[(1.0, 1.0, 0.0), (3.0, 1.0, 0.0)])
    assert clearances.tracks(recording) is clearances.tracks(recording)
    assert len(clearances._TRACKS) == before + 1
    del recording
    gc.collect()
    assert len(clearances._TRACKS) == before


def test_every_metric_is_in_one_group():
    grouped = [name for names in METRIC_GROUPS.values() for name in names]
    assert sorted(grouped) == sorted(Metrics.__struct_fields__)
