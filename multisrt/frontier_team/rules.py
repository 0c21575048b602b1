"""The rules by which robots choose their goals, each decided by every robot alone.

`closest`, `greedy` and `minpos` as compared by A. Bautin, O. Simonin and F. Charpillet, Towards
a communication free coordination for multi-robot exploration, Algorithms 1 to 3. Costs of the
other robots are those of the robot's own map, from where it heard of them last: robots that know
the same decide alike.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

import numpy as np

from multisrt.events import GoalChosen
from multisrt.explorer import Action, Note, Outcome
from multisrt.frontier_team.robot import FrontierRobot, Goal
from multisrt.geometry.distance_field import DistanceField
from multisrt.geometry.kernel import FloatArray
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import NOBODY
from multisrt.planners.assignment.greedy import greedy
from multisrt.planners.assignment.minpos import minpos

Choice = Generator[Action, Outcome, Goal | None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """What is bid for, and what it costs whom.

    Attributes
    ----------
    targets : (m, 2) array
        The frontiers' targets in metres.
    robots : tuple of int
        Who is reckoned with, by number.
    costs : (n, m) array
        Metres; inf where there is no way.
    field : DistanceField or None
        The distances from where this robot stands; None where it stands nowhere passable.
    row : int
        This robot's row.
    """

    targets: FloatArray
    robots: tuple[int, ...]
    costs: FloatArray
    field: DistanceField | None
    row: int


def nearest_only(robot: FrontierRobot) -> Table:
    """Work out which target is nearest to this robot, and what it costs: no more than that."""
    targets = robot.targets()
    costs = np.full((1, len(targets)), np.inf)
    with robot.around_bodies():
        own = robot.own_field()
        if own is not None:
            indices = robot.indices_of(targets)
            nearest = own.first(indices)
            if nearest is not None:
                costs[0, nearest] = own.distance(indices[nearest])[0]
    return Table(targets=targets, robots=(robot.me.robot,), costs=costs, field=own, row=0)


def bid_table(robot: FrontierRobot) -> Table:
    """Work out what every target costs every robot that is reckoned with."""
    targets = robot.targets()
    indices = robot.indices_of(targets)
    places = {robot.me.robot: robot.at[:2]}
    places.update({report.robot: report.place[:2] for report in robot.team.present()})
    numbers = tuple(sorted(places))
    row = numbers.index(robot.me.robot)
    costs = np.full((len(numbers), len(targets)), np.inf)
    for i, number in enumerate(numbers):
        if i != row and (field := robot.field(*places[number])) is not None:
            costs[i] = field.distance(indices)
    with robot.around_bodies():
        own = robot.own_field()
        if own is not None:
            costs[row] = own.distance(indices)
    return Table(targets=targets, robots=numbers, costs=costs, field=own, row=row)


def choose_closest(robot: FrontierRobot, because: str) -> Choice:
    """CLOSEST: the nearest frontier, whatever the others do (Yamauchi, 1997 and 1998)."""
    table = nearest_only(robot)
    return (yield from settle_on(robot, table, closest(table.costs[0]), "closest", because))


def choose_greedy(robot: FrontierRobot, because: str) -> Choice:
    """GREEDY: the shortest ways first, every frontier once before any is taken twice."""
    table = bid_table(robot)
    given = greedy(table.costs)
    own = int(given.assignment[table.row])
    return (
        yield from settle_on(
            robot,
            table,
            own if own != NOBODY else None,
            "greedy",
            because,
            rounds=tuple((table.robots[i], *rest) for i, *rest in given.rounds),
        )
    )


def choose_minpos(robot: FrontierRobot, because: str) -> Choice:
    """MINPOS: the frontier for which fewest robots are nearer."""
    table = bid_table(robot)
    given = minpos(table.costs, table.row)
    return (yield from settle_on(robot, table, given.choice, "minpos", because, ranks=given.ranks))


def settle_on(
    robot: FrontierRobot,
    table: Table,
    choice: int | None,
    rule: str,
    because: str,
    **details: Any,
) -> Choice:
    """Make a target the goal, and put on record what was known."""
    goal = None
    if choice is not None and np.isfinite(table.costs[table.row, choice]):
        assert table.field is not None
        with robot.around_bodies():
            goal = robot.goal_at(table.field, *table.targets[choice].tolist())
    yield Note(
        GoalChosen(
            time_s=robot.time_s,
            robot=robot.me.robot,
            rule=rule,
            because=because,
            goal=None if goal is None else goal.place,
            cost_m=0.0 if goal is None else goal.cost_m,
            frontiers=tuple(map(tuple, table.targets.tolist())),
            robots=table.robots,
            costs=finite(table.costs),
            **details,
        )
    )
    return goal


def finite(table: FloatArray) -> tuple[tuple[float | None, ...], ...]:
    """Write a table with None for what is infinite."""
    return tuple(
        tuple(value if np.isfinite(value) else None for value in row) for row in table.tolist()
    )
