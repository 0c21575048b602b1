"""Compiled grid functions of `gain_home`: frontiers, distance fields, visibility and tours.

This file needs only numpy and numba, and nothing else from the package: ``multisrt compete
--policy-out`` writes it at the start of the policy's file. Grids are indexed ``[row, column]``.
Lengths are in cells, areas in square cells and times in steps of the competition's simulator.
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
DistanceField = NDArray[np.int32]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

FREE, UNKNOWN, OCCUPIED = 0, 1, 2
"""Cell states."""

STEP = 3
"""Maximum number of cells that a robot drives in a step."""

MARGIN = 2
"""Width in cells of the unscored margin kept around the scored area."""

RAYS = 90
"""Number of rays by which visible unknown area is measured: one every 4 degrees."""

BLOCK = 4
"""Side in cells of the square blocks for which visible unknown area is counted."""


F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile a function on its first call, and cache the result on disk."""
    return cast(F, numba.njit(cache=True)(function))


@kernel
def cropped(known: Floats, offset: int) -> Grid:
    """Return the cell states of a map without `offset` rows and columns on each side."""
    rows, columns = known.shape[0] - 2 * offset, known.shape[1] - 2 * offset
    states = np.empty((rows, columns), np.int8)
    for i in range(rows):
        for j in range(columns):
            value = known[i + offset, j + offset]
            states[i, j] = FREE if value == 0.0 else (OCCUPIED if value == 1.0 else UNKNOWN)
    return states


@kernel
def is_clear(known: Floats, row: int, column: int) -> bool:
    """Return whether no cell of a cell's 3 by 3 neighbourhood is known to be occupied."""
    for a in range(row - 1, row + 2):
        for b in range(column - 1, column + 2):
            if known[a, b] == 1.0:
                return False
    return True


@kernel
def passable_cells(states: Grid) -> Flags:
    """Return a mask of the cells whose 3 by 3 neighbourhood is known to be free."""
    rows, columns = states.shape
    passable = np.zeros((rows, columns), np.bool_)
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            if states[i, j] == FREE:
                all_free = True
                for a in range(i - 1, i + 2):
                    for b in range(j - 1, j + 2):
                        if states[a, b] != FREE:
                            all_free = False
                passable[i, j] = all_free
    return passable


@kernel
def distance_field(passable: Flags, rows: Cells, columns: Cells, queue: Cells) -> DistanceField:
    """Return the distance field of some source cells.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        The passable cells. Sources need not be passable.
    rows, columns : (k,) arrays
        The source cells.
    queue : (rows * columns,) array
        Scratch memory with one entry per cell.

    Returns
    -------
    (rows, columns) array
        For each cell, the number of steps from the nearest source through passable cells
        (4-connected); -1 where unreachable.
    """
    height, width = passable.shape
    distances = np.full((height, width), -1, np.int32)
    end = 0
    for k in range(len(rows)):
        if distances[rows[k], columns[k]] < 0:
            distances[rows[k], columns[k]] = 0
            queue[end] = rows[k] * width + columns[k]
            end += 1
    begin = 0
    while begin < end:
        cell = queue[begin]
        begin += 1
        i, j = cell // width, cell % width
        further = distances[i, j] + 1
        if i > 0 and passable[i - 1, j] and distances[i - 1, j] < 0:
            distances[i - 1, j] = further
            queue[end] = cell - width
            end += 1
        if i < height - 1 and passable[i + 1, j] and distances[i + 1, j] < 0:
            distances[i + 1, j] = further
            queue[end] = cell + width
            end += 1
        if j > 0 and passable[i, j - 1] and distances[i, j - 1] < 0:
            distances[i, j - 1] = further
            queue[end] = cell - 1
            end += 1
        if j < width - 1 and passable[i, j + 1] and distances[i, j + 1] < 0:
            distances[i, j + 1] = further
            queue[end] = cell + 1
            end += 1
    return distances


@kernel
def descend(distances: DistanceField, row: int, column: int, steps: int) -> tuple[int, int]:
    """Return the cell that a number of steps leads to, each one closer to the nearest source.

    The descent ends at the source, or where no neighbour is closer.
    """
    height, width = distances.shape
    for _ in range(steps):
        closer = distances[row, column] - 1
        if closer < 0:
            break
        if row > 0 and distances[row - 1, column] == closer:
            row -= 1
        elif row < height - 1 and distances[row + 1, column] == closer:
            row += 1
        elif column > 0 and distances[row, column - 1] == closer:
            column -= 1
        elif column < width - 1 and distances[row, column + 1] == closer:
            column += 1
        else:
            break
    return row, column


@kernel
def frontier_cells(states: Grid, margin: int) -> Flags:
    """Return a mask of the free cells of the scored area with an unknown neighbour in it.

    Neighbours are the eight adjacent cells.
    """
    rows, columns = states.shape
    frontier = np.zeros((rows, columns), np.bool_)
    for i in range(margin, rows - margin):
        for j in range(margin, columns - margin):
            if states[i, j] == FREE:
                for a in range(max(margin, i - 1), min(rows - margin, i + 2)):
                    for b in range(max(margin, j - 1), min(columns - margin, j + 2)):
                        if states[a, b] == UNKNOWN:
                            frontier[i, j] = True
    return frontier


@kernel
def take_component(mask: Flags, first: int, component: Cells) -> int:
    """Move the 8-connected component of a cell from a mask to an array; return its size.

    Parameters
    ----------
    mask : (rows, columns) array of bool
        The mask, from which the component is removed.
    first : int
        Flat index of the cell.
    component : array
        Where the flat indices of the component's cells are written.
    """
    rows, columns = mask.shape
    mask[first // columns, first % columns] = False
    component[0] = first
    begin, end = 0, 1
    while begin < end:
        i, j = component[begin] // columns, component[begin] % columns
        begin += 1
        for a in range(max(0, i - 1), min(rows, i + 2)):
            for b in range(max(0, j - 1), min(columns, j + 2)):
                if mask[a, b]:
                    mask[a, b] = False
                    component[end] = a * columns + b
                    end += 1
    return end


@kernel
def nearest_to_mean(distances: DistanceField, cells: Cells) -> int:
    """Return the reachable cell nearest to the mean of some cells, by flat indices.

    Only cells at most three rows and columns from one of them are considered; -1 if none of these
    is reachable.
    """
    rows, columns = distances.shape
    mean_i, mean_j = np.mean(cells // columns), np.mean(cells % columns)
    least, nearest = np.inf, -1
    for cell in cells:
        i, j = cell // columns, cell % columns
        for a in range(max(0, i - 3), min(rows, i + 4)):
            for b in range(max(0, j - 3), min(columns, j + 4)):
                squared = (a - mean_i) ** 2 + (b - mean_j) ** 2
                if distances[a, b] >= 0 and squared < least:
                    least, nearest = squared, a * columns + b
    return nearest


@kernel
def frontier_segments(
    states: Grid,
    distances: DistanceField,
    half_width: int,
    min_cells: int,
    margin: int,
    queue: Cells,
) -> Cells:
    """Return a target for each segment of the frontiers between free and unknown cells.

    A frontier is an 8-connected component of `frontier_cells`. It is cut into segments, each of
    which is represented by the reachable cell nearest to the mean of its cells.

    Parameters
    ----------
    states : (rows, columns) array
        The map.
    distances : (rows, columns) array
        Distance field of the robot; cells below 0 are unreachable.
    half_width : int
        Maximum number of rows and columns from the first cell of a segment to its other cells.
    min_cells : int
        Minimum number of cells of a frontier; smaller ones are ignored.
    margin : int
        Width of the unscored margin.
    queue : (rows * columns,) array
        Scratch memory.

    Returns
    -------
    (m, 2) array
        Rows and columns of the targets. Segments without a reachable cell nearby have none.
    """
    columns = states.shape[1]
    frontier = frontier_cells(states, margin)
    found = [0]  # a placeholder, from which numba infers the type
    for first in np.flatnonzero(frontier):
        if not frontier[first // columns, first % columns]:
            continue
        count = take_component(frontier, int(first), queue)
        rest = queue[:count].copy()
        while count >= min_cells and len(rest):
            i, j = rest[0] // columns, rest[0] % columns
            near = np.abs(rest // columns - i) <= half_width
            near &= np.abs(rest % columns - j) <= half_width
            target = nearest_to_mean(distances, rest[near])
            if target >= 0:
                found.append(target)
            rest = rest[~near]
    targets = np.empty((len(found) - 1, 2), np.int64)
    for k in range(len(targets)):
        targets[k, 0] = found[k + 1] // columns
        targets[k, 1] = found[k + 1] % columns
    return targets


@kernel
def with_filled_walls(states: Grid, max_cells: int) -> Grid:
    """Return a copy of a map in which short runs of unknown cells between walls are occupied.

    A run lies between two occupied cells of a row or column and has at most `max_cells` cells. Such
    runs are usually the inside of a wall, or a part of a wall behind a pillar.
    """
    rows, columns = states.shape
    filled = states.copy()
    for i in range(rows):
        last = -1
        for j in range(columns):
            if states[i, j] == OCCUPIED:
                if last >= 0 and j - last - 1 <= max_cells:
                    filled[i, last + 1 : j] = OCCUPIED
                last = j
            elif states[i, j] == FREE:
                last = -1
    for j in range(columns):
        last = -1
        for i in range(rows):
            if states[i, j] == OCCUPIED:
                if last >= 0 and i - last - 1 <= max_cells:
                    filled[last + 1 : i, j] = OCCUPIED
                last = i
            elif states[i, j] == FREE:
                last = -1
    return filled


@kernel
def contact_zone(
    states: Grid, distances: DistanceField, base: tuple[int, int], link: tuple[int, float, float]
) -> tuple[Cells, Cells]:
    """Return the rows and columns of the reachable cells with a certain link to the base.

    Parameters
    ----------
    states : (rows, columns) array
        The map. All cells that are not known to be free count as wall.
    distances : (rows, columns) array
        Distance field of the robot; cells below 0 are unreachable.
    base : (row, column)
        The cell of the base, which is always the first of the zone.
    link : (int, float, float)
        Maximum length in cells, number of wall cells tolerated at 1 m, and decrease of that number
        per decade of distance.
    """
    base_row, base_column = base
    max_length, budget, slope = link
    rows, columns = states.shape
    zone_rows, zone_columns = [base_row], [base_column]
    for i in range(max(0, base_row - max_length), min(rows, base_row + max_length + 1)):
        for j in range(
            max(0, base_column - max_length), min(columns, base_column + max_length + 1)
        ):
            if distances[i, j] < 0:
                continue
            length = math.sqrt((i - base_row) ** 2 + (j - base_column) ** 2)
            if length > max_length or length < 1.0:
                continue
            tolerated = math.floor(budget - slope * math.log10(length / 10.0))
            count = max(abs(i - base_row), abs(j - base_column))
            walls = 0
            for k in range(count + 1):
                a = math.floor(base_row + (i - base_row) * k / count + 0.5)
                b = math.floor(base_column + (j - base_column) * k / count + 0.5)
                if states[a, b] != FREE:
                    walls += 1
                    if walls > tolerated:
                        break
            if walls <= tolerated:
                zone_rows.append(i)
                zone_columns.append(j)
    return np.array(zone_rows), np.array(zone_columns)


@kernel
def unknown_area_of_blocks(states: Grid, margin: int) -> Floats:
    """Return the unknown area of the scored part of each block, row by row, ``(n,)``."""
    rows, columns = states.shape
    areas = np.zeros((-(-rows // BLOCK), -(-columns // BLOCK)))
    for i in range(margin, rows - margin):
        for j in range(margin, columns - margin):
            if states[i, j] == UNKNOWN:
                areas[i // BLOCK, j // BLOCK] += 1.0
    return areas.ravel()


@kernel
def visible_blocks(states: Grid, targets: Cells, sight: float, margin: int) -> tuple[Cells, Cells]:
    """Return the blocks with unknown cells that are visible from targets.

    Unknown cells do not occlude.

    Parameters
    ----------
    states : (rows, columns) array
        The map.
    targets : (m, 2) array
        Rows and columns.
    sight : float
        Range within which cells are visible.
    margin : int
        Width of the unscored margin.

    Returns
    -------
    first, blocks : (m + 1,) and (n,) arrays
        The blocks of target ``t`` are ``blocks[first[t]:first[t + 1]]``, as indices into the result
        of `unknown_area_of_blocks`.

    Notes
    -----
    Rays are sampled at every second cell, so that some pass through a wall of which one cell is
    known. The area behind a nearby wall therefore counts in part. Sampling every cell delivered
    less in five runs, by 2.4 % of the map on average.
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
                if not (margin <= i < rows - margin and margin <= j < columns - margin):
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
def visible_areas(areas: Floats, first: Cells, blocks: Cells) -> Floats:
    """Return the total area of the blocks visible from each target, ``(m,)``."""
    sums = np.zeros(len(first) - 1)
    for t in range(len(sums)):
        for k in range(first[t], first[t + 1]):
            sums[t] += areas[blocks[k]]
    return sums


@kernel
def path_lengths_between(passable: Flags, targets: Cells) -> Floats:
    """Return approximate path lengths between targets, ``(m, m)``; ``inf`` where there is no path.

    They are computed on squares of 2 by 2 cells. A square is passable if one of its cells is. This
    connects nothing across a wall: cells next to a wall are not passable, so passable cells on its
    two sides have at least three cells between them.
    """
    rows, columns = passable.shape
    squares = np.zeros(((rows + 1) // 2, (columns + 1) // 2), np.bool_)
    for i in range(rows):
        for j in range(columns):
            if passable[i, j]:
                squares[i // 2, j // 2] = True
    lengths = np.full((len(targets), len(targets)), np.inf)
    queue = np.empty(squares.size, np.int64)
    for t in range(len(targets)):
        row, column = np.array([targets[t, 0] // 2]), np.array([targets[t, 1] // 2])
        distances = distance_field(squares, row, column, queue)
        for u in range(len(targets)):
            distance = distances[targets[u, 0] // 2, targets[u, 1] // 2]
            if distance >= 0:
                lengths[t, u] = 2.0 * distance
    return lengths


class Visibility(NamedTuple):
    """The blocks that are visible from targets, and their unknown areas.

    Attributes
    ----------
    areas : (n,) array
        Unknown area of each block, as `unknown_area_of_blocks` returns it.
    first, blocks : (m + 1,) and (k,) arrays
        The blocks that are visible from each target, as `visible_blocks` returns them.
    """

    areas: Floats
    first: Cells
    blocks: Cells


class Targets(NamedTuple):
    """The targets of a robot.

    Attributes
    ----------
    shares : (m,) array
        Factors on the visible areas of targets, from 0 to 1.
    lengths_there, lengths_home : (m,) arrays
        Path lengths from the robot to each target, and from each target home.
    path_lengths : (m, m) array
        Path lengths between targets.
    first_factors : (m,) array
        Factors on the values of tours, by their first target.
    """

    shares: Floats
    lengths_there: Floats
    lengths_home: Floats
    path_lengths: Floats
    first_factors: Floats


class TourParameters(NamedTuple):
    """The parameters of `best_tour`.

    Attributes
    ----------
    horizon : float
        Time over which the value of area decreases by the factor e.
    power, length_offset, homeward_weight, min_area : float
        As in `Settings` of `gain_home`.
    """

    horizon: float
    power: float
    length_offset: float
    homeward_weight: float
    min_area: float


@kernel
def targets_by_block(blocks: Cells, first: Cells, count: int) -> tuple[Cells, Cells]:
    """Return the targets from which each block is visible: the inverse of `visible_blocks`.

    Parameters
    ----------
    blocks, first : arrays
        As `visible_blocks` returns them.
    count : int
        Number of all blocks.

    Returns
    -------
    begin, targets : (count + 1,) and (n,) arrays
        The targets of block ``b`` are ``targets[begin[b]:begin[b + 1]]``.
    """
    begin = np.zeros(count + 1, np.int64)
    for block in blocks:
        begin[block + 1] += 1
    begin = np.cumsum(begin)
    filled, targets = begin[:-1].copy(), np.empty(len(blocks), np.int64)
    for t in range(len(first) - 1):
        for k in range(first[t], first[t + 1]):
            targets[filled[blocks[k]]] = t
            filled[blocks[k]] += 1
    return begin, targets


@kernel
def best_tour(
    visibility: Visibility, targets: Targets, left: float, parameters: TourParameters
) -> tuple[Cells, Floats]:
    """Return the most valuable of the tours that begin at each target, and its arrival times.

    A tour is extended greedily to the target with the most unknown area divided by a power of the
    path length, until no target is left that shows enough and from which the robot could be home
    in time, or until three horizons have passed. Area that is visible from an earlier target of the
    tour does not count again. The value of area decreases with the time at which it is seen. As a
    tour uses up the steps, the travel time home is added to that time.

    Parameters
    ----------
    visibility : Visibility
        What is visible from the targets.
    targets : Targets
        Path lengths and factors.
    left : float
        Steps left until the robot has to be home.
    parameters : TourParameters
        The parameters.

    Returns
    -------
    tour, times : (k,) arrays
        Indices of targets, and arrival times in steps from now; empty if no target can be reached.

    Notes
    -----
    Source: rollout algorithms (Bertsekas, Tsitsiklis and Wu, Journal of Heuristics 3, 1997), with
    the greedy rule as base policy.
    """
    areas, first, blocks = visibility
    shares, lengths_there, lengths_home, path_lengths, first_factors = targets
    count = len(lengths_there)
    begin, seen_from = targets_by_block(blocks, first, len(areas))
    all_gains = visible_areas(areas, first, blocks)
    seen_in = np.full(len(areas), -1, np.int64)
    tour, times = np.empty(count, np.int64), np.empty(count)
    best_value, best, best_times = -1.0, tour[:0].copy(), times[:0].copy()
    for start in range(count):
        if not np.isfinite(lengths_there[start]):
            continue
        gains, visited = all_gains.copy(), np.zeros(count, np.bool_)
        at, time, value, length = start, lengths_there[start] / STEP, 0.0, 0
        while time <= 3.0 * parameters.horizon or length == 0:
            visited[at] = True
            tour[length], times[length] = at, time
            length += 1
            back = lengths_home[at] / STEP
            late = time + parameters.homeward_weight * min(1.0, (time + back) / left) * back
            value += (gains[at] * shares[at] + 1.0) * math.exp(-late / parameters.horizon)
            for k in range(first[at], first[at + 1]):
                block = blocks[k]
                if seen_in[block] != start:
                    seen_in[block] = start
                    for q in range(begin[block], begin[block + 1]):
                        gains[seen_from[q]] -= areas[block]
            following, highest = -1, 0.0
            for t in range(count):
                if visited[t] or gains[t] < parameters.min_area:
                    continue
                if time + (path_lengths[at, t] + lengths_home[t]) / STEP > left:
                    continue
                cost = (path_lengths[at, t] + parameters.length_offset) ** parameters.power
                rate = gains[t] * shares[t] / cost
                if rate > highest:
                    following, highest = t, rate
            if following < 0:
                break
            time += path_lengths[at, following] / STEP
            at = following
        if value * first_factors[start] > best_value:
            best_value = value * first_factors[start]
            best, best_times = tour[:length].copy(), times[:length].copy()
    return best, best_times


@kernel
def unclaimed_areas(
    visibility: Visibility, tour: Cells, times: Floats, claim_decay: float, claim_share: float
) -> Floats:
    """Return the areas of blocks that a robot's tour leaves to others, ``(n,)``.

    Parameters
    ----------
    visibility : Visibility
        What is visible from the targets.
    tour, times : (k,) arrays
        The tour, as `best_tour` returns it.
    claim_decay : float
        Arrival time over which the claimed share decreases by the factor e.
    claim_share : float
        Share claimed at an arrival time of 0.
    """
    areas, first, blocks = visibility
    left = areas.copy()
    for k in range(len(tour)):
        share = 1.0 - claim_share * math.exp(-times[k] / claim_decay)
        for q in range(first[tour[k]], first[tour[k] + 1]):
            left[blocks[q]] = min(left[blocks[q]], areas[blocks[q]] * share)
    return left
