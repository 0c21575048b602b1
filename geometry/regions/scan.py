"""What a range finder reports from one place, and the two kinds that there are."""

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
        Where it was taken.
    time_s : float
        When it was taken.
    range_m : float
        How far the range finder reaches.
    boundary : (n, 2) array
        Corners of the visibility polygon, counter-clockwise, in the world's frame.
    tags : (n,) array
        `OBSTACLE`, `RANGE` or `GAP` for the piece from corner i to corner i + 1.
    """

    configuration: Configuration
    time_s: float
    range_m: float
    boundary: FloatArray
    tags: TagArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaserScan:
    """Ranges along equally spaced beams; the robot infers surfaces and jumps from them.

    Attributes
    ----------
    configuration, time_s, range_m
        As for `ExactScan`.
    ranges : (n,) array
        Distance along the beam in direction ``2 pi i / n`` of the world's frame, in metres;
        ``inf`` where nothing was hit.
    """

    configuration: Configuration
    time_s: float
    range_m: float
    ranges: FloatArray


Scan = ExactScan | LaserScan


def take_scan(
    index: EdgeIndex,
    configuration: Configuration,
    time_s: float,
    range_m: float,
    beams: int | None = None,
) -> Scan:
    """Sense the world from one place: exactly, or with a number of beams.

    Raises
    ------
    ClearanceError, InvalidInputError
        As `visibility_polygon` and `laser_ranges`.
    """
    # Kernels count in whole numbers what they are given in whole numbers.
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
    )


def beam_spacing_rad(scan: LaserScan) -> float:
    """Angle between neighbouring beams."""
    return 2.0 * math.pi / len(scan.ranges)
