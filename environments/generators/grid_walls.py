"""Random openings between the cells of a grid, for rooms and mazes."""

import numpy as np

Cell = tuple[int, int]
"""Column and row of a cell."""


def open_walls(
    columns: int, rows: int, loops: float, rng: np.random.Generator
) -> list[tuple[Cell, Cell]]:
    """Return openings between neighbouring cells that connect all cells.

    A depth-first walk from a random cell opens a spanning tree with long branches; each of the
    remaining walls is opened with a given probability.

    Parameters
    ----------
    columns, rows : int
        Number of columns and rows of the grid.
    loops : float
        Probability that a wall outside the tree is opened, from 0 (a tree) to 1 (no walls).
    rng : numpy.random.Generator
        Random generator.

    Returns
    -------
    list of (cell, cell)
        Pairs of neighbours, the left or lower one first.
    """
    start = (int(rng.integers(columns)), int(rng.integers(rows)))
    visited, path, opened = {start}, [start], []
    while path:
        here = path[-1]
        fresh = [cell for cell in _neighbours(here, columns, rows) if cell not in visited]
        if not fresh:
            path.pop()
            continue
        following = fresh[int(rng.integers(len(fresh)))]
        opened.append((min(here, following), max(here, following)))
        visited.add(following)
        path.append(following)
    tree = set(opened)
    others = [
        ((column, row), neighbour)
        for column in range(columns)
        for row in range(rows)
        for neighbour in ((column + 1, row), (column, row + 1))
        if neighbour[0] < columns and neighbour[1] < rows and ((column, row), neighbour) not in tree
    ]
    chances = rng.random(len(others))
    extra = [wall for wall, chance in zip(others, chances, strict=True) if chance < loops]
    return opened + extra


def _neighbours(cell: Cell, columns: int, rows: int) -> list[Cell]:
    column, row = cell
    around = ((column + 1, row), (column, row + 1), (column - 1, row), (column, row - 1))
    return [(x, y) for x, y in around if 0 <= x < columns and 0 <= y < rows]
