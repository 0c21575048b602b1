"""Rasters: every cell right, whatever the window and its growth."""

import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.polygon_fill import paint_polygon
from multisrt.geometry.grids.raster import OFFSET_X, OFFSET_Y, Raster, eroded
from multisrt.geometry.regions.visibility import visibility_polygon


def views(worlds, name, count, seed=51):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    return [
        visibility_polygon(index, x, y, 4.0)[0]
        for x, y in worlds.viewpoints(free, count, seed=seed)
    ]


def truth(raster, boundary):
    x, y = np.meshgrid(*raster.centres())
    polygon = shapely.Polygon(boundary)
    shapely.prepare(polygon)
    return shapely.contains_xy(polygon, x, y)


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
@pytest.mark.parametrize("cell", [0.1, 0.05])
def test_painted_cells_agree_with_shapely(worlds, name, cell):
    for boundary in views(worlds, name, 8):
        raster = Raster(cell)
        new = raster.paint(boundary)
        expected = truth(raster, boundary)
        assert np.array_equal(raster.cells, expected)
        assert new == np.count_nonzero(expected)


@pytest.mark.parametrize("cell", [0.1, 0.25, 0.5])
def test_walls_on_round_coordinates_pass_no_centre(cell):
    boundary = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.0, 2.0], [1.0, 1.0], [0.0, 1.0]])
    for shift in (0.0, cell / 2, cell / 4):
        raster = Raster(cell)
        raster.paint(boundary + shift)
        assert np.array_equal(raster.cells, truth(raster, boundary + shift))
        for centres in raster.centres():
            share = (centres / (cell / 4)) % 1.0
            assert (np.minimum(share, 1 - share) > 0.05).all()


def test_polygons_that_share_a_border_paint_each_cell_once():
    # The shared borders run through cell centres: every cell there is painted exactly once.
    cells = np.zeros((4, 6), np.bool_)
    left = np.array([[0.0, 0.0], [2.5, 0.0], [2.5, 4.0], [0.0, 4.0]])
    right = np.array([[2.5, 0.0], [6.0, 0.0], [6.0, 4.0], [2.5, 4.0]])
    assert (
        paint_polygon(left, 0.0, 0.0, 1.0, cells) + paint_polygon(right, 0.0, 0.0, 1.0, cells) == 24
    )
    assert cells.all()
    below = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 1.5], [0.0, 1.5]])
    above = np.array([[0.0, 1.5], [6.0, 1.5], [6.0, 4.0], [0.0, 4.0]])
    cells[:] = False
    counts = [paint_polygon(p, 0.0, 0.0, 1.0, cells) for p in (below, above)]
    assert sum(counts) == 24


def test_an_edge_almost_along_a_row_of_centres_paints_nothing_outside():
    # Its ends lie above and below the centres by no more than rounding.
    y0, cell = -0.09741538717342381, 0.1
    centre = y0 + 74.5 * cell
    for below, above in itertools.product(range(-4, 5), repeat=2):
        left, right = (centre + k * math.ulp(centre) for k in (below, above))
        polygon = np.array([[4.6, left], [10.8, right], [12.4, 7.8], [4.6, 7.8]])
        cells = np.zeros((80, 200), np.bool_)
        paint_polygon(polygon, 0.0, y0, cell, cells)
        assert not cells[:74].any()
        assert not cells[74, :46].any()
        assert not cells[74, 108:].any()
        assert cells[75, 46:108].all()


def test_only_new_cells_are_counted(worlds):
    raster = Raster(0.1)
    painted: BaseGeometry = shapely.Polygon()
    for boundary in views(worlds, "office", 25):
        before = np.count_nonzero(raster.cells)
        new = raster.paint(boundary)
        assert np.count_nonzero(raster.cells) == before + new
        assert raster.paint(boundary) == 0
        painted = painted.union(shapely.Polygon(boundary))
    assert raster.area_m2() == pytest.approx(painted.area, rel=0.01)


@pytest.mark.parametrize("name", ["office", "clutter"])
def test_a_raster_that_grew_equals_one_of_fixed_size(worlds, name):
    growing, fixed = Raster(0.1), Raster(0.1, (-1.0, -1.0, 21.0, 21.0))
    window = fixed.cells.shape
    for boundary in views(worlds, name, 25, seed=52):
        assert growing.paint(boundary) == fixed.paint(boundary)
    assert fixed.cells.shape == window
    rows, columns = growing.cells.shape
    dy, dx = growing.row - fixed.row, growing.column - fixed.column
    there = np.zeros_like(fixed.cells)
    for r, c in np.argwhere(growing.cells):
        there[r + dy, c + dx] = True
    assert np.array_equal(there, fixed.cells)
    assert growing.area_m2() == fixed.area_m2()
    assert rows * columns <= 9 * window[0] * window[1]


@given(
    st.lists(
        st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(0.01, 5), st.integers(3, 8)),
        min_size=1,
        max_size=8,
    )
)
def test_growing_in_any_direction_keeps_every_cell(shapes):
    raster = Raster(0.5)
    total = 0
    union: BaseGeometry = shapely.Polygon()
    for x, y, r, n in shapes:
        angles = 0.1 + np.arange(n) * 2 * np.pi / n
        boundary = np.column_stack([x + r * np.cos(angles), y + r * np.sin(angles)])
        new = raster.paint(boundary)
        assert new >= 0
        total += new
        assert np.array_equal(raster.cells | truth(raster, boundary), raster.cells)
        union = union.union(shapely.Polygon(boundary))
    assert np.count_nonzero(raster.cells) == total
    cx, cy = np.meshgrid(*raster.centres())
    assert not raster.cells[~shapely.contains_xy(union.buffer(1e-9), cx, cy)].any()


def test_polygons_outside_the_grid_paint_nothing():
    cells = np.zeros((5, 5), np.bool_)
    for shift in ((-20.0, 0.0), (20.0, 0.0), (0.0, -20.0), (0.0, 20.0)):
        boundary = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]]) + shift
        assert paint_polygon(boundary, 0.0, 0.0, 1.0, cells) == 0
    over = np.array([[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]])
    assert paint_polygon(over, 0.0, 0.0, 1.0, cells) == 25


def test_lattice_depends_on_the_cell_alone():
    a = Raster(0.1, (0.0, 0.0, 1.0, 1.0))
    b = Raster(0.1, (-7.31, 3.07, 2.0, 9.0))
    assert a.x0 - b.x0 == pytest.approx(0.1 * round((a.x0 - b.x0) / 0.1))
    assert a.x0 / 0.1 + OFFSET_X == pytest.approx(round(a.x0 / 0.1 + OFFSET_X))
    assert a.y0 / 0.1 + OFFSET_Y == pytest.approx(round(a.y0 / 0.1 + OFFSET_Y))


@given(
    st.sampled_from([0.05, 0.1, 0.25, 0.5]),
    st.tuples(st.integers(-5, 5), st.integers(-5, 5)).filter(lambda slope: slope != (0, 0)),
    st.tuples(st.integers(-200, 200), st.integers(-200, 200)),
    st.sampled_from([1, 2, 4, 5, 10]),
    st.sampled_from([0.05, 0.1, 0.25, 0.5, 1.0]),
)
def test_no_centre_lies_on_a_wall_through_round_coordinates(cell, slope, corner, part, unit):
    # The wall goes through a corner that is a multiple of a unit, or of a part of a cell.
    p, q = slope
    x, y = np.array(corner) * (cell / part if part > 1 else unit)
    i, j = np.mgrid[-60:60, -60:60] + 0.5
    away = p * ((i - OFFSET_X) * cell - x) + q * ((j - OFFSET_Y) * cell - y)
    assert np.abs(away).min() / np.hypot(p, q) > 2e-4 * cell


@pytest.mark.parametrize("cell", [0.05, 0.1])
def test_a_diamond_on_round_coordinates_is_counted_to_a_thousandth(cell):
    raster = Raster(cell)
    raster.paint(np.array([(0.0, -10.0), (10.0, 0.0), (0.0, 10.0), (-10.0, 0.0)]))
    assert raster.area_m2() == pytest.approx(200.0, rel=1e-3)


def test_the_window_holds_its_bounds():
    raster = Raster(0.3, (-1.0, 2.0, 4.0, 5.0))
    rows, columns = raster.cells.shape
    assert raster.x0 <= -1.0 < raster.x0 + 0.3
    assert raster.y0 <= 2.0 < raster.y0 + 0.3
    assert raster.x0 + columns * 0.3 - 0.3 <= 4.0 <= raster.x0 + columns * 0.3
    assert raster.y0 + rows * 0.3 - 0.3 <= 5.0 <= raster.y0 + rows * 0.3


def test_painted_cells_in_utm_coordinates_are_right(worlds):
    # The lattice lies differently under the moved polygon, so it is compared with shapely.
    for boundary in views(worlds, "office", 4):
        raster = Raster(0.1)
        moved = boundary + np.array([5e5, 4.5e6])
        raster.paint(moved)
        assert np.array_equal(raster.cells, truth(raster, moved))


@pytest.mark.parametrize("cell", [0.0, -0.1, np.nan, np.inf])
def test_refuses_cells_without_a_width(cell):
    with pytest.raises(InvalidInputError, match="positive width"):
        Raster(cell)


def test_refuses_to_grow_beyond_the_limit():
    raster = Raster(0.01)
    raster.paint(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    with pytest.raises(InvalidInputError, match=r"choose cells wider than 0\.01 m"):
        raster.paint(np.array([[1e4, 1e4], [1e4 + 1, 1e4], [1e4, 1e4 + 1]]))
    # The refusal has changed nothing.
    assert raster.area_m2() == pytest.approx(0.5, rel=0.03)


@given(
    st.integers(0, 100_000),
    st.sampled_from([0.0, 1.0, 2**0.5, 2.0, 5**0.5, 5.0]) | st.floats(0.0, 9.0),
)
def test_erosion_agrees_with_a_distance_transform(seed, radius):
    rng = np.random.default_rng(seed)
    cells = rng.random(rng.integers(1, 30, 2)) < rng.choice([0.5, 0.9, 0.99, 1.0])
    off_border = distance_transform_edt(np.pad(cells, 1))[1:-1, 1:-1]
    np.testing.assert_array_equal(eroded(cells, radius), cells & (off_border >= radius))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e19, -1e300])
@pytest.mark.parametrize("corner", range(4))
@pytest.mark.parametrize("axis", range(2))
def test_refuses_corners_that_are_not_finite(bad, corner, axis):
    raster = Raster(0.1, (0.0, 0.0, 2.0, 2.0))
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    raster.paint(square)
    before = raster.cells.copy()
    square[corner, axis] = bad
    with pytest.raises(InvalidInputError, match="finite numbers of metres"):
        raster.paint(square)
    np.testing.assert_array_equal(raster.cells, before)
