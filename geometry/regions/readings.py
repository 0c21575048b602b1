"""Scans from the readings of a real sensor, or of an external simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import shapely
from numpy.typing import ArrayLike

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.beams import MIN_BEAMS
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.scan import ExactScan, LaserScan

SAME_BEAM: Final = 1e-9
"""Beams whose directions differ by less are one, as a share of their spacing."""

RADIAL: Final = 1e-6
"""A piece whose line passes the sensor within this share of the range is radial."""


def scan_of_ranges(
    ranges: ArrayLike,
    configuration: Sequence[float],
    *,
    time_s: float,
    range_m: float,
    first_rad: float = 0.0,
) -> LaserScan:
    """Return the scan of a laser that turns with its robot.

    A `LaserScan` has its beams in directions of the world. Where those of the sensor lie between,
    the shorter of the two neighbouring ranges is taken, so that what is taken as free is free.

    Parameters
    ----------
    ranges : (n,) array_like
        Distance along each beam in metres, counter-clockwise, equally spaced over the full
        circle; ``inf``, or more than `range_m`, where nothing was hit.
    configuration : (x, y, heading)
        Where the sensor is, in metres and radians. On a robot that is driven, it is the reference
        point of the footprint: what the footprint covers there is taken as free.
    time_s : float
        When the scan was taken, in seconds.
    range_m : float
        Range of the sensor in metres.
    first_rad : float, optional
        Direction of the first beam from the heading, in radians.

    Returns
    -------
    LaserScan

    Raises
    ------
    InvalidInputError
        If there are too few beams, a range is not a positive number, or the place is not finite.

    Examples
    --------
    >>> scan = scan_of_ranges([1.0, 2.0, 9.0, 3.0, 4.0], (0.0, 0.0, 0.0), time_s=0.0, range_m=5.0)
    >>> scan.ranges.tolist()
    [1.0, 2.0, inf, 3.0, 4.0]
    >>> from math import tau
    >>> turned = scan_of_ranges(
    ...     [1.0, 2.0, 9.0, 3.0, 4.0], (0.0, 0.0, tau / 10), time_s=0.0, range_m=5.0
    ... )
    >>> turned.ranges.tolist()
    [1.0, 1.0, 2.0, 3.0, 3.0]
    """
    here, reach = _place(configuration, time_s, range_m), np.asarray(ranges, np.float64)
    if reach.ndim != 1 or len(reach) < MIN_BEAMS:
        raise InvalidInputError(
            f"a scan has at least {MIN_BEAMS} ranges in one row, not the shape {reach.shape}"
        )
    if not np.all(reach > 0.0):
        beam = int(np.flatnonzero(~(reach > 0.0))[0])
        raise InvalidInputError(
            f"the range of beam {beam} is {reach[beam]:g}; give a positive number of metres, or "
            "inf where nothing was hit"
        )
    reach = np.where(reach > range_m, np.inf, reach)
    beams = len(reach)
    # The direction of beam i of the sensor is that of beam i + turn of the world.
    turn = (here.heading + first_rad) * beams / math.tau
    whole = math.floor(turn + SAME_BEAM)
    before = np.roll(reach, whole)
    if abs(turn - whole) > SAME_BEAM:
        before = np.minimum(before, np.roll(before, 1))
    return LaserScan(configuration=here, time_s=float(time_s), range_m=range_m, ranges=before)


def scan_of_polygon(
    corners: ArrayLike,
    configuration: Sequence[float],
    *,
    time_s: float,
    range_m: float,
) -> ExactScan:
    """Return the scan of a sensor that reports a visibility polygon.

    Pieces of the boundary whose ends are both at the range are taken as its limit, pieces that
    point at the sensor as the sides of what a corner hides, and all others as obstacles.

    Parameters
    ----------
    corners : (n, 2) array_like
        Corners of what is seen in metres, in the frame of the world, around the sensor.
    configuration : (x, y, heading)
        Where the sensor is, in metres and radians.
    time_s : float
        When the scan was taken, in seconds.
    range_m : float
        Range of the sensor in metres.

    Returns
    -------
    ExactScan

    Raises
    ------
    InvalidInputError
        If the corners are not a valid polygon around the sensor.

    Examples
    --------
    >>> room = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)]
    >>> scan_of_polygon(room, (1.0, 1.0, 0.0), time_s=0.0, range_m=9.0).tags.tolist()
    [0, 0, 0, 0]
    """
    here = _place(configuration, time_s, range_m)
    try:
        polygon = shapely.Polygon(np.asarray(corners, np.float64))
    except (TypeError, ValueError) as error:
        raise InvalidInputError(f"the corners of a scan: {error}") from None
    if not polygon.is_valid or not polygon.contains(shapely.Point(here.x, here.y)):
        raise InvalidInputError(
            f"a scan is a simple polygon around the sensor at ({here.x:g}, {here.y:g})"
        )
    ring = shapely.get_coordinates(shapely.orient_polygons(polygon).exterior)
    start, end = ring[:-1] - here[:2], ring[1:] - here[:2]
    far = np.hypot(*start.T) >= range_m * (1.0 - RADIAL)
    length = np.hypot(*(end - start).T)
    off_line = np.abs(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]) / length
    tags = np.full(len(length), OBSTACLE, np.int8)
    tags[far & np.roll(far, -1)] = RANGE
    tags[off_line <= RADIAL * range_m] = GAP
    boundary: FloatArray = ring[:-1].copy()
    return ExactScan(
        configuration=here, time_s=float(time_s), range_m=range_m, boundary=boundary, tags=tags
    )


def _place(configuration: Sequence[float], time_s: float, range_m: float) -> Configuration:
    here = Configuration(*map(float, configuration))
    if not all(map(math.isfinite, (*here, time_s))) or not 0.0 < range_m < math.inf:
        raise InvalidInputError(
            f"a scan from {tuple(here)} at {time_s} s with a range of {range_m} m: give finite "
            "numbers, and a positive range"
        )
    return here
