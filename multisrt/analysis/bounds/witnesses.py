"""Lower bound of the time to see places no two of which are seen from one position.

A *witness* is a square of the plane; its area is that of the places in it that bodies can reach,
which is explorable. Its *region* are the places from which any point of it is seen. A team that
has been in none of the region has seen nothing of the witness. So, whichever witnesses a team has
seen nothing of, their areas sum to no more than what may be left unseen; and the paths of the
robots come into the regions of all others. How long they must be for that in total is bounded by
`min_total_length`, from distances between regions. The farther apart the regions are, the better:
witnesses in dead ends and behind corners, with small regions, are tried first.

**Theorem.** Take those witnesses whose regions are farther than a distance r from all starts. Let
B bound, as `min_total_length` does, the total length of the parts of the robots' paths that lie
farther than r from all starts, where the distances between two regions and to them count only as
far as they must lie there: min(d(i, j), d(i) - r + d(j) - r) and d(i) - r. Let B be positive.
A robot that comes farther than r from the starts needs r to do so, and has v t - r left by time
t. If j robots do, with a sum of speeds V, then V t - j r >= B; so t is at least the minimum over
j of (B + j r) / V for the j fastest robots. For r = 0 this is the total path length over the speed
of the team; for a large r the time to the last few witnesses.

**Regions.** Computed regions hold the true ones. A robot at x that is shown a point of a witness
to be free sees a point y at most `Member.spread_m` away from it. The segment from x to the point
is within that distance of the segment from x to y, which is free. If x is not in the witness, it
crosses the witness's border, at b. Let q be a point on the border within a distance e of b. The
segment from x to q is within e of the one from x to b, and so in free space widened by both
distances. Hence x is in the visibility polygon of q in the widened world, with a range larger by
e. The region is the union of these polygons, over points q along the border no farther apart than
2 e, and of the witness. It is taken as all cells that it touches.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from multisrt.analysis.bounds.forest import Service, chosen_regions, min_total_length
from multisrt.analysis.bounds.lattice import Lattice, ShortestPaths, edges_of
from multisrt.analysis.bounds.reach import Places, cell_width
from multisrt.analysis.bounds.team import Member
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import ClearanceError
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.visibility import visibility_polygon

CELL_M: Final = 0.2
"""Width of the cells in metres, unless the world is too large."""

MAX_CELLS: Final = 60_000
"""Number of cells in the window of the places from which on cells are larger."""

SIDES: Final = (2, 4, 8)
"""Sides of witnesses that are tried, in widths of a cell."""

AREA_LEFT: Final = 2.0
"""Witnesses are this many times as large as what may be left unseen, if one of the sides is."""

MIN_FILLED: Final = 0.3
"""Share of a witness, at least, that bodies can reach."""

MAX_WITNESSES: Final = 250
"""Number of witnesses among which regions far apart are looked for."""

APART_M: Final = 0.8
"""Their distance from each other in metres, at least."""

BORDER_M: Final = 0.05
"""Maximum distance in metres of a point of a witness's border from one that is looked from."""

ROUNDING_M: Final = 2e-3
"""Free space is widened by this much more, in metres; coordinates may be rounded to a grid."""

ARC_M: Final = 0.01
"""Maximum distance in metres of the arc of a range from its chords, by which it is longer."""

PRICES_M: Final = (4.0, 8.0, 16.0, 32.0)
"""Prices that are tried for an average witness left out."""

DISTANCES: Final = 7
"""Number of distances from the starts that are tried."""

ROUNDS_TRYING: Final = 8
ROUNDS_FINAL: Final = 200
"""Subgradient steps for each set of regions that is tried, and for the best of them."""


@dataclass(frozen=True, slots=True, eq=False)
class Witnesses:
    """Witnesses of a world, for a body and a range finder.

    Attributes
    ----------
    lattice : Lattice
        Cells over the places that bodies can reach.
    paths : ShortestPaths
        Paths through these places.
    squares : (n, 4) array
        x0, y0, x1, y1 of each witness in metres.
    areas_m2 : (n,) array
        The area of each that bodies can reach.
    regions : tuple of (k,) arrays of int
        The corners of the cells that the region of each touches, numbered by `paths`.
    between : (n, n) array
        Lower bounds in metres of the paths between two regions.
    """

    lattice: Lattice
    paths: ShortestPaths
    squares: FloatArray
    areas_m2: FloatArray
    regions: tuple[IntArray, ...]
    between: FloatArray

    def from_starts(self, starts: Sequence[tuple[float, float]]) -> FloatArray:
        """Return lower bounds in metres of the paths from the nearest start to each region."""
        here = self.paths.corners(self.lattice.cells_at(np.array(sorted(set(starts)))))
        lengths = self.paths.from_any(here)
        least: FloatArray = np.array([lengths[region].min() for region in self.regions])
        return least


def witness_s(
    environment: Environment, reachable: Places, team: Sequence[Member], unseen_m2: float
) -> float:
    """Return a time before which a team cannot have seen enough of the witnesses of a world.

    Parameters
    ----------
    environment : Environment
        The world.
    reachable : Polygon or MultiPolygon
        The places that the team can reach.
    team : sequence of Member
        The robots. All are taken to have the largest range among them.
    unseen_m2 : float
        Area that may be left unseen, positive.
    """
    side = next(
        (
            side
            for side in SIDES
            if (side * cell_width(reachable, CELL_M, MAX_CELLS)) ** 2 >= AREA_LEFT * unseen_m2
        ),
        SIDES[-1],
    )
    range_m = max(member.range_m for member in team)
    spread_m = max(member.spread_m for member in team)
    known = witnesses(environment, reachable, range_m, spread_m, side)
    start = known.from_starts([member.start for member in team])
    if not start.any():
        return 0.0
    speeds = np.cumsum(sorted((member.speed_m_s for member in team), reverse=True))
    robots = np.arange(1, len(team) + 1)
    longest = 0.0
    for distance in np.linspace(0.0, float(start.max()), DISTANCES, endpoint=False).tolist():
        length = _length_beyond(known, start, distance, unseen_m2, len(team))
        if length > 0.0:
            longest = max(longest, float(np.min((length + robots * distance) / speeds)))
    return longest


def _length_beyond(
    known: Witnesses, start: FloatArray, distance: float, unseen_m2: float, robots: int
) -> float:
    # A lower bound of the total path length beyond a distance from the starts.
    far = np.flatnonzero(start > distance)
    beyond = start[far] - distance
    between = np.minimum(known.between[np.ix_(far, far)], beyond[:, None] + beyond[None, :])
    unit_m2 = float(known.areas_m2[far].mean())
    nothing = np.zeros(len(far), np.bool_)
    longest = 0.0
    for price in PRICES_M:
        service = Service(
            between, beyond, known.areas_m2[far] / unit_m2, unseen_m2 / unit_m2, price, robots
        )
        chosen = chosen_regions(service, nothing, ROUNDS_TRYING)
        longest = max(longest, min_total_length(service, chosen, ROUNDS_FINAL))
    return longest


@lru_cache(maxsize=16)
def witnesses(
    environment: Environment, reachable: Places, range_m: float, spread_m: float, side: int
) -> Witnesses:
    """Return witnesses with small regions, and the distances between these.

    Parameters
    ----------
    environment : Environment
        The world.
    reachable : Polygon or MultiPolygon
        The places that bodies can reach.
    range_m, spread_m : float
        Of the range finders; see `Member`.
    side : int
        Side of a witness, in widths of a cell.
    """
    lattice = Lattice.over(reachable, cell_width(reachable, CELL_M, MAX_CELLS))
    places = lattice.touched(reachable)
    sight = _Sight(environment, lattice, places, range_m, spread_m)
    areas = _square_sums(lattice.areas(reachable), side)
    found: list[tuple[int, int, int]] = []
    side_m = side * lattice.cell_m
    for row, column in np.argwhere(areas >= MIN_FILLED * side_m**2).tolist():
        centre = np.array([_corner(lattice, row, column, side)]) + 0.5 * side_m
        found.append((int(np.count_nonzero(sight.seen_from(centre))), row, column))
    paths = ShortestPaths(lattice, places)
    kept: list[tuple[int, int]] = []
    regions: list[IntArray] = []
    for _, row, column in sorted(found):
        apart = [math.hypot(row - r, column - c) * side_m for r, c in kept]
        if min(apart, default=math.inf) < APART_M:
            continue
        region = sight.seen_from(_border(_corner(lattice, row, column, side), side_m))
        own = np.s_[row * side : (row + 1) * side, column * side : (column + 1) * side]
        region[own] = places[own]
        kept.append((row, column))
        regions.append(paths.corners(region))
        if len(kept) == MAX_WITNESSES:
            break
    return Witnesses(
        lattice=lattice,
        paths=paths,
        squares=np.array(
            [
                (*corner, corner[0] + side_m, corner[1] + side_m)
                for corner in (_corner(lattice, *square, side) for square in kept)
            ]
        ).reshape(-1, 4),
        areas_m2=np.array([areas[row, column] for row, column in kept]),
        regions=tuple(regions),
        between=paths.between(regions) if regions else np.zeros((0, 0)),
    )


class _Sight:
    # Places from which points are seen in a widened world.

    def __init__(
        self,
        environment: Environment,
        lattice: Lattice,
        places: BoolArray,
        range_m: float,
        spread_m: float,
    ) -> None:
        around = BORDER_M + spread_m + ROUNDING_M
        wide = environment.free.buffer(around, join_style="mitre", mitre_limit=2.0)
        self._index = EdgeIndex(edges_of(wide), range_m / 3.0)
        self._lattice = lattice
        self._places = places
        self._range_m = range_m + BORDER_M + ROUNDING_M + ARC_M

    def seen_from(self, points: FloatArray) -> BoolArray:
        cells = np.zeros_like(self._places)
        for x, y in points.tolist():
            try:
                polygon, _ = visibility_polygon(
                    self._index, x, y, self._range_m, arc_tolerance_m=ARC_M
                )
            except ClearanceError:
                # So far in a wall that no free point is near.
                continue
            self._lattice.touch(polygon, cells)
        return cells & self._places


def _corner(lattice: Lattice, row: int, column: int, side: int) -> tuple[float, float]:
    # The lower left corner of a witness.
    side_m = side * lattice.cell_m
    return lattice.x0 + column * side_m, lattice.y0 + row * side_m


def _border(corner: tuple[float, float], side_m: float) -> FloatArray:
    # Points along the border of a square, each point of which is within `BORDER_M` of one.
    count = math.ceil(side_m / (2.0 * BORDER_M))
    along = np.arange(count) * (side_m / count)
    zero, full = np.zeros(count), np.full(count, side_m)
    sides = [(along, zero), (full, along), (side_m - along, full), (zero, side_m - along)]
    points: FloatArray = np.concatenate([np.column_stack(each) for each in sides])
    points += np.array(corner)
    return points


def _square_sums(areas: FloatArray, side: int) -> FloatArray:
    # The areas of squares of cells; what is left at the upper and right borders is not a witness.
    rows, columns = areas.shape[0] // side, areas.shape[1] // side
    squares = areas[: rows * side, : columns * side].reshape(rows, side, columns, side)
    sums: FloatArray = squares.sum(axis=(1, 3))
    return sums
