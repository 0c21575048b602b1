import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.bodies.collision import (
    Body,
    CollisionWorld,
    bodies_collide,
    body_distance,
    first_contact_between,
)
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError

FOOTPRINTS = {
    "disc": Footprint.disc(0.25),
    "box": Footprint.box(0.6, 0.4),
    "wedge": Footprint.parse("polygon:-0.2,-0.12 0.25,-0.12 0.32,0 0.25,0.12 -0.2,0.12"),
    "ell": Footprint.parse("polygon:-0.2,-0.2 0.6,-0.2 0.6,0.1 0.1,0.1 0.1,0.5 -0.2,0.5"),
    "bend": Footprint.parse(
        "polygon:-0.3,-0.4 0.5,-0.4 0.5,-0.2 0.1,-0.2 0.1,0.2 0.5,0.2 0.5,0.4 -0.3,0.4"
    ),
}
PAIRS = [("disc", "disc"), ("disc", "bend"), ("box", "disc"), ("box", "wedge"), ("ell", "bend")]
MILLIMETRE = 1e-3


def cluttered(seed=0, count=70, width=12.0):
    """A hall with a room beside it, stones, poles smaller than any body, and thin walls."""
    rng = np.random.default_rng(seed)
    solid = []
    for _ in range(count):
        corners = rng.integers(3, 9)
        angles = (np.arange(corners) + rng.uniform(0.1, 0.9, corners)) * 2 * np.pi / corners
        reach = rng.choice([0.04, 0.15, 0.4]) * rng.uniform(0.3, 1.0, corners)
        at = rng.uniform(0, width, 2)
        solid.append(shapely.Polygon(at + (reach * [np.cos(angles), np.sin(angles)]).T))
    for _ in range(6):
        start, way = rng.uniform(0, width, 2), rng.uniform(-2, 2, 2)
        solid.append(shapely.LineString([start, start + way]).buffer(2e-3, cap_style="flat"))
    halls = shapely.box(0, 0, width, width) | shapely.box(width + 0.2, 2, width + 4, 8)
    return halls - shapely.union_all(solid)


@pytest.fixture(scope="module")
def free():
    return cluttered()


@pytest.fixture(scope="module")
def world(free):
    return CollisionWorld(free)


@pytest.fixture(scope="module")
def obstacles(free):
    """What lies outside of free space as far as any body in these tests gets."""
    outside = shapely.box(-40, -40, 60, 60) - free
    shapely.prepare(outside)
    return outside


@pytest.fixture(scope="module")
def cores(obstacles):
    """The obstacles without what a contact may be missed by: half the resolution."""
    inner = obstacles.buffer(-MILLIMETRE / 2)
    shapely.prepare(inner)
    return inner


def placed(footprint, poses):
    """Bodies at ``(n, 3)`` poses: polygons, or the centres of discs with their radius."""
    poses = np.asarray(poses, dtype=float).reshape(-1, 3)
    if footprint.is_disc:
        return shapely.points(poses[:, :2]), footprint.radius_m
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    px, py = footprint.vertices.T
    x = poses[:, :1] + c * px - s * py
    y = poses[:, 1:2] + s * px + c * py
    return shapely.polygons(np.stack([x, y], axis=-1)), 0.0


def touches(geometry, footprint, poses):
    places, radius = placed(footprint, poses)
    return shapely.dwithin(geometry, places, radius)


def gaps(footprint_a, poses_a, footprint_b, poses_b):
    """Distances of two bodies; for discs negative where they overlap."""
    places_a, radius_a = placed(footprint_a, poses_a)
    places_b, radius_b = placed(footprint_b, poses_b)
    return shapely.distance(places_a, places_b) - radius_a - radius_b


def on_line(start, turn, end, fractions):
    step = np.array([end[0] - start[0], end[1] - start[1], turn])
    return np.array(start) + fractions[:, None] * step


def on_arc(start, turn, end, fractions):
    """Points turn about the fixed point of the motion, in complex numbers."""
    first, last = complex(*start[:2]), complex(*end[:2])
    center = (last - first * np.exp(1j * turn)) / (1 - np.exp(1j * turn))
    points = center + (first - center) * np.exp(1j * turn * fractions)
    return np.column_stack([points.real, points.imag, start[2] + turn * fractions])


def random_poses(rng, count, low=-1.0, high=17.0):
    return np.column_stack([rng.uniform(low, high, (count, 2)), rng.uniform(-4, 4, count)])


def test_clearance_in_an_empty_room():
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    disc, box = Body(Footprint.disc(0.5)), Body(Footprint.box(2.0, 1.0))
    assert world.clearance(disc, (2.0, 4.0, 1.0)) == pytest.approx(1.5, abs=1e-12)
    assert world.clearance(box, (2.0, 4.0, 0.0)) == pytest.approx(1.0, abs=1e-12)
    assert world.clearance(box, (2.0, 4.0, math.pi / 2)) == pytest.approx(1.5, abs=1e-12)
    assert world.clearance(box, (1.0, 4.0, 0.0)) == pytest.approx(0.0, abs=1e-12)
    assert world.clearance(box, (0.5, 4.0, 0.0)) == 0.0
    assert not world.pose_is_free(disc, (0.5, 4.0, 0.0))
    assert world.pose_is_free(disc, (0.5 + 1e-9, 4.0, 0.0))
    assert not world.pose_is_free(disc, (0.5 - 1e-9, 4.0, 0.0))


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_a_body_outside_the_world_is_not_free(name):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body = world.body(FOOTPRINTS[name])
    for x in (-0.1, -0.9, -1.0, -1.1, -5.0, 11.5, 1e6, -1e12):
        assert not world.pose_is_free(body, (x, 4.0, 0.3))
        assert not world.pose_is_free(body, (4.0, x, 0.3))
        assert world.clearance(body, (x, 4.0, 0.3)) == 0.0
        assert not world.straight_motion_is_free(body, (5.0, 4.0, 0.0), (x, 4.0, 0.0))
        assert not world.straight_motion_is_free(body, (x, 4.0, 0.0), (5.0, 4.0, 0.0))
        assert not world.rotation_is_free(body, (x, 4.0, 0.0), 1.0)
        assert world.first_contact(body, (x, 4.0, 0.0), (5.0, 4.0, 0.0)) == 0.0


@pytest.mark.parametrize("name", FOOTPRINTS)
@pytest.mark.parametrize("scale", [1.0, 8.0])
def test_a_body_around_or_inside_an_obstacle_is_not_free(name, scale):
    footprint = FOOTPRINTS[name]
    if scale != 1.0:
        if footprint.is_disc:
            footprint = Footprint.disc(scale * footprint.radius_m)
        else:
            footprint = Footprint.polygon(scale * footprint.vertices)
    pole, block = shapely.box(9.99, 9.99, 10.01, 10.01), shapely.box(20, 0, 40, 20)
    world = CollisionWorld(shapely.box(0, 0, 60, 20) - pole - block)
    body = Body(footprint)
    inside = 0.5 * footprint.inscribed_radius_m
    for heading in np.linspace(-3, 3, 13):
        assert not world.pose_is_free(body, (10.0 + inside, 10.0, heading))
        assert not world.pose_is_free(body, (30.0, 10.0, heading))
        assert world.clearance(body, (10.0, 10.0 - inside, heading)) == 0.0
        assert world.clearance(body, (30.0, 10.0, heading)) == 0.0
    # A motion from free to free around which nothing sticks out but what is inside.
    assert not world.straight_motion_is_free(body, (6.0, 10.0, 0.0), (14.0, 10.0, 0.0))
    assert not world.straight_motion_is_free(body, (14.0, 10.0, 0.0), (50.0, 10.0, 0.0))
    assert world.first_contact(body, (30.0, 10.0, 0.0), (31.0, 10.0, 0.0)) == 0.0


def test_a_body_larger_than_the_world_is_not_free():
    world = CollisionWorld(shapely.box(0, 0, 1, 1))
    for footprint in (Footprint.disc(30.0), Footprint.box(50.0, 40.0)):
        assert not world.pose_is_free(Body(footprint), (0.5, 0.5, 0.0))
        assert world.clearance(Body(footprint), (0.5, 0.5, 0.0)) == 0.0


def test_a_slit_of_a_millimetre_divides_two_rooms():
    world = CollisionWorld(shapely.box(0, 0, 10, 8) - shapely.box(4.9995, 0, 5.0005, 8))
    for footprint in FOOTPRINTS.values():
        body = Body(footprint)
        assert not world.pose_is_free(body, (5.0, 4.0, 0.0))
        assert not world.straight_motion_is_free(body, (1.0, 4.0, 0.0), (9.0, 4.0, 0.0))
        contact = world.first_contact(body, (1.0, 4.0, 0.0), (9.0, 4.0, 6.0), 6.0)
        assert contact is not None
        assert contact < 0.5


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_poses_agree_with_shapely(name, world, free, obstacles):
    footprint, rng = FOOTPRINTS[name], np.random.default_rng(1)
    body = world.body(footprint)
    poses = random_poses(rng, 3000)
    expected = ~touches(obstacles, footprint, poses)
    assert [world.pose_is_free(body, pose) for pose in poses] == expected.tolist()
    assert 300 < expected.sum() < 2700


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_clearance_agrees_with_shapely(name, world, obstacles):
    footprint, rng = FOOTPRINTS[name], np.random.default_rng(2)
    body = world.body(footprint)
    poses = random_poses(rng, 700)
    places, radius = placed(footprint, poses)
    expected = np.maximum(shapely.distance(places, obstacles) - radius, 0.0)
    found = [world.clearance(body, pose) for pose in poses]
    assert found == pytest.approx(expected, abs=1e-12)


def test_answers_far_from_the_origin_are_as_good():
    shift = np.array([4e5, -3e5, 0.0])
    rng = np.random.default_rng(3)
    near_space = cluttered(5, 30)
    world = CollisionWorld(near_space)
    moved = CollisionWorld(shapely.transform(near_space, lambda points: points + shift[:2]))
    for name in ("disc", "ell"):
        body = Body(FOOTPRINTS[name])
        for pose in random_poses(rng, 300):
            clearance = world.clearance(body, pose)
            assert moved.clearance(body, pose + shift) == pytest.approx(clearance, abs=1e-8)


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_straight_motions_agree_with_shapely(name, world, obstacles):
    footprint, rng = FOOTPRINTS[name], np.random.default_rng(4)
    body = world.body(footprint)
    free_count = 0
    for start in random_poses(rng, 1500, 0.0, 12.0):
        end = start + np.array([*rng.normal(0, 0.8, 2), 0.0])
        if footprint.is_disc:
            way = shapely.LineString([start[:2], end[:2]])
            expected = obstacles.distance(way) > footprint.radius_m
            end[2] += rng.uniform(-1, 1)
        else:
            expected = not shapely.intersects(obstacles, footprint.swept(start, end))
        assert world.straight_motion_is_free(body, start, end) == expected
        free_count += expected
    assert 100 < free_count < 1400


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_long_motions_do_not_tunnel(name):
    thin = shapely.box(50.0, 0, 50.0015, 9.7)
    world = CollisionWorld(shapely.box(0, 0, 100, 10) - thin)
    body = Body(FOOTPRINTS[name])
    start, end = (1.0, 5.0, 0.0), (99.0, 5.0, 0.0)
    assert not world.straight_motion_is_free(body, start, end)
    contact = world.first_contact(body, start, end)
    front = FOOTPRINTS[name].radius_m if name == "disc" else FOOTPRINTS[name].vertices[:, 0].max()
    assert contact == pytest.approx((49.0 - front) / 98.0, abs=1e-7)
    turning = world.first_contact(body, start, (99.0, 5.0, 20.0), 20.0)
    assert turning is not None
    assert turning <= 0.5


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_rotations_agree_with_sampling(name, world, cores, obstacles):
    footprint, rng = FOOTPRINTS[name], np.random.default_rng(5)
    body = world.body(footprint)
    fractions = np.linspace(0, 1, 2001)
    answers = []
    for pose in random_poses(rng, 300, 0.0, 12.0):
        if obstacles.distance(shapely.Point(pose[:2])) > footprint.circumscribed_radius_m + 0.05:
            continue  # nothing within reach
        if touches(obstacles, footprint, pose).all():
            assert not world.rotation_is_free(body, pose, 0.0)
            continue
        turn = rng.uniform(-2 * math.pi, 2 * math.pi)
        free = world.rotation_is_free(body, pose, turn)
        answers.append(free)
        poses = on_line(pose, turn, pose, fractions)
        # Free: nothing is deeper than half the resolution. Not free: there is a contact, and so a
        # sample less than a millimetre away from one.
        if free:
            assert not touches(cores, footprint, poses).any()
        else:
            places, radius = placed(footprint, poses)
            assert shapely.dwithin(obstacles, places, radius + MILLIMETRE).any()
    assert sum(answers) > 10
    assert footprint.is_disc or answers.count(False) > 5


@pytest.mark.parametrize("arc", [False, True])
@pytest.mark.parametrize("name", FOOTPRINTS)
def test_first_contacts_agree_with_sampling(name, arc, world, cores, obstacles):
    footprint, rng = FOOTPRINTS[name], np.random.default_rng(6 + arc)
    body = world.body(footprint)
    path = on_arc if arc else on_line
    fractions = np.linspace(0, 1, 2001)
    found = []
    while len(found) < 50:
        start = random_poses(rng, 1, 0.5, 11.5)[0]
        turn = rng.uniform(-5, 5)
        end = start + np.array([*rng.normal(0, 0.7, 2), turn])
        contact = world.first_contact(body, start, end, turn, arc=arc)
        if touches(obstacles, footprint, start).all():
            assert contact == 0.0
            continue
        found.append(contact)
        sampled = path(start, turn, end, fractions)
        before = fractions < (2.0 if contact is None else contact)
        assert not touches(cores, footprint, sampled[before]).any()
        if contact is not None:
            there = path(start, turn, end, np.array([contact]))
            places, radius = placed(footprint, there)
            assert shapely.distance(places, obstacles)[0] - radius == pytest.approx(0, abs=2e-6)
            assert not touches(obstacles, footprint, there).any()
    assert 8 < found.count(None) < 42


def test_a_quarter_circle_is_followed():
    # About (0, 3): to the left from (0, 0) heading along x, to the right heading against x. A
    # disc of 0.5 passes a pole at 2.4 from the centre, half-way round, and meets one at 2.6.
    body = Body(Footprint.disc(0.5))
    for reach, is_free in ((2.4, True), (2.6, False)):
        at = reach * math.sqrt(0.5)
        for side in (1, -1):
            pole = shapely.Point(side * at, 3 - at).buffer(1e-3)
            world = CollisionWorld(shapely.box(-5, -5, 10, 10) - pole)
            start = (0, 0, 0.0 if side == 1 else math.pi)
            end, other = ((3, 3, math.pi / 2), (-3, 3, math.pi / 2))[::side]
            assert (world.first_contact(body, start, end, arc=True) is None) == is_free
            back = (0, 0, math.pi - start[2])
            assert world.first_contact(body, back, other, arc=True) is None


def test_an_arc_may_go_the_long_way_round():
    # About (0, 3) from (0, 0) to (-3, 3): by (0, 6), where something stands, at two thirds.
    world = CollisionWorld(shapely.box(-5, -5, 10, 10) - shapely.box(-0.1, 5.9, 0.1, 6.1))
    body, end = Body(Footprint.disc(0.5)), (-3, 3, -math.pi / 2)
    contact = world.first_contact(body, (0, 0, 0), end, 1.5 * math.pi, arc=True)
    assert contact == pytest.approx(2 / 3 - 0.6 / (4.5 * math.pi), abs=2e-3)
    assert world.first_contact(body, (0, 0, 0), end) is None


def test_sliding_along_a_wall_ends_only_where_the_wall_does():
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    for name in ("disc", "box"):
        body, half = Body(FOOTPRINTS[name]), 0.25 if name == "disc" else 0.2
        start, end = (1.0, half + 1e-7, 0.0), (9.0, half + 1e-7, 0.0)
        assert world.straight_motion_is_free(body, start, end)
        assert world.first_contact(body, start, end) is None
        # A motion that dips in by a tenth of a millimetre is found where it is sampled or later,
        # one by more than the resolution always.
        deep = world.first_contact(body, start, (9.0, half - 0.01, 0.0))
        assert deep is not None


def test_a_motion_that_starts_on_the_wall_may_leave_it():
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body = Body(FOOTPRINTS["box"])
    start = (1.0, 0.2 + 1e-9, 0.0)
    assert world.first_contact(body, start, (1.0, 0.21, 1.0)) is not None  # a corner dips
    assert world.first_contact(body, start, (1.0, 6.0, 0.3), 0.3) is None
    assert world.first_contact(body, start, (1.0, 0.1, 0.0)) < 1e-4


@pytest.mark.parametrize("pair", PAIRS)
def test_two_bodies_agree_with_shapely(pair):
    footprint_a, footprint_b = (FOOTPRINTS[name] for name in pair)
    body_a, body_b = Body(footprint_a), Body(footprint_b)
    rng = np.random.default_rng(7)
    poses_a, poses_b = random_poses(rng, 1500, 3.0, 4.2), random_poses(rng, 1500, 3.0, 4.2)
    expected = gaps(footprint_a, poses_a, footprint_b, poses_b)
    for pose_a, pose_b, gap in zip(poses_a, poses_b, expected, strict=True):
        assert bodies_collide(body_a, pose_a, body_b, pose_b) == (gap <= 0)
        assert bodies_collide(body_b, pose_b, body_a, pose_a) == (gap <= 0)
        distance = body_distance(body_a, pose_a, body_b, pose_b)
        assert distance == pytest.approx(max(gap, 0.0), abs=1e-9)
    assert 200 < (expected <= 0).sum() < 1300


def test_one_body_inside_the_other_collides():
    large, small = Footprint.box(4.0, 4.0), Footprint.box(0.1, 0.1)
    for big in (large, Footprint.disc(2.0)):
        for tiny in (small, Footprint.disc(0.05)):
            pose = (10.3, 9.8, 0.4)
            assert bodies_collide(Body(big), (10, 10, 0), Body(tiny), pose)
            assert bodies_collide(Body(tiny), pose, Body(big), (10, 10, 0))
            assert body_distance(Body(tiny), pose, Body(big), (10, 10, 0)) == 0.0


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-4, 4), st.floats(-5, 5), st.floats(-4, 4))
def test_distance_between_bodies_is_symmetric_and_moves_along(x, y, heading, shift, turn):
    body = Body(FOOTPRINTS["ell"])  # one object, in two places
    distance = body_distance(body, (0, 0, 0), body, (x, y, heading))
    assert body_distance(body, (x, y, heading), body, (0, 0, 0)) == pytest.approx(distance)
    c, s = math.cos(turn), math.sin(turn)
    moved = (shift + c * x - s * y, s * x + c * y, heading + turn)
    assert body_distance(body, (shift, 0, turn), body, moved) == pytest.approx(distance, abs=1e-9)


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("arcs", [(False, False), (True, False)])
def test_meetings_agree_with_sampling(pair, arcs):
    footprint_a, footprint_b = (FOOTPRINTS[name] for name in pair)
    body_a, body_b = Body(footprint_a), Body(footprint_b)
    rng = np.random.default_rng(8)
    fractions = np.linspace(0, 1, 2001)
    found = []
    while len(found) < 30:
        start_a, start_b = random_poses(rng, 2, 0, 2)
        turn_a, turn_b = rng.uniform(-4, 4, 2)
        end_a = np.array([*rng.uniform(0, 2, 2), start_a[2] + turn_a])
        end_b = np.array([*rng.uniform(0, 2, 2), start_b[2] + turn_b])
        contact = first_contact_between(
            body_a,
            start_a,
            end_a,
            body_b,
            start_b,
            end_b,
            turn_a=turn_a,
            turn_b=turn_b,
            arc_a=arcs[0],
            arc_b=arcs[1],
        )
        path_a, path_b = (on_arc if arc else on_line for arc in arcs)
        poses_a = path_a(start_a, turn_a, end_a, fractions)
        poses_b = path_b(start_b, turn_b, end_b, fractions)
        apart = gaps(footprint_a, poses_a, footprint_b, poses_b)
        if apart[0] <= 0:
            assert contact == 0.0
            continue
        found.append(contact)
        if contact is None:
            # Less than half a millimetre of overlap may be missed.
            for i in np.flatnonzero(apart <= 0):
                core = footprint_a.placed(poses_a[i]).buffer(-MILLIMETRE)
                assert not core.intersects(footprint_b.placed(poses_b[i]))
        else:
            at = np.array([contact])
            there_a = path_a(start_a, turn_a, end_a, at)
            there_b = path_b(start_b, turn_b, end_b, at)
            assert gaps(footprint_a, there_a, footprint_b, there_b)[0] == pytest.approx(0, abs=2e-6)
            assert (apart[fractions < contact - 1e-2] > 0).all()
    assert 3 < found.count(None) < 27


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("arcs", [(False, False), (True, True)])
def test_coming_within_a_gap_agrees_with_sampling(pair, arcs):
    footprint_a, footprint_b = (FOOTPRINTS[name] for name in pair)
    body_a, body_b = Body(footprint_a), Body(footprint_b)
    rng = np.random.default_rng(9)
    fractions = np.linspace(0, 1, 2001)
    found = []
    while len(found) < 25:
        gap = rng.choice([0.01, 0.3, 1.0])
        start_a, start_b = random_poses(rng, 2, 0, 4)
        turn_a, turn_b = rng.uniform(-4, 4, 2)
        end_a = np.array([*rng.uniform(0, 4, 2), start_a[2] + turn_a])
        end_b = np.array([*rng.uniform(0, 4, 2), start_b[2] + turn_b])
        turns = {"turn_a": turn_a, "turn_b": turn_b, "arc_a": arcs[0], "arc_b": arcs[1]}
        near = first_contact_between(
            body_a, start_a, end_a, body_b, start_b, end_b, gap_m=gap, **turns
        )
        path_a, path_b = (on_arc if arc else on_line for arc in arcs)

        def apart(at, path_a=path_a, path_b=path_b, a=(start_a, turn_a, end_a),
                  b=(start_b, turn_b, end_b)):  # fmt: skip
            return gaps(footprint_a, path_a(*a, at), footprint_b, path_b(*b, at))

        if apart(np.array([0.0]))[0] <= gap:
            assert near == 0.0
            continue
        found.append(near)
        before = fractions[fractions < (2.0 if near is None else near)]
        assert (apart(before) > gap - MILLIMETRE / 2).all()
        if near is not None:
            assert gap < apart(np.array([near]))[0] < gap + 2e-6
    assert 3 < found.count(None) < 22


@given(
    st.tuples(*[st.floats(-5, 5)] * 8),
    st.floats(0.05, 1.0),
    st.floats(0.05, 1.0),
    st.sampled_from([0.0, 0.2, 2.0]),
)
def test_discs_on_lines_meet_as_bodies_that_are_followed(numbers, radius_a, radius_b, gap):
    # A disc on a line has a closed form; on an arc, as straight as this one, it is followed.
    ax, ay, bx, by, to_ax, to_ay, to_bx, to_by = numbers
    body_a, body_b = Body(Footprint.disc(radius_a)), Body(Footprint.disc(radius_b))
    ends = (body_a, (ax, ay, 0), (to_ax, to_ay, 0), body_b, (bx, by, 0), (to_bx, to_by, 0))
    exact = first_contact_between(*ends, gap_m=gap)
    bent = (body_a, (ax, ay, 0), (to_ax, to_ay, 1e-6), *ends[3:])
    followed = first_contact_between(*bent, turn_a=1e-6, arc_a=True, gap_m=gap, resolution_m=1e-5)
    reach = radius_a + radius_b + gap
    if exact is None:
        assert followed is None or followed > 1 - 1e-5 or _least(numbers) > reach - 1e-6
    else:
        at = np.array(numbers[:4]) + exact * (np.array(numbers[4:]) - np.array(numbers[:4]))
        distance = math.hypot(at[2] - at[0], at[3] - at[1])
        assert exact == 0.0 or reach < distance < reach + 2e-6
        grazes = _least(numbers) > reach - 1e-5
        assert grazes or followed == pytest.approx(exact, abs=1e-3)


def _least(numbers):
    way = shapely.LineString(
        [(numbers[2] - numbers[0], numbers[3] - numbers[1]),
         (numbers[6] - numbers[4], numbers[7] - numbers[5])]
    )  # fmt: skip
    return way.distance(shapely.Point(0, 0))


def test_discs_that_all_but_miss_each_other_are_apart_where_they_meet():
    disc = Body(Footprint.disc(0.5))
    for offset in (1.0, 1.0 - 1e-15, 1.0 - 1e-12, 1.0 - 1e-9):
        ends = (disc, (0, 0, 0), (10, 0, 0), disc, (5, offset, 0), (5, offset, 0))
        meeting = first_contact_between(*ends)
        assert meeting is not None
        assert meeting == pytest.approx(0.5, abs=1e-4)
        assert math.hypot(5 - 10 * meeting, offset) > 1.0
    ends = (disc, (0, 0, 0), (10, 0, 0), disc, (5, 1 + 1e-9, 0), (5, 1 + 1e-9, 0))
    assert first_contact_between(*ends) is None
    assert first_contact_between(*ends, gap_m=1e-8) is not None
    assert first_contact_between(*ends, gap_m=5.0) == 0.0


def test_a_gap_is_a_finite_length():
    disc, at = Body(Footprint.disc(0.5)), (0, 0, 0)
    for gap in (-0.1, math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="a gap of"):
            first_contact_between(disc, at, at, disc, (5, 0, 0), at, gap_m=gap)


def test_bodies_that_keep_pace_never_meet():
    body = Body(Footprint.box(1.0, 1.0))
    side_by_side = first_contact_between(
        body, (0, 0, 0), (50, 0, 0), body, (0, 1.001, 0), (50, 1.001, 0)
    )
    assert side_by_side is None
    head_on = first_contact_between(body, (0, 0, 0), (10, 0, 0), body, (10, 0, 0), (0, 0, 0))
    assert head_on == pytest.approx(0.45, abs=1e-6)
    # They swap places on crossing ways: neither end touches, the middle does.
    crossing = first_contact_between(body, (0, 0, 0), (9, 9, 0), body, (0, 9, 0), (9, 0, 0))
    assert crossing == pytest.approx(4.0 / 9.0, abs=1e-6)
    waiting = first_contact_between(body, (0, 0, 0), (0, 0, 0), body, (3, 0, 0), (3, 0, 0))
    assert waiting is None


def test_touching_is_a_collision():
    disc = Body(Footprint.disc(0.5))
    assert bodies_collide(disc, (0, 0, 0), disc, (1, 0, 0))
    assert not bodies_collide(disc, (0, 0, 0), disc, (1 + 1e-9, 0, 0))


@pytest.mark.parametrize(
    "bad", [(math.nan, 0, 0), (0, math.inf, 0), (0, 0, math.nan), (1, 2), None]
)
def test_configurations_that_are_not_numbers_never_reach_fcl(bad):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body, good = Body(FOOTPRINTS["ell"]), (1.0, 1.0, 0.0)
    queries = [
        lambda: world.pose_is_free(body, bad),
        lambda: world.clearance(body, bad),
        lambda: world.straight_motion_is_free(body, bad, good),
        lambda: world.straight_motion_is_free(body, good, bad),
        lambda: world.rotation_is_free(body, bad, 1.0),
        lambda: world.first_contact(body, good, bad),
        lambda: bodies_collide(body, good, body, bad),
        lambda: body_distance(body, bad, body, good),
        lambda: first_contact_between(body, good, good, body, bad, good),
    ]
    for query in queries:
        with pytest.raises(InvalidInputError, match="configuration"):
            query()


def test_motions_that_make_no_sense_are_refused():
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body, here, there = Body(FOOTPRINTS["box"]), (1.0, 1.0, 0.0), (2.0, 2.0, 1.0)
    with pytest.raises(InvalidInputError, match="the heading of a straight motion is constant"):
        world.straight_motion_is_free(body, here, there)
    with pytest.raises(InvalidInputError, match="does not lead from heading 0 to 1"):
        world.first_contact(body, here, there, 2.0)
    with pytest.raises(InvalidInputError, match="not finite"):
        world.first_contact(body, here, there, math.inf)
    with pytest.raises(InvalidInputError, match="no arc leads"):
        world.first_contact(body, here, (3.0, 3.0, 0.0), 2 * math.pi, arc=True)
    for resolution in (0.0, -1.0, math.nan):
        with pytest.raises(InvalidInputError, match="resolution"):
            world.first_contact(body, here, there, resolution_m=resolution)


@pytest.mark.parametrize("turn", [0.5e-9, 1e-9, 1.5e-9, 2.5e-9, 9e-9, 1.1e-8, 1e-7])
def test_an_arc_that_hardly_turns_is_as_good_as_straight(turn):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body = Body(FOOTPRINTS["box"])
    for sign in (1.0, -1.0):
        start, end = (2.0, 4.0, 0.0), (12.0, 4.0, sign * turn)
        contact = world.first_contact(body, start, end, sign * turn, arc=True)
        straight = world.first_contact(body, start, (12.0, 4.0, 0.0), 0.0)
        assert contact == pytest.approx(straight, abs=1e-6)


@pytest.mark.parametrize(
    ("free", "says"),
    [
        (shapely.Polygon(), "empty"),
        (shapely.MultiPolygon(), "empty"),
        (shapely.LineString([(0, 0), (1, 1)]), "not LineString"),
        ("room", "not str"),
        (shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), "not valid: Self-intersection"),
        (shapely.box(0, 0, math.inf, 1), "not finite"),
    ],
)
def test_worlds_that_are_no_area_are_refused(free, says):
    with pytest.raises(InvalidInputError, match=says):
        CollisionWorld(free)


def test_obstacles_may_touch_each_other_and_the_outline():
    blocks = shapely.union_all(
        [shapely.box(0, 3, 2, 4), shapely.box(2, 4, 3, 5), shapely.box(5, 0, 6, 1)]
    )
    space = shapely.box(0, 0, 10, 8) - blocks
    world = CollisionWorld(space)
    body = Body(Footprint.disc(0.25))
    outside = shapely.box(-5, -5, 15, 13) - space
    rng = np.random.default_rng(9)
    for pose in random_poses(rng, 500, 0.0, 8.0):
        expected = outside.distance(shapely.Point(pose[:2])) - 0.25
        assert world.clearance(body, pose) == pytest.approx(max(expected, 0.0), abs=1e-12)
    assert not world.straight_motion_is_free(body, (1.5, 5.0, 0.0), (2.5, 3.0, 0.0))


def test_a_body_is_made_once_for_a_footprint():
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body = world.body(Footprint.box(0.6, 0.4))
    assert world.body(Footprint.parse("box:0.6x0.4")) is body
    assert body.footprint == Footprint.box(0.6, 0.4)
    assert world.body(Footprint.disc(0.2)).turning_radius_m == 0.0
