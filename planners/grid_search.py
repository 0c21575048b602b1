"""Searches over grids of cells: A*, and rings that widen until enough is found.

Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D, sections 3.2.3 (goal search) and 3.2.5 (path planning). Both pass through cells
that nobody has seen. A* there may cut corners or not, the thesis does not say; ours does not.
"""

from __future__ import annotations

import heapq
import math

import numpy as np

from multisrt.geometry.kernel import BoolArray, IntArray, kernel

DIAGONAL = math.sqrt(2.0)


@kernel
def a_star(
    passable: BoolArray, start_row: int, start_column: int, goal_row: int, goal_column: int
) -> IntArray:
    """Find a shortest way over the 8 neighbours of cells, not cutting corners.

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
    rows, columns = passable.shape
    nothing = np.empty((0, 2), np.int64)
    if not passable[goal_row, goal_column]:
        return nothing
    cost = np.full(rows * columns, np.inf)
    came = np.full(rows * columns, -1, np.int64)
    done = np.zeros(rows * columns, np.bool_)
    start, goal = start_row * columns + start_column, goal_row * columns + goal_column
    cost[start] = 0.0
    heap = [(0.0, start)]
    while len(heap) > 0:
        _, cell = heapq.heappop(heap)
        if done[cell]:
            continue
        done[cell] = True
        if cell == goal:
            break
        row, column = cell // columns, cell % columns
        for r in range(max(0, row - 1), min(rows, row + 2)):
            for c in range(max(0, column - 1), min(columns, column + 2)):
                other = r * columns + c
                if done[other] or not passable[r, c]:
                    continue
                is_diagonal = r != row and c != column
                if is_diagonal and not (passable[r, column] and passable[row, c]):
                    continue
                reached = cost[cell] + (DIAGONAL if is_diagonal else 1.0)
                if reached < cost[other] - 1e-12:
                    cost[other] = reached
                    came[other] = cell
                    dr, dc = abs(goal_row - r), abs(goal_column - c)
                    rest = max(dr, dc) + (DIAGONAL - 1.0) * min(dr, dc)
                    heapq.heappush(heap, (reached + rest, other))
    if not done[goal]:
        return nothing
    n, cell = 1, goal
    while cell != start:
        cell = came[cell]
        n += 1
    way = np.empty((n, 2), np.int64)
    cell = goal
    for k in range(n - 1, -1, -1):
        way[k, 0], way[k, 1] = cell // columns, cell % columns
        cell = came[cell]
    return way


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
