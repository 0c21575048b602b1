"""Where one can look from: strictly inside free space, and how far from its border."""

from __future__ import annotations

import math
from typing import Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, kernel, unsigned
from multisrt.geometry.regions.edge_index import winding_number

MIN_CLEARANCE_M: Final = 1e-9
"""A viewpoint nearer to an edge than this would leak through it."""

MAX_RANGE_M: Final = 1e7
"""As far as coordinates may lie from the origin: a range beyond it reaches no further."""


def refuse_range(range_m: float) -> NoReturn:
    """Raise the error for a range that is not allowed."""
    raise InvalidInputError(
        f"a range is a positive number of metres, at most {MAX_RANGE_M:g}, not {range_m:g}"
    )


def refuse_clearance(x: float, y: float, clearance: float) -> NoReturn:
    """Raise the error for a viewpoint that is not strictly inside free space."""
    raise ClearanceError(
        f"({x:g}, {y:g}) is on or inside an obstacle (clearance {clearance:.3g} m): "
        f"a viewpoint needs more than {MIN_CLEARANCE_M:g} m",
        clearance,
    )


@kernel
def signed_clearance(
    x: float,
    y: float,
    radius: float,
    free_winding: int,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: NDArray[np.int64],
    stamps: NDArray[np.int64],
    query: int,
    found: NDArray[np.int64],
    count: int,
) -> float:
    """Distance to the nearest of the edges found, negative inside an obstacle.

    The side is that of the nearest edge; of edges that meet in the nearest corner, that of the
    one which faces the point most, for another may be seen edge-on or from the wrong side.
    """
    nearest, facing = np.inf, 0.0
    free = True
    for k in range(count):
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
            free = cross > 0.0
    clearance = math.sqrt(nearest)
    if clearance > radius:
        # There may be nearer edges that were not looked up.
        winding = winding_number(x, y, edges, grid, bins, stamps, query + 1)
        clearance = radius
        free = winding >= free_winding
    return clearance if free else -clearance
