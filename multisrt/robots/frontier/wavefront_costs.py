"""Costs of robots to frontiers by wavefronts over one robot's map, computed when asked for.

Costs of the other robots are those on the robot's own map, from where it last heard from them, so
that robots with the same knowledge decide alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import Final

import numpy as np

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.planners.assignment.positions import positions
from multisrt.robots.frontier.fields import NEAR_BY_CELLS
from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.robot import FrontierRobot

BOUND_FACTOR: Final = 1.05
BOUND_CELLS: Final = 3.0
"""Allowance of the Euclidean lower bound, as a factor and in cells.

Marching the same path from either end gives lengths that differ by up to 3 %, and a path begins
and ends at the centre of a cell.
"""

CENTRE_CELLS: Final = 1.5
"""Upper bound of the distances of both ends of a path from the centres of their cells, in cells."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """The targets of a decision, and their costs as far as computed.

    Attributes
    ----------
    targets : (m, 2) array
        Targets of the frontiers in metres.
    robots : tuple of int
        Ids of the robots that are taken into account.
    costs : (n, m) array
        Path lengths in metres; ``inf`` where there is no path or none was computed.
    field : DistanceField or None
        Distances from the deciding robot; None if no passable cell is near it.
    row : int
        Row of the deciding robot.
    """

    targets: FloatArray
    robots: tuple[int, ...]
    costs: FloatArray
    field: DistanceField | None
    row: int


class WavefrontCosts:
    """A lazy `CostOracle`: a wave runs only as far as the question asked requires.

    Parameters
    ----------
    robot : FrontierRobot
        The robot that decides.
    alone : bool
        Leave the other robots out.
    every : bool
        Compute the robot's own costs to all targets. It then looks for other cells of every
        frontier whose target it cannot reach; otherwise only if it can reach no target.

    Attributes
    ----------
    robots : tuple of int
        Ids of the robots that are taken into account, ascending.
    row : int
        Row of the deciding robot.
    field : DistanceField or None
        Distances from the deciding robot; None if no passable cell is near it.
    targets : (m, 2) array
        Targets of the frontiers in metres.
    costs : (n, m) array
        Path lengths in metres; ``inf`` where there is no path or none was computed.
    is_choosable : (m,) array of bool
        Whether the deciding robot has time for a target and, with `every`, can reach it.
    """

    def __init__(self, robot: FrontierRobot, *, alone: bool = False, every: bool = False) -> None:
        self.robot = robot
        places = {robot.me.robot: robot.at[:2]}
        if not alone:
            places.update({report.robot: report.place[:2] for report in robot.team.present()})
        self.robots = tuple(sorted(places))
        self.row = self.robots.index(robot.me.robot)
        self._places = [places[number] for number in self.robots]
        # Bodies that this robot knows to be in the way are in its own way only.
        with robot.around_bodies():
            self.field = robot.own_field()
            self._fields: dict[int, DistanceField | None] = {self.row: self.field}
            self._take_targets()
            if self.field is None:
                self.is_choosable[:] = False
            elif every:
                self._put_all_in_reach(self.field)
            else:
                self._put_one_in_reach(self.field)
            self._leave_out_late()
            if not every and self.field is not None and not self.is_choosable.any():
                self._look_again(self.field)
            if every and self.field is not None:
                own = self.field.distance(self._indices)
                self.costs[self.row] = np.where(self.is_choosable, own, np.inf)

    def _take_targets(self) -> None:
        self.targets = self.robot.targets()
        self._indices = self.robot.indices_of(self.targets)
        self.costs = np.full((len(self.robots), len(self.targets)), np.inf)
        self.is_choosable: BoolArray = np.ones(len(self.targets), np.bool_)
        self._own_nearest: tuple[float, int] | None = None

    def _put_all_in_reach(self, field: DistanceField) -> None:
        """Look for other cells of all frontiers whose targets are out of reach."""
        reach = field.reachable()
        # What was left out has to be looked at again: parts of the map join as it grows.
        if self.robot.frontiers.leaves_out or not reach[tuple(self._indices.T)].all():
            self.robot.look_closer(reach)
            self._take_targets()
        self.is_choosable = reach[tuple(self._indices.T)]

    def _put_one_in_reach(self, field: DistanceField) -> None:
        """Find the nearest target; look for other cells if there is none, or one is left out."""
        self._find_nearest()
        is_some = self._own_nearest is not None
        if is_some and not self.robot.frontiers.leaves_out:
            return
        if self.robot.look_closer(field.reachable()) or is_some:
            self._take_targets()
            self._find_nearest()

    def _find_nearest(self) -> None:
        self._own_nearest = self._first(self.row, np.arange(len(self.targets)), math.inf)

    def _look_again(self, field: DistanceField) -> None:
        """Look for other cells of frontiers where there is no time for any target in reach."""
        if self.robot.look_closer(field.reachable()):
            self._take_targets()
            self._find_nearest()
            self._leave_out_late()

    def _leave_out_late(self) -> None:
        """Leave out of the deciding robot's own choice the targets that it has no time for."""
        if self.field is None or self.robot.homing is None:
            return
        self.is_choosable = np.isfinite(self.robot.fitting_costs(self.field, self.targets))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of robots and number of targets."""
        return len(self.robots), len(self.targets)

    def table(self) -> Table:
        """Return the targets and the costs computed so far."""
        return Table(
            targets=self.targets,
            robots=self.robots,
            costs=self.costs,
            field=self.field,
            row=self.row,
        )

    def lower_bounds(self) -> FloatArray:
        """Return the Euclidean distances less an allowance for rounding, ``(n, m)`` metres."""
        places = np.array(self._places)
        if self.field is not None:
            places[self.row] = self.field.sources[0]
        offsets = places[:, None] - self.targets
        euclidean = np.hypot(offsets[..., 0], offsets[..., 1])
        spare_m = np.full((len(self.robots), 1), BOUND_CELLS * self.robot.raster.cell_m)
        for row, centre in self._centres.items():
            # The wave from a robot beside passable cells begins at the nearest of them.
            away_m = math.dist(self._places[row], centre) + CENTRE_CELLS * self.robot.raster.cell_m
            spare_m[row] = max(spare_m[row, 0], away_m)
        bounds: FloatArray = np.maximum(0.0, euclidean - spare_m) / BOUND_FACTOR
        return bounds

    def nearest(
        self, robot: int, frontiers: IntArray, limit_m: float = math.inf
    ) -> tuple[float, int] | None:
        """Return the nearest of some targets for one robot; see `CostOracle.nearest`.

        The wave from the robot stops at the first of them, or at the limit.
        """
        if robot != self.row:
            return self._first(robot, frontiers, limit_m)
        frontiers = frontiers[self.is_choosable[frontiers]]
        known = self._own_nearest
        if known is not None and known[1] in frontiers:
            return known
        with self.robot.around_bodies():
            return self._first(robot, frontiers, limit_m)

    def own_cost(self, target: int) -> float:
        """Return the deciding robot's cost to a target in metres.

        It is ``inf`` if the robot cannot reach it, or has no time for it.
        """
        if not self.is_choosable[target]:
            return math.inf
        if self.field is not None and not np.isfinite(self.costs[self.row, target]):
            with self.robot.around_bodies():
                self.costs[self.row, target] = self.field.distance(self._indices[[target]])[0]
        return float(self.costs[self.row, target])

    def _first(self, robot: int, frontiers: IntArray, limit_m: float) -> tuple[float, int] | None:
        field = self._field_from(robot)
        found = None if field is None else field.first(self._indices[frontiers], limit_m)
        if found is None:
            return None
        place, cost = found
        target = int(frontiers[place])
        self.costs[robot, target] = cost
        return cost, target

    def robots_ahead(self, robot: int, frontier: int) -> Iterator[int]:
        """Iterate over the robots nearer to a target than one robot, the nearest first.

        A wave from the target runs on while the next robot is asked for, if the Euclidean distance
        of any other robot allows it to be nearer. The robot's own cost has to be known already.
        Robots in one cell take turns, see `positions`.
        """
        return chain(self._ahead_of_cell(robot, frontier), self._ahead_in_cell(robot, frontier))

    def compute_others(self) -> None:
        """Compute the costs of all other robots to all targets."""
        for row in range(len(self.robots)):
            if row != self.row:
                self._compute_row(row)

    def _ahead_of_cell(self, robot: int, target: int) -> Iterator[int]:
        waiting = [robot, *self._rivals(robot, target)]
        if len(waiting) == 1:
            return
        wave = self.robot.field(*self.targets[target].tolist())
        assert wave is not None, "a target that can be reached is in a passable cell"
        indices = self.robot.indices_of(np.array([self._centres[row] for row in waiting]))
        while (found := wave.first(indices)) is not None:
            place, cost = found
            row = waiting.pop(place)
            if row == robot:
                return
            indices = np.delete(indices, place, axis=0)
            self.costs[row, target] = cost
            yield row

    def _ahead_in_cell(self, robot: int, target: int) -> Iterator[int]:
        here = [i for i, cell in enumerate(self._cells) if cell == self._cells[robot]]
        if len(here) > 1 and (field := self.robot.field(*self._places[robot])) is not None:
            costs = field.distance(self._indices)
            ranks = positions(np.tile(costs, (len(here), 1)))[:, target]
            own = ranks[here.index(robot)]
            yield from (here[i] for i in np.argsort(ranks)[:own].tolist())

    def _rivals(self, robot: int, target: int) -> list[int]:
        """Return the robots in other cells whose Euclidean distance allows them to be nearer."""
        near_m = BOUND_FACTOR * self.costs[robot, target]
        near_m += BOUND_CELLS * self.robot.raster.cell_m
        own, place = self._cells[robot], self.targets[target].tolist()
        return [
            row
            for row, centre in self._centres.items()
            if self._cells[row] != own and math.dist(centre, place) <= near_m
        ]

    @cached_property
    def _cells(self) -> list[tuple[int, int] | None]:
        near = self.robot.raster.passable_near
        return [near(x, y, NEAR_BY_CELLS) for x, y in self._places]

    @cached_property
    def _centres(self) -> dict[int, Place]:
        centre_of = self.robot.raster.centre_of
        return {row: centre_of(*cell) for row, cell in enumerate(self._cells) if cell is not None}

    def _field_from(self, row: int) -> DistanceField | None:
        if row not in self._fields:
            self._fields[row] = self.robot.field(*self._places[row])
        return self._fields[row]

    def _compute_row(self, row: int) -> None:
        field = self._field_from(row)
        if field is not None:
            self.costs[row] = field.distance(self._indices)


def own_costs(robot: FrontierRobot) -> Table:
    """Return one robot's costs to all targets, as a table of one row."""
    return WavefrontCosts(robot, alone=True, every=True).table()


def full_table(robot: FrontierRobot) -> Table:
    """Return the costs of all robots that are taken into account to all targets."""
    costs = WavefrontCosts(robot, every=True)
    costs.compute_others()
    return costs.table()
