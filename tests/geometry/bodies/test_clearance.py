"""Clearance, free travel and fitting inside a region, against shapely and by hand."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.bodies.clearance import disc_clearance
from multisrt.geometry.bodies.fitting import pose_is_inside, rotation_is_free
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.bodies.free_travel import free_travel_disc, free_travel_polygon

ROOM = np.array([(0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (0.0, 8.0)])
# Two rooms joined by a door one metre wide in a wall from x = 4.9 to 5.1.
DOOR = np.array(
    [
        *[(0.0, 0.0), (4.9, 0.0), (4.9, 3.5), (5.1, 3.5), (5.1, 0.0), (10.0, 0.0)],
        *[(10.0, 8.0), (5.1, 8.0), (5.1, 4.5), (4.9, 4.5), (4.9, 8.0), (0.0, 8.0)],
    ]
)
BODIES = {
    "box": Footprint.box(0.6, 0.4),
    "wedge": Footprint.parse("polygon:-0.2,-0.1 0.3,0 -0.2,0.1"),
    "ell": Footprint.parse("polygon:-0.2,-0.2 0.6,-0.2 0.6,0.1 0.1,0.1 0.1,0.5 -0.2,0.5"),
    "bend": Footprint.parse(
        "polygon:-0.3,-0.4 0.5,-0.4 0.5,-0.2 0.1,-0.2 0.1,0.2 0.5,0.2 0.5,0.4 -0.3,0.4"
    ),
    "star": Footprint.parse(
        "polygon:0.5,0 0.1,0.1 0,0.5 -0.1,0.1 -0.5,0 -0.1,-0.1 0,-0.5 0.1,-0.1"
    ),
}


def region(rng, corners=60):
    """Return a star-shaped region around the origin with jumps in depth, as a robot sees it."""
    angles = (np.arange(corners) + rng.uniform(0.1, 0.9, corners)) * 2 * np.pi / corners
    depth = np.repeat(rng.uniform(0.8, 3.0, corners // 4), 4) * rng.uniform(0.9, 1.1, corners)
    return np.column_stack([depth * np.cos(angles), depth * np.sin(angles)])


def travel_polygon(boundary, body, pose, direction, limit):
    x, y, heading = pose
    cosine, sine = math.cos(direction), math.sin(direction)
    return free_travel_polygon(boundary, body.vertices, x, y, heading, cosine, sine, limit)


def travel_disc(boundary, x, y, direction, radius, limit):
    cosine, sine = math.cos(direction), math.sin(direction)
    return free_travel_disc(boundary, x, y, cosine, sine, radius, limit)


def test_clearance_is_the_distance_to_the_nearest_wall():
    assert disc_clearance(ROOM, 3.0, 2.5) == 2.5
    assert disc_clearance(ROOM, -3.0, -4.0) == 5.0
    assert disc_clearance(ROOM, 0.0, 5.0) == 0.0


@given(st.integers(0, 2**32 - 1), st.floats(-4, 4), st.floats(-4, 4))
def test_clearance_agrees_with_shapely(seed, x, y):
    boundary = region(np.random.default_rng(seed))
    expected = shapely.LinearRing(boundary).distance(shapely.Point(x, y))
    assert disc_clearance(boundary, x, y) == pytest.approx(expected, abs=1e-12)


def test_a_disc_drives_up_to_the_wall():
    assert travel_disc(ROOM, 2.0, 4.0, 0.0, 0.5, 100.0) == pytest.approx(7.5, abs=1e-12)
    assert travel_disc(ROOM, 2.0, 4.0, 0.0, 0.5, 3.0) == 3.0
    assert travel_disc(ROOM, 2.0, 4.0, 0.0, 0.5, 0.0) == 0.0
    assert travel_disc(ROOM, 2.0, 4.0, math.pi / 2, 0.5, math.inf) == pytest.approx(3.5, abs=1e-12)
    # Down a 3-4-5 slope: the floor is reached at a height of one radius.
    slope = math.atan2(-4, 3)
    assert travel_disc(ROOM, 2.0, 4.5, slope, 0.5, 100.0) == pytest.approx(5.0, abs=1e-12)


def test_a_disc_meets_the_end_of_a_wall():
    # The corner (4.9, 3.5) of the door is 0.3 off the line: a disc of 0.5 stops 0.4 short of it.
    assert travel_disc(DOOR, 2.0, 3.8, 0.0, 0.5, 100.0) == pytest.approx(2.5, abs=1e-12)


def test_a_disc_passes_a_door_of_its_own_width():
    assert travel_disc(DOOR, 2.0, 4.0, 0.0, 0.5, 6.0) == 6.0
    assert travel_disc(DOOR, 2.0, 4.0, 0.0, 0.5 + 1e-6, 6.0) < 2.91
    assert travel_disc(DOOR, 2.0, 4.0 + 1e-6, 0.0, 0.5, 6.0) < 2.91


@pytest.mark.parametrize("heading", [0.0, 0.3, 1.0, math.pi / 2, 2.5])
def test_sliding_along_a_wall_is_free_and_into_it_is_not(heading):
    """In a turned room, where the touch is exact only up to rounding."""
    c, s = math.cos(heading), math.sin(heading)
    turn = np.array([[c, s], [-s, c]])
    room = ROOM @ turn
    disc, box, wedge = (np.array(p) @ turn for p in ((2.0, 0.5), (2.0, 0.2), (2.0, 0.1)))
    x, y = disc
    assert travel_disc(room, x, y, heading, 0.5, 5.0) == 5.0
    assert travel_disc(room, x, y, heading + math.pi, 0.5, 5.0) == pytest.approx(1.5, abs=1e-9)
    assert travel_disc(room, x, y, heading - 0.01, 0.5, 5.0) < 1e-9
    assert travel_disc(room, x, y, heading + 0.01, 0.5, 5.0) == 5.0
    for body, place in ((BODIES["box"], box), (BODIES["wedge"], wedge)):
        pose = (*place, heading)
        assert travel_polygon(room, body, pose, heading, 5.0) == 5.0
        assert travel_polygon(room, body, pose, heading, 50.0) == pytest.approx(7.7, abs=1e-9)
        assert travel_polygon(room, body, pose, heading - 0.01, 5.0) < 1e-9
        assert travel_polygon(room, body, pose, heading + 0.01, 5.0) == 5.0


def test_a_box_in_a_corner_can_leave_it():
    pose = (0.3, 0.2, 0.0)
    for direction in (0.0, math.pi / 4, math.pi / 2):
        assert travel_polygon(ROOM, BODIES["box"], pose, direction, 2.0) == 2.0
    for direction in (-0.1, math.pi, -math.pi / 2, -3 * math.pi / 4, math.pi / 2 + 0.1):
        assert travel_polygon(ROOM, BODIES["box"], pose, direction, 2.0) < 1e-9
    for direction in (0.0, math.pi / 4, math.pi / 2):
        assert travel_disc(ROOM, 0.5, 0.5, direction, 0.5, 2.0) == 2.0
    for direction in (-0.1, math.pi, -math.pi / 2, -3 * math.pi / 4, math.pi / 2 + 0.1):
        assert travel_disc(ROOM, 0.5, 0.5, direction, 0.5, 2.0) < 1e-9


def test_a_box_passes_a_door_of_its_own_width():
    wide = Footprint.box(0.6, 1.0)
    assert travel_polygon(DOOR, wide, (2.0, 4.0, 0.0), 0.0, 6.0) == 6.0
    too_wide = Footprint.box(0.6, 1.0 + 1e-6)
    assert travel_polygon(DOOR, too_wide, (2.0, 4.0, 0.0), 0.0, 6.0) == pytest.approx(2.6)
    assert travel_polygon(DOOR, wide, (2.0, 4.1, 0.0), 0.0, 6.0) == pytest.approx(2.6)


def test_a_corner_that_meets_a_corner_does_not_slip_through():
    tip = Footprint.polygon([(-0.2, -0.3), (0.4, 0.0), (-0.2, 0.3)])
    spike = np.array([(0, 0), (4, 0), (4, 3.9), (3, 4), (4, 4.1), (4, 8), (0, 8)], dtype=float)
    assert travel_polygon(spike, tip, (1.0, 4.0, 0.0), 0.0, 9.0) == pytest.approx(1.6, abs=1e-9)


def test_a_body_that_overlaps_the_boundary_cannot_move():
    assert travel_disc(ROOM, 0.5 - 1e-6, 4.0, 0.0, 0.5, 1.0) == 0.0
    assert travel_disc(ROOM, 0.5 - 1e-12, 4.0, 0.0, 0.5, 1.0) == 1.0
    box = BODIES["box"]
    for x in (0.3 - 1e-6, 0.0, -3.0):
        assert travel_polygon(ROOM, box, (x, 4.0, 0.0), 0.0, 1.0) == 0.0
        assert not rotation_is_free(ROOM, box.vertices, x, 4.0, 0.0, 1e-3)
        assert not pose_is_inside(ROOM, box.vertices, x, 4.0, 0.0)
    assert travel_polygon(ROOM, box, (0.3 - 1e-12, 4.0, 0.0), 0.0, 1.0) == 1.0


def test_a_body_that_fits_its_region_edge_on_edge_is_inside_it():
    room = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
    body = Footprint.box(1.0, 1.0).vertices
    assert pose_is_inside(room, body, 0.5, 0.5, 0.0)
    assert pose_is_inside(room, body, 0.5, 0.5, math.pi / 2)
    assert not pose_is_inside(room, body, 1.0, 0.5, 0.0)
    assert not pose_is_inside(room, body, 0.8, 0.5, 0.0)
    notched = np.array([(0, 0), (1, 0), (0.7, 0.5), (1, 1), (0, 1)], dtype=float)
    assert not pose_is_inside(notched, body, 0.5, 0.5, 0.0)


def test_a_block_within_the_body_on_its_lines_is_found():
    # The block fills the left of the body from edge to edge: no corner of one is inside the
    # other, and no two edges cross.
    block = np.array([(0, 0), (4, 0), (4, 3), (0, 3), (0, 2), (1, 2), (1, 1), (0, 1)], dtype=float)
    body = Footprint.box(2.0, 1.0)
    assert not pose_is_inside(block, body.vertices, 1.5, 1.5, 0.0)
    assert travel_polygon(block, body, (1.5, 1.5, 0.0), 0.0, 1.0) == 0.0
    assert pose_is_inside(block, body.vertices, 2.0, 1.5, 0.0)
    assert travel_polygon(block, body, (2.0, 1.5, 0.0), 0.0, 5.0) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.slow
def test_bodies_and_walls_on_one_grid_agree_with_shapely():
    """Where everything touches, passes and fits exactly, as in worlds from occupancy grids."""
    rng = np.random.default_rng(0)
    moved = stopped = inside_count = 0
    for _ in range(120):
        blocks = [
            shapely.box(x, y, x + w, y + h)
            for x, y, w, h in np.column_stack(
                [rng.integers(0, 60, (6, 2)), rng.integers(1, 12, (6, 2))]
            )
            / 10
        ]
        parts = shapely.get_parts(shapely.box(0, 0, 6, 6) - shapely.union_all(blocks))
        largest = shapely.Polygon(max(parts, key=shapely.area).exterior)
        if not largest.is_valid:
            continue
        boundary = shapely.get_coordinates(shapely.orient_polygons(largest))[:-1].copy()
        touching, near = largest.buffer(2e-9, join_style="mitre"), largest.buffer(1e-7)
        shapely.prepare([touching, near])
        for _ in range(40):
            body = BODIES[("box", "ell", "bend")[rng.integers(3)]]
            x, y, limit = rng.integers(1, 60, 3) / 10
            heading, direction = rng.integers(-4, 5, 2) * math.pi / (2, 4)
            pose = (x, y, heading)
            inside = touching.covers(body.placed(pose))
            assert pose_is_inside(boundary, body.vertices, *pose) == inside
            travel = travel_polygon(boundary, body, pose, direction, limit)
            if not inside:
                assert travel == 0.0
                continue
            inside_count += 1
            ahead = np.array([math.cos(direction), math.sin(direction), 0.0])
            assert near.covers(body.swept(pose, pose + travel * ahead))
            if travel < limit:
                stopped += 1
                assert not touching.covers(body.placed(pose + (travel + 1e-5) * ahead))
            moved += travel > 0.0
    assert inside_count > moved > 400
    assert stopped > 200


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_pose_that_is_not_finite_allows_no_motion(value, place):
    pose = [5.0, 4.0, 0.0]
    pose[place] = value
    x, y, heading = pose
    box = BODIES["box"].vertices
    assert free_travel_polygon(ROOM, box, x, y, heading, 1.0, 0.0, 1.0) == 0.0
    assert not rotation_is_free(ROOM, box, x, y, heading, 1.0)
    assert not rotation_is_free(ROOM, box, 5.0, 4.0, 0.0, value)
    assert free_travel_disc(ROOM, 5.0, 4.0, value, 0.0, 0.2, 1.0) == 0.0
    assert free_travel_disc(ROOM, value, 4.0, 1.0, 0.0, 0.2, 1.0) == 0.0
    assert free_travel_polygon(ROOM, box, 5.0, 4.0, 0.0, value, 0.0, 1.0) == 0.0
    assert free_travel_disc(ROOM, 5.0, 4.0, 1.0, 0.0, 0.2, math.nan) == 0.0


def test_travel_of_a_disc_agrees_with_shapely():
    rng = np.random.default_rng(0)
    stopped = 0
    for case in range(1500):
        boundary = DOOR if case % 5 == 0 else region(rng)
        inside = shapely.Polygon(boundary)
        ring = inside.exterior
        x, y = rng.uniform((0, 0), (10, 8)) if case % 5 == 0 else rng.uniform(-0.5, 0.5, 2)
        direction, radius, limit = rng.uniform(-4, 4), rng.uniform(0.05, 0.6), rng.uniform(0.1, 5)
        travel = travel_disc(boundary, x, y, direction, radius, limit)
        ahead = np.array([math.cos(direction), math.sin(direction)])
        clearance = ring.distance(shapely.Point(x, y))
        if clearance < radius:
            assert travel == 0.0
            continue
        path = shapely.LineString([(x, y), (x, y) + travel * ahead])
        assert ring.distance(path) >= radius - 1e-8
        if travel < limit:
            stopped += 1
            assert ring.distance(shapely.Point((x, y) + travel * ahead)) < radius + 1e-8
            assert ring.distance(shapely.Point((x, y) + (travel + 1e-5) * ahead)) < radius
    assert stopped > 700


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_travel_of_a_polygon_agrees_with_shapely(name):
    rng = np.random.default_rng(len(name))
    body = BODIES[name]
    stopped = blocked = 0
    for case in range(500):
        boundary = DOOR if case % 4 == 0 else region(rng)
        inside = shapely.Polygon(boundary)
        x, y = rng.uniform((0, 0), (10, 8)) if case % 4 == 0 else rng.uniform(-0.5, 0.5, 2)
        heading, direction, limit = rng.uniform(-4, 4), rng.uniform(-4, 4), rng.uniform(0.1, 5)
        travel = travel_polygon(boundary, body, (x, y, heading), direction, limit)
        starts_inside = inside.covers(body.placed((x, y, heading)))
        assert pose_is_inside(boundary, body.vertices, x, y, heading) == starts_inside
        if not starts_inside:
            blocked += 1
            assert travel == 0.0
            continue
        ahead = np.array([math.cos(direction), math.sin(direction)])
        end = (*((x, y) + travel * ahead), heading)
        assert inside.buffer(1e-7).covers(body.swept((x, y, heading), end))
        if travel < limit:
            stopped += 1
            assert inside.exterior.distance(body.placed(end)) < 1e-8
            beyond = (*((x, y) + (travel + 1e-5) * ahead), heading)
            assert not inside.covers(body.placed(beyond))
    assert stopped > 100
    assert blocked > 10


def test_a_box_turns_where_its_diagonal_fits():
    box = BODIES["box"]  # half diagonal: sqrt(0.13) = 0.36056 m
    assert rotation_is_free(ROOM, box.vertices, 0.37, 4.0, 0.0, 2 * math.pi)
    assert rotation_is_free(ROOM, box.vertices, math.sqrt(0.13), 4.0, 0.0, 2 * math.pi)
    assert not rotation_is_free(ROOM, box.vertices, 0.36, 4.0, 0.0, math.pi)
    assert not rotation_is_free(ROOM, box.vertices, 0.36, 4.0, 0.0, -math.pi)
    assert rotation_is_free(ROOM, box.vertices, 0.36, 4.0, 0.0, 0.5)
    assert not rotation_is_free(ROOM, box.vertices, 5.0, 4.0, 0.0, 7.0)


def test_a_touching_box_can_turn_away_but_not_in():
    # The corner (-0.3, -0.2) touches the wall x = 0 between two headings of the box: it meets the
    # wall where -0.3 cos h + 0.2 sin h = -0.32.
    box = BODIES["box"].vertices
    reach, lean = math.sqrt(0.13), math.atan2(0.2, 0.3)
    touch = math.acos(0.32 / reach) - lean
    assert rotation_is_free(ROOM, box, 0.32, 4.0, touch, 0.0)
    free = {turn: rotation_is_free(ROOM, box, 0.32, 4.0, touch, turn) for turn in (-0.05, 0.05)}
    expected = {}
    for turn in free:
        placed = Footprint.box(0.6, 0.4).placed((0.32, 4.0, touch + turn))
        expected[turn] = bool(shapely.Polygon(ROOM).covers(placed))
    assert free == expected
    assert sorted(expected.values()) == [False, True]


def test_a_corner_of_the_world_blocks_an_edge_of_the_body():
    # A long body turns beside a spike: its edge comes near, but none of its corners.
    body = Footprint.box(4.0, 0.2).vertices
    spike = np.array(
        [(0, 0), (10, 0), (10, 8), (5.2, 8), (5.1, 4.5), (5.0, 8), (0, 8)], dtype=float
    )
    assert rotation_is_free(spike, body, 4.0, 4.0, 0.0, 0.25)
    assert not rotation_is_free(spike, body, 4.0, 4.0, 0.0, 0.7)
    assert rotation_is_free(spike, body, 4.0, 4.0, 0.0, -0.7)


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_rotations_agree_with_sampling(name):
    rng = np.random.default_rng(100 + len(name))
    body = BODIES[name]
    outline = np.vstack([body.vertices, body.vertices[:1]])
    answers = []
    for _ in range(100):
        boundary = rng.uniform(0.7, 1.4) * body.circumscribed_radius_m * region(rng, 40)
        inside = shapely.Polygon(boundary)
        x, y = rng.uniform(-0.4, 0.4, 2) * body.circumscribed_radius_m
        heading, turn = rng.uniform(-4, 4), rng.uniform(-2 * math.pi, 2 * math.pi)
        free = rotation_is_free(boundary, body.vertices, x, y, heading, turn)
        angles = heading + turn * np.linspace(0, 1, 2000)
        c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
        px = x + c * outline[:, 0] - s * outline[:, 1]
        py = y + s * outline[:, 0] + c * outline[:, 1]
        places = shapely.polygons(np.stack([px, py], axis=-1))
        grown = inside.buffer(1e-6)
        shapely.prepare([inside, grown])
        answers.append(free)
        if free:
            assert shapely.covers(grown, places).all()
        elif shapely.covers(inside, places).all():
            # Sampling misses only what happens between two samples.
            assert shapely.distance(places, inside.exterior).min() < 1e-3
    assert 20 < sum(answers) < 80
