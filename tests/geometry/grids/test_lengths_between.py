import numpy as np
import pytest

from multisrt.geometry.grids.distance_field import distance_field
from multisrt.geometry.grids.lengths_between import lengths_between


def lengths(passable, *cells):
    return lengths_between(passable, np.array(cells, np.int64).reshape(-1, 2))


def test_lengths_along_a_row_are_five_units_a_block():
    # 9 blocks of 3 cells: 9 steps of 5 in units of which 5.2 are a block's width.
    found = lengths(np.ones((3, 30), bool), (0, 0), (2, 27), (1, 1))
    assert found[0, 1] == pytest.approx(9 * 5 * 3 / 5.2)
    assert found[0, 2] == 0.0
    assert (found == found.T).all()


def test_paths_lead_round_walls():
    # From block (0, 0) down 6, across 2 and up 6; a wall of a block's width is between, and the
    # steps round its end are diagonal: 5 + 1 + 1 + 5 steps in all, two of them diagonal.
    passable = np.ones((21, 9), bool)
    passable[:18, 3:6] = False
    found = lengths(passable, (0, 0), (0, 8))
    assert found[0, 1] == pytest.approx((10 * 5 + 2 * 7) * 3 / 5.2)


def test_there_may_be_no_path():
    passable = np.ones((9, 9), bool)
    passable[:, 3:6] = False
    found = lengths(passable, (0, 0), (0, 8), (5, 1))
    assert np.isinf(found[0, 1])
    assert np.isfinite(found[0, 2])


def test_the_last_rows_and_columns_count():
    passable = np.zeros((7, 7), bool)
    passable[6, :] = True
    assert np.isfinite(lengths(passable, (6, 0), (6, 6))[0, 1])
    assert lengths(passable).shape == (0, 0)


def test_lengths_are_near_those_of_a_fast_march():
    rng = np.random.default_rng(2)
    passable = np.ones((120, 160), bool)
    for _ in range(8):
        row, column = rng.integers(0, 100), rng.integers(0, 140)
        passable[row : row + 18, column : column + 8] = False
    cells = np.argwhere(passable)[rng.choice(passable.sum(), 12, replace=False)]
    found = lengths_between(passable, cells)
    for k, (row, column) in enumerate(cells.tolist()):
        exact = distance_field(passable, 1.0, [(column + 0.5, row + 0.5)])
        expected = exact[cells[:, 0], cells[:, 1]]
        assert (np.abs(found[k] - expected) <= 0.08 * expected + 4.0).all()
