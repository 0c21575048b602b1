"""The rules by which robots choose their goals, each decided by every robot alone.

`closest`, `greedy` and `minpos` as compared by A. Bautin, O. Simonin and F. Charpillet, Towards
a communication free coordination for multi-robot exploration, Algorithms 1 to 3. Costs of the
other robots are those of the robot's own map, from where it heard of them last: robots that know
the same decide alike.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np

from multisrt.events import GoalChosen
from multisrt.explorer import Action, Note, Outcome
from multisrt.frontier_team.robot import NEAR_BY_CELLS, FrontierRobot, Goal
from multisrt.geometry.distance_field import DistanceField
from multisrt.geometry.kernel import FloatArray, IntArray
from multisrt.planners.assignment.closest import closest
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
    with robot.around_bodies():
        own = robot.own_field()
        targets = robot.targets()
        nearest = None if own is None else own.first(robot.indices_of(targets))
        if own is not None and nearest is None and robot.look_closer(own):
            targets = robot.targets()
            nearest = own.first(robot.indices_of(targets))
        costs = np.full((1, len(targets)), np.inf)
        if own is not None and nearest is not None:
            costs[0, nearest] = own.distance(robot.indices_of(targets[nearest : nearest + 1]))[0]
    return Table(targets=targets, robots=(robot.me.robot,), costs=costs, field=own, row=0)


def bid_table(robot: FrontierRobot) -> Table:
    """Work out what every target costs every robot that is reckoned with."""
    own, targets, own_costs = own_bids(robot)
    indices = robot.indices_of(targets)
    places = {robot.me.robot: robot.at[:2]}
    places.update({report.robot: report.place[:2] for report in robot.team.present()})
    numbers = tuple(sorted(places))
    row = numbers.index(robot.me.robot)
    costs = np.full((len(numbers), len(targets)), np.inf)
    for i, number in enumerate(numbers):
        if i == row:
            costs[i] = own_costs
        elif (field := robot.field(*places[number])) is not None:
            costs[i] = field.distance(indices)
    return Table(targets=targets, robots=numbers, costs=costs, field=own, row=row)


def own_bids(robot: FrontierRobot) -> tuple[DistanceField | None, FloatArray, FloatArray]:
    """Give this robot's field, the targets, and what they cost it."""
    with robot.around_bodies():
        own = robot.own_field()
        targets = robot.targets()
        if own is None:
            return None, targets, np.full(len(targets), np.inf)
        costs = own.distance(robot.indices_of(targets))
        if not np.isfinite(costs).all() or not len(costs):
            robot.look_closer(own)
            targets = robot.targets()
            costs = own.distance(robot.indices_of(targets))
        return own, targets, costs


class Bids:
    """What frontiers cost whom, worked out only as far as it is asked for.

    Parameters
    ----------
    robot : FrontierRobot
        Who decides.
    """

    def __init__(self, robot: FrontierRobot) -> None:
        self.robot = robot
        places = {robot.me.robot: robot.at[:2]}
        places.update({report.robot: report.place[:2] for report in robot.team.present()})
        self.robots = tuple(sorted(places))
        self.row = self.robots.index(robot.me.robot)
        self._places = [places[number] for number in self.robots]
        with robot.around_bodies():
            self._own = robot.own_field()
        self._fields: dict[int, DistanceField | None] = {self.row: self._own}
        self._take_targets()
        if self._own is not None and self.nearest(self.row, self.all_targets()) is None:
            with robot.around_bodies():
                changes = robot.look_closer(self._own)
            if changes:
                self._take_targets()

    def _take_targets(self) -> None:
        self.targets = self.robot.targets()
        self._indices = self.robot.indices_of(self.targets)
        self._costs = np.full((len(self.robots), len(self.targets)), np.inf)

    def all_targets(self) -> IntArray:
        """Give the numbers of all targets."""
        return np.arange(len(self.targets))

    def nearest(self, row: int, targets: IntArray) -> tuple[float, int] | None:
        """Give how far a robot has to the nearest of some targets, and which that is."""
        if row not in self._fields:
            self._fields[row] = self.robot.field(*self._places[row])
        field = self._fields[row]
        if field is None:
            return None
        with self._passable_for(row):
            first = field.first(self._indices[targets])
            if first is None:
                return None
            target = int(targets[first])
            cost = float(field.distance(self._indices[target : target + 1])[0])
        self._costs[row, target] = cost
        return cost, target

    def stands_apart(self) -> bool:
        """Whether no other robot stands in this robot's cell."""
        cells = self._cells()
        return cells.count(cells[self.row]) == 1

    def comes_first(self, target: int) -> bool:
        """Whether a wave from a target comes to this robot before all others."""
        field = self.robot.field(*self.targets[target].tolist())
        cells = self._cells()
        rows = [i for i, cell in enumerate(cells) if cell is not None]
        if field is None or cells[self.row] is None:
            return False
        named = np.array([cells[i] for i in rows])
        first = field.first(np.column_stack(self.robot.raster.indices_of(named)))
        return first is not None and rows[first] == self.row

    def table(self) -> Table:
        """Give what was worked out; inf where it was not."""
        return Table(
            targets=self.targets,
            robots=self.robots,
            costs=self._costs,
            field=self._own,
            row=self.row,
        )

    def _cells(self) -> list[tuple[int, int] | None]:
        near = self.robot.raster.passable_near
        return [near(x, y, NEAR_BY_CELLS) for x, y in self._places]

    def _passable_for(self, row: int) -> AbstractContextManager[None]:
        # Bodies that are known to bar the way bar only this robot's.
        return self.robot.around_bodies() if row == self.row else nullcontext()


def choose_closest(robot: FrontierRobot, because: str) -> Choice:
    """CLOSEST: the nearest frontier, whatever the others do (Yamauchi, 1997 and 1998)."""
    table = nearest_only(robot)
    return (yield from settle_on(robot, table, closest(table.costs[0]), "closest", because))


def choose_greedy(robot: FrontierRobot, because: str) -> Choice:
    """GREEDY: the shortest ways first, every frontier once before any is taken twice.

    As `planners.assignment.greedy`, but every robot's wave runs only as far as to the frontier
    that it gets, and the rounds end with this robot's own.
    """
    bids = Bids(robot)
    unused = bids.all_targets()
    waiting = dict.fromkeys(i for i in range(len(bids.robots)) if bids.nearest(i, unused))
    rounds: list[tuple[int, int, float]] = []
    while bids.row in waiting:
        offers = [(*found, i) for i in waiting if (found := bids.nearest(i, unused)) is not None]
        if not offers:
            unused = bids.all_targets()
            continue
        cost, target, i = min(offers, key=lambda offer: (offer[0], offer[2], offer[1]))
        rounds.append((i, target, cost))
        del waiting[i]
        unused = unused[unused != target]
    own = rounds[-1][1] if rounds and rounds[-1][0] == bids.row else None
    longest = max((cost for _, _, cost in rounds), default=0.0) or 1.0
    told = tuple((bids.robots[i], target, 1.0, cost / longest) for i, target, cost in rounds)
    return (yield from settle_on(robot, bids.table(), own, "greedy", because, rounds=told))


def choose_minpos(robot: FrontierRobot, because: str) -> Choice:
    """MINPOS: the frontier for which fewest robots are nearer.

    As `planners.assignment.minpos`. A wave from the nearest frontier that comes to this robot
    first settles it, since no rank is lower: only where all waves come to others first, they
    are let run to everybody (the paper's wavefronts, Algorithm 3).
    """
    bids = Bids(robot)
    left = bids.all_targets()
    while (nearest := bids.nearest(bids.row, left)) is not None and bids.stands_apart():
        _, target = nearest
        if bids.comes_first(target):
            return (yield from settle_on(robot, bids.table(), target, "minpos", because))
        left = left[left != target]
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
