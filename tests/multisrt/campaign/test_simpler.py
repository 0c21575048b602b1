"""Specs that are simpler than one."""

from typing import Any

import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.campaign.draws import candidate
from multisrt.campaign.simpler import simplifications, subsets
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import (
    BaseSpec,
    CatalogEnvironment,
    Death,
    InlineEnvironment,
    LateStart,
    RobotSpec,
    RunSpec,
    StopRule,
)

MAZE = CatalogEnvironment(name="maze", parameters={"size_m": 10.0, "cells": 5}, seed=4)
TEAM = tuple(RobotSpec(footprint=f"disc:{radius}") for radius in (0.1, 0.2, 0.3, 0.4))


@given(st.integers(0, 12))
def test_parts_of_items_are_all_different_and_smaller(number):
    left = list(subsets(range(number)))
    assert len(set(left)) == len(left)
    assert all(len(part) < number for part in left)
    assert all(list(part) == sorted(part) for part in left)
    for item in range(number):
        assert tuple(other for other in range(number) if other != item) in left


def test_robots_that_stay_keep_their_faults():
    faults = (Death(robot=1, time_s=5.0), LateStart(robot=3, time_s=2.0))
    spec = RunSpec(environment=MAZE, robots=TEAM, faults=faults)
    pairs = [
        simpler
        for simpler in simplifications(spec)
        if [robot.footprint for robot in simpler.robots] == ["disc:0.3", "disc:0.4"]
    ]
    assert [pair.faults for pair in pairs] == [(LateStart(robot=1, time_s=2.0),)]


def test_a_shorter_run_has_no_faults_after_its_end():
    stop = StopRule(max_time_s=100.0)
    spec = RunSpec(environment=MAZE, faults=(Death(robot=0, time_s=60.0),), stop=stop)
    shorter = [s for s in simplifications(spec, 20.0) if s.stop.max_time_s < 100.0]
    assert [s.stop.max_time_s for s in shorter] == [21.0, 50.0, 80.0]
    assert [len(s.faults) for s in shorter] == [0, 0, 1]


def test_a_shorter_run_ends_after_its_violation():
    spec = RunSpec(environment=MAZE, stop=StopRule(max_time_s=6000.0))
    ends_s = [s.stop.max_time_s for s in simplifications(spec, 1232.0)]
    assert min(ends_s) == 1233.0


def test_parameters_below_the_smallest_are_not_tried():
    world = CatalogEnvironment(name="maze", parameters={"size_m": 10.0, "cells": 1})
    worlds: list[Any] = [s.environment for s in simplifications(RunSpec(environment=world))]
    assert 0 not in [one.parameters.get("cells", 1) for one in worlds if one.name == "maze"]


def test_a_world_becomes_a_hall_or_smaller():
    worlds: list[Any] = [s.environment for s in simplifications(RunSpec(environment=MAZE))]
    assert CatalogEnvironment(name="open", parameters={"size_m": 5.0}) in worlds
    assert any(world.name == "maze" and world.parameters.get("cells") == 2 for world in worlds)
    assert any(world.name == "maze" and world.seed is None for world in worlds)


def test_holes_of_a_shape_are_left_out_one_by_one():
    hall: Any = shapely.box(0, 0, 9, 9)
    for x in (1, 4, 7):
        hall = hall.difference(shapely.box(x, 3, x + 1, 5))
    spec = RunSpec(environment=InlineEnvironment(name="hall", wkt=hall.wkt))
    shapes: list[Any] = [
        shapely.from_wkt(simpler.environment.wkt)
        for simpler in simplifications(spec)
        if isinstance(simpler.environment, InlineEnvironment)
    ]
    assert {len(shape.interiors) for shape in shapes} >= {0, 1, 2}


def test_without_a_base_no_news_are_brought_home():
    spec = RunSpec(environment=MAZE, base=BaseSpec(x=1, y=1), options={"home": "worth", "alpha": 1})
    assert any(s.base is None and s.options == {"alpha": 1} for s in simplifications(spec))


def test_every_simplification_of_missions_differs_and_is_a_spec():
    for number in range(12):
        try:
            spec = candidate(3, number, 0)
        except InvalidInputError:
            continue
        found = list(simplifications(spec, 5.0))
        assert len(found) > 5
        for simpler in found:
            assert simpler != spec
            assert RunSpec.from_toml(simpler.to_toml()) == simpler


def test_the_simplest_spec_has_few_simplifications():
    hall = CatalogEnvironment(name="open", parameters={"size_m": 5.0})
    plain = RunSpec(environment=hall, stop=StopRule(max_time_s=1.0), starts="clustered")
    for simpler in simplifications(plain):
        assert simpler.environment != hall or simpler.robots != plain.robots
