"""Chains of relays: in a corridor, with answers worked out by hand."""

import dataclasses
import itertools
import math
import re

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned, Decided, Ended, Motion, NodeAdded, PresumedLost
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.explorer import Look, RadioSelf, RobotSelf, Send, Sighting
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.messages import ChainLink, ReportMessage
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.homing.options import HomingOptions
from multisrt.robots.registry import strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    BaseSpec,
    Death,
    RadioSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

CORRIDOR = Environment("corridor", shapely.box(0, 0, 60, 2.4))
STARTS = ((3.0, 0.6), (2.2, 1.8), (1.4, 0.6), (0.6, 1.8))
RANGE_M = 10.0
# Links are 9 m long at most: nine tenths of the range.
LINK_M = 9.0


def go(
    robots=4,
    *,
    world=CORRIDOR,
    rule="minpos",
    faults=(),
    radio=None,
    limit_s=600.0,
    base=(1.0, 1.2),
    **options,
):
    return simulate(
        RunSpec(
            environment=inline(world),
            strategy=rule,
            options={"home": "chain"} | options,
            robots=tuple(RobotSpec(start=start) for start in STARTS[:robots]),
            base=BaseSpec(x=base[0], y=base[1]),
            radio=radio or RadioSpec(range_m=RANGE_M),
            stop=StopRule(max_time_s=limit_s),
            faults=faults,
        )
    )


@pytest.fixture(scope="module")
def chain():
    """Four robots in 60 m of corridor, with a radio of 10 m."""
    return go()


def links_of(recording):
    """The places at which robots stood as relays: by time, robot, x."""
    found = []
    for e in recording.of(Decided):
        at = re.match(r"serves the chain: stands at \(([\d.]+),", e.text)
        if at:
            found.append((e.time_s, e.robot, float(at[1])))
    return found


def place_at(recording, robot, time_s):
    place = recording.header.starts[robot][:2]
    for motion in recording.of(Motion):
        if motion.robot == robot:
            for t, x, y, _ in motion.waypoints:
                if t <= time_s:
                    place = x, y
    return place


def test_the_relays_stand_a_link_apart(chain):
    stood = {robot: x for _, robot, x in links_of(chain)}
    # From the base at x = 1: 10, 19 and 28, less what a bend over the width of the corridor takes
    # and the steps of a quarter of a metre in which places are looked for.
    assert sorted(stood.values()) == pytest.approx([10.0, 19.0, 28.0], abs=0.5)
    assert set(stood) == {1, 2, 3}


def test_the_base_learns_what_the_front_sees_while_it_drives(chain):
    learned = {tuple(n): e.time_s for e in chain.of(BaseLearned) for n in e.nodes}
    # There is no latency: every node is delivered at the moment at which it was made.
    for node in chain.of(NodeAdded):
        assert learned[node.robot, node.serial] == pytest.approx(node.time_s, abs=1e-6)
    metrics = measure(chain, CORRIDOR)
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)
    assert metrics.delivery_delay_s == pytest.approx(0.0, abs=1e-6)


def test_it_ends_where_the_chain_does(chain):
    # A frontier 9 m beyond the last relay is the farthest goal; the next one is not taken.
    metrics = measure(chain, CORRIDOR)
    assert metrics.coverage == pytest.approx((1.0 + 4 * LINK_M) / 60.0, abs=0.02)
    assert metrics.collisions == 0
    for ended in chain.of(Ended):
        assert ended.reason == "no goal is left from which the chain reaches the base station"
        assert not ended.complete
    assert chain.footer.outcome == "stalled"


def test_more_robots_reach_farther():
    two = measure(go(2), CORRIDOR)
    assert two.coverage == pytest.approx((1.0 + 2 * LINK_M) / 60.0, abs=0.03)
    three = measure(go(3), CORRIDOR)
    assert three.coverage == pytest.approx((1.0 + 3 * LINK_M) / 60.0, abs=0.03)


def test_relays_come_one_after_the_other_and_stay(chain):
    stood = links_of(chain)
    # Each place is farther out than those before, and none is left before the front is done.
    xs = [x for _, _, x in stood]
    assert all(b >= a - 0.5 for a, b in itertools.pairwise(xs))
    [done] = [e.time_s for e in chain.of(Ended) if e.robot == 0]
    for time_s, robot, x in stood:
        later = [t for t, other, _ in stood if other == robot and t > time_s]
        if not later:
            assert place_at(chain, robot, done)[0] == pytest.approx(x, abs=0.2)


def test_with_a_radio_that_reaches_all_nobody_stands():
    recording = go(2, radio=RadioSpec())
    assert links_of(recording) == []
    assert measure(recording, CORRIDOR).delivered_coverage == pytest.approx(1.0, abs=0.01)


def test_behind_walls_links_are_lines_of_sight():
    # Round a corner: the base station sees the first corridor, a relay the second.
    world = Environment(
        "corner", shapely.union_all([shapely.box(0, 0, 12, 2.4), shapely.box(9.6, 0, 12, 16)])
    )
    radio = RadioSpec(range_m=30.0, walls="block")
    recording = go(2, world=world, radio=radio)
    metrics = measure(recording, world)
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)
    assert metrics.coverage > 0.97
    assert metrics.collisions == 0
    stood = {
        (e.robot, e.goal) for e in recording.of(Decided) if "serves the chain: stands" in e.text
    }
    assert stood
    for _, (x, y) in stood:
        sight = shapely.LineString([(1.0, 1.2), (x, y)])
        assert world.free.buffer(1e-6).covers(sight)


def test_a_base_station_in_a_cell_of_a_wall_is_linked():
    radio = RadioSpec(range_m=RANGE_M, walls="block")
    for x in (0.02, 1.0):
        metrics = measure(go(2, radio=radio, limit_s=200.0, base=(x, 1.2)), CORRIDOR)
        assert metrics.coverage > 0.25


def test_a_robot_that_knows_no_way_home_looks_for_one():
    recording = simulate(
        RunSpec(
            environment=inline(CORRIDOR),
            strategy="minpos",
            options={"home": "chain"},
            robots=(RobotSpec(start=(30.0, 1.2)), RobotSpec(start=(31.0, 1.2))),
            base=BaseSpec(x=1.0, y=1.2),
            radio=RadioSpec(range_m=RANGE_M),
            stop=StopRule(max_time_s=600.0),
        )
    )
    metrics = measure(recording, CORRIDOR)
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)
    assert metrics.coverage > 0.4


# Faults ------------------------------------------------------------------------------------------


def lost(recording):
    return {(e.robot, e.other) for e in recording.of(PresumedLost)}


def test_a_relay_that_dies_is_replaced():
    # Robot 1 stands at the first link from 25 s or so on.
    recording = go(faults=(Death(robot=1, time_s=60.0),))
    metrics = measure(recording, CORRIDOR)
    assert metrics.collisions == 0
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)
    assert any(other == 1 for _, other in lost(recording))
    # Two relays are left: the front comes as far as three robots do.
    assert metrics.coverage > (3 * LINK_M - 2.0) / 60.0


def test_a_front_that_dies_is_followed_by_the_next():
    recording = go(faults=(Death(robot=0, time_s=30.0),))
    metrics = measure(recording, CORRIDOR)
    assert metrics.collisions == 0
    assert metrics.delivered_coverage == pytest.approx(metrics.coverage, abs=1e-9)
    assert any(other == 0 for _, other in lost(recording))
    # Robot 1 goes on, with two relays.
    called = [e for e in recording.of(Decided) if e.text.endswith("for robot 1")]
    assert called
    assert all(e.robot > 1 for e in called)


RULES = ("closest", "greedy", "minpos", "utility", "self-bidding", "rules", "gain", "routes")


@pytest.mark.parametrize("seed", range(8))
def test_nobody_waits_for_ever_and_none_collides(seed):
    rule = RULES[seed]
    rng = np.random.default_rng(seed)
    dead = int(rng.integers(4))
    faults = (
        Death(robot=dead, time_s=float(rng.uniform(10.0, 120.0))),
        Silence(robot=(dead + 1) % 4, time_s=float(rng.uniform(10.0, 120.0)), duration_s=40.0),
    )
    recording = go(rule=rule, faults=faults, limit_s=1500.0)
    metrics = measure(recording, CORRIDOR)
    assert metrics.collisions == 0
    assert recording.footer.outcome in ("complete", "stalled")
    assert metrics.coverage > 0.2


def test_the_same_run_is_the_same_to_the_byte(chain):
    assert go().footer.digest == chain.footer.digest


# Misuse ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("robots", "base", "radio", "match"),
    [
        (1, True, RadioSpec(range_m=5.0), "needs robots that stand as relays"),
        (2, True, RadioSpec(range_m=5.0, multi_hop=False), "needs a radio by which robots relay"),
        (2, False, RadioSpec(range_m=5.0), "needs a base station to return data to"),
    ],
)
def test_what_a_chain_needs_is_asked_for_in_one_line(robots, base, radio, match):
    spec = RunSpec(
        environment=inline(CORRIDOR),
        strategy="minpos",
        options={"home": "chain"},
        robots=tuple(RobotSpec(start=start) for start in STARTS[:robots]),
        base=BaseSpec(x=1.0, y=1.2) if base else None,
        radio=radio,
    )
    with pytest.raises(InvalidInputError, match=match) as told:
        strategy("minpos").require_fit(spec)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("share", [0.0, 1.1, math.nan])
def test_a_link_is_a_share_of_the_range(share):
    with pytest.raises(InvalidInputError, match="home_link"):
        HomingOptions(home_link=share)


# Parts -------------------------------------------------------------------------------------------


def member(number):
    """A robot of three at x = 3 + its number that has seen the corridor up to x = 33."""
    me = RobotSelf(
        robot=number,
        start=Configuration(3.0 + number, 1.2, 0.0),
        footprint=Footprint.disc(0.25),
        kinematics=Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2),
        range_m=4.0,
        rng=np.random.default_rng(1),
        team=3,
        base=(1.0, 1.2),
        radio=RadioSelf(range_m=RANGE_M, reaches_all=False),
        limit_s=600.0,
    )
    robot = FrontierRobot(me, FrontierOptions(home="chain"))
    index = EdgeIndex(CORRIDOR.edges, 1.5)
    for x in np.arange(1.0, 29.1, 0.5):
        robot.map.add(take_scan(index, Configuration(x, 1.2, 0.0), x, 4.0))
    return robot


def report_of(robot, number, place, links=None):
    return msgspec.structs.replace(
        robot.team.own_report(), robot=number, place=(*place, 0.0), links=links
    )


def goal_at(x):
    return Goal(x, 1.2, np.array([(3.0, 1.2), (x, 1.2)]), x - 3.0)


def test_the_front_calls_the_nearest_and_lets_go_who_is_not_needed():
    front = member(0)
    for number, x in ((1, 4.0), (2, 5.0)):
        front.team.teammates.take(report_of(front, number, (x, 1.2)))
    chain = front.homing.chain
    assert chain.is_front
    # To x = 24, 23 m from the base station: relays at 10 and 19, of which robot 2 is nearest to the
    # first.
    wait = chain.call(goal_at(24.0))
    assert wait.kind == "wait"
    assert [link.robot for link in front.team.links] == [2, 1]
    assert [link.place[0] for link in front.team.links] == pytest.approx([10.0, 19.0], abs=0.3)
    # To x = 15, one relay: it stays the same.
    chain.call(goal_at(15.0))
    assert [link.robot for link in front.team.links] == [2]
    # To x = 8 none.
    assert chain.call(goal_at(8.0)) is None
    assert front.team.links == ()
    chain.let_go()
    assert front.team.links is None


def test_the_goal_that_relays_were_called_for_is_kept_until_they_are_there():
    front = member(0)
    teammates, chain = front.team.teammates, front.homing.chain
    for number, x in ((1, 4.0), (2, 5.0)):
        teammates.take(report_of(front, number, (x, 1.2)))
        teammates.heard_s[number] = front.time_s
    goal = goal_at(24.0)
    assert chain.take_called_for() is None
    assert chain.call(goal) is not None
    # Both relays are still on their way, and the goal is asked for only once.
    assert chain.take_called_for() is None
    assert chain.call(goal) is not None
    for said, link in enumerate(front.team.links, 1):
        arrived = report_of(front, link.robot, link.place)
        teammates.take(msgspec.structs.replace(arrived, said=said))
    assert chain.take_called_for() == goal.place
    assert chain.take_called_for() is None
    # Who lets its relays go has no goal to keep.
    away = report_of(front, 1, (4.0, 1.2))
    teammates.take(msgspec.structs.replace(away, said=3))
    assert chain.call(goal) is not None
    chain.let_go()
    assert chain.take_called_for() is None


def test_the_front_goes_where_its_relays_are_enough_for():
    front = member(0)
    front.team.teammates.take(report_of(front, 1, (4.0, 1.2)))
    places = np.array([(9.0, 1.2), (18.0, 1.2), (20.0, 1.2)])
    costs = np.array([6.0, 15.0, 17.0])
    # One relay: 9 m, and 9 m more.
    found = front.homing.chain.only_in_reach(places, costs)
    assert np.isfinite(found).tolist() == [True, True, False]
    front.team.teammates.note_lost(1, 1.0)
    found = front.homing.chain.only_in_reach(places, costs)
    assert np.isfinite(found).tolist() == [True, False, False]


def test_the_others_go_where_the_base_station_or_a_relay_hears_them():
    other = member(1)
    link = ChainLink(robot=2, place=(10.0, 1.2))
    places = np.array([(9.0, 1.2), (18.0, 1.2), (20.0, 1.2)])
    costs = np.array([6.0, 15.0, 17.0])
    for links, reached in (((), [True, False, False]), ((link,), [True, True, False])):
        other.team.teammates.take(report_of(other, 0, (12.0, 1.2), links))
        found = other.homing.chain.only_in_reach(places, costs)
        assert np.isfinite(found).tolist() == reached


def test_a_relay_stops_when_it_is_called_and_when_it_is_let_go():
    relay = member(1)
    link = ChainLink(robot=1, place=(10.0, 1.2))
    for k, (links, at) in enumerate((((), None), ((link,), (10.0, 1.2)), ((), None))):
        relay.team.requests.link = False
        report = msgspec.structs.replace(report_of(relay, 0, (12.0, 1.2), links), said=k)
        message = ReportMessage(sender=0, reports=(report,))
        # It has all that the front has: there is nothing to say.
        assert list(relay.team._take_reports(message)) == []
        assert relay.team.requests.link is (k > 0)
        assert relay.homing.chain.own_link == at
        errand = relay.homing.chain.follow()
        assert (errand is None) is (at is None)


def test_who_does_not_hear_the_front_for_long_takes_it_as_lost():
    relay = member(1)
    link = ChainLink(robot=1, place=(10.0, 1.2))
    relay.team.teammates.take(report_of(relay, 0, (12.0, 1.2), (link,)))
    chain = relay.homing.chain
    errand = chain.follow()
    assert errand.waits_until_s(10.0) == 40.0
    relay.course.time_s = 29.0
    assert chain.note_unheard() is None
    relay.course.time_s = 40.0
    assert chain.note_unheard() == 0
    assert errand.is_over()
    assert chain.is_front


def test_a_robot_that_is_late_three_times_is_not_called_again():
    front = member(0)
    front.team.teammates.take(report_of(front, 1, (4.0, 1.2)))
    chain = front.homing.chain
    for late in range(1, 4):
        assert front.homing.fits(goal_at(15.0)), late
        assert chain.call(goal_at(15.0)) is not None
        # It was heard, and is not lost.
        assert chain.note_missed() == []
    assert not front.homing.fits(goal_at(15.0))
    assert front.homing.fits(goal_at(8.0))


def test_a_front_with_nothing_to_do_passes_the_front_on():
    robots = [member(number) for number in range(3)]

    def tell(teller):
        robots[teller].team._reports_made += 1
        message = ReportMessage(sender=teller, reports=(robots[teller].team.own_report(),))
        for robot in robots:
            if robot is not robots[teller]:
                # It asks for nodes that it lacks, which is of no account here.
                assert all(isinstance(sent, Send) for sent in robot.team._take_reports(message))

    for number in range(3):
        tell(number)
    chains = [robot.homing.chain for robot in robots]
    assert [chain.front for chain in chains] == [0, 0, 0]
    assert [chain.is_led for chain in chains] == [False, True, True]
    chains[0].pass_front()
    tell(0)
    assert robots[2].team.requests.link
    # What others pass on of its own report is no news to it.
    own = ReportMessage(sender=1, reports=(robots[0].team.own_report(),))
    robots[0].team.requests.link = False
    list(robots[0].team._take_reports(own))
    assert not robots[0].team.requests.link
    assert [chain.front for chain in chains] == [1, 1, 1]
    assert [chain.is_led for chain in chains] == [True, False, True]
    for number in (1, 2):
        chains[number].pass_front()
        tell(number)
    # All have nothing to do: nobody waits for another, and the first is the one to go on.
    assert [chain.front for chain in chains] == [0, 0, 0]
    assert not any(chain.is_led for chain in chains)
    # It does, and the others may follow it again.
    chains[0].call(goal_at(8.0))
    tell(0)
    assert [robot.team.passes_front for robot in robots] == [False, False, False]
    assert [chain.is_led for chain in chains] == [False, True, True]


def test_who_stands_by_takes_a_front_as_lost_that_called_nobody():
    other = member(1)
    other.team.teammates.take(report_of(other, 0, (12.0, 1.2)))
    chain = other.homing.chain
    errand = chain.stand_by()
    assert errand.waits_until_s(0.0) == 30.0
    # One that is interrupted meanwhile does not wait for as long again.
    other.course.time_s = 31.0
    assert chain.stand_by().waits_until_s(31.0) == 31.0
    assert chain.note_unheard() == 0
    assert chain.is_front


def test_a_relay_that_does_not_get_to_its_place_gives_an_unheard_front_up():
    relay = member(1)
    link = ChainLink(robot=1, place=(10.0, 1.2))
    relay.team.teammates.take(report_of(relay, 0, (12.0, 1.2), (link,)))
    chain = relay.homing.chain
    for time_s, stays in ((0.0, False), (299.0, False), (301.0, True)):
        relay.course.time_s = time_s
        errand = chain.follow()
        assert (errand.goal.place == relay.at[:2]) is stays
    assert errand.waits_until_s(301.0) == 301.0
    assert chain.note_unheard() == 0


GAP = Environment(
    "gap",
    CORRIDOR.free.difference(
        shapely.union_all([shapely.box(8, 0, 8.3, 0.7), shapely.box(8, 1.7, 8.3, 2.4)])
    ),
)


def test_a_front_that_fits_nowhere_does_not_keep_the_others_from_exploring():
    starts = ((3.0, 1.2), (1.8, 0.6), (1.8, 1.8), (0.7, 1.2))
    bodies = ("disc:0.6", "disc:0.2", "disc:0.2", "disc:0.2")
    recording = simulate(
        RunSpec(
            environment=inline(GAP),
            strategy="minpos",
            options={"home": "chain"},
            robots=tuple(
                RobotSpec(start=start, footprint=body)
                for start, body in zip(starts, bodies, strict=True)
            ),
            base=BaseSpec(x=1.0, y=1.2),
            radio=RadioSpec(range_m=RANGE_M),
            stop=StopRule(max_time_s=900.0),
        )
    )
    # Robot 0 cannot pass the gap at x = 8: of the others two are relays.
    assert measure(recording, GAP).coverage > (3 * LINK_M - 2.0) / 60.0
    fronts = [e.text[-1] for e in recording.of(Decided) if "serves the chain: stands" in e.text]
    # Each of the three has its turn, as the one before has nothing to do any more.
    assert [front for front, _ in itertools.groupby(fronts)] == ["1", "2", "3"]
    assert recording.footer.outcome == "stalled"


def test_a_front_that_dies_before_it_calls_anybody_is_followed_by_the_next():
    recording = go(faults=(Death(robot=0, time_s=2.0),))
    assert (1, 0) in lost(recording)
    assert measure(recording, CORRIDOR).coverage > (3 * LINK_M - 2.0) / 60.0


PILLAR = Environment("pillar", shapely.box(0, 0, 16, 20).difference(shapely.box(4, 0, 12, 9)))


def test_relays_stay_that_hear_a_goal_to_which_there_are_too_few_on_the_way():
    # From the base station at (2, 5) the goal at (14, 5) is behind the pillar, on a way around it
    # of two corners; the relay at (8, 18) sees both.
    me = dataclasses.replace(
        member(0).me,
        start=Configuration(3.0, 5.0, 0.0),
        range_m=8.0,
        base=(2.0, 5.0),
        radio=RadioSelf(range_m=30.0, reaches_all=False, walls_matter=True),
    )
    robot = FrontierRobot(me, FrontierOptions(home="chain"))
    index = EdgeIndex(PILLAR.edges, 1.5)
    seen_from = (
        (3, 5), (2, 9), (2, 14), (4, 12), (8, 12), (8, 16), (8, 18), (12, 12), (12, 16), (14, 12),
        (14, 8), (14, 5), (14, 3),
    )  # fmt: skip
    for k, (x, y) in enumerate(seen_from):
        robot.map.add(take_scan(index, Configuration(float(x), float(y), 0.0), float(k), 8.0))
    relay, place = (8.0, 18.0), (14.0, 5.0)
    robot.team.teammates.take(report_of(robot, 1, relay))
    assert robot.homing is not None
    chain = robot.homing.chain
    assert chain is not None
    path = np.array([(3.0, 5.0), place])
    assert not np.isfinite(chain.only_in_reach(np.array([place]), np.array([20.0])))[0]
    robot.team.links = (ChainLink(robot=1, place=relay),)
    assert np.isfinite(chain.only_in_reach(np.array([place]), np.array([20.0])))[0]
    assert chain.call(Goal(*place, path, 20.0)) is None
    assert robot.team.links == (ChainLink(robot=1, place=relay),)


def test_a_relay_whose_path_was_barred_goes_once_it_is_free():
    relay = member(1)
    link = ChainLink(robot=1, place=(10.0, 1.2))
    relay.team.teammates.take(report_of(relay, 0, (12.0, 1.2), (link,)))
    barring = Sighting(
        robot=2, configuration=Configuration(6.5, 1.2, 0.0), footprint=Footprint.disc(0.9)
    )
    relay.bodies.add(barring)
    chain = relay.homing.chain
    errand = chain.follow()
    assert errand.is_barred
    assert errand.goal.place == relay.at[:2]
    assert not errand.is_over()
    # It looks, and the body is elsewhere.
    look = relay.bodies.look()
    assert isinstance(next(look), Look)
    elsewhere = msgspec.structs.replace(barring, configuration=Configuration(20.0, 1.2, 0.0))
    with pytest.raises(StopIteration):
        look.send((elsewhere,))
    assert errand.is_over()
    again = chain.follow()
    assert not again.is_barred
    assert again.goal.place == pytest.approx((10.0, 1.2), abs=0.1)


def test_a_front_whose_relays_leave_goes_back_into_touch():
    # Rooms along a corridor: relays that are called to another room let go of where the front is.
    office = environment("office")
    run = simulate(
        RunSpec(
            environment=inline(office),
            strategy="minpos",
            options={"home": "chain"},
            robots=tuple(RobotSpec(start=start) for start in ((2.0, 3.0), (2.8, 3.0), (2.0, 3.8))),
            base=BaseSpec(x=2.0, y=3.0),
            radio=RadioSpec(range_m=9.0),
            stop=StopRule(max_time_s=1000.0),
        )
    )
    assert run.of(PresumedLost) == []
    assert (measure(run, office).delivered_coverage or 0.0) > 0.5
    assert "no goal is left from which the chain reaches the base station" in run.footer.reason
