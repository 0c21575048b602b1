import numpy as np
import pytest

from multisrt.competition.frontier_policies import visible_unknown_areas
from multisrt.competition.gain_home import nearness_shares
from multisrt.competition.grid_kernels import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    Targets,
    TourParameters,
    Visibility,
    best_tour,
    contact_zone,
    descend,
    distance_field,
    frontier_segments,
    passable_cells,
    path_lengths_between,
    unclaimed_areas,
    unknown_area_of_blocks,
    visible_areas,
    visible_blocks,
    with_filled_walls,
)


def states(*rows):
    signs = {".": FREE, "?": UNKNOWN, "#": OCCUPIED}
    return np.array([[signs[sign] for sign in row] for row in rows], np.int8)


def distances_from(passable, row, column):
    queue = np.empty(passable.size, np.int64)
    return distance_field(passable, np.array([row]), np.array([column]), queue)


def test_robots_keep_away_from_what_is_not_known():
    grid = states("......", "......", "......", ".....?", "..#...", "......")
    found = passable_cells(grid)
    assert np.argwhere(found).tolist() == [[1, 1], [1, 2], [1, 3], [1, 4], [2, 1], [2, 2], [2, 3]]


def test_distance_fields_count_steps_and_lead_back():
    passable = np.ones((7, 9), bool)
    passable[:6, 4] = False
    distances = distances_from(passable, 0, 0)
    assert distances[0, 8] == 6 + 8 + 6
    assert distances[0, 4] == -1
    row, column = descend(distances, 0, 8, 3)
    assert distances[row, column] == 17
    assert descend(distances, 0, 8, 99) == (0, 0)


def test_short_gaps_between_walls_are_walls():
    grid = states("#???#", "#?.?#", "?????", "#???#")
    filled = with_filled_walls(grid, 3)
    assert (filled[0] == OCCUPIED).all()
    assert filled[1].tolist() == grid[1].tolist()
    assert filled[2].tolist() == [OCCUPIED, UNKNOWN, UNKNOWN, UNKNOWN, OCCUPIED]
    assert (with_filled_walls(grid, 2)[0] == grid[0]).all()


def test_the_area_in_sight_is_that_of_a_disc():
    grid = np.full((201, 201), UNKNOWN, np.int8)
    (area,) = visible_unknown_areas(grid, np.array([[100, 100]]), 60.0, 0)
    assert abs(area / (np.pi * 60.0**2) - 1.0) < 0.05
    grid[:, 101] = OCCUPIED
    (half,) = visible_unknown_areas(grid, np.array([[100, 100]]), 60.0, 0)
    assert abs(half / area - 0.5) < 0.05


def test_frontiers_are_cut_into_segments_of_their_width():
    grid = np.full((40, 80), FREE, np.int8)
    grid[20:] = UNKNOWN
    distances = distances_from(passable_cells(grid), 5, 5)
    queue = np.empty(grid.size, np.int64)
    targets = frontier_segments(grid, distances, 12, 6, 0, queue)
    assert 3 <= len(targets) <= 7
    assert (distances[targets[:, 0], targets[:, 1]] >= 0).all()
    assert (targets[:, 0] == 18).all()
    assert len(frontier_segments(grid, distances, 12, 81, 0, queue)) == 0


def test_home_is_where_few_enough_walls_are_between():
    grid = np.full((41, 41), FREE, np.int8)
    grid[:, 20:23] = OCCUPIED
    distances = np.zeros(grid.shape, np.int32)

    def cells(link):
        return set(zip(*contact_zone(grid, distances, (20, 5), link), strict=True))

    everywhere = cells((40, 8.5, 3.5))
    assert (20, 40) in everywhere
    near = cells((40, 2.5, 3.5))
    assert (20, 19) in near
    assert (20, 24) not in near


def test_unknown_area_in_sight_is_counted_in_blocks():
    grid = np.full((200, 200), UNKNOWN, np.int8)
    grid[:, 101:103] = OCCUPIED
    areas = unknown_area_of_blocks(grid, 0)
    assert areas.sum() == (grid == UNKNOWN).sum()
    targets = np.array([[100, 100], [100, 103]])
    first, blocks = visible_blocks(grid, targets, 60.0, 0)
    seen = visible_areas(areas, first, blocks)
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
        exact = distances_from(passable, row, column)[targets[:, 0], targets[:, 1]]
        assert np.abs(lengths[k] - exact).max() <= 4
    passable[:, 28:31] = False
    assert np.isinf(path_lengths_between(passable, targets[:2])[0, 1])


PLAIN = TourParameters(
    horizon=100.0, power=1.0, length_offset=1.0, homeward_weight=0.0, min_area=1.0
)


def visibility_of(areas, *seen):
    first = np.concatenate(([0], np.cumsum([len(blocks) for blocks in seen])))
    return Visibility(np.array(areas, float), first, np.concatenate(seen).astype(np.int64))


def targets_at(*places, home=0.0):
    """Return targets on a line, with the robot and its home at 0; 30 cells are 10 steps."""
    at = np.array(places, float)
    ones = np.ones(len(at))
    return Targets(ones, np.abs(at), np.abs(at) + home, np.abs(at[:, None] - at[None]), ones)


def test_a_tour_takes_what_is_on_its_path_first():
    visibility = visibility_of([100.0, 40.0], [0], [1])
    tour, times = best_tour(visibility, targets_at(60.0, 30.0), 1000.0, PLAIN)
    assert tour.tolist() == [1, 0]
    assert times.tolist() == [10.0, 20.0]


def test_area_seen_earlier_in_a_tour_counts_only_once():
    visibility = visibility_of([100.0, 40.0], [0, 1], [1])
    tour, _ = best_tour(visibility, targets_at(30.0, 60.0), 1000.0, PLAIN)
    assert tour.tolist() == [0]


def test_a_tour_is_home_in_time():
    visibility = visibility_of([100.0, 100.0], [0], [1])
    on_two_sides = targets_at(30.0, -30.0)
    assert len(best_tour(visibility, on_two_sides, 40.0, PLAIN)[0]) == 2
    assert len(best_tour(visibility, on_two_sides, 39.0, PLAIN)[0]) == 1


def test_the_path_home_counts_when_the_steps_are_nearly_used_up():
    visibility = visibility_of([110.0, 100.0], [0], [1])
    targets = targets_at(60.0, -60.0)._replace(lengths_home=np.array([90.0, 0.0]))
    homeward = PLAIN._replace(homeward_weight=1.0, min_area=200.0)
    assert best_tour(visibility, targets, 60.0, homeward)[0].tolist() == [1]
    assert best_tour(visibility, targets, 6000.0, homeward)[0].tolist() == [0]


def test_out_of_reach_is_no_tour():
    targets = targets_at(30.0)._replace(lengths_there=np.array([np.inf]))
    assert len(best_tour(visibility_of([9.0], [0]), targets, 100.0, PLAIN)[0]) == 0


def test_a_claim_is_weaker_the_later_it_comes():
    visibility = visibility_of([100.0, 100.0, 100.0], [0, 1], [1], [2])
    left = unclaimed_areas(visibility, np.array([0, 1]), np.array([0.0, 75.0]), 75.0, 0.9)
    assert left.tolist() == pytest.approx([10.0, 10.0, 100.0])
    left = unclaimed_areas(visibility, np.array([2]), np.array([75.0]), 75.0, 0.9)
    assert left[2] == pytest.approx(100.0 * (1.0 - 0.9 / np.e))


def test_targets_nearer_to_others_count_less():
    costs = np.array([[10.0, 100.0, np.inf, 50.0], [100.0, 10.0, 5.0, 50.0]])
    shares = nearness_shares(costs, 0.4)
    assert shares.tolist() == [[1.0, 0.4, 1.0, 1.0], [0.4, 1.0, 1.0, 1.0]]
