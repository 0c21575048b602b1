"""What a laser measures: distances along equally spaced beams."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, kernel, unsigned
from multisrt.geometry.regions.edge_index import EdgeIndex, edges_within
from multisrt.geometry.regions.viewpoint import (
    MAX_RANGE_M,
    MIN_CLEARANCE_M,
    refuse_clearance,
    refuse_range,
    signed_clearance,
)


def laser_ranges(
    index: EdgeIndex, x: float, y: float, range_m: float, beams: int, *, first_rad: float = 0.0
) -> FloatArray:
    """Measure the distance to the nearest obstacle along equally spaced beams.

    Parameters
    ----------
    index, x, y, range_m
        As for `visibility_polygon`.
    beams : int
        How many beams share the full circle.
    first_rad : float
        Direction of the first beam; the others follow counter-clockwise.

    Returns
    -------
    (beams,) array
        Distances in metres; ``inf`` where nothing is hit within the range.

    Raises
    ------
    ClearanceError, InvalidInputError
        As for `visibility_polygon`; also for fewer than 3 beams.
    """
    if not (-math.inf < x < math.inf and -math.inf < y < math.inf):
        raise InvalidInputError(f"the viewpoint is finite, not ({x}, {y})")
    if not 0.0 < range_m <= MAX_RANGE_M:
        refuse_range(range_m)
    if beams < 3:
        raise InvalidInputError(f"a laser has at least 3 beams, not {beams}")
    scratch = index.scratch
    ranges, clearance = _z_buffer(
        x,
        y,
        range_m,
        _beam_directions(beams, first_rad),
        first_rad,
        index.free_winding,
        index.edges,
        index.grid,
        index.bins,
        scratch.memory,
        scratch.next_query(),
    )
    if clearance < MIN_CLEARANCE_M:
        refuse_clearance(x, y, clearance)
    return ranges


@lru_cache(maxsize=32)
def _beam_directions(beams: int, first_rad: float) -> FloatArray:
    angles = first_rad + np.arange(beams) * (2.0 * np.pi / beams)
    directions = np.array([np.cos(angles), np.sin(angles)])
    directions.setflags(write=False)
    return directions


@kernel
def _z_buffer(
    x: float,
    y: float,
    radius: float,
    directions: FloatArray,
    first_rad: float,
    free_winding: int,
    edges: FloatArray,
    grid: tuple[float, float, float, int, int],
    bins: NDArray[np.int64],
    scratch: NDArray[np.int64],
    query: int,
) -> tuple[FloatArray, float]:
    stamps, found = scratch[0], scratch[1]
    # Every edge that faces the viewpoint visits only the beams that it spans. They keep the
    # largest inverse distance: it is linear in the direction, so that this takes no division.
    # `ranges` holds it until the end.
    beams = directions.shape[1]
    count = edges_within(x, y, radius, grid, bins, stamps, query, found)
    ranges = np.zeros(beams)
    clearance = signed_clearance(
        x, y, radius, free_winding, edges, grid, bins, stamps, query, found, count
    )
    if clearance < MIN_CLEARANCE_M:
        return ranges, clearance
    radius2 = radius * radius
    per_rad = beams / (2.0 * np.pi)
    last_x, last_y, last_angle = 0.0, 0.0, 0.0
    for k in range(count):
        e = unsigned(found[k])
        ax, ay = edges[e, 0] - x, edges[e, 1] - y
        bx, by = edges[e, 2] - x, edges[e, 3] - y
        cross = ax * by - ay * bx
        if cross <= 0.0:
            continue
        dx, dy = bx - ax, by - ay
        if cross * cross >= radius2 * (dx * dx + dy * dy):
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
            # Slices: so the processor takes several beams at once.
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
