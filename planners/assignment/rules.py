"""RULES: scores of unexplored cells, looking ahead, giving way and exchanging goals.

Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D (Universidad de Guanajuato, 2018), sections 3.2.3, 3.2.4, 3.2.7 and 3.2.8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.planners.assignment.costs import check_robot, cost_table

SECTOR_RAD: Final = math.radians(15.0)
"""Half the width of the sectors in which obstacles and companions are looked for."""

EDGE: Final = 1e-9
"""In metres and radians: what lies on the border of a rectangle or a sector belongs to it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GoalChoice:
    """The best cell, and the scores of all.

    Attributes
    ----------
    distance, turn, others : (c,) array
        The terms P_d, P_a and P_r.
    scores : (c,) array
        ``base - P_d - P_a + P_r``.
    choice : int or None
        The cell that scored most; None: there is no cell.
    """

    distance: FloatArray
    turn: FloatArray
    others: FloatArray
    scores: FloatArray
    choice: int | None


def choose_cell(
    distances: ArrayLike,
    turns: ArrayLike,
    to_goals: ArrayLike,
    robots: int,
    diagonal_m: float,
    *,
    base: float = 70.0,
    distance_weight: float = 45.0,
    turn_weight: float = 25.0,
    others_weight: float = 30.0,
) -> GoalChoice:
    """Score unexplored cells and choose the best as a robot's goal.

    Parameters
    ----------
    distances : (c,) array
        Straight distance from the robot to each cell in metres.
    turns : (c,) array
        Direction of each cell less the robot's heading in radians; whole turns do not count.
    to_goals : (g, c) array
        Straight distance from the goal of each other robot that has one to each cell.
    robots : int
        How many robots the mission has (p), this one among them.
    diagonal_m : float
        The map's diagonal (the largest distance).
    base, distance_weight, turn_weight, others_weight : float
        The thesis's 70, 45, 25 and 30.

    Returns
    -------
    GoalChoice

    Raises
    ------
    InvalidInputError
        If shapes do not fit, a distance or turn is none, the diagonal is not positive, or
        there are more goals of others than other robots.

    Notes
    -----
    ``P_d = 45 d / D``, ``P_a = 25 |turn| / 360 degrees``, ``P_r = 30 (sum over goals of d / D)
    / p``. The thesis's prose calls the first two bonuses, its Equation 3.5 subtracts them, and
    so do we. A turn is never more than 180 degrees, so P_a is 12.5 at most; the thesis
    takes the plain difference of the two angles. Of equal scores the nearer cell, then the first.

    Source: section 3.2.3, Equations 3.2 to 3.5 and Algorithm 2.

    Examples
    --------
    >>> chosen = choose_cell([10.0, 10.0], [0.0, 0.0], [[5.0, 20.0]], 2, 100.0)
    >>> chosen.scores.tolist(), chosen.choice
    ([66.25, 68.5], 1)
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
    turn = turn_weight * (np.abs(_wrapped(angles)) / (2.0 * math.pi))
    others = others_weight * (spread / diagonal_m).sum(axis=0) / robots
    scores = base - distance - turn + others
    return GoalChoice(
        distance=distance,
        turn=turn,
        others=others,
        scores=scores,
        choice=int(np.lexsort((away, -scores))[0]) if len(away) else None,
    )


def cells_ahead(
    centres: ArrayLike,
    place: ArrayLike,
    goal: ArrayLike,
    cell_m: float,
    *,
    sector_rad: float = SECTOR_RAD,
) -> BoolArray:
    """Find the cells that lie ahead of a robot on its way to a goal.

    Parameters
    ----------
    centres : (c, 2) array
        Centres of cells in metres.
    place, goal : (2,) array
        Where the robot is and where it is bound for.
    cell_m : float
        Width of a cell.
    sector_rad : float
        How far a cell's bearing may be from the goal's, to either side.

    Returns
    -------
    (c,) array of bool

    Raises
    ------
    InvalidInputError
        If points are no pairs of numbers, or the cell is not positive.

    Notes
    -----
    An obstacle among them calls for a path around it: ``(cells_ahead(...) & obstacle).any()``.
    The rectangle has robot and goal in opposite corners. It is wider by half a cell all round
    than in the thesis, which counts cells: on a way along an axis it still has a cell's width.
    A cell in whose centre the robot stands has no bearing and is not ahead.

    Source: section 3.2.4.
    """
    points = _points(centres, "centres")
    start, end = _points(np.array([place, goal], np.float64), "place and goal")
    if not 0.0 < cell_m < math.inf:
        raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")
    margin = 0.5 * cell_m + EDGE
    low, high = np.minimum(start, end) - margin, np.maximum(start, end) + margin
    between: BoolArray = ((points >= low) & (points <= high)).all(axis=1)
    if np.array_equal(start, end):
        return np.zeros(len(points), np.bool_)
    return between & _in_sector(points - start, end - start, sector_rad)


def mates_ahead(
    robot: int,
    places: ArrayLike,
    heading_rad: float,
    inactive: ArrayLike,
    radius_m: float,
    *,
    sector_rad: float = SECTOR_RAD,
) -> BoolArray:
    """Find the companions that a robot has to stop for.

    Parameters
    ----------
    robot : int
        The row of the robot that looks.
    places : (n, 2) array
        Where all robots are, in metres.
    heading_rad : float
        The robot's heading.
    inactive : (n,) array of bool
        Who is flagged inactive, and so is ignored.
    radius_m : float
        How far the sector reaches (the conflict radius).
    sector_rad : float
        How far it reaches to either side of the heading.

    Returns
    -------
    (n,) array of bool

    Raises
    ------
    InvalidInputError
        If shapes do not fit, `robot` is no row, or the heading or radius is no number.

    Notes
    -----
    A companion at the very place of the robot counts, whatever the heading.

    Source: section 3.2.7.
    """
    points = _points(places, "places")
    idle = np.asarray(inactive, np.bool_)
    check_robot(robot, len(points))
    if idle.shape != (len(points),):
        raise InvalidInputError(f"inactive has the shape {idle.shape}; robots: {len(points)}")
    if not math.isfinite(heading_rad) or not radius_m >= 0.0:
        raise InvalidInputError(f"no sector has heading {heading_rad} and radius {radius_m}")
    offsets = points - points[robot]
    gaps = np.hypot(offsets[:, 0], offsets[:, 1])
    ahead = np.array([math.cos(heading_rad), math.sin(heading_rad)])
    found: BoolArray = (gaps <= radius_m + EDGE) & (
        _in_sector(offsets, ahead, sector_rad) | (gaps == 0.0)
    )
    found &= ~idle
    found[robot] = False
    return found


def exchange(robot: int, to_goals: ArrayLike, own: ArrayLike) -> int | None:
    """Find the robot with which one robot swaps goals.

    Parameters
    ----------
    robot : int
        The row of the robot that asks (i).
    to_goals : (n,) array
        What the way of this robot to each robot's goal costs; ``inf``: it has none, or that
        robot has no goal. Its own entry is not looked at.
    own : (n,) array
        What the way of each robot to its own goal costs.

    Returns
    -------
    The other robot, or None if all keep their goals.

    Raises
    ------
    InvalidInputError
        If the rows are of different lengths or hold what is no cost, or `robot` is no row.

    Notes
    -----
    A goal is taken when it costs this robot less than its own goal does, and less than it costs
    the robot that has it; of several the cheapest, then the lower id. The other gets this
    robot's goal, even where that is the longer way for it. When no robot has moved or chosen
    anew since, what was just swapped is not swapped back at once by the same two.

    Source: section 3.2.8, Algorithm 6.
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


def _points(values: ArrayLike, name: str) -> FloatArray:
    points = np.asarray(values, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise InvalidInputError(f"{name}: pairs x, y of finite numbers, not {points.shape}")
    return points


def _wrapped(angles: FloatArray) -> FloatArray:
    wrapped: FloatArray = (angles + math.pi) % (2.0 * math.pi) - math.pi
    return wrapped


def _in_sector(offsets: FloatArray, axis: FloatArray, half_rad: float) -> BoolArray:
    x, y = offsets[:, 0], offsets[:, 1]
    bearings = np.arctan2(y, x) - math.atan2(axis[1], axis[0])
    within: BoolArray = (np.abs(_wrapped(bearings)) <= half_rad + EDGE) & ((x != 0) | (y != 0))
    return within
