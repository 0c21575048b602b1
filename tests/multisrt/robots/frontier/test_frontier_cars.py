"""Cars in frontier bidding: they reach their goals, and are never caught."""

import contextlib
import itertools
import math
from typing import Any

import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import Collision, Motion
from multisrt.geometry.bodies.clearance import rings_of
from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.trajectory import leg_length
from multisrt.robots.explorer import Look, Moved, RobotSelf, Sighting
from multisrt.robots.frontier.car_driving import CarDriver
from multisrt.robots.frontier.car_planning import MIN_LENGTH_M, ends_of, spaced_points
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import DriveSpec, RobotSpec, RunSpec, StopRule

FAMILY = ["closest", "greedy", "minpos", "utility", "self-bidding", "rules"]
BOX = "box:0.6x0.4"
RADIUS_M = 0.6


def car(kind="reeds-shepp"):
    return RobotSpec(footprint=BOX, drive=DriveSpec(kind=kind, turning_radius_m=RADIUS_M))


WALL = shapely.union_all([shapely.box(5, 0, 5.2, 1.7), shapely.box(5, 3.1, 5.2, 5)])
TWO_ROOMS = Environment(
    "two rooms",
    shapely.box(0, 0, 10, 5).difference(WALL),
    starts=[(1, 1), (1, 2.5), (1, 4)],
)
BEND = Environment(
    "bend",
    shapely.union(shapely.box(0, 0, 8, 1.6), shapely.box(6.4, 0, 8, 8)),
    starts=[(1.0, 0.8)],
)
HALL = Environment(
    "hall",
    shapely.box(0, 0, 10, 10).difference(shapely.box(4.5, 4.5, 6, 6)),
    starts=[(2, 2), (4, 2), (6, 2)],
)
# A corridor in which no car can turn round.
DEAD_END = Environment(
    "dead end",
    shapely.union(shapely.box(0, 0, 6, 6), shapely.box(6, 3, 12, 4.2)),
    starts=[(3.0, 3.0)],
)


def simulated(name, *robots, world=TWO_ROOMS, options=None, max_time_s=900.0, **spec):
    if name == "self-bidding":
        options = {"drive": "path", **(options or {})}
    return simulate(
        RunSpec(
            environment=inline(world),
            strategy=name,
            options=options or {},
            robots=robots,
            stop=StopRule(max_time_s=max_time_s),
            **spec,
        ),
        world,
    )


def motions(run, robot):
    return [e for e in run.events if isinstance(e, Motion) and e.robot == robot]


def assert_drivable(run, robot, reverse):
    """No motion is tighter than the car can drive, sideways, or on the spot."""
    for event in motions(run, robot):
        for a, b in itertools.pairwise(event.waypoints):
            turn, length = b[3] - a[3], leg_length(a, b)
            assert abs(turn) * RADIUS_M <= length + 1e-5
            if length > 1e-3:
                along = math.cos(math.atan2(b[2] - a[2], b[1] - a[1]) - a[3] - 0.5 * turn)
                assert abs(along) == pytest.approx(1.0, abs=1e-5)
                assert reverse or along > 0.0


def assert_ended_well(run):
    assert run.footer.outcome == "complete"
    assert not [e for e in run.events if isinstance(e, Collision)]


# Whole runs ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FAMILY)
def test_cars_that_reverse_complete_two_rooms(name):
    run = simulated(name, car(), car(), seed=1)
    assert_ended_well(run)
    assert measure(run, TWO_ROOMS).coverage > 0.99
    for robot in range(2):
        assert_drivable(run, robot, reverse=True)


def test_a_car_gets_round_a_bend():
    run = simulated("closest", car(), world=BEND)
    assert_ended_well(run)
    assert measure(run, BEND).coverage > 0.99
    x, y, _ = max((e.waypoints[-1][1:] for e in motions(run, 0)), key=lambda place: place[1])
    assert x > 6.4
    assert y > 3.5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["closest", "self-bidding", "rules"])
def test_cars_that_only_drive_forwards_see_a_hall(name):
    run = simulated(name, car("dubins"), world=HALL)
    assert_ended_well(run)
    assert measure(run, HALL).coverage > 0.99
    assert_drivable(run, 0, reverse=False)


def test_a_car_that_only_drives_forwards_stays_out_of_dead_ends():
    run = simulated("closest", car("dubins"), world=DEAD_END)
    assert_ended_well(run)
    assert max(w[1] for e in motions(run, 0) for w in e.waypoints) < 8.0
    back = simulated("closest", car(), world=DEAD_END)
    assert measure(back, DEAD_END).coverage > measure(run, DEAD_END).coverage


@pytest.mark.slow
@pytest.mark.parametrize("name", ["minpos", "utility"])
def test_cars_and_other_robots_explore_together(name):
    run = simulated(name, car(), RobotSpec(), car("dubins"), world=HALL, seed=2)
    assert_ended_well(run)
    assert measure(run, HALL).coverage > 0.99
    assert_drivable(run, 0, reverse=True)
    assert_drivable(run, 2, reverse=False)


@pytest.mark.slow
def test_runs_with_cars_repeat():
    first, second = (simulated("greedy", car(), car("dubins"), seed=3) for _ in range(2))
    assert first.footer.digest == second.footer.digest


@pytest.mark.parametrize("kind", ["reeds-shepp", "dubins"])
def test_the_nearness_diagram_drives_no_car(kind):
    world = inline(TWO_ROOMS)
    choices: dict[str, dict[str, bool | int | float | str]] = {
        "self-bidding": {},
        "closest": {"drive": "nearness-diagram"},
    }
    for name, options in choices.items():
        robots = (RobotSpec(), car(kind))
        spec = RunSpec(environment=world, strategy=name, options=options, robots=robots)
        with pytest.raises(InvalidInputError, match=r"robot 1 is a car.*choose drive=path") as bad:
            simulate(spec, TWO_ROOMS)
        assert "\n" not in str(bad.value)


# The exit --------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["reeds-shepp", "dubins"])
def test_a_car_always_has_a_free_exit(kind, monkeypatch):
    body = Footprint.parse(BOX)
    world = CollisionWorld(HALL.free)
    solid = world.body(body)
    note_driven, looked = CarDriver.note_driven, []

    def checked(driver, moved, set_out_s):
        note_driven(driver, moved, set_out_s)
        at = moved.configuration
        for piece in reversed(driver.route.exit()):
            assert piece.start == pytest.approx(at, abs=1e-6)
            for a, b in itertools.pairwise(piece.waypoints):
                assert (
                    leg_length(a, b) < 1e-3
                    or abs(b[3] - a[3]) * RADIUS_M <= leg_length(a, b) + 1e-5
                )
                assert world.first_contact(solid, a[1:], b[1:], b[3] - a[3], arc=True) is None
            at = piece.end
        assert at[:2] == pytest.approx((2.0, 2.0), abs=1e-6)
        looked.append(moved)

    monkeypatch.setattr(CarDriver, "note_driven", checked)
    simulated("closest", car(kind), world=HALL, options={"replan_period_s": 3.0}, max_time_s=40.0)
    assert len(looked) > 20


def robot_in(world, x, y, kind="reeds-shepp", teammates=0):
    """A robot that has looked round once."""
    me = RobotSelf(
        robot=0,
        start=Configuration(x, y, 0.0),
        footprint=Footprint.parse(BOX),
        kinematics=Car(turning_radius_m=RADIUS_M, reverse=kind == "reeds-shepp"),
        range_m=4.0,
        rng=np.random.default_rng(1),
        team=1 + teammates,
    )
    robot = FrontierRobot(me, FrontierOptions())
    rings = shapely.get_rings(shapely.get_parts(world.free))
    corners = [shapely.get_coordinates(ring) for ring in rings]
    index = EdgeIndex(np.vstack([np.hstack([c[:-1], c[1:]]) for c in corners]), 1.5)
    steps = robot.perceive()
    next(steps)
    acts_of(steps, take_scan(index, me.start, 0.0, 4.0))
    return robot


def acts_of(steps, outcome):
    """Run some steps to their end; only the first action has an outcome."""
    with contextlib.suppress(StopIteration):
        while True:
            steps.send(outcome)
            outcome = None


def motion_along(robot, path, seen=()):
    steps = robot.car.motion_along(np.array(path, float))
    try:
        action = next(steps)
        assert isinstance(action, Look)
        steps.send(tuple(seen))
    except StopIteration as end:
        return end.value
    raise AssertionError


def drive(robot, motion, duration_s):
    """Let a car drive a motion for some time."""
    duration_s = min(duration_s, motion.duration_s)
    robot.course.at = motion.at(duration_s)
    robot.course.time_s += duration_s
    moved = Moved(configuration=robot.at, time_s=robot.time_s)
    robot.car.note_driven(moved, robot.time_s - duration_s)


def new_driver(robot):
    """A driver that has planned nothing yet."""
    parts = robot.options, robot.course, robot.map, robot.bodies
    return CarDriver(robot.me, robot.me.kinematics, *parts)


def test_a_motion_is_kept_until_its_end():
    robot = robot_in(HALL, 2.0, 2.0)
    path = [(2.0, 2.0), (4.0, 3.0)]
    whole = motion_along(robot, path)
    assert whole.end[:2] == pytest.approx((4.0, 3.0))
    drive(robot, whole, 1.0)
    rest = motion_along(robot, path)
    assert rest.waypoints == whole.after(1.0).waypoints
    drive(robot, rest, 100.0)
    assert robot.at[:2] == pytest.approx((4.0, 3.0))


@pytest.mark.parametrize("kind", ["reeds-shepp", "dubins"])
def test_a_new_goal_has_a_new_motion_and_keeps_the_exit(kind):
    robot = robot_in(HALL, 2.0, 2.0, kind)
    first = motion_along(robot, [(2.0, 2.0), (4.0, 3.0)])
    drive(robot, first, 1.0)
    second = motion_along(robot, [robot.at[:2], (2.5, 4.0)])
    assert second.start == pytest.approx(robot.at)
    assert second.end[:2] == pytest.approx((2.5, 4.0))
    at = second.end
    for piece in reversed(robot.car.route._legs[0].exit_from_end()):
        assert piece.start == pytest.approx(at)
        at = piece.end
    assert at == pytest.approx(first.start)


@pytest.mark.parametrize("kind", ["reeds-shepp", "dubins"])
def test_a_car_makes_room_along_its_exit(kind):
    robot = robot_in(HALL, 2.0, 2.0, kind)
    drive(robot, motion_along(robot, [(2.0, 2.0), (4.0, 2.0)]), 3.0)
    barred = np.array([(robot.at.x, 0.0), (robot.at.x, 4.0)])
    on = robot.car.leave_by_exit(barred, 0.4)
    assert on.start == pytest.approx(robot.at)
    # Back as it came, or on to where it was going.
    beyond = on.end.x - robot.at.x
    assert beyond <= -0.4 if kind == "reeds-shepp" else beyond >= 0.4
    drive(robot, on, 100.0)
    assert robot.at == pytest.approx(on.end)
    at = on.end
    for piece in reversed(robot.car.route.exit()):
        assert piece.start == pytest.approx(at)
        at = piece.end
    assert at[:2] == pytest.approx((2.0, 2.0))
    assert robot.car.leave_by_exit(barred, 100.0) is None


def test_a_car_drives_round_bodies_beside_its_path_only():
    robot = robot_in(HALL, 2.0, 3.0, teammates=1)
    disc = Footprint.parse("disc:0.25")
    around = [(2.0, 3.0), (3.0, 4.2), (4.5, 3.0)]
    teammate = Sighting(robot=1, configuration=Configuration(3.2, 3.0, 0.0), footprint=disc)
    solid = disc.placed(teammate.configuration)

    def nearest_m(motion):
        times = np.linspace(0.0, motion.duration_s, 200)
        return min(robot.me.footprint.placed(motion.at(t)).distance(solid) for t in times)

    assert nearest_m(motion_along(robot, around)) == 0.0
    robot.car = new_driver(robot)
    assert nearest_m(motion_along(robot, around, [teammate])) >= robot.options.guard_m
    robot.car = new_driver(robot)
    assert nearest_m(motion_along(robot, [around[0], around[-1]], [teammate])) == 0.0


def test_motions_that_lead_no_nearer_are_given_up():
    robot = robot_in(HALL, 2.0, 2.0)
    path = [(2.0, 2.0), (4.0, 3.0)]
    for _ in range(1 + robot.options.max_vain_motions):
        assert motion_along(robot, path) is not None
        robot.car._aim = None
    assert motion_along_refused(robot, path)
    robot.raster._changes.revision += 1
    assert motion_along(robot, path) is not None


def motion_along_refused(robot, path):
    with pytest.raises(StopIteration) as end:
        next(robot.car.motion_along(np.array(path, float)))
    return end.value.value is None


def test_a_goal_without_a_path_is_tried_again_on_news():
    robot = robot_in(HALL, 2.0, 2.0)
    no_rule: Any = None
    explorer = FrontierExplorer(robot.me, robot.options, rule=no_rule)
    explorer.robot = robot
    (x, y), *_ = robot.targets().tolist()
    goal = Goal(x, y, np.array([(2.0, 2.0), (x, y)]), 2.24)

    def is_target():
        return [x, y] in robot.targets().tolist()

    for _ in range(2):
        assert is_target()
        list(explorer.judge_no_path(goal))
    assert not is_target()
    assert not robot.frontiers.reopen(())
    robot.raster._changes.revision += 1
    assert robot.frontiers.reopen(())
    assert is_target()
    assert not robot.frontiers.reopen(())


def test_a_goal_without_a_path_round_a_body_is_not_explored():
    robot = robot_in(HALL, 2.0, 2.0)
    no_rule: Any = None
    explorer = FrontierExplorer(robot.me, robot.options, rule=no_rule)
    explorer.robot = robot
    robot.bodies.add(
        Sighting(robot=1, configuration=Configuration(3.0, 2.0), footprint=Footprint.disc(0.25))
    )
    # Each place that is given up leaves other cells of its frontier, a finite number.
    while len(targets := robot.targets()):
        x, y = targets[0].tolist()
        list(explorer.judge_no_path(Goal(x, y, np.array([(2.0, 2.0), (x, y)]), 2.24)))
    # The body does not answer: the robot does not wait, but its map is not complete.
    assert explorer.why_no_goal() is Event.BOXED_IN
    robot.bodies.note_heard(1)
    assert explorer.why_no_goal() is Event.NO_WAY
    assert len(robot.targets()) > 0


# Places along a path ---------------------------------------------------------------------------


def test_points_along_a_path():
    path = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)])
    points = spaced_points(path, 10.0)
    assert points[0].tolist() == [0.0, 0.0, 0.0, 0.0]
    assert points[-1] == pytest.approx([1.0, 2.0, 0.5 * math.pi, 3.0])
    assert np.diff(points[:, 3]).max() <= MIN_LENGTH_M + 1e-9
    line = shapely.LineString(path)
    for x, y, heading, along in points.tolist():
        assert line.project(shapely.Point(x, y)) == pytest.approx(along, abs=1e-9)
        assert heading == pytest.approx(0.0 if along <= 1.0 else 0.5 * math.pi)
    assert spaced_points(path, 1.5)[-1] == pytest.approx([1.0, 0.5, 0.5 * math.pi, 1.5])
    assert len(spaced_points(path[:1], 1.0)) == 1


def test_ends_are_where_a_body_has_room_the_farthest_first():
    region = shapely.union(shapely.box(0, 0, 2, 2), shapely.box(2, 0.9, 4, 1.1))
    points = spaced_points(np.array([(0.5, 1.0), (4.0, 1.0)]), 10.0)
    ends = ends_of(points, rings_of(region), 0.5)
    assert [x for x, *_ in ends] == sorted((x for x, *_ in ends), reverse=True)
    assert 1.4 < ends[0][0] <= 1.5 + 1e-9
    assert all(along >= MIN_LENGTH_M for *_, along in ends)
    nearby = spaced_points(np.array([(0.9, 1.0), (0.95, 1.0)]), 10.0)
    assert [x for x, *_ in ends_of(nearby, rings_of(region), 0.5)] == [0.95]
