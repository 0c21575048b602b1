"""Lower bound of the time that a team needs to come within range of what is far away.

**Theorem.** Let d(x) be the length of the shortest path from a robot's start to a point x through
the space in which lines of sight run: free space, and around it as much as the robot's range
finder may be off (`Member.spread_m`). When the robot has seen x by a time t, then t is at least
(d(x) - R) / v, with its range R and speed v. For it has been at a place from which it saw x in
a straight line no longer than R, and had come there by a path no longer than v t; both lie in the
space. So the points of the least such time over all robots beyond t are unseen at t. Where the
places that bodies can reach, which are explorable, have more area beyond t than may be left
unseen, the team has not seen its share by t.

Distances are those of `ShortestPaths` over the cells that touch the space, which are never longer
than d(x) for any point x of the cell at whose corners they end; areas of places are exact for
each cell.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.analysis.bounds.lattice import Lattice, ShortestPaths
from multisrt.analysis.bounds.team import Member
from multisrt.environments.environment import Environment
from multisrt.geometry.numerics.kernel import FloatArray, IntArray

CELL_M: Final = 0.07
"""Width of the cells in metres, unless the world is too large."""

MAX_CELLS: Final = 250_000
"""Number of cells in the window of a world from which on cells are larger."""

WORLDS_KEPT: Final = 4
"""Number of worlds whose shortest paths are kept: those of a large one take about 100 MB."""

TEAMS_KEPT: Final = 16
"""Number of teams whose distances are kept: those of one team take up to 6 MB."""

Places = Polygon | MultiPolygon
"""Positions of reference points, in metres."""


def cell_width(area: BaseGeometry, cell_m: float, max_cells: int) -> float:
    """Return the width in metres of cells over the bounds of an area, not more than some."""
    x0, y0, x1, y1 = area.bounds
    width, height = x1 - x0, y1 - y0
    return float(max(cell_m, math.sqrt(width * height / max_cells), (width + height) / max_cells))


def reach_s(
    environment: Environment, reachable: Places, team: Sequence[Member], unseen_m2: float
) -> float:
    """Return a time before which a team cannot have come within range of all but some area.

    Parameters
    ----------
    environment : Environment
        The world.
    reachable : Polygon or MultiPolygon
        The places that the team can reach.
    team : sequence of Member
        The robots.
    unseen_m2 : float
        Area that may be left unseen.
    """
    times, beyond_m2 = _areas_beyond(environment, reachable, tuple(team))
    k = int(np.searchsorted(beyond_m2, unseen_m2, side="right"))
    return float(times[k]) if k < len(times) else 0.0


@lru_cache(maxsize=TEAMS_KEPT)
def _areas_beyond(
    environment: Environment, reachable: Places, team: tuple[Member, ...]
) -> tuple[FloatArray, FloatArray]:
    # Least times of cells that hold places, the latest first, and the area from each time on.
    # Robots that differ in their starts only have one field of distances.
    alike: dict[tuple[float, float, float], list[tuple[float, float]]] = {}
    for start, speed_m_s, range_m, spread_m in team:
        alike.setdefault((speed_m_s, range_m, spread_m), []).append(start)
    times: FloatArray | None = None
    for (speed_m_s, range_m, spread_m), starts in sorted(alike.items()):
        distance = _distances(environment, reachable, spread_m, tuple(sorted(set(starts))))
        own = np.maximum(0.0, distance - range_m) / speed_m_s
        times = own if times is None else np.minimum(times, own)
    assert times is not None
    latest = np.argsort(-times, kind="stable")
    areas_m2 = _places_by_cell(environment, reachable)[2]
    return times[latest], np.cumsum(areas_m2[latest])


@lru_cache(maxsize=WORLDS_KEPT)
def _lattice(environment: Environment) -> Lattice:
    return Lattice.over(environment.free, cell_width(environment.free, CELL_M, MAX_CELLS))


@lru_cache(maxsize=WORLDS_KEPT)
def _shortest_paths(environment: Environment, spread_m: float) -> ShortestPaths:
    lattice = _lattice(environment)
    space = environment.free.buffer(spread_m, join_style="mitre", mitre_limit=2.0)
    return ShortestPaths(lattice, lattice.touched(space if spread_m else environment.free))


@lru_cache(maxsize=WORLDS_KEPT)
def _places_by_cell(
    environment: Environment, reachable: Places
) -> tuple[IntArray, IntArray, FloatArray]:
    # Rows and columns of the cells that hold places, and the area of the places in each.
    lattice = _lattice(environment)
    areas = lattice.areas(reachable)
    # Sums along rows leave rounding in cells without places.
    rows, columns = np.nonzero(areas > 1e-9 * lattice.cell_m**2)
    return rows, columns, areas[rows, columns]


@lru_cache(maxsize=TEAMS_KEPT)
def _distances(
    environment: Environment,
    reachable: Places,
    spread_m: float,
    starts: tuple[tuple[float, float], ...],
) -> FloatArray:
    # From the nearest start to each of the cells that hold places.
    paths = _shortest_paths(environment, spread_m)
    here = _lattice(environment).cells_at(np.array(starts))
    rows, columns, _ = _places_by_cell(environment, reachable)
    return paths.to_cells(paths.from_any(paths.corners(here)), rows, columns)
