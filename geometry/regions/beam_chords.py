"""The boundary of what a laser's beams show to be free: a corner on every beam."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.beams import MIN_BEAMS, MIN_CORNER_RAD
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE, TagArray
from multisrt.geometry.regions.scan import LaserScan, beam_spacing_rad

MIN_INCIDENCE_RAD: Final = math.radians(10.0)
"""Minimum angle in radians between a beam and a surface for neighbouring beams to count as hits of
one surface."""


def boundary_from_beams(scan: LaserScan) -> tuple[FloatArray, TagArray]:
    """Return the boundary of the space that beams show to be free.

    Parameters
    ----------
    scan : LaserScan
        At least `MIN_BEAMS` beams.

    Returns
    -------
    boundary : (n, 2) array
        A corner in metres on every beam, before its reading and those beside it.
    tags : (n,) array of int8
        `OBSTACLE`, `RANGE` or `GAP`.

    Raises
    ------
    InvalidInputError
        For too few beams.

    Notes
    -----
    From a corner of angle c between two beams the chord of their hits is seen under that angle,
    so that it lies on or behind an arc. It comes nearest for equal readings r: to
    r (cos a - sin a / tan(c / 2)) along the middle, a being half the spacing; chords between
    beams at r (1 - tan a / tan(c / 2)) touch it there.
    """
    if len(scan.ranges) < MIN_BEAMS:
        raise InvalidInputError(
            f"a safe region needs at least {MIN_BEAMS} beams around the robot, "
            f"not {len(scan.ranges)}"
        )
    x, y, _ = scan.configuration
    spacing = beam_spacing_rad(scan)
    directions = _directions(len(scan.ranges), spacing)
    boundary, tags = _chords(scan.ranges, scan.range_m, x, y, spacing, directions)
    return boundary, tags


@lru_cache(maxsize=16)
def _directions(beams: int, spacing_rad: float) -> FloatArray:
    angles = spacing_rad * np.arange(beams)
    directions = np.column_stack([libm.cos(angles), libm.sin(angles)])
    directions.setflags(write=False)
    return directions


@kernel
def _chords(
    ranges: FloatArray,
    range_m: float,
    x: float,
    y: float,
    spacing: float,
    directions: FloatArray,
) -> tuple[FloatArray, TagArray]:
    # A corner on every beam, before the nearest of its reading and those beside it.
    n = ranges.shape[0]
    indent = math.tan(0.5 * spacing) / math.tan(0.5 * MIN_CORNER_RAD)
    steepest = math.tan(MIN_INCIDENCE_RAD)
    reading, nearest = np.empty(n), np.empty(n)
    for i in range(n):
        reading[i] = ranges[i] if np.isfinite(ranges[i]) else range_m
    boundary, tags = np.empty((n, 2)), np.empty(n, np.int8)
    for i in range(n):
        nearest[i] = min(reading[i], reading[i - 1], reading[i + 1 - n])
        radius = nearest[i] * (1.0 - indent)
        boundary[i, 0], boundary[i, 1] = (
            x + radius * directions[i, 0],
            y + radius * directions[i, 1],
        )
    for i in range(n):
        j = i + 1 - n
        is_surface = np.isfinite(ranges[i]) and np.isfinite(ranges[j])
        for distance in (reading, nearest):
            jump = abs(distance[j] - distance[i])
            is_surface &= jump <= min(distance[i], distance[j]) * spacing / steepest
        if is_surface:
            tags[i] = OBSTACLE
        elif nearest[i] == range_m and nearest[j] == range_m:
            tags[i] = RANGE
        else:
            tags[i] = GAP
    return boundary, tags
