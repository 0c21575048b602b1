"""MINPOS: a robot goes to the frontier towards which it is in the best position."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Final

import numpy as np

from multisrt.geometry.numerics.arrays import IntArray
from multisrt.planners.assignment.costs import CostOracle, check_robot

UNCOUNTED: Final = -1
"""Entry of a table of positions that the decision does not depend on."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MinPosChoice:
    """One robot's choice, and the positions that it is based on.

    Attributes
    ----------
    choice : int or None
        Number of the frontier; None if the robot can reach none.
    positions : (n, m) array of int
        Number of robots that come before robot i at frontier j (P_ij), as far as counted; -1
        where it was not. The choosing robot's own are counted up to the lowest before.
    """

    choice: int | None
    positions: IntArray


def minpos(costs: CostOracle, robot: int) -> MinPosChoice:
    """Choose the frontier towards which one robot is in the best position.

    Parameters
    ----------
    costs : CostOracle
        Costs of robots to frontiers.
    robot : int
        Number of the robot that chooses (i).

    Returns
    -------
    MinPosChoice

    Raises
    ------
    InvalidInputError
        If there is no such robot.

    Notes
    -----
    The position P_ij is the number of robots nearer to frontier j. The lowest wins, among equal
    ones the nearest frontier, then the lowest number. Frontiers are visited in the order of their
    cost, so that one replaces another only by a lower position: no position is counted beyond the
    lowest so far, and the search ends at a frontier to which this robot is nearest.

    Cost: O(n m) comparisons. Source: A. Bautin, O. Simonin and F. Charpillet, Towards a
    communication free coordination for multi-robot exploration, Algorithm 3; differs in: ties of
    robots, see `positions`.

    Examples
    --------
    A robot leaves the nearer frontier to a teammate that is nearer still:

    >>> from multisrt.planners.assignment.costs import DenseCosts
    >>> chosen = minpos(DenseCosts([[3.0, 4.0], [1.0, 6.0]]), 0)
    >>> chosen.choice, chosen.positions.tolist()
    (1, [[1, 0], [0, -1]])
    """
    n, m = costs.shape
    check_robot(robot, n)
    P = np.full((n, m), UNCOUNTED, np.int64)
    choice, lowest = None, n
    for j in _by_cost(costs, robot):
        P[robot, j] = 0
        for position, k in enumerate(islice(costs.robots_ahead(robot, j), lowest)):
            P[k, j], P[robot, j] = position, position + 1
        if P[robot, j] < lowest:
            choice, lowest = j, int(P[robot, j])
        if lowest == 0:
            break
    return MinPosChoice(choice=choice, positions=P)


def _by_cost(costs: CostOracle, robot: int) -> Iterator[int]:
    """Iterate over the frontiers that a robot can reach, the nearest first."""
    remaining = np.arange(costs.shape[1])
    while (found := costs.nearest(robot, remaining)) is not None:
        _, frontier = found
        yield frontier
        remaining = remaining[remaining != frontier]
