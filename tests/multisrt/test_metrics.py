import math

import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    Collision,
    Decision,
    Ended,
    MapComplete,
    Motion,
    NodeAdded,
)
from multisrt.geometry.configuration import Configuration
from multisrt.metrics import CoverageMeter, lower_bounds, measure, smallest_clearance
from multisrt.recording import Recorder, Recording, header_of
from multisrt.run import explore
from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec, RunSpec, inline

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


def seen(time_s: float, polygon: shapely.Polygon, stage: str = "draw", serial: int = 0):
    corners = tuple(shapely.orient_polygons(polygon).exterior.coords)[:-1]
    return NodeAdded(
        time_s=time_s,
        robot=0,
        serial=serial,
        parent=None,
        configuration=(1.0, 1.0, 0.0),
        stage=stage,
        boundary=corners,
        tags="0" * len(corners),
    )


def moved(*waypoints) -> Motion:
    return Motion(time_s=waypoints[0][0], robot=0, waypoints=waypoints)


# The hall is 100 columns of cells wide. What is known of it grows from the left.
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


def test_what_is_seen_twice_or_outside_counts_once_or_not():
    twice = seen(0.0, shapely.box(0, 0, 5, 10)), seen(1.0, shapely.box(0, 0, 5, 10))
    assert measure(recorded(*twice), HALL).coverage == 0.5
    outside = seen(0.0, shapely.box(-50, -50, 5, 50))
    assert measure(recorded(outside), HALL).coverage == 0.5


def test_coverage_is_of_what_the_body_can_get_to_see():
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
    decision = Decision(time_s=0.0, robot=0, node=0, frontier_m=1.0, choice="end", target=None)
    metrics = measure(
        recorded(
            *GROWING,
            decision,
            decision,
            ArcClosed(time_s=1.0, robot=0, node=0, reason="too narrow", arc=arc),
            ArcClosed(time_s=1.0, robot=0, node=0, reason="not reachable", arc=arc),
            ArcClosed(time_s=1.0, robot=0, node=0, reason="too narrow", arc=arc),
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
    ],
)
def test_smallest_clearance(footprint, start, motions, clearance):
    recording = recorded(*(moved(*w) for w in motions), footprint=footprint, start=(*start, 0.0))
    assert smallest_clearance(recording, HALL) == pytest.approx(clearance, abs=1e-4)
    assert measure(recording, HALL).smallest_clearance_m == pytest.approx(clearance, abs=1e-4)


def test_the_clearance_of_a_body_that_touched():
    into = moved((0, 1.0, 1.0, 0.0), (2, 1.0, 0.1, 0.0))
    assert smallest_clearance(recorded(into), HALL) == pytest.approx(0.1 - 0.25)


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


def test_lower_bounds_fall_with_the_speed_and_vanish_with_the_range():
    hall = Environment("hall", shapely.box(0, 0, 20, 20))
    slow, fast = bounds(hall, speed=0.5), bounds(hall, speed=1.0)
    assert slow == pytest.approx((2.0 * fast[0], 2.0 * fast[1]))
    assert bounds(hall, range_m=40.0) == (0.0, 0.0)


def test_the_larger_bound_is_the_bound():
    hall = Environment("hall", shapely.box(0, 0, 20, 20), starts=[(10.0, 10.0)])
    metrics = explore(hall, seed=1).metrics
    assert metrics.lower_bound_s == max(metrics.lower_bound_reach_s, metrics.lower_bound_area_s)
    assert metrics.exploration_time_s > metrics.lower_bound_s > 0.0
