"""Runs with a base station: by scripts, and by strategies in two rooms and a corridor."""

import math
import subprocess
import sys

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.analysis.run_tables import coverage_curve
from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned, Ended, Motion, NodeAdded, Sensed, Sent
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.geometry.regions.visibility import visibility_polygon
from multisrt.robots.explorer import Done, Note, Receive, Send, Sense
from multisrt.robots.knowledge import (
    AcknowledgementMessage,
    EntriesMessage,
    Node,
    NodeId,
    WantMessage,
)
from multisrt.robots.messages import Message
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import BaseSpec, Death, RadioSpec, RobotSpec, RunSpec, Silence, StopRule

END = Done(complete=True, reason="enough")
ON_CALL = Done(complete=True, reason="enough", on_call=True)
NEAR = RadioSpec(range_m=5.0)

# Two rooms of 6 x 6 m, and a corridor of 10 m between them.
ROOMS = Environment(
    "two rooms",
    shapely.union_all(
        [shapely.box(0, 0, 6, 6), shapely.box(6, 2.4, 16, 3.6), shapely.box(16, 0, 22, 6)]
    ),
)
AT_HOME = BaseSpec(x=1.0, y=3.0)


class News(Message, frozen=True, kw_only=True):
    entries: tuple[Node, ...]
    have: tuple[tuple[int, int, int], ...] = ()


def node(serial: int, time_s: float, x: float = 1.0, y: float = 1.0, robot: int = 0) -> Node:
    half = 0.4
    square = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    return Node(
        id=NodeId(robot, serial),
        configuration=Configuration(x, y, 0.0),
        region=LocalSafeRegion(
            x=x,
            y=y,
            range_m=4.0,
            boundary=square + np.array([x, y]),
            tags=np.zeros(4, np.int8),
        ),
        parent=None,
        time_s=time_s,
    )


def delivered(recording) -> dict[tuple[int, int], float]:
    """When the base station learned of each node."""
    names = [(tuple(name), e.time_s) for e in recording.of(BaseLearned) for name in e.nodes]
    assert len(dict(names)) == len(names)
    return dict(names)


def makes(serial: int, time_s: float, x: float, robot: int = 0) -> list:
    made = node(serial, time_s, x, 1.0, robot)
    return [Sense(), Note(made.added("scan")), Send(News(sender=robot, entries=(made,)))]


# Scripts -----------------------------------------------------------------------------------------


def test_a_single_robot_delivers_where_its_radio_reaches(play, straight):
    # The base is at (1, 3), its range 5 m: at y = 1 up to x = 1 + sqrt(21) = 5.58.
    recording, [told] = play(
        [
            *makes(0, 0.0, 1.0),
            straight(1.0, 1.0, 5.5, 1.0),
            *makes(1, 9.0, 5.5),
            straight(5.5, 1.0, 5.6, 1.0),
            *makes(2, 9.2, 5.6),
            END,
        ],
        starts=[(1.0, 1.0)],
        base=AT_HOME,
        radio=NEAR,
    )
    assert delivered(recording) == {(0, 0): 0.0, (0, 1): 9.0}
    [*_, last] = [e for e in recording.of(Sent) if e.robot == 0]
    assert last.reached == ()
    answers = [e for e in recording.of(Sent) if e.robot == 1]
    assert [(e.kind, e.reached) for e in answers] == [("acknowledgement", (0,))] * 2
    assert told


def test_a_robot_is_told_what_the_base_has(play):
    made = node(0, 0.0)
    _, [told] = play(
        [Sense(), Note(made.added("scan")), Send(News(sender=0, entries=(made,))), Receive(), END],
        starts=[(1.0, 1.0)],
        base=AT_HOME,
    )
    assert told[3].messages == (AcknowledgementMessage(sender=1, have=((0, 1, 0),)),)


def test_the_base_asks_by_radio_and_learns(play):
    made = [node(0, 0.0), node(1, 0.0)]

    def reports():
        yield Sense()
        for one in made:
            yield Note(one.added("scan"))
        yield Send(News(sender=0, entries=(made[1],), have=((0, 2, 0),)))
        told = yield Receive()
        assert told.messages == (WantMessage(sender=1, have=((0, 0, 0),)),)
        assert told.time_s == 1.0
        yield Send(EntriesMessage(sender=0, entries=(made[0],)), 1)
        told = yield Receive()
        assert told.messages == (AcknowledgementMessage(sender=1, have=((0, 2, 0),)),)
        yield END

    recording, _ = play(reports, starts=[(1.0, 1.0)], base=AT_HOME, radio=RadioSpec(latency_s=0.5))
    assert delivered(recording) == {(0, 1): 0.5, (0, 0): 1.5}
    assert recording.footer.time_s == 2.0


@pytest.mark.parametrize(("multi_hop", "by_base"), [(True, {(0, 0): 0.0}), (False, {})])
def test_another_robot_relays_to_the_base(play, multi_hop, by_base):
    # Robot 0 is 8 m from the base; robot 1 stands between them.
    recording, _ = play(
        [*makes(0, 0.0, 9.0), END],
        [END],
        starts=[(9.0, 1.0), (5.0, 2.0)],
        base=AT_HOME,
        radio=RadioSpec(range_m=5.0, multi_hop=multi_hop),
    )
    assert delivered(recording) == by_base
    [first, *_] = recording.of(Sent)
    assert first.reached == ((1, 2) if multi_hop else (1,))


def test_the_base_relays_between_robots(play):
    recording, (_, told) = play(
        [*makes(0, 0.0, 5.0), END],
        [Receive(timeout_s=1.0), END],
        starts=[(5.0, 1.0), (1.0, 5.9 - 1.0)],
        base=AT_HOME,
        radio=RadioSpec(range_m=4.6),
    )
    assert math.dist((5.0, 1.0), (1.0, 4.9)) > 4.6
    assert recording.of(Sent)[0].reached == (1, 2)
    assert [message.sender for message in told[0].messages] == [0]


def test_walls_block_messages_to_the_base(play):
    world = Environment("cell", shapely.box(0, 0, 10, 6) - shapely.box(0, 1.9, 9, 2.1))
    for radio, got in ((RadioSpec(), {(0, 0): 0.0}), (RadioSpec(walls="block"), {})):
        recording, _ = play(
            [*makes(0, 0.0, 1.0), END], starts=[(1.0, 1.0)], base=AT_HOME, radio=radio, world=world
        )
        assert delivered(recording) == got


def test_what_is_lost_is_not_delivered(play):
    outcomes = set()
    for seed in range(6):
        recording, _ = play(
            [*makes(0, 0.0, 1.0), END],
            starts=[(1.0, 1.0)],
            base=AT_HOME,
            radio=RadioSpec(loss=0.5),
            seed=seed,
        )
        first = recording.of(Sent)[0]
        assert delivered(recording) == ({(0, 0): 0.0} if first.reached else {})
        assert (first.reached, first.lost) in (((1,), ()), ((), (1,)))
        outcomes.add(first.reached)
    assert len(outcomes) == 2


def test_a_robot_that_dies_before_delivers_nothing(play, straight):
    script = [
        Sense(),
        Note(node(0, 0.0, 9.0).added("scan")),
        straight(9.0, 1.0, 3.0, 1.0),
        Send(News(sender=0, entries=(node(0, 0.0, 9.0),))),
        END,
    ]
    more = {"starts": [(9.0, 1.0)], "base": AT_HOME, "radio": NEAR}
    assert delivered(play(script, **more)[0]) == {(0, 0): 12.0}
    recording, _ = play(script, faults=(Death(robot=0, time_s=6.0),), **more)
    assert delivered(recording) == {}
    assert measure(recording).delivered_coverage == 0.0
    recording, _ = play(script, faults=(Silence(robot=0, time_s=6.0, duration_s=10.0),), **more)
    assert delivered(recording) == {}


def test_a_node_that_is_not_on_record_is_none(play):
    sent = [Send(News(sender=0, entries=(node(0, 0.0), node(5, 0.0, robot=0))))]
    recording, _ = play(
        [Sense(), Note(node(0, 0.0).added("scan")), *sent, END], starts=[(1.0, 1.0)], base=AT_HOME
    )
    assert delivered(recording) == {(0, 0): 0.0}


def test_an_explorer_cannot_speak_for_the_base(play):
    lie = BaseLearned(time_s=0.0, robot=0, nodes=())
    with pytest.raises(InvalidInputError, match="which explorers do not note"):
        play([Note(lie), END], starts=[(1.0, 1.0)], base=AT_HOME)
    wrong = Send(News(sender=7, entries=(node(0, 0.0),)))
    with pytest.raises(InvalidInputError, match=r"sender of its message is 7.*; give sender=0"):
        play([wrong, END], starts=[(1.0, 1.0)], base=AT_HOME)


def test_the_base_is_in_nobodys_way(play, straight):
    recording, _ = play([straight(1.0, 1.0, 5.0, 1.0, guard_m=0.1), END], starts=[(1.0, 1.0)],
                        base=BaseSpec(x=3.0, y=1.0))  # fmt: skip
    [motion] = recording.of(Motion)
    assert motion.waypoints[-1][1] == 5.0


def test_a_message_on_its_way_to_the_base_is_waited_for(play):
    recording, _ = play(
        [*makes(0, 0.0, 1.0), END],
        starts=[(1.0, 1.0)],
        base=AT_HOME,
        radio=RadioSpec(latency_s=3.0),
    )
    assert recording.of(Ended)[0].time_s == 0.0
    assert delivered(recording) == {(0, 0): 3.0}
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s == 3.0


# The spec ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("x", "y", "said"),
    [
        (8.0, 1.0, "outside the outline, 1.4 m from free space; the nearest place in free space, "
         r"0.25 m from walls, is \(8, 2.66\)"),
        (6.0, 1.0, "on its border; the nearest place in free space, 0.25 m from walls, is"
         r" \(5.74, 1\)"),
    ],
)  # fmt: skip
def test_a_base_in_a_wall_is_refused(x, y, said):
    spec = RunSpec(environment=inline(ROOMS), base=BaseSpec(x=x, y=y))
    with pytest.raises(ClearanceError, match=rf"^the base station \({x:g}, {y:g}\).*{said}"):
        simulate(spec)


def test_a_place_that_is_not_finite_is_refused():
    for x in (math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="place of a base station is finite"):
            BaseSpec(x=x, y=0.0)


def test_a_spec_with_a_base_is_read_again():
    spec = RunSpec(environment=inline(ROOMS), base=BaseSpec(x=1, y=3))
    assert RunSpec.from_toml(spec.to_toml()) == spec == RunSpec.from_json(spec.to_json())
    assert spec.to_dict()["base"] == {"x": 1.0, "y": 3.0}
    assert "base" not in RunSpec(environment=inline(ROOMS)).canonical().to_json()
    with pytest.raises(InvalidInputError, match="base: there is no field 'z'"):
        RunSpec.from_toml(spec.to_toml() + "z = 1.0\n")


# Strategies --------------------------------------------------------------------------------------


def two_rooms(strategy: str, robots: int = 1, **more) -> RunSpec:
    starts = [(2.0, 3.0), (3.0, 4.0)][:robots]
    return RunSpec(
        environment=inline(ROOMS),
        strategy=strategy,
        robots=tuple(RobotSpec(start=start) for start in starts),
        base=AT_HOME,
        stop=StopRule(max_time_s=2000.0),
        seed=1,
        **{"radio": NEAR} | more,
    )


@pytest.fixture(scope="module")
def run():
    """Make runs, each once."""
    made = {}

    def make(spec: RunSpec):
        key = spec.to_json()
        if key not in made:
            made[key] = simulate(spec, ROOMS)
        return made[key]

    return make


def places_at(recording, robot: int, times_s: np.ndarray) -> np.ndarray:
    """Where a robot was, from its motions alone."""
    x, y, _ = recording.header.starts[robot]
    points = [(0.0, x, y)]
    for motion in sorted(recording.of(Motion), key=lambda motion: motion.time_s):
        if motion.robot == robot:
            points += [(motion.time_s, *points[-1][1:]), *(w[:3] for w in motion.waypoints)]
    t, x, y = np.array(points).T
    return np.column_stack([np.interp(times_s, t, x), np.interp(times_s, t, y)])


@pytest.mark.parametrize("strategy", ["srt-radial", "minpos", "closest", "rules"])
def test_a_base_knows_all_up_to_the_last_contact(run, strategy):
    """Each time that a single robot speaks in range, the base learns all that it knows."""
    recording = run(two_rooms(strategy))
    spoke_s = np.array([e.time_s for e in recording.of(Sent) if e.robot == 0])
    places = places_at(recording, 0, spoke_s)
    near = np.hypot(*(places - AT_HOME.place).T) <= 5.0 + 1e-9
    last_s = spoke_s[near].max()
    nodes = recording.of(NodeAdded)
    assert set(delivered(recording)) == {
        (n.robot, n.serial) for n in nodes if n.time_s <= last_s
    }  # fmt: skip
    assert any(n.time_s < delivered(recording).get((0, n.serial), math.inf) for n in nodes)
    if strategy == "srt-radial":  # it returns to where it started
        assert len(delivered(recording)) == len(nodes)


@pytest.mark.parametrize("strategy", ["srt-star", "minpos", "utility", "self-bidding"])
def test_a_team_delivers_what_is_seen_and_no_more(run, strategy):
    recording = run(two_rooms(strategy, 2, radio=RadioSpec(range_m=12.0)))
    m = measure(recording)
    assert m.delivered_coverage is not None
    assert 0.0 < m.delivered_coverage <= m.coverage
    curve = coverage_curve(recording, ROOMS)
    share, covered = (np.array(curve[name].values) for name in ("delivered", "coverage"))
    assert (np.diff(share) >= 0.0).all()
    assert np.all(share <= covered + 1e-12)
    assert share[-1] == m.delivered_coverage
    # Independently: the regions of the nodes, clipped to what the scans at their places showed.
    index = EdgeIndex(ROOMS.edges, 1.0)
    scans = [
        np.array([e.configuration[:2] for e in recording.of(Sensed) if e.robot == robot])
        for robot in (0, 1)
    ]
    areas = []
    for made in recording.of(NodeAdded):
        if (made.robot, made.serial) in delivered(recording):
            x, y, _ = made.configuration
            assert np.hypot(*(scans[made.robot] - (x, y)).T).min() < 1e-9
            shown = shapely.Polygon(visibility_polygon(index, x, y, 4.0)[0])
            areas.append(shapely.Polygon(made.region()).buffer(0) & shown.buffer(0))
    expected_m2 = shapely.union_all(areas).intersection(ROOMS.free).area
    found_m2 = m.delivered_coverage * m.explorable_area_m2
    assert found_m2 == pytest.approx(expected_m2, abs=2e-4 * m.explorable_area_m2 + 1e-3)
    # No robot took the base for a robot.
    for event in recording.events:
        named = {getattr(event, name, 0) for name in ("by", "other", "master")}
        assert max(named) < 2
        for name in ("gpr", "ger", "feasible", "unfeasible", "robots"):
            assert 2 not in getattr(event, name, ())


@pytest.mark.parametrize("strategy", ["srt-radial", "minpos"])
def test_a_base_changes_no_decision_of_a_single_robot(run, strategy):
    with_base = run(two_rooms(strategy))
    without = run(msgspec.structs.replace(two_rooms(strategy), base=None))
    radio_only = (Sent, BaseLearned)
    told = [e for e in with_base.events if not isinstance(e, radio_only)]
    assert told == list(without.events)
    assert not without.of(Sent)


@pytest.mark.parametrize("seed", range(5))
def test_losses_are_made_good_by_later_reports(play, seed):
    made = [node(serial, 0.0) for serial in range(4)]

    def reports():
        yield Sense()
        for one in made:
            yield Note(one.added("scan"))
        for period in range(60):
            sent = made[period : period + 1]
            have = ((0, min(period + 1, 4), 0),)
            yield Send(News(sender=0, entries=tuple(sent), have=have))
            told = yield Receive(timeout_s=1.0)
            for message in getattr(told, "messages", ()):
                if isinstance(message, WantMessage):
                    known = message.have[0][1] if message.have else 0
                    yield Send(EntriesMessage(sender=0, entries=tuple(made[known:])), 1)
        yield END

    radio = RadioSpec(loss=0.5, latency_s=0.1)
    recording, _ = play(reports, starts=[(1.0, 1.0)], base=AT_HOME, radio=radio, seed=seed)
    assert [e for e in recording.of(Sent) if e.lost]
    assert sorted(delivered(recording)) == [(0, 0), (0, 1), (0, 2), (0, 3)]


def test_a_strategy_that_shares_nothing_delivers_nothing(run):
    recording = run(two_rooms("informed", 2, options={"effort": 0.05}, radio=RadioSpec()))
    m = measure(recording)
    assert (m.delivered_coverage, m.delivered_90_s) == (0.0, None)
    assert m.delivery_delay_s is not None
    assert m.delivery_delay_s > 0.0


def test_the_digest_is_the_same_in_another_process(run):
    spec = two_rooms("minpos", 2, radio=RadioSpec(range_m=5.0, loss=0.2, latency_s=0.1))
    code = (
        "import sys; from multisrt.simulation.simulate import simulate; "
        "from multisrt.spec import RunSpec; "
        "print(simulate(RunSpec.from_json(sys.stdin.read())).footer.digest)"
    )
    other = subprocess.run(
        [sys.executable, "-c", code], input=spec.to_json(), text=True, capture_output=True,
        check=True,
    )  # fmt: skip
    assert other.stdout.strip() == run(spec).footer.digest
