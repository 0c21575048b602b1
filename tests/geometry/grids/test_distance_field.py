"""Geodesic distances, against shortest paths of a visibility graph and answers by hand."""

import doctest
import itertools
import math
import tracemalloc
from typing import Any, cast

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

import multisrt.geometry.grids.distance_field as module
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.distance_field import DistanceField, distance_field


def grid(free, cell, shift=0.0):
    """Return the cells whose centres are free, and the x and y of the centres."""
    x0, y0, x1, y1 = free.bounds
    x = x0 + shift + (np.arange(round((x1 - x0) / cell)) + 0.5) * cell
    y = y0 + shift + (np.arange(round((y1 - y0) / cell)) + 0.5) * cell
    return shapely.contains_xy(free, *np.meshgrid(x, y)), x, y


def shortest_paths(worlds, free, source, targets):
    """Return exact lengths, by a visibility graph of all corners."""
    corners = np.unique(worlds.edges(free)[:, :2], axis=0)
    points = np.vstack([source, corners, targets])
    known = 1 + len(corners)
    pairs = np.array(
        [(i, j) for i, j in itertools.product(range(known), range(len(points))) if i < j]
    )
    room = free.buffer(1e-7)
    shapely.prepare(room)
    sees = shapely.covers(room, shapely.linestrings(points[pairs]))
    i, j = pairs[sees].T
    graph = csr_array((np.hypot(*(points[i] - points[j]).T), (i, j)), shape=(len(points),) * 2)
    return dijkstra(graph, directed=False, indices=[0])[0, known:]


def error(worlds, free, cell, source, targets):
    """Return the relative errors at the centres of the cells that hold the targets."""
    cells, x, y = grid(free, cell)
    columns = np.floor((targets[:, 0] - x[0]) / cell + 0.5).astype(int)
    rows = np.floor((targets[:, 1] - y[0]) / cell + 0.5).astype(int)
    field = distance_field(cells, cell, [source], x0=x[0] - cell / 2, y0=y[0] - cell / 2)
    truth = shortest_paths(worlds, free, source, np.column_stack([x[columns], y[rows]]))
    return field[rows, columns] / truth - 1.0


def test_distances_converge_to_shortest_paths(worlds):
    # Walls are wider than the widest cells, which would leave gaps in thinner ones.
    free = worlds.rooms(wall=0.5)
    targets = worlds.viewpoints(free, 80, clearance=0.2, seed=61)
    targets = targets[np.hypot(*(targets - (3.0, 3.0)).T) > 2.0]
    coarse, fine, finest = (
        error(worlds, free, cell, (3.02, 3.03), targets) for cell in (0.2, 0.1, 0.05)
    )
    assert np.abs(coarse).mean() < 0.02
    assert np.abs(fine).mean() < 0.008
    assert np.abs(fine).max() < 0.04
    assert np.abs(finest).mean() < 0.004
    assert np.abs(finest).mean() < 0.65 * np.abs(fine).mean() < 0.5 * np.abs(coarse).mean()


def test_open_space_is_nearly_euclidean():
    field = distance_field(np.ones((160, 200), bool), 0.1, [(10.03, 8.06)])
    x, y = np.meshgrid((np.arange(200) + 0.5) * 0.1, (np.arange(160) + 0.5) * 0.1)
    truth = np.hypot(x - 10.03, y - 8.06)
    relative = np.abs(field - truth) / truth
    assert relative.max() < 0.001
    assert relative.mean() < 0.0004
    near = np.maximum(np.abs(x - 10.05), np.abs(y - 8.05)) < 1.0
    assert field[near] == pytest.approx(truth[near], abs=1e-12)


def test_around_a_wall_by_hand():
    # The path leads around the end (10, 15) of a wall one cell thick.
    free = np.ones((200, 200), bool)
    free[:150, 100] = False
    field = distance_field(free, 0.1, [(5.05, 5.05)])
    truth = math.hypot(10.0 - 5.05, 15.0 - 5.05) + 0.1 + math.hypot(15.05 - 10.1, 15.0 - 5.05)
    assert field[50, 150] == pytest.approx(truth, rel=0.01)
    assert np.isinf(field[:150, 100]).all()


def test_straight_corridor_is_exact_by_hand():
    field = distance_field(np.ones((1, 60), bool), 0.5, [(0.25, 0.25)])
    assert field[0] == pytest.approx(0.5 * np.arange(60))


def test_nothing_passes_between_cells_that_meet_in_a_corner():
    free = np.zeros((4, 4), bool)
    free[:2, :2] = free[2:, 2:] = True
    field = distance_field(free, 1.0, [(0.5, 0.5)])
    assert np.isfinite(field[:2, :2]).all()
    assert np.isinf(field[2:, 2:]).all()


def test_unreachable_cells_are_infinite():
    free = np.ones((10, 21), bool)
    free[:, 10] = False
    field = distance_field(free, 1.0, [(0.5, 0.5)])
    assert np.isfinite(field[:, :10]).all()
    assert np.isinf(field[:, 10:]).all()


@pytest.mark.parametrize("name", ["rooms", "office"])
def test_several_sources_are_the_nearest_of_each(worlds, name):
    cells, _, _ = grid(worlds.WORLDS[name](), 0.1)
    sources = worlds.viewpoints(worlds.WORLDS[name](), 4, seed=62)
    together = distance_field(cells, 0.1, sources)
    apart = np.min([distance_field(cells, 0.1, [source]) for source in sources], axis=0)
    finite = np.isfinite(apart)
    assert np.array_equal(np.isfinite(together), finite)
    assert np.abs(together[finite] - apart[finite]).max() < 0.15


def test_a_nearer_source_behind_a_wall_counts():
    # From cell (0, 9) the second source is 2.2 cells away around the wall, the first one 9.
    free = np.ones((3, 12), bool)
    free[1, :10] = False
    field = distance_field(free, 1.0, [(0.5, 0.5), (9.5, 2.5)])
    alone = distance_field(free, 1.0, [(9.5, 2.5)])
    assert alone[0, 9] < 5.0
    assert field[0, 9] == pytest.approx(alone[0, 9], abs=1.0)


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
def test_an_early_stop_gives_asked_cells_their_final_values(worlds, name):
    cells, _, _ = grid(worlds.WORLDS[name](), 0.1)
    whole = distance_field(cells, 0.1, worlds.viewpoints(worlds.WORLDS[name](), 1, seed=63))
    reached = np.argwhere(np.isfinite(whole))
    order = np.argsort(whole[tuple(reached.T)], kind="stable")
    asked = reached[order[[100, len(order) // 8, len(order) // 5]]]
    part = distance_field(
        cells, 0.1, worlds.viewpoints(worlds.WORLDS[name](), 1, seed=63), asked=asked
    )
    assert np.array_equal(part[tuple(asked.T)], whole[tuple(asked.T)])
    # Values that were reached are final; the rest was not computed.
    done = np.isfinite(part)
    assert np.array_equal(part[done], whole[done])
    assert done.sum() < 0.25 * len(reached)
    assert part[done].max() == whole[tuple(asked[-1])]


def test_unreachable_asked_cells_do_not_stop_the_march():
    free = np.ones((10, 21), bool)
    free[:, 10] = False
    field = distance_field(free, 1.0, [(0.5, 0.5)], asked=[(0, 20), (0, 10)])
    assert np.isfinite(field[:, :10]).all()
    assert np.isinf(distance_field(free, 1.0, [(0.5, 0.5)], asked=[(0, 10)])).all()


def test_the_grid_may_lie_anywhere(worlds):
    cells, _, _ = grid(worlds.office(), 0.1)
    here = distance_field(cells, 0.1, [(2.5, 2.5)])
    there = distance_field(cells, 0.1, [(5e5 + 2.5, 4.5e6 + 2.5)], x0=5e5, y0=4.5e6)
    finite = np.isfinite(here)
    assert np.array_equal(np.isfinite(there), finite)
    assert there[finite] == pytest.approx(here[finite], abs=1e-6)


@given(st.integers(0, 10_000), st.floats(0.1, 0.6))
def test_fields_are_distances(seed, blocked):
    rng = np.random.default_rng(seed)
    free = rng.random((20, 25)) > blocked
    free[3, 4] = True
    field = distance_field(free, 1.0, [(4.5, 3.5)])
    assert field[3, 4] == 0.0
    assert np.isinf(field[~free]).all()
    x, y = np.meshgrid(np.arange(25) + 0.5, np.arange(20) + 0.5)
    straight = np.hypot(x - 4.5, y - 3.5)
    # Values are hardly shorter than the straight line, and neighbours differ little.
    assert (field >= 0.95 * straight - 0.5).all()
    for a, b in ((field[1:], field[:-1]), (field[:, 1:], field[:, :-1])):
        both = np.isfinite(a) & np.isfinite(b)
        assert np.abs(a[both] - b[both]).max(initial=0.0) < 1.5
    # Cells are reached if they are connected through sides.
    reached = {(3, 4)}
    border = [(3, 4)]
    while border:
        r, c = border.pop()
        for cell in ((r + 1, c), (r - 1, c), (r, c + 1), (r, c - 1)):
            inside = 0 <= cell[0] < 20 and 0 <= cell[1] < 25
            if inside and free[cell] and cell not in reached:
                reached.add(cell)
                border.append(cell)
    assert {tuple(cell) for cell in np.argwhere(np.isfinite(field)).tolist()} == reached


def test_the_grid_is_not_changed(worlds):
    cells, _, _ = grid(worlds.pillar(), 0.5)
    before = cells.copy()
    cells.setflags(write=False)
    distance_field(cells, 0.5, [(1.0, 1.0)])
    assert np.array_equal(cells, before)


def test_examples():
    assert doctest.testmod(module).failed == 0


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"free": np.ones(5, bool)}, "two dimensions, not 1"),
        ({"cell_m": 0.0}, "positive width in metres, not 0.0"),
        ({"cell_m": np.nan}, "not nan"),
        ({"sources": []}, "k > 0"),
        ({"sources": [(1.0, 1.0, 1.0)]}, "(k, 2)"),
        ({"sources": [(1.0, 1.0), (2.5, 2.5)]}, "source 1 at (2.5, 2.5) is not in a free cell"),
        ({"sources": [(-0.1, 1.0)]}, "source 0 at (-0.1, 1)"),
        ({"sources": [(5.1, 1.0)]}, "source 0 at (5.1, 1)"),
        ({"sources": [(np.nan, 1.0)]}, "source 0 at (nan, 1)"),
        ({"asked": [(0, 0), (4, 1)]}, "cell (4, 1) is not in the grid of 4 rows and 5 columns"),
        ({"asked": [(-1, 0)]}, "cell (-1, 0)"),
    ],
)
def test_refuses_invalid_fields(change, told):
    free = np.ones((4, 5), bool)
    free[2, 2] = False
    arguments = {"free": free, "cell_m": 1.0, "sources": [(1.0, 1.0)]} | change
    with pytest.raises(InvalidInputError) as refused:
        distance_field(
            arguments["free"],
            arguments["cell_m"],
            arguments["sources"],
            asked=arguments.get("asked"),
        )
    assert told in str(refused.value)


def disturbed(seed, count=1):
    """Return a random grid, sources, and a function that changes cells and returns where."""
    rng = np.random.default_rng(seed)
    rows, columns = (int(n) for n in rng.integers(8, 130, 2))
    passable = rng.random((rows, columns)) > rng.choice([0.0, 0.02, 0.1, 0.3])
    if rng.random() < 0.3:
        passable[:] = True
        passable[rows // 3, : columns - 2] = passable[rows // 2 + 1, 2:] = False
    starts = np.column_stack([rng.integers(0, columns, count), rng.integers(0, rows, count)])
    passable[starts[:, 1], starts[:, 0]] = True

    def change():
        r0, c0 = int(rng.integers(-3, rows)), int(rng.integers(-3, columns))
        r1, c1 = r0 + int(rng.integers(1, 30)), c0 + int(rng.integers(1, 30))
        window = passable[max(r0, 0) : max(r1, 0), max(c0, 0) : max(c1, 0)]
        window[:] = rng.random(window.shape) > rng.choice([0.0, 0.1, 0.5, 0.9, 1.0])
        passable[starts[:, 1], starts[:, 0]] = True
        return r0, r1, c0, c1

    return passable, starts + rng.choice([0.5, 0.25, 0.0], (count, 2)), change, rng


@pytest.mark.slow
@given(st.integers(0, 100_000), st.integers(1, 2))
@settings(max_examples=150)
def test_a_repaired_field_is_a_new_one_to_the_bit(seed, count):
    passable, sources, change, rng = disturbed(seed, count=count)
    field = DistanceField(passable, 0.1, np.array(sources) * 0.1)
    for _ in range(3):
        free = np.argwhere(passable)
        asked = free[rng.integers(0, len(free), 3)]
        whole = distance_field(passable, 0.1, np.array(sources) * 0.1)
        assert np.array_equal(field.distance(asked), whole[tuple(asked.T)])
        field.repair(change())
    field.complete()
    assert np.array_equal(field.reached(), distance_field(passable, 0.1, sources * 0.1))


@given(st.integers(0, 100_000))
def test_a_field_follows_free_space_that_grows_in_a_large_grid(seed):
    rng = np.random.default_rng(seed)
    passable = np.zeros((160, 200), bool)
    passable[70:75, 90:95] = True
    source = np.array([[92.5, 72.5]])
    field = DistanceField(passable, 1.0, source)
    for _ in range(6):
        free = np.argwhere(passable)
        asked = free[rng.integers(0, len(free), 3)]
        whole = distance_field(passable, 1.0, source)
        assert np.array_equal(field.distance(asked), whole[tuple(asked.T)])
        row, column = free[rng.integers(len(free))]
        height, width = rng.integers(1, 40, 2)
        r0, c0 = max(0, row - height), max(0, column - width)
        passable[r0 : row + height, c0 : column + width] = True
        field.repair((r0, min(160, row + height), c0, min(200, column + width)))
    field.complete()
    assert np.array_equal(field.reached(), distance_field(passable, 1.0, source))


@pytest.mark.parametrize("x", [2.0, 2.0 - 1e-13, 2.0 + 1e-13])
def test_a_source_on_a_border_of_cells_is_in_the_one_that_is_free(x):
    for free_column in (1, 2):
        passable = np.zeros((3, 5), bool)
        passable[:, free_column] = True
        field = DistanceField(passable, 1.0, [(x, 1.5)])
        assert field.distance([(1, free_column)])[0] == pytest.approx(0.5)
        assert np.isfinite(field.distance([(2, free_column)])[0])
        passable[:, free_column] = False
        with pytest.raises(InvalidInputError, match="not in a free cell"):
            DistanceField(passable, 1.0, [(x, 1.5)])


def test_a_field_whose_source_was_blocked_still_answers():
    passable = np.zeros((200, 200), bool)
    passable[95:105] = True
    field = DistanceField(passable, 1.0, [(100.5, 100.5)])
    assert field.distance([(100, 110)]) == [10.0]
    passable[:, :90] = passable[:, 112:] = passable[100, 100] = False
    passable[100, 160] = True
    with pytest.raises(InvalidInputError, match="not in a free cell"):
        field.repair((0, 200, 0, 200))
    assert field.distance([(100, 110)]) == [10.0]
    assert np.isinf(field.distance([(100, 160)])[0])


def test_values_before_a_change_are_kept():
    passable = np.ones((40, 300), bool)
    field = DistanceField(passable, 1.0, [(5.5, 20.5)])
    field.complete()
    passable[:, 200] = False
    field.repair((0, 40, 200, 201))
    kept = field.reached()
    assert np.isfinite(kept[:, :190]).all()
    assert np.isinf(kept[:, 200:]).all()
    assert np.isinf(field.distance([(20, 250)])[0])
    passable[3, 200] = True
    field.repair((3, 4, 200, 201))
    assert field.distance([(20, 250)])[0] == pytest.approx(
        math.hypot(195.0, 17.0) + math.hypot(50.0, 17.0), rel=0.005
    )


def test_a_change_beyond_the_front_takes_nothing_back():
    passable = np.ones((200, 200), bool)
    field = DistanceField(passable, 1.0, [(20.5, 20.5)])
    field.distance([(30, 30)])
    before = field.reached()
    passable[60:90, 60:90] = False
    field.repair((60, 90, 60, 90))
    assert np.array_equal(field.reached(), before)
    assert np.isinf(field.distance([(70, 70)])[0])


@given(st.integers(0, 100_000))
def test_going_on_leads_to_the_same_field(seed):
    passable, sources, _, rng = disturbed(seed)
    whole = distance_field(passable, 1.0, sources)
    field = DistanceField(passable, 1.0, sources)
    free = np.argwhere(passable)
    for _ in range(4):
        asked = free[rng.integers(0, len(free), 2)]
        assert np.array_equal(field.distance(asked), whole[tuple(asked.T)])
    done = np.isfinite(field.reached())
    assert np.array_equal(field.reached()[done], whole[done])


@given(st.integers(0, 100_000))
def test_the_first_of_some_cells_is_the_nearest(seed):
    passable, sources, _, rng = disturbed(seed)
    whole = distance_field(passable, 1.0, sources)
    rows, columns = passable.shape
    for known in (False, True):
        asked = np.column_stack([rng.integers(0, rows, 6), rng.integers(0, columns, 6)])
        field = DistanceField(passable, 1.0, sources)
        if known:
            field.distance(asked[3:])
        lengths = whole[tuple(asked.T)]
        found = field.first(asked)
        if found is None:
            assert np.isinf(lengths).all()
        else:
            first, length = found
            assert length == lengths[first] == pytest.approx(lengths.min(), abs=1e-9)
            assert known or field.reached()[np.isfinite(field.reached())].max() <= lengths[first]


@pytest.mark.parametrize("seed", range(6))
def test_the_first_of_some_cells_within_a_limit(seed):
    passable, sources, _, rng = disturbed(seed)
    whole = distance_field(passable, 1.0, sources)
    rows, columns = passable.shape
    asked = np.column_stack([rng.integers(0, rows, 6), rng.integers(0, columns, 6)])
    nearest = whole[tuple(asked.T)].min()
    field = DistanceField(passable, 1.0, sources)
    for limit in (0.0, nearest / 3.0, nearest - 0.01):
        if limit < nearest < np.inf:
            assert field.first(asked, limit) is None
            reached = field.reached()
            assert reached[np.isfinite(reached)].max(initial=0.0) <= limit
    # Later queries go on to the same values.
    for limit in (nearest, np.inf):
        found = field.first(asked, limit)
        assert (found is None) == np.isinf(nearest)
        assert found is None or whole[tuple(asked[found[0]])] == found[1] == nearest
    field.complete()
    np.testing.assert_array_equal(field.reached(), whole)


@pytest.mark.parametrize("seed", range(6))
def test_distances_within_a_limit(seed):
    passable, sources, _, rng = disturbed(seed)
    whole = distance_field(passable, 1.0, sources)
    rows, columns = passable.shape
    asked = np.column_stack([rng.integers(0, rows, 6), rng.integers(0, columns, 6)])
    lengths = whole[tuple(asked.T)]
    for limit in (0.0, *np.sort(lengths)):
        field = DistanceField(passable, 1.0, sources)
        found = field.distance(asked, limit)
        np.testing.assert_array_equal(found, np.where(lengths <= limit, lengths, np.inf))
        # Later queries go on to the same values.
        np.testing.assert_array_equal(field.distance(asked), lengths)


def test_memory_does_not_depend_on_the_size_of_the_grid():
    passable = np.ones((4000, 4000), bool)
    tracemalloc.start()
    field = DistanceField(passable, 0.1, [(200.05, 200.05)])
    assert field.distance([(2025, 2000)])[0] == pytest.approx(2.5, rel=0.001)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 2_000_000


def test_memory_depends_on_where_paths_may_run():
    passable = np.zeros((1000, 1000), bool)
    passable[480:520, 300:700] = True
    field = DistanceField(passable, 1.0, [(310.5, 500.5)])
    assert field.distance([(500, 690)])[0] == pytest.approx(380.0, rel=0.001)
    assert field.nbytes < 40 * 46 * 406


def test_the_grid_may_be_a_view():
    passable = np.ones((60, 80), bool)
    part = passable[10:50:2, 5:75:2]
    field = DistanceField(part, 1.0, [(2.5, 2.5)])
    assert field.distance([(15, 30)]) == distance_field(part.copy(), 1.0, [(2.5, 2.5)])[15, 30]


@given(st.integers(0, 100_000))
def test_the_descent_leads_to_the_source_and_cuts_no_corner(seed):
    passable, sources, _, rng = disturbed(seed)
    whole = distance_field(passable, 1.0, sources)
    reached = np.argwhere(np.isfinite(whole))
    down = DistanceField(passable, 1.0, sources).descent(reached[rng.integers(len(reached))])
    assert (np.diff(whole[tuple(down.T)]) < 0.0).all()
    assert (np.abs(np.diff(down, axis=0)) <= 1).all()
    for (r, c), (q, p) in itertools.pairwise(down.tolist()):
        assert passable[q, p]
        assert passable[r, p]
        assert passable[q, c]
    assert np.abs(down[-1] + 0.5 - sources[0, ::-1]).max() <= 0.5


def test_refuses_invalid_grids_cells_and_repairs():
    with pytest.raises(InvalidInputError, match="of bool, not float64"):
        DistanceField(cast(Any, np.ones((3, 3))), 1.0, [(0.5, 0.5)])
    passable = np.ones((3, 9), bool)
    field = DistanceField(passable, 1.0, [(0.5, 0.5)])
    with pytest.raises(InvalidInputError, match=r"cell \(3, 0\)"):
        field.distance([(3, 0)])
    with pytest.raises(InvalidInputError, match=r"cell \(0, -1\)"):
        field.first([(0, -1)])
    passable[:, 4] = False
    field.repair((0, 3, 4, 5))
    with pytest.raises(InvalidInputError, match=r"no path leads to cell \(1, 6\)"):
        field.descent((1, 6))
    passable[0, 0] = False
    with pytest.raises(InvalidInputError, match="not in a free cell"):
        field.repair((0, 1, 0, 1))
    assert field.distance([(0, 1)])[0] == 1.0
