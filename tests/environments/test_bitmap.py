import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy import ndimage
from shapely import MultiPolygon

from multisrt.environments import Environment
from multisrt.environments.formats import bitmap
from multisrt.environments.formats.bitmap import polygons_between_lines, polygons_from_grid
from multisrt.geometry.errors import InvalidInputError


def grid(*rows):
    """A grid drawn with '.' for free cells, its first row at the top."""
    return np.array([[sign == "." for sign in row] for row in rows])[::-1]


def cell_boxes(free):
    rows, columns = np.nonzero(free)
    return shapely.union_all(shapely.box(columns, rows, columns + 1, rows + 1))


def rings(polygons):
    return [
        shapely.LineString(ring.coords)
        for part in polygons.geoms
        for ring in (part.exterior, *part.interiors)
    ]


grids = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=12))
tolerances = st.sampled_from([0.0, 0.25, 0.45, 0.49])


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(free=grids, scale=st.integers(1, 3), tolerance=tolerances)
def test_topology_and_places_are_kept(free, scale, tolerance):
    free = free.repeat(scale, axis=0)
    polygons = polygons_from_grid(free, 1.0, tolerance_cells=tolerance)
    assert polygons.is_valid
    assert len(polygons.geoms) == ndimage.label(free)[1]
    outside = np.pad(~free, 1, constant_values=True)
    holes = sum(len(part.interiors) for part in polygons.geoms)
    assert holes == ndimage.label(outside, np.ones((3, 3)))[1] - 1
    rows, columns = np.nonzero(free)
    assert shapely.contains_xy(polygons, columns + 0.5, rows + 0.5).all()
    rows, columns = np.nonzero(~free)
    assert not shapely.intersects_xy(polygons, columns + 0.5, rows + 0.5).any()


def borders(free):
    """Middles of the borders between free and other cells, and the way out of free space."""
    padded = np.pad(free, 1)
    for row, column in np.argwhere(padded):
        for up, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            if not padded[row + up, column + right]:
                yield column - 0.5 + right / 2, row - 0.5 + up / 2, right, up


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(
    free=grids.filter(np.any),
    scales=st.tuples(st.integers(1, 4), st.integers(1, 4)),
    tolerance=tolerances,
)
def test_every_border_is_passed_within_the_tolerance(free, scales, tolerance):
    free = free.repeat(scales[0], axis=0).repeat(scales[1], axis=1)
    polygons = polygons_from_grid(free, 1.0, tolerance_cells=tolerance)
    x, y, right, up = np.array(list(borders(free))).T
    reach = tolerance + 1e-9
    assert shapely.contains_xy(polygons, x - reach * right, y - reach * up).all()
    assert not shapely.intersects_xy(polygons, x + reach * right, y + reach * up).any()


@settings(max_examples=60, deadline=None)
@given(free=grids.filter(np.any), tolerance=tolerances)
def test_boundary_and_area_stay_within_the_tolerance(free, tolerance):
    polygons = polygons_from_grid(free, 1.0, tolerance_cells=tolerance)
    boxes = cell_boxes(free)
    reach = math.hypot(0.5, tolerance) + 1e-9
    apart = shapely.hausdorff_distance(polygons.boundary, boxes.boundary, densify=0.05)
    assert apart <= reach < 1
    # A cell's side sweeps at most a window's width; a pinch costs two cut corners.
    assert abs(polygons.area - free.sum()) <= (tolerance + 0.125) * boxes.boundary.length


@settings(max_examples=60, deadline=None)
@given(free=grids.filter(np.any), tolerance=tolerances)
def test_rings_keep_their_distance(free, tolerance):
    lines = rings(polygons_from_grid(free, 1.0, tolerance_cells=tolerance))
    least = min((1 - 2 * tolerance) / math.sqrt(2), 0.25 * math.sqrt(2)) - 1e-9
    for number, line in enumerate(lines):
        others = lines[number + 1 :]
        assert not others or shapely.distance(line, np.array(others)).min() >= least


def test_rectangles_stay_exact():
    polygons = polygons_from_grid(grid("......", ".##...", ".##...", "......"), 0.5)
    outline = shapely.box(0, 0, 3, 2) - shapely.box(0.5, 0.5, 1.5, 1.5)
    assert polygons.equals(outline)
    assert shapely.get_num_coordinates(polygons) == 5 + 5


def test_single_cells_stay_squares():
    polygons = polygons_from_grid(grid("...", ".#.", "..."), 1.0)
    assert polygons.equals(shapely.box(0, 0, 3, 3) - shapely.box(1, 1, 2, 2))
    assert polygons_from_grid(grid("."), 2.0).equals(shapely.box(0, 0, 2, 2))


def test_cells_have_a_width_and_a_height():
    polygons = polygons_from_grid(grid("......", ".##...", ".##...", "......"), (0.5, 0.2))
    outline = shapely.box(0, 0, 3, 0.8) - shapely.box(0.5, 0.2, 1.5, 0.6)
    assert shapely.equals_exact(
        polygons.normalize(), MultiPolygon(shapely.get_parts(outline).tolist()).normalize(), 1e-12
    )


@settings(max_examples=60, deadline=None)
@given(
    free=grids,
    sides=st.tuples(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3)),
    tolerance=tolerances,
)
def test_walls_are_chosen_in_cells_whatever_their_sides(free, sides, tolerance):
    square = polygons_from_grid(free, 1.0, tolerance_cells=tolerance)
    stretched = polygons_from_grid(free, sides, tolerance_cells=tolerance)
    assert stretched.is_valid
    np.testing.assert_allclose(
        shapely.get_coordinates(stretched), shapely.get_coordinates(square) * sides, rtol=1e-12
    )


@given(free=grids, side=st.floats(1e-3, 1e3))
def test_equal_sides_give_the_bytes_of_square_cells(free, side):
    square, pair = polygons_from_grid(free, side), polygons_from_grid(free, (side, side))
    assert shapely.to_wkb(square) == shapely.to_wkb(pair)


def test_row_zero_is_the_lowest():
    polygons = polygons_from_grid(np.array([[True, True], [True, False]]), 1.0)
    assert polygons.contains(shapely.Point(1.5, 0.5))
    assert not polygons.contains(shapely.Point(1.5, 1.5))


def test_walls_and_doors_of_one_cell_survive():
    wall = grid("...#...", "...#...", "...#...")
    assert polygons_from_grid(wall, 1.0).equals(shapely.box(0, 0, 3, 3) | shapely.box(4, 0, 7, 3))
    door = grid("...#...", ".......", "...#...")
    (one,) = polygons_from_grid(door, 1.0).geoms
    assert one.contains(shapely.LineString([(1, 1.5), (6, 1.5)]))


def test_nothing_slips_through_a_diagonal_wall():
    polygons = polygons_from_grid(~np.eye(20, dtype=bool), 1.0)
    above, below = polygons.geoms
    assert above.distance(below) > 0.5
    assert not polygons.intersects(shapely.LineString([(0.5, 0.5), (19.5, 19.5)]))


def test_checkerboard_cells_are_components_of_their_own():
    free = np.indices((6, 6)).sum(axis=0) % 2 == 0
    polygons = polygons_from_grid(free, 1.0)
    assert len(polygons.geoms) == 18
    cells = list(polygons.geoms)
    assert len(shapely.STRtree(cells).query(cells, predicate="intersects").T) == 18


@pytest.mark.parametrize("slope", [1.0, 0.5, 0.29, -0.7])
def test_staircases_of_slanted_walls_become_straight(slope):
    rows, columns = np.mgrid[:100, :100]
    free = rows + 0.5 > 50 + slope * (columns + 0.5 - 50)
    (part,) = polygons_from_grid(free, 1.0).geoms
    assert len(part.exterior.coords) - 1 <= 10
    assert shapely.get_num_coordinates(cell_boxes(free).simplify(0)) > 50
    assert part.area == pytest.approx(free.sum(), rel=0.005)
    wall = shapely.LineString([(2, 50 - 48 * slope), (98, 50 + 48 * slope)])
    inside = wall.intersection(shapely.box(1, 1, 99, 99))
    assert all(part.boundary.distance(shapely.Point(p)) < 0.75 for p in inside.coords)


def test_disc_is_round_with_few_edges():
    rows, columns = np.mgrid[:81, :81]
    free = np.hypot(rows - 40, columns - 40) < 36
    (part,) = polygons_from_grid(free, 1.0).geoms
    assert len(part.exterior.coords) < 60
    assert part.area == pytest.approx(math.pi * 36**2, rel=0.01)
    assert part.hausdorff_distance(shapely.Point(40.5, 40.5).buffer(36)) < 1


def test_only_a_stepped_diagonal_corridor_is_free_passage():
    diagonal = np.eye(8, dtype=bool)
    assert len(polygons_from_grid(diagonal, 1.0).geoms) == 8
    stepped = diagonal | np.eye(8, k=1, dtype=bool)
    (part,) = polygons_from_grid(stepped, 1.0).geoms
    assert part.buffer(-0.2).geom_type == "Polygon"


def test_environment_takes_the_result():
    free = np.ones((20, 20), dtype=bool)
    free[5:15, 8] = False
    world = Environment("walled", polygons_from_grid(free, 0.05))
    assert world.area_m2 == pytest.approx(390 * 0.05**2)
    assert len(world.edges) == 8


def test_same_grid_same_polygons():
    free = np.random.default_rng(7).random((40, 50)) < 0.7
    first, second = (polygons_from_grid(free, 0.1) for _ in range(2))
    assert shapely.to_wkb(first) == shapely.to_wkb(second)


def test_no_free_cell_gives_an_empty_geometry():
    assert polygons_from_grid(np.zeros((3, 4), dtype=bool), 1.0).is_empty
    assert polygons_from_grid(np.zeros((0, 4), dtype=bool), 1.0).is_empty


@pytest.mark.parametrize(
    ("cells", "resolution", "tolerance", "message"),
    [
        (np.ones(4, dtype=bool), 1.0, 0.45, r"shape \(4,\)"),
        (np.ones((2, 2), dtype=bool), 0.0, 0.45, "resolution_m is 0"),
        (np.ones((2, 2), dtype=bool), math.nan, 0.45, "resolution_m is nan"),
        (np.ones((2, 2), dtype=bool), 1e308, 0.45, "resolution_m is 1e.308; .* to 1e.07, or two"),
        (np.ones((2, 2), dtype=bool), (1e-300, 1.0), 0.45, "resolution_m is .*from 1e-06 to"),
        (np.ones((2, 2), dtype=bool), (1.0, 0.0), 0.45, r"resolution_m is \(1.0, 0.0\)"),
        (np.ones((2, 2), dtype=bool), (1.0, math.inf), 0.45, r"resolution_m is \(1.0, inf\)"),
        (np.ones((2, 2), dtype=bool), (1.0, 1.0, 1.0), 0.45, "or two, along x and along y"),
        (np.ones((2, 2), dtype=bool), 1.0, 0.5, "tolerance_cells is 0.5"),
        (np.ones((2, 2), dtype=bool), 1.0, math.nan, "tolerance_cells is nan"),
    ],
)
def test_bad_arguments_are_named(cells, resolution, tolerance, message):
    with pytest.raises(InvalidInputError, match=message):
        polygons_from_grid(cells, resolution, tolerance_cells=tolerance)


def test_noise_is_refused(monkeypatch):
    monkeypatch.setattr(bitmap, "MAX_CORNERS", 1000)
    noise = np.random.default_rng(1).random((100, 100)) < 0.5
    with pytest.raises(InvalidInputError, match="noise or a photograph"):
        polygons_from_grid(noise, 1.0)


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(free=grids, seed=st.integers(0, 99))
def test_cells_between_uneven_lines_are_united(free, seed):
    rng = np.random.default_rng(seed)
    x, y = (np.cumsum(rng.integers(1, 5, size + 1)).astype(float) for size in free.shape[::-1])
    row, column = np.nonzero(free)
    boxes = shapely.box(x[column], y[row], x[column + 1], y[row + 1])
    corners = np.pad(free, 1)
    one, other = corners[:-1, :-1], corners[1:, :-1]
    across, over = corners[1:, 1:], corners[:-1, 1:]
    if ((one == across) & (other == over) & (one != other)).any():
        with pytest.raises(InvalidInputError, match="touch only at the corner"):
            polygons_between_lines(free, x, y)
        return
    united = polygons_between_lines(free, x, y)
    assert united.is_valid
    assert united.equals(shapely.union_all(boxes))
    assert len(united.geoms) == ndimage.label(free)[1]
