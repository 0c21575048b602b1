"""Shortest paths on a grid, traced in a distance field."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.sight import in_sight
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.distances import length_of
from multisrt.geometry.numerics.kernel import kernel


def shortest_path(field: DistanceField, cell: ArrayLike) -> FloatArray:
    """Trace the path from the nearest source to a cell in a distance field.

    Parameters
    ----------
    field : DistanceField
        Distances from the sources. It marches on to the cell if it has not reached it yet.
    cell : (2,) array_like of int
        Row and column.

    Returns
    -------
    (n, 2) array
        Points x, y in metres from the source to the cell's centre. The lines between them run
        through passable cells, and between two cells that meet in a corner only where both
        cells beside it are passable.

    Raises
    ------
    InvalidInputError
        If the cell is not in the grid, or no path leads there.

    Notes
    -----
    The path descends the field from the cell, each step to the steepest of eight neighbours,
    and is then pulled straight: from each point to the farthest later one that it sees, once
    from the source onwards and once from the cell backwards, of which the shorter line is taken.
    Its turning points are centres of cells, half a cell's diagonal from the corners that it goes
    around. Compared with the shortest paths around the blocked cells, which a visibility graph
    has, it is too long by 0.8 % on average and 4.7 % at most in rooms of 40 cells with doors and
    desks; by 2.3 % and 9.0 % in rooms of 15 cells, where the shortest line over centres is 1.9 %
    and 8.7 % too long; and by 8.7 % on average in grids with 5 to 40 % of the cells blocked at
    random, where each step is a turn.

    Examples
    --------
    >>> import numpy as np
    >>> passable = np.ones((3, 5), bool)
    >>> passable[:2, 2] = False
    >>> field = DistanceField(passable, 1.0, [(0.5, 0.5)])
    >>> shortest_path(field, (0, 4)).tolist()
    [[0.5, 0.5], [1.5, 2.5], [3.5, 2.5], [4.5, 0.5]]
    """
    return straightened(field, field.descent(cell))


def straightened(field: DistanceField, descent: IntArray) -> FloatArray:
    """Return a descent of a field as a straightened path; see `shortest_path`.

    Parameters
    ----------
    field : DistanceField
        The field.
    descent : (n, 2) array of int
        What `DistanceField.descent` has returned for a cell.

    Returns
    -------
    (m, 2) array
        Points x, y in metres from the source to the cell's centre.
    """
    line = _line_of(descent, field.passable, field.starts)
    turns = line[_pull(field.passable, line, True)]
    if len(turns) > 2:
        other = line[_pull(field.passable, line, False)]
        turns = other if length_of(other) < length_of(turns) else turns
    path: FloatArray = turns * field.cell_m + (field.x0, field.y0)
    return path


@kernel
def _line_of(descent: IntArray, passable: BoolArray, starts: FloatArray) -> FloatArray:
    # From the source where a descent ends through the centres of its cells.
    count = len(descent)
    line = np.empty((count + 1, 2))
    for i in range(count):
        line[count - i, 0], line[count - i, 1] = descent[i, 1] + 0.5, descent[i, 0] + 0.5
    line[0] = starts[_source_of(passable, line[1], starts)]
    return line


@kernel
def _source_of(passable: BoolArray, centre: FloatArray, starts: FloatArray) -> int:
    # The nearest source that sees the cell where the descent ends.
    nearest, source = np.inf, 0
    for k in range(len(starts)):
        x, y = starts[k]
        away = math.hypot(centre[0] - x, centre[1] - y)
        if away < nearest and in_sight(passable, x, y, int(centre[0]), int(centre[1])):
            nearest, source = away, k
    return source


@kernel
def _pull(passable: BoolArray, line: FloatArray, onward: bool) -> IntArray:
    # From each turning point to the farthest point of the line that it sees, from the source
    # onwards or from the cell backwards. All points but the source are centres of cells.
    end, step = (len(line) - 1, 1) if onward else (0, -1)
    here = len(line) - 1 - end
    turns = [here]
    while here != end:
        seen = end
        while not in_sight(
            passable,
            line[min(here, seen), 0],
            line[min(here, seen), 1],
            int(line[max(here, seen), 0]),
            int(line[max(here, seen), 1]),
        ):
            seen -= step
        here = seen
        turns.append(here)
    return np.array(turns)[::step]
