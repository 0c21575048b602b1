import math

import hypothesis.strategies as st
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from shapely import Polygon, box
from shapely.geometry.base import BaseGeometry

from multisrt.analysis import clearance_tree as module
from multisrt.analysis.clearance_tree import CORNER_SHARE, clearance_tree


def tree_of(free):
    assert isinstance(free, Polygon)
    return clearance_tree(free)


def rooms(*doors):
    """Rooms of 4 x 4 m in a row, with a door in each wall of 0.2 m: bottom and width."""
    free: BaseGeometry = box(0, 0, 4.2 * len(doors) + 4, 4)
    for number, (bottom, width) in enumerate(doors):
        x = 4 + 4.2 * number
        free -= box(x, -1, x + 0.2, bottom) | box(x, bottom + width, x + 0.2, 5)
    return free


def reached_share(free, radius):
    """The share of free space that a disc reaches, by erosion and dilation."""
    room = free.buffer(-radius, quad_segs=64)
    shares = [0.0]
    for part in shapely.get_parts(room):
        if part.is_empty:
            continue
        left = shapely.get_parts(free - part.buffer(radius, quad_segs=64))
        areas = shapely.area(left)
        shares.append(1 - areas[areas > CORNER_SHARE * radius**2].sum() / free.area)
    return max(shares)


def test_triangles_cover_free_space():
    free = rooms((1, 0.8)) - box(1, 1, 2, 2)
    tree = tree_of(free)
    assert tree.areas.sum() == pytest.approx(free.area)
    assert len(tree.links) == len(tree.areas) - 1


def test_a_dumbbell_has_one_door():
    tree = tree_of(rooms((1, 0.8)))
    (door,) = tree.passages(1.0)
    assert door.width_m == pytest.approx(0.8, abs=1e-9)
    assert 4.0 <= door.centre[0] <= 4.2
    assert door.centre[1] == pytest.approx(1.4)
    assert door.beyond_m2 == pytest.approx(16.0, abs=0.2)
    largest = tree.largest_body(0.95)
    assert largest.radius_m == pytest.approx(0.4, abs=1e-9)
    assert largest.limit == door


def test_a_door_between_corners_at_an_angle_is_exact():
    free = (
        box(0, 0, 8, 4)
        - Polygon([(3, 0), (5, 0), (4, 1.7)])
        - Polygon([(3, 4), (6, 4), (4.3, 2.1)])
    )
    (door,) = tree_of(free).passages(1.0)
    assert door.width_m == pytest.approx(math.hypot(0.3, 0.4), abs=1e-9)
    assert sorted(door.ends) == [(4.0, 1.7), (4.3, 2.1)]


def test_a_corner_before_a_slanted_wall_is_exact():
    # The corner (4, 1.7) is at a distance of 0.6 / sqrt(1.25) from the wall y = 2.3 + (x - 4) / 2.
    wall = Polygon([(0, 6), (0, 0.3), (8, 4.3), (8, 6)])
    free = box(0, 0, 8, 4) - Polygon([(3, 0), (5, 0), (4, 1.7)]) - wall
    door = tree_of(free).passages(0.5)[0]
    assert door.width_m == pytest.approx(0.6 / math.sqrt(1.25), abs=1e-9)


def test_the_narrowest_of_several_doors_comes_first():
    passages = tree_of(rooms((1, 0.9), (2, 0.6), (0.5, 0.75))).passages(1.0)
    assert [round(passage.width_m, 6) for passage in passages] == [0.6, 0.75, 0.9]


def test_small_closets_do_not_limit_the_largest_body():
    # A closet of 0.6 x 0.6 m behind a door of 0.3 m: 0.36 of 16.4 m2.
    free = box(0, 0, 4, 4) | box(4, 1.15, 4.1, 1.45) | box(4.1, 1, 4.7, 1.6)
    tree = tree_of(free)
    assert tree.largest_body(0.95).radius_m > 1.0
    assert tree.largest_body(0.99).radius_m == pytest.approx(0.15, abs=1e-9)


def test_a_wider_way_round_makes_a_passage_none():
    # Two rooms with two doors: the narrow one keeps nobody out.
    free = rooms((0.5, 1.0)) | box(3.9, 3, 4.3, 3.4)
    assert [round(p.width_m, 6) for p in tree_of(free).passages(1.0)] == [1.0]


def test_a_corridor_with_a_bend_is_as_wide_as_its_arms():
    tree = tree_of(box(0, 0, 6, 1) | box(5, 0, 6, 7))
    assert tree.largest_body(0.95).radius_m == pytest.approx(0.5, abs=1e-3)
    assert tree.reached_share(0.499) > 0.95
    assert tree.reached_share(0.51) < 0.15


def test_a_maze_is_limited_by_its_bottleneck():
    # Corridors of 1 m between walls of 0.2 m, as a snake; one opening is of 0.7 m.
    free: BaseGeometry = box(0, 0, 8, 5.8)
    free -= box(0, 1, 7, 1.2) | box(1, 2.2, 8, 2.4) | box(0, 3.4, 7.3, 3.6) | box(1, 4.6, 8, 4.8)
    largest = tree_of(free).largest_body(0.9)
    assert largest.radius_m == pytest.approx(0.35, abs=1e-9)
    assert largest.limit is not None
    assert largest.limit.centre == pytest.approx((7.65, 3.5), abs=0.2)
    assert largest.limit.beyond_m2 == pytest.approx(16.4, abs=1.0)


def test_a_square_has_its_inscribed_disc():
    largest = tree_of(box(0, 0, 3, 3)).largest_body(0.95)
    assert largest.radius_m == pytest.approx(1.5)
    assert largest.limit is None


def test_coordinates_may_be_far_from_the_origin():
    far = shapely.affinity.translate(rooms((1, 0.8)), 250_000, -4_000_000)
    largest = tree_of(far).largest_body(0.95)
    assert largest.radius_m == pytest.approx(0.4, abs=1e-6)


def test_cracks_and_thin_walls_do_not_connect_rooms():
    # A wall of 2 mm with a door of 0.5 m, and a crack of 1 mm beside it.
    free = box(0, 0, 8, 4) - box(4, 0, 4.002, 1.5) - box(4, 2, 4.002, 3) - box(4, 3.001, 4.002, 4)
    largest = tree_of(free).largest_body(0.95)
    assert largest.radius_m == pytest.approx(0.25, abs=1e-4)


def test_equal_parts_give_equal_trees():
    first, second = (tree_of(rooms((1, 0.8), (2, 0.7))) for _ in range(2))
    assert np.array_equal(first.links, second.links)
    assert np.array_equal(first.clearances, second.clearances)


@given(st.integers(0, 10_000))
@settings(max_examples=12, deadline=None)
def test_the_largest_body_fits_and_a_larger_one_does_not(seed):
    rng = np.random.default_rng(seed)
    free: BaseGeometry = box(0, 0, 9, 7)
    for _ in range(9):
        corner = rng.uniform((0, 0), (8, 6))
        turned = shapely.affinity.rotate(
            box(*corner, *(corner + rng.uniform(0.1, 2.0, 2))), rng.uniform(0, 90)
        )
        free -= turned
    free = max(shapely.get_parts(free), key=lambda part: part.area)
    share = 0.9
    radius = tree_of(free).largest_body(share).radius_m
    assert reached_share(free, 0.99 * radius) >= share - 5e-3
    assert reached_share(free, 1.01 * radius) < share + 5e-3


@given(st.integers(0, 10_000), st.floats(0.1, 1.0))
@settings(max_examples=12, deadline=None)
def test_the_reached_share_is_that_of_erosion_and_dilation(seed, radius):
    rng = np.random.default_rng(seed)
    free = rooms(*rng.uniform((0.2, 0.3), (1.0, 2.0), (3, 2)))
    tree = tree_of(free)
    if np.abs(tree.clearances - radius).min() > 2e-3:
        assert tree.reached_share(radius) == pytest.approx(reached_share(free, radius), abs=0.01)


def rough_gap():
    """Two rooms with a gap between rough walls, narrow at three places within 0.4 m."""
    ups = [0.02, 0.0, 0.02, 0.01, 0.03, 0.005, 0.03]
    xs = [4 + 0.06 * k for k in range(len(ups))]
    lower = Polygon([(4, -1), *((x, 2 - up) for x, up in zip(xs, ups, strict=True)), (xs[-1], -1)])
    upper = shapely.affinity.scale(lower, 1, -1, origin=(0, 2.08))
    return box(0, 0, 8, 4) - lower - upper


def test_one_gap_that_is_narrow_at_several_places_is_one_passage():
    tree = tree_of(rough_gap())
    several = tree.passages(0.3)
    assert len(several) > 1
    (gap,) = tree.passages(0.3, apart_m=0.5)
    assert gap == several[0]
    assert tree.passages(0.3, apart_m=0.01) == several


def test_doors_of_two_closets_side_by_side_are_two_passages():
    walls = box(-1, 2, 1.6, 2.2) | box(1.8, 2, 2.2, 2.2) | box(2.4, 2, 5, 2.2) | box(1.9, 2, 2.1, 5)
    tree = tree_of(box(0, 0, 4, 4) - walls)
    doors = tree.passages(0.3, apart_m=1.0)
    assert sorted(round(door.centre[0], 1) for door in doors) == [1.7, 2.3]


def test_doors_on_both_sides_of_an_anteroom_are_two_passages():
    free = rooms((1.9, 0.3), (1.9, 0.4))
    assert len(tree_of(free).passages(0.3, apart_m=5.0)) == 2


def test_long_walls_of_wide_halls_take_few_triangles():
    # Two halls of 400 x 300 m with a door of 1.5 m in a wall of 20 m.
    wall = box(400, -1, 420, 301) - box(399, 200, 421, 201.5)
    tree = tree_of(box(0, 0, 820, 300) - wall)
    (door,) = tree.passages(100.0)
    assert door.width_m == pytest.approx(1.5, abs=1e-9)
    assert tree.radii.max() == pytest.approx(150.0, rel=1e-3)
    assert tree.areas.sum() == pytest.approx(2 * 400 * 300 + 20 * 1.5)
    assert len(tree.areas) < 20_000


def test_samples_that_are_wide_at_first_find_what_even_ones_find(monkeypatch):
    rng = np.random.default_rng(4)
    pillars = [box(x, y, x + 9, y + 8) for x, y in rng.uniform(5, 75, (9, 2))]
    free = max(shapely.get_parts(box(0, 0, 90, 90) - shapely.union_all(pillars)), key=shapely.area)
    graded = tree_of(free)
    monkeypatch.setattr(module, "MAX_EVEN", math.inf)
    even = tree_of(free)
    assert len(graded.areas) < len(even.areas)
    assert graded.areas.sum() == pytest.approx(free.area)
    found = [[p.width_m for p in tree.passages(5.0)] for tree in (even, graded)]
    assert found[0] == pytest.approx(found[1], abs=1e-6)
    for radius in (1.0, 2.0, 4.0):
        true = reached_share(free, radius)
        assert graded.reached_share(radius) == pytest.approx(true, abs=5e-3)
