import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.numerics.distances import (
    distance_to_boundary,
    distance_to_segments,
    inside,
    length_of,
    nearest_point,
    nearest_points,
)


@st.composite
def stars(draw):
    radii = np.array(draw(st.lists(st.floats(0.5, 3.0), min_size=5, max_size=20)))
    angles = np.arange(len(radii)) * (2.0 * math.pi / len(radii))
    return radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


coordinates = st.integers(-3500, 3500).map(lambda n: n / 1000)
points = st.lists(st.tuples(coordinates, coordinates), max_size=6).map(
    lambda p: np.array(p).reshape(-1, 2)
)
segments = st.lists(
    st.tuples(coordinates, coordinates, coordinates, coordinates), min_size=1, max_size=6
).map(np.array)


@given(stars(), st.floats(-math.pi, math.pi))
def test_distance_to_boundary_agrees_with_shapely(boundary, direction):
    ux, uy = math.cos(direction), math.sin(direction)
    ray = shapely.LineString([(0, 0), (10 * ux, 10 * uy)])
    expected = ray.intersection(shapely.Polygon(boundary).exterior).distance(shapely.Point(0, 0))
    assert distance_to_boundary(boundary, 0.0, 0.0, ux, uy) == pytest.approx(expected, abs=1e-9)


def test_distance_is_infinite_without_a_boundary_ahead():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    assert distance_to_boundary(square, 9.0, 2.0, 1.0, 0.0) == math.inf
    assert distance_to_boundary(square, 9.0, 2.0, -1.0, 0.0) == 5.0


@given(stars(), coordinates, coordinates)
def test_inside_agrees_with_shapely(boundary, x, y):
    polygon = shapely.Polygon(boundary)
    if polygon.exterior.distance(shapely.Point(x, y)) > 1e-9:
        assert inside(boundary, x, y) == shapely.contains_xy(polygon, x, y)


@given(points, points)
def test_nearest_points_agree_with_shapely(nodes, places):
    expected = [
        shapely.MultiPoint(nodes).distance(shapely.Point(place)) if len(nodes) else math.inf
        for place in places
    ]
    assert nearest_points(nodes, places) == pytest.approx(expected)
    for place, distance in zip(places, expected, strict=True):
        assert nearest_point(nodes, *place) == pytest.approx(distance)


@given(segments, points)
def test_distance_to_segments_agrees_with_shapely(lines, places):
    shape = shapely.MultiLineString(list(lines.reshape(-1, 2, 2)))
    expected = [shape.distance(shapely.Point(place)) for place in places]
    assert distance_to_segments(places, lines) == pytest.approx(expected, abs=1e-9)


@given(points)
def test_the_length_of_a_path_agrees_with_shapely(path):
    expected = shapely.LineString(path).length if len(path) > 1 else 0.0
    assert length_of(path) == pytest.approx(expected)
