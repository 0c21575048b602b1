"""CLOSEST: every robot goes to its nearest frontier, whatever the others do."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from multisrt.planners.assignment.costs import cost_table


def closest(costs: ArrayLike) -> int | None:
    """Choose the frontier that is nearest to one robot.

    Parameters
    ----------
    costs : (m,) array
        The robot's distance to each frontier in metres; ``inf`` where there is no way.

    Returns
    -------
    Index of the frontier, or None if the robot can reach none.

    Raises
    ------
    InvalidInputError
        If `costs` is not one row of distances.

    Notes
    -----
    Cost: O(m). Source: B. Yamauchi (1997, 1998), as given by A. Bautin, O. Simonin and
    F. Charpillet, Towards a communication free coordination for multi-robot exploration,
    Algorithm 1; differs in: of frontiers equally near the first, where the paper draws one.

    Examples
    --------
    >>> closest([4.0, 2.5, 2.5])
    1
    >>> closest([float("inf")]) is None
    True
    """
    row = cost_table(costs, dimensions=1)
    if not len(row):
        return None
    nearest = int(np.argmin(row))
    return nearest if np.isfinite(row[nearest]) else None
