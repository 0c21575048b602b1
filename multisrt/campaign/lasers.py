"""Lasers of a campaign: those whose beams find all obstacles of a world, as is promised.

An obstacle that is thinner than the spacing of two beams, or has a corner sharper than 45 degrees,
may be missed (see `multisrt.geometry.regions.safe_region`): a collision with it is no defect.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

import numpy as np
import shapely

from multisrt.campaign.worlds import world_of
from multisrt.environments.environment import Environment
from multisrt.spec import RangeFinderSpec, RunSpec

SPACINGS_M: Final = (0.4, 0.2, 0.1, 0.05)
"""Spacings of neighbouring beams at the range that are drawn, in metres."""

MAX_BEAMS: Final = 1500
"""Largest number of beams that is drawn."""

MIN_CORNER_RAD: Final = math.radians(46.0)
"""Smallest angle of a corner of an obstacle beside which no beam is missed, with some room."""

BORDER_M: Final = 2.0
"""Width of the obstacle around free space, in metres."""

DETAIL_M: Final = 0.01
"""Detail of outlines that does not count as a corner, in metres."""

SLIVER_M: Final = 0.005
"""Width of parts of obstacles beyond `DETAIL_M` that are rounding errors, in metres."""


def beam_spacing_m(range_finder: RangeFinderSpec) -> float:
    """Return the spacing of neighbouring beams at the range, in metres; 0 for the exact sensor.

    Examples
    --------
    >>> round(beam_spacing_m(RangeFinderSpec(range_m=4.0, beams=360)), 3)
    0.07
    """
    if range_finder.beams is None:
        return 0.0
    return math.tau * range_finder.range_m / range_finder.beams


def finds_all(spec: RunSpec, environment: Environment | None = None) -> bool:
    """Whether the range finders of all robots find all obstacles of their world.

    Parameters
    ----------
    spec : RunSpec
        The run.
    environment : Environment, optional
        Its world. Default: built from the spec.

    Returns
    -------
    bool
        True for exact sensors.

    Raises
    ------
    InvalidInputError
        If the world cannot be built.
    """
    widest_m = max(beam_spacing_m(robot.range_finder) for robot in spec.robots)
    return widest_m == 0.0 or are_found(environment or world_of(spec.environment), widest_m)


@lru_cache(maxsize=1000)
def are_found(environment: Environment, spacing_m: float) -> bool:
    """Whether beams of a spacing find all obstacles of a world.

    Parameters
    ----------
    environment : Environment
        The world.
    spacing_m : float
        Spacing of neighbouring beams at the range, in metres.

    Returns
    -------
    bool
        Whether no obstacle is thinner and none has a sharp corner.

    Examples
    --------
    >>> from multisrt.environments.catalog import environment
    >>> maze = environment("maze", size_m=10, cells=5)  # its walls are 0.2 m thick
    >>> are_found(maze, 0.1), are_found(maze, 0.3)
    (True, False)
    """
    free = environment.free
    x0, y0, x1, y1 = free.bounds
    around = shapely.box(x0 - BORDER_M, y0 - BORDER_M, x1 + BORDER_M, y1 + BORDER_M)
    obstacles = around.difference(free)
    half_m = spacing_m / 2.0
    with np.errstate(divide="ignore", invalid="ignore"):  # within GEOS, of degenerate corners
        opened = obstacles.buffer(-half_m, join_style="mitre").buffer(
            half_m, join_style="mitre", mitre_limit=1.0 / math.sin(MIN_CORNER_RAD / 2.0)
        )
    thin = obstacles.difference(opened.buffer(DETAIL_M))
    if not thin.buffer(-0.5 * SLIVER_M).is_empty:
        return False
    return _sharpest(obstacles.simplify(DETAIL_M)) >= MIN_CORNER_RAD


def _sharpest(obstacles: shapely.geometry.base.BaseGeometry) -> float:
    """Return the smallest angle of a convex corner, in radians."""
    sharpest = math.pi
    for part in shapely.get_parts(obstacles):
        if not isinstance(part, shapely.Polygon):
            continue
        oriented = shapely.geometry.polygon.orient(part)  # its inside is on the left
        for ring in (oriented.exterior, *oriented.interiors):
            steps = np.diff(shapely.get_coordinates(ring), axis=0)
            headings = np.arctan2(steps[:, 1], steps[:, 0])
            turns = np.mod(np.roll(headings, -1) - headings + math.pi, math.tau) - math.pi
            sharpest = min(sharpest, float(math.pi - turns.max()))
    return sharpest
