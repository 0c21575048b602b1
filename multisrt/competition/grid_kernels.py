"""Compiled functions of the policy `gain_home` on grids: borders, ways, sight and rollouts.

This file needs numpy and numba only, and nothing of the package that it is part of: ``multisrt
compete --policy-out`` puts it at the head of the policy. Grids are ``[row, column]``; lengths are
in cells and areas in cells, times in steps of the competition's simulator.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

Cells = NDArray[np.int64]
Grid = NDArray[np.int8]
Way = NDArray[np.int32]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

FREE, UNKNOWN, OCCUPIED = 0, 1, 2
"""States of a cell."""

STEP = 3
"""Cells that a robot drives in a step."""

BORDER = 2
"""Cells around the scored area that are looked at."""

RAYS = 90
"""Rays by which unknown area is measured: one for every 4 degrees."""

BLOCK = 4
"""Side of the squares of cells in which unknown area is counted once."""


F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile a function when it is first called, and keep it on disk."""
    return cast(F, numba.njit(cache=True)(function))


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
def passable_cells(states: Grid) -> Flags:
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
def field_from(passable: Flags, rows: Cells, columns: Cells, queue: Cells) -> Way:
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
def edge_cells(states: Grid, border: int) -> Flags:
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
def take_part(edge: Flags, first: int, part: Cells) -> int:
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


@kernel
def unknown_blocks(states: Grid, border: int) -> Floats:
    """Return the unknown cells of the scored area in each block, row by row."""
    rows, columns = states.shape
    areas = np.zeros((-(-rows // BLOCK), -(-columns // BLOCK)))
    for i in range(border, rows - border):
        for j in range(border, columns - border):
            if states[i, j] == UNKNOWN:
                areas[i // BLOCK, j // BLOCK] += 1.0
    return areas.ravel()


@kernel
def blocks_in_sight(states: Grid, targets: Cells, sight: float, border: int) -> tuple[Cells, Cells]:
    """Return the blocks with unknown cells in sight of targets; unknown cells hide nothing.

    Parameters
    ----------
    states : (rows, columns) array
        The map.
    targets : (m, 2) array
        Cells.
    sight : float
        The range.
    border : int
        Cells at the edge of the map that are not scored.

    Returns
    -------
    first, blocks : (m + 1,) and (n,) arrays
        Those of target ``t`` are ``blocks[first[t]:first[t + 1]]``, as numbers of `unknown_blocks`.

    Notes
    -----
    Rays are looked at in every second cell, so that some pass a wall of which one cell is known.
    What is behind a near wall counts in part, therefore. Robots that looked at every cell did worse
    in five runs, by 2.4 % of the map in the mean.
    """
    rows, columns = states.shape
    high, wide = -(-rows // BLOCK), -(-columns // BLOCK)
    seen_by = np.full(high * wide, -1, np.int64)
    first = np.zeros(len(targets) + 1, np.int64)
    blocks = np.empty(4096, np.int64)
    count = 0
    for t in range(len(targets)):
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
                block = (i // BLOCK) * wide + j // BLOCK
                if states[i, j] == UNKNOWN and seen_by[block] != t:
                    seen_by[block] = t
                    if count == len(blocks):
                        blocks = np.concatenate((blocks, np.empty(count, np.int64)))
                    blocks[count] = block
                    count += 1
                r += 2.0
        first[t + 1] = count
    return first, blocks[:count].copy()


@kernel
def areas_in_sight(areas: Floats, first: Cells, blocks: Cells) -> Floats:
    """Return the sum of the areas of the blocks of each target."""
    found = np.zeros(len(first) - 1)
    for t in range(len(found)):
        for k in range(first[t], first[t + 1]):
            found[t] += areas[blocks[k]]
    return found


@kernel
def path_lengths_between(passable: Flags, targets: Cells) -> Floats:
    """Return the path lengths between targets in cells, ``(m, m)``; ``inf`` where there is no path.

    Paths are found among squares of two by two cells. Passable cells on two sides of a wall are
    three cells or more apart, since those beside a wall are not passable, so squares connect
    nothing that is apart.
    """
    rows, columns = passable.shape
    squares = np.zeros(((rows + 1) // 2, (columns + 1) // 2), np.bool_)
    for i in range(rows):
        for j in range(columns):
            if passable[i, j]:
                squares[i // 2, j // 2] = True
    found = np.full((len(targets), len(targets)), np.inf)
    queue = np.empty(squares.size, np.int64)
    for t in range(len(targets)):
        row, column = np.array([targets[t, 0] // 2]), np.array([targets[t, 1] // 2])
        lengths = field_from(squares, row, column, queue)
        for u in range(len(targets)):
            length = lengths[targets[u, 0] // 2, targets[u, 1] // 2]
            if length >= 0:
                found[t, u] = 2.0 * length
    return found


class Sights(NamedTuple):
    """What targets show: unknown areas of blocks, and the blocks in sight of each target.

    The three arrays of `unknown_blocks` and `blocks_in_sight`.
    """

    areas: Floats
    first: Cells
    blocks: Cells


class Targets(NamedTuple):
    """The targets of a robot.

    Attributes
    ----------
    shares : (m,) array
        Factors on the areas of targets, from 0 to 1.
    start, home : (m,) arrays
        Ways from the robot to each target, and from there home.
    path_lengths : (m, m) array
        Path lengths between targets.
    favour : (m,) array
        Factors on the values of tours by their first target.
    """

    shares: Floats
    start: Floats
    home: Floats
    path_lengths: Floats
    favour: Floats


class Rules(NamedTuple):
    """The constants of `best_tour`; see `Settings` in `gain_home`."""

    horizon: float
    power: float
    nearest: float
    homeward: float
    least_area: float


@kernel
def by_block(blocks: Cells, first: Cells, count: int) -> tuple[Cells, Cells]:
    """Return the targets that have each block in sight, as `blocks_in_sight` does the reverse."""
    begin = np.zeros(count + 1, np.int64)
    for block in blocks:
        begin[block + 1] += 1
    begin = np.cumsum(begin)
    filled, owners = begin[:-1].copy(), np.empty(len(blocks), np.int64)
    for t in range(len(first) - 1):
        for k in range(first[t], first[t + 1]):
            owners[filled[blocks[k]]] = t
            filled[blocks[k]] += 1
    return begin, owners


@kernel
def best_tour(sights: Sights, targets: Targets, left: float, rules: Rules) -> tuple[Cells, Floats]:
    """Return the best of the tours that begin with each target, and when it is where.

    A tour goes on to the target of the highest area over a power of the way, until no time is
    left, or none is worth it. What was in sight before counts no more. Areas count less the later
    they are seen. As a tour nears the end of the time, the way home counts as time as well.

    Parameters
    ----------
    sights : Sights
        What the targets show.
    targets : Targets
        Their ways and factors.
    left : float
        Steps until it has to be home.
    rules : Rules
        The constants.

    Returns
    -------
    tour, times : (k,) arrays
        Numbers of targets, and steps from now; none if no target can be reached.

    Notes
    -----
    Source: rollout algorithms (Bertsekas, Tsitsiklis and Wu, Journal of Heuristics 3, 1997), with
    the greedy rule as base policy.
    """
    areas, first, blocks = sights
    shares, start, home, ways, favour = targets
    count = len(start)
    begin, owners = by_block(blocks, first, len(areas))
    alone = areas_in_sight(areas, first, blocks)
    seen_in = np.full(len(areas), -1, np.int64)
    tour, times = np.empty(count, np.int64), np.empty(count)
    best, best_tour, best_times = -1.0, tour[:0].copy(), times[:0].copy()
    for one in range(count):
        if not np.isfinite(start[one]):
            continue
        gains, been = alone.copy(), np.zeros(count, np.bool_)
        at, time, value, length = one, start[one] / STEP, 0.0, 0
        while time <= 3.0 * rules.horizon or length == 0:
            been[at] = True
            tour[length], times[length] = at, time
            length += 1
            back = home[at] / STEP
            late = time + rules.homeward * min(1.0, (time + back) / left) * back
            value += (gains[at] * shares[at] + 1.0) * math.exp(-late / rules.horizon)
            for k in range(first[at], first[at + 1]):
                block = blocks[k]
                if seen_in[block] != one:
                    seen_in[block] = one
                    for q in range(begin[block], begin[block + 1]):
                        gains[owners[q]] -= areas[block]
            after, most = -1, 0.0
            for t in range(count):
                if been[t] or gains[t] < rules.least_area:
                    continue
                if time + (ways[at, t] + home[t]) / STEP > left:
                    continue
                rate = gains[t] * shares[t] / (ways[at, t] + rules.nearest) ** rules.power
                if rate > most:
                    after, most = t, rate
            if after < 0:
                break
            time += ways[at, after] / STEP
            at = after
        if value * favour[one] > best:
            best = value * favour[one]
            best_tour, best_times = tour[:length].copy(), times[:length].copy()
    return best_tour, best_times


@kernel
def areas_after(
    sights: Sights, tour: Cells, times: Floats, claim: float, strength: float
) -> Floats:
    """Return what the tour of a robot leaves of areas to others: the less, the sooner it comes.

    Parameters
    ----------
    sights : Sights
        What the targets show.
    tour, times : (k,) arrays
        A tour.
    claim : float
        Steps after which a claim is weaker by the factor e.
    strength : float
        Share that a claim takes at once.
    """
    areas, first, blocks = sights
    left = areas.copy()
    for k in range(len(tour)):
        share = 1.0 - strength * math.exp(-times[k] / claim)
        for q in range(first[tour[k]], first[tour[k] + 1]):
            left[blocks[q]] = min(left[blocks[q]], areas[blocks[q]] * share)
    return left
