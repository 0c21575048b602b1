"""GAIN with tours: the value of a target, and the length of the tour that it begins."""

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
    ValueParameters,
    check_positive,
    checked_tables,
)
from multisrt.planners.assignment.open_tours import open_tours

MAX_STOPS: Final = 12
"""Maximum number of targets of a tour: those of the highest values."""

LEAVING: Final = 0.5
"""Length added where a tour leaves a target, as a multiple of the square root of the area there.

A robot comes back late from a large area, beyond which there is more to explore. With this length
tours end at large areas rather than at small ones.
"""

SEARCH_M_PER_M2: Final = 0.15
"""Path length in metres that a robot needs to explore a square metre beyond a target it took."""

MIN_AREA_M2: Final = 0.01
"""Smaller areas count as this one, so that the scores of targets without any area are finite."""


def gain_on_tours(
    costs: ArrayLike | LazyCosts,
    areas: ArrayLike,
    distances: ArrayLike,
    path_lengths: ArrayLike,
    robot: int,
    *,
    parameters: ValueParameters,
    tour_weight: float = 2.0,
    preferred: ArrayLike | None = None,
) -> GainChoice:
    """Choose a target for one robot by its value and by the tour of the others that it begins.

    Parameters
    ----------
    costs : (n, m) array or LazyCosts
        Cost of each robot to each target in metres; ``inf`` where there is no path.
    areas : (m,) array
        Area that would be seen at each target in square metres.
    distances : (m, m) array
        Euclidean distances between targets in metres.
    path_lengths : (m, m) array
        Lengths of the paths between targets in metres, finite and symmetric.
    robot : int
        Row of the robot that chooses.
    parameters : ValueParameters
        Parameters of the values, as in `gain`, and the area added to every area.
    tour_weight : float
        Weight of the length of the tour against the cost of its first target.
    preferred : (m,) array of bool, optional
        Targets before all others: if the robot takes some of them, its tour visits these alone.

    Returns
    -------
    GainChoice
        The rounds end with that in which the robot takes the target that it chooses. The choice is
        None if the others leave it no target.

    Raises
    ------
    InvalidInputError
        If a table has the wrong shape, a negative entry or NaN, `path_lengths` has an infinite
        one, `preferred` is no array of bool, or a parameter is out of its range.

    Notes
    -----
    All targets are taken as in `gain`, by the path lengths given; where a robot goes on from a
    target, its costs increase by what it needs to explore the area there. Of the targets that the
    robot takes, it chooses that with the least ``s_j + w (T_j - min T)``. Here s_j is the cost of
    target j plus `offset_m`, times the factor ``(h / area_j) ** (1 / power)`` with h the area of
    the disc in range, so that the target of the highest value has the least s_j; T_j is the length
    of a short tour of the targets that begins with j, and w the weight of tours.

    Source: of this project; tours of frontiers are those of Kulich, Faigl and Přeučil (2011);
    differs in: areas count as well, and the tours of all first targets are compared.

    Examples
    --------
    The robot is near a corner of 2 m2. The area of the hall is 20 times as large, but the robot
    would have to come back from there to the corner:

    >>> costs, areas = [[3.0, 5.0]], [2.0, 40.0]
    >>> far = [[0.0, 8.0], [8.0, 0.0]]
    >>> sight = ValueParameters(6.0)
    >>> gain_on_tours(costs, areas, far, far, 0, parameters=sight).choice
    0
    >>> gain_on_tours(costs, areas, far, far, 0, parameters=sight, tour_weight=0.01).choice
    1
    """
    costs, cost_of = costs if isinstance(costs, LazyCosts) else (costs, None)
    table, beyond, euclidean = checked_tables(costs, areas, distances, robot)
    lengths, right = cost_table(path_lengths, "path_lengths"), euclidean.shape
    if lengths.shape != right:
        raise InvalidInputError(f"path_lengths has the shape {lengths.shape}; it must be {right}")
    if not np.isfinite(lengths).all():
        raise InvalidInputError(
            "path_lengths has an infinite entry; give targets that paths connect"
        )
    parameters.check()
    check_positive(tour_weight=tour_weight)
    first = np.zeros(len(beyond), np.bool_) if preferred is None else np.asarray(preferred)
    if first.shape != beyond.shape or first.dtype != np.bool_:
        raise InvalidInputError(
            f"preferred is {first.dtype} of shape {first.shape}; "
            f"it must be bool of shape {beyond.shape}"
        )

    auction = Auction(table, beyond, euclidean, parameters, robot, cost_of)
    rounds: list[tuple[int, int, float, float]] = []
    while auction.is_open_to(robot):
        rounds.append(auction.next_round())
        taker, target = rounds[-1][:2]
        auction.go_on(taker, target, lengths[target] + SEARCH_M_PER_M2 * beyond[target])
    own = np.array([target for taker, target, _, _ in rounds if taker == robot], np.int64)
    if not len(own):
        return GainChoice(choice=None, rounds=())
    if first[own].any():
        own = own[first[own]]

    worth = beyond + parameters.return_area_m2
    disc_m2 = math.pi * parameters.range_m**2
    factors = libm.power(disc_m2 / np.maximum(worth[own], MIN_AREA_M2), 1.0 / parameters.power)
    scores = (table[robot, own] + parameters.offset_m) * factors
    order = np.argsort(scores, kind="stable")[:MAX_STOPS]
    own, scores = own[order], scores[order]
    tours = open_tours(table[robot, own], lengths[np.ix_(own, own)], LEAVING * np.sqrt(beyond[own]))
    choice = int(own[np.argmin(scores + tour_weight * (tours - tours.min()))])
    turn = next(k for k, pair in enumerate(rounds) if pair[:2] == (robot, choice))
    return GainChoice(choice=choice, rounds=tuple(rounds[: turn + 1]))
