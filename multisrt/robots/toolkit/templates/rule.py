"""An assignment rule: which frontier a robot goes to. The rest is provided.

multisrt check mine.py
multisrt explore museum --strategy mine.py --robots 3
"""

import numpy as np
from numpy.typing import NDArray

from multisrt.robots.toolkit import assignment


@assignment
def mine(costs: NDArray[np.float64], robot: int) -> int | None:
    """Assign each frontier to one robot, shortest paths first."""
    # costs[i, j] is the length of the path from robot i to frontier j in metres, inf if there is
    # none; `robot` is the row of the robot that decides. Return the index of a frontier, or None
    # to leave all frontiers to the others for now.
    left = costs.copy()
    while np.isfinite(left).any():
        i, j = np.unravel_index(left.argmin(), left.shape)
        if i == robot:
            return int(j)
        left[i, :] = left[:, j] = np.inf
    # More robots than frontiers: share the nearest frontier with another robot.
    return int(costs[robot].argmin())
