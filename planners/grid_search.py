"""Searches over grids of cells: A*, what it can reach, and rings that widen until enough is found.

Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D, sections 3.2.3 (goal search) and 3.2.5 (path planning). Both pass through cells
that nobody has seen. A* there may cut corners or not, the thesis does not say; ours does not.
"""

from __future__ import annotations

import heapq
import math

import numpy as np

from multisrt.geometry.numerics.kernel import BoolArray, IntArray, kernel

DIAGONAL = math.sqrt(2.0)


@kernel
def a_star(
    passable: BoolArray, start_row: int, start_column: int, goal_row: int, goal_column: int
) -> IntArray:
    """Find a shortest way over the 8 neighbours of cells, not cutting corners.

    Of the many equally short ways through the open it follows one, from one cell at which a way
    may have to turn to the next: D. Harabor and A. Grastien, Online Graph Pruning for Pathfinding
    on Grid Maps (2011), in the form for ways that do not cut corners.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Where the way may lead; where it begins need not be passable.
    start_row, start_column, goal_row, goal_column : int
        Its ends.

    Returns
    -------
    (n, 2) array
        Rows and columns from start to goal; of no rows where there is no way. Of equally short
        ways it is always the same one.
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
        # In which direction the way came; at its start in none: 0, 0.
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
    # Write down in which directions a shortest way may go on that came to a cell in one of them,
    # where no other way is as short that has turned before; give how many these are.
    n = 0
    for dr in range(-1, 2):
        for dc in range(-1, 2):
            if dr == 0 and dc == 0:
                continue
            if down != 0 and right != 0:
                # Straight on, or along one of the two sides.
                may = dr * down >= 0 and dc * right >= 0
            elif down != 0 or right != 0:
                # Straight on; or to a side, past the end of an obstacle there.
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
    # Go on in one direction to the next cell at which a shortest way may have to turn, or to the
    # goal; -1 where there is none.
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
    # Where an obstacle beside the way ends it may have to turn.
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
    # All cells of a way of which those are known at which it turns.
    n, cell = 1, goal
    while cell != start:
        before = came[cell]
        n += max(abs(cell // width - before // width), abs(cell % width - before % width))
        cell = before
    way = np.empty((n, 2), np.int64)
    row, column, turn = goal // width, goal % width, goal
    for k in range(n - 1, -1, -1):
        way[k, 0], way[k, 1] = row - 1, column - 1
        if row == turn // width and column == turn % width:
            turn = came[turn]
        row += np.sign(turn // width - row)
        column += np.sign(turn % width - column)
    return way


@kernel
def reachable(passable: BoolArray, row: int, column: int) -> BoolArray:
    """Tell to which cells ways lead from one that is passable.

    Over 4 neighbours: a way that does not cut corners comes no farther over 8.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Where ways may lead.
    row, column : int
        Where they begin.

    Returns
    -------
    (rows, columns) array of bool
        Where they come to.
    """
    framed = _framed(passable)
    width, free = framed.shape[1], framed.reshape(-1)
    seen = np.zeros(free.size, np.bool_)
    # Run by run; of a run beside one that was seen the first cell waits.
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
    # With a border all around that is not passable, so that none need be asked for.
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
    """Widen a ring around a cell, not through what is not passable, until enough is found.

    Parameters
    ----------
    passable : (rows, columns) array of bool
        Through which cells the ring spreads, to 8 neighbours at a time.
    wanted : (rows, columns) array of bool
        The cells that are looked for.
    row, column : int
        Where the ring begins.
    enough : int
        The ring that brings the found cells to this number is the last.

    Returns
    -------
    (k, 2) array
        Rows and columns of what was found, ring by ring.
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
