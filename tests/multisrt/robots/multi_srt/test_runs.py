"""Whole runs of Multi-SRT teams in small worlds, without faults and with many."""

import itertools
import math
import signal
from collections.abc import Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import (
    Collision,
    Coordinated,
    Decision,
    Died,
    Ended,
    Joined,
    MapComplete,
    Motion,
    NodeAdded,
    Organized,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    DriveSpec,
    Fault,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

WORLDS: dict[str, dict[str, bool | int | float | str]] = {
    "open": {"size_m": 12.0, "columns": 3},
    "rooms": {"size_m": 16.0, "rooms_per_side": 2},
    "garden": {"size_m": 16.0, "plots": 2},
}
MAX_WALL_S = 60
"""Time on the clock after which a run fails; those that end take a second or two."""


@cache
def world(name: str) -> Environment:
    parameters: dict[str, Any] = dict(WORLDS[name])
    return environment(name, **parameters)


@contextmanager
def time_limit(seconds: int):
    """Fail where a run does not end."""

    def ring(number, frame):
        raise TimeoutError(f"the run goes on after {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def name_of(spec: RunSpec) -> str:
    assert isinstance(spec.environment, CatalogEnvironment)
    return spec.environment.name


def explore(spec: RunSpec) -> Recording:
    """Run a spec in its world."""
    with time_limit(MAX_WALL_S):
        return simulate(spec, world(name_of(spec)))


def spec_of(name: str, count: int, seed: int, **more) -> RunSpec:
    return RunSpec(
        environment=CatalogEnvironment(name=name, parameters=WORLDS[name]),
        robots=(RobotSpec(),) * count,
        stop=StopRule(max_time_s=7200.0),
        seed=seed,
        **more,
    )


def check_motions(recording: Recording, motions: Sequence[Sequence[Motion]]) -> None:
    """Check that the motions of every robot follow on one another in time and place."""
    for robot, own in enumerate(motions):
        here: tuple[float, ...] = recording.starts[robot]
        time_s = 0.0
        for motion in own:
            assert motion.waypoints[0][0] == motion.time_s >= time_s - 1e-6
            assert motion.waypoints[0][1:3] == pytest.approx(here[:2], abs=1e-6)
            assert math.remainder(motion.waypoints[0][3] - here[2], 2 * math.pi) == pytest.approx(
                0.0, abs=1e-6
            )
            time_s, *end = motion.waypoints[-1]
            here = tuple(end)


def closest_approach(recording: Recording, motions: Sequence[Sequence[Motion]]) -> float:
    """Smallest distance of two centres along all motions; straight legs only."""
    paths = []
    for robot, own in enumerate(motions):
        x, y, _ = recording.starts[robot]
        path = [(0.0, x, y)]
        for motion in own:
            path += [waypoint[:3] for waypoint in motion.waypoints]
        paths.append(np.array([*path, (recording.footer.time_s + 1.0, *path[-1][1:])]))
    least = math.inf
    for a, b in itertools.combinations(paths, 2):
        # Between two times at which either turns, the distance is that of two straight motions.
        times = np.unique(np.concatenate([a[:, 0], b[:, 0]]))
        gap = [
            np.interp(times, a[:, 0], a[:, k]) - np.interp(times, b[:, 0], b[:, k]) for k in (1, 2)
        ]
        points = np.column_stack(gap)
        legs = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
        least = min(least, float(shapely.distance(legs, shapely.Point(0, 0)).min()))
    return least


@pytest.fixture
def check_end(events_of):
    """Check that a run ends in time, for a stated reason, without collisions; so do survivors."""

    def run(recording, spec: RunSpec):
        assert events_of(recording, Collision) == []
        assert recording.footer.outcome in ("complete", "stalled")
        assert recording.footer.reason
        assert recording.footer.time_s < spec.stop.max_time_s
        dead = {event.robot for event in events_of(recording, Died)}
        for robot in range(len(spec.robots)):
            assert robot in dead or events_of(recording, Ended, robot), f"robot {robot} did not end"
        assert "message that never comes" not in recording.footer.reason
        motions = [events_of(recording, Motion, robot) for robot in range(len(spec.robots))]
        check_motions(recording, motions)
        assert closest_approach(recording, motions) > 0.5 - 1e-6

    return run


@pytest.mark.slow
@pytest.mark.parametrize(("strategy", "count"), [("srt-radial", 4), ("srt-star", 2)])
@pytest.mark.parametrize("name", WORLDS)
def test_a_team_without_faults_completes_its_map(events_of, check_end, strategy, name, count):
    spec = spec_of(name, count, seed=count, strategy=strategy)
    recording = explore(spec)
    check_end(recording, spec)
    assert recording.footer.outcome == "complete"
    for robot in range(count):
        assert events_of(recording, MapComplete, robot)
    known = shapely.union_all(
        [shapely.Polygon(n.boundary) for n in events_of(recording, NodeAdded)]
    )
    free = world(name).free
    assert known.intersection(free).area > 0.97 * free.area
    assert known.difference(free.buffer(1e-6)).area < 1e-3


@pytest.mark.parametrize("count", [1, 3])
def test_scans_on_the_way_become_nodes_between_places(events_of, check_end, count):
    sensing = {"sense": "moving", "sense_period_s": 1.0}
    spec = spec_of(next(iter(WORLDS)), count, seed=1, strategy="srt-radial", options=sensing)
    recording = explore(spec)
    check_end(recording, spec)
    assert recording.footer.outcome == "complete"
    passed = [node for node in events_of(recording, NodeAdded) if node.stage == "passed"]
    assert len(passed) > 10
    motions = {(e.robot, *e.waypoints[-1]) for e in events_of(recording, Motion)}
    for node in passed:
        assert any(
            robot == node.robot and math.dist((x, y), node.configuration[:2]) < 1e-9
            for robot, _, x, y, _ in motions
        )
    at_targets = explore(msgspec.structs.replace(spec, options={}))
    assert not [node for node in events_of(at_targets, NodeAdded) if node.stage == "passed"]


def test_robots_far_from_all_others_act_as_if_alone(events_of):
    # In a long hall they are never within twice the range of one another in so short a time.
    hall = Environment("hall", shapely.box(0, 0, 60, 3))
    robots = (RobotSpec(start=(2.0, 1.5)), RobotSpec(start=(58.0, 1.5)))
    spec = RunSpec(environment=inline(hall), robots=robots, stop=StopRule(max_time_s=25.0), seed=3)
    with time_limit(MAX_WALL_S):
        together = simulate(spec, hall)
    first_moves = [events_of(together, Motion, robot)[0] for robot in (0, 1)]
    assert [motion.time_s for motion in first_moves] == [0.0, 0.0]
    assert events_of(together, Coordinated) == events_of(together, Organized) == []


@pytest.mark.parametrize("multi_hop", [True, False])
@pytest.mark.parametrize("walls", ["pass", "block"])
def test_a_team_with_a_short_radio_ends(check_end, multi_hop, walls):
    radio = RadioSpec(range_m=12.0, multi_hop=multi_hop, walls=walls)
    spec = spec_of("rooms", 3, seed=1, radio=radio)
    check_end(explore(spec), spec)


def with_ranges(sensors_m, radio_m) -> RunSpec:
    robots = tuple(RobotSpec(range_finder=RangeFinderSpec(range_m=m)) for m in sensors_m)
    return RunSpec(
        environment=CatalogEnvironment(name="open", parameters=WORLDS["open"]),
        robots=robots,
        radio=RadioSpec(range_m=radio_m),
        stop=StopRule(max_time_s=1.0),
    )


@pytest.mark.parametrize(
    ("sensors_m", "radio_m", "said"),
    [
        ((4.0, 4.0), 11.9, "12 m for a sensor range of 4 m, not 11.9 m;"),
        ((2.0, 5.0, 4.0), 12.0, "15 m for a sensor range of 5 m, not 12 m;"),
        ((4.0, 4.0), 0.0, "12 m for a sensor range of 4 m, not 0 m;"),
    ],
)
def test_a_radio_shorter_than_three_sensing_ranges_is_refused(sensors_m, radio_m, said):
    with pytest.raises(InvalidInputError) as error:
        explore(with_ranges(sensors_m, radio_m))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("sensors_m", "radio_m"),
    # Three times 1.1 and 4.4 are not 3.3 and 13.2 in binary; a robot alone needs no radio.
    [((4.0, 4.0), 12.0), ((1.1, 1.1), 3.3), ((4.4, 4.4), 13.2), ((4.0,), 1.0)],
)
def test_a_radio_of_three_sensing_ranges_is_accepted(sensors_m, radio_m):
    assert explore(with_ranges(sensors_m, radio_m)).footer.outcome == "out_of_time"


def faulty(seed: int) -> RunSpec:
    """Return a run with many faults; the same for the same seed."""
    rng = np.random.default_rng([seed, 2])
    count = int(rng.integers(2, 6))
    faults: list[Fault] = []
    robots = rng.permutation(count).tolist()
    for robot in robots[: int(rng.integers(0, count))]:
        when: Any = str(rng.choice(["any", "moving", "waiting", "master"]))
        faults.append(Death(robot=robot, time_s=float(rng.uniform(0.0, 150.0)), when=when))
    for robot in range(count):
        if rng.random() < 0.3:
            faults.append(LateStart(robot=robot, time_s=float(rng.uniform(1.0, 100.0))))
        if rng.random() < 0.4:
            time_s, duration_s = rng.uniform(0.0, 100.0), rng.uniform(5.0, 60.0)
            faults.append(Silence(robot=robot, time_s=float(time_s), duration_s=float(duration_s)))
    return spec_of(
        str(rng.choice(list(WORLDS))),
        count,
        seed,
        strategy=str(rng.choice(["srt-radial", "srt-star"])),
        starts=str(rng.choice(["scattered", "clustered"])),
        radio=RadioSpec(
            loss=0.3 if rng.random() < 0.6 else 0.0,
            latency_s=float(rng.choice([0.0, rng.uniform(0.0, 2.0)])),
            jitter_s=float(rng.choice([0.0, rng.uniform(0.0, 1.0)])),
        ),
        faults=tuple(faults),
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_a_team_with_faults_ends(events_of, check_end, seed):
    spec = faulty(seed)
    recording = explore(spec)
    check_end(recording, spec)
    late = {f.robot: f.time_s for f in spec.faults if isinstance(f, LateStart)}
    for robot, time_s in late.items():
        joined = events_of(recording, Joined, robot)
        assert [event.time_s for event in joined] == [time_s] or events_of(recording, Died, robot)
    for died in events_of(recording, Died):
        assert not [
            event
            for event in recording.events
            if event.robot == died.robot and event.time_s > died.time_s
        ]


def test_the_faults_are_of_all_kinds():
    specs = [faulty(seed) for seed in range(12)]
    kinds = {type(fault) for spec in specs for fault in spec.faults}
    assert kinds == {Death, LateStart, Silence}
    assert {name_of(spec) for spec in specs} == set(WORLDS)
    assert {len(spec.robots) for spec in specs} == {2, 3, 4, 5}
    assert {spec.strategy for spec in specs} == {"srt-radial", "srt-star"}
    assert any(spec.radio.loss and spec.radio.latency_s for spec in specs)


@pytest.mark.parametrize("strategy", ["srt-star", "srt-radial"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_living_pass_the_dead_and_explore_the_rest(strategy, seed):
    # Wherever in the corridor the other dies, there is room on one side.
    world = Environment("corridor", shapely.box(0, 0, 24, 2.6))
    spec = RunSpec(
        environment=inline(world),
        strategy=strategy,
        robots=(RobotSpec(start=(3.0, 1.3)), RobotSpec(start=(4.0, 1.3))),
        radio=RadioSpec(range_m=12.0),
        faults=(Death(robot=1, time_s=12.0, when="moving"),),
        seed=seed,
        stop=StopRule(max_time_s=3000.0),
    )
    recording = simulate(spec, world)
    assert recording.footer.outcome == "complete"
    metrics = measure(recording, world)
    assert metrics.collisions == 0
    assert metrics.coverage > 0.96
    assert metrics.known_complete_s is not None
    assert math.isfinite(metrics.known_complete_s)
    for event in recording.events:
        if isinstance(event, Decision) and event.choice == "bypass":
            assert event.target is not None
        if isinstance(event, NodeAdded):
            assert event.stage != "root" or event.serial == 0


@pytest.mark.slow
def test_robots_whose_paths_cross_do_not_stop_each_other_for_ever():
    # Balls that do not overlap are not coordinated, but the ways to their parents may cross.
    spec = RunSpec(
        environment=CatalogEnvironment(name="open"),
        strategy="srt-ball",
        robots=(RobotSpec(),) * 4,
        starts="clustered",
        radio=RadioSpec(range_m=20.0, walls="block"),
        faults=(
            Death(robot=3, time_s=55.444),
            Silence(robot=1, time_s=75.631, duration_s=60.0),
            LateStart(robot=2, time_s=73.638),
        ),
        stop=StopRule(max_time_s=4000.0),
        seed=1,
    )
    assert simulate(spec).footer.outcome == "complete"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("strategy", "name", "seed", "faults"),
    [
        # A robot adds one node after another at the same place, before the body of a dead one.
        (
            "srt-radial",
            "museum",
            0,
            (
                Death(robot=1, time_s=147.056),
                Death(robot=2, time_s=37.71),
                Death(robot=0, time_s=73.738),
            ),
        ),
        # Three robots on their way to the same place stand in each other's way.
        (
            "srt-ball",
            "apartment",
            4,
            (
                Death(robot=2, time_s=54.802),
                Silence(robot=0, time_s=7.737, duration_s=60.0),
                LateStart(robot=1, time_s=14.36),
            ),
        ),
    ],
)
def test_robots_that_block_each_other_do_not_wait_for_ever(
    strategy: str, name: str, seed: int, faults: tuple[Fault, ...]
) -> None:
    spec = RunSpec(
        environment=CatalogEnvironment(name=name),
        strategy=strategy,
        robots=(RobotSpec(),) * 4,
        starts="clustered",
        radio=RadioSpec(range_m=20.0, walls="block"),
        faults=faults,
        stop=StopRule(max_time_s=5000.0),
        seed=seed,
    )
    footer = simulate(spec).footer
    assert footer.outcome in ("complete", "stalled")
    assert "for a message that never comes" not in footer.reason


@pytest.mark.parametrize("support", [True, False])
def test_robots_wait_to_take_over_only_if_they_support_others(events_of, support):
    spec = spec_of(
        "rooms",
        2,
        seed=2,
        radio=RadioSpec(range_m=12.0),
        options={"support": support, "take_over_after_s": 3000.0},
    )
    ends = [one.time_s for one in events_of(explore(spec), Ended)]
    assert (max(ends) > 3000.0) == support


def test_a_car_that_finds_no_motion_from_its_start_is_not_complete():
    car = RobotSpec(footprint="box:0.5x0.3", drive=DriveSpec(kind="dubins", turning_radius_m=0.5))
    apartment = environment("apartment")
    spec = RunSpec(
        environment=inline(apartment),
        strategy="srt-radial",
        robots=(car,),
        starts="clustered",
        stop=StopRule(max_time_s=1000.0),
    )
    recording = simulate(spec)
    [end] = recording.of(Ended)
    assert not end.complete
    assert end.reason.startswith("boxed in at the start")
    assert measure(recording, apartment).coverage < 0.1
