"""Plans of small worlds that are worked out by hand, and what holds of any plan."""

import math

import pytest
import shapely
from shapely import box

from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import NodeAdded
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.registry import strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    DriveSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
)
from multisrt.testing import check_explorer

ROOM = Environment("room", box(0.0, 0.0, 4.0, 3.0))

# Two arms of 10 x 1 m that meet at a corner.
L_CORRIDOR = Environment("l", shapely.union(box(0, 0, 10, 1), box(9, 0, 10, 10)))

# Two rooms of 5 x 5 m behind the ends of a hall of 8 x 2 m, with doors of 1 m.
TWO_ROOMS = Environment(
    "two",
    shapely.union_all(
        [
            box(0, 0, 8, 2),
            box(-5.2, -1.5, -0.2, 3.5),
            box(8.2, -1.5, 13.2, 3.5),
            box(-0.3, 0.5, 0.1, 1.5),
            box(7.9, 0.5, 8.3, 1.5),
        ]
    ),
)


def driven(world, *starts, options=None, **robot):
    spec = RunSpec(
        environment=inline(world),
        strategy="informed",
        options={"effort": 0.1, **(options or {})},
        robots=tuple(RobotSpec(start=start, **robot) for start in starts),
    )
    recording = simulate(spec, world)
    return recording, measure(recording, world)


def test_a_room_that_is_seen_at_once_takes_no_path():
    recording, metrics = driven(ROOM, (1.0, 1.0, 0.0), range_finder=RangeFinderSpec(range_m=9.0))
    assert recording.footer.outcome == "complete"
    assert metrics.makespan_s == 0.0
    assert metrics.total_distance_m == 0.0
    assert metrics.coverage > 0.999


def test_the_corner_of_a_corridor_is_as_far_as_a_robot_must_go():
    # From (1, 0.5) the second arm is seen from its axis at x = 9.5; from x = 9.26 on, 96 % of it
    # are seen by a robot at the outer wall. So the way is 8 to 8.5 m, and no turn is needed.
    far = RangeFinderSpec(range_m=20.0)
    recording, metrics = driven(L_CORRIDOR, (1.0, 0.5, 0.0), range_finder=far)
    assert recording.footer.outcome == "complete"
    assert metrics.time_to_99_s is not None
    assert 7.0 < metrics.total_distance_m < 8.6
    assert metrics.makespan_s < metrics.total_distance_m / 0.5 + 1.0


def test_of_two_rooms_each_robot_takes_one():
    far = RangeFinderSpec(range_m=12.0)
    recording, metrics = driven(TWO_ROOMS, (3.0, 1.0, 0.0), (5.0, 1.0, 0.0), range_finder=far)
    assert metrics.time_to_99_s is not None
    last = {}
    for event in recording.events:
        if isinstance(event, NodeAdded):
            last[event.robot] = event.configuration[0]
    # Up to just behind its own door: 3 to 4 m away.
    assert last[0] < 1.0
    assert last[1] > 7.0
    assert max(metrics.distance_by_robot_m) < 4.5
    assert metrics.collisions == 0


def test_a_robot_that_faces_away_drives_backwards():
    far = RangeFinderSpec(range_m=20.0)
    _, ahead = driven(L_CORRIDOR, (1.0, 0.5, 0.0), range_finder=far)
    _, back = driven(L_CORRIDOR, (1.0, 0.5, math.pi), range_finder=far)
    assert back.makespan_s == pytest.approx(ahead.makespan_s, abs=0.5)


def test_robots_that_drive_home_end_where_they_started():
    far = RangeFinderSpec(range_m=20.0)
    there, _ = driven(L_CORRIDOR, (1.0, 0.5, 0.0), range_finder=far)
    recording, metrics = driven(
        L_CORRIDOR, (1.0, 0.5, 0.0), range_finder=far, options={"home": True}
    )
    nodes = recording.of(NodeAdded)
    assert nodes[-1].configuration[:2] == pytest.approx((1.0, 0.5), abs=1e-6)
    assert metrics.makespan_s > 1.9 * there.footer.time_s


def test_a_share_that_is_asked_for_is_reached_and_no_more():
    _, less = driven(TWO_ROOMS, (4.0, 1.0, 0.0), options={"share": 0.7})
    _, more = driven(TWO_ROOMS, (4.0, 1.0, 0.0))
    assert 0.7 <= less.coverage < 0.9
    assert less.makespan_s < more.makespan_s


def test_equal_specs_give_equal_bytes():
    one, _ = driven(TWO_ROOMS, (3.0, 1.0, 0.0), (5.0, 1.0, 0.0))
    two, _ = driven(TWO_ROOMS, (3.0, 1.0, 0.0), (5.0, 1.0, 0.0))
    assert one.footer.digest == two.footer.digest


def test_robots_pass_one_another_in_a_hall():
    # Each robot starts before the room of the other; one has to let the other pass, or they
    # exchange their rooms.
    recording, metrics = driven(TWO_ROOMS, (-3.0, 1.0, 0.0), (11.0, 1.0, 0.0), (4.0, 1.0, 0.0))
    assert recording.footer.outcome == "complete"
    assert metrics.collisions == 0
    assert metrics.protective_stops == 0
    assert metrics.coverage >= 0.99


@pytest.mark.parametrize(
    "robot",
    [
        {"drive": DriveSpec(kind="holonomic")},
        {"footprint": "box:0.5x0.3"},
        {"range_finder": RangeFinderSpec(range_m=3.0, beams=360)},
        {"footprint": "disc:0.1", "drive": DriveSpec(speed_m_s=1.0, turn_rate_rad_s=0.5)},
    ],
)
def test_any_body_drive_and_sensor(robot):
    _, metrics = driven(TWO_ROOMS, (3.0, 1.0, 0.0), (5.0, 1.0, 0.0), **robot)
    assert metrics.collisions == 0
    assert metrics.protective_stops == 0
    assert metrics.coverage >= 0.985


def test_mixed_teams():
    spec = RunSpec(
        environment=inline(TWO_ROOMS),
        strategy="informed",
        options={"effort": 0.1},
        robots=(
            RobotSpec(start=(3.0, 1.0, 0.0), footprint="disc:0.2", drive=DriveSpec(speed_m_s=1.0)),
            RobotSpec(start=(5.0, 1.0, 0.0), range_finder=RangeFinderSpec(range_m=2.0)),
        ),
    )
    metrics = measure(simulate(spec, TWO_ROOMS), TWO_ROOMS)
    assert metrics.coverage >= 0.985
    assert metrics.collisions == 0
    assert metrics.distance_by_robot_m[0] > metrics.distance_by_robot_m[1]


@pytest.mark.slow
def test_a_crowd_in_a_corridor():
    # Eight robots in a row in a dead end: those in front go first, and none is in the way of all.
    starts = [(0.5 + 0.9 * k, 0.5, 0.0) for k in range(8)]
    recording, metrics = driven(L_CORRIDOR, *starts)
    assert metrics.collisions == 0
    assert recording.footer.outcome == "complete"
    assert metrics.coverage >= 0.99


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_any_drive_is_free_of_collisions_and_reaches_its_share(seed):
    world = CatalogEnvironment(name="maze", parameters={"size_m": 8.0, "cells": 4}, seed=seed)
    spec = RunSpec(
        environment=world,
        strategy="informed",
        options={"effort": 0.05},
        robots=(RobotSpec(),) * 5,
        starts="clustered",
    )
    metrics = measure(simulate(spec))
    assert metrics.coverage >= 0.99
    assert metrics.collisions == 0
    assert metrics.protective_stops == 0


def test_beams_that_are_too_coarse_for_the_share_are_no_success():
    # Between sixteen beams little is certain: all that they can show is less than 99 %.
    recording, _ = driven(ROOM, (1.0, 1.0, 0.0), range_finder=RangeFinderSpec(beams=16))
    assert recording.footer.outcome == "stalled"
    assert "no place shows more" in recording.footer.reason


def test_the_checker_of_explorers_finds_that_it_sees_the_truth():
    with pytest.raises(ExplorerDefect, match="reaches the truth"):
        check_explorer(strategy("informed"))


def test_progress_of_the_plan_is_told():
    spec = RunSpec(
        environment=inline(L_CORRIDOR),
        strategy="informed",
        options={"effort": 0.1},
        robots=(RobotSpec(start=(1.0, 0.5, 0.0)),),
    )
    told: list[float] = []
    simulate(spec, L_CORRIDOR, planning=told.append)
    assert told == sorted(told)
    assert told[0] == 0.0
    assert 0.9 < told[-1] < 1.0


def test_a_robot_that_cannot_turn_at_its_start_says_so():
    # A box that fits into a niche lengthways only; it is planned as a disc.
    niche = Environment("niche", shapely.union(box(0, 0, 4, 4), box(4, 1.8, 6, 2.2)))
    recording, metrics = driven(niche, (5.0, 2.0, 0.0), footprint="box:0.5x0.3")
    assert recording.footer.outcome == "stalled"
    assert "robot 0 has no room to leave its start" in recording.footer.reason
    assert metrics.total_distance_m == 0.0


def test_cars_are_refused():
    with pytest.raises(InvalidInputError, match="robot 0 is a car"):
        driven(ROOM, (1.0, 1.0, 0.0), drive=DriveSpec(kind="dubins"))


def test_robots_that_die_are_refused():
    spec = RunSpec(
        environment=inline(ROOM), strategy="informed", faults=(Death(robot=0, time_s=1.0),)
    )
    with pytest.raises(InvalidInputError, match="robot 0 does not"):
        simulate(spec, ROOM)
