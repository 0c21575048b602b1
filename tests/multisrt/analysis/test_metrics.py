"""Metrics of a run: coverage, counts, distances, waiting, losses and messages."""

import dataclasses
import math
from functools import partial

import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.analysis.metrics import METRIC_GROUPS, Metrics
from multisrt.environments.environment import Environment
from multisrt.events import (
    AnyEvent,
    ArcClosed,
    ArcReopened,
    Blocked,
    Collision,
    Decided,
    Decision,
    Ended,
    Joined,
    Learned,
    MapComplete,
    NodeAdded,
    Organized,
    Sensed,
    Sent,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.run import explore
from multisrt.spec import LateStart


@pytest.fixture(scope="session")
def growing(seen):
    """The known part of the hall grows from the left."""
    return (
        seen(0.0, shapely.box(0, 0, 5, 10), "root"),
        seen(10.0, shapely.box(0, 0, 9.2, 10), serial=1),
        seen(30.0, shapely.box(4, 0, 9.6, 10), "approach", serial=2),
        seen(40.0, shapely.box(9, 0, 10, 10), "complete", serial=3),
    )


def test_shares_and_times_of_coverage(recorded, hall, growing):
    metrics = measure(recorded(*growing), hall)
    assert metrics.coverage == 1.0
    assert metrics.free_area_m2 == 100.0
    assert metrics.explorable_area_m2 == pytest.approx(100.0)
    assert metrics.covered_area_m2 == metrics.seen_area_m2 == pytest.approx(100.0)
    assert metrics.given_up_m2 == {}
    assert (metrics.time_to_90_s, metrics.time_to_95_s, metrics.time_to_99_s) == (10.0, 30.0, 40.0)
    # Half is missing for 10 s, then 8 % for 20 s, then 4 % for 10 s.
    assert metrics.coverage_integral_s == pytest.approx(5.0 + 1.6 + 0.4, abs=0.01)
    assert metrics.makespan_s == 50.0


def test_shares_that_are_never_covered_have_no_time(recorded, hall, growing):
    metrics = measure(recorded(*growing[:2]), hall)
    assert metrics.coverage == pytest.approx(0.92, abs=1e-4)
    assert (metrics.time_to_90_s, metrics.time_to_95_s, metrics.time_to_99_s) == (10.0, None, None)
    assert metrics.coverage_integral_s == pytest.approx(5.0 + 0.08 * 40.0, abs=0.01)


def test_a_run_without_nodes(recorded, hall):
    metrics = measure(recorded(end_s=3.0), hall)
    assert metrics.coverage == 0.0
    assert metrics.coverage_integral_s == 3.0
    assert metrics.nodes == 0
    assert metrics.known_complete_s is None
    assert metrics.total_distance_m == 0.0


def test_areas_count_once_and_areas_outside_do_not_count(recorded, hall, seen):
    twice = seen(0.0, shapely.box(0, 0, 5, 10)), seen(1.0, shapely.box(0, 0, 5, 10))
    assert measure(recorded(*twice), hall).coverage == pytest.approx(0.5, abs=1e-4)
    outside = seen(0.0, shapely.box(-50, -50, 5, 50))
    assert measure(recorded(outside), hall).coverage == pytest.approx(0.5, abs=1e-4)


def test_coverage_is_relative_to_what_the_body_can_see(recorded, hall, growing):
    rooms = Environment("rooms", shapely.union(hall.free, shapely.box(10.5, 0, 14.5, 10)))
    metrics = measure(recorded(*growing, world=rooms), rooms)
    assert metrics.coverage == 1.0
    assert metrics.free_area_m2 == pytest.approx(140.0)
    assert metrics.explorable_area_m2 == pytest.approx(100.0)


def test_one_scan_of_a_small_room_covers_it():
    run = explore(Environment("closet", shapely.box(0, 0, 3, 2)), start=(1.5, 1.0))
    assert run.metrics.coverage == 1.0
    assert run.metrics.nodes == 1
    assert run.metrics.known_complete_s == 0.0
    assert run.metrics.makespan_s == 0.0
    assert run.metrics.time_to_99_s == 0.0
    assert run.metrics.coverage_integral_s == 0.0
    assert run.metrics.total_distance_m == 0.0
    assert run.metrics.min_clearance_m == pytest.approx(0.75)


def test_counts(recorded, hall, growing):
    arc = ((0.0, 0.0, 3.0, 4.0),)
    left = ((0.0, 0.0, 0.0, 2.0), (0.0, 2.0, 1.5, 2.0))
    decision = Decision(time_s=0.0, robot=0, node=(0, 0), frontier_m=1.0, choice="end", target=None)
    metrics = measure(
        recorded(
            *growing,
            decision,
            Decided(time_s=0.0, robot=0, text="so"),
            ArcClosed(time_s=1.0, robot=0, node=(0, 0), reason="too narrow", arc=arc),
            ArcClosed(time_s=1.0, robot=0, node=(0, 0), reason="not reachable", arc=arc),
            ArcClosed(time_s=1.0, robot=0, node=(0, 0), reason="too narrow", arc=arc),
            MapComplete(time_s=41.0, robot=0),
            MapComplete(time_s=42.0, robot=0),
            Collision(time_s=42.0, robot=0, configuration=(0.0, 0.0, 0.0), account=""),
            Ended(time_s=45.0, robot=0, reason="", complete=True, frontier=left),
        ),
        hall,
    )
    assert metrics.nodes == 4
    assert metrics.nodes_by_stage == {"approach": 1, "complete": 1, "draw": 1, "root": 1}
    assert metrics.decisions == 2
    assert metrics.arcs_closed == {"not reachable": 1, "too narrow": 2}
    assert metrics.collisions == 1
    assert metrics.known_complete_s == 42.0
    assert metrics.frontier_left_m == 3.5


def test_distances(recorded, hall, moved):
    there = moved((0, 1.0, 1.0, 0.0), (6, 4.0, 1.0, 0.0), (7, 4.0, 1.0, 1.0), (9, 4.0, 5.0, 1.0))
    back = moved((9, 4.0, 5.0, 1.0), (12, 1.0, 1.0, 1.0))
    metrics = measure(recorded(there, back), hall)
    assert metrics.total_distance_m == 3.0 + 4.0 + 5.0
    assert metrics.distance_by_robot_m == (12.0,)


def test_distance_along_arcs_and_in_place(recorded, hall, moved):
    arc = moved((0.0, 3.0, 3.0, -math.pi / 2.0), (9.0, 7.0, 3.0, math.pi / 2.0))
    assert measure(recorded(arc), hall).total_distance_m == pytest.approx(2.0 * math.pi)
    whole_turn = moved((0, 3.0, 3.0, 0.0), (9, 3.0, 3.0, 2.0 * math.pi))
    assert measure(recorded(whole_turn), hall).total_distance_m == 0.0


def test_distances_of_a_team_and_their_spread(recorded, hall, moved):
    metrics = measure(
        recorded(
            moved((0, 1.0, 1.0, 0.0), (2, 2.0, 1.0, 0.0)),
            moved((0, 1.0, 5.0, 0.0), (2, 4.0, 5.0, 0.0), robot=1),
            moved((3, 4.0, 5.0, 0.0), (5, 6.0, 5.0, 0.0), robot=1),
            starts=[(1.0, 1.0, 0.0), (1.0, 5.0, 0.0), (1.0, 9.0, 0.0)],
        ),
        hall,
    )
    assert metrics.distance_by_robot_m == (1.0, 5.0, 0.0)
    assert metrics.total_distance_m == 6.0
    assert metrics.distance_spread_m == pytest.approx(math.sqrt((1.0 + 9.0 + 4.0) / 3.0))


def ended(time_s: float, robot: int) -> Ended:
    return Ended(time_s=time_s, robot=robot, reason="", complete=True, frontier=())


def test_waiting(recorded, hall, moved, died):
    starts = [(1.0, y, 0.0) for y in (1.0, 3.0, 5.0, 7.0, 9.0)]
    metrics = measure(
        recorded(
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
        hall,
    )
    assert metrics.waiting_time_by_robot_s == (30.0 - 1.5 - 4.0, 50.0, 6.0, 25.0, 0.0)
    assert metrics.waiting_time_s == pytest.approx(24.5 + 50.0 + 6.0 + 25.0)
    assert metrics.deaths == 1


def looked(
    time_s: float, x: float, robot: int = 0, serial: int = 0, claim_m: float = 1.0
) -> tuple[AnyEvent, ...]:
    """A scan at (x, 5), and a node that claims a disc."""
    here = (x, 5.0, 0.0)
    disc = shapely.Point(x, 5.0).buffer(claim_m, quad_segs=32).exterior
    ring = tuple((float(x), float(y)) for x, y in list(disc.reverse().coords)[:-1])
    return (
        Sensed(time_s=time_s, robot=robot, configuration=here),
        NodeAdded(
            time_s=time_s,
            robot=robot,
            serial=serial,
            parent=None,
            configuration=here,
            stage="root",
            boundary=ring,
            tags="0" * len(ring),
        ),
    )


DISC_M2 = math.pi
"""What a scan with a range of 1 m shows, but for the segments beyond its chords: 0.4 %."""

LENS_M2 = 2.0 * math.acos(0.5) - 0.5 * math.sqrt(3.0)
"""What two such scans show in common, 1 m apart."""


@pytest.fixture(scope="session")
def short(recorded):
    """Build a recording in the hall, with a range of 1 m."""
    return partial(recorded, range_m=1.0, scans=False)


def test_what_no_scan_has_shown_is_not_covered(short, hall):
    metrics = measure(short(*looked(0.0, 5.0, claim_m=3.0)), hall)
    assert metrics.covered_area_m2 == pytest.approx(metrics.seen_area_m2, rel=1e-12)
    assert metrics.seen_area_m2 == pytest.approx(DISC_M2, abs=0.02)
    assert metrics.unseen_m2 == pytest.approx(100.0 - DISC_M2, abs=0.02)


def test_a_robot_that_notes_nothing_is_measured_by_its_scans(short, hall):
    scan, _ = looked(2.0, 5.0)
    metrics = measure(short(scan), hall)
    assert metrics.coverage == metrics.seen == pytest.approx(DISC_M2 / 100.0, abs=3e-4)
    assert metrics.nodes == 0
    # One that notes nodes is not measured by what it saw beside them.
    other, _ = looked(3.0, 1.5)
    metrics = measure(short(*looked(2.0, 8.0), other), hall)
    assert metrics.coverage == pytest.approx(DISC_M2 / 100.0, abs=3e-4)
    assert metrics.seen == pytest.approx(2.0 * DISC_M2 / 100.0, abs=3e-4)


def test_nodes_without_scans_cannot_be_judged(recorded, hall, growing):
    with pytest.raises(InvalidInputError, match="has nodes but no scans"):
        measure(recorded(*growing, scans=False), hall)


def test_a_scan_in_a_wall_cannot_be_judged(recorded, hall):
    scan = Sensed(time_s=0.0, robot=0, configuration=(12.0, 5.0, 0.0))
    with pytest.raises(InvalidInputError, match="not taken in free space"):
        measure(recorded(scan), hall)


def test_integrals_run_to_the_horizon(recorded, hall, growing):
    growing = growing[:2]
    half, most = 0.5 * 10.0, 0.08
    for horizon_s, expected in ((5.0, 2.5), (50.0, half + 40.0 * most), (80.0, half + 70.0 * most)):
        metrics = measure(recorded(*growing), hall, horizon_s=horizon_s)
        assert metrics.coverage_integral_s == pytest.approx(expected, abs=0.01)
        known = 50.0 * min(horizon_s, 10.0) + 92.0 * max(0.0, horizon_s - 10.0)
        assert metrics.known_to_one_m2s == pytest.approx(known, rel=1e-4)
    for horizon_s in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="horizon of integrals is a positive number"):
            measure(recorded(*growing), hall, horizon_s=horizon_s)


def test_success_is_what_was_covered(recorded, hall, growing):
    metrics = measure(recorded(*growing[:3]), hall)
    assert metrics.outcome == "complete"
    assert (metrics.reached(), metrics.reached(0.97)) == (True, False)
    assert not measure(recorded(*growing[:2]), hall).reached()
    for threshold in (0.0, -0.1, 1.1, math.nan):
        with pytest.raises(InvalidInputError, match="a share above 0 and up to 1"):
            metrics.reached(threshold)


def test_what_was_left_is_told_by_the_frontier_before_it(recorded, hall, seen):
    # Two strips are left, of 10 and of 20 m2: the first was given up, the second one in halves.
    arcs = ArcClosed(
        time_s=1.0, robot=0, node=(0, 0), reason="too narrow", arc=((1.0, 10.0, 1.0, 0.0),)
    )
    half = ArcClosed(
        time_s=1.0, robot=0, node=(0, 0), reason="seen from near", arc=((8.0, 0.0, 8.0, 5.0),)
    )
    left = Ended(time_s=2.0, robot=0, reason="", complete=False, frontier=((8.0, 5.0, 8.0, 10.0),))
    known = seen(0.0, shapely.box(1, 0, 8, 10))
    metrics = measure(recorded(known, arcs, half, left), hall)
    assert metrics.given_up_m2 == pytest.approx(
        {"left open": 10.0, "seen from near": 10.0, "too narrow": 10.0}, abs=0.5
    )
    assert sum(metrics.given_up_m2.values()) == pytest.approx(30.0, abs=0.01)
    metrics = measure(recorded(known, arcs), hall)
    assert metrics.given_up_m2 == pytest.approx({"no frontier": 20.0, "too narrow": 10.0}, abs=0.01)


def test_a_claim_to_know_the_map_counts_if_it_was_known(recorded, hall, growing):
    early = MapComplete(time_s=5.0, robot=0)
    late = MapComplete(time_s=41.0, robot=0)
    assert measure(recorded(early, *growing, late), hall).known_complete_s == 41.0
    assert measure(recorded(early, *growing), hall).known_complete_s is None
    # Robot 1 knows nothing until it is told.
    starts = [(1.0, 1.0, 0.0), (1.0, 5.0, 0.0)]
    other = MapComplete(time_s=42.0, robot=1)
    assert measure(recorded(*growing, other, starts=starts), hall).known_complete_s is None
    told = Learned(time_s=42.0, robot=1, nodes=((0, 1), (0, 2), (0, 3)))
    metrics = measure(recorded(*growing, told, other, starts=starts), hall)
    assert metrics.known_complete_s == 42.0
    assert measure(recorded(early), hall).known_complete_s is None
    # What it says last counts, and nobody knows a map complete by ending early.
    again = MapComplete(time_s=45.0, robot=0)
    assert measure(recorded(*growing, late, again), hall).known_complete_s == 45.0
    half = MapComplete(time_s=3.0, robot=0)
    assert measure(recorded(growing[0], half), hall).known_complete_s is None
    # An arc that a body blocks makes a map never complete, until it is taken up again.
    arc = ((0.0, 0.0, 1.0, 0.0),)
    blocked = ArcClosed(time_s=40.0, robot=0, node=(0, 0), reason="blocked by a robot", arc=arc)
    freed = ArcReopened(time_s=40.5, robot=0, node=(0, 0), arc=arc)
    assert measure(recorded(*growing, blocked, late), hall).known_complete_s is None
    assert measure(recorded(*growing, blocked, freed, late), hall).known_complete_s == 41.0


def test_what_a_robot_says_that_it_learned_counts_if_it_was_told(recorded, hall, growing):
    starts = [(1.0, 1.0, 0.0), (1.0, 5.0, 0.0)]
    learned = Learned(time_s=41.0, robot=1, nodes=((0, 0), (0, 1), (0, 2), (0, 3), (0, 9)))

    def alone_m2(*events):
        # The recording as it is: its builder would add the messages.
        run = recorded(*growing, starts=starts)
        last = sorted([*run.events, *events], key=lambda event: event.time_s)
        return measure(dataclasses.replace(run, events=tuple(last)), hall).known_to_one_m2

    sent = Sent(time_s=40.5, robot=0, kind="map", size_bytes=9, reached=(1,))
    assert alone_m2(learned) == pytest.approx(100.0, rel=1e-4)
    assert alone_m2(sent, learned) == pytest.approx(0.0, abs=1e-6)
    # A message that came before the nodes were made told nothing of them.
    early = Sent(time_s=5.0, robot=0, kind="map", size_bytes=9, reached=(1,))
    assert alone_m2(early, learned) == pytest.approx(50.0, rel=1e-3)


def test_a_node_where_no_scan_was_taken_covers_nothing(short, hall):
    scan, _ = looked(0.0, 2.0)
    _, node = looked(1.0, 8.0)
    metrics = measure(short(scan, node), hall)
    assert metrics.seen_area_m2 == pytest.approx(DISC_M2, abs=0.02)
    assert metrics.covered_area_m2 == 0.0
    assert metrics.given_up_m2 == {"no frontier": pytest.approx(100.0)}


def test_frontier_of_any_length_can_be_left(recorded, hall, seen):
    known = seen(0.0, shapely.box(1, 0, 8, 10))
    for frontier in (((1.0, 1.0, 1.0, 1.0),), ((0.0, 0.0, 1e8, 0.0),)):
        end = Ended(time_s=2.0, robot=0, reason="", complete=False, frontier=frontier)
        left = measure(recorded(known, end), hall).given_up_m2
        assert sum(left.values()) == pytest.approx(30.0, abs=0.01)


def test_the_overlap_is_the_area_seen_by_several_robots(short, hall):
    starts = [(1.0, 1.0, 0.0), (1.0, 5.0, 0.0), (1.0, 9.0, 0.0)]
    metrics = measure(
        short(
            *looked(0.0, 2.0),
            *looked(1.0, 2.0, serial=1),  # its own again: no overlap
            *looked(1.0, 3.0, robot=1),
            *looked(2.0, 7.0, robot=1, serial=1),
            *looked(3.0, 7.0, robot=2),
            starts=starts,
        ),
        hall,
    )
    assert metrics.seen_area_m2 == pytest.approx(3.0 * DISC_M2 - LENS_M2, abs=0.03)
    assert metrics.overlap_area_m2 == pytest.approx(LENS_M2 + DISC_M2, abs=0.02)
    assert metrics.overlap_share == pytest.approx(
        (LENS_M2 + DISC_M2) / (3.0 * DISC_M2 - LENS_M2), abs=0.005
    )


def test_a_single_robot_has_no_overlap(recorded, hall, growing):
    metrics = measure(recorded(*growing), hall)
    assert (metrics.overlap_area_m2, metrics.overlap_share) == (0.0, 0.0)
    assert metrics.min_distance_between_robots_m is None
    assert (metrics.lost_area_m2, metrics.lost_area_by_robot_m2) == (0.0, (0.0,))
    assert measure(recorded(end_s=3.0), hall).overlap_share == 0.0


def test_area_is_lost_with_robots_that_die(short, hall, died):
    starts = [(1.0, y, 0.0) for y in (1.0, 4.0, 7.0, 9.0)]
    story = (
        # Robot 1 passes on one node of two; robot 0 sees a part of the other for itself.
        *looked(0.0, 1.5, robot=1),
        *looked(1.0, 4.0, robot=1, serial=1),
        Learned(time_s=2.0, robot=0, nodes=((1, 0),)),
        *looked(3.0, 3.0),
        # Robot 2 tells robot 1 alone, which dies, too.
        *looked(3.0, 8.0, robot=2),
        Learned(time_s=4.0, robot=1, nodes=((2, 0),)),
        died(5.0, 1),
        died(6.0, 2),
    )
    metrics = measure(short(*story, starts=starts), hall)
    own = DISC_M2 - LENS_M2
    assert metrics.lost_area_by_robot_m2 == pytest.approx((0.0, own, DISC_M2, 0.0), abs=0.02)
    assert metrics.lost_area_m2 == pytest.approx(own + DISC_M2, abs=0.02)
    assert metrics.deaths == 2
    # What a survivor has learned is not lost, although the other ones do not know it.
    told = Learned(time_s=49.0, robot=3, nodes=((2, 0),))
    metrics = measure(short(*story, told, starts=starts), hall)
    assert metrics.lost_area_by_robot_m2 == pytest.approx((0.0, own, 0.0, 0.0), abs=0.02)
    assert metrics.lost_area_m2 == pytest.approx(own, abs=0.02)


def test_all_area_is_lost_when_all_robots_die(short, hall, died):
    starts = [(1.0, 1.0, 0.0), (1.0, 4.0, 0.0)]
    story = (*looked(0.0, 4.0), *looked(0.0, 4.0, robot=1), died(5.0, 0), died(5.0, 1))
    metrics = measure(short(*story, starts=starts), hall)
    assert metrics.lost_area_m2 == pytest.approx(DISC_M2, abs=0.02)
    # What both saw counts for both.
    assert metrics.lost_area_by_robot_m2 == pytest.approx((DISC_M2, DISC_M2), abs=0.02)


def sent(robot: int, kind: str, size: int, reached=(), lost=()) -> Sent:
    return Sent(time_s=1.0, robot=robot, kind=kind, size_bytes=size, reached=reached, lost=lost)


def test_messages_and_events_are_counted(recorded, hall):
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
        recorded(
            sent(0, "hello", 10, reached=(1, 2)),
            sent(1, "map", 500, reached=(0,), lost=(2,)),
            sent(2, "map", 300),
            organized(False),
            organized(True),
            blocked,
            starts=[(1.0, 1.0, 0.0), (1.0, 5.0, 0.0), (1.0, 9.0, 0.0)],
        ),
        hall,
    )
    assert metrics.messages == 3
    assert metrics.deliveries == 3
    assert metrics.lost_deliveries == 1
    assert metrics.bytes_sent == 810
    assert metrics.messages_by_kind == {"hello": 1, "map": 2}
    assert metrics.bytes_by_kind == {"hello": 10, "map": 800}
    assert (metrics.coordinations, metrics.deadlocks, metrics.protective_stops) == (2, 1, 1)


def test_every_metric_is_in_one_group():
    grouped = [name for names in METRIC_GROUPS.values() for name in names]
    assert sorted(grouped) == sorted(Metrics.__struct_fields__)
