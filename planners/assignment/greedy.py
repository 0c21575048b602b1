"""GREEDY: repeatedly assign the robot and frontier with the lowest cost."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.planners.assignment.costs import UNASSIGNED, CostOracle, check_robot


class Pair(NamedTuple):
    """A robot, the frontier that it is assigned, and what the frontier costs it.

    Attributes
    ----------
    robot, frontier : int
        Their numbers.
    cost_m : float
        Cost in metres.
    """

    robot: int
    frontier: int
    cost_m: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GreedyAssignment:
    """Frontiers assigned to robots, and the order in which they were.

    Attributes
    ----------
    assignment : (n,) array of int
        Each robot's frontier; -1 for a robot that can reach none, or whose turn did not come.
    rounds : tuple of Pair
        The assigned pairs in order.
    """

    assignment: IntArray
    rounds: tuple[Pair, ...]


def greedy(costs: CostOracle, until: int | None = None) -> GreedyAssignment:
    """Assign frontiers to robots, always the cheapest of the remaining pairs.

    Parameters
    ----------
    costs : CostOracle
        Costs of robots to frontiers.
    until : int, optional
        Number of a robot: stop when it has its frontier. By default all robots get one.

    Returns
    -------
    GreedyAssignment

    Raises
    ------
    InvalidInputError
        If there is no robot `until`.

    Notes
    -----
    Of equal pairs the lower robot comes first. Cost: O(n^2 m) on a table. On a lazy oracle a
    robot's search extends no farther than the cheapest pair found so far, and starts only if its
    lower bounds allow for a cheaper one.

    Source: A. Bautin, O. Simonin and F. Charpillet, Towards a communication free coordination for
    multi-robot exploration, Algorithm 2. Differs in: the paper's frontiers become available again
    when all are assigned; here also when no remaining robot can reach a remaining frontier, so
    that no robot that can reach a frontier is idle.

    Examples
    --------
    >>> from multisrt.planners.assignment.costs import DenseCosts
    >>> costs = DenseCosts([[1.0, 5.0], [2.0, 9.0]])
    >>> greedy(costs).assignment.tolist()
    [0, 1]
    >>> greedy(costs, until=0).rounds
    (Pair(robot=0, frontier=0, cost_m=1.0),)
    """
    n, _ = costs.shape
    if until is not None:
        check_robot(until, n)
    assignment = np.full(n, UNASSIGNED, np.int64)
    rounds: list[Pair] = []
    R = dict.fromkeys(range(n))
    F = _Remaining(costs)
    while R if until is None else until in R:
        pair = F.cheapest_pair(R)
        if pair is None:
            if F.is_initial:
                break
            F = _Remaining(costs)
            continue
        assignment[pair.robot] = pair.frontier
        rounds.append(pair)
        del R[pair.robot]
        F.remove(pair.frontier)
    return GreedyAssignment(assignment=assignment, rounds=tuple(rounds))


class _Remaining:
    """The frontiers not yet assigned (F), and each robot's cheapest of them as far as known."""

    def __init__(self, costs: CostOracle) -> None:
        self._costs = costs
        n, m = costs.shape
        self._bounds: FloatArray = costs.lower_bounds()
        self._frontiers: IntArray = np.arange(m)
        self._cheapest: dict[int, Pair] = {}
        # No frontier costs a robot less than this; inf: it can reach none.
        self._searched_m = np.zeros(n)

    @property
    def is_initial(self) -> bool:
        """Whether no frontier has been removed."""
        return len(self._frontiers) == self._costs.shape[1]

    def remove(self, frontier: int) -> None:
        """Remove a frontier; robots whose cheapest it was have to be searched for again."""
        self._frontiers = self._frontiers[self._frontiers != frontier]
        self._cheapest = {i: p for i, p in self._cheapest.items() if p.frontier != frontier}

    def cheapest_pair(self, robots: dict[int, None]) -> Pair | None:
        """Return the pair of lowest cost, of equal ones the lowest robot's; None if there is none.

        Robots are queried in the order of their lower bounds, until no bound is below the best
        pair.
        """
        if not len(self._frontiers):
            return None
        bounds = np.maximum(self._bounds[:, self._frontiers].min(axis=1), self._searched_m)
        best: Pair | None = None
        for i in sorted(robots, key=bounds.__getitem__):
            limit_m = math.inf if best is None else best.cost_m
            if math.isinf(bounds[i]) or bounds[i] > limit_m:
                break
            if i not in self._cheapest:
                found = self._costs.nearest(i, self._frontiers, limit_m)
                if found is None:
                    self._searched_m[i] = limit_m
                    continue
                cost, frontier = found
                self._cheapest[i] = Pair(i, frontier, cost)
            pair = self._cheapest[i]
            if best is None or (pair.cost_m, i) < (best.cost_m, best.robot):
                best = pair
        return best
