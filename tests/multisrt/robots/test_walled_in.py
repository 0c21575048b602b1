"""Robots that find no motion from their starts say so, and do not report a complete map."""

import math

import pytest

from multisrt import RobotSpec, RunSpec, simulate
from multisrt.events import Ended, Motion
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.spec import InlineEnvironment, RadioSpec, RangeFinderSpec, Silence, StopRule

HALL = InlineEnvironment(name="hall", wkt="POLYGON ((0 0, 9 0, 9 6, 0 6, 0 0))")


def run(strategy, footprint, gap_m, beams=None, **options):
    left, low, _, _ = Footprint.parse(footprint).placed((0.0, 0.0, 0.3)).bounds
    robot = RobotSpec(
        start=(gap_m - left, gap_m - low, 0.3),
        footprint=footprint,
        range_finder=RangeFinderSpec(range_m=3.0, beams=beams),
    )
    spec = RunSpec(environment=HALL, strategy=strategy, robots=(robot,), options=options)
    return simulate(spec)


@pytest.mark.parametrize(
    ("strategy", "gap_m", "beams"),
    [
        ("minpos", 0.001, 90),
        ("gain", 0.001, 90),
        ("srt-radial", 0.001, 90),
        ("srt-radial", 0.0003, None),
        ("srt-star", 0.001, 90),
        ("srt-star", 0.0003, None),
    ],
)
def test_a_box_in_a_corner_that_cannot_move_is_boxed_in(strategy, gap_m, beams):
    recording = run(strategy, "box:0.6x0.4", gap_m, beams)
    (end,) = recording.of(Ended)
    assert not recording.of(Motion)
    assert not end.complete
    assert end.reason.startswith("boxed in at the start, where the scan shows no way")
    assert recording.footer.outcome == "stalled"


@pytest.mark.parametrize("strategy", ["minpos", "gain"])
def test_a_box_in_a_corner_drives_straight_to_where_it_can_turn(strategy):
    recording = run(strategy, "box:0.6x0.4", 0.0003)
    x0, y0, heading = recording.of(Motion)[0].waypoints[0][1:]
    x1, y1, ahead = recording.of(Motion)[0].waypoints[-1][1:]
    assert heading == ahead == pytest.approx(math.atan2(y1 - y0, x1 - x0)) == 0.3
    assert recording.footer.outcome == "complete"


@pytest.mark.parametrize("strategy", ["minpos", "gain", "srt-radial"])
@pytest.mark.parametrize("beams", [60, 116, None])
def test_a_disc_leaves_a_wall_that_it_begins_beside(strategy, beams):
    recording = run(strategy, "disc:0.25", 0.001, beams)
    assert len(recording.of(Motion)) > 3
    assert recording.footer.outcome == "complete"


@pytest.mark.parametrize("strategy", ["minpos", "srt-radial"])
def test_a_robot_that_sees_the_whole_room_from_a_corner_is_complete(strategy):
    # It cannot move, but nothing is left to be seen.
    left, low, _, _ = Footprint.parse("box:0.6x0.4").placed((0.0, 0.0, 0.3)).bounds
    robot = RobotSpec(
        start=(0.0003 - left, 0.0003 - low, 0.3),
        footprint="box:0.6x0.4",
        range_finder=RangeFinderSpec(range_m=20.0),
    )
    recording = simulate(RunSpec(environment=HALL, strategy=strategy, robots=(robot,)))
    assert recording.footer.outcome == "complete"


@pytest.mark.parametrize("strategy", ["minpos", "self-bidding", "rules"])
def test_a_box_that_cannot_turn_in_its_corridor_is_boxed_in(strategy):
    corridor = InlineEnvironment(name="corridor", wkt="POLYGON ((0 0, 9 0, 9 0.66, 0 0.66, 0 0))")
    robot = RobotSpec(
        start=(4.5, 0.33, 0.0),
        footprint="box:0.6x0.4",
        range_finder=RangeFinderSpec(range_m=3.0),
    )
    recording = simulate(RunSpec(environment=corridor, strategy=strategy, robots=(robot,)))
    (end,) = recording.of(Ended)
    assert not end.complete
    assert end.reason.startswith("boxed in at the start")


def test_a_robot_that_only_turned_at_its_start_is_boxed_in():
    hall = InlineEnvironment(name="hall", wkt="POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0))")
    robot = RobotSpec(
        start=(0.2501, 0.26, 0.0),
        footprint="disc:0.25",
        range_finder=RangeFinderSpec(range_m=1.5, beams=45),
    )
    recording = simulate(RunSpec(environment=hall, strategy="self-bidding", robots=(robot,)))
    (end,) = recording.of(Ended)
    assert recording.of(Motion)
    assert not end.complete


@pytest.mark.parametrize("strategy", ["minpos", "gain"])
def test_a_robot_boxed_in_at_its_start_is_complete_once_others_have_seen_the_rest(strategy):
    left, low, _, _ = Footprint.parse("box:0.6x0.4").placed((0.0, 0.0, 0.3)).bounds
    starts = (0.0003 - left, 0.0003 - low, 0.3), (6.0, 4.0, 0.0)
    robots = tuple(
        RobotSpec(start=start, footprint="box:0.6x0.4", range_finder=RangeFinderSpec(range_m=1.5))
        for start in starts
    )
    recording = simulate(RunSpec(environment=HALL, strategy=strategy, robots=robots))
    assert recording.footer.outcome == "complete"


def test_a_robot_that_gives_up_between_two_nodes_ends():
    crossing = "8 1.2, 8 5, 14 5, 14 6.2, 0 6.2, 0 5, 6 5, 6 1.2"
    wkt = f"POLYGON ((0 0, 14 0, 14 1.2, {crossing}, 0 1.2, 0 0))"
    finder = RangeFinderSpec(range_m=2.0)
    robots = tuple(
        RobotSpec(start=(x, 0.6, 0.0), footprint="disc:0.3", range_finder=finder)
        for x in (1.5, 4.0, 7.0, 10.0, 12.5)
    )
    faults = tuple(Silence(robot=k, time_s=1.0 + 3.0 * k, duration_s=2000.0) for k in range(5))
    for seed in range(3):
        spec = RunSpec(
            environment=InlineEnvironment(name="corridors", wkt=wkt),
            strategy="srt-radial",
            robots=robots,
            options={"gives_up_after": 1, "jammed_after": 1, "crowded_after": 1},
            seed=seed,
            radio=RadioSpec(range_m=None, loss=0.3),
            faults=faults,
            stop=StopRule(max_time_s=1500.0),
        )
        assert simulate(spec).of(Ended)
