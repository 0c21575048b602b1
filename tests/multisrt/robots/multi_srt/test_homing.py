"""Robots of the SRT family deliver data, over their roadmap."""

import math

import msgspec
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned, Decided, Decision, Ended, Motion, NodeAdded
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.multi_srt import bring_home
from multisrt.robots.multi_srt.build_srt import take_steps
from multisrt.robots.multi_srt.progress import BoxedIn
from multisrt.robots.registry import strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    BaseSpec,
    Death,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

replace = msgspec.structs.replace

CORRIDOR = Environment("corridor", shapely.box(0, 0, 60, 2.4))


def spec_of(*starts, name="srt-radial", limit_s=150.0, radio_m=3.0, faults=(), **options):
    return RunSpec(
        environment=inline(CORRIDOR),
        strategy=name,
        options=options,
        robots=tuple(RobotSpec(start=start) for start in starts),
        radio=RadioSpec(range_m=radio_m),
        base=BaseSpec(x=1.0, y=1.2),
        stop=StopRule(max_time_s=limit_s),
        faults=faults,
    )


def told(recording, robot=0):
    return [(e.time_s, e.text) for e in recording.of(Decided) if e.robot == robot]


@pytest.mark.parametrize("name", ["srt-radial", "srt-star", "srt-ball"])
def test_it_is_home_in_time_with_all_that_it_knows(name):
    recording = simulate(spec_of((1.0, 1.2), name=name, home="in-time"))
    metrics = measure(recording, CORRIDOR)
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)
    assert metrics.coverage > 0.1
    # It may be heard on the way, with time left for more.
    assert len(told(recording)) <= 2
    assert all("time" in text for _, text in told(recording))
    [ended] = recording.of(Ended)
    assert not ended.complete
    assert ended.reason.startswith("no time is left")


def test_candidates_that_it_has_no_time_for_are_refused_and_others_are_not():
    recording = simulate(spec_of((1.0, 1.2), home="in-time"))
    nodes = {(0, e.serial): e for e in recording.of(NodeAdded)}

    def left_s(decision, place):
        # There at 0.5 m/s with half a turn (2 s); a quarter more home, by one hop more than from
        # here, with half a turn for each and one at the beginning; and 10 s in reserve.
        x, y, _ = nodes[decision.node].configuration
        away_m = math.dist((x, y), place)
        route, at = [(x, y)], nodes[decision.node]
        while at.parent is not None:
            at = nodes[0, at.parent[1]]
            route.append(at.configuration[:2])
        # It is heard within 3 m of x = 1: at the first such node of the route.
        while len(route) > 1 and math.dist(route[-2], (1.0, 1.2)) <= 2.95:
            route.pop()
        home_m = away_m + sum(map(math.dist, route, route[1:]))
        home_s = home_m / 0.5 * 1.25 + 2.0 * (len(route) - 1) + 2.0 + 10.0
        return 150.0 - decision.time_s - away_m / 0.5 - 2.0 - home_s

    late = [
        (decision, (x, y))
        for decision in recording.of(Decision)
        for x, y, reason in decision.candidates
        if reason == "no time"
    ]
    drawn = [(d, d.target) for d in recording.of(Decision) if d.choice == "draw"]
    assert len(late) > 3
    assert len(drawn) > 5
    assert all(left_s(decision, place) < 0.0 for decision, place in late)
    assert all(left_s(decision, place) >= 0.0 for decision, place in drawn)


def test_without_the_option_its_news_stay_out():
    recording = simulate(spec_of((1.0, 1.2), limit_s=100.0))
    metrics = measure(recording, CORRIDOR)
    assert told(recording) == []
    delivered_coverage = metrics.delivered_coverage
    assert delivered_coverage is not None
    assert delivered_coverage < 0.3 < metrics.coverage


def test_it_goes_home_when_that_is_worth_it_and_goes_on():
    recording = simulate(spec_of((1.0, 1.2), limit_s=300.0, home="worth", home_ratio=0.8))
    nodes = {
        (e.robot, e.serial): (e.time_s, shapely.Polygon(e.boundary))
        for e in recording.of(NodeAdded)
    }
    learned = {tuple(n): e.time_s for e in recording.of(BaseLearned) for n in e.nodes}
    turns = [time_s for time_s, text in told(recording) if "less than 80%" in text]
    assert len(turns) >= 3
    for time_s in turns:
        known = [area for name, (_, area) in nodes.items() if learned.get(name, 1e9) <= time_s]
        whole = [area for made_s, area in nodes.values() if made_s <= time_s]
        assert shapely.union_all(known).area / shapely.union_all(whole).area < 0.81
    metrics = measure(recording, CORRIDOR)
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)
    # After the deliveries it explores on.
    assert max(e.time_s for e in recording.of(Decision) if e.choice == "draw") > turns[-1] - 30.0


def test_a_robot_that_is_done_carries_the_rest_home():
    spec = spec_of((20.0, 1.2), limit_s=86_400.0, home="in-time")
    recording = simulate(spec)
    metrics = measure(recording, CORRIDOR)
    # Its root is out of reach of the base: it ends at a node that is not.
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)
    assert metrics.coverage > 0.95
    [ended] = recording.of(Ended)
    assert ended.complete


def test_robots_that_crowd_at_home_do_not_go_there_for_what_giving_way_showed():
    narrow = Environment("narrow", shapely.box(0, 0, 40, 1.6))
    finder = RangeFinderSpec(range_m=2.0)
    run = RunSpec(
        environment=inline(narrow),
        strategy="srt-radial",
        options={"home": "in-time"},
        robots=tuple(RobotSpec(start=(x, 0.8), range_finder=finder) for x in (14.0, 22.0, 24.0)),
        radio=RadioSpec(range_m=6.0, multi_hop=False),
        base=BaseSpec(x=1.0, y=0.8),
        stop=StopRule(max_time_s=1000.0),
        seed=1,
    )
    recording = simulate(run)
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s < 400.0
    metrics = measure(recording, narrow)
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=0.01)


def test_it_stops_on_its_way_home_once_all_is_delivered():
    # Walls block the radio: the base station hears it on the way to the node that is certain.
    run = spec_of((3.0, 1.2), limit_s=200.0, radio_m=12.0, home="in-time")
    run = replace(run, radio=RadioSpec(range_m=12.0, walls="block"))
    recording = simulate(run)
    made = [e.time_s for e in recording.of(NodeAdded)]
    told_s = [e.time_s for e in recording.of(BaseLearned) for _ in e.nodes]
    homewards = [m for m in recording.of(Motion) if m.purpose == "home"]
    assert homewards
    for motion in homewards:
        begin_s = motion.waypoints[0][0]
        known = sum(time_s <= begin_s for time_s in made)
        assert sum(time_s < begin_s for time_s in told_s) < known


def test_it_does_not_go_back_along_its_tree_where_there_is_no_time_for_anything():
    base = 2.0, 2.0
    run = replace(
        spec_of(base, name="srt-star", limit_s=150.0, home="in-time"),
        environment=inline(environment("rooms")),
        base=BaseSpec(x=base[0], y=base[1]),
        seed=1,
    )
    [ended] = simulate(run).of(Ended)
    assert ended.reason.startswith("no time is left")
    assert ended.time_s < 149.0


def test_a_robot_that_gives_up_where_it_was_stopped_has_a_node_there():
    run = RunSpec(
        environment=inline(environment("apartment")),
        strategy="srt-radial",
        options={"crowded_after": 1, "jammed_after": 1, "gives_up_after": 1},
        robots=(RobotSpec(),) * 5,
        starts="clustered",
        stop=StopRule(max_time_s=500.0),
        seed=1,
    )
    recording = simulate(run)
    nodes = [e.configuration[:2] for e in recording.of(NodeAdded)]
    last = {m.robot: m.waypoints[-1][1:3] for m in recording.of(Motion)}
    ended = {e.robot for e in recording.of(Ended)}
    assert ended
    for robot in ended:
        assert min(math.dist(last[robot], node) for node in nodes) < 1e-6


def test_a_teams_living_robots_bring_home_what_they_know():
    recording = simulate(
        spec_of(
            (1.0, 1.2),
            (2.5, 1.2),
            (4.0, 1.2),
            radio_m=12.0,
            limit_s=200.0,
            home="in-time",
            faults=(Death(robot=2, time_s=60.0),),
        )
    )
    metrics = measure(recording, CORRIDOR)
    assert metrics.collisions == 0
    own = {(e.robot, e.serial) for e in recording.of(NodeAdded) if e.robot != 2}
    delivered = {tuple(n) for e in recording.of(BaseLearned) for n in e.nodes}
    assert own <= delivered


def test_after_a_delivery_it_goes_on_where_it_was():
    # The base station is in the middle: the root of the tree, at the left end, is out of the way.
    hall = Environment("hall", shapely.box(0, 0, 80, 2))
    spec = replace(
        spec_of((1.0, 1.0), limit_s=2000.0, radio_m=12.0, home="worth"),
        environment=inline(hall),
        base=BaseSpec(x=30.0, y=1.0),
    )
    recording = simulate(spec)
    assert recording.footer.outcome == "complete"
    [first_s, *_] = [time_s for time_s, text in told(recording) if "less than" in text]
    [end] = recording.of(Ended)
    # A third of the hall is left to explore when it has delivered for the first time.
    back = [e.time_s for e in recording.of(Decision) if e.choice == "parent"]
    assert not any(first_s < time_s < end.time_s - 200.0 for time_s in back)
    assert end.time_s < 700.0


def test_a_way_home_that_is_barred_is_tried_again_later(monkeypatch):
    barred_s: list[float] = []

    def stopped(robot, choose):
        if len(barred_s) == 3:
            yield from take_steps(robot, choose)
        else:
            barred_s.append(robot.at.time_s)
            raise BoxedIn

    monkeypatch.setattr(bring_home, "take_steps", stopped)
    spec = spec_of((1.0, 1.2), limit_s=600.0, home="worth", home_ratio=0.8, home_wait_s=10.0)
    recording = simulate(spec)
    first_s, second_s, third_s = barred_s
    # It explores on for so long, where it was stopped, and then brings all home.
    assert second_s - first_s >= 10.0
    assert third_s - second_s >= 20.0
    assert any(first_s < n.time_s < second_s for n in recording.of(NodeAdded))
    metrics = measure(recording, CORRIDOR)
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)


def test_trees_have_no_relays():
    with pytest.raises(InvalidInputError, match="home='relays' of srt-star"):
        strategy("srt-star").parse_options({"home": "relays"})


def test_a_limit_too_short_and_a_missing_base_are_refused():
    with pytest.raises(InvalidInputError, match="too short to deliver data"):
        simulate(spec_of((59.0, 1.2), home="in-time", limit_s=100.0))
    with pytest.raises(InvalidInputError, match="srt-radial needs a base station"):
        strategy("srt-radial").require_fit(
            RunSpec(environment=inline(CORRIDOR), options={"home": "in-time"})
        )
