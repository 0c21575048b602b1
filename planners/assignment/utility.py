"""UTILITY: a leader weighs the way to each target against what others will see from theirs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.planners.assignment.costs import NOBODY, cost_table, longest


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UtilityAssignment:
    """Who goes where, and what each target was worth when it was given away.

    Attributes
    ----------
    costs : (n, m) array
        The table decided on, in metres.
    assignment : (n,) array of int
        Each robot's target; -1: it can reach none.
    rounds : tuple of (robot, target, utility, share)
        In this order targets were given away: the target's utility U_t then, and the robot's
        distance as a share of the longest finite one (V_it).
    utilities : (rounds + 1, m) array
        The utilities of all targets before each round, and after the last.
    """

    costs: FloatArray
    assignment: IntArray
    rounds: tuple[tuple[int, int, float, float], ...]
    utilities: FloatArray


def utility(
    costs: ArrayLike,
    between: ArrayLike,
    visible: ArrayLike,
    sensor_range_m: float,
    beta: float = 1.0,
) -> UtilityAssignment:
    """Assign targets to all robots, lowering the worth of what lies near a target given away.

    Parameters
    ----------
    costs : (n, m) array
        Distance of each robot to each target in metres; ``inf`` where there is no way.
    between : (m, m) array
        Straight distances between targets in metres.
    visible : (m, m) array of bool
        Whether two targets see each other; a target always sees itself.
    sensor_range_m : float
        Range R_p of the robots' range finders.
    beta : float
        Weight of the way against the utility.

    Returns
    -------
    UtilityAssignment

    Raises
    ------
    InvalidInputError
        If a table has the wrong shape or holds what is no distance, if the range is not
        positive, or if `beta` is negative or not finite.

    Notes
    -----
    ``U_t = 1``; until every robot that reaches a target has one: ``(i, t) = argmax(U_t - beta
    V_it)``, then ``U_t' -= P(dist(t, t'))`` for every t', where ``P(d) = 1 - d / R`` for
    ``d < R = 2 R_p``, else 0, and 0 where the two do not see each other. A target that was
    given away stays to be had at a lower utility, so that there may be more robots than
    targets. Cost: O(n^2 m + n m).

    Source: W. Burgard, M. Moors, C. Stachniss and F. Schneider, Coordinated Multi-robot
    Exploration, IEEE Transactions on Robotics 21 (2005). Differs in: V is the distance as a
    share of the longest, and of equal values the nearer target is taken first.
    """
    table = cost_table(costs)
    robots, targets = table.shape
    apart = cost_table(between, "between")
    sees = np.asarray(visible, np.bool_)
    for name, shape in (("between", apart.shape), ("visible", sees.shape)):
        if shape != (targets, targets):
            raise InvalidInputError(
                f"{name} has the shape {shape}; for {targets} targets it must be square"
            )
    if not 0.0 < sensor_range_m < math.inf:
        raise InvalidInputError(f"sensor_range_m is {sensor_range_m}; it must be positive")
    if not 0.0 <= beta < math.inf:
        raise InvalidInputError(f"beta is {beta}; it must be 0 or more")

    share = table / (longest(table) or 1.0)
    seen_from_there = np.maximum(1.0 - apart / (2.0 * sensor_range_m), 0.0)  # P
    seen_from_there[~(sees | np.eye(targets, dtype=np.bool_))] = 0.0
    worth = np.ones(targets)  # U
    history = [worth]
    assignment = np.full(robots, NOBODY, np.int64)
    rounds: list[tuple[int, int, float, float]] = []
    waiting: BoolArray = np.count_nonzero(np.isfinite(table), axis=1) > 0
    while waiting.any():
        # Masked first, since inf * 0 would be NaN for beta = 0.
        offered = waiting[:, None] & np.isfinite(table)
        value = np.full(table.shape, -np.inf)
        np.subtract(worth, beta * np.where(offered, share, 0.0), out=value, where=offered)
        best = np.where(value == value.max(), table, np.inf)
        robot, target = divmod(int(np.argmin(best)), targets)
        assignment[robot] = target
        rounds.append((robot, target, float(worth[target]), float(share[robot, target])))
        waiting[robot] = False
        worth = worth - seen_from_there[target]
        history.append(worth)
    return UtilityAssignment(
        costs=table,
        assignment=assignment,
        rounds=tuple(rounds),
        utilities=np.array(history),
    )
