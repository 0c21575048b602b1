"""A policy for the indoor exploration competition that stands alone: gain over way, home in time.

This file needs numpy and numba only, and nothing of the package that it is part of, so that it can
be handed in as it is: ``multisrt compete --policy-out`` copies it.

A robot is asked for a goal at every step, since it names cells of its way that are three cells
ahead. So it drives exactly the way that it planned:

- **Ways** lead through cells all of whose neighbours are known to be free. A cell next to an
  unknown one may turn out to be too near to a wall, and a robot that has passed it is shut in.
- **Targets** are pieces of the borders between free and unknown cells. The value of a target is the
  unknown area in sight of it, and a constant for what it would cost to come back, over a power of
  the way. Robots take targets in order of value, as in `multisrt.planners.assignment.gain`; those
  that are taken leave less to others near them. Each robot works this out for itself, for all
  robots that it is in contact with.
- **Home** is every cell from which a link to the base holds on what is known, unknown cells counted
  as walls. Targets from which a robot could not be there in time are none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

Cells = NDArray[np.int64]
Grid = NDArray[np.int8]
Way = NDArray[np.int32]
Floats = NDArray[np.float64]

FREE, UNKNOWN, OCCUPIED = 0, 1, 2
"""States of a cell."""

STEP = 3
"""Cells that a robot drives in a step."""

BORDER = 2
"""Cells around the scored area that are looked at."""

RAYS = 90
"""Rays by which unknown area is measured: one for every 4 degrees."""


F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile a function when it is first called, and keep it on disk."""
    return cast(F, numba.njit(cache=True)(function))


@dataclass(frozen=True)
class Settings:
    """The constants of the policy; lengths in cells, areas in cells, times in steps.

    Attributes
    ----------
    power : float
        Power of the way.
    return_area : float
        Added to the area of every target: what it would cost to come back.
    return_share : float
        Upper bound of what is added, as a share of the area itself.
    wall : int
        Unknown cells between two occupied ones of a row or column that are taken as wall.
    nearest : float
        Added to every way.
    sight : float
        Range up to which unknown area counts.
    apart : float
        Distance from which a target leaves the area of another one to it.
    keep : float
        Factor on the value of the present target.
    every : int
        Steps between two plans.
    margin : int
        Steps that are kept in reserve on the way home.
    piece : int
        Half the width of a piece of a border.
    least : int
        Cells of the shortest border that counts.
    recall : int
        For how long the target of a robot out of contact counts.
    """

    power: float = 1.5
    return_area: float = 400.0
    return_share: float = 2.0
    wall: int = 15
    nearest: float = 5.0
    sight: float = 60.0
    apart: float = 80.0
    keep: float = 1.1
    every: int = 3
    margin: int = 4
    piece: int = 12
    least: int = 6
    recall: int = 100


@dataclass
class Memory:
    """What one robot remembers between two questions.

    A policy is one object for the whole team; what robots know must not pass through it. So each
    has a memory of its own, found by an array that the simulator keeps for it alone.
    """

    mask: object
    shape: tuple[int, int]
    time: int = 0
    end: int = 1000
    next_plan: int = 0
    route: Way | None = None
    target: tuple[int, int] | None = None
    home: Way | None = None
    zone: tuple[Cells, Cells] | None = None
    zone_time: int = -1000
    done: list[tuple[int, int]] = field(default_factory=list)
    heard: dict[int, int] = field(default_factory=dict)
    believed: dict[int, tuple[int, int]] = field(default_factory=dict)
    queue: Cells = field(default_factory=lambda: np.empty(0, np.int64))


class GainHome:
    """Drive to the target of the highest gain over way, and be in touch with the base at the end.

    Parameters
    ----------
    settings : Settings, optional
        The constants.
    """

    def __init__(self, settings: Settings | None = None) -> None:
        self.settings = settings or Settings()
        self._memories: dict[int, Memory] = {}

    def should_relay(self, obs: Any, collect_opts: Any, t: int, max_steps: int) -> None:
        """Note the time; robots drive home by goals of their own, never by the relay mode."""
        memory = self._memory(obs)
        memory.time, memory.end = t, max_steps

    def decide_relay_handoff(self, obs: Any, collect_opts: Any) -> None:
        """Hand nothing over."""

    def decide(self, obs: Any, collect_opts: Any) -> NDArray[np.int64] | None:
        """Return the cell three cells ahead on the robot's way."""
        memory = self._memory(obs)
        corner = obs.pd_size - BORDER
        row, column = (int(x) - corner for x in obs.pose)
        if memory.route is None or memory.time >= memory.next_plan:
            self._plan(memory, obs, collect_opts, row, column)
        ahead = self._ahead(memory, obs, row, column)
        if ahead is None:  # it has arrived, or a wall was seen on its way
            self._plan(memory, obs, collect_opts, row, column)
            ahead = self._ahead(memory, obs, row, column)
        if ahead is None:  # it stays, unless a wall was seen beside it: no goal may be there
            here = is_clear(obs.combined_obs_map, row + corner, column + corner)
            ahead = (row, column) if here else None
        return None if ahead is None else np.array(ahead, np.int64) + corner

    def _ahead(self, memory: Memory, obs: Any, row: int, column: int) -> tuple[int, int] | None:
        """Return the cell a step ahead on the way; None if there is none, or it is blocked."""
        if memory.route is None:
            return None
        corner, place = obs.pd_size - BORDER, (row, column)
        for _ in range(STEP):
            r, c = descend(memory.route, *place, 1)
            if (r, c) == place:
                break
            if not is_clear(obs.combined_obs_map, r + corner, c + corner):
                return None
            place = int(r), int(c)
        return None if place == (row, column) else place

    def _memory(self, obs: Any) -> Memory:
        key = id(obs.unreported_mask)
        if key not in self._memories:
            margin = 2 * (obs.pd_size - BORDER)
            rows, columns = obs.combined_obs_map.shape
            shape = rows - margin, columns - margin
            self._memories[key] = Memory(
                obs.unreported_mask, shape, queue=np.empty(shape[0] * shape[1], np.int64)
            )
        return self._memories[key]

    def _plan(self, memory: Memory, obs: Any, options: Any, row: int, column: int) -> None:
        """Choose a target, and set the field down which the robot drives."""
        settings, queue = self.settings, memory.queue
        corner = obs.pd_size - BORDER
        base = int(obs.base_pose[0]) - corner, int(obs.base_pose[1]) - corner
        states = cropped(obs.combined_obs_map, corner)
        passable = passable_cells(states)
        passable[row, column] = True
        ways = field_from(passable, np.array([row]), np.array([column]), queue)
        if memory.zone is None or memory.time - memory.zone_time >= 25:
            memory.zone = zone(states, ways, base, radio(options))
            memory.zone_time = memory.time
        memory.home = home = field_from(passable, *memory.zone, queue)
        memory.next_plan = memory.time + settings.every

        targets = border_pieces(states, ways, settings.piece, settings.least, BORDER, queue)
        near = targets[ways[targets[:, 0], targets[:, 1]] == 0]
        memory.done.extend(map(tuple, near.tolist()))
        if memory.done and len(targets):
            done = np.array(memory.done)
            far = np.abs(targets[:, None] - done[None]).max(axis=2) > 4
            targets = targets[far.all(axis=1)]
        there, back = ways[targets[:, 0], targets[:, 1]], home[targets[:, 0], targets[:, 1]]
        left = memory.end - memory.time
        in_time = np.ceil((there + back) / STEP) + settings.margin <= left
        targets = targets[(there > 0) & (back >= 0) & in_time]
        if not len(targets):
            memory.target = None
            memory.route = home if home[row, column] > 0 else None
            return
        costs, robots = self._costs(memory, obs, passable, ways, targets, corner)
        chosen = self.choose(memory, states, targets, costs, robots)
        if chosen is None:
            memory.target, memory.route = None, None
            return
        memory.target = int(targets[chosen, 0]), int(targets[chosen, 1])
        memory.route = field_from(
            passable, targets[chosen : chosen + 1, 0], targets[chosen : chosen + 1, 1], queue
        )

    def _costs(
        self,
        memory: Memory,
        obs: Any,
        passable: NDArray[np.bool_],
        ways: Way,
        targets: Cells,
        corner: int,
    ) -> tuple[Floats, list[int]]:
        """Return the ways of this robot, the first, and of those in contact, and their numbers."""
        rows, robots = [ways[targets[:, 0], targets[:, 1]].astype(float)], [0]
        for number in obs.connected_robot_ids:
            places = obs.pose_lists_of_others.get(f"robot{number}")
            if places is None or not len(places):
                continue
            row, column = (int(x) - corner for x in places[-1])
            if not (0 <= row < passable.shape[0] and 0 <= column < passable.shape[1]):
                continue
            memory.heard[number] = memory.time
            field = field_from(passable, np.array([row]), np.array([column]), memory.queue)
            costs = field[targets[:, 0], targets[:, 1]].astype(float)
            costs[costs < 0] = np.inf
            rows.append(costs)
            robots.append(number)
        return np.array(rows), robots

    def choose(
        self, memory: Memory, states: Grid, targets: Cells, costs: Floats, robots: list[int]
    ) -> int | None:
        """Return the number of the target of the highest value, after those of the others."""
        s = self.settings
        seen = unknown_in_sight(with_walls(states, s.wall), targets, s.sight, BORDER)
        areas = seen + np.minimum(s.return_area, s.return_share * seen) + 1.0
        if memory.target is not None:
            same = np.abs(targets - np.array(memory.target)).sum(axis=1) < s.piece
            areas = np.where(same, s.keep * areas, areas)
        for number, place in memory.believed.items():
            if number not in robots and memory.time - memory.heard[number] < s.recall:
                areas = areas * np.minimum(1.0, distances(targets, place) / s.apart)
        weights = (costs + s.nearest) ** -s.power
        waiting: NDArray[np.bool_] = np.asarray(np.isfinite(costs).any(axis=1))
        while True:
            values = np.where(waiting[:, None], areas * weights, -1.0)
            taker, target = divmod(int(np.argmax(values)), len(targets))
            if taker == 0:
                return target
            waiting[taker] = False
            memory.believed[robots[taker]] = int(targets[target, 0]), int(targets[target, 1])
            gaps = distances(targets, targets[target])
            areas = areas * np.minimum(1.0, gaps / s.apart)


def distances(targets: Cells, place: Any) -> Floats:
    """Return the Euclidean distances of targets from a cell."""
    gaps = targets - np.asarray(place)
    apart: Floats = np.hypot(gaps[:, 0], gaps[:, 1])
    return apart


def radio(options: Any) -> tuple[int, float, float]:
    """Return the range of a link in cells, the walls it bears at 1 m, and how many less at 10 m.

    One wall and four cells are kept in reserve.
    """
    budget = (options.transmitted_power - options.power_threshold) / options.attenuation_constant
    slope = 10.0 * options.path_loss_exponent / options.attenuation_constant
    return int(options.pixel_per_meter * options.comm_range) - 4, budget - 1.5, slope


@kernel
def cropped(known: Floats, corner: int) -> Grid:
    """Return the states of the scored area and a border."""
    rows, columns = known.shape[0] - 2 * corner, known.shape[1] - 2 * corner
    states = np.empty((rows, columns), np.int8)
    for i in range(rows):
        for j in range(columns):
            value = known[i + corner, j + corner]
            states[i, j] = FREE if value == 0.0 else (OCCUPIED if value == 1.0 else UNKNOWN)
    return states


@kernel
def is_clear(known: Floats, row: int, column: int) -> bool:
    """Whether no cell around one is known to be occupied."""
    for a in range(row - 1, row + 2):
        for b in range(column - 1, column + 2):
            if known[a, b] == 1.0:
                return False
    return True


@kernel
def passable_cells(states: Grid) -> NDArray[np.bool_]:
    """Return the cells whose whole neighbourhood is known to be free."""
    rows, columns = states.shape
    passable = np.zeros((rows, columns), np.bool_)
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            if states[i, j] == FREE:
                found = True
                for a in range(i - 1, i + 2):
                    for b in range(j - 1, j + 2):
                        if states[a, b] != FREE:
                            found = False
                passable[i, j] = found
    return passable


@kernel
def field_from(passable: NDArray[np.bool_], rows: Cells, columns: Cells, queue: Cells) -> Way:
    """Return the way of every cell from the nearest of some cells; -1 where there is none."""
    height, width = passable.shape
    way = np.full((height, width), -1, np.int32)
    end = 0
    for k in range(len(rows)):
        if way[rows[k], columns[k]] < 0:
            way[rows[k], columns[k]] = 0
            queue[end] = rows[k] * width + columns[k]
            end += 1
    begin = 0
    while begin < end:
        cell = queue[begin]
        begin += 1
        i, j = cell // width, cell % width
        further = way[i, j] + 1
        if i > 0 and passable[i - 1, j] and way[i - 1, j] < 0:
            way[i - 1, j] = further
            queue[end] = cell - width
            end += 1
        if i < height - 1 and passable[i + 1, j] and way[i + 1, j] < 0:
            way[i + 1, j] = further
            queue[end] = cell + width
            end += 1
        if j > 0 and passable[i, j - 1] and way[i, j - 1] < 0:
            way[i, j - 1] = further
            queue[end] = cell - 1
            end += 1
        if j < width - 1 and passable[i, j + 1] and way[i, j + 1] < 0:
            way[i, j + 1] = further
            queue[end] = cell + 1
            end += 1
    return way


@kernel
def descend(way: Way, row: int, column: int, cells: int) -> tuple[int, int]:
    """Return the cell that is some cells down a field."""
    height, width = way.shape
    for _ in range(cells):
        less = way[row, column] - 1
        if less < 0:
            break
        if row > 0 and way[row - 1, column] == less:
            row -= 1
        elif row < height - 1 and way[row + 1, column] == less:
            row += 1
        elif column > 0 and way[row, column - 1] == less:
            column -= 1
        elif column < width - 1 and way[row, column + 1] == less:
            column += 1
        else:
            break
    return row, column


@kernel
def edge_cells(states: Grid, border: int) -> NDArray[np.bool_]:
    """Return the free cells beside unknown ones of the scored area."""
    rows, columns = states.shape
    edge = np.zeros((rows, columns), np.bool_)
    for i in range(border, rows - border):
        for j in range(border, columns - border):
            if states[i, j] == FREE:
                for a in range(max(border, i - 1), min(rows - border, i + 2)):
                    for b in range(max(border, j - 1), min(columns - border, j + 2)):
                        if states[a, b] == UNKNOWN:
                            edge[i, j] = True
    return edge


@kernel
def take_part(edge: NDArray[np.bool_], first: int, part: Cells) -> int:
    """Move the cells that are connected with one out of a mask; return how many they are."""
    rows, columns = edge.shape
    edge[first // columns, first % columns] = False
    part[0] = first
    begin, end = 0, 1
    while begin < end:
        i, j = part[begin] // columns, part[begin] % columns
        begin += 1
        for a in range(max(0, i - 1), min(rows, i + 2)):
            for b in range(max(0, j - 1), min(columns, j + 2)):
                if edge[a, b]:
                    edge[a, b] = False
                    part[end] = a * columns + b
                    end += 1
    return end


@kernel
def nearest_to_mean(ways: Way, cells: Cells) -> int:
    """Return the reachable cell nearest to the mean of cells, within 3 of one; -1 if none is."""
    rows, columns = ways.shape
    mean_i, mean_j = np.mean(cells // columns), np.mean(cells % columns)
    nearest, place = np.inf, -1
    for cell in cells:
        i, j = cell // columns, cell % columns
        for a in range(max(0, i - 3), min(rows, i + 4)):
            for b in range(max(0, j - 3), min(columns, j + 4)):
                gap = (a - mean_i) ** 2 + (b - mean_j) ** 2
                if ways[a, b] >= 0 and gap < nearest:
                    nearest, place = gap, a * columns + b
    return place


@kernel
def border_pieces(
    states: Grid, ways: Way, piece: int, least: int, border: int, queue: Cells
) -> Cells:
    """Return a reachable cell, ``(m, 2)``, of each piece of the borders of what is unknown.

    A border is a connected set of free cells beside unknown ones. It is cut into pieces as wide
    as twice `piece`; each is given by the reachable cell nearest to the mean of its cells.
    """
    columns = states.shape[1]
    edge = edge_cells(states, border)
    found = [0]
    for first in np.flatnonzero(edge):
        if not edge[first // columns, first % columns]:
            continue
        count = take_part(edge, int(first), queue)
        part = queue[:count].copy()
        while count >= least and len(part):
            i, j = part[0] // columns, part[0] % columns
            near = np.abs(part // columns - i) <= piece
            near &= np.abs(part % columns - j) <= piece
            place = nearest_to_mean(ways, part[near])
            if place >= 0:
                found.append(place)
            part = part[~near]
    targets = np.empty((len(found) - 1, 2), np.int64)
    for k in range(len(targets)):
        targets[k, 0] = found[k + 1] // columns
        targets[k, 1] = found[k + 1] % columns
    return targets


@kernel
def with_walls(states: Grid, longest: int) -> Grid:
    """Return a map in which short runs of unknown cells between occupied ones are occupied.

    They are the insides of walls, and the parts of walls that a pillar hides.
    """
    rows, columns = states.shape
    filled = states.copy()
    for i in range(rows):
        last = -1
        for j in range(columns):
            if states[i, j] == OCCUPIED:
                if last >= 0 and j - last - 1 <= longest:
                    filled[i, last + 1 : j] = OCCUPIED
                last = j
            elif states[i, j] == FREE:
                last = -1
    for j in range(columns):
        last = -1
        for i in range(rows):
            if states[i, j] == OCCUPIED:
                if last >= 0 and i - last - 1 <= longest:
                    filled[last + 1 : i, j] = OCCUPIED
                last = i
            elif states[i, j] == FREE:
                last = -1
    return filled


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


@kernel
def zone(
    states: Grid, ways: Way, base: tuple[int, int], link: tuple[int, float, float]
) -> tuple[Cells, Cells]:
    """Return the reachable cells from which a link to the base holds on what is known."""
    base_row, base_column = base
    reach, budget, slope = link
    rows, columns = states.shape
    found_rows, found_columns = [base_row], [base_column]
    for i in range(max(0, base_row - reach), min(rows, base_row + reach + 1)):
        for j in range(max(0, base_column - reach), min(columns, base_column + reach + 1)):
            if ways[i, j] < 0:
                continue
            gap = math.sqrt((i - base_row) ** 2 + (j - base_column) ** 2)
            if gap > reach or gap < 1.0:
                continue
            bears = math.floor(budget - slope * math.log10(gap / 10.0))
            count = max(abs(i - base_row), abs(j - base_column))
            walls = 0
            for k in range(count + 1):
                a = math.floor(base_row + (i - base_row) * k / count + 0.5)
                b = math.floor(base_column + (j - base_column) * k / count + 0.5)
                if states[a, b] != FREE:
                    walls += 1
                    if walls > bears:
                        break
            if walls <= bears:
                found_rows.append(i)
                found_columns.append(j)
    return np.array(found_rows), np.array(found_columns)
