"""GAIN with tours: the value of a target, and what it does to the rest of the way."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.planners.assignment.costs import cost_table
from multisrt.planners.assignment.gain import (
    Auction,
    GainChoice,
    LazyCosts,
    Values,
    check_positive,
    checked_tables,
)
from multisrt.planners.assignment.open_tours import open_tours

MAX_STOPS: Final = 12
"""Number of targets of a tour: the best ones by their values."""

LEAVING: Final = 0.5
"""Length added where a tour goes on from a target, in square roots of the area there.

Beyond a large area there is more to explore, so that a robot comes back from there later than it
seems. Tours therefore end at large areas rather than at scraps.
"""

SEARCH_M_PER_M2: Final = 0.15
"""Way in metres that a robot needs to explore a square metre beyond a target it has taken."""

MIN_AREA_M2: Final = 0.01
"""Smaller areas count as this one, so that the way to a target that is worth nothing is finite."""


def gain_on_tours(
    costs: ArrayLike | LazyCosts,
    areas: ArrayLike,
    between: ArrayLike,
    lengths: ArrayLike,
    robot: int,
    *,
    rule: Values,
    return_area_m2: float = 5.0,
    tour_weight: float = 2.0,
) -> GainChoice:
    """Choose a target for one robot by its value and by the tour of the rest that is left.

    Parameters
    ----------
    costs : (n, m) array or LazyCosts
        Cost of each robot to each target in metres; ``inf`` where there is no path.
    areas : (m,) array
        Area that would be seen at each target in square metres.
    between : (m, m) array
        Euclidean distances between targets in metres.
    lengths : (m, m) array
        Lengths of the paths between targets in metres, finite and symmetric.
    robot : int
        Row of the robot that chooses.
    rule : Values
        How targets are valued, as in `gain`.
    return_area_m2 : float
        Added to every area: what stands for the way back to a target that is left behind.
    tour_weight : float
        Weight of the length of the tour against the way to its first target.

    Returns
    -------
    GainChoice
        Its rounds end with the one in which the robot takes the target that it chooses. The choice
        is None if the others leave it no target.

    Raises
    ------
    InvalidInputError
        If a table has the wrong shape, a negative entry or NaN, `lengths` has an infinite one, or a
        parameter is not positive.

    Notes
    -----
    All targets are taken as in `gain`, by the lengths given; where a robot goes on from a target,
    its way grows by what it needs to explore the area there. Of the targets that the robot takes,
    it chooses that with the least ``s_j + w (T_j - min T)``. Here s_j is the way to target j, made
    longer by the factor ``(h / area_j) ** (1 / power)`` with h the disc of the range finder,
    so that the least s_j has the highest value; T_j is the length of the shortest tour of the
    targets that begins with j, and w the weight of tours.

    Source: of our own; tours of frontiers are those of Kulich, Faigl and Přeučil (2011); differs
    in: areas count as well, and the tour of each first target is compared.

    Examples
    --------
    The robot is beside a corner of 2 m2. The hall is worth 20 times as much, but it would have to
    come back for the corner from there:

    >>> costs, areas = [[3.0, 5.0]], [2.0, 40.0]
    >>> far = [[0.0, 8.0], [8.0, 0.0]]
    >>> gain_on_tours(costs, areas, far, far, 0, rule=Values(6.0)).choice
    0
    >>> gain_on_tours(costs, areas, far, far, 0, rule=Values(6.0), tour_weight=0.01).choice
    1
    """
    costs, cost_of = costs if isinstance(costs, LazyCosts) else (costs, None)
    table, beyond, apart = checked_tables(costs, areas, between, robot)
    ways = cost_table(lengths, "lengths")
    if ways.shape != apart.shape:
        raise InvalidInputError(f"lengths has the shape {ways.shape}; it must be {apart.shape}")
    if not np.isfinite(ways).all():
        raise InvalidInputError("lengths has an infinite entry; give targets that paths connect")
    check_positive(**rule._asdict(), tour_weight=tour_weight)
    if not 0.0 <= return_area_m2 < math.inf:
        raise InvalidInputError(f"return_area_m2 is {return_area_m2}; it must be 0 or more")

    worth = beyond + return_area_m2
    auction = Auction(table, worth, apart, rule, robot, cost_of)
    rounds: list[tuple[int, int, float, float]] = []
    while auction.is_open_to(robot):
        rounds.append(auction.next_round())
        taker, target = rounds[-1][:2]
        auction.go_on(taker, target, ways[target] + SEARCH_M_PER_M2 * beyond[target])
    own = np.array([target for taker, target, _, _ in rounds if taker == robot], np.int64)
    if not len(own):
        return GainChoice(choice=None, rounds=())

    disc_m2 = math.pi * rule.range_m**2
    factors = libm.power(disc_m2 / np.maximum(worth[own], MIN_AREA_M2), 1.0 / rule.power)
    scores = (table[robot, own] + rule.nearest_m) * factors
    order = np.argsort(scores, kind="stable")[:MAX_STOPS]
    own, scores = own[order], scores[order]
    tours = open_tours(table[robot, own], ways[np.ix_(own, own)], LEAVING * np.sqrt(beyond[own]))
    choice = int(own[np.argmin(scores + tour_weight * (tours - tours.min()))])
    turn = next(k for k, pair in enumerate(rounds) if pair[:2] == (robot, choice))
    return GainChoice(choice=choice, rounds=tuple(rounds[: turn + 1]))
