"""Whether two points see each other."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.edge_index import EdgeIndex


def line_of_sight(index: EdgeIndex, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether two points of free space see each other: no obstacle lies between them.

    Touching a corner or running along a wall does not block the view.
    """
    if not (math.isfinite(ax + ay) and math.isfinite(bx + by)):
        raise InvalidInputError(f"points are finite, not ({ax}, {ay}) and ({bx}, {by})")
    return bool(
        _line_of_sight(
            ax,
            ay,
            bx,
            by,
            index.edges,
            index.grid,
            index.bins,
            index.scratch.memory,
            index.scratch.next_query(),
        )
    )


@kernel
def _line_of_sight(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: NDArray[np.int64],
    scratch: NDArray[np.int64],
    query: int,
) -> bool:
    # Add up how much of the segment lies inside obstacles: minus the distance of every crossing
    # into one, plus that of every crossing out of one. An end exactly on the line counts as right
    # of it in one sum and as left of it in the other; what is only touched, or run along on one
    # side, leaves one of the two at zero.
    count = edges_across(ax, ay, bx, by, edges, grid, bins, scratch, query)
    if count == 0:
        return True
    length = np.hypot(bx - ax, by - ay)
    ux, uy = (bx - ax) / length, (by - ay) / length
    found = scratch[1]
    inside_right = inside_left = 0.0
    touched = False
    met = 0
    for k in range(count):
        e = found[k]
        px, py = edges[e, 0] - ax, edges[e, 1] - ay
        qx, qy = edges[e, 2] - ax, edges[e, 3] - ay
        side_p, side_q = ux * py - uy * px, ux * qy - uy * qx
        fraction = side_p / (side_p - side_q)
        t = ux * (px + fraction * (qx - px)) + uy * (py + fraction * (qy - py))
        if 0.0 < t < length:
            found[met] = e
            met += 1
            touched = touched or side_p == 0.0 or side_q == 0.0
            left = length - t if side_q > side_p else t - length
            if (side_p > 0.0) != (side_q > 0.0):
                inside_right += left
            if (side_p < 0.0) != (side_q < 0.0):
                inside_left += left
    if min(inside_right, inside_left) <= 1e-9:
        return True
    if not touched:
        return False
    return _inside_on_both_sides(ax, ay, ux, uy, edges, found[:met]) <= 1e-9


@kernel
def edges_across(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: NDArray[np.int64],
    scratch: NDArray[np.int64],
    query: int,
) -> int:
    """Find the edges that a segment may cross: those near it that its line crosses or touches.

    Walks the cells along the segment. Edges that run along the line are left out.

    Parameters
    ----------
    ax, ay, bx, by : float
        The ends of the segment.
    edges, grid, bins
        As an `EdgeIndex` has them.
    scratch : (2, n) array
        Its second row takes the edges found.
    query : int
        A number of the scratch memory that no query had before.

    Returns
    -------
    int
        How many edges were found.
    """
    stamps, found = scratch[0], scratch[1]
    x0, y0, cell, columns, rows = grid
    length = np.hypot(bx - ax, by - ay)
    if length == 0.0:
        return 0
    ux, uy = (bx - ax) / length, (by - ay) / length
    i, j = int(np.floor((ax - x0) / cell)), int(np.floor((ay - y0) / cell))
    step_i, step_j = (1 if ux > 0.0 else -1), (1 if uy > 0.0 else -1)
    next_x = np.inf if ux == 0.0 else (x0 + (i + (step_i > 0)) * cell - ax) / ux
    next_y = np.inf if uy == 0.0 else (y0 + (j + (step_j > 0)) * cell - ay) / uy
    width_x = np.inf if ux == 0.0 else cell / abs(ux)
    width_y = np.inf if uy == 0.0 else cell / abs(uy)
    count = 0
    travelled = 0.0
    while travelled <= length:
        if 0 <= i < columns and 0 <= j < rows:
            for k in range(bins[i * rows + j], bins[i * rows + j + 1]):
                e = bins[k]
                if stamps[e] == query:
                    continue
                stamps[e] = query
                side_p = ux * (edges[e, 1] - ay) - uy * (edges[e, 0] - ax)
                side_q = ux * (edges[e, 3] - ay) - uy * (edges[e, 2] - ax)
                if side_p != side_q and min(side_p, side_q) <= 0.0 <= max(side_p, side_q):
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
    return count


@kernel
def crossings(
    ax: float,
    ay: float,
    ux: float,
    uy: float,
    edges: FloatArray,
    crossed: NDArray[np.int64],
) -> tuple[FloatArray, NDArray[np.int64], NDArray[np.int64]]:
    """Tell where a line crosses edges, and what that means a hair beside it.

    Parameters
    ----------
    ax, ay, ux, uy : float
        A point of the line, and the unit vector along it.
    edges : (n, 4) array
        The edges, free space on their left.
    crossed : (k,) array
        Which of them the line meets; none is parallel to it.

    Returns
    -------
    at : (k,) array
        Where, in metres from the point.
    right, left : (k,) arrays
        Whether the line a hair beside it enters an obstacle there (1), leaves one (-1) or
        neither (0).
    """
    n = crossed.shape[0]
    at = np.empty(n)
    right, left = np.zeros(n, np.int64), np.zeros(n, np.int64)
    for k in range(n):
        e = crossed[k]
        px, py = edges[e, 0] - ax, edges[e, 1] - ay
        qx, qy = edges[e, 2] - ax, edges[e, 3] - ay
        side_p, side_q = ux * py - uy * px, ux * qy - uy * qx
        fraction = side_p / (side_p - side_q)
        at[k] = ux * (px + fraction * (qx - px)) + uy * (py + fraction * (qy - py))
        into = 1 if side_q > side_p else -1
        right[k] = into if (side_p > 0.0) != (side_q > 0.0) else 0
        left[k] = into if (side_p < 0.0) != (side_q < 0.0) else 0
    return at, right, left


@kernel
def _inside_on_both_sides(
    ax: float,
    ay: float,
    ux: float,
    uy: float,
    edges: FloatArray,
    crossed: NDArray[np.int64],
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
