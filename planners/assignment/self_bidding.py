"""SELF-BIDDING: a robot bids for itself and for its team, and keeps within reach of the others.

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
from multisrt.planners.assignment.costs import NOBODY, check_robot, cost_table, longest

TIE_M: Final = 1e-6
"""Matchings whose total bids differ by no more than this are equally good."""

MOST_STEPS: Final = 10_000
"""A communication range that would need more steps to cross the map is refused."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BidStep:
    """One turn of the loop that widens the radius of cohesion.

    Attributes
    ----------
    phi_m : float
        The radius that was tried.
    bids : (n, m) array
        All robots' bids under it; ``inf`` where the bridge to the others would break.
    """

    phi_m: float
    bids: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SelfBid:
    """What one robot chose, and the tables of bids that led to it.

    Attributes
    ----------
    ways : (n, m) array
        How far each robot has to each frontier by way of its present goal (rho + a), in metres.
    steps : tuple of BidStep
        The radii tried, with their tables; the last one was matched.
    matching : (n,) array of int
        The frontier matched to each robot; -1: a virtual one.
    choice : int or None
        The robot's own frontier; None: it can reach none.
    is_virtual : bool
        Whether it was matched to no real frontier and so chose the nearest.
    """

    ways: FloatArray
    steps: tuple[BidStep, ...]
    matching: IntArray
    choice: int | None
    is_virtual: bool

    @property
    def phi_m(self) -> float:
        """The radius of cohesion that was used."""
        return self.steps[-1].phi_m

    @property
    def bids(self) -> FloatArray:
        """The table of bids that was matched."""
        return self.steps[-1].bids


def self_bidding(
    robot: int,
    rho: ArrayLike,
    a: ArrayLike,
    path_gap: ArrayLike,
    frontier_gap: ArrayLike,
    *,
    radio_range_m: float,
    diagonal_m: float,
    j0: float = 0.9,
    dj: float = 0.5,
) -> SelfBid:
    """Choose one robot's frontier by the bids that it reckons all robots would make.

    Parameters
    ----------
    robot : int
        The row of the robot that chooses (k).
    rho : (n,) array
        What is left of each robot's way to its goal, in metres; 0 for a robot that is there.
    a : (n, m) array
        Geodesic distance from each robot's goal to each frontier; ``inf``: no way.
    path_gap : (n, m) array
        Along the path of that robot to that frontier, the largest straight distance of any of
        its points from the nearest goal of *another* robot. Not looked at for a robot alone.
    frontier_gap : (n, m) array
        Straight distance of the frontier from the nearest *other* robot. Likewise.
    radio_range_m : float
        Communication range (beta); ``inf``: unlimited.
    diagonal_m : float
        The map's diagonal.
    j0, dj : float
        The radius phi is ``beta * j``, where j begins with `j0` and grows by `dj`.

    Returns
    -------
    SelfBid

    Raises
    ------
    InvalidInputError
        If an array has the wrong shape or holds what is no distance, `robot` is no row, a
        number is not positive, or the range is too small for the map.

    Notes
    -----
    Algorithm 2 of the paper. Equation 1: ``b_k^i = (rho_k + a_k^i) - mean over j != k of
    (rho_j + a_j^i)`` if every point of the path lies within phi of another robot's goal, else
    infinite; frontiers take part that are nearer than phi to another robot. A robot alone pays
    no such penalty and has no others to compare itself with: it goes to its nearest frontier.
    phi grows until `robot` has a finite bid or phi exceeds the diagonal. Then the table, padded
    by virtual frontiers at a large cost, is matched at minimum cost; a robot that gets no real
    frontier takes its nearest, whoever else goes there: that holds the bridge.

    The paper's gaps, settled: phi bounds the path as Equation 1 has it, where the text above it
    has 0.9 phi; a robot that could only be matched at an infinite bid counts as matched to a
    virtual frontier; a companion that has no way to a frontier
    counts there with the diagonal, or the longest finite way if that is more. Equally good
    matchings are frequent (two robots that both must pass the first of two frontiers to get to
    the second): robots in the order of their ids get the nearest frontier that a best matching
    leaves them.

    Examples
    --------
    >>> near = [[1.0, 1.0], [1.0, 1.0]]
    >>> bid = self_bidding(
    ...     0, [0, 0], [[2, 5], [3, 9]], near, near, radio_range_m=10, diagonal_m=30
    ... )
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
    for name, value in (("radio_range_m", radio_range_m), ("j0", j0), ("dj", dj)):
        if not value > 0.0:
            raise InvalidInputError(f"{name} is {value}; it must be positive")
    if not 0.0 < diagonal_m < math.inf:
        raise InvalidInputError(f"diagonal_m is {diagonal_m}; it must be positive")
    if diagonal_m > MOST_STEPS * dj * radio_range_m:
        raise InvalidInputError(
            f"radio_range_m is {radio_range_m}; it is too small for a map of {diagonal_m:g} m"
        )

    ways = goals_left[:, None] + onward
    offers = _offers(ways, diagonal_m)
    # All that phi has to exceed; alone, there is nobody to lose.
    bridge = np.maximum(*gaps) if robots > 1 else np.zeros_like(ways)
    bridge[~np.isfinite(ways)] = np.inf
    steps: list[BidStep] = []
    while True:
        phi_m = radio_range_m * (j0 + dj * len(steps))
        bids = np.where(bridge < phi_m, offers, np.inf)
        steps.append(BidStep(phi_m=phi_m, bids=bids))
        if np.isfinite(bids[robot]).any() or phi_m > diagonal_m:
            break

    matching = minimum_matching(bids, ways)
    matched = int(matching[robot])
    return SelfBid(
        ways=ways,
        steps=tuple(steps),
        matching=matching,
        choice=closest(ways[robot]) if matched == NOBODY else matched,
        is_virtual=matched == NOBODY,
    )


def _offers(ways: FloatArray, diagonal_m: float) -> FloatArray:
    # Equation 1 without its penalty: exploitation minus exploration.
    robots = len(ways)
    if robots == 1:
        return ways.copy()
    counted = np.where(np.isfinite(ways), ways, max(diagonal_m, longest(ways)))
    others = np.array([np.delete(counted, k, axis=0).mean(axis=0) for k in range(robots)])
    offers: FloatArray = counted - others
    return offers


def minimum_matching(bids: ArrayLike, ways: ArrayLike) -> IntArray:
    """Match robots to frontiers so that the sum of their bids is least.

    Parameters
    ----------
    bids : (n, m) array
        In metres, negative ones too; ``inf``: not to be had.
    ways : (n, m) array
        Distances in metres, by which ties are broken.

    Returns
    -------
    (n,) array of int
        Each robot's frontier, -1 for none. As many robots as can have a finite bid get one.

    Notes
    -----
    The Hungarian method of the paper, by `scipy.optimize.linear_sum_assignment`. Among the
    matchings within `TIE_M` of the best, the one in which robot 0 has its nearest frontier, then
    robot 1 its nearest that is left, and so on. Differs in: the paper pads the table to a square;
    a virtual frontier for every robot has the same best matchings. Cost: one matching, and one
    for every frontier that is nearer to a robot than what it has.
    """
    offered = np.asarray(bids, np.float64)
    distances = np.asarray(ways, np.float64)
    robots, frontiers = offered.shape
    finite: BoolArray = np.isfinite(offered)
    if not finite.any():
        return np.full(robots, NOBODY, np.int64)

    # So large that one finite bid more outweighs whatever it does to the others. Each robot has
    # a virtual frontier, before which it takes no real one that is not to be had.
    spread = float(offered[finite].max() - offered[finite].min())
    large = float(np.abs(offered[finite]).max()) + (spread + 1.0) * robots
    padded = np.full((robots, frontiers + robots), large)
    padded[:, :frontiers] = np.where(finite, offered, 3.0 * large)

    everyone = np.arange(robots)
    columns = linear_sum_assignment(padded)[1]
    least = float(padded[everyone, columns].sum())
    for robot in range(robots):
        for frontier in np.argsort(distances[robot], kind="stable").tolist():
            if frontier == columns[robot]:
                break
            if not finite[robot, frontier] or frontier in columns[:robot]:
                continue
            tried = _matched_from(padded, columns, robot, frontier)
            if float(padded[everyone, tried].sum()) <= least + TIE_M:
                columns = tried
                break
    return np.where(columns < frontiers, columns, NOBODY).astype(np.int64)


def _matched_from(padded: FloatArray, columns: IntArray, robot: int, column: int) -> IntArray:
    # The best matching that keeps the rows before `robot` and gives it this column.
    tried = columns.copy()
    tried[robot] = column
    free = np.setdiff1d(np.arange(padded.shape[1]), tried[: robot + 1])
    rest = linear_sum_assignment(padded[robot + 1 :, free])[1]
    tried[robot + 1 :] = free[rest]
    return tried
