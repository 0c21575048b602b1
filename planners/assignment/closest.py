"""CLOSEST: every robot goes to its nearest frontier, whatever the others do."""

from __future__ import annotations

import numpy as np

from multisrt.planners.assignment.costs import CostOracle, check_robot


def closest(costs: CostOracle, robot: int) -> int | None:
    """Choose the frontier that is nearest to one robot.

    Parameters
    ----------
    costs : CostOracle
        Costs of robots to frontiers.
    robot : int
        Number of the robot that chooses.

    Returns
    -------
    int or None
        Number of the frontier; None if the robot can reach none.

    Raises
    ------
    InvalidInputError
        If there is no such robot.

    Notes
    -----
    Cost: O(m). Source: B. Yamauchi (1997, 1998), as given by A. Bautin, O. Simonin and
    F. Charpillet, Towards a communication free coordination for multi-robot exploration,
    Algorithm 1; differs in: of equally near frontiers the first, where the paper draws one.

    Examples
    --------
    >>> from multisrt.planners.assignment.costs import DenseCosts
    >>> closest(DenseCosts([[4.0, 2.5, 2.5]]), 0)
    1
    >>> closest(DenseCosts([[float("inf")]]), 0) is None
    True
    """
    robots, frontiers = costs.shape
    check_robot(robot, robots)
    found = costs.nearest(robot, np.arange(frontiers))
    return None if found is None else found[1]
