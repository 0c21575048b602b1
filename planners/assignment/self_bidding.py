"""SELF-BIDDING: a robot bids for itself and for its team, where it can within reach of the others.

Source: J. C. Elizondo, G. Ramírez, E. Rodriguez and J. R. Martínez, Multi-robot Exploration Using
Self-Biddings under Constraints on Communication Range (SBX-R), sections III.A and III.B.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import (
    UNASSIGNED,
    DenseCosts,
    check_robot,
    cost_table,
    largest_finite,
)

TIE_M: Final = 1e-6
"""Matchings are equally good if their total bids differ by at most this, in metres."""

MAX_STEPS: Final = 10_000
"""Maximum number of radii tried, up to the last: the increment is larger if it needs more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CohesionRadii:
    """The radii of cohesion (phi) to try: ``range_m * (first + k * step)``, k = 0, 1, 2...

    Attributes
    ----------
    range_m : float
        Communication range (beta) in metres; ``inf`` if unlimited.
    diagonal_m : float
        Diagonal of the map in metres; the first radius above it is the last.
    first, step : float
        First factor (the paper's j) and its increment, which is larger if crossing the map would
        take more than `MAX_STEPS` radii.

    Raises
    ------
    InvalidInputError
        If a number is not positive, or the diagonal is infinite.
    """

    range_m: float
    diagonal_m: float
    first: float = 0.9
    step: float = 0.5

    def __post_init__(self) -> None:
        for name in ("range_m", "first", "step"):
            if not getattr(self, name) > 0.0:
                raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be positive")
        if not 0.0 < self.diagonal_m < math.inf:
            raise InvalidInputError(f"diagonal_m is {self.diagonal_m}; it must be positive")

    def radius_m(self, k: int) -> float:
        """Return radius k in metres."""
        longer = max(1.0, self.diagonal_m / (MAX_STEPS * self.step * self.range_m))
        return self.range_m * (self.first + self.step * longer * k)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BidStep:
    """One iteration of the loop that increases the radius of cohesion.

    Attributes
    ----------
    phi_m : float
        The radius tried, in metres.
    bids : (n, m) array
        All robots' bids under it in metres; ``inf`` where the bridge to the others would break.
    """

    phi_m: float
    bids: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SelfBid:
    """One robot's choice, and the tables of bids that it is based on.

    Attributes
    ----------
    path_lengths : (n, m) array
        Path length of each robot to each frontier by way of its present goal (rho + a), in metres.
    steps : tuple of BidStep
        The radii tried with their tables; the last was matched.
    matching : (n,) array of int
        The frontier matched to each robot; -1 for a virtual one.
    choice : int or None
        The robot's own frontier: the nearest, if it was matched to a virtual one; None if it can
        reach none.
    """

    path_lengths: FloatArray
    steps: tuple[BidStep, ...]
    matching: IntArray
    choice: int | None

    @property
    def phi_m(self) -> float:
        """The radius of cohesion that was used, in metres."""
        return self.steps[-1].phi_m

    @property
    def bids(self) -> FloatArray:
        """The table of bids that was matched, ``(n, m)``."""
        return self.steps[-1].bids


def self_bidding(
    robot: int,
    rho: ArrayLike,
    a: ArrayLike,
    path_gap: ArrayLike,
    frontier_gap: ArrayLike,
    radii: CohesionRadii,
) -> SelfBid:
    """Choose one robot's frontier by the bids that it computes for all robots.

    Parameters
    ----------
    robot : int
        Number of the robot that chooses (k).
    rho : (n,) array
        Remaining path length of each robot to its goal in metres; 0 for a robot at its goal.
    a : (n, m) array
        Path length from each robot's goal to each frontier in metres; ``inf`` where none leads.
    path_gap : (n, m) array
        Maximum Euclidean distance in metres from a point on the path of that robot to that
        frontier to the nearest goal of *another* robot. Ignored for a single robot.
    frontier_gap : (n, m) array
        Euclidean distance in metres from the frontier to the nearest *other* robot. Likewise.
    radii : CohesionRadii
        The radii of cohesion to try.

    Returns
    -------
    SelfBid

    Raises
    ------
    InvalidInputError
        If shapes do not match, an entry is negative or NaN, or there is no such robot.

    Notes
    -----
    Algorithm 2 of the paper. Equation 1: ``b_k^i = (rho_k + a_k^i) - mean over j != k of
    (rho_j + a_j^i)`` if every point of the path lies within phi of another robot's goal, else
    infinite. Only frontiers nearer than phi to another robot take part. phi grows until `robot`
    has a finite bid or phi exceeds the diagonal. Then the table, padded by virtual frontiers at a
    large cost, is matched at minimum cost. A robot matched to a virtual frontier goes to its
    nearest frontier, whatever phi is and whichever other robot goes there too: the paper wants the
    bridge held so. A robot alone has no penalty and goes to its nearest frontier.

    Where all robots have paths to all frontiers, rho adds the same number to all bids of a robot.
    It then decides only which robots go without, where frontiers or finite bids are too few.

    Differs in, where the paper leaves it open: phi bounds the path as in Equation 1, where the
    text above it has 0.9 phi; a robot left with infinite bids only counts as matched to a virtual
    frontier; another robot without a path to a frontier counts there with the diagonal, or the
    longest finite path if that is longer; among equally good matchings the lower robot gets the
    nearer frontier (see `minimum_matching`).

    Examples
    --------
    >>> near = [[1.0, 1.0], [1.0, 1.0]]
    >>> radii = CohesionRadii(range_m=10.0, diagonal_m=30.0)
    >>> bid = self_bidding(0, [0, 0], [[2, 5], [3, 9]], near, near, radii)
    >>> bid.bids.tolist(), bid.matching.tolist(), bid.choice
    ([[-1.0, -4.0], [1.0, 4.0]], [1, 0], 1)
    """
    goals_left = cost_table(rho, "rho", dimensions=1)
    onward = cost_table(a, "a")
    robots = len(goals_left)
    check_robot(robot, robots)
    if len(onward) != robots:
        raise InvalidInputError(f"a has {len(onward)} rows; rho has {robots} robots")
    gaps = [cost_table(path_gap, "path_gap"), cost_table(frontier_gap, "frontier_gap")]
    for name, gap in zip(("path_gap", "frontier_gap"), gaps, strict=True):
        if gap.shape != onward.shape:
            raise InvalidInputError(f"{name} has the shape {gap.shape}; a has {onward.shape}")

    path_lengths = goals_left[:, None] + onward
    offers = _offers(path_lengths, radii.diagonal_m)
    # A bid is finite once phi exceeds this; a robot alone has no bridge to keep.
    bridge = np.maximum(*gaps) if robots > 1 else np.zeros_like(path_lengths)
    bridge[~np.isfinite(path_lengths)] = np.inf
    steps: list[BidStep] = []
    while True:
        phi_m = radii.radius_m(len(steps))
        bids = np.where(bridge < phi_m, offers, np.inf)
        steps.append(BidStep(phi_m=phi_m, bids=bids))
        if np.isfinite(bids[robot]).any() or phi_m > radii.diagonal_m:
            break

    matching = minimum_matching(bids, path_lengths)
    matched = int(matching[robot])
    return SelfBid(
        path_lengths=path_lengths,
        steps=tuple(steps),
        matching=matching,
        choice=closest(DenseCosts(path_lengths), robot) if matched == UNASSIGNED else matched,
    )


def _offers(path_lengths: FloatArray, diagonal_m: float) -> FloatArray:
    """Return Equation 1 without its penalty: exploitation minus exploration, ``(n, m)``."""
    robots = len(path_lengths)
    if robots == 1:
        return path_lengths.copy()
    counted = np.where(
        np.isfinite(path_lengths), path_lengths, max(diagonal_m, largest_finite(path_lengths))
    )
    others = np.array([np.delete(counted, k, axis=0).mean(axis=0) for k in range(robots)])
    offers: FloatArray = counted - others
    return offers


def minimum_matching(bids: ArrayLike, path_lengths: ArrayLike) -> IntArray:
    """Match robots to frontiers at the minimum sum of bids.

    Parameters
    ----------
    bids : (n, m) array
        Bids in metres, possibly negative; ``inf`` for pairs that must not be matched.
    path_lengths : (n, m) array
        Path lengths in metres, which break ties.

    Returns
    -------
    (n,) array of int
        Each robot's frontier; -1 for none. The number of matched robots is the largest possible.

    Notes
    -----
    Among the matchings within `TIE_M` of the best, robot 0 gets its nearest frontier, then robot
    1 the nearest of the remaining ones, and so on. Equally good matchings are frequent, for
    instance where two robots both have to pass the first of two frontiers to get to the second.

    Source: the Hungarian method of the paper, by `scipy.optimize.linear_sum_assignment`; differs
    in: the paper pads the table to a square; a virtual frontier for every robot has the same best
    matchings. Cost: one matching, and one more for each frontier nearer to a robot than its own.

    Examples
    --------
    >>> minimum_matching([[-1.0, 0.0], [1.0, 0.0]], [[4.0, 5.0], [5.0, 5.0]]).tolist()
    [0, 1]
    >>> minimum_matching([[float("inf")], [2.0]], [[1.0], [1.0]]).tolist()
    [-1, 0]
    """
    offered = np.asarray(bids, np.float64)
    distances = np.asarray(path_lengths, np.float64)
    robots, frontiers = offered.shape
    finite: BoolArray = np.isfinite(offered)
    if not finite.any():
        return np.full(robots, UNASSIGNED, np.int64)

    # One more finite bid outweighs all effects on the other bids. Each robot has a virtual
    # frontier, which is cheaper than an infinite bid.
    spread = float(offered[finite].max() - offered[finite].min())
    large = float(np.abs(offered[finite]).max()) + (spread + 1.0) * robots
    padded = np.full((robots, frontiers + robots), large)
    padded[:, :frontiers] = np.where(finite, offered, 3.0 * large)

    everyone = np.arange(robots)
    columns = linear_sum_assignment(padded)[1]
    lowest = float(padded[everyone, columns].sum())
    for robot in range(robots):
        for frontier in np.argsort(distances[robot], kind="stable").tolist():
            if frontier == columns[robot]:
                break
            if not finite[robot, frontier] or frontier in columns[:robot]:
                continue
            tried = _matched_from(padded, columns, robot, frontier)
            if float(padded[everyone, tried].sum()) <= lowest + TIE_M:
                columns = tried
                break
    return np.where(columns < frontiers, columns, UNASSIGNED).astype(np.int64)


def _matched_from(padded: FloatArray, columns: IntArray, robot: int, column: int) -> IntArray:
    """Return the best matching that keeps the rows before `robot` and gives it this column."""
    tried = columns.copy()
    tried[robot] = column
    free = np.setdiff1d(np.arange(padded.shape[1]), tried[: robot + 1])
    rest = linear_sum_assignment(padded[robot + 1 :, free])[1]
    tried[robot + 1 :] = free[rest]
    return tried
