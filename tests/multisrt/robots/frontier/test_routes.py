"""ROUTES on a robot's own map: equal plans, goals that are kept, and whole runs."""

import math
from itertools import chain
from typing import Any

import pytest
import shapely

import multisrt as ms
from multisrt.environments.environment import Environment
from multisrt.events import GoalChosen
from multisrt.explain.srt import explain
from multisrt.robots.frontier.options import RoutesOptions

HALLS = Environment(
    "halls",
    shapely.union_all([shapely.box(0, 0, 8, 8), shapely.box(8, 3, 10, 5)]).union(
        shapely.box(10, 0, 18, 8)
    ),
)


def explored(**changes: Any) -> ms.Run:
    given: dict[str, Any] = {"strategy": "routes", "robots": 3, "seed": 2, "starts": "clustered"}
    return ms.explore(HALLS, **(given | changes))


@pytest.fixture(scope="module")
def run() -> ms.Run:
    return explored()


def routes_of(choice: GoalChosen) -> dict[int, list[int]]:
    """The targets on the route of each robot, in order."""
    routes: dict[int, list[int]] = {robot: [] for robot in choice.robots}
    for robot, target, _, _ in choice.rounds:
        routes[robot].append(target)
    return routes


def choices_of(run: ms.Run) -> list[GoalChosen]:
    return [e for e in run.recording.events if isinstance(e, GoalChosen)]


def test_a_team_explores_two_halls(run):
    assert run.metrics.outcome == "complete"
    assert run.metrics.coverage > 0.99
    assert run.metrics.collisions == 0


def test_equal_runs_are_equal(run):
    assert explored().recording.events == run.recording.events


def test_robots_that_know_the_same_plan_the_same_routes():
    # At the start all decide at one moment. They hear the first goals one after the other.
    run = explored(options={"keep_m": 0.0})
    first = choices_of(run)[:3]
    assert {e.robot for e in first} == {0, 1, 2}
    assert len({(e.time_s, e.frontiers) for e in first}) == 1
    assert len({tuple((r, t) for r, t, _, _ in e.rounds) for e in first}) == 1


def test_every_frontier_is_on_one_route(run):
    for choice in choices_of(run):
        if choice.rounds:
            visited = list(chain.from_iterable(routes_of(choice).values()))
            assert len(visited) == len(set(visited))
            own = choice.costs[choice.robots.index(choice.robot)]
            assert set(visited) == {k for k, cost in enumerate(own) if cost is not None}


def test_the_goal_is_the_first_stop_or_the_nearest(run):
    for choice in choices_of(run):
        if choice.goal is None:
            continue
        own = routes_of(choice)[choice.robot]
        if own:
            assert choice.goal == choice.frontiers[own[0]]
        else:
            row = choice.costs[choice.robots.index(choice.robot)]
            costs = {k: c for k, c in enumerate(row) if c is not None}
            assert choice.goal == choice.frontiers[min(costs, key=costs.__getitem__)]


def test_the_routes_are_explained(run):
    choice = next(e for e in choices_of(run) if routes_of(e)[e.robot])
    text = explain(run.recording, choice.robot, choice.time_s)
    assert "the first stop of its own route" in text
    own = [(target, at_m) for robot, target, _, at_m in choice.rounds if robot == choice.robot]
    stops = ", ".join(f"{target} at {at_m:.1f} m" for target, at_m in own)
    assert f"> robot {choice.robot}: {stops}" in text


def test_a_choice_of_no_goal_is_explained(run):
    last = choices_of(run)[-1]
    assert last.goal is None
    text = explain(run.recording, last.robot, last.time_s)
    assert "no goal: there is none that it can reach" in text
    assert "its own route is empty" not in text


def test_one_robot_explores_alone():
    alone = explored(robots=1)
    assert alone.metrics.outcome == "complete"
    assert {e.robot for e in choices_of(alone)} == {0}


def test_lengths_along_routes_grow(run):
    for choice in choices_of(run):
        for robot in choice.robots:
            along = [at_m for other, _, _, at_m in choice.rounds if other == robot]
            assert along == sorted(along)


def test_robots_without_radio_explore_alone():
    alone = explored(radio_range_m=0.0, robots=2)
    assert alone.metrics.coverage > 0.99


@pytest.mark.parametrize(
    ("name", "value"), [("turn_m_per_rad", -1.0), ("keep_m", math.inf), ("search_m_per_m2", -1.0)]
)
def test_bad_options_are_refused(name, value):
    with pytest.raises(ms.InvalidInputError, match=f"{name} is"):
        RoutesOptions(**{name: value})
