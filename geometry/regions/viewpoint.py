"""Where a range finder can stand: strictly inside free space, and how far from its border."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.numerics.kernel import IntArray, kernel, unsigned
from multisrt.geometry.regions.edge_index import EdgeGrid, winding_number

MIN_CLEARANCE_M: Final = 1e-9
"""Minimum distance in metres of a viewpoint from all edges: nearer to one, the view would leak
through it."""

MAX_RANGE_M: Final = 1e7
"""Maximum range in metres, as far as coordinates may lie from the origin."""


def check_view(x: float, y: float, range_m: float) -> None:
    """Raise `InvalidInputError` unless a viewpoint is finite and its range allowed."""
    if not (-math.inf < x < math.inf and -math.inf < y < math.inf):
        raise InvalidInputError(f"the viewpoint is finite, not ({x}, {y})")
    if not 0.0 < range_m <= MAX_RANGE_M:
        raise InvalidInputError(
            f"a range is a positive number of metres, at most {MAX_RANGE_M:g}, not {range_m:g}"
        )


def check_clearance(x: float, y: float, clearance_m: float) -> None:
    """Raise `ClearanceError` unless a viewpoint is strictly inside free space."""
    if clearance_m < MIN_CLEARANCE_M:
        raise ClearanceError(
            f"({x:g}, {y:g}) is on or inside an obstacle (clearance {clearance_m:.3g} m): "
            f"a viewpoint needs more than {MIN_CLEARANCE_M:g} m",
            clearance_m,
        )


@kernel
def signed_clearance(x: float, y: float, radius: float, grid: EdgeGrid, found: IntArray) -> float:
    """Return the distance from a point to the nearest edge, negative inside an obstacle.

    Parameters
    ----------
    x, y : float
        The point, in metres.
    radius : float
        Maximum absolute value that is returned, in metres.
    grid : EdgeGrid
        The edges.
    found : (k,) array of int
        The edges near the point: all within the radius, as `edges_within` returns them.

    Notes
    -----
    The nearest edge decides on the side; of several that meet in the nearest corner, the one that
    faces the point most, for another may be seen edge-on or from behind.
    """
    edges = grid.edges
    nearest, facing = np.inf, 0.0
    is_free = True
    for k in range(found.shape[0]):
        e = unsigned(found[k])
        ax, ay = edges[e, 0] - x, edges[e, 1] - y
        dx, dy = edges[e, 2] - edges[e, 0], edges[e, 3] - edges[e, 1]
        length2 = dx * dx + dy * dy
        cross = ax * dy - ay * dx
        if length2 == 0.0 or cross * cross > nearest * (1.0 + 1e-9) * length2:
            continue
        t = min(1.0, max(0.0, -(ax * dx + ay * dy) / length2))
        px, py = ax + t * dx, ay + t * dy
        distance = px * px + py * py
        if distance > nearest * (1.0 + 1e-9):
            continue
        face = cross * cross / length2
        if distance < nearest * (1.0 - 1e-9) or face > facing:
            nearest, facing = min(nearest, distance), face
            is_free = cross > 0.0
    clearance = math.sqrt(nearest)
    if clearance > radius:
        # Edges that were not looked up may be nearer.
        clearance = radius
        is_free = winding_number(x, y, grid) >= grid.free_winding
    return clearance if is_free else -clearance
