"""Rules on lazy wavefronts decide as on the full table, over random grids."""

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.costs import DenseCosts
from multisrt.planners.assignment.gain import LazyCosts, ValueParameters, gain
from multisrt.planners.assignment.gain_tours import gain_on_tours
from multisrt.planners.assignment.greedy import greedy
from multisrt.planners.assignment.minpos import minpos
from multisrt.robots.frontier.wavefront_costs import WavefrontCosts, full_table

ROWS, COLUMNS = 12, 15


class GridRobot:
    """Robot 0 of a team on a grid of cells of 1 m, with what wavefronts need."""

    def __init__(self, passable, cells, targets) -> None:
        self.passable = passable
        (row, column), *others = cells
        self.me = SimpleNamespace(robot=0)
        self.at = (column + 0.5, row + 0.5, 0.0)
        self.raster = SimpleNamespace(
            cell_m=1.0,
            passable_near=lambda x, y, _: self.nearest_cell(x, y),
            centre_of=lambda r, c: (c + 0.5, r + 0.5),
            indices_of=lambda cells: tuple(np.asarray(cells).T),
        )
        reports = [
            SimpleNamespace(robot=k, place=(c + 0.5, r + 0.5, 0.0))
            for k, (r, c) in enumerate(others, start=1)
        ]
        self.team = SimpleNamespace(present=lambda: reports)
        self.frontiers = SimpleNamespace(leaves_out=False)
        self.homing = None
        self.marched: list[DistanceField] = []
        self._targets = np.array([(c + 0.5, r + 0.5) for r, c in targets]).reshape(-1, 2)

    def nearest_cell(self, x, y):
        cells = np.argwhere(self.passable)
        return tuple(cells[np.hypot(*(cells + 0.5 - (y, x)).T).argmin()].tolist())

    def around_bodies(self):
        return nullcontext()

    def look_closer(self, _field):
        return False

    def targets(self):
        return self._targets

    def indices_of(self, places):
        return np.floor(places[:, ::-1]).astype(np.int64)

    def own_field(self):
        return self.field(*self.at[:2])

    def field(self, x, y):
        row, column = self.nearest_cell(x, y)
        self.marched.append(DistanceField(self.passable, 1.0, [(column + 0.5, row + 0.5)]))
        return self.marched[-1]


def grid_robot(*situation: Any) -> Any:
    """A robot on a grid, in place of a `FrontierRobot`."""
    return GridRobot(*situation)


@st.composite
def situations(draw, *, others_are_free=True):
    """Return a passable grid, the cells of robots and those of targets, mostly all passable."""
    cells = st.tuples(st.integers(0, ROWS - 1), st.integers(0, COLUMNS - 1))
    robots = draw(st.lists(cells, min_size=1, max_size=4))
    targets = draw(st.lists(cells, max_size=6, unique=True))
    passable = ~draw(arrays(bool, (ROWS, COLUMNS), elements=st.booleans(), fill=st.just(False)))
    for cell in (*(robots if others_are_free else robots[:1]), *targets):
        passable[cell] = True
    return passable, robots, targets


def has_ties(costs):
    """Whether two targets are equally far from a robot: a wave finds either of them first."""
    return any(len(np.unique(row[np.isfinite(row)])) < np.isfinite(row).sum() for row in costs)


@given(situations(others_are_free=False))
def test_no_cost_is_below_its_bound(situation):
    costs = full_table(grid_robot(*situation)).costs
    assert (WavefrontCosts(grid_robot(*situation)).lower_bounds() <= costs).all()


def test_a_robot_off_the_passable_cells_is_as_near_as_the_nearest_of_them():
    # A corridor; robot 1 is eight cells off it, next to target 0, which is worth less.
    passable = np.zeros((10, 15), np.bool_)
    passable[0] = True
    robot = grid_robot(passable, [(0, 0), (8, 7)], [(0, 8)])
    assert full_table(robot).costs[1, 0] == 1.0
    assert WavefrontCosts(robot).lower_bounds()[1, 0] <= 1.0


def on_tours(costs, areas, distances):
    return gain_on_tours(costs, areas, distances, distances, 0, parameters=ValueParameters(4.0))


def by_value(costs, areas, distances):
    return gain(costs, areas, distances, 0, range_m=4.0)


@pytest.mark.parametrize("choose", [on_tours, by_value])
@given(
    situation=situations(others_are_free=False),
    areas=st.lists(st.sampled_from([0.0, 1.0, 2.5, 9.0]), min_size=6, max_size=6),
)
def test_gain_chooses_as_on_the_full_table(choose, situation, areas):
    whole = full_table(grid_robot(*situation))
    lazy = WavefrontCosts(grid_robot(*situation), every=True)
    near = np.flatnonzero(np.isfinite(whole.costs[0]))
    distances = np.hypot(*(whole.targets[near, None] - whole.targets[near]).transpose(2, 0, 1))

    def cost_of(row, target):
        found = lazy.nearest(row, near[[target]])
        return np.inf if found is None else found[0]

    bounds = lazy.lower_bounds()
    bounds[0] = lazy.costs[0]
    chosen = [
        choose(costs, areas[: len(near)], distances)
        for costs in (whole.costs[:, near], LazyCosts(bounds[:, near], cost_of))
    ]
    assert chosen[0].choice == chosen[1].choice
    assert chosen[0].rounds == chosen[1].rounds


@given(situations())
def test_greedy_assigns_as_on_the_full_table(situation):
    dense = DenseCosts(full_table(grid_robot(*situation)).costs)
    assume(not has_ties(dense.table))
    for robot in range(len(situation[1])):
        lazy = WavefrontCosts(grid_robot(*situation))
        assert greedy(lazy, until=robot).rounds == greedy(dense, until=robot).rounds


@given(situations())
def test_closest_chooses_as_on_the_full_table(situation):
    table = full_table(grid_robot(*situation))
    lazy = WavefrontCosts(grid_robot(*situation), alone=True)
    choice = closest(lazy, lazy.row)
    if choice is None:
        assert not np.isfinite(table.costs[0]).any()
    else:
        assert table.costs[0, choice] == table.costs[0].min()


@given(situations())
def test_minpos_chooses_as_on_the_full_table(situation):
    table = full_table(grid_robot(*situation))
    # Marches from either end differ by some percent of the way, so near ties are left out.
    columns = np.sort(table.costs, axis=0)
    with np.errstate(invalid="ignore"):
        assume(not (np.diff(columns, axis=0) < 1.0).any())
    assume(not has_ties(table.costs))
    lazy = WavefrontCosts(grid_robot(*situation))
    assert minpos(lazy, 0).choice == minpos(DenseCosts(table.costs), 0).choice


def test_greedy_marches_no_farther_than_needed():
    # In a corridor of 200 m, robot 0 is 2 m from a target; robot 1, 100 m away, is not asked.
    corridor = np.ones((1, 200), np.bool_)
    robot = grid_robot(corridor, [(0, 10), (0, 110)], [(0, 12), (0, 60)])
    lazy = WavefrontCosts(robot)
    assert greedy(lazy, until=0).rounds == ((0, 0, 2.0),)
    (own,) = robot.marched
    assert np.isfinite(own.reached()).sum() < 10


def test_minpos_marches_no_farther_than_needed():
    # Robot 0 is 2 m from a target, and no other robot can be nearer: no wave runs from there.
    corridor = np.ones((1, 200), np.bool_)
    robot = grid_robot(corridor, [(0, 10), (0, 110)], [(0, 12), (0, 60)])
    assert minpos(WavefrontCosts(robot), 0).choice == 0
    assert len(robot.marched) == 1
