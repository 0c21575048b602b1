"""Who steps together: GPR and GER as equivalence classes, by an oracle and in real runs."""

import itertools
import math
from collections import defaultdict

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import Coordinated, Decision
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.exploration_map import NodeId
from multisrt.robots.explorer import Look, Receive, RobotSelf, Send, Sighting, TimedOut
from multisrt.robots.multi_srt.build_srt import look
from multisrt.robots.multi_srt.engagement import Regroup, build_ger
from multisrt.robots.multi_srt.groups import are_coupled, group_of
from multisrt.robots.multi_srt.messages import Order, OrdersMessage, RobotState
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec, StopRule


def state(robot, path, *, moving=False, range_m=4.0) -> RobotState:
    """A robot that goes along some places, one a second, or plans to."""
    return RobotState(
        robot=robot,
        said=1,
        step=0,
        phase="moving" if moving else "waiting",
        key=(),
        path=tuple((float(k), x, y, 0.0) for k, (x, y) in enumerate(path)),
        arrival_s=0.0,
        node=None,
        frontier_m=0.0,
        waited=0,
        tree=None,
        footprint="disc:0.25",
        kinematics=Differential(),
        range_m=range_m,
        have=(),
    )


coordinates = st.tuples(st.floats(0.0, 30.0), st.floats(0.0, 30.0))


@st.composite
def teams(draw, most=8):
    """Robots that stand, plan a motion or move, and see differently far, by their numbers."""
    count = draw(st.integers(1, most))
    return {
        number: state(
            number,
            draw(st.lists(coordinates, min_size=1, max_size=4)),
            moving=draw(st.booleans()),
            range_m=draw(st.floats(0.5, 6.0)),
        )
        for number in range(count)
    }


def meet(a, b) -> bool:
    """Whether two robots are pre-engaged, written down anew from the definition."""
    places = []
    for robot in (a, b):
        way = np.array([(x, y) for _, x, y, _ in robot.path])
        places.append(way if robot.phase == "moving" else way[:1])
    reach = a.range_m + b.range_m
    if np.hypot(*(places[0][-1] - places[1][-1])) < reach:
        return True
    near_a = np.hypot(*(places[0] - places[1][-1]).T).min() < b.range_m
    near_b = np.hypot(*(places[1] - places[0][-1]).T).min() < a.range_m
    return (a.phase == "moving" and near_a) or (b.phase == "moving" and near_b)


def components(members, coupled) -> dict[int, tuple[int, ...]]:
    """The connected component of every member, by scipy."""
    numbers = sorted(members)
    pairs = np.array(
        [[i != j and bool(coupled(members[i], members[j])) for j in numbers] for i in numbers]
    )
    _, labels = connected_components(csr_array(pairs), directed=False)
    return {
        i: tuple(j for j, other in zip(numbers, labels, strict=True) if other == label)
        for i, label in zip(numbers, labels, strict=True)
    }


def check_groups(members, coupled, oracle, order):
    """The laws that groups obey under any symmetric relation."""
    for a, b in itertools.permutations(members.values(), 2):
        assert coupled(a, b) == coupled(b, a)
    groups = {number: group_of(number, members, coupled) for number in members}
    for number, group in groups.items():
        assert number in group
        assert list(group) == sorted(set(group))
        assert all(groups[other] == group for other in group)
    assert sorted(itertools.chain(*set(groups.values()))) == sorted(members)
    for i, j in itertools.combinations(members, 2):
        if coupled(members[i], members[j]):
            assert groups[i] == groups[j]
    assert groups == components(members, oracle)
    shuffled = {number: members[number] for number in order}
    assert {number: group_of(number, shuffled, coupled) for number in members} == groups


@given(teams(), st.data())
def test_the_groups_of_pre_engaged_robots_are_equivalence_classes(team, data):
    check_groups(team, are_coupled, meet, data.draw(st.permutations(sorted(team))))


@st.composite
def regions(draw, most=7):
    count = draw(st.integers(1, most))
    made = {}
    for number in range(count):
        x, y = draw(coordinates)
        radii = draw(st.lists(st.floats(0.3, 5.0), min_size=3, max_size=9))
        angles = np.linspace(0.0, 2.0 * math.pi, len(radii), endpoint=False)
        boundary = np.column_stack([x + radii * np.cos(angles), y + radii * np.sin(angles)])
        tags = np.zeros(len(radii), np.int8)
        made[number] = LocalSafeRegion(x=x, y=y, range_m=5.0, boundary=boundary, tags=tags)
    return made


@given(regions(), st.data())
def test_the_groups_of_engaged_robots_are_equivalence_classes(made, data):
    def touch(a, b):
        return not shapely.relate_pattern(a.polygon(), b.polygon(), "FF*FF****")

    order = data.draw(st.permutations(sorted(made)))
    check_groups(made, LocalSafeRegion.overlaps, touch, order)


WORLD = environment("clutter", seed=4)
INDEX = EdgeIndex(WORLD.edges, 1.5)


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.sampled_from(["ball", "star", "radial"]))
def test_groups_of_real_regions(seed, shape):
    rng = np.random.default_rng(seed)
    places = rng.uniform(WORLD.free.bounds[:2], WORLD.free.bounds[2:], (60, 2)).tolist()
    free = [p for p in places if shapely.contains_xy(WORLD.free, *p) and WORLD.clearance(*p) > 0.3]
    made = {
        number: local_safe_region(take_scan(INDEX, Configuration(x, y, 0.0), 0.0, 4.0), shape)
        for number, (x, y) in enumerate(free[:8])
    }

    def share_area(a, b):
        return shapely.distance(a.polygon(), b.polygon()) == 0.0

    check_groups(made, LocalSafeRegion.overlaps, share_area, rng.permutation(len(made)).tolist())


# By hand -------------------------------------------------------------------------------------


def test_robots_couple_when_their_targets_are_nearer_than_their_ranges_together():
    a, far, near = state(0, [(0, 0)]), state(1, [(8, 0)]), state(2, [(7.99, 0)])
    assert not are_coupled(a, far)
    assert are_coupled(a, near)
    assert are_coupled(a, state(3, [(8, 0)], range_m=4.1))
    assert not are_coupled(state(0, [(0, 0)], range_m=1.0), state(1, [(4, 0)], range_m=2.0))


def test_the_target_of_a_robot_that_stands_is_its_place_whatever_it_plans():
    other = state(1, [(20, 0)])
    assert not are_coupled(state(0, [(0, 0), (15, 0)]), other)
    assert are_coupled(state(0, [(0, 0), (15, 0)], moving=True), other)
    assert not are_coupled(state(0, [(20, 9), (0, 0)], moving=True), other)


def test_a_curve_that_passes_near_couples():
    # A long way round: it passes 3 m from the other, which sees 4 m, and ends 20 m from it.
    detour = [(-20, 0), (0, 3), (20, 0)]
    other = state(1, [(0, 0)])
    assert are_coupled(state(0, detour, moving=True), other)
    assert not are_coupled(state(0, detour), other)
    assert not are_coupled(state(0, [(-20, 0), (0, 4), (20, 0)], moving=True), other)


def test_a_chain_is_one_group():
    chain = {k: state(k, [(7.0 * k, 0.0)]) for k in range(5)}
    assert not are_coupled(chain[0], chain[2])
    assert group_of(3, chain, are_coupled) == (0, 1, 2, 3, 4)
    del chain[2]
    assert group_of(0, chain, are_coupled) == (0, 1)
    assert group_of(4, chain, are_coupled) == (3, 4)


# In runs -------------------------------------------------------------------------------------


def team_run(world: Environment, count: int, strategy: str, seed: int):
    """Five minutes of a team, with a radio that reaches everybody."""
    spec = RunSpec(
        environment=inline(world),
        strategy=strategy,
        robots=(RobotSpec(),) * count,
        starts="clustered",
        stop=StopRule(max_time_s=300.0),
        seed=seed,
    )
    return simulate(spec, world)


@pytest.mark.parametrize(
    ("name", "count", "strategy"),
    [("open", 3, "srt-radial"), ("rooms", 4, "srt-star"), ("garden", 5, "srt-radial")],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_members_that_decide_together_name_the_same_groups(name, count, strategy, seed):
    events = team_run(environment(name), count, strategy, seed).events
    moments = defaultdict(dict)
    for event in events:
        if isinstance(event, Decision):
            assert event.robot in event.ger
            assert set(event.ger) <= set(event.gpr)
            moments[event.time_s][event.robot] = event
    together = 0
    for decisions in moments.values():
        for one, other in itertools.combinations(decisions.values(), 2):
            for groups in ((one.gpr, other.gpr), (one.ger, other.ger)):
                assert groups[0] == groups[1] or not set(groups[0]) & set(groups[1])
            together += one.ger == other.ger
    assert together > 10


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_members_that_are_coordinated_together_name_the_same_group_and_master(seed):
    told = defaultdict(dict)
    for event in team_run(environment("open"), 5, "srt-radial", seed).events:
        if isinstance(event, Coordinated):
            told[event.time_s][event.robot] = event
    words = [
        (event.ger, event.master, event.feasible, event.unfeasible)
        for moment in told.values()
        for event in moment.values()
    ]
    assert words
    for moment in told.values():
        for one, other in itertools.combinations(moment.values(), 2):
            if set(one.ger) & set(other.ger):
                assert one.ger == other.ger
                assert one.master == other.master
                assert (one.feasible, one.unfeasible) == (other.feasible, other.unfeasible)
        for event in moment.values():
            assert sorted(event.feasible + event.unfeasible) == list(event.ger)
            assert event.unfeasible
            assert event.master in event.ger


def member(number: int, *, step: int, key=(), phase="idle") -> RobotState:
    """A robot that stands two metres from the last."""
    standing = state(number, [(2.0 * number, 0.0)])
    return msgspec.structs.replace(standing, step=step, key=key, phase=phase)


def a_robot() -> SrtRobot:
    """The first of three, at the origin."""
    me = RobotSelf(
        robot=0,
        start=Configuration(0.0, 0.0, 0.0),
        footprint=Footprint.parse("disc:0.25"),
        kinematics=Differential(),
        range_m=4.0,
        rng=np.random.default_rng(0),
        team=3,
    )
    return SrtRobot(me, "star", MultiSrtOptions())


@pytest.mark.parametrize("theirs", [((0, 0), (1, 3), (2, 5)), ((0, 0), (1, 3))])
def test_a_member_whom_others_name_otherwise_is_asked_itself(theirs):
    # The second waits with another group: it has left out the third, which stands idle, or it
    # knows of a step that the third made meanwhile. Only the third can tell.
    robot = a_robot()
    team = robot.team
    team.roster.states[1] = member(1, step=3, key=theirs, phase="perceived")
    team.roster.states[2] = member(2, step=4)
    gpr = team.gpr()
    assert gpr == (0, 1, 2)
    team.plan.key = team.key_of(gpr)
    meeting, outcome, asked = build_ger(robot, gpr), None, ()
    while not asked:
        action = meeting.send(outcome)
        outcome = None
        if isinstance(action, Send):
            asked = action.message.asked
        elif isinstance(action, Receive):
            outcome = TimedOut(robot.at.time_s + action.timeout_s)
    assert asked == (1, 2)


def test_a_member_whose_node_only_the_master_knows_is_engaged():
    # The master's orders have come before the node that the third stands at.
    robot = a_robot()
    team = robot.team
    team.roster.states[1] = member(1, step=3)
    team.roster.states[2] = msgspec.structs.replace(member(2, step=4), node=NodeId(2, 7))
    team.plan.key = team.key_of(team.gpr())
    orders = tuple((number, Order(order="wait")) for number in (0, 1, 2))
    team.orders[team.plan.key] = OrdersMessage(
        sender=2, key=team.plan.key, orders=orders, feasible=(), unfeasible=(0, 1, 2)
    )
    meeting = build_ger(robot, (0, 1, 2))
    assert isinstance(next(meeting), Send)
    with pytest.raises(StopIteration) as met:
        next(meeting)
    assert met.value.value == (0, 2)


def looks(robot: SrtRobot, seen: tuple[Sighting, ...]) -> tuple[tuple[int, ...], bool]:
    """Let a robot look round where nobody answers: whom it asks, and whether it begins anew."""
    looking, outcome, asked = look(robot), None, ()
    while True:
        try:
            action = looking.send(outcome)
        except StopIteration:
            return asked, False
        except Regroup:
            return asked, True
        outcome = None
        if isinstance(action, Look):
            outcome = seen
        elif isinstance(action, Send):
            asked += action.message.asked
        elif isinstance(action, Receive):
            outcome = TimedOut(robot.at.time_s + action.timeout_s)


def sighting(number: int, x: float, y: float) -> Sighting:
    """A robot that is seen somewhere."""
    return Sighting(
        robot=number,
        configuration=Configuration(x, y, 0.0),
        footprint=Footprint.parse("disc:0.25"),
    )


def test_one_that_is_seen_elsewhere_than_where_it_said_to_stand_is_asked_until_it_is_a_body():
    # The second said that it stands idle, went on unheard, and died on its way.
    robot = a_robot()
    team = robot.team
    team.roster.states[1] = member(1, step=3)
    there = sighting(1, 3.0, 1.0)
    for _ in range(team.roster.patience):
        assert looks(robot, (there,)) == ((1,), True)
        assert not robot.obstacles.silent
    assert looks(robot, (there,)) == ((1,), True)
    assert 1 in team.roster.lost
    assert looks(robot, (there,)) == ((), False)
    assert robot.obstacles.silent == {1: there}


def test_one_that_stands_where_it_said_or_moves_is_not_asked():
    robot = a_robot()
    robot.team.roster.states[1] = member(1, step=3)
    robot.team.roster.states[2] = state(2, [(4.0, 0.0), (6.0, 0.0)], moving=True)
    assert looks(robot, (sighting(1, 2.0, 0.0), sighting(2, 5.0, 0.0))) == ((), False)
    assert not robot.obstacles.silent


def test_one_with_whom_there_is_no_agreement_is_gone_round_while_it_is_in_sight():
    robot = a_robot()
    robot.team.roster.states[1] = member(1, step=3, phase="perceived")
    there = sighting(1, 2.0, 0.0)
    looks(robot, (there,))
    assert not robot.obstacles
    robot.team.roster.left_out_until_s[1] = 30.0
    looks(robot, (there,))
    assert robot.obstacles.all == {1: there}
