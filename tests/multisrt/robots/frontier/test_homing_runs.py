"""Robots that go to frontiers deliver data: in corridors, with answers worked out by hand."""

import dataclasses
import itertools
import math
from typing import Any

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned, Decided, Ended, GoalChosen, Motion, NodeAdded, PresumedLost
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.explorer import Done, Note, RadioSelf, RobotSelf, Sighting
from multisrt.robots.frontier.alvarez import Rules
from multisrt.robots.frontier.gain import choose_gain
from multisrt.robots.frontier.options import (
    BiddingOptions,
    FrontierOptions,
    GainOptions,
    RoutesOptions,
    RulesOptions,
    SelfBiddingOptions,
    UtilityOptions,
)
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.routes import choose_routes
from multisrt.robots.frontier.self_bidding import choose_by_self_bidding
from multisrt.robots.frontier.utility import choose_utility
from multisrt.robots.frontier.wavefront_costs import WavefrontCosts
from multisrt.robots.frontier.wavefront_rules import choose_closest, choose_greedy, choose_minpos
from multisrt.robots.registry import registered
from multisrt.robots.strategy import Strategy
from multisrt.robots.toolkit import RegionExplorer
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    BaseSpec,
    Death,
    DriveSpec,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

# A corridor of 60 m, with the base station at its left end.
NARROW = Environment("narrow", shapely.box(0, 0, 60, 1.2))
WIDE = Environment("wide", shapely.box(0, 0, 60, 2.4))
NEAR = RadioSpec(range_m=3.0)


def go(world, *starts, strategy="closest", limit_s=400.0, base=(1.0, 0.6), **changes):
    options = {key: changes.pop(key) for key in list(changes) if key.startswith("home")}
    drive = changes.pop("drive", DriveSpec())
    fields = {"radio": NEAR} | changes
    return simulate(
        RunSpec(
            environment=inline(world),
            strategy=strategy,
            options=options,
            robots=tuple(RobotSpec(start=start, drive=drive) for start in starts),
            base=BaseSpec(x=base[0], y=base[1]),
            stop=StopRule(max_time_s=limit_s),
            **fields,
        )
    )


def same(coverage):
    return pytest.approx(coverage, abs=1e-9)


def told(recording, robot=0):
    return [(e.time_s, e.text) for e in recording.of(Decided) if e.robot == robot]


def place_at(recording, time_s, robot=0):
    """Where a robot was."""
    place = recording.header.starts[robot][:2]
    for motion in recording.of(Motion):
        if motion.robot == robot:
            for t, x, y, _ in motion.waypoints:
                if t <= time_s:
                    place = x, y
    return place


def lost(recording):
    # A robot that is dead may also be met on the way.
    return {(e.robot, e.other) for e in recording.of(PresumedLost)}


# In time -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def in_time():
    """One robot, 100 s, a radio of 3 m."""
    return go(NARROW, (1.0, 0.6), home="in-time", limit_s=100.0)


def left_s(choice, goal):
    """Time that a goal leaves: at 0.5 m/s there, and home to x = 3.5 with a quarter more."""
    there_s = choice.time_s + (goal[0] - x_of(choice)) / 0.5
    # The node at x = 3.5 is the last within 3 m of the base; half a turn is 2 s, and 10 s are left
    # at home, besides two legs of a second each of which takes 2.25 s.
    return 100.0 - there_s - (goal[0] - 3.5) / 0.5 * 1.25 - 2.0 - 10.0 - 4.5


def x_of(choice):
    # It drives on at 0.5 m/s from x = 1 without a turn.
    return 1.0 + 0.5 * choice.time_s


def test_it_turns_back_when_the_next_goal_and_the_way_home_do_not_fit(in_time):
    [(turned_s, text)] = told(in_time)
    assert text == "goes home: there is no time for another goal and the way home"
    choices = [c for c in in_time.of(GoalChosen) if c.time_s <= turned_s]
    *fitting, last = choices
    assert last.time_s == turned_s
    # Half a cell of the goal's place, on both ways, is 0.5 s.
    assert all(left_s(choice, choice.goal) > -0.5 for choice in fitting)
    # The frontier ahead is known, and no candidate.
    [ahead] = last.frontiers
    assert last.goal is None
    assert left_s(last, ahead) < 0.5
    # That is, with goals 4 m ahead and one choice in 2 s, at 32 s and x = 17.
    assert (turned_s, place_at(in_time, turned_s)[0]) == (32.0, pytest.approx(17.0, abs=0.05))


def test_all_that_it_saw_is_delivered_as_soon_as_it_is_heard(in_time):
    metrics = measure(in_time, NARROW)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage == pytest.approx(21.0 / 60.0, abs=0.005)
    *_, last = in_time.of(BaseLearned)
    nodes = {(e.robot, e.serial) for e in in_time.of(NodeAdded)}
    assert {tuple(n) for e in in_time.of(BaseLearned) for n in e.nodes} == nodes
    # 13 m from x = 17 to where the base hears it, and half a turn: 28 s after 32 s.
    x, _ = place_at(in_time, last.time_s)
    assert x == pytest.approx(4.0, abs=0.15)
    assert last.time_s == pytest.approx(60.0, abs=0.5)
    [ended] = in_time.of(Ended)
    assert not ended.complete
    assert ended.reason == "no time is left for another goal and the way home"
    assert {m.purpose for m in in_time.of(Motion)} == {"explore", "home"}


def test_without_the_option_nothing_is_brought_home():
    recording = go(NARROW, (1.0, 0.6), limit_s=100.0)
    metrics = measure(recording, NARROW)
    assert told(recording) == []
    assert metrics.coverage > 0.85
    # What it saw when it was last heard: from x = 4 up to x = 8.
    assert metrics.delivered_coverage == pytest.approx(8.0 / 60.0, abs=0.01)


def test_a_robot_that_has_explored_all_brings_it_home():
    world = Environment("short", shapely.box(0, 0, 20, 1.2))
    recording = go(world, (1.0, 0.6), home="in-time")
    [(_, text)] = told(recording)
    assert text == "goes home: it knows of nothing that is left to explore"
    metrics = measure(recording, world)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.99
    [ended] = recording.of(Ended)
    assert ended.complete


def corridor_robot(kind=FrontierOptions, **options):
    """A robot at x = 13.5 in the narrow corridor that has scanned every half metre."""
    me = RobotSelf(
        robot=0,
        start=Configuration(1.0, 0.6, 0.0),
        footprint=Footprint.disc(0.25),
        kinematics=Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2),
        range_m=4.0,
        rng=np.random.default_rng(1),
        base=(1.0, 0.6),
        radio=RadioSelf(range_m=3.0, reaches_all=False),
        limit_s=100.0,
    )
    robot = FrontierRobot(me, kind(home="in-time", **options))
    index = EdgeIndex(NARROW.edges, 1.5)
    for x in np.arange(1.0, 13.6, 0.5):
        robot.map.add(take_scan(index, Configuration(x, 0.6, 0.0), x, 4.0))
    robot.course.arrive(Configuration(13.5, 0.6, 0.0), 0.0)
    return robot


def test_it_is_called_home_on_the_way_when_the_time_has_come():
    # 10 m to x = 3.5 take 20 s, 5 s of margin and 2 s for half a turn; 10 s in reserve, and two
    # legs of 2.25 s: 41.5 s before the end.
    robot = corridor_robot()
    for time_s, called in ((0.0, False), (40.0, False), (58.2, False), (58.8, True), (99.0, True)):
        robot.course.time_s = time_s
        assert robot.is_called_home() is called
    # The time that was found to be left is not asked for again, and is not too long.
    robot = corridor_robot()
    assert not robot.is_called_home()
    robot.course.time_s = 58.8
    assert robot.is_called_home()


def test_who_was_not_heard_goes_nearer_to_the_base_until_it_is_heard_again():
    robot = corridor_robot()
    homing, team = robot.homing, robot.team

    def ends_at():
        return homing.errand("").goal.place[0]

    # The base station at x = 1 hears it at 3 m, less 5 cm.
    assert ends_at() == pytest.approx(3.95, abs=0.1)
    assert homing.in_time(np.array([[13.5, 0.6]]), np.array([0.0]))[0]
    robot.course.time_s = 50.0
    homing.note_unheard(50.0)
    assert ends_at() == pytest.approx(1.0, abs=0.2)
    # The path home is longer by 3 m, or 7.5 s with their margin.
    robot.course.time_s = 55.0
    assert robot.is_called_home()
    team.base_heard_s = 54.0
    assert ends_at() == pytest.approx(3.95, abs=0.1)
    assert not robot.is_called_home()


BRANCHED = Environment(
    "branched", shapely.union_all([shapely.box(0, 0, 60, 1.2), shapely.box(4.4, 1.2, 5.6, 12)])
)
CHOOSERS = {
    "closest": (choose_closest, BiddingOptions),
    "greedy": (choose_greedy, BiddingOptions),
    "minpos": (choose_minpos, BiddingOptions),
    "utility": (choose_utility, UtilityOptions),
    "self-bidding": (choose_by_self_bidding, SelfBiddingOptions),
    "rules": (Rules().choose, RulesOptions),
    "gain": (choose_gain, GainOptions),
    "routes": (choose_routes, RoutesOptions),
}


def branched_robot(kind=FrontierOptions):
    """A robot at x = 17 of a corridor that has a branch at x = 5, of which it saw the mouth."""
    robot = corridor_robot(kind)
    index = EdgeIndex(BRANCHED.edges, 1.5)
    robot = FrontierRobot(robot.me, kind(home="in-time"))
    for x in np.arange(1.0, 17.1, 0.5):
        robot.map.add(take_scan(index, Configuration(x, 0.6, 0.0), x, 4.0))
    robot.course.arrive(Configuration(17.0, 0.6, 0.0), 0.0)
    return robot


@pytest.mark.parametrize("rule", CHOOSERS)
def test_every_rule_chooses_among_the_goals_that_there_is_time_for(rule):
    # Ahead, at x = 21: 8 s there, 17.5 m or 43.75 s home to x = 3.5, 2 s for half a turn, 10 s in
    # reserve and 4.5 s for two legs: it fits until 31.75 s. In the branch, at (5, 4.6): some 16 m
    # or 32 s there, 5.5 m or 13.75 s home, and 16.5 s: it fits until 37 s or so.
    choose, kind = CHOOSERS[rule]
    ahead, branch, neither = (chosen_at(choose, kind, time_s) for time_s in (30.0, 34.0, 41.0))
    if rule == "closest":
        assert ahead.x == pytest.approx(20.9, abs=0.2)
    assert ahead is not None
    assert branch.x == pytest.approx(5.0, abs=0.4)
    assert branch.y == pytest.approx(4.5, abs=0.3)
    assert neither is None


def chosen_at(choose, kind, time_s):
    robot = branched_robot(kind)
    robot.course.time_s = time_s
    notes: list[Any] = []
    goal = finished(choose(robot, Event.START), notes)
    assert all(isinstance(note, Note) for note in notes)
    assert robot.homing.has_left_out is (time_s > 31.75)
    assert goal is None or robot.homing.fits(goal)
    return goal


def finished(steps, notes):
    """Return what a generator returns."""

    def whole():
        result.append((yield from steps))

    result: list[Any] = []
    notes.extend(whole())
    [made] = result
    return made


def test_random_goals_are_among_those_that_there_is_time_for():
    chosen = []
    for seed in range(10):
        robot = branched_robot(RulesOptions)
        robot.course.arrive(Configuration(9.0, 0.6, 0.0), 0.0)
        # Of the corridor of 21 m, there is time to go to x = 14 or so and home.
        robot.course.time_s = 40.0
        robot.me = dataclasses.replace(robot.me, rng=np.random.default_rng(seed))
        rules = Rules()
        rules.in_vain = 99
        goal = finished(rules.choose(robot, Event.NO_WAY), [])
        assert robot.homing.fits(goal)
        chosen.append(rules.wanders)
    assert any(chosen)


def test_bodies_in_the_way_do_not_change_ways_home_that_are_kept():
    robot = branched_robot(BiddingOptions)
    robot.course.time_s = 34.0
    # A body bars the corridor between the robot and home, where no way home was asked for before.
    robot.bodies.add(
        Sighting(
            robot=1, configuration=Configuration(10.0, 0.6, 0.0), footprint=Footprint.disc(0.5)
        )
    )
    with robot.around_bodies():
        robot.fitting_costs(robot.own_field(), robot.targets())
    # From x = 15 to x = 3.5, as if the body were not there: it may leave.
    lengths = robot.homing._home_paths.lengths(np.array([(15.05, 0.65)]))
    assert lengths[0] == pytest.approx(11.5, abs=0.3)


def test_the_others_are_assigned_what_this_robot_has_no_time_for():
    # Robot 1 stands at x = 18 and is nearer to the goal ahead, which robot 0 has no time for.
    robot = branched_robot(BiddingOptions)
    robot.course.time_s = 34.0
    report = robot.team.own_report()
    place = (18.0, 0.6, 0.0)
    robot.team.teammates.take(
        msgspec.structs.replace(report, robot=1, place=place, phase="driving")
    )
    costs = WavefrontCosts(robot)
    [late] = [k for k, (x, _) in enumerate(costs.targets.tolist()) if x > 20.0]
    frontiers = np.arange(len(costs.targets))
    mine, theirs = costs.nearest(0, frontiers), costs.nearest(1, frontiers)
    assert mine is not None
    assert theirs is not None
    assert mine[1] != late
    assert theirs[1] == late
    assert costs.own_cost(late) == math.inf


def test_after_its_delivery_it_goes_to_what_is_near_and_ends_when_nothing_is():
    world = Environment(
        "branches",
        shapely.union_all(
            [shapely.box(0, 0, 60, 1.2), *(shapely.box(x, 1.2, x + 1, 9) for x in (10, 16))]
        ),
    )
    recording = go(world, (1.0, 0.6), home="in-time", strategy="gain", limit_s=130.0)
    metrics = measure(recording, world)
    assert metrics.delivered_coverage == same(metrics.coverage)
    choices = recording.of(GoalChosen)
    # It went on by choices that were not the nearest to where it was, nor the last of its life.
    late = [c for c in choices if c.goal is not None and None in c.costs[0]]
    assert late
    [ended] = recording.of(Ended)
    assert ended.reason == "no time is left for another goal and the way home"
    assert ended.time_s <= 130.0


def test_a_robot_that_carries_nothing_is_not_called_home():
    robot = corridor_robot()
    robot.course.time_s = 80.0
    assert robot.is_called_home()
    robot.team.base_has = robot.map.entries.have()
    assert not robot.is_called_home()


def test_who_knows_no_way_home_goes_on():
    # It begins 30 m from the base station, and has to find the way.
    recording = go(NARROW, (31.0, 0.6), home="in-time", limit_s=300.0)
    metrics = measure(recording, NARROW)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.5


def test_behind_walls_it_goes_to_where_nothing_is_in_between():
    # The base is behind a wall that the robot passes at 1 m from it, but without a line of sight.
    walls = shapely.box(4.0, 1.2, 12.0, 1.4)
    world = Environment("bend", shapely.box(0, 0, 24, 3).difference(walls))
    radio = RadioSpec(range_m=6.0, walls="block")
    recording = go(world, (1.0, 0.6), home="in-time", limit_s=120.0, base=(1.0, 2.4), radio=radio)
    metrics = measure(recording, world)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.8
    assert metrics.collisions == 0


def test_lost_messages_are_sent_again():
    radio = RadioSpec(range_m=3.0, loss=0.6, latency_s=0.1)
    recording = go(NARROW, (1.0, 0.6), home="in-time", limit_s=100.0, radio=radio)
    metrics = measure(recording, NARROW)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.25


def test_a_robot_without_a_radio_does_not_wait_for_ever():
    silence = Silence(robot=0, time_s=10.0, duration_s=1000.0)
    recording = go(
        NARROW, (1.0, 0.6), home="in-time", limit_s=900.0, faults=(silence,), home_wait_s=20.0
    )
    assert recording.footer.outcome == "complete"
    # All is explored at some 112 s; 104 s home, and two waits of 20 s.
    assert 230.0 < recording.footer.time_s < 330.0
    delivered_coverage = measure(recording, NARROW).delivered_coverage
    assert delivered_coverage is not None
    assert delivered_coverage < 0.2


def test_a_carrier_that_dies_loses_what_it_carries():
    recording = go(
        NARROW, (1.0, 0.6), home="in-time", limit_s=100.0, faults=(Death(robot=0, time_s=40.0),)
    )
    metrics = measure(recording, NARROW)
    assert metrics.coverage == pytest.approx(21.0 / 60.0, abs=0.005)
    assert metrics.delivered_coverage == pytest.approx(8.0 / 60.0, abs=0.01)


def test_a_body_that_bars_the_way_home_ends_no_exploration():
    # Robot 1 dies behind robot 0, in a corridor where there is no room to pass.
    recording = go(
        NARROW,
        (2.0, 0.6),
        (1.0, 0.6),
        home="in-time",
        limit_s=300.0,
        strategy="minpos",
        faults=(Death(robot=1, time_s=25.0),),
    )
    metrics = measure(recording, NARROW)
    assert metrics.collisions == 0
    assert metrics.coverage > 0.99


@pytest.mark.parametrize(
    ("limit_s", "base", "match"),
    [
        (11.0, (1.0, 0.6), "11 s is too short to deliver data: robot 0 begins at 0 s, 0 m"),
        (
            100.0,
            (58.0, 0.6),
            "robot 0 begins at 0 s, 57 m from the base station, .* at least 147 s",
        ),
    ],
)
def test_a_limit_that_is_too_short_is_refused(limit_s, base, match):
    with pytest.raises(InvalidInputError, match=match):
        go(NARROW, (1.0, 0.6), home="in-time", limit_s=limit_s, base=base)


def test_the_limit_that_is_named_is_enough_for_all_robots():
    starts = [(1.0, 0.6), (31.0, 0.6), (11.0, 0.6)]
    with pytest.raises(InvalidInputError, match=r"robot 1 begins .* of at least 80 s"):
        go(NARROW, *starts, home="in-time", limit_s=10.0)
    with pytest.raises(InvalidInputError, match="at least 80 s"):
        go(NARROW, *starts, home="in-time", limit_s=79.0)
    go(NARROW, *starts, home="in-time", limit_s=80.0)


# Worth it ----------------------------------------------------------------------------------------


def test_it_goes_home_when_the_share_that_is_known_there_falls_below_the_ratio():
    recording = go(NARROW, (1.0, 0.6), home="worth", home_ratio=0.7, limit_s=400.0)
    nodes = {
        (e.robot, e.serial): (e.time_s, shapely.Polygon(e.boundary))
        for e in recording.of(NodeAdded)
    }
    learned = {tuple(n): e.time_s for e in recording.of(BaseLearned) for n in e.nodes}

    def share(time_s):
        known = [area for name, (_, area) in nodes.items() if learned.get(name, 1e9) <= time_s]
        whole = [area for made_s, area in nodes.values() if made_s <= time_s]
        return shapely.union_all(known).area / shapely.union_all(whole).area

    turns = [time_s for time_s, text in told(recording) if "less than 70%" in text]
    assert len(turns) >= 4
    for time_s in turns:
        assert share(time_s) < 0.7 + 0.02
        assert share(time_s - 2.0) > 0.7 - 0.02
    # In the corridor the share is the ratio of lengths seen; so each trip is 1 / 0.7 times longer.
    far = [place_at(recording, time_s)[0] + 4.0 for time_s in turns]
    for one, following in itertools.pairwise(far[1:]):
        assert following / one == pytest.approx(1.0 / 0.7, rel=0.06)
    metrics = measure(recording, NARROW)
    assert metrics.delivered_coverage == same(metrics.coverage)


def test_in_touch_with_the_base_no_way_is_worth_it():
    recording = go(WIDE, (1.0, 1.2), home="worth", base=(1.0, 1.2), radio=RadioSpec())
    assert told(recording) == []
    delivered_coverage = measure(recording, WIDE).delivered_coverage
    assert delivered_coverage is not None
    assert delivered_coverage > 0.99


# Relays ------------------------------------------------------------------------------------------


def pair(*, limit_s=900.0, world=WIDE, **changes):
    return go(
        world,
        (1.0, 1.2),
        (2.0, 1.2),
        strategy="minpos",
        base=(1.0, 1.2),
        home="relays",
        limit_s=limit_s,
        **{"radio": RadioSpec(range_m=5.0)} | changes,
    )


def test_the_relay_brings_home_what_the_explorer_found():
    recording = pair()
    metrics = measure(recording, WIDE)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.99
    assert metrics.collisions == 0
    assert lost(recording) == set()
    # From beyond 15 m the explorer never came near the base until it was done; the relay did.
    [done] = [t for t, text in told(recording) if "nothing that is left" in text]
    by_relay = [e for e in recording.of(BaseLearned) if e.robot == 1 and 60.0 < e.time_s < done]
    assert len(by_relay) >= 2
    assert sum(len(e.nodes) for e in by_relay) >= 30
    # Each rendezvous is kept before half a minute after its time.
    agreed = [e for e in recording.of(Decided) if "(rendezvous" in e.text]
    for e, following in itertools.pairwise(agreed):
        due_s = float(e.text.split("next at ")[1].split(" s")[0])
        assert following.time_s <= due_s + 30.0
        # Its place is the next goal of the explorer.
        assert e.goal in [c.goal for c in recording.of(GoalChosen)]


@pytest.mark.parametrize("limit_s", [150.0, 200.0, 300.0])
def test_pairs_agree_on_no_rendezvous_after_which_there_is_no_time(limit_s):
    recording = pair(limit_s=limit_s)
    assert recording.footer.outcome == "stalled"
    metrics = measure(recording, WIDE)
    assert metrics.delivered_coverage == same(metrics.coverage)
    agreed = [e for e in recording.of(Decided) if "meets robot 1" in e.text]
    *earlier, last = agreed
    assert "no time is left for another rendezvous" in last.text
    for event in earlier:
        due_s = float(event.text.split("next at ")[1].split(" s")[0])
        assert event.goal is not None
        home_s = (event.goal[0] - 6.0) / 0.5
        assert due_s + home_s < limit_s
    # After that neither waits for the other.
    after = [e.text for e in recording.of(Decided) if e.time_s > last.time_s]
    assert not any("goes to meet" in text for text in after)


def test_a_relay_does_not_stop_its_explorer_for_data_that_the_base_has():
    def meetings(multi_hop: bool) -> int:
        recording = pair(radio=RadioSpec(range_m=70.0, multi_hop=multi_hop))
        return sum("meets robot" in text for _, text in told(recording))

    # All hear the base station, which hears them, whether messages are relayed or not.
    assert meetings(multi_hop=False) == meetings(multi_hop=True)


def test_where_no_target_is_in_time_other_cells_of_frontiers_are():
    # In the maze at 35 s, the only frontier that there is time for begins out of reach.
    world = environment("maze")
    run = RunSpec(
        environment=inline(world),
        robots=(RobotSpec(),) * 2,
        starts="clustered",
        strategy="minpos",
        options={"home": "in-time"},
        base=BaseSpec(x=3.0, y=3.0),
        radio=RadioSpec(range_m=6.0),
        stop=StopRule(max_time_s=80.0),
    )
    ends = [end.time_s for end in simulate(run).of(Ended)]
    assert min(ends) > 50.0


def test_an_explorer_whose_relay_is_dead_brings_its_news_home_itself():
    recording = pair(faults=(Death(robot=1, time_s=100.0),))
    assert lost(recording) == {(0, 1)}
    metrics = measure(recording, WIDE)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.8
    assert metrics.collisions == 0
    texts = [text for _, text in told(recording)]
    at = next(k for k, text in enumerate(texts) if "at the backup of" in text)
    assert "goes to meet its partner" in texts[at - 1]
    assert texts[at + 1].startswith("goes home: the base station knows less than 80%")
    # It waited at the place until half a minute after the time.
    due_s = next(
        float(text.split("next at ")[1].split(" s")[0])
        for _, text in reversed(told(recording))
        if "(rendezvous" in text
    )
    [(left_s, _)] = [one for one in told(recording) if "at the backup of" in one[1]]
    assert left_s == pytest.approx(due_s + 30.0, abs=1.5)


def test_a_relay_whose_explorer_is_dead_takes_over_exploring():
    recording = pair(faults=(Death(robot=0, time_s=100.0),))
    assert lost(recording) == {(1, 0)}
    metrics = measure(recording, WIDE)
    assert metrics.collisions == 0
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.55


def test_what_a_dead_relay_carried_comes_home_by_its_explorer():
    # It dies on its way home at 80 s, with the news of the meeting at 75 s.
    recording = pair(faults=(Death(robot=1, time_s=80.0),))
    assert lost(recording) == {(0, 1)}
    metrics = measure(recording, WIDE)
    assert metrics.delivered_coverage == same(metrics.coverage)


def test_with_a_radio_that_reaches_all_there_is_nothing_to_meet_for():
    recording = pair(radio=RadioSpec())
    assert not any("goes to meet" in text for _, text in told(recording))
    delivered_coverage = measure(recording, WIDE).delivered_coverage
    assert delivered_coverage is not None
    assert delivered_coverage > 0.99
    # It takes no longer than without relays, but for the moments in which they agree.
    other = go(WIDE, (1.0, 1.2), strategy="minpos", base=(1.0, 1.2), radio=RadioSpec())
    assert recording.footer.time_s < other.footer.time_s + 15.0


def test_lost_messages_do_not_part_a_pair_for_long():
    recording = pair(radio=RadioSpec(range_m=5.0, loss=0.3, latency_s=0.05))
    metrics = measure(recording, WIDE)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.95


def pair_from_afar(*, limit_s):
    return go(
        WIDE,
        (30.0, 1.2),
        (31.0, 1.2),
        strategy="minpos",
        base=(1.0, 1.2),
        home="relays",
        limit_s=limit_s,
        radio=RadioSpec(range_m=5.0),
    )


def test_a_pair_that_begins_apart_from_the_base_finds_it_first():
    recording = pair_from_afar(limit_s=900.0)
    metrics = measure(recording, WIDE)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.9


def test_a_relay_that_knows_no_way_home_explores_and_takes_no_news():
    # 29 m from the base station, which hears it at 5 m: half a metre a second takes it there.
    recording = pair_from_afar(limit_s=76.0)
    near = [e.time_s for e in recording.of(NodeAdded) if e.configuration[0] < 6.0]
    meetings = [e.time_s for e in recording.of(Decided) if "meet" in e.text]
    assert 0.0 < min(near) <= min(meetings)
    chosen = [e for e in recording.of(GoalChosen) if e.robot == 1 and e.time_s < min(near)]
    assert any(event.goal is not None for event in chosen)


def test_where_the_base_hears_a_robot_anyway_it_needs_no_time_to_go_home():
    recordings = [
        go(WIDE, (1.0, 1.2), strategy="minpos", home=home, limit_s=60.0, radio=RadioSpec())
        for home in ("never", "in-time")
    ]
    assert recordings[1].footer.outcome == "out_of_time"
    ends = [[motion.waypoints[-1] for motion in run.of(Motion)] for run in recordings]
    assert ends[0] == ends[1]


# All rules ---------------------------------------------------------------------------------------


RULES = ("closest", "greedy", "minpos", "utility", "self-bidding", "rules", "gain", "routes")
HALL = Environment(
    "hall",
    shapely.box(0, 0, 24, 12).difference(
        shapely.union_all([shapely.box(x, 0, x + 0.2, 9) for x in (6, 18)]).union(
            shapely.box(12, 3, 12.2, 12)
        )
    ),
)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("home", ["in-time", "relays"])
def test_every_rule_brings_home_all_that_living_robots_know(rule, home):
    recording = go(
        HALL,
        (1.0, 1.0),
        (2.0, 2.0),
        (3.0, 1.0),
        strategy=rule,
        base=(1.0, 1.0),
        home=home,
        limit_s=150.0,
        radio=RadioSpec(range_m=6.0, walls="block"),
        faults=(Death(robot=2, time_s=50.0),),
    )
    metrics = measure(recording, HALL)
    assert metrics.collisions == 0
    known = {
        tuple(n)
        for e in recording.events
        if getattr(e, "nodes", None) and getattr(e, "robot", None) != 2
        for n in e.nodes
    } | {(e.robot, e.serial) for e in recording.of(NodeAdded) if e.robot != 2}
    delivered = {tuple(n) for e in recording.of(BaseLearned) for n in e.nodes}
    assert known <= delivered
    delivered_coverage = metrics.delivered_coverage
    assert delivered_coverage is not None
    assert delivered_coverage > 0.3


def test_a_car_comes_home():
    world = Environment("yard", shapely.box(0, 0, 30, 6))
    recording = go(
        world,
        (2.0, 3.0),
        drive=DriveSpec(kind="reeds-shepp"),
        base=(1.0, 3.0),
        home="in-time",
        limit_s=80.0,
    )
    metrics = measure(recording, world)
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.3


def test_the_same_run_is_the_same_to_the_byte():
    runs = [pair(limit_s=200.0, radio=RadioSpec(range_m=5.0, loss=0.2)) for _ in range(2)]
    assert runs[0].footer.digest == runs[1].footer.digest


# Strategies of one's own -------------------------------------------------------------------------


class Newest(RegionExplorer):
    """To a frontier of the newest node that has one."""

    def choose(self):
        for node in reversed(self.map.open_nodes()):
            for arc in self.map.frontier_arcs(node):
                place = arc[len(arc) // 2, :2]
                if np.isfinite(self.costs(place)[0]):
                    return place
        return None


class Stays:
    """Does nothing."""

    def __init__(self, me):
        self.me = me

    def run(self):
        yield Done(complete=False, reason="stays")


@pytest.mark.parametrize("home", ["in-time", "worth"])
def test_a_planner_on_regions_brings_news_home_without_a_line_of_its_own(home):
    with registered(Strategy.of(Newest)):
        recording = go(NARROW, (1.0, 0.6), strategy="newest", home=home, limit_s=120.0)
        metrics = measure(recording, NARROW)
    assert any(text.startswith("goes home") for _, text in told(recording))
    assert metrics.delivered_coverage == same(metrics.coverage)
    assert metrics.coverage > 0.2


def test_a_strategy_without_the_option_refuses_it():
    with (
        registered(Strategy.of(Stays)),
        pytest.raises(InvalidInputError, match="stays has no option 'home'"),
    ):
        go(NARROW, (1.0, 0.6), strategy="stays", home="in-time")


def test_a_slow_relay_is_met_when_it_can_be_there():
    hall = Environment("hall", shapely.box(0, 0, 100, 3))
    spec = RunSpec(
        environment=inline(hall),
        strategy="minpos",
        options={"home": "relays"},
        robots=tuple(
            RobotSpec(start=(x, 1.5), drive=DriveSpec(speed_m_s=speed_m_s))
            for x, speed_m_s in ((1.5, 1.0), (2.5, 0.25))
        ),
        base=BaseSpec(x=1.0, y=1.5),
        radio=RadioSpec(range_m=5.0),
        stop=StopRule(max_time_s=600.0),
    )
    recording = simulate(spec)
    assert not any("backup" in event.text for event in recording.of(Decided))
    assert recording.of(PresumedLost) == []
    assert (measure(recording, hall).delivered_coverage or 0.0) > 0.99


def test_an_explorer_in_touch_leaves_no_goal_to_meet_its_relay():
    # The base station says nothing while there is nothing new, and all robots hear it.
    apartment = environment("apartment")
    spec = RunSpec(
        environment=inline(apartment),
        strategy="minpos",
        options={"home": "relays"},
        robots=(RobotSpec(), RobotSpec()),
        starts="clustered",
        base=BaseSpec(x=2.5, y=2.0),
        radio=RadioSpec(range_m=60.0),
        stop=StopRule(max_time_s=600.0),
    )
    recording = simulate(spec)
    assert recording.footer.outcome == "complete"
    texts = [event.text for event in recording.of(Decided) if event.robot == 0]
    assert not any(text.startswith("goes to meet its partner") for text in texts)


def test_a_silent_robot_that_has_moved_is_sought_again():
    # A corridor between a room with the base station and its dead end; robot 1 follows robot 0.
    hall = Environment("hall", shapely.union(shapely.box(0, 0, 4, 5), shapely.box(4, 2, 40, 3)))
    spec = RunSpec(
        environment=inline(hall),
        strategy="gain",
        options={"home": "in-time"},
        robots=tuple(
            RobotSpec(
                start=(x, 2.5),
                drive=DriveSpec(speed_m_s=speed_m_s),
                range_finder=RangeFinderSpec(range_m=2.0),
            )
            for x, speed_m_s in ((7.5, 0.5), (5.5, 0.3))
        ),
        base=BaseSpec(x=0.5, y=2.5),
        radio=RadioSpec(range_m=9.0),
        faults=(Silence(robot=1, time_s=0.0, duration_s=200.0),),
        stop=StopRule(max_time_s=900.0),
        seed=1,
    )
    recording = simulate(spec)
    assert recording.footer.outcome == "complete"
    assert (measure(recording, hall).delivered_coverage or 0.0) > 0.99
