"""Whether two points see each other."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, inlined_kernel, kernel
from multisrt.geometry.regions.edge_index import EdgeGrid, EdgeIndex

ON_LINE_M: Final = 1e-9
"""A corner at most this far from a line lies on it, in metres."""


def line_of_sight(index: EdgeIndex, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether two points of free space see each other: no obstacle lies between them.

    Touching a corner or running along a wall does not block the view.

    Parameters
    ----------
    index : EdgeIndex
        The edges of the world.
    ax, ay, bx, by : float
        The points in metres.

    Returns
    -------
    bool
        The same in either direction; a point sees itself.

    Raises
    ------
    InvalidInputError
        If a point is not finite.

    Examples
    --------
    A room of 4 x 3 m with a pillar of 1 x 1 m, which is clockwise:

    >>> import numpy as np
    >>> room = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    >>> pillar = np.array([[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]])
    >>> rings = [np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in (room, pillar)]
    >>> index = EdgeIndex(np.concatenate(rings), 1.0)
    >>> line_of_sight(index, 0.5, 1.5, 3.0, 1.5)
    False
    >>> line_of_sight(index, 0.5, 1.0, 3.0, 1.0)
    True
    """
    if not (math.isfinite(ax + ay) and math.isfinite(bx + by)):
        raise InvalidInputError(f"points are finite, not ({ax}, {ay}) and ({bx}, {by})")
    return bool(segment_is_free(float(ax), float(ay), float(bx), float(by), index.grid))


@inlined_kernel
def _side(ux: float, uy: float, x: float, y: float) -> float:
    # Distance of a point from a line through the origin; 0 if it lies on it but for rounding.
    side = ux * y - uy * x
    return 0.0 if abs(side) <= ON_LINE_M else side


@kernel
def segment_is_free(ax: float, ay: float, bx: float, by: float, grid: EdgeGrid) -> bool:
    """Return what `line_of_sight` returns, as a kernel."""
    # Add up how much of the segment lies inside obstacles: minus the distance of every crossing
    # into one, plus that of every crossing out of one. An end exactly on the line counts as right
    # of it in one sum and as left of it in the other; what is only touched, or run along on one
    # side, leaves one of the two at zero.
    crossed = edges_across(ax, ay, bx, by, grid)
    if crossed.shape[0] == 0:
        return True
    edges = grid.edges
    length = np.hypot(bx - ax, by - ay)
    ux, uy = (bx - ax) / length, (by - ay) / length
    inside_right = inside_left = 0.0
    is_touched = False
    between = np.empty_like(crossed)
    count = 0
    for k in range(crossed.shape[0]):
        e = crossed[k]
        px, py = edges[e, 0] - ax, edges[e, 1] - ay
        qx, qy = edges[e, 2] - ax, edges[e, 3] - ay
        side_p, side_q = _side(ux, uy, px, py), _side(ux, uy, qx, qy)
        fraction = side_p / (side_p - side_q)
        t = ux * (px + fraction * (qx - px)) + uy * (py + fraction * (qy - py))
        if 0.0 < t < length:
            between[count] = e
            count += 1
            is_touched = is_touched or side_p == 0.0 or side_q == 0.0
            left = length - t if side_q > side_p else t - length
            if (side_p > 0.0) != (side_q > 0.0):
                inside_right += left
            if (side_p < 0.0) != (side_q < 0.0):
                inside_left += left
    if min(inside_right, inside_left) <= 1e-9:
        return True
    if not is_touched:
        return False
    return _inside_on_both_sides(ax, ay, ux, uy, edges, between[:count]) <= 1e-9


@kernel
def edges_across(ax: float, ay: float, bx: float, by: float, grid: EdgeGrid) -> IntArray:
    """Return the edges near a segment that its line crosses or touches.

    All edges that the segment itself crosses or touches are among them, but for those that run
    along it.

    Parameters
    ----------
    ax, ay, bx, by : float
        Ends of the segment in metres.
    grid : EdgeGrid
        The edges; only the cells along the segment are read.

    Returns
    -------
    (k,) array of int
        Rows of `grid.edges`, each once, in the order of the cells from a to b.
    """
    edges, bins, cell = grid.edges, grid.bins, grid.cell_m
    found = np.empty(16, np.int64)
    length = np.hypot(bx - ax, by - ay)
    if length == 0.0:
        return found[:0]
    ux, uy = (bx - ax) / length, (by - ay) / length
    i, j = int(np.floor((ax - grid.x0) / cell)), int(np.floor((ay - grid.y0) / cell))
    step_i, step_j = (1 if ux > 0.0 else -1), (1 if uy > 0.0 else -1)
    next_x = np.inf if ux == 0.0 else (grid.x0 + (i + (step_i > 0)) * cell - ax) / ux
    next_y = np.inf if uy == 0.0 else (grid.y0 + (j + (step_j > 0)) * cell - ay) / uy
    width_x = np.inf if ux == 0.0 else cell / abs(ux)
    width_y = np.inf if uy == 0.0 else cell / abs(uy)
    count = 0
    travelled = 0.0
    while travelled <= length:
        if 0 <= i < grid.columns and 0 <= j < grid.rows:
            k = i * grid.rows + j
            for e in bins[bins[k] : bins[k + 1]]:
                side_p = _side(ux, uy, edges[e, 0] - ax, edges[e, 1] - ay)
                side_q = _side(ux, uy, edges[e, 2] - ax, edges[e, 3] - ay)
                if (
                    side_p != side_q
                    and min(side_p, side_q) <= 0.0 <= max(side_p, side_q)
                    and not _holds(found, count, e)
                ):
                    if count == found.shape[0]:
                        found = np.concatenate((found, np.empty_like(found)))
                    found[count] = e
                    count += 1
        if next_x < next_y:
            travelled = next_x
            next_x += width_x
            i += step_i
        else:
            travelled = next_y
            next_y += width_y
            j += step_j
    return found[:count]


@kernel
def _holds(found: IntArray, count: int, edge: int) -> bool:
    # Whether an edge is among those found; if it is, it was mostly found in the cell before.
    k = count - 1
    while k >= 0 and found[k] != edge:
        k -= 1
    return k >= 0


@kernel
def crossings(
    ax: float, ay: float, ux: float, uy: float, edges: FloatArray, crossed: IntArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return where a line crosses edges, and whether it enters or leaves an obstacle there.

    Parameters
    ----------
    ax, ay : float
        A point of the line in metres.
    ux, uy : float
        The unit vector along the line.
    edges : (n, 4) array
        The edges, free space on their left.
    crossed : (k,) array of int
        The edges that the line meets; none is parallel to it.

    Returns
    -------
    at : (k,) array
        The crossings, in metres along the line from the point.
    right, left : (k,) arrays of int
        Whether the line a hair to its right, or to its left, enters an obstacle there (1), leaves
        one (-1) or does neither (0).
    """
    n = crossed.shape[0]
    at = np.empty(n)
    right, left = np.zeros(n, np.int64), np.zeros(n, np.int64)
    for k in range(n):
        e = crossed[k]
        px, py = edges[e, 0] - ax, edges[e, 1] - ay
        qx, qy = edges[e, 2] - ax, edges[e, 3] - ay
        side_p, side_q = _side(ux, uy, px, py), _side(ux, uy, qx, qy)
        fraction = side_p / (side_p - side_q)
        at[k] = ux * (px + fraction * (qx - px)) + uy * (py + fraction * (qy - py))
        into = 1 if side_q > side_p else -1
        right[k] = into if (side_p > 0.0) != (side_q > 0.0) else 0
        left[k] = into if (side_p < 0.0) != (side_q < 0.0) else 0
    return at, right, left


@kernel
def _inside_on_both_sides(
    ax: float, ay: float, ux: float, uy: float, edges: FloatArray, crossed: IntArray
) -> float:
    # How much of a segment has obstacles on its left and on its right. One that runs along a
    # wall on its left and later along one on its right has none.
    at, right, left = crossings(ax, ay, ux, uy, edges, crossed)
    inside = 0.0
    depth_right = depth_left = 0
    previous = 0.0
    for k in np.argsort(at):
        if depth_right > 0 and depth_left > 0:
            inside += at[k] - previous
        depth_right += right[k]
        depth_left += left[k]
        previous = at[k]
    return inside
