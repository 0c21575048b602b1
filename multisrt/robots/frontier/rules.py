"""The rules by which robots choose their goals, each decided by every robot alone.

`closest`, `greedy` and `minpos` as compared by A. Bautin, O. Simonin and F. Charpillet, Towards
a communication free coordination for multi-robot exploration, Algorithms 1 to 3. Costs of the
other robots are those of the robot's own map, from where it heard of them last: robots that know
the same decide alike.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, islice
from typing import Any, Final

import numpy as np

from multisrt.events import GoalChosen
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.minpos import positions
from multisrt.robots.explorer import Action, Note, Outcome
from multisrt.robots.frontier.fields import NEAR_BY_CELLS
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.robot import FrontierRobot

NEARER_FACTOR: Final = 1.05
NEARER_CELLS: Final = 3.0
"""Who has farther to a target in a straight line than this robot by its way is not nearer.

With this to spare: a distance marched from one end and from the other differs by up to 3 %.
"""

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


class Bids:
    """What frontiers cost whom, worked out only as far as it is asked for.

    Parameters
    ----------
    robot : FrontierRobot
        Who decides.
    alone : bool
        Reckon with no other robots.
    whole : bool
        Work out what every target costs this robot. It then looks closer at all targets that it
        cannot reach; otherwise only if it can reach none.

    Attributes
    ----------
    robots : tuple of int
        Who is reckoned with, by number.
    row : int
        This robot's row.
    field : DistanceField or None
        The distances from where this robot stands; None where it stands nowhere passable.
    targets : (m, 2) array
        The frontiers' targets in metres.
    costs : (n, m) array
        Metres; inf where there is no way, or where it was not worked out.
    ranks : (n, m) array of int
        How many robots are nearer to a target; -1 where it was not counted.
    """

    def __init__(self, robot: FrontierRobot, *, alone: bool = False, whole: bool = False) -> None:
        self.robot = robot
        places = {robot.me.robot: robot.at[:2]}
        if not alone:
            places.update({report.robot: report.place[:2] for report in robot.team.present()})
        self.robots = tuple(sorted(places))
        self.row = self.robots.index(robot.me.robot)
        self._places = [places[number] for number in self.robots]
        # Bodies that are known to bar the way bar only this robot's.
        with robot.around_bodies():
            self.field = robot.own_field()
            self._fields: dict[int, DistanceField | None] = {self.row: self.field}
            self._take_targets()
            if self.field is not None and not self._are_in_reach(whole):
                changes = robot.look_closer(self.field)
                if changes or whole:
                    self._take_targets()
                    self._are_in_reach(whole)

    def _take_targets(self) -> None:
        self.targets = self.robot.targets()
        self._indices = self.robot.indices_of(self.targets)
        shape = len(self.robots), len(self.targets)
        self.costs = np.full(shape, np.inf)
        self.ranks = np.full(shape, -1)

    def _are_in_reach(self, whole: bool) -> bool:
        # Whether there is a way to one of the targets, or to all.
        if not whole:
            return self.nearest(self.row, self.all_targets()) is not None
        self._fill_in(self.row)
        return len(self.targets) > 0 and bool(np.isfinite(self.costs[self.row]).all())

    def table(self) -> Table:
        """Give what was worked out."""
        return Table(
            targets=self.targets,
            robots=self.robots,
            costs=self.costs,
            field=self.field,
            row=self.row,
        )

    def at_least(self) -> FloatArray:
        """Give what no way is shorter than: as the crow flies, and rounded down, ``(n, m)``."""
        apart = np.array(self._places)[:, None] - self.targets
        straight = np.hypot(apart[..., 0], apart[..., 1])
        spare = NEARER_CELLS * self.robot.raster.cell_m
        bound: FloatArray = np.maximum(0.0, straight - spare) / NEARER_FACTOR
        return bound

    def all_targets(self) -> IntArray:
        """Give the numbers of all targets."""
        return np.arange(len(self.targets))

    def fill_in_others(self) -> None:
        """Work out what every target costs everybody else."""
        for row in range(len(self.robots)):
            if row != self.row:
                self._fill_in(row)

    def nearest(
        self, row: int, targets: IntArray, at_most_m: float = math.inf
    ) -> tuple[float, int] | None:
        """Give how far a robot has to the nearest of some targets, and which that is.

        None if it has a way to none of them; or none that is so short, as far as that is known.
        """
        field = self._field_from(row)
        if field is None:
            return None
        with self.robot.around_bodies() if row == self.row else nullcontext():
            found = field.first(self._indices[targets], at_most_m)
        if found is None:
            return None
        place, cost = found
        target = int(targets[place])
        self.costs[row, target] = cost
        return cost, target

    def nearest_first(self) -> Iterator[int]:
        """Give the targets that this robot can reach, one after the other."""
        left = self.all_targets()
        while (nearest := self.nearest(self.row, left)) is not None:
            _, target = nearest
            yield target
            left = left[left != target]

    def nearer_robots(self, target: int) -> Iterator[int]:
        """Give the rows of the robots to whom a wave from a target comes before this one.

        The wave runs on only while it is asked for more, and only if there is anybody who can
        be nearer. To call when it is known how far this robot has to the target.
        """
        self.ranks[self.row, target] = 0
        ahead = chain(self._ahead_of_cell(target), self._ahead_in_cell(target))
        for rank, row in enumerate(ahead):
            self.ranks[row, target], self.ranks[self.row, target] = rank, rank + 1
            yield row

    def _ahead_of_cell(self, target: int) -> Iterator[int]:
        waiting = [self.row, *self._rivals(target)]
        if len(waiting) == 1:
            return
        wave = self.robot.field(*self.targets[target].tolist())
        assert wave is not None, "a cell to which a way leads is passable"
        cells = np.array([self._cells[row] for row in waiting])
        indices = np.column_stack(self.robot.raster.indices_of(cells))
        while (found := wave.first(indices)) is not None:
            place, cost = found
            row = waiting.pop(place)
            if row == self.row:
                return
            indices = np.delete(indices, place, axis=0)
            self.costs[row, target] = cost
            yield row

    def _ahead_in_cell(self, target: int) -> Iterator[int]:
        # Robots in one cell take turns.
        here = [i for i, cell in enumerate(self._cells) if cell == self._cells[self.row]]
        if len(here) > 1 and (field := self.robot.field(*self._places[self.row])) is not None:
            costs = field.distance(self._indices)
            ranks = positions(np.tile(costs, (len(here), 1)))[:, target]
            own = ranks[here.index(self.row)]
            yield from (here[i] for i in np.argsort(ranks)[:own].tolist())

    def _rivals(self, target: int) -> list[int]:
        # Who is nearer as the crow flies than this robot by its way.
        near_m = NEARER_FACTOR * self.costs[self.row, target]
        near_m += NEARER_CELLS * self.robot.raster.cell_m
        centre_of, place = self.robot.raster.centre_of, self.targets[target].tolist()
        return [
            row
            for row, cell in enumerate(self._cells)
            if cell not in (None, self._cells[self.row])
            and math.dist(centre_of(*cell), place) <= near_m
        ]

    @cached_property
    def _cells(self) -> list[tuple[int, int] | None]:
        near = self.robot.raster.passable_near
        return [near(x, y, NEAR_BY_CELLS) for x, y in self._places]

    def _field_from(self, row: int) -> DistanceField | None:
        if row not in self._fields:
            self._fields[row] = self.robot.field(*self._places[row])
        return self._fields[row]

    def _fill_in(self, row: int) -> None:
        field = self._field_from(row)
        if field is not None:
            self.costs[row] = field.distance(self._indices)


def nearest_only(robot: FrontierRobot) -> Table:
    """Work out which target is nearest to this robot, and what it costs: no more than that."""
    return Bids(robot, alone=True).table()


def own_bids(robot: FrontierRobot) -> tuple[DistanceField | None, FloatArray, FloatArray]:
    """Give this robot's field, the targets, and what they cost it."""
    bids = Bids(robot, alone=True, whole=True)
    return bids.field, bids.targets, bids.costs[0]


def bid_table(robot: FrontierRobot) -> Table:
    """Work out what every target costs every robot that is reckoned with."""
    bids = Bids(robot, whole=True)
    bids.fill_in_others()
    return bids.table()


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
    waiting = dict.fromkeys(range(len(bids.robots)))
    offers = Offers(bids)
    rounds: list[tuple[int, int, float]] = []
    while bids.row in waiting:
        shortest = offers.shortest(waiting)
        if shortest is not None:
            cost, i, target = shortest
            rounds.append((i, target, cost))
            del waiting[i]
            offers.take(target)
        elif not offers.start_again():
            break
    own = rounds[-1][1] if rounds and rounds[-1][0] == bids.row else None
    longest = max((cost for _, _, cost in rounds), default=0.0) or 1.0
    told = tuple((bids.robots[i], target, 1.0, cost / longest) for i, target, cost in rounds)
    return (yield from settle_on(robot, bids.table(), own, "greedy", because, rounds=told))


class Offers:
    """The shortest ways of several robots to the targets that are left, worked out when needed.

    A robot's wave runs no farther than the shortest way found, and only if its nearest target
    is that near as the crow flies.

    Parameters
    ----------
    bids : Bids
        What targets cost.
    """

    def __init__(self, bids: Bids) -> None:
        self._bids = bids
        self._straight = bids.at_least()
        self._start()

    def _start(self) -> None:
        self._unused = self._bids.all_targets()
        self._known: dict[int, tuple[float, int]] = {}
        # How far waves have run in vain: inf, to the end.
        self._beyond = np.zeros(len(self._bids.robots))

    def shortest(self, waiting: Iterable[int]) -> tuple[float, int, int] | None:
        """Give the cost, robot and target of the shortest way that a waiting robot has.

        Of equal ones that of the first robot; None if none of them has a way.
        """
        if not len(self._unused):
            return None
        at_least = np.maximum(self._straight[:, self._unused].min(axis=1), self._beyond)
        best: tuple[float, int, int] | None = None
        for i in sorted(waiting, key=at_least.__getitem__):
            if math.isinf(at_least[i]) or (best is not None and at_least[i] > best[0]):
                break
            if i not in self._known:
                at_most = math.inf if best is None else best[0]
                found = self._bids.nearest(i, self._unused, at_most)
                if found is None:
                    self._beyond[i] = at_most
                    continue
                self._known[i] = found
            cost, target = self._known[i]
            if best is None or (cost, i) < best[:2]:
                best = cost, i, target
        return best

    def take(self, target: int) -> None:
        """Leave out a target: to no robot it is the nearest any more."""
        self._unused = self._unused[self._unused != target]
        self._known = {i: known for i, known in self._known.items() if known[1] != target}

    def start_again(self) -> bool:
        """Leave in all targets again; false if they all were left in."""
        if len(self._unused) == len(self._bids.targets):
            return False
        self._start()
        return True


def choose_minpos(robot: FrontierRobot, because: str) -> Choice:
    """MINPOS: the frontier for which fewest robots are nearer, of several the nearest.

    The paper's wavefronts, Algorithm 3. Frontiers come in the order of the way to them, so that
    one replaces another only by a lower rank: none is counted further than to the lowest so far.
    """
    bids = Bids(robot)
    choice, lowest = None, len(bids.robots)
    for target in bids.nearest_first():
        rank = sum(1 for _ in islice(bids.nearer_robots(target), lowest))
        if rank < lowest:
            choice, lowest = target, rank
        if lowest == 0:
            break
    ranks = tuple(tuple(rank if rank >= 0 else None for rank in row) for row in bids.ranks.tolist())
    return (yield from settle_on(robot, bids.table(), choice, "minpos", because, ranks=ranks))


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
    values = table.astype(object)
    values[~np.isfinite(table)] = None
    return tuple(map(tuple, values.tolist()))
