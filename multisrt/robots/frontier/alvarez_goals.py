"""RULES: the map as cells of the search, their scores, and the path to one of them.

Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D, sections 3.2.3 to 3.2.5. Differs in:

- The size of the map is not known: searched is the bounding rectangle of the known area, grown by
  one cell on every side.
- The search ends when it has found unexplored cells to the number of 5 % (`enough_share`) of all
  cells of that rectangle. So does Algorithm 2 of the thesis, with the cells of the map; its text
  has 5 % of the unexplored cells.
- A* runs over the raster that the body moves on, not over the larger cells of the search, which
  would close a door not much wider than the body. It keeps the body's radius from known obstacles,
  and enters the unknown only where a frontier is wide enough for the body.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.grids.occupancy import UNKNOWN, Occupancy
from multisrt.geometry.grids.sight import in_sight
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray
from multisrt.planners.assignment.cell_choice import GoalChoice, choose_cell
from multisrt.planners.grid_search import DIAGONAL, a_star, reachable, ring_search
from multisrt.planners.navigation.sector import cells_ahead
from multisrt.robots.frontier.fields import NEAR_BY_CELLS
from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.options import RulesOptions
from multisrt.robots.frontier.robot import FrontierRobot

Cell = tuple[int, int]

BESIDE = 1.5
"""Distance in cells from the edge of a body to the centres of the cells diagonally beside it."""

SAMPLES = 4
"""Number of points sampled on a line for each cell that it crosses."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Survey:
    """The map of one robot as the rules see it.

    Attributes
    ----------
    row, column : int
        Where the first row and column of the raster's cells lie in the lattice.
    unknown, traversable : (rows, columns) array of bool
        Which cells of the raster are unknown, and which ones A* may pass.
    start : (row, column) or None
        The cell at which its paths begin; None if none is passable near the robot.
    xs, ys : (m,) and (n,) arrays
        Centres of the columns and rows of the cells of the search in metres.
    at : tuple of arrays
        Indices of the raster's cells at the centres of the cells of the search, (n, m).
    inaccessible : tuple of (row, column)
        Cells of the search that all robots found inaccessible.
    width_m : float
        Width of a cell of the search.
    """

    row: int
    column: int
    unknown: BoolArray
    traversable: BoolArray
    start: Cell | None
    xs: FloatArray
    ys: FloatArray
    at: tuple[IntArray, ...]
    inaccessible: tuple[Cell, ...]
    width_m: float

    @cached_property
    def reachable(self) -> BoolArray:
        """Which of the raster's cells can be reached from where the robot stands."""
        if self.start is None:
            return np.zeros(self.traversable.shape, np.bool_)
        return reachable(self.traversable, *self.start)

    @cached_property
    def unexplored(self) -> BoolArray:
        """Which cells of the search are unexplored, by the raster's cell at the centre, (n, m)."""
        unexplored: BoolArray = self.unknown[self.at]
        for cell in self.inaccessible:
            unexplored[cell] = False
        return unexplored

    @cached_property
    def obstacle(self) -> BoolArray:
        """Which cells of the search are obstacles, (n, m)."""
        unknown = self.unknown[self.at]
        obstacle: BoolArray = ~unknown & ~self.traversable[self.at]
        for cell in self.inaccessible:
            obstacle[cell] |= unknown[cell]
        return obstacle

    @cached_property
    def centres(self) -> FloatArray:
        """Centres of the cells of the search in metres, (n, m, 2)."""
        return np.stack(np.meshgrid(self.xs, self.ys), axis=-1)

    @property
    def diagonal_m(self) -> float:
        """Diagonal of the map in metres."""
        xs, ys, width = self.xs, self.ys, self.width_m
        return math.hypot(xs[-1] - xs[0] + width, ys[-1] - ys[0] + width)

    def index_of(self, raster: Occupancy, place: Place) -> Cell | None:
        """Return the indices of the raster's cell of a place; None if it is outside the arrays."""
        row, column = raster.cell_of(*place)
        row, column = row - self.row, column - self.column
        rows, columns = self.unknown.shape
        return (row, column) if 0 <= row < rows and 0 <= column < columns else None

    def can_reach(self, raster: Occupancy, place: Place) -> bool:
        """Whether a path leads from the robot to a place."""
        index = self.index_of(raster, place)
        return index is not None and bool(self.reachable[index])


class PathToCell(NamedTuple):
    """A path to an unexplored cell.

    Attributes
    ----------
    edge : (x, y)
        The last known place on it, where the body can stand.
    cost_m : float
        Its length in metres.
    """

    edge: Place
    cost_m: float


def take_survey(
    robot: FrontierRobot, tried: Iterable[Place], inaccessible: Iterable[Place]
) -> Survey:
    """Return the map of one robot for one choice.

    Parameters
    ----------
    robot : FrontierRobot
        The robot. In `around_bodies`, bodies in its way are obstacles too.
    tried : iterable of (x, y)
        Places at the edge of the known area that were tried without result.
    inaccessible : iterable of (x, y)
        Cells of the search that all robots found inaccessible; they are obstacles.
    """
    raster, width = robot.raster, robot_options(robot).search_cell_m
    seen = raster.cells != UNKNOWN
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    pad = math.ceil(width / raster.cell_m) + 2
    shape = (int(np.ptp(rows)) + 1 + 2 * pad, int(np.ptp(columns)) + 1 + 2 * pad)
    row, column = raster.row + int(rows[0]) - pad, raster.column + int(columns[0]) - pad
    inner = slice(pad, shape[0] - pad), slice(pad, shape[1] - pad)
    held = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    unknown, traversable = np.ones(shape, np.bool_), np.zeros(shape, np.bool_)
    unknown[inner] = ~seen[held]
    traversable[inner] = raster.passable[held]
    traversable |= unknown & ~_closed(robot, tried, (row, column), shape)

    start = robot.path_finder.first_cell()
    x0, y0 = raster.centre_of(row + pad, column + pad)
    x1, y1 = raster.centre_of(row + shape[0] - pad - 1, column + shape[1] - pad - 1)
    xs, ys = _middles(x0 - width, x1 + width, width), _middles(y0 - width, y1 + width, width)
    places = [(round((y - ys[0]) / width), round((x - xs[0]) / width)) for x, y in inaccessible]
    return Survey(
        row=row,
        column=column,
        unknown=unknown,
        traversable=traversable,
        start=None if start is None else (start[0] - row, start[1] - column),
        xs=xs,
        ys=ys,
        at=np.ix_(
            raster.cells_of(np.column_stack([np.zeros(len(ys)), ys]))[:, 0] - row,
            raster.cells_of(np.column_stack([xs, np.zeros(len(xs))]))[:, 1] - column,
        ),
        inaccessible=tuple((r, c) for r, c in places if 0 <= r < len(ys) and 0 <= c < len(xs)),
        width_m=width,
    )


def robot_options(robot: FrontierRobot) -> RulesOptions:
    """Return the parameters of a robot that goes by the rules."""
    assert isinstance(robot.options, RulesOptions)
    return robot.options


def _nearest(middles: FloatArray, value: float, width: float) -> int:
    # A robot that sees hardly farther than its body reaches may see the centre of no cell, and know
    # only what others told it, far away: then it stands outside of its map.
    return min(max(round((value - float(middles[0])) / width), 0), len(middles) - 1)


def _middles(low: float, high: float, width: float) -> FloatArray:
    """Return the centres, along one axis, of the cells whose centres lie between two values.

    The borders are at multiples of the width, so that all robots have the same cells.
    """
    first, last = math.ceil(low / width - 0.5), math.floor(high / width - 0.5)
    middles: FloatArray = (np.arange(first, last + 1, dtype=np.float64) + 0.5) * width
    return middles


def _closed(
    robot: FrontierRobot, tried: Iterable[Place], corner: Cell, shape: tuple[int, int]
) -> NDArray[np.bool_]:
    """Return the unknown cells next to a frontier too narrow for the body, or a place tried."""
    raster = robot.raster
    wide = {id(group) for group in robot.frontiers.groups() if group.target is not None}
    closed = np.zeros(shape, np.bool_)
    narrow = [g.cells for g in raster.frontier_groups(0.0) if id(g) not in wide]
    r, c = np.vstack([np.empty((0, 2), np.int64), *narrow]).T - np.array(corner)[:, None]
    for across, along in product((-1, 0, 1), repeat=2):
        closed[r + across, c + along] = True
    reach = 0.5 * robot.me.footprint.width_m / raster.cell_m + BESIDE
    n = math.floor(reach)
    for place in tried:
        row, column = raster.cell_of(*place)
        r0, c0 = row - corner[0], column - corner[1]
        rows = np.arange(max(0, r0 - n), min(shape[0], r0 + n + 1))
        columns = np.arange(max(0, c0 - n), min(shape[1], c0 + n + 1))
        near = np.hypot(rows[:, None] - r0, columns[None] - c0) <= reach
        closed[np.ix_(rows, columns)] |= near
    return closed


def search(
    robot: FrontierRobot, survey: Survey, goals: FloatArray, everywhere: bool = False
) -> tuple[FloatArray, GoalChoice]:
    """GOAL SEARCH: score the unexplored cells around a robot.

    Parameters
    ----------
    robot : FrontierRobot
        The robot.
    survey : Survey
        Its map.
    goals : (g, 2) array
        Goals of the other robots in metres.
    everywhere : bool
        Whether to score all unexplored cells, not only those that the growing ring finds.

    Returns
    -------
    cells : (k, 2) array
        Centres of the cells in metres.
    GoalChoice
        Their scores.
    """
    options = robot_options(robot)
    cells = survey.centres[survey.unexplored]
    if not everywhere:
        found = ring_search(
            ~survey.obstacle,
            survey.unexplored,
            _nearest(survey.ys, robot.at.y, options.search_cell_m),
            _nearest(survey.xs, robot.at.x, options.search_cell_m),
            math.ceil(options.enough_share * survey.unexplored.size),
        )
        cells = survey.centres[found[:, 0], found[:, 1]]
    x, y, heading = robot.at
    offsets = cells - (x, y)
    to_goals = np.hypot(*(goals[:, None] - cells[None]).transpose(2, 0, 1))
    return cells, choose_cell(
        np.hypot(*offsets.T),
        libm.arctan2(offsets[:, 1], offsets[:, 0]) - heading,
        to_goals,
        robot.me.team,
        survey.diagonal_m,
        distance_weight=options.distance_weight,
        turn_weight=options.turn_weight,
        others_weight=options.others_weight,
    )


def path_to(robot: FrontierRobot, survey: Survey, aim: Place) -> PathToCell | None:
    """Return the path to an unexplored cell; None if there is none, or the cell has been seen.

    LOOK AHEAD: where no obstacle lies ahead, the path is straight. PLAN: otherwise by A*.
    """
    raster, width = robot.raster, robot_options(robot).search_cell_m
    goal = survey.index_of(raster, aim)
    if survey.start is None or goal is None or not survey.unknown[goal]:
        return None
    (r, c), (goal_r, goal_c) = survey.start, goal
    obstacles = survey.centres[survey.obstacle]
    if not cells_ahead(obstacles, robot.at[:2], aim, width).any() and in_sight(
        survey.traversable, c + 0.5, r + 0.5, goal_c, goal_r
    ):
        n = SAMPLES * (abs(goal_r - r) + abs(goal_c - c)) + 1
        line = np.linspace((r + 0.5, c + 0.5), (goal_r + 0.5, goal_c + 0.5), n)
        path, cells = np.floor(line).astype(np.int64), math.hypot(goal_r - r, goal_c - c)
    else:
        path = a_star(survey.traversable, r, c, goal_r, goal_c)
        if not len(path):
            return None
        cells = _length(path)
    row, column = path[last_known(survey.traversable & ~survey.unknown, path)].tolist()
    edge = raster.centre_of(row + survey.row, column + survey.column)
    return PathToCell(edge, cells * raster.cell_m)


def last_known(known: BoolArray, path: IntArray) -> int:
    """Return the index of the last cell of a path before its first step into unknown cells.

    Parameters
    ----------
    known : (rows, columns) array of bool
        Which cells are known.
    path : (n, 2) array of int
        The path as rows and columns; its last cell is not known.

    Returns
    -------
    int
        Index into the path. A diagonal step counts as known if one of the two cells beside it is.
    """
    rows, columns = path.T
    beside = known[rows[:-1], columns[1:]] | known[rows[1:], columns[:-1]]
    return int(np.argmin(known[rows[1:], columns[1:]] & beside))


def path_cost(robot: FrontierRobot, survey: Survey, place: Place, aim: Place) -> float:
    """Return the length in metres of the path of A* from a place to a cell; inf without one."""
    start = robot.raster.passable_near(*place, NEAR_BY_CELLS)
    goal = survey.index_of(robot.raster, aim)
    if start is None or goal is None:
        return math.inf
    path = a_star(survey.traversable, start[0] - survey.row, start[1] - survey.column, *goal)
    return _length(path) * robot.raster.cell_m if len(path) else math.inf


def _length(path: IntArray) -> float:
    """Return the length of a path of cells, in cells."""
    steps = np.abs(np.diff(path, axis=0)).sum(axis=1)
    return float((steps == 1).sum() + DIAGONAL * (steps == 2).sum())


def is_open(raster: Occupancy, place: Place) -> bool:
    """Whether the raster's cell of a place has an unknown neighbour."""
    row, column = raster.cell_of(*place)
    return any(
        not raster.is_known(*raster.centre_of(r, c))
        for r in range(row - 1, row + 2)
        for c in range(column - 1, column + 2)
    )
