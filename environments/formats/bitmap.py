"""Occupancy grids as polygons: walls keep their place, slanted walls lose their staircases.

The boundary between free and other cells is traced along the borders of cells. Every ring is
then replaced by a polygon of few vertices that passes between the same cell centres as the ring,
within a tolerance. Rings can therefore neither touch nor cross, the centre of a free cell is never
in a wall, and no wall opens, however thin it is.

Occupied cells that touch at a corner are joined (8-connected), free cells that touch at a
corner are not (4-connected): a robot cannot slip through a diagonal wall.
"""

import math
from typing import TypeAlias

import numpy as np
import shapely
from shapely import MultiPolygon

from multisrt.environments.environment import MAX_COORDINATE_M, MIN_LENGTH_M
from multisrt.environments.formats.straighten import straighten_rings
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel

TOLERANCE_CELLS = 0.45
"""Default of the maximum displacement of a wall between two cells, in cells."""

MAX_CORNERS = 5_000_000
"""Upper bound of the corners of the boundary; a grid with more is noise or a photograph."""

Resolution: TypeAlias = float | tuple[float, float]
"""Side of a square cell in metres, or the width (along x) and the height (along y) of a cell."""


def polygons_from_grid(
    free: BoolArray, resolution_m: Resolution, *, tolerance_cells: float = TOLERANCE_CELLS
) -> MultiPolygon:
    """Return the free space of an occupancy grid as polygons.

    Parameters
    ----------
    free : bool array, shape (rows, columns)
        True where a cell is free. Row 0 is the lowest, column 0 the leftmost; the outside of
        the grid is not free.
    resolution_m : float or (x, y)
        Side of a cell in metres, or its width and its height where cells are not square.
    tolerance_cells : float
        Maximum displacement of a wall between two cells, in cells, in [0, 0.5). With 0 it
        passes through the middle of every cell border, so that only staircases of 45
        degrees become straight. Walls and gaps of one cell keep at least
        ``(1 - 2 * tolerance_cells) / sqrt(2)`` of a cell's shorter side.

    Returns
    -------
    MultiPolygon
        Valid polygons in metres, with the lower left corner of the grid at the origin: one
        polygon for each 4-connected component of free cells, with one hole for each 8-connected
        group of other cells inside it. No two rings touch. The distance between its boundary
        and that of the cells is at most ``hypot(0.5, tolerance_cells)`` of a cell's longer side.

    Raises
    ------
    InvalidInputError
        If the grid is not two-dimensional, the resolution or the tolerance is out of range,
        or the boundary has more than five million corners.

    Examples
    --------
    >>> import numpy as np
    >>> room = np.ones((4, 6), dtype=bool)
    >>> room[1:3, 2] = False
    >>> free = polygons_from_grid(room, 0.5)
    >>> free.area, len(free.geoms[0].interiors), free.bounds
    (5.5, 1, (0.0, 0.0, 3.0, 2.0))

    The same with cells of 0.5 x 0.25 m:

    >>> polygons_from_grid(room, (0.5, 0.25)).bounds
    (0.0, 0.0, 3.0, 1.0)
    """
    free = np.asarray(free, dtype=np.bool_)
    if free.ndim != 2:
        raise InvalidInputError(
            f"an occupancy grid has rows and columns; this array has shape {free.shape}"
        )
    cell = _cell_sides(resolution_m)
    if not 0 <= tolerance_cells < 0.5:
        raise InvalidInputError(
            f"tolerance_cells is {tolerance_cells}; it must be at least 0 and below 0.5, "
            "or thin walls would vanish"
        )
    if not free.any():
        return MultiPolygon()
    padded = np.pad(free, 1)
    corners = _count_corners(padded)
    if corners > MAX_CORNERS:
        raise InvalidInputError(
            f"the boundary of free space has {corners:,} corners, more than {MAX_CORNERS:,}: "
            "this is noise or a photograph; clean the image or choose another threshold"
        )
    turns, pinched, ring_starts, ring_cells = _trace(padded, corners)
    vertices, vertex_starts = straighten_rings(turns, pinched, ring_starts, tolerance_cells)
    return _assemble(free, vertices * cell, vertex_starts, ring_cells)


def _cell_sides(resolution_m: Resolution) -> FloatArray:
    """Return the width and the height of a cell in metres."""
    sides = np.asarray(resolution_m, np.float64)
    in_range = (sides >= MIN_LENGTH_M) & (sides <= MAX_COORDINATE_M)
    if sides.shape not in ((), (2,)) or not in_range.all():
        raise InvalidInputError(
            f"resolution_m is {resolution_m}; it must be a number of metres per cell from "
            f"{MIN_LENGTH_M:g} to {MAX_COORDINATE_M:g}, or two, along x and along y"
        )
    return np.broadcast_to(sides, 2)


def polygons_between_lines(free: BoolArray, x_m: FloatArray, y_m: FloatArray) -> MultiPolygon:
    """Return the union of the free cells of a grid whose lines are unevenly spaced.

    Parameters
    ----------
    free : bool array, shape (rows, columns)
        True where a cell is free. No two free cells may touch only at a corner.
    x_m : float array, shape (columns + 1,)
        The lines between columns in metres, increasing.
    y_m : float array, shape (rows + 1,)
        The lines between rows in metres, increasing.

    Returns
    -------
    MultiPolygon
        One polygon for each component, in metres, with vertices only at its corners.

    Raises
    ------
    InvalidInputError
        If two free cells touch only at a corner.

    Examples
    --------
    >>> import numpy as np
    >>> bent = np.array([[True, True], [True, False]])
    >>> polygons_between_lines(bent, np.array([0.0, 1.0, 4.0]), np.array([0.0, 1.0, 3.0])).area
    6.0
    """
    if not free.any():
        return MultiPolygon()
    padded = np.pad(free, 1)
    turns, pinched, ring_starts, ring_cells = _trace(padded, _count_corners(padded))
    if pinched.any():
        column, row = turns[np.flatnonzero(pinched)[0]]
        raise InvalidInputError(
            f"free cells touch only at the corner between rows {row - 1} and {row} and columns "
            f"{column - 1} and {column}; free one more cell there"
        )
    vertices = np.column_stack([x_m[turns[:, 0]], y_m[turns[:, 1]]])
    return _assemble(free, vertices, ring_starts, ring_cells)


def displacement_bound_m(
    resolution_m: Resolution, tolerance_cells: float = TOLERANCE_CELLS
) -> float:
    """Return the upper bound of the distance between the polygons of a grid and its cells.

    Parameters
    ----------
    resolution_m, tolerance_cells
        As for `polygons_from_grid`.

    Examples
    --------
    >>> round(displacement_bound_m(0.05), 4)
    0.0336
    """
    return math.hypot(0.5, tolerance_cells) * float(_cell_sides(resolution_m).max())


def _count_corners(padded: BoolArray) -> int:
    """Return the number of turns: one where 1 or 3 of 4 cells are free, two at a pinch."""
    southwest, southeast = padded[:-1, :-1], padded[:-1, 1:]
    northwest, northeast = padded[1:, :-1], padded[1:, 1:]
    odd = southwest ^ southeast ^ northwest ^ northeast
    pinch = (southwest == northeast) & (southeast == northwest) & (southwest != southeast)
    return int(np.count_nonzero(odd)) + 2 * int(np.count_nonzero(pinch))


def _assemble(
    free: BoolArray, vertices: FloatArray, vertex_starts: IntArray, ring_cells: IntArray
) -> MultiPolygon:
    """Return polygons of the rings around the same free component, with the shell first."""
    from scipy import ndimage

    component, _ = ndimage.label(free)
    owner = component[ring_cells[:, 0], ring_cells[:, 1]]
    sizes = np.diff(vertex_starts)
    following = np.arange(len(vertices)) + 1
    following[vertex_starts[1:] - 1] = vertex_starts[:-1]
    x, y = vertices.T
    cross = x * y[following] - x[following] * y
    is_hole = np.add.reduceat(cross, vertex_starts[:-1]) < 0
    order = np.lexsort((is_hole, owner))
    closed = np.concatenate(
        [
            np.concatenate(
                [np.arange(vertex_starts[r], vertex_starts[r + 1]), vertex_starts[r : r + 1]]
            )
            for r in order
        ]
    )
    ring_offsets = np.concatenate([[0], np.cumsum(sizes[order] + 1)])
    shells = np.flatnonzero(~is_hole[order])
    polygon_offsets = np.append(shells, len(order))
    (polygons,) = shapely.from_ragged_array(
        shapely.GeometryType.MULTIPOLYGON,
        vertices[closed],
        (ring_offsets, polygon_offsets, np.array([0, len(shells)])),
    )
    assert isinstance(polygons, MultiPolygon)
    return polygons


# Headings are 0 east, 1 north, 2 west, 3 south; free space lies on a ring's left. In the padded
# grid, the cell right above and right of the lattice point (x, y) is [y + 1, x + 1].


@kernel
def _trace(padded: BoolArray, corners: int) -> tuple[IntArray, BoolArray, IntArray, IntArray]:
    """Trace the rings along the borders of cells.

    Returns the turns as ``(n, 2)`` lattice points, whether each is a pinch, the indices where
    rings start (with the end appended), and a free cell (row, column) beside each ring.
    """
    step_x, step_y = (1, 0, -1, 0), (0, 1, 0, -1)
    left_row, left_column = (1, 1, 0, 0), (1, 0, 0, 1)
    right_row, right_column = (0, 1, 1, 0), (1, 1, 0, 0)
    rows, columns = padded.shape[0] - 2, padded.shape[1] - 2
    turns = np.empty((corners, 2), np.int64)
    pinched = np.zeros(corners, np.bool_)
    ring_starts = np.zeros(corners // 4 + 1, np.int64)
    ring_cells = np.empty((corners // 4, 2), np.int64)
    followed = np.zeros((rows + 1, columns), np.bool_)  # borders followed eastwards
    n_turns, n_rings = 0, 0
    for row in range(rows):
        for column in range(columns):
            starts_here = padded[row + 1, column + 1] and not padded[row, column + 1]
            if not starts_here or followed[row, column]:
                continue
            x, y, heading = column, row, 0
            while True:
                if heading == 0:
                    followed[y, x] = True
                x += step_x[heading]
                y += step_y[heading]
                left = padded[y + left_row[heading], x + left_column[heading]]
                right = padded[y + right_row[heading], x + right_column[heading]]
                if not left or right:
                    turns[n_turns, 0] = x
                    turns[n_turns, 1] = y
                    pinched[n_turns] = right and not left
                    n_turns += 1
                    heading = (heading + (3 if left else 1)) % 4
                if x == column and y == row and heading == 0:
                    break
            ring_cells[n_rings, 0] = row
            ring_cells[n_rings, 1] = column
            n_rings += 1
            ring_starts[n_rings] = n_turns
    return turns, pinched, ring_starts[: n_rings + 1], ring_cells[:n_rings]
