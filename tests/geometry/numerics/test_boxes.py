"""Boxes that meet a box, against shapely."""

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.numerics.boxes import all_below, bounds_of, intersecting_boxes

# Multiples of a quarter, so that borders often touch and nothing is rounded.
numbers = st.integers(-20, 20).map(lambda n: n / 4.0)
sizes = st.integers(0, 12).map(lambda n: n / 4.0)
boxes = st.tuples(numbers, numbers, sizes, sizes).map(
    lambda b: (b[0], b[1], b[0] + b[2], b[1] + b[3])
)


@given(st.lists(st.tuples(boxes, sizes), max_size=12), boxes)
def test_boxes_that_meet_agree_with_shapely(many, one):
    given_boxes = np.array([box for box, _ in many]).reshape(-1, 4)
    slacks = np.array([slack for _, slack in many])
    expected = [
        k
        for k, ((x0, y0, x1, y1), slack) in enumerate(many)
        if shapely.intersects(
            shapely.box(x0 - slack, y0 - slack, x1 + slack, y1 + slack), shapely.box(*one)
        )
    ]
    found = np.empty(len(many), np.int64)
    assert found[: intersecting_boxes(given_boxes, slacks, one, found)].tolist() == expected


coordinates = st.floats(-20.0, 20.0) | st.sampled_from([np.nan, np.inf, -np.inf, 10.0, -10.0])
points = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=6).map(np.array)


@given(points)
def test_coordinates_below_a_limit_agree_with_numpy(some):
    assert all_below(some, 10.0) == bool(np.all(np.abs(some) < 10.0))


@given(points.filter(lambda some: np.isfinite(some).all()))
def test_bounds_agree_with_numpy(some):
    assert bounds_of(some) == (*some.min(axis=0), *some.max(axis=0))
