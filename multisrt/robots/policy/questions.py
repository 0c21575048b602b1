"""The question of a robot: which of the frontiers that it can reach to go to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_costs import Table, WavefrontCosts


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Question:
    """The frontiers between which a robot has to choose.

    Attributes
    ----------
    table : Table
        Their places, and the lengths of the robot's own paths there.
    sizes_m : (m,) array
        Their lengths in metres.
    nearest : (k,) array of int
        The rows of those that can be reached, by the length of the path; no more than asked for.
    """

    table: Table
    sizes_m: FloatArray
    nearest: IntArray

    @property
    def costs_m(self) -> FloatArray:
        """Lengths of the paths in metres, ``(m,)``; inf where none leads or none was computed."""
        costs: FloatArray = self.table.costs[self.table.row]
        return costs


def question_of(robot: FrontierRobot, at_most: int) -> Question:
    """Return what a robot has to choose between.

    Parameters
    ----------
    robot : FrontierRobot
        The robot.
    at_most : int
        Number of frontiers to choose from: the nearest.
    """
    costs = WavefrontCosts(robot, alone=True)
    left, nearest = np.arange(len(costs.targets)), list[int]()
    # The wave from the robot runs only as far as the last of those that it may choose.
    while len(nearest) < at_most and (found := costs.nearest(costs.row, left)) is not None:
        nearest.append(found[1])
        left = left[left != found[1]]
    return Question(
        table=costs.table(),
        sizes_m=np.array([group.size_m for group, _ in robot.frontiers.placed()]),
        nearest=np.array(nearest, np.int64),
    )
