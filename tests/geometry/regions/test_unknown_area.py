import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from multisrt.geometry.regions.boundary import OBSTACLE, RANGE
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.geometry.regions.unknown_area import RAYS, unknown_areas

RANGE_M = 4.0
DISC_M2 = math.pi * RANGE_M**2


def box(x0: float, y0: float, x1: float, y1: float, *tags: int) -> LocalSafeRegion:
    """A rectangle whose lower, right, upper and left sides have these tags."""
    return LocalSafeRegion(
        x=0.5 * (x0 + x1),
        y=0.5 * (y0 + y1),
        range_m=9.0,
        boundary=np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]),
        tags=np.array(tags or (OBSTACLE,) * 4, np.int8),
    )


def area(place: ArrayLike, *regions: LocalSafeRegion) -> float:
    (found,) = unknown_areas(np.array([place]), RANGE_M, regions).tolist()
    return float(found)


def test_nothing_is_unknown_in_a_closed_room():
    assert area((0.5, 0.0), box(-2, -2, 2, 2)) == 0.0


def test_the_whole_disc_is_unknown_far_from_all_regions():
    assert area((20.0, 0.0), box(-2, -2, 2, 2)) == pytest.approx(DISC_M2)


def test_half_a_disc_lies_beyond_the_middle_of_a_long_arc():
    room = box(-9, -9, 0, 9, OBSTACLE, RANGE, OBSTACLE, OBSTACLE)
    assert area((0.0, 0.0), room) == pytest.approx(0.5 * DISC_M2)


def test_an_obstacle_hides_what_is_behind_it_also_from_its_back():
    # The far room is known up to its wall at x = 1, whose back the rays meet.
    near, far = box(-9, -9, 0, 9, OBSTACLE, RANGE, OBSTACLE, OBSTACLE), box(1, -9, 3, 9)
    angles = (np.arange(RAYS) + 0.5) * 2.0 * np.pi / RAYS
    ahead = angles[np.cos(angles) > 0.0]
    sector_m2 = 0.5 * (2.0 * np.pi / RAYS) * np.minimum(RANGE_M, 1.0 / np.cos(ahead)) ** 2
    assert area((0.0, 0.0), near, far) == pytest.approx(sector_m2.sum())


def test_known_space_behind_open_borders_is_looked_through():
    near = box(-9, -9, 0, 9, OBSTACLE, RANGE, OBSTACLE, OBSTACLE)
    far = box(1, -9, 2, 9, *(RANGE,) * 4)
    wall = box(1, -9, 2, 9)
    beyond = area((0.0, 0.0), near, far)
    disc = shapely.Point(0, 0).buffer(RANGE_M, quad_segs=90)
    exact = disc.difference(shapely.union_all([near.polygon(), far.polygon()])).area
    assert beyond == pytest.approx(exact, rel=0.01)
    assert area((0.0, 0.0), near, wall) < beyond


def centimetres(low_m: int, high_m: int) -> st.SearchStrategy[float]:
    return st.integers(100 * low_m, 100 * high_m).map(lambda n: n / 100)


open_boxes = st.tuples(
    centimetres(-5, 4), centimetres(-5, 4), centimetres(1, 4), centimetres(1, 4)
).map(lambda b: box(b[0], b[1], b[0] + b[2], b[1] + b[3], *(RANGE,) * 4))


@settings(max_examples=60, deadline=None)
@given(st.lists(open_boxes, max_size=5), centimetres(-3, 3), centimetres(-3, 3))
def test_without_obstacles_it_is_the_disc_less_the_regions(regions, x, y):
    disc = shapely.Point(x, y).buffer(RANGE_M, quad_segs=180)
    exact = disc.difference(shapely.union_all([r.polygon() for r in regions])).area
    # A ray stands for 5 degrees, so that an edge along a ray may be off by half of that.
    assert area((x, y), *regions) == pytest.approx(exact, abs=0.05 * DISC_M2)


@settings(max_examples=60, deadline=None)
@given(st.lists(open_boxes, max_size=5), open_boxes, centimetres(-3, 3), centimetres(-3, 3))
def test_one_more_region_never_adds_area(regions, more, x, y):
    assert area((x, y), *regions, more) <= area((x, y), *regions) + 1e-9
