"""Readings of a laser: distances along equally spaced beams."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import FloatArray, kernel, unsigned
from multisrt.geometry.regions.edge_index import EdgeGrid, EdgeIndex, edges_within
from multisrt.geometry.regions.viewpoint import (
    MIN_CLEARANCE_M,
    check_clearance,
    check_view,
    signed_clearance,
)


def laser_ranges(
    index: EdgeIndex, x: float, y: float, range_m: float, beams: int, *, first_rad: float = 0.0
) -> FloatArray:
    """Measure the distance to the nearest obstacle along equally spaced beams.

    Parameters
    ----------
    index : EdgeIndex
        The edges of the world.
    x, y : float
        The place of the laser in metres, strictly inside free space.
    range_m : float
        Range of the laser in metres, at most `MAX_RANGE_M`.
    beams : int
        Number of beams around the full circle, at least 3.
    first_rad : float, default 0.0
        Direction of the first beam in radians; the others follow counter-clockwise.

    Returns
    -------
    (beams,) array
        Distances in metres; ``inf`` where nothing is hit within the range.

    Raises
    ------
    ClearanceError
        If the place lies on an edge or inside an obstacle.
    InvalidInputError
        If the place or the range is not finite, the range is not positive or too large, or there
        are fewer than 3 beams.

    Examples
    --------
    Four beams in a room of 4 x 3 m:

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    >>> room = EdgeIndex(np.hstack([corners, np.roll(corners, -1, axis=0)]), 1.0)
    >>> laser_ranges(room, 1.5, 1.0, 2.2, 4).round(9).tolist()
    [inf, 2.0, 1.5, 1.0]
    """
    check_view(x, y, range_m)
    if beams < 3:
        raise InvalidInputError(f"a laser has at least 3 beams, not {beams}")
    directions = _beam_directions(beams, first_rad)
    ranges, clearance = _z_buffer(x, y, range_m, directions, first_rad, index.grid)
    check_clearance(x, y, clearance)
    return ranges


@lru_cache(maxsize=32)
def _beam_directions(beams: int, first_rad: float) -> FloatArray:
    angles = first_rad + np.arange(beams) * (2.0 * np.pi / beams)
    directions = np.array([libm.cos(angles), libm.sin(angles)])
    directions.setflags(write=False)
    return directions


@kernel
def _z_buffer(
    x: float, y: float, radius: float, directions: FloatArray, first_rad: float, grid: EdgeGrid
) -> tuple[FloatArray, float]:
    # Every edge that faces the viewpoint visits only the beams that it spans. They keep the
    # largest inverse distance: it is linear in the direction, so that this takes no division.
    # `ranges` holds it until the end.
    edges = grid.edges
    beams = directions.shape[1]
    found = edges_within(x, y, radius, grid)
    ranges = np.zeros(beams)
    clearance = signed_clearance(x, y, radius, grid, found)
    if clearance < MIN_CLEARANCE_M:
        return ranges, clearance
    radius2, tiny2 = radius * radius, MIN_CLEARANCE_M * MIN_CLEARANCE_M
    per_rad = beams / (2.0 * np.pi)
    last_x, last_y, last_angle = 0.0, 0.0, 0.0
    for k in range(found.shape[0]):
        e = unsigned(found[k])
        ax, ay = edges[e, 0] - x, edges[e, 1] - y
        bx, by = edges[e, 2] - x, edges[e, 3] - y
        cross = ax * by - ay * bx
        dx, dy = bx - ax, by - ay
        length2 = dx * dx + dy * dy
        # Where a beam meets an edge that is hardly longer than a point, or seen along its length,
        # would be rounding alone.
        if length2 <= tiny2 or cross <= 0.0 or cross * cross <= tiny2 * length2:
            continue
        if cross * cross >= radius2 * length2:
            continue
        leaves_range = ax * dx + ay * dy >= 0.0 and ax * ax + ay * ay > radius2
        never_enters = bx * dx + by * dy <= 0.0 and bx * bx + by * by > radius2
        if leaves_range or never_enters:
            continue
        # Edges of one wall follow each other: an end's direction is computed once.
        angle_a = last_angle if ax == last_x and ay == last_y else np.arctan2(ay, ax)
        angle_b = np.arctan2(by, bx)
        last_x, last_y, last_angle = bx, by, angle_b
        start = (angle_a - first_rad) * per_rad
        end = (angle_b - first_rad) * per_rad
        if end < start:
            end += beams
        begin, until = int(np.ceil(start - 1e-9)), int(np.floor(end + 1e-9)) + 1
        along_x, along_y = dy / cross, -dx / cross
        turn = begin // beams * beams
        for low, high in (
            (begin - turn, min(until - turn, beams)),
            (0, until - turn - beams),
        ):
            if low >= high:
                continue
            # Slices let the processor take several beams at once.
            some, cosines, sines = (
                ranges[low:high],
                directions[0, low:high],
                directions[1, low:high],
            )
            for i in range(some.shape[0]):
                value = cosines[i] * along_x + sines[i] * along_y
                some[i] = value if value > some[i] else some[i]
    for i in range(beams):
        ranges[i] = 1.0 / ranges[i] if ranges[i] * radius >= 1.0 else np.inf
    return ranges, clearance
