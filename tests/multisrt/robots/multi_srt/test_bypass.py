"""Ways through what is known where the roadmap has none: round bodies, and from tree to tree."""

import math
from dataclasses import replace
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.metrics import measure
from multisrt.environments.environment import Environment
from multisrt.events import Decision, NodeAdded
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.planners.motion.kinematics import Car, Differential
from multisrt.robots.exploration_map import Node, NodeId
from multisrt.robots.explorer import RobotSelf, Sighting
from multisrt.robots.multi_srt.build_srt import as_far_as_it_gets
from multisrt.robots.multi_srt.bypass import Bypass
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.progress import BoxedIn
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.targets import KnownNode, NewPlace
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    LateStart,
    RadioSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

RADIUS = 0.25
REACH = 8.0
BERTH = 2 * RADIUS + 1.2 * 0.1


def box_node(robot: int, serial: int, place, box) -> Node:
    """A node somewhere in a rectangle that is its region."""
    x0, y0, x1, y1 = box
    region = LocalSafeRegion(
        x=place[0],
        y=place[1],
        range_m=REACH,
        boundary=np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], float),
        tags=np.full(4, OBSTACLE, np.int8),
    )
    return Node(
        id=NodeId(robot, serial),
        configuration=Configuration(*place, 0.0),
        region=region,
        parent=None,
        time_s=0.0,
    )


def robot_in(*rooms, kinematics=None) -> SrtRobot:
    """A robot at the first of some nodes, whose regions are boxes, (x, y) and the box of each."""
    me = RobotSelf(
        robot=0,
        start=Configuration(*rooms[0][0], 0.0),
        footprint=Footprint.parse(f"disc:{RADIUS}"),
        kinematics=kinematics or Differential(),
        range_m=REACH,
        rng=np.random.default_rng(0),
        team=2,
    )
    robot = SrtRobot(me, "star", MultiSrtOptions())
    for number, (place, box) in enumerate(rooms):
        robot.map.add(box_node(0, number, place, box))
    robot.ways.extend()
    robot.at.here = NodeId(0, 0)
    robot.at.q_act = me.start
    return robot


def seen_at(x: float, y: float) -> Sighting:
    """Robot 1, seen at a place."""
    footprint = Footprint.parse(f"disc:{RADIUS}")
    return Sighting(robot=1, configuration=Configuration(x, y, 0.0), footprint=footprint)


def stand(robot: SrtRobot, x: float, y: float) -> None:
    """Robot 1 stands at a place and does not answer."""
    robot.obstacles.silent[1] = seen_at(x, y)


def stand_at(robot: SrtRobot, serial: int, place, box) -> None:
    """The robot itself has come to a place, straight from where it was, and made a node."""
    before = robot.at.here
    robot.map.add(box_node(0, serial, place, box))
    robot.at.q_act, robot.at.here = Configuration(*place, 0.0), NodeId(0, serial)
    robot.ways.extend()
    robot.ways.join(before, robot.at.here)


def corridor(width: float, body_y: float) -> SrtRobot:
    """Nodes at both ends of a corridor along y = 0, 4 m apart, and a body half way."""
    low, high = -width / 2, width / 2
    ends = ((0.0, 0.0), (-1.0, low, 5.0, high)), ((4.0, 0.0), (-1.0, low, 5.0, high))
    robot = robot_in(*ends)
    stand(robot, 2.0, body_y)
    return robot


def at_end(node: NodeId) -> bool:
    return node == NodeId(0, 1)


@pytest.mark.parametrize("body_y", [0.0, 0.2, -0.2])
def test_round_a_body_step_by_step(body_y):
    width = 2.2
    robot = corridor(width, body_y)
    known = shapely.box(-1, -width / 2, 5, width / 2)
    body = shapely.Point(2.0, body_y)
    assert robot.routes.way(robot.at.here, NodeId(0, 1)) is None
    serial = 2
    while robot.routes.way(robot.at.here, NodeId(0, 1)) is None:
        target = robot.bypass.to(at_end)
        assert isinstance(target, NewPlace)
        assert target.stage == "bypass"
        start = robot.map[target.way[-1]].configuration
        line = shapely.LineString([start[:2], (target.x, target.y)])
        assert line.distance(body) >= BERTH
        assert known.buffer(-RADIUS).covers(line)
        stand_at(robot, serial, (target.x, target.y), known.bounds)
        serial += 1
        assert serial < 6


def test_a_way_that_was_found_is_gone_to_its_end_without_searching_again(monkeypatch):
    robot, searches = corridor(2.2, 0.0), []
    search = Bypass._search
    monkeypatch.setattr(Bypass, "_search", lambda *a: searches.append(a) or search(*a))
    serial = 2
    while robot.routes.way(robot.at.here, NodeId(0, 1)) is None:
        target = robot.bypass.to(at_end)
        # Who has to wait, and asks again, is told the same.
        assert robot.bypass.to(at_end) == target
        stand_at(robot, serial, (target.x, target.y), (-1.0, -1.1, 5.0, 1.1))
        serial += 1
    assert serial > 3
    assert len(searches) == 1


def test_a_way_that_was_found_is_forgotten_where_somebody_stands_on_it():
    robot = corridor(2.2, -0.2)
    target = robot.bypass.to(at_end)
    stand(robot, target.x, target.y)
    other = robot.bypass.to(at_end)
    assert other is None or math.dist((other.x, other.y), (target.x, target.y)) > BERTH - 0.01


def test_a_way_that_was_found_is_forgotten_where_something_else_is_looked_for():
    robot = corridor(2.2, -0.2)
    assert robot.bypass.to(at_end) is not None
    assert robot.bypass.to(lambda node: False) is None
    assert robot.bypass.to_place(0.5, 0.5, NodeId(0, 1)).aim == NodeId(0, 1)


def test_no_way_where_there_is_no_room():
    # On either side it takes the body's berth and the own radius.
    room = BERTH + RADIUS
    assert corridor(2 * room - 0.02, 0.0).bypass.to(at_end) is None
    assert corridor(2 * room + 0.2, 0.0).bypass.to(at_end) is not None
    # With the body at one wall there is room at the other.
    assert corridor(2 * room - 0.02, 0.3).bypass.to(at_end) is not None


def test_to_a_place_behind_a_body():
    robot = corridor(2.4, 0.0)
    target = robot.bypass.to_place(3.5, 0.1, NodeId(0, 1))
    assert target is not None
    assert target.stage == "bypass"
    del robot.obstacles.silent[1]
    target = robot.bypass.to_place(3.5, 0.1, NodeId(0, 1))
    assert (target.x, target.y, target.stage) == (3.5, 0.1, "complete")


def test_round_a_corner_from_tree_to_tree():
    # Two corridors that meet in a corner, each seen from its far end: no straight way joins them.
    known = shapely.box(-1, -0.5, 4, 0.5).union(shapely.box(3, -0.5, 4, 6))
    robot = robot_in(((0.0, 0.0), (-1.0, -0.5, 4.0, 0.5)), ((3.5, 5.5), (3.0, -0.5, 4.0, 6.0)))
    assert robot.routes.way(robot.at.here, NodeId(0, 1)) is None
    start, (x, y) = robot.bypass.first_leg(at_end)
    assert start == robot.at.here
    assert known.buffer(-RADIUS).covers(shapely.LineString([(0, 0), (x, y)]))
    for serial in range(2, 6):
        target = robot.bypass.to(at_end)
        if not isinstance(target, NewPlace):
            break
        stand_at(robot, serial, (target.x, target.y), (-1.0, -0.5, 4.0, 0.5))
    # Now the roadmap leads there, and there is nothing to look for off it.
    assert robot.routes.way(robot.at.here, NodeId(0, 1))[-1] == NodeId(0, 1)
    assert robot.bypass.to(at_end) is None


def test_a_car_and_one_without_a_place_have_none():
    robot = corridor(2.4, 0.0)
    robot.at.here = None
    assert robot.bypass.first_leg(at_end) is None
    ends = ((0.0, 0.0), (-1.0, -2, 5.0, 2)), ((4.0, 0.0), (-1.0, -2, 5.0, 2))
    car = robot_in(*ends, kinematics=Car(turning_radius_m=0.5))
    stand(car, 2.0, 0.0)
    assert car.bypass.first_leg(at_end) is None


def test_who_is_boxed_in_ends_what_it_was_at_and_nothing_else():
    robot = corridor(2.4, 0.0)
    robot.journey.target = robot.bypass.to(at_end)

    def steps():
        yield "one"
        raise BoxedIn

    assert [*as_far_as_it_gets(robot, steps())] == ["one"]
    assert robot.journey.target is None


@pytest.mark.parametrize("strategy", ["srt-star", "srt-radial"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_who_is_left_passes_the_dead_and_explores_the_rest(strategy, seed):
    # Wherever in the corridor the other dies, there is room on one side.
    world = Environment("corridor", shapely.box(0, 0, 24, 2.6))
    spec = RunSpec(
        environment=inline(world),
        strategy=strategy,
        robots=(RobotSpec(start=(3.0, 1.3)), RobotSpec(start=(4.0, 1.3))),
        radio=RadioSpec(range_m=12.0),
        faults=(Death(robot=1, time_s=12.0, when="moving"),),
        seed=seed,
        stop=StopRule(max_time_s=3000.0),
    )
    recording = simulate(spec, world)
    assert recording.footer.outcome == "complete"
    metrics = measure(recording, world)
    assert metrics.collisions == 0
    assert metrics.coverage > 0.96
    assert math.isfinite(metrics.exploration_time_s)
    for event in recording.events:
        if isinstance(event, Decision) and event.choice == "bypass":
            assert event.target is not None
        if isinstance(event, NodeAdded):
            assert event.stage != "root" or event.serial == 0


@pytest.mark.parametrize(
    ("seen", "stands"),
    [
        ((seen_at(2.0, 0.0),), True),
        ((seen_at(2.0, 0.5),), False),
        ((), False),
    ],
    ids=["there", "elsewhere", "gone"],
)
def test_who_is_avoided_only_while_it_stands(seen, stands):
    robot = robot_in(((0.0, 0.0), (-1.0, -1.0, 5.0, 1.0)), ((4.0, 0.0), (-1.0, -1.0, 5.0, 1.0)))
    robot.team.roster.states[1] = SimpleNamespace(phase="idle", place=(2.0, 0.0, 0.0))
    robot.obstacles.avoided[1] = seen_at(2.0, 0.0)
    robot.notice(seen)
    assert (1 in robot.obstacles.avoided) == stands
    assert robot.routes.goes_straight(4.0, 0.0) == (not stands)


def test_who_is_out_of_view_is_still_believed_to_stand():
    robot = robot_in(((0.0, 0.0), (-1.0, -1.0, 1.0, 1.0)))
    robot.obstacles.avoided[1] = robot.obstacles.silent[2] = seen_at(2.0, 0.0)
    robot.notice(())
    assert robot.obstacles.avoided
    assert robot.obstacles.silent


def test_nodes_at_the_very_place_are_reached_already():
    box = (-1.0, -1.0, 5.0, 1.0)
    robot = robot_in(*(((x, 0.0), box) for x in (0.0, 0.0, 0.0, 4.0)))
    first, second, third, last = (NodeId(0, k) for k in range(4))
    assert robot.journey.past_here(KnownNode((first, last))) == KnownNode((first, last))
    assert robot.at.here == first
    assert robot.journey.past_here(KnownNode((first, second, third, last))) == KnownNode(
        (third, last)
    )
    assert robot.at.here == third
    place = NewPlace(1.0, 0.0, "complete", (third, first))
    assert robot.journey.past_here(place) == replace(place, way=(first,))
    assert robot.journey.past_here(KnownNode((first, second))) is None
    assert robot.at.here == second


def test_two_whose_ways_back_cross_do_not_stop_one_another_for_ever():
    # Balls that do not overlap are not coordinated; the ways to their parents may cross all the
    # same. Both stopped, stepped back, and tried again until the time was over.
    spec = RunSpec(
        environment=CatalogEnvironment(name="open"),
        strategy="srt-ball",
        robots=(RobotSpec(),) * 4,
        starts="clustered",
        radio=RadioSpec(range_m=20.0, walls="block"),
        faults=(
            Death(robot=3, time_s=55.444),
            Silence(robot=1, time_s=75.631, duration_s=60.0),
            LateStart(robot=2, time_s=73.638),
        ),
        stop=StopRule(max_time_s=4000.0),
        seed=1,
    )
    assert simulate(spec).footer.outcome == "complete"


def test_a_protective_stop_tells_nothing_of_other_bodies():
    robot = corridor(2.2, 0.0)
    robot.team.roster.lost[2] = None
    robot.heed(msgspec.structs.replace(seen_at(1.0, 0.0), robot=2))
    assert sorted(robot.obstacles.silent) == [1, 2]


def test_who_says_that_it_goes_is_not_avoided_any_more():
    robot, other = corridor(2.2, 0.0), corridor(2.2, 0.0)
    robot.obstacles.silent.clear()
    other.team.number = 1
    for phase, stands in (("idle", True), ("moving", False)):
        robot.obstacles.avoided[1] = seen_at(2.0, 0.0)
        other.team.plan.phase = phase
        robot.team.roster.take(other.team.state(), sender=1)
        assert (1 in robot.obstacles.avoided) == stands
