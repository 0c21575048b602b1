import heapq
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.collision import Body
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.simulation.traffic import Traffic

HALL = shapely.box(-50, -50, 50, 50)
DISC = Body(Footprint.disc(0.5))
BODIES = {
    "disc": DISC,
    "box": Body(Footprint.box(1.2, 0.6)),
    "ell": Body(Footprint.parse("polygon:-0.2,-0.2 0.6,-0.2 0.6,0.1 0.1,0.1 0.1,0.5 -0.2,0.5")),
}


def index_of(world=HALL):
    return EdgeIndex(Environment("world", world).edges, 3.0)


OPEN = index_of()


def traffic(*starts, bodies=None, index=OPEN):
    return Traffic(
        bodies or [DISC] * len(starts), [Configuration(*start) for start in starts], index
    )


def straight(x, y, to_x, to_y, speed=1.0, heading=0.0):
    duration = math.hypot(to_x - x, to_y - y) / speed
    return Trajectory((Waypoint(0.0, x, y, heading), Waypoint(duration, to_x, to_y, heading)))


def test_a_disc_drives_up_to_one_that_stands():
    # Centres are 10 m apart; bodies touch at 1 m, and the guard adds 0.5 m: after 8.5 s.
    roads = traffic((0, 0), (10, 0))
    roads.begin(0, 3.0, straight(0, 0, 20, 0), 0.5)
    event = roads.next_event(0, 3.0)
    assert (event.other, event.kind) == (1, "guard")
    assert event.time_s == pytest.approx(3.0 + 8.5, abs=1e-6)
    assert roads.next_event(1, 3.0) is None
    assert roads.next_event(0, 7.0) == event
    stop = roads.end(0, event.time_s)
    assert stop.x == pytest.approx(8.5, abs=1e-6)
    assert stop.x < 8.5
    assert roads.where(0, 100.0) == stop
    assert roads.next_event(0, 12.0) is None


def test_without_a_guard_bodies_touch():
    roads = traffic((0, 0), (10, 0))
    roads.begin(0, 0.0, straight(0, 0, 20, 0), None)
    event = roads.next_event(0, 0.0)
    assert (event.other, event.kind) == (1, "contact")
    assert event.time_s == pytest.approx(9.0, abs=1e-6)
    roads.end(0, 2.0)
    roads.begin(0, 5.0, straight(2, 0, 8.9, 0), None)
    assert roads.next_event(0, 5.0) is None


def test_two_robots_that_meet_stop_each_by_its_own_guard():
    # The bodies are 9 m apart and approach at 2 m/s.
    roads = traffic((0, 0), (10, 0))
    roads.begin(0, 0.0, straight(0, 0, 10, 0), 1.0)
    assert roads.next_event(0, 0.0).time_s == pytest.approx(8.0, abs=1e-6)
    roads.begin(1, 0.0, straight(10, 0, 0, 0), 0.2)
    assert roads.affected(1) == [0]
    assert roads.next_event(0, 0.0).time_s == pytest.approx(4.0, abs=1e-6)
    assert roads.next_event(1, 0.0).time_s == pytest.approx(4.4, abs=1e-6)
    roads.end(0, 4.0)
    assert roads.affected(0) == [1]
    # The second goes on alone, by the remaining metre less 0.2 m.
    assert roads.next_event(1, 4.0).time_s == pytest.approx(4.8, abs=1e-6)


def test_a_robot_that_follows_at_the_same_speed_is_not_stopped():
    roads = traffic((0, 0), (2, 0))
    roads.begin(1, 0.0, straight(2, 0, 12, 0), 0.9)
    roads.begin(0, 0.0, straight(0, 0, 10, 0), 0.9)
    assert roads.next_event(0, 0.0) is None
    assert roads.next_event(1, 0.0) is None
    # The one ahead is stopped: the distance of 1 m between the bodies shrinks to 0.9 m.
    roads.end(1, 4.0)
    assert roads.affected(1) == [0]
    assert roads.next_event(0, 4.0).time_s == pytest.approx(4.1, abs=1e-6)


def test_robots_that_stand_close_can_part():
    # The bodies are 0.6 m apart, the guard is at 1 m.
    roads = traffic((0, 0), (1.6, 0))
    roads.begin(0, 0.0, straight(0, 0, -5, 0), 1.0)
    assert roads.next_event(0, 0.0) is None
    roads.end(0, 0.0)
    roads.begin(0, 0.0, straight(0, 0, 5, 0), 1.0)
    assert roads.next_event(0, 0.0).time_s == pytest.approx(0.3, abs=1e-6)
    roads.end(0, 0.3)
    # Sideways past it: the distance only grows.
    roads.begin(0, 0.3, straight(0.3, 0, 0.3, 9), 1.0)
    assert roads.next_event(0, 0.3) is None


@pytest.mark.parametrize(
    ("apart", "stop"), [(0.6, 0.3), (0.4, 0.25), (0.25, 0.25), (0.1, 0.1), (0.001, 0.001)]
)
def test_how_near_a_robot_comes_to_a_body_within_its_guard(apart, stop):
    # Half of the distance, but not within a quarter of the guard of 1 m.
    roads = traffic((0, 0), (1 + apart, 0))
    roads.begin(0, 0.0, straight(0, 0, 5, 0), 1.0)
    assert roads.next_event(0, 0.0).time_s == pytest.approx(apart - stop, abs=1e-6 + 2e-3 * stop)


def test_repeated_motions_do_not_creep_up_to_a_body():
    roads, x, now = traffic((0, 0), (1.5, 0)), 0.0, 0.0
    for _ in range(40):
        roads.begin(0, now, straight(x, 0, 5, 0), 0.1)
        event = roads.next_event(0, now)
        assert event.kind == "guard"
        now = event.time_s
        x = roads.end(0, now).x
    assert 0.9 * 0.025 < 1.5 - 1.0 - x <= 0.025


def test_after_a_stop_a_robot_is_as_near_as_the_guard():
    roads = traffic((0, 0), (5, 0))
    roads.begin(0, 0.0, straight(0, 0, 10, 0), 1.0)
    event = roads.next_event(0, 0.0)
    here = roads.end(0, event.time_s)
    roads.begin(0, event.time_s, straight(here.x, here.y, 10, 0), 1.0)
    again = roads.next_event(0, event.time_s)
    assert again.time_s == pytest.approx(event.time_s + 0.5, abs=2e-5)


def test_arrivals_are_exact():
    roads = traffic((0.1, 0.2), (40, 40))
    motion = Trajectory((Waypoint(0, 0.1, 0.2, 0), Waypoint(1 / 3, 0.1, 0.7, 0.1)))
    roads.begin(0, 0.7, motion, 0.3)
    assert roads.where(0, 0.7 + 1 / 3 + 1e-9) == motion.end
    assert roads.where(0, 0.7) == motion.start
    assert roads.end(0, 0.7 + motion.duration_s) == motion.end
    assert roads.where(0, 5.0) == motion.end
    assert roads.affected(0) == []


def test_a_cut_is_where_the_trajectory_is_then():
    roads = traffic((0, 0, 0), (40, 40))
    arc = Trajectory((Waypoint(0, 0, 0, 0), Waypoint(3.0, 2, 2, math.pi / 2)))
    roads.begin(0, 1.0, arc, None)
    assert roads.where(0, 2.0) == arc.at(1.0)
    here = roads.end(0, 2.5)
    assert here == arc.until(1.5).end
    assert here.x == pytest.approx(2 * math.sin(math.pi / 4))
    assert here.y == pytest.approx(2 - 2 * math.cos(math.pi / 4))
    assert roads.where(0, 9.0) == here


def test_a_robot_that_has_arrived_is_an_obstacle():
    roads = traffic((0, 0), (10, 5))
    roads.begin(1, 0.0, straight(10, 5, 10, 0), None)
    roads.begin(0, 0.0, straight(0, 0, 20, 0), 0.5)
    event = roads.next_event(0, 0.0)
    assert event.time_s == pytest.approx(8.5, abs=1e-6)
    roads.end(1, 5.0)
    assert roads.affected(1) == []
    assert roads.next_event(0, 5.0) == event


def test_a_thin_wall_hides():
    wall = shapely.box(-50, 0.9, 4, 0.95)
    hidden = traffic((0, 0), (3, 1.8), index=index_of(HALL - wall))
    hidden.begin(0, 0.0, straight(0, 0, 6, 0), 1.5)
    # The wall ends at x = 4. The line of sight to (3, 1.8) passes its upper corner (4, 0.95) when
    # the robot is 1.8 / 0.85 = 2.118 m to the right of the other: 1.779 m between the bodies.
    assert hidden.next_event(0, 0.0) is None
    hidden.end(0, 0.0)
    hidden.begin(0, 0.0, straight(0, 0, 6, 0), 1.9)
    event = hidden.next_event(0, 0.0)
    assert (event.kind, event.other) == ("guard", 1)
    assert event.time_s == pytest.approx(3 + 1.8 / 0.85, abs=1e-5)
    # Without the wall it is stopped earlier.
    seen = traffic((0, 0), (3, 1.8))
    seen.begin(0, 0.0, straight(0, 0, 6, 0), 1.5)
    assert seen.next_event(0, 0.0).time_s == pytest.approx(3 - math.sqrt(2.5**2 - 1.8**2), abs=1e-6)


def test_a_blind_corner_stops_a_robot_at_first_sight():
    # A block has its corner in the origin. Both drive towards it, at (-4, 0.6) and (0.6, -4);
    # they see each other when the line x + y = s - 3.4 passes the corner, at s = 3.4, with
    # sqrt(2) * 1.2 = 1.697 m between the centres, 1.297 m between the bodies.
    corner = HALL - shapely.box(-50, -50, 0, 0)
    body = Body(Footprint.disc(0.2))
    roads = traffic((-4, 0.6), (0.6, -4), bodies=[body, body], index=index_of(corner))
    roads.begin(0, 0.0, straight(-4, 0.6, 5, 0.6), 1.5)
    roads.begin(1, 0.0, straight(0.6, -4, 0.6, 5), 1.5)
    for robot in (0, 1):
        event = roads.next_event(robot, 0.0)
        assert event.kind == "guard"
        assert event.time_s == pytest.approx(3.4, abs=1e-3)


def test_bodies_are_seen_by_their_nearest_points_too():
    # Two long boxes meet nose to nose round a corner that hides their reference points.
    corner = HALL - shapely.box(-50, -50, 0, 0)
    long = Body(Footprint.box(4.0, 0.4))
    roads = traffic(
        (-6, 0.3, 0), (0.25, -2.2, math.pi / 2), bodies=[long, long], index=index_of(corner)
    )
    roads.begin(0, 0.0, straight(-6, 0.3, 5, 0.3), 0.5)
    # Its nose, at x = t - 4, y = 0.1, is 0.5 m from the other's, at (0.05, -0.2), when x = -0.35.
    # The line between them passes the corner when the nose is at x = -0.025; middles are hidden.
    event = roads.next_event(0, 0.0)
    assert event.kind == "guard"
    assert event.time_s == pytest.approx(3.975, abs=1e-5)


def test_a_wall_does_not_hide_a_contact():
    # A wall thinner than the bodies, which drive through it here: they touch unseen.
    wall = shapely.box(-50, -0.01, 50, 0.01)
    roads = traffic((0, -3), (0, 0.6), index=index_of(HALL - wall))
    roads.begin(0, 0.0, straight(0, -3, 0, 9), 0.5)
    event = roads.next_event(0, 0.0)
    assert (event.kind, event.other) == ("contact", 1)
    assert event.time_s == pytest.approx(2.6, abs=1e-5)


def test_robots_are_seen_by_their_bodies():
    wall = shapely.box(3, -5, 3.1, 5)
    roads = traffic(
        (0, 0), (0, 4.4), (5, 0), (-4, 0), (0, -4, math.pi / 2),
        bodies=[DISC, DISC, DISC, DISC, BODIES["box"]],
        index=index_of(HALL - wall),
    )  # fmt: skip
    assert roads.in_sight(0, 0.0, 4.0) == [1, 3, 4]
    assert roads.in_sight(0, 0.0, 3.8) == [3, 4]
    assert roads.in_sight(0, 0.0, 3.45) == [4]
    assert roads.in_sight(0, 0.0, 3.39) == []
    assert roads.in_sight(0, 0.0, 50.0) == [1, 3, 4]
    assert roads.in_sight(2, 0.0, 50.0) == []
    # It drives round the end of the wall.
    roads.begin(2, 0.0, straight(5, 0, 5, 10), None)
    assert roads.in_sight(0, 8.0, 50.0) == [1, 3, 4]
    assert roads.in_sight(0, 8.5, 50.0) == [1, 2, 3, 4]


def test_invalid_motions_are_refused():
    roads = traffic((0, 0), (10, 0))
    with pytest.raises(InvalidInputError, match="robot 0 stands"):
        roads.end(0, 1.0)
    for guard in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="protective stop"):
            roads.begin(0, 0.0, straight(0, 0, 1, 0), guard)
    roads.begin(0, 0.0, straight(0, 0, 1, 0), 1.0)
    with pytest.raises(InvalidInputError, match="moves already"):
        roads.begin(0, 0.5, straight(0, 0, 1, 0), 1.0)


# Against sampling --------------------------------------------------------------------------


def wander(rng, legs, start=None, size=3.0):
    """A trajectory of straight legs, turns in place, arcs and rests."""
    x, y = rng.uniform(-size, size, 2) if start is None else start[:2]
    heading = rng.uniform(-4, 4) if start is None else start[2]
    points = [Waypoint(0.0, float(x), float(y), float(heading))]
    for _ in range(legs):
        time = points[-1].time_s + rng.uniform(0.2, 3.0)
        kind = rng.integers(4)
        if kind < 3:
            x, y = rng.uniform(-size, size, 2)
        if kind == 1:
            heading += rng.uniform(-3, 3)
        if kind == 3:
            heading += rng.uniform(-6, 6)
        points.append(Waypoint(float(time), float(x), float(y), float(heading)))
    return Trajectory(tuple(points))


def sampled_distance(body_a, poses_a, body_b, poses_b):
    def shapes(footprint, poses):
        if footprint.is_disc:
            return shapely.points([pose[:2] for pose in poses]), footprint.radius_m
        return np.array([footprint.placed(pose) for pose in poses]), 0.0

    shapes_a, radius_a = shapes(body_a.footprint, poses_a)
    shapes_b, radius_b = shapes(body_b.footprint, poses_b)
    return np.maximum(0.0, shapely.distance(shapes_a, shapes_b) - radius_a - radius_b)


def stopping_distance(at_first, guard):
    """Distance at which a motion ends: the guard; for a body within it, half of the distance.

    But a quarter of the guard where half would be less; and no less than such a body has left.
    """
    return guard if at_first > guard else max(at_first / 2, min(0.999 * at_first, guard / 4))


@pytest.mark.slow
@settings(max_examples=35)
@given(
    st.integers(0, 10**6),
    st.sampled_from(sorted(BODIES)),
    st.sampled_from(sorted(BODIES)),
    st.sampled_from([None, 0.05, 0.4, 1.0]),
)
def test_encounters_agree_with_sampling(seed, name_a, name_b, guard):
    rng = np.random.default_rng(seed)
    bodies = [BODIES[name_a], BODIES[name_b]]
    way_a, way_b = wander(rng, rng.integers(1, 5)), wander(rng, rng.integers(0, 5))
    begin_b, begin_a = 10.0, 10.0 + rng.uniform(0, 2)
    roads = traffic(way_a.start, way_b.start, bodies=bodies)
    roads.begin(1, begin_b, way_b, None)
    roads.begin(0, begin_a, way_a, guard)
    event = roads.next_event(0, begin_a)

    times = np.linspace(begin_a, begin_a + way_a.duration_s, 1500)
    if event is not None:
        times = np.append(times[times < event.time_s], event.time_s)
    poses_a = [way_a.at(time - begin_a) for time in times]
    poses_b = [way_b.at(time - begin_b) for time in times]
    distance = sampled_distance(bodies[0], poses_a, bodies[1], poses_b)
    threshold = 0.0 if guard is None else stopping_distance(distance[0], guard)
    # An approach by less than half a millimetre may be missed.
    slack = min(5e-4, 0.2 * threshold) if threshold else 5e-4
    if threshold == 0.0:
        for pose_a, pose_b, gap in zip(poses_a[:-1], poses_b[:-1], distance[:-1], strict=True):
            if gap == 0.0:
                core = bodies[0].footprint.placed(pose_a).buffer(-2 * slack)
                assert not core.intersects(bodies[1].footprint.placed(pose_b))
    else:
        assert (distance[:-1] >= threshold - slack).all()
    if event is not None:
        assert event.other == 1
        assert event.kind == ("guard" if threshold > 0.0 else "contact")
        if event.time_s > begin_a or distance[0] > 0.0:
            assert distance[-1] > 0.0
        assert threshold - 1e-9 <= distance[-1] <= threshold + 1e-5


def corridor_world(rng):
    """A hall of 8 m with thin walls that leave gaps."""
    walls = []
    for _ in range(6):
        x, y = rng.uniform(-4, 4, 2)
        w, h = (rng.uniform(0.5, 3), 0.02) if rng.random() < 0.5 else (0.02, rng.uniform(0.5, 3))
        walls.append(shapely.box(x, y, x + w, y + h))
    return HALL - shapely.union_all(walls)


@pytest.mark.slow
@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_hidden_bodies_do_not_stop_a_motion(seed):
    # Small discs on paths through walls, with a guard far larger than the discs.
    rng = np.random.default_rng(seed)
    world = corridor_world(rng)
    solid = HALL - world
    shapely.prepare(solid)
    body = Body(Footprint.disc(0.05))
    way_a, way_b = wander(rng, 3), wander(rng, 3)
    for way in (way_a, way_b):
        if shapely.intersects_xy(solid, way.start.x, way.start.y):
            return
    roads = traffic(way_a.start, way_b.start, bodies=[body, body], index=index_of(world))
    roads.begin(1, 0.0, way_b, None)
    roads.begin(0, 0.0, way_a, 1.0)
    event = roads.next_event(0, 0.0)
    times = np.linspace(0.0, way_a.duration_s, 3000)
    if event is not None:
        times = np.append(times[times < event.time_s], event.time_s)
    a = np.array([way_a.at(time)[:2] for time in times])
    b = np.array([way_b.at(time)[:2] for time in times])
    distance = np.hypot(*(a - b).T) - 0.1
    threshold = stopping_distance(distance[0], 1.0)
    between = shapely.linestrings(np.stack([a, b], axis=1))
    seen = shapely.length(shapely.intersection(between, solid)) < 1e-9
    # Sight for less time than between two checks may be missed.
    bad = (distance <= threshold) & seen
    speed = np.hypot(*np.diff(a, axis=0).T) + np.hypot(*np.diff(b, axis=0).T)
    run = 0.0
    for k in range(len(times) - 1):
        run = run + speed[k] if bad[k] and bad[k + 1] else 0.0
        assert run < 0.025
    if event is not None and event.kind == "guard":
        # To within the rounding of the corners of the world, a nanometre.
        wide = shapely.LineString([a[-1], b[-1]]).intersection(solid)
        # Paths here lead through walls; sight is defined between points of free space only.
        is_in_wall = shapely.intersects_xy(solid, *np.transpose([a[-1], b[-1]])).any()
        assert is_in_wall or wide.length < 1e-3 or seen[max(0, len(seen) - 3) :].any()
        assert 0.0 < distance[-1] <= threshold + 1e-5


class Model:
    """A small simulation: robots drive from place to place and are stopped before others."""

    def __init__(self, seed, count, bodies, guard):
        self.rng = np.random.default_rng(seed)
        self.bodies = [bodies[k % len(bodies)] for k in range(count)]
        side = math.ceil(math.sqrt(count))
        self.starts = [
            Configuration(2.5 * (k % side), 2.5 * (k // side), self.rng.uniform(-3, 3))
            for k in range(count)
        ]
        self.guard = guard
        self.size = 2.5 * side

    def trajectory(self, at):
        goal = self.rng.uniform(0, self.size, 2)
        step = goal - at[:2]
        goal = np.array(at[:2]) + step * min(1.0, 3.0 / np.hypot(*step))
        turn = self.rng.uniform(-1, 1) if self.rng.random() < 0.5 else 0.0
        duration = self.rng.uniform(2, 6)
        return Trajectory(
            (
                Waypoint(0.0, *at),
                Waypoint(duration, float(goal[0]), float(goal[1]), at.heading + turn),
            )
        )


@pytest.mark.slow
@pytest.mark.parametrize("names", [["disc"], ["disc", "box", "ell"]])
def test_many_robots_never_touch_and_only_the_affected_change(names):
    model = Model(3, 25, [BODIES[name] for name in names], 0.3)
    asked = traffic(*model.starts, bodies=model.bodies)
    fresh = traffic(*model.starts, bodies=model.bodies)
    ends: dict[int, float] = {}
    known, queue, stops = {}, [], 0

    def tell(robot, now):
        # The events of affected robots are computed again; those of all others still hold.
        for other in asked.affected(robot):
            known[other] = asked.next_event(other, now)
        for other in ends:
            event, before = fresh.next_event(other, now), known[other]
            assert (event is None) == (before is None)
            if event is not None:
                assert (event.other, event.kind) == (before.other, before.kind)
                assert event.time_s == pytest.approx(before.time_s, abs=1e-5)

    def begin(robot, now):
        motion = model.trajectory(asked.where(robot, now))
        for roads in (asked, fresh):
            roads.begin(robot, now, motion, model.guard)
        known[robot] = asked.next_event(robot, now)
        ends[robot] = now + motion.duration_s
        tell(robot, now)

    for robot in range(25):
        begin(robot, 0.0)
    now = 0.0
    for _ in range(70):
        queue = [
            (min(ends[robot], known[robot].time_s if known[robot] else math.inf), robot)
            for robot in ends
        ]
        heapq.heapify(queue)
        now, robot = max(now, queue[0][0]), queue[0][1]
        event = known.pop(robot)
        if event is not None and event.time_s <= ends[robot]:
            assert event.kind == "guard"
            stops += 1
        for roads in (asked, fresh):
            roads.end(robot, now)
        del ends[robot]
        tell(robot, now)
        poses = [asked.where(k, now) for k in range(25)]
        for k in range(25):
            if k != robot:
                gap = sampled_distance(
                    model.bodies[robot], [poses[robot]], model.bodies[k], [poses[k]]
                )
                assert gap[0] > 0.0
        begin(robot, now)
    assert stops > 10


def test_robots_in_reach_include_those_over_relays():
    # In a row, 3 m apart; the last is moving from the third position to far beyond.
    bodies = [Body(Footprint.disc(0.25))] * 5
    starts = [Configuration(x, 0.0, 0.0) for x in (0.0, 3.0, 6.0, 9.0, 30.0)]
    traffic = Traffic(bodies, starts, EdgeIndex(np.array([[0.0, 5.0, 1.0, 5.0]]), 1.0))
    assert traffic.may_reach(0, 3.5, relayed=False) == [0, 1]
    assert traffic.may_reach(0, 3.5, relayed=True) == [0, 1, 2, 3]
    assert traffic.may_reach(4, 3.5, relayed=True) == [4]
    assert traffic.may_reach(4, math.inf, relayed=False) == [0, 1, 2, 3, 4]
    motion = Trajectory((Waypoint(0.0, 9.0, 0.0, 0.0), Waypoint(40.0, 27.0, 0.0, 0.0)))
    traffic.begin(3, 0.0, motion, None)
    assert traffic.may_reach(0, 3.5, relayed=True) == [0, 1, 2, 3, 4]
