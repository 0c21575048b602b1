"""GAIN: the area that a robot would see at a target, against the cost of the path there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.assignment.costs import check_robot, cost_table


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GainChoice:
    """What one robot chooses, and what the robots before it took.

    Attributes
    ----------
    choice : int or None
        The target; None if the robot can reach none.
    rounds : tuple of (robot, target, area, value)
        The pairs in the order in which they were taken, up to the robot's own: the area that was
        left to the target for the robot in square metres, with the return area, and its value. If
        the robot shares a target, they are those of the second auction, in which others may take
        other targets.
    """

    choice: int | None
    rounds: tuple[tuple[int, int, float, float], ...]


def gain(
    costs: ArrayLike | LazyCosts,
    areas: ArrayLike,
    distances: ArrayLike,
    robot: int,
    *,
    range_m: float,
    power: float = 4.0,
    offset_m: float = 0.5,
    overlap_ranges: float = 1.0,
) -> GainChoice:
    """Choose the target of the highest value for one robot, after those that come before it.

    Parameters
    ----------
    costs : (n, m) array or LazyCosts
        Cost of each robot to each target in metres; ``inf`` where there is no path.
    areas : (m,) array
        Area of each target in square metres: that which would be seen there, and a return area for
        the path back if the target is left behind.
    distances : (m, m) array
        Euclidean distances between targets in metres.
    robot : int
        Row of the robot that chooses.
    range_m : float
        Range of the range finder in metres.
    power : float
        Exponent of the cost in the denominator of the value.
    offset_m : float
        Length in metres added to every cost, so that near targets are compared by their areas.
    overlap_ranges : float
        Distance, in ranges, at and beyond which a target that is taken no longer reduces the area
        of another. Areas seen from two places overlap up to 2.

    Returns
    -------
    GainChoice

    Raises
    ------
    InvalidInputError
        If a table has the wrong shape, a negative entry or NaN, or a parameter is not positive.

    Notes
    -----
    The value of a target j for a robot i is ``area_j / (cost_ij + offset_m) ** power``. Pairs of a
    robot and a target are taken in order of value, of equal ones that of the lowest cost first,
    then of the lowest numbers, until the robot that chooses has its first target. Once a robot has
    taken a target, its paths to the others lead over that one, and cost accordingly, by the
    Euclidean distances from one to the next. So a robot leaves targets on the route of another to
    that one. A target that is taken reduces, for all other robots, the area of each other target by
    the factor ``min(1, d / (overlap_ranges * range_m))`` with d the distance between the two.

    A robot to which the others leave nothing shares a target: in a second auction, each robot takes
    one target only, and targets may be taken again.

    Source: the value is that of role-based exploration (de Hoog, Cameron and Visser, 2010: area
    over a power of the path length); differs in: robots take targets in order of value, reduce
    the areas near these, as in Burgard et al. (2005), and go on from there, as in sequential
    single-item auctions (Lagoudakis et al., 2005).

    Examples
    --------
    Both robots are nearer to the closet. Its area is small, so robot 0 takes the hall and leaves
    the closet to robot 1:

    >>> costs = [[4.0, 6.0], [5.0, 8.0]]
    >>> areas, distances = [1.0, 40.0], [[0.0, 9.0], [9.0, 0.0]]
    >>> [gain(costs, areas, distances, i, range_m=8.0, power=2.0).choice for i in (0, 1)]
    [1, 0]
    """
    costs, cost_of = costs if isinstance(costs, LazyCosts) else (costs, None)
    table, left, euclidean = checked_tables(costs, areas, distances, robot)
    parameters = ValueParameters(range_m, power, offset_m, overlap_ranges, return_area_m2=0.0)
    parameters.check()
    for goes_on in (True, False):
        auction = Auction(table, left, euclidean, parameters, robot, cost_of)
        rounds = _taken(auction, euclidean, robot, goes_on=goes_on)
        if rounds and rounds[-1][0] == robot:
            return GainChoice(choice=rounds[-1][1], rounds=tuple(rounds))
    return GainChoice(choice=None, rounds=())


class ValueParameters(NamedTuple):
    """Parameters of the values of targets; see `gain`.

    Attributes
    ----------
    range_m : float
        Range of the range finder in metres.
    power : float
        Exponent of the cost in the denominator of the value.
    offset_m : float
        Length in metres added to every cost.
    overlap_ranges : float
        Distance, in ranges, at and beyond which a target that is taken no longer reduces the area
        of another.
    return_area_m2 : float
        Area in square metres added to every area, for the path back to a target that is left
        behind.
    """

    range_m: float
    power: float = 4.0
    offset_m: float = 0.5
    overlap_ranges: float = 1.0
    return_area_m2: float = 5.0

    def check(self) -> None:
        """Raise `InvalidInputError` if a parameter is out of its range."""
        values = self._asdict()
        area_m2 = values.pop("return_area_m2")
        check_positive(**values)
        if not 0.0 <= area_m2 < math.inf:
            raise InvalidInputError(f"return_area_m2 is {area_m2}; it must be 0 or more")


def checked_tables(
    costs: ArrayLike, areas: ArrayLike, distances: ArrayLike, robot: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the tables of `gain` as arrays, or raise `InvalidInputError` as it does."""
    table = cost_table(costs)
    robots, targets = table.shape
    check_robot(robot, robots)
    euclidean = cost_table(distances, "distances")
    left = cost_table(areas, "areas", dimensions=1)
    for name, shape, right in (
        ("distances", euclidean.shape, (targets, targets)),
        ("areas", left.shape, (targets,)),
    ):
        if shape != right:
            raise InvalidInputError(f"{name} has the shape {shape}; it must be {right}")
    return table, left, euclidean


def check_positive(**values: float) -> None:
    """Raise `InvalidInputError` unless all values are positive and finite."""
    for name, value in values.items():
        if not 0.0 < value < math.inf:
            raise InvalidInputError(f"{name} is {value}; it must be positive")


CostOf = Callable[[int, int], float]
"""Returns the cost of a robot to a target."""


class LazyCosts(NamedTuple):
    """Costs of which those of other robots are computed only if a choice depends on them.

    Attributes
    ----------
    bounds : (n, m) array
        Costs of the robot that chooses, and lower bounds of those of the others, in metres.
    cost_of : callable
        Returns the cost of another robot to a target in metres, ``inf`` if there is no path. A
        robot with a path to one target must have paths to all: once it has taken one, its other
        costs are not computed.
    """

    bounds: FloatArray
    cost_of: CostOf


class Auction:
    """Auction in which robots take targets in order of value.

    Parameters
    ----------
    costs : (n, m) array
        Cost of each robot to each target in metres; ``inf`` where there is no path. With
        `cost_of`, those of the other robots are lower bounds.
    areas : (m,) array
        Area that would be seen at each target in square metres.
    distances : (m, m) array
        Euclidean distances between targets in metres.
    parameters : ValueParameters
        Parameters of the values.
    robot : int
        Row of the robot that chooses.
    cost_of : callable, optional
        As in `LazyCosts`.
    """

    def __init__(
        self,
        costs: FloatArray,
        areas: FloatArray,
        distances: FloatArray,
        parameters: ValueParameters,
        robot: int,
        cost_of: CostOf | None = None,
    ) -> None:
        self._distances, self._parameters, self._cost_of = distances, parameters, cost_of
        self._overlap_m = parameters.overlap_ranges * parameters.range_m
        self._costs, self._is_open = costs.copy(), np.isfinite(costs)
        self._weights = self._weights_of(costs)
        self._is_bound = np.full(costs.shape, cost_of is not None)
        self._is_bound[robot] = False
        self._left = np.tile(areas + parameters.return_area_m2, (len(costs), 1))

    def _weights_of(self, costs: ArrayLike) -> FloatArray:
        """Return the values of a square metre at some costs."""
        offset_m, power = self._parameters.offset_m, self._parameters.power
        return libm.power(np.asarray(costs) + offset_m, -power)

    def is_open_to(self, robot: int) -> bool:
        """Return whether there is a target that a robot could take."""
        return bool(self._is_open[robot].any())

    def next_round(self) -> tuple[int, int, float, float]:
        """Take the pair of the highest value.

        Returns
        -------
        robot, target, area, value
            As in `GainChoice`.
        """
        left = self._left
        values = self._values()
        # Where no area is left the nearest target is taken.
        costs = np.where(values == values.max(), self._costs, np.inf)
        taker, target = divmod(int(np.argmin(costs)), values.shape[1])
        found = taker, target, float(left[taker, target]), float(values[taker, target])
        kept = left[taker].copy()
        left *= np.minimum(1.0, self._distances[target] / self._overlap_m)
        left[taker] = kept
        return found

    def _values(self) -> FloatArray:
        """Return the values of all pairs, ``(n, m)``.

        Costs are computed until no pair of the highest value is a bound: a lower bound of a cost
        gives an upper bound of a value, so that no other pair has a value as high.
        """
        while True:
            values: FloatArray = np.where(self._is_open, self._left * self._weights, -1.0)
            bounds = np.argwhere(self._is_bound & (values == values.max()))
            if not len(bounds):
                return values
            assert self._cost_of is not None
            for robot, target in bounds.tolist():
                cost = self._cost_of(robot, target)
                self._costs[robot, target] = cost
                self._weights[robot, target] = self._weights_of(cost)
                self._is_open[robot, target] = math.isfinite(cost)
                self._is_bound[robot, target] = False

    def go_on(self, taker: int, target: int, onward: FloatArray) -> None:
        """Close a target to all, and let the robot that took it go on from there.

        Parameters
        ----------
        taker, target : int
            Row and column of the pair that was taken.
        onward : (m,) array
            Path lengths from the target to all, in metres.
        """
        self._is_open[:, target] = False
        self._is_bound[:, target] = self._is_bound[taker] = False
        self._costs[taker] = self._costs[taker, target] + onward
        self._weights[taker] = self._weights_of(self._costs[taker])

    def leave(self, taker: int) -> None:
        """Let a robot take no more."""
        self._is_open[taker] = False


def _taken(
    auction: Auction, distances: FloatArray, robot: int, *, goes_on: bool
) -> list[tuple[int, int, float, float]]:
    """Return what is taken up to a robot's first target; each takes several if it goes on."""
    rounds: list[tuple[int, int, float, float]] = []
    while auction.is_open_to(robot):
        rounds.append(auction.next_round())
        taker, target = rounds[-1][:2]
        if taker == robot:
            break
        if goes_on:
            auction.go_on(taker, target, distances[target])
        else:
            auction.leave(taker)
    return rounds
