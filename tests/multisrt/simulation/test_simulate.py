"""Whole runs, their recordings, and what explorers are given."""

import gc
import math
import weakref
from itertools import pairwise

import msgspec
import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import ArcClosed, Collision, Ended, Event, MapComplete, Motion, Sensed
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.scan import ExactScan, LaserScan
from multisrt.robots.explorer import Done, Moved, Note, Send, Sense
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    CatalogEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

END = Done(complete=True, reason="enough")
THREE = [(1.0, 1.0), (5.0, 1.0), (9.0, 1.0)]


def test_a_run_by_hand(drive, straight):
    note = MapComplete(time_s=6.0, robot=0)
    arc = ((1.0, 2.0, 3.0, 4.0),)
    recording, explorer = drive(
        Sense(), straight(1, 1, 4, 1), Sense(), Note(note), Done(True, "enough", arc)
    )
    first, moved, second, noted = explorer.told
    assert isinstance(first, ExactScan)
    assert (first.configuration, first.time_s) == (Configuration(1.0, 1.0, 0.0), 0.0)
    assert first.range_m == 4.0
    assert moved == Moved(configuration=Configuration(4.0, 1.0, 0.0), time_s=6.0)
    assert (second.configuration, second.time_s) == (Configuration(4.0, 1.0, 0.0), 6.0)
    assert noted is None
    assert recording.events == (
        Sensed(time_s=0.0, robot=0, configuration=(1.0, 1.0, 0.0)),
        Motion(time_s=0.0, robot=0, waypoints=((0.0, 1.0, 1.0, 0.0), (6.0, 4.0, 1.0, 0.0))),
        Sensed(time_s=6.0, robot=0, configuration=(4.0, 1.0, 0.0)),
        note,
        Ended(time_s=6.0, robot=0, reason="enough", complete=True, frontier=arc),
    )
    assert (recording.footer.outcome, recording.footer.time_s) == ("complete", 6.0)
    assert "enough" in recording.footer.reason


def test_a_run_knows_whether_chance_had_a_part_in_it():
    alone = RunSpec(
        environment=inline(Environment("lane", shapely.box(0.0, 0.0, 12.0, 4.0))),
        strategy="closest",
        robots=(RobotSpec(start=(2.0, 2.0, 0.0)),),
    )
    runs = [simulate(msgspec.structs.replace(alone, seed=seed)) for seed in (1, 2)]
    assert [run.footer.chance for run in runs] == [False, False]
    assert runs[0].events == runs[1].events
    # Starts that are drawn, a planner that draws, a radio that loses messages.
    drawn = msgspec.structs.replace(alone, robots=(RobotSpec(), RobotSpec()))
    planned = msgspec.structs.replace(alone, strategy="srt-radial")
    starts = tuple(RobotSpec(start=(x, 2.0, 0.0)) for x in (2.0, 3.0))
    lossy = msgspec.structs.replace(alone, robots=starts, radio=RadioSpec(loss=0.5))
    for spec in (drawn, planned, lossy):
        assert simulate(spec).footer.chance


def test_times_count_from_the_start_of_the_run(drive, straight, events_of):
    recording, _ = drive(straight(1, 1, 3, 1), straight(3, 1, 3, 4), Done(complete=True, reason=""))
    assert [[w[0] for w in motion.waypoints] for motion in events_of(recording, Motion)] == [
        [0.0, 4.0],
        [4.0, 10.0],
    ]
    assert [motion.time_s for motion in events_of(recording, Motion)] == [0.0, 4.0]


def test_an_explorer_is_given_what_its_robot_is(drive):
    robot = RobotSpec(start=(2.0, 3.0, 0.5), footprint="box:0.6x0.4")
    _, explorer = drive(Done(complete=True, reason=""), robot=robot)
    assert explorer.me.robot == 0
    assert explorer.me.start == (2.0, 3.0, 0.5)
    assert str(explorer.me.footprint) == "box:0.6x0.4"
    assert explorer.me.kinematics.speed_m_s == 0.5
    assert explorer.me.range_m == 4.0


def test_an_explorer_is_given_its_team(act):
    robots = [
        RobotSpec(start=start, range_finder=RangeFinderSpec(range_m=range_m))
        for start, range_m in zip(THREE, (2.0, 5.0, 3.0), strict=True)
    ]
    radio = RadioSpec(range_m=9.0, latency_s=0.5, jitter_s=0.25, loss=0.1, multi_hop=False)
    _, actors = act(*[[END]] * 3, robots=robots, radio=radio)
    selves = [actor.me for actor in actors]
    assert [me.robot for me in selves] == [0, 1, 2]
    assert [me.range_m for me in selves] == [2.0, 5.0, 3.0]
    assert {(me.team, me.max_range_m) for me in selves} == {(3, 5.0)}
    assert selves[0].radio.latency_s == 0.75
    assert (selves[0].radio.range_m, selves[0].radio.loss) == (9.0, 0.1)
    assert not selves[0].radio.multi_hop
    assert not selves[0].radio.reaches_all
    streams = [me.rng.random() for me in selves]
    assert len(set(streams)) == 3


def test_a_laser_scan_has_ranges(drive):
    robot = RobotSpec(start=(1.0, 1.0), range_finder=RangeFinderSpec(range_m=3.0, beams=16))
    _, explorer = drive(Sense(), Done(complete=True, reason=""), robot=robot)
    scan = explorer.told[0]
    assert isinstance(scan, LaserScan)
    # Walls 1 m to the left and below; the corner between them at the root of two; else nothing.
    assert scan.ranges[[8, 10, 12]] == pytest.approx([1.0, math.sqrt(2.0), 1.0])
    assert math.isinf(scan.ranges[0])


def test_the_watcher_is_called_with_every_event(drive, straight):
    seen: list[Event] = []
    recording, _ = drive(straight(1, 1, 3, 1), Done(complete=True, reason=""), watch=seen.append)
    assert tuple(seen) == recording.events


@pytest.fixture(scope="module")
def museum_run():
    from multisrt.environments.catalog import environment

    world = environment("museum")
    return simulate(RunSpec(environment=inline(world), seed=3), world)


def test_events_of_a_run_are_in_order(museum_run):
    times = [event.time_s for event in museum_run.events if not isinstance(event, Collision)]
    assert all(a <= b for a, b in pairwise(times))
    assert not any(isinstance(event, ArcClosed) and not event.arc for event in museum_run.events)


def test_events_are_recorded_in_the_order_in_which_they_happen(play, word, straight, events_of):
    def chatter(robot, x):
        def acts():
            for k in range(4):
                y = 1.0 + k % 2
                yield Send(word(sender=robot))
                yield straight(x, y, x, 3.0 - y, seconds=1.0 + 0.3 * robot)
            yield END

        return acts

    recording, _ = play(chatter(0, 1.0), chatter(1, 5.0), chatter(2, 9.0), starts=THREE)
    # A motion is recorded when it ends.
    times = [
        event.waypoints[-1][0] if isinstance(event, Motion) else event.time_s
        for event in recording.events
    ]
    assert times == sorted(times)
    for robot in range(3):
        for before, after in pairwise(events_of(recording, Motion, robot)):
            assert before.waypoints[-1][0] <= after.time_s == after.waypoints[0][0]
            assert before.waypoints[-1][1:] == after.waypoints[0][1:]


@pytest.mark.parametrize("trouble", ["none", "much"])
def test_a_run_of_a_team_can_be_repeated(hall, trouble):
    radio = RadioSpec(loss=0.2, latency_s=0.1, jitter_s=0.3) if trouble == "much" else RadioSpec()
    spec = RunSpec(
        environment=inline(hall), robots=(RobotSpec(),) * 3, radio=radio,
        stop=StopRule(max_time_s=120.0), seed=5,
    )  # fmt: skip
    first, second = simulate(spec, hall), simulate(spec, hall)
    assert first.events == second.events
    assert first.footer == second.footer


def test_a_run_never_sets_the_garbage_collector():
    before, met = gc.get_threshold(), set()
    simulate(
        RunSpec(environment=CatalogEnvironment(name="open"), seed=1),
        watch=lambda _: met.add(gc.get_threshold()),
    )
    assert met == {before}
    assert gc.get_threshold() == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("strategy", "kind"), [("srt-radial", SrtRobot), ("minpos", FrontierRobot)]
)
@pytest.mark.parametrize("max_time_s", [20.0, 600.0])
def test_the_knowledge_of_robots_is_freed_with_their_run(monkeypatch, strategy, kind, max_time_s):
    # Without the garbage collector: experiments make thousands of runs in one process.
    made, init = [], kind.__init__

    def noted(robot, *arguments):
        init(robot, *arguments)
        made.append(weakref.ref(robot))

    spec = RunSpec(
        environment=CatalogEnvironment(name="apartment"),
        strategy=strategy,
        robots=(RobotSpec(),) * 2,
        stop=StopRule(max_time_s=max_time_s),
    )
    # Compiling a kernel keeps the frames of its caller, so a first run compiles them.
    simulate(spec)
    monkeypatch.setattr(kind, "__init__", noted)
    gc.disable()
    try:
        simulate(spec)
        assert [robot() for robot in made] == [None, None]
    finally:
        gc.enable()
