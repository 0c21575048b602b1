"""Unions of regions against sampled points, and differences that GEOS gets wrong."""

import numpy as np
import pytest
import shapely
from shapely import affinity

from multisrt.geometry.regions.overlay import GRID_M, difference_of, union_on_grid


def covered(polygons, points):
    return np.any([shapely.contains_xy(polygon, points) for polygon in polygons], axis=0)


def test_a_part_beside_borders_that_nearly_coincide_is_kept():
    # Regions of two scans on either side of a line; GEOS without a grid leaves out the first.
    first = shapely.Polygon(
        [(-1.1, 8.3), (-1.2, 7.2), (-0.08800000000000008, 8.38), (3.144, 8.717)]
    )
    second = shapely.Polygon([(-1.1, 6.9), (-0.088, 8.38), (3.144, 8.717)])
    union = union_on_grid([first, second])
    assert union.area == pytest.approx(first.area + second.area)
    assert shapely.contains_xy(union, *shapely.get_coordinates(first.representative_point())[0])


@pytest.mark.parametrize("seed", range(20))
def test_a_union_is_what_any_of_its_areas_covers(seed):
    # Triangles with corners on few lines, moved by rounding, so that borders nearly coincide.
    rng = np.random.default_rng(seed)
    corners = rng.integers(0, 6, (12, 3, 2)) / 3.0 + rng.choice([0.0, 1e-16, 1e-15], (12, 3, 2))
    triangles = [polygon for polygon in map(shapely.Polygon, corners) if polygon.area > 0.0]
    union = union_on_grid(triangles)
    assert union.is_valid
    points = rng.uniform(0.0, 2.0, (2000, 2))
    off = shapely.distance(shapely.points(points), shapely.union_all(shapely.boundary(triangles)))
    clear = points[off > 10.0 * GRID_M]
    assert (shapely.contains_xy(union, clear) == covered(triangles, clear)).all()


def test_invalid_areas_are_made_valid():
    bow_tie = shapely.Polygon([(0, 0), (2, 2), (2, 0), (0, 2)])
    assert union_on_grid([bow_tie, shapely.box(0.0, 0.0, 0.5, 0.5)]).area == pytest.approx(2.125)


def test_the_union_of_nothing_is_empty():
    assert union_on_grid([]).is_empty


BOXES = [(5.5, 0.5, 6.5, 0.7), (7.25, 7.25, 7.45, 8.0), (1.25, 7.25, 4.25, 8.0)]


def rotated(degrees):
    shapes = [shapely.box(0.0, 0.0, 10.0, 8.0), *(shapely.box(*bounds) for bounds in BOXES)]
    hall, *walls = (affinity.rotate(shape, degrees, origin=(0.0, 0.0)) for shape in shapes)
    return hall, walls


def test_no_wall_of_a_rotated_hall_is_lost():
    # The second wall ends at the border of the hall, up to rounding; GEOS leaves out the third.
    hall, walls = rotated(199.91693149343544)
    free = difference_of(hall, walls)
    assert free.area == pytest.approx(80.0 - 0.2 - 0.15 - 2.25)
    assert not free.covers(walls[2].centroid)


def test_corners_stay_as_they_are_given():
    hall, walls = rotated(30.0)
    free = difference_of(hall, walls)
    assert {*hall.exterior.coords} <= {*map(tuple, shapely.get_coordinates(free).tolist())}
    assert difference_of(hall, []) is hall
