"""A rule of assignment: which frontier a robot goes to. All else is done for it.

multisrt check mine.py
multisrt explore museum --strategy mine.py --robots 3
"""

import numpy as np
from numpy.typing import NDArray

from multisrt.robots.toolkit import assignment


@assignment
def mine(costs: NDArray[np.float64], robot: int) -> int | None:
    """Assign frontiers by the shortest paths, each to one robot."""
    # costs[i, j] is the length of the path from robot i to frontier j in metres, inf where there
    # is none; `robot` is the row of the robot that decides. Return the number of a frontier, or
    # None to leave them all to the others for now.
    left = costs.copy()
    while np.isfinite(left).any():
        i, j = np.unravel_index(left.argmin(), left.shape)
        if i == robot:
            return int(j)
        left[i, :] = left[:, j] = np.inf
    # There are more robots than frontiers: go along with another one.
    return int(costs[robot].argmin())
