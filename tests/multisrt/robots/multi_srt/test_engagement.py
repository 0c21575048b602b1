"""BUILD_GER: members of a group agree on it, by hand and in runs."""

import itertools
from collections import defaultdict

import pytest

from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import Coordinated, Decision
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.robots.explorer import Action, Look, Outcome, Receive, Send, Sighting, TimedOut
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.build_srt import look
from multisrt.robots.multi_srt.engagement import Regroup, build_ger
from multisrt.robots.multi_srt.messages import Order, OrdersMessage, StateMessage
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec, StopRule

# In runs -------------------------------------------------------------------------------------


def team_run(world: Environment, count: int, strategy: str, seed: int):
    """Five minutes of a team, with an unlimited radio."""
    spec = RunSpec(
        environment=inline(world),
        strategy=strategy,
        robots=(RobotSpec(),) * count,
        starts="clustered",
        stop=StopRule(max_time_s=300.0),
        seed=seed,
    )
    return simulate(spec, world)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "count", "strategy"),
    [("open", 3, "srt-radial"), ("rooms", 4, "srt-star"), ("garden", 5, "srt-radial")],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_members_that_decide_together_name_the_same_groups(name, count, strategy, seed):
    events = team_run(environment(name), count, strategy, seed).events
    moments: defaultdict[float, dict[int, Decision]] = defaultdict(dict)
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
def test_coordinated_members_name_the_same_group_and_master(seed):
    told: defaultdict[float, dict[int, Coordinated]] = defaultdict(dict)
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


@pytest.fixture
def robot(robot_self) -> SrtRobot:
    """The first of three, at the origin."""
    return SrtRobot(robot_self(), "star", MultiSrtOptions())


@pytest.fixture
def member(robot_state):
    """Build the state of a robot that stands two metres from the one before it."""

    def member(number, *, step, key=(), phase="idle", **more):
        place = [(2.0 * number, 0.0)]
        return robot_state(number, place, step=step, key=key, phase=phase, **more)

    return member


def asked_by(action: Action) -> tuple[int, ...]:
    """The robots that an action asks for their states."""
    if not isinstance(action, Send):
        return ()
    assert isinstance(action.message, StateMessage)
    return action.message.asked


def answer(robot: SrtRobot, action: Action) -> Outcome:
    """The outcome of an action where no robot answers."""
    if not isinstance(action, Receive):
        return None
    assert action.timeout_s is not None
    return TimedOut(robot.at.time_s + action.timeout_s)


@pytest.mark.parametrize("theirs", [((0, 0), (1, 3), (2, 5)), ((0, 0), (1, 3))])
def test_a_disputed_member_is_asked_itself(robot, member, theirs):
    # The second waits with another group: it has left out the third, which stands idle, or it
    # knows of a step that the third made meanwhile. Only the third can tell.
    team = robot.team
    team.roster.states[1] = member(1, step=3, key=theirs, phase="perceived")
    team.roster.states[2] = member(2, step=4)
    gpr = team.gpr()
    assert gpr == (0, 1, 2)
    team.status.key = team.key_of(gpr)
    meeting = build_ger(robot, gpr)
    outcome: Outcome = None
    asked: tuple[int, ...] = ()
    while not asked:
        action = meeting.send(outcome)
        outcome = answer(robot, action)
        asked = asked_by(action)
    assert asked == (1, 2)


def test_a_member_whose_node_only_the_master_knows_is_engaged(robot, member):
    # The master's orders have come before the node that the third stands at.
    team = robot.team
    team.roster.states[1] = member(1, step=3)
    team.roster.states[2] = member(2, step=4, node=NodeId(2, 7))
    team.status.key = team.key_of(team.gpr())
    orders = tuple((number, Order(order="wait")) for number in (0, 1, 2))
    team.orders = OrdersMessage(
        sender=2, key=team.status.key, orders=orders, feasible=(), unfeasible=(0, 1, 2)
    )
    meeting = build_ger(robot, (0, 1, 2))
    assert isinstance(next(meeting), Send)
    with pytest.raises(StopIteration) as met:
        next(meeting)
    assert met.value.value == (0, 2)


def looks(robot: SrtRobot, seen: tuple[Sighting, ...]) -> tuple[tuple[int, ...], bool]:
    """Let a robot look round where no robot answers: those it asks, and whether it regroups."""
    looking = look(robot)
    outcome: Outcome = None
    asked: tuple[int, ...] = ()
    while True:
        try:
            action = looking.send(outcome)
        except StopIteration:
            return asked, False
        except Regroup:
            return asked, True
        outcome = seen if isinstance(action, Look) else answer(robot, action)
        asked += asked_by(action)


def sighting(number: int, x: float, y: float) -> Sighting:
    """A robot seen at a place."""
    return Sighting(
        robot=number,
        configuration=Configuration(x, y, 0.0),
        footprint=Footprint.parse("disc:0.25"),
    )


def test_a_robot_seen_elsewhere_is_asked_until_it_is_lost(robot, member):
    # The second said that it stands idle, went on unheard, and died on its way.
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


def test_a_robot_where_it_said_or_moving_is_not_asked(robot, member, robot_state):
    robot.team.roster.states[1] = member(1, step=3)
    robot.team.roster.states[2] = robot_state(2, [(4.0, 0.0), (6.0, 0.0)], moving=True)
    assert looks(robot, (sighting(1, 2.0, 0.0), sighting(2, 5.0, 0.0))) == ((), False)
    assert not robot.obstacles.silent


def test_a_robot_left_out_is_avoided_while_in_sight(robot, member):
    robot.team.roster.states[1] = member(1, step=3, phase="perceived")
    there = sighting(1, 2.0, 0.0)
    looks(robot, (there,))
    assert not robot.obstacles
    robot.team.roster.left_out_until_s[1] = 30.0
    looks(robot, (there,))
    assert robot.obstacles.all == {1: there}
