"""UTILITY: costs are weighed against utilities that assigned targets near by reduce."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.planners.assignment.costs import UNASSIGNED, cost_table, largest_finite


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UtilityAssignment:
    """Targets assigned to robots, and the utility of each when it was assigned.

    Attributes
    ----------
    costs : (n, m) array
        The costs in metres, a read-only copy.
    assignment : (n,) array of int
        Each robot's target; -1 for a robot that can reach none.
    rounds : tuple of (robot, target, utility, share)
        The assigned pairs in order, with the target's utility U_t before, and the cost as a share
        of the largest finite one (V_it).
    """

    costs: FloatArray
    assignment: IntArray
    rounds: tuple[tuple[int, int, float, float], ...]


def utility(
    costs: ArrayLike,
    distances: ArrayLike,
    visible: ArrayLike,
    overlap_m: float,
    beta: float = 1.0,
    worth: ArrayLike | None = None,
) -> UtilityAssignment:
    """Assign targets to all robots, reducing the utility of targets near an assigned one.

    Parameters
    ----------
    costs : (n, m) array
        Cost of each robot to each target in metres; ``inf`` where there is no path.
    distances : (m, m) array
        Euclidean distances between targets in metres.
    visible : (m, m) array of bool
        Whether two targets see each other; the diagonal is taken as True.
    overlap_m : float
        Distance R in metres at and beyond which targets do not reduce each other's utility. Burgard
        et al. take the range of the range finders; areas seen from two targets overlap up to twice
        that.
    beta : float
        Weight of the cost against the utility.
    worth : (m,) array, optional
        Utility of each target at the beginning. Default: 1. Where some robots keep their goals, 1
        less the `overlap` of these.

    Returns
    -------
    UtilityAssignment

    Raises
    ------
    InvalidInputError
        If a table has the wrong shape, a negative entry or NaN, if a utility is not finite, if the
        distance R is not positive, or if `beta` is negative or not finite.

    Notes
    -----
    ``U_t = 1``; until every robot that can reach a target has one: ``(i, t) = argmax(U_t - beta
    V_it)``, then ``U_t' -= P(dist(t, t'))`` for every t', where ``P(d) = 1 - d / R`` for
    ``d < R``, else 0, and 0 where the two do not see each other. An assigned target
    remains available at a reduced utility, so that there may be more robots than targets. The rule
    needs every cost: V is relative to the largest. Cost: O(n^2 m + n m).

    Source: W. Burgard, M. Moors, C. Stachniss and F. Schneider, Coordinated Multi-robot
    Exploration, IEEE Transactions on Robotics 21 (2005). Differs in: V is the cost as a share of
    the largest finite one, and of equal values the nearer target is taken first.

    Examples
    --------
    Targets 0 and 1 are 2 m apart and see each other, so robot 1 goes to target 2:

    >>> costs = [[2.0, 3.0, 9.0], [3.0, 4.0, 10.0]]
    >>> distances = [[0.0, 2.0, 30.0], [2.0, 0.0, 30.0], [30.0, 30.0, 0.0]]
    >>> utility(costs, distances, np.ones((3, 3)), 8.0).assignment.tolist()
    [0, 2]
    """
    table = cost_table(costs)
    robots, targets = table.shape
    euclidean = cost_table(distances, "distances")
    sees = np.asarray(visible, np.bool_)
    for name, shape in (("distances", euclidean.shape), ("visible", sees.shape)):
        if shape != (targets, targets):
            raise InvalidInputError(
                f"{name} has the shape {shape}; for {targets} targets it must be square"
            )
    if not 0.0 < overlap_m < math.inf:
        raise InvalidInputError(f"overlap_m is {overlap_m}; it must be positive")
    if not 0.0 <= beta < math.inf:
        raise InvalidInputError(f"beta is {beta}; it must be 0 or more")

    left = np.ones(targets) if worth is None else np.array(worth, np.float64)  # U
    if left.shape != (targets,) or not np.isfinite(left).all():
        raise InvalidInputError(f"worth must have a finite utility for each of {targets} targets")
    share = table / (largest_finite(table) or 1.0)
    lost = overlap(euclidean, sees | np.eye(targets, dtype=np.bool_), overlap_m)  # P
    assignment = np.full(robots, UNASSIGNED, np.int64)
    rounds: list[tuple[int, int, float, float]] = []
    waiting: BoolArray = np.count_nonzero(np.isfinite(table), axis=1) > 0
    while waiting.any():
        # inf * 0 would be NaN for beta = 0.
        offered = waiting[:, None] & np.isfinite(table)
        value = np.full(table.shape, -np.inf)
        np.subtract(left, beta * np.where(offered, share, 0.0), out=value, where=offered)
        best = np.where(value == value.max(), table, np.inf)
        robot, target = divmod(int(np.argmin(best)), targets)
        assignment[robot] = target
        rounds.append((robot, target, float(left[target]), float(share[robot, target])))
        waiting[robot] = False
        left = left - lost[target]
    return UtilityAssignment(
        costs=table,
        assignment=assignment,
        rounds=tuple(rounds),
    )


def overlap(distances: ArrayLike, visible: ArrayLike, overlap_m: float) -> FloatArray:
    """Return by how much goals reduce the utility of targets near them (P).

    Parameters
    ----------
    distances : (k, m) array
        Euclidean distances from k goals to the targets in metres.
    visible : (k, m) array of bool
        Whether they see each other.
    overlap_m : float
        Distance R in metres at and beyond which targets do not reduce each other's utility. Burgard
        et al. take the range of the range finders; areas seen from two targets overlap up to twice
        that.

    Returns
    -------
    (k, m) array

    Examples
    --------
    >>> overlap([[0.0, 2.0, 9.0]], [[True, True, True]], 8.0).tolist()
    [[1.0, 0.75, 0.0]]
    """
    lost: FloatArray = np.maximum(1.0 - np.asarray(distances) / overlap_m, 0.0)
    lost[~np.asarray(visible, np.bool_)] = 0.0
    return lost
