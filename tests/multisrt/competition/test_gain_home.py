import numpy as np
import pytest

from multisrt.competition.gain_home import nearer_to
from multisrt.competition.grid_kernels import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    Rules,
    Sights,
    Targets,
    areas_after,
    areas_in_sight,
    best_tour,
    blocks_in_sight,
    border_pieces,
    descend,
    field_from,
    passable_cells,
    path_lengths_between,
    unknown_blocks,
    with_walls,
    zone,
)
from multisrt.competition.rules import unknown_in_sight


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


def test_unknown_area_in_sight_is_counted_in_blocks():
    grid = np.full((200, 200), UNKNOWN, np.int8)
    grid[:, 101:103] = OCCUPIED
    areas = unknown_blocks(grid, 0)
    assert areas.sum() == (grid == UNKNOWN).sum()
    targets = np.array([[100, 100], [100, 103]])
    first, blocks = blocks_in_sight(grid, targets, 60.0, 0)
    seen = areas_in_sight(areas, first, blocks)
    half = np.pi * 60.0**2 / 2
    assert np.all(np.abs(seen / half - 1.0) < 0.1)
    columns = blocks % 50
    assert columns[first[0] : first[1]].max() <= 25
    assert columns[first[1] : first[2]].min() >= 25


def test_path_lengths_between_targets_are_those_of_cells():
    passable = np.ones((40, 60), bool)
    passable[:30, 28:31] = False
    targets = np.array([[2, 2], [2, 56], [36, 30]])
    lengths = path_lengths_between(passable, targets)
    for k, (row, column) in enumerate(targets):
        exact = ways_from(passable, row, column)[targets[:, 0], targets[:, 1]]
        assert np.abs(lengths[k] - exact).max() <= 4
    passable[:, 28:31] = False
    assert np.isinf(path_lengths_between(passable, targets[:2])[0, 1])


PLAIN = Rules(horizon=100.0, power=1.0, nearest=1.0, homeward=0.0, least_area=1.0)


def sights_of(areas, *seen):
    first = np.concatenate(([0], np.cumsum([len(blocks) for blocks in seen])))
    return Sights(np.array(areas, float), first, np.concatenate(seen).astype(np.int64))


def targets_at(*places, home=0.0):
    """Return targets on a line, with the robot and its home at 0; 30 cells are 10 steps."""
    at = np.array(places, float)
    ones = np.ones(len(at))
    return Targets(ones, np.abs(at), np.abs(at) + home, np.abs(at[:, None] - at[None]), ones)


def test_a_tour_takes_what_is_on_its_way_first():
    sights = sights_of([100.0, 40.0], [0], [1])
    tour, times = best_tour(sights, targets_at(60.0, 30.0), 1000.0, PLAIN)
    assert tour.tolist() == [1, 0]
    assert times.tolist() == [10.0, 20.0]


def test_what_was_in_sight_before_is_not_worth_a_way():
    sights = sights_of([100.0, 40.0], [0, 1], [1])
    tour, _ = best_tour(sights, targets_at(30.0, 60.0), 1000.0, PLAIN)
    assert tour.tolist() == [0]


def test_a_tour_is_home_in_time():
    sights = sights_of([100.0, 100.0], [0], [1])
    on_two_sides = targets_at(30.0, -30.0)
    assert len(best_tour(sights, on_two_sides, 40.0, PLAIN)[0]) == 2
    assert len(best_tour(sights, on_two_sides, 39.0, PLAIN)[0]) == 1


def test_the_way_home_counts_as_the_time_ends():
    sights = sights_of([110.0, 100.0], [0], [1])
    targets = targets_at(60.0, -60.0)._replace(home=np.array([90.0, 0.0]))
    homeward = PLAIN._replace(homeward=1.0, least_area=200.0)
    assert best_tour(sights, targets, 60.0, homeward)[0].tolist() == [1]
    assert best_tour(sights, targets, 6000.0, homeward)[0].tolist() == [0]


def test_out_of_reach_is_no_tour():
    targets = targets_at(30.0)._replace(start=np.array([np.inf]))
    assert len(best_tour(sights_of([9.0], [0]), targets, 100.0, PLAIN)[0]) == 0


def test_a_claim_is_weaker_the_later_it_comes():
    sights = sights_of([100.0, 100.0, 100.0], [0, 1], [1], [2])
    left = areas_after(sights, np.array([0, 1]), np.array([0.0, 75.0]), 75.0, 0.9)
    assert left.tolist() == pytest.approx([10.0, 10.0, 100.0])
    left = areas_after(sights, np.array([2]), np.array([75.0]), 75.0, 0.9)
    assert left[2] == pytest.approx(100.0 * (1.0 - 0.9 / np.e))


def test_targets_nearer_to_others_count_less():
    costs = np.array([[10.0, 100.0, np.inf, 50.0], [100.0, 10.0, 5.0, 50.0]])
    shares = nearer_to(costs, 0.4)
    assert shares.tolist() == [[1.0, 0.4, 1.0, 1.0], [0.4, 1.0, 1.0, 1.0]]
