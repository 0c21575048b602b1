"""Searches over grids of cells: A*, reachable cells, and widening rings.

Grids are indexed ``[row, column]``. Paths do not cut corners: a diagonal step needs both cells
beside it to be passable.

Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D, sections 3.2.3 (goal search) and 3.2.5 (path planning), where both pass through
unknown cells. Differs in: the thesis does not say whether its A* cuts corners.
"""

from __future__ import annotations

import heapq
import math

import numpy as np

from multisrt.geometry.numerics.kernel import BoolArray, IntArray, kernel

DIAGONAL = math.sqrt(2.0)
"""Length of a diagonal step in cells."""


@kernel
def a_star(
    passable: BoolArray, start_row: int, start_column: int, goal_row: int, goal_column: int
) -> IntArray:
    """Return a shortest path over the 8 neighbours of cells.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Cells that the path may pass; the start need not be one.
    start_row, start_column, goal_row, goal_column : int
        Ends of the path.

    Returns
    -------
    (n, 2) array of int
        Rows and columns from start to goal; empty if there is no path. Of equally short paths
        always the same.

    Notes
    -----
    Source: D. Harabor and A. Grastien, Online Graph Pruning for Pathfinding on Grid Maps (2011),
    in the variant without corner cutting: of equally short paths only one is followed, from one
    possible turning point to the next.

    Examples
    --------
    >>> passable = np.array([[True, False, True], [True, False, True], [True, True, True]])
    >>> a_star(passable, 0, 0, 0, 2).tolist()
    [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2]]
    """
    framed = _framed(passable)
    width, free = framed.shape[1], framed.reshape(-1)
    goal_row, goal_column = goal_row + 1, goal_column + 1
    start, goal = (start_row + 1) * width + start_column + 1, goal_row * width + goal_column
    if not free[goal]:
        return np.empty((0, 2), np.int64)
    known, done = np.zeros(free.size, np.bool_), np.zeros(free.size, np.bool_)
    cost, came = np.empty(free.size), np.empty(free.size, np.int64)
    known[start], cost[start], came[start] = True, 0.0, start
    turns = np.empty((8, 2), np.int64)
    heap = [(0.0, start)]
    while len(heap) > 0:
        _, cell = heapq.heappop(heap)
        if done[cell]:
            continue
        done[cell] = True
        if cell == goal:
            return _cells_between(came, start, goal, width)
        row, column = cell // width, cell % width
        # Direction in which the path came; (0, 0) at its start.
        down, right = np.sign(row - came[cell] // width), np.sign(column - came[cell] % width)
        for k in range(_turns(free, width, cell, down, right, turns)):
            dr, dc = turns[k]
            other = _jump(free, width, cell, dr, dc, goal)
            if other < 0 or done[other]:
                continue
            r, c = other // width, other % width
            steps = max(abs(r - row), abs(c - column))
            reached = cost[cell] + steps * (DIAGONAL if dr != 0 and dc != 0 else 1.0)
            if not known[other] or reached < cost[other] - 1e-12:
                known[other], cost[other], came[other] = True, reached, cell
                r, c = abs(goal_row - r), abs(goal_column - c)
                rest = max(r, c) + (DIAGONAL - 1.0) * min(r, c)
                heapq.heappush(heap, (reached + rest, other))
    return np.empty((0, 2), np.int64)


@kernel
def _turns(free: BoolArray, width: int, cell: int, down: int, right: int, turns: IntArray) -> int:
    """Write the directions in which a path has to be continued to `turns`; return their number.

    Directions in which another path is as short that turned before are left out.
    """
    n = 0
    for dr in range(-1, 2):
        for dc in range(-1, 2):
            if dr == 0 and dc == 0:
                continue
            if down != 0 and right != 0:
                # A diagonal continues straight or along one of its two components.
                may = dr * down >= 0 and dc * right >= 0
            elif down != 0 or right != 0:
                # A straight path continues straight, or to a side behind an obstacle there.
                along, across = dr * down + dc * right, dr * right - dc * down
                aside = dr * width if down == 0 else dc
                before = cell - down * width - right
                may = along >= 0 and (across == 0 or not free[before + aside])
            else:
                may = True
            if may:
                turns[n, 0], turns[n, 1] = dr, dc
                n += 1
    return n


@kernel
def _jump(free: BoolArray, width: int, cell: int, dr: int, dc: int, goal: int) -> int:
    """Return the next possible turning point in a direction, or the goal; -1 without one."""
    if dr == 0:
        return _jump_straight(free, cell, dc, width, goal)
    down = dr * width
    if dc == 0:
        return _jump_straight(free, cell, down, 1, goal)
    while free[cell + down] and free[cell + dc] and free[cell + down + dc]:
        cell += down + dc
        if (
            cell == goal
            or _jump_straight(free, cell, down, 1, goal) >= 0
            or _jump_straight(free, cell, dc, width, goal) >= 0
        ):
            return cell
    return -1


@kernel
def _jump_straight(free: BoolArray, cell: int, step: int, aside: int, goal: int) -> int:
    """Return the first cell beside which an obstacle ends, or the goal; -1 without one."""
    beside, other_side = free[cell + aside], free[cell - aside]
    while free[cell + step]:
        cell += step
        if cell == goal:
            return cell
        before, other_before = beside, other_side
        beside, other_side = free[cell + aside], free[cell - aside]
        if (beside and not before) or (other_side and not other_before):
            return cell
    return -1


@kernel
def _cells_between(came: IntArray, start: int, goal: int, width: int) -> IntArray:
    """Return all cells of a path from its turning points."""
    n, cell = 1, goal
    while cell != start:
        before = came[cell]
        n += max(abs(cell // width - before // width), abs(cell % width - before % width))
        cell = before
    path = np.empty((n, 2), np.int64)
    row, column, turn = goal // width, goal % width, goal
    for k in range(n - 1, -1, -1):
        path[k, 0], path[k, 1] = row - 1, column - 1
        if row == turn // width and column == turn % width:
            turn = came[turn]
        row += np.sign(turn // width - row)
        column += np.sign(turn % width - column)
    return path


@kernel
def reachable(passable: BoolArray, row: int, column: int) -> BoolArray:
    """Return the cells that paths from a cell can reach.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Cells that paths may pass.
    row, column : int
        The cell where they begin.

    Returns
    -------
    (rows, columns) array of bool
        All False if the first cell is not passable.

    Notes
    -----
    A scanline fill over 4 neighbours; without corner cutting, 8 neighbours reach no more.

    Examples
    --------
    >>> reachable(np.array([[True, False, True], [True, False, False]]), 0, 0).tolist()
    [[True, False, False], [True, False, False]]
    """
    framed = _framed(passable)
    width, free = framed.shape[1], framed.reshape(-1)
    seen = np.zeros(free.size, np.bool_)
    # Row by row; of each run of cells in the row above or below, the first is queued.
    waiting = [(row + 1) * width + column + 1]
    while len(waiting) > 0:
        cell = waiting.pop()
        if seen[cell] or not free[cell]:
            continue
        while free[cell - 1]:
            cell -= 1
        above = below = False
        while free[cell]:
            seen[cell] = True
            was_above, above = above, free[cell - width] and not seen[cell - width]
            was_below, below = below, free[cell + width] and not seen[cell + width]
            if above and not was_above:
                waiting.append(cell - width)
            if below and not was_below:
                waiting.append(cell + width)
            cell += 1
    return seen.reshape(framed.shape)[1:-1, 1:-1]


@kernel
def _framed(passable: BoolArray) -> BoolArray:
    """Return a grid with a border of impassable cells, which replaces checks of bounds."""
    rows, columns = passable.shape
    framed = np.zeros((rows + 2, columns + 2), np.bool_)
    for r in range(rows):
        for c in range(columns):
            framed[r + 1, c + 1] = passable[r, c]
    return framed


@kernel
def ring_search(
    passable: BoolArray, wanted: BoolArray, row: int, column: int, enough: int
) -> IntArray:
    """Return the wanted cells found by a widening ring, once there are enough of them.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Cells through which the ring spreads, to 8 neighbours at a time.
    wanted : (rows, columns) array of bool
        Cells to look for.
    row, column : int
        The cell where the ring begins.
    enough : int
        The search ends with the ring that brings the count to this number.

    Returns
    -------
    (k, 2) array of int
        Rows and columns, ring by ring; may exceed `enough`, or fall short if cells run out.

    Examples
    --------
    >>> passable = np.ones((1, 5), np.bool_)
    >>> wanted = np.array([[False, False, False, True, True]])
    >>> ring_search(passable, wanted, 0, 0, 1).tolist()
    [[0, 3]]
    """
    rows, columns = passable.shape
    seen = np.zeros((rows, columns), np.bool_)
    queue = np.empty((rows * columns, 2), np.int64)
    found = np.empty((rows * columns, 2), np.int64)
    queue[0, 0], queue[0, 1] = row, column
    seen[row, column] = True
    begin, end, n = 0, 1, 0
    while begin < end and n < enough:
        ring_end = end
        while begin < ring_end:
            r0, c0 = queue[begin, 0], queue[begin, 1]
            begin += 1
            if wanted[r0, c0]:
                found[n, 0], found[n, 1] = r0, c0
                n += 1
            for r in range(max(0, r0 - 1), min(rows, r0 + 2)):
                for c in range(max(0, c0 - 1), min(columns, c0 + 2)):
                    if not seen[r, c] and passable[r, c]:
                        seen[r, c] = True
                        queue[end, 0], queue[end, 1] = r, c
                        end += 1
    return found[:n].copy()
