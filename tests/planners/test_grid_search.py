import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy.ndimage import binary_dilation, label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from multisrt.planners.grid_search import a_star, reachable, ring_search

GRIDS = arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=9))
EIGHT = np.ones((3, 3), bool)


def cells(shape):
    return st.tuples(st.integers(0, shape[0] - 1), st.integers(0, shape[1] - 1))


def grid_of(text):
    return np.array([[c != "#" for c in row] for row in text.split()])


def may_step(passable, a, b):
    """Whether a single step leads from one cell to another."""
    (r, c), (s, d) = a, b
    near = max(abs(s - r), abs(d - c)) == 1
    return bool(
        near and passable[s, d] and (r == s or c == d or (passable[r, d] and passable[s, c]))
    )


def costs_by_dijkstra(passable, start):
    """Path lengths from a cell to all cells by scipy."""
    rows, columns = passable.shape
    every = [(r, c) for r in range(rows) for c in range(columns)]
    steps = [
        (r * columns + c, s * columns + d, math.dist((r, c), (s, d)))
        for r, c in every
        for s, d in every
        if may_step(passable, (r, c), (s, d))
    ]
    i, j, cost = np.array(steps).reshape(-1, 3).T
    graph = coo_array((cost, (i.astype(int), j.astype(int))), shape=(passable.size,) * 2)
    return dijkstra(graph.tocsr(), indices=start[0] * columns + start[1]).reshape(passable.shape)


@given(GRIDS, st.data())
def test_paths_are_as_short_as_those_of_dijkstra(passable, data):
    start, goal = data.draw(cells(passable.shape)), data.draw(cells(passable.shape))
    path = [tuple(cell) for cell in a_star(passable, *start, *goal).tolist()]
    cost = costs_by_dijkstra(passable, start)[goal] if passable[goal] else math.inf
    if math.isinf(cost):
        assert path == []
        return
    assert (path[0], path[-1]) == (start, goal)
    assert all(may_step(passable, a, b) for a, b in pairwise(path))
    assert sum(math.dist(a, b) for a, b in pairwise(path)) == pytest.approx(cost)


def test_the_only_path_of_a_maze_is_found():
    maze = grid_of(".#... .#.#. .#.#. ...#.")
    down, up = [[r, 0] for r in range(4)], [[r, 2] for r in (3, 2, 1, 0)]
    on = [[3, 1], *up, [0, 3], *([r, 4] for r in range(4))]
    assert a_star(maze, 0, 0, 3, 4).tolist() == [*down, *on]


def test_paths_do_not_cut_corners():
    assert a_star(grid_of(".# #."), 0, 0, 1, 1).tolist() == []
    assert a_star(grid_of(".. #."), 0, 0, 1, 1).tolist() == [[0, 0], [0, 1], [1, 1]]


def test_only_the_start_of_a_path_may_be_impassable():
    row = grid_of("#..")
    assert a_star(row, 0, 0, 0, 2).tolist() == [[0, 0], [0, 1], [0, 2]]
    assert a_star(row, 0, 2, 0, 0).tolist() == []
    assert a_star(row, 0, 0, 0, 0).tolist() == []


def test_the_path_to_the_start_is_one_cell():
    assert a_star(grid_of("..."), 0, 1, 0, 1).tolist() == [[0, 1]]


@given(GRIDS, st.data())
def test_reachable_cells_agree_with_scipys_labels(passable, data):
    start = data.draw(cells(passable.shape))
    reached = reachable(passable, *start)
    labels, _ = label(passable)
    assert (reached == ((labels == labels[start]) if passable[start] else False)).all()


@pytest.mark.slow
@given(GRIDS, st.data())
def test_paths_lead_exactly_to_reachable_cells(passable, data):
    start, goal = data.draw(cells(passable.shape)), data.draw(cells(passable.shape))
    if passable[start]:
        assert reachable(passable, *start)[goal] == (len(a_star(passable, *start, *goal)) > 0)


def rings(passable, start):
    """Cells covered by each successive ring."""
    covered = np.zeros_like(passable)
    covered[start] = True
    while True:
        yield covered
        wider = covered | (binary_dilation(covered, EIGHT) & passable)
        if (wider == covered).all():
            return
        covered = wider


@given(GRIDS, st.data(), st.integers(0, 30))
def test_search_ends_with_the_ring_that_finds_enough(passable, data, enough):
    wanted = data.draw(arrays(bool, passable.shape))
    start = data.draw(cells(passable.shape))
    row, column = start
    found = [tuple(cell) for cell in ring_search(passable, wanted, row, column, enough).tolist()]
    expected: list[tuple[int, ...]] = []
    before = np.zeros_like(passable)
    for covered in rings(passable, start):
        if len(expected) >= enough:
            break
        # The order within a ring is arbitrary.
        new = {tuple(cell) for cell in np.argwhere(covered & ~before & wanted).tolist()}
        assert set(found[len(expected) : len(expected) + len(new)]) == new
        expected += new
        before = covered
    assert len(found) == len(expected)


def test_rings_do_not_pass_walls():
    passable = grid_of("..#.. ..#.. ..#..")
    wanted = np.ones_like(passable)
    assert sorted(ring_search(passable, wanted, 0, 0, 99)[:, 1].tolist()) == [0, 0, 0, 1, 1, 1]


def test_cells_are_found_ring_by_ring():
    passable = np.ones((1, 7), bool)
    wanted = np.array([[True, False, True, False, True, True, False]])
    assert ring_search(passable, wanted, 0, 3, 1)[:, 1].tolist() == [2, 4]
    assert ring_search(passable, wanted, 0, 3, 3)[:, 1].tolist() == [2, 4, 5]
    assert ring_search(passable, wanted, 0, 3, 4)[:, 1].tolist() == [2, 4, 5, 0]
