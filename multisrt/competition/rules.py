"""Rules of the frontier family as policies of the competition.

A robot's map, targets, ways and its way home are those of `gain_home`; the choice among targets is
made by the rule of `multisrt.planners.assignment` that robots of this package use as well, with
costs in metres of all robots in contact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from multisrt.competition.gain_home import GainHome, Memory, Situation
from multisrt.competition.grid_kernels import (
    BORDER,
    OCCUPIED,
    RAYS,
    UNKNOWN,
    Cells,
    Floats,
    Grid,
    kernel,
)
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import UNASSIGNED, DenseCosts
from multisrt.planners.assignment.gain import gain
from multisrt.planners.assignment.greedy import greedy
from multisrt.planners.assignment.minpos import minpos

CELL_M: Final = 0.1
RANGE_M: Final = 15.0
RETURN_AREA_M2: Final = 4.0
"""Area added to every area, for the path back to a target that is left behind."""

Rule = Callable[[Floats, Floats, Floats, int], int | None]
"""Takes costs (n, m), areas (m,), distances between targets (m, m) and the robot's row."""


def _closest(costs: Floats, areas: Floats, distances: Floats, row: int) -> int | None:
    return closest(DenseCosts(costs), row)


def _greedy(costs: Floats, areas: Floats, distances: Floats, row: int) -> int | None:
    chosen = int(greedy(DenseCosts(costs), until=row).assignment[row])
    return None if chosen == UNASSIGNED else chosen


def _minpos(costs: Floats, areas: Floats, distances: Floats, row: int) -> int | None:
    return minpos(DenseCosts(costs), row).choice


def _gain(costs: Floats, areas: Floats, distances: Floats, row: int) -> int | None:
    return gain(costs, areas + RETURN_AREA_M2, distances, row, range_m=RANGE_M).choice


RULES: Final[dict[str, Rule]] = {
    "closest": _closest,
    "greedy": _greedy,
    "minpos": _minpos,
    "gain": _gain,
}
"""The rules by the names of the strategies that use them."""


class RulePolicy(GainHome):
    """A policy that chooses targets by a rule of this package.

    Parameters
    ----------
    name : str
        Name of the rule, of `RULES`.

    Raises
    ------
    InvalidInputError
        If there is no such rule.
    """

    def __init__(self, name: str) -> None:
        if name not in RULES:
            raise InvalidInputError(
                f"no strategy of the competition is called {name!r}{did_you_mean(name, RULES)}"
            )
        super().__init__()
        self._rule = RULES[name]

    def choose(self, memory: Memory, situation: Situation) -> int | None:
        """Return the number of the target that the rule chooses for this robot.

        Rows are put in the order of the robots' numbers, since ties are broken by it.
        """
        states, targets, costs = situation.states, situation.targets, situation.costs
        order = np.argsort(situation.robots)
        areas = unknown_in_sight(states, targets, RANGE_M / CELL_M, BORDER) * CELL_M**2
        distances = np.hypot(*(targets[:, None] - targets[None]).transpose(2, 0, 1)) * CELL_M
        row = int(np.flatnonzero(order == 0)[0])
        return self._rule(costs[order] * CELL_M, areas, distances, row)


def policy(name: str) -> Any:
    """Return the class of the policy of a rule, to be made without arguments."""

    class Policy(RulePolicy):
        def __init__(self) -> None:
            super().__init__(name)

    return Policy


@kernel
def unknown_in_sight(states: Grid, targets: Cells, sight: float, border: int) -> Floats:
    """Return the unknown area in sight of targets in cells, where unknown cells hide nothing."""
    rows, columns = states.shape
    areas = np.zeros(len(targets))
    for t in range(len(targets)):
        area = 0.0
        for k in range(RAYS):
            angle = 2.0 * np.pi * k / RAYS
            di, dj = math.sin(angle), math.cos(angle)
            r = 1.0
            while r < sight:
                i, j = int(targets[t, 0] + r * di + 0.5), int(targets[t, 1] + r * dj + 0.5)
                if not (border <= i < rows - border and border <= j < columns - border):
                    break
                if states[i, j] == OCCUPIED:
                    break
                if states[i, j] == UNKNOWN:
                    area += 2.0 * r
                r += 2.0
        areas[t] = area * 2.0 * np.pi / RAYS
    return areas
