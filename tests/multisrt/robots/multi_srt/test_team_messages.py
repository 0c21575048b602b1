"""Messages: robots share nothing else; their sizes, and how they bring maps together."""

import dataclasses
import enum
import gc
import math
import types
from collections import Counter
from itertools import combinations
from typing import ClassVar

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import Decision, Learned, NodeAdded, Sent
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic
from multisrt.robots import registry
from multisrt.robots.exploration_map import Node, NodeId
from multisrt.robots.explorer import Send
from multisrt.robots.messages import Message
from multisrt.robots.multi_srt.messages import (
    EntriesMessage,
    NoPlaceMessage,
    Order,
    OrdersMessage,
    StateMessage,
    WantMessage,
)
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.support import open_frontier
from multisrt.robots.registry import strategies
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RadioSpec, RobotSpec, RunSpec, StopRule

ROOMS = Environment(
    "two rooms", shapely.box(0, 0, 12, 5).difference(shapely.box(6, 0, 6.2, 3.5)), starts=[(1, 1)]
)
CORRIDOR = Environment("corridor", shapely.box(0, 0, 30, 2))


@pytest.fixture
def explorers(monkeypatch):
    """Every explorer of a run, in the order of the robots, and all their messages."""
    built, sent = [], []

    class Listened:
        def __init__(self, explorer):
            self.explorer = explorer

        def run(self):
            acts, outcome = self.explorer.run(), None
            while True:
                action = acts.send(outcome)
                if isinstance(action, Send):
                    sent.append(action.message)
                outcome = yield action

    def keeping(strategy):
        def explorer(me, options):
            built.append(strategy.explorer(me, options))
            return Listened(built[-1])

        return dataclasses.replace(strategy, explorer=explorer)

    known = {s.name: keeping(s) for s in strategies()}
    monkeypatch.setattr(registry, "_registry", lambda: known)
    return built, sent


def run(world, count, *, seed=0, max_time_s=300.0, **more):
    robots = more.pop("robots", (RobotSpec(),) * count)
    spec = RunSpec(
        environment=inline(world),
        robots=robots,
        stop=StopRule(max_time_s=max_time_s),
        seed=seed,
        **more,
    )
    return simulate(spec, world)


# Nothing is shared ---------------------------------------------------------------------------

PROGRAM = (types.ModuleType, type, types.BuiltinFunctionType, types.MethodDescriptorType, enum.Enum)
ATOMS = (str, bytes, int, float, complex, bool, type(None), np.generic, np.dtype, range)
VALUES = (Footprint, shapely.Geometry)
"""Immutable by their contract; what they cache of themselves is the same for every caller."""


def is_frozen_struct(thing: object) -> bool:
    return isinstance(thing, msgspec.Struct) and thing.__struct_config__.frozen


def is_frozen_dataclass(thing: object) -> bool:
    params = getattr(type(thing), "__dataclass_params__", None)
    return params is not None and params.frozen


def inside(root: object) -> dict[int, object]:
    """Every object reachable from a robot, by id, but for the program and immutable atoms."""
    found: dict[int, object] = {}
    waiting = [root]
    while waiting:
        thing = waiting.pop()
        if id(thing) in found or isinstance(thing, PROGRAM + ATOMS + VALUES):
            continue
        if isinstance(thing, types.FunctionType):
            waiting += [cell.cell_contents for cell in thing.__closure__ or ()]
            continue
        found[id(thing)] = thing
        if isinstance(thing, np.ndarray) and isinstance(thing.base, np.ndarray):
            waiting.append(thing.base)
        waiting += gc.get_referents(thing)
    return found


def may_be_shared(thing: object) -> bool:
    """Whether an object itself is immutable; what it holds is checked on its own."""
    if isinstance(thing, np.ndarray):
        whole = thing.base if isinstance(thing.base, np.ndarray) else thing
        return not thing.flags.writeable and not whole.flags.writeable
    return (
        isinstance(thing, tuple | frozenset | types.MethodType | bytes)
        or is_frozen_struct(thing)
        or is_frozen_dataclass(thing)
    )


def shared(a: object, b: object) -> list[object]:
    theirs = inside(b)
    return [
        thing
        for number, thing in inside(a).items()
        if number in theirs and not may_be_shared(thing)
    ]


@dataclasses.dataclass(frozen=True)
class _Sealed:
    content: object


@pytest.mark.parametrize("wrap", [lambda x: [x], lambda x: {1: x}, lambda x: (x,), _Sealed])
def test_the_search_finds_shared_objects(wrap):
    one = [1.0]
    assert shared(wrap(one), {"b": one}) == [one]
    array = np.zeros(3)
    assert len(shared(wrap(array), [array])) == 1
    view = array[1:]
    view.setflags(write=False)
    assert len(shared(wrap(view), [view])) == 2
    array.setflags(write=False)
    assert shared(wrap(array), [array]) == []
    assert shared(wrap((1, "a")), [(1, "a")]) == []


@pytest.mark.parametrize("strategy", ["srt-radial", "srt-star"])
@pytest.mark.parametrize("max_time_s", [0.01, 40.0, 2000.0])
def test_robots_share_nothing_mutable(explorers, strategy, max_time_s):
    run(ROOMS, 3, strategy=strategy, max_time_s=max_time_s)
    robots = [explorer.robot for explorer in explorers[0]]
    assert len(robots) == 3
    if max_time_s > 1.0:
        assert all(len(robot.map.entries.have()) == 3 for robot in robots)
    for a, b in combinations(robots, 2):
        assert a.me.rng is not b.me.rng
        assert shared(a, b) == []


def test_messages_do_not_change_after_they_are_sent(explorers):
    before: list[tuple[Message, bytes]] = []

    def keep(event):
        if isinstance(event, Sent):
            message = explorers[1][-1]
            before.append((message, encoded(message)))

    spec = RunSpec(
        environment=inline(ROOMS), robots=(RobotSpec(),) * 3, stop=StopRule(max_time_s=300.0)
    )
    simulate(spec, ROOMS, watch=keep)
    assert len(before) > 30
    assert any(message.entries for message, _ in before if isinstance(message, StateMessage))
    assert all(encoded(message) == then for message, then in before)


def plain(value: object) -> object:
    return value.tobytes() if isinstance(value, np.ndarray) else repr(value)


def encoded(message: Message) -> bytes:
    return msgspec.msgpack.encode(message, enc_hook=plain)


# Sizes ---------------------------------------------------------------------------------------


@pytest.fixture
def state(robot_state):
    """Build a state of robot 1 with a node, and entries known of two robots."""

    def state(**more):
        given = {"said": 3, "step": 2, "path": ((1.0, 2.0),), "node": NodeId(1, 4)}
        given |= {"frontier_m": 2.5, "tree": NodeId(1, 0), "have": ((0, 1, 0), (1, 5, 0))}
        return robot_state(**given | more)

    return state


def a_node(explorers) -> Node:
    run(ROOMS, 1, max_time_s=1.0)
    return explorers[0][0].robot.map.nodes[0]


def test_the_size_of_a_state_follows_from_its_fields(state):
    message = StateMessage(sender=1, states=(state(),))
    # 15 fields whose names and few numbers are written out: some hundreds of bytes.
    assert 200 < message.size_bytes < 500
    longer = StateMessage(sender=1, states=(state(path=((1.0, 2.0),) * 11),))
    # Ten more waypoints of four doubles of 9 bytes, each in an array with a head of one.
    assert longer.size_bytes == message.size_bytes + 10 * (4 * 9 + 1)
    two = StateMessage(sender=1, states=(state(), state(robot=2)))
    assert two.size_bytes > 1.8 * message.size_bytes


@pytest.mark.parametrize("kinematics", [Differential(), Holonomic(), Car()])
def test_every_drive_can_be_sent(state, kinematics):
    assert StateMessage(sender=0, states=(state(kinematics=kinematics),)).size_bytes > 100


def test_the_size_of_a_node_is_that_of_its_boundary(state, explorers):
    node = a_node(explorers)
    bare = StateMessage(sender=1, states=(state(),))
    with_node = StateMessage(sender=1, states=(state(),), entries=(node,))
    corners = node.region.boundary.nbytes
    assert corners > 50
    assert corners < with_node.size_bytes - bare.size_bytes < 3 * corners + 1000
    entries = EntriesMessage(sender=1, entries=(node, node))
    assert entries.size_bytes > 2 * corners


def test_questions_and_orders_wake_and_news_does_not(state):
    said = (state(),)
    assert not StateMessage(sender=0, states=said).wakes
    assert StateMessage(sender=0, states=said, ask=True).wakes
    assert StateMessage(sender=0, states=said, asked=(2,)).wakes
    assert WantMessage(sender=0, have=()).wakes
    assert not EntriesMessage(sender=0, entries=()).wakes
    orders = OrdersMessage(
        sender=0,
        key=((0, 1), (1, 2)),
        orders=((0, Order(order="keep")),),
        feasible=(),
        unfeasible=(0, 1),
    )
    assert orders.wakes
    assert orders.size_bytes > 20


def test_a_message_refuses_what_it_cannot_encode():
    class Odd(Message, frozen=True, kw_only=True):
        kind: ClassVar[str] = "odd"
        what: object = None

    with pytest.raises(TypeError, match="object"):
        _ = Odd(sender=0, what=object()).size_bytes


def test_the_size_of_every_message_is_on_record(explorers):
    recording = run(ROOMS, 3)
    sent = [event for event in recording.events if isinstance(event, Sent)]
    assert [event.size_bytes for event in sent] == [m.size_bytes for m in explorers[1]]
    assert [event.kind for event in sent] == [m.kind for m in explorers[1]]
    assert [event.robot for event in sent] == [m.sender for m in explorers[1]]
    assert measure(recording, ROOMS).bytes_sent == sum(event.size_bytes for event in sent)


# Maps come together --------------------------------------------------------------------------


@pytest.mark.parametrize("latency_s", [0.0, 1.0])
@pytest.mark.parametrize("seed", [0, 1])
def test_with_an_unlimited_radio_all_maps_are_equal_at_the_end(explorers, latency_s, seed):
    radio = RadioSpec(latency_s=latency_s)
    recording = run(ROOMS, 3, seed=seed, max_time_s=2000.0, radio=radio)
    assert recording.footer.outcome == "complete"
    have = [explorer.robot.map.entries.have() for explorer in explorers[0]]
    assert have[0] == have[1] == have[2]
    assert sum(nodes for nodes, _ in have[0].values()) == sum(
        isinstance(event, NodeAdded) for event in recording.events
    )


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("multi_hop", [True, False])
def test_robots_that_meet_learn_all_that_the_other_knows(explorers, seed, multi_hop):
    # Their starts are 26 m apart, the radio reaches 12 m: each explores its half, and somewhere
    # between they meet. From then on both know all that either knew at that time.
    recording = run(
        CORRIDOR,
        2,
        seed=seed,
        max_time_s=2000.0,
        robots=(RobotSpec(start=(2.0, 1.0)), RobotSpec(start=(28.0, 1.0))),
        radio=RadioSpec(range_m=12.0, multi_hop=multi_hop),
    )
    made: dict[int, list[float]] = {0: [], 1: []}
    known: dict[int, set[tuple[int, ...]]] = {0: set(), 1: set()}
    for event in recording.events:
        if isinstance(event, NodeAdded):
            made[event.robot].append(event.time_s)
            known[event.robot].add((event.robot, event.serial))
        elif isinstance(event, Learned):
            known[event.robot].update(tuple(node) for node in event.nodes)
    met = [e.time_s for e in recording.events if isinstance(e, Sent) and e.reached]
    assert met
    assert met[0] > 0.0
    early = {
        (robot, serial)
        for robot in (0, 1)
        for serial, time_s in enumerate(made[robot])
        if time_s <= met[0]
    }
    assert len(early) > 4
    assert {robot for robot, _ in early} == {0, 1}
    assert early <= known[0] & known[1]
    # The last node was made while they were in range: so their version vectors are equal.
    assert max(times[-1] for times in made.values()) <= max(met)
    have = [explorer.robot.map.entries.have() for explorer in explorers[0]]
    assert have[0] == have[1]


def test_robots_that_have_not_met_know_nothing_of_each_other(explorers):
    run(
        CORRIDOR,
        2,
        max_time_s=5.0,
        robots=(RobotSpec(start=(2.0, 1.0)), RobotSpec(start=(28.0, 1.0))),
        radio=RadioSpec(range_m=12.0),
    )
    assert [list(explorer.robot.map.entries.have()) for explorer in explorers[0]] == [[0], [1]]
    assert [explorer.robot.team.roster.states for explorer in explorers[0]] == [{}, {}]


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_in_between_passes_on_what_it_learned(explorers, seed):
    # Robot 1 hears both, now and then; robots 0 and 2 never hear one another, and nobody relays.
    recording = run(
        CORRIDOR,
        3,
        seed=seed,
        max_time_s=30.0,
        robots=tuple(RobotSpec(start=(x, 1.0)) for x in (4.0, 15.0, 26.0)),
        radio=RadioSpec(range_m=12.0, multi_hop=False),
    )
    sent = [event for event in recording.events if isinstance(event, Sent)]
    assert not any({event.robot, *event.reached} >= {0, 2} for event in sent if event.robot != 1)
    for explorer in explorers[0]:
        assert set(explorer.robot.map.entries.have()) == {0, 1, 2}


# Nodes at which the paper's planner finds no place --------------------------------------------


PAPERS_PLANNER = {"approach": False, "complete": False}


@pytest.mark.slow
@pytest.mark.parametrize("after", [1, 2])
def test_robots_do_not_go_where_others_found_no_place(explorers, after):
    world, options = environment("rooms"), PAPERS_PLANNER | {"no_place_after": after}
    recording = run(world, 3, max_time_s=2000.0, starts="clustered", options=options, seed=1)
    told = [message for message in explorers[1] if isinstance(message, NoPlaceMessage)]
    assert told
    counts = Counter(message.node for message in told)
    robots = [explorer.robot for explorer in explorers[0]]
    assert [robot.team.without_place for robot in robots] == [counts] * 3
    # Nobody chose to go to such a node in support of its tree after it was told often enough.
    heard: Counter[NodeId] = Counter()
    told_s: dict[NodeId, float] = {}
    sent = [event for event in recording.events if isinstance(event, Sent)]
    for event, message in zip(sent, explorers[1], strict=True):
        if isinstance(message, NoPlaceMessage):
            heard[message.node] += 1
            if heard[message.node] == after:
                told_s[message.node] = event.time_s
    goes_there = []
    places = {robots[0].map[node].configuration[:2]: node for node in counts}
    for event in recording.events:
        if isinstance(event, Decision) and event.choice == "nearest_open":
            node = places.get(event.target)
            goes_there.append(event)
            assert node is None or event.time_s <= told_s.get(node, math.inf)
    assert goes_there


@pytest.mark.slow
def test_without_the_option_no_robot_says_so(explorers):
    run(
        environment("rooms"),
        3,
        max_time_s=60.0,
        starts="clustered",
        options=PAPERS_PLANNER,
        seed=1,
    )
    assert not any(isinstance(message, NoPlaceMessage) for message in explorers[1])


def test_with_the_third_stage_the_option_is_refused():
    with pytest.raises(InvalidInputError, match="no_place_after is 2, but complete is true"):
        MultiSrtOptions(no_place_after=2)


@pytest.mark.parametrize(
    ("other", "is_heeded"),
    [
        ({}, True),
        ({"footprint": "disc:0.3"}, False),
        ({"kinematics": Holonomic()}, False),
    ],
)
def test_only_robots_of_the_same_body_and_drive_are_heeded(
    robot_self, robot_state, other, is_heeded
):
    robot = SrtRobot(robot_self(), "radial", MultiSrtOptions())
    list(robot.team._take_message(NoPlaceMessage(sender=1, node=NodeId(1, 0))))
    assert not robot.team.without_place  # nothing is known of its sender yet
    robot.team.roster.take(robot_state(1, **other), 1)
    list(robot.team._take_message(NoPlaceMessage(sender=1, node=NodeId(1, 2))))
    assert robot.team.without_place == ({NodeId(1, 2): 1} if is_heeded else {})


@pytest.mark.parametrize(
    ("options", "counts"),
    [
        ({"complete": False, "no_place_after": 2}, False),
        ({"complete": False}, True),
    ],
)
def test_frontier_at_such_nodes_needs_no_support(explorers, options, counts):
    run(ROOMS, 1, max_time_s=1.0)
    found = explorers[0][0].robot
    root = found.map.nodes[0].id
    open_m = found.map.open_frontier_m(root)
    assert open_m > 0.0
    robot = SrtRobot(found.me, "radial", MultiSrtOptions(**options))
    robot.map.merge(found.map.nodes)
    robot.team.without_place[root] = 1
    assert open_frontier(robot, root) == pytest.approx(open_m)
    robot.team.without_place[root] = 2
    assert open_frontier(robot, root) == pytest.approx(open_m if counts else 0.0)
