"""Costs of robots to frontiers: the questions that rules ask, and the table that answers them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.planners.assignment.positions import positions

UNASSIGNED: Final = -1
"""Entry of an assignment for a robot without a frontier."""


class CostOracle(Protocol):
    """Answers the questions that a rule asks about costs.

    Costs are path lengths in metres. An oracle may be lazy: rules ask only for what their decision
    depends on, in an order that lets a wavefront stop early.
    """

    @property
    def shape(self) -> tuple[int, int]:
        """Number of robots and number of frontiers."""
        ...

    def lower_bounds(self) -> FloatArray:
        """Return a lower bound of every cost, cheap to compute.

        Returns
        -------
        (n, m) array
            Metres.
        """
        ...

    def nearest(
        self, robot: int, frontiers: IntArray, limit_m: float = math.inf
    ) -> tuple[float, int] | None:
        """Return the cheapest of some frontiers for one robot.

        Parameters
        ----------
        robot : int
            Number of the robot.
        frontiers : (k,) array of int
            Numbers of the frontiers to choose from.
        limit_m : float
            The search may stop at this cost.

        Returns
        -------
        (cost, frontier) or None
            None if no path leads to any of them. With a limit, also if the cheapest costs more
            and was not known before. Of equally cheap ones a table takes the first, a wave the
            one that it meets first.
        """
        ...

    def robots_ahead(self, robot: int, frontier: int) -> Iterator[int]:
        """Iterate over the robots in a better position towards a frontier, the best first.

        Parameters
        ----------
        robot : int
            Number of the robot whose position is asked for.
        frontier : int
            Number of a frontier that it can reach.

        Yields
        ------
        int
            Number of another robot; see `positions` for ties.
        """
        ...


class DenseCosts:
    """The costs of a table.

    Parameters
    ----------
    costs : (n, m) array
        Cost of each robot to each frontier in metres; ``inf`` where there is no path. Copied.

    Attributes
    ----------
    table : (n, m) array
        The copy, read-only.

    Raises
    ------
    InvalidInputError
        If `costs` is not two-dimensional, or has a negative entry or NaN.

    Examples
    --------
    >>> costs = DenseCosts([[4.0, 2.5], [1.0, float("inf")]])
    >>> costs.nearest(0, np.array([0, 1]))
    (2.5, 1)
    >>> costs.nearest(1, np.array([1])) is None
    True
    >>> list(costs.robots_ahead(0, 0))
    [1]
    """

    def __init__(self, costs: ArrayLike) -> None:
        self.table = cost_table(costs)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of robots and number of frontiers."""
        robots, frontiers = self.table.shape
        return robots, frontiers

    def lower_bounds(self) -> FloatArray:
        """Return the costs themselves, ``(n, m)``."""
        return self.table

    def nearest(
        self, robot: int, frontiers: IntArray, limit_m: float = math.inf
    ) -> tuple[float, int] | None:
        """Return the cheapest of some frontiers for one robot, of equal ones the first.

        Parameters and result are those of `CostOracle.nearest`.
        """
        if not len(frontiers):
            return None
        costs = self.table[robot, frontiers]
        first = int(np.argmin(costs))
        cost = float(costs[first])
        return (cost, int(frontiers[first])) if cost <= limit_m and math.isfinite(cost) else None

    def robots_ahead(self, robot: int, frontier: int) -> Iterator[int]:
        """Iterate over the robots in a better position towards a frontier, the best first.

        Parameters and result are those of `CostOracle.robots_ahead`.
        """
        column = self._positions[:, frontier]
        yield from np.argsort(column)[: column[robot]].tolist()

    @cached_property
    def _positions(self) -> IntArray:
        return positions(self.table)


def cost_table(values: ArrayLike, name: str = "costs", *, dimensions: int = 2) -> FloatArray:
    """Return a checked, read-only copy of an array of costs or distances.

    Parameters
    ----------
    values : array
        Metres, 0 or more; ``inf`` where there is no path.
    name : str
        Name of the array in error messages.
    dimensions : {1, 2}
        Required number of dimensions.

    Returns
    -------
    array
        Negative zeros are replaced by 0.0.

    Raises
    ------
    InvalidInputError
        If the number of dimensions differs, or an entry is negative or NaN.
    """
    table = np.array(values, np.float64)
    if table.ndim != dimensions:
        raise InvalidInputError(f"{name} has {table.ndim} dimensions; it must have {dimensions}")
    wrong = np.argwhere(~(table >= 0.0))
    if len(wrong):
        place = tuple(wrong[0].tolist())
        raise InvalidInputError(
            f"{name} is {table[place]} at {list(place)}; distances are 0 or more, inf for no path"
        )
    table += 0.0  # positions() compares rows bit by bit
    table.setflags(write=False)
    return table


def check_robot(robot: int, robots: int) -> None:
    """Raise `InvalidInputError` unless `robot` is a row of a table with `robots` rows."""
    if not 0 <= robot < robots:
        raise InvalidInputError(f"robot is {robot}; the table has rows 0 to {robots - 1}")


def largest_finite(table: FloatArray) -> float:
    """Return the largest finite entry of a table; 0 if there is none."""
    return float(table[np.isfinite(table)].max(initial=0.0))
