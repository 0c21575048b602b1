"""Frontier bidding where things go wrong: lost messages, late and dead robots, narrow ways."""

import dataclasses
import itertools
import math
from functools import partial

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.clearances import smallest_distance_between_robots
from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import (
    Blocked,
    Collision,
    Died,
    Ended,
    GoalChosen,
    Joined,
    Learned,
    MapComplete,
    Motion,
    NodeAdded,
    Sent,
)
from multisrt.experiments.crossing import runs
from multisrt.experiments.spec import EnvironmentChoice, ExperimentSpec, StartsChoice
from multisrt.geometry.grids.occupancy import UNKNOWN, Occupancy
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots import registry
from multisrt.robots.frontier.driving import drive
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.protective_stop import MIN_SHARE
from multisrt.robots.registry import strategy
from multisrt.robots.strategy import Strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    Death,
    DriveSpec,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

CROWDS = ExperimentSpec(
    name="crowds",
    environments=(
        EnvironmentChoice(name="maze", parameters={"size_m": 20.0, "cells": 10}, seed="repetition"),
    ),
    strategies=("closest",),
    robots=(6,),
    starts=(StartsChoice(how="clustered", first="drawn"),),
    repetitions=1,
    first_seed=11,
    drive=DriveSpec(kind="holonomic"),
    range_finder=RangeFinderSpec(range_m=4.0),
)
FAMILY = ["closest", "greedy", "minpos", "utility", "self-bidding", "rules"]
WALLS = shapely.union_all(
    [
        box
        for x in (5.0, 10.2)
        for box in (shapely.box(x, 0, x + 0.2, 1.5), shapely.box(x, 2.7, x + 0.2, 5))
    ]
)
THREE_ROOMS = Environment("three rooms", shapely.box(0, 0, 15.4, 5).difference(WALLS))
STARTS = [(1.0, 1.0), (1.0, 2.5), (1.0, 4.0)]


# Two rooms, and between them a corridor in which two bodies cannot pass each other.
NARROW = Environment(
    "narrow",
    shapely.union_all(
        [shapely.box(0, 0, 5, 5), shapely.box(5, 2.1, 10, 2.9), shapely.box(10, 0, 15, 5)]
    ),
)


@pytest.fixture
def explored(monkeypatch):
    """Run a team; return the recording and the robots."""

    def run(name, starts=STARTS, *, world=THREE_ROOMS, options=None, max_time_s=1500.0, **spec):
        own = strategy(name)
        crew: list[FrontierExplorer] = []

        def explorer(me, options):
            built = own.explorer(me, options)
            assert isinstance(built, FrontierExplorer)
            crew.append(built)
            return built

        with monkeypatch.context() as patch:
            patch.setitem(registry._registry(), name, dataclasses.replace(own, explorer=explorer))
            recording = simulate(
                RunSpec(
                    environment=inline(world),
                    strategy=name,
                    options=options or {},
                    robots=tuple(RobotSpec(start=start) for start in starts),
                    stop=StopRule(max_time_s=max_time_s),
                    **spec,
                ),
                world,
            )
        return recording, [explorer.robot for explorer in crew]

    return run


def knowledge(raster):
    """The known cells of a raster, whatever its window."""
    known = np.argwhere(raster.cells != UNKNOWN)
    return (
        (known + np.array([raster.row, raster.column])).tolist(),
        raster.cells[*known.T].tolist(),
        raster.passable[*known.T].tolist(),
    )


@pytest.fixture
def raster_from_record(events_of):
    """Paint the regions that a robot saw or received, from the events alone."""

    def run(recording, robot, like):
        seen = {(e.robot, e.serial): e for e in events_of(recording, NodeAdded)}
        names = [(robot, e.serial) for e in events_of(recording, NodeAdded, robot)]
        names += [name for e in events_of(recording, Learned, robot) for name in e.nodes]
        raster = Occupancy(like.cell_m, like.radius_m)
        for name in names:
            node = seen[name]
            raster.add(
                LocalSafeRegion(
                    x=node.configuration[0],
                    y=node.configuration[1],
                    range_m=4.0,
                    boundary=np.array(node.boundary),
                    tags=np.array([*map(int, node.tags)], np.int8),
                )
            )
        return raster

    return run


@pytest.fixture
def sent(events_of):
    def run(recording, kind, robot=None):
        return [e for e in events_of(recording, Sent, robot) if e.kind == kind]

    return run


# What a robot knows ----------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_a_robot_knows_only_what_it_saw_or_was_told(raster_from_record, explored, name):
    radio = RadioSpec(range_m=3.0, loss=0.6)
    recording, crew = explored(name, radio=radio, seed=1, max_time_s=10.0)
    assert recording.footer.outcome == "out_of_time"
    known = []
    for number, robot in enumerate(crew):
        rebuilt = raster_from_record(recording, number, robot.raster)
        assert knowledge(robot.raster) == knowledge(rebuilt)
        known.append(len(knowledge(rebuilt)[0]))
    # They have not all come to know the same: the test could tell.
    assert len({*known}) > 1


# Radio -----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_lost_nodes_are_asked_for(events_of, sent, explored, name):
    recording, _ = explored(name, radio=RadioSpec(loss=0.4, latency_s=0.05), seed=1)
    assert recording.footer.outcome == "complete"
    assert not events_of(recording, Collision)
    assert any(e.lost for e in sent(recording, "report"))
    assert sent(recording, "want")
    assert sent(recording, "entries")


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_maps_are_equal_again_after_a_silence(sent, explored, name):
    recording, crew = explored(
        name, STARTS[:2], faults=(Silence(robot=1, time_s=3.0, duration_s=15.0),), seed=2
    )
    assert recording.footer.outcome == "complete"
    assert sent(recording, "want")
    first, second = (knowledge(robot.raster) for robot in crew)
    assert first == second


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
@pytest.mark.parametrize("multi_hop", [True, False])
def test_a_short_radio_range_is_enough(events_of, explored, name, multi_hop):
    recording, _ = explored(name, radio=RadioSpec(range_m=6.0, multi_hop=multi_hop), seed=1)
    assert recording.footer.outcome == "complete"
    assert not events_of(recording, Collision)
    assert measure(recording, THREE_ROOMS).coverage > 0.98


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_robots_in_range_at_the_end_have_the_same_map(explored, name):
    _, crew = explored(name, radio=RadioSpec(range_m=6.0), seed=1)
    for one, other in itertools.combinations(crew, 2):
        if math.dist(one.at[:2], other.at[:2]) <= 6.0:
            assert one.map.entries.have() == other.map.entries.have()
            assert knowledge(one.raster) == knowledge(other.raster)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_a_robot_that_joins_late_gets_the_map(events_of, explored, name):
    recording, crew = explored(name, STARTS[:2], faults=(LateStart(robot=1, time_s=20.0),), seed=1)
    assert recording.footer.outcome == "complete"
    (joined,) = events_of(recording, Joined)
    before = [e for e in events_of(recording, NodeAdded, 0) if e.time_s < joined.time_s]
    assert len(before) > 5
    soon = [
        name
        for e in events_of(recording, Learned, 1)
        if e.time_s <= joined.time_s + 1.0
        for name in e.nodes
    ]
    assert {(0, e.serial) for e in before} <= {*soon}
    assert knowledge(crew[0].raster) == knowledge(crew[1].raster)


# Deaths ----------------------------------------------------------------------------------------


def test_when_the_leader_dies_another_leads(events_of, sent, explored):
    recording, _ = explored("utility", faults=(Death(robot=0, time_s=8.0),), seed=1)
    (died,) = events_of(recording, Died)
    said = sent(recording, "assignment")
    assert {e.robot for e in said if e.time_s <= died.time_s} == {0}
    # Robot 2 may lead while robot 1 still waits for the dead one; in the end robot 1 leads.
    led_s = min(e.time_s for e in said if e.robot == 1)
    assert led_s > died.time_s
    led = {e.time_s for e in said if e.robot == 1}
    follows = [e for e in events_of(recording, GoalChosen, 2) if e.time_s in led]
    assert any(robot == 2 for e in follows for robot, *_ in e.rounds)
    assert recording.footer.outcome == "complete"
    assert measure(recording, THREE_ROOMS).coverage > 0.98
    assert not events_of(recording, Collision)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_no_robot_touches_a_dead_one_in_the_only_passage(events_of, explored, name):
    recording, crew = explored(
        name,
        [(7.0, 2.5), (2.0, 1.5), (2.0, 3.5)],
        world=NARROW,
        faults=(Death(robot=0, time_s=0.5),),
        seed=1,
        max_time_s=60.0,
    )
    (died,) = events_of(recording, Died)
    assert any(e.by == 0 for e in events_of(recording, Blocked))
    assert not events_of(recording, Collision)
    assert all(robot.at.x < died.configuration[0] - 0.5 for robot in crew[1:])
    assert not any(e.complete for e in events_of(recording, Ended))
    assert not events_of(recording, MapComplete)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_a_dead_robot_in_the_only_passage_boxes_others_in(events_of, explored, name):
    recording, _ = explored(
        name,
        [(7.0, 2.5), (2.0, 1.5), (2.0, 3.5)],
        world=NARROW,
        faults=(Death(robot=0, time_s=0.5),),
        seed=1,
        max_time_s=400.0,
    )
    assert recording.footer.outcome == "stalled"
    for robot in (1, 2):
        assert not events_of(recording, Ended, robot)[-1].complete
    reasons = [events_of(recording, Ended, robot)[-1].reason for robot in (1, 2)]
    assert any(reason.startswith("boxed in by robot 0,") for reason in reasons)
    assert not events_of(recording, MapComplete)


# Narrow ways -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FAMILY)
def test_robots_in_a_corridor_explore_both_its_ends(events_of, explored, name):
    recording, _ = explored(name, [(6.0, 2.5, 0.0), (9.0, 2.5, math.pi)], world=NARROW, seed=1)
    assert recording.footer.outcome == "complete"
    assert not events_of(recording, Collision)
    assert measure(recording, NARROW).coverage > 0.98


def going_to(places):
    """A rule by which every robot goes to its place, as far as it knows the way."""

    def rule(robot, because):
        x, y = places[robot.me.robot]
        if math.dist(robot.at[:2], (x, y)) < 0.3:
            return None
        yield from robot.bodies.look()
        with robot.around_bodies():
            field = robot.own_field()
            spots = robot.raster.passable_centres(*robot.at[:2], 20.0)
            spots = spots[np.isfinite(field.distance(robot.indices_of(spots)))]
            nearest = spots[np.argmin(np.hypot(*(spots - (x, y)).T))]
            return robot.goal_at(field, *nearest.tolist())

    return rule


@pytest.mark.parametrize("seed", range(4))
def test_robots_that_meet_in_a_corridor_pass_by_giving_way(events_of, sent, monkeypatch, seed):
    places = [(13.5, 2.5), (1.5, 2.5)]
    monkeypatch.setitem(
        registry._registry(),
        "swap-places",
        Strategy(
            name="swap-places",
            summary="",
            options=FrontierOptions,
            explorer=lambda me, options: FrontierExplorer(
                me, options, going_to(places), partial(drive, purpose="home", to_see=False)
            ),
        ),
    )
    recording = simulate(
        RunSpec(
            environment=inline(NARROW),
            strategy="swap-places",
            robots=(RobotSpec(start=(6.5, 2.5, 0.0)), RobotSpec(start=(8.5, 2.5, math.pi))),
            stop=StopRule(max_time_s=400.0),
            seed=seed,
        ),
        NARROW,
    )
    assert not events_of(recording, Collision)
    assert recording.footer.outcome == "complete"
    assert sent(recording, "give way")
    assert any(e.purpose == "give way" for e in events_of(recording, Motion))
    for robot, place in enumerate(places):
        last = events_of(recording, Motion, robot)[-1].waypoints[-1]
        assert math.dist(last[1:3], place) < 1.5


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILY)
def test_robots_in_a_crowd_do_not_creep_up_to_each_other(events_of, name):
    # In this drawn maze they begin close together: with any rule some stop before others, and
    # look for ways round them where there are none.
    crowd = next(run.spec for run in runs(CROWDS))
    spec = msgspec.structs.replace(crowd, strategy=name, stop=StopRule(max_time_s=12.0))
    recording = simulate(spec)
    assert not events_of(recording, Collision)
    stops = [[e for e in events_of(recording, Blocked) if e.robot == robot] for robot in range(6)]
    assert sum(map(len, stops)) > 0
    at_once = [
        later
        for of_one in stops
        for earlier, later in itertools.pairwise(of_one)
        if later.time_s - earlier.time_s < 1e-3
    ]
    assert len(at_once) <= 3
    least_m = MIN_SHARE * FrontierOptions().guard_m
    least = smallest_distance_between_robots(recording)
    assert least is not None
    assert least > 0.95 * least_m
