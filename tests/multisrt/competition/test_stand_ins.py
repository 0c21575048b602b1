import math

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from multisrt.competition.stand_ins import (
    BresenhamRays,
    OccupancyMap,
    astar_path,
    block_reduce,
    line,
)


def cast(grid, row, column, angles, reach=30.0):
    queries = np.zeros((len(angles), 3), np.float32)
    queries[:, 0], queries[:, 1], queries[:, 2] = row, column, angles
    ranges = np.zeros(len(angles), np.float32)
    BresenhamRays(OccupancyMap(grid), reach).calc_range_many(queries, ranges)
    return ranges


def marched(grid, row, column, angle, reach=30.0):
    """Return the range by rounding the ideal line, cell by cell along its longer axis."""
    di, dj = reach * math.cos(angle), reach * math.sin(angle)
    along = max(abs(di), abs(dj))
    for step in range(math.floor(along) + 1):
        share = step / along
        i = row + int(math.copysign(math.floor(abs(di) * share + 0.5), di))
        j = column + int(math.copysign(math.floor(abs(dj) * share + 0.5), dj))
        if grid[i, j]:
            return math.hypot(i - row, j - column)
    return reach


def test_rays_end_where_a_march_along_the_line_ends():
    rng = np.random.default_rng(5)
    angles, differ = np.linspace(0.0, 2.0 * np.pi, 500), 0
    for share in (0.0, 0.01, 0.1):
        grid = (rng.random((80, 90)) < share).astype(float)
        grid[40, 45] = 0.0
        expected = [marched(grid, 40, 45, angle) for angle in angles]
        differ += (abs(cast(grid, 40, 45, angles) - expected) > 1e-4).sum()
    assert differ <= 8  # lines through corners of cells, which single precision decides


def test_ranges_along_the_axes():
    grid = np.zeros((40, 40))
    grid[10, 20] = grid[20, 33] = 1
    assert cast(grid, 20, 20, [np.pi, np.pi / 2]).tolist() == [10.0, 13.0]
    assert cast(grid, 10, 20, [0.0]).tolist() == [0.0]


def test_paths_cost_as_little_as_by_dijkstra():
    rng = np.random.default_rng(2)
    for _ in range(40):
        weights = rng.integers(1, 11, (12, 15)).astype(np.float32)
        weights[rng.random(weights.shape) < 0.3] = np.inf
        start, goal = (0, 0), (11, 14)
        path = astar_path(weights, start, goal)
        numbers = np.arange(weights.size).reshape(weights.shape)
        pairs = np.concatenate(
            [
                np.stack([a.ravel(), b.ravel()], 1)
                for one, two in (
                    (numbers[1:], numbers[:-1]),
                    (numbers[:, 1:], numbers[:, :-1]),
                )
                for a, b in ((one, two), (two, one))
            ]
        )
        cost = weights.ravel()[pairs[:, 1]].astype(float)
        pairs, cost = pairs[np.isfinite(cost)], cost[np.isfinite(cost)]
        graph = coo_array((cost, pairs.T), shape=(weights.size, weights.size)).tocsr()
        least = dijkstra(graph)[0, -1]
        if path is None:
            assert np.isinf(least)
            continue
        assert (tuple(path[0]), tuple(path[-1])) == (start, goal)
        assert (abs(np.diff(path, axis=0)).sum(axis=1) == 1).all()
        assert weights[path[1:, 0], path[1:, 1]].sum() == least


def test_paths_are_those_of_pyastar2d():
    theirs = pytest.importorskip("pyastar2d")
    rng = np.random.default_rng(4)
    for k in range(60):
        weights = rng.integers(1, 2 + 9 * (k % 2), (30, 35)).astype(np.float32)
        weights[rng.random(weights.shape) < 0.25] = np.inf
        one, other = (path(weights, (0, 0), (29, 34)) for path in (theirs.astar_path, astar_path))
        assert (one is None) == (other is None)
        assert one is None or np.array_equal(np.asarray(one), np.asarray(other))


def test_lines_join_their_ends_in_single_steps():
    rng = np.random.default_rng(3)
    for ends in rng.integers(-20, 20, (100, 4)):
        rows, columns = line(*ends)
        assert (rows[0], columns[0], rows[-1], columns[-1]) == tuple(ends)
        assert len(rows) == max(abs(ends[2] - ends[0]), abs(ends[3] - ends[1])) + 1
        ideal = np.linspace(ends[:2], ends[2:], len(rows))
        assert (abs(np.stack([rows, columns], 1) - ideal) <= 0.5 + 1e-9).all()


def test_blocks_beyond_the_edge_are_filled():
    reduced = block_reduce(np.array([[2, 2, 2], [2, 1, 2]]), (2, 2), func=np.min, cval=1)
    assert reduced.tolist() == [[1, 1]]
