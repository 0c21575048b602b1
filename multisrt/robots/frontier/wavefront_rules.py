"""Frontier rules that every robot decides alone: closest, greedy and MinPos.

The rules themselves are in `planners.assignment`. Here they are applied to the robot's own map, and
the decision is recorded with what it was based on.

Source: the papers named there. Differs in: where they count all robots, `greedy` and `minpos` leave
out those with nothing to do and those that are presumed lost (`Teammates.present`).
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import numpy as np

from multisrt.events import GoalChosen
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import UNASSIGNED
from multisrt.planners.assignment.greedy import greedy
from multisrt.planners.assignment.minpos import UNCOUNTED, minpos
from multisrt.robots.explorer import Action, Note, Outcome
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_costs import Table, WavefrontCosts

Choice = Generator[Action, Outcome, Goal | None]


def choose_closest(robot: FrontierRobot, because: str) -> Choice:
    """CLOSEST: the nearest frontier, whatever the others do."""
    costs = WavefrontCosts(robot, alone=True)
    choice = closest(costs, costs.row)
    return (yield from settle_on(robot, costs.table(), choice, "closest", because))


def choose_greedy(robot: FrontierRobot, because: str) -> Choice:
    """GREEDY: assign frontiers to the robots at increasing cost, up to this robot's own.

    Differs in: idle robots, and robots not heard from for long, have no costs and get no frontier.
    """
    costs = WavefrontCosts(robot)
    assigned = greedy(costs, until=costs.row)
    own = int(assigned.assignment[costs.row])
    choice = None if own == UNASSIGNED else own
    largest = max((cost for _, _, cost in assigned.rounds), default=0.0) or 1.0
    # Recorded with utility 1, as all frontiers are equal, and the cost as a share of the largest.
    rounds = tuple((costs.robots[i], j, 1.0, cost / largest) for i, j, cost in assigned.rounds)
    return (yield from settle_on(robot, costs.table(), choice, "greedy", because, rounds=rounds))


def choose_minpos(robot: FrontierRobot, because: str) -> Choice:
    """MINPOS: the frontier to which the fewest robots are nearer, of several the nearest.

    Differs in: idle robots, and robots not heard from for long, do not count as nearer.
    """
    costs = WavefrontCosts(robot)
    chosen = minpos(costs, costs.row)
    ranks = tuple(
        tuple(None if rank == UNCOUNTED else rank for rank in row)
        for row in chosen.positions.tolist()
    )
    return (
        yield from settle_on(robot, costs.table(), chosen.choice, "minpos", because, ranks=ranks)
    )


def settle_on(
    robot: FrontierRobot,
    table: Table,
    choice: int | None,
    rule: str,
    because: str,
    **details: Any,
) -> Choice:
    """Make a target the robot's goal, and record the choice.

    Parameters
    ----------
    robot : FrontierRobot
        The robot that decides.
    table : Table
        The targets and costs that the choice is based on.
    choice : int or None
        Number of the target; None if there is none.
    rule, because : str
        Name of the rule and reason for choosing, as in `GoalChosen`.
    **details
        Further fields of `GoalChosen`.

    Returns
    -------
    Goal or None
        The goal with the path there; None if there is no target or no path.
    """
    goal = None
    if choice is not None and np.isfinite(table.costs[table.row, choice]):
        assert table.field is not None
        with robot.around_bodies():
            goal = robot.goal_at(table.field, *table.targets[choice].tolist())
    yield note_goal(robot, table, goal, rule, because, **details)
    return goal


def note_goal(
    robot: FrontierRobot, table: Table, goal: Goal | None, rule: str, because: str, **details: Any
) -> Note:
    """Return the note of a choice; the parameters are those of `settle_on`, and the goal."""
    return Note(
        GoalChosen(
            time_s=robot.time_s,
            robot=robot.me.robot,
            rule=rule,
            because=because,
            goal=None if goal is None else goal.place,
            cost_m=0.0 if goal is None else goal.cost_m,
            frontiers=tuple([(x, y) for x, y in table.targets.tolist()]),
            robots=table.robots,
            costs=finite_or_none(table.costs),
            **details,
        )
    )


def finite_or_none(table: FloatArray) -> tuple[tuple[float | None, ...], ...]:
    """Return the rows of a table with None in place of infinite entries."""
    values = table.astype(object)
    values[~np.isfinite(table)] = None
    return tuple(map(tuple, values.tolist()))
