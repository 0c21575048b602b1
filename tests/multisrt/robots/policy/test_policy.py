"""Robots that go where a policy says."""

import functools

import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.environments.environment import Environment
from multisrt.events import GoalChosen
from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, UNKNOWN, Occupancy
from multisrt.geometry.regions.boundary import OBSTACLE, RANGE
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.policy import DecisionSpec, policy_strategy
from multisrt.robots.policy.observing import cells_around
from multisrt.robots.registry import registered

HALL = Environment("hall", shapely.box(0, 0, 16, 3), starts=[(8, 1.5)])
"""A robot in the middle sees 4 m to either side, and so two frontiers."""

FIRST = DecisionSpec(observe=("frontiers",))


def nearest(observation):
    return 0


def explore(policy, world=HALL, spec=FIRST, **keywords):
    with registered(policy_strategy("told", policy, spec)):
        return ms.explore(world, strategy="told", seed=1, **keywords)


def first_observation(spec, **keywords):
    seen = []

    def policy(observation):
        seen.append(observation)
        return 0

    explore(policy, spec=spec, range_m=4.0, max_time_s=1.0, **keywords)
    return seen[0]


@pytest.mark.slow
@pytest.mark.parametrize("robots", [1, 3])
def test_going_to_the_nearest_is_the_strategy_closest(robots):
    runs = [
        explore(nearest, "open", robots=robots),
        ms.explore("open", strategy="closest", seed=1, robots=robots, options={"replan": "target"}),
    ]
    told, closest = [[e for e in r.recording.events if not isinstance(e, GoalChosen)] for r in runs]
    assert told == closest


def test_frontiers_are_observed_nearest_first():
    seen = first_observation(FIRST, start=(7.0, 1.5))
    rows = seen["frontiers"]
    assert seen["action_mask"].tolist() == [1, 1, 0, 0, 0, 0, 0, 0, 0]
    assert rows[:2, 0] == pytest.approx([-4.0, 4.0], abs=0.2)
    assert rows[:2, 2] == pytest.approx(2.9, abs=0.15)
    assert (rows[:2, 3] >= np.hypot(rows[:2, 0], rows[:2, 1]) - 0.2).all()
    assert not rows[2:].any()
    assert seen["pose"][:2].tolist() == [7.0, 1.5]


def test_fewer_frontiers_than_there_are_can_be_observed():
    seen = first_observation(DecisionSpec(frontiers=1, observe=("frontiers",)))
    assert seen["frontiers"].shape == (1, 4)
    assert seen["action_mask"].tolist() == [1, 0]


def test_only_the_parts_that_are_named_are_observed():
    assert set(first_observation(DecisionSpec(observe=()))) == {"pose", "time", "action_mask"}
    full = first_observation(DecisionSpec(), robots=2, start=None)
    assert {"map", "others", "others_mask", "frontiers"} < set(full)


def test_the_number_chosen_is_the_frontier_gone_to():
    def second(observation):
        return int(observation["action_mask"][1])

    run = explore(second, range_m=4.0, start=(7.0, 1.5))
    first = run.recording.of(GoalChosen)[0]
    assert first.goal[0] == pytest.approx(11.0, abs=0.2)
    assert first.rule == "told"
    assert "told" in run.why(robot=0, time_s=1.0)


@pytest.mark.parametrize("number", [7, 8, -1, 100])
def test_a_number_not_allowed_leads_to_the_nearest(number):
    def wrong(observation):
        return number

    assert explore(wrong, range_m=4.0).recording.of(GoalChosen) == explore(
        nearest, range_m=4.0
    ).recording.of(GoalChosen)


@pytest.mark.parametrize("answer", ["left", None, 0.5, [0, 1]])
def test_an_answer_that_is_no_number_is_refused(answer):
    with pytest.raises(ms.InvalidInputError, match="whole number, not"):
        explore(lambda observation: answer)


PLACES = DecisionSpec(actions="place", place_m=4.0, observe=())


def test_a_place_is_gone_to_though_nothing_is_new_there():
    answers = iter([[0.25, 0.0]])

    def policy(observation):
        return next(answers, [np.nan, 0.0])

    run = explore(policy, spec=PLACES, range_m=4.0, start=(8.0, 1.5))
    first, second = run.recording.of(GoalChosen)[:2]
    assert first.goal == pytest.approx((9.0, 1.5), abs=0.1)
    assert second.because == "reached"
    assert run.outcome == "complete"


@pytest.mark.parametrize("offset", [(0.0, 1.0), (np.nan, 0.0), (np.inf, 0.0)])
def test_a_place_in_the_unknown_leads_to_the_nearest_frontier(offset):
    first = explore(lambda _: offset, spec=PLACES, range_m=4.0, max_time_s=5.0)
    goal = first.recording.of(GoalChosen)[0].goal
    assert abs(goal[0] - 8.0) == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize("answer", ["left", None, 0.5, [0, 1, 2], 3])
def test_an_answer_that_is_no_offset_is_refused(answer):
    with pytest.raises(ms.InvalidInputError, match="two numbers"):
        explore(lambda observation: answer, spec=PLACES)


def test_others_are_observed_as_they_were_heard():
    seen = []

    def policy(observation):
        seen.append(observation)
        return 0

    spec = DecisionSpec(observe=("others",))
    explore(policy, spec=spec, robots=2, starts=[(4, 1.5), (6, 1.5)], range_m=2.0)
    last = seen[-1]
    assert last["others"].shape == (1, 5)
    assert last["others_mask"][0, 0] == 1
    assert any(s["others_mask"][0].tolist() == [1, 1] for s in seen)
    heard = [s for s in seen if s["others_mask"][0, 0]]
    # The other is where it said: its own place plus the offset lies in the hall.
    for s in heard:
        x, y = s["pose"][:2] + s["others"][0, :2]
        assert 0 < x < 16
        assert 0 < y < 3
        assert s["others"][0, 4] >= 0.0


def test_nothing_is_observed_of_robots_that_are_not_heard():
    seen = []

    def policy(observation):
        seen.append(observation)
        return 0

    spec = DecisionSpec(observe=("others",))
    explore(policy, spec=spec, robots=2, starts=[(4, 1.5), (6, 1.5)], radio_range_m=0.0)
    assert seen
    assert not any(s["others"].any() or s["others_mask"].any() for s in seen)


def test_the_map_is_what_the_robot_has_seen():
    spec = DecisionSpec(observe=("map",), map_cells=60, map_scale=2)
    cells = first_observation(spec, start=(8.0, 1.5))["map"]
    assert cells.dtype == np.uint8
    assert cells[30, 30] == FREE
    assert OCCUPIED in cells[:, 30]
    # The middle row shows 4 m to either side, of 6 m; cells are 0.2 m wide.
    assert np.count_nonzero(cells[30] == FREE) == pytest.approx(40, abs=2)
    assert (cells[30, :8] == UNKNOWN).all()


def test_the_map_can_stay_where_the_robot_started():
    maps = []

    def policy(observation):
        maps.append(observation)
        return 0

    spec = DecisionSpec(observe=("map",), map_centre="start")
    explore(policy, spec=spec, range_m=4.0)
    assert len(maps) > 1
    free = maps[0]["map"] == FREE
    # What was free is known in the same cells ever after.
    assert (maps[-1]["map"][free] != UNKNOWN).all()
    assert maps[-1]["pose"][0] != maps[0]["pose"][0]


def test_cells_taken_together_keep_walls():
    corners = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
    tags = np.array([OBSTACLE, RANGE, OBSTACLE, OBSTACLE], np.int8)
    raster = Occupancy(0.1, 0.25)
    raster.add(LocalSafeRegion(x=1.0, y=1.0, range_m=3.0, boundary=corners, tags=tags))
    fine = cells_around(raster, (2.0, 1.5), 60, 1)
    coarse = cells_around(raster, (2.0, 1.5), 20, 3)
    assert fine.shape == (60, 60)
    assert fine[30, 30] == FREE
    wall = coarse[:, 10] == OCCUPIED
    assert wall.sum() == 2
    assert not (coarse[10] == OCCUPIED)[11:].any()


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"actions": "frontiers"}, "actions is frontier or place, not 'frontiers'"),
        ({"frontiers": 0}, "frontiers is a whole number from 1"),
        ({"place_m": float("inf")}, "place_m is a positive length"),
        ({"observe": ("map", "map")}, "names a part twice"),
        ({"map_cells": 2.5}, "map_cells is a whole number"),
        ({"map_centre": "world"}, "map_centre is robot or start"),
    ],
)
def test_a_spec_out_of_range_is_refused(fields, told):
    with pytest.raises(ms.InvalidInputError, match=told):
        DecisionSpec(**fields)


def test_a_car_is_not_driven_by_the_nearness_diagram():
    car = ms.RobotSpec(drive=ms.DriveSpec(kind="dubins", turning_radius_m=0.5))
    with pytest.raises(ms.InvalidInputError, match="is a car"):
        explore(nearest, robots=[car], options={"drive": "nearness-diagram"})


def test_a_strategy_is_one_of_the_module_of_its_policy():
    class Learned:
        def __call__(self, observation):
            return 0

    for policy in (Learned(), functools.partial(Learned.__call__, Learned())):
        assert policy_strategy("learned", policy).explorer.__module__ == __name__
