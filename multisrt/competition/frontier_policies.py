"""Policies for the competition that choose among frontiers by the rules of `planners.assignment`.

The map, the targets, the paths and the drive home are those of `gain_home`. A target is chosen by
the costs in metres of all robots in contact.

`closest`, `greedy` and `minpos` are the rules of the strategies of the same names. `gain` differs
from the strategy: it chooses by value only, as the strategy does with ``tour_weight=0``, it adds
4 m² to every area instead of 5 (`return_area_m2`), which robots do not share, and costs are path
lengths, without `turn_m_per_rad` and `keep_m`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from multisrt.competition.gain_home import GainHome, Memory, Situation
from multisrt.competition.grid_kernels import (
    MARGIN,
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
"""Added to the area of every target in `gain`: the cost of returning to it if it is left behind."""

ChoiceRule = Callable[[Floats, Floats, Floats, int], int | None]
"""Returns the index of a target, or None, for costs ``(n, m)``, areas ``(m,)``, Euclidean distances
between targets ``(m, m)`` and the robot's row.
"""


def _closest(costs: Floats, areas: Floats, distances: Floats, row: int) -> int | None:
    return closest(DenseCosts(costs), row)


def _greedy(costs: Floats, areas: Floats, distances: Floats, row: int) -> int | None:
    chosen = int(greedy(DenseCosts(costs), until=row).assignment[row])
    return None if chosen == UNASSIGNED else chosen


def _minpos(costs: Floats, areas: Floats, distances: Floats, row: int) -> int | None:
    return minpos(DenseCosts(costs), row).choice


def _gain(costs: Floats, areas: Floats, distances: Floats, row: int) -> int | None:
    return gain(costs, areas + RETURN_AREA_M2, distances, row, range_m=RANGE_M).choice


CHOICE_RULES: Final[dict[str, ChoiceRule]] = {
    "closest": _closest,
    "greedy": _greedy,
    "minpos": _minpos,
    "gain": _gain,
}
"""The rules by name."""


class FrontierPolicy(GainHome):
    """A policy that chooses targets by one of `CHOICE_RULES`.

    Parameters
    ----------
    name : str
        Name of the rule.

    Raises
    ------
    InvalidInputError
        If there is no such rule.
    """

    def __init__(self, name: str) -> None:
        if name not in CHOICE_RULES:
            raise InvalidInputError(
                f"no strategy of the competition is called {name!r}"
                f"{did_you_mean(name, CHOICE_RULES)}"
            )
        super().__init__()
        self._rule = CHOICE_RULES[name]

    def choose(self, memory: Memory, situation: Situation) -> int | None:
        """Return the index of the target that the rule chooses for this robot.

        Costs are sorted by the robots' numbers, since rules break ties by the order of the rows.
        """
        states, targets, costs = situation.states, situation.targets, situation.costs
        order = np.argsort(situation.robots)
        areas = visible_unknown_areas(states, targets, RANGE_M / CELL_M, MARGIN) * CELL_M**2
        distances = np.hypot(*(targets[:, None] - targets[None]).transpose(2, 0, 1)) * CELL_M
        row = int(np.flatnonzero(order == 0)[0])
        return self._rule(costs[order] * CELL_M, areas, distances, row)


def policy_class(name: str) -> Any:
    """Return the class of the policy with a choice rule, which takes no arguments."""

    class Policy(FrontierPolicy):
        def __init__(self) -> None:
            super().__init__(name)

    return Policy


@kernel
def visible_unknown_areas(states: Grid, targets: Cells, sight: float, margin: int) -> Floats:
    """Return the unknown area visible from each target within `sight` cells, ``(m,)``.

    Areas are in square cells; unknown cells do not occlude.
    """
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
                if not (margin <= i < rows - margin and margin <= j < columns - margin):
                    break
                if states[i, j] == OCCUPIED:
                    break
                if states[i, j] == UNKNOWN:
                    area += 2.0 * r
                r += 2.0
        areas[t] = area * 2.0 * np.pi / RAYS
    return areas
