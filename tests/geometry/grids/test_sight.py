"""Lines of sight through a grid, by hand."""

import numpy as np

from multisrt.geometry.grids.sight import in_sight


def test_a_blocked_cell_beside_a_corner_hides_what_is_behind():
    free = np.ones((3, 3), bool)
    assert in_sight(free, 0.5, 0.5, 2, 2)
    free[1, 0] = False
    assert not in_sight(free, 0.5, 0.5, 2, 2)
    assert in_sight(free, 0.5, 0.5, 2, 0)
