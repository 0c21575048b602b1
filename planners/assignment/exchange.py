"""RULES: two robots exchange their goals."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.assignment.costs import check_robot, cost_table


def exchange(robot: int, to_goals: ArrayLike, own: ArrayLike) -> int | None:
    """Choose the robot with which one robot exchanges goals.

    Parameters
    ----------
    robot : int
        Number of the robot that asks (i).
    to_goals : (n,) array
        Cost in metres of this robot's path to the goal of each robot; ``inf`` where there is no
        path or that robot has no goal. The robot's own entry is ignored.
    own : (n,) array
        Cost in metres of each robot's path to its own goal.

    Returns
    -------
    int or None
        Number of the other robot (j); None if all keep their goals.

    Raises
    ------
    InvalidInputError
        If the lengths differ, an entry is negative or NaN, or there is no such robot.

    Notes
    -----
    Robot i takes the goal of j if it costs i less than its own goal does, and less than it costs
    j; of several the cheapest, then the lower number. Robot j gets the goal of i, whatever it
    costs. Unless a robot has moved or chosen again, the same two do not swap back at once.

    Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
    escenarios 2D (Universidad de Guanajuato, 2018), section 3.2.8, Algorithm 6.

    Examples
    --------
    Robot 0 needs 9 m to its own goal and 5 m to that of robot 1, which needs 7 m:

    >>> exchange(0, [9.0, 5.0], [9.0, 7.0])
    1
    >>> exchange(0, [9.0, 5.0], [9.0, 4.0]) is None
    True
    """
    asked = cost_table(to_goals, "to_goals", dimensions=1)
    owners = cost_table(own, "own", dimensions=1)
    if len(asked) != len(owners):
        raise InvalidInputError(f"to_goals has {len(asked)} robots, own has {len(owners)}")
    check_robot(robot, len(owners))
    better = (asked < owners) & (asked < owners[robot])
    better[robot] = False
    partner = int(np.argmin(np.where(better, asked, np.inf)))
    return partner if better[partner] else None
