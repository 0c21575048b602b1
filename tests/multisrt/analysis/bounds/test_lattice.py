"""Paths through cells against visibility graphs; touched cells and areas against shapely."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra
from shapely import affinity

from multisrt.analysis.bounds.lattice import TOUCH_M, Lattice, ShortestPaths


def tilted(width, height, angle, *, at=(0.0, 0.0)):
    box = shapely.box(at[0], at[1], at[0] + width, at[1] + height)
    return affinity.rotate(box, angle, origin=(0.0, 0.0))


def boxes(lattice):
    """Return the squares of all cells, by rows."""
    rows, columns = np.mgrid[: lattice.rows, : lattice.columns].reshape(2, -1)
    x0, y0 = lattice.x0 + columns * lattice.cell_m, lattice.y0 + rows * lattice.cell_m
    return shapely.box(x0, y0, x0 + lattice.cell_m, y0 + lattice.cell_m)


def world(seed):
    """Return a hall with tilted walls in it, some of them thin."""
    rng = np.random.default_rng(seed)
    hall = affinity.rotate(shapely.box(0, 0, 8, 6), float(rng.uniform(0, 90)))
    walls = [
        affinity.rotate(
            shapely.box(x, y, x + rng.uniform(0.5, 4.0), y + rng.uniform(0.02, 0.5)),
            float(rng.uniform(0, 180)),
        )
        for x, y in rng.uniform(hall.bounds[:2], hall.bounds[2:], (7, 2))
    ]
    free = hall.difference(shapely.union_all(walls))
    return max(shapely.get_parts(free), key=lambda part: part.area)


def points_in(polygon, count, seed):
    rng = np.random.default_rng(seed)
    x0, y0, x1, y1 = polygon.bounds
    points = rng.uniform((x0, y0), (x1, y1), (200 * count, 2))
    return points[shapely.contains_xy(polygon, points)][:count]


def geodesics(polygon, points):
    """Return the lengths of the shortest ways between points, by a visibility graph."""
    nodes = np.concatenate([points, shapely.get_coordinates(polygon)])
    room = polygon.buffer(1e-9)
    shapely.prepare(room)
    i, j = np.triu_indices(len(nodes), 1)
    lines = shapely.linestrings(np.stack([nodes[i], nodes[j]], axis=1))
    lengths = np.where(shapely.covers(room, lines), shapely.length(lines), np.inf)
    graph = np.full((len(nodes), len(nodes)), np.inf)
    graph[i, j] = graph[j, i] = np.maximum(lengths, 1e-12)
    found = dijkstra(np.where(np.isfinite(graph), graph, 0.0), indices=range(len(points)))
    return found[:, : len(points)]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("cell", [0.06, 0.3])
def test_no_path_is_shorter_than_its_bound(seed, cell):
    free = world(seed)
    points = points_in(free, 6, seed)
    lattice = Lattice.over(free, cell)
    paths = ShortestPaths(lattice, lattice.touched(free))
    ends = [paths.corners(lattice.cells_at(point[None])) for point in points]
    bounds, true = paths.between(ends), geodesics(free, points)
    assert np.isfinite(bounds).all()
    assert (bounds <= true + 1e-9).all()


def test_bounds_are_close_where_walls_are_thick():
    free = shapely.box(0, 0, 10, 10).difference(shapely.box(4, -1, 6, 8))
    points = np.array([(1.0, 1.0), (9.0, 2.0), (3.0, 9.0)])
    lattice = Lattice.over(free, 0.05)
    paths = ShortestPaths(lattice, lattice.touched(free))
    bounds = paths.between([paths.corners(lattice.cells_at(point[None])) for point in points])
    assert (bounds >= geodesics(free, points) / 1.03 - 0.3).all()


@given(st.floats(0.0, 90.0), st.floats(0.03, 0.5))
def test_a_slanted_corridor_is_as_long_as_it_is(angle, width):
    corridor = tilted(12.0, width, angle)
    start, end = (tilted(0.001, 0.001, angle, at=(x, 0.5 * width)).centroid for x in (0.1, 11.9))
    lattice = Lattice.over(corridor, 0.1)
    paths = ShortestPaths(lattice, lattice.touched(corridor))
    ends = [paths.corners(lattice.cells_at(shapely.get_coordinates(end))) for end in (start, end)]
    length = paths.between(ends)[0, 1]
    assert 11.8 / 1.03 - 0.3 <= length <= start.distance(end)


@given(st.floats(0.0, 180.0), st.floats(0.01, 3.0), st.floats(0.01, 3.0), st.floats(0.11, 1.3))
def test_all_cells_that_meet_a_polygon_are_touched(angle, width, height, cell):
    outer = tilted(width + 2.0, height + 2.0, angle, at=(-0.7, 0.3))
    polygon = outer.difference(affinity.scale(outer, 0.5, 0.6))
    lattice = Lattice.over(polygon, cell)
    touched = lattice.touched(polygon)
    meets = shapely.intersects(boxes(lattice), polygon).reshape(touched.shape)
    near = shapely.distance(boxes(lattice), polygon).reshape(touched.shape) <= 3.0 * TOUCH_M
    assert (touched >= meets).all()
    assert (touched <= near).all()


@given(st.floats(0.0, 180.0), st.floats(0.01, 3.0), st.floats(0.11, 1.3))
def test_areas_by_cell_are_those_of_shapely(angle, width, cell):
    outer = tilted(width + 2.0, 2.5, angle, at=(-0.7, 0.3))
    polygon = outer.difference(affinity.scale(outer, 0.5, 0.6))
    lattice = Lattice.over(polygon, cell)
    expected = shapely.area(shapely.intersection(boxes(lattice), polygon))
    assert lattice.areas(polygon).ravel() == pytest.approx(expected, abs=1e-9)


def test_areas_of_walls_on_lines_of_the_lattice():
    lattice = Lattice(x0=0.0, y0=0.0, cell_m=1.0, rows=3, columns=3)
    ring = shapely.box(0, 0, 3, 3).difference(shapely.box(1, 1, 2, 2))
    assert lattice.areas(ring).tolist() == [[1, 1, 1], [1, 0, 1], [1, 1, 1]]


def test_parts_without_a_path_between_them_are_infinitely_far():
    two = shapely.MultiPolygon([shapely.box(0, 0, 1, 1), shapely.box(3, 0, 4, 1)])
    lattice = Lattice.over(two, 0.25)
    paths = ShortestPaths(lattice, lattice.touched(two))
    ends = [paths.corners(lattice.cells_at(np.array([[x, 0.5]]))) for x in (0.5, 3.5)]
    assert math.isinf(paths.between(ends)[0, 1])


def test_a_point_on_the_border_of_cells_is_in_all_of_them():
    lattice = Lattice(x0=0.0, y0=0.0, cell_m=1.0, rows=3, columns=3)
    assert np.count_nonzero(lattice.cells_at(np.array([[1.0, 1.0]]))) == 4
    assert np.count_nonzero(lattice.cells_at(np.array([[1.5, 1.5]]))) == 1
