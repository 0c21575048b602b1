"""Paths on grids from either field, against a visibility graph around the blocked cells."""

import doctest
import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

import multisrt.geometry.grids.grid_path as module
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.euclidean_field import EuclideanField
from multisrt.geometry.grids.grid_path import shortest_path


def solid(passable, shrunk):
    """Return blocked cells and the grid's frame as one shape, joined where corners meet."""
    blocked = np.pad(~passable, 1, constant_values=True)
    rows, columns = np.nonzero(blocked)
    a, b, c, d = blocked[:-1, :-1], blocked[1:, 1:], blocked[1:, :-1], blocked[:-1, 1:]
    y, x = np.nonzero((a & b & ~c & ~d) | (c & d & ~a & ~b))
    pins = shapely.box(x - 0.002, y - 0.002, x + 0.002, y + 0.002)
    squares = shapely.box(columns - 1.0, rows - 1.0, columns, rows)
    whole = shapely.union_all(np.concatenate([squares, pins]))
    return shapely.buffer(whole, -shrunk, join_style="mitre")


def exact_lengths(passable, source, cells):
    """Return the lengths of the shortest paths around the blocked cells to cells' centres."""
    corners = []
    for part in shapely.get_parts(shapely.orient_polygons(solid(passable, 1e-4))):
        for ring in (part.exterior, *part.interiors):
            at = np.asarray(ring.coords)[:-1]
            into, out = at - np.roll(at, 1, axis=0), np.roll(at, -1, axis=0) - at
            corners.append(at[into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0] > 1e-9])
    turns = np.vstack(corners)
    turns = turns[(turns > 0.0).all(axis=1) & (turns < passable.shape[::-1]).all(axis=1)]
    points = np.vstack([[source], turns, np.asarray(cells)[:, ::-1] + 0.5])
    known = 1 + len(turns)
    pairs = np.array([(i, j) for i in range(known) for j in range(i + 1, len(points))])
    walls = solid(passable, 2e-4)
    shapely.prepare(walls)
    i, j = pairs[~shapely.intersects(walls, shapely.linestrings(points[pairs]))].T
    graph = csr_array((np.hypot(*(points[i] - points[j]).T), (i, j)), shape=(len(points),) * 2)
    return dijkstra(graph, directed=False, indices=[0])[0, known:]


def office(seed, rows=80, columns=120, room=40):
    rng = np.random.default_rng(seed)
    passable = np.ones((rows, columns), bool)
    passable[:, room::room] = passable[room::room] = False
    for x, y in itertools.product(range(0, columns, room), range(0, rows, room)):
        at = rng.integers(3, room - 8, 2)
        passable[y + at[0] : y + at[0] + 5, x : x + 1] = True
        passable[y : y + 1, x + at[1] : x + at[1] + 5] = True
        for _ in range(4):
            r, c = y + rng.integers(0, room - 6), x + rng.integers(0, room - 8)
            passable[r : r + rng.integers(1, 6), c : c + rng.integers(1, 8)] = False
    return passable


def scattered(seed):
    rng = np.random.default_rng(seed)
    return rng.random((25, 30)) > rng.uniform(0.05, 0.4)


def draw(passable, seed, count, away_cells=4.0):
    """Return a source at the centre of a cell, and reachable cells that are not near it."""
    rng = np.random.default_rng(seed)
    free = np.argwhere(passable)
    row, column = free[rng.integers(len(free))]
    source = (column + 0.5, row + 0.5)
    reached = free[np.isfinite(DistanceField(passable, 1.0, [source]).distance(free))]
    away = reached[np.hypot(*(reached - (row, column)).T) > away_cells]
    return source, away[rng.integers(0, len(away), count)] if len(away) else away


def length(path):
    return np.hypot(*np.diff(path, axis=0).T).sum()


def paths(method, passable, source, cells):
    if method == "descent":
        field = DistanceField(passable, 1.0, [source])
        return [shortest_path(field, cell) for cell in cells]
    transform = EuclideanField(passable, 1.0, source, order=method)
    return [transform.path(cell) for cell in cells]


@pytest.mark.slow
@pytest.mark.parametrize("method", ["descent", "queue", "sweeps"])
def test_paths_in_rooms_are_nearly_shortest(method):
    excess = []
    for seed in range(3):
        passable = office(seed)
        source, cells = draw(passable, seed, 30, 20.0)
        lengths = [length(path) for path in paths(method, passable, source, cells)]
        excess.append(np.array(lengths) / exact_lengths(passable, source, cells) - 1.0)
    assert np.min(excess) > -1e-4
    assert np.mean(excess) < 0.012
    assert np.max(excess) < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("method", ["descent", "queue", "sweeps"])
def test_paths_lose_less_than_a_cell_per_turn(method):
    for seed in range(4):
        passable = scattered(seed)
        source, cells = draw(passable, seed, 10)
        if not len(cells):
            continue
        truth = exact_lengths(passable, source, cells)
        for path, least in zip(paths(method, passable, source, cells), truth, strict=True):
            assert least - 1e-2 < length(path) < 1.05 * least + 1.0 * (len(path) - 2) + 1e-9


@pytest.mark.slow
@given(st.integers(0, 100_000), st.sampled_from(["descent", "queue", "sweeps"]))
@settings(max_examples=100)
def test_paths_never_pass_a_blocked_cell(seed, method):
    passable = scattered(seed)
    source, cells = draw(passable, seed, 3)
    source = tuple(np.floor(source) + np.random.default_rng(seed).uniform(0.01, 0.99, 2))
    walls = solid(passable, 1e-6)
    for cell, path in zip(cells, paths(method, passable, source, cells), strict=True):
        assert path[0] == pytest.approx(source)
        assert path[-1] == pytest.approx(cell[::-1] + 0.5)
        assert not shapely.intersects(shapely.linestrings(path), walls)


def test_around_a_wall_in_metres_by_hand():
    passable = np.ones((30, 40), bool)
    passable[:20, 20] = False
    field = DistanceField(passable, 0.1, [(11.03, 50.55)], x0=10.0, y0=50.0)
    path = shortest_path(field, (5, 30))
    assert path == pytest.approx(
        np.array([(11.03, 50.55), (11.95, 52.05), (12.15, 52.05), (13.05, 50.55)])
    )


def test_the_path_to_a_cell_in_sight_is_straight():
    field = DistanceField(np.ones((50, 70), bool), 1.0, [(3.2, 4.7)])
    assert shortest_path(field, (44, 61)).tolist() == [[3.2, 4.7], [61.5, 44.5]]
    assert shortest_path(field, (4, 3)).tolist() == [[3.2, 4.7], [3.5, 4.5]]


def test_the_path_begins_at_the_nearest_source():
    passable = np.ones((20, 60), bool)
    passable[:15, 30] = False
    field = DistanceField(passable, 1.0, [(5.5, 5.5), (50.5, 5.5)])
    assert shortest_path(field, (3, 26))[0].tolist() == [5.5, 5.5]
    assert shortest_path(field, (3, 34))[0].tolist() == [50.5, 5.5]


def test_paths_use_a_passage_after_a_repair():
    passable = np.ones((30, 40), bool)
    passable[:, 20] = False
    passable[28, 20] = True
    field = DistanceField(passable, 1.0, [(5.5, 5.5)])
    around = length(shortest_path(field, (5, 34)))
    passable[5, 20] = True
    field.repair((5, 6, 20, 21))
    assert shortest_path(field, (5, 34)).tolist() == [[5.5, 5.5], [34.5, 5.5]]
    assert around > 2 * math.hypot(14.0, 22.0)


def test_refuses_cells_without_a_path():
    passable = np.ones((3, 5), bool)
    passable[:, 2] = False
    field = DistanceField(passable, 1.0, [(0.5, 0.5)])
    with pytest.raises(InvalidInputError, match=r"no path leads to cell \(1, 4\)"):
        shortest_path(field, (1, 4))
    with pytest.raises(InvalidInputError, match="not in the grid"):
        shortest_path(field, (3, 0))


def test_examples():
    assert doctest.testmod(module).failed == 0
