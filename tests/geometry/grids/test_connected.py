"""Connected cells, against the labels of scipy and the fields of distances."""

import doctest

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy import ndimage

import multisrt.geometry.grids.connected as module
from multisrt.geometry.grids.connected import connected
from multisrt.geometry.grids.distance_field import DistanceField

grids = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=12))


@given(grids, st.data())
def test_connected_cells_have_the_label_of_one_of_the_cells(passable, data):
    rows, columns = passable.shape
    cell = st.tuples(st.integers(0, rows - 1), st.integers(0, columns - 1))
    cells = np.array(data.draw(st.lists(cell, max_size=3)), np.int64).reshape(-1, 2)
    labels, _ = ndimage.label(passable)
    own = set(labels[tuple(cells.T)].tolist()) - {0}
    assert (connected(passable, cells) == np.isin(labels, list(own))).all()


@given(st.integers(0, 100_000), st.floats(0.1, 0.6))
def test_there_is_a_path_to_connected_cells_only(seed, blocked):
    rng = np.random.default_rng(seed)
    passable = rng.random((30, 40)) > blocked
    row, column = np.argwhere(passable)[0]
    field = DistanceField(passable, 1.0, [(column + rng.random(), row + rng.random())])
    reach = field.reachable()
    field.complete()
    assert (reach == np.isfinite(field.reached())).all()


def test_a_winding_corridor_is_followed_to_its_end():
    # More runs wait to be filled than there was room for at first.
    passable = np.ones((201, 401), np.bool_)
    passable[1::2] = False
    passable[1::4, -1] = passable[3::4, 0] = True
    assert (connected(passable, np.array([[0, 0]])) == passable).all()
    comb = np.ones((3, 1001), np.bool_)
    comb[::2, 1::2] = False
    assert (connected(comb, np.array([[1, 500]])) == comb).all()


def test_the_grid_may_be_a_view():
    passable = np.zeros((9, 9), np.bool_)
    passable[::2] = True
    assert connected(passable[::2, ::3], np.array([[0, 0]])).sum() == 15


def test_examples():
    assert doctest.testmod(module).attempted > 0
