"""GREEDY: the shortest way of all first, every frontier once before any is taken twice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.planners.assignment.costs import NOBODY, cost_table, longest


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GreedyAssignment:
    """Who goes where, and in which order it was settled.

    Attributes
    ----------
    costs : (n, m) array
        The table decided on, in metres.
    assignment : (n,) array of int
        Each robot's frontier; -1: it can reach none.
    rounds : tuple of (robot, frontier, utility, share)
        In this order the robots got their frontiers. The utility is 1 throughout: to this rule
        all frontiers are worth the same. The share is the distance over the longest finite one.
    """

    costs: FloatArray
    assignment: IntArray
    rounds: tuple[tuple[int, int, float, float], ...]


def greedy(costs: ArrayLike) -> GreedyAssignment:
    """Assign frontiers to all robots, always the closest pair of those that are left.

    Parameters
    ----------
    costs : (n, m) array
        Distance of each robot to each frontier in metres; ``inf`` where there is no way.

    Returns
    -------
    GreedyAssignment

    Raises
    ------
    InvalidInputError
        If `costs` is not a table of distances.

    Notes
    -----
    Cost: O(n^2 m). Source: A. Bautin, O. Simonin and F. Charpillet, Towards a communication
    free coordination for multi-robot exploration, Algorithm 2. Differs in: the paper's
    frontiers start again when they are used up; ours do so too when no robot that is left can
    reach a frontier that is left, since no robot is to stand idle that has somewhere to go.

    Examples
    --------
    >>> greedy([[1.0, 5.0], [2.0, 9.0]]).assignment.tolist()
    [0, 1]
    """
    table = cost_table(costs)
    robots, frontiers = table.shape
    assignment = np.full(robots, NOBODY, np.int64)
    scale = longest(table) or 1.0
    rounds: list[tuple[int, int, float, float]] = []

    # R and F: the robots and frontiers that are left; whoever reaches nothing is not in R.
    waiting: BoolArray = np.count_nonzero(np.isfinite(table), axis=1) > 0
    unused = np.ones(frontiers, np.bool_)
    while waiting.any():
        open_pairs = np.where(waiting[:, None] & unused, table, np.inf)
        # The first of equals in reading order: lowest robot, then lowest frontier.
        robot, frontier = divmod(int(np.argmin(open_pairs)), frontiers)
        if np.isinf(open_pairs[robot, frontier]):
            unused[:] = True
            continue
        assignment[robot] = frontier
        rounds.append((robot, frontier, 1.0, float(table[robot, frontier]) / scale))
        waiting[robot] = False
        unused[frontier] = False
    return GreedyAssignment(costs=table, assignment=assignment, rounds=tuple(rounds))
