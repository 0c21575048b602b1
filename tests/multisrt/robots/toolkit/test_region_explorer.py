import math
from collections import Counter

import numpy as np
import pytest

import multisrt as ms
from multisrt.environments.catalog import environment
from multisrt.events import ArcClosed, Decided, NodeAdded, Sensed
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.toolkit import RegionExplorer, Teammate
from multisrt.robots.toolkit.region_explorer import within_disc

WORLD = environment("open", size_m=8.0, columns=2)


class Nearest(RegionExplorer):
    """To the nearest frontier."""

    def candidates(self):
        arcs = [arc for node in self.map.open_nodes() for arc in self.map.frontier_arcs(node)]
        return np.array([arc[len(arc) // 2, :2] for arc in arcs]).reshape(-1, 2)

    def choose(self):
        places = self.candidates()
        costs = self.costs(places)
        if not np.isfinite(costs).any():
            return None
        self.explain("the nearest", places, path_m=costs)
        return places[costs.argmin()]


@pytest.fixture(scope="module")
def team():
    return ms.explore(WORLD, strategy=Nearest, robots=2, seed=1)


def test_a_planner_explores_and_says_why(team):
    assert team.outcome == "complete"
    assert team.metrics.coverage > 0.95
    decisions = team.recording.of(Decided)
    assert {event.text for event in decisions} == {"the nearest", "no place is left"}
    for event in decisions:
        if event.goal is not None:
            path_m = [value for value in event.values["path_m"] if value is not None]
            assert event.values["path_m"][event.options.index(event.goal)] == min(path_m)


def test_scans_are_mapped_where_places_were_chosen(team):
    for robot in range(2):
        goals = [e.goal for e in team.recording.of(Decided) if e.robot == robot and e.goal]
        nodes = [e for e in team.recording.of(NodeAdded) if e.robot == robot][1:]
        assert nodes
        for node in nodes:
            assert min(math.dist(node.configuration[:2], goal) for goal in goals) < 0.8
    assert len(team.recording.of(Sensed)) > len(team.recording.of(NodeAdded))


@pytest.mark.parametrize("replan", ["target", "news"])
def test_a_planner_may_map_what_it_sees_on_the_way(replan):
    """Places where an arc is left, but no frontier of the raster, are driven to nevertheless."""
    options = {"sense": "moving", "replan": replan}
    run = ms.explore(WORLD, strategy=Nearest, robots=2, seed=1, options=options, max_time_s=300.0)
    assert run.outcome == "complete"
    assert run.metrics.coverage > 0.95
    # The same place may be chosen again on the way there, but not without end.
    goals = Counter((e.robot, e.goal) for e in run.recording.of(Decided) if e.goal is not None)
    assert max(goals.values()) < 10


def test_what_stays_frontier_after_a_scan_is_given_up_once(team):
    closed = team.recording.of(ArcClosed)
    assert {event.reason for event in closed} <= {"seen from near", "not reachable"}
    known = [(event.node, event.arc) for event in closed]
    assert len(known) == len(set(known))


def test_robots_know_of_each_other():
    heard: list[tuple[int, float, Teammate]] = []

    class Polite(Nearest):
        def choose(self):
            heard.extend((self.me.robot, self.time_s, teammate) for teammate in self.teammates())
            return super().choose()

    ms.explore(WORLD, strategy=ms.Strategy.of(Polite), robots=2, seed=1)
    assert {robot for robot, _, _ in heard} == {0, 1}
    assert all(teammate.robot == 1 - robot for robot, _, teammate in heard)
    assert any(teammate.goal is not None for _, _, teammate in heard)


@pytest.mark.parametrize(
    ("chosen", "told"),
    [
        ((500.0, 500.0), "choose returned (500, 500), where its body cannot stand"),
        ([(1.0, 1.0), (2.0, 2.0)], "choose returned 2 places"),
        ("there", "what choose returned is 'there'"),
    ],
)
def test_a_place_that_is_none_is_refused(chosen, told):
    class Wrong(RegionExplorer):
        def choose(self):
            return chosen

    with pytest.raises(ms.InvalidInputError) as error:
        ms.explore(WORLD, strategy=ms.Strategy.of(Wrong), seed=1)
    assert told in str(error.value)


def test_a_place_is_not_chosen_twice():
    class Stubborn(Nearest):
        def choose(self):
            self.first = getattr(self, "first", None) or tuple(super().choose())
            return self.first

    with pytest.raises(ExplorerDefect, match="which it has tried before"):
        ms.explore(WORLD, strategy=ms.Strategy.of(Stubborn), seed=1)


def test_it_is_given_as_a_class():
    with pytest.raises(ms.InvalidInputError, match="give the class, and not one that is built"):
        Nearest(None, None)  # type: ignore[arg-type]


def test_without_choose_there_is_no_explorer():
    class Nothing(RegionExplorer):
        pass

    with pytest.raises(TypeError, match="choose"):
        Nothing(None, None)  # type: ignore[abstract, arg-type]


def test_parts_of_segments_in_a_disc():
    segments = np.array(
        [[-9.0, 0.0, 9.0, 0.0], [0.0, 0.5, 0.0, 0.5], [0.5, 0.0, 0.5, 9.0], [9.0, 9.0, 9.0, 8.0]]
    )
    parts = within_disc(segments, (0.0, 0.0), 1.0)
    assert parts == pytest.approx(
        np.array([[-1.0, 0.0, 1.0, 0.0], [0.5, 0.0, 0.5, math.sqrt(0.75)]])
    )
    assert within_disc(np.empty((0, 4)), (0.0, 0.0), 1.0).shape == (0, 4)
