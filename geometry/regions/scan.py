"""The scan of a range finder at one place: the visibility polygon itself, or ranges of beams."""

from __future__ import annotations

import math
from dataclasses import dataclass

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.boundary import TagArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.geometry.regions.visibility import visibility_polygon


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ExactScan:
    """The visibility polygon itself, as the Multi-SRT paper simulates its sensor.

    Attributes
    ----------
    configuration : Configuration
        Where the scan was taken, in metres and radians.
    time_s : float
        When the scan was taken, in seconds.
    range_m : float
        Range of the range finder in metres.
    boundary : (n, 2) array
        Corners of the visibility polygon in metres, counter-clockwise, in the world's frame.
    tags : (n,) array of int8
        `OBSTACLE`, `RANGE` or `GAP` for the piece from corner i to corner i + 1.
    """

    configuration: Configuration
    time_s: float
    range_m: float
    boundary: FloatArray
    tags: TagArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaserScan:
    """Ranges along equally spaced beams, from which the robot infers surfaces and jumps.

    Attributes
    ----------
    configuration : Configuration
        Where the scan was taken, in metres and radians.
    time_s : float
        When the scan was taken, in seconds.
    range_m : float
        Range of the range finder in metres.
    ranges : (n,) array
        Distance along the beam in direction ``2 pi i / n`` of the world's frame, in metres;
        ``inf`` where nothing was hit.
    covered : (k, 2) array or None
        Corners in metres of the body around the range finder, counter-clockwise and star-shaped
        about it, in the world's frame: it stands there, so that this is free. None, the default,
        where the body is not known.
    """

    configuration: Configuration
    time_s: float
    range_m: float
    ranges: FloatArray
    covered: FloatArray | None = None


Scan = ExactScan | LaserScan


def take_scan(
    index: EdgeIndex,
    configuration: Configuration,
    time_s: float,
    range_m: float,
    beams: int | None = None,
    covered: FloatArray | None = None,
) -> Scan:
    """Return what a range finder measures at one place.

    Parameters
    ----------
    index : EdgeIndex
        The edges of the world.
    configuration : Configuration
        The place in metres, strictly inside free space; the heading makes no difference.
    time_s : float
        Time of the scan in seconds.
    range_m : float
        Range in metres, at most `MAX_RANGE_M`.
    beams : int, optional
        Number of beams of a laser, at least 3. Default: the visibility polygon itself.
    covered : (k, 2) array, optional
        The body around a laser; see `LaserScan`.

    Returns
    -------
    ExactScan or LaserScan
        The former without beams.

    Raises
    ------
    ClearanceError
        If the place lies on an edge or inside an obstacle.
    InvalidInputError
        If the place or the range is not finite, the range is not positive or too large, or there
        are fewer than 3 beams.

    Examples
    --------
    A corridor of 20 x 3 m, of which 4 m can be seen:

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 3.0], [0.0, 3.0]])
    >>> corridor = EdgeIndex(np.hstack([corners, np.roll(corners, -1, axis=0)]), 4.0 / 3.0)
    >>> place = Configuration(10.0, 1.0)
    >>> scan = take_scan(corridor, place, time_s=0.0, range_m=4.0)
    >>> scan.boundary.max(axis=0).round(9).tolist()
    [14.0, 3.0]
    >>> take_scan(corridor, place, time_s=0.0, range_m=4.0, beams=4).ranges.tolist()
    [inf, 2.0, inf, 1.0]
    """
    # Kernels would compute with whole numbers if they were given whole numbers.
    configuration = Configuration(*map(float, configuration))
    range_m = float(range_m)
    x, y, _ = configuration
    if beams is None:
        boundary, tags = visibility_polygon(index, x, y, range_m)
        return ExactScan(
            configuration=configuration,
            time_s=time_s,
            range_m=range_m,
            boundary=boundary,
            tags=tags,
        )
    return LaserScan(
        configuration=configuration,
        time_s=time_s,
        range_m=range_m,
        ranges=laser_ranges(index, x, y, range_m, beams),
        covered=covered,
    )


def beam_spacing_rad(scan: LaserScan) -> float:
    """Return the angle between neighbouring beams in radians."""
    return 2.0 * math.pi / len(scan.ranges)
