"""Collision of a body with a world, against shapely, sampling and answers by hand."""

import math

import numpy as np
import pytest
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.collision import Body, CollisionWorld
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError

FOOTPRINTS = ["disc", "box", "wedge", "ell", "bend"]
MILLIMETRE = 1e-3


def cluttered(seed=0, count=70, width=12.0):
    """Return a hall with a room beside it, stones, poles smaller than any body and thin walls."""
    rng = np.random.default_rng(seed)
    solid = []
    for _ in range(count):
        corners = rng.integers(3, 9)
        angles = (np.arange(corners) + rng.uniform(0.1, 0.9, corners)) * 2 * np.pi / corners
        reach = rng.choice([0.04, 0.15, 0.4]) * rng.uniform(0.3, 1.0, corners)
        at = rng.uniform(0, width, 2)
        solid.append(shapely.Polygon(at + (reach * [np.cos(angles), np.sin(angles)]).T))
    for _ in range(6):
        start, step = rng.uniform(0, width, 2), rng.uniform(-2, 2, 2)
        solid.append(shapely.LineString([start, start + step]).buffer(2e-3, cap_style="flat"))
    halls = shapely.box(0, 0, width, width) | shapely.box(width + 0.2, 2, width + 4, 8)
    return halls - shapely.union_all(solid)


def world_without(room: shapely.Polygon, *obstacles: BaseGeometry) -> CollisionWorld:
    """Return a world whose free space is a room without obstacles in it."""
    free = room.difference(shapely.union_all(obstacles))
    assert isinstance(free, shapely.Polygon | shapely.MultiPolygon)
    return CollisionWorld(free)


@pytest.fixture(scope="module")
def free():
    return cluttered()


@pytest.fixture(scope="module")
def world(free):
    return CollisionWorld(free)


@pytest.fixture(scope="module")
def obstacles(free):
    """Everything outside of free space within reach of any body in these tests."""
    outside = shapely.box(-40, -40, 60, 60) - free
    shapely.prepare(outside)
    return outside


@pytest.fixture(scope="module")
def cores(obstacles):
    """The obstacles, shrunk by the depth of contact that may be missed: half the resolution."""
    inner = obstacles.buffer(-MILLIMETRE / 2)
    shapely.prepare(inner)
    return inner


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
def test_a_body_outside_the_world_is_not_free(name, moving):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body = world.body(moving.footprints[name])
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
def test_a_body_around_or_inside_an_obstacle_is_not_free(name, scale, moving):
    footprint = moving.footprints[name]
    if scale != 1.0:
        if footprint.is_disc:
            footprint = Footprint.disc(scale * footprint.radius_m)
        else:
            footprint = Footprint.polygon(scale * footprint.vertices)
    pole, block = shapely.box(9.99, 9.99, 10.01, 10.01), shapely.box(20, 0, 40, 20)
    world = world_without(shapely.box(0, 0, 60, 20), pole, block)
    body = Body(footprint)
    inside = 0.5 * footprint.inscribed_radius_m
    for heading in np.linspace(-3, 3, 13):
        assert not world.pose_is_free(body, (10.0 + inside, 10.0, heading))
        assert not world.pose_is_free(body, (30.0, 10.0, heading))
        assert world.clearance(body, (10.0, 10.0 - inside, heading)) == 0.0
        assert world.clearance(body, (30.0, 10.0, heading)) == 0.0
    # A motion between free poses, with an obstacle wholly inside of the swept area.
    assert not world.straight_motion_is_free(body, (6.0, 10.0, 0.0), (14.0, 10.0, 0.0))
    assert not world.straight_motion_is_free(body, (14.0, 10.0, 0.0), (50.0, 10.0, 0.0))
    assert world.first_contact(body, (30.0, 10.0, 0.0), (31.0, 10.0, 0.0)) == 0.0


def test_a_body_larger_than_the_world_is_not_free():
    world = CollisionWorld(shapely.box(0, 0, 1, 1))
    for footprint in (Footprint.disc(30.0), Footprint.box(50.0, 40.0)):
        assert not world.pose_is_free(Body(footprint), (0.5, 0.5, 0.0))
        assert world.clearance(Body(footprint), (0.5, 0.5, 0.0)) == 0.0


def test_a_slit_of_a_millimetre_divides_two_rooms(moving):
    world = world_without(shapely.box(0, 0, 10, 8), shapely.box(4.9995, 0, 5.0005, 8))
    for footprint in moving.footprints.values():
        body = Body(footprint)
        assert not world.pose_is_free(body, (5.0, 4.0, 0.0))
        assert not world.straight_motion_is_free(body, (1.0, 4.0, 0.0), (9.0, 4.0, 0.0))
        contact = world.first_contact(body, (1.0, 4.0, 0.0), (9.0, 4.0, 6.0), 6.0)
        assert contact is not None
        assert contact < 0.5


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_poses_agree_with_shapely(name, world, free, obstacles, moving):
    footprint, rng = moving.footprints[name], np.random.default_rng(1)
    body = world.body(footprint)
    poses = moving.random_poses(rng, 3000)
    expected = ~moving.touches(obstacles, footprint, poses)
    assert [world.pose_is_free(body, pose) for pose in poses] == expected.tolist()
    assert 300 < expected.sum() < 2700


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_clearance_agrees_with_shapely(name, world, obstacles, moving):
    footprint, rng = moving.footprints[name], np.random.default_rng(2)
    body = world.body(footprint)
    poses = moving.random_poses(rng, 700)
    places, radius = moving.placed(footprint, poses)
    expected = np.maximum(shapely.distance(places, obstacles) - radius, 0.0)
    found = [world.clearance(body, pose) for pose in poses]
    assert found == pytest.approx(expected, abs=1e-12)


def test_clearance_far_from_the_origin_is_as_exact(moving):
    shift = np.array([4e5, -3e5, 0.0])
    rng = np.random.default_rng(3)
    near_space = cluttered(5, 30)
    world = CollisionWorld(near_space)
    moved = CollisionWorld(shapely.transform(near_space, lambda points: points + shift[:2]))
    for name in ("disc", "ell"):
        body = Body(moving.footprints[name])
        for pose in moving.random_poses(rng, 300):
            clearance = world.clearance(body, pose)
            assert moved.clearance(body, pose + shift) == pytest.approx(clearance, abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("name", FOOTPRINTS)
def test_straight_motions_agree_with_shapely(name, world, obstacles, moving):
    footprint, rng = moving.footprints[name], np.random.default_rng(4)
    body = world.body(footprint)
    free_count = 0
    for start in moving.random_poses(rng, 1500, 0.0, 12.0):
        end = start + np.array([*rng.normal(0, 0.8, 2), 0.0])
        if footprint.is_disc:
            step = shapely.LineString([start[:2], end[:2]])
            expected = obstacles.distance(step) > footprint.radius_m
            end[2] += rng.uniform(-1, 1)
        else:
            expected = not shapely.intersects(obstacles, footprint.swept(start, end))
        assert world.straight_motion_is_free(body, start, end) == expected
        free_count += expected
    assert 100 < free_count < 1400


@pytest.mark.parametrize("name", FOOTPRINTS)
def test_long_motions_do_not_tunnel(name, moving):
    thin = shapely.box(50.0, 0, 50.0015, 9.7)
    world = world_without(shapely.box(0, 0, 100, 10), thin)
    body = Body(moving.footprints[name])
    start, end = (1.0, 5.0, 0.0), (99.0, 5.0, 0.0)
    assert not world.straight_motion_is_free(body, start, end)
    contact = world.first_contact(body, start, end)
    front = (
        moving.footprints[name].radius_m
        if name == "disc"
        else moving.footprints[name].vertices[:, 0].max()
    )
    assert contact == pytest.approx((49.0 - front) / 98.0, abs=1e-7)
    turning = world.first_contact(body, start, (99.0, 5.0, 20.0), 20.0)
    assert turning is not None
    assert turning <= 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", FOOTPRINTS)
def test_rotations_agree_with_sampling(name, world, cores, obstacles, moving):
    footprint, rng = moving.footprints[name], np.random.default_rng(5)
    body = world.body(footprint)
    fractions = np.linspace(0, 1, 2001)
    answers = []
    for pose in moving.random_poses(rng, 300, 0.0, 12.0):
        if obstacles.distance(shapely.Point(pose[:2])) > footprint.circumscribed_radius_m + 0.05:
            continue  # nothing within reach
        if moving.touches(obstacles, footprint, pose).all():
            assert not world.rotation_is_free(body, pose, 0.0)
            continue
        turn = rng.uniform(-2 * math.pi, 2 * math.pi)
        free = world.rotation_is_free(body, pose, turn)
        answers.append(free)
        poses = moving.on_line(pose, turn, pose, fractions)
        # If free, no overlap is deeper than half the resolution. If not, there is a contact, and
        # so a sample less than a millimetre away from one.
        if free:
            assert not moving.touches(cores, footprint, poses).any()
        else:
            places, radius = moving.placed(footprint, poses)
            assert shapely.dwithin(obstacles, places, radius + MILLIMETRE).any()
    assert sum(answers) > 10
    assert footprint.is_disc or answers.count(False) > 5


@pytest.mark.slow
@pytest.mark.parametrize("arc", [False, True])
@pytest.mark.parametrize("name", FOOTPRINTS)
def test_first_contacts_agree_with_sampling(name, arc, world, cores, obstacles, moving):
    footprint, rng = moving.footprints[name], np.random.default_rng(6 + arc)
    body = world.body(footprint)
    path = moving.on_arc if arc else moving.on_line
    fractions = np.linspace(0, 1, 2001)
    found: list[float | None] = []
    while len(found) < 50:
        start = moving.random_poses(rng, 1, 0.5, 11.5)[0]
        turn = rng.uniform(-5, 5)
        end = start + np.array([*rng.normal(0, 0.7, 2), turn])
        contact = world.first_contact(body, start, end, turn, arc=arc)
        if moving.touches(obstacles, footprint, start).all():
            assert contact == 0.0
            continue
        found.append(contact)
        sampled = path(start, turn, end, fractions)
        before = fractions < (2.0 if contact is None else contact)
        assert not moving.touches(cores, footprint, sampled[before]).any()
        if contact is not None:
            there = path(start, turn, end, np.array([contact]))
            places, radius = moving.placed(footprint, there)
            assert shapely.distance(places, obstacles)[0] - radius == pytest.approx(0, abs=2e-6)
            assert not moving.touches(obstacles, footprint, there).any()
    assert 8 < found.count(None) < 42


def test_a_quarter_circle_is_followed():
    # About (0, 3): to the left from (0, 0) heading along x, to the right heading against x. A
    # disc of 0.5 passes a pole at 2.4 from the centre, halfway along, and meets one at 2.6.
    body = Body(Footprint.disc(0.5))
    for reach, is_free in ((2.4, True), (2.6, False)):
        at = reach * math.sqrt(0.5)
        for side in (1, -1):
            pole = shapely.Point(side * at, 3 - at).buffer(1e-3)
            world = world_without(shapely.box(-5, -5, 10, 10), pole)
            start = (0, 0, 0.0 if side == 1 else math.pi)
            end, other = ((3, 3, math.pi / 2), (-3, 3, math.pi / 2))[::side]
            assert (world.first_contact(body, start, end, arc=True) is None) == is_free
            back = (0, 0, math.pi - start[2])
            assert world.first_contact(body, back, other, arc=True) is None


def test_an_arc_may_turn_by_more_than_half_a_circle():
    # About (0, 3) from (0, 0) to (-3, 3), through (0, 6) at two thirds, where an obstacle stands.
    world = world_without(shapely.box(-5, -5, 10, 10), shapely.box(-0.1, 5.9, 0.1, 6.1))
    body, end = Body(Footprint.disc(0.5)), (-3, 3, -math.pi / 2)
    contact = world.first_contact(body, (0, 0, 0), end, 1.5 * math.pi, arc=True)
    assert contact == pytest.approx(2 / 3 - 0.6 / (4.5 * math.pi), abs=2e-3)
    assert world.first_contact(body, (0, 0, 0), end) is None


def test_sliding_along_a_wall_ends_where_the_wall_ends(moving):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    for name in ("disc", "box"):
        body, half = Body(moving.footprints[name]), 0.25 if name == "disc" else 0.2
        start, end = (1.0, half + 1e-7, 0.0), (9.0, half + 1e-7, 0.0)
        assert world.straight_motion_is_free(body, start, end)
        assert world.first_contact(body, start, end) is None
        # A contact deeper than the resolution is always found.
        deep = world.first_contact(body, start, (9.0, half - 0.01, 0.0))
        assert deep is not None


def test_a_motion_that_starts_on_the_wall_may_leave_it(moving):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body = Body(moving.footprints["box"])
    start = (1.0, 0.2 + 1e-9, 0.0)
    assert world.first_contact(body, start, (1.0, 0.21, 1.0)) is not None  # a corner dips
    assert world.first_contact(body, start, (1.0, 6.0, 0.3), 0.3) is None
    contact = world.first_contact(body, start, (1.0, 0.1, 0.0))
    assert contact is not None
    assert contact < 1e-4


@pytest.mark.parametrize(
    "bad", [(math.nan, 0, 0), (0, math.inf, 0), (0, 0, math.nan), (1, 2), None]
)
def test_configurations_that_are_not_numbers_are_refused(bad, moving):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body, good = Body(moving.footprints["ell"]), (1.0, 1.0, 0.0)
    queries = [
        lambda: world.pose_is_free(body, bad),
        lambda: world.clearance(body, bad),
        lambda: world.straight_motion_is_free(body, bad, good),
        lambda: world.straight_motion_is_free(body, good, bad),
        lambda: world.rotation_is_free(body, bad, 1.0),
        lambda: world.first_contact(body, good, bad),
    ]
    for query in queries:
        with pytest.raises(InvalidInputError, match="configuration"):
            query()


def test_inconsistent_motions_are_refused(moving):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body, here, there = Body(moving.footprints["box"]), (1.0, 1.0, 0.0), (2.0, 2.0, 1.0)
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
def test_an_arc_of_a_tiny_turn_is_as_good_as_straight(turn, moving):
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body = Body(moving.footprints["box"])
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
def test_worlds_without_an_area_are_refused(free, says):
    with pytest.raises(InvalidInputError, match=says):
        CollisionWorld(free)


def test_obstacles_may_touch_each_other_and_the_outline(moving):
    blocks = shapely.union_all(
        [shapely.box(0, 3, 2, 4), shapely.box(2, 4, 3, 5), shapely.box(5, 0, 6, 1)]
    )
    world = world_without(shapely.box(0, 0, 10, 8), blocks)
    body = Body(Footprint.disc(0.25))
    outside = (shapely.box(-5, -5, 15, 13) - shapely.box(0, 0, 10, 8)) | blocks
    rng = np.random.default_rng(9)
    for pose in moving.random_poses(rng, 500, 0.0, 8.0):
        expected = outside.distance(shapely.Point(pose[:2])) - 0.25
        assert world.clearance(body, pose) == pytest.approx(max(expected, 0.0), abs=1e-12)
    assert not world.straight_motion_is_free(body, (1.5, 5.0, 0.0), (2.5, 3.0, 0.0))


def test_a_footprint_has_one_body_in_a_world():
    world = CollisionWorld(shapely.box(0, 0, 10, 8))
    body = world.body(Footprint.box(0.6, 0.4))
    assert world.body(Footprint.parse("box:0.6x0.4")) is body
    assert body.footprint == Footprint.box(0.6, 0.4)
    assert world.body(Footprint.disc(0.2)).turning_radius_m == 0.0
