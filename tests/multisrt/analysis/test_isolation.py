import itertools
import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from multisrt.analysis.isolation import isolation, team_isolation
from multisrt.analysis.known_area import area_known_to_one
from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, CameBack, FellSilent, Joined, Learned, Motion
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.recording import Recording
from multisrt.simulation.radio import Radio
from multisrt.spec import LateStart, RadioSpec

HALL = Environment("hall", shapely.box(-5, 0, 45, 20))
FAR = RadioSpec(range_m=5.0)


@pytest.fixture(scope="module")
def team(recorded) -> Callable[..., Recording]:
    """Build a recording of a team that sees all of the hall, with a short radio."""
    return partial(recorded, world=HALL, radio=FAR, range_m=60.0)


def close(spells: Iterable[tuple[float, float]]) -> list[Any]:
    return [pytest.approx(spell, abs=1e-6) for spell in spells]


# Robot 0 stands at (20, 10); robot 1 drives past it, 3 m aside, from x = 0 to x = 40 in 40 s.
PASSING = {"starts": [(20.0, 10.0), (0.0, 7.0)]}


@pytest.fixture(scope="module")
def past(moved) -> Motion:
    return moved((5.0, 0.0, 7.0, 0.0), (45.0, 40.0, 7.0, 0.0), robot=1)


def test_two_robots_that_pass_each_other(team, past):
    # In range of 5 m while |x - 20| <= 4: from 5 + 16 to 5 + 24 s.
    result = team_isolation(team(past, **PASSING))
    for robot in result.robots:
        assert robot.spells == tuple(close([(0.0, 21.0), (29.0, 50.0)]))
        assert robot.total_s == pytest.approx(42.0, abs=1e-6)
        assert robot.longest_s == pytest.approx(21.0, abs=1e-6)
        assert robot.beyond_range_m == pytest.approx(math.hypot(20.0, 3.0) - 5.0, abs=1e-6)
    assert result.total_s == result.split_s == pytest.approx(42.0, abs=1e-6)
    assert result.longest_s == pytest.approx(21.0, abs=1e-6)
    assert result.beyond_range_m == pytest.approx(math.hypot(20.0, 3.0) - 5.0, abs=1e-6)


def test_touching_the_range_is_no_contact_that_lasts(team, moved, past):
    result = isolation(team(past, radio=RadioSpec(range_m=3.0), **PASSING))
    assert [robot.spells for robot in result] == [((0.0, 50.0),)] * 2
    # Both stand at exactly the range until one leaves: the border belongs to the range.
    away = moved((10.0, 23.0, 14.0, 0.0), (11.0, 26.0, 18.0, 0.0), robot=1)
    leaving = team(away, starts=[(20.0, 10.0), (23.0, 14.0)])
    assert isolation(leaving)[0].spells == tuple(close([(10.0, 50.0)]))
    assert isolation(leaving)[0].beyond_range_m == pytest.approx(5.0, abs=1e-6)


def test_no_robot_is_isolated_with_an_unlimited_radio(team, past):
    result = team_isolation(team(past, radio=RadioSpec(), **PASSING))
    assert (result.total_s, result.longest_s, result.split_s) == (0.0, 0.0, 0.0)
    assert result.beyond_range_m is None
    assert all(robot.spells == () and robot.beyond_range_m is None for robot in result.robots)
    alone = team_isolation(team(starts=[(1.0, 1.0)]))
    assert (alone.total_s, alone.beyond_range_m, alone.split_s) == (0.0, 0.0, 0.0)
    empty = team_isolation(team(end_s=0.0, **PASSING))
    assert (empty.total_s, empty.beyond_range_m, empty.split_s) == (0.0, 0.0, 0.0)


def test_a_chain_of_relays(team, moved):
    # 4 m from one to the next; the middle one goes 12 m up from 10 to 22 s. In contact with
    # either for 3 m, till 13 s.
    starts = [(16.0, 5.0), (20.0, 5.0), (24.0, 5.0)]
    up = moved((10.0, 20.0, 5.0, 0.0), (22.0, 20.0, 17.0, 0.0), robot=1)
    result = team_isolation(team(up, starts=starts))
    assert [robot.spells for robot in result.robots] == [tuple(close([(13.0, 50.0)]))] * 3
    assert result.split_s == pytest.approx(37.0, abs=1e-6)
    # Its ends are 8 m apart, and finally 12.649 m from the middle one.
    beyond = [robot.beyond_range_m for robot in result.robots]
    assert beyond == pytest.approx([3.0, math.hypot(12.0, 4.0) - 5.0, 3.0], abs=1e-6)
    # Without relays its ends never reach each other, but no robot is more isolated.
    single = team_isolation(team(up, starts=starts, radio=RadioSpec(range_m=5.0, multi_hop=False)))
    assert single.robots == result.robots
    assert single.split_s == 50.0


def test_two_halves_of_a_team_are_split_but_not_isolated(team, moved):
    starts = [(1.0, 1.0), (1.0, 3.0), (9.0, 1.0), (9.0, 3.0)]
    away = [
        moved((20.0, 9.0, y, math.pi), (30.0, 4.0, y, math.pi), robot=r)
        for r, y in ((2, 1.0), (3, 3.0))
    ]
    result = team_isolation(team(*away, starts=starts))
    assert result.total_s == 0.0
    assert result.split_s == pytest.approx(26.0, abs=1e-6)  # until 6 m are left


WALL = Environment(
    "wall with a window",
    HALL.free - shapely.box(19.9, -1, 20.1, 8) - shapely.box(19.9, 12, 20.1, 21),
)


def test_a_wall_that_blocks_but_for_a_window(team, moved):
    # Robot 0 stands at (16, 10); robot 1 drives up behind the wall at x = 24, 0.25 m/s. The
    # line at x = 20.1 must be between 8 and 12: y - 10 within 2 * 8 / 4.1 of 0.
    starts = [(16.0, 10.0), (24.0, 1.0)]
    up = moved((2.0, 24.0, 1.0, 1.0), (74.0, 24.0, 19.0, 1.0), robot=1)
    bound = 2.0 * 8.0 / 4.1
    for range_m in (None, 30.0):
        radio = RadioSpec(range_m=range_m, walls="block")
        recording = team(up, starts=starts, radio=radio, world=WALL, end_s=80.0)
        expected = [(0.0, 2.0 + 4.0 * (9.0 - bound)), (2.0 + 4.0 * (9.0 + bound), 80.0)]
        for robot in isolation(recording, WALL):
            assert robot.spells == tuple(close(expected))
            # Within range all the time: the wall isolates them.
            assert robot.beyond_range_m == (None if range_m is None else 0.0)
        assert isolation(recording) == isolation(recording, WALL)


def test_a_wall_that_weakens(team, moved):
    # 6.0206 dB halve the range of 12 m: along y = 4 through the wall 6 m are left of it, and
    # beside the window (y from 8 to 12) all of it.
    radio = RadioSpec(range_m=12.0, walls="weaken", wall_loss_db=20.0 * math.log10(2.0))
    for y, reach in ((4.0, 6.0), (10.0, 12.0)):
        away = moved((10.0, 22.0, y, 0.0), (26.0, 38.0, y, 0.0), robot=1)
        recording = team(away, starts=[(18.0, y), (22.0, y)], radio=radio, world=WALL)
        (first, _) = isolation(recording, WALL)
        assert first.spells == tuple(close([(10.0 + reach - 4.0, 50.0)]))
        assert first.beyond_range_m == pytest.approx(8.0, abs=1e-6)


def test_an_arc_out_of_range_and_back(team, moved):
    # A whole circle of 4 m about (20, 10) in 40 s, from its right end; robot 0 stands at its
    # left end, 2 m farther: the distance d has d^2 = 16 + 36 + 48 cos(angle), in range below 25.
    waypoints = [
        (10.0 + 10 * k, 20 + 4 * math.cos(a), 10 + 4 * math.sin(a), a + math.pi / 2)
        for k, a in enumerate(np.linspace(0.0, 2.0 * math.pi, 5).tolist())
    ]
    result = isolation(
        team(moved(*waypoints, robot=1), starts=[(14.0, 10.0), (24.0, 10.0)], end_s=60.0)
    )
    angle = math.acos((25.0 - 52.0) / 48.0)
    enters = 10.0 + 40.0 * angle / (2.0 * math.pi)
    assert result[0].spells == tuple(close([(0.0, enters), (60.0 - enters, 60.0)]))
    assert result[0].beyond_range_m == pytest.approx(5.0, abs=1e-6)


def test_the_farthest_from_the_nearest_is_between_two(team, moved):
    # Robot 0 drives from one to the other, 20 m apart: farthest in the middle.
    there = moved((0.0, 10.0, 10.0, 0.0), (20.0, 30.0, 10.0, 0.0), robot=0)
    result = isolation(team(there, starts=[(10.0, 10.0), (10.0, 10.0), (30.0, 10.0)], end_s=20.0))
    assert result[0].spells == tuple(close([(5.0, 15.0)]))
    assert result[0].beyond_range_m == pytest.approx(5.0, abs=1e-6)
    assert result[1].spells == tuple(close([(5.0, 20.0)]))
    assert result[1].beyond_range_m == pytest.approx(15.0, abs=1e-6)


def test_the_dead_the_silent_and_the_late(team, died):
    near = [(1.0, 1.0), (2.0, 1.0), (3.0, 1.0)]
    # One of the last two robots dies: the other one is not isolated any more.
    apart = isolation(team(died(10.0, 0), died(30.0, 1), starts=near))
    assert [robot.spells for robot in apart] == [(), (), ()]
    # Dead robots do not relay, and do not count for the distance.
    chain = [(1.0, 1.0), (5.0, 1.0), (9.0, 1.0)]
    result = team_isolation(team(died(20.0, 1), starts=chain))
    assert [robot.spells for robot in result.robots] == [((20.0, 50.0),), (), ((20.0, 50.0),)]
    assert [robot.beyond_range_m for robot in result.robots] == [3.0, 0.0, 3.0]
    # A silent robot is isolated, though near; the others reach each other.
    quiet = FellSilent(time_s=10.0, robot=1), CameBack(time_s=15.0, robot=1)
    for radio in (FAR, RadioSpec()):
        result = team_isolation(team(*quiet, starts=near, radio=radio))
        assert [robot.spells for robot in result.robots] == [(), ((10.0, 15.0),), ()]
        assert result.beyond_range_m == (None if radio.range_m is None else 0.0)
        assert (result.total_s, result.split_s) == (5.0, 5.0)
    # A silent robot does not relay, but counts for the distance: it is 4 m away.
    apart = isolation(team(*quiet, starts=chain))
    assert [robot.spells for robot in apart] == [((10.0, 15.0),)] * 3
    assert [robot.beyond_range_m for robot in apart] == [0.0, 0.0, 0.0]
    # A robot counts from when it joins, for itself and for others; never if it never joins.
    far = [(1.0, 1.0), (9.0, 1.0), (2.0, 1.0)]
    late = LateStart(robot=1, time_s=12.0), LateStart(robot=2, time_s=60.0)
    apart = isolation(team(Joined(time_s=12.0, robot=1), starts=far, faults=late))
    assert [robot.spells for robot in apart] == [((12.0, 50.0),), ((12.0, 50.0),), ()]


BLOCKS = Environment(
    "blocks",
    HALL.free
    - shapely.box(10.013, 5.037, 12.029, 9.041)
    - shapely.box(15.017, 8.023, 16.031, 16.043)
    - shapely.Polygon([(22.011, 4.019), (27.007, 6.053), (23.047, 9.059), (24.061, 6.067)]),
)
PLACES = st.tuples(st.floats(1.0, 39.0), st.floats(1.0, 19.0))
LEGS = st.lists(
    st.tuples(PLACES, st.sampled_from([0.0, 0.0, -2.0, 1.0, 3.0]), st.floats(1.0, 3.0)),
    max_size=4,
)


def wandering(robot, start, legs) -> Motion:
    time, heading = 0.5 * robot, 0.0
    waypoints = [(time, *start, heading)]
    for (x, y), turn, duration in legs:
        time, heading = time + duration, heading + turn
        waypoints.append((time, x, y, heading))
    return Motion(time_s=waypoints[0][0], robot=robot, waypoints=tuple(waypoints))


def places(motion: Motion, times: NDArray[np.floating]) -> NDArray[np.float64]:
    """The position of a robot on legs of constant twist, by complex numbers."""
    at = np.full(len(times), complex(*motion.waypoints[0][1:3]))
    for (t0, x0, y0, h0), (t1, x1, y1, h1) in itertools.pairwise(motion.waypoints):
        share = np.clip((times - t0) / (t1 - t0), 0.0, 1.0)
        chord, turn = complex(x1 - x0, y1 - y0), h1 - h0
        if turn:
            share = (np.exp(1j * turn * share) - 1.0) / (np.exp(1j * turn) - 1.0)
        at = np.where(times >= t0, complex(x0, y0) + chord * share, at)
    return np.column_stack([at.real, at.imag])


RADIOS = st.sampled_from(
    [
        RadioSpec(range_m=6.0713),
        RadioSpec(range_m=9.0717, multi_hop=False),
        RadioSpec(range_m=14.0737, walls="block"),
        RadioSpec(walls="block"),
        RadioSpec(range_m=16.0797, walls="weaken", wall_loss_db=4.0),
    ]
)


def in_the_open(motions: Iterable[Motion]) -> Iterator[Motion]:
    # In the free part of the world, as robots keep out of walls.
    times = np.linspace(0.0, 14.0, 1401)
    for motion in motions:
        inside = shapely.contains_xy(BLOCKS.free.buffer(-0.05), places(motion, times))
        yield motion if inside.all() else replace(motion, waypoints=motion.waypoints[:1])


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(PLACES, LEGS), min_size=2, max_size=4), RADIOS)
def test_isolation_agrees_with_sampled_times(team, drawn, radio):
    drawn = [
        (start, legs)
        for start, legs in drawn
        if BLOCKS.free.buffer(-0.1).contains(shapely.Point(start))
    ]
    motions = [wandering(robot, *one) for robot, one in enumerate(drawn)]
    if radio.walls != "pass":
        motions = list(in_the_open(motions))
    if len(motions) < 2:
        return
    starts = [motion.waypoints[0][1:3] for motion in motions]
    end = 14.0
    result = team_isolation(
        team(*motions, starts=starts, radio=radio, world=BLOCKS, end_s=end), BLOCKS
    )
    step = 1e-2
    times = (np.arange(round(end / step)) + 0.5) * step
    where = np.stack([places(motion, times) for motion in motions], axis=1)
    truth = Radio(radio, EdgeIndex(BLOCKS.edges, 3.0), np.random.default_rng(0))
    working = [True] * len(motions)
    links = np.array([truth.links(at, working) for at in where])
    reached = [len(truth.reached(0, at, working)) for at in where]
    alone = np.asarray(~links.any(axis=2))
    full = links.sum(axis=(1, 2)) == len(motions) * (len(motions) - 1)
    split = np.array(reached) < len(motions) - 1 if radio.multi_hop else ~full
    changes = np.count_nonzero(np.diff(alone, axis=0), axis=0)
    slack = (int(np.count_nonzero(np.diff(split))) + 1) * step
    for robot, own in enumerate(result.robots):
        inside = np.zeros(len(times), np.bool_)
        for a, b in own.spells:
            inside |= (times > a) & (times < b)
        # Moments are precise enough for every sample to be on the right side.
        assert np.array_equal(inside, alone[:, robot])
        assert own.total_s == pytest.approx(
            alone[:, robot].sum() * step, abs=(changes[robot] + 2 * len(own.spells)) * step
        )
        if radio.range_m is not None and own.spells:
            fine = np.concatenate([np.arange(a, b, 1e-3) for a, b in own.spells])
            others = np.stack([places(m, fine) for m in motions if m.robot != motions[robot].robot])
            gaps = np.hypot(*np.moveaxis(others - places(motions[robot], fine), 2, 0)).min(axis=0)
            farthest = max(0.0, gaps.max() - radio.range_m)
            # A leg is at most 66 m long and takes a second or more.
            assert own.beyond_range_m is not None
            assert farthest - 1e-5 <= own.beyond_range_m <= farthest + 132.0 * 1e-3
    assert result.split_s == pytest.approx(split.sum() * step, abs=2 * slack)
    assert result.total_s == pytest.approx(
        alone.any(axis=1).sum() * step, abs=2 * step * (changes.sum() + 1)
    )
    assert result.longest_s == max(robot.longest_s for robot in result.robots)


# Area known to one robot -------------------------------------------------------------------


def learned(time_s, robot, *nodes) -> Learned:
    return Learned(time_s=time_s, robot=robot, nodes=nodes)


TWO = [(1.0, 1.0), (9.0, 1.0)]


@pytest.fixture(scope="module")
def exchange(seen) -> tuple[AnyEvent, ...]:
    return (
        seen(0.0, shapely.box(0, 0, 4, 10), robot=0, serial=0),  # 40 m2 of robot 0 alone
        seen(
            5.0, shapely.box(3, 0, 9, 10), robot=1, serial=0
        ),  # overlaps by 10: 30 of robot 0, 50 of robot 1
        learned(10.0, 1, (0, 0)),  # robot 0 alone knows nothing any more
        seen(
            20.0, shapely.box(8, 0, 12, 10), robot=0, serial=1
        ),  # 30 new, and 10 that were robot 1's: 40 are left to it
        learned(25.0, 0, (1, 0)),
        learned(25.0, 0, (1, 0)),  # once more changes nothing
    )


def test_two_robots_that_exchange_their_maps_late(team, exchange):
    known = area_known_to_one(team(*exchange, starts=TWO))
    assert known.integral_m2s == pytest.approx(
        (40.0 * 5 + 30.0 * 5 + 30.0 * 30, 50.0 * 5 + 50.0 * 10 + 40.0 * 5), rel=1e-4
    )
    assert known.final_m2 == pytest.approx((30.0, 0.0), rel=1e-4)
    metrics = measure(team(*exchange, starts=TWO), HALL)
    assert metrics.known_to_one_by_robot_m2s == pytest.approx(known.integral_m2s)
    assert metrics.known_to_one_m2s == pytest.approx(2200.0, rel=1e-4)
    assert metrics.known_to_one_m2 == pytest.approx(30.0, rel=1e-4)


def test_what_only_a_dead_robot_knew_is_known_to_no_robot(team, died, exchange):
    known = area_known_to_one(team(*exchange, died(30.0, 0), starts=TWO))
    # Robot 1 alone knows the first node and its own: 90 m2.
    assert known.integral_m2s == pytest.approx((350.0 + 30.0 * 10, 950.0 + 90.0 * 20), rel=1e-4)
    assert known.final_m2 == pytest.approx((0.0, 90.0), rel=1e-4)
    # What it learns later counts for it again.
    more = died(30.0, 0), learned(40.0, 1, (0, 1))
    known = area_known_to_one(team(*exchange, *more, starts=TWO))
    assert known.final_m2 == pytest.approx((0.0, 120.0), rel=1e-4)


def test_no_area_without_nodes(team):
    assert area_known_to_one(team(starts=TWO)).integral_m2s == (0.0, 0.0)


BOXES = st.tuples(st.integers(0, 30), st.integers(1, 9))
STORY = st.lists(
    st.tuples(
        st.integers(0, 4), st.floats(0.0, 9.0), st.one_of(BOXES, st.none(), st.integers(0, 9))
    ),
    max_size=14,
)


@settings(max_examples=40, deadline=None)
@given(STORY)
def test_known_areas_agree_with_sets_of_columns(team, died, seen, story):
    """Boxes of whole metres, so that sets of their columns are the truth.

    Areas are exact to 1e-4 of what is explorable, 1,000 m2.
    """
    events: list[AnyEvent] = []
    boxes: list[tuple[tuple[int, int], set[int]]] = []
    knows: list[set[int]] = [set() for _ in range(5)]
    alone = np.zeros(5)
    integral, since = np.zeros(5), 0.0
    dead = set()

    def count() -> NDArray[np.float64]:
        return np.array(
            [
                10.0 * len(own.difference(*(o for k, o in enumerate(knows) if k != robot)))
                for robot, own in enumerate(knows)
            ]
        )

    for robot, wait, what in story:
        if robot in dead:
            continue
        time = since + wait
        integral, since = integral + alone * wait, time
        if what is None:
            events.append(died(time, robot))
            dead.add(robot)
            knows[robot] = set()
        elif isinstance(what, int):
            if what >= len(boxes):
                continue
            name, columns = boxes[what]
            events.append(learned(time, robot, name))
            knows[robot] |= columns
        else:
            name, columns = (robot, len(boxes)), set(range(what[0], sum(what)))
            events.append(
                seen(time, shapely.box(what[0], 0, sum(what), 10), robot=name[0], serial=name[1])
            )
            boxes.append((name, columns))
            knows[robot] |= columns
        alone = count()
    known = area_known_to_one(
        team(*events, starts=[(1.0 + k, 1.0) for k in range(5)], end_s=since + 3.0)
    )
    assert known.final_m2 == pytest.approx(alone, abs=0.05)
    assert known.integral_m2s == pytest.approx(integral + 3.0 * alone, abs=0.05 * (since + 3.0))


def test_metrics_include_isolation(team, past):
    metrics = measure(team(past, **PASSING), HALL)
    assert metrics.isolated_total_s == pytest.approx(42.0, abs=1e-6)
    assert metrics.isolated_by_robot_s == pytest.approx((42.0, 42.0), abs=1e-6)
    assert metrics.isolated_longest_s == pytest.approx(21.0, abs=1e-6)
    assert metrics.split_s == pytest.approx(42.0, abs=1e-6)
    assert metrics.beyond_range_m == pytest.approx(math.hypot(20.0, 3.0) - 5.0, abs=1e-6)
