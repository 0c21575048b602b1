"""Edges in a grid: every edge in reach is found, and winding numbers are right."""

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


def lookup(index, x, y, radius):
    scratch = index.scratch
    count = edges_within(
        x,
        y,
        radius,
        index.grid,
        index.bins,
        scratch.memory[0],
        scratch.next_query(),
        scratch.memory[1],
    )
    return scratch.memory[1, :count].copy()


def wind(index, x, y):
    scratch = index.scratch
    return winding_number(
        x,
        y,
        index.edges,
        index.grid,
        index.bins,
        scratch.memory[0],
        scratch.next_query(),
    )


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
    assert index.rows * index.columns <= 4_100_000
    assert len(lookup(index, 5e4, 1.0, 2.0)) == 1


@pytest.mark.parametrize("cell", [0.37, 1.0, 50.0])
@pytest.mark.parametrize("length", [0.0, 0.8, 7.0])
def test_edges_near_a_way(worlds, cell, length):
    edges = worlds.edges(worlds.office())
    index = EdgeIndex(edges, cell)
    lines = shapely.linestrings(edges.reshape(-1, 2, 2))
    rng = np.random.default_rng(9)
    told = []
    for x, y in worlds.viewpoints(worlds.hall(), 60, seed=4) * 2.0:
        angle = rng.uniform(0.0, 2.0 * np.pi)
        way = x, y, x + length * np.cos(angle), y + length * np.sin(angle)
        nearest = shapely.distance(lines, shapely.LineString([way[:2], way[2:]])).min()
        for distance in (0.05, 0.3, nearest - 1e-9, nearest + 1e-9):
            if distance > 0.0:
                told.append(no_edge_within(*way, distance, index.edges, index.grid, index.bins))
                assert told[-1] == (nearest > distance)
    assert len(set(told)) == 2


def test_a_way_that_touches_is_not_clear():
    index = EdgeIndex(np.array([[0.0, 0.0, 4.0, 0.0]]), 1.0)
    rest = index.edges, index.grid, index.bins
    for way in ((0.0, 0.5, 4.0, 0.5), (4.5, 0.0, 9.0, 0.0), (2.0, 3.0, 2.0, 0.5)):
        assert not no_edge_within(*way, 0.5, *rest)
        assert no_edge_within(*way, 0.49, *rest)
    # It crosses the edge, and all ends are far from it.
    assert not no_edge_within(2.0, -1.0, 2.0, 1.0, 0.1, *rest)


@given(x=st.floats(-2, 12), y=st.floats(-2, 12))
def test_winding_number_tells_inside_from_outside(worlds, x, y):
    free = worlds.pillar()
    if free.boundary.distance(shapely.Point(x, y)) < 1e-9:
        return
    index = worlds.index(free)
    assert index.free_winding == 1
    assert (wind(index, x, y) == 1) == shapely.contains_xy(free, x, y)


def test_obstacles_without_an_outline_have_free_space_around_them():
    clockwise = np.array([[0.0, 0, 0, 1], [0, 1, 1, 1], [1, 1, 1, 0], [1, 0, 0, 0]])
    index = EdgeIndex(clockwise, 1.0)
    assert index.free_winding == 0
    assert wind(index, -3.0, 0.5) == 0
    assert wind(index, 0.5, 0.5) == -1


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
