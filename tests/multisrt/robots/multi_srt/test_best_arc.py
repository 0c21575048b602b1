"""The choice of the frontier arc that shows much for a short way, in worlds drawn by hand."""

import math
from collections.abc import Generator
from typing import Any

import msgspec
import numpy as np
import pytest

from multisrt.analysis.measuring import measure
from multisrt.environments.catalog import environment
from multisrt.events import Collision, Decision, NodeAdded
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.boundary import OBSTACLE, RANGE
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.geometry.regions.unknown_area import unknown_areas
from multisrt.planners.srt import Draws
from multisrt.recording import Recording
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.multi_srt.best_arc import (
    MAX_RECORDED,
    NEAREST_M,
    best_arc,
    first_view,
    valued_arcs,
)
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.targets import NewPlace
from multisrt.simulation.simulate import simulate
from multisrt.spec import (
    CatalogEnvironment,
    DriveSpec,
    RadioSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

RANGE_M = 4.0
HALF_DISC_M2 = 0.5 * math.pi * RANGE_M**2
UP = 0.5 * math.pi

Box = tuple[float, float, float, float]

CLOSET: tuple[Box, str] = (-9.0, -9.0, -4.5, 9.0), ""
"""A closed part of the world, 0.5 m to the left of `room(-4, ...)`: little is unknown between."""


@pytest.fixture
def robot_at(robot_self):
    """Build a robot at the origin, in the first of some rectangles of which it knows all.

    The letters ``l`` and ``r`` after each name the sides, left and right, that are open.
    """

    def build(*boxes: tuple[Box, str], heading: float = UP, number: int = 0, **options: Any):
        me = robot_self(start=Configuration(0.0, 0.0, heading), range_m=RANGE_M, robot=number)
        robot = SrtRobot(me, "radial", MultiSrtOptions(choice="gain", **options))
        for serial, (box, sides) in enumerate(boxes):
            robot.map.add(node(serial, box, sides))
        robot.roadmap.extend()
        robot.at.here = robot.at.tree = NodeId(0, 0)
        return robot

    return build


def node(serial: int, box: Box, sides: str) -> Node:
    x0, y0, x1, y1 = box
    tags = [OBSTACLE, RANGE if "r" in sides else OBSTACLE, OBSTACLE]
    tags.append(RANGE if "l" in sides else OBSTACLE)
    place = (0.0, 0.0) if serial == 0 else (0.5 * (x0 + x1), 0.5 * (y0 + y1))
    return Node(
        id=NodeId(0, serial),
        configuration=Configuration(*place),
        region=LocalSafeRegion(
            x=place[0],
            y=place[1],
            range_m=RANGE_M,
            boundary=np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]),
            tags=np.array(tags, np.int8),
        ),
        parent=None if serial == 0 else NodeId(0, 0),
        time_s=0.0,
    )


def room(left: float, right: float, sides: str = "lr") -> tuple[Box, str]:
    return (left, -2.0, right, 2.0), sides


def never(node: NodeId, arc: np.ndarray) -> None:
    pytest.fail(f"an arc of {node} is postponed")


def values(robot) -> list[tuple[float, float]]:
    return [(arc.x, arc.value) for arc in valued_arcs(robot, robot.deferred.arcs)]


def outcome_of(steps: Generator[Any, Any, Any]) -> Any:
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value


def test_the_value_is_the_area_over_a_power_of_the_way(robot_at):
    robot = robot_at(room(-4, 3, "r"))
    (arc,) = valued_arcs(robot, robot.deferred.arcs)
    # Half a disc lies beyond the middle, 3 m away, after a turn by a right angle.
    way_m = 3.0 + 0.3 * UP
    assert arc.area_m2 == pytest.approx(HALF_DISC_M2)
    assert arc.way_m == pytest.approx(way_m)
    assert arc.value == pytest.approx((HALF_DISC_M2 + 5.0) / (way_m + NEAREST_M) ** 4)


def test_of_arcs_at_one_distance_the_one_with_more_beyond_is_first(robot_at):
    # It faces the arc with little beyond.
    robot = robot_at(room(-4, 4), CLOSET, heading=math.pi, turn_m_per_rad=0.1)
    assert [x for x, _ in values(robot)] == [4.0, -4.0]


def test_of_arcs_with_as_much_beyond_the_nearest_is_first(robot_at):
    assert values(robot_at(room(-4, 3)))[0][0] == 3.0
    assert values(robot_at(room(-3, 4)))[0][0] == -3.0


@pytest.mark.parametrize(("power", "first"), [(1.0, 5.0), (4.0, -2.0)])
def test_the_power_says_how_far_a_robot_goes_for_area(robot_at, power, first):
    behind: tuple[Box, str] = (-9.0, -9.0, -2.5, 9.0), ""
    robot = robot_at(room(-2, 5), behind, power=power)
    assert values(robot)[0][0] == first


@pytest.mark.parametrize(("heading", "first"), [(0.0, 4.0), (math.pi, -4.0)])
def test_a_robot_does_not_turn_round_for_nothing(robot_at, heading, first):
    assert values(robot_at(room(-4, 4), heading=heading))[0][0] == first


def test_an_arc_that_another_robot_goes_to_is_worth_less(robot_at, robot_state):
    alone = dict(values(robot_at(room(-4, 4))))
    robot = robot_at(room(-4, 4))
    robot.team.roster.take(robot_state(1, ((-8.0, 0.0), (-5.0, 0.0)), moving=True), 1)
    shared = dict(values(robot))
    # Its target is a quarter of the range from the left arc.
    assert shared == pytest.approx({-4.0: 0.25 * alone[-4.0], 4.0: alone[4.0]})


def test_a_robot_that_stands_takes_nothing(robot_at, robot_state):
    robot = robot_at(room(-4, 4))
    robot.team.roster.take(robot_state(1, ((-5.0, 0.0),)), 1)
    assert values(robot) == values(robot_at(room(-4, 4)))


def test_robots_with_equal_knowledge_value_arcs_alike(robot_at):
    worlds = room(-4, 3), CLOSET
    assert values(robot_at(*worlds, number=0)) == values(robot_at(*worlds, number=2))


def test_the_way_to_another_node_leads_over_the_roadmap(robot_at):
    robot = robot_at(room(-2, 2, ""), ((1.0, -2.0, 5.0, 2.0), "r"))
    (arc,) = valued_arcs(robot, robot.deferred.arcs)
    # Over the node in the middle of the second rectangle, at x = 3.
    assert arc.node == NodeId(0, 1)
    assert arc.way_m == pytest.approx(5.0 + 0.3 * UP)


def test_the_robot_goes_to_where_it_sees_the_best_arc(robot_at):
    robot, draws = robot_at(room(-4, 3), stop_share=1.0), Draws()
    is_interim, place = outcome_of(best_arc(robot, robot.deferred.arcs, never, draws))
    assert not is_interim
    assert 2.0 < place.x < 3.0
    assert place.route == (NodeId(0, 0),)
    assert [arc[0] for arc in draws.arcs] == [3.0, -4.0]


def test_arcs_to_whose_views_no_path_leads_are_postponed(robot_at, monkeypatch):
    robot = robot_at(room(-4, 3))
    postponed: list[tuple[NodeId, np.ndarray]] = []

    def arcs_of(node: NodeId) -> list[np.ndarray]:
        return robot.deferred.arcs(node)[len(postponed) :]

    monkeypatch.setattr(type(robot.views), "viewing_place", lambda *_: "not reachable")
    steps = best_arc(robot, arcs_of, lambda node, arc: postponed.append((node, arc)), Draws())
    assert outcome_of(steps) is None
    assert [node for node, _ in postponed] == [NodeId(0, 0)] * 2
    assert robot.map.closings == ()


def test_nodes_that_are_not_wanted_are_left_out(robot_at):
    robot, draws = robot_at(room(-4, 3)), Draws()
    assert outcome_of(best_arc(robot, lambda node: [], never, draws)) is None
    assert draws.arcs == []


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_it_stops_at_the_first_place_that_shows_enough(robot_at, share):
    robot = robot_at(room(-4, 4, "r"), stop_share=share)
    end = NewPlace(3.5, 0.0, "complete", (NodeId(0, 0),), roomy=True)
    stop = first_view(robot, end)
    places = np.array([(x, 0.0) for x in np.arange(1, 8) * 0.5])
    areas = unknown_areas(places, RANGE_M, [n.region for n in robot.map.nodes])
    assert stop.x == places[np.argmax(areas >= share * areas.max()), 0]
    assert stop.x < end.x or share == 0.9


def test_it_goes_all_the_way_where_it_is_told_to_or_has_to(robot_at):
    end = NewPlace(3.5, 0.0, "complete", (NodeId(0, 0),), roomy=True)
    assert first_view(robot_at(room(-4, 4, "r"), stop_share=1.0), end) is end
    narrow = NewPlace(3.5, 0.0, "complete", (NodeId(0, 0),), roomy=False)
    assert first_view(robot_at(room(-4, 4, "r")), narrow) is narrow


def test_it_goes_all_the_way_where_no_place_shows_anything(robot_at):
    end = NewPlace(3.5, 0.0, "complete", (NodeId(0, 0),), roomy=True)
    assert first_view(robot_at(room(-4, 4, "")), end) is end


def test_it_stops_at_no_place_near_a_node(robot_at):
    # All but the end of the way is within half of the distance that places keep from nodes.
    robot = robot_at(room(-4, 4, "r"), d_min_m=8.0, stop_share=0.1)
    end = NewPlace(3.5, 0.0, "complete", (NodeId(0, 0),), roomy=True)
    assert (first_view(robot, end).x, first_view(robot, end).y) == (3.5, 0.0)


def test_a_stop_on_the_way_does_not_count_as_a_look(robot_at):
    robot = robot_at(room(-4, 4, "r"), max_views=1)
    for _ in range(3):
        # As if the robot had stood elsewhere in between, so that each would count.
        robot.views._last_choice = None
        assert outcome_of(best_arc(robot, robot.deferred.arcs, never, Draws())) is not None
    assert robot.map.has_frontier(NodeId(0, 0))


def test_a_look_from_the_end_of_the_way_counts(robot_at):
    # All stops before the end are too near to a node.
    robot = robot_at(room(-4, 4, "r"), d_min_m=8.0, stop_share=0.1, max_views=1)
    looks = 0
    while outcome_of(best_arc(robot, robot.deferred.arcs, never, Draws())) is not None:
        robot.views._last_choice = None
        looks += 1
        assert looks < 5
    assert looks


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"choice": "gain", "complete": False}, "choice is gain, but complete is false"),
        ({"power": 0.0}, "power is 0.0; it must be positive"),
        ({"return_area_m2": -1.0}, "return_area_m2 is -1.0; it must be 0 or more"),
        ({"turn_m_per_rad": math.inf}, "turn_m_per_rad is inf"),
        ({"stop_share": 0.0}, "stop_share is 0.0; it must be above 0 and at most 1"),
    ],
)
def test_options_out_of_range_are_refused(options, said):
    with pytest.raises(InvalidInputError, match=said):
        MultiSrtOptions(**options)


ROOMS = CatalogEnvironment(name="rooms", parameters={"size_m": 16.0, "rooms_per_side": 2}, seed=3)
BOX = RobotSpec(footprint="box:0.5x0.3")
CAR = RobotSpec(footprint="box:0.5x0.3", drive=DriveSpec(kind="reeds-shepp", turning_radius_m=0.4))


def run(strategy: str, *robots: RobotSpec, choice: str = "gain", **more: Any) -> Recording:
    return simulate(
        RunSpec(
            environment=ROOMS,
            strategy=strategy,
            robots=robots,
            seed=1,
            options={"choice": choice},
            stop=StopRule(max_time_s=3000.0),
            **more,
        )
    )


@pytest.mark.parametrize(
    ("strategy", "robots", "more"),
    [
        ("srt-radial", (RobotSpec(),), {}),
        ("srt-radial", (RobotSpec(),) * 3, {"starts": "clustered"}),
        ("srt-radial", (RobotSpec(),) * 3, {"radio": RadioSpec(range_m=13.0)}),
        ("srt-radial", (BOX, RobotSpec()), {}),
        ("srt-radial", (CAR,), {}),
        ("srt-star", (RobotSpec(),) * 2, {}),
        ("srt-ball", (RobotSpec(footprint="disc:0.15"),), {}),
    ],
)
@pytest.mark.slow
def test_whole_explorations_end_with_all_seen(strategy, robots, more):
    recording = run(strategy, *robots, **more)
    assert recording.footer.outcome == "complete"
    assert not list(recording.of(Collision))
    parameters: dict[str, Any] = dict(ROOMS.parameters)
    metrics = measure(recording, environment(ROOMS.name, seed=3, **parameters))
    assert metrics.coverage > 0.99
    decisions = list(recording.of(Decision))
    chosen = {decision.choice for decision in decisions}
    assert "gain" in chosen
    assert chosen.isdisjoint({"draw", "approach", "parent"})
    for decision in decisions:
        if decision.choice == "gain":
            assert decision.arcs is not msgspec.UNSET
            assert 1 <= len(decision.arcs) <= MAX_RECORDED
            assert [arc[-1] for arc in decision.arcs] == sorted(
                (arc[-1] for arc in decision.arcs), reverse=True
            )


@pytest.mark.slow
def test_equal_specs_give_equal_explorations():
    first, again = (run("srt-radial", RobotSpec(), RobotSpec()) for _ in range(2))
    assert first.footer.digest == again.footer.digest


@pytest.mark.slow
def test_random_draws_record_no_arcs():
    recording = run("srt-radial", RobotSpec(), choice="random")
    assert all(decision.arcs is msgspec.UNSET for decision in recording.of(Decision))
    assert {"draw"} <= {event.stage for event in recording.of(NodeAdded)}
