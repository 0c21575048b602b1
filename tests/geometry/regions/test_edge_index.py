"""Edges in a grid: queries find every edge in reach, and winding numbers are right."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import (
    EdgeIndex,
    edges_within,
    no_edge_within,
    winding_number,
)
from multisrt.geometry.regions.line_of_sight import edges_across


def lookup(index, x, y, radius):
    return edges_within(x, y, radius, index.grid)


def wind(index, x, y):
    return winding_number(x, y, index.grid)


@pytest.mark.parametrize("cell", [0.1, 0.37, 1.0, 50.0])
def test_finds_all_edges_in_reach_once(worlds, cell):
    edges = worlds.edges(worlds.office())
    index = EdgeIndex(edges, cell)
    lines = shapely.linestrings(edges.reshape(-1, 2, 2))
    for x, y in worlds.viewpoints(worlds.hall(), 20, seed=4) * 2.0:
        found = lookup(index, x, y, 3.0)
        assert len(found) == len(set(found.tolist()))
        near = np.flatnonzero(shapely.distance(lines, shapely.Point(x, y)) <= 3.0)
        assert set(near.tolist()) <= set(found.tolist())
        # Nothing beyond the cells that the disc touches.
        far = np.flatnonzero(
            shapely.distance(lines, shapely.Point(x, y)) > 3.0 + cell * np.sqrt(2.0) + 1e-6
        )
        assert not set(far.tolist()) & set(found.tolist())


def test_reach_beyond_everything_finds_all(worlds):
    index = worlds.index(worlds.office())
    for radius in (1e3, 1e7, 1e30):
        assert len(lookup(index, 3.0, 3.0, radius)) == len(index.edges)
    assert len(lookup(index, 1e30, 3.0, 4.0)) == 0


def test_cells_grow_instead_of_memory():
    edges = np.array([[0.0, 0.0, 1e5, 0.0], [1e5, 0.0, 0.0, 1e5], [0.0, 1e5, 0.0, 0.0]])
    index = EdgeIndex(edges, 0.01)
    assert index.grid.rows * index.grid.columns <= 4_100_000
    assert len(lookup(index, 5e4, 1.0, 2.0)) == 1


@pytest.mark.parametrize("cell", [0.37, 1.0, 50.0])
@pytest.mark.parametrize("length", [0.0, 0.8, 7.0])
def test_no_edge_within_equals_shapely(worlds, cell, length):
    edges = worlds.edges(worlds.office())
    index = EdgeIndex(edges, cell)
    lines = shapely.linestrings(edges.reshape(-1, 2, 2))
    rng = np.random.default_rng(9)
    told = []
    for x, y in worlds.viewpoints(worlds.hall(), 60, seed=4) * 2.0:
        angle = rng.uniform(0.0, 2.0 * np.pi)
        path = x, y, x + length * np.cos(angle), y + length * np.sin(angle)
        nearest = shapely.distance(lines, shapely.LineString([path[:2], path[2:]])).min()
        for distance in (0.05, 0.3, nearest - 1e-9, nearest + 1e-9):
            if distance > 0.0:
                told.append(no_edge_within(*path, distance, index.grid))
                assert told[-1] == (nearest > distance)
    assert len(set(told)) == 2


def test_an_edge_at_exactly_the_distance_is_within():
    index = EdgeIndex(np.array([[0.0, 0.0, 4.0, 0.0]]), 1.0)
    for path in ((0.0, 0.5, 4.0, 0.5), (4.5, 0.0, 9.0, 0.0), (2.0, 3.0, 2.0, 0.5)):
        assert not no_edge_within(*path, 0.5, index.grid)
        assert no_edge_within(*path, 0.49, index.grid)
    # It crosses the edge, and all ends are far from it.
    assert not no_edge_within(2.0, -1.0, 2.0, 1.0, 0.1, index.grid)


@given(x=st.floats(-2, 12), y=st.floats(-2, 12))
def test_winding_number_is_one_inside_and_zero_outside(worlds, x, y):
    free = worlds.pillar()
    if free.boundary.distance(shapely.Point(x, y)) < 1e-9:
        return
    index = worlds.index(free)
    assert index.grid.free_winding == 1
    assert (wind(index, x, y) == 1) == shapely.contains_xy(free, x, y)


def test_obstacles_without_outline_stand_in_free_space():
    clockwise = np.array([[0.0, 0, 0, 1], [0, 1, 1, 1], [1, 1, 1, 0], [1, 0, 0, 0]])
    index = EdgeIndex(clockwise, 1.0)
    assert index.grid.free_winding == 0
    assert wind(index, -3.0, 0.5) == 0
    assert wind(index, 0.5, 0.5) == -1


@pytest.mark.parametrize("cell", [0.37, 1.0, 50.0])
def test_edges_across_are_those_on_both_sides_of_the_line(worlds, cell):
    edges = worlds.edges(worlds.office())
    grid = EdgeIndex(edges, cell).grid
    lines = shapely.linestrings(edges.reshape(-1, 2, 2))
    places = worlds.viewpoints(worlds.office(), 40, seed=6)
    for (ax, ay), (bx, by) in zip(places[:20], places[20:], strict=True):
        found = edges_across(ax, ay, bx, by, grid).tolist()
        assert len(found) == len(set(found))
        sides = (bx - ax) * (edges[:, 1::2] - ay) - (by - ay) * (edges[:, ::2] - ax)
        assert (sides[found].prod(axis=1) <= 0.0).all()
        crossed = shapely.intersects(lines, shapely.LineString([(ax, ay), (bx, by)]))
        assert set(np.flatnonzero(crossed).tolist()) <= set(found)


def test_more_edges_are_found_than_there_was_room_for():
    x = np.arange(0.5, 50.0)
    fence = np.column_stack([x, np.full(50, -1.0), x, np.ones(50)])
    assert edges_across(0.0, 0.0, 50.0, 0.0, EdgeIndex(fence, 3.0).grid).tolist() == [*range(50)]


def test_queries_change_nothing_in_an_index(worlds):
    grid = worlds.index(worlds.office()).grid
    before = grid.edges.copy(), grid.bins.copy()
    edges_within(3.0, 3.0, 4.0, grid)
    edges_across(3.0, 3.0, 9.0, 8.0, grid)
    winding_number(3.0, 3.0, grid)
    assert np.array_equal(grid.edges, before[0])
    assert np.array_equal(grid.bins, before[1])


@pytest.mark.parametrize(
    ("edges", "cell", "told"),
    [
        (np.empty((0, 4)), 1.0, "n > 0"),
        (np.zeros((3, 3)), 1.0, "(n, 4)"),
        (np.array([[0.0, 0.0, np.nan, 1.0]]), 1.0, "finite"),
        (np.array([[0.0, 0.0, np.inf, 1.0]]), 1.0, "finite"),
        (np.array([[0.0, 0.0, 1.0, 1.0]]), 0.0, "positive width, not 0.0"),
        (np.array([[0.0, 0.0, 1.0, 1.0]]), -1.0, "-1.0"),
        (np.array([[0.0, 0.0, 1.0, 1.0]]), np.nan, "nan"),
        (np.array([[0.0, 0.0, 1.0, 1.0]]), np.inf, "inf"),
    ],
)
def test_refuses_what_cannot_be_indexed(edges, cell, told):
    with pytest.raises(InvalidInputError) as refused:
        EdgeIndex(edges, cell)
    assert told in str(refused.value)
