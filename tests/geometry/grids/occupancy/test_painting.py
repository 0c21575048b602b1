"""Painting: every cell right, whatever the order, and no way through walls."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage
from shapely import affinity, box

from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, UNKNOWN, Occupancy
from multisrt.geometry.grids.raster import OFFSET_X, OFFSET_Y, Raster
from multisrt.geometry.regions.boundary import GAP, OBSTACLE


@pytest.mark.slow
def test_cells_agree_with_shapely(worlds, views, seen):
    name, options = views
    regions = seen.regions_of(worlds, name, 7, **options)
    occupancy = Occupancy(0.1, 0.23)
    new = sum(occupancy.add(region) for region in regions)
    assert new == np.count_nonzero(occupancy.cells)
    points = seen.centres(occupancy)

    inside = np.zeros(len(points), bool)
    for region in regions:
        polygon = region.polygon()
        shapely.prepare(polygon)
        inside |= shapely.contains_xy(polygon, points)
    walls = shapely.STRtree(seen.surfaces(regions))
    squares = shapely.box(*(points - 0.05).T, *(points + 0.05).T)
    touched = np.zeros(len(points), bool)
    touched[walls.query(squares, predicate="intersects")[0]] = True
    surely = np.zeros(len(points), bool)
    smaller = shapely.box(*(points - 0.05 + 1e-9).T, *(points + 0.05 - 1e-9).T)
    surely[walls.query(smaller, predicate="intersects")[0]] = True

    cells = occupancy.cells.ravel()
    assert (cells[surely] == OCCUPIED).all()
    assert touched[cells == OCCUPIED].all()
    assert (cells[~touched] == np.where(inside, FREE, UNKNOWN)[~touched]).all()

    (which, _), distance = walls.query_nearest(
        shapely.points(points), return_distance=True, all_matches=False
    )
    nearest = np.empty(len(points))
    nearest[which] = distance
    clear = np.abs(nearest - 0.23) > 1e-9
    expected = (cells == FREE) & (nearest >= 0.23)
    assert np.array_equal(occupancy.passable.ravel()[clear], expected[clear])
    assert expected.any()


@pytest.mark.slow
def test_order_and_repetition_do_not_matter(worlds, views, seen):
    name, options = views
    regions = seen.regions_of(worlds, name, 16, seed=62, **options)
    expected = None
    for seed in range(4):
        order = np.random.default_rng(seed).permutation(16).tolist()
        # One starts with a window for all regions, the others grow theirs.
        occupancy = Occupancy(0.1, 0.2, None if seed else (-3.0, -3.0, 25.0, 25.0))
        for k in order + order[:5]:
            occupancy.add(regions[k])
            if seed % 2:
                occupancy.frontier_groups()
        expected = expected or seen.knowledge(occupancy)
        assert seen.knowledge(occupancy) == expected


@pytest.mark.parametrize("angle", [0.0, 17.0, 45.0, 88.0])
@pytest.mark.parametrize("size", [(3.0, 2.0), (2.43, 4.71)])
def test_a_closed_room_has_no_frontier(worlds, angle, size, seen):
    room = affinity.rotate(box(0, 0, *size), angle)
    index = worlds.index(room, 8.0)
    places = worlds.viewpoints(room, 3, clearance=0.25)
    for place in places:
        occupancy = Occupancy(0.1, 0.2)
        occupancy.add(*seen.seen_from(index, [place], range_m=8.0))
        assert occupancy.frontier_groups(0.0) == []
        assert np.count_nonzero(occupancy.cells == FREE) * 0.01 > 0.8 * room.area
    # With a range too short to see all of it there is a frontier.
    occupancy.add(*seen.seen_from(index, [places[0]], range_m=1.0))
    short = Occupancy(0.1, 0.2)
    short.add(*seen.seen_from(index, [places[0]], range_m=1.0))
    assert short.frontier_groups()
    assert occupancy.frontier_groups(0.0) == []


@pytest.mark.parametrize("name", ["rooms", "office", "clutter", "crates"])
@pytest.mark.parametrize("beams", [None, 360])
def test_visiting_all_targets_explores_everything(worlds, name, beams, seen):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    occupancy = Occupancy(0.1, 0.2)
    place = worlds.viewpoints(free, 1, clearance=0.3)[0]
    for _ in range(150):
        occupancy.add(*seen.seen_from(index, [place], beams=beams))
        targets = [g.target for g in occupancy.frontier_groups() if g.target]
        if not targets:
            break
        # All unknown cells at a target are seen from it.
        assert occupancy.cell_of(*place) not in targets
        place = occupancy.centre_of(*targets[0])
    assert targets == []
    # But for slivers, no passable cell is beside an unknown one.
    assert np.count_nonzero(seen.frontier(occupancy) & occupancy.passable) < 20
    standing = free.buffer(-0.35)
    shapely.prepare(standing)
    places = seen.centres(occupancy)[shapely.contains_xy(standing, seen.centres(occupancy))]
    found = occupancy.passable[occupancy.indices_of(occupancy.cells_of(places))]
    assert np.mean(found) > 0.97


@given(
    st.tuples(st.floats(-9, 9), st.floats(-9, 9)),
    st.tuples(st.floats(-9, 9), st.floats(-9, 9)),
    st.booleans(),
)
def test_the_cells_of_a_wall_are_four_connected(seen, a, b, on_lattice):
    cell = 0.5
    if on_lattice:
        a, b = ((np.round(p) - (OFFSET_X, OFFSET_Y)) * cell for p in (a, b))
    cells = []
    for corners in ((a, b), (b, a)):
        occupancy = Occupancy(cell, 0.5, (-12.0, -12.0, 12.0, 12.0))
        occupancy.add(seen.hand_made([*corners, corners[1]], [OBSTACLE, GAP, GAP]))
        cells.append(occupancy.cells)
    one_way, other_way = cells
    assert np.array_equal(one_way, other_way)
    wall = one_way == OCCUPIED
    assert ndimage.label(wall)[1] == 1
    for end in (a, b):
        row, column = occupancy.cell_of(*end)
        assert wall[occupancy.indices_of([(row, column)])].all()


def test_occupied_wins_in_either_order_and_is_never_passable(seen):
    free, wall = (
        seen.rectangle(0, 0, 4, 4),
        seen.hand_made([(1, 2), (3, 2), (2, 2.5)], [OBSTACLE, GAP, GAP]),
    )
    for regions in ((free, wall), (wall, free)):
        occupancy = Occupancy(0.1, 0.05)
        for region in regions:
            occupancy.add(region)
        at = occupancy.indices_of([occupancy.cell_of(2.0, 2.0)])
        assert occupancy.cells[at] == OCCUPIED
        assert not occupancy.passable[at].any()
    # A free cell that becomes occupied is a change, but not a new cell.
    occupancy = Occupancy(0.1, 0.05)
    occupancy.add(free)
    assert occupancy.add(wall) == 0
    assert occupancy.revision == 2


def test_free_cells_are_painted_in_a_raster_of_equal_cells(worlds, seen):
    occupancy, raster = Occupancy(0.1, 0.2), Raster(0.1)
    for region in seen.regions_of(worlds, "crates", 12):
        occupancy.add(region)
        raster.paint(region.boundary)
    painted = seen.in_lattice(raster, np.argwhere(raster.cells))
    assert (occupancy.cells[occupancy.indices_of(painted)] != UNKNOWN).all()
    free = seen.in_lattice(occupancy, np.argwhere(occupancy.cells == FREE))
    assert {*map(tuple, free.tolist())} <= {*map(tuple, painted.tolist())}
