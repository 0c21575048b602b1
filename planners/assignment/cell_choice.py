"""RULES: scores of the unexplored cells around a robot, of which the best becomes its goal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.planners.assignment.costs import cost_table
from multisrt.planners.navigation.sector import wrapped

BASE_SCORE: Final = 70.0
"""Score of a cell at the robot's place, straight ahead, of a robot without teammates."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GoalChoice:
    """The scores of cells, and the cells ordered by them.

    Attributes
    ----------
    distance, turn, others : (c,) array
        The terms P_d, P_a and P_r.
    scores : (c,) array
        ``BASE_SCORE - P_d - P_a + P_r``.
    order : (c,) array of int
        Indices of the cells, that of the highest score first.
    """

    distance: FloatArray
    turn: FloatArray
    others: FloatArray
    scores: FloatArray
    order: IntArray


def choose_cell(
    distances: ArrayLike,
    turns: ArrayLike,
    to_goals: ArrayLike,
    robots: int,
    diagonal_m: float,
    *,
    distance_weight: float = 45.0,
    turn_weight: float = 25.0,
    others_weight: float = 30.0,
) -> GoalChoice:
    """Score unexplored cells and order them, the best goal of a robot first.

    Parameters
    ----------
    distances : (c,) array
        Euclidean distance from the robot to each cell in metres.
    turns : (c,) array
        Bearing of each cell relative to the robot's heading in radians, modulo full turns.
    to_goals : (g, c) array
        Euclidean distance in metres from each goal of another robot to each cell.
    robots : int
        Number of robots of the mission (p), including this one.
    diagonal_m : float
        Diagonal of the map in metres (D).
    distance_weight, turn_weight, others_weight : float
        Weights of the three terms; the defaults are those of the thesis.

    Returns
    -------
    GoalChoice

    Raises
    ------
    InvalidInputError
        If shapes do not match, a distance or turn is not valid, the diagonal is not positive, or
        there are more goals of other robots than other robots.

    Notes
    -----
    ``P_d = 45 d / D``, ``P_a = 25 |turn| / 360 degrees``, ``P_r = 30 (sum over goals of d / D)
    / p``. Of equal scores the smaller P_d comes first, then the lower index. A turn is at most 180
    degrees, so that P_a is at most 12.5.

    Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
    escenarios 2D (Universidad de Guanajuato, 2018), section 3.2.3, Equations 3.2 to 3.5 and
    Algorithm 2. Differs in: the thesis takes the plain difference of the two angles. Its prose
    calls the first two terms bonuses, but its Equation 3.5 subtracts them, as is done here.

    Examples
    --------
    >>> chosen = choose_cell([10.0, 10.0], [0.0, 0.0], [[5.0, 20.0]], 2, 100.0)
    >>> chosen.scores.tolist(), chosen.order.tolist()
    ([66.25, 68.5], [1, 0])
    """
    away = cost_table(distances, "distances", dimensions=1)
    angles = np.asarray(turns, np.float64)
    spread = cost_table(to_goals, "to_goals")
    if angles.shape != away.shape or not np.isfinite(angles).all():
        raise InvalidInputError(f"turns are {len(away)} finite angles, one for each cell")
    if spread.shape[1] != len(away):
        raise InvalidInputError(
            f"to_goals has {spread.shape[1]} columns; there are {len(away)} cells"
        )
    if not len(spread) < robots:
        raise InvalidInputError(f"robots is {robots}; others alone have {len(spread)} goals")
    if not 0.0 < diagonal_m < math.inf:
        raise InvalidInputError(f"diagonal_m is {diagonal_m}; it must be positive")

    distance = distance_weight * (away / diagonal_m)
    turn = turn_weight * (np.abs(wrapped(angles)) / (2.0 * math.pi))
    others = others_weight * (spread / diagonal_m).sum(axis=0) / robots
    scores = BASE_SCORE - distance - turn + others
    return GoalChoice(
        distance=distance,
        turn=turn,
        others=others,
        scores=scores,
        order=np.lexsort((distance, -scores)),
    )
