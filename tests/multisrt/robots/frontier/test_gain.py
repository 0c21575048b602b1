"""GAIN on a robot's own map: areas, equal plans, and whole runs."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.environments.environment import Environment
from multisrt.events import GoalChosen
from multisrt.explain.srt import explain
from multisrt.geometry.grids.occupancy import UNKNOWN
from multisrt.robots.frontier import gain
from multisrt.robots.frontier.areas import areas_beyond
from multisrt.robots.frontier.gain import return_area_m2
from multisrt.robots.frontier.options import GainOptions
from multisrt.robots.robot_self import RadioSelf

CELL_M = 0.1
HALLS = Environment(
    "halls",
    shapely.union_all([shapely.box(0, 0, 8, 8), shapely.box(8, 3, 10, 5)]).union(
        shapely.box(10, 0, 18, 8)
    ),
)


def test_areas_are_in_square_metres():
    robot: Any = SimpleNamespace(
        me=SimpleNamespace(range_m=4.0),
        raster=SimpleNamespace(cell_m=CELL_M, cells=np.full((5, 5), UNKNOWN, np.uint8)),
        indices_of=lambda _: np.array([[2, 2]]),
    )
    assert areas_beyond(robot, np.zeros((1, 2))) == pytest.approx([math.pi * 4.0**2])


@pytest.mark.parametrize(
    ("radio", "area_m2"),
    [(RadioSelf(), 1.5), (RadioSelf(range_m=9.0, reaches_all=False), 6.0)],
)
def test_robots_that_always_hear_each_other_share_the_return_area(radio, area_m2):
    robot: Any = SimpleNamespace(
        me=SimpleNamespace(radio=radio), options=GainOptions(return_area_m2=6.0)
    )
    costs: Any = SimpleNamespace(robots=[0, 1, 3, 4])
    assert return_area_m2(robot, costs) == area_m2


def explored(**changes: Any) -> ms.Run:
    given: dict[str, Any] = {"strategy": "gain", "robots": 3, "seed": 2, "starts": "clustered"}
    return ms.explore(HALLS, **(given | changes))


def goals(run: ms.Run) -> list[GoalChosen]:
    events = run.recording.events
    return [e for e in events if isinstance(e, GoalChosen) and e.goal is not None]


@pytest.fixture(scope="module")
def run() -> ms.Run:
    return explored()


def test_a_team_explores_two_halls(run):
    assert run.metrics.outcome == "complete"
    assert run.metrics.coverage > 0.99
    assert run.metrics.collisions == 0


def test_equal_runs_are_equal(run):
    assert explored().recording.events == run.recording.events


def test_robots_that_know_the_same_agree():
    # With an unlimited radio all know the same: at the start they decide at one moment, and each
    # plan is the beginning of one order. They hear the first goals one after the other.
    run = explored(options={"keep_m": 0.0})
    first = [e for e in run.recording.events if isinstance(e, GoalChosen)][:3]
    assert {e.robot for e in first} == {0, 1, 2}
    assert len({(e.time_s, e.frontiers) for e in first}) == 1
    longest = max((e.rounds for e in first), key=len)
    for choice in first:
        rounds = [pair[:2] for pair in choice.rounds]
        assert rounds == [pair[:2] for pair in longest][: len(rounds)]
        assert choice.frontiers[rounds[-1][1]] == choice.goal


def test_the_decisions_are_recorded_and_explained(run):
    choices = [e for e in run.recording.events if isinstance(e, GoalChosen)]
    assert {e.rule for e in choices} == {"gain"}
    taken = next(e for e in choices if e.goal is not None and len(e.rounds) == 1)
    robot, target, area, value = taken.rounds[-1]
    assert robot == taken.robot
    assert taken.frontiers[target] == taken.goal
    assert area > 0.0
    assert value > 0.0
    text = explain(run.recording, robot, taken.time_s)
    assert "the largest area to be seen for its cost" in text
    assert f"robot {robot} got frontier {target}, " in text
    assert f": {area:.1f} m2, value {value:.3g}\n" in text
    assert "first stop" not in text


def test_a_tour_that_decides_is_explained():
    run = explored(robots=1, seed=3)
    choices = [e for e in run.recording.events if isinstance(e, GoalChosen)]
    by_tour = next(e for e in choices if [pair[0] for pair in e.rounds].count(e.robot) > 1)
    stop = by_tour.rounds[-1][1]
    text = explain(run.recording, by_tour.robot, by_tour.time_s)
    assert f"by value and tour length, frontier {stop} is the first stop of its tour\n" in text


def test_driving_backwards_changes_a_run(run):
    turned = explored(options={"saves_turns": False})
    assert turned.metrics.outcome == "complete"
    assert turned.recording.events != run.recording.events


def test_robots_without_radio_explore_alone():
    alone = explored(radio_range_m=0.0, robots=2)
    assert alone.metrics.coverage > 0.99


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("power", 0.0),
        ("return_area_m2", -1.0),
        ("turn_m_per_rad", math.inf),
        ("keep_m", -1.0),
        ("tour_weight", -1.0),
        ("room_m2", math.nan),
        ("routes_below_m2", -1.0),
    ],
)
def test_bad_options_are_refused(name, value):
    with pytest.raises(ms.InvalidInputError, match=f"{name} is"):
        GainOptions(**{name: value})


def test_below_an_area_in_sight_robots_choose_by_routes(run):
    always = explored(options={"routes_below_m2": 1000.0, "keep_m": 2.0})
    assert goals(always) == goals(explored(strategy="routes"))
    later = explored(options={"routes_below_m2": 29.0})
    rules = [e.rule for e in goals(later)]
    assert set(rules) == {"gain", "routes"}
    assert rules[0] == "gain"
    choice = next(e for e in goals(later) if e.rule == "routes")
    text = explain(later.recording, choice.robot, choice.time_s)
    assert "as no frontier that it can go to has 29 m2 in sight" in text


def test_a_robot_finishes_its_room_first(monkeypatch):
    asked = []

    def are_on_the_right(_, targets, room_m2):
        asked.append(room_m2)
        return targets[:, 0] > 9.0

    monkeypatch.setattr(gain, "are_in_own_room", are_on_the_right)
    run = explored(robots=1, options={"room_m2": 12.0})
    choices = goals(run)
    assert set(asked) == {12.0}
    turn = next(k for k, e in enumerate(choices) if max(x for x, _ in e.frontiers) > 9.0)
    for choice in choices[turn:]:
        on_the_right = [x for x, _ in choice.frontiers if x > 9.0]
        assert choice.goal is not None
        assert choice.goal[0] > 9.0 or not on_the_right
        assert choice.rule == ("room" if on_the_right else "gain")
    several = next(e for e in choices if e.rule == "room" and len(e.rounds) > 1)
    text = explain(run.recording, 0, several.time_s)
    assert "How it chose: room" in text
    assert "of the frontiers in its room, the largest area to be seen for its cost" in text
    assert f"frontier {several.rounds[-1][1]} is the first stop of its tour there" in text


@pytest.mark.parametrize("options", [{"room_m2": 30.0}, {"room_m2": 30.0, "routes_below_m2": 25.0}])
def test_teams_finish_rooms_first(options):
    found = ms.explore("rooms", strategy="gain", robots=3, seed=2, options=options)
    assert found.metrics.outcome == "complete"
    assert found.metrics.coverage > 0.99
    assert found.metrics.collisions == 0
    usual = ms.explore("rooms", strategy="gain", robots=3, seed=2)
    assert found.recording.events != usual.recording.events


def test_rooms_need_tours():
    with pytest.raises(ms.InvalidInputError, match="0 without tours"):
        GainOptions(room_m2=30.0, tour_weight=0.0)
