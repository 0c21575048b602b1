import numpy as np

from multisrt.competition.grid_kernels import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    border_pieces,
    descend,
    field_from,
    passable_cells,
    unknown_in_sight,
    with_walls,
    zone,
)


def states(*rows):
    signs = {".": FREE, "?": UNKNOWN, "#": OCCUPIED}
    return np.array([[signs[sign] for sign in row] for row in rows], np.int8)


def ways_from(passable, row, column):
    queue = np.empty(passable.size, np.int64)
    return field_from(passable, np.array([row]), np.array([column]), queue)


def test_robots_keep_away_from_what_is_not_known():
    grid = states("......", "......", "......", ".....?", "..#...", "......")
    found = passable_cells(grid)
    assert np.argwhere(found).tolist() == [[1, 1], [1, 2], [1, 3], [1, 4], [2, 1], [2, 2], [2, 3]]


def test_ways_count_cells_and_lead_back():
    passable = np.ones((7, 9), bool)
    passable[:6, 4] = False
    ways = ways_from(passable, 0, 0)
    assert ways[0, 8] == 6 + 8 + 6
    assert ways[0, 4] == -1
    row, column = descend(ways, 0, 8, 3)
    assert ways[row, column] == 17
    assert descend(ways, 0, 8, 99) == (0, 0)


def test_short_gaps_between_walls_are_walls():
    grid = states("#???#", "#?.?#", "?????", "#???#")
    filled = with_walls(grid, 3)
    assert (filled[0] == OCCUPIED).all()
    assert filled[1].tolist() == grid[1].tolist()
    assert filled[2].tolist() == [OCCUPIED, UNKNOWN, UNKNOWN, UNKNOWN, OCCUPIED]
    assert (with_walls(grid, 2)[0] == grid[0]).all()


def test_the_area_in_sight_is_that_of_a_disc():
    grid = np.full((201, 201), UNKNOWN, np.int8)
    (area,) = unknown_in_sight(grid, np.array([[100, 100]]), 60.0, 0)
    assert abs(area / (np.pi * 60.0**2) - 1.0) < 0.05
    grid[:, 101] = OCCUPIED
    (half,) = unknown_in_sight(grid, np.array([[100, 100]]), 60.0, 0)
    assert abs(half / area - 0.5) < 0.05


def test_borders_are_cut_into_pieces_of_their_width():
    grid = np.full((40, 80), FREE, np.int8)
    grid[20:] = UNKNOWN
    ways = ways_from(passable_cells(grid), 5, 5)
    queue = np.empty(grid.size, np.int64)
    pieces = border_pieces(grid, ways, 12, 6, 0, queue)
    assert 3 <= len(pieces) <= 7
    assert (ways[pieces[:, 0], pieces[:, 1]] >= 0).all()
    assert (pieces[:, 0] == 18).all()
    assert len(border_pieces(grid, ways, 12, 81, 0, queue)) == 0


def test_home_is_where_few_enough_walls_are_between():
    grid = np.full((41, 41), FREE, np.int8)
    grid[:, 20:23] = OCCUPIED
    ways = np.zeros(grid.shape, np.int32)
    everywhere = set(map(tuple, np.stack(zone(grid, ways, (20, 5), (40, 8.5, 3.5)), 1).tolist()))
    assert (20, 40) in everywhere
    near = set(map(tuple, np.stack(zone(grid, ways, (20, 5), (40, 2.5, 3.5)), 1).tolist()))
    assert (20, 19) in near
    assert (20, 24) not in near
